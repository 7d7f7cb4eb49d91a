"""Contact force of a scene with dynamics, estimated from the statistics of its surface.

The contact averages the heights with its pressure, an ellipsoid over the circle in which a smooth
contact is at most an rms height apart, and their mean moves sphere, contact and plate as a linear
chain. A looped record has the lines of its lap, which a sharp resonance may miss. docs/dynamics.md
compares the estimate with runs.
"""

import math

import numpy as np

from acoustics.arrays import Array
from rolling.check import cost
from rolling.dynamics.comb import NEAR_SPEEDS
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.scene.laws import HeightLaw
from rolling.scene.scene import Scene
from rolling.surface.contact_average import averaged_density, rough_axes

NOTHING = 1e-200  # spectral density [m3] of a surface that the contact averages out
SPEEDS = 61  # number of speeds, as a sharp resonance needs them
# points along, and over the resonance
WAVES = 160
LINES = 40_000


def force_rms(scene: Scene) -> float | None:
    """Estimate the rms fluctuation of the contact force [N] at the maximum speed.

    Return None for a height file, whose statistics the scene does not know.
    """
    if not scene.laws:
        return 0.0 if scene.is_smooth else None
    chain = bodies_of(scene).smooth_chain
    speed = scene.motion.fastest(scene.duration)
    longest = scene.track.n_along * scene.spacing
    shortest = 2 * scene.step
    coarse = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, WAVES)
    density = np.sum([mean_heights(scene, law, coarse) for law in scene.laws], axis=0)
    if longest <= shortest or not density.max() > NOTHING:
        return 0.0
    kept = np.log(np.maximum(density, NOTHING))

    def power(waves: Array, ratio: float = 1.0) -> Array:
        """Return the spectral density of the force [N2 m] at another ratio of speeds."""
        gain = chain.force(waves * (ratio * speed / (2 * math.pi)), np.ones(len(waves)))
        spectrum = np.exp(np.interp(np.log(waves), np.log(coarse), kept))
        return np.asarray(2 * spectrum * np.square(np.abs(gain)))

    if scene.track.closed and scene.track.n_along <= 2 * LINES:
        lines = coarse[0] * np.arange(1, math.floor(coarse[-1] / coarse[0]) + 1)
        ratios = np.linspace(1 - NEAR_SPEEDS, 1 + NEAR_SPEEDS, SPEEDS)
        typical = np.median([power(lines, ratio).sum() for ratio in ratios])
        return float(np.sqrt(coarse[0] * typical))
    fine = np.geomspace(coarse[0], coarse[-1], LINES)
    return float(np.sqrt(np.trapezoid(power(fine), fine)))


def contact_axes(scene: Scene) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact of a rough surface, along and across."""
    return rough_axes(
        semi_axes_m=smooth_contact_of(scene).semi_axes_m(),
        radii_m=(scene.radius, scene.radius_across),
        rq_m=cost.roughness(scene)[0],
    )


def mean_heights(scene: Scene, law: HeightLaw, along: Array) -> Array:
    """Return the two-sided spectral density [m3] of the heights that the contact averages."""
    return averaged_density(law.in_si, along, contact_axes(scene), scene.spacing)
