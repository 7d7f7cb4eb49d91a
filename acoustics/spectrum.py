"""Spectra of a record: lines of the whole that add up, their mean density (Welch), the line level of Lee, Kim & Kim (2025).

Depends on numpy, scipy and the A-weighting.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import signal as scipy_signal

from acoustics.radiation import I_REF_W_M2, intensity
from acoustics.weighting import a_weighting_db

_PSD_LINE_HZ = 10.0
_LEAST_SEGMENT = 16


@dataclass(frozen=True)
class Psd:
    """Power spectral density of a record, one-sided.

    frequency_hz (n,), psd (n,) [unit of the record squared per Hz], window : its name. line_width_hz : distance of the
    lines. enbw_hz : equivalent noise bandwidth of a line; a tone's mean square is its line's density times this.
    """

    frequency_hz: np.ndarray
    psd: np.ndarray
    window: str
    line_width_hz: float
    enbw_hz: float


def check_record(signal: np.ndarray) -> None:
    """Refuse what is no record (n,) of any unit.

    Raises
    ------
    ValueError
        If it is empty, not one-dimensional, or holds a value that is not finite.
    """
    if np.ndim(signal) != 1 or len(signal) == 0:
        raise ValueError(f"a record is a series of at least one sample, got an array of shape {np.shape(signal)}")
    if not np.all(np.isfinite(signal)):
        raise ValueError("the record holds values that are not finite")


def line_spectrum(signal: np.ndarray, sample_rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of each spectral line; their sum is mean(signal**2) (Parseval).

    Rectangular window: the record is taken to close on itself, or to be faded.

    Parameters
    ----------
    signal
        Record (n,), any unit.
    sample_rate_hz
        Sample rate, Hz.

    Returns
    -------
    frequency_hz, line_mean_square
        One-sided lines from 0 Hz up (n//2 + 1,), a line width of sample_rate/n apart; the unit of the signal squared.

    Raises
    ------
    ValueError
        As `check_record`.
    """
    lines = _lines(signal)
    mean_square = np.square(lines.real) + np.square(lines.imag)
    mean_square[_paired(len(signal))] *= 2.0
    return np.fft.rfftfreq(len(signal), 1.0 / sample_rate_hz), mean_square


def welch(signal: np.ndarray, sample_rate_hz: float) -> Psd:
    """Power spectral density by Welch's method: Hann window, segments overlapping by half, no mean taken off.

    Lines 10 Hz apart, or farther in a record of less than 0.4 s: a segment is a quarter of it at most, so that seven are
    averaged and a line of noise is uncertain by 1.7 dB or less. Never fewer than 16 samples in a segment, or all there
    are. What fills no segment at the end is left out.

    Parameters
    ----------
    signal
        Record (n,), any unit: Pa for a density in Pa^2/Hz.
    sample_rate_hz
        Sample rate, Hz.

    Raises
    ------
    ValueError
        As `check_record`.

    References
    ----------
    Welch, IEEE Transactions on Audio and Electroacoustics 1967, 15(2), 70-73. Harris, Proceedings of the IEEE 1978,
    66(1), 51-83, for the equivalent noise bandwidth.
    """
    check_record(signal)
    segment = min(round(sample_rate_hz / _PSD_LINE_HZ), len(signal) // 4)
    segment = min(max(segment, _LEAST_SEGMENT), len(signal))
    window = scipy_signal.get_window("hann", segment)
    frequency_hz, psd = scipy_signal.welch(
        signal, sample_rate_hz, window=window, noverlap=segment // 2, detrend=False, scaling="density"
    )
    return Psd(
        frequency_hz=frequency_hz,
        psd=psd,
        window="hann",
        line_width_hz=sample_rate_hz / segment,
        enbw_hz=equivalent_noise_bandwidth(window, sample_rate_hz),
    )


def equivalent_noise_bandwidth(window: np.ndarray, sample_rate_hz: float) -> float:
    """Width in Hz of the rectangle that passes as much white noise as a line behind this window (n,): 1.5 lines of Hann."""
    return sample_rate_hz * float(np.sum(np.square(window)) / np.sum(window) ** 2)


def article_line_level_db(
    power_w: np.ndarray, sample_rate_hz: float, distance_m: float, q: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """A-weighted level of each line as the article plots it: 10 lg(q |E'^(f)| / (S I_ref)) + A(f).

    |E'^(f)| is the single-sided amplitude of the line of the release power in watts, S = 4 pi r^2. **The level depends
    on the length of the record**: the lines of a noise fall by 5 dB when it becomes ten times as long (an amplitude
    falls with the square root of the line width and is read here as a power), a tone stays. State duration and line
    width wherever it is shown. It is a second view of the power; no sound pressure has this spectrum.

    Parameters
    ----------
    power_w
        Release power (n,), W.
    sample_rate_hz
        Sample rate, Hz.
    distance_m
        Distance r, m.
    q
        Share of the release power that is radiated.

    Returns
    -------
    frequency_hz, level_db
        Lines above 0 Hz (n//2,) and their levels in dB re 1e-12 W/m^2; -inf where a line is zero.

    Raises
    ------
    ValueError
        As `check_record`.

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equations (10) and (11).
    """
    amplitude_w = np.abs(_lines(power_w))
    amplitude_w[_paired(len(power_w))] *= 2.0
    frequency_hz = np.fft.rfftfreq(len(power_w), 1.0 / sample_rate_hz)[1:]
    with np.errstate(divide="ignore"):
        level_db = 10.0 * np.log10(intensity(amplitude_w[1:], distance_m, q) / I_REF_W_M2)
    return frequency_hz, level_db + a_weighting_db(frequency_hz)


def _lines(signal: np.ndarray) -> np.ndarray:
    """Complex lines divided by the length of the record."""
    check_record(signal)
    return np.fft.rfft(signal) / len(signal)


def _paired(n: int) -> slice:
    """The lines whose mirror image at negative frequency rfft leaves out: all but 0 Hz and, for even n, Nyquist."""
    return slice(1, (n + 1) // 2)
