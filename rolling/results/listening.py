"""Records for the ear: at least five seconds of laps or a long record.

listen.wav has what plays, and released.wav the released power. long.wav is made on request, and so
is room.wav, the same in a room. passes.wav has the passes over a plate that remembers.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import soundfile

from acoustics import level, resampling, room, wav
from acoustics.arrays import Array
from acoustics.level import lae_db
from acoustics.numbers import decibels_a, rounded
from rolling.contact.track import Motion
from rolling.kinds.heard_sound import FileGain, HeardSound
from rolling.kinds.run_folder import LISTEN, RELEASED, RunFolder
from rolling.numbers.ball_numbers import Source
from rolling.numbers.file_facts import ListenFacts, RaisedEnd, SignalFacts
from rolling.numbers.run_file import StoredNumbers
from rolling.results.long_record import ends_within
from rolling.results.solved_run import NumberedRun
from rolling.results.stated_sound import (
    StatedSound,
    playing_source,
    sound_to_listen,
    stated_sound,
)
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import FADE_S, ContactSound
from rolling.sound.long_listening import Listening
from rolling.terminal.whole_files import make_below, read_regular, write_bytes

LONG = "long.wav"
ROOM = "room.wav"  # the same in a room
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


def record_for_ear(stated: StatedSound, motion: Motion) -> EarRecord:
    """Return the long record of a sound if its scene asks for one, or its record in laps.

    `motion` is that of the ball, which may come to rest.
    """
    if stated.long is not None:
        return long_ear_record(stated, stated.long)
    return record_in_laps_of(stated, motion)


def long_ear_record(stated: StatedSound, long: Listening) -> EarRecord:
    """Return a long record for the ear."""
    content = describe_long_record(stated, long)
    return _with_raised_end(stated.sound, EarRecord(long.channels, content))


def _with_raised_end(sound: ContactSound, record: EarRecord) -> EarRecord:
    """Return a record whose end, after impacts that have died away, is raised so that it is heard.

    Records that go round stay as they are.
    """
    if not sound.once or not record.pressure.any():
        return record
    rate = sound.sample_rate
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


def record_in_laps_of(stated: StatedSound, motion: Motion) -> EarRecord:
    """Return the record of a sound in laps for the ear."""
    content = describe_laps(stated.sound, motion)
    if stated.no_long:
        content += f"; no long record: {stated.no_long}"
    return _with_raised_end(stated.sound, EarRecord(record_in_laps(stated.sound, motion), content))


def record_in_laps(sound: ContactSound, motion: Motion) -> Array:
    """Return the record of all channels [Pa], or as many of its laps as last five seconds.

    The record of what ends has no laps.
    """
    record = sound.channels
    samples = round(MIN_S * sound.sample_rate)
    if ends_within(sound, motion, sound.duration) or len(record) >= samples:
        return record
    lap = sound.lap.samples(record)
    count = math.ceil(samples / len(lap))
    return np.concatenate([lap] * count)


def describe_laps(sound: ContactSound, motion: Motion) -> str:
    """Describe how a file for the ear follows from the record."""
    lap = sound.lap
    rate = sound.sample_rate
    if ends_within(sound, motion, sound.duration) or len(sound.pressure) >= MIN_S * rate:
        return f"the record, {sound.ends}"
    count = len(record_in_laps(sound, motion)) // len(lap)
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
    """Return the long record of a run, from its file where that holds it; None without one."""
    return stored_long_record(run) or run.long


def stored_long_record(run: NumberedRun) -> Listening | None:
    """Return the long record that a file of a stored run holds, as made; None without a whole one.

    It is that of the record of the run: the other source has none that is kept.
    """
    numbers = run.numbers.listening
    if run.stored is None or numbers is None or numbers.seconds is None:
        return None
    with suppress(OSError, ValueError, soundfile.LibsndfileError):
        file_name, facts = _file_of_record(run.stored)
        content = read_regular(run.folder / file_name, MAX_BYTES)
        with soundfile.SoundFile(io.BytesIO(content)) as file:
            if file.frames * file.channels > len(content):  # packed, so not of this program
                return None
            samples = file.read()
            rate = file.samplerate
            gain = gain_of_comment(file.comment)
        to_stated = 10 ** (facts.stated_gain_db / 20)
        channels = np.atleast_2d(samples.T) / (gain.full_scale_per_pa * to_stated)
        is_whole = abs(channels.shape[1] - numbers.seconds * rate) < 1
        if is_whole and np.isfinite(channels).all():
            right = channels[1] if len(channels) > 1 else None
            return Listening(channels[0], rate, numbers, right)
    return None


def _file_of_record(stored: StoredNumbers) -> tuple[str, ListenFacts]:
    """Return the file for the ear, with its facts, of the source of the record of a run."""
    listen = stored.files.listen
    released = stored.files.released
    if released is not None and listen.source != stored.numbers.record.source:
        return RELEASED, released
    return LISTEN, listen


def describe_long_record(stated: StatedSound, long: Listening) -> str:
    """Describe length, level, kurtosis, impacts and the solved share of a long record as made."""
    numbers = long.numbers
    is_event = stated.is_event
    own = decibels_a(stated.record.levels.laeq_db)
    if is_event:
        exposure_db = lae_db(stated.record.pressure, stated.record.sample_rate)
        own = f"has LAE {decibels_a(exposure_db)} re 1 s"
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
    name = stated.source_words
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
    """A sound of a run of a ball for the ear, and its file.

    Its file has a long record that is made anew, so that the bytes do not depend on an earlier
    file; it plays the one that an earlier file holds.

    Parameters
    ----------
    run : NumberedRun
        The run.
    source : vibration or release
        What is heard. Default: what plays.
    file : str
        Name of the file. Default: listen.wav.
    as_made : bool
        Whether it plays as it was made, and not at the level that is stated, as in the files of an
        earlier program. Default: at this level.
    """

    unit = "Pa"
    group: Source

    def __init__(
        self,
        run: NumberedRun,
        source: Source | None = None,
        file: str = LISTEN,
        as_made: bool = False,
    ) -> None:
        self._run = run
        self._as_made = as_made
        self.file = file
        self.group = source or playing_source(run, run.numbers)

    @cached_property
    def written(self) -> StatedSound:
        """The sound at the level that is stated, made anew."""
        return self._sound(None)

    @cached_property
    def stated(self) -> StatedSound:
        """The sound at the level that is stated, with the long record of an earlier file."""
        known = stored_long_record(self._run)
        if known is None or self.group != self._run.sound.source:
            return self.written
        return self._sound(known)

    def _sound(self, known: Listening | None) -> StatedSound:
        """Return the sound with a long record that is known, or made."""
        stated = sound_to_listen(self._run, self._run.numbers, self.group, known)
        return replace(stated, stated_db=None) if self._as_made else stated

    @cached_property
    def for_the_ear(self) -> EarRecord:
        """The record that is heard."""
        return record_for_ear(self.stated, self._run.scene.motion)

    @cached_property
    def _written_record(self) -> EarRecord:
        return record_for_ear(self.written, self._run.scene.motion)

    @property
    def samples(self) -> Array:
        """The pressure [Pa]."""
        return self.for_the_ear.pressure

    @property
    def words(self) -> str:
        """What the record holds."""
        return f"{self.stated.name}, {self.stated.level.words}; {self.for_the_ear.content}"

    @property
    def level_db(self) -> float | None:
        """Level of what is heard [dB(A)], before its end is raised; LAE of what ends."""
        return self.stated.level.level_db

    @cached_property
    def _own_gain(self) -> Gain:
        return own_gain(self._written_record)

    def _gains(self, common: float | None) -> tuple[Gain, Gain]:
        """Return its own gain, and the gain that is used."""
        own = self._own_gain
        if common is not None and own.rule != SILENCE:
            return own, Gain(common, COMMON_GAIN)
        return own, own

    def wav(self, common: float | None = None) -> bytes:
        """Return the file with a common gain [full scale per Pa], or with its own gain."""
        sound = self.written.sound
        record = self._written_record
        repeats = sound.loops or len(record.pressure) > len(sound.pressure)
        _, used = self._gains(common)
        loops = repeats and self.written.long is None
        return _wav(self._run, self.written, record, used, loops=loops)

    def facts(self, common: float | None = None) -> ListenFacts:
        """Return the content of the file and the meaning of its samples."""
        record = self._written_record
        stated = self.written
        rate = stated.sound.sample_rate
        own, used = self._gains(common)
        scale = used.full_scale_per_pa
        meaning = _meaning(stated, own, used)
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
            source=self.group,
            how=stated.how,
            measure=stated.measure,
            level_db=stated.level.level_db,
            stated_gain_db=stated.level.gain_db,
            duration_s=len(record.pressure) / rate,
            rule=used.rule,
            pascal_per_full_scale=1.0 / scale,
            gain_full_scale_per_pa=scale,
            gain_db_re_1_per_pa=20.0 * math.log10(scale),
            own_gain_full_scale_per_pa=own.full_scale_per_pa,
            common_gain_full_scale_per_pa=common,
            raised=raised,
        )


def listen_sounds(run: NumberedRun) -> list[ListenSound]:
    """Return the sounds of the files of a run for the ear, that of listen.wav first.

    A run of an earlier program has the source of its record in listen.wav, and no other file.
    """
    stored = run.stored
    if stored is not None and stored.files.released is None and run.release is not None:
        return [ListenSound(run, _source_of(stored), as_made=True)]
    return new_sounds(run)


def new_sounds(run: NumberedRun) -> list[ListenSound]:
    """Return the sounds of a run for the ear as its files have them when they are made now."""
    sounds = [ListenSound(run)]
    if run.release is not None:
        sounds.append(ListenSound(run, "release", RELEASED))
    return sounds


def listen_gains(stored: StoredNumbers) -> Iterator[FileGain]:
    """Yield the gains of the files for the ear of a run of a ball; a silent one shares none.

    Vibration and release have gains of their own, because one does not compare the two by ear.
    """
    for file, facts in ((LISTEN, stored.files.listen), (RELEASED, stored.files.released)):
        if facts is None or facts.own_gain_full_scale_per_pa <= 0.0 or facts.rule == SILENCE:
            continue
        yield FileGain(
            file=file,
            group=_source_of(stored) if file == LISTEN else "release",
            own=facts.own_gain_full_scale_per_pa,
            used=facts.common_gain_full_scale_per_pa,
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


def _meaning(stated: StatedSound, own: Gain, used: Gain) -> str:
    """Say what the samples of a file for the ear are, and what its gain does to the ear."""
    text = (
        "Samples times pascal_per_full_scale are sound pressure in Pa at the listener; "
        f"{_CONSEQUENCES[used.rule]}. They are of the {stated.name}: {stated.level.words}."
    )
    if stated.source == "release":
        text += " The record is of the released power; which ball is louder, the vibration says."
    lowered_db = 20.0 * math.log10(own.full_scale_per_pa / used.full_scale_per_pa)
    if lowered_db > QUIET_DB:
        text += (
            f" This run plays {lowered_db:.0f} dB below the level at which it would play alone, so"
            " you may not hear it. Its own gain is own_gain_full_scale_per_pa; the page makes the"
            " runs equally loud with one switch."
        )
    return text


def signal_facts(sound: ContactSound, for_the_ear: str) -> SignalFacts:
    """Say what the samples of a file in pascals are, and whether a player clips them."""
    peak_pa = float(np.abs(sound.channels).max())
    meaning = "Samples are sound pressure in Pa at the listener, for calculations, not for playing"
    if peak_pa > 1.0:
        meaning += f": the peak of {peak_pa:.3g} Pa lies above full scale, and a player clips it"
    return SignalFacts(meaning=f"{meaning}; {for_the_ear} is for the ear.", peak_pa=peak_pa)


def refuse_reverberation(reverberation_s: float) -> None:
    """Raise ValueError for a reverberation time [s] that no room of `acoustics` has."""
    if not room.SHORTEST_S <= reverberation_s <= room.LONGEST_S:
        allowed = f"{room.SHORTEST_S:g} to {room.LONGEST_S:g} s"
        raise ValueError(f"reverberation: got {reverberation_s:g} s, allowed: {allowed}")


def record_in_room(record: EarRecord, reverberation_s: float, distance_m: float) -> EarRecord:
    """Return a record as it is heard in a room, which its content says and no level includes.

    Parameters
    ----------
    record : EarRecord. The record in the free field.
    reverberation_s : float, s. Reverberation time.
    distance_m : float, m. Distance of the listener from the source.
    """
    pressure = room.in_room(record.pressure, reverberation_s, distance_m, wav.SAMPLE_RATE_HZ)
    content = f"{record.content}; {words_of_room(reverberation_s)}"
    return record._replace(pressure=pressure, content=content)


def words_of_room(reverberation_s: float) -> str:
    """Say in which room a record is heard, and that no level has it."""
    return (
        f"heard in a made room of {room.VOLUME_M3:g} m3 with a reverberation time of"
        f" {reverberation_s:g} s, which no level includes"
    )


def write_long(run: NumberedRun, long: Listening, reverberation_s: float | None = None) -> Path:
    """Write long.wav, a long record of what plays for the ear, and return its path.

    With a reverberation time [s] the record is heard in a room, and written to room.wav. A run of a
    sweep keeps the common gain of listen.wav, unless the record would clip.

    Raises
    ------
    OSError : the file cannot be written. An earlier file is kept.
    """
    playing = playing_source(run, run.numbers)
    stated = stated_sound(run, run.numbers, playing)
    record = long_ear_record(stated, long)
    path = run.folder / LONG
    if reverberation_s is not None:
        path = run.folder / ROOM
        record = record_in_room(record, reverberation_s, run.scene.listener_distance_m)
    gain = own_gain(record)
    common = None
    if run.stored is not None and _source_of(run.stored) == playing:
        common = run.stored.files.listen.common_gain_full_scale_per_pa
    if common is not None and common < gain.full_scale_per_pa:
        gain = Gain(common, COMMON_GAIN)
    make_below(run.home, run.folder)
    write_bytes(path, _wav(run, stated, record, gain, loops=False))
    return path


def content_words(stored: StoredNumbers) -> str:
    """Say what the listen.wav of a stored run holds, a vibration with how it was found."""
    if _source_of(stored) == "release":
        return "released power"
    return f"vibration, {stored.numbers.vibration.how}"


def _source_of(stored: StoredNumbers) -> Source:
    """Return what the listen.wav of a stored run holds."""
    return stored.files.listen.source or stored.numbers.record.source


def _wav(
    run: NumberedRun, stated: StatedSound, record: EarRecord, gain: Gain, loops: bool
) -> bytes:
    """Return a record as a WAV, with a loop where it repeats."""
    comment = (
        f"{comment_of_gain(gain)}; {stated.name}, {stated.level.words}; {record.content}; "
        f"{wav_comment(run, stated.sound)}"
    )
    title = wav_title(run, run.label)
    return wav.listening(record.pressure, gain.full_scale_per_pa, comment, title, loops=loops)


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


def wav_comment(run: NumberedRun, sound: ContactSound) -> str:
    """Write the facts that the comment of a sound file holds: place, source and ends."""
    where = _place(run.scene, sound)
    return f"{wav_title(run, run.label)}; {where}, {_source(run.scene, sound)}; {sound.ends}"


def _place(scene: Scene, sound: ContactSound) -> str:
    """Name the place of the listeners."""
    if sound.source != "vibration" or scene.sound.listener_mm is None:
        return f"distance {scene.sound.distance_m:g} m"
    if sound.right is None:
        return f"listener at {scene.listener_place}"
    left, right = scene.sound.listener_mm[:2]
    return f"listeners left and right at {list(left)} and {list(right)} mm"


def _source(scene: Scene, sound: ContactSound) -> str:
    """Name the source of the sound, a release with its factor."""
    if sound.factor is not None:
        return f"q {scene.sound.q:g}, {sound.factor:.6g} Pa per W/m2 of fluctuation"
    bodies = "plate and sphere" if scene.sound.ball else "plate"
    where = "on the axis" if scene.plate.edges_mm is None else "with edges"
    return f"vibration of {bodies} {where}"
