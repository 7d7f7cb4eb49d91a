"""What a table of recovery events says in a few numbers. Depends on numpy only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class EventStatistics:
    """Recovery events of a stretch of track.

    count : events; `per_metre` [1/m] of track.
    energy_mean, energy_median, energy_p90 : of an event [J]; nine in ten release less than the last.
    duration_mean : steps an event lasts.
    peak : most that one node releases in a step [J].
    top_tenth_share : of the release, by the tenth of the events (rounded up) with the most energy.
    """

    count: int
    per_metre: float
    energy_mean: float
    energy_median: float
    energy_p90: float
    duration_mean: float
    peak: float
    top_tenth_share: float


def event_statistics(events: Mapping[str, NDArray[Any]], length: float) -> EventStatistics | None:
    """Numbers of a table of recovery events (see `rolling.recovery.EventTable`); None when there are none.

    Parameters
    ----------
    events : columns first, last, energy [J] and peak [J per step], each (n,).
    length : of the track they were released on [m].
    """
    energy = events["energy"]
    count = len(energy)
    if count == 0:
        return None
    most = np.sort(energy)[-math.ceil(count / 10) :]
    return EventStatistics(
        count=count,
        per_metre=count / length,
        energy_mean=float(energy.mean()),
        energy_median=float(np.median(energy)),
        energy_p90=float(np.quantile(energy, 0.9)),
        duration_mean=float((events["last"] - events["first"]).mean()),
        peak=float(events["peak"].max()),
        top_tenth_share=float(most.sum() / energy.sum()),
    )
