"""Difference of two bearings in one band over pairs of specimens, with its ±."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import SURE, joint_freedom, paired_mean, student_factor, sureness
from acoustics.ring_velocity import VELOCITY_BANDS_HZ

HOUSING = "housing"  # A-weighted sound pressure of the housing plate, beside the three bands
NAMES = {
    **{name: f"{low:g} to {high:g} Hz" for name, (low, high) in VELOCITY_BANDS_HZ.items()},
    HOUSING: "sound of the housing",
}


@dataclass(frozen=True)
class BandDifference:
    """Difference of two bearings in one band, second less first.

    band : str. low, medium, high, or housing.
    pairs : int. Number of pairs of specimens.
    db : float, dB. Mean difference of the levels; infinite where the first one is at rest.
    uncertainty_db : float or None, dB. Standard uncertainty by Student's t, with the part of the
        gains; None for one pair.
    sureness : float or None. Probability that the sign is right.
    gain_db : float, dB. Part of the uncertainty by the gains of the contacts, which all specimens
        share.
    """

    band: str
    pairs: int
    db: float
    uncertainty_db: float | None
    sureness: float | None
    gain_db: float = 0.0

    @property
    def is_sure(self) -> bool:
        """Whether the sign is right with 95 % probability."""
        return self.sureness is not None and self.sureness >= SURE


def band_difference(band: str, first: Array, second: Array, gain_db: float = 0.0) -> BandDifference:
    """Return the difference of the levels of two bearings on the same specimens.

    Parameters
    ----------
    band : str
        low, medium, high or housing.
    first, second : arrays (specimens,)
        Root mean square of each specimen in the band, in any unit.
    gain_db : float, dB
        Standard uncertainty of the difference by what all specimens share. Default: 0.
    """
    if not (np.all(first > 0) and np.all(second > 0)):
        moves = float(np.sum(second)) - float(np.sum(first))
        db = math.copysign(math.inf, moves) if moves else 0.0
        return BandDifference(
            band=band, pairs=len(first), db=db, uncertainty_db=None, sureness=None
        )
    of_pairs = paired_mean(20 * np.log10(second / first))
    if not math.isfinite(of_pairs.error):
        return BandDifference(
            band=band,
            pairs=1,
            db=of_pairs.mean,
            uncertainty_db=None,
            sureness=None,
            gain_db=gain_db,
        )
    total = math.hypot(of_pairs.error, gain_db)
    freedom = joint_freedom(of_pairs, total)
    return BandDifference(
        band=band,
        pairs=len(first),
        db=of_pairs.mean,
        uncertainty_db=total * student_factor(freedom),
        sureness=sureness(of_pairs.mean, total, freedom),
        gain_db=gain_db,
    )
