"""A body of two radii presses, sinks, rolls and releases as the elliptic Hertz contact does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import STEEL, assert_solved, make_track, roll, step_energies
from scipy.special import ellipe, ellipk

from rolling.contact import closed_forms
from rolling.contact.state import RollingContact
from rolling.dynamics import drop
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

LOAD = 20.0
RADIUS = 5e-3


def hertz(radius: float, radius_across: float) -> tuple[float, float, float, float]:
    """Return semi-axes, approach and pressure by K and E (Johnson, eq. 4.28 to 4.32), on a rim."""
    wanted = max(radius, radius_across) / min(radius, radius_across)
    low = 1e-6
    high = 1 - 1e-12
    for _ in range(200):  # the ratio of the radii falls with the ratio of the semi-axes
        k = math.sqrt(low * high)
        e2 = 1 - k**2
        ratio = (ellipe(e2) / k**2 - ellipk(e2)) / (ellipk(e2) - ellipe(e2))
        low, high = (k, high) if ratio > wanted else (low, k)
    a = (1.5 * LOAD * max(radius, radius_across) * (ellipk(e2) - ellipe(e2)) / e2) * 2
    a = (a / (math.pi * STEEL)) ** (1 / 3)
    pressure = 1.5 * LOAD / (math.pi * a * a * k)
    axes = (a, a * k) if radius > radius_across else (a * k, a)
    return *axes, pressure * a * k * ellipk(e2) / STEEL, pressure


def track_of(radius: float, radius_across: float, nodes: float, **changes: float) -> RollingContact:
    """Return a smooth track with so many nodes in the shorter semi-axis."""
    along, across, *_ = hertz(radius, radius_across)
    spacing = min(along, across) / nodes
    shape = tuple(2 * math.ceil(1.3 * axis / spacing) for axis in (along, across))
    values = {"spacing": spacing, "load": LOAD, "radius": radius, "tolerance": 1e-8}
    return make_track(np.zeros(shape), **values, radius_across=radius_across, **changes)


@pytest.mark.law("Elliptic Hertz: semi-axes, approach and pressure by complete elliptic integrals.")
@pytest.mark.parametrize("ratio", [1.5, 5.0, 30.0])
@pytest.mark.parametrize("is_transposed", [False, True])
def test_area_approach_and_pressure_are_those_of_hertz(ratio: float, is_transposed: bool) -> None:
    """Measured 2.6 % (as of a sphere, by whole rim nodes), 2e-4 and, by half a node, 7e-4."""
    radii = (RADIUS, ratio * RADIUS)[:: -1 if is_transposed else 1]
    along, across, approach, pressure = hertz(*radii)
    track = track_of(*radii, nodes=12)
    state = roll(track, 0, 0)[0]
    assert_solved(track, state)
    assert state.contact_area == pytest.approx(math.pi * along * across, rel=0.03)
    assert state.approach == pytest.approx(approach, rel=3e-4)
    assert state.max_pressure == pytest.approx(pressure, rel=1e-3)


@pytest.mark.parametrize("ratio", [1 + 1e-6, 1.5, 5.0, 30.0, 1e4])
def test_closed_form_is_that_of_complete_integrals(ratio: float) -> None:
    """Carlson's integrals are another form of the same; K - E cancels at a ratio of 1."""
    equivalent, *shape = closed_forms.hertz_ellipse(ratio * RADIUS, RADIUS)
    contact = closed_forms.hertz_radius(LOAD, equivalent, STEEL)
    along, across, approach, _ = hertz(ratio * RADIUS, RADIUS)
    assert np.multiply(shape, contact) == pytest.approx((along, across), rel=1e-6)
    assert contact**2 / equivalent == pytest.approx(approach, rel=1e-6)
    swapped = closed_forms.hertz_ellipse(RADIUS, ratio * RADIUS)
    assert swapped == pytest.approx((equivalent, shape[1], shape[0]), rel=1e-12)


@pytest.mark.law(
    "Line contact: a long ellipse has p0 = sqrt(w E* / (pi R)) of its load per length."
)
def test_long_ellipse_is_a_cylinder() -> None:
    """The load per length w in the middle is pi a p0 / 2; the closed form is off by (a/b)^2."""
    radius = RADIUS
    across = 1e5 * RADIUS
    equivalent, *shape = closed_forms.hertz_ellipse(radius, across)
    contact = closed_forms.hertz_radius(LOAD, equivalent, STEEL)
    pressure = 1.5 * LOAD / (math.pi * contact**2 * shape[0] * shape[1])
    per_length = math.pi * contact * shape[0] * pressure / 2
    line = math.sqrt(per_length * STEEL / (math.pi * radius))
    assert pressure == pytest.approx(line, rel=1e-4)


@pytest.mark.law("Smooth release: an elastic ellipse releases 3 W v a / (16 R), a and R along it.")
@pytest.mark.parametrize("ratio", [0.2, 5.0])
def test_rolling_ellipse_releases_the_closed_form_and_keeps_its_energy(ratio: float) -> None:
    """Half of the pressure falls at the rate x / R; the ledger closes to rounding."""
    track = track_of(RADIUS, ratio * RADIUS, nodes=16)
    along = hertz(RADIUS, ratio * RADIUS)[0]
    states = roll(track, 0, 3)
    for before, after, step in zip(states, states[1:], step_energies(track, states), strict=False):
        gain = after.stored_energy - before.stored_energy
        assert step.loading - step.release == pytest.approx(gain, abs=1e-12 * after.stored_energy)
        assert step.release / track.step == pytest.approx(
            3 * LOAD * along / (16 * RADIUS), rel=5e-3
        )


def scene_of(**sphere: float) -> Scene:
    """Return a scene of an elastic plate under a steel-heavy body of some radii [mm]."""
    surface = {"kind": "smooth", "spacing_um": 4, "width_um": 400}
    return Scene.from_dict(
        {
            "name": "ellipse",
            "sphere": {"radius_mm": 1e3 * RADIUS, "density_kg_m3": 7850} | sphere,
            "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "density_kg_m3": 7850},
            "surface": surface,
            "rolling": {"load_n": LOAD, "speed_m_s": 0.1, "duration_s": 0.004, "drop_mm": 1},
            "dynamics": {},
        }
    )


def test_dynamics_have_the_mass_of_the_radius_and_the_stiffness_of_both() -> None:
    """The stiffness 2 E* a of the equivalent sphere is dW / d(approach), here over 1e-4 of W."""
    scene = scene_of(radius_across_mm=5e3 * RADIUS)
    assert scene.mass == scene_of().mass
    radius = smooth_contact_of(scene).equivalent_radius_m
    step = 1e-4
    modulus = scene.contact_modulus
    rise = [closed_forms.hertz_approach(LOAD * (1 + x), radius, modulus) for x in (-step, step)]
    stiffness = 2 * modulus * closed_forms.hertz_radius(LOAD, radius, modulus)
    assert 2 * step * LOAD / (rise[1] - rise[0]) == pytest.approx(stiffness, rel=1e-6)
    energy = closed_forms.hertz_approach(LOAD, radius, modulus) * 0.4 * LOAD  # of F ~ d^1.5
    assert closed_forms.hertz_force(energy, radius, modulus) == pytest.approx(LOAD, rel=1e-9)
    assert drop.impact_s(bodies_of(scene)) < drop.impact_s(bodies_of(scene_of()))


@pytest.mark.parametrize("radius", [-1, 0, 4e-6, 1e9, math.nan, "wide"])
def test_a_wrong_radius_is_one_fault(radius: float | str) -> None:
    with pytest.raises(
        SceneError, match=r"^scene: sphere\.radius_across_mm: got [^\n]+, allowed: [^\n]+$"
    ):
        scene_of(radius_across_mm=radius)
