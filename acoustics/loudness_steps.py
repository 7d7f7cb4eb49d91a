"""Two steps of the loudness in time as mosqito computes them, in compiled code.

mosqito advances the decay of a loudness by 1/48 ms, and the slopes of masking by 0.1 Bark, in
Python. Both took more time than all else of a loudness in time. This module makes the same
operations in the same order; it has the same digits.
"""

from functools import cache
from math import exp, sqrt
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array

_RATE_HZ = 2000.0  # of the core loudness
_STEPS = 24  # of the decay in a frame
_SHORT_S = 0.005
_LONG_S = 0.015
_VARIABLE_S = 0.075
_EQUAL_SONE = 1e-5  # per Bark, within which a loudness counts as steady

# fmt: off
# Upper ends of the critical bands [Bark].
_ENDS_BARK = np.array(
    [
        0.9, 1.8, 2.8, 3.5, 4.4, 5.4, 6.6, 7.9, 9.2, 10.6, 12.3,
        13.8, 15.2, 16.7, 18.1, 19.3, 20.6, 21.8, 22.7, 23.6, 24.0,
    ]
)
_PLACES = (_ENDS_BARK * 10).astype(np.int32)  # of these ends, 0.1 Bark apart
# Lower ends of the ranges of specific loudness [sone/Bark] in which a slope has one steepness.
_RANGES = np.array(
    [
        21.5, 18.0, 15.1, 11.5, 9.0, 6.1, 4.4, 3.1, 2.13,
        1.36, 0.82, 0.42, 0.30, 0.22, 0.15, 0.10, 0.035, 0.0,
    ]
)
# fmt: on
# Steepness [sone/Bark^2] in each range (rows), above the bands 1 to 8; the last is that of all
# higher bands.
_STEEPNESS = np.array(
    [
        [13.0, 8.2, 6.3, 5.5, 5.5, 5.5, 5.5, 5.5],
        [9.0, 7.5, 6.0, 5.1, 4.5, 4.5, 4.5, 4.5],
        [7.8, 6.7, 5.6, 4.9, 4.4, 3.9, 3.9, 3.9],
        [6.2, 5.4, 4.6, 4.0, 3.5, 3.2, 3.2, 3.2],
        [4.5, 3.8, 3.6, 3.2, 2.9, 2.7, 2.7, 2.7],
        [3.7, 3.0, 2.8, 2.35, 2.2, 2.2, 2.2, 2.2],
        [2.9, 2.3, 2.1, 1.9, 1.8, 1.7, 1.7, 1.7],
        [2.4, 1.7, 1.5, 1.35, 1.3, 1.3, 1.3, 1.3],
        [1.95, 1.45, 1.3, 1.15, 1.1, 1.1, 1.1, 1.1],
        [1.5, 1.2, 0.94, 0.86, 0.82, 0.82, 0.82, 0.82],
        [0.72, 0.67, 0.64, 0.63, 0.62, 0.62, 0.62, 0.62],
        [0.59, 0.53, 0.51, 0.50, 0.42, 0.42, 0.42, 0.42],
        [0.40, 0.33, 0.26, 0.24, 0.24, 0.22, 0.22, 0.22],
        [0.27, 0.21, 0.20, 0.18, 0.17, 0.17, 0.17, 0.17],
        [0.16, 0.15, 0.14, 0.12, 0.11, 0.11, 0.11, 0.11],
        [0.12, 0.11, 0.10, 0.08, 0.08, 0.08, 0.08, 0.08],
        [0.09, 0.08, 0.07, 0.06, 0.06, 0.06, 0.06, 0.05],
        [0.06, 0.05, 0.03, 0.02, 0.02, 0.02, 0.02, 0.02],
    ]
)
_LAST_RANGE = len(_RANGES) - 1
_LAST_STEEPNESS = _STEEPNESS.shape[1] - 1


class Coefficients(NamedTuple):
    """Factors of a step: the capacitors 1 and 2 of the model feed the output and each other."""

    second_of_output: float
    second_of_second: float
    output_of_output: float
    output_of_second: float
    long: float
    variable: float


def decayed(core_loudness: Array) -> Array:
    """Return the core loudness of bands with its decay in time.

    A loudness that rises is followed at once. One that falls is followed with 15 ms after a sound
    of some milliseconds, and with 75 ms after a long one.

    Parameters
    ----------
    core_loudness : array (bands, frames), sone/Bark. Core loudness in frames of 0.5 ms.

    Returns
    -------
    array (bands, frames), sone/Bark

    References
    ----------
    ISO 532-1:2017, A.4, function f_nl of its program.
    """
    core = np.ascontiguousarray(core_loudness, dtype=float)
    out = np.empty_like(core)
    _kernels().decay(core, coefficients(), out)
    return out


def total(core_loudness: Array) -> Array:
    """Return the loudness of frames, the integral of specific loudness with its slopes [sone].

    A band masks those above it: the specific loudness falls along a slope until it meets the core
    loudness of a higher band.

    Parameters
    ----------
    core_loudness : array (21, frames), sone/Bark. Core loudness of the critical bands.

    Returns
    -------
    array (frames,), sone
        To three digits after the point, and above 16 sone to two.

    References
    ----------
    ISO 532-1:2017, A.4, function f_calc_slopes of its program.
    """
    core = np.ascontiguousarray(core_loudness, dtype=float)
    sone = np.empty(core.shape[1])
    _kernels().slopes(core, sone)
    np.maximum(sone, 0.0, out=sone)
    return np.where(sone <= 16, np.floor(sone * 1e3 + 0.5) / 1e3, np.floor(sone * 1e2 + 0.5) / 1e2)


@cache
def coefficients() -> Coefficients:
    """Return the factors of a step of 1/48 ms."""
    step_s = 1.0 / (_RATE_HZ * _STEPS)
    p = (_VARIABLE_S + _LONG_S) / (_VARIABLE_S * _SHORT_S)
    q = 1.0 / (_SHORT_S * _VARIABLE_S)
    slow = -p / 2.0 + sqrt(p * p / 4.0 - q)
    fast = -p / 2.0 - sqrt(p * p / 4.0 - q)
    scale = _VARIABLE_S * (slow - fast)
    slow_step = exp(slow * step_s)
    fast_step = exp(fast * step_s)
    of_slow = _VARIABLE_S * slow + 1.0
    of_fast = _VARIABLE_S * fast + 1.0
    return Coefficients(
        second_of_output=(slow_step - fast_step) / scale,
        second_of_second=(of_fast * slow_step - of_slow * fast_step) / scale,
        output_of_output=(of_slow * slow_step - of_fast * fast_step) / scale,
        output_of_second=of_slow * of_fast * (slow_step - fast_step) / scale,
        long=exp(-step_s / _LONG_S),
        variable=exp(-step_s / _VARIABLE_S),
    )


class Kernels(NamedTuple):
    """The compiled functions of this module."""

    decay: Any
    slopes: Any


@cache
def _kernels() -> Kernels:
    """Compile the steps, which takes half a second and so needs no cache on the disk."""
    import numba

    rounded = numba.njit(_rounded)
    first_range = numba.njit(_range_finder(rounded))
    return Kernels(numba.njit(_advance), numba.njit(_slopes_by(rounded, first_range)))


def _advance(core: Array, factors: Coefficients, out: Array) -> None:
    """Write the decayed loudness of each band at the first step of each frame.

    Between frames the core loudness is linear, and it ends at zero. As in mosqito, the output
    before the first step is the core loudness at the last step.
    """
    bands, frames = core.shape
    for band in range(bands):
        rise = (0.0 - core[band, frames - 1]) / _STEPS
        output = core[band, frames - 1]
        for _ in range(_STEPS - 1):
            output += rise
        second = 0.0
        for frame in range(frames):
            given = core[band, frame]
            following = core[band, frame + 1] if frame + 1 < frames else 0.0
            rise = (following - given) / _STEPS
            for step in range(_STEPS):
                if output > second:
                    fallen = output * factors.output_of_output - second * factors.output_of_second
                else:
                    fallen = output * factors.long
                new = fallen if fallen >= given else given
                new_second = new
                if given < output:
                    if output > second:
                        fed = output * factors.second_of_output - second * factors.second_of_second
                        if fed <= new:
                            new_second = fed
                elif abs(given - output) >= _EQUAL_SONE or new > second:
                    new_second = (second - given) * factors.variable + given
                output = new
                second = new_second
                if step == 0:
                    out[band, frame] = new
                given += rise


def _rounded(value: float) -> Any:
    """Return a value as mosqito compares it."""
    return np.rint(value * 1e8) / 1e8


def _range_finder(rounded: Any) -> Any:
    """Return a function that finds the range of a specific loudness."""

    def range_of(value: float, or_equal: bool) -> int:
        """Return the first range that begins below a value, or at it; the last one has no end."""
        compared = rounded(value)
        for number in range(_LAST_RANGE):
            begin = rounded(_RANGES[number])
            if compared > begin or (compared == begin and not or_equal):
                return number
        return _LAST_RANGE

    return range_of


def _slopes_by(rounded: Any, range_of: Any) -> Any:
    """Return the function that integrates specific loudness over the bands of each frame."""

    def slopes(core: Array, sone: Array) -> None:
        bands, frames = core.shape
        for frame in range(frames):
            area = 0.0
            n1 = 0.0  # sone/Bark, at the begin of a slope,
            z1 = 0.0  # Bark
            before = core[bands - 1, frame]
            reached = _RANGES[range_of(before, False)]  # to which the slope at hand goes down
            for band in range(bands):
                own = core[band, frame]
                end = _ENDS_BARK[band]
                column = min(band - 1, _LAST_STEEPNESS) if band else _LAST_STEEPNESS
                if rounded(before) <= rounded(own):
                    area += own * (end - z1)
                    n1 = own
                    z1 = end
                    reached = _RANGES[range_of(own, False)]
                    before = own
                    continue
                number = range_of(before, False)
                steepness = _STEEPNESS[number, column]
                z2 = min((n1 - max(reached, own)) / steepness + z1, end)
                n2 = n1 - (z2 - z1) * steepness
                area += (z2 - z1) * (n1 + n2) / 2
                reached = _RANGES[number]
                z = _ENDS_BARK[band - 1] + 0.1
                first = _PLACES[band - 1] if band else 0
                is_falling = True
                for place in range(first, _PLACES[band]):
                    begins_anew = rounded(z2) <= rounded(z)
                    if begins_anew:
                        number = range_of(n2, True)
                        reached = _RANGES[number]
                        steepness = _STEEPNESS[number, column]
                        n1 = n2
                        z1 = z2
                        if rounded(n1) <= rounded(own):
                            n2 = own
                            z2 = end
                            area += n2 * (z2 - z1)
                            is_falling = False
                        else:
                            z2 = min((n1 - max(reached, own)) / steepness + z1, end)
                            n2 = n1 - (z2 - z1) * steepness
                            area += (z2 - z1) * (n1 + n2) / 2
                    z += 0.1
                    n1 = n2
                    z1 = z2
                    if begins_anew and place == _PLACES[band] - 1:
                        reached = _RANGES[range_of(n2, True)]
                    elif not is_falling:
                        reached = _RANGES[range_of(own, False)]
                    if not is_falling:
                        break
                before = n1
            sone[frame] = area

    return slopes
