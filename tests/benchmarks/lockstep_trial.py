"""What pieces of a march gain that advance in lockstep, against pieces one after the other.

The script marches k pieces of the track of the quickstart at 1 and 5 N, with sharp edges and steps
of a node. The present solver takes them one after the other on one core, and on two processes. A
batch takes them in lockstep on one core, and half of them each in two processes and in two threads.
Its k transforms are in one plan, or they are those of the present solver in a single call, which
are quicker and serve on two cores. All take turns. Processor time counts on one core, wall time on
two; the numbers are medians over rounds.

Then the parts: transforms in one plan, sweeps in one call, the Python of a step, and what lockstep
costs (blocks of one size, rounds of the slowest piece). The answers of both are judged on wider
grids by code that neither shares.

python tests/benchmarks/lockstep_trial.py [--steps N] [--rounds N] [--out FOLDER]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    pinned = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
    os.environ.update(dict.fromkeys(pinned, "1"))

import numpy as np
from lockstep import compiled
from lockstep.batch_transforms import BatchTransforms
from lockstep.compiled import CompiledBatch
from lockstep.compiled_passes import CONVOLUTIONS, OUTSIDE
from lockstep.interface import follow
from lockstep.parts import Sweeps, transform_each, transform_pairs
from peers.problem import Problem

from rolling.contact import _position_kernels, _window_kernels, solver
from rolling.contact._transform_kernels import GROUP, nodes_kernel
from rolling.contact.half_space import HalfSpace, padded_length
from rolling.contact.march import march
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.kinds.reading import read_scene

HERE = Path(__file__).parent
QUICKSTART = HERE.parent.parent / "scenarios" / "quickstart.yaml"
OUTPUTS = HERE.parent.parent / "outputs" / "benchmarks"
LOADS = (1, 5)
PIECES = (4, 8, 16)
APART = 500  # positions from the first of a piece to that of the next
JUDGED = 128  # nodes on a side of the grid on which answers are judged
PARTS = 400  # repetitions of a part


@lru_cache
def contact_of(load: float) -> RollingContact:
    """Return the contact of the quickstart with sharp edges on whole cells, and steps of a node."""
    pinned = ("sweep=", "numerics.step_nodes=1", "numerics.subcells=1", "numerics.edges=sharp")
    estimate = "numerics.error_estimate=false"
    return rolling_contact(
        read_scene(QUICKSTART, [f"rolling.load_n={load}", *pinned, estimate]).runs()[0][1]
    )


@lru_cache
def half_space_for(load: float) -> HalfSpace:
    """Return the half-space of a load, whose transforms all tasks share."""
    contact = contact_of(load)
    return half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)


@dataclass(frozen=True)
class Task:
    """Pieces that one core marches.

    Parameters
    ----------
    load : float, N
        Load of the contact.
    first, pieces : int
        Number of the first piece, and of pieces.
    steps : int
        Timed steps of each piece, after its first two positions.
    in_lockstep : bool
        Whether they march in lockstep.
    one_plan : bool
        Whether k transforms are then in one plan.
    """

    load: float
    first: int
    pieces: int
    steps: int
    in_lockstep: bool
    one_plan: bool = True

    def halves(self) -> list[Task]:
        """Return the tasks of two cores."""
        half = self.pieces // 2
        return [replace(self, first=self.first + begin, pieces=half) for begin in (0, half)]

    def prepared(self) -> Callable[[], Any]:
        """Solve the first two positions of each piece; return the function that is timed."""
        contact = contact_of(self.load)
        half_space = half_space_for(self.load)
        begins = [APART * (self.first + i) for i in range(self.pieces)]
        marches = [march(contact, k, k + 1 + self.steps, half_space) for k in begins]
        states = [(next(each), next(each)) for each in marches]
        if self.in_lockstep:
            batch = CompiledBatch(contact, half_space, states, self.one_plan, self.first)

            def run() -> CompiledBatch:
                for _ in range(self.steps):
                    follow(batch)
                return batch

            return run

        def run_one_by_one() -> list[list[ContactState]]:
            return [list(each) for each in marches]

        return run_one_by_one


def on_one_core(task: Task) -> float:
    """Return the processor time [ms] of a step of a piece."""
    run = task.prepared()
    began = time.process_time()
    run()
    return 1e3 * (time.process_time() - began) / (task.pieces * task.steps)


def _in_process(task: Task, barrier: Any, ends: Any) -> None:
    """March a task when all processes are ready, and tell when it began and ended."""
    run = task.prepared()
    barrier.wait()
    began = time.perf_counter()
    run()
    ends.put((began, time.perf_counter()))


def on_two_processes(task: Task) -> float:
    """Return the wall time [ms] of a step of a piece, where two processes have half of them each.

    They are forked, so that they have all compiled code.
    """
    context = get_context("fork")
    barrier = context.Barrier(2)
    ends = context.Queue()
    processes = [
        context.Process(target=_in_process, args=(half, barrier, ends)) for half in task.halves()
    ]
    for process in processes:
        process.start()
    times = [ends.get() for _ in processes]
    for process in processes:
        process.join()
    return _wall(times, task)


def on_two_threads(task: Task) -> float:
    """Return the wall time [ms] of a step of a piece, where two threads have half of them each."""
    runs = [half.prepared() for half in task.halves()]
    times: list[tuple[float, float]] = []

    def timed(run: Callable[[], Any]) -> None:
        began = time.perf_counter()
        run()
        times.append((began, time.perf_counter()))

    threads = [threading.Thread(target=timed, args=(run,)) for run in runs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return _wall(times, task)


def _wall(times: list[tuple[float, float]], task: Task) -> float:
    """Return the milliseconds from the first beginning to the last end, for a step of a piece."""
    seconds = max(end for _, end in times) - min(begin for begin, _ in times)
    return 1e3 * seconds / (task.pieces * task.steps)


ONE_BY_ONE = {"in_lockstep": False}
ONE_PLAN = {"in_lockstep": True, "one_plan": True}
OWN_PLANS = {"in_lockstep": True, "one_plan": False}
WAYS = {
    "one core, one after the other": (on_one_core, ONE_BY_ONE),
    "one core, k transforms in one plan": (on_one_core, ONE_PLAN),
    "one core, lockstep": (on_one_core, OWN_PLANS),
    "two processes, one after the other": (on_two_processes, ONE_BY_ONE),
    "two processes, lockstep": (on_two_processes, OWN_PLANS),
    "two threads, lockstep": (on_two_threads, OWN_PLANS),
}


@dataclass(frozen=True)
class Gain:
    """Milliseconds of a step of a piece by each way, and the gains of lockstep: medians.

    A gain is over pieces one after the other on as many cores.
    """

    load: float
    pieces: int
    ms: list[float]
    one_plan: float
    one_core: float
    two_processes: float
    two_threads: float


def measure_gain(load: float, pieces: int, steps: int, rounds: int) -> Gain:
    """Measure all ways in turn, so many times.

    Transforms are made before: a task on two threads makes those of the processes.
    """
    turn = [
        (clock, Task(load=load, first=0, pieces=pieces, steps=steps, **how))
        for clock, how in WAYS.values()
    ]
    for clock, task in turn:
        if clock is not on_two_processes:
            clock(task)
    table = np.array([[clock(task) for clock, task in turn] for _ in range(rounds)])
    one, one_plan, lockstep, two, processes, threads = table.T
    return Gain(
        load=load,
        pieces=pieces,
        ms=np.median(table, axis=0).tolist(),
        one_plan=float(np.median(one / one_plan)),
        one_core=float(np.median(one / lockstep)),
        two_processes=float(np.median(two / processes)),
        two_threads=float(np.median(two / threads)),
    )


# ---- answers and counts


@dataclass(frozen=True)
class Answers:
    """Errors and counts of both, over all pieces and positions.

    Gap errors are maxima over the deflection, which the tolerance bounds. Convolutions are of a
    step of a piece; `rounds` are the transforms of a position that the slowest piece needs.
    `padding` is the size of the common window and block over the mean size of a piece's own.
    """

    load: float
    pieces: int
    tolerance: float
    gap_error: float
    gap_error_in_lockstep: float
    load_error_in_lockstep: float
    convolutions: float
    convolutions_in_lockstep: float
    rounds: float
    window_padding: float
    block_padding: float
    too_narrow: int


def judge(contact: RollingContact, k: int, window: Window, pressure: np.ndarray) -> Any:
    """Judge the pressures of a position on a wider square grid by code that no solver shares."""
    row = round(contact.position(k) / contact.spacing) - JUDGED // 2
    column = round(contact.mid_width / contact.spacing) - JUDGED // 2
    square = Window(row, column, JUDGED, JUDGED)
    if not square.covers(window):
        raise RuntimeError(f"the grid of {JUDGED} nodes does not cover {window}")
    problem = Problem(
        gaps=contact.gap(k, square)[None],
        moves=np.zeros(1),
        spacing=contact.spacing,
        radius=contact.radius,
        contact_modulus=contact.contact_modulus,
        hardness=float(contact.hardness),
        load=contact.load,
    )
    return problem.judge(0, window.moved(pressure, square))


def compare_answers(load: float, pieces: int, steps: int) -> Answers:
    """Judge all pieces of both at all positions, and count convolutions and padding."""
    contact = contact_of(load)
    task = Task(load, 0, pieces, steps, in_lockstep=False)
    blocks: list[int] = []
    with blocks_of_descents(blocks):
        marched = task.prepared()()
    half_space = half_space_for(load)
    starts = [march(contact, APART * i, APART * i + 1, half_space) for i in range(pieces)]
    batch = CompiledBatch(
        contact, half_space, [(next(each), next(each)) for each in starts], one_plan=True
    )
    windows = []
    common = []
    mine = []
    rounds = []
    for j in range(steps):
        before = batch.rounds
        follow(batch)
        rounds.append(batch.rounds - before + 1)  # and one in double precision
        rows, columns = batch.frames.p.shape[1:]
        windows.append(rows * columns)
        common.append(batch.block[0] * batch.block[1])
        for i in range(pieces):
            window = Window(*(int(x) for x in batch.corners[0, i]), rows, columns)
            state = marched[i][j]
            mine.append(
                (
                    judge(contact, state.position, window, batch.frames.p[i]),
                    judge(contact, state.position, state.window, state.pressure),
                )
            )
    own = [state.window.rows * state.window.columns for states in marched for state in states]
    in_lockstep, one_by_one = zip(*mine, strict=True)
    return Answers(
        load=load,
        pieces=pieces,
        tolerance=float(contact.tolerance),
        gap_error=max(each.gap_error / each.deflection for each in one_by_one),
        gap_error_in_lockstep=max(each.gap_error / each.deflection for each in in_lockstep),
        load_error_in_lockstep=max(abs(each.load_error) for each in in_lockstep),
        convolutions=float(np.mean([s.convolutions for states in marched for s in states])),
        convolutions_in_lockstep=float(batch.counts[:, CONVOLUTIONS].mean() / steps),
        rounds=float(np.mean(rounds)),
        window_padding=float(np.mean(windows) / np.mean(own)),
        block_padding=float(np.mean(common) / np.mean(blocks)),
        too_narrow=int(batch.counts[:, OUTSIDE].sum()),
    )


@contextmanager
def blocks_of_descents(sizes: list[int]) -> Iterator[None]:
    """Note the size of the block of each descent of the present solver."""
    listing = solver._candidates

    def noted(*arguments: Any) -> Any:
        found = listing(*arguments)
        sizes.append(found.block[2] * found.block[3])
        return found

    solver._candidates = noted
    try:
        yield
    finally:
        solver._candidates = listing


# ---- parts


@dataclass(frozen=True)
class Parts:
    """Processor time of the parts for one piece [us], and shares of Python in a step.

    The block is that of the lockstep. `plan_each` are transforms of the present solver, a plan for
    each piece, `plan_pair` and `plan_all` those of two pieces side by side, in a plan for each pair
    and in one plan.
    """

    load: float
    pieces: int
    block: tuple[int, int]
    plan_each: float
    plan_pair: float
    plan_all: float
    sweeps_each: float
    sweeps_all: float
    python: float
    python_in_lockstep: float


def microseconds(run: Callable[[], Any], pieces: int) -> float:
    """Return the processor time of a call for one piece [us], the lower quartile of ten."""
    run()
    taken = []
    for _ in range(10):
        began = time.process_time()
        for _ in range(PARTS // 10):
            run()
        taken.append(time.process_time() - began)
    return float(1e6 * np.quantile(taken, 0.25) / (PARTS // 10) / pieces)


def measure_parts(load: float, pieces: int, steps: int) -> Parts:
    """Measure the parts on the block of the last position of a batch."""
    half_space = half_space_for(load)
    batch = Task(load, 0, pieces, 3, in_lockstep=True, one_plan=False).prepared()()
    block = batch.block[:2]
    each, pair, together = transforms_of(half_space, block, pieces)
    sweeps = Sweeps(half_space.unit, block, pieces)
    return Parts(
        load=load,
        pieces=pieces,
        block=block,
        plan_each=microseconds(each, pieces),
        plan_pair=microseconds(pair, pieces),
        plan_all=microseconds(together, pieces),
        sweeps_each=microseconds(sweeps.one_by_one, pieces),
        sweeps_all=microseconds(sweeps.all_at_once, pieces),
        python=share_of_python(Task(load, 0, pieces, steps, in_lockstep=False)),
        python_in_lockstep=share_of_python(
            Task(load, 0, pieces, steps, in_lockstep=True, one_plan=False)
        ),
    )


def transforms_of(
    half_space: HalfSpace, block: tuple[int, int], pieces: int
) -> list[Callable[[], None]]:
    """Return the transforms of a block for all pieces by the three ways."""
    rows, columns = block
    made = half_space.convolution(rows - 1, columns - 1, single=True)
    each = nodes_kernel(1, True), made.planned_entry(rows)
    m = padded_length(rows - 1)
    n = padded_length(columns - 1, across=True)
    lines = min(m, rows + -rows % GROUP)
    pair = BatchTransforms(m, n, lines, 1, half_space.unit, single=True)
    together = BatchTransforms(m, n, lines, pieces // 2, half_space.unit, single=True)

    def transformed(ours: BatchTransforms) -> None:
        transform_pairs(ours.lines, ours.spectrum, (ours.execute, ours.plans), pieces)

    return [
        lambda: transform_each(each, block, pieces),
        lambda: transformed(pair),
        lambda: transformed(together),
    ]


COMPILED = (
    (solver, ("descend", "candidates")),
    (_position_kernels, ("judge", "measure", "carried_by")),
    (_window_kernels, ("overlap", "undeformed_gap", "copy_block")),
    (HalfSpace, ("deflect",)),
    (compiled, ("find_windows", "move", "list_nodes", "lead", "step_and_turn", "farthest")),
    (compiled, ("nodes_by_own_plans", "frames_by_own_plans", "judge_and_measure")),
    (BatchTransforms, ("deflect_nodes", "deflect_frames")),
)


def share_of_python(task: Task) -> float:
    """Return the share of the time of a task that its compiled calls do not take."""
    run = task.prepared()
    inside: dict[str, float] = defaultdict(float)
    former = [(home, name, getattr(home, name)) for home, names in COMPILED for name in names]

    def clocked(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            began = time.perf_counter()
            answer = function(*arguments, **named)
            inside[name] += time.perf_counter() - began
            return answer

        return call

    for home, name, function in former:
        setattr(home, name, clocked(name, function))
    began = time.perf_counter()
    try:
        run()
        whole = time.perf_counter() - began
    finally:
        for home, name, function in former:
            setattr(home, name, function)
    return 1 - sum(inside.values()) / whole


# ---- tables


def tables(gains: list[Gain], answers: list[Answers], parts: list[Parts]) -> str:
    """Return the measurements as three Markdown tables."""
    lines = [
        "|load, pieces|one core [ms]: one after the other, lockstep, with one plan|gains"
        "|two cores [ms]: one after the other, lockstep in processes, in threads|gains|",
        "|---|---|---|---|---|",
    ]
    for g in gains:
        one, one_plan, lockstep, two, processes, threads = g.ms
        lines.append(
            f"|{g.load:g} N, {g.pieces}|{one:.3f}, {lockstep:.3f}, {one_plan:.3f}"
            f"|{g.one_core:.2f}, {g.one_plan:.2f}|{two:.3f}, {processes:.3f}, {threads:.3f}"
            f"|{g.two_processes:.2f}, {g.two_threads:.2f}|"
        )
    lines += [
        "",
        "|load, pieces|tolerance|gap error over deflection: present, lockstep|convolutions of a"
        " piece: present, lockstep|rounds of a position|common window, block over own|windows too"
        " narrow|",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"|{a.load:g} N, {a.pieces}|{a.tolerance:.1g}|{a.gap_error:.2g},"
        f" {a.gap_error_in_lockstep:.2g}|{a.convolutions:.2f}, {a.convolutions_in_lockstep:.2f}"
        f"|{a.rounds:.2f}|{a.window_padding:.2f}, {a.block_padding:.2f}|{a.too_narrow}|"
        for a in answers
    ]
    lines += [
        "",
        "|load, pieces|block|transforms of a piece [us]: plan for each, for each pair, one plan"
        "|4 sweeps of a piece [us]: call for each, one call|Python in a step: present, lockstep|",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"|{p.load:g} N, {p.pieces}|{p.block[0]} x {p.block[1]}|{p.plan_each:.1f},"
        f" {p.plan_pair:.1f}, {p.plan_all:.1f}|{p.sweeps_each:.1f}, {p.sweeps_all:.1f}"
        f"|{p.python:.0%}, {p.python_in_lockstep:.0%}|"
        for p in parts
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--steps", type=int, default=100, help="timed steps of a piece")
    parser.add_argument("--rounds", type=int, default=5, help="turns of all ways")
    parser.add_argument("--pieces", type=int, nargs="+", default=PIECES, help="even numbers")
    parser.add_argument("--out", metavar="FOLDER", type=Path, default=OUTPUTS)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    gains = []
    answers = []
    parts = []
    for load in LOADS:
        for pieces in given.pieces:
            gains.append(measure_gain(load, pieces, given.steps, given.rounds))
            print(gains[-1], file=sys.stderr, flush=True)
            answers.append(compare_answers(load, pieces, max(given.steps // 5, 2)))
            print(answers[-1], file=sys.stderr, flush=True)
            parts.append(measure_parts(load, pieces, given.steps))
            print(parts[-1], file=sys.stderr, flush=True)
    kept = {
        "gains": [asdict(each) for each in gains],
        "answers": [asdict(each) for each in answers],
        "parts": [asdict(each) for each in parts],
    }
    (given.out / "lockstep.json").write_text(json.dumps(kept, indent=1) + "\n")
    (given.out / "lockstep.md").write_text(tables(gains, answers, parts))
    print(tables(gains, answers, parts), end="")


if __name__ == "__main__":
    main()
