"""The ball bouncing on its contact, which a constant load leaves out: its frequency and its part of
the sound.

The mass belongs to a free ball. The stiffness is 2 E* a, the smooth elastic contact with the Hertz
radius a, whether the plate yields or not; the elasticity of both bodies is in it.
"""

from __future__ import annotations

import math

from rolling.contact import closed_forms
from rolling.scene.scene import Scene
from rolling.scene.sections import Gaussian

# Length v / f0 of the waves that feed the resonance, over contact radius and correlation length
# together: the contact averages shorter waves out, and the surface has few of them. Release that
# the bouncing adds, re the release within hearing, by a linear model of the ball on a 10 mm steel
# plate (Q 20), 2 to 100 N, Ra 0.01 to 1 um, correlation lengths 10 to 100 um, 0.03 to 2 m/s: -25 to
# -37 dB at 0.2, -5 to -15 dB at 0.7.
FELT = 0.2
DOMINANT = 0.7


def frequency(scene: Scene) -> float:
    """Return the natural frequency [Hz] of the free ball on its contact: sqrt(2 E* a / m) / (2 pi)."""
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    return math.sqrt(2 * scene.contact_modulus * radius / scene.mass) / (2 * math.pi)


def relative_wave(scene: Scene, speed: float) -> float:
    """Return the length of the waves that feed the resonance at a speed [m/s], over contact radius
    plus correlation length.
    """
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    correlation = (
        scene.surface.correlation_length_um * 1e-6 if isinstance(scene.surface, Gaussian) else 0.0
    )
    return speed / frequency(scene) / (radius + correlation)
