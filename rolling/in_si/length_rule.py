"""Length that `rolling.duration_s: auto` or `distance_mm: auto` takes, from the values of a scene.

The spectrum follows from the law of the surface: the contact averages the heights, and ball,
contact and plate carry them to the listener as a linear chain. Nothing is marched, so the length
does not depend on the machine, and a stored run has the one that it began with.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.loss_factors import least_loss_factor
from rolling.contact.track import MIN_NODES
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.bodies import Chain
from rolling.in_si.assumed_bodies import with_bodies
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.scene import grid_error
from rolling.scene.scene import Scene
from rolling.scene.surfaces import turn_nodes
from rolling.scene.values_in_si import SceneQuantities
from rolling.sound.needed_record import (
    ExpectedVibration,
    Need,
    longest_need,
    needed_record,
    two_digits_up,
)
from rolling.sound.radiators import roughness_gain
from rolling.sound.receivers import Listener
from rolling.surface.contact_average import asperity_density, averaged_density, rough_axes
from rolling.surface.height_law import HeightSpectrum

CORRELATION_LENGTHS = 50.0  # of the surface along the track, at least
CONTACT_LENGTHS = 10.0  # of the rough contact along the track, at least
MOST_NODES = 100_000  # of the surface along the track, unless a floor needs more
# Variance [dB2] that few asperities add to the level of a track of a correlation length under a
# contact of this semi-axis or a smaller one; it falls with the asperities that carry. It was fitted
# to 8 scenes of tests/benchmarks/length_study.py from draw 500 on, and judged on those from 0 on.
UNEVEN_DB2 = 80.0
_FREQUENCIES = 4000
_WIDTHS = 20.0  # of a resonance on both sides, which _NEAR frequencies resolve
_NEAR = 401
_WAVES = 200
_NOTHING = 1e-300  # spectral density [m3] of a surface that the contact averages out


class LengthNumbers(NamedTuple):
    """What the rule takes of a scene, as plain numbers in SI.

    bodies : BallOnPlate. Ball and plate that vibrate.
    listener : Listener. Who hears them.
    laws : tuple. Laws of the random heights of plate and ball.
    semi_axes_m : pair of float, m. Of the rough contact, along and across.
    correlation_m : float, m. Longest correlation length.
    spacing_m, step_m : float, m. Of nodes and of steps, as far as the scene states them.
    speed_m_s : float, m/s. Speed.
    turn_m : float, m. Circumference of a ball with a surface of its own; 0 without one.
    way_m : float, m. Way to and fro of a contact that moves on a plate with edges; 0 without one.
    within_db : float, dB. Wanted uncertainty of LAeq.
    """

    bodies: BallOnPlate
    listener: Listener
    laws: tuple[HeightSpectrum, ...]
    semi_axes_m: tuple[float, float]
    correlation_m: float
    spacing_m: float
    step_m: float
    speed_m_s: float
    turn_m: float
    way_m: float
    within_db: float


def needed_length(scene: SceneQuantities) -> Need:
    """Return the time [s] that a scene needs whose length is `auto`, with the reason."""
    assert isinstance(scene, Scene)  # which adds rules to the quantities
    return _need(numbers_of(scene))


def numbers_of(scene: Scene) -> LengthNumbers:
    """Return what the rule takes of a scene; one without dynamics gets the usual bodies."""
    described = scene if scene.dynamics is not None else with_bodies(scene)
    bodies = bodies_of(described)
    given = scene.numerics.step_nodes
    turn = 0.0
    if scene.sphere.surface is not None:
        turn = turn_nodes(scene.sphere.radius_mm, scene.spacing_um) * scene.spacing
    way = 0.0
    if bodies.plate.has_path:
        way = 2 * math.dist(*bodies.plate.contact_ends_m)
    return LengthNumbers(
        bodies=bodies,
        listener=listener_of(described),
        laws=tuple(law.in_si for law in scene.laws),
        semi_axes_m=rough_axes(
            semi_axes_m=bodies.contact.semi_axes_m(),
            radii_m=(scene.radius, scene.radius_across),
            rq_m=grid_error.law_roughness(scene)[0],
        ),
        correlation_m=1e-6 * max(max(law.lengths_um) for law in scene.laws),
        spacing_m=scene.spacing,
        step_m=scene.spacing * (1.0 if isinstance(given, str) else given),
        speed_m_s=scene.motion.speeds[0],
        turn_m=turn,
        way_m=way,
        within_db=scene.numerics.within_db,
    )


@lru_cache(maxsize=256)
def _need(numbers: LengthNumbers) -> Need:
    """Return the time [s] that a scene with these numbers needs, with the reason."""
    speed = numbers.speed_m_s
    most_s = two_digits_up(MOST_NODES * numbers.spacing_m / speed)
    length, _ = numbers.semi_axes_m
    floors = [
        (MIN_NODES * numbers.spacing_m, f"{MIN_NODES} nodes"),
        (
            CORRELATION_LENGTHS * numbers.correlation_m,
            f"{CORRELATION_LENGTHS:g} correlation lengths of the surface",
        ),
        (2 * length * CONTACT_LENGTHS, f"{CONTACT_LENGTHS:g} lengths of the contact"),
    ]
    if numbers.way_m:
        floors.append((numbers.way_m, "the way of the contact to and fro"))
    needs = [Need(two_digits_up(metres / speed), reason) for metres, reason in floors]
    need = longest_need(
        [needed_record(expected_vibration(numbers), numbers.within_db, most_s), *needs]
    )
    if not numbers.turn_m:
        return need
    turns = math.ceil(need.seconds * speed / numbers.turn_m - 1e-9)
    noun = "turn" if turns == 1 else "turns"
    return Need(
        turns * numbers.turn_m / speed, f"{turns} whole {noun} of the ball, for {need.reason}"
    )


def expected_vibration(numbers: LengthNumbers) -> ExpectedVibration:
    """Return the spectrum that the linear chain expects a listener to hear."""
    speed = numbers.speed_m_s
    highest = min(AUDIBLE_HZ[1], speed / (2 * numbers.step_m))
    lowest = min(AUDIBLE_HZ[0], 0.5 * highest)
    chain = numbers.bodies.smooth_chain
    frequency = _frequencies(chain, lowest, highest)
    heights = _height_density(numbers, 2 * math.pi * frequency / speed) * 2 * math.pi / speed
    resonance_hz = chain.resonance_hz
    quality = chain.quality
    density = heights * approach_gain(numbers.bodies, numbers.listener, frequency)
    if chain.modes is not None:
        # The modes about the middle of the power are the narrowest that carry it.
        power_up_to = np.cumsum(density * np.gradient(frequency))
        place = int(np.searchsorted(power_up_to, power_up_to[-1] / 2))
        resonance_hz = float(frequency[min(place, len(frequency) - 1)])
        quality = 1 / least_loss_factor(numbers.bodies.plate.loss_factor or 1.0)
    return ExpectedVibration(
        frequency_hz=frequency,
        density=density,
        resonance_hz=resonance_hz,
        quality=quality,
        uneven_db2_s=_uneven_db2_m(numbers) / speed,
    )


def _frequencies(chain: Chain, lowest: float, highest: float) -> Array:
    """Return frequencies [Hz] over a band that resolve the resonance of the ball on its contact."""
    wide = np.geomspace(lowest, highest, _FREQUENCIES)
    if not math.isfinite(chain.quality):
        return wide
    width = chain.resonance_hz / chain.quality
    near = chain.resonance_hz + width * np.linspace(-_WIDTHS, _WIDTHS, _NEAR)
    inside = near[(near > lowest) & (near < highest)]
    return np.unique(np.concatenate((wide, inside)))


def _uneven_db2_m(numbers: LengthNumbers) -> float:
    """Return the variance [dB2 m] that few asperities add to a level, times the length of track."""
    length, _ = numbers.semi_axes_m
    across = min(1.0, numbers.correlation_m / length)
    return UNEVEN_DB2 * across**2 * numbers.correlation_m


def _height_density(numbers: LengthNumbers, waves: Array) -> Array:
    """Return the one-sided density [m3] of the approach over wave numbers [rad/m]."""
    length, _ = numbers.semi_axes_m

    def averaged(along: Array) -> Array:
        """Return the one-sided density of the heights that the contact averages."""
        parts = [
            averaged_density(law, along, numbers.semi_axes_m, numbers.spacing_m)
            for law in numbers.laws
        ]
        return np.asarray(2 * np.sum(parts, axis=0))

    coarse = np.geomspace(waves[0], waves[-1], _WAVES)
    logarithms = np.log(np.maximum(averaged(coarse), _NOTHING))
    own = np.exp(np.interp(np.log(waves), np.log(coarse), logarithms))
    every = np.geomspace(1e-4 / length, math.pi / numbers.spacing_m, _WAVES)
    whole = float(np.trapezoid(averaged(every), every))
    return np.asarray(np.maximum(own, whole * asperity_density(waves, length)))


def approach_gain(bodies: BallOnPlate, listener: Listener, frequency: Array) -> Array:
    """Return the power gain [Pa2/m2] from an approach to the pressure at frequencies [Hz].

    It is that of the chain with a smooth contact, on a plate without its edges. The modes of a
    plate with edges enter by the force, and by the power that enters the plate there. Where they
    lie counts for sums over frequencies, and not where the listener stands.
    """
    chain = bodies.smooth_chain
    if chain.modes is None:
        return roughness_gain(bodies, listener, chain)(frequency)
    endless = replace(bodies, plate=replace(bodies.plate, sides_m=None, contact_ends_m=()))
    own = chain.mobilities(frequency)["plate"].real
    return roughness_gain(endless, listener, chain)(frequency) * np.maximum(own, 0.0)
