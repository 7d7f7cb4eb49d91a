"""A-weighting in the frequency domain."""

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array, real_array

_HIGHEST_HZ = 1e15  # beyond hearing by far; its powers stay finite
# IEC 61672-1:2013, annex E: the poles follow from these four frequencies in Hz and D = sqrt(1/2).
_REFERENCE = 1000.0
_LOW = 10.0**1.5
_HIGH = 10.0**3.9
_A = 10.0**2.45


def _pole_frequencies() -> tuple[float, float, float, float]:
    """Return the unrounded pole frequencies in Hz.

    They are 20.60 (double), 107.7, 737.9 and 12194 (double).
    """
    d = np.sqrt(0.5)
    c = (_LOW * _HIGH) ** 2
    b = (_REFERENCE**2 + c / _REFERENCE**2 - d * (_LOW**2 + _HIGH**2)) / (1.0 - d)
    root = np.sqrt(b**2 - 4.0 * c)
    first = np.sqrt((-b - root) / 2.0)
    fourth = np.sqrt((-b + root) / 2.0)
    second = (3.0 - 5.0**0.5) / 2.0 * _A
    third = (3.0 + 5.0**0.5) / 2.0 * _A
    return float(first), second, third, float(fourth)


POLES_HZ = _pole_frequencies()


def _response(frequency_hz: ArrayLike) -> Array:
    """Return the magnitude of the A-weighting, not normalised."""
    first, second, third, fourth = [pole**2 for pole in POLES_HZ]
    f = np.square(frequency_hz)
    return f**2 * fourth / ((f + first) * np.sqrt((f + second) * (f + third)) * (f + fourth))


_RESPONSE_1KHZ = float(_response(_REFERENCE))


def a_weighting_db(frequency_hz: ArrayLike) -> Array:
    """Return the A-weighting: 0 dB at 1 kHz exactly, -inf at 0 Hz.

    This is the exact curve with unrounded poles. The standard's table holds at the exact mid
    frequencies 10**(n/10) Hz. At the nominal frequencies the curve differs from it by up to
    0.28 dB.

    Parameters
    ----------
    frequency_hz : float or array of any shape, Hz
        Frequencies.

    Returns
    -------
    array of the same shape, dB

    References
    ----------
    IEC 61672-1:2013, annex E.

    Examples
    --------
    >>> from acoustics import a_weighting_db
    >>> [round(float(a_weighting_db(f)), 1) for f in (100.0, 1000.0, 10000.0)]
    [-19.1, 0.0, -2.5]
    """
    frequency = real_array("frequency_hz", frequency_hz, None)
    if np.max(np.abs(frequency), initial=0.0) > _HIGHEST_HZ:
        largest = np.max(np.abs(frequency))
        raise ValueError(f"frequency_hz: got {largest:g}, allowed: at most {_HIGHEST_HZ:g} Hz")
    ratio = _response(frequency) / _RESPONSE_1KHZ
    with np.errstate(divide="ignore"):
        return 20.0 * np.log10(ratio)
