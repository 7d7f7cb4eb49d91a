"""Sound files: calibrated in pascals, or scaled for listening. Depends on soundfile.

Every file is written whole or not at all, and the same record gives the same bytes at any time.
"""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np
import soundfile

from acoustics.level import a_weighted_rms

SAMPLE_RATE_HZ = 48000

# libsndfile writes longer strings but reads back 2048 bytes at most.
_LONGEST_COMMENT = 2000

_TARGET_RMS = 10.0 ** (-23.0 / 20.0)  # the programme loudness of EBU R 128, here as A-weighted rms
_PEAK = 10.0 ** (-1.0 / 20.0)


def write_calibrated(path: str | os.PathLike[str], pressure_pa: np.ndarray, comment: str) -> None:
    """Write sound pressure as a mono 32-bit float WAV in which 1.0 is 1 Pa.

    Full scale is 91 dB rms for a sine, so a quiet record plays as quietly. 32 bits are what players read, and their
    rounding lies 150 dB below the record.

    Parameters
    ----------
    path
        File to write or to replace, in an existing folder.
    pressure_pa
        Sound pressure (n,) at 48 kHz, Pa.
    comment
        Goes into the file's metadata as it is; up to 2000 bytes of UTF-8.

    Raises
    ------
    ValueError
        If the record is not a finite series of at least one sample, or the comment does not fit.
    OSError
        If it cannot be written; what was there before is still there.
    """
    _write(Path(path), pressure_pa, "FLOAT", comment)


def write_listening(path: str | os.PathLike[str], pressure_pa: np.ndarray, gain: float, comment: str) -> None:
    """Write gain * pressure as a mono 24-bit PCM WAV, for the ear.

    Parameters
    ----------
    path
        File to write or to replace, in an existing folder.
    pressure_pa
        Sound pressure (n,) at 48 kHz, Pa.
    gain
        Full scale per pascal, e.g. from `listening_gain`. One gain for several records keeps their differences.
    comment
        Goes into the file's metadata as it is, and should state the gain; up to 2000 bytes of UTF-8.

    Raises
    ------
    ValueError
        If a sample exceeds full scale (nothing is clipped, nothing is written), and as `write_calibrated`.
    OSError
        If it cannot be written; what was there before is still there.
    """
    samples = gain * np.asarray(pressure_pa, dtype=float)
    peak = float(np.max(np.abs(samples), initial=0.0))
    if peak > 1.0:
        raise ValueError(
            f"a gain of {gain:g} per Pa drives the peak to {peak:.4g} of full scale; "
            f"the largest that fits is {gain / peak:g}"
        )
    _write(Path(path), samples, "PCM_24", comment)


def listening_gain(pressure_pa: np.ndarray, target_rms: float = _TARGET_RMS, peak: float = _PEAK) -> float:
    """Gain, full scale per pascal, that makes a record equally loud as others without clipping.

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
    The gain; 1 for a silent record.
    """
    largest = float(np.max(np.abs(pressure_pa), initial=0.0))
    if largest == 0.0:
        return 1.0
    weighted = a_weighted_rms(pressure_pa, SAMPLE_RATE_HZ)
    return min(target_rms / weighted if weighted > 0.0 else np.inf, peak / largest)


def read(path: str | os.PathLike[str]) -> tuple[np.ndarray, int, str]:
    """Read a sound file.

    Returns
    -------
    samples, sample_rate_hz, comment
        Float64 (n,) for a mono file (pascals if calibrated, else of full scale), Hz, and the metadata's comment.
    """
    with soundfile.SoundFile(os.fspath(path)) as file:
        return file.read(dtype="float64"), file.samplerate, file.comment


def _write(path: Path, samples: np.ndarray, subtype: str, comment: str) -> None:
    if np.ndim(samples) != 1 or len(samples) == 0:
        raise ValueError(f"{path.name}: a record is a series of at least one sample, got shape {np.shape(samples)}")
    if not np.all(np.isfinite(samples)):
        raise ValueError(f"{path.name}: the record holds values that are not finite")
    length = len(comment.encode())
    if length > _LONGEST_COMMENT:
        raise ValueError(f"{path.name}: the comment takes {length} bytes, at most {_LONGEST_COMMENT} fit")
    # Built in memory: libsndfile reports a full disk late or not at all.
    memory = io.BytesIO()
    with soundfile.SoundFile(memory, "w", SAMPLE_RATE_HZ, channels=1, subtype=subtype, format="WAV") as file:
        if comment:  # libsndfile refuses an empty one
            file.comment = comment
        file.write(samples)
    _write_whole(path, _without_time_stamp(memory.getvalue()))


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


def _write_whole(path: Path, content: bytes) -> None:
    """Write a file under another name in the same folder, then give it its own."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
