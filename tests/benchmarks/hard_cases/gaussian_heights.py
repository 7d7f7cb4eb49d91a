"""Gaussian heights by their Ra and autocorrelation, without a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rolling.scene.laws import Roughness
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
    along, across = (1e6 * length for length in lengths)
    ellipse = {"correlation_length_um": along, "correlation_length_across_um": across}
    law = Roughness.model_construct(
        autocorrelation=name, roughness_ra_um=1e6 * ra, seed=0, **ellipse
    )
    heights = filtered(np.random.default_rng(seed).standard_normal(shape), spacing, law)
    return heights * (ra / np.abs(heights).mean())
