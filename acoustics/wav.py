"""Sound files as bytes, calibrated in pascals or scaled for listening.

The same record gives the same bytes at any time.
"""

import io
import math
import os
import struct
from typing import Any, Literal

import numpy as np
import soundfile
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import (
    Array,
    finite,
    instance,
    positive,
    real_array,
    truth,
)
from acoustics.level import a_weighted_rms
from acoustics.radiation import P_REF_PA
from acoustics.traps import ignoring_underflow

SAMPLE_RATE_HZ = 48000

# libsndfile writes longer strings but reads back 2048 bytes at most.
_LONGEST_TEXT = 2000

_TARGET = 10.0 ** (-23.0 / 20.0)  # programme loudness of EBU R 128, here as A-weighted rms
PEAK = 10.0 ** (-1.0 / 20.0)  # maximum sample of a record for listening, as a share of full scale
# The threshold of hearing, 0 dB(A), reaches the target. Quieter records stay quieter, because an
# unbounded gain would make the rounding of a silent record as loud as a sound.
MAX_GAIN = _TARGET / P_REF_PA  # full scale per pascal

_MIDDLE_C = 60  # the MIDI note at which a sampler plays a record at its own pitch
_FORWARD = 0  # direction of a loop
_FOREVER = 0  # number of times that a loop is played


@ignoring_underflow
def calibrated(pressure_pa: ArrayLike, comment: str, title: str = "", loops: bool = False) -> bytes:
    """Write sound pressure as a 32-bit float WAV in which 1.0 is 1 Pa.

    Full scale is a sine of 91 dB rms, so a quiet record plays quietly. Players read 32 bits, and
    their rounding lies 150 dB below the record.

    Parameters
    ----------
    pressure_pa : array (n,) or (n, channels), Pa
        Sound pressure at 48 kHz.
    comment, title : str
        Metadata of the file, up to 2000 bytes of UTF-8 each. Default title: empty.
    loops : bool
        Mark the whole record as a loop for samplers and editors. Default: false.

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    ValueError
        If the record is not a finite series of at least one sample, or exceeds the range of a
        32-bit float, or if a text does not fit.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> from acoustics import wav
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "signal.wav"
    ...     _ = file.write_bytes(wav.calibrated([0.25, -0.5], "1.0 is 1 Pa"))
    ...     samples, rate, comment = wav.read(file)
    >>> samples.tolist(), rate, comment
    ([0.25, -0.5], 48000, '1.0 is 1 Pa')
    """
    samples = _samples(pressure_pa)
    if (largest := float(np.max(np.abs(samples)))) > np.finfo(np.float32).max:
        raise ValueError(f"the record reaches {largest:g} Pa, more than a 32-bit float holds")
    return _wav(samples, "FLOAT", comment, title, loops)


@ignoring_underflow
def listening(
    pressure_pa: Array,
    gain: float,
    comment: str,
    title: str = "",
    bits: Literal[16, 24] = 24,
    loops: bool = False,
) -> bytes:
    """Write gain * pressure as a PCM WAV for listening, with the same gain for all channels.

    Samples are rounded without dither, so silence stays silent. The noise of rounding is white. Its
    rms is LSB/sqrt(12): -101 dB of full scale with 16 bits and -149 dB with 24 bits, which is 78
    and 126 dB below a record at -23 dB.

    Parameters
    ----------
    pressure_pa : array (n,) or (n, channels), Pa
        Sound pressure at 48 kHz.
    gain : float, full scale per Pa
        Gain, for example from `listening_gain`. One gain for several records keeps their
        differences.
    comment, title : str
        Metadata of the file, up to 2000 bytes of UTF-8 each; the comment should state the gain.
        Default title: empty.
    bits : 16 or 24
        Bits of a sample. Default 24.
    loops : bool
        Mark the whole record as a loop for samplers and editors. Default: false.

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    ValueError
        If a sample exceeds full scale (nothing is clipped), and as `calibrated`.

    References
    ----------
    EBU R 128 for the level of -23 dB, here applied to the A-weighted rms.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import wav
    >>> tone = 0.01 * np.sin(2 * np.pi * 1000 * np.arange(4800) / 48000)
    >>> gain = wav.listening_gain(tone)
    >>> len(wav.listening(tone, gain, f"gain {gain:g}", bits=16)) > 2 * len(tone)
    True
    """
    if type(bits) is not int or bits not in (16, 24):
        raise ValueError(f"bits: got {bits!r}, allowed: 16 or 24")
    samples = finite("gain", gain) * _samples(pressure_pa)
    peak = float(np.max(np.abs(samples)))
    if peak > 1.0:
        words = f"a gain of {gain:g} per Pa drives the peak to {peak:.4g} of full scale"
        raise ValueError(f"{words}; the largest that fits is {gain / peak:g}")
    # libsndfile would round down, which leaves half a step of offset. It takes 32-bit integers and
    # writes their upper bits. Full scale itself lies one step above the largest number.
    steps = np.minimum(np.rint(samples * 2.0 ** (bits - 1)), 2.0 ** (bits - 1) - 1.0)
    return _wav(steps.astype(np.int32) << (32 - bits), f"PCM_{bits}", comment, title, loops)


@ignoring_underflow
def listening_gain(pressure_pa: Array, target_rms: float = _TARGET, peak: float = PEAK) -> float:
    """Return the gain that makes a record as loud as others without clipping.

    A record below 0 dB(A) gets `MAX_GAIN`, which brings 0 dB(A) to the default target, and stays
    quieter than the others.

    Parameters
    ----------
    pressure_pa : array (n,) or (n, channels), Pa
        Sound pressure at 48 kHz. Channels share the gain, which follows their mean power and their
        maximum.
    target_rms : float, of full scale
        A-weighted rms to reach. Default -23 dB.
    peak : float, of full scale
        Maximum sample; it takes precedence over the target. Default -1 dB.

    Returns
    -------
    float, full scale per Pa
        At most `MAX_GAIN`; 1 for a silent record.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import wav
    >>> # 1 Pa rms; A-weighting is 0 dB at 1 kHz
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)
    >>> round(float(20 * np.log10(wav.listening_gain(tone))), 2)
    -23.0
    """
    pressure_pa = _samples(pressure_pa)
    target_rms = positive("target_rms", target_rms, 1.0)
    peak = positive("peak", peak, 1.0)
    largest = float(np.max(np.abs(pressure_pa), initial=0.0))
    if largest < np.finfo(float).tiny:  # the gain would not be a number
        return 1.0
    channels = np.atleast_2d(np.transpose(pressure_pa))
    of_channels = [a_weighted_rms(channel, SAMPLE_RATE_HZ) for channel in channels]
    weighted = math.hypot(*of_channels) / math.sqrt(len(channels))
    gain = min(peak / largest, MAX_GAIN)
    if weighted > 0.0:
        gain = min(target_rms / weighted, gain)
    return gain


@ignoring_underflow
def read(path: str | os.PathLike[str]) -> tuple[Array, int, str]:
    """Read a sound file, for example one that `calibrated` made.

    Parameters
    ----------
    path : str or path
        Sound file.

    Returns
    -------
    samples : array (n,), or (n, channels) of several, Pa if calibrated, otherwise of full scale
    sample_rate_hz : int, Hz
    comment : str
        Comment in the metadata.

    Raises
    ------
    soundfile.LibsndfileError
        If the file is missing or not a sound file.
    """
    with soundfile.SoundFile(os.fspath(path)) as file:
        return file.read(dtype="float64"), file.samplerate, file.comment


def _samples(pressure: ArrayLike) -> Array:
    """Return a record (n,) or several of them (n, channels) as floats; refuse other arrays."""
    samples = real_array("pressure_pa", pressure, None)
    return real_array("pressure_pa", samples, 2 if samples.ndim == 2 else 1)


def _wav(samples: NDArray[Any], subtype: str, comment: str, title: str, loops: bool) -> bytes:
    loops = truth("loops", loops)
    for field, text in (("comment", comment), ("title", title)):
        instance(field, text, str)
        length = len(text.encode())
        if length > _LONGEST_TEXT:
            raise ValueError(f"the {field} takes {length} bytes, at most {_LONGEST_TEXT} fit")
    memory = io.BytesIO()
    channels = 1 if samples.ndim == 1 else samples.shape[1]
    with soundfile.SoundFile(memory, "w", SAMPLE_RATE_HZ, channels, subtype, format="WAV") as file:
        if comment:  # libsndfile refuses an empty title
            file.comment = comment
        if title:
            file.title = title
        file.write(samples)
    wav = _without_time_stamp(memory.getvalue())
    if loops:
        wav = _with_loop(wav, len(samples))
    return wav


def _with_loop(wav: bytes, samples: int) -> bytes:
    """Append a `smpl` chunk with one loop over all samples, which soundfile cannot write.

    References
    ----------
    Microsoft, *Multimedia Programming Interface and Data Specifications 1.0*, 1991, and its
    *New Multimedia Data Types and Data Techniques*, 1994: `smpl`, the sampler chunk. Numbers are
    little-endian and take 32 bits; the end of a loop is its last sample.
    """
    numbers = [
        0,  # manufacturer
        0,  # product
        round(1e9 / SAMPLE_RATE_HZ),  # period [ns]
        _MIDDLE_C,
        0,  # fraction of the note
        0,  # SMPTE format
        0,  # SMPTE offset
        1,  # number of loops
        0,  # bytes of sampler data
        0,  # cue point of the loop
        _FORWARD,
        0,  # first sample
        samples - 1,  # last sample
        0,  # fraction of a sample
        _FOREVER,
    ]
    content = struct.pack(f"<{len(numbers)}I", *numbers)
    even = wav + bytes(len(wav) % 2)  # a chunk begins at an even place
    whole = even + b"smpl" + struct.pack("<I", len(content)) + content
    return whole[:4] + struct.pack("<I", len(whole) - 8) + whole[8:]


def _without_time_stamp(wav: bytes) -> bytes:
    """Set the time of writing in the PEAK chunk of a file to zero.

    A float WAV of libsndfile carries the time behind the chunk's name, size and version, four bytes
    each. soundfile has no public call that leaves the chunk out.
    """
    start = 12
    while start + 8 <= len(wav):
        name = wav[start : start + 4]
        size = int.from_bytes(wav[start + 4 : start + 8], "little")
        if name == b"PEAK":
            return wav[: start + 12] + bytes(4) + wav[start + 16 :]
        start += 8 + size + size % 2
    return wav
