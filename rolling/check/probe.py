"""A few solved positions of a scene: contact areas, pressure and time of a step.

The closed forms of a smooth sphere cannot tell whether asperities yield. Eight cold starts along
the track can, for less than a hundredth of the cost of a run.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.check import cost, error_cost
from rolling.check.finding import Finding, clock, computing, si, surface_time
from rolling.contact import compiling
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import half_space_of
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface import scene_surface
from rolling.surface.contact_of_scene import rolling_contact
from rolling.terminal import progress

POSITIONS = 8
WARM_STEPS = 3  # after each cold start, for the time of a step
COLD_STEPS = 1 + error_cost.START_STEPS  # cost of a cold position in steps
MAX_NODES = 10_000_000  # maximum for a generated surface, which takes about 4 s and 400 MB
MAX_SECONDS = 60.0  # expected time of the solved positions, of one run and of all runs of a sweep
# If a sweep has more runs, or slow runs, only its first and last runs are solved.
MAX_RUNS = 12


@dataclass(frozen=True)
class Probe:
    """Solved positions of one run; arrays have an entry per solved position.

    Attributes
    ----------
    tried : int
        Number of positions.
    contact_area, plastic_area : (positions,) arrays, m2
        Contact area and yielding area.
    max_pressure : (positions,) array, Pa
        Maximum pressure.
    window : (positions, 2) array
        Nodes of the window along and across.
    step_ms : (positions,) array, ms
        Median time of the warm steps that follow each position.
    failures : tuple of str
        Messages of the positions that failed.
    left_out : str
        Reason why no position was solved; empty where some were.
    surface_s : float, s
        Time in which the surface was made; hardly any where it was there already.
    """

    tried: int
    contact_area: Array
    plastic_area: Array
    max_pressure: Array
    window: NDArray[np.int64]
    step_ms: Array
    failures: tuple[str, ...] = ()
    left_out: str = ""
    surface_s: float = 0.0

    @classmethod
    def without(cls, reason: str) -> Probe:
        """Make a probe without positions, for a reason."""
        none = np.empty(0)
        return cls(0, none, none, none, np.empty((0, 2), np.int64), none, (), reason)

    def findings(self, scene: Scene) -> list[Finding]:
        """State the numbers of the solved positions, in place of closed forms and cost model."""
        count, failed = len(self.contact_area), None
        if self.failures:
            failed = (
                f"{len(self.failures)} of {self.tried} positions fail, and so will the run:"
                f" {self.failures[0]}"
            )
        value = f"none: {self.left_out}" if self.left_out else f"{count} of {self.tried}"
        result = [Finding("positions", "positions solved", value, failed)]
        if not count:
            return result
        seconds = scene.track.solved_steps * float(self.step_ms.mean()) * 1e-3
        step = _ranged(self.step_ms, lambda ms: f"{rounded(ms)} ms")
        nodes = np.rint(self.window.mean(axis=0)), self.window.min(axis=0), self.window.max(axis=0)
        mean, least, most = (f"{along:.0f} x {across:.0f}" for along, across in nodes)
        window = f"{mean} nodes" + (f" ({least} to {most})" if least != most else "")
        if making := cost.surface_seconds(scene)[0]:
            result += surface_time(scene, max(1.0, self.surface_s / making))
        result += [
            Finding("window", "window", window),
            Finding("step_time", "time of a step", f"{step} on 1 core"),
            Finding("expected_time", "expected time", computing(seconds), None, seconds),
            Finding("contact_area", "contact area", _ranged(self.contact_area, _area)),
        ]
        if math.isfinite(scene.hardness):
            share = 100 * self.plastic_area / self.contact_area
            whole = 100 * self.plastic_area.sum() / self.contact_area.sum()
            says = "stays elastic where solved"
            if whole:
                range_ = f"{rounded(share.min())} to {rounded(share.max())} %"
                says = f"yields on {rounded(whole)} % of the contact ({range_})"
            result += [
                Finding("hardness", "hardness", f"{si(scene.hardness, 'Pa')}, {says}"),
                Finding("plastic_area", "plastic area", _ranged(self.plastic_area, _area)),
            ]
        pressure = _ranged(self.max_pressure, lambda value: si(value, "Pa"))
        return [*result, Finding("max_pressure", "maximum pressure", pressure)]


def _ranged(values: Array, text: Callable[[float], str]) -> str:
    """Write mean and range: 2.1 ms (1.9 to 2.3 ms)."""
    least, most = text(float(values.min())), text(float(values.max()))
    return text(float(values.mean())) + (f" ({least} to {most})" if least != most else "")


def _area(value: float) -> str:
    return f"{float(f'{value * 1e12:.3g}'):.15g} um2"


def probes(scenes: Sequence[Scene]) -> list[Probe]:
    """Solve positions of the runs of a sweep, for a minute at most, with a progress bar.

    Runs that share a surface are solved in succession, so that it is made only once. Raise
    SceneError for a surface that cannot be made or read.
    """
    reasons = _left_out(scenes)
    chosen = [k for k, reason in enumerate(reasons) if not reason]
    chosen.sort(key=lambda k: str(scene_surface.identity(scenes[k])))
    result = [Probe.without(reason) for reason in reasons]
    bar = progress.bar(POSITIONS * len(chosen), "solving positions")
    with bar, compiling.told(progress.compiling):
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
    solved: list[tuple[ContactState, Window, float]] = []
    failures: list[str] = []
    with suppress(ContactError):  # the same position fails again below
        _position(contact, 0, half_space)
    for place in places:
        try:
            solved.append(_position(contact, place, half_space))
        except ContactError as error:
            failures.append(str(error))
        tell(1)
    tell(POSITIONS - len(places))  # a track may have fewer steps than positions
    states = [state for state, _, _ in solved]
    windows = [(window.rows, window.columns) for _, window, _ in solved]
    return Probe(
        len(places),
        np.array([state.contact_area for state in states]),
        np.array([state.plastic_area for state in states]),
        np.array([state.max_pressure for state in states]),
        np.array(windows, np.int64).reshape(-1, 2),
        np.array([ms for _, _, ms in solved]),
        tuple(failures),
    )


def _position(
    contact: RollingContact, k: int, half_space: HalfSpace
) -> tuple[ContactState, Window, float]:
    """Solve position k from a cold start, and time the warm steps after it with their release.

    Return its state, the window of the last step in cells, and the median time of a step [ms].
    """
    states: list[ContactState] = []
    times: list[float] = []
    began = time.perf_counter()
    for state in march(contact, k, k + WARM_STEPS, half_space):
        if states:
            step_energy(states[-1], state, half_space)
        times.append(time.perf_counter() - began)
        states.append(state)
    window = states[-1].window.cells(contact.subcells)
    return states[0], window, 1e3 * float(np.median([b - a for a, b in pairwise(times)]))


def _left_out(scenes: Sequence[Scene]) -> list[str]:
    """Give the reason per run why its positions are not solved, empty where they are."""
    reasons: list[str] = []
    seconds, made = 0.0, set[object]()
    for scene in scenes:
        nodes = (scene.track.n_along + scene.track.turn_nodes) * scene.track.n_across
        nodes = 0 if isinstance(scene.surface, HeightFile) else nodes
        solving = POSITIONS * (COLD_STEPS + WARM_STEPS) * cost.step_ms(scene) * 1e-3
        reason = ""
        if nodes > MAX_NODES:
            reason = (
                f"making {rounded(nodes / 1e6, 3)} million nodes would take long, the limit is"
                f" {rounded(MAX_NODES / 1e6)} million"
            )
        elif solving > MAX_SECONDS:
            reason = f"it would take about {clock(solving)}, the limit is {clock(MAX_SECONDS)}"
        else:
            key = scene_surface.identity(scene)
            seconds += solving + cost.surface_seconds(scene)[0] * (key not in made)
            made.add(key)
        reasons.append(reason)
    if len(scenes) <= MAX_RUNS and seconds <= MAX_SECONDS:
        return reasons
    only, ends = f"first and last of {len(scenes)} runs only", (0, len(scenes) - 1)
    return [reason or ("" if k in ends else only) for k, reason in enumerate(reasons)]
