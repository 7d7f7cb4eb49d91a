"""Spectral density against time in rows of a twelfth octave."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics._typing import Array
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import check_record, equivalent_noise_bandwidth

# Edges of base-10 twelfth octaves: four to each third octave of acoustics.bands, whose edges are
# among them (125,).
ROW_EDGES_HZ = 10.0 ** (np.arange(50, 175) / 40.0)
ROW_EDGES_HZ.setflags(write=False)

_MOST_FRAMES = 400
_FRAME_S = 0.04
_FRAMES_IN_RECORD = 12.5  # 40 ms in 0.5 s; a shorter record has shorter frames
_HOPS_IN_FRAME = 16
_LEAST_FRAME = 16
_ROUNDING = 1e-20  # share of the maximum density, as for levels


@dataclass(frozen=True)
class Spectrogram:
    """Level of the spectral density against time.

    Parameters
    ----------
    time_s : array (m,), s. Middles of the frames.
    edges_hz : array (r + 1,), Hz. Edges of the rows.
    level_db : array (r, m), dB re (20 uPa)^2/Hz. NaN where the sound is silent or unknown.
    window : str. Name of the window.
    frame_s, hop_s : float, s. Length and distance of the frames.
    line_width_hz, enbw_hz : float, Hz. Distance and equivalent noise bandwidth of the lines.
    """

    time_s: Array
    edges_hz: Array
    level_db: Array
    window: str
    frame_s: float
    hop_s: float
    line_width_hz: float
    enbw_hz: float


def spectrogram(
    pressure_pa: Array, sample_rate_hz: float, highest_hz: float = math.inf, closed: bool = True
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

    Returns
    -------
    Spectrogram

    Raises
    ------
    ValueError
        As `acoustics.spectrum.check_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics.spectrogram import spectrogram
    >>> shown = spectrogram(np.sin(2 * np.pi * 1025 * np.arange(24000) / 48000), 48000)
    >>> row, _ = np.unravel_index(np.nanargmax(shown.level_db), shown.level_db.shape)
    >>> bool(shown.edges_hz[row] < 1025 < shown.edges_hz[row + 1])
    True
    """
    from scipy.signal import ShortTimeFFT, get_window  # slow to import, and levels do without

    check_record(pressure_pa)
    n = len(pressure_pa)
    frame = max(_LEAST_FRAME, round(min(_FRAME_S * sample_rate_hz, n / _FRAMES_IN_RECORD)))
    hop = max(1, frame // _HOPS_IN_FRAME, -(-n // _MOST_FRAMES))
    frame = max(frame, 2 * hop)
    frames = max(1, n // hop)
    first = (n - (frames - 1) * hop) // 2  # middle of the first frame
    before = -(-frame // hop) * hop  # silence of whole hops, more than half a frame
    padded = np.pad(pressure_pa, (before - first, frame), mode="wrap" if closed else "constant")

    window = get_window("hann", frame)
    transform = ShortTimeFFT(
        window, hop, sample_rate_hz, fft_mode="onesided2X", scale_to="psd", phase_shift=None
    )
    density = transform.spectrogram(padded, p0=before // hop, p1=before // hop + frames)
    rows = _share_of_lines(transform.f, sample_rate_hz / frame) @ density

    sounding = rows > _ROUNDING * rows.max()
    sounding &= (ROW_EDGES_HZ[1:] <= min(highest_hz, sample_rate_hz / 2.0))[:, np.newaxis]
    level_db = np.full(rows.shape, np.nan)
    level_db[sounding] = 10.0 * (np.log10(rows[sounding]) - math.log10(P_REF_PA**2))
    return Spectrogram(
        time_s=(first + hop * np.arange(frames)) / sample_rate_hz,
        edges_hz=ROW_EDGES_HZ,
        level_db=level_db,
        window="hann",
        frame_s=frame / sample_rate_hz,
        hop_s=hop / sample_rate_hz,
        line_width_hz=sample_rate_hz / frame,
        enbw_hz=equivalent_noise_bandwidth(window, sample_rate_hz),
    )


def _share_of_lines(frequency_hz: Array, line_width_hz: float) -> Array:
    """Return the share of each row's width that each line covers: (r, l).

    The shares of a row add up to 1.
    """
    low, high = ROW_EDGES_HZ[:-1, np.newaxis], ROW_EDGES_HZ[1:, np.newaxis]
    from_line = np.maximum(low, frequency_hz - line_width_hz / 2.0)
    to_line = np.minimum(high, frequency_hz + line_width_hz / 2.0)
    share: Array = np.maximum(to_line - from_line, 0.0) / (high - low)
    return share
