"""Numbers of a choice: contenders with what is heard of them, and how much louder each is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.choice.candidates import Candidate
from rolling.choice.difference import Difference, level_db
from rolling.choice.heard import Heard, Specimen
from rolling.sound.heard_in_room import HeardDifference


class OmittedPair(NamedTuple):
    """A pair of specimens that is left out, because a contact has no solution.

    number : int. Number of the specimen, from 1 on.
    label : str. The candidate whose contact has no solution.
    reason : str. Why it has none, with the remedy.
    """

    number: int
    label: str
    reason: str


@dataclass(frozen=True, eq=False)
class Contender:
    """A candidate with what is heard of its specimens.

    Attributes
    ----------
    candidate : Candidate
        Label and scene.
    heard : list of Heard
        What is heard of each specimen.
    specimens : list of Specimen
        Their runs and folders.
    """

    candidate: Candidate
    heard: list[Heard]
    specimens: list[Specimen]

    @property
    def label(self) -> str:
        """What the candidate is called."""
        return self.candidate.label

    @property
    def levels_db(self) -> Array:
        """(specimens,) dB(A). What a listener would hear of each specimen."""
        return np.array([level_db(one.squares).mean() for one in self.heard])

    @property
    def level_db(self) -> float:
        """Mean level of the vibration over specimens, dB(A); minus infinity for silence."""
        return float(self.levels_db.mean())

    @property
    def released_power_db(self) -> float | None:
        """Mean level of the released power, dB(A)."""
        levels = [one.released_power_db for one in self.heard if one.released_power_db is not None]
        return float(np.mean(levels)) if levels else None


class Compared(NamedTuple):
    """A contender, and how much louder than the quietest it is."""

    contender: Contender
    apart: Difference


@dataclass(frozen=True, eq=False)
class ChoiceNumbers:
    """Contenders of a choice, and their differences.

    Attributes
    ----------
    contenders : list of Contender
        Candidates, the quietest first.
    differences : list of Difference
        Of each contender after the first from the quietest: how much louder it is.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    overlap : bool
        Whether the places of a scan overlap.
    limit : str
        Why no more pairs were heard although the ± is above the wanted one; empty if it is not.
    within_db : float, dB
        The wanted ±.
    folder : Path
        Folder of the choice.
    audible : tuple of HeardDifference
        Whether each difference is audible in the noise of the room.
    omitted : list of OmittedPair
        Pairs that are left out, because a contact has no solution.
    is_early : bool
        Whether the limit of time ended the choice before its rule did.
    command : str
        Command that repeats the answer; empty for a choice in Python.
    """

    contenders: list[Contender]
    differences: list[Difference]
    noun: str
    overlap: bool
    limit: str
    within_db: float
    folder: Path
    audible: tuple[HeardDifference, ...] = ()
    omitted: Sequence[OmittedPair] = ()
    is_early: bool = False
    command: str = ""

    @property
    def pairs(self) -> int:
        """Number of specimens on which every candidate was heard."""
        return len(self.contenders[0].heard)

    @property
    def numbers(self) -> list[int]:
        """Numbers, from 1 on, of the specimens on which every candidate was heard."""
        left_out = [pair.number for pair in self.omitted]
        return [number for number in range(1, self.tried + 1) if number not in left_out]

    @property
    def widest(self) -> Compared:
        """The contender whose difference has the largest ±."""
        others = map(Compared, self.contenders[1:], self.differences)
        return max(others, key=lambda one: one.apart.uncertainty_db or 0.0)

    @property
    def tried(self) -> int:
        """Number of specimens that were taken, with those that are left out."""
        return self.pairs + len(self.omitted)
