"""Height of the ball and contact force during a slow motion, as the page draws them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.simulation.run_result import RunResult

MOST = 1500  # values of a curve, more than the page has pixels


@dataclass(frozen=True)
class FilmMotion:
    """The motion of the ball in the stretch of a slow motion.

    begin, step : float, s. First time in the record, and time from one value to the next.
    height_nm : list of float, nm. Height of the ball over its mean in the record.
    force_n : list of float, N. Contact force.
    load_n : float, N. Load.
    flights : list of (float, float), s. Begin and end of the times without contact.
    """

    begin: float
    step: float
    height_nm: list[float]
    force_n: list[float]
    load_n: float
    flights: list[tuple[float, float]]


def motion_between(run: RunResult, begin: float, end: float) -> FilmMotion | None:
    """Return the motion of a run between two times [s] of its record; None without dynamics."""
    if run.vibration is None:
        return None
    motion = run.vibration.motion
    first, last = np.searchsorted(motion.time_s, (begin, end))
    first, last = max(0, int(first) - 1), min(len(motion.time_s), int(last) + 1)
    if last - first < 2:
        return None
    stride = -(-(last - first) // MOST)
    height = (motion.displacement_m.mean() - motion.displacement_m[first:last:stride]) * 1e9
    force = motion.force_n[first:last]
    edges = motion.time_s[first] + (np.arange(last - first + 1) - 0.5) * motion.time_step_s
    return FilmMotion(
        begin=round(float(motion.time_s[first]), 9),
        step=stride * motion.time_step_s,
        height_nm=_short(height),
        force_n=_short(force[::stride]),
        load_n=run.vibration.load,
        flights=[
            (round(max(begin, float(edges[a])), 9), round(min(end, float(edges[b])), 9))
            for a, b in _stretches(force == 0)
            if edges[b] > begin and edges[a] < end
        ],
    )


def _stretches(where: Array) -> list[tuple[int, int]]:
    """Return first index and index after the last of each stretch of true values."""
    turns = np.flatnonzero(np.diff(np.concatenate([[0], where.astype(int), [0]])))
    return list(zip(turns[::2].tolist(), turns[1::2].tolist(), strict=True))


def _short(values: Array) -> list[float]:
    """Return values with four digits."""
    return [float(f"{value:.4g}") for value in values]
