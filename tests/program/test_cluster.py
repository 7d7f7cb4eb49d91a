"""A Dask cluster of real processes on loopback survives real kills, and nothing is done twice."""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
import pytest
from scene_text import TINY

from rolling import cli
from rolling.folders import run_record
from rolling.folders.run_record import RunRecord

pytest.importorskip("distributed", reason="a cluster needs Dask")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("default"),  # of the packages of Dask
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="kills are seen in /proc"),
]
ROOT = Path(__file__).parents[2]
KILLER, HELD = 13, 100
SCENE = TINY
# A scene of seed 13 kills its worker. One of seed 100 or more waits in its first start.
PRELOAD = f"""\
import os, signal, time
from pathlib import Path
from rolling.simulation import simulate

march = simulate.simulate_piece  # Dask runs a preload twice in a process

def held(scene, first, last, stopped, *more, march=march, **named):
    seed = scene.surface.seed
    if seed == {KILLER}:
        os.kill(os.getpid(), signal.SIGKILL)
    flag = Path(__file__).with_name(f"held-{{seed}}")
    if seed >= {HELD} and not flag.exists():
        flag.touch()
        end = time.monotonic() + 60
        while time.monotonic() < end and not stopped():
            time.sleep(0.05)
    return march(scene, first, last, stopped, *more, **named)

if march.__name__ != "held":
    simulate.simulate_piece = held
"""


@dataclass
class Cluster:
    """A scheduler and its workers, which listen on loopback only."""

    folder: Path
    processes: dict[str, subprocess.Popen] = field(default_factory=dict)

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    def start(self, name: str, program: str, *words: str, **more: object) -> None:
        environment = os.environ | {"PYTHONPATH": str(more.pop("path", ROOT))}
        with (self.folder / f"{name}.log").open("wb") as log:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", "--host", "127.0.0.1", *words],
                cwd=self.folder,
                env=environment,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                **more,
            )

    def worker(self, name: str, **more: object) -> None:
        own = ["--scheduler-file", str(self.file), "--nthreads", "1", "--no-dashboard"]
        preload = ["--preload", str(self.folder / "preload.py")]
        local = ["--local-directory", str(self.folder / name), "--name", name]
        self.start(name, "dask_worker", *own, *preload, *local, "--death-timeout", "60", **more)

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text(errors="replace")

    def wait(self, workers: int) -> None:
        wait_for(lambda: self.log("scheduler").count("Register worker addr") >= workers, 90)

    def kill(self, name: str) -> None:
        process = self.processes.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def wait_for(condition: Callable[[], object], seconds: float) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited for nothing"
        time.sleep(0.05)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    (made.folder / "preload.py").write_text(PRELOAD)
    words = ["--port", "0", "--no-dashboard", "--scheduler-file", str(made.file)]
    made.start("scheduler", "dask_scheduler", *words)
    made.worker("first")
    made.worker("second")
    made.wait(2)
    yield made
    for name in [*made.processes]:
        made.kill(name)


def scene(folder: Path, *seeds: int) -> Path:
    path = folder / "tiny.yaml"
    path.write_text(f"{SCENE}sweep: {{surface.seed: {[*seeds]}}}\n")
    return path


def words(scene: Path, out: Path, cluster: Cluster | None) -> list[str]:
    solvers = ["--cluster", str(cluster.file)] if cluster else ["--workers", "1"]
    return ["run", str(scene), "--out", str(out), "--no-pictures", *solvers]


def record(out: Path, seed: int) -> RunRecord | None:
    return run_record.read(out / f"seed={seed}")


def kill_who_holds(out: Path, seed: int) -> None:
    """Kill the worker that has begun a scene, in the middle of it."""
    wait_for(lambda: (begun := record(out, seed)) is not None and begun.process, 60)
    wait_for(lambda: (record(out, seed).process) is not None, 10)
    time.sleep(0.2)
    os.kill(record(out, seed).process.pid, signal.SIGKILL)


def in_background(function: Callable[[], object]) -> threading.Thread:
    thread = threading.Thread(target=function, daemon=True)
    thread.start()
    return thread


def assert_same(one: Path, other: Path) -> None:
    """Assert that two runs have the same series, bit by bit, but for times."""
    with h5py.File(one / "result.h5") as first, h5py.File(other / "result.h5") as second:
        for name in ("release_energy", "approach", "residual", "sound/pressure"):
            assert np.array_equal(first[name][:], second[name][:])
    assert (one / "signal.wav").read_bytes() == (other / "signal.wav").read_bytes()


def test_killed_workers_cost_one_start_each_and_a_killer_is_named(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, local = tmp_path / "out", tmp_path / "local"
    killing = in_background(lambda: kill_who_holds(out, HELD))
    good = (1, 2, 3)
    assert cli.main(words(scene(tmp_path, *good, HELD, KILLER), out, cluster)) == 1
    killing.join()
    assert f"seed {KILLER}: its worker was killed 4 times" in capsys.readouterr().err
    killer = record(out, KILLER)
    assert (killer.state, killer.starts) == ("failed", 4)
    assert (record(out, HELD).state, record(out, HELD).starts) == ("done", 2)
    for seed in good:
        assert record(out, seed).state == "done"
    rows = {row["folder"]: row["summary"] for row in json.loads((out / "sweep.json").read_text())}
    assert [name for name, summary in rows.items() if summary is None] == [f"seed={KILLER}"]
    assert not [*out.rglob(".*.partial")]
    assert cli.main(words(scene(tmp_path, *good), local, None)) == 0
    for seed in good:
        assert_same(out / f"seed={seed}", local / f"seed={seed}")


def test_pieces_of_a_long_track_are_tasks(cluster: Cluster, tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    path.write_text(SCENE.replace("0.0005}", "0.012}"))  # 600 steps, three pieces
    out, local = tmp_path / "out", tmp_path / "local"
    assert cli.main(words(path, out, cluster)) == 0
    assert cli.main(words(path, local, None)) == 0
    assert_same(out, local)
    assert run_record.read(out).state == "done"


def test_a_second_client_is_refused_and_a_killed_client_leaves_a_folder_to_resume(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, seed = tmp_path / "out", HELD + 1
    command = [sys.executable, "-m", "rolling.cli", *words(scene(tmp_path, 1, seed), out, cluster)]
    first = subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, stderr=subprocess.DEVNULL
    )
    wait_for(lambda: (begun := record(out, seed)) is not None and begun.process, 60)
    resume = ["resume", str(out), "--no-pictures", "--cluster", str(cluster.file)]
    try:
        assert cli.main(resume) == 2
        assert f"in use by process {first.pid}" in capsys.readouterr().err
    finally:
        first.kill()
        first.wait()
    wait_for(lambda: record(out, seed).state != "running", 30)  # its worker notices
    assert cli.main(resume) == 0
    assert {record(out, each).state for each in (1, seed)} == {"done"}


def test_a_worker_of_another_version_is_refused_by_name(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for package in ("rolling", "acoustics"):
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / "other" / package, ignore=skip)
    other = tmp_path / "other" / "rolling" / "_typing.py"
    other.write_text(f"{other.read_text()}# another version\n")
    before = cluster.log("scheduler").count("Register worker addr")
    cluster.worker("other", path=tmp_path / "other")
    cluster.wait(before + 1)
    out = tmp_path / "out"
    assert cli.main(words(scene(tmp_path, 1, 2, 3), out, cluster)) == 0
    cluster.kill("other")
    said = capsys.readouterr().err
    assert "is not used: version" in said and "127.0.0.1" in said
    assert {record(out, seed).starts for seed in (1, 2, 3)} == {1}


def test_a_worker_with_a_full_disk_is_left_out(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def small_files() -> None:  # a real limit of the system: no file above 10 kB
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))

    before = cluster.log("scheduler").count("Register worker addr")
    cluster.worker("full", preexec_fn=small_files)
    cluster.wait(before + 1)
    out, seeds = tmp_path / "out", range(1, 9)
    assert cli.main(words(scene(tmp_path, *seeds), out, cluster)) == 0
    cluster.kill("full")
    said = capsys.readouterr().err
    assert "is not used any more" in said and "File too large" in said
    assert {record(out, seed).state for seed in seeds} == {"done"}
    assert not [*out.rglob(".*.partial")]


def test_a_lost_scheduler_ends_in_a_sentence_and_resume_finishes(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, seed = tmp_path / "out", HELD + 2
    killed: list[float] = []

    def kill() -> None:
        wait_for(lambda: (begun := record(out, seed)) is not None and begun.process, 60)
        cluster.kill("scheduler")
        killed.append(time.monotonic())

    killing = in_background(kill)
    assert cli.main(words(scene(tmp_path, 1, 2, seed), out, cluster)) == 1
    killing.join()
    assert time.monotonic() - killed[0] < 30
    said = capsys.readouterr().err
    assert "scheduler" in said and "is gone" in said and f"`rolling resume {out}`" in said
    wait_for(lambda: record(out, seed).state != "running", 60)
    assert cli.main(["resume", str(out), "--workers", "1", "--no-pictures"]) == 0
    assert {record(out, each).state for each in (1, 2, seed)} == {"done"}


def test_no_scheduler_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from rolling.simulation import cluster

    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1.0)
    for address, text in (("none.json", "no such"), ("tcp://127.0.0.1:9", "no scheduler answers")):
        out = tmp_path / "out"
        path = scene(tmp_path, 1, 2)
        assert cli.main(["run", str(path), "--out", str(out), "--cluster", address]) == 2
        assert text in capsys.readouterr().err
        assert not out.exists()
