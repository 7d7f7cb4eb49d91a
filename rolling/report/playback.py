"""Gains to compare records by ear, calibrated or equally loud, without clipping."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from acoustics.wav import PEAK


@dataclass(frozen=True)
class Playback:
    """The gains of a record; a silent record has gains of 0 and no levels.

    Parameters
    ----------
    full_scale_pa : float, Pa. Sound pressure of full scale in its file, whose peak lies at -1 dB.
    calibrated, equal : float. Factors on the samples of the file, for a common full scale and for a
        common LAeq of all records.
    calibrated_pa, equal_pa : float, Pa. Sound pressure of full scale with these factors;
        `calibrated_pa` is equal for all records.
    equal_db : float, dB. Difference of the equally loud to the calibrated level.
    """

    full_scale_pa: float
    calibrated: float = 0.0
    equal: float = 0.0
    calibrated_pa: float | None = None
    equal_pa: float | None = None
    equal_db: float | None = None


def playbacks(peaks_pa: Sequence[float], laeq_db: Sequence[float | None]) -> list[Playback]:
    """Compute the gains of records that are compared.

    Parameters
    ----------
    peaks_pa : sequence of float, Pa. Maximum |p| of each record.
    laeq_db : sequence of float or None, dB. Level of each record; None if it is silent or has no
        audible part after A-weighting.
    """
    scales = [peak / PEAK if peak > 0 else 1.0 for peak in peaks_pa]
    common = max(
        (scale for scale, peak in zip(scales, peaks_pa, strict=True) if peak > 0), default=1.0
    )
    # Each record is loudest with its peak at the limit. All records can reach the minimum of these
    # levels.
    target = min(
        (
            level - _db(scale)
            for scale, level in zip(scales, laeq_db, strict=True)
            if level is not None
        ),
        default=0.0,
    )
    gains = []
    for scale, peak, level in zip(scales, peaks_pa, laeq_db, strict=True):
        if not peak > 0:
            gains.append(Playback(scale))
            continue
        equal_pa = common if level is None else 10.0 ** ((level - target) / 20.0)
        gains.append(
            Playback(
                scale, scale / common, scale / equal_pa, common, equal_pa, _db(common / equal_pa)
            )
        )
    return gains


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
