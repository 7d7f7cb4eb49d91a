"""A bearing in a housing plate: the force is that of both as one linear system."""

import numpy as np
import pytest

from acoustics import wav
from acoustics.rectangular_plate import RectangularPlate
from rolling.bearing_kind.housing import housing_sound, plate_mobility

MASS_KG = 0.06
STIFFNESS_N_M = 5e7
CONTACT = np.array([0.12, 0.07])
RATE = wav.SAMPLE_RATE_HZ


def plate(thickness_m: float) -> RectangularPlate:
    stiffness = 210e9 * thickness_m**3 / (12 * (1 - 0.3**2))
    return RectangularPlate(7850 * thickness_m, stiffness, 0.02, length_m=0.3, width_m=0.2)


def ring_mobility(frequency: np.ndarray) -> np.ndarray:
    omega = 2 * np.pi * frequency
    return 1j * omega / (STIFFNESS_N_M * (1 + 0.02j) - MASS_KG * omega**2)


def tone(frequency: float) -> np.ndarray:
    return 1e-5 * np.sin(2 * np.pi * frequency * np.arange(RATE) / RATE)


def middle_rms(record: np.ndarray) -> float:
    """Return the rms of the middle, which is 0.7 % high: it makes up for the fades at the ends."""
    return float(np.sqrt(np.mean(np.square(record[RATE // 3 : 2 * RATE // 3]))))


@pytest.mark.law("Housing: ring and plate move as one system of mass, springs and modes.")
@pytest.mark.parametrize("frequency", [150.0, 1000.0, 4300.0])
@pytest.mark.parametrize("thickness_m", [0.003, 0.012])
def test_the_force_is_that_of_ring_and_plate_joined(frequency: float, thickness_m: float) -> None:
    sheet = plate(thickness_m)
    free = tone(frequency)
    sound = housing_sound(sheet, CONTACT, (0.12, 0.07, 1.0), ring_mobility, free)
    # One system: springs of the balls shake ring and plate, which have one displacement x, so that
    # k (e - x) + M w^2 x = x / R, where e is the unevenness and R the receptance of the plate.
    omega = 2 * np.pi * frequency
    spring = STIFFNESS_N_M * (1 + 0.02j)
    receptance = plate_mobility(sheet, CONTACT, np.array([frequency]))[0] / (1j * omega)
    free_displacement = 1e-5 / np.sqrt(2) / omega
    unevenness = free_displacement * abs(spring - MASS_KG * omega**2) / abs(spring)
    moved = unevenness * abs(spring / (1 / receptance + spring - MASS_KG * omega**2))
    assert middle_rms(sound.velocity_m_s) == pytest.approx(omega * moved, rel=0.01)
    assert middle_rms(sound.force_n) == pytest.approx(moved / abs(receptance), rel=0.01)


def test_a_plate_that_hardly_moves_takes_the_blocked_force() -> None:
    sound = housing_sound(plate(0.5), CONTACT, (0.12, 0.07, 1.0), ring_mobility, tone(1000.0))
    blocked = 1e-5 / np.sqrt(2) / abs(ring_mobility(np.array([1000.0]))[0])
    assert middle_rms(sound.force_n) == pytest.approx(blocked, rel=0.02)


def test_the_level_grows_with_the_free_velocity() -> None:
    one = housing_sound(plate(0.003), CONTACT, (0.12, 0.07, 1.0), ring_mobility, tone(1000.0))
    two = housing_sound(plate(0.003), CONTACT, (0.12, 0.07, 1.0), ring_mobility, 2 * tone(1000.0))
    assert two.levels.laeq_db - one.levels.laeq_db == pytest.approx(6.02, abs=0.01)
