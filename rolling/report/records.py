"""Records of runs on the page, and the gains at which they are compared.

The computed record of a run is a FLAC without loss. Records for the ear alone are MP3 of the
highest quality, in which third octaves below 14 kHz keep their levels within 0.1 dB.
"""

import io
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
import soundfile

from acoustics import wav
from acoustics.arrays import Array
from acoustics.laps import Lap, crossfaded_lap
from rolling.report import maps
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.sound.contact_sound import ContactSound, fade_length
from rolling.sound.long_listening import Listening

_FULL = 2**15  # steps of full scale


class RunRecords(NamedTuple):
    """Records of a run for the page, the first of which is heard: long, computed, by passes.

    `playback` are the gains of the first record, `lap` is the part of it to which its end leads
    back, and `solved` the time [s] in it at which the solved track ends.
    """

    records: list[dict[str, str]]
    playback: dict[str, float | None]
    lap: dict[str, float]
    solved: float


def of_runs(runs: Sequence[Run]) -> list[RunRecords]:
    """Return the records of runs that are compared on a page."""
    longs = [listening.long_record_of(run) for run in runs]
    peaks_pa = []
    levels_db = []
    for run, long in zip(runs, longs, strict=True):
        if long is None:
            peaks_pa.append(float(np.abs(run.sound.channels).max()))
            levels_db.append(run.record_laeq_db)
        else:
            peaks_pa.append(float(np.abs(long.channels).max()))
            levels_db.append(long.numbers["laeq_db"])
    playbacks = gains(peaks_pa, levels_db)
    return [
        RunRecords(
            records=_records(run, long),
            playback=playback,
            lap=lap(run.sound, long),
            solved=solved(run.sound, long),
        )
        for run, long, playback in zip(runs, longs, playbacks, strict=True)
    ]


def _records(run: Run, long: Listening | None) -> list[dict[str, str]]:
    """Return name, sound and description of the records of a run, the one that is heard first."""
    records = []
    if long is not None:
        full_pa = full_scale(float(np.abs(long.channels).max()))
        sentence = listening.describe_long_record(run, long)
        text = f"long record: {sentence}; full scale is {full_pa:.4g} Pa"
        records.append({"name": "long", "text": text, "src": compressed(long.channels / full_pa)})
    full_pa = full_scale(float(np.abs(run.sound.channels).max()))
    text = f"computed record of {run.sound.duration:.4g} s; full scale is {full_pa:.4g} Pa"
    records.append({"name": "run", "text": text, "src": lossless(run.sound.channels / full_pa)})
    if run.result.passes is not None:
        content, sentence = listening.passes_wav(run, 16)
        samples, _ = soundfile.read(io.BytesIO(content))
        text = f"pass by pass: {sentence}"
        records.append({"name": "passes", "text": text, "src": compressed(samples)})
    return records


def lossless(samples: Array) -> str:
    """Return samples within full scale in 16 bits as a FLAC in a data URI."""
    steps = np.clip(np.rint(_FULL * samples), -_FULL, _FULL - 1).astype(np.int16)
    return _embedded(steps, "FLAC", "audio/flac", subtype="PCM_16")


def compressed(samples: Array) -> str:
    """Return samples within full scale as an MP3 in a data URI, or lossless where none is made."""
    if "MP3" not in soundfile.available_formats():
        return lossless(samples)
    return _embedded(samples, "MP3", "audio/mpeg", compression_level=0.0, bitrate_mode="VARIABLE")


def _embedded(samples: Any, form: str, kind: str, **options: Any) -> str:
    """Return a sound file in a data URI."""
    content = io.BytesIO()
    soundfile.write(content, samples, wav.SAMPLE_RATE_HZ, format=form, **options)
    return maps.uri(kind, content.getvalue())


def lap(sound: ContactSound, long: Listening | None = None) -> dict[str, float]:
    """Return the lap to which the end of the record that is heard leads back."""
    if sound.once:
        record = sound.pressure if long is None else long.pressure
        return asdict(Lap(0, len(record)))
    if long is None:
        return asdict(sound.lap)
    ends = fade_length(len(long.pressure), len(long.pressure) / long.sample_rate)
    return asdict(crossfaded_lap(long.pressure, ends, long.sample_rate))


def solved(sound: ContactSound, long: Listening | None) -> float:
    """Return the time [s] in the record that is heard at which the solved track ends."""
    own_s = len(sound.pressure) / sound.sample_rate
    if long is None:
        return own_s
    long_s = len(long.pressure) / long.sample_rate
    return min(own_s, long_s * float(long.numbers["solved_share"]))


# ---- gains


def gains(
    peaks_pa: Sequence[float], laeq_db: Sequence[float | None]
) -> list[dict[str, float | None]]:
    """Compute the gains of records that are compared.

    Parameters
    ----------
    peaks_pa : sequence of float, Pa. Maximum |p| of each record.
    laeq_db : sequence of float or None, dB. Level of each record; None if it is silent or has no
        audible part after A-weighting.

    Returns
    -------
    list of dict. `full_scale_pa` [Pa] is the pressure of full scale in the file of a record, whose
        peak lies at -1 dB. `calibrated` and `equal` are factors on its samples for a common full
        scale, `calibrated_pa` [Pa], and for a common LAeq; `equal_db` [dB] is the gain of the
        second over the first. A silent record has factors of 0 and nothing else.
    """
    scales = [full_scale(peak) for peak in peaks_pa]
    sounding = []
    loudest = []  # level of each record with its peak at the limit, less a constant
    for scale, peak, level in zip(scales, peaks_pa, laeq_db, strict=True):
        if peak > 0:
            sounding.append(scale)
        if level is not None:
            loudest.append(level - _db(scale))
    common = max(sounding, default=1.0)
    # All records can reach the minimum of the loudest levels.
    target = min(loudest, default=0.0)
    computed = []
    for scale, peak, level in zip(scales, peaks_pa, laeq_db, strict=True):
        gain: dict[str, float | None] = {
            "full_scale_pa": scale,
            "calibrated": 0.0,
            "equal": 0.0,
            "calibrated_pa": None,
            "equal_db": None,
        }
        if peak > 0:
            equal_pa = common if level is None else 10.0 ** ((level - target) / 20.0)
            gain["calibrated"] = scale / common
            gain["equal"] = scale / equal_pa
            gain["calibrated_pa"] = common
            gain["equal_db"] = _db(common / equal_pa)
        computed.append(gain)
    return computed


def full_scale(peak_pa: float) -> float:
    """Return the pressure [Pa] of full scale of a record whose peak lies at -1 dB."""
    return peak_pa / wav.PEAK if peak_pa > 0 else 1.0


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
