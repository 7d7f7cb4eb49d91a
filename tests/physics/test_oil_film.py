"""A film of oil is as thick as Hamrock and Dowson say, and takes waves as its laws say."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from bearings import bearing

from rolling.bearing import oil_film
from rolling.bearing.oil_film import ContactFilm, FilmContact, Oil, contact_film

LOAD_N = 36.4
SPEED_M_S = 1.494


def film(ring: str, viscosity_mpa_s: float) -> FilmContact:
    """Return a contact of a 6204 at 70 N and 1,800 rpm in an oil of 18 /GPa."""
    oil = Oil(1e-3 * viscosity_mpa_s, 18e-9)
    return FilmContact(getattr(bearing(), ring), LOAD_N, SPEED_M_S, oil)


@pytest.mark.law("Oil: films are as thick as Hamrock and Dowson say.")
def test_films_of_a_6204() -> None:
    """Thickness at 10, 20, 50 and 100 mPa s by another program, to its two digits."""
    wanted = {"inner": [0.10, 0.16, 0.29, 0.46], "outer": [0.12, 0.20, 0.36, 0.57]}
    for ring, thickness_um in wanted.items():
        found = [1e6 * film(ring, viscosity).thickness_m for viscosity in (10, 20, 50, 100)]
        assert found == pytest.approx(thickness_um, abs=0.01)
    faster = FilmContact(bearing().inner, LOAD_N, 2 * SPEED_M_S, Oil(20e-3, 18e-9))
    assert faster.thickness_m / film("inner", 20).thickness_m == pytest.approx(2**0.67)


@pytest.mark.law("Oil: viscosity follows Walther's line over temperature.")
def test_viscosity_at_a_temperature() -> None:
    """A spindle oil of 30 and 5.23 mm2/s at 40 and 100 degrees has 14.5 at 60 (libvisc).

    That program adds 0.8 mm2/s as DIN 51563 does, and not 0.7.
    """
    slope = oil_film.viscosity_slope(30.0, 5.23)
    found = [oil_film.kinematic_viscosity_mm2_s(t, 30.0, slope) for t in (40, 60, 100)]
    assert found == pytest.approx([30.0, 14.525, 5.23], rel=0.01)
    assert oil_film.kinematic_viscosity_mm2_s(20, 30.0) > 70  # 1.65 mm2/s colder by a degree


@pytest.mark.law("Oil: a film presses long waves flat and leaves short ones as they are.")
def test_waves_in_a_film() -> None:
    """Shares that press by both laws, at 150 um; long waves act as in a dry contact."""
    shares = {
        (ring, viscosity): film(ring, viscosity).pressed_shares(np.array([150e-6]))
        for ring in ("inner", "outer")
        for viscosity in (20, 100)
    }
    for ring in ("inner", "outer"):
        circular, line = (float(share[0]) for share in shares[ring, 20])
        assert 0.8 < circular < 0.95 and 0.5 <= line < 0.65
        circular, line = (float(share[0]) for share in shares[ring, 100])
        assert 0.55 < circular < 0.8 and 0.2 < line < 0.35
    waves = np.array([1e-6, 1e-5, 1e-4, 1e-3, 1.0, inf])
    between = film("outer", 50).pressed_share(waves)
    assert np.all(np.diff(between) > 0) or between[-1] == 1.0
    assert between[0] < 0.1 and between[-2] == pytest.approx(1.0, abs=1e-3) and between[-1] == 1.0
    circular, line = film("outer", 50).pressed_shares(waves)
    assert np.all((between <= np.maximum(circular, line)) & (between >= np.minimum(circular, line)))


def test_a_film_has_the_weight_of_its_ratio() -> None:
    weights = [oil_film.film_weight(ratio) for ratio in (0.2, 1.0, 2.0, 3.0, inf)]
    assert weights == [0.0, 0.0, 0.5, 1.0, 1.0]
    contact = bearing().inner
    thick: ContactFilm = contact_film(contact, LOAD_N, SPEED_M_S, Oil(50e-3, 18e-9), 0.05e-6)
    assert thick.ratio == pytest.approx(0.294 / 0.05, rel=0.01)
    assert contact_film(contact, LOAD_N, SPEED_M_S, thick.oil, 0.0).ratio == inf
