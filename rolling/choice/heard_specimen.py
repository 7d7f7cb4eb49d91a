"""What is heard of a specimen of any kind: root mean squares by quantity, and its file."""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from acoustics.arrays import Array
from acoustics.level import level_db
from acoustics.radiation import P_REF_PA
from rolling.choice.candidate import Candidate
from rolling.kinds.run_folder import FAILED, MAX_FAILURE, RunFolder
from rolling.marches.piece import contact_identity
from rolling.numbers.number_files import from_bytes, to_bytes
from rolling.scene.identity import scene_identity
from rolling.terminal.whole_files import FolderError, read_regular, write_json

HEARD = "heard.json"
_MAX_BYTES = 1_000_000
_Stored = TypeVar("_Stored")


@dataclass(frozen=True)
class HeardQuantity:
    """A quantity by which specimens are compared.

    name : str. Its name, such as vibration.
    words : str. What it is called in tables and pictures.
    column : str. Column of the table with its mean over specimens.
    unit : str. Unit of that mean.
    is_level : bool. Whether the mean is one of levels; otherwise it is a root mean square.
    drawn : str. Label of the axis of several quantities of its unit; empty for its words.
    where : str. Beginning of its sentences where there are several quantities.
    verb, adverb : str. What the quieter one does: it is so much quieter, or moves so much less.
    leads : bool. Whether it puts the candidates in their order.
    """

    name: str
    words: str
    column: str
    unit: str = "dB(A)"
    is_level: bool = True
    drawn: str = ""
    where: str = ""
    verb: str = "is"
    adverb: str = "quieter"
    leads: bool = False

    @property
    def decibels(self) -> str:
        """Unit of a difference of two levels."""
        return self.unit if self.is_level else "dB"

    @property
    def level_unit(self) -> str:
        """Unit of a level."""
        return self.unit if self.is_level else f"dB re 1 {self.unit}"


class Heard(ABC):
    """What is heard of one specimen of a candidate."""

    @abstractmethod
    def rms(self, quantity: str) -> float:
        """Return the root mean square of a quantity in its unit; in pascals for a level."""

    def level_db(self, quantity: str) -> float:
        """Return the level of a quantity, minus infinity for silence."""
        level = level_db(self.rms(quantity) ** 2)
        return -math.inf if level is None else level

    def highest_level_db(self, quantity: str) -> float:
        """Return the level of a quantity under the least favourable of what is not known."""
        return self.level_db(quantity)

    @property
    def third_octaves(self) -> Array | None:
        """A-weighted mean squares by third octave, (31,) [Pa2]; None where a kind has none."""
        return None

    @property
    def released_level_db(self) -> float | None:
        """Level of the released power, dB(A); None where a kind has none."""
        return None


@dataclass(frozen=True, kw_only=True)
class StoredFailure:
    """Why a contact has no solution, as failed.json has it, and the identity of this contact."""

    reason: str
    contact: str


@dataclass(frozen=True, eq=False)
class Specimen(RunFolder):
    """A specimen of a candidate and its folder.

    candidate : Candidate. The candidate, whose scene is that of the specimen but for what varies.
    number : int. Number of the specimen, from 0 on.
    """

    candidate: Candidate
    number: int

    @property
    def is_heard(self) -> bool:
        """Whether what is heard of the specimen is stored."""
        return (self.folder / HEARD).is_file()

    @property
    def no_solution(self) -> str:
        """Why the contact of the specimen has no solution; empty unless that is remembered."""
        try:
            stored = from_bytes(StoredFailure, read_regular(self.folder / FAILED, MAX_FAILURE))
        except (OSError, ValueError, RecursionError):
            return ""
        return stored.reason if stored.contact == contact_identity(self.scene) else ""


def write_heard_file(specimen: Specimen, stored: Any) -> None:
    """Write what is heard of a specimen, with the identity of its scene."""
    content = json.loads(to_bytes(stored)) | {"scene": scene_identity(specimen.scene)}
    write_json(specimen.folder / HEARD, content)


def read_heard_file(specimen: Specimen, kind: type[_Stored]) -> _Stored:
    """Read what is heard of a specimen from its file.

    Raises
    ------
    FolderError : the file is missing or damaged, was not written by this program, or is of another
        scene.
    """
    try:
        content = read_regular(specimen.folder / HEARD, _MAX_BYTES)
        stored = from_bytes(kind, content)
        identity = json.loads(content).get("scene")
    except (OSError, ValueError, RecursionError) as error:
        raise damaged(specimen, error) from error
    if identity != scene_identity(specimen.scene):
        raise FolderError(
            f"{specimen.folder}: holds a specimen of another scene; give another folder with --out"
        )
    return stored


def damaged(specimen: Specimen, reason: Any) -> FolderError:
    """Return the error of what is stored of a specimen and cannot be used."""
    return FolderError(
        f"{specimen.folder / HEARD}: not readable ({reason}); delete it, and the same command makes"
        " it again"
    )


def levels_of(squares: Array) -> Array:
    """Return levels [dB re 20 uPa] of mean squares [Pa2]; that of silence is minus infinity."""
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(squares / P_REF_PA**2))
