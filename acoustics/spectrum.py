"""Line spectra of a whole record: mean squares that add up, and the line level of Lee, Kim & Kim (2025).

Depends on numpy and the A-weighting.
"""

from __future__ import annotations

import numpy as np

from acoustics.radiation import I_REF_W_M2, intensity
from acoustics.weighting import a_weighting_db


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
        If the record is empty, not one-dimensional, or holds a value that is not finite.
    """
    lines = _lines(signal)
    mean_square = np.square(lines.real) + np.square(lines.imag)
    mean_square[_paired(len(signal))] *= 2.0
    return np.fft.rfftfreq(len(signal), 1.0 / sample_rate_hz), mean_square


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
        As `line_spectrum`.

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
    if np.ndim(signal) != 1 or len(signal) == 0:
        raise ValueError(f"a record is a series of at least one sample, got an array of shape {np.shape(signal)}")
    if not np.all(np.isfinite(signal)):
        raise ValueError("the record holds values that are not finite")
    return np.fft.rfft(signal) / len(signal)


def _paired(n: int) -> slice:
    """The lines whose mirror image at negative frequency rfft leaves out: all but 0 Hz and, for even n, Nyquist."""
    return slice(1, (n + 1) // 2)
