"""A sweep of seeds on one core and on two, and simulated on many.

`python tests/benchmarks/core_study.py [--seeds 4] [--pieces 6]` runs a short sweep in this process,
measures its parts, and simulates two workers, whose time it measures as well. It then simulates
`--many` seeds with as many pieces as a second of sound has, on 64 and 1,000 cores, the latter in
one pool and as parts of 64 cores (`rolling run --part`). One process hands out all pieces of its
pool, as the program does (`rolling.run.backlog`). A process makes the surface of each seed that it
meets, also for the files of a run, and keeps the last one.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from typing import Any

if __name__ == "__main__":  # read when numpy is imported
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))

import numpy as np
import pandas as pd

from rolling import cli
from rolling.in_si.scene_surface import heights
from rolling.run.backlog import Backlog
from rolling.run.executor import FinishedRun, RunLoop
from rolling.run.pools import MAX_TEAMS, LocalPool, Pool, Task

QUICKSTART = Path(__file__).parents[2] / "scenarios" / "quickstart.yaml"
# A piece of the quickstart has 200 steps of a node.
PIECE_M = 400e-6
SPEED_M_S = 0.1
SECOND = round(SPEED_M_S / PIECE_M)  # pieces of a second of sound
PART = 64  # cores of a part, and most cores of a machine; more have a team each in a cluster


@dataclass(frozen=True)
class Costs:
    """Measured times [s] of the parts of a sweep.

    `pieces` are those of all pieces, `surface` that of making a surface per metre of track,
    `finish` that of a run's files, `loop` that of the process that hands out tasks per task, and
    `start` that of a worker until its first task.
    """

    pieces: np.ndarray
    surface: float
    finish: float
    loop: float
    start: float


def sweep(seeds: int, pieces: int) -> list[str]:
    """Return the overrides of a sweep of the quickstart over seeds, each with so many pieces."""
    return [
        "rolling.load_n=20",
        f"sweep={{surface.seed: {list(range(1, seeds + 1))}}}",
        f"rolling.duration_s={pieces * PIECE_M / SPEED_M_S:.6g}",
    ]


def command(seeds: int, pieces: int, workers: int, out: Path) -> list[str]:
    """Return the arguments of `rolling` that run such a sweep."""
    settings = [word for text in sweep(seeds, pieces) for word in ("--set", text)]
    fixed = ["--workers", str(workers), "--no-report", "-q"]
    return ["run", str(QUICKSTART), "--out", str(out), *fixed, *settings]


@contextmanager
def clocked(record: list[tuple[str, float]]):
    """Record the seconds of each task of a pool in this process, and of the loop around them."""
    submit = Pool.submit
    finished_runs = RunLoop.finished_runs

    def timed_submit(pool: Pool, task: Task, *team: Any) -> Any:
        began = time.perf_counter()
        if task.piece is not None:
            heights(task.piece.scene)
            record.append(("surface", time.perf_counter() - began))
            began = time.perf_counter()
        future = submit(pool, task, *team)
        kind = "finish" if task.piece is None else "piece"
        record.append((kind, time.perf_counter() - began))
        return future

    def timed_runs(loop: RunLoop, pool: Pool) -> Iterator[FinishedRun]:
        began = time.perf_counter()
        yield from finished_runs(loop, pool)
        record.append(("all", time.perf_counter() - began))

    Pool.submit = timed_submit
    RunLoop.finished_runs = timed_runs
    try:
        yield
    finally:
        Pool.submit = submit
        RunLoop.finished_runs = finished_runs


def measure(seeds: int, pieces: int, folder: Path) -> tuple[Costs, float]:
    """Run a sweep in this process; return the costs of its parts, and the seconds of its loop."""
    cli.main(command(1, 1, 1, folder / "warm"))  # loads or compiles the kernels
    record: list[tuple[str, float]] = []
    with clocked(record):
        cli.main(command(seeds, pieces, 1, folder / "one"))
    times = pd.DataFrame(record, columns=["part", "seconds"])
    parts = {name: group.to_numpy() for name, group in times.groupby("part")["seconds"]}
    total = float(parts.pop("all")[0])
    tasks = len(parts["piece"]) + len(parts["finish"])
    costs = Costs(
        pieces=parts["piece"],
        surface=float(parts["surface"].sum()) / (seeds * pieces * PIECE_M),
        finish=float(parts["finish"].mean()),
        loop=(total - sum(part.sum() for part in parts.values())) / tasks,
        start=start_of_worker(folder),
    )
    return costs, total


def start_of_worker(folder: Path) -> float:
    """Return the seconds that a process takes to load the compiled solver, less a piece."""
    code = (
        "import time; began = time.perf_counter()\n"
        "from rolling import cli\n"
        f"cli.main({command(1, 1, 1, folder / 'start')!r})\n"
        f"first = time.perf_counter() - began; began = time.perf_counter()\n"
        f"cli.main({command(1, 1, 1, folder / 'again')!r})\n"
        "print(first - (time.perf_counter() - began))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return float(done.stdout.split()[-1])


def simulate(costs: Costs, seeds: int, pieces: int, cores: int) -> dict[str, float]:
    """Simulate a sweep on so many workers of one pool; return wall time [s] and shares of it."""
    rng = np.random.default_rng(1)
    surface = costs.surface * pieces * PIECE_M
    pool = LocalPool(cores, min(cores, seeds, MAX_TEAMS) if cores <= PART else cores)
    backlog = Backlog()
    for run in range(seeds):
        backlog.put_last(run, (run, "begin"))
    lacking = Counter(dict.fromkeys(range(seeds), pieces))
    in_hand = Counter[Any]()
    last = dict[tuple[Any, int], int]()
    # Processes of each team with the time since when they are idle, and tasks by the time.
    idle = {team: [(costs.start, number) for number in range(n)] for team, n in pool.teams.items()}
    waiting = {team: deque[tuple[float, int, str]]() for team in pool.teams}
    flying: list[tuple[float, Any, int, int, str]] = []
    now = main = main_busy = work = surfaces = 0.0

    def start(team: Any) -> None:
        nonlocal work, surfaces
        while waiting[team] and idle[team]:
            (since, number), (handed, run, kind) = heappop(idle[team]), waiting[team].popleft()
            taken = float(rng.choice(costs.pieces)) if kind == "piece" else costs.finish
            made = 0.0 if last.get((team, number)) == run else surface
            last[team, number] = run
            work = work + taken
            surfaces = surfaces + made
            heappush(flying, (max(since, handed) + taken + made, team, number, run, kind))

    while backlog or flying:
        while item := backlog.take(pool.teams, in_hand, pool.slots):
            team, (run, kind) = item
            if kind == "begin":
                backlog.put(run, [(run, "piece")] * pieces)
                continue
            main = max(main, now) + costs.loop
            main_busy += costs.loop
            in_hand[team] += 1
            waiting[team].append((main, run, kind))
            start(team)
        now, team, number, run, kind = heappop(flying)
        in_hand[team] -= 1
        heappush(idle[team], (now, number))
        start(team)
        lacking[run] -= kind == "piece"
        if kind == "piece" and not lacking[run]:
            backlog.put(run, [(run, "finish")])
    return {
        "cores": cores,
        "wall s": now,
        "efficiency": work / (cores * now),
        "surfaces": surfaces / (cores * now),
        "main process": main_busy / now,
    }


def in_parts(costs: Costs, seeds: int, pieces: int, cores: int) -> dict[str, float]:
    """Simulate a sweep as parts of PART cores, each with every N-th run; the slowest counts."""
    parts = max(1, cores // PART)
    shares = [simulate(costs, -(-(seeds - part) // parts), pieces, PART) for part in range(parts)]
    slowest = max(shares, key=lambda share: share["wall s"])
    wall = slowest["wall s"]
    efficiency = sum(s["efficiency"] * s["wall s"] for s in shares) / (parts * wall)
    return slowest | {"cores": parts * PART, "efficiency": efficiency}


def measured_wall(seeds: int, pieces: int, workers: int, out: Path) -> float:
    """Return the wall time [s] of the command on so many workers, less that of one that is done."""
    words = [sys.executable, "-m", "rolling", *command(seeds, pieces, workers, out)]
    clock = [time.perf_counter()]
    for _ in range(2):
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        clock.append(time.perf_counter())
    return (clock[1] - clock[0]) - (clock[2] - clock[1])


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, simulate and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--pieces", type=int, default=6)
    parser.add_argument("--many", type=int, default=200)
    given = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        costs, total = measure(given.seeds, given.pieces, folder)
        two = measured_wall(given.seeds, given.pieces, 2, folder / "two")
    print(
        f"piece {costs.pieces.mean():.3f} s ({costs.pieces.std():.3f} s scatter), surface"
        f" {costs.surface * PIECE_M * SECOND:.3f} s per second of sound, files of a run"
        f" {costs.finish:.3f} s, main process {1e3 * costs.loop:.2f} ms per task, start of a"
        f" worker {costs.start:.2f} s"
    )
    checks = [simulate(costs, given.seeds, given.pieces, cores) for cores in (1, 2)]
    for check, measured in zip(checks, (total + costs.start, two), strict=True):
        check["measured s"] = measured
    print(pd.DataFrame(checks).to_string(index=False, float_format="{:.3g}".format))
    many = [simulate(costs, given.many, SECOND, cores) for cores in (64, 1000)]
    many += [in_parts(costs, given.many, SECOND, 1000) | {"parts": 1000 // PART}]
    print(f"{given.many} seeds of {SECOND} pieces:")
    print(pd.DataFrame(many).to_string(index=False, float_format="{:.3g}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
