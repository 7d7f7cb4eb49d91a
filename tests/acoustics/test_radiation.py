"""Radiation follows the area of the sphere and the two laws of a level."""

import math

import numpy as np
import pytest

from acoustics.level import laeq_db
from acoustics.radiation import RHO_C, intensity, sound_pressure

NOISE = np.random.default_rng(1).standard_normal(4800) * 1e-7


@pytest.mark.law("Radiation: the intensity at distance r is P / (4 pi r^2).")
def test_intensity_spreads_over_a_sphere():
    # 1 / (4 pi), ten digits
    assert intensity(np.array([1.0]), 1.0)[0] == pytest.approx(0.0795774715, rel=1e-9)
    assert intensity(np.array([3.0]), 2.0, q=0.5)[0] == pytest.approx(
        3.0 * 0.5 / (16.0 * math.pi), rel=1e-15
    )


@pytest.mark.law("Radiation: the mean of p^2 / (rho c) is the rms of the intensity's fluctuation.")
def test_pressure_carries_the_rms_of_the_intensity():
    pressure, factor = sound_pressure(NOISE)
    assert np.mean(pressure**2) / RHO_C == pytest.approx(np.sqrt(np.mean(NOISE**2)), rel=1e-12)
    # linear: the wave form is that of the power
    np.testing.assert_array_equal(pressure, factor * NOISE)


@pytest.mark.law(
    "Radiation: between records the level follows 10 lg of the release, with a given gain 20 lg."
)
@pytest.mark.parametrize(("gain", "expected"), [(None, 10.0), (2.0e3, 20.0)])
def test_level_law_between_records(gain, expected):
    # Ten times the release: 10 dB between records that each have their own factor, 20 dB with one
    # gain.
    once, tenfold = (laeq_db(sound_pressure(c * NOISE, gain)[0], 48000) for c in (1.0, 10.0))
    assert once is not None and tenfold is not None
    assert tenfold - once == pytest.approx(expected, abs=1e-9)


@pytest.mark.law("Radiation: with a given gain sounds superpose.")
def test_a_given_gain_superposes():
    a = NOISE
    b = NOISE[::-1]
    together = sound_pressure(a + b, 5.0)[0]
    np.testing.assert_allclose(
        together, sound_pressure(a, 5.0)[0] + sound_pressure(b, 5.0)[0], rtol=0, atol=1e-20
    )


def test_silence():
    for gain, expected in ((None, 0.0), (7.0, 7.0)):
        pressure, factor = sound_pressure(np.zeros(5), gain)
        assert factor == expected and np.array_equal(pressure, np.zeros(5))


@pytest.mark.parametrize("gain", [0.0, -1.0, math.inf, math.nan])
def test_a_gain_is_a_positive_number(gain):
    with pytest.raises(ValueError, match=r"gain_pa_per_w_m2: got .* a number > 0"):
        sound_pressure(NOISE, gain)
