"""Motion of a ball beyond the solved track, over a force law that is continued at random.

Approach at the scene's load and logarithms of the slopes of the law are continued as rows along the
track, so slopes stay positive and the approach rises with the load at every place. The motion is
the same as on the solved track, taken in stretches that carry the state on.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from acoustics.arrays import Array
from acoustics.continued_rows import ContinuedRows
from rolling.dynamics import _motion_kernels, drop, of_scene
from rolling.dynamics._motion_kernels import LawTable, State
from rolling.dynamics.force_law import SOFTEST, ForceLaw, law_table, slope_weights
from rolling.dynamics.motion import DECAYS, MODAL_HZ, Stepping, at_rest, on_level
from rolling.scene.scene import Scene

STRETCH_STEPS = 2**17  # time steps at once: 5 MB
_GUARD = 24  # positions beyond a stretch, after which a spline has forgotten its end


class LongLaw:
    """Force law of a solved track, continued at random."""

    def __init__(self, law: ForceLaw, load_n: float, seed: int, turn_m: float | None) -> None:
        self._law, self._breaks = law, law.table.breaks
        self._weights = slope_weights(self._breaks, load_n ** (2 / 3))
        count, closed = len(law.position_m), law.period_m is not None
        values = law.table.values[:count]
        rows = np.log(values[:, 1:]).T
        spread = rows.std(axis=1)
        self._least, self._most = rows.min(axis=1) - spread, rows.max(axis=1) + spread
        approach = values[:, 0] + values[:, 1:] @ self._weights
        turn = None if turn_m is None else round(turn_m / law.spacing_m)
        self.rows = ContinuedRows(np.vstack((approach, rows)), closed, seed, turn)
        self.limited, self.continued = 0, 0  # positions

    def table(self, begin_m: float, end_m: float) -> LawTable:
        """Return the law between two positions [m], neither of them before the last ones."""
        start, spacing = float(self._law.position_m[0]), self._law.spacing_m
        first = max(math.floor((begin_m - start) / spacing) - _GUARD, 0)
        last = math.ceil((end_m - start) / spacing) + _GUARD + 1
        approach, slopes = np.split(self.rows.between(first, last), [1])
        slopes = np.exp(self._within_limits(slopes, first)).T
        lift_off = approach[0] - slopes @ self._weights
        values = np.ascontiguousarray(np.column_stack((lift_off, slopes)))
        return law_table(start + first * spacing, spacing, False, self._breaks, values)

    def _within_limits(self, slopes: Array, first: int) -> Array:
        """Limit the logarithms of continued slopes (m, n) to the solved range and a deviation."""
        known = max(self.rows.solved - first, 0)
        limited = np.clip(slopes, self._least[:, None], self._most[:, None])
        # The first slope has its lower limit from the second, as in a force law.
        limited[0] = np.maximum(limited[0], limited[1] + math.log(SOFTEST))
        limited[:, :known] = slopes[:, :known]
        self.limited += int(np.any(limited != slopes, axis=0).sum())
        self.continued += max(slopes.shape[1] - known, 0)
        return limited


class LongMotion:
    """Motion of the sphere of a scene at the scene's speed, first over the solved track.

    The counts belong to the steps taken so far.
    """

    def __init__(
        self, scene: Scene, law: ForceLaw, seconds: float, rate_hz: int, seed: int
    ) -> None:
        self._scene, self._solved_law = scene, law
        self._chain = of_scene.chain_over(scene, law)
        fastest = scene.motion.fastest(seconds)
        least = max(Stepping().per_period * self._chain.resonance_hz, fastest / law.spacing_m)
        if self._chain.modes is not None:
            least = max(least, MODAL_HZ)
        if scene.rolling.drop_mm is not None:
            least = max(least, 1 / drop.time_step_s(scene, law, self._chain, fastest))
        self.steps_per_sample = math.ceil(least / rate_hz)
        self.step = 1 / (rate_hz * self.steps_per_sample)
        self._bodies = self._chain.steps(self.step)
        self._steps = round(seconds * rate_hz) * self.steps_per_sample
        self.law = LongLaw(law, scene.load, seed, turn_m(scene))
        self.taken, self.apart, self.impacts, self.outside = 0, 0, 0, 0.0

    def forces(self) -> Iterator[Array]:
        """Yield the contact forces [N] of time steps, in stretches of whole samples."""
        count = max(STRETCH_STEPS // self.steps_per_sample, 1) * self.steps_per_sample
        state, flew = self._start(), False
        for first in range(0, self._steps, count):
            numbers = np.arange(first, min(first + count, self._steps), dtype=float)
            middles = np.asarray((numbers + 0.5) * self.step, dtype=float)
            places = np.asarray(self._scene.motion.distance(middles), dtype=float)
            places += self._solved_law.position_m[0]
            table = self.law.table(float(places[0]), float(places[-1]))
            state, force = self._advanced(state, places, table, self._points(middles))
            apart = force == 0
            self.impacts += int(np.sum(np.append(flew, apart[:-1]) & ~apart))
            self.taken, self.apart = self.taken + len(force), self.apart + int(apart.sum())
            self.outside += len(force) * self._solved_law.outside(force)
            flew = bool(apart[-1])
            yield force

    def _start(self) -> State:
        """Return the state at the start: at rest in the air, or run in over a closed track."""
        if self._scene.rolling.drop_mm is not None:
            start = drop.start(self._scene, self._solved_law, self._chain)
            points = self._points(np.zeros(1))
            return at_rest(self._bodies, points, *start[:2], -self._scene.load)
        law, motion = self._solved_law, self._scene.motion
        speed, begin = float(motion.speed(0.0)), float(law.position_m[0])
        steps = 0
        if law.period_m is not None and speed > 0:
            lasts = min(DECAYS * self._chain.decay_s, law.period_m / speed)
            steps = math.ceil(lasts / self.step)
        before = self.step * (np.arange(steps, 0, -1) - 0.5)
        places = np.asarray(begin - speed * before, dtype=float)
        first = float(places[0]) if steps else begin
        points = self._points(np.zeros(1))
        approach = float(law.approach(first, self._scene.load))
        state = at_rest(self._bodies, points, approach, 0.0, 0.0)
        return on_level(self._advanced(state, places, law.table, points)[0]) if steps else state

    def _points(self, times: Array) -> Array:
        """Return the contact points (n, 2) [m] on a plate at times [s], or the only one."""
        modes = self._chain.modes
        if modes is None or len(self._scene.plate.contact_ends_mm) == 1:
            return np.zeros((1, 2)) if modes is None else modes.point
        return of_scene.contact_points(self._scene, times)

    def _advanced(
        self, state: State, places: Array, table: LawTable, points: Array
    ) -> tuple[State, Array]:
        """Advance ball and plate by a step to each place [m]; return state and forces [N]."""
        record = np.empty((len(places), 4))
        end, _ = _motion_kernels.advance(
            state, self._scene.load, self._bodies, places, points, table, record
        )
        return State(*end), record[:, 0].copy()


def turn_m(scene: Scene) -> float | None:
    """Return the circumference [m] of a sphere with a surface, after which rows repeat."""
    return None if scene.sphere.surface is None else 2 * math.pi * scene.radius
