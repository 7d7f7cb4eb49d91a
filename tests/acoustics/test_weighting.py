"""The A-weighting agrees with Table 3 of IEC 61672-1:2013."""

from pathlib import Path

import numpy as np
import pytest

from acoustics.weighting import POLES_HZ, a_weighting_db

DATA = Path(__file__).parents[1] / "data" / "a_weighting_iec61672.csv"
TABLE = np.genfromtxt(DATA, delimiter=",", names=True, skip_header=2)


@pytest.mark.law("A-weighting: the curve is Table 3 of IEC 61672-1:2013 at the exact frequencies.")
def test_the_curve_is_the_table_at_the_exact_frequencies():
    # The table is rounded to 0.1 dB, so a right curve is within half of that.
    assert len(TABLE) == 34
    difference = a_weighting_db(10.0 ** (TABLE["n"] / 10.0)) - TABLE["a_weighting_db"]
    assert np.max(np.abs(difference)) <= 0.05 + 1e-9


def test_at_nominal_frequencies_it_is_not():
    # Why the exact frequencies matter: 0.28 dB is gained or lost by reading the table at nominal
    # ones.
    difference = a_weighting_db(TABLE["nominal_hz"]) - TABLE["a_weighting_db"]
    assert 0.2 < np.max(np.abs(difference)) < 0.3


def test_1_khz_is_the_reference_exactly():
    assert a_weighting_db(1000.0) == 0.0


def test_0_hz_is_silent_without_a_warning():
    with np.errstate(all="raise"):
        assert a_weighting_db(0.0) == -np.inf
        assert list(np.isinf(a_weighting_db(np.array([0.0, 1.0])))) == [True, False]


def test_poles_are_those_of_the_standard():
    # The standard prints them rounded: half a unit of the last digit each.
    assert np.all(
        np.abs(np.array(POLES_HZ) - (20.60, 107.7, 737.9, 12194.0)) <= (0.005, 0.05, 0.05, 0.5)
    )
