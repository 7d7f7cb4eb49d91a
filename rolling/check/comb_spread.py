"""Comb of a short lap before the run: how far the place of a sharp resonance spreads the level.

The lines of the approach follow from the statistics of the surface, or from the heights of a file
along the track, averaged with the pressure of the contact. The linear chain with the stiffness of a
smooth contact carries them to the listener.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from acoustics.arrays import Array
from acoustics.loss_factors import least_loss_factor
from acoustics.numbers import rounded, si
from acoustics.radiation import axis_transfer
from acoustics.weighting import a_weighting_db
from rolling.check.finding import Finding
from rolling.check.force_estimate import SHARED, contact_axes
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.bodies import Chain
from rolling.dynamics.comb import (
    BROAD,
    COMB_MOST_DB,
    MOST_SPEEDS,
    NEAR_SPEEDS,
    speeds_of_comb,
    spread_db,
)
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.in_si.scene_surface import heights
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.scene import Scene
from rolling.scene.sections import loss_text
from rolling.scene.surfaces import HeightFile
from rolling.sound.radiators import sources
from rolling.sound.receivers import Listener
from rolling.surface.contact_average import asperity_density, averaged_density
from rolling.surface.height_law import HeightSpectrum

KEY = "comb"  # of the finding
_SPEEDS_OF_MODES = 20  # a plate with modes is slow to compute
_FEWEST_STEPS = 8  # of a lap
_DRAWS = 16  # random strengths of the lines of a law
_WAVES = 300  # at which the density of a law is computed
_NAME = "comb of the lap"


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Warn of a track that is so short that one undamped resonance decides the level."""
    if not _repeats(scene):
        return
    lap_m = _lap_m(scene)
    chain = bodies_of(scene).smooth_chain
    speed = scene.motion.fastest(scene.duration)
    spread = comb_spread_db(scene, chain, lap_m, speed)
    if spread is None:
        yield Finding(KEY, _NAME, "none: the resonance holds several lines, or nothing is heard")
        return
    near = f"{100 * NEAR_SPEEDS:g} %"
    value = f"LAeq spreads by about {rounded(spread)} dB over speeds within {near}"
    yield Finding(KEY, _NAME, value)
    if spread > COMB_MOST_DB:
        yield Doubt(
            KEY,
            f"{_NAME}: the track is so short that one undamped resonance decides the level, so "
            f"LAeq will be given as the mean over speeds within {near}",
            Severity.DO_NOT_QUOTE,
            advice=_advice(scene, chain, lap_m, speed),
        )


def _lap_m(scene: Scene) -> float:
    """Return the length [m] after which the surface repeats; long steps may repeat later."""
    if _is_file_alone(scene):
        return scene.track.plate_nodes * scene.track.spacing
    return scene.track.lap_steps * scene.track.step


def _is_file_alone(scene: Scene) -> bool:
    """Tell whether the heights of the plate are a file, and the sphere is smooth."""
    return isinstance(scene.surface, HeightFile) and scene.sphere.surface is None


def _repeats(scene: Scene) -> bool:
    """Tell whether a vibration may repeat from lap to lap, so that its force has lines."""
    return (
        scene.sound.source == "vibration"
        and scene.track.closed
        and scene.motion.is_constant(scene.duration)
        and not scene.is_one_event
        and len(scene.plate.contact_ends_mm) < 2
        and not scene.is_smooth
        and scene.track.lap_steps >= _FEWEST_STEPS
    )


@dataclass(frozen=True, kw_only=True)
class HeardLap:
    """A lap as it is heard: all that the spread takes beside the heights, which runs may share.

    Attributes
    ----------
    chain : Chain
        Ball, contact and plate.
    bodies : BallOnPlate
        The bodies that radiate.
    listener : Listener
        Who hears them.
    axes_m : (2,) tuple of float, m
        Semi-axes of the contact of the rough surface, along and across.
    length_m : float, m
        Length of the lap.
    speed_m_s : float, m/s
        Highest speed.
    """

    chain: Chain
    bodies: BallOnPlate
    listener: Listener
    axes_m: tuple[float, float]
    length_m: float
    speed_m_s: float


@dataclass(frozen=True, kw_only=True)
class LawsOfLap:
    """Random heights of a lap by their laws, which know no seed.

    Attributes
    ----------
    laws : tuple of HeightSpectrum
        Laws of the random heights of plate and sphere.
    spacing_m : float, m
        Distance of nodes.
    steps : int
        Steps of the lap.
    """

    laws: tuple[HeightSpectrum, ...]
    spacing_m: float
    steps: int


def comb_spread_db(scene: Scene, chain: Chain, lap_m: float, speed: float) -> float | None:
    """Return the rms difference of LAeq at near speeds from its mean [dB]; None without a comb.

    It is the median over random strengths of the lines.
    """
    lap = HeardLap(
        chain=chain,
        bodies=bodies_of(scene),
        listener=listener_of(scene),
        axes_m=contact_axes(scene),
        length_m=lap_m,
        speed_m_s=speed,
    )
    if _is_file_alone(scene):  # whose lines are known
        return _spread_over_speeds(lap, _lines(lap, _lines_of_heights(scene), strengths=None))
    if not scene.laws:
        return None
    laws = LawsOfLap(
        laws=tuple(law.in_si for law in scene.laws),
        spacing_m=scene.spacing,
        steps=scene.track.lap_steps,
    )
    return spread_of_laws(lap, laws)


@lru_cache(maxsize=SHARED)
def spread_of_laws(lap: HeardLap, laws: LawsOfLap) -> float | None:
    """Return the rms difference of LAeq at near speeds [dB] of a lap over random heights."""
    expected = _lines_of_laws(lap, laws)
    return _spread_over_speeds(lap, _lines(lap, expected, strengths=_strengths(len(expected))))


def _spread_over_speeds(lap: HeardLap, lines: Array) -> float | None:
    """Return the rms difference of LAeq at near speeds [dB] of lines (draws, lines)."""
    chain = lap.chain
    speeds = speeds_of_comb(
        chain=chain,
        lines=lines.mean(axis=0),
        line_hz=lap.speed_m_s / lap.length_m,
        loss_factor=least_loss_factor(lap.bodies.plate.loss_factor or 0.0),
        gain=lambda frequency: _weighted_gain(lap, frequency),
        most_speeds=MOST_SPEEDS if chain.modes is None else _SPEEDS_OF_MODES,
    )
    if speeds is None:
        return None
    sums = np.array([lines[:, at.audible] @ at.gain for at in speeds])
    if not sums.min() > 0:
        return None
    return float(np.median([spread_db(sums_of_draw) for sums_of_draw in sums.T]))


def _strengths(count: int) -> Array:
    """Return random strengths of lines (draws, lines)."""
    return np.random.default_rng(0).exponential(size=(_DRAWS, count))


def _lines(lap: HeardLap, linear: Array, strengths: Array | None) -> Array:
    """Return mean squares of the lines of the approach over a lap, (draws, lines), to one factor.

    `linear` (lines,) are those of the heights that the contact averages; without `strengths` they
    are known. The lines of the asperities are random.
    """
    waves: Array = 2 * math.pi / lap.length_m * np.arange(1.0, len(linear) + 1)
    tail = linear.sum() * asperity_density(waves, lap.axes_m[0]) * (2 * math.pi / lap.length_m)
    if strengths is None:
        return np.asarray(np.maximum(linear, tail * _strengths(len(linear))))
    return np.asarray(np.maximum(linear * strengths, tail * strengths))


def _lines_of_laws(lap: HeardLap, laws: LawsOfLap) -> Array:
    """Return the expected mean squares of the lines of the heights that the contact averages."""
    count = laws.steps // 2
    waves = np.asarray(2 * math.pi / lap.length_m * np.arange(1, count + 1), dtype=float)
    coarse = np.geomspace(waves[0], waves[-1], min(count, _WAVES))
    densities = [averaged_density(law, coarse, lap.axes_m, laws.spacing_m) for law in laws.laws]
    return np.asarray(np.interp(np.log(waves), np.log(coarse), np.sum(densities, axis=0)))


def _lines_of_heights(scene: Scene) -> Array:
    """Return the mean squares of the lines of the heights that the contact averages."""
    from scipy.special import j1  # slow to import

    z = heights(scene)
    spacing = scene.spacing
    length, width = contact_axes(scene)
    steps = len(z)
    middle = z.shape[1] // 2
    wave = 2 * math.pi * np.fft.rfftfreq(steps, spacing)[1:]
    reach = min(int(width / spacing), middle)
    total = np.zeros(len(wave), dtype=complex)
    for row in range(-reach, reach + 1):
        # An ellipsoid of pressure over this row is a half ellipse, whose transform is a J1.
        height = math.sqrt(max(1 - (row * spacing / width) ** 2, 0.0))
        q = np.maximum(wave * (length * height), 1e-9)
        total += np.fft.rfft(z[:, (middle + row) % z.shape[1]])[1:] * (height**2 * 2 * j1(q) / q)
    lines: Array = np.square(np.abs(total))
    return lines / max(float(lines.max()), 1e-300)


def _weighted_gain(lap: HeardLap, frequency: Array) -> Array:
    """Return A-weighted power at the first listener per mean square of the approach."""
    force = lap.chain.force(frequency, np.ones(len(frequency)))
    plate = lap.bodies.plate.with_edges
    listener = lap.listener
    if plate is None:
        bodies = sources(lap.bodies, listener)
        parts = [axis_transfer(frequency, body, listener.distance_m) for body in bodies]
        transfer = np.sum(parts, axis=0)
    else:
        (contact,) = lap.bodies.plate.points_between_ends(1)
        transfer = plate.pressure_transfer(frequency, contact, listener.places_m[0], 0.0)
    weight = 10 ** (a_weighting_db(frequency) / 10)
    return np.asarray(weight * np.square(np.abs(transfer * force)))


def _advice(scene: Scene, chain: Chain, lap_m: float, speed: float) -> str:
    """Name the keys that make the resonance broader than the lines of the lap."""
    ways = []
    if scene.plate.edges_mm is None:
        ways.append(
            "set plate.contact_loss_factor to the damping of the contact (such as 0.02), which is "
            f"{rounded(scene.plate.contact_loss_factor or 0.0)} now"
        )
        if scene.plate.thickness_mm is None:
            ways.append(
                "give plate.thickness_mm, because a half-space hardly damps the sphere and a plate "
                "that bends does"
            )
        else:
            ways.append(f"choose a plate.thickness_mm below {scene.plate.thickness_mm:g}")
    else:
        ways.append(
            "set plate.loss_factor to the damping of the plate as it is mounted, which is "
            f"{loss_text(scene.plate.loss_factor or 0.0)} now, and plate.contact_loss_factor to "
            f"that of the contact, which is {rounded(scene.plate.contact_loss_factor or 0.0)} now"
        )
    if math.isfinite(chain.quality) and scene.plate.edges_mm is None:
        least = BROAD * speed * chain.quality / chain.resonance_hz
        longer = f"{si(least, 'm')} instead of {si(lap_m, 'm')}"
    else:
        longer = f"longer than {si(lap_m, 'm')}"
    if isinstance(scene.surface, HeightFile):
        ways.append(f"measure a longer track ({longer})")
    else:
        key = "duration_s" if scene.rolling.distance_mm is None else "distance_mm"
        ways.append(f"choose a longer track by rolling.{key} ({longer})")
    return "; or ".join(ways)
