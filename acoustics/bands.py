"""Third-octave bands from 20 Hz to 20 kHz: edges, sums of line power, uncertainty. Depends on numpy only."""

from __future__ import annotations

import numpy as np

# Nominal mid frequencies of IEC 61260-1:2014. They name the bands; they are not used to calculate.
# fmt: off
NOMINAL_HZ: tuple[float, ...] = (
    20, 25, 31.5, 40, 50, 63, 80, 100, 125, 160, 200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000, 2500, 3150,
    4000, 5000, 6300, 8000, 10000, 12500, 16000, 20000,
)
# fmt: on
BAND_NAMES: tuple[str, ...] = tuple(f"{nominal:g}" for nominal in NOMINAL_HZ)

_N = np.arange(13, 44)
MID_HZ = 10.0 ** (_N / 10.0)  # exact base-10 mid frequencies (31,)
EDGES_HZ = 10.0 ** (np.arange(25, 88, 2) / 20.0)  # band b reaches from edge b to edge b + 1 (32,)
BANDWIDTH_HZ = np.diff(EDGES_HZ)
for _constant in (MID_HZ, EDGES_HZ, BANDWIDTH_HZ):
    _constant.setflags(write=False)

AUDIBLE_HZ: tuple[float, float] = (float(EDGES_HZ[0]), float(EDGES_HZ[-1]))

# With fewer than this many independent lines in a band (B T) its level is uncertain by 2 dB or more.
LEAST_BT = 5.0


def third_octave_mean_square(frequency_hz: np.ndarray, line_mean_square: np.ndarray) -> np.ndarray:
    """Mean square in each third octave: the sum over the lines that lie in it.

    A line on an edge belongs to the band above it, so every line in ``AUDIBLE_HZ`` is counted once and the bands add up
    to the lines. Lines outside are not counted.

    Parameters
    ----------
    frequency_hz
        Frequencies of the lines (n,), Hz, in any order.
    line_mean_square
        Mean square of each line (n,), any unit.

    Returns
    -------
    Mean square per band (31,), same unit. A band without a line holds 0.
    """
    band = np.searchsorted(EDGES_HZ, frequency_hz, side="right") - 1
    inside = (band >= 0) & (band < len(NOMINAL_HZ))
    return np.bincount(band[inside], weights=np.asarray(line_mean_square)[inside], minlength=len(NOMINAL_HZ))


def band_uncertainty_db(duration_s: float) -> np.ndarray:
    """Standard uncertainty of a band level of Gaussian noise: 4.34 / sqrt(B T) dB, (31,).

    The mean square of a band of width B over a time T has the relative standard deviation 1/sqrt(B T) (Bendat and
    Piersol, Random Data, 4th ed. 2010, chapter 8); 10/ln(10) = 4.34 turns it into dB.
    """
    return 10.0 / np.log(10.0) / np.sqrt(BANDWIDTH_HZ * duration_s)


def reliable(duration_s: float) -> np.ndarray:
    """Whether each band holds enough of a record of this duration, B T >= 5, to be read as a level: bool (31,)."""
    return BANDWIDTH_HZ * duration_s >= LEAST_BT
