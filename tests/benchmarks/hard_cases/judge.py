"""The outcome of a hard case: the scene is marched, and separate code checks each state."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from hard_cases import optimality
from hard_cases.named_cases import CAPACITY, ROOM, SOLVED, WIDTH, HardCase
from hard_cases.random_cases import GENERATORS, random_case
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import half_space_of

FAILED = "failed"
# Maximum time of solving a scene [s], a hundred times the slowest; the long march has more.
TIME_LIMIT = 60.0
COMPILING_SCENES = 3  # of each generator, of which one at least is solved
LEDGER_ERROR = 1e-12  # share of the stored energy; the ledger is an identity except for rounding
REFUSALS = {  # words of a message: the reason of refusal
    "more than the surface can carry": CAPACITY,
    "um wide": WIDTH,
    "there is room for": ROOM,
}
CONDITIONS = (
    "Pressures lie between 0 and the hardness, exactly.",
    "The gap is zero where the pressure lies between, not negative at zero pressure, and not"
    " positive at the hardness. A convolution by separate code checks this within 1.5 times the"
    " tolerance of the largest deflection.",
    "There is no contact outside the window, on the whole plate.",
    "The load is right to 1e-12; stored energy and deflections agree with that convolution to"
    " 1e-11.",
    "Loading minus release equals the change of stored energy to 1e-12 of the stored energy.",
    "Every number is finite, there is no warning, iterations stay within the budget of the case,"
    " and the time within a minute.",
    "Later laps equal the first within 10 tolerances.",
    "A scene without a solution is refused with numbers; a scene with a solution is not.",
)


@dataclass(frozen=True)
class Outcome:
    """The outcome of one case.

    name, group, feature : str. Name, group and surface of the case.
    plate : str. "capped" or "elastic".
    result : str. SOLVED, a reason of refusal, or FAILED.
    violations : tuple of str. Violated conditions with their numbers.
    message : str. The solver's message, empty without one.
    iterations : tuple of int. Iterations of each state.
    """

    name: str
    group: str
    feature: str
    plate: str
    result: str
    violations: tuple[str, ...]
    message: str
    iterations: tuple[int, ...]


def judge(case: HardCase, keep: list[ContactState] | None = None) -> Outcome:
    """March a case with warnings as errors, check all conditions, and append its states to keep."""
    _compile_kernels()
    return _judge(case, keep)


@cache
def _compile_kernels() -> None:
    """March small scenes of each generator once, so that no case is charged the compilation."""
    for generator in GENERATORS:
        for seed in range(COMPILING_SCENES):
            _judge(random_case(generator, seed), None)


def _judge(case: HardCase, keep: list[ContactState] | None) -> Outcome:
    """Judge a case where the kernels are compiled."""
    trial = _Trial(case, keep)
    result = SOLVED
    message = ""
    track = case.build()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            trial.march(track)
    except ContactError as error:
        message = str(error)
        result = next((reason for words, reason in REFUSALS.items() if words in message), FAILED)
        if result == FAILED:
            trial.violations.append(f"unsolved: {message}")
        elif sum(c.isdigit() for c in message) < 3 or "nan" in message or "inf " in message:
            trial.violations.append(f"refused without its numbers: {message}")
    except Exception as error:  # the other cases continue and this error is shown
        trial.violations.append(f"raised: {type(error).__name__}: {error}")
    if result not in (*case.right, FAILED):
        trial.violations.append(f"{result}, expected: {' or '.join(case.right)} {message}".rstrip())
    return Outcome(
        name=case.name,
        group=case.group,
        feature=case.feature,
        plate="capped" if np.isfinite(track.hardness) else "elastic",
        result=FAILED if trial.violations else result,
        violations=tuple(trial.violations),
        message=message,
        iterations=tuple(trial.iterations),
    )


class _Trial:
    """The march of a case, whose states are checked at once, so that it needs little memory."""

    def __init__(self, case: HardCase, keep: list[ContactState] | None) -> None:
        self.case = case
        self.keep = keep
        self.violations: list[str] = []
        self.iterations: list[int] = []
        self.approaches: list[float] = []
        self.releases: list[float] = []
        self.seconds = 0.0

    def march(self, track: RollingContact) -> None:
        """March the case and check each state, each step and the laps."""
        half_space = half_space_of(track.spacing, track.contact_modulus, track.subcells)
        states = march(track, self.case.first, self.case.first + self.case.steps, half_space)
        limit = TIME_LIMIT + 0.1 * self.case.steps
        old: ContactState | None = None
        while (state := self._timed(states)) is not None:
            self._check_state(track, state)
            if old is not None:
                self._check_step(old, state, half_space)
            if self.seconds > limit:
                self._note(state, f"time: {self.seconds:.0f} s, allowed {limit:.0f}")
                return
            old = state
        if self.case.lap and old is not None:
            self._check_laps(track.tolerance * float(old.deflection.max()))

    def _timed(self, states: Iterator[ContactState]) -> ContactState | None:
        """Return the next state and add its time, or return None after the last state."""
        began = time.perf_counter()
        try:
            return next(states, None)
        finally:
            self.seconds += time.perf_counter() - began

    def _check_state(self, track: RollingContact, state: ContactState) -> None:
        """Check the contact conditions and the iterations of a state."""
        for violation in optimality.broken(track, state):
            self._note(state, violation)
        if state.iterations > self.case.budget:
            self._note(state, f"iterations: {state.iterations}, budget {self.case.budget}")
        self.iterations.append(state.iterations)
        self.approaches.append(state.approach)
        if self.keep is not None:
            self.keep.append(state)

    def _check_step(self, old: ContactState, new: ContactState, half_space: HalfSpace) -> None:
        """Check the energy ledger of a step."""
        energy = step_energy(old, new, half_space)
        self.releases.append(energy.release)
        largest = max(old.stored_energy, new.stored_energy)
        if not abs(energy.defect) <= LEDGER_ERROR * largest:
            self._note(new, f"ledger: defect {energy.defect:.3g} J of {largest:.3g} J stored")

    def _check_laps(self, tolerance: float) -> None:
        """Compare later laps, which start warm, with the first, within the tolerance [m]."""
        laps = np.array(self.approaches[:-1]).reshape(-1, self.case.lap)
        drift = float(np.abs(laps - laps[0]).max())
        if not drift <= 10 * tolerance:
            self.violations.append(f"drift: approach by {drift:.3g} m, tolerance {tolerance:.3g} m")
        released = np.array(self.releases).reshape(-1, self.case.lap).sum(axis=1)
        share = np.ptp(released) / released.mean()
        if not share <= 1e-3:
            self.violations.append(f"drift: release of a lap by {share:.3g}, allowed 0.001")

    def _note(self, state: ContactState, violation: str) -> None:
        """Note a violation at the position of a state."""
        self.violations.append(f"position {state.position}: {violation}")
