"""Static balance of the ring that moves: displacement, tilt, loads and angles of the balls.

The ring is pressed by the loads against balls whose contacts are Hertz springs in series, along
lines that are fixed or turn (`contact_lines`). It is rigid, or bends (`ring_bending`). The energy
of all contacts and of the bending is convex, so Newton's method finds the balance. Lifted balls,
clearance and tilts need no case of their own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import acos, ceil, cos, log, pi, tan

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.contact_lines import (
    RIGID,
    Angle,
    ContactLines,
    PressedLines,
    contact_lines,
    free_columns,
)
from rolling.bearing.geometry import BearingGeometry, Ring
from rolling.bearing.ring_bending import BendingMode

CAGE_PLACES = 8  # of the cage from one ball to the next, at which balances stand for all of them
_MAX_ITERATIONS = 60  # of Newton's method; 5 to 15 are usual
_WIDE = 0.1  # approach over the distance of the grooves' centres, under which Newton's method holds
_LIGHTER = 4.0  # ratio of loads on the way from a heavy to a light one
_TOLERANCE = 1e-11  # of the load, that may lack
_GRAINS = 8  # units in the last place of a displacement, to which forces are known
_SOFT = 1e-10  # of the stiffness along each displacement, where balls do not hold a direction
_OVERSHOOT = 0.5  # of the force along a step that may act against it at its end
_LEAST_SHARE = 1e-30  # of a step that is tried
_BEARING = 1e-6  # of the largest load of a ball, from which on another one bears load


@dataclass(frozen=True)
class StaticBalance:
    """Balance of the ring that moves under its loads.

    displacement_m : array (3,), m. x, y radial and z axial, of the ring.
    tilt : array (2,), rad. Turns of the ring about x and y; zeros where it is held.
    bending_m : array (2 k,), m. Cosine and sine part of each of k bending modes of the ring.
    ball_load_n : array (balls,), N.
    angles : array (balls,), rad. Contact angle of each ball.
    ways : array (balls, m). Derivatives of the approach by displacements, turns and bending of the
        ring, m = 5 + 2 k.
    moment_n_m : array (2,), N m. Moments about x and y with which the ring presses the balls.
    stiffness : array (m, m). Tangent stiffness of the balls against displacements, turns and
        bending [N/m, N, N m].
    """

    __repr__ = short_repr

    displacement_m: Array
    tilt: Array
    bending_m: Array
    ball_load_n: Array
    angles: Array
    ways: Array
    moment_n_m: Array
    stiffness: Array

    @property
    def lines(self) -> Array:
        """Directions in which displacements of the ring press the balls, (balls, 3)."""
        return self.ways[:, :3]

    @property
    def stiffness_n_m(self) -> Array:
        """Tangent stiffness [N/m] of a rigid ring that does not tilt, (3, 3)."""
        return self.stiffness[:3, :3]

    @property
    def displacements(self) -> Array:
        """Displacements, turns and bending of the ring together, (m,)."""
        return np.concatenate((self.displacement_m, self.tilt, self.bending_m))


def least_axial_load(geometry: BearingGeometry, radial_load_n: float) -> float:
    """Return the axial load [N] that must be exceeded so that a radial load has a balance.

    At a fixed contact angle the balls push the ring off along its axis. With a ball on either side
    of the load zone's middle, their loads balance both forces if F_a > F_r tan(alpha) / cos(pi/Z).
    """
    return radial_load_n * tan(geometry.contact_angle) / cos(pi / geometry.balls)


@dataclass(frozen=True, kw_only=True)
class LoadedRing:
    """Ring that moves, with its loads and what holds it.

    Attributes
    ----------
    axial_load_n, radial_load_n : float, N
        Loads on the ring, not negative, one of them positive.
    gap_m : float, m
        Gap of each ball along its contact line while the ring is centred: half of the radial
        clearance at contact angle 0, and zero where an axial load has closed it. A negative one
        presses the balls of a ring without load.
    moving : "outer" or "inner"
        Ring that moves.
    angle : "fixed" or "moving"
        Whether the loads turn the contact angles. All loads have a balance at moving ones.
    moments_n_m : pair of float, N m, optional
        Moments on the ring about x and y, under which it tilts at a moving angle. Default: it is
        held from tilting.
    bending : tuple of BendingMode
        Bending modes of the ring. Default: it is rigid.
    """

    axial_load_n: float
    radial_load_n: float
    gap_m: float = 0.0
    moving: Ring = "outer"
    angle: Angle = "fixed"
    moments_n_m: tuple[float, float] | None = None
    bending: tuple[BendingMode, ...] = ()

    @property
    def load(self) -> Array:
        """Load on the ring [N], (3,).

        The radial load presses it against the balls at angle 0, the middle of the load zone.
        """
        sign = 1.0 if self.moving == "inner" else -1.0
        return np.array([sign * self.radial_load_n, 0.0, self.axial_load_n])


FREE_TO_TILT = (0.0, 0.0)  # moments on a ring that tilts under none


def static_balance(
    geometry: BearingGeometry, ring: LoadedRing, cage_angle: float = 0.0
) -> StaticBalance:
    """Return the static balance of the ring that moves.

    Parameters
    ----------
    geometry : BearingGeometry
    ring : LoadedRing
    cage_angle : float, rad
        Angle of ball 0 from the middle of the load zone.

    Returns
    -------
    StaticBalance

    Raises
    ------
    ValueError
        If no load acts, a fixed contact angle does not let the axial load hold the ring on its
        balls, moments act at a fixed angle, or the balance is not found.
    """
    _refuse_loads(geometry, ring)
    if ring.moments_n_m is not None and ring.angle == "fixed":
        raise ValueError(
            "moments_n_m: allowed at a moving angle alone; at a fixed one a tilt presses the balls"
            " as a radial displacement does, and nothing tells them apart"
        )
    lines = contact_lines(
        geometry,
        geometry.ball_angles(cage_angle),
        gap_m=ring.gap_m,
        moving=ring.moving,
        angle=ring.angle,
        orders=tuple(mode.order for mode in ring.bending),
    )
    moments = np.array(ring.moments_n_m or ())
    bent = np.repeat([mode.stiffness_n_m for mode in ring.bending], 2)
    load = ring.load
    balls = _Balls(
        lines=lines,
        stiffness=geometry.series_stiffness,
        columns=tuple(free_columns(len(moments) > 0, len(ring.bending))),
        springs=np.concatenate((0 * load, bent, 0 * moments)),
    )
    whole = np.zeros(RIGID + len(bent))
    whole[list(balls.columns)] = _balanced(balls, np.concatenate((load, 0 * bent, moments)))
    pressed = lines.at(whole)
    forces = ball_loads(pressed.approach_m, geometry.series_stiffness)
    return StaticBalance(
        displacement_m=whole[:3],
        tilt=whole[3:RIGID],
        bending_m=whole[RIGID:],
        ball_load_n=forces,
        angles=pressed.angles,
        ways=pressed.lines,
        moment_n_m=forces @ pressed.lines[:, 3:RIGID],
        stiffness=tangent_stiffness(pressed, geometry.series_stiffness),
    )


def _refuse_loads(geometry: BearingGeometry, ring: LoadedRing) -> None:
    """Refuse loads that have no balance, by a ValueError."""
    axial_load_n = ring.axial_load_n
    radial_load_n = ring.radial_load_n
    if axial_load_n < 0 or radial_load_n < 0 or axial_load_n + radial_load_n <= 0:
        raise ValueError("loads of a bearing: allowed: not negative, and one of them positive")
    if ring.angle == "moving":
        return
    least = least_axial_load(geometry, radial_load_n)
    if geometry.contact_angle > 0 and axial_load_n <= least:
        raise ValueError(
            f"axial_load_n: got {axial_load_n:g}, allowed: more than {least:g} at the radial load"
            f" of {radial_load_n:g} N, or the ring is pushed off its balls"
        )
    if geometry.contact_angle <= 0 and axial_load_n > 0:
        raise ValueError(
            f"axial_load_n: got {axial_load_n:g}, allowed: 0 at a contact angle of 0, where no ball"
            " bears an axial load"
        )


def ball_loads(approach_m: Array, stiffness: float) -> Array:
    """Return the loads [N] of balls that are pressed by some approaches; free balls bear none."""
    return np.asarray(stiffness * np.maximum(approach_m, 0.0) ** 1.5)


def ball_stiffness(approach_m: Array, stiffness: float) -> Array:
    """Return the stiffness [N/m] of balls that are pressed by some approaches."""
    return 1.5 * stiffness * np.sqrt(np.maximum(approach_m, 0.0))


def tangent_stiffness(pressed: PressedLines, stiffness: float) -> Array:
    """Return the tangent stiffness of all balls, (m, m), for the m displacements of the ring."""
    along = ball_stiffness(pressed.approach_m, stiffness)
    across = ball_loads(pressed.approach_m, stiffness) * pressed.turning
    by_approach = (pressed.lines.T * along) @ pressed.lines
    return np.asarray(by_approach + (pressed.across.T * across) @ pressed.across)


def _balanced(balls: "_Balls", load: Array) -> Array:
    """Return the free displacements at which balls and bending bear a load.

    Raise ValueError if they are not found.
    """
    lines = balls.lines
    wanted = load / balls.units
    size = float(np.linalg.norm(wanted))
    start = (max(lines.gap_m, 0.0) + balls.approach_m(size)) * wanted / size
    place = balls.place_under(wanted, start)
    if place is None:
        # A light load leads along a bent and narrow valley of the energy, which a heavy one widens.
        reach = _WIDE / lines.curvature if lines.curvature > 0 else abs(lines.gap_m)
        heaviest = max(balls.stiffness * reach**1.5 / size, 1.0)
        times = ceil(log(heaviest, _LIGHTER)) + 1
        place = reach * wanted / size
        for heavier in np.geomspace(heaviest, 1.0, times):
            place = balls.place_under(heavier * wanted, place)
            if place is None:
                raise ValueError(
                    f"loads of a bearing: got {size:g} N, whose balance was not found; allowed:"
                    " loads that press the balls by more than the rounding of their places"
                )
    return np.asarray(place / balls.units)


@dataclass(frozen=True)
class _Balls:
    """Balls that a ring presses, and the search for the place at which they bear a load.

    A place counts turns of the ring as the way that they move its groove, so that all of its
    numbers are lengths and all of a load are forces.

    columns : tuple of int. Displacements that are free.
    springs : array (columns,), N/m. Stiffness of the ring itself against them.
    """

    lines: ContactLines
    stiffness: float
    columns: tuple[int, ...]
    springs: Array

    @cached_property
    def units(self) -> Array:
        """Lengths of a unit of each free displacement, (columns,)."""
        units = np.ones(RIGID + 2 * len(self.lines.orders))
        units[3:RIGID] = self.lines.tilt_radius_m
        return units[list(self.columns)]

    def approach_m(self, load_n: float) -> float:
        """Return the approach [m] of a ball under a load."""
        return float((load_n / self.stiffness) ** (2 / 3))

    def place_under(self, wanted: Array, start: Array) -> Array | None:
        """Return the place at which the balls bear a load, by Newton's method; None if not found.

        Forces are allowed to lack what rounding makes of them.
        """
        size = float(np.linalg.norm(wanted))
        typical = size / self.approach_m(size)
        place = start
        pressed, missing = self._at(place, wanted)
        for _ in range(_MAX_ITERATIONS):
            allowed = _TOLERANCE * size + self._rounding_n(pressed, place)
            if np.all(np.abs(missing) <= allowed):
                return place
            tangent = tangent_stiffness(pressed, self.stiffness) / self._unit_products
            tangent += np.diag(self.springs)
            step = _newton_step(tangent, missing, typical)
            # Along a step, the slope of a convex energy rises from below zero. At the end of the
            # share of it that is taken, the forces act little against it.
            first = float(missing @ step)
            share = 1.0
            pressed, missing = self._at(place + step, wanted)
            here = -float(missing @ step)
            while here > _OVERSHOOT * first and share > _LEAST_SHARE:
                share *= min(max(first / (first + here), 0.1), 0.5)
                pressed, missing = self._at(place + share * step, wanted)
                here = -float(missing @ step)
            place = place + share * step
        return None

    @cached_property
    def _unit_products(self) -> Array:
        """Products of the units, (columns, columns)."""
        return np.outer(self.units, self.units)

    def _at(self, place: Array, wanted: Array) -> tuple[PressedLines, Array]:
        """Return the lines at a place, and the forces [N] that balls lack there, (columns,)."""
        whole = np.zeros(RIGID + 2 * len(self.lines.orders))
        whole[list(self.columns)] = place / self.units
        pressed = self.lines.at(whole).of(list(self.columns))
        loads = ball_loads(pressed.approach_m, self.stiffness)
        missing = wanted - loads @ pressed.lines / self.units - self.springs * place
        return pressed, missing

    def _rounding_n(self, pressed: PressedLines, place: Array) -> Array:
        """Return the forces [N] by which rounding changes those of the balls, (columns,)."""
        eps = _GRAINS * float(np.finfo(float).eps)
        ways = np.abs(pressed.lines) / self.units
        grain = eps * (abs(self.lines.gap_m) + ways @ np.abs(place))
        loads = ball_loads(pressed.approach_m, self.stiffness)
        beside = ball_loads(pressed.approach_m + grain, self.stiffness)
        return np.asarray((beside - loads + eps * loads) @ ways)


def _newton_step(tangent: Array, missing: Array, typical: float) -> Array:
    """Return Newton's step, long in directions that no ball holds.

    Each displacement is counted by its own stiffness, because that along the axis may be smaller
    than that along the radius by many powers of ten.
    """
    own = np.diag(tangent)
    scale = 1 / np.sqrt(np.where(own > 0, own, typical))
    scaled = tangent * np.outer(scale, scale) + _SOFT * np.eye(len(missing))
    return np.asarray(scale * np.linalg.solve(scaled, scale * missing))


# ---- places of the cage


@lru_cache(maxsize=32)  # of bearings whose check, motion and numbers ask for the same balances
def balances_around(geometry: BearingGeometry, ring: LoadedRing) -> tuple[StaticBalance, ...]:
    """Return the balances at places of the cage from one ball to the next.

    The arrays are shared: they are not to be changed.
    """
    spacing = 2 * pi / (CAGE_PLACES * geometry.balls)
    return tuple(static_balance(geometry, ring, spacing * place) for place in range(CAGE_PLACES))


def rolling_angle(balances: Sequence[StaticBalance]) -> float:
    """Return the contact angle [rad] at which the balls roll, the mean over their loads.

    Its cosine is the mean, because speeds follow from it.
    """
    loads = np.concatenate([balance.ball_load_n for balance in balances])
    cosines = np.cos(np.concatenate([balance.angles for balance in balances]))
    return acos(min(float(loads @ cosines / loads.sum()), 1.0))


def angles_under_loads(geometry: BearingGeometry, ring: LoadedRing) -> tuple[float, float]:
    """Return the least and the largest contact angle [rad] of balls that bear load.

    They are those over the places of the cage, as loads turn them.
    """
    balances = balances_around(geometry, replace(ring, angle="moving"))
    angles: list[float] = []
    for balance in balances:
        loads = balance.ball_load_n
        angles += balance.angles[loads > _BEARING * loads.max()].tolist()
    return min(angles), max(angles)
