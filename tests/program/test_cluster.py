"""A Dask cluster of real processes on loopback survives real kills, and nothing is done twice."""

from __future__ import annotations

import asyncio
import json
import os
import resource
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import happenings
import pytest
import same_runs
from scene_text import TINY

from rolling import cli
from rolling.commands import table
from rolling.folders import run_record
from rolling.folders.run_record import RunRecord
from rolling.scene.messages import SceneError
from rolling.simulation import cluster as cluster_module
from rolling.simulation import cluster_address
from rolling.simulation.cluster import _Work

pytest.importorskip("distributed", reason="a cluster needs Dask")
from distributed import Client

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("default"),  # of the packages of Dask
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="kills are seen in /proc"),
]
ROOT = Path(__file__).parents[2]
KILLER, HELD = 13, 100
SCENE = TINY
# A scene of seed 13 kills its worker. One of seed 100 or more waits in its first start. While there
# is a file `gate`, workers that may write wait until one that may not has begun a scene.
PRELOAD = f"""\
import os, resource, signal, time
from pathlib import Path
from rolling.simulation import simulate

march = simulate.simulate_piece  # Dask runs a preload twice in a process

place = Path(os.environ["HELD_IN"])

def wait_until(condition, stopped):
    end = time.monotonic() + 900
    while time.monotonic() < end and not stopped() and not condition():
        time.sleep(0.05)

def held(scene, first, last, stopped, *more, march=march, **named):
    seed = scene.surface.seed
    if (place / "gate").exists():
        begun = place / "begun-without-disk"
        if resource.getrlimit(resource.RLIMIT_FSIZE)[0] != resource.RLIM_INFINITY:
            begun.touch()
        wait_until(begun.exists, stopped)
    if seed == {KILLER}:
        os.kill(os.getpid(), signal.SIGKILL)
    flag = place / f"held-{{seed}}"
    if seed >= {HELD} and not flag.exists():
        flag.touch()
        wait_until(lambda: False, stopped)
    return march(scene, first, last, stopped, *more, **named)

if march.__name__ != "held":
    simulate.simulate_piece = held
"""
# Workers, and those that follow killed ones, fork from a process that has loaded the program.
NANNY = """\
import multiprocessing
from distributed import utils

utils._forkserver_preload_set = True  # Dask would set a list of its own
multiprocessing.set_forkserver_preload(["distributed.worker", "loaded"])
"""
LOADED = """\
from pathlib import Path
from rolling.commands import whole_runs
from rolling.scene import file
from rolling.simulation import simulate

simulate.simulate_piece(file.read_scene(Path(__file__).with_name("one.yaml")), 0, 2)
"""
FORKED = {"DASK_DISTRIBUTED__WORKER__MULTIPROCESSING_METHOD": "forkserver"}


@dataclass
class Cluster:
    """A scheduler and its workers, which listen on loopback only."""

    folder: Path
    processes: dict[str, subprocess.Popen] = field(default_factory=dict)

    @property
    def file(self) -> Path:
        return self.folder / "scheduler.json"

    def start(self, name: str, program: str, *words: str, path: Path = ROOT) -> None:
        own = {"PYTHONPATH": f"{path}:{self.folder}", "HELD_IN": str(self.folder)}
        with (self.folder / f"{name}.log").open("wb") as log:
            self.processes[name] = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", "--host", "127.0.0.1", *words],
                cwd=self.folder,
                env=os.environ | FORKED | own,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def workers(self, name: str, *words: str, path: Path = ROOT) -> None:
        own = ["--scheduler-file", str(self.file), "--nthreads", "1", "--no-dashboard"]
        local = ["--local-directory", str(self.folder / name), "--name", name]
        more = ["--death-timeout", "600", *words]
        self.start(name, "dask_worker", *own, *local, *more, path=path)

    def log(self, name: str) -> str:
        return (self.folder / f"{name}.log").read_text(errors="replace")

    def wait(self, workers: int) -> None:
        wait_for(lambda: self.log("scheduler").count("Register worker addr") >= workers)

    def wait_until_held(self, seed: int) -> None:
        """Wait until a worker is in the middle of the scene."""
        wait_for((self.folder / f"held-{seed}").exists)

    def kill(self, name: str) -> None:
        process = self.processes.pop(name)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def wait_for(condition: Callable[[], object]) -> None:
    end = time.monotonic() + happenings.PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited for nothing"
        time.sleep(0.05)


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait for answers as long as a slow machine takes."""
    for name in ("CONNECT_SECONDS", "LOST_SECONDS", "RESULT_SECONDS"):
        monkeypatch.setattr(cluster_module, name, 100.0)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    for name, text in {
        "preload.py": PRELOAD,
        "nanny.py": NANNY,
        "loaded.py": LOADED,
        "one.yaml": SCENE,
    }.items():
        (made.folder / name).write_text(text)
    words = ["--port", "0", "--no-dashboard", "--scheduler-file", str(made.file)]
    made.start("scheduler", "dask_scheduler", *words)
    preload = ["--preload", str(made.folder / "preload.py")]
    nanny = ["--preload-nanny", str(made.folder / "nanny.py")]
    made.workers("pair", "--nworkers", "2", *preload, *nanny)
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


def kill_who_holds(cluster: Cluster, out: Path, seed: int) -> None:
    """Kill the worker that has begun a scene, in the middle of it."""
    cluster.wait_until_held(seed)
    os.kill(record(out, seed).process.pid, signal.SIGKILL)


def in_background(function: Callable[[], object]) -> threading.Thread:
    thread = threading.Thread(target=function, daemon=True)
    thread.start()
    return thread


def test_killed_workers_cost_one_start_each_and_a_killer_is_named(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, local = tmp_path / "out", tmp_path / "local"
    killing = in_background(lambda: kill_who_holds(cluster, out, HELD))
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
        assert not same_runs.series_that_differ(out / f"seed={seed}", local / f"seed={seed}")


def test_pieces_of_a_long_track_are_tasks(cluster: Cluster, tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    path.write_text(SCENE.replace("0.0005}", "0.012}"))  # 600 steps, three pieces
    out, local = tmp_path / "out", tmp_path / "local"
    assert cli.main(words(path, out, cluster)) == 0
    assert cli.main(words(path, local, None)) == 0
    assert not same_runs.series_that_differ(out, local)
    assert run_record.read(out).state == "done"


def test_a_second_client_is_refused_and_a_killed_client_leaves_a_folder_to_resume(
    cluster: Cluster, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, seed = tmp_path / "out", HELD + 1
    command = [sys.executable, "-m", "rolling.cli", *words(scene(tmp_path, 1, seed), out, cluster)]
    first = subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": str(ROOT)}, stderr=subprocess.DEVNULL
    )
    cluster.wait_until_held(seed)
    resume = ["resume", str(out), "--no-pictures", "--cluster", str(cluster.file)]
    try:
        assert cli.main(resume) == 2
        assert f"in use by process {first.pid}" in capsys.readouterr().err
    finally:
        first.kill()
        first.wait()
    wait_for(lambda: record(out, seed).state != "running")  # its worker notices
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
    cluster.workers("other", "--no-nanny", path=tmp_path / "other")
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
    out, seeds, gate = tmp_path / "out", range(1, 9), cluster.folder / "gate"
    gate.touch()
    with Client(scheduler_file=str(cluster.file), set_as_default=False) as client:
        full = next(iter(client.scheduler_info(n_workers=-1)["workers"]))
        limit = resource.setrlimit, resource.RLIMIT_FSIZE  # a real limit of the system
        client.run(*limit, (10_000, resource.RLIM_INFINITY), workers=[full])
        try:
            assert cli.main(words(scene(tmp_path, *seeds), out, cluster)) == 0
        finally:
            client.run(*limit, (resource.RLIM_INFINITY,) * 2, workers=[full])
            gate.unlink()
    said = capsys.readouterr().err
    assert f"worker {full} is not used any more" in said and "File too large" in said
    assert {record(out, seed).state for seed in seeds} == {"done"}
    assert not [*out.rglob(".*.partial")]


def test_all_ways_give_the_same_table(cluster: Cluster, tmp_path: Path) -> None:
    """On processes, as parts in mixed order of which one is killed, and on a cluster."""
    path = tmp_path / "tiny.yaml"
    path.write_text(f"{SCENE}sweep: {{rolling.load_n: [0.005, 0.01], surface.seed: {[*range(6)]}}}")
    pool, parts, on_cluster = (tmp_path / name for name in ("pool", "parts", "cluster"))
    assert cli.main([*words(path, pool, None), "--workers", "2"]) == 0
    assert cli.main(words(path, on_cluster, cluster)) == 0
    second = [*words(path, parts, None), "--part", "2/3"]
    lost = happenings.run(second, happenings.KILL, tmp_path)
    assert lost.returncode == -signal.SIGKILL, lost.stderr
    assert len([*parts.glob("*/summary.json")]) == 1
    for part in ("3/3", "1/3", "2/3"):
        assert cli.main([*words(path, parts, None), "--part", part]) == 0
    for folder in (pool, parts, on_cluster):
        assert run_record.read(folder).state == "done"
        table.tabulate(folder)
    assert same_runs.differences(pool, parts) == same_runs.differences(pool, on_cluster) == []


def test_a_lost_connection_is_made_again(cluster: Cluster, tmp_path: Path) -> None:
    """The scheduler forgets the tasks of a client that it loses, and their workers stop."""
    out, seed = tmp_path / "out", HELD + 3

    def cut() -> None:
        cluster.wait_until_held(seed)
        for client in [*Client._instances]:
            client.loop.add_callback(client.scheduler_comm.comm.abort)

    cutting = in_background(cut)
    assert cli.main(words(scene(tmp_path, 1, seed), out, cluster)) == 0
    cutting.join()
    assert (record(out, 1).state, record(out, seed).state) == ("done", "done")
    assert record(out, seed).starts == 2


def test_a_lost_scheduler_ends_in_a_sentence_and_resume_finishes(
    cluster: Cluster,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    out, seed = tmp_path / "out", HELD + 2
    killed: list[float] = []
    monkeypatch.setattr(cluster_module, "LOST_SECONDS", 1.0)
    take = _Work._take

    def kill_and_take(work: _Work, *arguments: Any) -> None:
        if not killed:  # just before the first result is fetched
            cluster.kill("scheduler")
            killed.append(time.monotonic())
        take(work, *arguments)

    monkeypatch.setattr(_Work, "_take", kill_and_take)
    assert cli.main(words(scene(tmp_path, 1, 2, seed), out, cluster)) == 1
    assert time.monotonic() - killed[0] < 300  # five seconds on a quick machine
    said = capsys.readouterr().err
    assert "scheduler" in said and "is gone" in said and f"`rolling resume {out}`" in said
    seeds = 1, 2, seed  # of which all workers are at work, and notice it
    begun = lambda: [each for each in (record(out, seed) for seed in seeds) if each]  # noqa: E731
    wait_for(lambda: all(each.state != "running" for each in begun()))
    assert cli.main(["resume", str(out), "--workers", "1", "--no-pictures"]) == 0
    assert {record(out, each).state for each in (1, 2, seed)} == {"done"}


def test_a_running_loop_is_in_nobodys_way() -> None:
    """Notebooks run a loop of events in the thread of their cells."""

    async def cell() -> str:
        with pytest.raises(SceneError) as error:
            cluster_address.answering("tcp://127.0.0.1:9", 1.0)
        return str(error.value)

    with ThreadPoolExecutor(1) as thread:
        said = thread.submit(lambda: asyncio.run(cell())).result()
    assert "no scheduler answers" in said and "not one of Dask" not in said


def test_no_scheduler_is_refused_before_anything_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_module, "CONNECT_SECONDS", 1.0)
    (tmp_path / "empty.json").write_text("{}")
    (tmp_path / "gone.json").write_text('{"address": "tcp://127.0.0.1:9"}')
    with socket.create_server(("127.0.0.1", 0)) as silent:  # takes calls and never answers
        addresses = {
            "none.json": "no such scheduler file",
            str(tmp_path): "allowed: an address such as tcp://HOST:8786",
            str(tmp_path / "empty.json"): "not a scheduler file",
            str(tmp_path / "gone.json"): "gone.json: no scheduler answers",
            "127.0.0.1:port": "got 127.0.0.1:port, allowed: ",
            "inproc://here": "got inproc://here, allowed: ",
            f"tcp://127.0.0.1:{silent.getsockname()[1]}": "no scheduler answers (a time-out)",
        }
        for address, text in addresses.items():
            out = tmp_path / "out"
            path = scene(tmp_path, 1, 2)
            assert cli.main(["run", str(path), "--out", str(out), "--cluster", address]) == 2
            (line,) = capsys.readouterr().err.splitlines()
            assert line.startswith("--cluster: ") and text in line
            assert not out.exists()
