"""Decay of loudness in time (ISO 532-1:2017, method 2), compiled.

mosqito advances all bands together by 1/48 ms in Python, which took four fifths of the time of a
loudness. Here each band goes through time alone, with the same operations in the same order, so
that the numbers are those of mosqito.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

from acoustics.arrays import Array

FRAMES_PER_S = 2000.0
ITERATIONS = 24  # of the circuit within a frame
SHORT_S = 0.005  # time constants of the circuit
LONG_S = 0.015
VARIABLE_S = 0.075
_EQUAL = 1e-5  # sone; voltages that differ by less are equal


def decayed(core: Array) -> Array:
    """Return the core loudness of bands after the decay of hearing [sone].

    Parameters
    ----------
    core : array (bands, frames), sone. Core loudness in frames of 0.5 ms.
    """
    kernel = _compiled()
    result = np.empty_like(core)
    for band, course in enumerate(core):
        kernel(np.ascontiguousarray(course), *_circuit(), result[band])
    return result


def _circuit() -> tuple[float, float, float, float, float, float]:
    """Return the factors of the two voltages of the circuit, which discharges and charges."""
    step_s = 1.0 / (FRAMES_PER_S * ITERATIONS)
    p = (VARIABLE_S + LONG_S) / (VARIABLE_S * SHORT_S)
    q = 1.0 / (SHORT_S * VARIABLE_S)
    slow = -p / 2.0 + math.sqrt(p * p / 4.0 - q)
    fast = -p / 2.0 - math.sqrt(p * p / 4.0 - q)
    den = VARIABLE_S * (slow - fast)
    of_slow = math.exp(slow * step_s)
    of_fast = math.exp(fast * step_s)
    by_slow = VARIABLE_S * slow + 1.0
    by_fast = VARIABLE_S * fast + 1.0
    return (
        (of_slow - of_fast) / den,
        (by_fast * of_slow - by_slow * of_fast) / den,
        (by_slow * of_slow - by_fast * of_fast) / den,
        by_slow * by_fast * (of_slow - of_fast) / den,
        math.exp(-step_s / LONG_S),
        math.exp(-step_s / VARIABLE_S),
    )


_kernels: list[Any] = []  # the compiled kernel, once it is needed


def _compiled() -> Any:
    """Return the kernel, compiled with a lasting cache where there is a folder for it."""
    if not _kernels:
        try:
            _kernels.append(numba.njit(cache=True)(_decay))
        except RuntimeError:  # no folder that can be written
            _kernels.append(numba.njit(_decay))
    return _kernels[0]


def _decay(
    core: Array, b0: float, b1: float, b2: float, b3: float, b4: float, b5: float, result: Array
) -> None:
    """Write the voltage of the first capacitor at the frames of a band into the result."""
    frames = len(core)
    # Before the first frame the first capacitor has the voltage after the last one, as in mosqito.
    step = (0.0 - core[-1]) / ITERATIONS
    out_before = core[-1]
    for _ in range(1, ITERATIONS):
        out_before += step
    second_before = 0.0
    for frame in range(frames):
        following = 0.0
        if frame + 1 < frames:
            following = core[frame + 1]
        step = (following - core[frame]) / ITERATIONS
        into = core[frame]
        for iteration in range(ITERATIONS):
            if iteration > 0:
                into += step
            if out_before > second_before:
                falling = out_before * b2 - second_before * b3
            else:
                falling = out_before * b4
            out = into
            if falling >= into:
                out = falling
            second = out
            if into < out_before and out_before > second_before:
                discharged = out_before * b0 - second_before * b1
                if discharged <= out:
                    second = discharged
            if into >= out_before:
                is_equal = abs(into - out_before) < _EQUAL and out <= second_before
                if not is_equal:
                    second = (second_before - into) * b5 + into
            if iteration == 0:
                result[frame] = out
            out_before = out
            second_before = second
