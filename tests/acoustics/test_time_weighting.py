"""Time weighting meets its closed forms, a long loop and the tone bursts of IEC 61672-1."""

import math

import numpy as np
import pytest

from acoustics.level import (
    FAST_S,
    SLOW_S,
    a_weighted,
    a_weighted_rms,
    level_db,
    running_mean_square,
)

RATE = 48000


@pytest.mark.law("Time weighting: from silence a constant rises as 1 - exp(-t / tau).")
@pytest.mark.parametrize("tau", [FAST_S, SLOW_S])
def test_from_silence_a_constant_rises_as_one_minus_exp(tau):
    t = np.arange(1, RATE + 1) / RATE
    got = running_mean_square(np.full(RATE, 3.0), RATE, tau, closed=False)
    # rounding of 48000 recursions
    np.testing.assert_allclose(got, 9.0 * -np.expm1(-t / tau), rtol=1e-10)


# IEC 61672-1:2013, table 4: maximum of a 4 kHz tone burst below the level of the steady tone, dB.
@pytest.mark.law("Time weighting: tone bursts read as IEC 61672-1 asks.")
@pytest.mark.parametrize(
    ("tau", "milliseconds", "below_db"),
    [
        (FAST_S, 1000, 0.0), (FAST_S, 500, -0.1), (FAST_S, 200, -1.0), (FAST_S, 100, -2.6),
        (FAST_S, 50, -4.8), (FAST_S, 20, -8.3), (FAST_S, 10, -11.1), (FAST_S, 5, -14.1),
        (FAST_S, 2, -18.0), (FAST_S, 1, -21.0), (FAST_S, 0.25, -27.0),
        (SLOW_S, 1000, -2.0), (SLOW_S, 500, -4.1), (SLOW_S, 200, -7.4), (SLOW_S, 100, -10.2),
        (SLOW_S, 50, -13.1), (SLOW_S, 20, -17.0), (SLOW_S, 10, -20.0), (SLOW_S, 5, -23.0),
        (SLOW_S, 2, -27.0),
    ],
)  # fmt: skip
def test_tone_bursts_of_the_standard(tau, milliseconds, below_db):
    n = round(milliseconds * RATE / 1000)
    record = np.zeros(n + RATE)
    record[100 : 100 + n] = math.sqrt(2.0) * np.sin(2.0 * np.pi * 4000.0 * np.arange(n) / RATE)
    got = level_db(float(running_mean_square(record, RATE, tau, closed=False).max()), 1.0)
    # The table is rounded to 0.1 dB: half of that, and 0.02 dB as it gives -20.0 for -20.02 and
    # -27.0 for -27.02.
    assert got == pytest.approx(below_db, abs=0.07)


@pytest.mark.parametrize("n", [2, 480, 24001])
def test_a_loop_reads_as_one_that_has_played_for_long(n):
    record = np.random.default_rng(1).standard_normal(n)
    rounds = math.ceil(30 * FAST_S * RATE / n)  # what the start leaves: exp(-30) = 1e-13
    long = running_mean_square(np.tile(record, rounds + 1), RATE, FAST_S, closed=False)[-n:]
    got = running_mean_square(record, RATE, FAST_S, closed=True)
    np.testing.assert_allclose(got, long, rtol=1e-9)  # rounding of 1e5 recursions
    # The weighting neither adds nor takes energy.
    assert np.mean(got) == pytest.approx(np.mean(record**2), rel=1e-10)


def test_the_weighted_record_has_the_weighted_level():
    for n in (24000, 23993, 2):
        record = np.random.default_rng(3).standard_normal(n)
        rms = math.sqrt(np.mean(a_weighted(record, RATE) ** 2))
        assert rms == pytest.approx(a_weighted_rms(record, RATE), rel=1e-12)  # Parseval
    tone = np.sin(2.0 * np.pi * 1000.0 * np.arange(4800) / RATE)
    # 0 dB at 1 kHz, and no delay
    np.testing.assert_allclose(a_weighted(tone, RATE), tone, atol=1e-13)
