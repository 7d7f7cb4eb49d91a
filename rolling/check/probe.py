"""A few solved positions of a scene: contact areas, pressure and time of a step.

The closed forms of a smooth sphere cannot tell whether asperities yield. Eight cold starts along
the track can, at the cost of some 90 steps of the march.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import clock, rounded, si
from rolling.check import cost
from rolling.check.error_cost import COLD_STEPS
from rolling.check.finding import Finding
from rolling.check.forecast import surface_time
from rolling.contact import compiling
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si import scene_surface
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.terminal import progress

POSITIONS = 8
WARM_STEPS = 4  # after each cold start, for the time of a step
MAX_NODES = 10_000_000  # maximum for a generated surface, which takes about 4 s and 400 MB
MAX_SECONDS = 60.0  # expected time of the solved positions, of one run and of all runs of a sweep
# If a sweep has more runs, or slow runs, only its first and last runs are solved.
MAX_RUNS = 12


class Position(NamedTuple):
    """A solved position.

    contact_area, plastic_area : float, m2.
    max_pressure : float, Pa.
    step_ms : float, ms. Minimum time of the warm steps that follow it.
    rows, columns : int. Nodes of the window of the last of them.
    """

    contact_area: float
    plastic_area: float
    max_pressure: float
    step_ms: float
    rows: int
    columns: int


@dataclass(frozen=True)
class Probe:
    """Solved positions of one run.

    Attributes
    ----------
    solved : tuple of Position
        Solved positions.
    tried : int
        Number of positions.
    failures : tuple of str
        Messages of the positions that failed.
    left_out : str
        Reason why no position was solved; empty where some were.
    surface_s : float, s
        Time in which the surface was made; hardly any where it was there already.
    """

    solved: tuple[Position, ...] = ()
    tried: int = 0
    failures: tuple[str, ...] = ()
    left_out: str = ""
    surface_s: float = 0.0

    def findings(self, scene: Scene) -> Iterator[Finding | Doubt]:
        """State the numbers of the solved positions, in place of closed forms and cost model."""
        value = f"{len(self.solved)} of {self.tried}"
        if self.left_out:
            value = f"none: {self.left_out}"
        yield Finding("positions", "positions solved", value)
        if self.failures:
            yield Doubt(
                "positions",
                f"positions solved: {len(self.failures)} of {self.tried} positions fail, and so "
                f"will the run: {self.failures[0]}",
                Severity.REFUSED,
            )
        if self.solved:
            yield from self._times(scene)
            yield from self._contact(scene)

    def _times(self, scene: Scene) -> Iterator[Finding]:
        """State window and time of a step, and the time of the march that follows from it."""
        making, _ = cost.surface_seconds(scene)
        if making:
            yield from surface_time(scene, max(1.0, self.surface_s / making))
        rows = np.array([position.rows for position in self.solved])
        columns = np.array([position.columns for position in self.solved])
        least = f"{rows.min()} x {columns.min()}"
        most = f"{rows.max()} x {columns.max()}"
        window = f"{rows.mean():.0f} x {columns.mean():.0f} nodes"
        if least != most:
            window += f" ({least} to {most})"
        yield Finding("window", "window", window)
        step_ms = np.array([position.step_ms for position in self.solved])
        step = _ranged(step_ms, lambda ms: f"{rounded(ms)} ms")
        yield Finding("step_time", "time of a step", f"{step} on 1 core")
        slow = float(step_ms.mean()) / cost.step_ms(scene)
        seconds = slow * cost.expected_seconds(scene)
        yield Finding("expected_time", "time of the march", cost.computing(seconds), seconds)

    def _contact(self, scene: Scene) -> Iterator[Finding]:
        """State areas and maximum pressure, and on which share of the contact the plate yields."""
        contact_area = np.array([position.contact_area for position in self.solved])
        plastic_area = np.array([position.plastic_area for position in self.solved])
        pressure = np.array([position.max_pressure for position in self.solved])
        yield Finding("contact_area", "contact area", _ranged(contact_area, _area))
        if math.isfinite(scene.hardness):
            says = "stays elastic where solved"
            whole = 100 * plastic_area.sum() / contact_area.sum()
            if whole:
                share = 100 * plastic_area / contact_area
                extremes = f"{rounded(share.min())} to {rounded(share.max())} %"
                says = f"yields on {rounded(whole)} % of the contact ({extremes})"
            yield Finding("hardness", "hardness", f"{si(scene.hardness, 'Pa')}, {says}")
            yield Finding("plastic_area", "plastic area", _ranged(plastic_area, _area))
        words = _ranged(pressure, lambda value: si(value, "Pa"))
        yield Finding("max_pressure", "maximum pressure", words)


def _ranged(values: Array, text: Callable[[float], str]) -> str:
    """Write mean and range: 2.1 ms (1.9 to 2.3 ms)."""
    least = text(float(values.min()))
    most = text(float(values.max()))
    mean = text(float(values.mean()))
    return mean if least == most else f"{mean} ({least} to {most})"


def _area(value: float) -> str:
    """Write an area [m2] in square micrometres, without an exponent."""
    return f"{float(f'{value * 1e12:.3g}'):.15g} um2"


def probes(scenes: Sequence[Scene]) -> list[Probe]:
    """Solve positions of the runs of a sweep, for a minute at most, with a progress bar.

    Runs that share a surface are solved in succession, so that it is made only once. Raise
    SceneError for a surface that cannot be made or read.
    """
    reasons = _left_out(scenes)
    chosen = [k for k, reason in enumerate(reasons) if not reason]
    chosen.sort(key=lambda k: str(scene_surface.identity(scenes[k])))
    result = [Probe(left_out=reason) for reason in reasons]
    bar = progress.Bar(POSITIONS * len(chosen), "solving positions")
    with bar, compiling.reporting(progress.compiling):
        for k in chosen:
            began = time.perf_counter()
            contact = rolling_contact(scenes[k])
            made = time.perf_counter() - began
            solved = probe(contact, scenes[k].track.solved_steps, bar.update)
            result[k] = replace(solved, surface_s=made)
    return result


def probe(
    contact: RollingContact, steps: int, tell: Callable[[int], object] = lambda count: None
) -> Probe:
    """Solve positions evenly along a track of steps, each from a cold start, and time warm steps.

    The first position is solved once in advance, so that the times exclude compilation.
    """
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    places = sorted({k * steps // POSITIONS for k in range(POSITIONS)})
    solved: list[Position] = []
    failures: list[str] = []
    with suppress(ContactError):  # the same position fails again below
        _solve(contact, 0, half_space)
    for place in places:
        try:
            solved.append(_solve(contact, place, half_space))
        except ContactError as error:
            failures.append(str(error))
        tell(1)
    tell(POSITIONS - len(places))  # a track may have fewer steps than positions
    return Probe(tuple(solved), len(places), tuple(failures))


def _solve(contact: RollingContact, k: int, half_space: HalfSpace) -> Position:
    """Solve position k from a cold start, and time the warm steps after it with their release."""
    states: list[ContactState] = []
    times: list[float] = []
    began = time.process_time()  # other programs may hold the processor
    for state in march(contact, k, k + WARM_STEPS, half_space):
        if states:
            step_energy(states[-1], state, half_space)
        times.append(time.process_time() - began)
        states.append(state)
    window = states[-1].window.cells(contact.subcells)
    return Position(
        contact_area=states[0].contact_area,
        plastic_area=states[0].plastic_area,
        max_pressure=states[0].max_pressure,
        step_ms=1e3 * float(np.min(np.diff(times))),  # other programs only add to it
        rows=window.rows,
        columns=window.columns,
    )


def _left_out(scenes: Sequence[Scene]) -> list[str]:
    """Give the reason per run why its positions are not solved, empty where they are."""
    reasons: list[str] = []
    seconds = 0.0
    made = set[object]()
    for scene in scenes:
        is_read = isinstance(scene.surface, HeightFile)
        nodes = 0 if is_read else scene.track.surface_nodes
        solving = POSITIONS * (1 + COLD_STEPS + WARM_STEPS) * cost.step_ms(scene) * 1e-3
        reason = ""
        if nodes > MAX_NODES:
            reason = (
                f"making {rounded(nodes / 1e6, 3)} million nodes would take long, the limit is "
                f"{rounded(MAX_NODES / 1e6)} million"
            )
        elif solving > MAX_SECONDS:
            reason = f"it would take about {clock(solving)}, the limit is {clock(MAX_SECONDS)}"
        else:
            key = scene_surface.identity(scene)
            seconds += solving
            if key not in made:
                seconds += cost.surface_seconds(scene)[0]
            made.add(key)
        reasons.append(reason)
    if len(scenes) <= MAX_RUNS and seconds <= MAX_SECONDS:
        return reasons
    for k in range(1, len(scenes) - 1):
        reasons[k] = reasons[k] or f"first and last of {len(scenes)} runs only"
    return reasons
