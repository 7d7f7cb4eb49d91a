"""Oracles: Parseval's theorem, and single tones whose lines are known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acoustics.spectrum import article_line_level_db, line_spectrum


@settings(max_examples=60, deadline=None)
@given(n=st.integers(1, 3000), seed=st.integers(0, 999), mean=st.sampled_from([0.0, 1.0, -50.0]))
def test_parseval(n, seed, mean):
    signal = mean + np.random.default_rng(seed).standard_normal(n)
    frequency, lines = line_spectrum(signal, 48000.0)
    assert len(frequency) == len(lines) == n // 2 + 1
    np.testing.assert_allclose(lines.sum(), np.mean(signal**2), rtol=1e-12)  # rounding of n log n operations


@pytest.mark.parametrize(("n", "k", "expected"), [(8, 0, 1.0), (8, 3, 0.5), (8, 4, 1.0), (9, 0, 1.0), (9, 4, 0.5)])
def test_each_kind_of_line(n, k, expected):
    # A cosine of amplitude 1 has the mean square 1/2; at 0 Hz and at Nyquist every sample is +-1.
    frequency, lines = line_spectrum(np.cos(2.0 * np.pi * k * np.arange(n) / n), 800.0)
    assert frequency[k] == pytest.approx(k * 800.0 / n)
    np.testing.assert_allclose(lines, np.where(np.arange(n // 2 + 1) == k, expected, 0.0), atol=1e-15)


@pytest.mark.parametrize("bad", [np.zeros(0), np.zeros((2, 3)), np.array([1.0, np.nan])])
def test_what_is_no_record_is_refused(bad):
    with pytest.raises(ValueError, match="record"):
        line_spectrum(bad, 48000.0)


def test_article_level_of_a_tone():
    # 1 mW amplitude at 1 kHz, 1 m: 10 lg(1e-3 / (4 pi) / 1e-12) = 79.0079 dB, whatever the mean and the length.
    rate = 50000.0
    for n in (5000, 50000):
        power = 0.1 + 1e-3 * np.sin(2.0 * np.pi * 1000.0 * np.arange(n) / rate)
        frequency, level = article_line_level_db(power, rate, 1.0)
        assert frequency[0] > 0.0 and len(level) == n // 2
        top = int(level.argmax())
        assert frequency[top] == pytest.approx(1000.0)
        assert level[top] == pytest.approx(79.00790, abs=1e-5)  # the digits printed
    doubled = article_line_level_db(power, rate, 2.0, q=0.5)[1][top]
    assert doubled == pytest.approx(79.00790 - 20.0 * np.log10(2.0) - 10.0 * np.log10(2.0), abs=1e-5)


def test_article_level_of_noise_depends_on_the_record_length():
    # The amplitude of a line falls with 1/sqrt(T) and is read as a power: 5 dB per decade of T. The shorter record has
    # 100 lines in the band, each amplitude with a relative standard deviation of 0.52: the mean is good to 0.23 dB.
    noise = np.random.default_rng(1).standard_normal(48000)
    levels = []
    for n in (4800, 48000):
        frequency, level = article_line_level_db(noise[:n], 48000.0, 1.0)
        band = (frequency > 1000.0) & (frequency < 2000.0)
        levels.append(10.0 * np.log10(np.mean(10.0 ** (level[band] / 10.0))))
    assert levels[0] - levels[1] == pytest.approx(5.0, abs=0.8)


def test_zero_lines_are_minus_infinity_without_a_warning():
    with np.errstate(all="raise"):
        assert np.all(article_line_level_db(np.zeros(16), 48000.0, 1.0)[1] == -np.inf)
