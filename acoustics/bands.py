"""Third-octave bands from 20 Hz to 20 kHz: edges, sums of line power, uncertainty."""

import math

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, real_array, refuse_masked, within

# Nominal mid frequencies of IEC 61260-1:2014. They name the bands; they are not used to calculate.
# fmt: off
NOMINAL_HZ: tuple[float, ...] = (
    20, 25, 31.5, 40, 50, 63, 80, 100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250,
    1600, 2000, 2500, 3150, 4000, 5000, 6300, 8000, 10000, 12500, 16000, 20000,
)
# fmt: on
BAND_NAMES: tuple[str, ...] = tuple(f"{nominal:g}" for nominal in NOMINAL_HZ)
"""Names of the 31 bands by their nominal mid frequencies [Hz], "20" to "20000"."""

_N = np.arange(13, 44)
MID_HZ = 10.0 ** (_N / 10.0)
"""Exact base-10 mid frequencies (31,) [Hz]."""
EDGES_HZ = 10.0 ** (np.arange(25, 88, 2) / 20.0)
"""Edges (32,) [Hz]; band b reaches from edge b to edge b + 1."""
BANDWIDTH_HZ = np.diff(EDGES_HZ)
for _constant in (MID_HZ, EDGES_HZ, BANDWIDTH_HZ):
    _constant.setflags(write=False)

AUDIBLE_HZ: tuple[float, float] = (float(EDGES_HZ[0]), float(EDGES_HZ[-1]))

# With fewer independent lines in a band (B T) its level is uncertain by 2 dB or more.
MIN_BT = 5.0
MIN_DURATION_S = 1e-12  # of a record
MAX_DURATION_S = 1e12  # of a record
MIN_ROOM_DB = -20.0  # of a third octave of the noise of a room
MAX_ROOM_DB = 120.0  # of a third octave of the noise of a room
# A band whose level is off by more is marked in plots and tables [dB].
OFF_DB = 1.0


def third_octave_mean_square(frequency_hz: Array, line_mean_square: Array) -> Array:
    """Sum the mean squares of the lines in each third octave.

    A line on an edge belongs to the band above it. Every line in ``AUDIBLE_HZ`` is therefore
    counted once, and the sum of the bands equals the sum of the lines. Lines outside are not
    counted.

    Parameters
    ----------
    frequency_hz : array (n,), Hz
        Frequencies of the lines, in any order.
    line_mean_square : array (n,), any unit
        Mean square of each line.

    Returns
    -------
    array (31,), same unit
        Mean square per band; a band without a line holds 0.

    Raises
    ------
    ValueError
        The frequencies are no finite numbers, or not as many as the mean squares.

    References
    ----------
    IEC 61260-1:2014, 5.4 and 5.6, for mid and edge frequencies.

    Examples
    --------
    >>> from acoustics import BAND_NAMES, third_octave_mean_square
    >>> bands = third_octave_mean_square([990.0, 1010.0, 2000.0], [1.0, 2.0, 4.0])
    >>> float(bands[BAND_NAMES.index("1000")]), float(bands.sum())
    (3.0, 7.0)
    """
    if isinstance(frequency_hz, np.ndarray) and frequency_hz.size == 0 == np.size(line_mean_square):
        return np.zeros(len(NOMINAL_HZ))  # no line is audible
    lines = real_array("frequency_hz", frequency_hz, 1)
    refuse_masked("line_mean_square", line_mean_square)
    weights = real_array("line_mean_square", line_mean_square, 1, gaps=True)
    if weights.shape != lines.shape:
        got = f"got an array of shape {weights.shape}"
        raise ValueError(f"line_mean_square: {got}, allowed: that of frequency_hz, {lines.shape}")
    band = np.searchsorted(EDGES_HZ, lines, side="right") - 1
    inside = (band >= 0) & (band < len(NOMINAL_HZ))
    sums = np.bincount(band[inside], weights=weights[inside], minlength=len(NOMINAL_HZ))
    return np.asarray(sums, dtype=float)


def band_uncertainty_db(duration_s: float) -> Array:
    """Return the standard uncertainty of band levels of Gaussian noise, 4.34 / sqrt(B T) dB.

    The mean square of a band of width B over a time T has the relative standard deviation
    1/sqrt(B T). The factor 10/ln(10) = 4.34 converts it to dB.

    Parameters
    ----------
    duration_s : float, s
        Duration T of the record.

    Returns
    -------
    array (31,), dB

    References
    ----------
    Bendat and Piersol, Random Data, 4th ed. 2010, chapter 8.

    Examples
    --------
    >>> from acoustics import BAND_NAMES, band_uncertainty_db
    >>> round(float(band_uncertainty_db(1.0)[BAND_NAMES.index("1000")]), 2)
    0.29
    """
    duration_s = within("duration_s", duration_s, MIN_DURATION_S, MAX_DURATION_S)
    independent_lines = BANDWIDTH_HZ * duration_s
    return np.asarray(10.0 / np.log(10.0) / np.sqrt(independent_lines))


def reliable(duration_s: float) -> NDArray[np.bool_]:
    """Return for each band whether a record is long enough for its level, B T >= 5.

    Parameters
    ----------
    duration_s : float, s
        Duration T of the record.

    Returns
    -------
    array (31,) of bool

    Examples
    --------
    >>> from acoustics import BAND_NAMES, reliable
    >>> first = int(reliable(0.5).argmax())  # bands widen upwards
    >>> BAND_NAMES[first]
    '50'
    """
    duration_s = within("duration_s", duration_s, MIN_DURATION_S, MAX_DURATION_S)
    return np.asarray(BANDWIDTH_HZ * duration_s >= MIN_BT)


def nearest_nominal(frequency_hz: float) -> float:
    """Return the nominal mid frequency nearest to a frequency by their ratio [Hz]."""
    if not frequency_hz > 0:
        return NOMINAL_HZ[0]
    if math.isinf(frequency_hz):
        return NOMINAL_HZ[-1]
    return min(NOMINAL_HZ, key=lambda nominal: abs(math.log(nominal / frequency_hz)))
