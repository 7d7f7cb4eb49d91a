"""The ring of a bearing moves as linear theory, statics and energy say, on every geometry."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
from bearings import angular, bearing, miniature, model

import rolling
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_motion import RingMotion, move_ring
from rolling.bearing.tracks import BearingTracks, BodyTrack, smooth_tracks, with_waves
from rolling.bearing.wave_motion import WaveMotion

A = 1e-9  # [m] amplitude of waves, far below the approach
SLOW_HZ = 5.0  # turns per second, with which all lines lie far below the resonances
BEARINGS = {
    "6204": {"geometry": bearing(), "axial_load_n": 70.0},
    "7210": {"geometry": angular(balls=9), "axial_load_n": 400.0},
}


def amplitudes(motion: RingMotion, lines_hz: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes of lines (lines, 3) by least squares, and the rms of what is left."""
    phase = 2 * pi * motion.time_s[:, None] * np.array(lines_hz)
    constant = np.ones((len(phase), 1))  # the mean of lines that do not end with a period
    waves = np.concatenate((np.cos(phase), np.sin(phase), constant), axis=1)
    coefficients = np.linalg.lstsq(waves, motion.displacement_m, rcond=None)[0]
    left = motion.displacement_m - waves @ coefficients
    count = len(lines_hz)
    return np.hypot(coefficients[:count], coefficients[count : 2 * count]), left.std(axis=0)


@pytest.mark.law("Bearing: waves of a raceway move the ring at the lines of their orders only.")
@pytest.mark.parametrize("name", BEARINGS)
@pytest.mark.parametrize(
    ("turning", "ring"), [("inner", "inner"), ("inner", "outer"), ("outer", "inner")]
)
def test_waves_of_a_raceway(name: str, turning: str, ring: str) -> None:
    """Of order n = q Z axial at q times the ball pass, A / sin(alpha); of q Z +- 1 radial.

    A radial line lies at the ball pass plus or minus the turns of the raceway, A / cos(alpha).
    Other orders move nothing. Linear theory holds within 1 % so far below the resonances.
    """
    case = model(turning=turning, turns_hz=SLOW_HZ, **BEARINGS[name])
    balls = case.geometry.balls
    speeds = case.kinematics
    passes, turns = speeds.ball_pass_outer_hz, speeds.outer_hz
    if ring == "inner":
        passes, turns = speeds.ball_pass_inner_hz, speeds.inner_hz
    axial = A / sin(case.geometry.contact_angle)
    radial = A / cos(case.geometry.contact_angle)
    silent = [2, 3, balls - 2, balls + 2, balls + 3, 2 * balls - 2]
    # On a raceway at rest q Z - 1 and q Z + 1 share a line, so they have a run each.
    for group in ([(1, 0), (1, -1), (2, 1)], [(2, 0), (2, -1), (1, 1)]):
        orders = [q * balls + beside for q, beside in group]
        tracks = with_waves(
            smooth_tracks(case.geometry), **{ring: dict.fromkeys((*orders, *silent), A)}
        )
        expected: dict[float, np.ndarray] = {}
        for q, beside in group:
            frequency = q * passes + beside * turns
            moved = [radial, radial, 0.0] if beside else [0.0, 0.0, axial]
            expected[frequency] = expected.get(frequency, np.zeros(3)) + moved
        motion = move_ring(case, tracks, 0.25)
        found, left = amplitudes(motion, list(expected))
        wanted = np.array(list(expected.values()))
        np.testing.assert_allclose(found, wanted, rtol=0.01, atol=0.01 * A)
        assert max(left) < 0.01 * axial


@pytest.mark.law("Bearing: under a load zone each order has the lines of the parts of the forces.")
@pytest.mark.parametrize("body", ["inner", "outer", "balls"])
def test_waves_under_a_load_zone(body: str) -> None:
    """Combined loads couple radial and axial motion; the motion without waves is taken off.

    Of an order that is beside q Z by more than one, a load zone has lines in both directions.
    """
    case = model(turns_hz=4 * SLOW_HZ, axial_load_n=120.0, radial_load_n=200.0)
    order = 4 if body == "balls" else 8 + 2
    found = [
        line
        for line in WaveMotion(case).of_order(body, order)
        if max(line.velocity.values()) > 0.03 * 2 * pi * line.frequency_hz
    ]
    assert found
    smooth = smooth_tracks(case.geometry)
    waves = {0: {order: A}} if body == "balls" else {order: A}
    still = move_ring(case, smooth, 0.25)
    moved = move_ring(case, with_waves(smooth, **{body: waves}), 0.25)
    change = replace(moved, displacement_m=moved.displacement_m - still.displacement_m)
    seen, _ = amplitudes(change, [line.frequency_hz for line in found])
    for line, (x, y, axial) in zip(found, seen, strict=True):
        scale = A / (2 * pi * line.frequency_hz)
        radial = float(np.hypot(x, y) / np.sqrt(2))
        assert radial == pytest.approx(line.velocity["radial"] * scale, rel=0.05, abs=0.01 * A)
        assert axial == pytest.approx(line.velocity["axial"] * scale, rel=0.05, abs=0.01 * A)


@pytest.mark.law("Bearing: waves of even order of a ball move the ring, odd ones do not.")
@pytest.mark.parametrize("name", BEARINGS)
def test_waves_of_a_ball(name: str) -> None:
    """Axial at n f_b, 2 A / (Z sin(alpha)); radial at n f_b +- f_c, 2 A / (Z cos(alpha)) each."""
    case = model(turns_hz=SLOW_HZ, **BEARINGS[name])
    speeds = case.kinematics
    balls = case.geometry.balls
    angle = case.geometry.contact_angle
    waves = dict.fromkeys((2, 3, 4, 5, 6, 7), A)
    tracks = with_waves(smooth_tracks(case.geometry), balls={balls - 2: waves})
    motion = move_ring(case, tracks, 0.3)
    even = [n * speeds.ball_spin_hz for n in (2, 4, 6)]
    lines = [*even]
    lines += [f + speeds.cage_hz for f in even] + [f - speeds.cage_hz for f in even]
    found, left = amplitudes(motion, lines)
    np.testing.assert_allclose(found[:3, 2], 2 * A / (balls * sin(angle)), rtol=0.03)
    np.testing.assert_allclose(found[3:, :2], 2 * A / (balls * cos(angle)), rtol=0.03)
    assert np.max(found[:3, :2]) < 0.01 * A and np.max(found[3:, 2]) < 0.01 * A / sin(angle)
    assert max(left) < 0.02 * A / sin(angle)


@pytest.mark.law("Bearing: perfectly smooth under an axial load, it is silent.")
@pytest.mark.parametrize("inertia", [False, True])
def test_a_smooth_bearing_is_silent(inertia: bool) -> None:
    for case in (model(ball_inertia=inertia), model(angular(), axial_load_n=300.0)):
        motion = move_ring(case, smooth_tracks(case.geometry), 0.02)
        quiet = 1e-9 if case.ball_inertia else 1e-13  # centrifugal force leaves its run-in
        assert np.abs(motion.velocity_m_s).max() < quiet
        assert motion.lost_contact_share == 0
        assert motion.energy_error < 1e-6


@pytest.mark.law("Bearing: under a radial load its stiffness varies with the balls' passing.")
@pytest.mark.parametrize(
    ("geometry", "loads"),
    [
        (bearing(angle_deg=0.0), {"axial_load_n": 0.0, "radial_load_n": 500.0, "gap_m": 4e-6}),
        (angular(balls=11), {"axial_load_n": 400.0, "radial_load_n": 300.0}),
        (bearing(), {"axial_load_n": 70.0, "radial_load_n": 500.0, "angle": "moving"}),
    ],
    ids=["radial with clearance", "combined", "balls lifted at moving angles"],
)
def test_varying_compliance_follows_the_static_balance(geometry, loads) -> None:
    """A slow ring goes through the balances of the cage's places, and moves at Z f_c.

    Its inertia, and a ball's entry into the load zone, change that by less than 1e-3 of the way.
    """
    case = model(geometry, turns_hz=1.0, **loads)
    motion = move_ring(case, smooth_tracks(geometry), 0.4)
    places = np.linspace(0, len(motion.time_s) - 1, 40).astype(int)
    balances = [case.balance(motion.ball_angle[place]) for place in places]
    still = np.array([state.displacement_m for state in balances])
    moved = (motion.displacement_m + motion.mean_displacement_m)[places]
    way = np.ptp(still, axis=0).max()
    np.testing.assert_allclose(moved, still, atol=1e-3 * way)
    still_loads = np.array([state.ball_load_n for state in balances])
    np.testing.assert_allclose(
        motion.ball_load_n[places], still_loads, atol=1e-3 * still_loads.max()
    )
    period = 1 / (case.geometry.balls * case.kinematics.cage_hz)
    later = round(period * motion.rate_hz)
    repeated = motion.displacement_m[later:, 0] - motion.displacement_m[:-later, 0]
    assert np.abs(repeated).max() < 2e-3 * way


def valley(tracks: BearingTracks, depth_m: float, share: float) -> BearingTracks:
    """Return tracks with a valley in the outer raceway over a share of its turn."""
    points = 20000
    place = np.arange(points) / points
    bottom = np.where(np.abs(place - 0.3) < share / 2, depth_m, 0.0)
    edge = round(0.1 * share * points)
    bottom = np.convolve(bottom, np.hanning(edge) / np.hanning(edge).sum(), mode="same")
    deep = BodyTrack(loads_n=np.ones(1), approach_m=bottom[None])
    return replace(tracks, outer=tracks.outer.plus(deep))


def test_a_ball_in_a_deep_valley_loses_its_contact() -> None:
    """The other balls then bear the axial load, as a bearing of them would.

    The valley is ten times as deep as the approach, and the cage is so slow that the ring follows.
    """
    case = model(turns_hz=1.0, contact_loss_factor=0.2)
    tracks = valley(smooth_tracks(case.geometry), 10e-6, 0.02)
    time = 0.3 / case.kinematics.cage_hz  # ball 0 is in the valley then
    motion = move_ring(case, tracks, time)
    assert motion.ball_load_n[-1, 0] == pytest.approx(0.0, abs=1e-6)
    assert sin(case.geometry.contact_angle) * motion.ball_load_n[-1].sum() == pytest.approx(
        70.0, rel=1e-3
    )
    opposite = motion.ball_load_n[-1, 4]
    beside = motion.ball_load_n[-1, [1, 7]]
    assert opposite < 42.0 < beside.min()  # moments of the loads about the axis balance
    assert 0 < motion.lost_contact_share < 0.1


def rough_tracks(case: BearingModel, rms_m: float, seed: int = 1) -> BearingTracks:
    """Return tracks of random heights down to waves of 100 um, which shrink with the load."""
    random = np.random.default_rng(seed)
    geometry = case.geometry

    def rough(radius_m: float) -> BodyTrack:
        points = int(2 * pi * radius_m / 20e-6)
        lines = np.fft.rfft(random.standard_normal(points))
        waves = np.arange(len(lines)) / (2 * pi * radius_m)
        lines *= np.exp(-((waves * 100e-6) ** 2))
        height = np.fft.irfft(lines, points)
        shrunk = np.array([1.0, 0.9, 0.7])[:, None]
        track = shrunk * rms_m / height.std() * (height - height.mean())
        return BodyTrack(loads_n=np.array([2.0, 20.0, 200.0]), approach_m=track)

    balls = tuple(rough(geometry.ball_radius_m) for _ in range(geometry.balls))
    return BearingTracks(
        inner=rough(geometry.inner.radius_m),
        outer=rough(geometry.outer.radius_m),
        balls_on_inner=balls,
        balls_on_outer=balls,
    )


HARD = {
    "rough": ({}, 20e-9),
    "rough as the approach": ({}, 1e-6),
    "3 balls": ({"geometry": bearing(balls=3)}, 50e-9),
    "clearance": (
        {
            "geometry": bearing(angle_deg=0.0),
            "axial_load_n": 0.0,
            "radial_load_n": 5.0,
            "gap_m": 5e-6,
        },
        50e-9,
    ),
    "40 degrees": ({"geometry": angular(), "axial_load_n": 300.0, "radial_load_n": 200.0}, 50e-9),
    "moving angle": ({"radial_load_n": 400.0, "angle": "moving"}, 50e-9),
    "light ring": ({"ring_mass_kg": 1e-3}, 20e-9),
    "fast": ({"turns_hz": 500.0}, 20e-9),
    "without losses": ({"contact_loss_factor": 0.0}, 20e-9),
}


@pytest.mark.law("Bearing: the work of loads and turning tracks is what the ring stores and loses.")
@pytest.mark.parametrize("name", HARD)
def test_energy_is_balanced(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a fortieth of a period lose track of 3e-3 of the energy that moves at most.

    The largest share is that of a ring that hits its balls again and again. Rounding decides which
    hits there are: masses that differ by 1e-12 have shares of 0.6e-3 to 2.2e-3.
    """
    monkeypatch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.05)
    changes, rms = HARD[name]
    case = model(**changes)
    motion = move_ring(case, rough_tracks(case, rms), 0.1)
    assert motion.energy_error < 3e-3
    assert np.isfinite(motion.velocity_m_s).all()


def test_finer_steps_balance_the_energy_better() -> None:
    """The error of ball and ring falls with the square of the step, where balls hit raceways."""
    case = model(ball_inertia=True)
    tracks = valley(smooth_tracks(case.geometry), 10e-6, 0.005)
    coarse = move_ring(case, tracks, 0.1, per_period=20).energy_error
    fine = move_ring(case, tracks, 0.1, per_period=80).energy_error
    assert coarse < 0.03
    assert fine < coarse / 8


def test_a_turning_outer_ring_is_the_exchanged_frame() -> None:
    """Names of the raceways exchanged, the ring moves the other way, and by as much.

    The axial way keeps its sign.
    """
    case = model(turning="outer", axial_load_n=70.0, radial_load_n=50.0)
    tracks = rough_tracks(case, 50e-9)
    balls = tuple(track.resampled(2048) for track in tracks.balls_on_inner)
    turned = tuple(
        BodyTrack(loads_n=track.loads_n, approach_m=np.roll(track.approach_m, 1024, axis=1))
        for track in balls
    )
    tracks = replace(tracks, balls_on_inner=balls, balls_on_outer=balls)
    speeds = case.kinematics
    exchanged = replace(
        case,
        geometry=replace(case.geometry, inner=case.geometry.outer, outer=case.geometry.inner),
        kinematics=replace(
            speeds, turning="inner", inner_hz=speeds.outer_hz, outer_hz=speeds.inner_hz
        ),
    )
    other = BearingTracks(
        inner=tracks.outer,
        outer=tracks.inner,
        balls_on_inner=turned,
        balls_on_outer=turned,
    )
    moved = move_ring(case, tracks, 0.1)
    mirrored = move_ring(exchanged, other, 0.1)
    size = np.abs(moved.velocity_m_s).max()
    expected = moved.velocity_m_s * [-1.0, -1.0, 1.0]
    np.testing.assert_allclose(mirrored.velocity_m_s, expected, atol=1e-6 * size)


def bands(motion: RingMotion) -> np.ndarray:
    """Return mean squares of the velocity, (bands, 3), in the three bands of ISO 15242."""
    window = np.hanning(len(motion.time_s))[:, None]
    power = np.abs(np.fft.rfft(motion.velocity_m_s * window, axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(window), 1 / motion.rate_hz)
    edges = ((50, 300), (300, 1800), (1800, 10000))
    return np.array([power[(frequency >= a) & (frequency < b)].sum(axis=0) for a, b in edges])


BALLS_IN_BANDS = {
    "6204": model(),
    "608": model(miniature(), ring_mass_kg=5e-3, axial_load_n=20.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BALLS_IN_BANDS)
def test_balls_without_mass_serve_the_three_bands(name: str) -> None:
    """Balls with mass bounce at 34 kHz and above; they change the bands by less than 0.5 dB.

    Their mass lowers the resonance of the ring by some 2 %, where random tracks have other waves,
    so the loss factor is high enough for many of them. The radial bands below differ by 0.1 dB.
    """
    case = replace(BALLS_IN_BANDS[name], contact_loss_factor=0.1)
    tracks = rough_tracks(case, 20e-9)
    light = bands(move_ring(case, tracks, 0.6))
    heavy = bands(move_ring(replace(case, ball_inertia=True), tracks, 0.6))
    difference_db = np.abs(10 * np.log10(heavy / light))
    assert difference_db.max() < 0.5
    assert difference_db[:2, :2].max() < 0.1


@pytest.mark.law("Bearing: small waves move the ring as a mass on the mean stiffness.")
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("name", BEARINGS)
def test_mobility_is_that_of_the_linear_ring(name: str, ratio: float) -> None:
    """Waves A of order Z push with K A / sin(alpha), below, at and above the axial resonance."""
    loss = 0.05
    case = model(contact_loss_factor=loss, turns_hz=1.0, **BEARINGS[name])
    ring = linear_ring(case)
    turns = ratio * ring.axial_hz / case.kinematics.ball_pass_inner_hz
    case = model(contact_loss_factor=loss, turns_hz=turns, **BEARINGS[name])
    tracks = with_waves(smooth_tracks(case.geometry), inner={case.geometry.balls: 0.1 * A})
    motion = move_ring(case, tracks, 0.1)
    frequency = ratio * ring.axial_hz
    found, _ = amplitudes(motion, [frequency])
    force = ring.stiffness_n_m[2, 2] * 0.1 * A / sin(case.geometry.contact_angle)
    velocity = force * np.abs(ring.mobility(np.array([frequency]))[0, 2, 2])
    assert 2 * pi * frequency * found[0, 2] == pytest.approx(velocity, rel=0.02)
    if ratio == 1.0:
        quality = velocity * ring.mass_kg * 2 * pi * frequency / force
        assert quality == pytest.approx(1 / loss, rel=1e-6)


@pytest.mark.law("Bearing: the motion is that of an independent solution of its equations.")
@pytest.mark.parametrize("angle", ["fixed", "moving"])
def test_motion_agrees_with_another_solver(angle: str) -> None:
    """Waves above the approach and a radial load; balls lose contact, and nothing is lost.

    The comparison begins with a recorded state. 160 steps in a period of the resonance leave 0.2 %
    of the maximum after 60 periods. A moving line leads from one centre of the grooves to the
    other.
    """
    from scipy.integrate import solve_ivp

    case = model(contact_loss_factor=0.0, radial_load_n=150.0, angle=angle)
    geometry = case.geometry
    tracks = with_waves(smooth_tracks(geometry), inner={9: 3e-6}, outer={12: 2e-6})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.05)
        motion = move_ring(case, tracks, 0.01, per_period=160)
    speeds = case.kinematics
    places = 2 * pi * np.arange(geometry.balls) / geometry.balls
    distance = geometry.groove_distance_m
    cosine, sine = cos(geometry.contact_angle), sin(geometry.contact_angle)

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        around = places + 2 * pi * speeds.cage_hz * time
        outwards = -np.stack((np.cos(around), np.sin(around)))
        height = 3e-6 * np.cos(9 * (around - 2 * pi * speeds.inner_hz * time))
        height += 2e-6 * np.cos(12 * around)
        if angle == "fixed":
            approach = cosine * (state[:2] @ outwards) + sine * state[2] + height
            line = np.full((2, len(around)), [[cosine], [sine]])
        else:
            line = np.array([distance * cosine + state[:2] @ outwards, 0 * around])
            line[1] = distance * sine + state[2]
            length = np.hypot(*line)
            approach = length - distance + height
            line /= length
        load = geometry.series_stiffness * np.maximum(approach, 0.0) ** 1.5
        force = np.append(outwards @ (load * line[0]), (load * line[1]).sum())
        return np.append(state[3:], (case.load - force) / case.ring_mass_kg)

    start = np.append(motion.displacement_m[0] + motion.mean_displacement_m, motion.velocity_m_s[0])
    solution = solve_ivp(
        rates,
        (0.0, motion.time_s[-1]),
        start,
        method="DOP853",
        t_eval=motion.time_s,
        rtol=1e-9,
        atol=1e-13,
    )
    expected = solution.y[3:].T
    assert motion.ball_load_n.min() < 1.0  # a contact is lost
    size = np.abs(expected).max()
    np.testing.assert_allclose(motion.velocity_m_s, expected, atol=0.005 * size)


@pytest.mark.law("Bearing: resonances at moving angles are those of exact geometry.")
@pytest.mark.parametrize(
    ("axial_n", "angle", "radial_hz", "axial_hz"),
    [
        (70.0, "fixed", 6154, 1849),
        (70.0, "moving", 5958, 2172),
        (1000.0, "fixed", 9581, 2880),
        (1000.0, "moving", 8564, 4633),
    ],
)
def test_the_turning_line_moves_the_resonances(
    axial_n: float, angle: str, radial_hz: float, axial_hz: float
) -> None:
    """Q cos^2(alpha)/s holds a 6204 along its axis, beside an angle that turns towards it."""
    ring = linear_ring(model(axial_load_n=axial_n, angle=angle))
    assert ring.radial_hz == pytest.approx(radial_hz, rel=1e-3)
    assert ring.axial_hz == pytest.approx(axial_hz, rel=1e-3)


@pytest.mark.law("Bearing: single waves move a 6204 at moving angles as exact grooves have it.")
@pytest.mark.parametrize(("order", "amplitude_um", "um_s"), [(8, 0.05, 130), (64, 0.005, 147)])
def test_single_waves_at_moving_angles(order: int, amplitude_um: float, um_s: float) -> None:
    """Axial velocities at 70 N and 1,800 rpm are those of an integration of another program."""
    scene = rolling.BearingScene(
        bearing=rolling.Bearing(named="6204", speed_rpm=1800, axial_load_n=70, angle="moving")
    )
    waves = with_waves(smooth_tracks(scene.geometry), inner={order: 1e-6 * amplitude_um})
    motion = move_ring(scene.model, waves, 0.1)
    line_hz = order / 8 * scene.kinematics.ball_pass_inner_hz
    found, left = amplitudes(motion, [line_hz])
    assert 2e6 * pi * line_hz * found[0, 2] / np.sqrt(2) == pytest.approx(um_s, rel=0.005)
    assert max(left) < 0.02 * found[0, 2]
    (line,) = WaveMotion(scene.model).of_order("inner", order)
    assert line.velocity["axial"] * amplitude_um / np.sqrt(2) == pytest.approx(um_s, rel=0.005)


@pytest.mark.law("Bearing: single waves with losses are those of an own integration.")
@pytest.mark.parametrize(("order", "amplitude_um", "um_s"), [(8, 0.05, 130), (64, 0.005, 147)])
def test_single_waves_by_an_own_integration(order: int, amplitude_um: float, um_s: float) -> None:
    """Orders q Z press all eight balls alike, so a ring on exact grooves has one equation.

    The centres of the grooves are A apart, on a line that the way z along the axis turns. The loss
    factor 0.02 is that of the stiffness at rest, at the axial resonance.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    scene = rolling.BearingScene(
        bearing=rolling.Bearing(named="6204", speed_rpm=1800, axial_load_n=70, angle="moving")
    )
    geometry, mass = scene.geometry, scene.model.ring_mass_kg
    distance, angle = geometry.groove_distance_m, geometry.contact_angle
    line_hz = order / 8 * scene.kinematics.ball_pass_inner_hz

    def force(way: float, height: float = 0.0) -> float:
        length = np.hypot(distance * cos(angle), distance * sin(angle) + way)
        load = geometry.series_stiffness * (length - distance + height) ** 1.5
        return float(8 * load * (distance * sin(angle) + way) / length)

    rest = brentq(lambda way: force(way) - 70.0, 1e-9, 1e-4, xtol=1e-15)
    stiffness = (force(rest + 1e-9) - force(rest - 1e-9)) / 2e-9
    viscous = 0.02 * np.sqrt(stiffness * mass)

    def rates(time: float, state: np.ndarray) -> list[float]:
        height = 1e-6 * amplitude_um * np.cos(2 * pi * line_hz * time)
        pushed = 70.0 - force(state[0], height) - viscous * state[1]
        return [state[1], pushed / mass]

    times = np.linspace(0.05, 0.06, 2000)
    solution = solve_ivp(
        rates, (0.0, 0.06), [rest, 0.0], method="DOP853", t_eval=times, rtol=1e-8, atol=1e-13
    )
    tone = np.exp(-2j * pi * line_hz * times)
    window = np.hanning(len(times))
    seen = abs(2 * np.sum(window * tone * solution.y[1]) / np.sum(window)) / np.sqrt(2)
    assert 1e6 * seen == pytest.approx(um_s, rel=0.02)
    waves = with_waves(smooth_tracks(geometry), inner={order: 1e-6 * amplitude_um})
    found, _ = amplitudes(move_ring(scene.model, waves, 0.1), [line_hz])
    assert np.sqrt(2) * pi * line_hz * found[0, 2] == pytest.approx(seen, rel=0.02)


def test_balls_with_mass_keep_to_lines_that_turn() -> None:
    """Far below their bounce they change the axial motion of a wave by less than a hundredth."""
    waves = with_waves(smooth_tracks(bearing()), inner={8: 20e-9})
    velocities = {}
    for inertia in (False, True):
        case = model(angle="moving", ball_inertia=inertia, contact_loss_factor=0.1)
        motion = move_ring(case, waves, 0.05)
        assert motion.energy_error < 2e-3
        velocities[inertia] = motion.velocity_m_s[:, 2].std()
    assert velocities[True] == pytest.approx(velocities[False], rel=0.01)


@pytest.mark.law("Bearing: a ball with mass moves between its raceways as a mass on two springs.")
@pytest.mark.parametrize(
    ("turning", "order", "frequency_hz"),
    [("inner", 10, 10e3), ("inner", 11, 10e3), ("outer", 11, 10e3), ("outer", 10, 3e3)],
)
def test_balls_with_mass_follow_linear_theory(
    turning: str, order: int, frequency_hz: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same waves on all balls move the ring along its axis; two equations give how far.

    The centrifugal force makes the load on the inner raceway smaller than that on the outer.
    """
    monkeypatch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.03)
    geometry = bearing(angle_deg=25.0)
    one_turn = model(geometry, turning=turning, turns_hz=1.0).kinematics.ball_spin_hz
    case = model(
        geometry,
        turning=turning,
        turns_hz=frequency_hz / order / one_turn,
        axial_load_n=2000.0,
        ball_inertia=True,
        contact_loss_factor=0.1,
    )
    waves = {ball: {order: A} for ball in range(geometry.balls)}
    motion = move_ring(case, with_waves(smooth_tracks(geometry), balls=waves), 0.02)
    found, _ = amplitudes(motion, [frequency_hz])

    sine = sin(geometry.contact_angle)
    loads = {case.kinematics.moving: 2000.0 / geometry.balls / sine}
    if turning == "inner":
        loads["inner"] = loads["outer"] - case.centrifugal_n
    else:
        loads["outer"] = loads["inner"] + case.centrifugal_n
    stiffness = {
        ring: 1.5 * contact.stiffness_n_m15 ** (2 / 3) * loads[ring] ** (1 / 3)
        for ring, contact in (("inner", geometry.inner), ("outer", geometry.outer))
    }
    heights = {"inner": A, "outer": A * (-1) ** order}
    # Unknowns: the way of the ring along its axis, and of each ball outwards.
    ways = {"inner": np.array([0.0, -1.0]), "outer": np.array([0.0, 1.0])}
    ways[case.kinematics.moving] += [sine, 0.0]
    masses = np.diag([case.ring_mass_kg / geometry.balls, case.ball_mass_kg])
    matrix = -masses * (2 * pi * frequency_hz) ** 2
    push = np.zeros(2)
    for ring, way in ways.items():
        matrix = matrix + stiffness[ring] * np.outer(way, way)
        push -= stiffness[ring] * heights[ring] * way
    expected = abs(np.linalg.solve(matrix, push)[0])
    largest = 2 * A / sine
    assert found[0, 2] == pytest.approx(expected, rel=0.02, abs=2e-3 * largest)


@pytest.mark.law("Bearing: over a pit, balls with mass come to balls without as their mass falls.")
def test_lighter_balls_come_to_balls_without_mass_over_a_pit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The pulse differs by the square of frequency over bounce, which is as the mass.

    Equal steps leave the mass as the only difference.
    """
    monkeypatch.setattr("rolling.bearing.limits.LONGEST_RUN_IN_S", 0.004)
    monkeypatch.setattr("rolling.bearing.ring_motion._steps_per_sample", lambda *_: 200)
    case = model(axial_load_n=300.0, contact_loss_factor=0.0, film_time_s=5e-6, turns_hz=100.0)
    tracks = valley(smooth_tracks(case.geometry), 0.2e-6, 0.04)
    massless = move_ring(case, tracks, 0.004).acceleration_m_s2
    lags = []
    for share in (0.04, 0.16):
        light = replace(case, ball_mass_kg=share * case.ball_mass_kg, ball_inertia=True)
        pulse = move_ring(light, tracks, 0.004).acceleration_m_s2
        lags.append(float(np.sqrt(np.square(pulse - massless).mean())))
    size = float(np.sqrt(np.square(massless).mean()))
    assert lags[0] < 0.005 * size
    assert lags[1] / lags[0] == pytest.approx(4.0, rel=0.02)


def test_centrifugal_force_relieves_the_inner_raceway() -> None:
    case = model(turns_hz=150.0, ball_inertia=True, axial_load_n=100.0)
    geometry = case.geometry
    motion = move_ring(case, smooth_tracks(geometry), 0.02)
    load = 100.0 / geometry.balls / sin(geometry.contact_angle)
    relieved = load - case.centrifugal_n
    approach = (load / geometry.outer.stiffness_n_m15) ** (2 / 3)
    approach += (relieved / geometry.inner.stiffness_n_m15) ** (2 / 3)
    expected = approach / sin(geometry.contact_angle)
    assert motion.mean_displacement_m[2] == pytest.approx(expected, rel=1e-4)
    assert relieved < 0.99 * load


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ring_mass_kg": 1e-9}, "ring_mass_kg"),
        ({"ball_inertia": True, "turns_hz": 1000.0}, "centrifugal"),
        ({"radial_load_n": 400.0}, "axial_load_n"),
    ],
)
def test_a_ring_that_cannot_be_moved_is_refused(changes, message: str) -> None:
    case = model(**changes)
    with pytest.raises(ValueError, match=message):
        move_ring(case, smooth_tracks(case.geometry), 0.1)


def test_tracks_of_another_number_of_balls_are_refused() -> None:
    with pytest.raises(ValueError, match="got 8 balls, allowed: 7"):
        move_ring(model(miniature()), smooth_tracks(bearing()), 0.1)


def test_a_caller_learns_the_share_of_the_motion_that_is_done() -> None:
    """Stretches of run-in and record add up to 1, and a few samples of the filter beyond."""
    shares: list[float] = []
    case = model(bearing())
    move_ring(case, smooth_tracks(case.geometry), 0.1, progress=shares.append)
    assert len(shares) > 1 and min(shares) > 0
    assert sum(shares) == pytest.approx(1, abs=0.01)
