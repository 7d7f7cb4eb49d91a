"""Gaussian heights by their Ra and autocorrelation, without a scene."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rolling.surface.heights import filtered, white_noise


def gaussian(
    shape: tuple[int, int],
    spacing: float,
    ra: float,
    lengths: tuple[float, float],
    law: str,
    seed: int | Sequence[int],
) -> np.ndarray:
    """Generate periodic Gaussian heights [m] of exact Ra and zero mean."""
    heights = filtered(white_noise(shape, seed), spacing, lengths, law)
    return heights * (ra / np.abs(heights).mean())
