"""Gains to compare records by ear, calibrated or equally loud, without clipping."""

from __future__ import annotations

import math
from collections.abc import Sequence

from acoustics.wav import PEAK

Gains = dict[str, float | None]


def gains(peaks_pa: Sequence[float], laeq_db: Sequence[float | None]) -> list[Gains]:
    """Compute the gains of records that are compared.

    Parameters
    ----------
    peaks_pa : sequence of float, Pa. Maximum |p| of each record.
    laeq_db : sequence of float or None, dB. Level of each record; None if it is silent or has no
        audible part after A-weighting.

    Returns
    -------
    list of dict. `full_scale_pa` [Pa] is the pressure of full scale in the file of a record, whose
        peak lies at -1 dB. `calibrated` and `equal` are factors on its samples for a common full
        scale and for a common LAeq, `calibrated_pa` and `equal_pa` [Pa] the full scales that they
        lead to, and `equal_db` [dB] their ratio. A silent record has factors of 0 and no scales.
    """
    scales = [peak / PEAK if peak > 0 else 1.0 for peak in peaks_pa]
    records = [*zip(scales, peaks_pa, laeq_db, strict=True)]
    common = max((scale for scale, peak, _ in records if peak > 0), default=1.0)
    # Each record is loudest with its peak at the limit. All records can reach the minimum of these
    # levels.
    loudest = [level - _db(scale) for scale, _, level in records if level is not None]
    target = min(loudest, default=0.0)
    computed: list[Gains] = []
    for scale, peak, level in records:
        gain: Gains = {"full_scale_pa": scale, "calibrated": 0.0, "equal": 0.0}
        gain |= dict.fromkeys(("calibrated_pa", "equal_pa", "equal_db"))
        if peak > 0:
            equal = common if level is None else 10.0 ** ((level - target) / 20.0)
            gain |= {"calibrated": scale / common, "equal": scale / equal}
            gain |= {"calibrated_pa": common, "equal_pa": equal, "equal_db": _db(common / equal)}
        computed.append(gain)
    return computed


def _db(ratio: float) -> float:
    return 20.0 * math.log10(ratio)
