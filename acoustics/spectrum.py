"""Spectra of a record: lines that add up, densities, spectrograms, and the article's lines.

The article is Lee, Kim & Kim (2025).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array, positive, real_array, short_repr, within
from acoustics.bands import AUDIBLE_HZ
from acoustics.radiation import I_REF_W_M2, P_REF_PA, intensity
from acoustics.weighting import a_weighting_db

MIN_RATE_HZ = 1e-6  # of samples
MAX_RATE_HZ = 1e12  # of samples
_PSD_LINE_HZ = 10.0
_MIN_SEGMENT = 16

Band = tuple[float, float]

# Edges of base-10 twelfth octaves: four to each third octave of acoustics.bands, whose edges are
# among them (125,).
ROW_EDGES_HZ = 10.0 ** (np.arange(50, 175) / 40.0)
ROW_EDGES_HZ.setflags(write=False)

_MAX_FRAMES = 400
FRAME_S = 0.04  # of a spectrogram of a sound
_FRAMES_IN_RECORD = 12.5  # 40 ms in 0.5 s; a shorter record has shorter frames
_HOPS_IN_FRAME = 16
_MIN_FRAME = 16
_ROUNDING = 1e-20  # share of the maximum density, as for levels


@dataclass(frozen=True)
class Psd:
    """One-sided power spectral density of a record.

    Parameters
    ----------
    frequency_hz : array (n,), Hz
        Frequencies of the lines.
    psd : array (n,), unit of the record squared per Hz
        Density.
    window : str
        Name of the window.
    line_width_hz : float, Hz
        Distance of the lines.
    enbw_hz : float, Hz
        Equivalent noise bandwidth of a line. A tone's mean square is the density of its line times
        this bandwidth.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> tone = np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)
    >>> density = acoustics.welch(tone, 48000)
    >>> round(float(density.psd.max() * density.enbw_hz), 6)
    0.5
    """

    __repr__ = short_repr

    frequency_hz: Array
    psd: Array
    window: str
    line_width_hz: float
    enbw_hz: float


def band_edges(band_hz: Sequence[float], sample_rate_hz: float) -> Band:
    """Return the edges of a band [Hz]; raise ValueError unless they rise from 0 Hz."""
    edges = real_array("band_hz", band_hz, 1)
    half = positive("sample_rate_hz", sample_rate_hz) / 2.0
    if len(edges) != 2 or not 0.0 <= edges[0] < min(edges[1], half):
        raise ValueError(
            f"band_hz: got {tuple(band_hz)}, allowed: two edges that rise from 0 to {half:g} Hz"
        )
    return float(edges[0]), float(edges[1])


def checked_record(record: ArrayLike, sample_rate_hz: float, name: str = "signal") -> Array:
    """Return a record (n,) as an array of floats; refuse others, and rates outside the limits.

    Raises
    ------
    ValueError
        If the record is empty, not one-dimensional, or holds a value that is not finite, or if the
        sample rate lies outside 1e-6 to 1e12 Hz.
    """
    within("sample_rate_hz", sample_rate_hz, MIN_RATE_HZ, MAX_RATE_HZ)
    return real_array(name, record, 1)


def line_spectrum(signal: Array, sample_rate_hz: float) -> tuple[Array, Array]:
    """Compute the mean square of each spectral line.

    Their sum is mean(signal**2) by Parseval's theorem. The window is rectangular, so the record
    must close on itself or be faded.

    Parameters
    ----------
    signal : array (n,), any unit
        Record.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    frequency_hz : array (n//2 + 1,), Hz
        Frequencies from 0 Hz up, sample_rate/n apart.
    line_mean_square : array (n//2 + 1,), unit of the record squared
        One-sided mean squares.

    Raises
    ------
    ValueError
        As `checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import line_spectrum
    >>> frequency, mean_square = line_spectrum(np.sin(2 * np.pi * np.arange(8) / 8), 8)
    >>> float(frequency[1]), round(float(mean_square[1]), 9), round(float(mean_square.sum()), 9)
    (1.0, 0.5, 0.5)
    """
    frequency_hz, lines = _lines(signal, sample_rate_hz)
    mean_square: Array = np.square(lines.real) + np.square(lines.imag)
    mean_square[1 : (len(signal) + 1) // 2] *= 2.0
    return frequency_hz, mean_square


def audible_lines(signal: Array, sample_rate_hz: float) -> tuple[Array, Array]:
    """Return frequencies [Hz] and mean squares of the lines of a record from 20 Hz to 20 kHz."""
    frequency_hz, mean_square = line_spectrum(signal, sample_rate_hz)
    audible = (frequency_hz >= AUDIBLE_HZ[0]) & (frequency_hz < AUDIBLE_HZ[1])
    return frequency_hz[audible], mean_square[audible]


def audible_phasors(signal: Array, sample_rate_hz: float) -> tuple[Array, NDArray[np.complex128]]:
    """Return frequencies [Hz] and Fourier coefficients of a record from 20 Hz to 20 kHz.

    Twice the square of a coefficient is the mean square of its line, below the Nyquist frequency.
    """
    frequency_hz, lines = _lines(signal, sample_rate_hz)
    audible = (frequency_hz >= AUDIBLE_HZ[0]) & (frequency_hz < AUDIBLE_HZ[1])
    return frequency_hz[audible], lines[audible]


def welch(signal: Array, sample_rate_hz: float) -> Psd:
    """Compute the power spectral density by Welch's method with Hann windows that overlap by half.

    The lines are 10 Hz apart, or farther in a record of less than 0.4 s. A segment is at most a
    quarter of the record, so that at least seven are averaged and a line of noise is uncertain by
    1.7 dB or less. A segment has at least 16 samples, or all of the record. The mean is not
    subtracted. Samples at the end that fill no segment are left out.

    Parameters
    ----------
    signal : array (n,), any unit
        Record; Pa gives a density in Pa^2/Hz.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    Psd

    Raises
    ------
    ValueError
        As `checked_record`.

    References
    ----------
    Welch, IEEE Transactions on Audio and Electroacoustics 1967, 15(2), 70-73. Harris, Proceedings
    of the IEEE 1978, 66(1), 51-83, for the equivalent noise bandwidth.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import welch
    >>> density = welch(np.random.default_rng(1).standard_normal(48000), 48000)  # 1 Pa, to 24 kHz
    >>> density.line_width_hz, round(density.enbw_hz, 6)
    (10.0, 15.0)
    >>> round(float(density.psd.sum() * density.line_width_hz), 1)
    1.0
    """
    record = checked_record(signal, sample_rate_hz)
    segment = min(round(sample_rate_hz / _PSD_LINE_HZ), len(record) // 4)
    segment = min(max(segment, _MIN_SEGMENT), len(record))
    window = hann(segment)
    step = segment - segment // 2
    firsts = range(0, len(record) - segment + 1, step)
    total = np.zeros(segment // 2 + 1)
    for first in firsts:
        total += _frame_density(record[first : first + segment], window, sample_rate_hz)
    frequency_hz = np.asarray(np.fft.rfftfreq(segment, 1.0 / sample_rate_hz), dtype=float)
    return Psd(
        frequency_hz=frequency_hz,
        psd=total / len(firsts),
        window="hann",
        line_width_hz=sample_rate_hz / segment,
        enbw_hz=equivalent_noise_bandwidth(window, sample_rate_hz),
    )


def hann(length: int) -> Array:
    """Return a Hann window of so many samples, whose next sample would be its first one.

    That of a single sample is 1. It is written out, because `scipy.signal` takes half a second to
    import.
    """
    if length == 1:
        return np.ones(1)
    angle = np.linspace(-np.pi, np.pi, length + 1)[:-1]
    window: Array = 0.5 + 0.5 * np.cos(angle)
    return window


def _frame_density(frames: Array, window: Array, sample_rate_hz: float) -> Array:
    """Return the one-sided densities of frames (..., n), each times a window (n,)."""
    lines = np.fft.rfft(frames * window)
    density: Array = np.square(lines.real) + np.square(lines.imag)
    density[..., 1 : (len(window) + 1) // 2] *= 2.0
    return density / (sample_rate_hz * np.sum(window**2))


def equivalent_noise_bandwidth(window: Array, sample_rate_hz: float) -> float:
    """Return the equivalent noise bandwidth of a line of this window [Hz].

    It is the width of a rectangle that passes as much white noise, 1.5 lines for a Hann window.

    Parameters
    ----------
    window : array (n,). Window.
    sample_rate_hz : float, Hz. Sample rate.
    """
    return sample_rate_hz * float(np.sum(np.square(window)) / np.sum(window) ** 2)


def article_line_level_db(
    power_w: Array, sample_rate_hz: float, distance_m: float, q: float = 1.0
) -> tuple[Array, Array]:
    """Return the A-weighted line levels of the article, 10 lg(q |E'^(f)| / (S I_ref)) + A(f).

    |E'^(f)| is the single-sided amplitude of a line of the release power in watts; S = 4 pi r^2.
    **The level depends on the length of the record**: the lines of a noise fall by 5 dB when the
    record becomes ten times as long, because an amplitude falls with the square root of the line
    width and is treated here as a power. The line of a tone stays. State duration and line width
    beside it. This spectrum shows the power and is not the spectrum of a sound pressure.

    Parameters
    ----------
    power_w : array (n,), W. Release power.
    sample_rate_hz : float, Hz. Sample rate.
    distance_m : float, m. Distance r.
    q : float. Share of the release power that is radiated. Default 1.

    Returns
    -------
    frequency_hz : array (n//2,), Hz
        Frequencies of the lines above 0 Hz.
    level_db : array (n//2,), dB re 1e-12 W/m^2
        Levels of the lines; -inf where a line is zero.

    Raises
    ------
    ValueError
        As `checked_record`.

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equations (10) and (11).
    """
    frequency_hz, lines = _lines(power_w, sample_rate_hz)
    frequency_hz = frequency_hz[1:]
    amplitude_w = np.abs(lines[1:])
    amplitude_w[: (len(power_w) - 1) // 2] *= 2.0  # all but Nyquist
    with np.errstate(divide="ignore"):
        level_db = 10.0 * np.log10(intensity(amplitude_w, distance_m, q) / I_REF_W_M2)
    return frequency_hz, level_db + a_weighting_db(frequency_hz)


def _lines(signal: Array, sample_rate_hz: float) -> tuple[Array, NDArray[np.complex128]]:
    """Return frequencies [Hz] and complex lines divided by the length of the record.

    All lines but 0 Hz and, of an even number of samples, Nyquist have a mirror image.
    """
    record = checked_record(signal, sample_rate_hz)
    frequency_hz = np.fft.rfftfreq(len(record), 1.0 / sample_rate_hz)
    return np.asarray(frequency_hz, dtype=np.float64), np.fft.rfft(record) / len(record)


# ---- density against time


@dataclass(frozen=True)
class Spectrogram:
    """Level of the spectral density against time.

    Parameters
    ----------
    time_s : array (m,), s. Middles of the frames.
    edges_hz : array (r + 1,), Hz. Edges of the rows.
    level_db : array (r, m), dB re (20 uPa)^2/Hz, or re the square of another reference value per
        Hz. NaN where the sound is silent or unknown.
    window : str. Name of the window.
    frame_s, hop_s : float, s. Length and distance of the frames.
    enbw_hz : float, Hz. Equivalent noise bandwidth of the lines, which are 1 / `frame_s` apart.
    """

    __repr__ = short_repr

    time_s: Array
    edges_hz: Array
    level_db: Array
    window: str
    frame_s: float
    hop_s: float
    enbw_hz: float


def spectrogram(
    pressure_pa: Array,
    sample_rate_hz: float,
    highest_hz: float = math.inf,
    closed: bool = True,
    frame_s: float = FRAME_S,
    reference: float = P_REF_PA,
) -> Spectrogram:
    """Compute the density of a record in up to 400 frames and 124 rows from 20 Hz to 20 kHz.

    A row holds the mean density over its width, where each line fills the distance to the next.
    White noise is therefore flat, a row narrower than a line has the density of its line, and rows
    times widths add up to the lines. A tone rises above noise by its mean square over its row's
    width, or over `enbw_hz` if that is wider.

    The frames are Hann windows of 40 ms, or of a 12.5th of a shorter record. At most 16 begin
    within the length of one frame. From 8 s on they are long enough to overlap by half.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz. Sample rate.
    highest_hz : float, Hz. Highest frequency that the record resolves. Rows that reach above it, or
        above the record's own Nyquist frequency, are NaN. Default infinity.
    closed : bool. If true, frames at the ends continue at the other end; otherwise there is silence
        before and after. Default True.
    frame_s : float, s. Length of the frames, unless the record is short. Default 40 ms.
    reference : float. Reference value of the levels, in the unit of the record. Default 20 uPa.

    Returns
    -------
    Spectrogram

    Raises
    ------
    ValueError
        As `checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics.spectrum import spectrogram
    >>> shown = spectrogram(np.sin(2 * np.pi * 1025 * np.arange(24000) / 48000), 48000)
    >>> row, _ = np.unravel_index(np.nanargmax(shown.level_db), shown.level_db.shape)
    >>> bool(shown.edges_hz[row] < 1025 < shown.edges_hz[row + 1])
    True
    """
    record = checked_record(pressure_pa, sample_rate_hz)
    n = len(record)
    frame = max(_MIN_FRAME, round(min(frame_s * sample_rate_hz, n / _FRAMES_IN_RECORD)))
    hop = max(1, frame // _HOPS_IN_FRAME, -(-n // _MAX_FRAMES))
    frame = max(frame, 2 * hop)
    frames = max(1, n // hop)
    first = (n - (frames - 1) * hop) // 2  # middle of the first frame
    before = -(-frame // hop) * hop  # silence of whole hops, more than half a frame
    padded = np.pad(record, (before - first, frame), mode="wrap" if closed else "constant")

    window = hann(frame)
    begin = before - frame // 2  # of the first frame
    cut = np.lib.stride_tricks.sliding_window_view(padded[begin:], frame)[::hop][:frames]
    density = _frame_density(cut, window, sample_rate_hz).T
    low = ROW_EDGES_HZ[:-1, np.newaxis]
    high = ROW_EDGES_HZ[1:, np.newaxis]
    lines_hz = np.fft.rfftfreq(frame, 1.0 / sample_rate_hz)
    half = sample_rate_hz / frame / 2.0  # of a line's width
    covered = np.minimum(high, lines_hz + half) - np.maximum(low, lines_hz - half)
    rows = np.maximum(covered, 0.0) / (high - low) @ density

    sounding = rows > _ROUNDING * rows.max()
    sounding &= (ROW_EDGES_HZ[1:] <= min(highest_hz, sample_rate_hz / 2.0))[:, np.newaxis]
    level_db = np.full(rows.shape, np.nan)
    level_db[sounding] = 10.0 * (np.log10(rows[sounding]) - math.log10(reference**2))
    return Spectrogram(
        time_s=(first + hop * np.arange(frames)) / sample_rate_hz,
        edges_hz=ROW_EDGES_HZ,
        level_db=level_db,
        window="hann",
        frame_s=frame / sample_rate_hz,
        hop_s=hop / sample_rate_hz,
        enbw_hz=equivalent_noise_bandwidth(window, sample_rate_hz),
    )
