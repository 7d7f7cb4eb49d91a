"""Sounds of a run as a person listens to them, with the gains of their files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

from acoustics import wav
from acoustics.arrays import Array
from acoustics.level import laeq_db
from rolling.kinds.stated_level import StatedLevel
from rolling.numbers.file_facts import SoundFacts


class HeardSound(ABC):
    """A sound of a run that a person listens to, and its file.

    Attributes
    ----------
    file : str
        Name of its file in the run folder, such as listen.wav. Facts about the file stand under
        this name without ending among the facts of the files.
    unit : str
        SI unit of its samples, such as Pa or m/s2.
    group : str
        What it is a sound of. Sounds of one group share a gain where runs are compared by ear.
    words : str
        What one hears.
    samples : array (n,) or (n, channels)
        The record at 48 kHz, in its unit.
    """

    file: str
    unit: str
    group: str

    @property
    @abstractmethod
    def samples(self) -> Array:
        """The record at 48 kHz, (n,) or (n, channels), in its unit."""

    @property
    @abstractmethod
    def words(self) -> str:
        """What one hears."""

    @abstractmethod
    def wav(self, common: float | None = None) -> bytes:
        """Return its file with a common gain [full scale per unit], or with its own gain."""

    @abstractmethod
    def facts(self, common: float | None = None) -> Any:
        """Return the facts about this file."""

    @property
    def level_db(self) -> float | None:
        """A-weighted level of its samples, dB re 20e-6 of their unit; None for silence."""
        first = self.samples if self.samples.ndim == 1 else self.samples[:, 0]
        return laeq_db(first, wav.SAMPLE_RATE_HZ)


@dataclass(frozen=True, eq=False)
class PlainSound(HeardSound):
    """A sound whose file says its full scale, and nothing else of its gain.

    Parameters
    ----------
    file, unit, group : str
        As in `HeardSound`.
    record : array (n,), in the unit
        The samples at 48 kHz.
    heard : str
        What one hears.
    title : str
        Title of the file.
    comment : str
        What the comment of the file says before its full scale. Default: what one hears.
    stated_db : float, dB
        LAeq that is stated for a sound pressure, to which one gain brings the record. Default: none
        is stated.
    spread_db : float, dB
        Its standard uncertainty, which is the largest gain.
    """

    file: str
    unit: str
    group: str
    record: Array
    heard: str
    title: str
    comment: str = ""
    stated_db: float | None = None
    spread_db: float = 0.0

    @cached_property
    def level(self) -> StatedLevel:
        """Level of the record [dB re 20e-6 of its unit], beside the level that is stated."""
        return StatedLevel(
            own_db=laeq_db(self.record, wav.SAMPLE_RATE_HZ),
            stated_db=self.stated_db,
            spread_db=self.spread_db,
        )

    @cached_property
    def samples(self) -> Array:
        """The record at 48 kHz, in its unit."""
        return self.record * 10 ** (self.level.gain_db / 20)

    @property
    def words(self) -> str:
        """What one hears, with the level of a sound pressure."""
        return self._with_level(self.heard)

    def _with_level(self, text: str) -> str:
        """Return a text with the level of the samples where they are sound pressure."""
        return f"{text}, {self.level.words}" if self.unit == "Pa" else text

    @cached_property
    def own_gain(self) -> float:
        """Gain that makes all runs equally loud [full scale per unit]."""
        return wav.listening_gain(self.samples)

    def wav(self, common: float | None = None) -> bytes:
        """Return its file with a common gain [full scale per unit], or with its own gain."""
        gain = self.own_gain if common is None else common
        text = self._with_level(self.comment or self.heard)
        comment = f"{text}; {full_scale_words(gain, self.unit)}"
        return wav.listening(self.samples, gain, comment, self.title)

    def facts(self, common: float | None = None) -> SoundFacts:
        """Return length and gains of this file."""
        gain = self.own_gain if common is None else common
        return SoundFacts(
            duration_s=len(self.record) / wav.SAMPLE_RATE_HZ,
            unit=self.unit,
            own_full_scale=1 / self.own_gain,
            full_scale=1 / gain,
            level_db=self.level.level_db if self.unit == "Pa" else None,
            stated_gain_db=self.level.gain_db,
        )


def full_scale_words(gain: float, unit: str) -> str:
    """Say in the comment of a file which gain it has [full scale per unit]."""
    return f"full scale is {1 / gain:.6g} {unit}"


class FileGain(NamedTuple):
    """The gains of a sound file that is written [full scale per unit].

    file : str. Its name.
    group : str. Sounds of one group share a gain.
    own : float. Its own gain.
    used : float or None. The common gain that it has; None without one.
    words : callable. What the comment of the file says of a common gain.
    """

    file: str
    group: str
    own: float
    used: float | None
    words: Callable[[float], str]


def plain_gains(files: Any) -> Iterator[FileGain]:
    """Yield the gains of all files of which a data class has facts as those of `PlainSound`."""
    for field in fields(files):
        facts = getattr(files, field.name)
        if isinstance(facts, SoundFacts):
            yield _plain_gain(field.name, facts)


def _plain_gain(name: str, facts: SoundFacts) -> FileGain:
    """Return the gains of a file with plain facts."""
    return FileGain(
        file=f"{name}.wav",
        group=name,
        own=1 / facts.own_full_scale,
        used=1 / facts.full_scale,
        words=lambda gain: full_scale_words(gain, facts.unit),
    )


def common_gains(files: Iterable[FileGain]) -> dict[str, float]:
    """Return the common gain of the sounds of each group [full scale per unit].

    It is the minimum of their own gains: the loudest one plays as it would alone, and none clips.
    """
    gains: dict[str, float] = {}
    for file in files:
        gains[file.group] = min(file.own, gains.get(file.group, file.own))
    return gains


def played_sound(sounds: Iterable[HeardSound]) -> HeardSound | None:
    """Return the sound that is played first: a sound pressure before any other; None of none."""
    every = list(sounds)
    pressures = [sound for sound in every if sound.unit == "Pa"]
    return next(iter([*pressures, *every]), None)
