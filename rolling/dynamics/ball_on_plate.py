"""Ball and plate that vibrate: their properties, and the linear chain that they make.

The ball rolls on the plate, or falls on it. The plate bends, or is a half-space.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from acoustics.arrays import Array
from acoustics.loss_factors import LossFactor
from acoustics.plate_modes import SIMPLE
from acoustics.radiation import Ball, HalfSpaceBody, ThinPlate
from acoustics.rectangular_plate import RectangularPlate
from acoustics.ritz_plate import RitzPlate
from rolling.contact.smooth_contact import SmoothContact
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

MIN_THICKNESSES = 6.0  # in a bending wave; shorter waves are beyond thin-plate theory
BENT = 0.1  # deflection over thickness up to which thin-plate theory holds
_STATIONS = 17  # points of a path over which the linear chain takes the mean

Point = tuple[float, float]  # (x, y) [m] from a corner of a plate with edges


@dataclass(frozen=True, kw_only=True)
class PlateBody:
    """Plate as a body that vibrates.

    Attributes
    ----------
    youngs_modulus_pa : float, Pa
        Young's modulus.
    poissons_ratio : float
        Poisson's ratio.
    density_kg_m3 : float or None, kg/m^3
        Density. None: it is not known, and the plate does not vibrate.
    thickness_m : float, m
        Thickness of a plate that bends. 0: a half-space.
    loss_factor : float, or pairs of float, or None
        Loss factor of bending waves, or pairs of a frequency [Hz] and a loss factor. None: it is
        not known.
    sides_m : (2,) tuple of float or None, m
        Length and width of a rectangular plate. None: a plate without edges.
    edges : (2,) tuple of str
        Kinds of the edges at the ends of the length, and at those of the width.
    contact_ends_m : tuple of (x, y), m
        Contact point from a corner of a plate with edges, and the other end of its path if the
        contact moves. Empty for a plate without edges.
    """

    youngs_modulus_pa: float
    poissons_ratio: float
    density_kg_m3: float | None = None
    thickness_m: float = 0.0
    loss_factor: LossFactor | None = None
    sides_m: tuple[float, float] | None = None
    edges: tuple[str, str] = (SIMPLE, SIMPLE)
    contact_ends_m: tuple[Point, ...] = ()

    @property
    def bending(self) -> ThinPlate | None:
        """Infinite plate that bends, None for a half-space."""
        thickness = self.thickness_m
        if not thickness or self.density_kg_m3 is None:
            return None
        young = self.youngs_modulus_pa
        return ThinPlate(
            mass_per_area_kg_m2=self.density_kg_m3 * thickness,
            bending_stiffness_n_m=young * thickness**3 / (12 * (1 - self.poissons_ratio**2)),
            loss_factor=self.loss_factor or 0.0,
        )

    @property
    def ground(self) -> ThinPlate | HalfSpaceBody:
        """Plate that bends, or half-space, as a source of sound."""
        if self.bending is not None:
            return self.bending
        assert self.density_kg_m3 is not None  # a body that vibrates has one
        # An incompressible half-space would carry compression at once, and radiate nothing.
        nu = min(self.poissons_ratio, 0.499)
        stiffness = self.youngs_modulus_pa * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
        return HalfSpaceBody(self.density_kg_m3, math.sqrt(stiffness / self.density_kg_m3))

    @property
    def with_edges(self) -> RectangularPlate | None:
        """Rectangular plate, None for a plate without edges."""
        bending = self.bending
        if bending is None or self.sides_m is None or self.loss_factor is None:
            return None
        length_m, width_m = self.sides_m
        if self.edges == (SIMPLE, SIMPLE):
            return RectangularPlate(**vars(bending), length_m=length_m, width_m=width_m)
        return _ritz_plate(bending, length_m, width_m, self.poissons_ratio, self.edges)

    @property
    def bending_limit_hz(self) -> float:
        """Frequency [Hz] up to which bending waves are six thicknesses long or longer."""
        bending = self.bending
        assert bending is not None  # asked for plates that bend alone
        longest = bending.bending_wavelength_m(1.0)  # it falls with the root of the frequency
        return (longest / (MIN_THICKNESSES * self.thickness_m)) ** 2

    @property
    def has_path(self) -> bool:
        """Whether the contact moves on a plate with edges."""
        return len(self.contact_ends_m) > 1

    def contact_points(self, distance_m: Array) -> Array:
        """Return the contact points (n, 2) [m] after distances (n,) [m] along a path to and fro."""
        begin, end = np.array(self.contact_ends_m)
        along, across = end - begin
        way = float(np.hypot(along, across))
        passed = np.asarray(distance_m) % (2 * way)
        share = np.minimum(passed, 2 * way - passed) / way
        return np.asarray(begin + share[:, None] * (end - begin))

    def points_between_ends(self, count: int) -> Array:
        """Return points (count, 2) [m] at equal distances on the path, or the only point."""
        ends = np.array(self.contact_ends_m)
        share = np.linspace(0, 1, count if len(ends) > 1 else 1)[:, None]
        return np.asarray(ends[0] + share * (ends[-1] - ends[0]))


@lru_cache(maxsize=8)
def _ritz_plate(
    bending: ThinPlate, length_m: float, width_m: float, poisson: float, edges: tuple[str, str]
) -> RitzPlate:
    """Return a plate with free or clamped edges, the same again so that its modes are kept."""
    return RitzPlate(
        **vars(bending), length_m=length_m, width_m=width_m, poissons_ratio=poisson, edges=edges
    )


@dataclass(frozen=True, kw_only=True)
class BallOnPlate:
    """Ball and plate that vibrate, and the contact between them.

    Attributes
    ----------
    mass_kg : float, kg
        Mass of the ball.
    ball_density_kg_m3 : float or None, kg/m^3
        Density of the ball. None: it is not stated, and the ball is no source of sound.
    contact : SmoothContact
        Contact of the bodies where they are smooth, with the load, the radii and the modulus.
    plate : PlateBody
        Plate.
    contact_loss_factor : float or None
        Loss factor of the contact stiffness at the resonance. None: none is stated, and none acts.
    drop_height_m : float, m
        Height above the surface from which the ball is let go. 0: it rolls.
    is_smooth : bool
        Whether plate and ball are perfectly smooth, so that what fluctuates while the ball rolls is
        the error of the solver.
    """

    mass_kg: float
    ball_density_kg_m3: float | None
    contact: SmoothContact
    plate: PlateBody
    contact_loss_factor: float | None = None
    drop_height_m: float = 0.0
    is_smooth: bool = False

    @property
    def load_n(self) -> float:
        """Normal load [N]."""
        return self.contact.load_n

    @property
    def falls(self) -> bool:
        """Whether the ball is let go from a height."""
        return self.drop_height_m > 0

    @property
    def ball(self) -> Ball:
        """Ball as a source of sound."""
        assert self.ball_density_kg_m3 is not None  # a ball that is heard has one
        return Ball(self.contact.radius_m, self.ball_density_kg_m3)

    def chain(self, stiffness_n_m: float) -> Chain:
        """Return ball, contact and plate for small fluctuations, at a contact stiffness.

        The mobility of a half-space grows with the frequency, so it is taken at the resonance.
        """
        plate = self.plate
        loss_factor = self.contact_loss_factor or 0.0
        bending = plate.bending
        if bending is not None:
            modes = None
            if plate.with_edges is not None:
                modes = _modes_along_path(plate, self.falls)
            return Chain(
                mass_kg=self.mass_kg,
                mobility_s_kg=bending.mobility_s_kg,
                stiffness_n_m=stiffness_n_m,
                modes=modes,
                contact_loss_factor=loss_factor,
            )
        assert plate.density_kg_m3 is not None  # a body that vibrates has one
        resonance = Chain(self.mass_kg, 0.0, stiffness_n_m).resonance_hz
        mobility = half_space_mobility(
            resonance, plate.youngs_modulus_pa, plate.poissons_ratio, plate.density_kg_m3
        )
        return Chain(
            mass_kg=self.mass_kg,
            mobility_s_kg=mobility,
            stiffness_n_m=stiffness_n_m,
            contact_loss_factor=loss_factor,
        )

    @property
    def bounce_hz(self) -> float:
        """Natural frequency [Hz] of the free ball on its contact, sqrt(2 E* a / m) / 2 pi.

        The mass belongs to a free ball, and the stiffness 2 E* a to the smooth elastic contact with
        the Hertz radius a, whether the plate yields or not.
        """
        return math.sqrt(self.contact.stiffness_n_m / self.mass_kg) / (2 * math.pi)

    @property
    def smooth_chain(self) -> Chain:
        """Ball, contact and plate with the stiffness of a smooth contact."""
        return self.chain(self.contact.stiffness_n_m)

    def chain_over(self, law: ForceLaw) -> Chain:
        """Return ball, contact and plate with the mean stiffness of a force law."""
        return self.chain(contact_stiffness(law, self.load_n))


@lru_cache(maxsize=8)
def _modes_along_path(plate: PlateBody, falls: bool) -> Modes:
    """Return the modes of a plate with edges, weighted by their shapes along its contact path.

    The tail of the modes is the one for a ball that falls, or for one that rolls.
    """
    rectangle = plate.with_edges
    assert rectangle is not None  # only asked for with edges
    tail = FALLING_TAIL if falls else ROLLING_TAIL
    return modes_of(rectangle, plate.points_between_ends(_STATIONS), tail)
