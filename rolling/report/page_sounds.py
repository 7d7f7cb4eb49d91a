"""Records of runs on the page, and the gains at which they are compared.

The computed record of a run is a FLAC without loss. Records for the ear alone are MP3, in which
third octaves below 14 kHz that are heard keep their levels within 0.1 dB.
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
from acoustics.level import laeq_db
from rolling.kinds.run_folder import LISTEN
from rolling.report import maps
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.results.stated_sound import StatedSound
from rolling.sound.contact_sound import ContactSound, fade_length
from rolling.sound.long_listening import Listening

_FULL = 2**23  # steps of full scale
# Compression at a variable rate: a sixth less than at 0, and bands would change by 0.14 dB at 0.2.
MP3 = 0.1


class PageRecord(NamedTuple):
    """A record on the page.

    `name` is long, run, released-long, released-run or passes; `title` and `text` describe it,
    `src` is its sound in a data URI, `full_pa` the pressure [Pa] of full scale in it, and `size`
    that of its WAV in words.
    """

    name: str
    title: str
    text: str
    src: str
    full_pa: float
    size: str
    silent: bool


class RunRecords(NamedTuple):
    """Records of a sound of a run for the page, the first of which is heard: long, or computed.

    `stated` is the sound at the level that is stated. `playback` are the gains of the first record,
    and `below_db` is the level of the loudest run with this gain over its own. `lap` is the part of
    it to which its end leads back, and `solved` the time [s] in it at which the solved track ends.
    `ends` tells whether it is of something that ends, and so does not go round. `raised` is its end
    that is raised, if any. `released` are those of the released power where the vibration plays.
    """

    stated: StatedSound
    records: list[PageRecord]
    playback: dict[str, float | None]
    below_db: float
    lap: dict[str, float]
    solved: float
    ends: bool
    raised: listening.Raised | None
    released: "RunRecords | None" = None


class _Heard(NamedTuple):
    """A sound of a run, and the record of it that is heard.

    `is_of_record` tells whether it plays first, and not the released power beside it. `is_new`
    tells whether it was made, and not read from a file whose gain may change.
    """

    run: Run
    stated: StatedSound
    ear: listening.EarRecord
    is_of_record: bool
    is_new: bool


def of_runs(runs: Sequence[Run]) -> list[RunRecords]:
    """Return the records of runs that are compared on a page.

    Runs share a gain with the sounds of the same source: nobody compares vibration and release by
    ear, and the release is louder by tens of decibels.
    """
    sounds = [_heard(run, sound) for run in runs for sound in listening.new_sounds(run)]
    peaks_pa = [float(np.abs(sound.ear.pressure).max()) for sound in sounds]
    sources = [sound.stated.source for sound in sounds]
    # LAeq of the records, which a gain makes equal, also where an LAE is stated.
    levels_db = [_laeq_db(sound) for sound in sounds]
    playbacks = gains_by_source(sources, peaks_pa, levels_db)
    records: list[RunRecords] = []
    for sound, playback, own_db in zip(sounds, playbacks, levels_db, strict=True):
        beside = [
            level
            for source, level in zip(sources, levels_db, strict=True)
            if source == sound.stated.source and level is not None
        ]
        below_db = 0.0 if own_db is None else max(beside) - own_db
        of_sound = _records_of(sound, playback, below_db)
        if sound.is_of_record:
            records.append(of_sound)
        else:
            records[-1] = records[-1]._replace(released=of_sound)
    return records


def _heard(run: Run, sound: listening.ListenSound) -> _Heard:
    """Return a sound of a run with the record that is heard on the page."""
    ear = sound.for_the_ear
    if sound.stated.long is None and ear.raised is None:  # the page goes round by itself
        ear = listening.EarRecord(sound.stated.sound.channels, "")
    return _Heard(
        run=run,
        stated=sound.stated,
        ear=ear,
        is_of_record=sound.file == LISTEN,
        is_new=sound.stated is sound.written,
    )


def _laeq_db(sound: _Heard) -> float | None:
    """Return the LAeq of the first channel of a sound that is heard [dB]; None for silence."""
    stated = sound.stated
    played = stated.sound if stated.long is None else stated.long
    return laeq_db(played.pressure, played.sample_rate)


def _records_of(sound: _Heard, playback: dict[str, float | None], below_db: float) -> RunRecords:
    """Return the records of a sound with its gains."""
    stated = sound.stated
    heard_s = stated.sound.duration if stated.long is None else _seconds(stated.long)
    ends = sound.run.ends_within(heard_s)
    return RunRecords(
        stated=stated,
        records=_records(sound),
        playback=playback,
        below_db=below_db,
        lap=lap(stated.sound, stated.long, len(sound.ear.pressure), ends),
        solved=solved(stated.sound, stated.long),
        ends=ends,
        raised=sound.ear.raised,
    )


def prepare(run: Run) -> None:
    """Make the records of the sounds of a run that are not read from a file; the run keeps them."""
    for sound in listening.new_sounds(run):
        sound_of_run = _heard(run, sound)
        if sound_of_run.is_new:
            _records(sound_of_run)


def _records(sound: _Heard) -> list[PageRecord]:
    """Return the records of a sound, the one that is heard first; new ones are made once."""
    if not sound.is_new:
        return _made_records(sound)
    kept = sound.run.for_page
    key = "records", sound.stated.source
    if key not in kept:
        kept[key] = _made_records(sound)
    records: list[PageRecord] = kept[key]
    return records


def _made_records(sound: _Heard) -> list[PageRecord]:
    """Make the records of a sound, the one that is heard first."""
    stated = sound.stated
    prefix = "" if sound.is_of_record else "released-"
    of = "" if sound.is_of_record else " of the released power"
    records = []
    if sound.ear.content:
        full_pa = full_scale(float(np.abs(sound.ear.pressure).max()))
        record = PageRecord(
            name=f"{prefix}long",
            title=f"long record{of}",
            text=f"{stated.name}, long record, {stated.level.words}: {sound.ear.content}",
            src=compressed(sound.ear.pressure / full_pa),
            full_pa=full_pa,
            size=_wav_size(sound.ear.pressure),
            silent=False,
        )
        records.append(record)
    channels = stated.sound.channels
    full_pa = full_scale(float(np.abs(channels).max()))
    level = "" if sound.ear.content else f", {stated.level.words}"
    record = PageRecord(
        name=f"{prefix}run",
        title=f"solved record{of}",
        text=f"{stated.name}, record of the solved {stated.sound.duration:.4g} s{level}",
        src=lossless(channels / full_pa),
        full_pa=full_pa,
        size=_wav_size(channels),
        silent=not channels.any(),
    )
    records.append(record)
    if sound.run.result.passes is not None and stated.source == "release":
        content, sentence = listening.passes_wav(sound.run, 16)
        with soundfile.SoundFile(io.BytesIO(content)) as file:
            samples = file.read()
            gain = listening.gain_of_comment(file.comment).full_scale_per_pa
        record = PageRecord(
            name="passes",
            title="passes",
            text=f"released power pass by pass: {sentence}",
            src=compressed(samples),
            full_pa=1.0 / gain,
            size=_wav_size(samples),
            silent=not samples.any(),
        )
        records.append(record)
    return records


def _wav_size(samples: Array) -> str:
    """Return the size of a record as a WAV of 24 bits in words."""
    kilobytes = 3 * samples.size / 1000
    return f"{kilobytes:.0f} kB" if kilobytes < 1000 else f"{kilobytes / 1000:.1f} MB"


def lossless(samples: Array) -> str:
    """Return samples within full scale in 24 bits as a FLAC in a data URI."""
    steps = np.clip(np.rint(_FULL * samples), -_FULL, _FULL - 1).astype(np.int32) << 8
    return _embedded(steps, "FLAC", "audio/flac", subtype="PCM_24")


def compressed(samples: Array, compression: float = MP3) -> str:
    """Return samples within full scale as an MP3 in a data URI, or lossless where none is made."""
    if "MP3" not in soundfile.available_formats():
        return lossless(samples)
    options = {"compression_level": compression, "bitrate_mode": "VARIABLE"}
    return _embedded(samples, "MP3", "audio/mpeg", **options)


def _embedded(samples: Any, form: str, kind: str, **options: Any) -> str:
    """Return a sound file in a data URI."""
    content = io.BytesIO()
    soundfile.write(content, samples, wav.SAMPLE_RATE_HZ, format=form, **options)
    return maps.uri(kind, content.getvalue())


def lap(sound: ContactSound, long: Listening | None, samples: int, ends: bool) -> dict[str, float]:
    """Return the lap to which the end of the record that is heard, of so many samples, leads.

    The record of something that ends has no seam: all of it is one lap.
    """
    if ends:
        return asdict(Lap(0, samples))
    if long is None:
        return asdict(sound.lap)
    fade = fade_length(len(long.pressure), len(long.pressure) / long.sample_rate)
    return asdict(crossfaded_lap(long.pressure, fade, long.sample_rate))


def solved(sound: ContactSound, long: Listening | None) -> float:
    """Return the time [s] in the record that is heard at which the solved track ends."""
    own_s = len(sound.pressure) / sound.sample_rate
    if long is None:
        return own_s
    share = long.numbers.solved_share
    return min(own_s, _seconds(long) * (1.0 if share is None else share))


def _seconds(long: Listening) -> float:
    """Return the length of a long record [s]."""
    return len(long.pressure) / long.sample_rate


# ---- gains


def gains_by_source(
    sources: Sequence[str], peaks_pa: Sequence[float], laeq_db: Sequence[float | None]
) -> list[dict[str, float | None]]:
    """Compute the gains of records, as `gains`, among the records of each source."""
    computed: list[dict[str, float | None]] = [{} for _ in sources]
    for source in dict.fromkeys(sources):
        numbers = [number for number, other in enumerate(sources) if other == source]
        of_source = gains([peaks_pa[k] for k in numbers], [laeq_db[k] for k in numbers])
        for number, gain in zip(numbers, of_source, strict=True):
            computed[number] = gain
    return computed


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
