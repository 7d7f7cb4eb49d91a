"""The stretch of a longer record that fits a shorter one: by waveform, or by third octaves.

A recording holds a run and silence before and after it, or it was cut shorter than the run.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics import resampling
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BANDWIDTH_HZ, EDGES_HZ, third_octave_mean_square
from acoustics.wav import SAMPLE_RATE_HZ as RATE

EQUAL = 0.05  # relative difference of lengths up to which whole records are compared
PARTS = 3  # of a stretch, whose levels are compared one by one
FRAMES = 4  # of a part, by which a stretch is moved
STEADY_DB = 3.0  # largest change of the level of a record that counts as steady
SEEN_DB = 30.0  # below its loudest band, in which bands of the shorter record decide
MIN_LINES = 3.0  # of a frame in a band that decides
# The largest of many coefficients of unlike noise, sqrt(2 ln N) of their standard deviation, is
# exceeded by this factor where two records hold the same waveform.
SIGNIFICANT = 2.0
# The median of the absolute values of Gaussian numbers over their standard deviation.
_MEDIAN_OVER_DEVIATION = 0.6745


class Stretch(NamedTuple):
    """Stretch of the longer records that fits the shorter ones.

    first, length : int. First sample and number of samples.
    coefficient : float or None. Largest cross-correlation of a pair of waveforms; None where they
        are unlike, and the third octaves decided.
    is_reversed : tuple of bool. Whether the sign of each record is reversed.
    """

    first: int
    length: int
    coefficient: float | None
    is_reversed: tuple[bool, ...] = ()


def fitting_stretch(
    longer: Sequence[Array], shorter: Sequence[Array], highest_hz: float
) -> Stretch | None:
    """Find the stretch of longer records that fits shorter ones.

    Parameters
    ----------
    longer, shorter : sequences of arrays, any unit
        Records at 48 kHz: the channels of a recording and those of a run, pair by pair. All of a
        sequence have the same length.
    highest_hz : float, Hz
        Highest frequency that both resolve.

    Returns
    -------
    stretch : Stretch or None. None where the lengths are nearly equal, or where the longer records
        are steady and hold another waveform: then all of them tells more than any stretch.
    """
    count = len(shorter[0])
    if len(longer[0]) <= (1 + EQUAL) * count:
        return None
    band_hz = (AUDIBLE_HZ[0], min(AUDIBLE_HZ[1], highest_hz))
    limited = [resampling.band_limit(record, RATE, band_hz) for record in longer]
    targets = [resampling.band_limit(record, RATE, band_hz) for record in shorter]
    by_waveform = _by_waveform(limited, targets, highest_hz)
    if by_waveform is not None:
        return by_waveform
    frame = count // (PARTS * FRAMES)
    bands = [_frame_bands(record, frame) for record in limited]
    if all(_is_steady(squares) for squares in bands):
        return None
    seen = (BANDWIDTH_HZ * frame / RATE >= MIN_LINES) & (EDGES_HZ[1:] <= highest_hz)
    if not seen.any():
        return None
    misfits = [
        _misfit(squares, _frame_bands(target, frame), seen)
        for squares, target in zip(bands, targets, strict=True)
    ]
    first = int(np.argmin(np.sum(misfits, axis=0))) * frame
    return Stretch(first=first, length=count, coefficient=None)


def _by_waveform(
    longer: Sequence[Array], shorter: Sequence[Array], highest_hz: float
) -> Stretch | None:
    """Return the stretch whose waveform is that of the shorter records; None if none is.

    All third octaves count alike line by line: a resonance, which looks the same one period later,
    does not decide alone.
    """
    whitened = np.array(
        [
            _coefficients(_whitened(a, highest_hz), _whitened(b, highest_hz))
            for a, b in zip(longer, shorter, strict=True)
        ]
    )
    joined = np.sqrt(np.mean(np.square(whitened), axis=0))
    first = int(np.argmax(joined))
    deviation = float(np.median(joined)) / _MEDIAN_OVER_DEVIATION
    unlike = deviation * math.sqrt(2 * math.log(max(len(joined), 2)))
    if joined[first] < SIGNIFICANT * unlike:
        return None
    length = len(shorter[0])
    stretches = [record[first : first + length] for record in longer]
    values = [float(_coefficients(a, b)[0]) for a, b in zip(stretches, shorter, strict=True)]
    return Stretch(
        first=first,
        length=length,
        coefficient=float(np.max(np.abs(values))),
        is_reversed=tuple(bool(value < 0) for value in whitened[:, first]),
    )


def _whitened(record: Array, highest_hz: float) -> Array:
    """Return a record whose third octaves below a frequency have the same density, others none."""
    lines = np.fft.rfft(record)
    frequency = np.fft.rfftfreq(len(record), 1 / RATE).astype(float)
    band = np.searchsorted(EDGES_HZ, frequency, side="right") - 1
    is_known = (band >= 0) & (band < len(BANDWIDTH_HZ)) & (frequency <= highest_hz)
    squares = np.bincount(band[is_known], np.square(np.abs(lines[is_known])), len(BANDWIDTH_HZ))
    counts = np.bincount(band[is_known], minlength=len(BANDWIDTH_HZ))
    density = squares / np.maximum(counts, 1)
    gain = np.zeros(len(BANDWIDTH_HZ))
    gain[density > 0] = 1 / np.sqrt(density[density > 0])
    whitened = np.zeros_like(lines)
    whitened[is_known] = lines[is_known] * gain[band[is_known]]
    return np.fft.irfft(whitened, len(record))


def _coefficients(longer: Array, shorter: Array) -> Array:
    """Return the normalized cross-correlation at each place of a shorter record in a longer one."""
    lines = len(longer) + len(shorter)
    products = np.fft.irfft(
        np.fft.rfft(longer, lines) * np.conj(np.fft.rfft(shorter, lines)), lines
    )
    places = len(longer) - len(shorter) + 1
    energy = np.concatenate(([0.0], np.cumsum(np.square(longer))))
    of_stretch = energy[len(shorter) :] - energy[:places]
    # Silence has no waveform. Its rounding is kept from counting as one.
    of_stretch = np.maximum(of_stretch, 1e-6 * energy[-1] * len(shorter) / len(longer))
    whole = float(np.square(shorter).sum())
    if whole <= 0.0 or energy[-1] <= 0.0:
        return np.zeros(places)
    return np.asarray(products[:places] / np.sqrt(of_stretch * whole))


def _frame_bands(record: Array, frame: int) -> Array:
    """Return the mean squares of third octaves of each frame of a record, (frames, 31)."""
    count = len(record) // frame
    frames = record[: count * frame].reshape(count, frame) * np.hanning(frame)
    squares = np.square(np.abs(np.fft.rfft(frames, axis=1)))
    frequency = np.fft.rfftfreq(frame, 1 / RATE).astype(float)
    return np.array([third_octave_mean_square(frequency, square) for square in squares])


def _part_levels(squares: Array, frames: int) -> Array:
    """Return the levels [dB] of third octaves of `frames` frames from each frame on."""
    sums = np.concatenate((np.zeros((1, squares.shape[1])), np.cumsum(squares, axis=0)))
    floor = 1e-12 * squares.max()
    return np.asarray(10 * np.log10(np.maximum(sums[frames:] - sums[:-frames], floor)))


def _is_steady(squares: Array) -> bool:
    """Tell whether stretches of a record have nearly the same level."""
    levels = _part_levels(squares.sum(axis=1, keepdims=True), PARTS * FRAMES)
    return bool(np.ptp(levels) <= STEADY_DB)


def _misfit(longer: Array, shorter: Array, seen: NDArray[np.bool_]) -> Array:
    """Return the mean square difference [dB^2] of levels at each place, apart from their mean.

    The gain of a recording may be unknown, so that the shape of the third octaves over the parts of
    a stretch decides, and the level stays a result of the comparison.
    """
    target = _part_levels(shorter, FRAMES)[::FRAMES][:PARTS]
    is_counted = seen & (target.max(axis=0) >= target[:, seen].max() - SEEN_DB)
    levels = _part_levels(longer, FRAMES)
    places = len(longer) - PARTS * FRAMES + 1
    parts = [levels[part * FRAMES : part * FRAMES + places] for part in range(PARTS)]
    difference = np.stack(parts, axis=1)[:, :, is_counted] - target[:, is_counted]
    return np.asarray(difference.var(axis=(1, 2)))
