"""Levels of a record with their uncertainties: third octaves, totals, and octaves of modulation.

They have the reference values of ISO 1683, their uncertainties are standard uncertainties.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics import level, spectrum, uncertainty
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, band_uncertainty_db, third_octave_mean_square
from acoustics.modulation import envelope_spectrum
from acoustics.radiation import P_REF_PA
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.recordings.recorded import FAINTEST, PRESSURE, MeasuredQuantity, Recording

CLEAR_DB = 3.0  # least level of a recording above its background
MODULATION_HZ = 2.0 ** np.arange(8)  # mid frequencies of octaves of modulation
TOTALS = ("LAeq", "LZeq", "all bands")  # names of total levels, of which the first counts
_HANN = 1.5  # sum of the squared lines of a tone in a Hann window
_DB = 10.0 / math.log(10.0)


class Bands(NamedTuple):
    """Levels of third octaves and their standard uncertainty [dB], (31,); NaN is unknown."""

    level_db: Array
    a_weighted_db: Array
    uncertainty_db: Array

    def only(self, known: NDArray[np.bool_]) -> Bands:
        """Return the bands of a mask, all others NaN."""
        return Bands(
            level_db=np.where(known, self.level_db, np.nan),
            a_weighted_db=np.where(known, self.a_weighted_db, np.nan),
            uncertainty_db=np.where(known, self.uncertainty_db, np.nan),
        )

    def weighted(self, weighting: str) -> Array:
        """Return the levels with a weighting, A or Z."""
        return self.a_weighted_db if weighting == "A" else self.level_db


class Total(NamedTuple):
    """Total level of the third octaves that are compared, and its weighting."""

    name: str
    weighting: str


def totals_of(quantity: MeasuredQuantity) -> list[Total]:
    """Return the total levels of a quantity; the first is made equal without a calibration."""
    if quantity is PRESSURE:
        return [Total(TOTALS[0], "A"), Total(TOTALS[1], "Z")]
    return [Total(TOTALS[2], "Z")]


def third_octave_levels(
    record: Recording, seconds: float | None = None, excess: Array | float = 1.0
) -> Bands:
    """Return the levels of third octaves of a record, NaN if silent.

    The uncertainty is that of noise of a duration [s], by default of a lap, whose variance exceeds
    that of Gaussian noise by the factor `excess`. It is joined with the part of the scatter of the
    total level between thirds that noise rarely has: all bands rise and fall.
    """
    samples = record.samples
    laps = len(samples) / RATE / (seconds or record.seconds)
    levels = level.sound_levels(samples, RATE, record.highest, closed=False)
    noise = uncertainty.level_uncertainty(samples, RATE, levels, False, laps)
    # A sharp resonance leaves fewer independent lines in a band than its width does.
    frequency, square = spectrum.line_spectrum(samples, RATE)
    sums = third_octave_mean_square(frequency, square)
    squares = third_octave_mean_square(frequency, square**2)
    with np.errstate(under="ignore"):
        of_lines = _DB * np.sqrt(laps * squares / 2) / np.where(sums > 0, sums, np.nan)
    # A level that rises and falls couples neighbouring lines: a band has no more than its B T.
    of_length = band_uncertainty_db(len(samples) / RATE / laps)
    of_noise = np.maximum(np.fmax(_by_band(noise.third_octave_db), of_lines), of_length)
    of_noise *= np.sqrt(excess)
    total_db = noise.laeq_db if record.quantity.weighting == "A" else noise.level_db
    beyond = max(0.0, record.scatter_db**2 - 9 * (total_db or 0.0) ** 2)
    # Levels of sound have the reference value of sound pressure.
    shift_db = 20 * math.log10(P_REF_PA / record.quantity.reference)
    return Bands(
        level_db=_by_band(levels.third_octave_db) + shift_db,
        a_weighted_db=_by_band(levels.third_octave_a_db) + shift_db,
        uncertainty_db=np.sqrt(of_noise**2 + beyond),
    )


def _by_band(levels: Mapping[str, float | None]) -> Array:
    """Return levels of third octaves by name as an array, NaN in place of None."""
    return np.array([levels[name] for name in BAND_NAMES], dtype=float)


def without_background(noise: Bands, recorded: Bands) -> Bands:
    """Subtract the background from a recording; bands that are not clearly above become NaN.

    They are 3 dB above it, and by twice the standard uncertainty of the distance: in a band of few
    lines one noise is easily 3 dB above another.
    """
    noise_db = np.nan_to_num(noise.level_db, nan=-400.0)
    spread_db = np.hypot(recorded.uncertainty_db, np.nan_to_num(noise.uncertainty_db))
    clear_db = np.maximum(CLEAR_DB, 2 * spread_db)
    share = 10 ** ((noise_db - recorded.level_db) / 10)
    net = np.where(recorded.level_db - noise_db >= clear_db, 1 - share, np.nan)
    of_noise = share * np.nan_to_num(noise.uncertainty_db)
    return Bands(
        level_db=recorded.level_db + 10 * np.log10(net),
        a_weighted_db=recorded.a_weighted_db + 10 * np.log10(net),
        uncertainty_db=np.hypot(recorded.uncertainty_db, of_noise) / net,
    )


class ComparedLevels(NamedTuple):
    """Levels of third octaves, totals and octaves of modulation, one after the other [dB]."""

    levels_db: Array
    uncertainties_db: Array


def all_levels(record: Recording, bands: Bands, octave: tuple[float, float]) -> ComparedLevels:
    """Return the levels of third octaves, their totals, and the modulation of an octave [Hz]."""
    totals_db = []
    totals_uncertainty_db = []
    for total in totals_of(record.quantity):
        power = 10 ** (bands.weighted(total.weighting) / 10)
        whole = np.nansum(power)
        spread = np.sqrt(np.nansum(np.square(power * bands.uncertainty_db)))
        totals_db.append(10 * np.log10(whole))
        # The bands of impacts rise and fall together.
        totals_uncertainty_db.append(max(spread / whole, record.scatter_db))
    modulation_db, modulation_uncertainty_db = _modulation(record, octave)
    return ComparedLevels(
        levels_db=np.hstack([bands.level_db, totals_db, modulation_db]),
        uncertainties_db=np.hstack(
            [bands.uncertainty_db, totals_uncertainty_db, modulation_uncertainty_db]
        ),
    )


def _modulation(record: Recording, band: tuple[float, float]) -> tuple[Array, Array]:
    """Return octaves of the modulation of a band, re full modulation, and their uncertainty [dB].

    They are NaN where the record is too short, or the band too narrow.
    """
    envelope = envelope_spectrum(record.samples, RATE, band)
    low = MODULATION_HZ / 2**0.5
    octaves = np.searchsorted(low, envelope.frequency_hz)  # 0 below the first
    squares = np.bincount(octaves, np.square(envelope.modulation), len(low) + 1)[1:] / _HANN
    levels_db = 10 * np.log10(np.maximum(squares, FAINTEST))
    uncertainties_db = _DB / np.sqrt(low * record.seconds)
    is_known = (low * record.seconds >= 2) & (4 * low <= band[1] - band[0])
    return np.where(is_known, levels_db, np.nan), np.where(is_known, uncertainties_db, np.nan)
