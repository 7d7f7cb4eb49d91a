"""Sphere and plate of a scene as vibrating bodies, and their motion over a force law."""

import math
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from acoustics.arrays import Array
from acoustics.plate_modes import SIMPLE
from acoustics.radiation import Ball, HalfSpaceBody, ThinPlate
from acoustics.rectangular_plate import RectangularPlate
from acoustics.ritz_plate import RitzPlate
from rolling.contact import closed_forms
from rolling.dynamics import drop
from rolling.dynamics.bodies import (
    FALLING_TAIL,
    ROLLING_TAIL,
    Chain,
    Modes,
    contact_stiffness,
    half_space_mobility,
    modes_of,
)
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Path, Stepping, Travel, move
from rolling.dynamics.smooth_contact import equivalent_radius
from rolling.scene.scene import Scene
from rolling.scene.sections import Plate

MIN_THICKNESSES = 6.0  # in a bending wave; shorter waves are beyond thin-plate theory
BENT = 0.1  # deflection over thickness up to which thin-plate theory holds
NEAR_SPEEDS = 0.03  # relative change of the speed over which the levels of a looped record spread
_STATIONS = 17  # points of a path over which the linear chain takes the mean
_MAX_TIMES = 1_000_000  # maximum number of times that describe a changing speed


def plate(scene: Scene) -> ThinPlate | None:
    """Return the plate that bends, or None for a half-space."""
    return thin_plate(scene.plate)


def thin_plate(properties: Plate) -> ThinPlate | None:
    """Return the plate of a section that bends, or None for a half-space."""
    thickness = 1e-3 * (properties.thickness_mm or 0.0)
    if not thickness or properties.density_kg_m3 is None:
        return None
    young = properties.youngs_modulus_gpa * 1e9
    stiffness = young * thickness**3 / (12 * (1 - properties.poissons_ratio**2))
    return ThinPlate(
        mass_per_area_kg_m2=properties.density_kg_m3 * thickness,
        bending_stiffness_n_m=stiffness,
        loss_factor=properties.loss_factor or 0.0,
    )


def ground(scene: Scene) -> ThinPlate | HalfSpaceBody:
    """Return the plate that bends, or the half-space where the scene gives no thickness."""
    properties = scene.plate
    bending = plate(scene)
    if bending is not None:
        return bending
    assert properties.density_kg_m3 is not None  # dynamics needs it
    # An incompressible half-space would carry compression at once, and radiate nothing.
    nu = min(properties.poissons_ratio, 0.499)
    stiffness = properties.youngs_modulus_gpa * 1e9 * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return HalfSpaceBody(properties.density_kg_m3, math.sqrt(stiffness / properties.density_kg_m3))


def thickness_m(scene: Scene) -> float:
    """Return the thickness [m] of the plate, 0 for a half-space."""
    return (scene.plate.thickness_mm or 0.0) * 1e-3


def ball(scene: Scene) -> Ball:
    """Return the sphere as a source of sound."""
    assert scene.sphere.density_kg_m3 is not None  # dynamics needs it
    return Ball(scene.radius, scene.sphere.density_kg_m3)


def rectangular_plate(scene: Scene) -> RectangularPlate | None:
    """Return the plate with edges, or None for a plate without edges."""
    return plate_with_edges(scene.plate)


def plate_with_edges(properties: Plate) -> RectangularPlate | None:
    """Return the plate of a section with its edges, or None for a plate without edges."""
    bending = thin_plate(properties)
    edges = properties.edges_mm
    if bending is None or edges is None or properties.loss_factor is None:
        return None
    length_m, width_m = (1e-3 * edge for edge in edges)
    kinds = properties.edge_pair
    if kinds == (SIMPLE, SIMPLE):
        return RectangularPlate(**vars(bending), length_m=length_m, width_m=width_m)
    return _ritz_plate(bending, length_m, width_m, properties.poissons_ratio, kinds)


@lru_cache(maxsize=8)
def _ritz_plate(
    bending: ThinPlate, length_m: float, width_m: float, poisson: float, edges: tuple[str, str]
) -> RitzPlate:
    """Return a plate with free or clamped edges, the same again so that its modes are kept."""
    return RitzPlate(
        **vars(bending), length_m=length_m, width_m=width_m, poissons_ratio=poisson, edges=edges
    )


def contact_points(scene: Scene, time_s: Array) -> Array:
    """Return the moving contact points at times [s] on a plate with edges, (n, 2) [m]."""
    begin, end = 1e-3 * np.array(list(scene.plate.contact_ends_mm.values()))
    along, across = end - begin
    way = float(np.hypot(along, across))
    passed = np.asarray(scene.motion.distance(time_s)) % (2 * way)
    share = np.minimum(passed, 2 * way - passed) / way
    return np.asarray(begin + share[:, None] * (end - begin))


def contact_path(scene: Scene) -> Path | None:
    """Return the function of time [s] that gives the contact points, None for a single point."""
    if len(scene.plate.contact_ends_mm) < 2:
        return None
    return partial(contact_points, scene)


def bending_limit_hz(scene: Scene) -> float:
    """Return the frequency [Hz] up to which bending waves are six thicknesses long or longer."""
    bending = plate(scene)
    assert bending is not None  # asked for plates that bend alone
    longest = bending.bending_wavelength_m(1.0)  # it falls with the root of the frequency
    return (longest / (MIN_THICKNESSES * thickness_m(scene))) ** 2


def chain(scene: Scene, stiffness_n_m: float) -> Chain:
    """Return sphere, contact and plate for small fluctuations, at a contact stiffness.

    The mobility of a half-space grows with the frequency, so it is taken at the resonance.
    """
    bending = plate(scene)
    loss_factor = scene.plate.contact_loss_factor or 0.0
    if bending is not None:
        rectangle = rectangular_plate(scene)
        modes = None
        if rectangle is not None:
            ends = tuple(scene.plate.contact_ends_mm.values())
            falls = scene.rolling.drop_mm is not None
            modes = _modes_between(rectangle, ends, falls)
        return Chain(
            mass_kg=scene.mass,
            mobility_s_kg=bending.mobility_s_kg,
            stiffness_n_m=stiffness_n_m,
            modes=modes,
            contact_loss_factor=loss_factor,
        )
    young = scene.plate.youngs_modulus_gpa * 1e9
    density = scene.plate.density_kg_m3
    assert density is not None  # dynamics needs it
    resonance = Chain(scene.mass, 0.0, stiffness_n_m).resonance_hz
    mobility = half_space_mobility(resonance, young, scene.plate.poissons_ratio, density)
    return Chain(
        mass_kg=scene.mass,
        mobility_s_kg=mobility,
        stiffness_n_m=stiffness_n_m,
        contact_loss_factor=loss_factor,
    )


@lru_cache(maxsize=8)
def _modes_between(
    rectangle: RectangularPlate, ends_mm: tuple[tuple[float, float], ...], falls: bool
) -> Modes:
    """Return the modes of a plate, weighted by their shapes along a path or at a point [mm].

    The tail of the modes is the one for a sphere that falls, or for one that rolls.
    """
    tail = FALLING_TAIL if falls else ROLLING_TAIL
    return modes_of(rectangle, points_between(ends_mm, _STATIONS), tail)


def points_between(ends_mm: tuple[tuple[float, float], ...], count: int) -> Array:
    """Return points (count, 2) [m] at equal distances between ends [mm], or the only point."""
    ends = 1e-3 * np.array(ends_mm)
    share = np.linspace(0, 1, count if len(ends) > 1 else 1)[:, None]
    return np.asarray(ends[0] + share * (ends[-1] - ends[0]))


def smooth_chain(scene: Scene) -> Chain:
    """Return sphere, contact and plate with the stiffness of a smooth contact."""
    return chain(scene, smooth_stiffness(scene))


def smooth_stiffness(scene: Scene) -> float:
    """Return the stiffness [N/m] of the smooth elastic contact, 2 E* a of the equivalent sphere."""
    radius = closed_forms.hertz_radius(scene.load, equivalent_radius(scene), scene.contact_modulus)
    return 2 * scene.contact_modulus * radius


def chain_over(scene: Scene, law: ForceLaw) -> Chain:
    """Return sphere, contact and plate with the mean stiffness of a force law."""
    return chain(scene, contact_stiffness(law, scene.load))


def motion(scene: Scene, law: ForceLaw, time_step_s: float | None = None) -> BodyMotion:
    """Move the sphere of a scene over a force law for its duration; default: steps of `move`."""
    return _motion_of(scene, law, chain_over(scene, law), time_step_s)


def motion_on_rigid_plate(scene: Scene, law: ForceLaw) -> BodyMotion:
    """Move the sphere of a scene over a force law on a plate that does not give way.

    Only a loss factor of the contact damps it then.
    """
    rigid = replace(chain_over(scene, law), mobility_s_kg=0.0, modes=None)
    return _motion_of(scene, law, rigid)


def _motion_of(
    scene: Scene, law: ForceLaw, linear: Chain, time_step_s: float | None = None
) -> BodyMotion:
    """Move a chain over a force law for the duration of its scene."""
    duration = scene.duration
    fastest = scene.motion.fastest(duration)
    speed: float | Travel = fastest
    if not scene.motion.is_constant(duration):
        times = np.linspace(0.0, duration, min(4 * scene.track.steps, _MAX_TIMES) + 1)
        places = np.minimum(scene.motion.distance(times), scene.track.distance)
        speed = Travel(times, np.asarray(places, dtype=float))
    stepping = Stepping(time_step_s=time_step_s)
    if scene.rolling.drop_mm is not None:
        step = time_step_s or drop.time_step_s(scene, law, linear, fastest)
        stepping = Stepping(time_step_s=step, start=drop.start(scene, law, linear))
    path = contact_path(scene) if linear.modes is not None else None
    return move(law, linear, scene.load, speed, duration, stepping, path)
