"""Success rate of the contact solver on hard cases and random scenes.

Each scene is marched, and separate code judges each state.
"""

from __future__ import annotations

import multiprocessing
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import numpy as np

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import half_space_of
from rolling.simulation import lifeline, spawning
from rolling.verification import optimality
from rolling.verification.hard_cases import CAPACITY, ROOM, SOLVED, WIDTH, HardCase
from rolling.verification.random_cases import GENERATORS, random_case

# Maximum time of solving a scene [s], a hundred times the slowest; the long march has more.
TIME_LIMIT = 60.0
COMPILING_SCENES = 3  # of each generator, of which one at least is solved
LEDGER_ERROR = (
    1e-12  # share of the stored energy; the energy ledger is an identity except for rounding
)
REFUSALS = {  # words of a message: the reason of refusal
    "more than the surface can carry": CAPACITY,
    "um wide": WIDTH,
    "there is room for": ROOM,
}
MUST_HOLD = (
    "Pressures lie between 0 and the hardness, exactly.",
    "The gap is zero where the pressure lies between, not negative at zero pressure, "
    "and not positive at the hardness. A"
    " convolution by separate code checks this within 1.5 times the tolerance of the largest "
    "deflection.",
    "There is no contact outside the window, on the whole plate.",
    "The load is right to 1e-12; stored energy and deflections agree with that convolution to "
    "1e-11.",
    "Loading minus release equals the change of stored energy to 1e-12 of the stored energy.",
    "Every number is finite, there is no warning, iterations stay within the budget of the case, "
    "and the time within a minute.",
    "Later laps equal the first within 10 tolerances.",
    "A scene without a solution is refused with numbers; a scene with a solution is not.",
)
Task = HardCase | tuple[str, int]  # a case, or the generator and seed of one


@dataclass(frozen=True)
class Outcome:
    """The outcome of one case.

    Parameters
    ----------
    name, group, feature : str. Name, group and surface of the case.
    plate : str. "capped" or "elastic".
    result : str. SOLVED, a reason of refusal, or "failed".
    violated : tuple of str. The violated conditions, with numbers.
    message : str. The solver's message, empty without one.
    iterations : tuple of int. Iterations of each state.
    seconds : float, s. Time of solving, without judging.
    """

    name: str
    group: str
    feature: str
    plate: str
    result: str
    violated: tuple[str, ...]
    message: str
    iterations: tuple[int, ...]
    seconds: float


class _Trial:
    """The march of a case.

    Each state is judged at once, so a march of any length needs little memory.
    """

    def __init__(self, case: HardCase, keep: list[ContactState] | None) -> None:
        """Start without violations and append the states to `keep`."""
        self.case, self.keep = case, keep
        self.violated: list[str] = []
        self.iterations: list[int] = []
        self.approaches: list[float] = []
        self.releases: list[float] = []
        self.seconds = 0.0

    def march(self, track: RollingContact) -> None:
        """March the case and judge each state, each step and the laps."""
        half_space = half_space_of(track.spacing, track.contact_modulus, track.subcells)
        states = march(track, self.case.first, self.case.first + self.case.steps, half_space)
        limit = TIME_LIMIT + 0.1 * self.case.steps
        old: ContactState | None = None
        while (state := self._timed(states)) is not None:
            self._judge_state(track, state)
            if old is not None:
                self._judge_step(old, state, half_space)
            if self.seconds > limit:
                self._note(state, f"time: {self.seconds:.0f} s, allowed {limit:.0f}")
                return
            old = state
        if self.case.lap:
            self._judge_laps(
                track.tolerance * float(old.deflection.max()) if old is not None else 0.0
            )

    def _timed(self, states: Iterator[ContactState]) -> ContactState | None:
        """Return the next state and add its time, or return None after the last state."""
        began = time.perf_counter()
        try:
            return next(states, None)
        finally:
            self.seconds += time.perf_counter() - began

    def _judge_state(self, track: RollingContact, state: ContactState) -> None:
        """Check the contact conditions and the iterations of a state."""
        for violation in optimality.broken(track, state):
            self._note(state, violation)
        if state.iterations > self.case.budget:
            self._note(state, f"iterations: {state.iterations}, budget {self.case.budget}")
        self.iterations.append(state.iterations)
        self.approaches.append(state.approach)
        if self.keep is not None:
            self.keep.append(state)

    def _judge_step(self, old: ContactState, new: ContactState, half_space: HalfSpace) -> None:
        """Check the energy ledger of a step."""
        energy = step_energy(old, new, half_space)
        self.releases.append(energy.release)
        largest = max(old.stored_energy, new.stored_energy)
        if not abs(energy.defect) <= LEDGER_ERROR * largest:
            self._note(new, f"ledger: defect {energy.defect:.3g} J of {largest:.3g} J stored")

    def _judge_laps(self, tolerance: float) -> None:
        """Compare later laps with the first, within the tolerance [m].

        The first position has a cold start, and the same position a lap later a warm start. Both
        are within the tolerance.
        """
        laps = np.array(self.approaches[:-1]).reshape(-1, self.case.lap)
        drift = float(np.abs(laps - laps[0]).max())
        if not drift <= 10 * tolerance:
            self.violated.append(f"drift: approach by {drift:.3g} m, tolerance {tolerance:.3g} m")
        released = np.array(self.releases).reshape(-1, self.case.lap).sum(axis=1)
        if not np.ptp(released) <= 1e-3 * released.mean():
            self.violated.append(
                f"drift: release of a lap by {np.ptp(released) / released.mean():.3g}, "
                "allowed 0.001"
            )

    def _note(self, state: ContactState, violation: str) -> None:
        """Note a violation at the position of a state."""
        self.violated.append(f"position {state.position}: {violation}")


def judge(case: HardCase, keep: list[ContactState] | None = None) -> Outcome:
    """March a case with warnings as errors, and check all conditions.

    The states are appended to `keep`.
    """
    _compile_kernels()
    return _judge(case, keep)


@cache
def _compile_kernels() -> None:
    """March small scenes of each generator, once in a process.

    Without a cache compilation takes up to a minute, which no case may be charged with.
    """
    for generator in GENERATORS:
        for seed in range(COMPILING_SCENES):
            _judge(random_case(generator, seed), None)


def _judge(case: HardCase, keep: list[ContactState] | None) -> Outcome:
    """March a case as `judge` does, where kernels are compiled."""
    trial, result, message = _Trial(case, keep), SOLVED, ""
    track = case.build()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            trial.march(track)
    except ContactError as error:
        message = str(error)
        result = next((reason for words, reason in REFUSALS.items() if words in message), "failed")
        if result == "failed":
            trial.violated.append(f"unsolved: {message}")
        elif sum(c.isdigit() for c in message) < 3 or "nan" in message or "inf " in message:
            trial.violated.append(f"refused without its numbers: {message}")
    except Exception as error:  # any error: the other cases continue and this one is shown
        trial.violated.append(f"raised: {type(error).__name__}: {error}")
    if result not in (*case.right, "failed"):
        trial.violated.append(f"{result}, expected: {' or '.join(case.right)} {message}".rstrip())
    return Outcome(
        name=case.name,
        group=case.group,
        feature=case.feature,
        plate="capped" if np.isfinite(track.hardness) else "elastic",
        result="failed" if trial.violated else result,
        violated=tuple(trial.violated),
        message=message,
        iterations=tuple(trial.iterations),
        seconds=trial.seconds,
    )


def judge_task(task: Task) -> Outcome:
    """Judge a case, or the random scene of a generator and a seed, in a worker process."""
    return judge(task if isinstance(task, HardCase) else random_case(*task))


@dataclass(frozen=True)
class Iterations:
    """Iterations over all states: median, 95th percentile and maximum."""

    median: int = 0
    high: int = 0
    most: int = 0


@dataclass(frozen=True)
class Tally:
    """Counts over some outcomes, with the share of successful cases."""

    scenes: int
    solved: int
    refused: dict[str, int]
    failed: int
    success_rate: float
    states: int
    iterations: Iterations
    solving_seconds: float


@dataclass(frozen=True)
class Group:
    """The tally of all outcomes of a group, surface and plate."""

    group: str
    surface: str
    plate: str
    tally: Tally

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "group": self.group,
            "surface": self.surface,
            "plate": self.plate,
            **asdict(self.tally),
        }


@dataclass(frozen=True)
class Report:
    """The outcomes of all cases.

    Parameters
    ----------
    seconds : float, s. Time of the whole report.
    total : Tally. All cases except the group "found". Its scenes entered the report because they
        failed once, so they do not count for the rate of failure.
    groups : list of Group. Tallies in the order of the table.
    cases : list of (HardCase, Outcome). The given cases.
    failed : list of Outcome. All outcomes with a violation.
    """

    seconds: float
    total: Tally
    groups: list[Group]
    cases: list[tuple[HardCase, Outcome]]
    failed: list[Outcome]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "must_hold": list(MUST_HOLD),
            "seconds": self.seconds,
            "total": asdict(self.total),
            "groups": [group.to_dict() for group in self.groups],
            "cases": [
                {
                    "name": case.name,
                    "why": case.why,
                    "result": outcome.result,
                    "most_iterations": max(outcome.iterations, default=0),
                }
                for case, outcome in self.cases
            ],
            "failures": [
                {"scene": outcome.name, "violated": list(outcome.violated)}
                for outcome in self.failed
            ],
        }


def judge_all(
    cases: Sequence[HardCase],
    random: int,
    odd: int,
    blended: int,
    subcells: int = 0,
    workers: int = 1,
    progress: Callable[[int], object] = lambda scenes: None,
) -> Report:
    """Judge the given cases, and scenes of each generator.

    Parameters
    ----------
    cases : sequence of HardCase. Cases that are always judged.
    random, odd, blended, subcells : int. Numbers of scenes from each generator.
    workers : int. Number of processes. Default: 1.
    progress : function. It is called with 1 after each scene. Default: nothing happens.
    """
    tasks: list[Task] = [
        *cases,
        *(("random", seed) for seed in range(random)),
        *(("odd", seed) for seed in range(odd)),
    ]
    tasks += [("blended", seed) for seed in range(blended)]
    tasks += [("subcells", seed) for seed in range(subcells)]
    outcomes = []
    began = time.perf_counter()
    for outcome in _outcomes(tasks, workers):
        outcomes.append(outcome)
        progress(1)
    groups: dict[tuple[str, str, str], list[Outcome]] = defaultdict(list)
    for outcome in outcomes:
        groups[outcome.group, outcome.feature, outcome.plate].append(outcome)
    return Report(
        seconds=time.perf_counter() - began,
        total=_tally([outcome for outcome in outcomes if outcome.group != "found"]),
        groups=[
            Group(*key, _tally(groups[key])) for key in sorted(groups, key=lambda key: _order(*key))
        ],
        cases=list(zip(cases, outcomes, strict=False)),
        failed=[outcome for outcome in outcomes if outcome.violated],
    )


def _order(group: str, feature: str, plate: str) -> tuple[int, str, str]:
    """Return the sorting key of a group in the table."""
    return ("named", "found", *GENERATORS).index(group), feature, plate


def _outcomes(tasks: list[Task], workers: int) -> Iterable[Outcome]:
    """Judge all tasks in their order, in processes if there is more than one worker."""
    if workers == 1 or not spawning.can_start_workers():
        yield from map(judge_task, tasks)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, lifeline.end_with_parent) as pool:
        yield from pool.map(judge_task, tasks, chunksize=8)


def _tally(outcomes: Sequence[Outcome]) -> Tally:
    """Count the results, the share of successful cases, and the iterations over all states."""
    results = Counter(outcome.result for outcome in outcomes)
    iterations = [count for outcome in outcomes for count in outcome.iterations]
    percentiles = (
        (int(count) for count in np.percentile(iterations, [50, 95, 100])) if iterations else ()
    )
    return Tally(
        scenes=len(outcomes),
        solved=results[SOLVED],
        refused={reason: results[reason] for reason in (CAPACITY, WIDTH, ROOM)},
        failed=results["failed"],
        success_rate=1 - results["failed"] / len(outcomes) if outcomes else 1.0,
        states=len(iterations),
        iterations=Iterations(*percentiles),
        solving_seconds=sum(outcome.seconds for outcome in outcomes),
    )
