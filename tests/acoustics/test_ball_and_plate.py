"""Force on a ball and a plate becomes sound by closed forms, and power is never created."""

import numpy as np
import pytest

from acoustics.bands import BAND_NAMES, BANDWIDTH_HZ
from acoustics.radiation import (
    AIR_KG_M3,
    SOUND_M_S,
    Ball,
    HalfSpaceBody,
    ThinPlate,
    axis_transfer,
    pressure_on_axis,
)
from acoustics.sound_power import ball_power_per_force, band_power, plate_power_per_force

RATE = 48000
TIME = np.arange(4800) / RATE
STEEL = Ball(5e-3, 7850.0)


def steel(thickness_mm: float, loss_factor: float = 0.0) -> ThinPlate:
    h = thickness_mm * 1e-3
    return ThinPlate(7850 * h, 206e9 * h**3 / (12 * (1 - 0.3**2)), loss_factor)


def base_power(plate: ThinPlate) -> float:
    return AIR_KG_M3 / (2 * np.pi * SOUND_M_S * plate.mass_per_area_kg_m2**2)


def heard(force, *sources, distance=1.0):
    return pressure_on_axis(force, RATE, sources, distance)


def tone(frequency: float, phase: float = 0.0) -> np.ndarray:
    return np.cos(2 * np.pi * frequency * TIME + phase)


@pytest.mark.law(
    "Radiation: on the axis of a plate the pressure is -rho F / (2 pi r m''), without a derivative."
)
@pytest.mark.parametrize(("thickness", "mpa"), [(1, 24.4), (10, 2.44)])
def test_plate_pressure_of_a_sine_force(thickness, mpa):
    pressure = heard(tone(3000), steel(thickness))
    np.testing.assert_allclose(pressure, -1e-3 * mpa * tone(3000), rtol=2e-3, atol=1e-9)
    half = heard(tone(3000), steel(thickness), distance=2.0)
    np.testing.assert_allclose(half, pressure / 2)


@pytest.mark.law("Radiation: an oscillating ball and its image give the pressure of two dipoles.")
@pytest.mark.parametrize(("frequency", "mpa"), [(1000, 0.0613), (10000, 4.90)])
def test_ball_pressure_of_a_sine_force(frequency, mpa):
    pressure = heard(tone(frequency), STEEL)
    assert np.max(np.abs(pressure)) == pytest.approx(1e-3 * mpa, rel=5e-3)
    # A small ball: the derivative twice, once for the dipole and once for its image 2a below.
    w = 2 * np.pi * 100
    ka = 2 * np.pi * 100 * 5e-3 / SOUND_M_S
    slow = heard(tone(100), STEEL)
    dipole = 3 * AIR_KG_M3 / (8 * np.pi * 7850 * SOUND_M_S) * w
    np.testing.assert_allclose(slow, -dipole * 2 * ka * tone(100), atol=1e-4 * dipole * ka)


def test_half_space_pressure_of_a_sine_force():
    body = HalfSpaceBody(7850.0, 5900.0)
    pressure = heard(tone(5000), body, distance=2.0)
    factor = 2 * np.pi * 5000 * AIR_KG_M3 / (2 * np.pi * 2.0 * 7850 * 5900)
    np.testing.assert_allclose(pressure, factor * tone(5000, -np.pi / 2), atol=1e-9 * factor)


@pytest.mark.law("Radiation: far below coincidence a plate radiates rho F^2 / (2 pi c m''^2).")
@pytest.mark.parametrize(("thickness", "level"), [(1, 69.6), (3, 60.0), (10, 49.6)])
def test_plate_power_below_coincidence(thickness, level):
    plate = steel(thickness)
    assert 10 * np.log10(base_power(plate) / 1e-12) == pytest.approx(level, abs=0.05)
    shares = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    correction = 10 * np.log10(
        plate_power_per_force(shares * plate.critical_hz, plate) / base_power(plate)
    )
    # Without air loading, which subtracts 0.05 dB at a tenth and less above.
    np.testing.assert_allclose(correction, [0.05, 0.44, 1.37, 3.34, 8.90], atol=0.11)


@pytest.mark.law("Radiation: the directivity of a plate integrates to its power.")
def test_directivity_integrates_to_the_power():
    """The far pressure is that on the axis over 1 - (f/f_c)^2 sin^4; air loading is left out."""
    plate = steel(3)
    frequency = 0.6 * plate.critical_hz
    axis = abs(axis_transfer([frequency], plate, 1.0)[0])
    angle = np.linspace(0, np.pi / 2, 2001)
    pressure = axis / (1 - 0.36 * np.sin(angle) ** 4)
    intensity = pressure**2 / (AIR_KG_M3 * SOUND_M_S)
    power = np.trapezoid(2 * np.pi * np.sin(angle) * intensity, angle)
    assert plate_power_per_force([frequency], plate)[0] == pytest.approx(power, rel=0.015)


@pytest.mark.law("Radiation: above coincidence a plate radiates what it is fed less its loss.")
@pytest.mark.parametrize(
    ("sides", "shares"), [(1, [0.68, 0.33, 0.135, 0.07]), (2, [0.404, 0.249, 0.119, 0.064])]
)
def test_plate_power_above_coincidence(sides, shares):
    plate = steel(10, 1e-3)
    frequency = np.array([1.1, 2.0, 5.0, 10.0]) * plate.critical_hz
    power = plate_power_per_force(frequency, plate, sides) / plate.mobility_s_kg
    np.testing.assert_allclose(power, shares, rtol=0.03)


@pytest.mark.law("Radiation: a plate never radiates more than it is fed.")
@pytest.mark.parametrize("thickness", [1, 10])
@pytest.mark.parametrize("loss_factor", [0.0, 1e-5, 1e-2])
def test_power_never_exceeds_the_power_fed_in(thickness, loss_factor):
    plate = steel(thickness, loss_factor)
    near = 1 + np.concatenate(([0], np.geomspace(1e-6, 0.5, 100), -np.geomspace(1e-6, 0.5, 100)))
    frequency = np.concatenate((np.geomspace(20, 2e4, 300), near * plate.critical_hz))
    for sides in (1, 2):
        power = plate_power_per_force(frequency, plate, sides)
        assert np.all(power > 0)
        assert np.all(sides * power <= plate.mobility_s_kg * (1 + 1e-6))


@pytest.mark.law("Radiation: the image in the plane changes a ball's power by the known integral.")
def test_power_of_the_ball_over_a_plane():
    frequency = np.array([1e3, 2e3, 5e3, 10e3, 20e3])
    over, free = (ball_power_per_force(frequency, STEEL, plane) for plane in (True, False))
    np.testing.assert_allclose(
        10 * np.log10(over / free), [-20.0, -14.0, -6.2, -0.9, 2.4], atol=0.05
    )


@pytest.mark.law("Radiation: the power of a small ball is that of its pressure on all directions.")
def test_power_of_a_free_small_ball():
    w = 2 * np.pi * 500
    axis = 3 * AIR_KG_M3 / (8 * np.pi * 7850 * SOUND_M_S) * w  # cos(angle) off the axis
    power = axis**2 / (AIR_KG_M3 * SOUND_M_S) * 4 * np.pi / 3
    assert ball_power_per_force([500.0], STEEL, plane=False)[0] == pytest.approx(power, rel=1e-3)


def test_power_of_noise_is_the_sum_of_its_lines():
    force = np.random.default_rng(2).standard_normal(RATE)
    power = band_power(force, RATE, STEEL)
    band = BAND_NAMES.index("4000")
    expected = 2 * BANDWIDTH_HZ[band] / RATE * ball_power_per_force([4000.0], STEEL)[0]
    assert power[band] == pytest.approx(expected, rel=0.1)
