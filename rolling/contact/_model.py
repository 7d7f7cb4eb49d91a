"""Model problem of the contact solve: its stencil and its grid (see _model_kernels)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rolling._typing import Array
from rolling.contact.half_space import love

# Waves up to this many nodes long count in the fit of the stencil. Contacts are some ten to a
# hundred nodes wide.
LONGEST_WAVE = 40


@lru_cache(maxsize=1)
def inverse_stencil() -> Array:
    """Fit a 5 x 5 stencil to the inverse of Love's coefficients, by least squares over waves.

    The waves are up to LONGEST_WAVE nodes long, for unit spacing and pi E* = 1.

    Returns
    -------
    (6,) array
        Centre, side, corner, second side, beside it, second corner.
    """
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    spectrum = np.fft.rfft2(love(distance, distance)).real
    along = 2 * np.pi * np.fft.fftfreq(256)[:, None]
    across = 2 * np.pi * np.fft.rfftfreq(256)[None, :]
    waves = np.hypot(along, across) >= 2 * np.pi / LONGEST_WAVE

    def ring(a: int, b: int) -> Array:
        nodes = {(x * m, y * n) for m, n in ((a, b), (b, a)) for x in (-1, 1) for y in (-1, 1)}
        # Sorted, because the order of a sum has an effect on its last digits.
        total: Array = np.sum([np.cos(m * along + n * across) for m, n in sorted(nodes)], axis=0)
        return total

    pairs = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
    columns = np.stack([(ring(a, b) * spectrum)[waves] for a, b in pairs], axis=1)
    weights: Array = np.linalg.lstsq(columns, np.ones(len(columns)), rcond=None)[0]
    return weights
