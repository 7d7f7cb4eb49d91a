"""Pressure, contact radius and approach of a smooth sphere converge to Hertz."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import STEEL, assert_solved, make_track, roll

from rolling.contact import closed_forms
from rolling.contact.half_space import HalfSpace
from rolling.contact.single_contact import solve_contact
from rolling.contact.solver import ContactError

LOAD = 20.0
RADIUS = 5e-3
A = closed_forms.hertz_radius(LOAD, RADIUS, STEEL)  # 69 um
SPACINGS = (8e-6, 4e-6, 2e-6, 1e-6)


@pytest.fixture(scope="module", params=[0, 1], ids=["between nodes", "on a node"])
def series(request: pytest.FixtureRequest) -> list:
    """Solve a contact per spacing.

    An odd number of nodes across puts the sphere's centre on a node.
    """
    states = []
    for spacing in SPACINGS:
        n = round(240e-6 / spacing) + request.param
        track = make_track(
            np.zeros((n, n)), spacing=spacing, load=LOAD, radius=RADIUS, tolerance=1e-9
        )
        states.append(roll(track, 0, 0)[0])
        assert_solved(track, states[-1])
    return states


def rate(errors: list[float]) -> float:
    return float(np.polyfit(np.log(SPACINGS), np.log(np.abs(errors)), 1)[0])


@pytest.mark.law(
    "Hertz: the approach of a smooth sphere is a^2 / R, and its error falls with the square of the "
    "node spacing."
)
def test_approach_converges_to_hertz_at_second_order(series: list) -> None:
    """The error of the approach falls at second order.

    Measured -5.5e-4, -1.2e-4, -3.1e-5, -8.7e-6 between nodes (rate 1.98), and -7.4e-4 ...
    -8.1e-6 on a node (2.17).
    """
    errors = [s.approach / closed_forms.hertz_approach(LOAD, RADIUS, STEEL) - 1 for s in series]
    assert abs(errors[-1]) < 1.5e-5
    assert 1.75 < rate(errors) < 2.4


@pytest.mark.law(
    "Hertz: the maximum pressure of a smooth sphere is 3 W / (2 pi a^2), and its error falls with "
    "the square of the node spacing."
)
def test_pressure_converges_to_hertz_at_second_order(series: list) -> None:
    """A peak between nodes is missed by (spacing / a)^2 / 4, 1e-3 at 8 um.

    The measured rates are 1.98 and 1.83.
    """
    errors = [s.max_pressure / closed_forms.hertz_pressure(LOAD, RADIUS, STEEL) - 1 for s in series]
    assert abs(errors[-1]) < 3e-5
    assert 1.6 < rate(errors) < 2.4


@pytest.mark.law("Hertz: the contact radius of a smooth sphere obeys a^3 = 3 W R / (4 E*).")
def test_contact_radius_is_hertz_to_a_fraction_of_the_spacing(series: list) -> None:
    """The radius is known to a part of the spacing, at first order.

    A node counts as a whole cell; the measured error is at most 0.16 of the spacing.
    """
    for state, spacing in zip(series, SPACINGS, strict=True):
        assert abs(np.sqrt(state.contact_area / np.pi) - A) < 0.3 * spacing


@pytest.mark.law("Hertz: the pressure of a smooth sphere is p0 sqrt(1 - r^2 / a^2).")
def test_pressure_profile_is_the_hertz_ellipse(series: list) -> None:
    """Inside 0.9 a the pressure is within 0.2 % of p0 at a / spacing = 69.

    No grid resolves the square root at the edge.
    """
    state = series[-1]
    spacing = SPACINGS[-1]
    middle = state.loaded.column + (state.loaded.columns - 1) / 2
    assert 0 <= middle - (round(240e-6 / spacing) - 1) / 2 <= 0.5
    x = (state.window.row + np.arange(state.window.rows)) * spacing
    y = (state.window.column + np.arange(state.window.columns) - middle) * spacing
    r2 = (x[:, None] ** 2 + y**2) / A**2
    p0 = closed_forms.hertz_pressure(LOAD, RADIUS, STEEL)
    exact = p0 * np.sqrt(np.maximum(1 - r2, 0))
    assert np.abs(state.pressure - exact)[r2 < 0.81].max() < 2e-3 * p0
    assert state.pressure[r2 > (1 + spacing / A) ** 2].max() == 0


@pytest.mark.law("Hertz: area, pressure and approach follow the powers of load and radius.")
def test_load_and_radius_follow_the_powers_of_hertz() -> None:
    """Lengths times 4 and load times 16 give the same pressures and 4 times the approach.

    These are powers of two, so only rounding differs.
    """
    one = roll(make_track(np.zeros((64, 64)), load=5.0, radius=5e-3), 0, 0)[0]
    other = roll(
        make_track(np.zeros((64, 64)), load=5.0 * 16, radius=5e-3 * 4, spacing=8e-6), 0, 0
    )[0]
    np.testing.assert_allclose(
        other.pressure, one.pressure, rtol=1e-9, atol=1e-9 * one.max_pressure
    )
    assert other.approach / one.approach == pytest.approx(4, rel=1e-12)


def test_a_refusal_for_rounding_names_a_tolerance_that_is_met() -> None:
    space = HalfSpace(spacing=2e-6, contact_modulus=230e9)
    x = np.arange(-20, 21) * space.spacing
    gap = 1e3 + (x[:, None] ** 2 + x**2) / (2 * 5e-3)
    with pytest.raises(ContactError, match=r"gaps of up to 1000 m") as error:
        solve_contact(space, gap, 5.0, tolerance=1e-9)
    named = float(str(error.value).split("a tolerance of at least ")[1].split()[0])
    assert solve_contact(space, gap, 5.0, tolerance=1.01 * named).residual <= named


@pytest.mark.law("Hertz: a single contact has the maximum pressure 3 W / (2 pi a^2) and no yield.")
def test_a_single_contact_knows_its_maximum_pressure() -> None:
    """With a node at the middle the maximum is missed by -4e-4 at 2 um, or a / 34."""
    space = HalfSpace(2e-6, STEEL)
    x = np.arange(-60, 61) * space.spacing
    gap = (x[:, None] ** 2 + x**2) / (2 * RADIUS)
    contact = solve_contact(space, gap, LOAD)
    assert contact.max_pressure == pytest.approx(
        closed_forms.hertz_pressure(LOAD, RADIUS, STEEL), rel=1e-3
    )
    assert contact.plastic_area == 0.0


def test_a_punch_at_the_hardness_is_plastic_as_a_whole() -> None:
    """A flat punch under hardness times its area yields on all of it, and under less on less."""
    space = HalfSpace(2e-6, STEEL)
    gap = np.full((24, 24), 1e-6)
    gap[4:20, 4:20] = 0.0
    area = 256 * space.spacing**2
    hardness = 2e9
    full = solve_contact(space, gap, 0.999999 * hardness * area, hardness=hardness)
    # The last millionth of the load is missing on the four nodes in the middle.
    assert full.plastic_area == pytest.approx(area, rel=0.02)
    assert full.max_pressure == hardness
    half = solve_contact(space, gap, 0.9 * hardness * area, hardness=hardness)
    assert 0 < half.plastic_area < 0.9 * area  # the plastic part alone carries less than the load
