"""Motion of a ball along its track over a force law, rolling or after a fall."""

from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from rolling.contact.track import Motion, Travel
from rolling.dynamics import drop
from rolling.dynamics.ball_on_plate import BallOnPlate, PlateBody
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Path, Stepping, TabulatedTravel, move

_MAX_TIMES = 1_000_000  # maximum number of times that describe a changing speed


def contact_path(plate: PlateBody, motion: Motion) -> Path | None:
    """Return the function of time [s] that gives the contact points, None for a single point."""
    if not plate.has_path:
        return None

    def points_at(time_s: Array) -> Array:
        """Return the contact points (n, 2) [m] at times [s]."""
        return plate.contact_points(motion.distance(time_s))

    return points_at


def motion_of_ball(
    bodies: BallOnPlate, travel: Travel, law: ForceLaw, time_step_s: float | None = None
) -> BodyMotion:
    """Move a ball over a force law for the duration of its travel; default: steps of `move`."""
    return _motion_of_chain(bodies, bodies.chain_over(law), travel, law, time_step_s)


def motion_on_rigid_plate(bodies: BallOnPlate, travel: Travel, law: ForceLaw) -> BodyMotion:
    """Move a ball over a force law on a plate that does not give way.

    Only a loss factor of the contact damps it then.
    """
    rigid = replace(bodies.chain_over(law), mobility_s_kg=0.0, modes=None)
    return _motion_of_chain(bodies, rigid, travel, law)


def _motion_of_chain(
    bodies: BallOnPlate,
    linear: Chain,
    travel: Travel,
    law: ForceLaw,
    time_step_s: float | None = None,
) -> BodyMotion:
    """Move a chain over a force law for the duration of its travel."""
    duration = travel.duration_s
    fastest = travel.fastest_m_s
    speed: float | TabulatedTravel = fastest
    if not travel.is_constant:
        track = travel.track
        times = np.linspace(0.0, duration, min(4 * track.steps, _MAX_TIMES) + 1)
        places = np.minimum(travel.motion.distance(times), track.distance)
        speed = TabulatedTravel(times, np.asarray(places, dtype=float))
    stepping = Stepping(time_step_s=time_step_s)
    if bodies.falls:
        step = time_step_s or drop.time_step_s(bodies, law, linear, fastest)
        stepping = Stepping(time_step_s=step, start=drop.start(bodies, law, linear))
    path = contact_path(bodies.plate, travel.motion) if linear.modes is not None else None
    return move(law, linear, bodies.load_n, speed, duration, stepping, path)
