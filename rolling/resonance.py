"""The ball bouncing on its contact, which a constant load leaves out: its frequency, and how much of the sound it would be.

Depends on scenario and reference. The mass is a free ball's. The stiffness is that of the smooth elastic contact, 2 E* a with the
Hertz radius a, whether the plate yields or not; the elasticity of both bodies is in it.
"""

from __future__ import annotations

import math

from rolling import reference
from rolling.scenario import Scene

# Length v / f0 of the waves that feed the resonance, in contact radii. A contact averages shorter waves out: by a linear model of
# the ball on a 10 mm steel plate (Q 20) the release that the bouncing adds stands 31 to 36 dB below the release at 0.2 radii, 10 to
# 18 dB below at 0.6, and equals it at 2 (Ra 0.01 to 1 um, 5 to 100 N, radii of the ball 1 to 20 mm).
FELT_RADII = 0.2
DOMINANT_RADII = 0.6


def frequency(scene: Scene) -> float:
    """Return the natural frequency [Hz] of the free ball on its contact: sqrt(2 E* a / m) / (2 pi)."""
    radius = reference.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    return math.sqrt(2 * scene.contact_modulus * radius / scene.mass) / (2 * math.pi)


def wave_radii(scene: Scene, speed: float) -> float:
    """Return the length of the waves that feed the resonance at a speed [m/s], in contact radii."""
    return speed / frequency(scene) / reference.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
