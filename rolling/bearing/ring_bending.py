"""Bending of a ring: its section with a groove, its modes in the plane, and those left out.

A thin ring bends in its plane without stretching. Of n waves around it a place phi moves outwards
by q cos(n phi) and along the ring by -q/n sin(n phi), or as the sine of it, with

    omega_n^2 = E I / (rho S R^4) n^2 (n^2 - 1)^2 / (n^2 + 1),   m_n = m/2 (1 + 1/n^2)

where S is the area of the section, I its second moment about the axis through its centroid that is
parallel to the axis of the bearing, R the radius of the centroid, and m the mass of the ring
(A. E. H. Love, Mathematical Theory of Elasticity, section 293). Out of its plane it bends and
twists together:

    omega_n^2 = E I_x / (rho S R^4) n^2 (n^2 - 1)^2 / (n^2 + E I_x / (G J))

with the second moment I_x about the radius and the torsion constant J; without the inertia of the
twist, which lowers it. These modes are left out, and so are waves of four and more around the ring.
"""

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np

from acoustics.arrays import Array, short_repr

ORDERS = (2, 3)  # waves around the ring of the modes that are moved
HIGHEST_HZ = 50e3  # free frequency of a mode above which it is rigid in all that is heard
_POINTS = 40  # of Gauss and Legendre across a groove, which is smooth


@dataclass(frozen=True)
class BendingMode:
    """Mode of the bending of a free ring in its plane, with a cosine and a sine part.

    order : int. Waves around the ring.
    mass_kg : float, kg. Modal mass of each part, for a displacement outwards of 1 at its crest.
    frequency_hz : float, Hz. Frequency of the free ring.
    """

    order: int
    mass_kg: float
    frequency_hz: float

    @property
    def stiffness_n_m(self) -> float:
        """Modal stiffness [N/m]."""
        return self.mass_kg * (2 * pi * self.frequency_hz) ** 2


@dataclass(frozen=True)
class GroovedSection:
    """Section of a ring: a rectangle with a groove, which is a segment of a circle.

    wall_m : float, m. Height behind the bottom of the groove.
    depth_m : float, m. Height of the shoulders above it.
    groove_radius_m : float, m.
    width_m : float, m.
    """

    wall_m: float
    depth_m: float
    groove_radius_m: float
    width_m: float

    @cached_property
    def _heights(self) -> tuple[Array, Array, Array]:
        """Places across the section [m], the heights there, and the widths [m] that they have."""
        height = self.wall_m + self.depth_m
        half = sqrt(self.depth_m * (2 * self.groove_radius_m - self.depth_m))
        half = min(half, self.width_m / 2)
        nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
        shoulder = (self.width_m / 2 - half) / 2  # half of the width of one
        places = [half * nodes]
        centre = self.wall_m + self.groove_radius_m
        heights = [centre - np.sqrt(self.groove_radius_m**2 - places[0] ** 2)]
        widths = [half * weights]
        for side in (-1.0, 1.0):
            places.append(side * (half + shoulder) + shoulder * nodes)
            heights.append(np.full(_POINTS, height))
            widths.append(shoulder * weights)
        return np.concatenate(places), np.concatenate(heights), np.concatenate(widths)

    @cached_property
    def area_m2(self) -> float:
        """Area S [m2]."""
        _, heights, widths = self._heights
        return float(widths @ heights)

    @cached_property
    def centroid_m(self) -> float:
        """Distance of the centroid from the cylinder of the ring [m]."""
        _, heights, widths = self._heights
        return float(widths @ heights**2) / 2 / self.area_m2

    @cached_property
    def in_plane_m4(self) -> float:
        """Second moment I [m4] against bending in the plane of the ring."""
        _, heights, widths = self._heights
        return float(widths @ heights**3) / 3 - self.area_m2 * self.centroid_m**2

    @cached_property
    def out_of_plane_m4(self) -> float:
        """Second moment I_x [m4] against bending out of the plane of the ring."""
        places, heights, widths = self._heights
        return float((widths * heights) @ places**2)

    @property
    def torsion_m4(self) -> float:
        """Torsion constant J [m4] of a rectangle of the same area and width."""
        short, long = sorted((self.area_m2 / self.width_m, self.width_m))
        return long * short**3 / 3 * (1 - 0.63 * short / long)


@dataclass(frozen=True)
class RingBending:
    """Bending of a free ring.

    section : GroovedSection.
    radius_m : float, m. Radius of the centroid of the section.
    youngs_modulus, poissons_ratio, density : float. Of the ring [Pa, -, kg/m3].
    """

    __repr__ = short_repr

    section: GroovedSection
    radius_m: float
    youngs_modulus: float
    poissons_ratio: float
    density: float

    @property
    def mass_kg(self) -> float:
        """Mass of the ring without what is fixed to it [kg]."""
        return self.density * self.section.area_m2 * 2 * pi * self.radius_m

    def in_plane_hz(self, order: int) -> float:
        """Return the frequency [Hz] of a mode with some waves around the ring, in its plane."""
        shape = order * (order**2 - 1) / sqrt(order**2 + 1)
        return shape * sqrt(self._stiffness_over_mass(self.section.in_plane_m4)) / (2 * pi)

    def out_of_plane_hz(self, order: int) -> float:
        """Return the frequency [Hz] of a mode with some waves around the ring, out of its plane."""
        shear = self.youngs_modulus / (2 * (1 + self.poissons_ratio))
        ratio = self.youngs_modulus * self.section.out_of_plane_m4
        ratio /= shear * self.section.torsion_m4
        shape = order * (order**2 - 1) / sqrt(order**2 + ratio)
        return shape * sqrt(self._stiffness_over_mass(self.section.out_of_plane_m4)) / (2 * pi)

    def _stiffness_over_mass(self, moment_m4: float) -> float:
        """Return E I / (rho S R^4) [1/s2] of a second moment."""
        mass_per_length = self.density * self.section.area_m2
        return self.youngs_modulus * moment_m4 / (mass_per_length * self.radius_m**4)

    @property
    def left_out_hz(self) -> float:
        """Lowest frequency [Hz] of a mode that is left out of a ring that bends."""
        return min(self.in_plane_hz(max(ORDERS) + 1), self.out_of_plane_hz(min(ORDERS)))

    @property
    def modes(self) -> tuple[BendingMode, ...]:
        """Modes that are moved: of two and three waves, but for those far above hearing."""
        modes = []
        for order in ORDERS:
            frequency_hz = self.in_plane_hz(order)
            if frequency_hz < HIGHEST_HZ:
                mass = self.mass_kg / 2 * (1 + 1 / order**2)
                modes.append(BendingMode(order, mass, frequency_hz))
        return tuple(modes)
