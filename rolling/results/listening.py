"""Records for the ear: listen.wav, at least five seconds of laps or a long record; long.wav.

passes.wav has the passes over a plate that remembers.
"""

from __future__ import annotations

import io
import math
import os
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import soundfile

from acoustics import level, resampling, wav
from acoustics.arrays import Array
from acoustics.numbers import decibels_a, rounded
from rolling.kinds.heard_sound import FileGain, HeardSound, played_sound
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, RunFolder
from rolling.numbers.file_facts import ListenFacts, RaisedEnd, SignalFacts
from rolling.numbers.run_file import StoredNumbers
from rolling.results.solved_run import NumberedRun
from rolling.sound.contact_sound import FADE_S, ContactSound
from rolling.sound.long_listening import Listening
from rolling.terminal import progress
from rolling.terminal.whole_files import make_below, read_regular, write_bytes, write_temporary

# [s] of a pass for the ear, and of the silence after it
PASS_S = 1.5
PAUSE_S = 0.25
MAX_PASSES = 12  # in passes.wav; of more, it holds passes in a geometric sequence
MIN_S = 5.0  # [s] of listen.wav; a shorter record is a click
MAX_BYTES = 50_000_000  # of a listen.wav; 120 s of two channels take 35 million
# A record that is heard once has died away where its level LAF stays so far below its maximum
# [dB], or within so many decibels of the level at which it ends: a marble that has bounced rolls
# on. What follows is raised, for no longer than so many seconds, if it is much quieter.
DEAD_DB = 60.0
NEAR_END_DB = 3.0
MUCH_QUIETER_DB = 30.0
MAX_RAISED_S = 4.0
MIN_RAISED_S = 0.25
QUIET_DB = 30.0  # below the loudest run of a sweep, from which on a run may be inaudible beside it
# Rules of the gain of listen.wav, and what each means for whoever hears it.
SILENCE = "silence"
LARGEST_GAIN = "the largest gain"
EQUAL_LOUDNESS = "equal loudness"
COMMON_GAIN = "the common gain of its sweep"
_CONSEQUENCES = {
    SILENCE: "the record is silent, and the gain is 1",
    LARGEST_GAIN: (
        "the gain is the largest there is, that of a record at 0 dB(A): this record is below and"
        " stays quieter than others"
    ),
    EQUAL_LOUDNESS: (
        "the gain makes runs equally loud, so compare their levels by the numbers, not by ear"
    ),
    COMMON_GAIN: "all runs of the sweep have this gain, so a louder record sounds louder",
}


class Raised(NamedTuple):
    """The end of a record that is raised: its first sample, and its factor over the beginning."""

    begin: int
    factor: float

    @property
    def decibels(self) -> float:
        """The factor [dB]."""
        return 20.0 * math.log10(self.factor)


class EarRecord(NamedTuple):
    """A record for the ear: its pressure [Pa], (samples,) or (samples, 2), and its content.

    The pressure of an end that is raised is that of the sound times its factor.
    """

    pressure: Array
    content: str
    raised: Raised | None = None


class Gain(NamedTuple):
    """The gain of a record for the ear [full scale per Pa], and the rule that it follows."""

    full_scale_per_pa: float
    rule: str


# ---- records


def record_for_ear(run: NumberedRun) -> EarRecord:
    """Return the long record of a run if its scene asks for it, or its record in laps."""
    long = long_record_of(run)
    if long is not None:
        return long_ear_record(run, long)
    return record_in_laps_of(run)


def long_ear_record(run: NumberedRun, long: Listening) -> EarRecord:
    """Return a long record for the ear."""
    return _with_raised_end(run, EarRecord(long.channels, describe_long_record(run, long)))


def _with_raised_end(run: NumberedRun, record: EarRecord) -> EarRecord:
    """Return a record whose end, after impacts that have died away, is raised so that it is heard.

    Records that go round stay as they are.
    """
    if not run.sound.once or not record.pressure.any():
        return record
    rate = run.sound.sample_rate
    begin = _end_of_impacts(record.pressure, rate)
    end = min(len(record.pressure), begin + round(MAX_RAISED_S * rate))
    if end - begin < MIN_RAISED_S * rate:
        return record
    ends = round(FADE_S * rate)
    impacts = _faded(record.pressure[:begin], ends)
    rest = _faded(record.pressure[begin:end], ends)
    content = f"{record.content}; the impacts end after {rounded(begin / rate, 3)} s"
    factor = wav.listening_gain(rest) / wav.listening_gain(impacts)
    if factor <= 1.0 or not rest.any():
        return EarRecord(impacts, content)
    raised = Raised(begin, factor)
    content += f", and what follows is raised by {raised.decibels:.0f} dB"
    return EarRecord(np.concatenate((impacts, factor * rest)), content, raised)


def _end_of_impacts(pressure: Array, rate: int) -> int:
    """Return the sample from which on a record has died away; its length if it does not."""
    first = pressure if pressure.ndim == 1 else pressure[:, 0]
    square = level.running_mean_square(level.a_weighted(first, rate), rate, level.FAST_S, False)
    largest = float(square.max())
    at_its_end = float(np.median(square[len(square) // 2 :]))
    if at_its_end > largest * 10.0 ** (-MUCH_QUIETER_DB / 10.0):
        return len(pressure)
    dead = max(largest * 10.0 ** (-DEAD_DB / 10.0), at_its_end * 10.0 ** (NEAR_END_DB / 10.0))
    return int(np.flatnonzero(square > dead)[-1]) + 1


def _faded(record: Array, samples: int) -> Array:
    """Fade both ends of a record of one channel or two."""
    if record.ndim == 1:
        return resampling.fade(record, samples)
    return np.stack([resampling.fade(channel, samples) for channel in record.T], 1)


def record_in_laps_of(run: NumberedRun) -> EarRecord:
    """Return the record of a run in laps for the ear."""
    content = describe_laps(run)
    if run.scene.sound.listen_s is not None:
        content += f"; no long record: {run.no_long}"
    return _with_raised_end(run, EarRecord(record_in_laps(run), content))


def record_in_laps(run: NumberedRun) -> Array:
    """Return the record of all channels [Pa], or as many of its laps as last five seconds.

    The record of what ends has no laps.
    """
    sound = run.sound
    record = sound.channels
    samples = round(MIN_S * sound.sample_rate)
    if run.ends_within(sound.duration) or len(record) >= samples:
        return record
    lap = sound.lap.samples(record)
    count = math.ceil(samples / len(lap))
    return np.concatenate([lap] * count)


def describe_laps(run: NumberedRun) -> str:
    """Describe how listen.wav follows from the record."""
    sound = run.sound
    lap = sound.lap
    rate = sound.sample_rate
    if run.ends_within(sound.duration) or len(sound.pressure) >= MIN_S * rate:
        return f"the record, {sound.ends}"
    count = len(record_in_laps(run)) // len(lap)
    duration = rounded(sound.duration, 3)
    if sound.loops:
        return f"{count} laps of the record of {duration} s, which closes on itself"
    change_db = round(20 * math.log10(lap.factor), 1) + 0.0  # without the sign of a zero
    return (
        f"{count} laps of the record, which does not close: {rounded(len(lap) / rate, 3)} s of its "
        f"{duration} s, cross-faded over {rounded(lap.overlap / rate * 1e3)} ms at points of equal "
        f"slope and scaled by {change_db:+.1f} dB to its LAeq"
    )


def long_record_of(run: NumberedRun) -> Listening | None:
    """Return the long record of a run, from listen.wav where that holds it; None without one."""
    return _stored_long_record(run) or run.long


def _stored_long_record(run: NumberedRun) -> Listening | None:
    """Return the long record that listen.wav of a stored run holds; None without a whole one."""
    numbers = run.numbers.listening
    if run.stored is None or numbers is None or numbers.seconds is None:
        return None
    with suppress(OSError, ValueError, soundfile.LibsndfileError):
        content = read_regular(run.folder / LISTEN, MAX_BYTES)
        with soundfile.SoundFile(io.BytesIO(content)) as file:
            if file.frames * file.channels > len(content):  # packed, so not of this program
                return None
            samples = file.read()
            rate = file.samplerate
            gain = gain_of_comment(file.comment)
        channels = np.atleast_2d(samples.T) / gain.full_scale_per_pa
        is_whole = abs(channels.shape[1] - numbers.seconds * rate) < 1
        if is_whole and np.isfinite(channels).all():
            right = channels[1] if len(channels) > 1 else None
            return Listening(channels[0], rate, numbers, right)
    return None


def describe_long_record(run: NumberedRun, long: Listening) -> str:
    """Describe length, level, kurtosis, impacts and the solved share of a long record."""
    numbers = long.numbers
    is_event = run.numbers.record.single_event
    own = decibels_a(run.sound.levels.laeq_db)
    if is_event:
        own = f"has LAE {decibels_a(run.numbers.played.lae_db)} re 1 s"
    if numbers.ends:
        own += " in its solved part"
    kurtosis = "-" if numbers.kurtosis is None else f"{numbers.kurtosis:.2f}"
    seconds = numbers.seconds or 0.0
    solved_mm = numbers.solved_mm or 0.0
    rolled_mm = numbers.rolled_mm or 0.0
    track = "all solved"
    if solved_mm < rolled_mm:
        track = (
            f"of which the first {rounded(solved_mm, 3)} mm "
            f"({rounded(100 * (numbers.solved_share or 0.0))} % of the time) are solved and the "
            f"others follow their statistics at random (seed {numbers.seed})"
        )
    name = "vibration" if run.numbers.record.source == "vibration" else "released power"
    level_words = f"LAeq of the {name} {decibels_a(numbers.laeq_db)}"
    if numbers.ends and is_event:
        level_words = f"LAE of the {name} {decibels_a(numbers.lae_db)} re 1 s"
    text = (
        f"{rounded(seconds, 4)} s over {rounded(rolled_mm, 3)} mm, {track}: "
        f"{level_words} (the run {own}), kurtosis {kurtosis}"
    )
    if numbers.impacts is not None:
        text += f", {rounded(numbers.impacts / seconds, 3)} impacts per second"
    if numbers.stretches:
        text += f", {numbers.stretches} rare stretches inserted as solved"
    return text


# ---- files


class ListenSound(HeardSound):
    """The record for the ear of a run of a ball, and its listen.wav.

    Its file has a long record that is made anew, so that the bytes do not depend on an earlier
    file; it plays the one that an earlier file holds.
    """

    file = LISTEN
    unit = "Pa"

    def __init__(self, run: NumberedRun) -> None:
        self._run = run
        self.group = run.numbers.record.source

    @cached_property
    def _for_the_ear(self) -> EarRecord:
        return record_for_ear(self._run)

    @cached_property
    def _written(self) -> EarRecord:
        run = self._run
        return record_in_laps_of(run) if run.long is None else long_ear_record(run, run.long)

    @property
    def samples(self) -> Array:
        """The pressure [Pa]."""
        return self._for_the_ear.pressure

    @property
    def words(self) -> str:
        """What the record holds."""
        return self._for_the_ear.content

    @property
    def level_db(self) -> float | None:
        """LAeq of the record that is heard [dB(A)]: of the long record if there is one."""
        long = self._run.numbers.listening
        if long is not None and long.refused is None:
            return long.laeq_db
        return self._run.numbers.played.laeq_db

    def _gains(self, common: float | None) -> tuple[Gain, Gain]:
        """Return its own gain, and the gain that is used."""
        own = own_gain(self._written)
        if common is not None and own.rule != SILENCE:
            return own, Gain(common, COMMON_GAIN)
        return own, own

    def wav(self, common: float | None = None) -> bytes:
        """Return listen.wav with a common gain [full scale per Pa], or with its own gain."""
        run = self._run
        record = self._written
        repeats = run.sound.loops or len(record.pressure) > len(run.sound.pressure)
        _, used = self._gains(common)
        return _wav(run, record, used, loops=repeats and run.long is None)

    def facts(self, common: float | None = None) -> ListenFacts:
        """Return the content of listen.wav and the meaning of its samples."""
        record = self._written
        rate = self._run.sound.sample_rate
        own, used = self._gains(common)
        scale = used.full_scale_per_pa
        meaning = _meaning(self.group, own, used)
        raised = None
        if record.raised is not None:
            meaning += (
                " From raised.begin_s on, the factor is raised.pascal_per_full_scale: what follows"
                " the impacts has a gain of its own, so that it is heard."
            )
            raised = RaisedEnd(
                begin_s=record.raised.begin / rate,
                raised_db=record.raised.decibels,
                pascal_per_full_scale=1.0 / (scale * record.raised.factor),
            )
        return ListenFacts(
            content=record.content,
            meaning=meaning,
            duration_s=len(record.pressure) / rate,
            rule=used.rule,
            pascal_per_full_scale=1.0 / scale,
            gain_full_scale_per_pa=scale,
            gain_db_re_1_per_pa=20.0 * math.log10(scale),
            own_gain_full_scale_per_pa=own.full_scale_per_pa,
            common_gain_full_scale_per_pa=common,
            raised=raised,
        )


def listen_gains(stored: StoredNumbers) -> Iterator[FileGain]:
    """Yield the gains of the listen.wav of a run of a ball; a silent one shares none.

    Vibration and release have gains of their own, because one does not compare the two by ear.
    """
    listen = stored.files.listen
    own = listen.own_gain_full_scale_per_pa
    if own <= 0.0 or listen.rule == SILENCE:
        return
    yield FileGain(
        file=LISTEN,
        group=stored.numbers.record.source,
        own=own,
        used=listen.common_gain_full_scale_per_pa,
        words=words_of_common_gain,
    )


def words_of_common_gain(gain: float) -> str:
    """Return the words with which the comment of a listen.wav names a common gain."""
    return comment_of_gain(Gain(gain, COMMON_GAIN))


def own_gain(record: EarRecord) -> Gain:
    """Return the gain that makes a record as loud as others, with six digits, and its rule."""
    whole = record.pressure
    impacts = whole if record.raised is None else whole[: record.raised.begin]
    gain = float(f"{wav.listening_gain(impacts):.6g}")  # as the comment of the file has it
    if np.abs(record.pressure).max() < np.finfo(float).tiny:
        return Gain(gain, SILENCE)
    if gain >= float(f"{wav.MAX_GAIN:.6g}"):
        return Gain(gain, LARGEST_GAIN)
    return Gain(gain, EQUAL_LOUDNESS)


def _meaning(source: str, own: Gain, used: Gain) -> str:
    """Say what the samples of listen.wav are, and what its gain does to the ear."""
    text = (
        "Samples times pascal_per_full_scale are sound pressure in Pa at the listener; "
        f"{_CONSEQUENCES[used.rule]}."
    )
    if source == "release":
        text += " The record is of the released power; which ball is louder, the vibration says."
    lowered_db = 20.0 * math.log10(own.full_scale_per_pa / used.full_scale_per_pa)
    if lowered_db > QUIET_DB:
        text += (
            f" This run plays {lowered_db:.0f} dB below the level at which it would play alone, so"
            " you may not hear it. Its own gain is own_gain_full_scale_per_pa; the page makes the"
            " runs equally loud with one switch."
        )
    return text


def signal_facts(sound: ContactSound) -> SignalFacts:
    """Say what the samples of signal.wav are, and whether a player clips them."""
    peak_pa = float(np.abs(sound.channels).max())
    meaning = "Samples are sound pressure in Pa at the listener, for calculations, not for playing"
    if peak_pa > 1.0:
        meaning += f": the peak of {peak_pa:.3g} Pa lies above full scale, and a player clips it"
    return SignalFacts(meaning=f"{meaning}; listen.wav is for the ear.", peak_pa=peak_pa)


def write_long(run: NumberedRun, long: Listening) -> Path:
    """Write long.wav, a long record for the ear, and return its path.

    A run of a sweep keeps the common gain of listen.wav, unless the record would clip.

    Raises
    ------
    OSError : the file cannot be written. An earlier file is kept.
    """
    path = run.folder / "long.wav"
    record = long_ear_record(run, long)
    gain = own_gain(record)
    common = None
    if run.stored is not None:
        common = run.stored.files.listen.common_gain_full_scale_per_pa
    if common is not None and common < gain.full_scale_per_pa:
        gain = Gain(common, COMMON_GAIN)
    make_below(run.home, run.folder)
    write_bytes(path, _wav(run, record, gain, loops=False))
    return path


def _wav(run: NumberedRun, record: EarRecord, gain: Gain, loops: bool) -> bytes:
    """Return a record as a WAV, with a loop where it repeats."""
    comment = f"{comment_of_gain(gain)}; {record.content}; {wav_comment(run)}"
    return wav.listening(
        record.pressure, gain.full_scale_per_pa, comment, wav_title(run, run.label), loops=loops
    )


def comment_of_gain(gain: Gain) -> str:
    """Return the words on its gain with which the comment of a file begins."""
    return f"{gain.full_scale_per_pa:.6g} full scale per Pa, {gain.rule}"


def gain_of_comment(comment: str) -> Gain:
    """Return the gain that the comment of a file names; raise ValueError where it names none."""
    words, _, _ = comment.partition(";")
    number, _, rule = words.partition(" full scale per Pa, ")
    gain = float(number)
    if not (math.isfinite(gain) and gain > 0.0):
        raise ValueError(f"{gain}: no gain")
    return Gain(gain, rule)


def passes_wav(run: NumberedRun, bits: Literal[16, 24] = 24) -> tuple[bytes, str]:
    """Return a WAV of the passes of a run in sequence, and a description of its content."""
    count = len(run.pass_sounds)
    numbers = np.arange(1, count + 1)
    if count > MAX_PASSES:
        numbers = np.unique(np.geomspace(1, count, MAX_PASSES).round().astype(int))
    rate = wav.SAMPLE_RATE_HZ
    pause = np.zeros(round(PAUSE_S * rate))
    parts = []
    levels = []
    for number in numbers:
        sound = run.pass_sounds[number - 1]
        lap = sound.lap.samples(sound.pressure)
        repeated = np.resize(lap, round(PASS_S * rate))
        parts.append(resampling.fade(repeated, round(FADE_S * rate)))
        parts.append(pause)
        levels.append(f"{number} ({decibels_a(sound.levels.laeq_db)})")
    record = np.concatenate(parts)
    content = f"{PASS_S:g} s of each pass at one gain, with its LAeq: {', '.join(levels)}"
    gain = own_gain(EarRecord(record, content))
    comment = f"{comment_of_gain(gain)}; {content}"
    scale = gain.full_scale_per_pa
    return wav.listening(record, scale, comment, wav_title(run, run.label), bits), content


def wav_title(run: RunFolder, label: str) -> str:
    """Return the title of the sound files of a run under a label."""
    return f"{run.scene.name}, {label}"


def wav_comment(run: NumberedRun) -> str:
    """Write the facts that the comment of a sound file holds: place, source and ends."""
    return f"{wav_title(run, run.label)}; {_place(run)}, {_source(run)}; {run.sound.ends}"


def _place(run: NumberedRun) -> str:
    """Name the place of the listeners."""
    scene = run.scene
    if run.sound.source != "vibration" or scene.sound.listener_mm is None:
        return f"distance {scene.sound.distance_m:g} m"
    if run.sound.right is None:
        return f"listener at {scene.listener_place}"
    left, right = scene.sound.listener_mm[:2]
    return f"listeners left and right at {list(left)} and {list(right)} mm"


def _source(run: NumberedRun) -> str:
    """Name the source of the sound, a release with its factor."""
    scene = run.scene
    if run.sound.factor is not None:
        return f"q {scene.sound.q:g}, {run.sound.factor:.6g} Pa per W/m2 of fluctuation"
    bodies = "plate and sphere" if scene.sound.ball else "plate"
    where = "on the axis" if scene.plate.edges_mm is None else "with edges"
    return f"vibration of {bodies} {where}"


# ---- players


def play(run: Any) -> Any:
    """Return a player in a notebook; in a script, name a sound file and open a player for it.

    Raises
    ------
    ValueError : the kind of the run has no sounds.
    """
    kind = kind_of(run.scene)
    sound = played_sound(kind.sounds(run))
    if sound is None:
        raise ValueError(f"{kind.name}: runs of this kind have no sound")
    if progress.in_notebook():
        from IPython.display import Audio

        samples = sound.samples * wav.listening_gain(sound.samples)
        return Audio(samples.T, rate=wav.SAMPLE_RATE_HZ, normalize=False)
    path = run.folder / sound.file
    is_stored = run.stored is not None and path.is_file()
    if not is_stored:
        path = write_temporary(f"{run.scene.name}-listen-", ".wav", sound.wav())
    print(f"listen: {path}   {sound.words}")
    _open_player(path)
    return None


def _open_player(path: Path) -> None:
    """Play a file by the player of the desktop, where a person sits at a terminal of one."""
    has_display = {"DISPLAY", "WAYLAND_DISPLAY"} & {*os.environ}
    has_desktop = sys.platform in ("darwin", "win32") or has_display
    if has_desktop and sys.stdout.isatty() and "CI" not in os.environ:
        webbrowser.open(path.resolve().as_uri())
