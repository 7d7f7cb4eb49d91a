"""Levels of vibration and force, with the reference values of ISO 1683.

The bands are those of sound, and no level is weighted by frequency.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array, positive, short_repr
from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.level import level_db, peak_pressure
from acoustics.resampling import fade
from acoustics.spectrum import checked_record, line_spectrum

# An octave has the third octave of its name and both neighbours; that of 20 Hz belongs to none.
OCTAVE_NAMES: tuple[str, ...] = BAND_NAMES[2::3]
"""Names of the 10 octaves by their nominal mid frequencies [Hz], "31.5" to "16000"."""
LOWEST_HZ = 10.0  # of a velocity that is integrated
_ENDS_S = 0.1  # of a record that is integrated, faded at each end
_ROUNDING = 1e-20  # share of a record's mean square that counts as rounding, as for sound


class Reference(NamedTuple):
    """Unit of a quantity, and the reference value of its levels in this unit (ISO 1683)."""

    unit: str
    value: float

    @property
    def words(self) -> str:
        """The reference as it stands behind dB, such as `re 1e-6 m/s2`."""
        return f"re 1e{math.log10(self.value):.0f} {self.unit}"


REFERENCES: dict[str, Reference] = {
    "acceleration": Reference("m/s2", 1e-6),
    "velocity": Reference("m/s", 1e-9),
    "displacement": Reference("m", 1e-12),
    "force": Reference("N", 1e-6),
    "blocked_force": Reference("N", 1e-6),
}
"""Unit and reference value of each quantity (ISO 1683:2015)."""


@dataclass(frozen=True)
class VibrationLevels:
    """Levels of one record of vibration or force; None where nothing moves or is known.

    Parameters
    ----------
    quantity : str
        acceleration, velocity, displacement, force or blocked_force.
    rms, peak : float, in the unit of the quantity
        Root of the mean square, and the maximum magnitude at and between the samples.
    level_db : float or None, dB
        Level of the whole record, without weighting.
    third_octave_db, octave_db : dict, dB
        Levels by nominal mid frequency: 31 third octaves from "20" to "20000", and 10 octaves from
        "31.5" to "16000".

    Examples
    --------
    >>> import numpy as np
    >>> import acoustics
    >>> tone = np.sqrt(2) * 10 * np.sin(2 * np.pi * 160 * np.arange(48000) / 48000)
    >>> levels = acoustics.vibration_levels(tone, 48000, "acceleration")  # 10 m/s2 rms
    >>> round(levels.level_db, 1), round(levels.third_octave_db["160"], 1)
    (140.0, 140.0)
    """

    __repr__ = short_repr

    quantity: str
    rms: float
    peak: float
    level_db: float | None
    third_octave_db: dict[str, float | None]
    octave_db: dict[str, float | None]

    @property
    def reference(self) -> Reference:
        """Unit and reference value of the levels."""
        return REFERENCES[self.quantity]


def vibration_levels(
    signal: Array, sample_rate_hz: float, quantity: str, highest_hz: float = math.inf
) -> VibrationLevels:
    """Compute the levels of one record of vibration or force, without frequency weighting.

    Parameters
    ----------
    signal : array (n,), in the SI unit of the quantity
        Record; it closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.
    quantity : str
        acceleration, velocity, displacement, force or blocked_force, which has the reference.
    highest_hz : float, Hz
        Highest frequency that the record resolves. A band that reaches above it is None.

    Returns
    -------
    VibrationLevels, dB re 1e-6 m/s2, 1e-9 m/s, 1e-12 m or 1e-6 N

    Raises
    ------
    ValueError
        The quantity is unknown, or as `acoustics.spectrum.checked_record`.

    References
    ----------
    ISO 1683:2015 for the reference values, IEC 61260-1:2014 for the bands.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import vibration_levels
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 1 m/s2 rms
    >>> levels = vibration_levels(tone, 48000, "acceleration")
    >>> round(levels.level_db, 2), round(levels.octave_db["1000"], 2), levels.reference.words
    (120.0, 120.0, 're 1e-6 m/s2')
    """
    if quantity not in REFERENCES:
        raise ValueError(f"quantity: got {quantity!r}, allowed: {', '.join(REFERENCES)}")
    record = checked_record(signal, sample_rate_hz)
    highest_hz = positive("highest_hz", highest_hz, infinite=True)
    square = REFERENCES[quantity].value ** 2
    frequency_hz, line_square = line_spectrum(record, sample_rate_hz)
    whole = float(line_square.sum())
    known = EDGES_HZ[1:] <= min(highest_hz, sample_rate_hz / 2.0)
    thirds = np.where(known, third_octave_mean_square(frequency_hz, line_square), np.nan)
    third_octave_db = {}
    for name, value in zip(BAND_NAMES, thirds.tolist(), strict=True):
        third_octave_db[name] = _level(value, whole, square)
    octave_db = {}
    for name in OCTAVE_NAMES:
        middle = BAND_NAMES.index(name)
        octave_db[name] = _level(float(thirds[middle - 1 : middle + 2].sum()), whole, square)
    return VibrationLevels(
        quantity=quantity,
        rms=math.sqrt(whole),
        peak=peak_pressure(record),
        level_db=level_db(whole, square),
        third_octave_db=third_octave_db,
        octave_db=octave_db,
    )


def _level(mean_square: float, whole: float, reference_square: float) -> float | None:
    """Return the level [dB] of a band; None for rounding and for a band that is not known."""
    if not mean_square > _ROUNDING * whole:
        return None
    return level_db(mean_square, reference_square)


def velocity_of(
    acceleration_m_s2: Array, sample_rate_hz: float, lowest_hz: float = LOWEST_HZ
) -> Array:
    """Integrate an acceleration that closes nowhere to the velocity above a frequency.

    Parameters
    ----------
    acceleration_m_s2 : array (n,), m/s2
        Acceleration.
    sample_rate_hz : float, Hz
        Sample rate.
    lowest_hz : float, Hz
        Frequency below which the velocity is left out, because drifts grow there. Default: 10 Hz.

    Returns
    -------
    array, m/s
        A tenth of a second, or an eighth of a shorter record, is faded at each end and left out.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import velocity_of
    >>> tone = np.sqrt(2) * np.cos(2 * np.pi * 100 * np.arange(48000) / 48000)  # 1 m/s2 rms
    >>> round(1e3 * float(np.sqrt(np.mean(velocity_of(tone, 48000) ** 2))), 3)  # mm/s
    1.592
    """
    record = checked_record(acceleration_m_s2, sample_rate_hz, "acceleration_m_s2")
    ends = min(round(_ENDS_S * sample_rate_hz), len(record) // 8)
    lines = np.fft.rfft(fade(record - record.mean(), ends))
    angular = 2.0 * np.pi * np.fft.rfftfreq(len(record), 1.0 / sample_rate_hz)
    is_kept = angular >= 2.0 * np.pi * lowest_hz
    velocity = np.zeros_like(lines)
    velocity[is_kept] = lines[is_kept] / (1j * angular[is_kept])
    return np.fft.irfft(velocity, len(record))[ends : len(record) - ends]
