"""Geometry, speeds and static loads of a bearing agree with closed forms and exact sums."""

from __future__ import annotations

from math import acos, cos, degrees, pi, sin, tan

import numpy as np
import pytest
from bearings import STEEL, angular, bearing, miniature, sjovall
from scipy.optimize import root

import rolling
from rolling.bearing.contact_lines import contact_lines
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.kinematics import kinematics_of, lines_of
from rolling.bearing.linear_ring import free_tilt_db
from rolling.bearing.static_load import (
    LoadedRing,
    angles_under_loads,
    ball_loads,
    least_axial_load,
    rolling_angle,
    static_balance,
    tangent_stiffness,
)
from rolling.contact import closed_forms

GEOMETRIES = {"6204": bearing(), "7210": angular(), "608": miniature()}


@pytest.mark.parametrize("name", GEOMETRIES)
def test_contacts_are_elliptic_hertz_contacts(name: str) -> None:
    """Approach and stiffness are those of the sphere that `hertz_ellipse` gives."""
    geometry = GEOMETRIES[name]
    for contact in (geometry.inner, geometry.outer):
        radius, _, _ = closed_forms.hertz_ellipse(contact.radius_along_m, contact.radius_across_m)
        approach = closed_forms.hertz_approach(30.0, radius, STEEL)
        assert contact.stiffness_n_m15 * approach**1.5 == pytest.approx(30.0, rel=1e-12)
    both = sum(
        (10.0 / contact.stiffness_n_m15) ** (2 / 3) for contact in (geometry.inner, geometry.outer)
    )
    assert geometry.series_stiffness * both**1.5 == pytest.approx(10.0, rel=1e-12)


def test_grooves_are_apart_by_their_conformities() -> None:
    geometry = bearing(angle_deg=12.0)
    assert geometry.groove_distance_m == pytest.approx((0.515 + 0.525 - 1) * 7.938e-3, rel=1e-9)


@pytest.mark.law("Bearing: cage, ball passes and ball spin follow from pure rolling.")
def test_speeds_of_a_6204() -> None:
    """The numbers are those of another program, to the digits that it prints."""
    speeds = kinematics_of(bearing(), "inner", 30.0)
    assert speeds.cage_hz == pytest.approx(11.5233, abs=5e-5)
    assert speeds.ball_pass_outer_hz == pytest.approx(92.187, abs=5e-4)
    assert speeds.ball_pass_inner_hz == pytest.approx(147.813, abs=5e-4)
    assert speeds.ball_spin_hz == pytest.approx(59.902, abs=5e-4)
    assert speeds.rolling_speed_m_s == pytest.approx(1.494, abs=5e-4)


@pytest.mark.parametrize("name", GEOMETRIES)
@pytest.mark.parametrize("turning", ["inner", "outer"])
def test_contacts_roll_without_slip(name: str, turning: str) -> None:
    """Each raceway passes its contacts at the speed of the ball's surface."""
    geometry = GEOMETRIES[name]
    speeds = kinematics_of(geometry, turning, 25.0)
    inner = 2 * pi * geometry.inner.radius_m * abs(speeds.inner_hz - speeds.cage_hz)
    outer = 2 * pi * geometry.outer.radius_m * abs(speeds.cage_hz - speeds.outer_hz)
    assert inner == pytest.approx(speeds.rolling_speed_m_s, rel=1e-12)
    assert outer == pytest.approx(speeds.rolling_speed_m_s, rel=1e-12)


@pytest.mark.law("Bearing: under an axial load each ball bears F_a / (Z sin alpha).")
@pytest.mark.parametrize("name", GEOMETRIES)
@pytest.mark.parametrize("moving", ["inner", "outer"])
def test_axial_load_and_stiffness_of_all_balls(name: str, moving: str) -> None:
    geometry = GEOMETRIES[name]
    balls, angle = geometry.balls, geometry.contact_angle
    state = static_balance(
        geometry, LoadedRing(axial_load_n=70.0, radial_load_n=0.0, moving=moving), cage_angle=0.3
    )
    load = 70.0 / (balls * sin(angle))
    np.testing.assert_allclose(state.ball_load_n, load, rtol=1e-9)
    stiffness = 1.5 * geometry.series_stiffness ** (2 / 3) * load ** (1 / 3)
    radial = stiffness * balls * cos(angle) ** 2 / 2
    expected = np.diag([radial, radial, stiffness * balls * sin(angle) ** 2])
    np.testing.assert_allclose(state.stiffness_n_m, expected, rtol=1e-8, atol=1e-8 * radial)


@pytest.mark.law("Bearing: a radial load on eight balls loads one with 4.35 or 3.90 F_r / Z.")
@pytest.mark.parametrize(("ball_mm", "conformity"), [(7.938, 0.515), (11.0, 0.53)])
@pytest.mark.parametrize(("place", "factor"), [(0.0, 4.35), (0.5, 3.90)])
def test_largest_load_of_eight_balls(
    ball_mm: float, conformity: float, place: float, factor: float
) -> None:
    """The factors have three digits; a ball is at the bottom, or the bottom lies between two."""
    geometry = bearing(balls=8, ball_mm=ball_mm, angle_deg=0.0, inner=conformity)
    state = static_balance(
        geometry, LoadedRing(axial_load_n=0.0, radial_load_n=800.0), cage_angle=place * 2 * pi / 8
    )
    assert state.ball_load_n.max() * 8 / 800.0 == pytest.approx(factor, abs=0.006)


@pytest.mark.law("Bearing: loads of many balls follow Sjoevall's integral.")
@pytest.mark.parametrize(("balls", "ball_mm"), [(20, 7.938), (31, 4.0)])
@pytest.mark.parametrize("gap_um", [0.0, 3.0, 10.0, -2.0])
def test_many_balls_follow_sjovall(balls: int, ball_mm: float, gap_um: float) -> None:
    """The sum over 20 balls meets the integral within 1 %, with clearance or an interference.

    The load of the ball at the bottom fluctuates around it with the place of the cage, hence the
    mean over it.
    """
    geometry = bearing(balls=balls, ball_mm=ball_mm, pitch_mm=60.0, angle_deg=0.0)
    loads = []
    shifts = []
    for place in (0.0, 0.25, 0.5, 0.75):
        state = static_balance(
            geometry,
            LoadedRing(axial_load_n=0.0, radial_load_n=1000.0, gap_m=1e-6 * gap_um),
            cage_angle=place * 2 * pi / balls,
        )
        shifts.append(-state.displacement_m[0])
        approach = shifts[-1] - 1e-6 * gap_um
        loads.append(geometry.series_stiffness * approach**1.5)
    zone = 0.5 * (1 - 1e-6 * gap_um / np.mean(shifts))
    radial, _ = sjovall(zone)
    assert np.mean(loads) == pytest.approx(1000.0 / (balls * radial), rel=0.01)


@pytest.mark.parametrize("ratio", [0.3, 0.6, 0.9])
def test_combined_loads_of_many_balls_follow_sjovall(ratio: float) -> None:
    """Axial and radial integral give one load zone, within 1 % of the exact sums."""
    geometry = angular(balls=30)
    axial = 500.0
    radial = ratio * axial / tan(geometry.contact_angle)
    state = static_balance(
        geometry, LoadedRing(axial_load_n=axial, radial_load_n=radial), cage_angle=0.05
    )
    lines = contact_lines(geometry, np.array([0.0, pi]))
    nearest, farthest = lines.at(state.displacement_m).approach_m
    zone = nearest / (nearest - farthest)
    radial_integral, axial_integral = sjovall(zone)
    maximum = geometry.series_stiffness * nearest**1.5
    angle = geometry.contact_angle
    assert 30 * maximum * radial_integral * cos(angle) == pytest.approx(radial, rel=0.01)
    assert 30 * maximum * axial_integral * sin(angle) == pytest.approx(axial, rel=0.01)


def exact_loads(geometry: BearingGeometry, state, cage_angle: float) -> np.ndarray:
    """Return the load of each ball at the displacement of a state, by the law of one ball."""
    angles = cage_angle + 2 * pi * np.arange(geometry.balls) / geometry.balls
    x, y, z = state.displacement_m
    radial = -(x * np.cos(angles) + y * np.sin(angles)) * cos(geometry.contact_angle)
    approach = radial + z * sin(geometry.contact_angle)
    return geometry.series_stiffness * np.maximum(approach, 0.0) ** 1.5


@pytest.mark.parametrize("balls", [3, 4, 9, 30])
@pytest.mark.parametrize("cage_angle", [0.0, 0.4, 2.0])
def test_balls_bear_the_loads(balls: int, cage_angle: float) -> None:
    geometry = angular(balls=balls)
    radial = 200.0
    axial = 1.2 * least_axial_load(geometry, radial)
    state = static_balance(
        geometry, LoadedRing(axial_load_n=axial, radial_load_n=radial), cage_angle=cage_angle
    )
    np.testing.assert_allclose(state.ball_load_n, exact_loads(geometry, state, cage_angle))
    borne = state.ball_load_n @ state.lines
    np.testing.assert_allclose(borne, [-radial, 0.0, axial], atol=1e-8 * axial)


def test_a_single_ball_may_bear_a_small_load_in_a_wide_clearance() -> None:
    geometry = bearing(angle_deg=0.0)
    state = static_balance(geometry, LoadedRing(axial_load_n=0.0, radial_load_n=1.0, gap_m=5e-6))
    np.testing.assert_allclose(state.ball_load_n, [1.0, 0, 0, 0, 0, 0, 0, 0], atol=1e-9)


@pytest.mark.parametrize(
    ("angle_deg", "axial", "radial"), [(12.0, 0.0, 100.0), (12.0, 20.0, 100.0), (0.0, 1.0, 5.0)]
)
def test_loads_without_a_balance_are_refused(angle_deg: float, axial: float, radial: float) -> None:
    with pytest.raises(ValueError, match="axial_load_n"):
        static_balance(
            bearing(angle_deg=angle_deg), LoadedRing(axial_load_n=axial, radial_load_n=radial)
        )


# ---- contact angles that turn


@pytest.mark.parametrize("name", GEOMETRIES)
def test_the_angle_under_an_axial_load_balances_the_groove_centres(name: str) -> None:
    """The balls' force along the turned line has the axial load as its axial part."""
    geometry = GEOMETRIES[name]
    for load in (1.0, 300.0):
        angle, most = angles_under_loads(geometry, LoadedRing(axial_load_n=load, radial_load_n=0.0))
        assert most == pytest.approx(angle, rel=1e-9)
        stretch = cos(geometry.contact_angle) / cos(angle) - 1
        force = geometry.series_stiffness * (stretch * geometry.groove_distance_m) ** 1.5
        assert geometry.balls * force * sin(angle) == pytest.approx(load, rel=1e-6)
    angle, _ = angles_under_loads(bearing(), LoadedRing(axial_load_n=70.0, radial_load_n=0.0))
    assert degrees(angle) == pytest.approx(13.91, abs=0.01)


MOVING = {"angle": "moving", "moving": "inner"}


def printed_bearing(clearance_um: float) -> BearingGeometry:
    """Return seven balls of 11.5 mm on 43.5 mm with a radial clearance, as a source prints them."""
    distance = (0.52 + 0.53 - 1) * 11.5e-3
    angle = degrees(acos(1 - 1e-6 * clearance_um / (2 * distance)))
    return bearing(7, ball_mm=11.5, pitch_mm=43.5, angle_deg=angle, inner=0.52, outer=0.53)


@pytest.mark.law("Bearings: displacements under moving contact angles are those that are printed.")
@pytest.mark.parametrize(
    ("clearance_um", "radial_um", "axial_um", "from_touch_um"),
    [(0.0, 15.1101, 133.5381, 133.5381), (10.0, 21.223, 149.1717, 73.51)],
)
def test_moving_angles_give_the_printed_displacements(
    clearance_um: float, radial_um: float, axial_um: float, from_touch_um: float
) -> None:
    """Under 1 kN along a radius, or along the axis from the plane and from the first touch."""
    geometry = printed_bearing(clearance_um)
    plane = geometry.groove_distance_m * sin(geometry.contact_angle)
    state = static_balance(geometry, LoadedRing(axial_load_n=0.0, radial_load_n=1000.0, **MOVING))
    assert 1e6 * state.displacement_m[0] == pytest.approx(radial_um, rel=1e-4)
    assert state.displacement_m[2] == pytest.approx(-plane, abs=1e-10)
    state = static_balance(geometry, LoadedRing(axial_load_n=1000.0, radial_load_n=0.0, **MOVING))
    assert 1e6 * (state.displacement_m[2] + plane) == pytest.approx(axial_um, rel=1e-4)
    assert 1e6 * state.displacement_m[2] == pytest.approx(from_touch_um, rel=1e-4)


def test_a_clearance_is_a_gap_of_balls_in_the_middle_of_the_grooves() -> None:
    """A radial load alone meets 10 um as a free angle, or as a gap at an angle of 0."""
    state = static_balance(
        printed_bearing(0.0),
        LoadedRing(axial_load_n=0.0, radial_load_n=1000.0, gap_m=5e-6, **MOVING),
    )
    assert 1e6 * state.displacement_m[0] == pytest.approx(21.223, rel=1e-4)
    assert state.stiffness_n_m[2, 2] > 0  # loads hold the ring in the plane of the grooves


@pytest.mark.law("Bearings: a negative clearance presses the balls of a ring without load.")
@pytest.mark.parametrize(("axial", "radial"), [(70.0, 100.0), (1.0, 20.0), (400.0, 0.0)])
def test_a_negative_clearance_presses_all_balls(axial: float, radial: float) -> None:
    """Exact grooves, whose centres are 3 um farther apart than where a ball just touches."""
    geometry = bearing(angle_deg=0.0)
    angles = geometry.ball_angles(0.0)
    touching = geometry.groove_distance_m

    def loads(place_um: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        along_x, along_z = 1e-6 * place_um
        beside = touching + 3e-6 + np.cos(angles) * along_x
        distance = np.hypot(beside, along_z)
        forces = ball_loads(distance - touching, geometry.series_stiffness)
        return forces, forces * beside / distance, forces * along_z / distance

    def missing(place_um: np.ndarray) -> list[float]:
        _, across, along = loads(place_um)
        return [across @ np.cos(angles) - radial, along.sum() - axial]

    solution = root(missing, [0.1, 10.0], tol=1e-12)
    assert solution.success
    ring = LoadedRing(axial_load_n=axial, radial_load_n=radial, gap_m=-3e-6, **MOVING)
    state = static_balance(geometry, ring)
    assert state.ball_load_n == pytest.approx(loads(solution.x)[0], rel=1e-6)
    assert state.ball_load_n.min() > 0


def jones(geometry: BearingGeometry, places: np.ndarray, held: bool, start: np.ndarray, load):
    """Return the balance of an inner ring by Jones' equations, solved by MINPACK in micrometres.

    `load` has the forces along x, y and z [N] and the moments about x and y [N m]. The result has
    displacements and turns as `load` has forces, and the loads of the balls.
    """
    distance = geometry.groove_distance_m
    angle = geometry.contact_angle
    groove = 1 / (1 / geometry.ball_radius_m - 1 / geometry.inner.radius_across_m)
    circle = geometry.pitch_radius_m + (groove - geometry.ball_radius_m) * cos(angle)
    units = 1e-6 * np.array([1, 1, 1, 1 / circle, 1 / circle])[: 3 if held else 5]

    def parts(unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y, z, a, b = np.append(units * unknown, [0.0, 0.0])[:5]
        radial = distance * cos(angle) + x * np.cos(places) + y * np.sin(places)
        axial = distance * sin(angle) + z + circle * (a * np.sin(places) - b * np.cos(places))
        length = np.sqrt(radial**2 + axial**2)
        loads = geometry.series_stiffness * np.maximum(length - distance, 0.0) ** 1.5
        outwards, along = loads * radial / length, loads * axial / length
        forces = (
            (outwards * np.cos(places)).sum(),
            (outwards * np.sin(places)).sum(),
            along.sum(),
            circle * (along * np.sin(places)).sum(),
            -circle * (along * np.cos(places)).sum(),
        )
        return np.array(forces), loads

    size = np.abs(load[:3]).max()
    scale = np.array([size] * 3 + [size * circle] * 2)[: len(units)]
    found = root(
        lambda unknown: (parts(unknown)[0] - load)[: len(units)] / scale,
        start[: len(units)] / units,
        method="lm",
        options={"xtol": 1e-14, "ftol": 1e-14, "maxiter": 20000},
    )
    assert np.abs(found.fun).max() < 1e-8
    return units * found.x, parts(found.x)[1]


@pytest.mark.law("Bearings: balances at moving angles are those of another solver, with tilts too.")
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("held", [True, False], ids=["held", "tilting"])
def test_moving_angles_balance_as_another_solver_has_it(seed: int, held: bool) -> None:
    """Random bearings and loads, from one ball that bears to all of them.

    The other solver starts beside the balance, because its own steps are lost from far away.
    """
    random = np.random.default_rng(seed)
    geometry = bearing(
        balls=int(random.integers(5, 20)),
        ball_mm=8.0,
        pitch_mm=random.uniform(55.0, 120.0),
        angle_deg=random.uniform(1.0, 40.0),
        inner=random.uniform(0.51, 0.54),
        outer=random.uniform(0.51, 0.54),
    )
    axial, radial = 10 ** random.uniform(0.5, 3.5, 2)
    moments = random.normal(size=2) * 0.2 * axial * geometry.pitch_radius_m
    place = random.uniform(0, 6)
    state = static_balance(
        geometry,
        LoadedRing(
            axial_load_n=axial,
            radial_load_n=radial,
            moments_n_m=None if held else tuple(moments),
            **MOVING,
        ),
        cage_angle=place,
    )
    found = np.append(state.displacement_m, state.tilt)
    start = found * random.uniform(0.9, 1.1, 5)
    load = np.array([radial, 0.0, axial, *moments])
    other, loads = jones(geometry, geometry.ball_angles(place), held, start, load)
    size = np.abs(found[:3]).max()
    np.testing.assert_allclose(found[:3], other[:3], atol=1e-6 * size)
    np.testing.assert_allclose(state.tilt[: len(other) - 3], other[3:], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(state.ball_load_n, loads, atol=1e-5 * loads.max())


@pytest.mark.law("Bearings: the moment of a displacement is the force of a tilt.")
@pytest.mark.parametrize("moving", ["inner", "outer"])
@pytest.mark.parametrize("angle", ["fixed", "moving"])
def test_the_stiffness_is_the_change_of_forces_and_moments(moving: str, angle: str) -> None:
    """The forces' differences are the tangent stiffness, which is symmetric; an energy has both."""
    geometry = bearing(balls=9)
    state = static_balance(
        geometry,
        LoadedRing(
            axial_load_n=300.0,
            radial_load_n=500.0,
            moving=moving,
            angle="moving",
            moments_n_m=(0.4, -0.2),
        ),
        cage_angle=0.2,
    )
    lines = contact_lines(geometry, geometry.ball_angles(0.2), moving=moving, angle=angle)
    place = np.append(state.displacement_m, state.tilt)

    def borne(displacement: np.ndarray) -> np.ndarray:
        pressed = lines.at(displacement)
        return ball_loads(pressed.approach_m, geometry.series_stiffness) @ pressed.lines

    steps = 1e-10 * np.array([1, 1, 1, 30, 30])
    slopes = [
        (borne(place + change) - borne(place - change)) / (2 * step)
        for change, step in zip(np.diag(steps), steps, strict=True)
    ]
    wanted = tangent_stiffness(lines.at(place), geometry.series_stiffness)
    unit = np.sqrt(np.diag(wanted))
    scale = np.outer(unit, unit)
    np.testing.assert_allclose(slopes / scale, wanted / scale, atol=1e-5)
    np.testing.assert_allclose(wanted, wanted.T, rtol=1e-12)
    if angle == "moving":
        np.testing.assert_allclose(state.stiffness, wanted, rtol=1e-9)
        np.testing.assert_allclose(state.moment_n_m, [0.4, -0.2], atol=1e-8)


@pytest.mark.law("Bearings: at moving angles every load has a balance.")
def test_radial_loads_lift_balls_from_an_axial_load() -> None:
    """A fixed angle refuses these loads; three of fifteen balls bear the first."""
    geometry = bearing(15, ball_mm=20.0, pitch_mm=150.0, angle_deg=25.0, inner=0.52, outer=0.53)
    loads = {"axial_load_n": 70.0, "radial_load_n": 150.0}
    with pytest.raises(ValueError, match="axial_load_n"):
        static_balance(geometry, LoadedRing(**loads))
    state = static_balance(geometry, LoadedRing(**loads, angle="moving"))
    assert sorted(state.ball_load_n.round(0).tolist())[-4:] == [0.0, 48.0, 48.0, 76.0]
    state = static_balance(
        bearing(), LoadedRing(axial_load_n=150.0, radial_load_n=1000.0, **MOVING)
    )
    np.testing.assert_allclose(state.ball_load_n @ state.lines, [1000.0, 0.0, 150.0], atol=1e-7)


@pytest.mark.parametrize("force", [1e-13, 1e-6, 1.0])
def test_small_loads_at_small_angles_are_balanced(force: float) -> None:
    """Z K (A/2)^1.5 alpha^4 at the angle alpha under the load, while it is small."""
    geometry = bearing(angle_deg=degrees(1e-14))
    state = static_balance(
        geometry, LoadedRing(axial_load_n=force, radial_load_n=0.0, angle="moving")
    )
    approach = (geometry.groove_distance_m / 2) ** 1.5
    angle = (force / (geometry.balls * geometry.series_stiffness * approach)) ** 0.25
    np.testing.assert_allclose(state.angles, angle, rtol=2 * angle**2 + 1e-9)
    assert float(state.ball_load_n @ state.lines[:, 2]) == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("angle", ["fixed", "moving"])
def test_a_balance_that_is_not_found_is_no_number(
    angle: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rolling.bearing.static_load._MAX_ITERATIONS", 1)
    with pytest.raises(ValueError, match="not found"):
        static_balance(bearing(), LoadedRing(axial_load_n=70.0, radial_load_n=100.0, angle=angle))


def test_balls_roll_at_the_angle_under_their_loads() -> None:
    """Their speeds follow from the cosine, of which loaded balls have the most weight."""
    state = static_balance(
        bearing(), LoadedRing(axial_load_n=70.0, radial_load_n=250.0, angle="moving")
    )
    cosine = state.ball_load_n @ np.cos(state.angles) / state.ball_load_n.sum()
    assert cos(rolling_angle([state, state])) == pytest.approx(cosine, rel=1e-12)
    turned = kinematics_of(bearing(), "inner", 30.0, rolling_angle([state]))
    same = kinematics_of(bearing(angle_deg=degrees(acos(cosine))), "inner", 30.0)
    assert lines_of(turned) == pytest.approx(lines_of(same), rel=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_a_ring_that_tilts_moves_less_along_its_radius(name: str) -> None:
    """Two equations of motion of a ring on stiff balls, between its rocking mode and resonance."""
    geometry = GEOMETRIES[name]
    radius, width = 1.3 * geometry.pitch_radius_m, geometry.ball_radius_m
    angle = geometry.contact_angle
    way = np.array([cos(angle), geometry.pitch_radius_m * sin(angle)])
    inertia = np.diag([1.0, radius**2 / 2 + width**2 / 12])  # of a ring of 1 kg
    stiffness = 1e12
    matrix = stiffness * np.outer(way, way) - inertia * 1e3**2
    free = np.linalg.solve(matrix, stiffness * way)[0]
    held = 1 / cos(angle)
    assert 20 * np.log10(held / free) == pytest.approx(
        free_tilt_db(geometry, angle, radius, width), abs=1e-3
    )


def test_a_scene_has_the_same_geometry() -> None:
    """Its own circumferences and loads agree; without an axial load the clearance is open."""
    pushed = rolling.BearingScene(
        bearing=rolling.Bearing(named="6204", speed_rpm=1800, axial_load_n=70)
    )
    model = pushed.model
    for ring in ("inner", "outer"):
        contact = getattr(model.geometry, ring)
        assert 2 * pi * contact.radius_m == pytest.approx(pushed.circumferences[ring], rel=1e-12)
    distance = model.geometry.groove_distance_m
    clearance = 2 * distance * (1 - cos(model.geometry.contact_angle))
    assert clearance == pytest.approx(pushed.radial_clearance, rel=1e-9)
    assert model.gap_m == 0
    assert lines_of(pushed.kinematics)["turn"] == 30
    hung = pushed.with_(axial_load_n=0, radial_load_n=300)
    model = hung.model
    assert model.geometry.contact_angle == 0
    assert model.gap_m == pytest.approx(pushed.radial_clearance / 2, rel=1e-12)
    assert model.balance().ball_load_n.max() > 300 / 8
