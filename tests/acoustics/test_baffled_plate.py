"""Sound of a simply supported plate in a baffle: far field, infinite plate, power, listeners."""

from __future__ import annotations

import math

import numpy as np
import pytest

from acoustics.radiation import AIR_KG_M3, SOUND_M_S, Ball, axis_transfer
from acoustics.rectangular_plate import (
    RectangularPlate,
    _integrals,
    mode_pressures,
    own_resistance,
)

EDGES = 0.4, 0.3
CONTACT = 0.172, 0.111


def steel(thickness_m: float, loss_factor: float = 0.01, scale: float = 1.0) -> RectangularPlate:
    stiffness = 210e9 * thickness_m**3 / 12 / (1 - 0.3**2)
    length = scale * EDGES[0]
    width = scale * EDGES[1]
    mass = 7850 * thickness_m
    return RectangularPlate(mass, stiffness, loss_factor, length_m=length, width_m=width)


@pytest.mark.law("Sound of a plate with edges: a mode's far field is Wallace's.")
@pytest.mark.parametrize("order", [(1, 1), (2, 3), (7, 4)])
@pytest.mark.parametrize("degrees", [0.0, 25.0, 70.0])
def test_far_field_of_a_mode(order: tuple[int, int], degrees: float) -> None:
    """Wallace's closed form, JASA 51 (1972) 946, at 3 km: paths differ by 1e-5 m.

    At 0 degrees even orders cancel, so the tolerance is 3e-3 of the largest possible integral.
    """
    f = 3000.0
    r = 3000.0
    phi = math.radians(degrees)
    direction = np.array([math.sin(phi) * 0.8, math.sin(phi) * 0.6, math.cos(phi)])
    place = r * direction + (EDGES[0] / 2, EDGES[1] / 2, 0.0)
    table = mode_pressures(EDGES, np.array([order]), (place[0], place[1], place[2]))
    k = 2 * math.pi * f / SOUND_M_S
    integral = complex(table.at(np.array([f]))[0, 0]) * np.exp(-1j * k * table.distance_m)
    factors = []
    for m, edge, u in zip(order, EDGES, direction[:2], strict=True):
        phase = k * edge * u
        turn = (-1) ** m * np.exp(1j * phase) - 1
        factors.append(edge / (m * math.pi) * turn / ((phase / (m * math.pi)) ** 2 - 1))
    corner = math.dist(place, (0.0, 0.0, 0.0))
    wallace = np.exp(-1j * k * corner) / r * factors[0] * factors[1]
    largest = EDGES[0] * EDGES[1] * 4 / math.pi**2 / order[0] / order[1] / r
    assert abs(integral - wallace) < 3e-3 * largest


@pytest.mark.parametrize(
    "listener", [(0.17, 0.11, 1.0), (0.17, 0.11, 1e-3), (-0.3, 0.5, 0.02), (0.2, 0.1, -0.4)]
)
def test_the_integral_by_brute_force(listener: tuple[float, float, float]) -> None:
    """A midpoint rule of 0.2 mm that halves where a listener is near errs by less than 1 %."""
    f = 7123.0
    orders = np.array([(1, 1), (3, 2), (8, 9)])
    table = mode_pressures(EDGES, orders, listener)
    k = 2 * math.pi * f / SOUND_M_S
    values = table.at(np.array([f]))[0] * np.exp(-1j * k * table.distance_m)
    x, y = ((np.arange(round(edge / 2e-4)) + 0.5) * 2e-4 for edge in EDGES)
    distance = np.sqrt(
        np.square(x - listener[0])[:, None] + np.square(y - listener[1]) + listener[2] ** 2
    )
    green = np.exp(-1j * k * distance) / distance * 4e-8
    for value, (m, n) in zip(values, orders, strict=True):
        shape = np.sin(m * math.pi * x / EDGES[0]), np.sin(n * math.pi * y / EDGES[1])
        assert abs(value - shape[0] @ green @ shape[1]) < 0.01 * abs(value) + 1e-4


@pytest.mark.law(
    "Sound of a plate with edges: with strong damping it is that of an infinite plate."
)
def test_a_damped_large_plate_is_an_infinite_plate() -> None:
    """At a loss factor of 0.5 no wave returns from the edges of 0.6 x 0.45 m: 0.5 dB from 3 kHz."""
    plate = steel(0.5e-3, 0.5, 1.5)
    contact = 1.5 * CONTACT[0], 1.5 * CONTACT[1]
    pressure = plate.pressure_transfer(np.linspace(3e3, 19e3, 30), contact, (*contact, 1.0))
    infinite = -AIR_KG_M3 / (2 * math.pi * plate.mass_per_area_kg_m2)
    assert np.abs(20 * np.log10(np.abs(pressure / infinite))).max() < 0.5
    assert np.abs(np.angle(pressure / infinite)).max() < 0.06  # towards the ball's side


@pytest.mark.law(
    "Sound of a plate with edges: both sides, mirrored places and two points of force are alike."
)
def test_listeners_above_and_below_mirrored_and_reversed() -> None:
    """Baffle and plate are symmetric about their plane and about the middles of the edges."""
    plate = steel(3e-3)
    f = np.geomspace(30, 19e3, 50)
    above = plate.pressure_transfer(f, CONTACT, (0.25, 0.02, 0.7))
    assert np.allclose(-above, plate.pressure_transfer(f, CONTACT, (0.25, 0.02, -0.7)), rtol=1e-9)
    turned = EDGES[0] - CONTACT[0], CONTACT[1]
    mirrored = plate.pressure_transfer(f, turned, (EDGES[0] - 0.25, 0.02, 0.7))
    assert np.allclose(above, mirrored, rtol=0, atol=1e-9 * np.abs(above).max())


def test_the_power_of_a_mode_by_two_routes() -> None:
    """Power over wave numbers equals that of the pressure on the plate, 0.1 mm above it, to 1 %."""
    order = np.array([(2, 1)])
    f = 2500.0
    nodes, weights = np.polynomial.legendre.leggauss(8)
    power = 0.0
    for u, wu in zip(nodes, weights, strict=True):
        for v, wv in zip(nodes, weights, strict=True):
            x = EDGES[0] * (u + 1) / 2
            y = EDGES[1] * (v + 1) / 2
            integral = _integrals(EDGES, order, (x, y, 1e-4), 0.0, f)[0]
            pressure = 1j * AIR_KG_M3 * f * integral  # of a velocity of 1 m/s
            shape = math.sin(2 * math.pi * x / EDGES[0]) * math.sin(math.pi * y / EDGES[1])
            power += float(pressure.real) * shape * wu * wv * EDGES[0] * EDGES[1] / 4
    assert own_resistance(EDGES, order, np.array([f]))[0] == pytest.approx(power, rel=0.01)


@pytest.mark.law("Sound of a plate with edges: power fed in is lost or radiated.")
@pytest.mark.parametrize(("thickness", "loss_factor"), [(1e-3, 0.01), (10e-3, 1e-4)])
def test_power_in_is_power_radiated_and_lost(thickness: float, loss_factor: float) -> None:
    """Both sides radiate; the loss by sound is that at resonances, which leaves 5 % between them.

    At a loss factor of 1e-4 the plate of 10 mm radiates more than it loses.
    """
    plate = steel(thickness, loss_factor)
    f = np.linspace(1000, 3000, 3000 if loss_factor > 1e-3 else 20_000)
    w = 2 * math.pi * f[:, None]
    shapes = plate.shapes(CONTACT)[0]
    receptance = plate.mode_receptance(f)
    fed = np.sum(np.real(1j * w[:, 0] * (receptance @ np.square(shapes))))
    velocities = w * np.abs(receptance) * shapes
    rates = plate.loss_factor * plate.angular_frequency * plate.modal_mass_kg
    lost = np.sum(np.square(velocities) @ rates)
    radiated = 2 * np.sum(plate.power_per_force(f, CONTACT))
    assert lost + radiated == pytest.approx(fed, rel=0.05)
    assert (radiated > lost) == (loss_factor < 1e-3)


@pytest.mark.law(
    "Sound of a plate with edges: the pressure over a far half sphere carries the power."
)
def test_far_pressure_carries_the_power() -> None:
    """The mean square at 2000 plate lengths, over a half sphere, is that of the modes: 0.5 dB.

    Cross terms of modes, which the power leaves out, are small for a loss factor of 0.01.
    """
    plate = steel(10e-3, scale=0.5)
    r = 400.0
    contact = (0.086, 0.055)
    f = np.linspace(2000, 4000, 100)
    u, w = np.polynomial.legendre.leggauss(8)
    power = np.zeros(len(f))
    for cosine, weight in zip((u + 1) / 2, w / 2, strict=True):
        for phi in 2 * math.pi * (np.arange(10) + 0.5) / 10:
            sine = math.sqrt(1 - cosine**2)
            x = r * sine * math.cos(phi) + 0.1
            y = r * sine * math.sin(phi) + 0.075
            pressure = plate.pressure_transfer(f, contact, (x, y, r * cosine))
            power += weight / 10 * np.square(np.abs(pressure))
    power *= 2 * math.pi * r**2 / (AIR_KG_M3 * SOUND_M_S)
    ratio = power.sum() / plate.power_per_force(f, contact).sum()
    assert 10 * math.log10(ratio) == pytest.approx(0, abs=0.5)


def test_a_small_ball_off_its_axis_is_a_dipole_and_its_image() -> None:
    """A dipole along the axis and its near image: together the square of a cosine."""
    ball = Ball(1e-3, 7850)
    on, off = (axis_transfer([1000.0], ball, 1.0, cosine)[0] for cosine in (1.0, 0.5))
    assert off / on == pytest.approx(0.25, rel=1e-3)


@pytest.mark.parametrize("scale", [0.02, 0.05])
def test_tiny_plates_stay_finite(scale: float) -> None:
    """A plate without a mode below 30 kHz is silent, and one with a single mode is not."""
    plate = steel(10e-3 if scale < 0.03 else 1e-3, 1e-4, scale)
    contact = 0.4 * plate.length_m, 0.4 * plate.width_m
    pressure = plate.pressure_transfer([100.0, 10e3], contact, (0.0, 0.0, 1.0))
    assert np.isfinite(pressure).all()
    assert bool(np.any(pressure)) == (len(plate.angular_frequency) > 0)
    assert np.isfinite(plate.power_per_force([100.0, 10e3], contact)).all()
