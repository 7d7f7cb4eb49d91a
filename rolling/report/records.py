"""Records of runs on the page, and the gains at which they are compared.

The computed record of a run is a FLAC without loss. Records for the ear alone are MP3 of the
highest quality, in which third octaves below 14 kHz keep their levels within 0.1 dB.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import soundfile

from acoustics import wav
from acoustics.arrays import Array
from rolling.report import maps
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.results.running_in import passes_wav
from rolling.sound.contact_sound import ContactSound
from rolling.sound.long_listening import Listening

_FULL = 2**15  # steps of full scale


def of_runs(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return gains and records of runs: computed, long, and pass by pass.

    `playback` holds the gains of the computed records. `long` holds the gains of the long ones,
    beside the computed ones of runs without; it is None if no run has a long record.
    """
    longs = [listening.recorded(run) for run in runs]
    own = [(run.sound.channels, run.sound.levels.laeq_db) for run in runs]
    heard = [
        (long.channels, long.numbers["laeq_db"]) if long else record
        for long, record in zip(longs, own, strict=True)
    ]
    return [
        {
            "number": number,
            "playback": playback,
            "records": _records(run, long, playback, gain),
            "long": _long(long, gain) if any(longs) else None,
        }
        for number, (run, long, playback, gain) in enumerate(
            zip(runs, longs, _gains(own), _gains(heard), strict=True)
        )
    ]


def _gains(records: Sequence[tuple[Array, float | None]]) -> list[dict[str, Any]]:
    """Return the gains of records [Pa] with their LAeq [dB]."""
    peaks = [float(np.abs(record).max()) for record, _ in records]
    return [*gains(peaks, [level for _, level in records])]


def _long(long: Listening | None, playback: dict[str, Any]) -> dict[str, Any]:
    """Return gains and lengths [s] of the record that is heard among long ones."""
    if long is None:
        return {"own": False, "playback": playback}
    seconds = len(long.pressure) / long.sample_rate
    solved = seconds * long.numbers["solved_share"]
    return {"own": True, "playback": playback, "seconds": seconds, "solved": solved}


def _records(
    run: Run, long: Listening | None, playback: dict[str, Any], gain: dict[str, Any]
) -> list[dict[str, str]]:
    """Return name, sound and description of the records of a run."""
    full, scale = playback["full_scale_pa"], "full scale is {:.4g} Pa"
    text = f"computed record of {run.sound.duration:.4g} s; {scale.format(full)}"
    made = [{"name": "run", "text": text, "src": lossless(run.sound.channels / full)}]
    if long is not None:
        full = gain["full_scale_pa"]
        text = f"long record: {listening.sentence(run, long)}; {scale.format(full)}"
        made.append({"name": "long", "text": text, "src": compressed(long.channels / full)})
    if run.result.passes is not None:
        content, text = passes_wav(run, 16)
        samples = soundfile.read(io.BytesIO(content))[0]
        made.append({"name": "passes", "text": f"pass by pass: {text}", "src": compressed(samples)})
    return made


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


def lap(sound: ContactSound) -> dict[str, float]:
    """Return the lap of a record for the script, with a factor that never exceeds its peak."""
    part = sound.lap
    peak = float(np.abs(part.samples(sound.channels)).max())
    limit = float(np.abs(sound.channels).max()) / peak if peak > 0 else 1.0
    return asdict(part) | {"factor": part.factor * min(1.0, limit)}


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
    scales = [peak / wav.PEAK if peak > 0 else 1.0 for peak in peaks_pa]
    records = [*zip(scales, peaks_pa, laeq_db, strict=True)]
    common = max((scale for scale, peak, _ in records if peak > 0), default=1.0)
    # Each record is loudest with its peak at the limit. All records can reach the minimum of these
    # levels.
    loudest = [level - _db(scale) for scale, _, level in records if level is not None]
    target = min(loudest, default=0.0)
    computed = []
    for scale, peak, level in records:
        gain: dict[str, float | None] = {"full_scale_pa": scale, "calibrated": 0.0, "equal": 0.0}
        gain |= {"calibrated_pa": None, "equal_db": None}
        if peak > 0:
            equal = common if level is None else 10.0 ** ((level - target) / 20.0)
            gain |= {"calibrated": scale / common, "equal": scale / equal}
            gain |= {"calibrated_pa": common, "equal_db": _db(common / equal)}
        computed.append(gain)
    return computed


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
