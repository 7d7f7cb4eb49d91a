"""What would help the louder one of a choice, by its linear response, without a march."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from acoustics.texts import printable
from rolling.choice import drawing
from rolling.choice.candidate import Candidate
from rolling.choice.change_words import SHOWN_DB
from rolling.numbers.quantity import uncertain

if TYPE_CHECKING:
    from rolling.choice.audition import Audition

MOST = 2  # values that the answer names


class LinearChange(NamedTuple):
    """A value of a drawing, and what a step of it does to the level by the linear response.

    key : str. Its dotted key.
    words : str. The step that makes it quieter, such as 10 % smaller sphere radius.
    quieter_db, uncertainty_db : float, dB. How much quieter it then is, and its ±.
    """

    key: str
    words: str
    quieter_db: float
    uncertainty_db: float


class LinearAdvice(NamedTuple):
    """The values of a drawing that matter most for a candidate, the first one most.

    label : str. The candidate.
    changes : list of LinearChange. At most two.
    """

    label: str
    changes: list[LinearChange]

    @property
    def sentence(self) -> str:
        """Say what would help; empty without a value that does."""
        if not self.changes:
            return ""
        texts = [
            f"a {change.words} by {uncertain(change.quieter_db, change.uncertainty_db)} dB"
            for change in self.changes
        ]
        return (
            f"What would make {printable(self.label)} quieter, by the linear response and without"
            f" a march: {' and '.join(texts)}."
        )


def linear_advice(
    audition: Audition, candidate: Candidate, workers: int, folder: Path
) -> LinearAdvice:
    """Return the values of a drawing that matter most for a candidate.

    Who stands farther away hears less, but the drawing stays as it is.

    Parameters
    ----------
    audition : Audition. How scenes of the kind are compared.
    candidate : Candidate. The candidate.
    workers, folder : int, Path. Number of processes and folder, for which changes are refused.
    """
    if audition.linear_change(candidate, candidate) is None:
        return LinearAdvice(candidate.label, [])
    changed, _ = drawing.changes_of(audition, candidate.scene, candidate, workers, folder)
    changes = []
    for change in changed:
        if change.key == drawing.DISTANCE:
            continue
        changed_db = audition.linear_change(candidate, change.candidate)
        if changed_db is None:
            continue
        louder_db = changed_db if change.is_upwards else -changed_db
        uncertainty_db = audition.linear_error(change.key, louder_db)
        if uncertainty_db is None or abs(louder_db) < max(SHOWN_DB, uncertainty_db):
            continue
        changes.append(
            LinearChange(
                key=change.key,
                words=drawing.helping_words(change, louder_db),
                quieter_db=abs(louder_db),
                uncertainty_db=uncertainty_db,
            )
        )
    changes.sort(key=lambda change: -change.quieter_db)
    return LinearAdvice(candidate.label, changes[:MOST])
