"""Study of scale: overhead of a task on each way, and many cores simulated from measured times.

`python -m rolling.commands.scale_study RUN` measures the steps of the runs in a sweep folder and
the overheads on this machine, and prints two tables in Markdown. All times are CPU times of one
core, so other work on the machine changes them little.
"""

from __future__ import annotations

import argparse
import heapq
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rolling import tables
from rolling._typing import Array
from rolling.commands import table, whole_runs
from rolling.commands.whole_runs import Order
from rolling.scene.messages import SceneError
from rolling.simulation import batch, labels, pool, simulate
from rolling.simulation import cluster as clusters
from rolling.simulation.cluster import Cluster
from rolling.simulation.pool import Task
from rolling.simulation.stored_runs import read_runs

TASKS = 200  # empty tasks, for the overhead of one
MEASURED_STEPS = 100  # of each run
CORES = (1, 16, 1000)
SCENES = 10_000
HOUR_STEPS = 180_000_000  # an hour at 0.1 m/s in steps of 2 um
BUSY = 0.9  # share of the time above which a part of the work limits the whole


@dataclass(frozen=True)
class Overheads:
    """Measured times of one core besides the solving [s], and the size of a result [bytes].

    pool, cluster : float. The main process, per task on local processes and on a cluster; NaN where
        it was not measured.
    files : float. Claim, result, sound and states of a run, in its process.
    gather : float. Reading of a run's numbers for the table, in the process that finishes.
    start : float. Start of a process with the solver.
    piece_bytes : float. Result of a piece of a track, as a worker returns it.
    """

    pool: float
    cluster: float
    files: float
    gather: float
    start: float
    piece_bytes: float


@dataclass(frozen=True)
class Forecast:
    """A simulated command.

    seconds : float, s. Time until the last task has ended and the table is written.
    efficiency : float. Time of the solving over cores times `seconds`.
    limit : str. The part that limits it.
    """

    seconds: float
    efficiency: float
    limit: str


def nothing(stopped: Callable[[], bool], progress: Callable[[float], object]) -> bool:
    """Do nothing, as the task of which the overhead is measured."""
    return True


def forecast(
    times: Sequence[float] | Array, cores: int, dispatch: float, gather: float
) -> Forecast:
    """Simulate tasks on cores that one process hands out, the longest first.

    Parameters
    ----------
    times : sequence of float, s. Times of the tasks.
    cores : int. Number of cores.
    dispatch : float, s. Time of the handing process per task, in which it does nothing else.
    gather : float, s. Time after the last task.

    Examples
    --------
    >>> forecast([1.0] * 8, 4, 0.0, 0.0).seconds
    2.0
    """
    free = [0.0] * cores
    handed = 0.0
    ordered = sorted(times, reverse=True)
    for seconds in ordered:
        begin = max(heapq.heappop(free), handed)
        handed = begin if dispatch == 0 else max(handed, begin) + dispatch
        heapq.heappush(free, begin + dispatch + seconds)
    solved = max(free)
    total = solved + gather
    work = float(np.sum(ordered))
    if gather > (1 - BUSY) * total:
        limit = "the table at the end"
    elif dispatch * len(ordered) > BUSY * solved:
        limit = "the process that hands out tasks"
    elif ordered[0] > BUSY * solved and cores > 1:
        limit = "the longest task"
    elif work > BUSY * cores * solved:
        limit = "the cores"
    else:
        limit = "the last tasks"
    return Forecast(total, work / (cores * total), limit)


def measure(folder: Path, repeats: int = 3) -> Overheads:
    """Measure the overheads with the runs of a sweep folder, the best of some repeats."""
    run = read_runs(folder)[0]
    return Overheads(
        pool=_per_task(2, repeats),
        cluster=_on_cluster(repeats),
        files=min(_files_seconds(run) for _ in range(repeats)),
        gather=_gather_seconds(folder),
        start=min(_start_seconds() for _ in range(repeats)),
        piece_bytes=_piece_bytes(run),
    )


def _per_task(workers: pool.Workers, repeats: int) -> float:
    """Return the time of this process per empty task, from the end of the first task to the last.

    Threads of Dask are among it, its scheduler is not.
    """
    from rolling.commands import scale_study  # a process does not know the main module

    best = np.inf
    for _ in range(repeats):
        tasks = [Task(k, scale_study.nothing, (), 1.0) for k in range(TASKS)]
        ends: list[float] = []
        pool.work(tasks, workers, _noting(ends))
        best = min(best, (ends[-1] - ends[0]) / (len(ends) - 1))
    return best


def _noting(ends: list[float]) -> Callable[[int, object], None]:
    """Return the function that notes the CPU times at which tasks end."""
    return lambda run, result: ends.append(time.process_time())


def _on_cluster(repeats: int) -> float:
    """Return the time per empty task on a cluster of one worker on loopback; NaN without Dask."""
    try:
        with loopback() as cluster:
            return _per_task(cluster, repeats)
    except (SceneError, ImportError, TimeoutError):
        return float("nan")


@contextmanager
def loopback(workers: int = 1) -> Iterator[Cluster]:
    """Start a scheduler and workers that listen on loopback only, and end them.

    Raises
    ------
    ImportError : Dask is not installed.
    TimeoutError : they do not start within two minutes.
    """
    import distributed

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        cli = f"{distributed.__name__}.cli"
        common = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
        scheduler = [sys.executable, "-m", f"{cli}.dask_scheduler", *common, "--port", "0"]
        own = ["--nthreads", "1", "--no-nanny", "--local-directory", folder]
        worker = [sys.executable, "-m", f"{cli}.dask_worker", *common, *own]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
        processes = [subprocess.Popen(scheduler, **quiet)]  # type: ignore[call-overload]
        processes += [
            subprocess.Popen(worker, **quiet)  # type: ignore[call-overload]
            for _ in range(workers)
        ]
        try:
            cluster = Cluster(str(file))
            _wait(cluster, workers)
            yield cluster
        finally:
            for process in reversed(processes):
                process.terminate()
            for process in processes:
                with suppress(subprocess.TimeoutExpired):
                    process.wait(10)
                process.kill()


def _wait(cluster: Cluster, workers: int) -> None:
    """Wait until the workers have joined."""
    end = time.monotonic() + 120
    while time.monotonic() < end:
        with suppress(SceneError):
            if clusters.workers(cluster) >= workers:
                return
        time.sleep(0.5)
    raise TimeoutError("no worker joined")


def _files_seconds(run: batch.Run) -> float:
    """Return the time of a run besides its solving: claim, sound, files and states."""
    solved = batch.stored(run)
    assert solved is not None
    with tempfile.TemporaryDirectory() as folder:
        again = batch.Run(run.values, run.scene, Path(folder) / "run")
        again.folder.mkdir()
        batch.keep(again, solved)
        began = time.process_time()
        whole_runs.do_run(Order(again, labels.labels([run])[0], False, False), _never, _ignore)
        return time.process_time() - began


def _gather_seconds(folder: Path) -> float:
    """Return the time per run to read the numbers of a sweep."""
    began = time.process_time()
    rows = table.read_rows(folder)
    return (time.process_time() - began) / len(rows)


def _start_seconds() -> float:
    """Return the CPU time until a new process has the solver."""
    before = os.times()
    words = [sys.executable, "-c", "import rolling.commands.whole_runs"]
    subprocess.run(words, check=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
    after = os.times()
    return sum(after[2:4]) - sum(before[2:4])


def _piece_bytes(run: batch.Run) -> float:
    """Return the size of the result of a piece in a long track, nearly all of which have no map."""
    last = min(simulate.PIECE_STEPS, run.scene.track.solved_steps)
    piece = simulate.simulate_piece(run.scene, 0, last, mapped=False)
    return float(len(pickle.dumps(replace(piece, snapshot=None))))


def _never() -> bool:
    return False


def _ignore(share: float) -> None:
    """Do nothing with a share of the cost."""


def step_seconds(folder: Path) -> Array:
    """Return the mean CPU time of the first steps of each run of a sweep [s]."""
    runs = read_runs(folder)
    simulate.simulate_piece(runs[0].scene, 0, 1)  # loads the kernels
    times = []
    for run in runs:
        last = min(MEASURED_STEPS, run.scene.track.solved_steps)
        began = time.process_time()
        simulate.simulate_piece(run.scene, 0, last, mapped=False)
        times.append((time.process_time() - began) / last)
    return np.array(times)


def forecasts(steps: Array, seconds: float, measured: Overheads) -> list[tuple[str, ...]]:
    """Simulate many scenes, and an hour of sound, on each number of cores and each way.

    Parameters
    ----------
    steps : array, s. Times of a step, from which the times of the scenes are drawn.
    seconds : float, s. Sound of a scene.
    measured : Overheads.
    """
    random = np.random.default_rng(1)
    count = round(HOUR_STEPS / 3600 * seconds)
    scenes = random.choice(steps, SCENES) * count + measured.files
    pieces = np.full(HOUR_STEPS // simulate.PIECE_STEPS, np.median(steps) * simulate.PIECE_STEPS)
    rows: list[tuple[str, ...]] = []
    for work, times, gather in (
        (f"{SCENES:,} scenes of {seconds:g} s", scenes, SCENES * measured.gather),
        ("an hour of sound, in pieces", pieces, 0.0),
    ):
        for way, dispatch in (("local", measured.pool), ("Dask", measured.cluster)):
            for cores in CORES:
                if np.isnan(dispatch) or (way == "local" and cores == CORES[-1]):
                    continue
                expected = forecast(times, cores, dispatch, gather)
                shown = f"{expected.seconds / 3600:.3g} h", f"{100 * expected.efficiency:.0f} %"
                rows.append((work, way, str(cores), *shown, expected.limit))
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study from the command line and return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m rolling.commands.scale_study")
    parser.add_argument("folder", type=Path, metavar="RUN", help="a sweep whose runs are done")
    parser.add_argument("--seconds", type=float, default=0.5, help="sound of a scene (0.5)")
    parser.add_argument("--repeats", type=int, default=3, help="measurements of each overhead (3)")
    given = parser.parse_args(arguments)
    measured = measure(given.folder, given.repeats)
    print(tables.markdown(("overhead", "measured"), _overhead_rows(measured)))
    print()
    head = ("work", "way", "cores", "time", "efficiency", "limited by")
    print(tables.markdown(head, forecasts(step_seconds(given.folder), given.seconds, measured)))
    return 0


def _overhead_rows(measured: Overheads) -> list[tuple[str, str]]:
    """Write the overheads as rows of a table."""
    times = (
        ("a task on local processes, in the process that hands it out", measured.pool),
        ("a task on a Dask cluster on loopback, in the same process", measured.cluster),
        ("a run besides its solving: claim, sound, files, states", measured.files),
        ("a run in the table at the end", measured.gather),
        ("the start of a process with the solver, once per worker or part", measured.start),
    )
    rows = [(name, f"{seconds * 1e3:.3g} ms") for name, seconds in times]
    return [*rows, ("the result of a piece, as it is sent", f"{measured.piece_bytes / 1e3:.3g} kB")]


if __name__ == "__main__":
    raise SystemExit(main())
