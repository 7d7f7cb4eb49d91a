"""Motion of a ball beyond the solved track, over a force law that is continued at random.

The long record continues track and force law as random noise with the spectra of the solved part.
Continued are the approach at the scene's load and the logarithms of the law's slopes, so that
slopes stay positive and the approach rises with the load at every place. The waves around a ball
are not random: they are taken off before and added again, turn after turn. The motion is computed
as on the solved track, in stretches that carry the state on.
"""

import math
from collections.abc import Iterator

import numpy as np

from acoustics.arrays import Array
from acoustics.continued_rows import ContinuedRows
from rolling.contact.track import Motion
from rolling.dynamics import drop
from rolling.dynamics._motion_kernels import LawTable, State
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.ball_turn import BallTurn
from rolling.dynamics.force_law import SOFTEST, ForceLaw, law_table, slope_weights
from rolling.dynamics.motion import DECAYS, advance, at_rest, longest_step_s, run_in
from rolling.dynamics.motion_of_ball import contact_path

STRETCH_STEPS = 2**17  # time steps at once: 5 MB
_GUARD = 24  # positions beyond a stretch, after which a spline has forgotten its end


class LongLaw:
    """Force law of a solved track, continued at random."""

    def __init__(self, law: ForceLaw, load_n: float, seed: int, turn: BallTurn | None) -> None:
        self._law = law
        self._turn = turn
        self._breaks = law.table.breaks
        self._weights = slope_weights(self._breaks, load_n ** (2 / 3))
        count = len(law.position_m)
        closed = law.period_m is not None
        values = law.table.values[:count]
        rows = np.log(values[:, 1:]).T
        spread = rows.std(axis=1)
        self._least = rows.min(axis=1) - spread
        self._most = rows.max(axis=1) + spread
        approach = values[:, 0] + values[:, 1:] @ self._weights
        approach -= self._form(0, count)
        positions = None if turn is None else round(turn.length_m / law.spacing_m)
        self.rows = ContinuedRows(np.vstack((approach, rows)), closed, seed, positions)
        self.limited = 0  # continued positions at which a slope had to be limited
        self.continued = 0  # positions beyond the solved track

    def table(self, begin_m: float, end_m: float) -> LawTable:
        """Return the law between two positions [m], neither of them before the last ones."""
        start = float(self._law.position_m[0])
        spacing = self._law.spacing_m
        first = max(math.floor((begin_m - start) / spacing) - _GUARD, 0)
        last = math.ceil((end_m - start) / spacing) + _GUARD + 1
        approach, slopes = np.split(self.rows.between(first, last), [1])
        slopes = np.exp(self._within_limits(slopes, first)).T
        lift_off = approach[0] + self._form(first, last) - slopes @ self._weights
        values = np.ascontiguousarray(np.column_stack((lift_off, slopes)))
        return law_table(start + first * spacing, spacing, False, self._breaks, values)

    def _form(self, first: int, last: int) -> Array:
        """Return the approach [m] that the waves around the ball add at positions."""
        if self._turn is None:
            return np.zeros(last - first)
        return self._turn.form_at(self._law.spacing_m * np.arange(first, last, dtype=np.float64))

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
    """Motion of a ball, first over the solved track.

    The counts belong to the steps taken so far.
    """

    def __init__(
        self,
        bodies: BallOnPlate,
        motion: Motion,
        law: ForceLaw,
        seconds: float,
        rate: int,
        seed: int,
        turn: BallTurn | None = None,
    ) -> None:
        """Prepare a motion of some seconds, in whole steps of samples of a rate [Hz].

        `turn` is that of a ball with a surface, after which rows repeat.
        """
        self._ball = bodies
        self._motion = motion
        self._solved_law = law
        self._chain = bodies.chain_over(law)
        fastest = motion.fastest(seconds)
        longest = longest_step_s(law, self._chain, fastest)
        if bodies.falls:
            longest = drop.time_step_s(bodies, law, self._chain, fastest)
        self.steps_per_sample = math.ceil(1 / (longest * rate))
        self.step = 1 / (rate * self.steps_per_sample)
        self._bodies = self._chain.steps(self.step)
        self._path = contact_path(bodies.plate, motion)
        self._steps = round(seconds * rate) * self.steps_per_sample
        self.law = LongLaw(law, bodies.load_n, seed, turn)
        self.taken = 0
        self.free_steps = 0
        self.impacts = 0
        self.outside = 0.0

    def forces(self) -> Iterator[Array]:
        """Yield the contact forces [N] of time steps, in stretches of whole samples."""
        count = max(STRETCH_STEPS // self.steps_per_sample, 1) * self.steps_per_sample
        state = self._start()
        flew = False
        for first in range(0, self._steps, count):
            numbers = np.arange(first, min(first + count, self._steps), dtype=float)
            middles = np.asarray((numbers + 0.5) * self.step, dtype=float)
            places = np.asarray(self._motion.distance(middles), dtype=float)
            places += self._solved_law.position_m[0]
            table = self.law.table(float(places[0]), float(places[-1]))
            points = self._points(middles)
            load = self._ball.load_n
            steps = advance(table, self._bodies, load, state, places, points)
            state = steps.end
            force = steps.record[:, 0]
            is_free = force == 0
            self.impacts += int(np.sum(np.append(flew, is_free[:-1]) & ~is_free))
            self.taken += len(force)
            self.free_steps += int(is_free.sum())
            self.outside += len(force) * self._solved_law.outside(force)
            flew = bool(is_free[-1])
            yield force

    def _start(self) -> State:
        """Return the state at the start: at rest in the air, or run in over a closed track."""
        law = self._solved_law
        load = self._ball.load_n
        points = self._points(np.zeros(1))
        if self._ball.falls:
            approach, velocity = drop.start(self._ball, law, self._chain)
            return at_rest(self._bodies, points, approach, velocity, -load)
        speed = float(self._motion.speed(0.0))
        begin = float(law.position_m[0])
        if law.period_m is None or speed <= 0:
            return at_rest(self._bodies, points, float(law.approach(begin, load)), 0.0, 0.0)
        steps = math.ceil(min(DECAYS * self._chain.decay_s, law.period_m / speed) / self.step)
        before = self.step * (np.arange(steps, 0, -1) - 0.5)
        return run_in(law, self._bodies, load, np.asarray(begin - speed * before), points)

    def _points(self, times: Array) -> Array:
        """Return the contact points (n, 2) [m] on a plate at times [s], or the only one."""
        if self._path is None:
            return self._chain.point
        return self._path(times)
