"""The decay of loudness after a sound, as mosqito computes it, in compiled code.

mosqito advances the decay in Python by 1/48 ms, which took more time than all else of a loudness in
time. This module makes the same operations in the same order; it has the same digits.
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
    _kernel()(core, coefficients(), out)
    return out


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


@cache
def _kernel() -> Any:
    """Compile the decay, which takes a quarter of a second and so needs no cache on the disk."""
    import numba

    return numba.njit(_advance)


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
