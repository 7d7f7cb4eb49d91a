"""What a listener hears of each place of a surface by its linear response, without a march.

The contact averages the heights with its pressure, and ball, contact and plate carry their mean to
the listener as a linear chain. No contact is solved, so this serves for what depends little on the
contact: how much alike places of a scan are, and small changes of a level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import fft

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.weighting import a_weighting_db
from rolling.ball_kinds.ball_heard import SPEED_RATIOS
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.in_si.assumed_bodies import with_bodies
from rolling.in_si.length_rule import approach_gain
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.in_si.scene_surface import scene_surface
from rolling.scene.scene import Scene
from rolling.sound.receivers import Listener
from rolling.surface.contact_average import pressure_average, rough_axes


class Spacing(NamedTuple):
    """Distance of nodes along and across [m]."""

    along: float
    across: float


@dataclass(frozen=True)
class LinearResponse:
    """Contact and chain of a scene, which take heights to what is heard.

    bodies : BallOnPlate. Ball and plate.
    listener : Listener. Who hears them.
    semi_axes_m : pair of float, m. Of the rough contact, along and across.
    speed_m_s : float, m/s. Speed.
    highest_hz : float, Hz. Highest frequency that the steps of the track resolve.
    """

    bodies: BallOnPlate
    listener: Listener
    semi_axes_m: tuple[float, float]
    speed_m_s: float
    highest_hz: float

    def heard(self, heights: Array, spacing: Spacing) -> Array:
        """Return what is heard of each node [Pa], (along, across), A-weighted.

        Parameters
        ----------
        heights : (along, across) array, m
            Heights that close on themselves.
        spacing : Spacing
            Distance of their nodes.
        """
        along, across = heights.shape
        waves_along = 2 * np.pi * np.fft.fftfreq(along, spacing.along)
        waves_across = 2 * np.pi * np.fft.rfftfreq(across, spacing.across)
        length, width = self.semi_axes_m
        spectrum = fft.rfft2(heights)
        spectrum *= pressure_average(np.hypot(length * waves_along[:, None], width * waves_across))
        spectrum *= np.sqrt(self._gain(np.abs(waves_along)))[:, None]
        return np.asarray(fft.irfft2(spectrum, s=heights.shape))

    def _gain(self, waves: Array) -> Array:
        """Return the power gain [Pa2/m2] of waves along the track [rad/m], A-weighted.

        It is the mean over the speeds at which a choice hears.
        """
        total = np.zeros(len(waves))
        for ratio in SPEED_RATIOS:
            frequency = waves * (ratio * self.speed_m_s / (2 * np.pi))
            lowest, highest = AUDIBLE_HZ[0], min(AUDIBLE_HZ[1], self.highest_hz)
            inside = (frequency >= lowest) & (frequency <= highest)
            heard = frequency[inside]
            gain = approach_gain(self.bodies, self.listener, heard)
            total[inside] += gain * 10 ** (a_weighting_db(heard) / 10)
        return total / len(SPEED_RATIOS)


def linear_response(scene: Scene, rq_m: float) -> LinearResponse:
    """Return the linear response of a scene over heights of a root mean square [m]."""
    described = with_bodies(scene)
    bodies = bodies_of(described)
    speed = scene.motion.fastest(scene.duration)
    return LinearResponse(
        bodies=bodies,
        listener=listener_of(described),
        semi_axes_m=rough_axes(
            semi_axes_m=bodies.contact.semi_axes_m(),
            radii_m=(scene.radius, scene.radius_across),
            rq_m=rq_m,
        ),
        speed_m_s=speed,
        highest_hz=speed / (2 * scene.step),
    )


def heard_places(scene: Scene) -> Array:
    """Return what is heard of each node of the surface of a scene [Pa], (along, across).

    Raises
    ------
    SceneError : the surface cannot be made or read.
    """
    surface = scene_surface(scene)
    heights = surface.heights - surface.heights.mean()
    response = linear_response(scene, float(np.sqrt(np.mean(np.square(heights)))))
    return response.heard(heights, Spacing(surface.spacing, surface.spacing))
