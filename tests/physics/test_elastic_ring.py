"""A ring that bends on its balls moves as thin rings, own integrations and linear theory say."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from bearings import line, miniature, model

import rolling
from rolling.bearing.linear_ring import free_tilt_db, linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_bending import BendingMode, GroovedSection, RingBending
from rolling.bearing.ring_motion import RingMotion, move_ring
from rolling.bearing.ring_record import RADIAL, RingRecord, record_of
from rolling.bearing.tracks import smooth_tracks, with_waves
from rolling.bearing.wave_motion import WaveMotion
from rolling.bearing_kind.bearing_check import scene_rules
from rolling.check.finding import Finding

A = 1e-9  # [m] amplitude of waves, far below the approach
MODES = (BendingMode(2, 0.0356, 5698.0), BendingMode(3, 0.0316, 16115.0))  # of a 6204
TILT = 0.06 * (0.0215**2 / 2 + 0.014**2 / 12)  # [kg m2] of its ring


def elastic(**changes) -> BearingModel:
    """Return a 6204 whose outer ring bends."""
    return model(**{"bending": MODES} | changes)


# ---- free rings


@pytest.mark.law("Elastic ring: a groove takes from the section of a ring what it takes.")
def test_the_section_is_a_rectangle_less_its_groove() -> None:
    """Area and moments against sums over many strips; without a groove they are those of books."""
    wall, depth, groove, width = 2.8e-3, 1.6e-3, 4.2e-3, 14e-3
    section = GroovedSection(wall, depth, groove, width)
    places = (np.arange(400000) + 0.5) / 400000 * width - width / 2
    bottom = wall + groove - np.sqrt(np.maximum(groove**2 - places**2, 0.0))
    heights = np.minimum(bottom, wall + depth)
    heights[np.abs(places) >= groove] = wall + depth
    strip = width / len(places)
    area = heights.sum() * strip
    centroid = (heights**2).sum() / 2 * strip / area
    assert section.area_m2 == pytest.approx(area, rel=1e-6)
    assert section.centroid_m == pytest.approx(centroid, rel=1e-6)
    moment = (heights**3).sum() / 3 * strip - area * centroid**2
    assert section.in_plane_m4 == pytest.approx(moment, rel=1e-5)
    out_of_plane = (heights * places**2).sum() * strip
    assert section.out_of_plane_m4 == pytest.approx(out_of_plane, rel=1e-5)


@pytest.mark.law("Elastic ring: free frequencies are those of thin rings.")
def test_free_rings_bend_at_the_frequencies_of_books() -> None:
    """A wall of 2.8 mm of steel at 22.1 mm has 3.63 and 10.3 kHz.

    A rod of a circular section out of its plane has n^2 + 1 + nu in place of n^2 + 1.
    """
    flat = GroovedSection(wall_m=2.8e-3, depth_m=1e-12, groove_radius_m=4e-3, width_m=14e-3)
    ring = RingBending(
        section=flat, radius_m=22.1e-3, youngs_modulus=208e9, poissons_ratio=0.3, density=7800
    )
    assert ring.in_plane_hz(2) == pytest.approx(3630, rel=0.01)
    assert ring.in_plane_hz(3) == pytest.approx(10300, rel=0.01)
    ratio = ring.youngs_modulus * flat.out_of_plane_m4 / flat.torsion_m4
    ratio *= 2 * 1.3 / ring.youngs_modulus
    square = flat.out_of_plane_m4 / flat.in_plane_m4 * 5 / (4 + ratio)
    assert ring.out_of_plane_hz(2) == pytest.approx(ring.in_plane_hz(2) * sqrt(square), rel=1e-9)
    masses = [mode.mass_kg / ring.mass_kg for mode in ring.modes]
    assert masses == pytest.approx([5 / 8, 5 / 9])


@pytest.mark.law("Elastic ring: a free ring is the same by finite differences around it.")
@pytest.mark.parametrize("order", [2, 3])
def test_a_free_ring_of_many_links_has_the_same_modes(order: int) -> None:
    """Energies of an inextensional ring on 90 places, by differences around it, give omega_n."""
    count = 90
    step = 2 * pi / count
    next_one = np.roll(np.eye(count), 1, axis=1)
    second = (next_one + next_one.T - 2 * np.eye(count)) / step**2
    slope = (next_one - next_one.T) / (2 * step)
    bent = second + np.eye(count)  # curvature of a way w along the radius, over R^2
    # The way along the ring is v with dv/dphi = -w: the waves of w without their mean.
    waves = np.fft.fft(np.eye(count))
    orders = np.fft.fftfreq(count, 1 / count)
    inverse = np.zeros(count, dtype=complex)
    inverse[orders != 0] = -1 / (1j * orders[orders != 0])
    along = np.real(np.fft.ifft(inverse[:, None] * waves, axis=0))
    assert np.allclose(
        slope @ along @ np.cos(order * step * np.arange(count)),
        -np.cos(order * step * np.arange(count)),
        atol=0.01,
    )
    shape = np.cos(order * step * np.arange(count))
    stiffness = shape @ bent.T @ bent @ shape
    mass = shape @ shape + (along @ shape) @ (along @ shape)
    found = sqrt(stiffness / mass)
    wanted = order * (order**2 - 1) / sqrt(order**2 + 1)
    assert found == pytest.approx(wanted, rel=0.01)


# ---- an own program of the ring on its balls


def own_rates(case: BearingModel, heights, tilts: bool):
    """Return the equations of motion of an elastic ring, written without those of the program."""
    geometry = case.geometry
    places = 2 * pi * np.arange(geometry.balls) / geometry.balls
    distance = geometry.groove_distance_m
    free = distance * np.array([cos(geometry.contact_angle), sin(geometry.contact_angle)])
    radius = geometry.groove_circle_m("outer")
    bending = case.bending
    masses = [case.ring_mass_kg] * 3
    masses += [mode.mass_kg for mode in bending for _ in "cs"]
    masses += [case.tilt_inertia_kg_m2] * 2 if tilts else []
    count = len(masses)

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        place, velocity = state[:count], state[count:]
        around = places + 2 * pi * case.kinematics.cage_hz * time
        columns = [np.cos(around), np.sin(around), 0 * around]
        for mode in bending:
            columns += [np.cos(mode.order * around), np.sin(mode.order * around)]
        outwards = -np.stack(columns + ([0 * around] * 2 if tilts else []))
        forth = np.zeros_like(outwards)
        forth[2] = 1.0
        if tilts:
            forth[-2:] = radius * np.sin(around), -radius * np.cos(around)
        moved = np.stack([place @ outwards, place @ forth])
        if case.angle == "moving":
            whole = free[:, None] + moved
            length = np.hypot(*whole)
            approach, lines = length - distance, whole / length
        else:
            lines = np.repeat(free[:, None] / distance, len(around), axis=1)
            approach = (lines * moved).sum(axis=0)
        height = heights(around, time)
        load = geometry.series_stiffness * np.maximum(approach + height, 0.0) ** 1.5
        force = -(outwards @ (load * lines[0]) + forth @ (load * lines[1]))
        force[:3] += case.load[:3]
        for number, mode in enumerate(bending):
            columns_of_mode = slice(3 + 2 * number, 5 + 2 * number)
            stiffness = mode.mass_kg * (2 * pi * mode.frequency_hz) ** 2
            force[columns_of_mode] -= stiffness * place[columns_of_mode]
        return np.append(velocity, force / masses)

    return rates


@pytest.mark.law("Elastic ring: its motion is that of an independent solution of its equations.")
@pytest.mark.parametrize(
    ("angle", "tilts"), [("fixed", False), ("moving", False), ("moving", True)]
)
def test_motion_agrees_with_another_solver(angle: str, tilts: bool) -> None:
    """Waves above the approach and a radial load; nothing is lost, and balls nearly lose contact.

    320 steps in a period of the rigid resonance leave 0.3 % of the maximum.
    """
    from scipy.integrate import solve_ivp

    case = elastic(
        contact_loss_factor=0.0,
        radial_load_n=150.0,
        angle=angle,
        tilt_inertia_kg_m2=TILT if tilts else None,
    )
    waves = {"inner": {9: 4e-6, 10: 2e-6}, "outer": {13: 1e-6}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.02)
        motion = move_ring(
            case, with_waves(smooth_tracks(case.geometry), **waves), 0.004, 48000, 320
        )

    def heights(around: np.ndarray, time: float) -> np.ndarray:
        inner = around - 2 * pi * case.kinematics.inner_hz * time
        return 4e-6 * np.cos(9 * inner) + 2e-6 * np.cos(10 * inner) + 1e-6 * np.cos(13 * around)

    start = np.append(motion.displacement_m[0] + motion.mean_displacement_m, motion.velocity_m_s[0])
    solution = solve_ivp(
        own_rates(case, heights, tilts),
        (0.0, motion.time_s[-1]),
        start,
        method="DOP853",
        t_eval=motion.time_s,
        rtol=1e-8,
        atol=1e-13,
    )
    expected = solution.y[len(case.masses) :].T
    size = np.abs(expected).max(axis=0)
    assert motion.ball_load_n.min() < 10.0
    assert np.all(size[3:7] > 1e-5)  # the ring bends
    np.testing.assert_array_less(np.abs(motion.velocity_m_s - expected).max(axis=0), 0.01 * size)


def own_response(case: BearingModel, order: int, frequency_hz: float) -> np.ndarray:
    """Return the velocities [m/s] of a ring on N equal springs by a wave A of the inner raceway.

    Radially a ring and its bending with n waves are held by N k cos^2(alpha) / 2 each, where N is
    more than twice the waves, and an order q N + n of the raceway pushes them with N k A cos(alpha)
    / 2, both orientations alike. Returned are x, and each cosine part of bending.
    """
    geometry = case.geometry
    balls = geometry.balls
    load = case.axial_load_n / balls / sin(geometry.contact_angle)
    stiffness = 1.5 * geometry.series_stiffness ** (2 / 3) * load ** (1 / 3)
    held = balls * stiffness * cos(geometry.contact_angle) ** 2 / 2
    push = balls * stiffness * A * cos(geometry.contact_angle) / 2
    omega = 2 * pi * frequency_hz
    found = np.zeros(3, dtype=complex)
    bodies = [(1, case.ring_mass_kg, 0.0)]
    bodies += [
        (mode.order, mode.mass_kg, mode.mass_kg * (2 * pi * mode.frequency_hz) ** 2)
        for mode in case.bending
    ]
    for number, (waves, mass, own) in enumerate(bodies):
        if (order + waves) % balls and (order - waves) % balls:
            continue
        resonance = sqrt((held + own) / mass)
        lossy = held + own + 1j * omega * case.contact_loss_factor * held / resonance
        found[number] = 1j * omega * push / (lossy - mass * omega**2)
    return found


@pytest.mark.law("Elastic ring: waves bend it by the lines and amplitudes of rings on N springs.")
@pytest.mark.parametrize("beside", [-3, -2, -1, 1, 2, 3])
@pytest.mark.parametrize("line_hz", [500.0, 8000.0, 9700.0])
def test_waves_bend_the_ring(beside: int, line_hz: float) -> None:
    """Orders 2 N + n move it with n waves around it, below, at and above the resonances.

    Steps as fine as usual detune the resonance at 9,657 Hz by 0.3 %, which is seen on its flank.
    """
    case = elastic(contact_loss_factor=0.05, turns_hz=1.0)
    order = 2 * case.geometry.balls + beside
    (found,) = WaveMotion(case).of_order("inner", order)
    case = elastic(contact_loss_factor=0.05, turns_hz=line_hz / found.frequency_hz)
    tracks = with_waves(smooth_tracks(case.geometry), inner={order: A})
    motion = move_ring(case, tracks, 0.05, per_period=200 if line_hz > 9000 else 40)
    seen = [abs(line(motion.velocity_m_s[:, x], line_hz)) for x in (0, 3, 4, 5, 6)]
    expected = np.abs(own_response(case, order, line_hz))[[0, 1, 1, 2, 2]]
    np.testing.assert_allclose(seen, expected, rtol=0.03, atol=1e-3 * expected.max())
    (found,) = WaveMotion(case).of_order("inner", order)
    assert found.frequency_hz == pytest.approx(line_hz)
    assert found.velocity["radial"] * A == pytest.approx(expected.max(), rel=1e-3)


# ---- limits


@pytest.mark.law("Elastic ring: one that is infinitely stiff moves as a rigid one.")
def test_a_stiff_ring_is_a_rigid_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of modes with a great mass nothing but the rigid motion is left, in time and in frequency.

    Such modes hardly decay, so the longest run-in makes both motions begin alike.
    """
    monkeypatch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.03)
    stiff = tuple(replace(mode, mass_kg=1e9 * mode.mass_kg) for mode in MODES)
    for changes in ({}, {"angle": "moving", "radial_load_n": 300.0}):
        rigid = model(**changes)
        tracks = with_waves(smooth_tracks(rigid.geometry), inner={9: 50 * A, 10: 50 * A, 8: 20 * A})
        expected = move_ring(rigid, tracks, 0.02, per_period=80).velocity_m_s
        found = move_ring(model(**changes, bending=stiff), tracks, 0.02, per_period=80)
        size = np.abs(expected).max()
        np.testing.assert_allclose(found.velocity_m_s[:, :3], expected, atol=1e-6 * size)
        assert np.abs(found.velocity_m_s[:, 3:]).max() < 1e-6 * size
    frequency_hz = np.array([100.0, 1000.0, 6000.0])
    mobility = linear_ring(model()).mobility(frequency_hz)
    of_stiff = linear_ring(model(bending=stiff)).mobility(frequency_hz)[:, :3, :3]
    np.testing.assert_allclose(of_stiff, mobility, atol=1e-6 * np.abs(mobility).max())


@pytest.mark.law("Elastic ring: the work of loads and tracks is what it stores and loses.")
@pytest.mark.parametrize("changes", [{}, {"radial_load_n": 300.0, "angle": "moving"}])
def test_energy_is_balanced(changes: dict) -> None:
    case = elastic(**changes, tilt_inertia_kg_m2=TILT if changes else None)
    tracks = with_waves(smooth_tracks(case.geometry), inner={9: 1e-7, 10: 1e-7, 19: 1e-7})
    assert move_ring(case, tracks, 0.05).energy_error < 1e-3


def test_a_smooth_elastic_ring_is_silent() -> None:
    for angle in ("fixed", "moving"):
        case = elastic(angle=angle)
        motion = move_ring(case, smooth_tracks(case.geometry), 0.02)
        assert np.abs(motion.velocity_m_s).max() < 1e-12


@pytest.mark.law("Elastic ring: bending is what loads and its stiffness balance.")
@pytest.mark.parametrize("tilts", [False, True])
def test_a_radial_load_bends_the_ring(tilts: bool) -> None:
    """Forces of the balls on each mode are those of its spring; the middle of the zone gives way.

    Without mass the ring goes through these balances.
    """
    case = elastic(radial_load_n=400.0, angle="moving", tilt_inertia_kg_m2=TILT if tilts else None)
    state = case.balance(0.1)
    around = case.geometry.ball_angles(0.1)
    for number, mode in enumerate(MODES):
        for part, shape in enumerate((np.cos, np.sin)):
            pushed = state.ball_load_n @ (np.cos(state.angles) * shape(mode.order * around))
            bent = mode.stiffness_n_m * state.bending_m[2 * number + part]
            assert pushed == pytest.approx(bent, rel=1e-6, abs=1e-7)
    assert state.bending_m[0] > 1e-7
    borne = state.ball_load_n @ (np.cos(state.angles) * np.cos(around))
    assert borne == pytest.approx(400.0)
    slow = replace(case, kinematics=elastic(turns_hz=1.0).kinematics)
    motion = move_ring(slow, smooth_tracks(case.geometry), 0.02)
    wanted = slow.balance(float(motion.ball_angle[-1])).displacements[slow.columns]
    found = motion.displacement_m[-1] + motion.mean_displacement_m
    np.testing.assert_allclose(found, wanted, atol=2e-3 * np.abs(wanted[3:7]).max())


@pytest.mark.law("Elastic ring: the steps of its motion suit its modes.")
def test_steps_follow_small_rings() -> None:
    """The ring of a miniature bends far above hearing; finer steps change its waves by 0.1 %."""
    scene = rolling.BearingScene(
        bearing={"named": "608", "speed_rpm": 1800, "axial_load_n": 20, "ring": "elastic"}
    )
    assert [mode.order for mode in scene.model.bending] == [2, 3]
    tracks = with_waves(smooth_tracks(scene.geometry), inner={8: A, 9: A, 16: A})
    coarse = move_ring(scene.model, tracks, 0.03).velocity_m_s.std(axis=0)
    fine = move_ring(scene.model, tracks, 0.03, per_period=200).velocity_m_s.std(axis=0)
    np.testing.assert_allclose(coarse[[0, 2, 3]], fine[[0, 2, 3]], rtol=2e-3)


# ---- sensors


def sensed(motion: RingMotion, sensor_deg: float | None) -> RingRecord:
    """Return the record of a motion as a sensor at a place of the ring sees it."""
    sensor = None if sensor_deg is None else np.radians(sensor_deg)
    return record_of(motion, model().kinematics, sensor)


@pytest.mark.law("Elastic ring: a sensor sees what the place below it does.")
def test_a_sensor_sees_its_place() -> None:
    """Without a place, bands are the mean over all places by power."""
    case = elastic(radial_load_n=200.0, angle="moving", tilt_inertia_kg_m2=TILT)
    tracks = with_waves(smooth_tracks(case.geometry), outer={10: 1e-7, 17: 1e-7}, inner={9: 1e-8})
    motion = move_ring(case, tracks, 0.05)
    angle = np.radians(70.0)
    v = motion.velocity_m_s
    place = v[:, 0] * cos(angle) + v[:, 1] * sin(angle) + v[:, 3] * cos(2 * angle)
    place += v[:, 4] * sin(2 * angle) + v[:, 5] * cos(3 * angle) + v[:, 6] * sin(3 * angle)
    record = sensed(motion, 70.0)
    np.testing.assert_allclose(record.seen_velocity_m_s[:, 0], place, atol=1e-15)
    np.testing.assert_array_equal(record.seen_velocity_m_s[:, 2], v[:, 2])
    each = [sensed(motion, deg).bands[RADIAL].rms_m_s for deg in 30.0 * np.arange(12)]
    whole = sensed(motion, None).bands[RADIAL].rms_m_s
    for band, rms in whole.items():
        assert rms == pytest.approx(sqrt(np.mean([of[band] ** 2 for of in each])), rel=1e-6)


# ---- scenes


def test_tilts_and_seats_that_do_not_fit_are_refused() -> None:
    given = {"named": "6204", "speed_rpm": 1800, "axial_load_n": 70}
    with pytest.raises(rolling.SceneError, match=r"bearing\.angle moving"):
        rolling.BearingScene(bearing=given | {"angle": "fixed", "tilt": "free"})
    plate = {"material": "steel-s235", "length_mm": 300, "width_mm": 200, "thickness_mm": 5}
    with pytest.raises(rolling.SceneError, match="its seat in the housing holds the ring"):
        rolling.BearingScene(bearing=given | {"ring": "elastic"}, plate=plate)


def test_check_states_the_modes_and_what_is_left_out() -> None:
    given = {"named": "6204", "speed_rpm": 1800, "axial_load_n": 70}
    for ring in ("rigid", "elastic"):
        scene = rolling.BearingScene(bearing=given | {"ring": ring})
        findings = list(scene_rules(scene))
        rows = {row.key: row.value for row in findings if isinstance(row, Finding)}
        assert rows["ring_bending"] == "5.7 kHz, 16.1 kHz, free"
        assert rows["ring_left_out"].startswith("11.6 kHz, bending and twist out of the plane")
        keys = [row.key for row in findings]
        assert keys.count("ring_bending") == (2 if ring == "rigid" else 1)  # one is a doubt
        heavy = rolling.BearingScene(bearing=given | {"ring": ring, "ring_mass_kg": 0.2})
        assert ("fixed_mass" in {row.key for row in scene_rules(heavy)}) == (ring == "elastic")


def test_a_free_tilt_lowers_the_radial_motion_of_a_thin_ring() -> None:
    """Well above its rocking mode, by the decibels that `rolling check` states for a held one."""
    geometry = miniature()
    radius, width = 9e-3, 7e-3
    inertia = 0.01 * (radius**2 / 2 + width**2 / 12)
    given = {"axial_load_n": 20.0, "ring_mass_kg": 0.01, "angle": "moving"}
    held = model(geometry, **given)
    free = replace(held, tilt_inertia_kg_m2=inertia)
    wanted_db = free_tilt_db(geometry, held.rolling_angle, radius, width)
    levels = [WaveMotion(case).forces for case in (held, free)]
    assert levels[0].shape[1] == 3 and levels[1].shape[1] == 5
    below_hz = np.array([0.55 * linear_ring(held).radial_hz])
    moved = []
    for case, forces in zip((held, free), levels, strict=True):
        moved.append(abs(linear_ring(case).mobility(below_hz)[0] @ forces[1])[0])
    assert 20 * np.log10(moved[0] / moved[1]) == pytest.approx(wanted_db, abs=0.6)
