"""Spectra fit Parseval's theorem, single tones and white noise."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from acoustics.spectrum import article_line_level_db, line_spectrum, welch


@pytest.mark.law("Parseval: the lines of a spectrum hold the mean square of the record.")
@settings(max_examples=60, deadline=None)
@given(n=st.integers(1, 3000), seed=st.integers(0, 999), mean=st.sampled_from([0.0, 1.0, -50.0]))
def test_parseval(n, seed, mean):
    signal = mean + np.random.default_rng(seed).standard_normal(n)
    frequency, lines = line_spectrum(signal, 48000.0)
    assert len(frequency) == len(lines) == n // 2 + 1
    # rounding of n log n operations
    np.testing.assert_allclose(lines.sum(), np.mean(signal**2), rtol=1e-12)


@pytest.mark.parametrize(
    ("n", "k", "expected"), [(8, 0, 1.0), (8, 3, 0.5), (8, 4, 1.0), (9, 0, 1.0), (9, 4, 0.5)]
)
def test_each_kind_of_line(n, k, expected):
    # A cosine of amplitude 1 has the mean square 1/2; at 0 Hz and at Nyquist every sample is +-1.
    frequency, lines = line_spectrum(np.cos(2.0 * np.pi * k * np.arange(n) / n), 800.0)
    assert frequency[k] == pytest.approx(k * 800.0 / n)
    np.testing.assert_allclose(
        lines, np.where(np.arange(n // 2 + 1) == k, expected, 0.0), atol=1e-15
    )


@pytest.mark.parametrize("bad", [np.zeros(0), np.zeros((2, 3)), np.array([1.0, np.nan])])
def test_what_is_no_record_is_refused(bad):
    with pytest.raises(ValueError, match="signal: got"):
        line_spectrum(bad, 48000.0)


def test_article_level_of_a_tone():
    # 1 mW amplitude at 1 kHz, 1 m: 10 lg(1e-3 / (4 pi) / 1e-12) = 79.0079 dB, whatever the mean and
    # the length.
    rate = 50000.0
    for n in (5000, 50000):
        power = 0.1 + 1e-3 * np.sin(2.0 * np.pi * 1000.0 * np.arange(n) / rate)
        frequency, level = article_line_level_db(power, rate, 1.0)
        assert frequency[0] > 0.0 and len(level) == n // 2
        top = int(level.argmax())
        assert frequency[top] == pytest.approx(1000.0)
        assert level[top] == pytest.approx(79.00790, abs=1e-5)  # the digits printed
    doubled = article_line_level_db(power, rate, 2.0, q=0.5)[1][top]
    assert doubled == pytest.approx(
        79.00790 - 20.0 * np.log10(2.0) - 10.0 * np.log10(2.0), abs=1e-5
    )


def test_zero_lines_are_minus_infinity_without_a_warning():
    with np.errstate(all="raise"):
        assert np.all(article_line_level_db(np.zeros(16), 48000.0, 1.0)[1] == -np.inf)


def noise(seed, n):
    return np.random.default_rng(seed).standard_normal(n)


@pytest.mark.law("Parseval: the density of noise adds up to its mean square.")
def test_welch_density_of_noise_adds_up_to_its_mean_square():
    record = noise(4, 480000)
    psd = welch(record, 48000.0)
    assert (psd.window, psd.line_width_hz) == ("hann", 10.0) and psd.frequency_hz[1] == 10.0
    assert psd.enbw_hz == pytest.approx(15.0, rel=1e-12)  # 1.5 lines: Harris (1978), table 1
    # Windows weigh the samples unequally, by 1/3 rms, so the sum is off by 1/3 of the spread
    # sqrt(2/n) = 0.2 % of the mean square, and the two ends are seen half: 0.1 % altogether, three
    # of these.
    assert psd.psd.sum() * psd.line_width_hz == pytest.approx(np.mean(record**2), rel=3e-3)
    # White: 1/24000 per Hz at every line, each uncertain by 1/sqrt(1.9 * 100 segments) = 7 %; 5 of
    # these for 2400 lines.
    np.testing.assert_allclose(psd.psd[1:-1], 1.0 / 24000.0, rtol=0.37)


@pytest.mark.parametrize("n", [5, 16, 31, 2400, 48001])
def test_densities_are_those_of_scipy(n):
    record = noise(n, n)
    psd = welch(record, 48000.0)
    window = signal.get_window("hann", round(48000.0 / psd.line_width_hz))
    options = {"noverlap": len(window) // 2, "detrend": False}
    frequency_hz, expected = signal.welch(record, 48000.0, window, **options)
    np.testing.assert_array_equal(psd.frequency_hz, frequency_hz)
    np.testing.assert_allclose(psd.psd, expected, rtol=1e-13)


@pytest.mark.parametrize("frequency_hz", [1000.0, 1003.7])
def test_welch_gives_the_level_of_a_tone_through_its_noise_bandwidth(frequency_hz):
    psd = welch(0.3 * np.sin(2.0 * np.pi * frequency_hz * np.arange(24000) / 48000.0), 48000.0)
    around = np.abs(psd.frequency_hz - frequency_hz) < 30.0
    # All its lines add up to it; the highest alone does on a line, and lies up to 1.42 dB below
    # between lines (Harris).
    assert psd.psd[around].sum() * psd.line_width_hz == pytest.approx(0.045, rel=1e-3)
    highest_db = 10.0 * np.log10(psd.psd.max() * psd.enbw_hz / 0.045)
    assert -1.42 < highest_db < 1e-6
    assert frequency_hz != 1000.0 or abs(highest_db) < 1e-6


def test_welch_keeps_the_mean_and_refuses_what_is_no_record():
    assert np.isfinite(welch(np.ones(1), 48000).psd).all()  # a single sample has a window, too
    assert welch(np.full(4800, 2.0), 48000.0).psd[0] > 0.0
    with pytest.raises(ValueError, match="finite"):
        welch(np.array([0.0, np.inf]), 48000.0)
