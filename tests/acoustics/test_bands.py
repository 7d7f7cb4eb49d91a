"""Third octaves have the base-10 bands of IEC 61260-1, add up to the lines, and fit white noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acoustics.bands import (
    AUDIBLE_HZ,
    BAND_NAMES,
    BANDWIDTH_HZ,
    EDGES_HZ,
    MID_HZ,
    NOMINAL_HZ,
    band_uncertainty_db,
    reliable,
    third_octave_mean_square,
)
from acoustics.spectrum import line_spectrum


def test_nominal_frequencies_name_the_exact_ones():
    # The roundest nominal value, 3150 for 3162 or 31.5 for 31.62, is 0.8 % off at most.
    assert len(NOMINAL_HZ) == len(MID_HZ) == 31
    assert np.max(np.abs(np.array(NOMINAL_HZ) / MID_HZ - 1.0)) < 0.01
    assert (
        BAND_NAMES[0] == "20"
        and BAND_NAMES[2] == "31.5"
        and BAND_NAMES[17] == "1000"
        and BAND_NAMES[-1] == "20000"
    )


@pytest.mark.law("Third octaves: their edges are the base-10 edges of IEC 61260-1.")
def test_edges_lie_a_twentieth_of_a_decade_from_the_middle():
    np.testing.assert_allclose(EDGES_HZ[:-1] * 10**0.05, MID_HZ, rtol=1e-14)
    np.testing.assert_allclose(EDGES_HZ[1:] / 10**0.05, MID_HZ, rtol=1e-14)
    np.testing.assert_allclose(AUDIBLE_HZ, (17.7828, 22387.2), rtol=1e-6)  # as printed, six digits


@pytest.mark.law("Third octaves: they add up to the lines.")
@settings(max_examples=40, deadline=None)
@given(n=st.integers(1, 5000), rate=st.floats(10.0, 2e5), seed=st.integers(0, 99))
def test_bands_add_up_to_the_lines(n, rate, seed):
    frequency, lines = line_spectrum(np.random.default_rng(seed).standard_normal(n), rate)
    inside = (frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
    # The same numbers are added in another order: rounding only.
    np.testing.assert_allclose(
        third_octave_mean_square(frequency, lines).sum(), lines[inside].sum(), rtol=1e-13
    )


def test_no_lines_have_no_power():
    """A record of a few samples may have no audible line."""
    assert not third_octave_mean_square(np.zeros(0), np.zeros(0)).any()


def test_a_line_on_an_edge_belongs_to_the_band_above():
    power = third_octave_mean_square(EDGES_HZ, np.arange(32.0))
    assert np.array_equal(power, np.arange(31.0))  # the last edge is outside
    below = third_octave_mean_square(np.nextafter(EDGES_HZ, 0.0), np.arange(32.0))
    assert np.array_equal(below, np.arange(1.0, 32.0))  # here the first is


@pytest.mark.law("Third octaves: white noise grows with the bandwidth, within 4.34 / sqrt(B T) dB.")
def test_white_noise_grows_with_the_bandwidth_within_the_stated_uncertainty():
    rate = 48000.0
    n = 480000
    noise = np.random.default_rng(3).standard_normal(n)
    power = third_octave_mean_square(*line_spectrum(noise, rate))
    expected = BANDWIDTH_HZ / (rate / 2.0)
    error_db = 10.0 * np.log10(power / expected)
    normalised = error_db / band_uncertainty_db(n / rate)
    # 31 standard normal numbers: the largest is below 4 in 99.8 %, their rms between 0.7 and 1.3 in
    # 98 % of all seeds. B T is 46 in the lowest band, so levels are nearly normal.
    assert np.max(np.abs(normalised)) < 4.0
    assert 0.7 < np.sqrt(np.mean(normalised**2)) < 1.3
    slope = np.polyfit(
        np.log10(BANDWIDTH_HZ), 10.0 * np.log10(power), 1, w=1.0 / band_uncertainty_db(n / rate)
    )[0]
    assert abs(slope - 10.0) < 0.1  # dB per decade of bandwidth; its standard error here is 0.04


def test_reliable_bands_have_bt_of_5():
    # 0.5 s needs 10 Hz of bandwidth: 40 Hz has 9.2 Hz, 50 Hz has 11.5 Hz.
    assert [name for name, ok in zip(BAND_NAMES, reliable(0.5), strict=True) if not ok] == [
        "20",
        "25",
        "31.5",
        "40",
    ]
    assert np.all(band_uncertainty_db(0.5)[~reliable(0.5)] > 1.94)
    assert np.all(band_uncertainty_db(0.5)[reliable(0.5)] < 1.95)  # 4.34 / sqrt(5)
