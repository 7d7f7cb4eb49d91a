"""Sounds of a run at the levels that are stated for them, and which of them plays.

A run may have two: the vibration, computed or estimated, and the released power. The vibration
plays, and the release where nothing vibrates.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from acoustics.level import lae_db, laeq_db
from rolling.kinds.stated_level import StatedLevel
from rolling.numbers.ball_numbers import EstimateNumbers, HeardNumbers, RunNumbers, Source
from rolling.results import long_record
from rolling.results.estimated_vibration import approach_of, contact_stiffness, linear_vibration
from rolling.results.long_record import ListeningError, Speed
from rolling.results.run_quantities import LAE, LAEQ, exposure_db
from rolling.results.solved_run import SolvedRun
from rolling.sound.contact_sound import ContactSound
from rolling.sound.linear_sound import LinearVibration, linear_sound
from rolling.sound.long_listening import Listening
from rolling.sound.vibration_sound import Vibration, sound_of_vibration


@dataclass(frozen=True, eq=False)
class StatedSound:
    """Sound of one source of a run, with the level that is stated for it.

    Attributes
    ----------
    source : str
        Vibration or release.
    how : str
        How it was found: computed, estimated, upper bound or assumed.
    record : ContactSound
        Sound along the track as it was made.
    measure : str
        LAeq, or LAE of what ends.
    is_event : bool
        Whether the record of the run is a single event.
    stated_db : float or None, dB
        Level that is stated; None where none is.
    spread_db : float, dB
        Standard uncertainty of this level, which is the largest gain.
    long_record : Listening or None
        The same beyond the solved track, with `sound.listen_s`; then it is what plays.
    no_long : str
        Reason why there is no long record although the scene asks for one; empty otherwise.
    """

    source: Source
    how: str
    record: ContactSound
    measure: str
    is_event: bool
    stated_db: float | None
    spread_db: float
    long_record: Listening | None = None
    no_long: str = ""

    @cached_property
    def level(self) -> StatedLevel:
        """Level of what plays, beside the level that is stated."""
        played = self.record if self.long_record is None else self.long_record
        level = lae_db if self.measure == LAE else laeq_db
        return StatedLevel(
            own_db=level(played.pressure, played.sample_rate),
            stated_db=self.stated_db,
            spread_db=self.spread_db,
            measure=self.measure,
        )

    @cached_property
    def sound(self) -> ContactSound:
        """Sound along the track with its gain."""
        return self.record.scaled(self.level.gain_db)

    @property
    def along_track(self) -> ContactSound:
        """Sound along the track at the level that is stated, with a gain of its own."""
        return replace(self, long_record=None).sound

    @cached_property
    def long(self) -> Listening | None:
        """Long record with its gain."""
        return None if self.long_record is None else self.long_record.scaled(self.level.gain_db)

    @property
    def source_words(self) -> str:
        """The source in words."""
        return "vibration" if self.source == "vibration" else "released power"

    @property
    def name(self) -> str:
        """The source in words, and how it was found."""
        return f"{self.source_words}, {self.how}"

    @property
    def numbers(self) -> HeardNumbers:
        """Facts about the sound, as a run stores them of the one that plays."""
        return HeardNumbers(
            source=self.source,
            level_db=self.level.level_db,
            gain_db=self.level.gain_db,
            departure_db=self.level.departure_db,
            long_s=None if self.long_record is None else self.long_record.numbers.seconds,
        )


def playing_source(run: SolvedRun, numbers: RunNumbers) -> Source:
    """Return the source that plays: the vibration, or the release where nothing vibrates."""
    if numbers.vibration.value is None and run.release is not None:
        return "release"
    return "vibration"


def stated_sound(run: SolvedRun, numbers: RunNumbers, source: Source) -> StatedSound:
    """Return the sound of a source of a run along its track, at the level that is stated for it.

    Raises
    ------
    ValueError : the run has no sound of this source.
    """
    stated = _stated(numbers, _made(run, numbers, source).record)
    if numbers.heard_whole is not None:  # the level is that of the long record
        return replace(stated, stated_db=None)
    return stated


def sound_to_listen(
    run: SolvedRun, numbers: RunNumbers, source: Source, known: Listening | None = None
) -> StatedSound:
    """Return the sound of a source of a run as one listens to it: with its long record, if any.

    Parameters
    ----------
    run : SolvedRun. The run.
    numbers : RunNumbers. Its numbers.
    source : vibration or release. What is heard.
    known : Listening. The long record, as made. Default: it is made.

    Raises
    ------
    ValueError : the run has no sound of this source.
    """
    made = _made(run, numbers, source)
    stated = _stated(numbers, made.record)
    if run.scene.sound.listen_s is None:
        return stated
    no_long = ""
    long = known
    if long is None:
        no_long = made.no_long
        long = made.long
    stated = replace(stated, long_record=long, no_long=no_long)
    if long is None or long.numbers.ends:
        return stated
    if not made.record.constant_speed:  # it goes on at other speeds, for which no level is stated
        return replace(stated, measure=LAEQ, stated_db=None)
    if stated.measure == LAEQ or stated.stated_db is None:
        return stated
    return replace(stated, measure=LAEQ, stated_db=stated.stated_db - exposure_db(numbers))


def whole_vibration_db(run: SolvedRun, numbers: RunNumbers) -> float | None:
    """Return LAeq of the whole record of a vibration that ends, beside a release [dB(A)].

    It is the level of the solved part, as it is stated, with the decibels by which the whole record
    lies above that part. None where nothing vibrates, ends, or where the vibration is measured.
    """
    solved_db = _solved_vibration_db(numbers)
    if solved_db is None or numbers.record.source == "vibration" or numbers.heard_whole is None:
        return None
    made = _made(run, numbers, "vibration")
    if made.long is None:
        return None
    own_db = laeq_db(made.record.pressure, made.record.sample_rate)
    whole_db = laeq_db(made.long.pressure, made.long.sample_rate)
    if own_db is None or whole_db is None:
        return None
    return solved_db + whole_db - own_db


def _solved_vibration_db(numbers: RunNumbers) -> float | None:
    """Return LAeq of a vibration along the solved track [dB(A)]; None where nothing vibrates."""
    if numbers.levels.vibration is not None:
        return numbers.levels.vibration.laeq_db
    return None if numbers.estimate is None else numbers.estimate.laeq_db


def _stated(numbers: RunNumbers, record: ContactSound) -> StatedSound:
    """Return a record with the level that numbers state for its source."""
    quantity = numbers.vibration if record.source == "vibration" else numbers.released_power
    spread_db = quantity.uncertainty
    if spread_db is None:  # a release beside a computed vibration has the ± of its record
        spread_db = record.uncertainty.laeq_db or 0.0
    return StatedSound(
        source=record.source,
        how=quantity.how,
        record=record,
        measure=quantity.measure,
        is_event=numbers.record.single_event,
        stated_db=quantity.value,
        spread_db=spread_db,
    )


def listen(
    run: SolvedRun,
    numbers: RunNumbers,
    seconds: float,
    speed: Speed | None,
    seed: int,
    source: Source | None = None,
) -> Listening:
    """Return a long record of a source of a run, by default of what plays, as it is made.

    Raises
    ------
    ListeningError : a number is not allowed, or there is a reason against such a record.
    ValueError : the run has no sound of this source.
    """
    long_record.refuse_long_record(seconds, speed, seed)
    made = _made(run, numbers, source or playing_source(run, numbers))
    if made.no_long:
        raise ListeningError(made.no_long)
    return long_record.make_long_record(
        run.scene,
        run.result,
        made.record,
        made.vibration,
        seconds=seconds,
        speed=speed,
        seed=seed,
    )


class _MadeRecord:
    """Record of a source of a run, and its long record, which is made when it is asked for.

    record : ContactSound. Sound along the track.
    vibration : Vibration, LinearVibration or None. What it goes on by; None for a release.
    """

    def __init__(
        self,
        run: SolvedRun,
        record: ContactSound,
        vibration: Vibration | LinearVibration | None,
    ) -> None:
        self._run = run
        self.record = record
        self.vibration = vibration

    @cached_property
    def no_long(self) -> str:
        """Reason why there is no long record; empty if there is none."""
        run = self._run
        return long_record.reason_against_long_record(run.scene, run.result, self.record)

    @cached_property
    def long(self) -> Listening | None:
        """Long record of the length that the scene asks for; None with a reason against it."""
        run = self._run
        seconds = run.scene.sound.listen_s
        if seconds is None or self.no_long:
            return None
        if self.record is run.sound:
            return run.long
        return long_record.make_long_record(
            run.scene, run.result, self.record, self.vibration, seconds=seconds
        )


def _made(run: SolvedRun, numbers: RunNumbers, source: Source) -> _MadeRecord:
    """Return the record of a source of a run, which is made once."""
    if source not in run.made_records:
        record, vibration = _record_of(run, numbers, source)
        run.made_records[source] = _MadeRecord(run, record, vibration)
    made = run.made_records[source]
    assert isinstance(made, _MadeRecord)
    return made


def _record_of(
    run: SolvedRun, numbers: RunNumbers, source: Source
) -> tuple[ContactSound, Vibration | LinearVibration | None]:
    """Return the sound of a source along the track, and the vibration that it goes on by."""
    release = run.release
    if source == run.sound.source:
        return run.sound, run.vibration_sound
    if source == "release" and release is not None:
        return release, None
    if source == "vibration" and release is not None and run.vibration_sound is not None:
        return sound_of_vibration(release, run.vibration_sound), run.vibration_sound
    if source == "vibration" and run.scene.dynamics is None:
        linear = _linear_of(run, numbers.estimate)
        estimated = linear_sound(linear, run.sound)
        if estimated is not None:
            return estimated, linear
    raise ValueError(f"{run.title}: the run has no sound of the {source}")


def _linear_of(run: SolvedRun, estimate: EstimateNumbers | None) -> LinearVibration:
    """Return the linear chain of a run without dynamics, with the stiffness of its estimate.

    The contact is solved for the stiffness where the numbers of the run do not have it.
    """
    scene = run.scene
    result = run.result
    if estimate is None or estimate.stiffness_n_m is None:
        stiffness = contact_stiffness(scene, result)
    else:
        stiffness = np.array([estimate.stiffness_n_m])
    approach = approach_of(result, run.sound)
    return linear_vibration(scene, approach, result.step, run.sound.closed, stiffness)
