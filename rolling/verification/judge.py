"""Success rate of the contact solver on hard cases and random scenes: each is marched, and each state judged independently.

Depends on hard_scenes, random_scenes and optimality.
"""

from __future__ import annotations

import multiprocessing
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.folders import files
from rolling.simulation import lifeline
from rolling.verification import hard_cases, optimality
from rolling.verification.hard_cases import CAPACITY, CASES, ROOM, SOLVED, WIDTH, HardCase
from rolling.verification.random_cases import found_cases, random_case

TIME_LIMIT = 60.0  # [s] of solving per scene: a hundred times what the slowest needs; the long march is given more
LEDGER_ERROR = 1e-12  # of the stored energy; an identity but for rounding
REFUSALS = {  # words of a message: what it refuses
    "more than the surface can carry": CAPACITY,
    "um wide": WIDTH,
    "there is room for": ROOM,
}
MUST_HOLD = (
    "pressures between 0 and the hardness, exactly",
    "gap zero where the pressure is between, none negative at zero pressure, none positive at the hardness: within 1.5 times"
    " the tolerance of the largest deflection, by a convolution of its own",
    "no contact outside the window, on all of the plate",
    "load to 1e-12; stored energy and deflections to 1e-11 of that convolution",
    "loading minus release equals the change of stored energy to 1e-12 of it",
    "every number finite, no warning, iterations within the case's budget, a minute at most",
    "laps, where there are some, equal to the first within 10 tolerances",
    "a scene with no answer is refused with numbers; one that has an answer is not",
)
Task = HardCase | tuple[str, int]  # a case, or the generator and seed of one


@dataclass(frozen=True)
class Outcome:
    """What became of a case. `result`: SOLVED, a reason of refusal, or "failed" with what was violated.

    iterations : of each state. seconds : of solving, without the judging.
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


class _Judge:
    """Marches one case and gathers what is violated, state by state, so that a march of any length can be judged."""

    def __init__(self, case: HardCase, keep: list[ContactState] | None) -> None:
        self.case, self.keep = case, keep
        self.violated: list[str] = []
        self.iterations: list[int] = []
        self.approaches: list[float] = []
        self.releases: list[float] = []
        self.seconds = 0.0

    def march(self, track: RollingContact) -> None:
        half_space = HalfSpace(track.spacing, track.contact_modulus)
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
            self._judge_laps(track.tolerance * float(old.deflection.max()) if old is not None else 0.0)

    def _timed(self, states: Iterator[ContactState]) -> ContactState | None:
        began = time.perf_counter()
        try:
            return next(states, None)
        finally:
            self.seconds += time.perf_counter() - began

    def _judge_state(self, track: RollingContact, state: ContactState) -> None:
        for found in optimality.broken(track, state):
            self._note(state, found)
        if state.iterations > self.case.budget:
            self._note(state, f"iterations: {state.iterations}, budget {self.case.budget}")
        self.iterations.append(state.iterations)
        self.approaches.append(state.approach)
        if self.keep is not None:
            self.keep.append(state)

    def _judge_step(self, old: ContactState, new: ContactState, half_space: HalfSpace) -> None:
        energy = step_energy(old, new, half_space)
        self.releases.append(energy.release)
        largest = max(old.stored_energy, new.stored_energy)
        if not abs(energy.defect) <= LEDGER_ERROR * largest:
            self._note(new, f"ledger: defect {energy.defect:.3g} J of {largest:.3g} J stored")

    def _judge_laps(self, tolerance: float) -> None:
        """The first position of all is solved from a cold start, the same one a lap later is not: both within the tolerance."""
        laps = np.array(self.approaches[:-1]).reshape(-1, self.case.lap)
        drift = float(np.abs(laps - laps[0]).max())
        if not drift <= 10 * tolerance:
            self.violated.append(f"drift: approach by {drift:.3g} m, tolerance {tolerance:.3g} m")
        released = np.array(self.releases).reshape(-1, self.case.lap).sum(axis=1)
        if not np.ptp(released) <= 1e-3 * released.mean():
            self.violated.append(f"drift: release of a lap by {np.ptp(released) / released.mean():.3g}, allowed 0.001")

    def _note(self, state: ContactState, found: str) -> None:
        self.violated.append(f"position {state.position}: {found}")


def judge(case: HardCase, keep: list[ContactState] | None = None) -> Outcome:
    """March a case, warnings as errors, and check all that must hold; the states are appended to `keep`."""
    judged, result, message = _Judge(case, keep), SOLVED, ""
    track = case.build()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            judged.march(track)
    except ContactError as error:
        message = str(error)
        result = next((reason for words, reason in REFUSALS.items() if words in message), "failed")
        if result == "failed":
            judged.violated.append(f"unsolved: {message}")
        elif sum(c.isdigit() for c in message) < 3 or "nan" in message or "inf " in message:
            judged.violated.append(f"refused without its numbers: {message}")
    except Exception as error:  # whatever it is, the other cases go on and this one is shown
        judged.violated.append(f"raised: {type(error).__name__}: {error}")
    if result not in (*case.right, "failed"):
        judged.violated.append(f"{result}, expected: {' or '.join(case.right)} {message}".rstrip())
    return Outcome(
        name=case.name,
        group=case.group,
        feature=case.feature,
        plate="capped" if np.isfinite(track.hardness) else "elastic",
        result="failed" if judged.violated else result,
        violated=tuple(judged.violated),
        message=message,
        iterations=tuple(judged.iterations),
        seconds=judged.seconds,
    )


def judge_task(task: Task) -> Outcome:
    """Judge a case, or the random one of (generator, seed): what a worker process is sent."""
    return judge(task if isinstance(task, HardCase) else random_case(*task))


def report(
    cases: Sequence[HardCase],
    random: int = 2000,
    odd: int = 500,
    blended: int = 500,
    workers: int = 1,
    progress: Callable[[int], object] = lambda scenes: None,
) -> dict[str, Any]:
    """Judge the cases and so many random and odd scenes; plain data for JSON: groups, failures, refusals, what must hold."""
    tasks: list[Task] = [*cases, *(("random", k) for k in range(random)), *(("odd", k) for k in range(odd))]
    tasks += [("blended", k) for k in range(blended)]
    outcomes = []
    began = time.perf_counter()
    for outcome in _judged(tasks, workers):
        outcomes.append(outcome)
        progress(1)
    groups: dict[tuple[str, str, str], list[Outcome]] = defaultdict(list)
    for one in outcomes:
        groups[one.group, one.feature, one.plate].append(one)
    return {
        "must_hold": list(MUST_HOLD),
        "seconds": time.perf_counter() - began,
        # Scenes that are here because they failed say nothing of how often one does.
        "total": _figures([one for one in outcomes if one.group != "found"]),
        "groups": [
            {"group": group, "surface": feature, "plate": plate, **_figures(members)}
            for (group, feature, plate), members in sorted(groups.items(), key=lambda item: _order(*item[0]))
        ],
        "cases": [
            {
                "name": case.name,
                "why": case.why,
                "result": one.result,
                "most_iterations": max(one.iterations, default=0),
            }
            for case, one in zip(cases, outcomes, strict=False)
        ],
        "failures": [{"scene": one.name, "violated": list(one.violated)} for one in outcomes if one.violated],
    }


def _order(group: str, feature: str, plate: str) -> tuple[int, str, str]:
    return ("named", "found", "random", "odd", "blended").index(group), feature, plate


def _judged(tasks: list[Task], workers: int) -> Iterable[Outcome]:
    if workers == 1:
        yield from map(judge_task, tasks)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, lifeline.end_with_parent) as pool:
        yield from pool.map(judge_task, tasks, chunksize=8)


def _figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Counts, the share that held, and iterations over all states: median, 95 %, most."""
    results = Counter(one.result for one in outcomes)
    iterations = [k for one in outcomes for k in one.iterations]
    median, high, most = (int(k) for k in np.percentile(iterations, [50, 95, 100])) if iterations else (0, 0, 0)
    return {
        "scenes": len(outcomes),
        "solved": results[SOLVED],
        "refused": {reason: results[reason] for reason in (CAPACITY, WIDTH, ROOM)},
        "failed": results["failed"],
        "success_rate": 1 - results["failed"] / len(outcomes) if outcomes else 1.0,
        "states": len(iterations),
        "iterations": {"median": median, "high": high, "most": most},
        "solving_seconds": sum(one.seconds for one in outcomes),
    }


def table(data: dict[str, Any]) -> str:
    """The report as Markdown, aligned to be read as text too."""
    heads = ["group", "surface", "plate", "scenes", "solved", *(f"refused: {r}" for r in data["total"]["refused"])]
    heads += ["failed", "held %", "iterations 50 %", "95 %", "most"]
    total = {"group": "all but found", "surface": "", "plate": "", **data["total"]}
    lines = [heads, *(_row(group) for group in (*data["groups"], total))]
    widths = [max(len(line[k]) for line in lines) for k in range(len(heads))]
    aligned = [
        [c.ljust(w) if k < 3 else c.rjust(w) for k, (c, w) in enumerate(zip(x, widths, strict=True))] for x in lines
    ]
    rule = ["-" * w if k < 3 else "-" * (w - 1) + ":" for k, w in enumerate(widths)]
    text = ["# Hard cases", "", "Must hold, or the scene counts as failed:", ""]
    text += [f"- {condition}" for condition in data["must_hold"]]
    text += ["", *(f"| {' | '.join(line)} |" for line in (aligned[0], rule, *aligned[1:])), ""]
    total_seconds, solving = data["seconds"], data["total"]["solving_seconds"]
    text += [f"{data['total']['states']} states; {total_seconds:.1f} s, {solving:.1f} s of it solving.", ""]
    text += [f"## Failures: {len(data['failures'])}", ""]
    for failure in data["failures"]:
        text += [f"- {failure['scene']}: {'; '.join(failure['violated'][:3])}"]
    return "\n".join(text).rstrip() + "\n"


def _row(group: dict[str, Any]) -> list[str]:
    iterations = group["iterations"]
    numbers = [group["scenes"], group["solved"], *group["refused"].values(), group["failed"]]
    rate = f"{100 * group['success_rate']:.2f}"
    return [group["group"], group["surface"], group["plate"], *map(str, numbers), rate, *map(str, iterations.values())]


def main_report(out: Path, random: int, workers: int = 1, long: bool = False) -> int:
    """Judge all, print the table, write hard.json and hard.md to the folder `out`; returns 0 when nothing failed, else 1.

    random : scenes of random_scene, and a quarter as many odd and blended ones. long : adds the march of 1e5 steps, some minutes.
    """
    from tqdm import tqdm

    cases = [*CASES, *found_cases(), *([hard_cases.LONG] if long else [])]
    others = random // 4
    with tqdm(total=len(cases) + random + 2 * others, unit="scene", file=sys.stderr, disable=None) as bar:
        data = report(cases, random, others, others, workers, bar.update)
    text = table(data)
    print(text)
    out.mkdir(parents=True, exist_ok=True)
    files.write_json(out / "hard.json", data)
    files.write_bytes(out / "hard.md", text.encode())
    return 1 if data["failures"] else 0
