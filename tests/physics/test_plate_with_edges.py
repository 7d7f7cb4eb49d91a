"""Plates with edges move as closed forms, the linear chain and infinite plates say."""

from __future__ import annotations

import signal

import numpy as np
import pytest
from helpers import hertz_law, track_work
from scipy.linalg import expm
from test_ball_on_plate import (
    BOTH_ELASTIC,
    LOAD,
    MASS,
    RADIUS,
    RIGID_BALL,
    hertz_time,
    noise,
    plate,
    sheet,
    track_law,
    waves,
)
from test_ball_on_plate import bodies as of_infinite_plate

from acoustics.rectangular_plate import RectangularPlate
from rolling.dynamics import _mode_kernels as kernels
from rolling.dynamics.bodies import Chain, Modes, contact_stiffness, modes_of
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Stepping, advance, at_rest, move

SIDES = 0.3, 0.4
POINT = np.array([[0.43 * 0.3, 0.37 * 0.4]])
SOFT = 1e-20  # stiffness of a contact whose steps are in tune with nothing


def rectangle(
    thickness_mm: float, sides: tuple[float, float] = SIDES, loss_factor: float = 0.01
) -> RectangularPlate:
    bending = vars(sheet(thickness_mm))
    (length, width) = sides
    own = bending | {"loss_factor": loss_factor, "length_m": length, "width_m": width}
    return RectangularPlate(**own)


def bodies(
    law: ForceLaw,
    thickness_mm: float,
    sides: tuple[float, float] = SIDES,
    loss_factor: float = 0.01,
    contact: float = 0.0,
) -> Chain:
    modes = modes_of(rectangle(thickness_mm, sides, loss_factor), np.array([[0.43, 0.37]]) * sides)
    return Chain(MASS, plate(thickness_mm), contact_stiffness(law, LOAD), modes, contact)


def within_hearing(motion: BodyMotion) -> tuple[np.ndarray, np.ndarray]:
    """Return lines of the force from 20 Hz to 20 kHz, which belongs to the middle of its step."""
    count = len(motion.force_n)
    line = np.arange(count // 2 + 1)
    lines = 2 / count * np.fft.rfft(motion.force_n) * np.exp(-1j * np.pi * line / count)
    frequency = line / (count * motion.time_step_s)
    kept = (frequency > 20) & (frequency < 20e3)
    return frequency[kept], lines[kept]


@pytest.mark.kernel
@pytest.mark.law("Modes: a constant force moves a mode as a damped oscillator.")
@pytest.mark.parametrize("damping", [0.005, 0.7, 1.0, 1.5])
def test_single_mode(damping: float) -> None:
    """Displacement and velocity agree with the matrix exponential, critical damping too."""
    w = 2e4
    mass = 0.3
    step = 3e-5
    force = 2.0
    one = np.ones(1)
    reach = one / (w * np.sqrt(mass))
    modes = Modes(w * one, damping * one, reach, one, np.zeros(0, np.int64), np.ones(2), POINT)
    stepped = Chain(1.0, 0.0, SOFT, modes).steps(step)
    elastic = np.array([0.02])
    kinetic = np.array([-0.01])
    start = np.array([elastic[0] * reach[0], kinetic[0] / np.sqrt(mass), 1.0])
    rate = [[0, 1, 0], [-(w**2), -2 * damping * w, force / mass], [0, 0, 0]]
    kernels.move_modes(force, stepped.reach, stepped, elastic, kinetic)
    expected = expm(step * np.array(rate)) @ start
    assert elastic[0] * reach[0] == pytest.approx(expected[0], rel=1e-7)
    assert kinetic[0] / np.sqrt(mass) == pytest.approx(expected[1], rel=1e-7)


@pytest.mark.kernel
def test_shapes_by_recurrence() -> None:
    modes = modes_of(rectangle(10), POINT)
    stepped = Chain(MASS, 0.0, SOFT, modes).steps(1e-6)
    own = rectangle(10)
    order = np.lexsort(own.orders.T[::-1])
    shape = at_rest(stepped, POINT, 0.0, 0.0, 1.0).modes[0] / stepped.reach
    assert shape[: len(order)] == pytest.approx(own.shapes(POINT)[0][order], abs=1e-12)
    assert np.all(shape[len(order) :] == 1)


@pytest.mark.law("Modes: the static deflection under a force in the middle is 0.0116 F a^2 / B.")
def test_static_deflection() -> None:
    """Timoshenko's coefficient of a simply supported square has three digits, 0.01160."""
    square = rectangle(3, (0.4, 0.4))
    modes = modes_of(square, np.array([[0.2, 0.2]]))
    expected = 0.01160 * 0.4**2 / square.bending_stiffness_n_m
    assert modes.receptance(np.array([1e-3]))[0].real == pytest.approx(expected, rel=1e-3)


@pytest.mark.law("Modes: force and displacement of two points may be exchanged.")
def test_reciprocity_in_time() -> None:
    stepped = Chain(MASS, 0.0, SOFT, modes_of(rectangle(10), POINT)).steps(2e-6)
    shapes = [at_rest(stepped, point, 0.0, 0.0, 1.0).modes[0] for point in (POINT, POINT / 2)]
    ends = []
    for struck, heard in (shapes, shapes[::-1]):
        state = np.zeros((2, len(struck)))
        for force in (1.0, -2.0, 0.5, 0.0, 0.0):
            kernels.move_modes(force, struck, stepped, state[0], state[1])
        ends.append(heard @ state[0])
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)


@pytest.mark.law("Modes: the mean mobility over third octaves is an infinite plate's.")
def test_mean_mobility() -> None:
    """Above 1 kHz a plate of 1 mm has ten modes or more in a third octave: within 0.5 dB.

    The mean over five points takes out most of the luck of their shapes, 0.7 dB at one of them.
    """
    modes = modes_of(rectangle(1), POINT * np.linspace(0.8, 1.2, 5)[:, None])
    for centre in 1e3 * 2 ** (np.arange(1, 14) / 3):
        band = centre * 2 ** np.linspace(-1 / 6, 1 / 6, 3000)
        mobility = 2j * np.pi * band * modes.receptance(band)
        assert 10 * np.log10(mobility.real.mean() / plate(1)) == pytest.approx(0, abs=0.5)


@pytest.mark.law("Modes: until the first reflection returns, the restitution is Zener's.")
@pytest.mark.parametrize(
    ("modulus", "thickness", "side", "restitution"),
    [
        (BOTH_ELASTIC, 20, 1.6, 0.9894),
        (BOTH_ELASTIC, 10, 1.0, 0.9585),
        (BOTH_ELASTIC, 5, 0.7, 0.8458),
        (BOTH_ELASTIC, 3, 0.5, 0.6333),
        (RIGID_BALL, 5, 0.7, 0.8024),
        (RIGID_BALL, 3, 0.5, 0.5492),
    ],
)
def test_restitution(modulus: float, thickness: float, side: float, restitution: float) -> None:
    """The tail of a rolling sphere keeps 0.008; modes to 30 kHz alone are off by 0.013."""
    step = hertz_time(modulus, 0.1) / 300
    stepping = Stepping(time_step_s=step, start=(-1.5e-1 * step, 0.1))
    law = hertz_law(LOAD, RADIUS, modulus)
    motion = move(law, bodies(law, thickness, (side, side)), 0.0, 0.0, 750 * step, stepping)
    assert -motion.velocity_m_s[-1] / 0.1 == pytest.approx(restitution, abs=0.008)
    assert motion.energy_error < 1e-9


@pytest.mark.law("Plate with edges: a lap gives the force of the linear chain.")
@pytest.mark.parametrize(
    ("thickness", "speed", "loss_factor", "contact"),
    [(3, 0.3, 0.01, 0.0), (3, 0.7, 0.01, 0.0), (10, 0.5, 0.05, 0.0), (10, 0.5, 0.02, 0.1)],
)
def test_linear_chain(thickness: float, speed: float, loss_factor: float, contact: float) -> None:
    """Resonances are wider than the distance of the lines, and the stiffness is constant."""
    law = track_law(noise(2500, rms=5e-10))
    own = bodies(law, thickness, SIDES, loss_factor, contact)
    motion = move(law, own, LOAD, speed)
    assert motion.settled and motion.energy_error < 1e-9
    frequency, lines = within_hearing(motion)
    approach = np.fft.rfft(law.approach(law.position_m, LOAD)) * 2 / 2500
    order = np.round(frequency * law.period_m / speed).astype(int)
    expected = own.force(frequency, -approach[order])
    assert np.linalg.norm(lines - expected) < 0.02 * np.linalg.norm(expected)


@pytest.mark.law("Plate with edges: much loss makes a large plate infinite.")
def test_lossy_plate_is_infinite() -> None:
    """Lossy bending waves are a little softer: 0.12 on force and phase at a loss factor of 0.5."""
    law = track_law(noise(2500, rms=1e-9))
    forces = [
        within_hearing(move(law, own, LOAD, 0.5))[1][20:]
        for own in (bodies(law, 5, (0.9, 1.1), 0.5), of_infinite_plate(law, plate(5)))
    ]
    assert np.linalg.norm(forces[0] - forces[1]) < 0.12 * np.linalg.norm(forces[1])


@pytest.mark.law("Plate with edges: the power of the track is the power lost in modes and contact.")
@pytest.mark.parametrize("contact", [0.0, 0.05])
def test_power_in_is_power_lost(contact: float) -> None:
    """The chain gives the loss of a settled lap from its force, to 1 % with 100 steps a period."""
    law = track_law(noise(2500, rms=1e-9))
    own = bodies(law, 5, contact=contact)
    motion = move(law, own, LOAD, 0.5, stepping=Stepping(100))
    slope = track_work(law, motion.position_m, motion.approach_m)
    frequency, lines = within_hearing(motion)
    mobilities = own.mobilities(frequency)
    ball = mobilities["ball"]
    sheet = mobilities["plate"]
    damper = own.stiffness_n_m * own.contact_time_s * np.square(np.abs(ball + sheet))
    loss = np.sum(np.square(np.abs(lines)) / 2 * (sheet.real + damper))
    assert 0.5 * slope.mean() == pytest.approx(loss, rel=0.01)


@pytest.mark.law("Plate with edges: flights, impacts and moving contacts keep the energy balance.")
@pytest.mark.parametrize("seed", range(6))
def test_random_motions(seed: float) -> None:
    """Loads, plates and heights are drawn: every second ball drops, every third contact moves."""
    draw = np.random.default_rng(seed)
    size = float(10 ** draw.uniform(0.3, 1.3)), (0.12, 0.1), 10 ** draw.uniform(-3, 0)
    swing = np.array([[0.03, 0.02]])
    law = track_law(noise(500, rms=10 ** draw.uniform(-9, -5.5)))
    own = bodies(law, *size, contact=seed % 4 / 10)
    start = float(law.approach(0.0, 0.0)) - 1e-6, 0.3
    stepping = Stepping(start=start) if seed % 2 else Stepping()
    path = None
    if seed % 3 == 0:
        path = lambda time: POINT / 3 + np.sin(40 * np.asarray(time)[:, None]) * swing  # noqa: E731
    motion = move(law, own, LOAD, 1.0, 0.003, stepping, path)
    assert motion.energy_error < 1e-9
    assert motion.force_n.min() >= 0 and motion.force_n.max() < 5e3
    assert motion.impacts > 0 or seed % 2 == 0


def test_a_contact_that_rests_on_its_path_is_fixed() -> None:
    law = track_law(waves(64, 1, 1e-8))
    own = bodies(law, 10)
    start = Stepping(start=(float(law.approach(0.0, LOAD)), 0.0))
    paths = (None, lambda time: np.tile(POINT, (len(time), 1)))
    forces = [move(law, own, LOAD, 1.0, 5e-4, start, path).force_n for path in paths]
    assert forces[0] == pytest.approx(forces[1], abs=1e-8)


def test_stretches_continue() -> None:
    """A state that is carried on gives the motion without a break, bit by bit."""
    law = track_law(waves(64, 1, 1e-8))
    own = bodies(law, 10)
    stepped = own.steps(1.5e-6)
    table = law.table
    state = at_rest(stepped, POINT, float(law.approach(0.0, LOAD)), 0.0, 0.0)
    places = 1.5e-6 * (np.arange(300) + 0.5)
    whole = advance(table, stepped, LOAD, state, places, POINT)
    first = advance(table, stepped, LOAD, state, places[:100], POINT)
    second = advance(table, stepped, LOAD, first.end, places[100:], POINT)
    assert np.array_equal(whole.record[100:], second.record)
    assert np.array_equal(whole.end.modes, second.end.modes)


def test_a_plate_rests_under_the_force_of_the_start() -> None:
    """A ball in flight leaves the plate unloaded: it stays at rest until the impact."""
    law = hertz_law(LOAD, RADIUS, BOTH_ELASTIC)
    own = bodies(law, 5)
    motion = move(law, own, LOAD, 0.0, 2e-4, Stepping(start=(-1e-3, 0.0)))
    assert motion.flight_share == 1
    assert np.ptp(motion.plate_m) < 1e-9 * abs(motion.plate_m[0])


@pytest.mark.parametrize("loss_factor", [1e-3, 0.5])
def test_table_of_the_receptance(loss_factor: float) -> None:
    """Many frequencies are read from a table, within 1 % on sharp resonances and between."""
    modes = modes_of(rectangle(10, SIDES, loss_factor), POINT)
    frequency = np.geomspace(20, 40e3, 6001)
    exact = np.concatenate([modes.receptance(part) for part in np.array_split(frequency, 10)])
    assert np.abs(modes.receptance(frequency) / exact - 1).max() < 0.01


def test_an_interrupt_during_a_motion_is_raised() -> None:
    """Numba hands over arrays and named tuples by Python code, where nothing can be raised."""
    law = track_law(waves(64, 1, 1e-8))
    own = bodies(law, 10)
    stepped = own.steps(1.5e-6)
    state = at_rest(stepped, POINT, float(law.approach(0.0, LOAD)), 0.0, 0.0)
    places = 1.5e-6 * (np.arange(400_000) + 0.5)
    advance(law.table, stepped, LOAD, state, places[:10], POINT)
    handler = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            advance(law.table, stepped, LOAD, state, places, POINT)
    finally:
        signal.signal(signal.SIGALRM, handler)
