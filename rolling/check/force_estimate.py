"""Contact force of a scene that vibrates, estimated from the statistics of its surface.

A smooth contact averages the heights with its pressure, an ellipsoid over the Hertz circle. The
mean height moves sphere, contact and plate as a linear chain. Where the contact is rough or yields
it is wider than Hertz says, and the estimate is some decibels too high.
"""

from __future__ import annotations

import math

import numpy as np

from rolling._typing import Array
from rolling.check import cost
from rolling.contact import closed_forms
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.surface import heights

PEAKS = 4.0  # standard deviations of Gaussian noise that some 10^4 periods exceed once
_WAVES, _ACROSS, _LINES = 160, 160, 40_000  # points along, across, and over the resonance


def force_rms(scene: Scene) -> float | None:
    """Estimate the rms fluctuation of the contact force [N] at the maximum speed.

    Return None for surfaces without statistics in the scene.
    """
    surface = scene.surface
    if not isinstance(surface, Gaussian):
        return 0.0 if surface.kind == "smooth" else None
    chain, speed = of_scene.smooth_chain(scene), scene.motion.fastest(scene.duration)
    longest, shortest = scene.track.n_along * scene.spacing, 2 * scene.step
    coarse = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, _WAVES)
    density = _mean_heights(scene, surface, coarse)
    fine = np.geomspace(coarse[0], coarse[-1], _LINES)
    kept = np.maximum(density, 1e-300 * density.max())
    spectrum = np.exp(np.interp(np.log(fine), np.log(coarse), np.log(kept)))
    gain = np.abs(chain.force(fine * speed / (2 * math.pi), np.ones(_LINES)))
    return float(np.sqrt(2 * np.trapezoid(spectrum * gain**2, fine)))


def _mean_heights(scene: Scene, surface: Gaussian, along: Array) -> Array:
    """Return the two-sided spectral density [m3] of the heights that the contact averages."""
    rq = cost.roughness(scene)[0]
    decay, exponent = heights.AUTOCORRELATIONS[surface.autocorrelation]
    first, second = (
        length * 1e-6 * decay ** (-1 / exponent) for length in cost.correlation_lengths(surface)
    )
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    widest = math.pi / scene.spacing
    across = np.concatenate(([0.0], np.geomspace(1e-4 * widest, widest, _ACROSS)))
    scaled = np.square(along[:, None] * first) + np.square(across * second)
    if exponent == 2:
        plane = rq**2 * first * second * np.exp(-scaled / 4) / (4 * math.pi)
    else:
        plane = rq**2 * first * second / (2 * math.pi * (1 + scaled) ** 1.5)
    q = radius * np.hypot(along[:, None], across)
    pressure = 3 * (np.sin(q) - q * np.cos(q)) / q**3
    density: Array = 2 * np.trapezoid(plane * pressure**2, across, axis=1)
    return density
