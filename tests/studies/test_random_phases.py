"""The comparison with random phases finds nothing in noise, and what is modulated in it."""

from __future__ import annotations

import numpy as np
import pytest
from random_phases import measured, with_random_phases

RATE = 48000
NOISE = np.random.default_rng(3).standard_normal(2 * RATE)
TIME = np.arange(len(NOISE)) / RATE


def test_random_phases_keep_the_spectrum() -> None:
    drawn = with_random_phases(NOISE, 1)
    assert np.allclose(np.abs(np.fft.rfft(drawn)), np.abs(np.fft.rfft(NOISE)))
    assert abs(np.corrcoef(drawn, NOISE)[0, 1]) < 0.02


def test_noise_is_as_its_random_phases_and_a_modulated_one_is_not() -> None:
    """An envelope 1 + m cos has the rms modulation m / sqrt 2, beside that of the noise."""
    row = measured("noise", NOISE)
    assert float(row["ratio"]) == pytest.approx(1, abs=0.1)
    assert float(row["kurtosis"]) == pytest.approx(3, abs=0.1)
    own = float(row["modulation"])
    swelling = measured("swelling", NOISE * (1 + 0.5 * np.cos(2 * np.pi * 5 * TIME)))
    expected = np.hypot(0.5 / np.sqrt(2), own * np.sqrt(1 + 0.5**2 / 2))
    assert float(swelling["modulation"]) == pytest.approx(expected, rel=0.05)
    assert float(swelling["ratio"]) > 3
    ticks = measured("ticks", NOISE * (1 + 9 * (TIME % 0.2 < 0.002)))
    assert float(ticks["kurtosis"]) > 10
