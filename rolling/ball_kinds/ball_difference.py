"""Difference of two candidates over pairs of specimens of a ball: its third octaves and parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import paired_mean
from acoustics.unbaffled import baffle_difference_db
from rolling.ball_kinds.ball_heard import BAFFLE, HeardBall, LevelError
from rolling.choice.difference import Difference, paired_difference
from rolling.choice.heard_specimen import levels_of

VIBRATION = "vibration"  # what is compared
BAND = "band"  # part of candidates whose simulated bands end at other frequencies
# Parts of the ± of a run that have a part of their own in a difference. Pairs of specimens and
# several speeds take the place of a single record and its comb, two loss factors that of one.
COUNTED = ("record", "comb", "contact_loss", "grid", "instrument")


def difference(
    first: Sequence[HeardBall],
    second: Sequence[HeardBall],
    omitted: int = 0,
    correlation: Array | None = None,
) -> Difference:
    """Return the difference of two candidates that are heard on the same specimens.

    Parameters
    ----------
    first, second : sequences of HeardBall
        What is heard of each specimen, in the same order.
    omitted : int
        Number of pairs that are left out, because a contact has no solution. Default: 0.
    correlation : (pairs, pairs) array, optional
        Correlation of the pairs on the places of a scan. Default: they are independent.
    """
    pairs = list(zip(first, second, strict=True))
    # Pairs and loss factors. The one factor that a scene states stands beside two of the other's.
    with np.errstate(invalid="ignore"):  # two silences have no difference
        differences_db = np.array(
            [levels_of(ball.squares) - levels_of(other.squares) for ball, other in pairs]
        )
        bands = np.array([levels_of(ball.bands) - levels_of(other.bands) for ball, other in pairs])
        shared_db = {
            "loss_factor": float(np.ptp(differences_db.mean(axis=0))) / 2,
            "grid": _error_part(pairs, "grid"),
            "instrument": _error_part(pairs, "instrument"),
            BAFFLE: float(np.mean([_baffle_part(ball, other) for ball, other in pairs])),
            BAND: _band_part(pairs),
        }
    band_db, band_uncertainty_db = _by_band(bands.mean(axis=1), correlation)
    released_db, released_uncertainty_db = _released(pairs, correlation)
    of_levels = paired_difference(
        VIBRATION, differences_db.mean(axis=1), shared_db, omitted, correlation
    )
    return replace(
        of_levels,
        released_db=released_db,
        released_uncertainty_db=released_uncertainty_db,
        band_db=band_db,
        band_uncertainty_db=band_uncertainty_db,
        left_out_db=_left_out(pairs) if of_levels.uncertainty_db is not None else {},
    )


# ---- parts of a difference


def _by_band(values: Array, correlation: Array | None) -> tuple[Array, Array]:
    """Return mean and standard uncertainty of differences by band, (pairs, 31) [dB]."""
    means = np.full(values.shape[1], np.nan)
    errors = np.full(values.shape[1], np.nan)
    for band, of_band in enumerate(values.T):
        if not np.all(np.isfinite(of_band)):
            continue
        of_pairs = paired_mean(of_band, correlation)
        means[band] = of_pairs.mean
        if math.isfinite(of_pairs.error):
            errors[band] = of_pairs.uncertainty
    return means, errors


def _released(
    pairs: Sequence[tuple[HeardBall, HeardBall]], correlation: Array | None
) -> tuple[float | None, float | None]:
    """Return the mean difference of the released powers, and its standard uncertainty [dB]."""
    differences_db = []
    for ball, other in pairs:
        if ball.released_power_db is None or other.released_power_db is None:
            return None, None
        differences_db.append(ball.released_power_db - other.released_power_db)
    of_pairs = paired_mean(np.array(differences_db), correlation)
    if not math.isfinite(of_pairs.error):
        return of_pairs.mean, None
    return of_pairs.mean, of_pairs.uncertainty


def _error_part(pairs: Sequence[tuple[HeardBall, HeardBall]], origin: str) -> float:
    """Return the error of a difference [dB] from grid or instrument; 0 where no run knows one.

    Levels are not corrected, so the mean difference of their errors counts whole. What both share
    cancels. A surface that no instrument measured has no error of one.
    """
    none = LevelError(0.0, 0.0)
    differences_db = []
    spreads = []
    for ball, other in pairs:
        of_ball = ball.errors.get(origin, none)
        of_other = other.errors.get(origin, none)
        differences_db.append(of_ball.db - of_other.db)
        spreads.append(math.hypot(of_ball.uncertainty_db, of_other.uncertainty_db))
    return math.hypot(float(np.mean(differences_db)), float(np.mean(spreads)))


def _band_part(pairs: Sequence[tuple[HeardBall, HeardBall]]) -> float:
    """Return what a difference [dB] changes if only bands count that both candidates resolve.

    It is 0 where both resolve the same bands. Coarse nodes of one scan end its band below that of
    a finer scan, whose higher waves are then heard in the one alone.
    """
    changes_db = []
    for ball, other in pairs:
        known = np.isfinite(ball.bands).all(axis=0) & np.isfinite(other.bands).all(axis=0)
        own_db = _level_of_bands(ball.bands) - _level_of_bands(other.bands)
        common_db = _level_of_bands(ball.bands[:, known]) - _level_of_bands(other.bands[:, known])
        change_db = common_db - own_db
        changes_db.append(change_db if math.isfinite(change_db) else 0.0)
    return abs(float(np.mean(changes_db)))


def _level_of_bands(bands: Array) -> float:
    """Return the mean level over loss factors [dB] of the known bands of each, (losses, bands)."""
    return float(levels_of(np.nansum(bands, axis=1)).mean())


def _baffle_part(ball: HeardBall, other: HeardBall) -> float:
    """Return what the missing baffles of free plates leave on a difference [dB]; 0 without any.

    On equal plates the baffle changes both sounds alike, as far as they lie in the same bands.
    """
    bands = [np.nan_to_num(heard_ball.bands.mean(axis=0)) for heard_ball in (ball, other)]
    if ball.baffle_db is not None and _have_equal_baffles(ball, other):
        return baffle_difference_db(bands[0], bands[1], ball.baffle_db)
    parts = []
    for of_bands, uncertainty_db in zip(bands, (ball.baffle_db, other.baffle_db), strict=True):
        if uncertainty_db is not None and of_bands.sum() > 0:
            parts.append(float(of_bands @ uncertainty_db / of_bands.sum()))
    return math.hypot(*parts)


def _have_equal_baffles(ball: HeardBall, other: HeardBall) -> bool:
    """Tell whether two sounds come from equal free plates, which lack the same baffle."""
    if ball.baffle_db is None or other.baffle_db is None:
        return False
    return np.array_equal(ball.baffle_db, other.baffle_db)


def _left_out(pairs: Sequence[tuple[HeardBall, HeardBall]]) -> dict[str, float]:
    """Return the parts of the ± of the runs of pairs that a difference leaves out [dB].

    They are taken to shift both levels alike. Of what the missing baffle changes on equal plates,
    only a remainder is in the difference; on other plates it counts whole.
    """
    every = [ball for pair in pairs for ball in pair]
    sources = {source: None for ball in every for source, part in ball.parts_db.items() if part}
    left_out = {}
    for source in sources:
        if source in COUNTED:
            continue
        if source == BAFFLE and not all(_have_equal_baffles(*pair) for pair in pairs):
            continue
        sizes = []
        for first, second in pairs:
            sizes.append(
                math.hypot(first.parts_db.get(source, 0.0), second.parts_db.get(source, 0.0))
            )
        left_out[source] = float(np.mean(sizes))
    return left_out
