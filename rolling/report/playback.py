"""Gains with which records are compared by ear: as loud as they are, or all equally loud; nothing clips."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from acoustics.wav import PEAK


@dataclass(frozen=True)
class Playback:
    """How one record is played; a silent one has gains of 0 and no levels.

    full_scale_pa : sound pressure that full scale of its file stands for [Pa], its own peak being at -1 dB.
    calibrated, equal : factors on the file's samples, with one full scale for all records and with one LAeq for all.
    calibrated_pa, equal_pa : sound pressure that full scale then stands for [Pa]; the same for all when calibrated.
    equal_db : what equal loudness adds to the calibrated level [dB].
    """

    full_scale_pa: float
    calibrated: float = 0.0
    equal: float = 0.0
    calibrated_pa: float | None = None
    equal_pa: float | None = None
    equal_db: float | None = None


def playbacks(peaks_pa: Sequence[float], laeq_db: Sequence[float | None]) -> list[Playback]:
    """The gains of records that are compared.

    Parameters
    ----------
    peaks_pa : largest sample of each record [Pa].
    laeq_db : its level; None: it is silent, or has nothing that A-weighting leaves.
    """
    scales = [peak / PEAK if peak > 0 else 1.0 for peak in peaks_pa]
    common = max((scale for scale, peak in zip(scales, peaks_pa, strict=True) if peak > 0), default=1.0)
    # Each record reaches its greatest loudness with its peak at the limit; the least of these all can reach.
    target = min(
        (level - _db(scale) for scale, level in zip(scales, laeq_db, strict=True) if level is not None), default=0.0
    )
    found = []
    for scale, peak, level in zip(scales, peaks_pa, laeq_db, strict=True):
        if not peak > 0:
            found.append(Playback(scale))
            continue
        equal_pa = common if level is None else 10.0 ** ((level - target) / 20.0)
        found.append(Playback(scale, scale / common, scale / equal_pa, common, equal_pa, _db(common / equal_pa)))
    return found


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
