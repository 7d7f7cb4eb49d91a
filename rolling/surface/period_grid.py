"""Nodes of measured heights on their way to one period."""

from collections.abc import Sequence
from dataclasses import dataclass

SAME = 1e-6  # relative difference of spacings that count as equal
Pair = tuple[int, int]


@dataclass(frozen=True)
class HeightGrid:
    """Nodes along and across the track, from the file to the period that is rolled over."""

    steps: tuple[float, float]  # [m] spacings of the file
    spacing: float  # [m] of the period
    resampled: Pair  # nodes of the file at that spacing; a profile has its width
    overlap: Pair  # nodes that are blended into the beginning
    nodes: Pair  # of the period


def is_other(steps: Sequence[float], spacing: float) -> bool:
    """Tell whether the spacings [m] of a file differ from that of its period."""
    return any(abs(step / spacing - 1) > SAME for step in steps)
