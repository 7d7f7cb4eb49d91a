"""A Dask cluster of real processes on loopback: the results of a local run, whatever is killed."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil
import pytest
from ball_between_plates import KIND
from commands import PATIENCE, ROOT, SWEEP, contents, pieces, started, wait_for, words_of
from memory_scenes import MEMORY
from scene_text import TINY

import rolling
from rolling import cli
from rolling.ball_kinds import one_ball
from rolling.kinds import registry
from rolling.kinds.run_folder import RunFolder
from rolling.results import run_result
from rolling.run import folder as folders
from rolling.run import worker
from rolling.terminal import program, progress

pytest.importorskip("distributed", reason="a cluster needs Dask")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("default"),  # of the packages of Dask
]


@dataclass
class DaskProcesses:
    """A scheduler and its workers, which listen on loopback only."""

    folder: Path
    processes: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    def start(self, name: str, program: str, *words: str, path: Path = ROOT) -> None:
        with (self.folder / f"{name}.log").open("wb") as log:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", "--host", "127.0.0.1", *words],
                cwd=self.folder,
                env=os.environ | {"PYTHONPATH": str(path)},
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def workers(self, name: str, *words: str, path: Path = ROOT) -> None:
        registered = self.log("scheduler").count("Register worker addr")
        own = ["--scheduler-file", str(self.file), "--nthreads", "1", "--no-dashboard"]
        local = ["--local-directory", str(self.folder / name), "--name", name]
        self.start(name, "dask_worker", *own, *local, *words, path=path)
        count = 2 if "--nworkers" in words else 1
        wait_for(lambda: self.log("scheduler").count("Register worker addr") == registered + count)

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text(errors="replace")

    def kill(self, name: str) -> None:
        process = self.processes.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskProcesses]:
    made = DaskProcesses(tmp_path_factory.mktemp("cluster"))
    words = ["--port", "0", "--no-dashboard", "--scheduler-file", str(made.file)]
    made.start("scheduler", "dask_scheduler", *words)
    wait_for(made.file.is_file)
    made.workers("pair", "--nworkers", "2")
    yield made
    for name in [*made.processes]:
        made.kill(name)


def run(scene: Path, out: Path, cluster: DaskProcesses, *more: str) -> int:
    return cli.main(words_of(scene, out, "--cluster", str(cluster.file), *more))


@pytest.mark.slow
@pytest.mark.parametrize("text", [SWEEP, MEMORY], ids=["sweep", "passes"])
def test_a_killed_worker_changes_no_result(
    cluster: DaskProcesses, tmp_path: Path, text: str
) -> None:
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    local = tmp_path / "local"
    scene.write_text(text)
    assert cli.main(words_of(scene, local, "--workers", "1")) == 0
    nanny = psutil.Process(cluster.processes["pair"].pid)

    def kill() -> None:
        wait_for(lambda: pieces(out))
        workers = [child for child in nanny.children() if "spawn_main" in str(child.cmdline())]
        os.kill(workers[0].pid, signal.SIGKILL)

    killing = threading.Thread(target=kill)
    killing.start()
    assert run(scene, out, cluster) == 0
    killing.join()
    assert contents(out) == contents(local)


def test_parts_of_a_sweep_run_on_a_cluster(cluster: DaskProcesses, tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(TINY + "sweep: {surface.seed: [1, 2, 3]}\n")
    assert run(scene, out, cluster, "--part", "1/2") == 0
    assert [state for state, _ in folders.states(out).values()] == ["done", "waiting", "done"]
    assert run(scene, out, cluster) == 0


def test_runs_that_workers_kept_are_found_from_a_folder_that_only_the_command_knows(
    cluster: DaskProcesses, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The workers work elsewhere, and no sound is made again at the end."""
    made: list[str] = []

    def counted(place: RunFolder, label: str, *more: object) -> None:
        made.append(label)

    for module in (one_ball, run_result):
        monkeypatch.setattr(module, "make_run", counted)
    monkeypatch.chdir(tmp_path)
    scene = Path("scene.yaml")
    scene.write_text(TINY + "sweep: {surface.seed: [1, 2]}\n")
    assert run(scene, Path("out"), cluster) == 0
    assert not made
    assert Path("out", "runs.csv").is_file()


def test_workers_learn_a_registered_kind_from_the_command(
    cluster: DaskProcesses, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The module of the kind is no part of the program, so workers cannot import it."""
    monkeypatch.setattr(registry, "_added", dict(registry._added))
    rolling.register(KIND)
    scene = tmp_path / "pair.yaml"
    plates = "plates: {radius_mm: 5, waves: 4, amplitude_um: 0.05, load_n: 1, speed_m_s: 2}"
    scene.write_text(f"name: pair\n{plates}\n")
    assert run(scene, tmp_path / "out", cluster) == 0
    assert cli.main(words_of(scene, tmp_path / "local", "--workers", "1")) == 0
    far, near = (rolling.open_run(tmp_path / name) for name in ("out", "local"))
    assert far.numbers.velocity == near.numbers.velocity
    np.testing.assert_array_equal(far.arrays["height"], near.arrays["height"])


def test_a_run_that_fails_names_its_reason(
    cluster: DaskProcesses, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(TINY + "sweep: {rolling.load_n: [5000, 0.005]}\n")
    assert run(scene, out, cluster) == 1
    assert "more than the surface can carry" in capsys.readouterr().err
    assert [state for state, _ in folders.states(out).values()] == ["failed", "done"]


def test_a_worker_of_another_program_is_refused_by_name(
    cluster: DaskProcesses, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for package in ("rolling", "acoustics"):
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / "other" / package, ignore=skip)
    other = tmp_path / "other" / "rolling" / "_own_acoustics.py"
    other.write_text(f"{other.read_text()}# another program\n")
    cluster.workers("other", "--no-nanny", path=tmp_path / "other")
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(TINY)
    try:
        assert run(scene, out, cluster) == 2
    finally:
        cluster.kill("other")
    said = capsys.readouterr().err
    assert "all workers must run version" in said and said.count("127.0.0.1") == 1
    assert not out.exists()


@pytest.mark.parametrize("name", ["version", "sources", "packages"])
def test_a_late_worker_of_another_program_does_nothing(name: str) -> None:
    with pytest.raises(worker.OtherProgramError, match=r"version .* sources .* python .* numba"):
        worker.run_task(b"", program.identity()._replace(**{name: "another"}))


_events: list[str] = []


def _enter_and_leave() -> None:
    """Note the begin and the end of a task."""
    _events.append("begin")
    time.sleep(0.01)
    _events.append("end")


def test_a_worker_with_threads_does_one_task_at_a_time() -> None:
    task = registry.packed(_enter_and_leave, ())
    with ThreadPoolExecutor(3) as threads:
        list(threads.map(worker.run_task, [task] * 3, [program.identity()] * 3))
    assert _events == ["begin", "end"] * 3
    assert not progress.is_quiet(), "the program of the worker says what it said before"


@pytest.mark.slow
def test_a_lost_scheduler_ends_in_a_sentence_and_the_command_goes_on(
    cluster: DaskProcesses, tmp_path: Path
) -> None:
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(SWEEP)
    with started(words_of(scene, out, "--cluster", str(cluster.file)), tmp_path) as command:
        wait_for(lambda: pieces(out))
        cluster.kill("scheduler")
        assert command.wait(PATIENCE) == 1
    said = (tmp_path / "said").read_text()
    assert "is gone" in said and "same command goes on" in said and "Traceback" not in said
    assert cli.main(words_of(scene, out, "--workers", "2")) == 0


@pytest.mark.parametrize(
    ("address", "reason"),
    [
        ("tcp://127.0.0.1:9", "(Connection refused)"),
        ("none.json", "(No such file or directory)"),
        ("nonsense::::", "(not one of Dask)"),
        ("", "("),
        ("foreign", "(a time-out)"),
    ],
)
def test_an_address_without_a_scheduler_is_refused_before_anything_is_written(
    address: str,
    reason: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rolling.run.cluster.CONNECT_SECONDS", 2.0)
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(TINY)
    with socket.create_server(("127.0.0.1", 0)) as server:  # which never answers
        if address == "foreign":
            address = f"127.0.0.1:{server.getsockname()[1]}"
        assert cli.main(words_of(scene, out, "--cluster", address)) == 2
    said = capsys.readouterr().err
    assert f"no scheduler answers {reason}" in said and not out.exists()
    assert said.count("\n") == 1 and " object at 0x" not in said
