"""A free plate without a baffle: two methods and closed forms, and the stated uncertainty."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from acoustics.radiation import SOUND_M_S
from acoustics.ritz_plate import RitzPlate
from acoustics.unbaffled import baffle_uncertainty_db

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from unbaffled_panels import NO_VOLUME, RIGID, disc_limits, disc_powers, plate_powers

# Power in a baffle over that in the open [dB] of modes of a plate of 400 x 300 x 10 mm whose root
# of the area is 0.8 of the wavelength of sound, by `python tests/benchmarks/unbaffled_study.py`.
MODES = [0, 1, 2, 4, 5, 6, 8, 11]
REFERENCE_DB = [-0.37, 6.33, 2.98, 4.41, -0.21, 8.56, -1.69, -1.84]
# What the baffle takes from the third octaves at a listener above plates that are struck at a place
# [dB], by `python tests/benchmarks/unbaffled_bands.py`: by the sides and the wave number of sound
# at coincidence, from wave numbers of 1 in steps of two third octaves, both times the root of the
# area.
STRUCK_DB = {
    (2, 8): (-11.9, -13.1, -5.0, -2.3, 11.0, 5.3, 5.1, 0.9, -0.9, -1.2),
    (2, 32): (-17.2, -1.9, 1.1, 5.5, 5.8, 5.9, 0.4, 9.7, 9.8, 4.0),
    (3, 8): (-13.5, -9.9, -3.8, 0.3, 8.0, 11.3, 2.6, -1.3, -1.9, -1.2),
    (3, 32): (-14.9, -5.4, -2.3, 4.3, 3.7, -1.2, -0.3, 8.8, 4.7, 5.2),
}


@pytest.mark.law("Free plates: a disc in the open radiates as its closed forms, baffled or not.")
@pytest.mark.parametrize("profile", [RIGID, NO_VOLUME])
def test_disc(profile: str) -> None:
    """At ka = 0.05 the closed forms leave terms of (ka)^2 = 0.0025."""
    exchange, far, baffled = disc_powers(0.05, profile, count=12)
    open_limit, baffled_limit = disc_limits(0.05, profile)
    assert exchange == pytest.approx(far, rel=1e-6)
    assert exchange == pytest.approx(open_limit, rel=0.0025)
    assert baffled == pytest.approx(baffled_limit, rel=0.0025)


def test_disc_that_moves_no_volume_is_louder_in_the_open() -> None:
    exchange, _, baffled = disc_powers(0.2, NO_VOLUME, count=12)
    assert 10 * np.log10(exchange / baffled) == pytest.approx(18.2, abs=0.1)
    exchange, _, baffled = disc_powers(0.2, RIGID, count=12)
    assert 10 * np.log10(exchange / baffled) == pytest.approx(-26.1, abs=0.1)


@pytest.mark.law("Free plates: panels and waves agree on the power without a baffle.")
def test_panels_agree_with_waves() -> None:
    """The functions of the study leave 0.2 dB, and panels as large as here 0.1 dB."""
    thickness = 10e-3
    plate = RitzPlate(
        7850 * thickness,
        210e9 * thickness**3 / 12 / 0.91,
        0.01,
        length_m=0.4,
        width_m=0.3,
        poissons_ratio=0.3,
        edges=("free", "free"),
    )
    frequency = 0.8 * SOUND_M_S / np.sqrt(0.12)
    baffled = 2 * plate.resistances(frequency)[MODES]
    found = 10 * np.log10(baffled / plate_powers(plate, frequency, MODES, 8))
    assert found == pytest.approx(np.array(REFERENCE_DB), abs=0.3)


@pytest.mark.law("Free plates: the stated uncertainty holds what the baffle changes.")
def test_uncertainty_of_struck_plates() -> None:
    """Plates that the rule was not read from; twice a standard uncertainty holds 95 % of bands."""
    within = []
    for (_, coincidence), changes in STRUCK_DB.items():
        sizes = 2 ** (2 / 3 * np.arange(len(changes)))  # of a plate of 1 m2
        to_hz = SOUND_M_S / (2 * np.pi)
        spread = baffle_uncertainty_db(sizes * to_hz, 1.0, coincidence * to_hz)
        within.extend(np.abs(changes) <= 2 * spread)
    assert np.mean(within) >= 0.95


def test_refused_area() -> None:
    with pytest.raises(ValueError, match="area_m2: got 0, allowed: a number > 0"):
        baffle_uncertainty_db([1000.0], 0, 1200.0)
