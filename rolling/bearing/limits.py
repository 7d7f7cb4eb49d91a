"""Time steps of the motion of a ring, their cost, and what they cannot follow."""

from collections.abc import Iterator, Sequence
from math import pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from acoustics.numbers import rounded
from rolling.bearing.linear_ring import LinearRing, linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.static_load import StaticBalance

PER_PERIOD = 40  # minimum number of steps in a period of the fastest resonance of a rigid ring
# Minimum number of steps in a period of the fastest bending mode, which lies above the bands of a
# usual bearing. They raise its frequency by 0.7 %.
_PER_BENDING_PERIOD = 15
TRACK_HZ = 384e3  # rate of steps up to which they follow a track from point to point
FASTEST_HZ = 1.25e6  # resonance that can be moved, with 50 million steps a second
DECAYS = 7  # decay times of the slowest resonance in the run-in, during which the tracks grow
SHORTEST_RUN_IN_S = 0.02
LONGEST_RUN_IN_S = 2.0
# Processor time for a step of a ball, with the decimation: 0.3 to 0.7 us were measured for 3 to 30
# balls, with and without mass.
_SECONDS_PER_BALL = 0.4e-6
_BESIDE = 1.001  # a limit that is told keeps this distance, so that it is allowed when rounded


class BrokenLimit(NamedTuple):
    """Value with which a ring cannot be moved: its key in a scene, and what is allowed."""

    key: str
    text: str


def ring_hz(bearing: BearingModel, balances: Sequence[StaticBalance]) -> float:
    """Return the highest resonance [Hz] of the ring in some balances."""
    return sqrt(_stiffest(balances) / bearing.ring_mass_kg) / (2 * pi)


def bounce_hz(bearing: BearingModel, balances: Sequence[StaticBalance]) -> float:
    """Return the highest frequency [Hz] at which a ball with mass bounces between its raceways."""
    load = max(float(state.ball_load_n.max()) for state in balances) + bearing.centrifugal_n
    stiffness = 0.0
    for contact in (bearing.geometry.inner, bearing.geometry.outer):
        stiffness += 1.5 * contact.stiffness_n_m15 ** (2 / 3) * load ** (1 / 3)
    return sqrt(stiffness / bearing.ball_mass_kg) / (2 * pi)


def steps_hz(
    bearing: BearingModel,
    balances: Sequence[StaticBalance],
    points_hz: float = TRACK_HZ,
    per_period: int = PER_PERIOD,
) -> float:
    """Return the rate of steps [Hz] for resonances, and for tracks with so many points a second."""
    fastest = ring_hz(bearing, balances)
    if bearing.ball_inertia:
        fastest = max(fastest, bounce_hz(bearing, balances))
    resonances = max(per_period * fastest, _PER_BENDING_PERIOD * _bending_hz(bearing, balances))
    return max(resonances, min(points_hz, TRACK_HZ))


def _bending_hz(bearing: BearingModel, balances: Sequence[StaticBalance]) -> float:
    """Return the highest resonance [Hz] of a ring that bends, on its balls; 0 for a rigid one."""
    if not bearing.bending:
        return 0.0
    scale = 1 / np.sqrt(bearing.masses)
    springs = np.diag(bearing.springs)
    columns = np.ix_(bearing.columns, bearing.columns)
    squares = [
        np.linalg.norm(np.outer(scale, scale) * (state.stiffness[columns] + springs), 2)
        for state in balances
    ]
    return sqrt(float(max(squares))) / (2 * pi)


def run_in_s(ring: LinearRing) -> float:
    """Return the time [s] in which tracks grow and the slowest resonance of a ring decays."""
    decayed = DECAYS * ring.slowest_decay_s
    return min(max(decayed, SHORTEST_RUN_IN_S), LONGEST_RUN_IN_S)


def motion_seconds(bearing: BearingModel, duration_s: float) -> float:
    """Estimate the processor time [s] of a motion."""
    steps = steps_hz(bearing, bearing.balances()) * (duration_s + run_in_s(linear_ring(bearing)))
    return _SECONDS_PER_BALL * bearing.geometry.balls * steps


def broken_limits(bearing: BearingModel) -> Iterator[BrokenLimit]:
    """Yield the values of a bearing with which its ring cannot be moved.

    The loads must have a balance.
    """
    balances = bearing.balances()
    least = _stiffest(balances) / (2 * pi * FASTEST_HZ) ** 2
    if bearing.ring_mass_kg < least:
        yield BrokenLimit(
            key="ring_mass_kg",
            text=f"got {bearing.ring_mass_kg:g}, allowed: at least {_BESIDE * least:.4g}, because a"
            f" lighter ring would have a resonance above {1e-6 * FASTEST_HZ:g} MHz on these balls",
        )
    if not bearing.ball_inertia:
        return
    bounce = bounce_hz(bearing, balances)
    if bounce > FASTEST_HZ:
        yield BrokenLimit(
            key="ball_inertia",
            text=f"got true, allowed: false, because these balls bounce at {1e-6 * bounce:.3g} MHz,"
            f" and motions up to {1e-6 * FASTEST_HZ:g} MHz can be followed",
        )
    pushed = bearing.geometry.balls * bearing.centrifugal_n * sin(bearing.geometry.contact_angle)
    if bearing.kinematics.moving == "outer" and pushed > 0 and pushed >= bearing.axial_load_n:
        rpm = 60 * bearing.kinematics.turning_hz
        slower = rounded(rpm * sqrt(bearing.axial_load_n / pushed) / _BESIDE, 4)
        heavier = rounded(_BESIDE * pushed, 4)
        yield BrokenLimit(
            key="speed_rpm",
            text=f"got {rpm:g}, allowed with ball_inertia: below {slower}, or an axial_load_n above"
            f" {heavier}: the centrifugal force of the balls would push the outer ring off them,"
            " because both contacts of a ball have one angle",
        )


def _stiffest(balances: Sequence[StaticBalance]) -> float:
    """Return the highest stiffness [N/m] of the ring in any direction."""
    return max(float(np.linalg.norm(state.stiffness_n_m, 2)) for state in balances)
