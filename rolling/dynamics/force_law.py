"""Contact force of place and approach, from marches of the track at several loads."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array, short_repr
from rolling.dynamics._motion_kernels import LawTable, evaluate, laws_at

# Loads of a law are added up to these multiples of the scene's. A force beyond them is
# extrapolated, and the share of time that it lasts is reported.
HIGHEST = 128.0
LOWEST = 1 / 32
MIN_SLOPE = 0.2  # minimum slope da/ds at a break over the mean slopes beside it
# Ratio in s, from the highest load on, within which the slope becomes that of a smooth contact. On
# rough glass (Ra 0.05 and 0.2 um) forces of 1,700 times the load, by laws up to 3 to 140 times it,
# were off by 1 to 5 %, and with the slope of the highest load by 4 to 130 %.
SMOOTH = 2.0
SOFTEST = 0.5  # minimum slope da/ds at lift-off over the slope at the lowest load: F stays convex


@dataclass(frozen=True)
class ForceLaw:
    """Contact force as a function of position and approach.

    At each position the approach is interpolated over s = F^(2/3), in which a Hertz contact is a
    straight line: by a quadratic spline through all loads, one quadratic for three loads. Where it
    would fall, the spline has twice as many pieces, whose slopes are limited. Above the highest
    load the approach goes on straight, as Hertz would; with a smooth slope, its own slope becomes
    that on the way to 2.8 times the load. Below the lowest it goes on as the
    quadratic, with its slope limited so that the force stays convex down to a finite lift-off.
    Along the track, lift-off and slopes are cubic splines, so the energy is smooth in both.
    """

    __repr__ = short_repr

    position_m: Array  # (n,) equally spaced, ascending
    load_n: Array  # (k,) positive, ascending, at least two
    approach_m: Array  # (k, n) rising with the load
    period_m: float | None = None  # n times the spacing; None: the track is open
    smooth_slope: float | None = None  # da/ds of a smooth contact [m/N^(2/3)]; None: unknown

    def __post_init__(self) -> None:
        if len(self.load_n) < 2 or np.any(np.diff(self.load_n, prepend=0.0) <= 0):
            raise ValueError("a force law needs two loads or more, positive and ascending")
        if len(self.position_m) < 4:
            raise ValueError("a force law needs four positions or more")
        if not np.all(np.diff(self.approach_m, axis=0) > 0):
            raise ValueError("the approach of a force law must rise with the load at each position")

    @property
    def spacing_m(self) -> float:
        """Distance of the positions [m]."""
        return float((self.position_m[-1] - self.position_m[0]) / (len(self.position_m) - 1))

    @cached_property
    def table(self) -> LawTable:
        """Numbers that the kernels read: lift-off and slopes at each position."""
        s = np.asarray(self.load_n, dtype=float) ** (2 / 3)
        breaks, values = _broken_line(s, np.asarray(self.approach_m, dtype=float))
        if self.smooth_slope is not None:  # at high loads a rough contact is a smooth one
            breaks = np.append(breaks, SMOOTH * breaks[-1])
            values = np.append(values, np.full((len(values), 1), self.smooth_slope), axis=1)
        closed = self.period_m is not None
        if closed:
            values = np.concatenate((values, values[:1]))
        return law_table(float(self.position_m[0]), self.spacing_m, closed, breaks, values)

    def force(self, position_m: ArrayLike, approach_m: ArrayLike) -> Array:
        """Return the contact force [N] at positions [m] and approaches [m], broadcast together."""
        return self._evaluated(position_m, approach_m)[..., 0]

    def stiffness(self, position_m: ArrayLike, approach_m: ArrayLike) -> Array:
        """Return the contact stiffness dF/dd [N/m], zero where the surfaces are apart."""
        return self._evaluated(position_m, approach_m)[..., 1]

    def approach(self, position_m: ArrayLike, load_n: float) -> Array:
        """Return the approach [m] under a constant load [N] >= 0 at positions [m]."""
        x = np.asarray(position_m, dtype=float)
        laws = np.empty((x.size, self.table.values.shape[1]))
        laws_at(x.ravel(), self.table, laws)
        weights = slope_weights(self.table.breaks, float(load_n) ** (2 / 3))
        return np.asarray(laws[:, 0] + laws[:, 1:] @ weights).reshape(x.shape)

    def outside(self, force_n: ArrayLike) -> float:
        """Return the share of forces that lie outside the marched loads; a flight is known."""
        force = np.asarray(force_n, dtype=float)
        low = (force > 0) & (force < self.load_n[0])
        return float(np.mean(low | (force > self.load_n[-1])))

    def _evaluated(self, position_m: ArrayLike, approach_m: ArrayLike) -> Array:
        """Return force and stiffness as a last axis."""
        x, d = np.broadcast_arrays(np.asarray(position_m, float), np.asarray(approach_m, float))
        values = np.empty((x.size, 2))
        evaluate(x.ravel(), d.ravel(), self.table, values)
        return values.reshape((*x.shape, 2))


def law_table(start: float, spacing: float, closed: bool, breaks: Array, values: Array) -> LawTable:
    """Return the numbers of the kernels from lift-off and slopes at the breaks, (n, 1 + m)."""
    from scipy.interpolate import CubicSpline  # slow to import, for motions only

    knots = start + spacing * np.arange(len(values))
    spline = CubicSpline(knots, values, bc_type="periodic" if closed else "not-a-knot")
    slopes = np.ascontiguousarray(spline(knots, 1))
    steepest = 3 / spacing * values[:, 1:]  # up to which a cubic between positions is positive
    slopes[:, 1:] = np.clip(slopes[:, 1:], -steepest, steepest)
    return LawTable(
        start=start,
        spacing=spacing,
        closed=closed,
        breaks=breaks,
        edges=np.sqrt(breaks),
        values=values,
        slopes=slopes,
    )


def _broken_line(s: Array, approach: Array) -> tuple[Array, Array]:
    """Return the breaks (m,) in s, and lift-off and slopes (n, 1 + m) of the quadratic spline.

    Its inner breaks lie halfway between inner loads, so there are as many conditions as unknowns.
    """
    breaks = np.concatenate(([0.0], s[:1], (s[1:-2] + s[2:-1]) / 2, s[-1:]))
    means = np.diff(approach, axis=0) / np.diff(s)[:, None]
    if s.size == 2:
        inner = np.stack([means[0], means[0]])
    else:
        weights = np.array([slope_weights(breaks, end) for end in s])
        inner = np.linalg.solve((weights[1:] - weights[0])[:, 1:], approach[1:] - approach[0])
    if np.any(inner < MIN_SLOPE * means.min(axis=0)):
        breaks = np.sort(np.concatenate(([0.0], s, (s[:-1] + s[1:]) / 2)))
        inner = _limited_slopes(s, means)
    bend = (inner[1] - inner[0]) / (breaks[2] - breaks[1])
    first = np.maximum(inner[0] - bend * s[0], SOFTEST * inner[0])
    lift_off = approach[0] - s[0] * (first + inner[0]) / 2
    return breaks, np.ascontiguousarray(np.concatenate((lift_off[None], first[None], inner)).T)


def _limited_slopes(s: Array, means: Array) -> Array:
    """Return positive slopes at the loads and halfway between, from the mean slopes between loads.

    A slope at a load is that of a parabola, limited to 1.5 times either mean slope beside it. The
    slope halfway then follows from the mean slope, and is half of it at least.
    """
    lengths = np.diff(s)[:, None]
    joined = means[:-1] * lengths[1:] + means[1:] * lengths[:-1]
    inner = joined / (lengths[1:] + lengths[:-1])
    inner = np.minimum(inner, 1.5 * np.minimum(means[:-1], means[1:]))
    if len(inner):
        first = _end_slope(means[:1], inner[:1])
        last = _end_slope(means[-1:], inner[-1:])
    else:  # of two loads
        first = _end_slope(means[:1], means)
        last = _end_slope(means[-1:], means)
    at_loads = np.concatenate((first, inner, last))
    slopes = np.empty((2 * len(s) - 1, means.shape[1]))
    slopes[::2] = at_loads
    slopes[1::2] = 2 * means - (at_loads[:-1] + at_loads[1:]) / 2
    return slopes


def _end_slope(mean: Array, beside: Array) -> Array:
    """Return the slope at the first or last load from the mean slope and the slope beside it."""
    return np.clip(2 * mean - beside, 0.5 * mean, 1.5 * mean)


def slope_weights(breaks: Array, end: float) -> Array:
    """Return the weights of the slopes at the breaks in their integral from 0 to `end`."""
    lengths = np.diff(breaks)
    t = np.clip(end - breaks[:-1], 0.0, lengths)
    rising = t**2 / (2 * lengths)
    weights = np.zeros(breaks.size)
    weights[:-1] += t - rising
    weights[1:] += rising
    weights[-1] += max(end - breaks[-1], 0.0)
    return weights
