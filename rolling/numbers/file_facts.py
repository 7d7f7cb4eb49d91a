"""Facts about the files of a run: what their samples are, and which program made them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rolling.numbers.fields import group, number


@dataclass(frozen=True, kw_only=True)
class SignalFacts:
    """What the samples of signal.wav are."""

    meaning: str = number("what a sample is", "")
    peak_pa: float = number("largest magnitude", "Pa")


@dataclass(frozen=True, kw_only=True)
class RaisedEnd:
    """The end of a record for the ear that is raised, so that it is heard."""

    begin_s: float = number("where it begins", "s")
    raised_db: float = number("how far it is raised", "dB")
    pascal_per_full_scale: float = number("factor of its samples", "Pa")


@dataclass(frozen=True, kw_only=True)
class ListenFacts:
    """Content of a file for the ear, its level and its gain."""

    content: str = number("what the file holds", "")
    meaning: str = number("what a sample is, and what the gain does to the ear", "")
    source: Literal["vibration", "release"] | None = number(
        "what one hears; none in a file of an earlier program, which has the source of the record",
        "",
        default=None,
    )
    how: str = number("computed, estimated, upper bound or assumed", "", default="")
    measure: str = number("what its level is: LAeq, or LAE re 1 s", "", default="")
    level_db: float | None = number(
        "level of its samples as sound pressure; none of silence", "dB(A)", default=None
    )
    stated_gain_db: float = number(
        "gain that brought the record to the level that is stated", "dB", default=0.0
    )
    duration_s: float = number("length", "s")
    rule: str = number("rule of the gain", "")
    pascal_per_full_scale: float = number("factor of the samples", "Pa")
    gain_full_scale_per_pa: float = number("gain of the file", "1/Pa")
    gain_db_re_1_per_pa: float = number("the same as a level", "dB")
    own_gain_full_scale_per_pa: float = number("gain that makes all runs equally loud", "1/Pa")
    common_gain_full_scale_per_pa: float | None = number(
        "gain of its sweep; none until the sweep ends, and for a single run", "1/Pa", default=None
    )
    raised: RaisedEnd | None = group("the end of a fall that is raised", default=None)


@dataclass(frozen=True, kw_only=True)
class ChannelFile:
    """What the samples of the WAV of channels are."""

    meaning: str = number("what a sample is", "")
    unit: str = number("unit of the samples", "")
    unit_per_full_scale: float = number("factor of the samples")
    channels: tuple[str, ...] = number("names of its channels", "")


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """Program, packages and machine that made the numbers of a run."""

    program: str = number("version of the program", "")
    sources: str = number("digest of its sources", "")
    source: str | None = number("commit of a checkout", "", default=None)
    python: str = number("version of Python", "")
    packages: dict[str, str] = group("versions of packages")
    machine: str = number("system and processors", "")
    label: str = number("label of the run", "")
    written: str = number("when the files were written", "")
    seed: int | None = number("seed of the surface", "", default=None)


@dataclass(frozen=True, kw_only=True)
class SoundFacts:
    """Length and gains of a sound file to listen to, in the unit of its samples."""

    duration_s: float = number("length", "s")
    unit: str = number("unit of the samples", "")
    own_full_scale: float = number(
        "amplitude at full scale in this unit, with the gain that makes all runs equally loud"
    )
    full_scale: float = number("amplitude at full scale of the file in this unit")
    level_db: float | None = number(
        "LAeq of its samples as sound pressure; none of silence and of other quantities",
        "dB(A)",
        default=None,
    )
    stated_gain_db: float = number(
        "gain that brought the record to the level that is stated", "dB", default=0.0
    )


@dataclass(frozen=True, kw_only=True)
class BearingFiles:
    """Facts about the files of a run of a bearing."""

    listen: SoundFacts = group("listen.wav, the acceleration of the ring")
    housing: SoundFacts | None = group("housing.wav, the sound of a housing plate", default=None)


@dataclass(frozen=True, kw_only=True)
class FileFacts:
    """Facts about the files of a run of a ball."""

    signal: SignalFacts = group("signal.wav")
    listen: ListenFacts = group("listen.wav")
    released_signal: SignalFacts | None = group("released_signal.wav", default=None)
    released: ListenFacts | None = group("released.wav", default=None)
    channel_wavs: dict[str, ChannelFile] | None = group("WAVs of channels", default=None)
