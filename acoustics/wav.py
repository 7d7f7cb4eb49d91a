"""Sound files as bytes: calibrated in pascals, or scaled for listening. Depends on soundfile.

The same record gives the same bytes at any time.
"""

from __future__ import annotations

import io
import os
from typing import Literal

import numpy as np
import soundfile

from acoustics.level import a_weighted_rms
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import check_record

SAMPLE_RATE_HZ = 48000

# libsndfile writes longer strings but reads back 2048 bytes at most.
_LONGEST_TEXT = 2000

_TARGET_RMS = 10.0 ** (-23.0 / 20.0)  # the programme loudness of EBU R 128, here as A-weighted rms
PEAK = 10.0 ** (-1.0 / 20.0)  # largest sample of a record for the ear, of full scale
# The threshold of hearing, 0 dB(A), comes to the target and no higher: below it a record keeps its distance from the others,
# because a gain that grows without bound makes the rounding of a silent record as loud as a sound.
MOST_GAIN = _TARGET_RMS / P_REF_PA  # full scale per pascal


def calibrated(pressure_pa: np.ndarray, comment: str, title: str = "") -> bytes:
    """Sound pressure as a mono 32-bit float WAV in which 1.0 is 1 Pa.

    Full scale is 91 dB rms for a sine, so a quiet record plays as quietly. 32 bits are what players read, and their
    rounding lies 150 dB below the record.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,) at 48 kHz, Pa.
    comment, title
        Go into the file's metadata as they are; up to 2000 bytes of UTF-8 each.

    Returns
    -------
    The file.

    Raises
    ------
    ValueError
        If the record is not a finite series of at least one sample, or exceeds what 32 bits hold, or a text does not fit.
    """
    samples = np.asarray(pressure_pa, dtype=float)
    check_record(samples)
    if np.max(np.abs(samples), initial=0.0) > np.finfo(np.float32).max:
        raise ValueError(f"the record reaches {np.max(np.abs(samples)):g} Pa, more than a 32-bit float holds")
    return _wav(samples, "FLOAT", comment, title)


def listening(pressure_pa: np.ndarray, gain: float, comment: str, title: str = "", bits: Literal[16, 24] = 24) -> bytes:
    """gain * pressure as a mono PCM WAV, for the ear.

    Rounded without dither, so that silence stays silence: the noise of rounding is white, LSB/sqrt(12) or -101 dB of full
    scale (16 bits) and -149 dB (24 bits) rms in all, 78 and 126 dB below a record at -23 dB.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,) at 48 kHz, Pa.
    gain
        Full scale per pascal, e.g. from `listening_gain`. One gain for several records keeps their differences.
    comment, title
        Go into the file's metadata as they are, and should state the gain; up to 2000 bytes of UTF-8 each.
    bits
        Of a sample.

    Returns
    -------
    The file.

    Raises
    ------
    ValueError
        If a sample exceeds full scale (nothing is clipped), and as `calibrated`.
    """
    check_record(pressure_pa)
    samples = gain * np.asarray(pressure_pa, dtype=float)
    peak = float(np.max(np.abs(samples), initial=0.0))
    if peak > 1.0:
        raise ValueError(
            f"a gain of {gain:g} per Pa drives the peak to {peak:.4g} of full scale; "
            f"the largest that fits is {gain / peak:g}"
        )
    # libsndfile would round down, which leaves half a step of offset. It takes 32-bit integers, the upper bits of which
    # are the file's. Full scale itself lies one step above the greatest number.
    steps = np.minimum(np.rint(samples * 2.0 ** (bits - 1)), 2.0 ** (bits - 1) - 1.0)
    return _wav(steps.astype(np.int32) << (32 - bits), f"PCM_{bits}", comment, title)


def listening_gain(pressure_pa: np.ndarray, target_rms: float = _TARGET_RMS, peak: float = PEAK) -> float:
    """Return the gain, full scale per pascal, that makes a record as loud as others without clipping.

    A record below 0 dB(A) gets `MOST_GAIN`, which takes 0 dB(A) to the default target: it stays quieter than the others.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,) at 48 kHz, Pa.
    target_rms
        A-weighted rms to reach, of full scale; default -23 dB.
    peak
        Largest sample allowed, of full scale; default -1 dB. It wins over the target.

    Returns
    -------
    The gain, at most `MOST_GAIN`; 1 for a silent record.
    """
    largest = float(np.max(np.abs(pressure_pa), initial=0.0))
    if largest < np.finfo(float).tiny:  # the gain would be no number
        return 1.0
    weighted = a_weighted_rms(pressure_pa, SAMPLE_RATE_HZ)
    return min(target_rms / weighted if weighted > 0.0 else MOST_GAIN, peak / largest, MOST_GAIN)


def read(path: str | os.PathLike[str]) -> tuple[np.ndarray, int, str]:
    """Read a sound file.

    Returns
    -------
    samples, sample_rate_hz, comment
        Float64 (n,) for a mono file (pascals if calibrated, else of full scale), Hz, and the metadata's comment.
    """
    with soundfile.SoundFile(os.fspath(path)) as file:
        return file.read(dtype="float64"), file.samplerate, file.comment


def _wav(samples: np.ndarray, subtype: str, comment: str, title: str) -> bytes:
    for what, text in (("comment", comment), ("title", title)):
        length = len(text.encode())
        if length > _LONGEST_TEXT:
            raise ValueError(f"the {what} takes {length} bytes, at most {_LONGEST_TEXT} fit")
    memory = io.BytesIO()
    with soundfile.SoundFile(memory, "w", SAMPLE_RATE_HZ, channels=1, subtype=subtype, format="WAV") as file:
        if comment:  # libsndfile refuses an empty one
            file.comment = comment
        if title:
            file.title = title
        file.write(samples)
    return _without_time_stamp(memory.getvalue())


def _without_time_stamp(wav: bytes) -> bytes:
    """The file with the time of writing in its PEAK chunk set to zero.

    A float WAV of libsndfile carries it behind the chunk's name, size and version, four bytes each. soundfile has no
    public call that leaves the chunk out.
    """
    start = 12
    while start + 8 <= len(wav):
        name, size = wav[start : start + 4], int.from_bytes(wav[start + 4 : start + 8], "little")
        if name == b"PEAK":
            return wav[: start + 12] + bytes(4) + wav[start + 16 :]
        start += 8 + size + size % 2
    return wav
