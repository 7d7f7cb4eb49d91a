"""Records of runs on the page as FLAC, and the gains at which they are compared."""

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

_FULL = 2**15  # steps of full scale
_BLOCK = 4096  # samples of a frame of FLAC, which has its own number of bits
_BELOW = 10.0 ** (-60 / 20)  # rms of the rounding of a long record over that of its block


def of_runs(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return gains and records of runs: computed, long, and pass by pass.

    `playback` holds the gains of the computed records. `long` holds the gains of the long ones,
    beside the computed ones of runs without; it is None if no run has a long record.
    """
    sounds = [run.sound for run in runs]
    playbacks = _gains([s.channels for s in sounds], [s.levels.laeq_db for s in sounds])
    pressures = [(run.long or run.sound).channels for run in runs]
    levels = [run.long.numbers["laeq_db"] if run.long else run.sound.levels.laeq_db for run in runs]
    longs = _gains(pressures, levels)
    has_long = any(run.long for run in runs)
    return [
        {
            "number": number,
            "playback": playback,
            "long": _long(run, long) if has_long else None,
            "records": _records(run, playback, long),
        }
        for number, (run, playback, long) in enumerate(zip(runs, playbacks, longs, strict=True))
    ]


def _gains(channels: Sequence[Array], levels: Sequence[float | None]) -> list[dict[str, Any]]:
    """Return the gains of records [Pa] with their LAeq [dB]."""
    return gains([float(np.abs(record).max()) for record in channels], levels)


def _long(run: Run, playback: dict[str, Any]) -> dict[str, Any]:
    """Return gains and lengths [s] of the record that is heard among long ones."""
    if run.long is None:
        return {"own": False, "playback": playback}
    seconds = len(run.long.pressure) / run.long.sample_rate
    solved = seconds * run.long.numbers["solved_share"]
    return {"own": True, "playback": playback, "seconds": seconds, "solved": solved}


def _records(run: Run, playback: dict[str, Any], long: dict[str, Any]) -> list[dict[str, str]]:
    """Return name, FLAC and description of the records of a run."""
    computed = f"computed record of {run.sound.duration:.4g} s"
    written = [("run", computed, flac(run.sound.channels, playback["full_scale_pa"]), playback)]
    if run.long is not None:
        content = f"long record: {listening.sentence(run, run.long)}"
        samples = flac(run.long.channels, long["full_scale_pa"], thin=True)
        written.append(("long", content, samples, long))
    made = [
        {"name": name, "src": src, "text": f"{text}; full scale is {gain['full_scale_pa']:.4g} Pa"}
        for name, text, src, gain in written
    ]
    if run.result.passes is not None:
        content, text = passes_wav(run, 16)
        made.append({"name": "passes", "src": maps.uri("audio/wav", content), "text": text})
    return made


def flac(pressure: Array, full_scale: float, thin: bool = False) -> str:
    """Return a record [Pa] in 16 bits as a FLAC in a data URI; a thin one has fewer where loud."""
    steps = np.rint(pressure / full_scale * _FULL)
    if thin:
        steps = np.concatenate(
            [_rounded(steps[k : k + _BLOCK]) for k in range(0, len(steps), _BLOCK)]
        )
    samples = np.clip(steps, -_FULL, _FULL - 1).astype(np.int16)
    content = io.BytesIO()
    soundfile.write(content, samples, wav.SAMPLE_RATE_HZ, format="FLAC", subtype="PCM_16")
    return maps.uri("audio/flac", content.getvalue())


def _rounded(steps: Array) -> Array:
    """Clear the lowest bits of a block of samples, with an error 60 dB below its rms."""
    coarsest = math.sqrt(12) * _BELOW * float(np.sqrt(np.mean(np.square(steps))))
    step = 2.0 ** math.floor(math.log2(max(coarsest, 1.0)))
    return np.asarray(step * np.rint(steps / step))


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
        scale and for a common LAeq, `calibrated_pa` and `equal_pa` [Pa] the full scales that they
        lead to, and `equal_db` [dB] their ratio. A silent record has factors of 0 and no scales.
    """
    scales = [peak / wav.PEAK if peak > 0 else 1.0 for peak in peaks_pa]
    records = [*zip(scales, peaks_pa, laeq_db, strict=True)]
    common = max((scale for scale, peak, _ in records if peak > 0), default=1.0)
    # Each record is loudest with its peak at the limit. All records can reach the minimum of these
    # levels.
    loudest = [level - _db(scale) for scale, _, level in records if level is not None]
    target = min(loudest, default=0.0)
    computed: list[dict[str, float | None]] = []
    for scale, peak, level in records:
        gain: dict[str, float | None] = {"full_scale_pa": scale, "calibrated": 0.0, "equal": 0.0}
        gain |= dict.fromkeys(("calibrated_pa", "equal_pa", "equal_db"))
        if peak > 0:
            equal = common if level is None else 10.0 ** ((level - target) / 20.0)
            gain |= {"calibrated": scale / common, "equal": scale / equal}
            gain |= {"calibrated_pa": common, "equal_pa": equal, "equal_db": _db(common / equal)}
        computed.append(gain)
    return computed


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
