"""Ball and plate move as closed forms and the linear chain say, and no energy is lost."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import hertz_law, sphere_mass, track_work
from scipy.integrate import solve_ivp

from acoustics.radiation import ThinPlate
from rolling.dynamics.bodies import Chain, contact_stiffness
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import BodyMotion, Stepping, TabulatedTravel, move

RADIUS = 5e-3
LOAD = 20.0
YOUNG = 206e9
POISSON = 0.3
DENSITY = 7850.0
RIGID_BALL = YOUNG / (1 - POISSON**2)  # contact modulus of a rigid ball on an elastic plate
BOTH_ELASTIC = RIGID_BALL / 2
MASS = sphere_mass(RADIUS, DENSITY)
SPACING = 2e-6


def sheet(thickness_mm: float) -> ThinPlate:
    thickness = thickness_mm * 1e-3
    return ThinPlate(DENSITY * thickness, RIGID_BALL * thickness**3 / 12)


def plate(thickness_mm: float) -> float:
    return sheet(thickness_mm).mobility_s_kg


def bodies(law: ForceLaw, mobility: float, mass: float = MASS, load: float = LOAD) -> Chain:
    return Chain(mass, mobility, contact_stiffness(law, load))


def track_law(height: np.ndarray, closed: bool = True, spacing: float = SPACING) -> ForceLaw:
    """Return the law of a smooth ball on a track of given heights, without contact filter."""
    flat = hertz_law(LOAD, RADIUS, RIGID_BALL)
    n = len(height)
    return ForceLaw(
        np.arange(n) * spacing,
        flat.load_n,
        flat.approach_m[:, :1] - height,
        n * spacing if closed else None,
    )


def waves(n: int, count: int, amplitude: float) -> np.ndarray:
    return amplitude * np.cos(2 * np.pi * count * np.arange(n) / n)


def noise(n: int, rms: float = 14e-9, shortest: float = 60e-6) -> np.ndarray:
    frequency = np.fft.rfftfreq(n, SPACING)
    lines = np.fft.rfft(np.random.default_rng(1).standard_normal(n))
    lines *= np.exp(-((frequency * shortest) ** 2))
    lines[0] = 0
    height = np.fft.irfft(lines, n)
    return rms / np.std(height) * height


def impact(modulus: float, mobility: float, speed: float = 0.1, steps: int = 400) -> BodyMotion:
    """Return the motion of a ball without a load that hits a plate."""
    law = hertz_law(LOAD, RADIUS, modulus)
    step = hertz_time(modulus, speed) / steps
    stepping = Stepping(time_step_s=step, start=(-1.5 * speed * step, speed))
    return move(law, bodies(law, mobility), 0.0, 0.0, 2.5 * steps * step, stepping)


def hertz_time(modulus: float, speed: float) -> float:
    return float(2.8683 * (MASS**2 / (RADIUS * modulus**2 * speed)) ** 0.2)


@pytest.mark.law(
    "Impact: without a plate it lasts 2.8683 (M^2/(R E*^2 v))^(1/5), and the ball keeps its speed."
)
def test_hertz_impact() -> None:
    motion = impact(BOTH_ELASTIC, 0.0)
    touching = np.count_nonzero(motion.force_n) * motion.time_step_s
    # The first and last steps are in contact for a part of their length.
    assert abs(touching - hertz_time(BOTH_ELASTIC, 0.1)) < 1.5 * motion.time_step_s
    assert -motion.velocity_m_s[-1] == pytest.approx(0.1, rel=1e-9)
    assert (motion.impacts, motion.settled) == (1, False)
    assert motion.energy_error < 1e-12


def zener(inelasticity: float) -> float:
    """Return the restitution of Zener's equation s'' + (1 + l d/dt) s^(3/2) = 0 by scipy."""

    def rate(_: float, state: np.ndarray) -> list[float]:
        root = np.sqrt(max(state[0], 0.0))
        speed = state[1]
        return [speed, -(root**3) - 1.5 * inelasticity * root * speed]

    def apart(_: float, state: np.ndarray) -> float:
        return float(state[0])

    apart.terminal = True  # type: ignore[attr-defined]
    apart.direction = -1  # type: ignore[attr-defined]
    solution = solve_ivp(rate, (0, 100), [0.0, 1.0], events=apart, rtol=1e-8, atol=1e-10)
    return -float(solution.y[1, -1])


@pytest.mark.law("Impact: the restitution on an infinite plate is Zener's.")
@pytest.mark.parametrize(
    ("modulus", "thickness", "restitution"),
    [
        (BOTH_ELASTIC, 20, 0.9894),
        (BOTH_ELASTIC, 10, 0.9585),
        (RIGID_BALL, 5, 0.8024),
        (RIGID_BALL, 3, 0.5492),
    ],
)
def test_restitution_on_a_plate(modulus: float, thickness: float, restitution: float) -> None:
    """Restitution agrees with Zener's equation, and with its value from an independent program."""
    mobility = plate(thickness)
    motion = impact(modulus, mobility)
    assert -motion.velocity_m_s[-1] / 0.1 == pytest.approx(restitution, rel=0.002)
    hertz = 4 / 3 * modulus * np.sqrt(RADIUS)
    inelasticity = mobility * MASS**0.6 * hertz**0.4 * 0.1**0.2
    assert -motion.velocity_m_s[-1] / 0.1 == pytest.approx(zener(inelasticity), rel=2e-5)
    assert motion.energy_error < 1e-12


WAVE = 64  # nodes


def phasor(motion: BodyMotion) -> complex:
    """Return the complex amplitude of the force on a track with one wave, of exp(i k x)."""
    return 2 * np.mean(motion.force_n * np.exp(-2j * np.pi * motion.position_m / (WAVE * SPACING)))


@pytest.mark.law("Ball on plate: a small wave of the track gives the force of the linear chain.")
@pytest.mark.parametrize("thickness", [1, 10])
@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 2.0])
def test_wave_gives_the_force_of_the_linear_chain(share: float, thickness: float) -> None:
    """Amplitude and phase agree below, at and above the resonance."""
    amplitude = 1e-10
    law = track_law(waves(WAVE, 1, amplitude))
    chain = Chain(MASS, plate(thickness), contact_stiffness(law, LOAD))
    frequency = share * chain.resonance_hz
    motion = move(
        law,
        chain,
        LOAD,
        frequency * WAVE * SPACING,
        stepping=Stepping(per_period=250, settled=1e-11),
    )
    expected = complex(chain.force(frequency, amplitude))
    assert abs(phasor(motion) / expected - 1) < 0.005
    assert motion.settled


@pytest.mark.law("Ball on plate: the steps err by the square of their length.")
def test_steps_are_of_second_order() -> None:
    law = track_law(waves(WAVE, 1, 1e-10))
    chain = Chain(MASS, plate(10), contact_stiffness(law, LOAD))
    frequency = 0.9 * chain.resonance_hz
    forces = [
        phasor(
            move(
                law,
                chain,
                LOAD,
                frequency * WAVE * SPACING,
                stepping=Stepping(per_period=n, settled=1e-11),
            )
        )
        for n in (72, 144)
    ]
    expected = complex(chain.force(frequency, 1e-10))
    coarse, fine = (abs(force / expected - 1) for force in forces)
    assert coarse / fine == pytest.approx(4, rel=0.1)


@pytest.mark.law("Ball on plate: the steps keep a sharp resonance in tune.")
@pytest.mark.parametrize("thickness", [10, 40])
def test_steps_keep_the_resonance_in_tune(thickness: float) -> None:
    """Steps that detune by 0.2 % are off by -22 dB; the force that they miss is 0.1 to 4 %."""
    law = track_law(noise(2500, rms=1e-9))
    forces = []
    for per_period in (40, 480):
        stepping = Stepping(per_period=per_period)
        motion = move(law, bodies(law, plate(thickness)), LOAD, 0.7, stepping=stepping)
        lines = np.fft.rfft(motion.force_n)[1:150] / len(motion.force_n)
        # The force belongs to the middle of its step.
        lines *= np.exp(-1j * np.pi * np.arange(1, 150) / len(motion.force_n))
        forces.append(lines)
    coarse, fine = forces
    assert np.linalg.norm(coarse - fine) < 0.01 * np.linalg.norm(fine)  # -40 dB


@pytest.mark.law("Ball on plate: a massless ball presses with its load alone.")
def test_massless_ball() -> None:
    law = track_law(waves(WAVE, 1, 1e-10))
    chain = bodies(law, plate(10), 1e-4 * MASS)
    motion = move(law, chain, LOAD, 1.0)
    stiff = chain.stiffness_n_m * 1e-10
    assert abs(phasor(motion)) < 1e-4 * stiff
    assert abs(phasor(motion)) == pytest.approx(
        abs(chain.force(1.0 / (WAVE * SPACING), 1e-10)), rel=0.01
    )


@pytest.mark.law("Ball on plate: a ball of great mass on a rigid plate rides level, F = W + k r.")
def test_heavy_ball_on_a_rigid_plate() -> None:
    law = track_law(waves(WAVE, 1, 1e-11))
    motion = move(law, bodies(law, 0.0, 1e3), LOAD, 1.0)
    stiff = contact_stiffness(law, LOAD)
    assert phasor(motion) == pytest.approx(stiff * 1e-11, rel=1e-3)
    assert np.ptp(motion.displacement_m) < 1e-3 * 1e-11


@pytest.mark.law("Ball on plate: the force of a slow wave is proportional to the ball's density.")
def test_density_of_the_ball() -> None:
    """Below the resonance and below 1/(2 pi M Y) the level follows 20 lg of the density."""
    law = track_law(waves(WAVE, 1, 1e-10))
    light, steel = (
        phasor(move(law, bodies(law, plate(10), sphere_mass(RADIUS, density)), LOAD, 0.05))
        for density in (3200.0, DENSITY)
    )
    assert 20 * np.log10(abs(steel / light)) == pytest.approx(
        20 * np.log10(DENSITY / 3200.0), abs=0.02
    )


ROUGH = noise(2500)


@pytest.mark.law("Ball on plate: load, track and loss together change the kinetic energy and U.")
def test_energy_balance_on_a_rough_track() -> None:
    """The balance of the scheme closes to rounding; that of the equations in their integrals.

    The integrals are sums over the record, so they close with the square of the time step.
    """
    law = track_law(ROUGH)
    mobility = plate(10)
    speed = 1.0
    errors = []
    for per_period in (100, 200):
        motion = move(law, bodies(law, mobility), LOAD, speed, stepping=Stepping(per_period))
        assert motion.energy_error < 1e-10
        slope = track_work(law, motion.position_m, motion.approach_m)
        track = speed * slope.sum() * motion.time_step_s
        loss = mobility * np.sum((motion.force_n - LOAD) ** 2) * motion.time_step_s
        errors.append(abs(track / loss - 1))  # over a settled lap nothing else changes
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.3)


@pytest.mark.law("Ball on plate: the third lap equals the second.")
def test_third_lap_equals_the_second() -> None:
    """The transient has 5 ms, eight decay times of the ball on 10 mm, before the second lap."""
    law = track_law(noise(5000))
    start = (float(law.approach(0.0, LOAD)), 0.0)
    motion = move(law, bodies(law, plate(10)), LOAD, 1.0, 0.03, Stepping(start=start))
    laps = motion.force_n.reshape(3, -1)
    assert np.abs(laps[2] - laps[1]).max() < 1e-5
    assert np.abs(laps[1] - laps[0]).max() > 1e-2


@pytest.mark.law("Ball on plate: a hundred thousand steps do not drift.")
def test_many_steps_do_not_drift() -> None:
    law = track_law(ROUGH)
    lap = move(law, bodies(law, plate(10)), LOAD, 1.0)
    count = -(-100_000 // len(lap.force_n))
    motion = move(law, bodies(law, plate(10)), LOAD, 1.0, count * 5e-3)
    last = motion.force_n[-len(lap.force_n) :]
    assert len(motion.force_n) >= 100_000
    assert np.abs(last - lap.force_n).max() < 1e-5
    assert motion.energy_error < 1e-9


@pytest.mark.law("Ball on plate: flights and impacts on a wavy track keep the energy balance.")
@pytest.mark.parametrize("thickness", [5, 10])
def test_flight_and_impact(thickness: float) -> None:
    law = track_law(waves(WAVE, 1, 5e-7))
    motion = move(law, bodies(law, plate(thickness)), LOAD, 2.5, 0.01)
    assert 0.1 < motion.flight_share < 0.9
    assert motion.impacts > 5
    assert motion.outside_share > motion.flight_share
    assert motion.energy_error < 1e-9
    assert motion.force_n.min() == 0.0
    assert np.mean(motion.force_n) == pytest.approx(LOAD, rel=0.02)  # nothing else holds the ball


def test_a_flight_over_laps_is_not_settled() -> None:
    """Two laps without contact are alike, but they do not repeat."""
    law = track_law(waves(WAVE, 1, 5e-7))
    motion = move(law, bodies(law, plate(10), load=0.2), 0.2, 1.0)
    assert motion.flight_share == 1 and not motion.settled


@pytest.mark.law("Ball on plate: a sharp resonance settles on a short lap, to the linear chain.")
def test_a_sharp_resonance_settles() -> None:
    """A quality of 1500 takes thousands of laps; fewer leave the resonance too low."""
    law = track_law(waves(WAVE, 1, 1e-11))
    stiff = contact_stiffness(law, LOAD)
    chain = Chain(MASS, 1 / (1500 * np.sqrt(MASS * stiff)), stiff)
    assert chain.quality == pytest.approx(1500)
    frequency = 1.004 * chain.resonance_hz
    motion = move(law, chain, LOAD, frequency * WAVE * SPACING)
    assert motion.settled and motion.laps > 400
    assert abs(phasor(motion)) == pytest.approx(abs(chain.force(frequency, 1e-11)), rel=0.03)


@pytest.mark.law("Ball on plate: a travel at constant speed is the motion at that speed.")
def test_travel_at_constant_speed() -> None:
    law = track_law(ROUGH)
    speed = 0.7
    steady = move(law, bodies(law, plate(5)), LOAD, speed)
    time = np.linspace(0, 2.0 * 5e-3 / speed, 40)
    travel = move(law, bodies(law, plate(5)), LOAD, TabulatedTravel(time, speed * time), time[-1])
    assert np.abs(travel.force_n.reshape(2, -1) - steady.force_n).max() < 1e-5


def test_open_track_ends() -> None:
    law = track_law(ROUGH, closed=False)
    motion = move(law, bodies(law, plate(10)), LOAD, 1.0, 2499 * SPACING)
    assert motion.transient_s > 0 and not motion.settled
    assert motion.position_m[-1] < law.position_m[-1]
    with pytest.raises(ValueError, match="the ball leaves the track"):
        move(law, bodies(law, plate(10)), LOAD, 1.0, 0.006)
