"""Specimens whose contact has no solution: remembered, and refused where there are many."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rolling.choice.choice_numbers import OmittedPair
from rolling.choice.heard_specimen import Specimen, StoredFailure
from rolling.contact.solver import ContactError
from rolling.kinds.run_folder import FAILED
from rolling.marches.piece import contact_identity
from rolling.numbers.number_files import to_bytes
from rolling.terminal import whole_files

FEW = 10  # pairs; of fewer, up to half may be left out
MOST_OF_FEW = 0.5  # share of few pairs, which is refused itself
MOST_OF_MANY = 0.1  # share of ten pairs or more, above which a choice ends


def remember(home: Path, specimen: Specimen, reason: str) -> None:
    """Write why the contact of a specimen has no solution, so that it is not marched again."""
    whole_files.make_below(home, specimen.folder)
    failure = StoredFailure(reason=reason, contact=contact_identity(specimen.scene))
    whole_files.write_bytes(specimen.folder / FAILED, to_bytes(failure))


def forget(specimen: Specimen) -> None:
    """Remove what is remembered of another contact, such as one on a narrower surface."""
    (specimen.folder / FAILED).unlink(missing_ok=True)


def refuse_many(omitted: Sequence[OmittedPair], count: int, noun: str) -> None:
    """Refuse a choice of which so many pairs have no solution that the others do not tell.

    Parameters
    ----------
    omitted : sequence of OmittedPair. The pairs that are left out.
    count : int. Number of all pairs.
    noun : str. What the specimens are.

    Raises
    ------
    ContactError : there are more than one in ten of ten pairs or more, or half or more of fewer.
    """
    share = len(omitted) / count
    is_many = share > MOST_OF_MANY if count >= FEW else share >= MOST_OF_FEW
    if not is_many or not omitted:
        return
    first = omitted[0]
    if count == 1:
        raise ContactError(f"{first.label}: {first.reason}")
    which = f"none of {count} {noun} has a solution"
    if len(omitted) < count:
        which = (
            f"{len(omitted)} of {count} {noun} have no solution, so that the others do not stand"
            " for all"
        )
    raise ContactError(f"{which}; {first.label}, specimen {first.number}: {first.reason}")
