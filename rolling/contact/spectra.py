"""Spectra of influence coefficients, kept for the next transforms of their padded size.

Transforms in single and double precision, and the half-spaces of several runs, share a spectrum.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock

import numpy as np

from rolling._typing import Array

# Bytes of spectra that a process keeps beside its transforms: the hundred sizes of a rough track up
# to 300 nodes across, or seven sizes of 1,000 nodes. A longer spectrum is not kept at all.
KEPT_BYTES = 2**26

_kept: OrderedDict[tuple[int, int, int], Array] = OrderedDict()
_lock = Lock()


def half_spectrum(
    m: int, n: int, subcells: int, coefficients: Callable[[Array, Array], Array]
) -> Array:
    """Return the first half of the rows of the transform of coefficients that wrap around.

    The transform is real, and its other rows mirror these, because the coefficients are even in
    both directions.

    Parameters
    ----------
    m, n : int
        Padded lengths along and across.
    subcells : int
        Sub-cells along the side of a cell, which the coefficients belong to.
    coefficients : callable
        Coefficients (a, b) of the distances (a,) and (b,).

    Returns
    -------
    (m // 2 + 1, n // 2 + 1) array
        Its rows and columns from the frequency zero on.
    """
    key = (m, n, subcells)
    with _lock:
        if key in _kept:
            _kept.move_to_end(key)
            return _kept[key]
    rows, columns = (np.minimum(np.arange(k), k - np.arange(k)) for k in (m, n))
    quarter = coefficients(np.arange(m // 2 + 1.0), np.arange(n // 2 + 1.0))
    half = np.fft.rfft2(quarter[rows[:, None], columns]).real[: m // 2 + 1].copy()
    if half.nbytes <= KEPT_BYTES:
        with _lock:
            _kept[key] = half
            while sum(kept.nbytes for kept in _kept.values()) > KEPT_BYTES:
                _kept.popitem(last=False)
    return half
