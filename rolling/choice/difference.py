"""Difference of two candidates over pairs of specimens, its ± and how sure its sign is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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
from acoustics.radiation import P_REF_PA
from acoustics.unbaffled import baffle_difference_db
from rolling.choice.heard import BAFFLE, Heard, LevelError
from rolling.numbers.quantity import joined

SCATTER = "scatter"  # part of the pairs
LEFT_OUT = "left_out"  # part of the pairs that have no solution
# Parts of the ± of a run that have a part of their own in a difference. Pairs of specimens and
# several speeds take the place of a single record and its comb, two loss factors that of one.
COUNTED = ("record", "comb", "contact_loss", "grid", "instrument")
LEAST_SHARE = 0.5  # of the wanted ± that the scatter of the pairs gets in any case


@dataclass(frozen=True, eq=False)
class Difference:
    """Difference of the levels of two candidates, first less second.

    Attributes
    ----------
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
        Parts of the uncertainty by their origin: scatter of the pairs, loss factor, grid,
        instrument, missing baffle, pairs that are left out. Student's t widens them together.
    released_db, released_uncertainty_db : float or None, dB
        The same for the released power, whose sign says nothing of what is heard.
    band_db, band_uncertainty_db : (31,) arrays, dB
        The same by third octave, NaN where it is unknown.
    left_out_db : dict, dB
        What the uncertainty leaves out, by source: parts of the ± of the runs that are taken to
        shift both levels alike, with the size that they would have otherwise. Default: nothing.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> unknown = np.full(31, np.nan)
    >>> apart = rolling.Difference(
    ...     pairs=6, db=2.1, uncertainty_db=0.8, sureness=0.97, parts_db={"scatter": 0.72},
    ...     released_db=-1.0, released_uncertainty_db=0.1,
    ...     band_db=unknown, band_uncertainty_db=unknown,
    ... )
    >>> apart.is_sure
    True
    """

    pairs: int
    db: float | None
    uncertainty_db: float | None
    sureness: float | None
    parts_db: dict[str, float]
    released_db: float | None
    released_uncertainty_db: float | None
    band_db: Array
    band_uncertainty_db: Array
    left_out_db: dict[str, float] = field(default_factory=dict)

    @property
    def is_sure(self) -> bool:
        """Whether the sign is right with 95 % probability."""
        return self.sureness is not None and self.sureness >= SURE

    def wanted_scatter_db(self, within_db: float) -> float:
        """Return what the scatter may add to a wanted ± [dB], since more pairs lower it only.

        It gets at least half of the ±, whatever the other parts are.
        """
        of_others = joined(self.parts_db, left_out=[SCATTER])
        left = math.sqrt(max(0.0, within_db**2 - of_others**2))
        return max(left, LEAST_SHARE * within_db)


def difference(first: Sequence[Heard], second: Sequence[Heard], omitted: int = 0) -> Difference:
    """Return the difference of two candidates that are heard on the same specimens.

    Parameters
    ----------
    first, second : sequences of Heard
        What is heard of each specimen, in the same order.
    omitted : int
        Number of pairs that are left out, because a contact has no solution. Default: 0.
    """
    pairs = list(zip(first, second, strict=True))
    # Pairs and loss factors. The one factor that a scene states stands beside two of the other's.
    with np.errstate(invalid="ignore"):  # two silences have no difference
        apart = np.array([level_db(one.squares) - level_db(other.squares) for one, other in pairs])
        bands = np.array([level_db(one.bands) - level_db(other.bands) for one, other in pairs])
    band_db, band_uncertainty_db = _by_band(bands.mean(axis=1))
    released_db, released_uncertainty_db = _released(pairs)
    db = None
    uncertainty_db = None
    sure = None
    parts_db: dict[str, float] = {}
    if np.all(np.isfinite(apart)):
        of_pairs = paired_mean(apart.mean(axis=1))
        db = of_pairs.mean
        parts_db = {
            SCATTER: of_pairs.error,
            "loss_factor": float(np.ptp(apart.mean(axis=0))) / 2,
            "grid": _error_part(pairs, "grid"),
            "instrument": _error_part(pairs, "instrument"),
            BAFFLE: float(np.mean([_baffle_part(one, other) for one, other in pairs])),
        }
        adverse = None
        if omitted and math.isfinite(of_pairs.error):
            adverse = _with_adverse(apart.mean(axis=1), omitted)
            parts_db[LEFT_OUT] = abs(db - adverse.mean)
        if math.isfinite(of_pairs.error):
            total = joined(parts_db)
            freedom = joint_freedom(of_pairs, total)
            uncertainty_db = total * student_factor(freedom)
            sure = sureness(db, total, freedom)
            if adverse is not None:
                sure = min(sure, _adverse_sureness(db, adverse, parts_db))
    return Difference(
        pairs=len(pairs),
        db=db,
        uncertainty_db=uncertainty_db,
        sureness=sure,
        parts_db=parts_db,
        released_db=released_db,
        released_uncertainty_db=released_uncertainty_db,
        band_db=band_db,
        band_uncertainty_db=band_uncertainty_db,
        left_out_db=_left_out(pairs) if uncertainty_db is not None else {},
    )


# ---- statistics


def level_db(squares: Array) -> Array:
    """Return levels [dB re 20 uPa] of mean squares [Pa2]; that of silence is minus infinity."""
    with np.errstate(divide="ignore"):
        return np.asarray(10.0 * np.log10(squares / P_REF_PA**2))


def _with_adverse(values: Array, omitted: int) -> PairedMean:
    """Return the mean of pairs with those that are left out, as if these spoke against the others.

    Nobody knows the difference of a pair that has no solution. It counts as one that is as large as
    the mean and of the other sign, or that lies two standard deviations of the pairs beside the
    mean where this is farther.
    """
    mean = float(np.mean(values))
    beside = 2.0 * max(abs(mean), float(np.std(values, ddof=1)))
    against = mean - math.copysign(beside, mean)
    whole = np.append(values, np.full(omitted, against))
    return PairedMean(
        mean=float(np.mean(whole)),
        error=float(np.std(whole, ddof=1)) / math.sqrt(len(whole)),
        freedom=float(len(whole) - 1),
    )


def _adverse_sureness(db: float, adverse: PairedMean, parts_db: Mapping[str, float]) -> float:
    """Return the probability that a sign is right if the pairs that are left out speak against it.

    It is one half where they would turn the sign round.
    """
    if adverse.mean * db <= 0:
        return 0.5
    total = math.hypot(adverse.error, joined(parts_db, left_out=[SCATTER, LEFT_OUT]))
    return sureness(adverse.mean, total, joint_freedom(adverse, total))


# ---- parts of a difference


def _by_band(values: Array) -> tuple[Array, Array]:
    """Return mean and standard uncertainty of differences by band, (pairs, 31) [dB]."""
    means = np.full(values.shape[1], np.nan)
    errors = np.full(values.shape[1], np.nan)
    for band, of_band in enumerate(values.T):
        if not np.all(np.isfinite(of_band)):
            continue
        of_pairs = paired_mean(of_band)
        means[band] = of_pairs.mean
        if math.isfinite(of_pairs.error):
            errors[band] = of_pairs.uncertainty
    return means, errors


def _released(pairs: Sequence[tuple[Heard, Heard]]) -> tuple[float | None, float | None]:
    """Return the mean difference of the released powers, and its standard uncertainty [dB]."""
    apart = []
    for one, other in pairs:
        if one.released_power_db is None or other.released_power_db is None:
            return None, None
        apart.append(one.released_power_db - other.released_power_db)
    of_pairs = paired_mean(np.array(apart))
    if not math.isfinite(of_pairs.error):
        return of_pairs.mean, None
    return of_pairs.mean, of_pairs.uncertainty


def _error_part(pairs: Sequence[tuple[Heard, Heard]], origin: str) -> float:
    """Return the error of a difference [dB] from grid or instrument; 0 where no run knows one.

    Levels are not corrected, so the mean difference of their errors counts whole. What both share
    cancels. A surface that no instrument measured has no error of one.
    """
    none = LevelError(0.0, 0.0)
    apart = []
    spreads = []
    for one, other in pairs:
        of_one = one.errors.get(origin, none)
        of_other = other.errors.get(origin, none)
        apart.append(of_one.db - of_other.db)
        spreads.append(math.hypot(of_one.uncertainty_db, of_other.uncertainty_db))
    return math.hypot(float(np.mean(apart)), float(np.mean(spreads)))


def _baffle_part(one: Heard, other: Heard) -> float:
    """Return what the missing baffles of free plates leave on a difference [dB]; 0 without any.

    On equal plates the baffle changes both sounds alike, as far as they lie in the same bands.
    """
    bands = [np.nan_to_num(heard.bands.mean(axis=0)) for heard in (one, other)]
    if one.baffle_db is not None and _have_equal_baffles(one, other):
        return baffle_difference_db(bands[0], bands[1], one.baffle_db)
    parts = []
    for of_bands, uncertainty_db in zip(bands, (one.baffle_db, other.baffle_db), strict=True):
        if uncertainty_db is not None and of_bands.sum() > 0:
            parts.append(float(of_bands @ uncertainty_db / of_bands.sum()))
    return math.hypot(*parts)


def _have_equal_baffles(one: Heard, other: Heard) -> bool:
    """Tell whether two sounds come from equal free plates, which lack the same baffle."""
    if one.baffle_db is None or other.baffle_db is None:
        return False
    return np.array_equal(one.baffle_db, other.baffle_db)


def _left_out(pairs: Sequence[tuple[Heard, Heard]]) -> dict[str, float]:
    """Return the parts of the ± of the runs of pairs that a difference leaves out [dB].

    They are taken to shift both levels alike. Of what the missing baffle changes on equal plates,
    only a remainder is in the difference; on other plates it counts whole.
    """
    every = [one for pair in pairs for one in pair]
    sources = {source: None for one in every for source, part in one.parts_db.items() if part}
    left_out = {}
    for source in sources:
        if source in COUNTED:
            continue
        if source == BAFFLE and not all(_have_equal_baffles(*pair) for pair in pairs):
            continue
        sizes = [math.hypot(*(one.parts_db.get(source, 0.0) for one in pair)) for pair in pairs]
        left_out[source] = float(np.mean(sizes))
    return left_out
