"""A few solved positions of a scene: contact areas, pressure and time of a step.

The closed forms of a smooth sphere cannot tell whether asperities yield. Eight cold starts along
the track can, for less than a hundredth of the cost of a run.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.check import cost, error_cost
from rolling.check.finding import Finding, clock, on_cores, si
from rolling.contact import compiling
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.of_scene import rolling_contact
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import half_space_of
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface import scene_surface
from rolling.terminal import progress

POSITIONS = 8
WARM_STEPS = 3  # after each cold start, for the time of a step
COLD_STEPS = 1 + error_cost.START_STEPS  # cost of a cold position in steps
MAX_NODES = 10_000_000  # maximum for a generated surface, which takes about 4 s and 400 MB
MAX_SECONDS = 60.0  # expected time of the solved positions, of one run and of all runs of a sweep
# If a sweep has more runs, or slow runs, only its first and last runs are solved.
MAX_RUNS = 12
NODE_SECONDS = 4e-7  # per node of a generated surface


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
    """

    tried: int
    contact_area: Array
    plastic_area: Array
    max_pressure: Array
    window: NDArray[np.int64]
    step_ms: Array
    failures: tuple[str, ...] = ()
    left_out: str = ""

    @classmethod
    def without(cls, reason: str) -> Probe:
        """Make a probe without positions, for a reason."""
        nothing = np.empty(0)
        return cls(0, nothing, nothing, nothing, np.empty((0, 2), np.int64), nothing, (), reason)

    def findings(self, scene: Scene) -> list[Finding]:
        """State the numbers of the solved positions.

        They replace the numbers of closed forms and cost model.
        """
        count = len(self.contact_area)
        if self.left_out:
            return [Finding("positions", "positions solved", f"none: {self.left_out}")]
        failed = None
        if self.failures:
            failed = (
                f"{len(self.failures)} of {self.tried} positions fail, and so will the run:"
                f" {self.failures[0]}"
            )
        result = [Finding("positions", "positions solved", f"{count} of {self.tried}", failed)]
        if not count:
            return result
        step_ms = float(self.step_ms.mean())
        seconds = scene.track.solved_steps * step_ms * 1e-3 / cost.cores()
        return [
            *result,
            Finding("window", "window", self._window),
            Finding(
                "step_time",
                "time of a step",
                _ranged(self.step_ms, lambda ms: f"{ms:.2g} ms") + " on 1 core",
            ),
            Finding(
                "expected_time",
                "expected time",
                f"about {clock(seconds)} on {on_cores()}",
                seconds=seconds,
            ),
            Finding("contact_area", "contact area", _ranged(self.contact_area, _area)),
            *self._yielding(scene),
            Finding("max_pressure", "maximum pressure", _ranged(self.max_pressure, _pressure)),
        ]

    @property
    def _window(self) -> str:
        mean, least, most = (
            "{} x {}".format(*nodes)
            for nodes in (
                np.rint(self.window.mean(axis=0)).astype(int),
                self.window.min(axis=0),
                self.window.max(axis=0),
            )
        )
        return f"{mean} nodes" + (f" ({least} to {most})" if least != most else "")

    def _yielding(self, scene: Scene) -> list[Finding]:
        if not math.isfinite(scene.hardness):
            return []
        hardness = si(scene.hardness, "Pa")
        share = self.plastic_area / self.contact_area
        whole = self.plastic_area.sum() / self.contact_area.sum()
        range_ = f"{100 * share.min():.2g} to {100 * share.max():.2g} %"
        says = (
            f"yields on {100 * whole:.2g} % of the contact ({range_})"
            if whole
            else "stays elastic where solved"
        )
        return [
            Finding("hardness", "hardness", f"{hardness}, {says}"),
            Finding("plastic_area", "plastic area", _ranged(self.plastic_area, _area)),
        ]


def probes(scenes: Sequence[Scene]) -> list[Probe]:
    """Solve positions of the runs of a sweep, for a minute at most.

    A progress bar is shown on stderr.

    Runs that share a surface are solved in succession, so that it is made only once.

    Raises
    ------
    SceneError
        A surface cannot be made or read.
    """
    reasons = _left_out(scenes)
    chosen = [k for k, reason in enumerate(reasons) if not reason]
    chosen.sort(key=lambda k: str(scene_surface.identity(scenes[k])))
    result = [Probe.without(reason) for reason in reasons]
    bar = progress.bar(POSITIONS * len(chosen), "solving positions", delay=1, leave=False)
    with bar, compiling.told(progress.compiling):
        for k in chosen:
            result[k] = probe(rolling_contact(scenes[k]), scenes[k].track.solved_steps, bar.update)
    return result


def probe(
    contact: RollingContact, steps: int, tell: Callable[[int], object] = lambda count: None
) -> Probe:
    """Solve positions evenly along a track, each from a cold start, and time warm steps.

    The first position is solved once in advance, so that the times exclude compilation. The cold
    start at each position prepares the transforms of its window.

    Parameters
    ----------
    steps : int
        Number of steps of the track.
    tell : callable
        Function that is called with 1 after each of POSITIONS positions.
    """
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    places = np.arange(POSITIONS) * steps // POSITIONS
    solved: dict[int, tuple[ContactState, Window, float]] = {}
    failures: dict[int, str] = {}
    with suppress(ContactError):  # the same position fails again below
        _position(contact, 0, half_space)
    for k in places.tolist():
        try:
            if k not in solved:  # a track may have fewer steps than positions
                solved[k] = _position(contact, k, half_space)
                progress.detail(_position_text(*solved[k]))
        except ContactError as error:
            failures[k] = str(error)
        tell(1)
    states = [state for state, _, _ in solved.values()]
    return Probe(
        len(set(places.tolist())),
        np.array([state.contact_area for state in states]),
        np.array([state.plastic_area for state in states]),
        np.array([state.max_pressure for state in states]),
        np.array(
            [(window.rows, window.columns) for _, window, _ in solved.values()], np.int64
        ).reshape(-1, 2),
        np.array([ms for _, _, ms in solved.values()]),
        tuple(failures.values()),
    )


def _position_text(state: ContactState, window: Window, ms: float) -> str:
    """Write window, iterations and time of a solved position."""
    size = f"window {window.rows} x {window.columns} nodes"
    return f"position {state.position}: {size}, {state.iterations} iterations, {ms:.2f} ms a step"


def _position(
    contact: RollingContact, k: int, half_space: HalfSpace
) -> tuple[ContactState, Window, float]:
    """Solve position k from a cold start, then time the warm steps after it.

    The window of a warm step counts cells. The time [ms] is the median over the warm steps with
    their release.
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
    seconds: list[float] = []
    seen = set()
    for scene in scenes:
        nodes = (
            0
            if isinstance(scene.surface, HeightFile)
            else scene.track.n_along * scene.track.n_across
        )
        key = scene_surface.identity(scene)
        solving = (
            POSITIONS
            * (COLD_STEPS + WARM_STEPS)
            * cost.expected_seconds(scene)
            / scene.track.solved_steps
        )
        reason = ""
        if nodes > MAX_NODES:
            reason = f"making {nodes:.3g} nodes would take long, the limit is {MAX_NODES:.3g}"
        elif solving > MAX_SECONDS:
            reason = f"it would take about {clock(solving)}, the limit is {clock(MAX_SECONDS)}"
        else:
            seconds.append(solving + (nodes * NODE_SECONDS if key not in seen else 0.0))
            seen.add(key)
        reasons.append(reason)
    if len(scenes) <= MAX_RUNS and sum(seconds) <= MAX_SECONDS:
        return reasons
    only = f"first and last of {len(scenes)} runs only"
    return [
        reason or ("" if k in (0, len(scenes) - 1) else only) for k, reason in enumerate(reasons)
    ]


def _ranged(values: Array, text: Callable[[float], str]) -> str:
    """Write mean and range: 2.1 ms (1.9 to 2.3 ms)."""
    least, most = text(float(values.min())), text(float(values.max()))
    return text(float(values.mean())) + (f" ({least} to {most})" if least != most else "")


def _area(value: float) -> str:
    return f"{float(f'{value * 1e12:.3g}'):.15g} um2"


def _pressure(value: float) -> str:
    return si(value, "Pa")
