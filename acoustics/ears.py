"""Roughness and prominence of tones of a sound by the package mosqito, which is imported on use."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.loudness import heard_fluctuation

# Two windows of 0.2 s, so that a record is no single window.
MIN_ROUGHNESS_S = 0.4
# Lines of 1 Hz or less: the screening for tones takes the lines of a shorter loop for tones.
MIN_TONES_S = 1.0


def roughness_asper(pressure_pa: Array, sample_rate_hz: float) -> float | None:
    """Compute the roughness of a record with mosqito: `roughness_dw`.

    The record is read once. It is the mean over windows of 0.2 s that overlap by half.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Calibrated sound pressure.
    sample_rate_hz : float, Hz. Sample rate, at least 48 kHz.

    Returns
    -------
    float or None, asper
        0 for silence; None for a record of less than 0.4 s.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.

    References
    ----------
    P. Daniel and R. Weber, Psychoacoustical roughness: implementation of an optimized model,
    Acustica 83 (1997) 113-123. 1 asper is a tone of 1 kHz and 60 dB, all modulated by 70 Hz.
    """
    record = heard_fluctuation(pressure_pa, sample_rate_hz)
    if not record.any():
        return 0.0
    if len(record) < MIN_ROUGHNESS_S * sample_rate_hz:
        return None
    from mosqito.sq_metrics import roughness_dw

    roughness, _, _, _ = roughness_dw(record, sample_rate_hz, overlap=0.5)
    return float(np.mean(roughness))


@dataclass(frozen=True)
class Tone:
    """The tone of a record that stands out most, by one method.

    Parameters
    ----------
    decibels : float, dB. Tone-to-noise ratio, or prominence ratio.
    frequency_hz : float, Hz. Frequency of the tone.
    is_prominent : bool. Whether it is prominent by the criterion of ECMA-418-1.
    """

    decibels: float
    frequency_hz: float
    is_prominent: bool


@dataclass(frozen=True)
class Tones:
    """The tones of a record that stand out most; None where no tone is found.

    Parameters
    ----------
    tone_to_noise : Tone or None. By the tone-to-noise ratio.
    prominence : Tone or None. By the prominence ratio.
    """

    tone_to_noise: Tone | None
    prominence: Tone | None


def tones(pressure_pa: Array, sample_rate_hz: float) -> Tones | None:
    """Find the tones that stand out most with mosqito: `tnr_ecma_st` and `pr_ecma_st`.

    Tones from 89.1 Hz to 11.2 kHz are found. The record is read once.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Calibrated sound pressure of a steady sound.
    sample_rate_hz : float, Hz. Sample rate, at least 48 kHz.

    Returns
    -------
    Tones, or None for a record of less than 1 s, whose lines are too wide

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.

    References
    ----------
    ECMA-418-1:2022, tone-to-noise ratio and prominence ratio.
    """
    record = heard_fluctuation(pressure_pa, sample_rate_hz)
    if not record.any():
        return Tones(None, None)
    if len(record) < MIN_TONES_S * sample_rate_hz:
        return None
    from mosqito.sq_metrics import pr_ecma_st, tnr_ecma_st

    return Tones(
        tone_to_noise=_largest(tnr_ecma_st(record, sample_rate_hz, prominence=False)),
        prominence=_largest(pr_ecma_st(record, sample_rate_hz, prominence=False)),
    )


def _largest(columns: tuple[Any, Any, Any, Any]) -> Tone | None:
    """Return the tone with the largest ratio of those that mosqito found."""
    _, ratios, prominent, frequencies = columns
    ratio = np.atleast_1d(np.asarray(ratios, dtype=float))
    if not ratio.size:
        return None
    number = int(np.argmax(ratio))
    return Tone(
        decibels=float(ratio[number]),
        frequency_hz=float(np.atleast_1d(frequencies)[number]),
        is_prominent=bool(np.atleast_1d(prominent)[number]),
    )
