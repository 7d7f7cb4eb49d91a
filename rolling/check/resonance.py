"""Bouncing of the ball on its contact, which a constant load leaves out.

The mass belongs to a free ball. The stiffness is 2 E* a, the smooth elastic contact with the Hertz
radius a, whether the plate yields or not; the elasticity of both bodies is in it.
"""

from __future__ import annotations

import math

from rolling.contact import closed_forms
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian

# These are limits of the length v / f0 of the waves that feed the resonance, divided by the sum of
# contact radius and correlation length: the contact averages shorter waves out, and the surface has
# few of them. By a linear model of the ball on a 10 mm steel plate (Q 20), 2 to 100 N, Ra 0.01 to
# 1 um, correlation lengths 10 to 100 um, 0.03 to 2 m/s, the bouncing adds -25 to -37 dB at 0.2 and
# -5 to -15 dB at 0.7, relative to the release within hearing.
FELT = 0.2
DOMINANT = 0.7


def frequency(scene: Scene) -> float:
    """Return the natural frequency [Hz] of the free ball on its contact.

    It is sqrt(2 E* a / m) / (2 pi).
    """
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    return math.sqrt(2 * scene.contact_modulus * radius / scene.mass) / (2 * math.pi)


def relative_wave(scene: Scene, speed: float) -> float:
    """Return the relative length of the waves that feed the resonance at a speed [m/s].

    The length is divided by the sum of contact radius and correlation length.
    """
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    correlation = (
        scene.surface.correlation_length_um * 1e-6 if isinstance(scene.surface, Gaussian) else 0.0
    )
    return speed / frequency(scene) / (radius + correlation)
