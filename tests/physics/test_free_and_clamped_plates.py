"""Plates with free and clamped edges move as infinite plates and the linear chain say."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import hertz_law, track_work
from test_ball_on_plate import (
    BOTH_ELASTIC,
    LOAD,
    MASS,
    RADIUS,
    hertz_time,
    noise,
    plate,
    sheet,
    track_law,
)
from test_plate_with_edges import POINT, SIDES, within_hearing

from acoustics.plate_modes import Pair
from acoustics.ritz_plate import RitzPlate
from rolling.dynamics.bodies import Chain, contact_stiffness, modes_of
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.motion import Stepping, at_rest, move

FREE = ("free", "free")
CLAMPED = ("clamped", "clamped")
MIXED = ("free", "clamped")
KINDS = [FREE, CLAMPED, MIXED]


def rectangle(
    thickness_mm: float, edges: Pair, sides: tuple[float, float] = SIDES, loss_factor: float = 0.01
) -> RitzPlate:
    bending = vars(sheet(thickness_mm)) | {"loss_factor": loss_factor}
    length, width = sides
    return RitzPlate(**bending, length_m=length, width_m=width, poissons_ratio=0.3, edges=edges)


def bodies(
    law: ForceLaw, thickness_mm: float, edges: Pair, sides: tuple[float, float] = SIDES
) -> Chain:
    own = rectangle(thickness_mm, edges, sides)
    modes = modes_of(own, np.array([[0.43, 0.37]]) * sides)
    return Chain(MASS, plate(thickness_mm), contact_stiffness(law, LOAD), modes)


@pytest.mark.law("Free and clamped plates: the mean mobility is an infinite plate's.")
@pytest.mark.parametrize("edges", KINDS)
def test_mean_mobility(edges: Pair) -> None:
    """Third octaves of ten modes or more, as a mean over 40 points: within 0.5 dB."""
    points = POINT * np.linspace(0.4, 1.8, 40)[:, None]
    modes = modes_of(rectangle(2, edges), points)
    for centre in 2.5e3 * 2 ** (np.arange(1, 10) / 3):
        band = centre * 2 ** np.linspace(-1 / 6, 1 / 6, 2000)
        mobility = 2j * np.pi * band * modes.receptance(band)
        assert 10 * np.log10(mobility.real.mean() / plate(2)) == pytest.approx(0, abs=0.5)


@pytest.mark.slow
@pytest.mark.law("Free and clamped plates: until a reflection returns, the restitution is Zener's.")
@pytest.mark.parametrize("edges", KINDS)
@pytest.mark.parametrize(
    ("thickness", "side", "restitution"),
    [(5, 0.7, 0.8458), (3, 0.5, 0.6333)],
)
def test_restitution(edges: Pair, thickness: float, side: float, restitution: float) -> None:
    step = hertz_time(BOTH_ELASTIC, 0.1) / 300
    stepping = Stepping(time_step_s=step, start=(-1.5e-1 * step, 0.1))
    law = hertz_law(LOAD, RADIUS, BOTH_ELASTIC)
    chain = bodies(law, thickness, edges, (side, side))
    motion = move(law, chain, 0.0, 0.0, 750 * step, stepping)
    assert -motion.velocity_m_s[-1] / 0.1 == pytest.approx(restitution, abs=0.008)
    assert motion.energy_error < 1e-9


@pytest.mark.law("Plate with edges: a lap gives the force of the linear chain, and its power.")
@pytest.mark.parametrize("edges", KINDS)
def test_linear_chain_and_power(edges: Pair) -> None:
    """The power of the track is the power lost in the modes, 1 % with 100 steps a period."""
    law = track_law(noise(2500, rms=5e-10))
    own = bodies(law, 5, edges)
    motion = move(law, own, LOAD, 0.5, stepping=Stepping(100))
    assert motion.settled and motion.energy_error < 1e-9
    frequency, lines = within_hearing(motion)
    approach = np.fft.rfft(law.approach(law.position_m, LOAD)) * 2 / 2500
    order = np.round(frequency * law.period_m / 0.5).astype(int)
    expected = own.force(frequency, -approach[order])
    assert np.linalg.norm(lines - expected) < 0.02 * np.linalg.norm(expected)
    slope = track_work(law, motion.position_m, motion.approach_m)
    lost = np.sum(np.square(np.abs(lines)) / 2 * own.mobilities(frequency)["plate"].real)
    assert 0.5 * slope.mean() == pytest.approx(lost, rel=0.01)


@pytest.mark.law("Plate with edges: a free plate is pushed away as a mass.")
def test_a_free_plate_is_a_mass() -> None:
    """Far below its first mode, and far above its soft support, it has the mass of a rigid body."""
    own = rectangle(10, FREE)
    centre = np.array([[0.5, 0.5]]) * SIDES
    frequency = np.array([25.0, 40.0])
    receptance = modes_of(own, centre).receptance(frequency)
    mass = own.mass_per_area_kg_m2 * SIDES[0] * SIDES[1]
    bending = modes_of(own, centre).compliance_m_n
    expected = bending - 1 / (mass * np.square(2 * np.pi * frequency))
    assert receptance.real == pytest.approx(expected, rel=0.03)


def test_shapes_along_a_path() -> None:
    """Cubics between stations of a path leave 0.2 % of the largest shape."""
    own = rectangle(3, MIXED)
    begin, end = np.array([[0.05, 0.08], [0.21, 0.3]])
    path = begin + np.linspace(0, 1, 17)[:, None] * (end - begin)
    stepped = Chain(MASS, 0.0, 1e-20, modes_of(own, path)).steps(1e-6)
    for share in (0.0, 0.123, 0.5, 0.987, 1.0):
        point = (begin + share * (end - begin))[None]
        shape = at_rest(stepped, point, 0.0, 0.0, 1.0).modes[0] / stepped.reach
        assert shape[: own.mode_count] == pytest.approx(own.shapes(point)[0], abs=4e-3)
        assert np.all(shape[own.mode_count :] == 1)


@pytest.mark.law("Plate with edges: moving contacts keep the energy balance, free edges too.")
def test_energy_of_a_moving_contact() -> None:
    law = track_law(noise(500, rms=1e-7))
    begin, end = np.array([[0.05, 0.08], [0.21, 0.3]])
    path = begin + np.linspace(0, 1, 17)[:, None] * (end - begin)
    chain = Chain(MASS, plate(3), contact_stiffness(law, LOAD), modes_of(rectangle(3, FREE), path))
    motion = move(
        law,
        chain,
        LOAD,
        1.0,
        0.01,
        Stepping(start=(float(law.approach(0.0, LOAD)), 0.0)),
        lambda time: begin + 20 * np.asarray(time)[:, None] * (end - begin),
    )
    assert motion.energy_error < 1e-9
