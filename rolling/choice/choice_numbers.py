"""Numbers of a choice: contenders with what is heard of them, and how much louder each is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.choice.candidate import Candidate
from rolling.choice.difference import Difference
from rolling.choice.heard_specimen import Heard, HeardQuantity, Specimen
from rolling.choice.linear_advice import LinearAdvice
from rolling.kinds.stated_conditions import conditions_of
from rolling.numbers.conditions import Conditions
from rolling.sound.heard_in_room import HeardDifference

if TYPE_CHECKING:
    from rolling.choice.audition import Audition


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
    leading : str
        Name of the quantity that puts contenders in their order.
    """

    candidate: Candidate
    heard: list[Any]
    specimens: list[Specimen]
    leading: str

    @property
    def label(self) -> str:
        """What the candidate is called."""
        return self.candidate.label

    @property
    def levels_db(self) -> Array:
        """(specimens,) dB. Level of each specimen in the leading quantity."""
        return self.levels_in(self.leading)

    @property
    def level_db(self) -> float:
        """Mean level of the leading quantity over specimens; minus infinity for silence."""
        return float(self.levels_db.mean())

    @property
    def released_power_db(self) -> float | None:
        """Mean level of the released power, dB(A)."""
        every = [of_specimen.released_level_db for of_specimen in self.heard]
        levels = [level for level in every if level is not None]
        return float(np.mean(levels)) if levels else None

    @property
    def third_octaves(self) -> Array | None:
        """Mean A-weighted squares by third octave, (31,) [Pa2]; None where a kind has none."""
        if self.heard[0].third_octaves is None:
            return None
        return np.asarray(
            np.mean([of_specimen.third_octaves for of_specimen in self.heard], axis=0)
        )

    def levels_in(self, quantity: str) -> Array:
        """Return the level of each specimen in a quantity, (specimens,) [dB]."""
        of_specimens: list[Heard] = self.heard
        return np.array([of_specimen.level_db(quantity) for of_specimen in of_specimens])

    def rms_in(self, quantity: str) -> Array:
        """Return the root mean square of each specimen in a quantity, (specimens,)."""
        return np.array([of_specimen.rms(quantity) for of_specimen in self.heard])

    def mean_in(self, quantity: HeardQuantity) -> float | None:
        """Return the mean over specimens as tables show it; None for the level of silence."""
        if not quantity.is_level:
            return float(np.sqrt(np.mean(np.square(self.rms_in(quantity.name)))))
        level = float(self.levels_in(quantity.name).mean())
        return level if math.isfinite(level) else None


class Compared(NamedTuple):
    """A contender, and how much louder than the quietest it is."""

    contender: Contender
    difference: Difference


@dataclass(frozen=True, eq=False)
class ChoiceNumbers:
    """Contenders of a choice, and their differences.

    Attributes
    ----------
    contenders : list of Contender
        Candidates, the quietest first.
    by_quantity : list of dict of Difference
        Of each contender after the first from the quietest: how much louder it is, by quantity.
    audition : Audition
        How the scenes of the kind are compared.
    noun : str
        What the specimens are: surfaces, or places of the scan.
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
    advice : LinearAdvice or None
        The values of the drawing that matter most for the loudest one; None until the choice ends.
    """

    contenders: list[Contender]
    by_quantity: list[dict[str, Difference]]
    audition: Audition
    noun: str
    limit: str
    within_db: float
    folder: Path
    audible: tuple[HeardDifference, ...] = ()
    omitted: Sequence[OmittedPair] = ()
    is_early: bool = False
    command: str = ""
    advice: LinearAdvice | None = None

    @property
    def conditions(self) -> Conditions:
        """Conditions of the candidates, by their labels."""
        return conditions_of(
            {contender.label: contender.candidate.scene for contender in self.contenders}
        )

    @property
    def quantities(self) -> list[HeardQuantity]:
        """What the candidates are compared by."""
        return self.audition.quantities([contender.candidate for contender in self.contenders])

    @property
    def leading(self) -> HeardQuantity:
        """The quantity that puts the candidates in their order."""
        return leading_of(self.quantities)

    @property
    def differences(self) -> list[Difference]:
        """How much louder each contender after the first is, in the leading quantity."""
        return [of_one[self.leading.name] for of_one in self.by_quantity]

    @property
    def labels(self) -> list[str]:
        """Labels of the candidates, the quietest first."""
        return [contender.label for contender in self.contenders]

    @property
    def rms(self) -> dict[str, Array]:
        """Root mean square of each specimen by quantity, (candidates, specimens)."""
        return {
            quantity.name: np.array(
                [contender.rms_in(quantity.name) for contender in self.contenders]
            )
            for quantity in self.quantities
        }

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
        """The contender whose difference in some quantity has the largest ±."""
        others = [
            Compared(contender, difference)
            for contender, of_one in zip(self.contenders[1:], self.by_quantity, strict=True)
            for difference in of_one.values()
        ]
        return max(others, key=lambda compared: compared.difference.uncertainty_db or 0.0)

    @property
    def tried(self) -> int:
        """Number of specimens that were taken, with those that are left out."""
        return self.pairs + len(self.omitted)


def leading_of(quantities: Sequence[HeardQuantity]) -> HeardQuantity:
    """Return the quantity that puts candidates in their order."""
    return next(quantity for quantity in quantities if quantity.leads)
