"""Contact force of a scene with dynamics, estimated from the statistics of its surface.

The contact averages the heights with its pressure, an ellipsoid over the circle in which a smooth
contact is at most an rms height apart, and their mean moves sphere, contact and plate as a linear
chain. A looped record has the lines of its lap, which a sharp resonance may miss. docs/dynamics.md
compares the estimate with runs.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from acoustics.arrays import Array
from rolling.check import cost
from rolling.dynamics.bodies import Chain
from rolling.dynamics.comb import NEAR_SPEEDS
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.scene.scene import Scene
from rolling.surface.contact_average import averaged_density, rough_axes
from rolling.surface.height_law import HeightSpectrum

NOTHING = 1e-200  # spectral density [m3] of a surface that the contact averages out
SPEEDS = 61  # number of speeds, as a sharp resonance needs them
# points along, and over the resonance
WAVES = 160
LINES = 40_000
SHARED = 64  # estimates that are kept, for runs of a sweep that differ in other keys


@dataclass(frozen=True, kw_only=True)
class RollingStatistics:
    """All that the estimate of a force takes of a scene; runs that differ in other keys share it.

    Attributes
    ----------
    laws : tuple of HeightSpectrum
        Laws of the random heights of plate and sphere.
    axes_m : (2,) tuple of float, m
        Semi-axes of the contact of the rough surface, along and across.
    chain : Chain
        Ball, contact and plate.
    speed_m_s : float, m/s
        Highest speed.
    spacing_m, step_m : float, m
        Distance of nodes, and of positions.
    n_along : int
        Nodes of the track along.
    is_closed : bool
        Whether the track closes on itself.
    """

    laws: tuple[HeightSpectrum, ...]
    axes_m: tuple[float, float]
    chain: Chain
    speed_m_s: float
    spacing_m: float
    step_m: float
    n_along: int
    is_closed: bool


def force_rms(scene: Scene) -> float | None:
    """Estimate the rms fluctuation of the contact force [N] at the maximum speed.

    Return None for a height file, whose statistics the scene does not know.
    """
    if not scene.laws:
        return 0.0 if scene.is_smooth else None
    statistics = RollingStatistics(
        laws=tuple(law.in_si for law in scene.laws),
        axes_m=contact_axes(scene),
        chain=bodies_of(scene).smooth_chain,
        speed_m_s=scene.motion.fastest(scene.duration),
        spacing_m=scene.spacing,
        step_m=scene.step,
        n_along=scene.track.n_along,
        is_closed=scene.track.closed,
    )
    return rms_of_statistics(statistics)


@lru_cache(maxsize=SHARED)
def rms_of_statistics(rolling: RollingStatistics) -> float:
    """Estimate the rms fluctuation of the contact force [N] from the statistics of the heights."""
    longest = rolling.n_along * rolling.spacing_m
    shortest = 2 * rolling.step_m
    coarse = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, WAVES)
    densities = [
        averaged_density(law, coarse, rolling.axes_m, rolling.spacing_m) for law in rolling.laws
    ]
    density = np.sum(densities, axis=0)
    if longest <= shortest or not density.max() > NOTHING:
        return 0.0
    kept = np.log(np.maximum(density, NOTHING))

    def heights(waves: Array) -> Array:
        """Return the one-sided spectral density of the averaged heights [m3]."""
        return np.asarray(2 * np.exp(np.interp(np.log(waves), np.log(coarse), kept)))

    def gain(waves: Array, ratio: float = 1.0) -> Array:
        """Return the squared force over height [N2/m2] at another ratio of speeds."""
        frequency = waves * (ratio * rolling.speed_m_s / (2 * math.pi))
        return np.square(np.abs(rolling.chain.force(frequency, np.ones(len(waves)))))

    if rolling.is_closed and rolling.n_along <= 2 * LINES:
        lines = coarse[0] * np.arange(1, math.floor(coarse[-1] / coarse[0]) + 1)
        of_lines = heights(lines)
        ratios = np.linspace(1 - NEAR_SPEEDS, 1 + NEAR_SPEEDS, SPEEDS)
        typical = np.median([np.sum(of_lines * gain(lines, ratio)) for ratio in ratios])
        return float(np.sqrt(coarse[0] * typical))
    fine = np.geomspace(coarse[0], coarse[-1], LINES)
    return float(np.sqrt(np.trapezoid(heights(fine) * gain(fine), fine)))


def contact_axes(scene: Scene) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact of a rough surface, along and across."""
    return rough_axes(
        semi_axes_m=smooth_contact_of(scene).semi_axes_m(),
        radii_m=(scene.radius, scene.radius_across),
        rq_m=cost.roughness(scene)[0],
    )
