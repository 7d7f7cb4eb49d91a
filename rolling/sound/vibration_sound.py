"""Sound of a vibration: from the contact force in time to the sound pressure at the listener.

The contact force drives sphere and plate. Their pressures add up, with no factor left to choose, on
the axis through the contact or, over a plate with edges, at any listener. The levels belong to the
pressure at the first listener, and sound power stands beside them.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from acoustics import level, resampling, spectrum, uncertainty, wav
from acoustics.arrays import Array, short_repr
from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.radiation import RHO_C, pressure_on_axis
from acoustics.traps import ignoring_underflow
from acoustics.uncertainty import ExcessVariance
from rolling.contact.track import Motion, Travel
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.bodies import Chain
from rolling.dynamics.comb import COMB_MOST_DB, Comb
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import MAX_STEPS, BodyMotion
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.sound import edged_sound, radiators
from rolling.sound.contact_sound import ContactSound, faded, faded_out
from rolling.sound.radiators import (
    HALF,
    BaffleSpread,
    ContactLoss,
    comb,
    known_bands,
    powers,
    sources,
)
from rolling.sound.receivers import Listener

P_REF_W = 1e-12  # reference sound power
UNKNOWN_DB = 20.0  # maximum error from the time steps; an impact more or less makes it arbitrary


@ignoring_underflow
@dataclass(frozen=True, eq=False)
class Vibration:
    """Vibration of a run and its sound.

    Sound power is NaN where it is unknown: above the coincidence of a plate without a loss factor,
    for a half-space, and in bands that the steps do not resolve.

    Attributes
    ----------
    motion : BodyMotion
        Motion of sphere and plate on a fine grid of time.
    law : ForceLaw
        Contact force over approach and place.
    chain : Chain
        Linear mobilities of sphere, contact and plate.
    load : float, N
        Constant load that presses the sphere.
    closed : bool
        If true, the record repeats without a click; otherwise it is faded.
    highest : float, Hz
        Nyquist frequency of the steps at the maximum speed.
    force : (samples,) array, N
        Fluctuation of the contact force at the samples of the sound.
    pressures : (listeners, samples) array, Pa
        Sound pressure of sphere and plate.
    levels : SoundLevels, dB
        Levels of the record at the first listener.
    uncertainty : LevelUncertainty, dB
        Uncertainty of these levels, see `parts`.
    spreads : dict, dB
        Known parts of the uncertainty of LAeq: record, comb, time_step, contact_loss and, on a free
        plate, baffle.
    band_spreads : dict of (31,) arrays, dB
        The same parts of the third octaves; 0 where one is unknown.
    excess : ExcessVariance or None
        How much more the record varies than Gaussian noise; None where it is not known: in a record
        that does not repeat, and in one whose few lines in a resonance make a comb.
    mean_laeq : float or None, dB
        Mean level over speeds within 3 %; None without a comb.
    plate_power, ball_power : (31,) arrays, W
        Sound power by third octave.
    contact_loss_db : float, dB
        Change of LAeq by a loss factor of the contact of 0.02; 0 where the scene states one.
    once : bool
        If true, the record is one event, the fall of the sphere.

    Examples
    --------
    >>> import rolling
    >>> words = ["dynamics={}", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850"]
    >>> scene = rolling.read_scene("quickstart", [*words, "plate.thickness_mm=10"])
    >>> scene = scene.with_(load_n=1, duration_s=0.005, error_estimate=False)
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> run.vibration_sound.pressures.shape, f"{run.vibration_sound.load:g} N"
    ((1, 240), '1 N')
    """

    motion: BodyMotion
    law: ForceLaw
    chain: Chain
    load: float
    closed: bool
    highest: float
    force: Array
    pressures: Array
    levels: level.SoundLevels
    uncertainty: uncertainty.LevelUncertainty
    spreads: dict[str, float]
    band_spreads: dict[str, Array]
    excess: ExcessVariance | None
    mean_laeq: float | None
    plate_power: Array
    ball_power: Array
    contact_loss_db: float = 0.0
    once: bool = False

    __repr__ = short_repr

    @property
    def parts(self) -> dict[str, float]:
        """Parts of the uncertainty of LAeq [dB] whose squares add up, by their origin.

        The lines next to a sharp resonance are strong or weak by chance. This spreads the level
        over speeds as it does over seeds, so record and comb overlap: the larger counts, and the
        other is 0. The mean over the comb has no part from the record.
        """
        parts = dict(self.spreads)
        if "record" in parts and "comb" in parts:
            comb_counts = self.is_mean_of_comb or parts["comb"] > parts["record"]
            parts["record" if comb_counts else "comb"] = 0.0
        return parts

    @property
    def band_parts(self) -> dict[str, Array]:
        """Parts of the uncertainty of third octaves (31,) [dB] whose squares add up, as `parts`."""
        parts = dict(self.band_spreads)
        if "record" in parts and "comb" in parts:
            comb_counts = parts["comb"] > parts["record"]
            parts["record"] = np.where(comb_counts, 0.0, self.band_spreads["record"])
            parts["comb"] = np.where(comb_counts, self.band_spreads["comb"], 0.0)
        return parts

    @property
    def is_mean_of_comb(self) -> bool:
        """True if the comb spreads LAeq by more than 3 dB: its mean is the level that is stated."""
        spread = self.spreads.get("comb", 0.0)
        return spread > COMB_MOST_DB and self.mean_laeq is not None

    @property
    def stated_levels(self) -> level.SoundLevels:
        """Levels of the record, with the mean over the comb for LAeq if `is_mean_of_comb`."""
        if not self.is_mean_of_comb:
            return self.levels
        return replace(self.levels, laeq_db=self.mean_laeq)

    @property
    def pressure(self) -> Array:
        """Sound pressure [Pa] at the first listener."""
        return np.asarray(self.pressures[0])

    def listener_levels(self) -> list[level.SoundLevels]:
        """Return the levels of the record at each listener."""
        levels = [self.levels]
        for pressure in self.pressures[1:]:
            levels.append(
                level.sound_levels(pressure, wav.SAMPLE_RATE_HZ, self.highest, self.closed)
            )
        return levels

    @cached_property
    def force_ratio(self) -> Array:
        """Contact force over the load, at the times of the motion."""
        return self.motion.force_n / self.load

    @property
    def rms_ratio(self) -> float:
        """Rms of the fluctuation of the contact force over the load."""
        return float(np.sqrt(np.mean(np.square(self.force_ratio - 1.0))))

    @cached_property
    def force_bands(self) -> Array:
        """Rms [N] of the contact force in third octaves, NaN above the steps' resolution."""
        frequency, square = spectrum.line_spectrum(self.force, wav.SAMPLE_RATE_HZ)
        rms: Array = np.sqrt(third_octave_mean_square(frequency, square))
        return np.where(known_bands(self.highest), rms, np.nan)


def by_band(power: Array) -> dict[str, float | None]:
    """Return levels [dB re 1 pW] by nominal frequency, None for silence or an unknown power."""
    levels: dict[str, float | None] = {}
    for name, value in zip(BAND_NAMES, power.tolist(), strict=True):
        levels[name] = None
        if np.isfinite(value):
            levels[name] = level.level_db(value, P_REF_W)
    return levels


def vibrate(
    bodies: BallOnPlate,
    listener: Listener,
    travel: Travel,
    law: ForceLaw,
    highest: float,
    whole_laps: bool,
    laps: float = 1.0,
    motion: BodyMotion | None = None,
) -> Vibration:
    """Move sphere and plate over a force law, or take their known motion, and let them radiate.

    `highest` is the Nyquist frequency [Hz] of the steps at the maximum speed. The record holds
    `laps` laps of the track, whole laps of a closed track if `whole_laps`.
    """
    once = bodies.falls
    if once:  # the time steps resolve an impact, whatever the steps of the track
        highest = max(highest, wav.SAMPLE_RATE_HZ / 2)
    if motion is None:
        motion = motion_of_ball(bodies, travel, law)
    chain = bodies.chain_over(law)
    closed = whole_laps and bool(motion.settled)
    force, pressures = radiated_by_motion(bodies, listener, travel.motion, motion, closed)
    pressure = pressures[0]
    levels = level.sound_levels(pressure, wav.SAMPLE_RATE_HZ, highest, closed)
    gain = radiators.roughness_gain(bodies, listener, chain)
    combed = None
    if motion.settled and levels.laeq_db is not None:
        combed = comb(law, chain, bodies, gain, travel.fastest_m_s)
    spread = uncertainty.level_uncertainty(pressure, wav.SAMPLE_RATE_HZ, levels, False, laps=laps)
    excess = None
    if closed and combed is None and levels.laeq_db is not None:
        lap = pressure[: round(len(pressure) / max(1.0, laps))]
        excess = uncertainty.excess_variance(lap, wav.SAMPLE_RATE_HZ)
        spread = uncertainty.with_excess(spread, excess)
    spreads = dict[str, float]()
    if spread.laeq_db is not None and not once:
        spreads["record"] = spread.laeq_db
    if combed is not None:
        spreads["comb"] = combed.spread_db
    step_error_db = _step_error(bodies, listener, travel, law, motion, closed, levels.laeq_db)
    if step_error_db is not None:
        spreads["time_step"] = step_error_db
    loss = None
    if levels.laeq_db is not None:
        loss = radiators.contact_loss(law, chain, bodies, gain, travel.motion)
    if loss is not None:
        spreads["contact_loss"] = HALF * abs(loss.laeq_db)
    unbaffled = radiators.baffle_spread(bodies.plate, _weighted_squares(levels))
    if unbaffled is not None:
        spreads["baffle"] = unbaffled.laeq_db
    if once:  # an event is no sample of a noise
        known = 0.0 if spreads else None
        spread = spread.mapped(lambda _: known)
    plate_power, ball_power = powers(bodies, force, highest)
    band_spreads = _band_spreads(step_error_db, chain, combed, loss, unbaffled)
    if spread.laeq_db is not None and not once:
        of_record = [spread.third_octave_db[name] or 0.0 for name in BAND_NAMES]
        band_spreads["record"] = np.array(of_record)
    return Vibration(
        motion=motion,
        law=law,
        chain=chain,
        load=bodies.load_n,
        closed=closed,
        highest=highest,
        force=force,
        pressures=pressures,
        levels=levels,
        uncertainty=_with_other_parts(spread, spreads, band_spreads),
        spreads=spreads,
        band_spreads=band_spreads,
        excess=excess,
        mean_laeq=None if combed is None else combed.mean_laeq_db,
        plate_power=plate_power,
        ball_power=ball_power,
        contact_loss_db=0.0 if loss is None else loss.laeq_db,
        once=once,
    )


def radiated_by_motion(
    bodies: BallOnPlate,
    listener: Listener,
    along_track: Motion,
    motion: BodyMotion,
    closed: bool,
    count: int | None = None,
) -> tuple[Array, Array]:
    """Return force fluctuation [N] and pressures [Pa], (places, samples), of a motion."""
    fluctuation = force_fluctuation(bodies, motion, closed)
    return radiated(
        bodies, listener, along_track, fluctuation, 1 / motion.time_step_s, closed, count
    )


def force_fluctuation(bodies: BallOnPlate, motion: BodyMotion, closed: bool) -> Array:
    """Return the fluctuation of the contact force [N] at the time steps, faded unless closed."""
    duration = len(motion.force_n) * motion.time_step_s
    # On a smooth surface the remainder is the solver's error; a flight has no remainder.
    if (bodies.is_smooth and not bodies.falls) or motion.flight_share == 1:
        return np.zeros_like(motion.force_n)
    if bodies.falls:
        return faded_out(motion.force_n, duration)  # it begins in silence
    fluctuation = motion.force_n - bodies.load_n
    return fluctuation if closed else faded(fluctuation, duration)


def radiated(
    bodies: BallOnPlate,
    listener: Listener,
    along_track: Motion,
    fluctuation: Array,
    rate: float,
    closed: bool,
    count: int | None = None,
) -> tuple[Array, Array]:
    """Return force [N] and pressures [Pa] at first places from a force at any rate [Hz].

    The force is whole, or faded at the ends of an open record. `along_track` is distance and speed
    of the ball over time, for a contact that moves on a plate with edges. `count` is the number of
    the first places, by default all.
    """
    samples = max(2, round(len(fluctuation) / rate * wav.SAMPLE_RATE_HZ))
    force = _audible_samples(fluctuation, samples)
    if bodies.plate.with_edges is not None:
        # Without its mean, a fall would begin with a step of the force.
        whole = resampling.resample_closed(fluctuation, samples)
        return force, edged_sound.pressures(bodies, listener, along_track, whole, closed, count)
    radiating = sources(bodies, listener)
    pressure = pressure_on_axis(fluctuation, rate, radiating, listener.distance_m)
    return force, _audible_samples(pressure, samples)[None]


def _step_error(
    bodies: BallOnPlate,
    listener: Listener,
    travel: Travel,
    law: ForceLaw,
    motion: BodyMotion,
    closed: bool,
    laeq_db: float | None,
) -> float | None:
    """Return the change of LAeq by steps twice as long [dB]; None for silence or a long run-in."""
    if laeq_db is None or (motion.laps + 1) * len(motion.force_n) > MAX_STEPS:
        return None
    twice = motion_of_ball(bodies, travel, law, 2 * motion.time_step_s)
    _, pressures = radiated_by_motion(bodies, listener, travel.motion, twice, closed, count=1)
    coarse = level.sound_levels(pressures[0], wav.SAMPLE_RATE_HZ).laeq_db
    if coarse is None:
        return UNKNOWN_DB
    return min(abs(laeq_db - coarse), UNKNOWN_DB)


def _weighted_squares(levels: level.SoundLevels) -> Array:
    """Return A-weighted mean squares of the third octaves, 0 where a level is unknown, (31,)."""
    squares = np.zeros(len(BAND_NAMES))
    for k, name in enumerate(BAND_NAMES):
        level_db = levels.third_octave_a_db[name]
        if level_db is not None:
            squares[k] = 10 ** (level_db / 10)
    return squares


def _band_spreads(
    step_error_db: float | None,
    chain: Chain,
    combed: Comb | None,
    loss: ContactLoss | None,
    unbaffled: BaffleSpread | None,
) -> dict[str, Array]:
    """Return the known parts of the uncertainty of third octaves (31,) [dB], without the record's.

    Each third octave has its own comb. The time steps widen the third octave that holds the
    resonance, or all on a plate with modes. The unknown loss of the contact widens each by half its
    change, and the missing baffle of a free plate widens each.
    """
    parts: dict[str, Array] = {}
    if combed is not None:
        parts["comb"] = combed.band_spread_db
    if step_error_db is not None:
        in_step = np.ones(len(BAND_NAMES), dtype=bool)
        if chain.modes is None:
            widest = len(BAND_NAMES) - 1
            of_resonance = min(int(np.searchsorted(EDGES_HZ[1:], chain.resonance_hz)), widest)
            in_step = np.arange(len(BAND_NAMES)) == of_resonance
        parts["time_step"] = np.where(in_step, step_error_db, 0.0)
    if loss is not None:
        parts["contact_loss"] = HALF * np.abs(loss.third_octave_db)
    if unbaffled is not None:
        parts["baffle"] = unbaffled.third_octave_db
    return parts


def joined_db(record_db: ArrayLike, parts: Mapping[str, ArrayLike]) -> Array:
    """Return the uncertainty of levels [dB] from that of their record and from its other parts.

    The lines next to a sharp resonance are strong or weak by chance, which is in the part of the
    record as well as in that of the comb: the larger of the two counts.
    """
    overlapping = np.maximum(record_db, parts.get("comb", 0.0))
    square = np.square(overlapping)
    for name, part in parts.items():
        if name not in ("record", "comb"):
            square = square + np.square(part)
    return np.asarray(np.sqrt(square))


def _with_other_parts(
    spread: uncertainty.LevelUncertainty,
    spreads: dict[str, float],
    band_spreads: dict[str, Array],
) -> uncertainty.LevelUncertainty:
    """Return uncertainties [dB] of the record joined with the other parts.

    The levels of the whole have the parts of LAeq.
    """
    whole = spread.mapped(lambda db: float(joined_db(db, spreads)))
    bands: dict[str, float | None] = {}
    for k, (name, db) in enumerate(spread.third_octave_db.items()):
        bands[name] = db
        if db is not None:
            of_band = {part: values[k] for part, values in band_spreads.items()}
            bands[name] = float(joined_db(db, of_band))
    joined = replace(whole, third_octave_db=bands)
    comb_db = spreads.get("comb", 0.0)
    if comb_db > COMB_MOST_DB:  # the level is the mean over the comb, whatever the record is
        joined = replace(joined, laeq_db=float(joined_db(comb_db, spreads)))
    return joined


def with_impacts(vibration: Vibration, scatter_db: float | None) -> Vibration:
    """Return a vibration whose levels are as uncertain as the scatter of its record [dB], at least.

    What impacts make more uncertain than noise of the same spectrum is a part of its own.
    """
    before = vibration.uncertainty
    wide = uncertainty.widened(before, scatter_db)
    if not before.laeq_db or wide.laeq_db is None or wide.laeq_db <= before.laeq_db:
        return vibration
    more = math.sqrt((wide.laeq_db / before.laeq_db) ** 2 - 1)
    of_bands = np.array([before.third_octave_db[name] or 0.0 for name in BAND_NAMES])
    return replace(
        vibration,
        uncertainty=wide,
        spreads=vibration.spreads | {"impacts": more * before.laeq_db},
        band_spreads=vibration.band_spreads | {"impacts": more * of_bands},
    )


def compact_source_db(
    bodies: BallOnPlate, listener: Listener, vibrating: Vibration
) -> float | None:
    """Return the A-weighted level [dB] of a compact source with the sound power of the vibration.

    The source radiates evenly into a half-space, p^2 = rho c P / (2 pi r^2), which is the mean over
    a half sphere beyond the edges of a plate. The power of the plate depends on its loss factor, so
    None is returned without one, and for a half-space.
    """
    if not bodies.plate.loss_factor:
        return None
    weighted = level.a_weighted(vibrating.force, wav.SAMPLE_RATE_HZ)
    plate_power, ball_power = powers(bodies, weighted, vibrating.highest)
    power = np.nansum(plate_power) + (np.nansum(ball_power) if listener.hears_ball else 0.0)
    return level.level_db(float(power) * RHO_C / (2 * math.pi * listener.distance_m**2))


def sound_of_vibration(release: ContactSound, vibrating: Vibration) -> ContactSound:
    """Return the sound of a run whose source is the vibration, without steady level and factor."""
    return replace(
        release,
        source="vibration",
        pressure=vibrating.pressure,
        right=vibrating.pressures[1] if len(vibrating.pressures) > 1 else None,
        factor=None,
        closed=vibrating.closed,
        once=vibrating.once,
        levels=vibrating.stated_levels,
        uncertainty=vibrating.uncertainty,
        steady_level=None,
        steady_uncertainty=None,
    )


def _audible_samples(signal: Array, samples: int) -> Array:
    """Return a closed record at the samples of the sound, within hearing."""
    return resampling.band_limit(resampling.resample_closed(signal, samples), wav.SAMPLE_RATE_HZ)
