"""Runs that are numbers, arrays and a sound: their numbers, and the files of their folder.

A kind of scene whose runs are such needs no files of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, make_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics import wav
from acoustics.arrays import Array
from acoustics.texts import printable
from acoustics.traps import ignoring_underflow
from rolling.archive.archive_file import archive_bytes, read_archive, refusing
from rolling.archive.definition import (
    ROOT,
    Archive,
    ArchiveDefinition,
    ArchiveGroup,
    Attribute,
    GroupDefinition,
    Variable,
)
from rolling.archive.hdf5_writer import to_xarray
from rolling.contact.processor_time import ProcessorTime
from rolling.kinds.heard_sound import PlainSound
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, RESULT, RunFolder
from rolling.kinds.shown_run import ShownRun
from rolling.marches import effort
from rolling.numbers.doubt import Doubt
from rolling.numbers.fields import group, number
from rolling.numbers.file_facts import Provenance, SoundFacts
from rolling.results import labels
from rolling.results.provenance import program_provenance
from rolling.results.stored_numbers import read_stored, with_parts, write_stored
from rolling.terminal import whole_files

if TYPE_CHECKING:
    import xarray

SIGNAL = "signal"  # samples of the sound, among the arrays of result.h5
SIGNAL_WAV = "signal.wav"
RESULT_KIND = "plain"  # attribute of result.h5
_TITLE_LETTERS = 400


# ---- numbers


@dataclass(frozen=True, kw_only=True)
class MarchedEffort:
    """How long a run took."""

    march_cpu_s: float | None = number("processor time of the marches", "s", in_table=True)
    parts_cpu_s: dict[str, float | None] | None = group(
        "processor time [s] of each part of the run", default=None
    )


@dataclass(frozen=True, kw_only=True)
class PlainNumbers:
    """Numbers that a run of every kind has; a kind adds its own as fields.

    Attributes
    ----------
    name : str
        Name of the scene.
    title : str or None
        Its title.
    sentences : tuple of str
        The answer in words, the most important sentence first.
    effort : MarchedEffort
        Processor times.
    doubts : tuple of Doubt
        All that limits the numbers, the worst first.
    """

    name: str = ""
    title: str | None = None
    sentences: tuple[str, ...] = number("the answer in words", "", default=())
    effort: MarchedEffort = group(
        "processor times", default=MarchedEffort(march_cpu_s=None, parts_cpu_s=None)
    )
    doubts: tuple[Doubt, ...] = group("what limits the numbers", default=())


@dataclass(frozen=True, kw_only=True)
class PlainFiles:
    """Facts about the files of a run."""

    listen: SoundFacts = group("listen.wav")


def stored_type_of(kind: str, numbers_type: type[PlainNumbers]) -> type[Any]:
    """Return the data class of what a run folder holds of the numbers of a kind."""
    return make_dataclass(
        "StoredPlain",
        [
            ("format", int, field(default=1)),
            ("kind", str, field(default=kind)),
            ("numbers", numbers_type),
            ("files", PlainFiles),
            ("provenance", Provenance),
        ],
        frozen=True,
        kw_only=True,
    )


# ---- runs


class RunSound(NamedTuple):
    """A record to listen to: its samples at 48 kHz, their unit, and what they are in words."""

    samples: Array
    unit: str
    content: str


class Solved(NamedTuple):
    """What the marches of a run give: its numbers, its arrays by name, and its sound."""

    numbers: PlainNumbers
    arrays: Mapping[str, Array]
    sound: RunSound


@ignoring_underflow
@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class PlainRun(ShownRun, RunFolder):
    """A run that is numbers, arrays and a sound. It equals no other run.

    Attributes
    ----------
    scene : scene
        Scene without a sweep.
    label : str
        Label that distinguishes the run from others.
    numbers : PlainNumbers
        All numbers; a run that was opened has the stored ones.
    variables : tuple of Variable
        Definitions of its arrays.
    arrays : dict
        Arrays by name.
    sound : RunSound
        Its sound.
    stored : data class or None
        What the run folder holds beside the result; None for a run that was not opened.
    values : dict
        Swept values of the run, by dotted key.
    folder : Path
        Run folder; the working directory for a run that is in memory only.
    """

    label: str
    numbers: Any
    variables: tuple[Variable, ...]
    arrays: Mapping[str, Array]
    sound: RunSound
    stored: Any = None

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone, for pickle and copies."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __repr__(self) -> str:
        return "\n".join(self.numbers.sentences) or f"<run of {self.scene.name}>"

    @property
    def title(self) -> str:
        """The scene and the label."""
        return labels.title(self.scene.name, self.label)

    def to_xarray(self) -> xarray.DataTree:
        """Return the content of result.h5 as named arrays with units."""
        return to_xarray(definition_of(self.variables, self.sound), _archive(self, ""))


def definition_of(variables: tuple[Variable, ...], sound: RunSound | None) -> ArchiveDefinition:
    """Return the definition of a result with some arrays, and with a sound.

    A sound that is not known yet has its unit and its content in the attributes of the file.
    """
    unit, content = ("", "") if sound is None else (sound.unit, sound.content)
    signal = Variable(SIGNAL, "sample", unit, "f8", content)
    facts: dict[str, type[Attribute]] = {"unit": str, "content": str, "identity": str}
    group = GroupDefinition((*variables, signal), facts)
    return ArchiveDefinition(name="a result", format=1, kind=RESULT_KIND, groups={ROOT: group})


def _archive(run: PlainRun, identity: str) -> Archive:
    """Return the arrays of a run with its sound, and the facts about them."""
    facts = {"unit": run.sound.unit, "content": run.sound.content, "identity": identity}
    return {ROOT: ArchiveGroup({**run.arrays, SIGNAL: run.sound.samples}, facts)}


def write_run(run: PlainRun, stored_type: type[Any], identity: str) -> None:
    """Write the files of a run into its folder, last summary.json, which tells that all are whole.

    Parameters
    ----------
    run : PlainRun
        The run.
    stored_type : type
        What its numbers are stored as.
    identity : str
        Identity of its marches, which a result must have when it is read.

    Raises
    ------
    OSError : a file cannot be written. An earlier file of this name is kept.
    """
    began = ProcessorTime.now()
    folder = run.folder
    whole_files.make_below(run.home, folder)
    sound = run.sound
    definition = definition_of(run.variables, sound)
    whole_files.write_bytes(folder / RESULT, archive_bytes(definition, _archive(run, identity)))
    comment = f"{sound.content}; 1.0 is 1 {sound.unit}"
    whole_files.write_bytes(
        folder / SIGNAL_WAV, wav.calibrated(sound.samples, comment, _title(run))
    )
    listen = heard_sound(run)
    whole_files.write_bytes(folder / listen.file, listen.wav())
    stored = stored_type(
        numbers=run.numbers,
        files=PlainFiles(listen=listen.facts()),
        provenance=program_provenance(run.label),
    )
    spent = ProcessorTime.now().since(began)
    parts = effort.with_work(run.numbers.effort.parts_cpu_s or {}, effort.SOUND, spent)
    write_stored(folder, with_parts(stored, parts))


def heard_sound(run: PlainRun) -> PlainSound:
    """Return the sound of a run as a person listens to it, with its file."""
    return PlainSound(
        file=LISTEN,
        unit=run.sound.unit,
        group=Path(LISTEN).stem,
        record=run.sound.samples,
        heard=run.sound.content,
        title=_title(run),
    )


def _title(run: PlainRun) -> str:
    """Return the title of the sound of a run."""
    return printable(run.title)[:_TITLE_LETTERS]


def read_run(
    place: RunFolder,
    label: str,
    *,
    variables: tuple[Variable, ...],
    identity: str,
    most_bytes: int,
) -> PlainRun:
    """Read a run from its folder, with its stored numbers, under a label.

    Parameters
    ----------
    place : RunFolder
        Scene, swept values and folder.
    label : str
        The label.
    variables : tuple of Variable
        Definitions of its arrays.
    identity : str
        Identity of its marches.
    most_bytes : int
        Largest size of its result.

    Raises
    ------
    FolderError : a file is missing or damaged, or the result is that of another scene.
    """
    path = place.folder / RESULT
    definition = definition_of(variables, None)
    archive = read_archive(path, [definition], lengths={}, most_bytes=most_bytes, identity=identity)
    group = archive[ROOT]
    with refusing(path, definition):
        for name in definition.groups[ROOT].by_name:
            if not np.isfinite(group.arrays[name]).all():
                raise ValueError(f"{name}: values that are no finite numbers")
        unit, content = (printable(group.attributes[name]) for name in ("unit", "content"))
    arrays = group.arrays
    stored = read_stored(place.folder, kind_of(place.scene).name)
    return PlainRun(
        values=place.values,
        scene=place.scene,
        folder=place.folder,
        label=label,
        numbers=stored.numbers,
        variables=variables,
        arrays={variable.name: arrays[variable.name] for variable in variables},
        sound=RunSound(samples=arrays[SIGNAL], unit=unit, content=content),
        stored=stored,
    )
