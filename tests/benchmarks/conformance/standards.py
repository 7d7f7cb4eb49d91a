"""Tables of IEC 61672-1:2013 and IEC 61260-1:2014, class 1.

The limits are acceptance limits on the deviation from the design goal. The editions of 2013 and
2014 leave out the uncertainty of a testing laboratory, which the tolerance limits of earlier
editions included. A computed deviation therefore compares with them directly.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class WeightingRow(NamedTuple):
    """A-weighting at the exact frequency 10**(n/10) Hz, in dB except n and nominal_hz."""

    n: int
    nominal_hz: float
    a_db: float
    lower_db: float
    upper_db: float


class BurstRow(NamedTuple):
    """Response to a 4 kHz tone burst relative to the steady tone, dB, with limits.

    The Slow response is None below 2 ms.
    """

    duration_ms: float
    fast_db: float
    fast_lower_db: float
    exposure_db: float
    slow_db: float | None
    slow_lower_db: float | None
    upper_db: float


class DecayRow(NamedTuple):
    """Rate at which the level falls after a steady tone ends, with limits, dB/s."""

    weighting: str
    rate_db_s: float
    lower_db_s: float
    upper_db_s: float


class AttenuationRow(NamedTuple):
    """Minimum and maximum relative attenuation of an octave-band filter, dB.

    They hold at f/f_mid = G**exponent.
    """

    exponent: float
    min_db: float
    max_db: float


_NONE = float("inf")

# IEC 61672-1:2013, Table 3, column A and class 1. With a lower limit of minus infinity only the
# upper limit applies.
A_WEIGHTING: tuple[WeightingRow, ...] = (
    WeightingRow(10, 10, -70.4, -_NONE, 3.0),
    WeightingRow(11, 12.5, -63.4, -_NONE, 2.5),
    WeightingRow(12, 16, -56.7, -4.0, 2.0),
    WeightingRow(13, 20, -50.5, -2.0, 2.0),
    WeightingRow(14, 25, -44.7, -1.5, 2.0),
    WeightingRow(15, 31.5, -39.4, -1.5, 1.5),
    WeightingRow(16, 40, -34.6, -1.0, 1.0),
    WeightingRow(17, 50, -30.2, -1.0, 1.0),
    WeightingRow(18, 63, -26.2, -1.0, 1.0),
    WeightingRow(19, 80, -22.5, -1.0, 1.0),
    WeightingRow(20, 100, -19.1, -1.0, 1.0),
    WeightingRow(21, 125, -16.1, -1.0, 1.0),
    WeightingRow(22, 160, -13.4, -1.0, 1.0),
    WeightingRow(23, 200, -10.9, -1.0, 1.0),
    WeightingRow(24, 250, -8.6, -1.0, 1.0),
    WeightingRow(25, 315, -6.6, -1.0, 1.0),
    WeightingRow(26, 400, -4.8, -1.0, 1.0),
    WeightingRow(27, 500, -3.2, -1.0, 1.0),
    WeightingRow(28, 630, -1.9, -1.0, 1.0),
    WeightingRow(29, 800, -0.8, -1.0, 1.0),
    WeightingRow(30, 1000, 0.0, -0.7, 0.7),
    WeightingRow(31, 1250, 0.6, -1.0, 1.0),
    WeightingRow(32, 1600, 1.0, -1.0, 1.0),
    WeightingRow(33, 2000, 1.2, -1.0, 1.0),
    WeightingRow(34, 2500, 1.3, -1.0, 1.0),
    WeightingRow(35, 3150, 1.2, -1.0, 1.0),
    WeightingRow(36, 4000, 1.0, -1.0, 1.0),
    WeightingRow(37, 5000, 0.5, -1.5, 1.5),
    WeightingRow(38, 6300, -0.1, -2.0, 1.5),
    WeightingRow(39, 8000, -1.1, -2.5, 1.5),
    WeightingRow(40, 10000, -2.5, -3.0, 2.0),
    WeightingRow(41, 12500, -4.3, -5.0, 2.0),
    WeightingRow(42, 16000, -6.6, -16.0, 2.5),
    WeightingRow(43, 20000, -9.3, -_NONE, 3.0),
)

# IEC 61672-1:2013, 5.9 and Table 4. Design goals are equations (7), 10 lg(1 - exp(-Tb/tau)), and
# (8), 10 lg(Tb/1 s), as the table rounds them; the sound exposure level shares the limits of the
# Fast maximum.
TONE_BURSTS: tuple[BurstRow, ...] = (
    BurstRow(1000, 0.0, -0.5, 0.0, -2.0, -0.5, 0.5),
    BurstRow(500, -0.1, -0.5, -3.0, -4.1, -0.5, 0.5),
    BurstRow(200, -1.0, -0.5, -7.0, -7.4, -0.5, 0.5),
    BurstRow(100, -2.6, -1.0, -10.0, -10.2, -1.0, 1.0),
    BurstRow(50, -4.8, -1.0, -13.0, -13.1, -1.0, 1.0),
    BurstRow(20, -8.3, -1.0, -17.0, -17.0, -1.5, 1.0),
    BurstRow(10, -11.1, -1.0, -20.0, -20.0, -2.0, 1.0),
    BurstRow(5, -14.1, -1.0, -23.0, -23.0, -2.5, 1.0),
    BurstRow(2, -18.0, -1.5, -27.0, -27.0, -3.0, 1.0),
    BurstRow(1, -21.0, -2.0, -30.0, None, None, 1.0),
    BurstRow(0.5, -24.0, -2.5, -33.0, None, None, 1.0),
    BurstRow(0.25, -27.0, -3.0, -36.0, None, None, 1.0),
)

# IEC 61672-1:2013, 5.8.2: a steady 4 kHz tone suddenly ends.
DECAY_RATES: tuple[DecayRow, ...] = (DecayRow("F", 34.7, -3.7, 3.8), DecayRow("S", 4.3, -0.7, 0.8))

# IEC 61672-1:2013, 5.8.3: a steady 1 kHz tone reads alike with S, averaged over time, and F.
STEADY_LIMIT_DB = 0.1

# IEC 61260-1:2014, 5.10 and Table 1, class 1, side above the mid-band frequency. The first row at
# the exponent 1/2 is just inside the band edge, the second just outside.
OCTAVE_ATTENUATION: tuple[AttenuationRow, ...] = (
    AttenuationRow(0.0, -0.4, 0.4),
    AttenuationRow(1 / 8, -0.4, 0.5),
    AttenuationRow(1 / 4, -0.4, 0.7),
    AttenuationRow(3 / 8, -0.4, 1.4),
    AttenuationRow(1 / 2, -0.4, 5.3),
    AttenuationRow(1 / 2, 1.2, _NONE),
    AttenuationRow(1.0, 16.6, _NONE),
    AttenuationRow(2.0, 40.5, _NONE),
    AttenuationRow(3.0, 60.0, _NONE),
    AttenuationRow(4.0, 70.0, _NONE),
)

# IEC 61260-1:2014, 5.12, class 1.
EFFECTIVE_BANDWIDTH_LIMIT_DB = 0.4

# IEC 61260-1:2014, 5.2 and 5.3.
OCTAVE_RATIO = 10.0 ** (3.0 / 10.0)
REFERENCE_HZ = 1000.0

# ISO 3, series R10: the digits by which IEC 61260-1:2014, annex E, and ISO 266 name third octaves.
_R10 = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)


def third_octave_mid_hz(x: int) -> float:
    """Return the exact mid-band frequency of the band x third octaves above 1 kHz, Hz.

    The formula is IEC 61260-1:2014, 5.4.
    """
    return float(REFERENCE_HZ * OCTAVE_RATIO ** (x / 3.0))


def third_octave_edge_hz(x: int, side: int) -> float:
    """Return the band-edge frequency below (side -1) or above (side 1) the mid-band frequency, Hz.

    The formula is IEC 61260-1:2014, 5.6.
    """
    return float(third_octave_mid_hz(x) * OCTAVE_RATIO ** (side / 6.0))


def third_octave_nominal_hz(x: int) -> float:
    """Return the nominal mid-band frequency, Hz (IEC 61260-1:2014, annex E)."""
    decade, step = divmod(x, 10)
    return float(np.round(_R10[step] * REFERENCE_HZ * 10.0**decade, 6))


def third_octave_frequency_ratio(exponent: float) -> float:
    """Return f/f_mid of a third octave that corresponds to G**exponent of an octave; exponent >= 0.

    G is the octave ratio. The side below the mid-band frequency has the reciprocal
    (IEC 61260-1:2014, 5.10.3 and 5.10.4, formulas (9), (10)).
    """
    scale = (OCTAVE_RATIO ** (1.0 / 6.0) - 1.0) / (OCTAVE_RATIO**0.5 - 1.0)
    return float(1.0 + scale * (OCTAVE_RATIO**exponent - 1.0))
