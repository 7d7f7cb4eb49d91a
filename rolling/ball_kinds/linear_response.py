"""What a listener hears of each place of a surface by its linear response, without a march.

The contact averages the heights with its pressure, and ball, contact and plate carry their mean to
the listener as a linear chain. No contact is solved, so this serves for what depends little on the
contact: how much alike places of a scan are, and small changes of a level.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
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
from rolling.surface.contact_average import asperity_density, pressure_average, rough_axes


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

    def heard(self, heights: Array, spacing_m: float) -> Array:
        """Return what is heard of each node [Pa], (along, across), A-weighted.

        Parameters
        ----------
        heights : (along, across) array, m
            Heights that close on themselves.
        spacing_m : float, m
            Distance of their nodes.
        """
        waves_along, averaged = self._averaged(heights, spacing_m)
        averaged *= np.sqrt(self._gain(np.abs(waves_along)))[:, None]
        return np.asarray(fft.irfft2(averaged, s=heights.shape))

    def mean_square(self, heights: Array, spacing_m: float) -> float:
        """Return the A-weighted mean square [Pa2] over all tracks of heights.

        Short waves have at least what asperities that take the load from each other add to them.
        """
        along, across = heights.shape
        waves_along, averaged = self._averaged(heights, spacing_m)
        twice = np.full(averaged.shape[1], 2.0)  # waves across that stand for both signs
        twice[0] = 1.0
        if across % 2 == 0:
            twice[-1] = 1.0
        power = np.square(np.abs(averaged)) @ twice / heights.size**2
        power[0] = 0.0
        waves = np.abs(waves_along)
        length, _ = self.semi_axes_m
        line = 2 * np.pi / (along * spacing_m)  # distance of lines [rad/m], each of one sign
        of_asperities = asperity_density(np.maximum(waves, line), length) * line / 2
        power = np.maximum(power, float(power.sum()) * of_asperities)
        return float(power @ self._gain(waves))

    def _averaged(self, heights: Array, spacing_m: float) -> tuple[Array, NDArray[np.complex128]]:
        """Return wave numbers along [rad/m], and the spectrum of heights that a contact averages.

        The spectrum is that of a real transform, (along, across / 2 + 1).
        """
        along, across = heights.shape
        waves_along = np.asarray(2 * np.pi * np.fft.fftfreq(along, spacing_m), dtype=np.float64)
        waves_across = 2 * np.pi * np.fft.rfftfreq(across, spacing_m)
        length, width = self.semi_axes_m
        spectrum = fft.rfft2(heights)
        spectrum *= pressure_average(np.hypot(length * waves_along[:, None], width * waves_across))
        return waves_along, spectrum

    def _gain(self, waves: Array) -> Array:
        """Return the power gain [Pa2/m2] of waves along the track [rad/m], A-weighted.

        It is the mean over the speeds at which a choice hears.
        """
        total = np.zeros(len(waves))
        for ratio in SPEED_RATIOS:
            frequency = waves * (ratio * self.speed_m_s / (2 * np.pi))
            lowest, highest = AUDIBLE_HZ[0], min(AUDIBLE_HZ[1], self.highest_hz)
            inside = (frequency >= lowest) & (frequency <= highest)
            audible_hz = frequency[inside]
            gain = approach_gain(self.bodies, self.listener, audible_hz)
            total[inside] += gain * 10 ** (a_weighting_db(audible_hz) / 10)
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
    return response.heard(heights, surface.spacing)
