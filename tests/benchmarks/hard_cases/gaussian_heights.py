"""Gaussian heights by their Ra and autocorrelation, without a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rolling.scene.laws import AUTOCORRELATIONS
from rolling.surface.height_law import CorrelationLaw
from rolling.surface.heights import filtered


def gaussian(
    shape: tuple[int, int],
    spacing: float,
    ra: float,
    lengths: tuple[float, float],
    name: str,
    seed: int | Sequence[int],
) -> np.ndarray:
    """Generate periodic Gaussian heights [m] of exact Ra and zero mean."""
    decay, exponent = AUTOCORRELATIONS[name]
    law = CorrelationLaw(lengths_m=lengths, decay=decay, exponent=exponent, ra_m=ra)
    heights = filtered(np.random.default_rng(seed).standard_normal(shape), spacing, law)
    return heights * (ra / np.abs(heights).mean())
