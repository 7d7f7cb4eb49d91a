"""Difference of two candidates over pairs of specimens, its ± and how sure its sign is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import (
    SURE,
    PairedMean,
    joint_freedom,
    paired_mean,
    student_factor,
    sureness,
)
from rolling.numbers.quantity import joined

SCATTER = "scatter"  # part of the pairs
LEFT_OUT = "left_out"  # part of the pairs that have no solution
ALIKE = 0.95  # share of the pairs, below which the number of independent ones is told
LEAST_SHARE = 0.5  # of the wanted ± that the scatter of the pairs gets in any case


@dataclass(frozen=True, eq=False)
class Difference:
    """Difference of the levels of two candidates in one quantity, first less second.

    Attributes
    ----------
    quantity : str
        What is compared: the vibration of a ball, or a band of the ring of a bearing.
    pairs : int
        Number of pairs of specimens.
    db : float or None, dB
        Mean difference of what a listener would hear; None where one of them makes no sound.
    uncertainty_db : float or None, dB
        Standard uncertainty by Student's t; None for a single pair.
    sureness : float or None
        Probability that the sign of the difference is right; None without an uncertainty. Each pair
        that is left out counts as one on the other side.
    parts_db : dict, dB
        Parts of the uncertainty by their origin: scatter of the pairs, pairs that are left out, and
        what all pairs share, such as the loss factor of a contact, the error of the grid, or the
        gains of the contacts of a bearing. Student's t widens them together.
    released_db, released_uncertainty_db : float or None, dB
        The same for the released power of a ball, whose sign says nothing of what is heard.
    band_db, band_uncertainty_db : (31,) arrays or None, dB
        The same by third octave, NaN where it is unknown; None for a quantity without third
        octaves.
    left_out_db : dict, dB
        What the uncertainty leaves out, by source: parts of the ± of the runs that are taken to
        shift both levels alike, with the size that they would have otherwise. Default: nothing.
    independent : float or None
        Number of independent pairs that the pairs count as, because places of a scan share its
        ridges; None where each pair is independent. Default: None.
    further_scan_db : float or None, dB
        Standard uncertainty that as many places on a further scan of each would leave; None without
        scans. Default: None.

    Examples
    --------
    >>> import rolling
    >>> difference = rolling.Difference(
    ...     quantity="vibration", pairs=6, db=2.1, uncertainty_db=0.8, sureness=0.97,
    ...     parts_db={"scatter": 0.72},
    ... )
    >>> difference.is_sure
    True
    """

    quantity: str
    pairs: int
    db: float | None
    uncertainty_db: float | None
    sureness: float | None
    parts_db: dict[str, float]
    released_db: float | None = None
    released_uncertainty_db: float | None = None
    band_db: Array | None = None
    band_uncertainty_db: Array | None = None
    left_out_db: dict[str, float] = field(default_factory=dict)
    independent: float | None = None
    further_scan_db: float | None = None

    @property
    def is_sure(self) -> bool:
        """Whether the sign is right with 95 % probability."""
        return self.sureness is not None and self.sureness >= SURE

    @property
    def shares_places(self) -> bool:
        """Whether its pairs count as fewer independent ones, because their places are alike."""
        return are_alike(self.pairs, self.independent)

    def wanted_scatter_db(self, within_db: float) -> float:
        """Return what the scatter may add to a wanted ± [dB], since more pairs lower it only.

        It gets at least half of the ±, whatever the other parts are.
        """
        of_others = joined(self.parts_db, left_out=[SCATTER])
        left = math.sqrt(max(0.0, within_db**2 - of_others**2))
        return max(left, LEAST_SHARE * within_db)


def are_alike(places: int, independent: float | None) -> bool:
    """Tell whether places count as fewer independent ones, which are None where all are."""
    return independent is not None and independent < ALIKE * places


def paired_difference(
    quantity: str,
    differences_db: Array,
    shared_db: Mapping[str, float],
    omitted: int = 0,
    correlation: Array | None = None,
) -> Difference:
    """Return the difference of two candidates that are heard on the same specimens.

    Parameters
    ----------
    quantity : str
        What is compared.
    differences_db : (pairs,) array, dB
        Difference of the levels of each pair; not finite where one of them makes no sound.
    shared_db : mapping, dB
        Parts of the uncertainty that all pairs share, by their origin.
    omitted : int
        Number of pairs that are left out, because a contact has no solution. Default: 0.
    correlation : (pairs, pairs) array, optional
        Correlation of the pairs on the places of a scan. Default: they are independent.
    """
    if not np.all(np.isfinite(differences_db)):
        return Difference(
            quantity=quantity,
            pairs=len(differences_db),
            db=None,
            uncertainty_db=None,
            sureness=None,
            parts_db={},
        )
    of_pairs = paired_mean(differences_db, correlation)
    db = of_pairs.mean
    uncertainty_db = None
    further_db = None
    sure = None
    parts_db = {SCATTER: of_pairs.error, **shared_db}
    if math.isfinite(of_pairs.error):
        adverse = None
        if omitted:
            adverse = _with_adverse(differences_db, omitted, correlation)
            parts_db[LEFT_OUT] = abs(db - adverse.mean)
        total = joined(parts_db)
        freedom = joint_freedom(of_pairs, total)
        uncertainty_db = total * student_factor(freedom)
        sure = sureness(db, total, freedom)
        if correlation is not None:
            further_db = _with_further_scans(of_pairs, parts_db)
        if adverse is not None:
            sure = min(sure, _adverse_sureness(db, adverse, parts_db))
    return Difference(
        quantity=quantity,
        pairs=len(differences_db),
        db=db,
        uncertainty_db=uncertainty_db,
        sureness=sure,
        parts_db=parts_db,
        independent=None if correlation is None else of_pairs.independent,
        further_scan_db=further_db,
    )


def _with_further_scans(of_pairs: PairedMean, parts_db: Mapping[str, float]) -> float:
    """Return the uncertainty [dB] that a further scan of each with as many places would leave.

    Both scans have the same scatter, each about its own mean, and twice as many independent places.
    """
    both = of_pairs._replace(
        error=of_pairs.error / math.sqrt(2),
        freedom=2 * of_pairs.freedom + 1,
        independent=2 * of_pairs.independent,
    )
    total = math.hypot(both.error, joined(parts_db, left_out=[SCATTER]))
    return total * student_factor(joint_freedom(both, total))


def _with_adverse(values: Array, omitted: int, correlation: Array | None) -> PairedMean:
    """Return the mean of pairs with those that are left out, as if these spoke against the others.

    Nobody knows the difference of a pair that has no solution. It counts as one that is as large as
    the mean and of the other sign, or that lies two standard deviations of the pairs beside the
    mean where this is farther.
    """
    mean = float(np.mean(values))
    beside = 2.0 * max(abs(mean), float(np.std(values, ddof=1)))
    against = mean - math.copysign(beside, mean)
    whole = np.append(values, np.full(omitted, against))
    of_whole = np.eye(len(whole))
    if correlation is not None:
        of_whole[: len(values), : len(values)] = correlation
    return paired_mean(whole, of_whole, first_pairs=len(whole))


def _adverse_sureness(db: float, adverse: PairedMean, parts_db: Mapping[str, float]) -> float:
    """Return the probability that a sign is right if the pairs that are left out speak against it.

    It is one half where they would turn the sign round.
    """
    if adverse.mean * db <= 0:
        return 0.5
    total = math.hypot(adverse.error, joined(parts_db, left_out=[SCATTER, LEFT_OUT]))
    return sureness(adverse.mean, total, joint_freedom(adverse, total))
