"""Callers of the room of sound that still hand a scene to dynamics."""

from acoustics.arrays import Array
from acoustics.radiation import Ball, HalfSpaceBody, ThinPlate
from acoustics.rectangular_plate import RectangularPlate
from rolling.ball.bodies_of_scene import bodies_of, plate_of
from rolling.dynamics import motion_of_ball
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Path
from rolling.scene.scene import Scene


def plate(scene: Scene) -> ThinPlate | None:
    """Return the plate that bends, or None for a half-space."""
    return plate_of(scene.plate).bending


def ground(scene: Scene) -> ThinPlate | HalfSpaceBody:
    """Return the plate that bends, or the half-space where the scene gives no thickness."""
    return plate_of(scene.plate).ground


def ball(scene: Scene) -> Ball:
    """Return the sphere as a source of sound."""
    return bodies_of(scene).ball


def rectangular_plate(scene: Scene) -> RectangularPlate | None:
    """Return the plate with edges, or None for a plate without edges."""
    return plate_of(scene.plate).with_edges


def contact_path(scene: Scene) -> Path | None:
    """Return the function of time [s] that gives the contact points, None for a single point."""
    return motion_of_ball.contact_path(plate_of(scene.plate), scene.motion)


def points_on_path(scene: Scene, count: int) -> Array:
    """Return points (count, 2) [m] at equal distances on the contact path, or the only point."""
    return plate_of(scene.plate).points_between_ends(count)


def chain(scene: Scene, stiffness_n_m: float) -> Chain:
    """Return sphere, contact and plate for small fluctuations, at a contact stiffness."""
    return bodies_of(scene).chain(stiffness_n_m)


def smooth_chain(scene: Scene) -> Chain:
    """Return sphere, contact and plate with the stiffness of a smooth contact."""
    return bodies_of(scene).smooth_chain


def smooth_stiffness(scene: Scene) -> float:
    """Return the stiffness [N/m] of the smooth elastic contact."""
    return bodies_of(scene).contact.stiffness_n_m


def chain_over(scene: Scene, law: ForceLaw) -> Chain:
    """Return sphere, contact and plate with the mean stiffness of a force law."""
    return bodies_of(scene).chain_over(law)


def motion(scene: Scene, law: ForceLaw, time_step_s: float | None = None) -> BodyMotion:
    """Move the sphere of a scene over a force law for its duration; default: steps of `move`."""
    return motion_of_ball.motion_of_ball(bodies_of(scene), scene.travel, law, time_step_s)


def motion_on_rigid_plate(scene: Scene, law: ForceLaw) -> BodyMotion:
    """Move the sphere of a scene over a force law on a plate that does not give way."""
    return motion_of_ball.motion_on_rigid_plate(bodies_of(scene), scene.travel, law)
