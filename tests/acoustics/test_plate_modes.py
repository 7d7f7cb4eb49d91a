"""Modes of plates with free and clamped edges agree with published and with other computed ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

from acoustics.plate_modes import Pair, plate_modes
from acoustics.radiation import legendre
from acoustics.rectangular_plate import RectangularPlate
from acoustics.ritz_plate import RitzPlate

FREE = ("free", "free")
CLAMPED = ("clamped", "clamped")
SIMPLE = ("simply_supported", "simply_supported")
MIXED = ("free", "clamped")
SIDES = {"length_m": 0.2, "width_m": 0.15}


def steel(edges: Pair, thickness_m: float = 2e-3, loss_factor: float = 0.01) -> RitzPlate:
    stiffness = 210e9 * thickness_m**3 / 12 / 0.91
    return RitzPlate(
        7850 * thickness_m, stiffness, loss_factor, **SIDES, poissons_ratio=0.3, edges=edges
    )


@pytest.mark.law("Modes of plates: converged natural frequencies of squares and of an oblong.")
@pytest.mark.parametrize(
    ("ratio", "edges", "numbers"),
    [
        (1.0, FREE, [13.468, 19.596, 24.270, 34.801, 34.801, 61.093, 61.093, 63.686]),
        (1.5, FREE, [20.096, 21.413, 46.347, 49.910, 57.713, 67.030]),
        (1.0, CLAMPED, [35.985, 73.394, 73.394, 108.217, 131.581, 132.205]),
        (1.0, SIMPLE, [19.739, 49.348, 49.348, 78.957]),
    ],
)
def test_converged_frequencies(ratio: float, edges: Pair, numbers: list[float]) -> None:
    """Omega = w a^2 sqrt(m''/B) over the longer side a, at a Poisson's ratio of 0.3.

    Leissa's table of 1973 lies up to 1 % above these for free edges.
    """
    modes = plate_modes(ratio, edges, 0.3, 140.0)
    bending = modes.numbers[modes.rigid :] * ratio
    assert bending[: len(numbers)] == pytest.approx(numbers, abs=6e-4)


@pytest.mark.law("Modes of plates: three motions of a free plate bend nothing.")
@pytest.mark.parametrize(("edges", "count"), [(FREE, 3), (CLAMPED, 0), (MIXED, 0), (SIMPLE, 0)])
def test_rigid_bodies(edges: Pair, count: int) -> None:
    assert plate_modes(1.3, edges, 0.3, 60.0).rigid == count


def other_basis(kind: str, x: np.ndarray) -> np.ndarray:
    """Return functions of another kind with two derivatives, (3, functions, points)."""
    rows = []
    if kind == "clamped":  # cosines whose differences vanish with their slopes
        for i in range(1, 24):
            low, high = (i - 1) * np.pi / 2, (i + 1) * np.pi / 2
            row = [
                low**p * np.cos(low * (x + 1) + p * np.pi / 2)
                - high**p * np.cos(high * (x + 1) + p * np.pi / 2)
                for p in range(3)
            ]
            rows.append(row)
        return np.array(rows).transpose(1, 0, 2)
    for i in range(14):  # free: cosines, and polynomials for what these lack at the ends
        wave = i * np.pi / 2
        rows.append([wave**p * np.cos(wave * (x + 1) + p * np.pi / 2) for p in range(3)])
    for power in (1, 2, 3, 4):
        polynomial = np.polynomial.Polynomial.basis(power)
        rows.append([polynomial(x), polynomial.deriv(1)(x), polynomial.deriv(2)(x)])
    return np.array(rows).transpose(1, 0, 2)


def other_numbers(ratio: float, edges: Pair, poisson: float) -> np.ndarray:
    """Return the numbers of modes by cosines and polynomials, with full mass matrices."""
    nodes, weights = legendre(60)
    lengths = np.sqrt(ratio), 1 / np.sqrt(ratio)
    sides = []
    for kind, length in zip(edges, lengths, strict=True):
        rows = [row * (2 / length) ** p for p, row in enumerate(other_basis(kind, nodes))]
        sides.append([[length / 2 * (a * weights) @ b.T for b in rows] for a in rows])
    x, y = sides
    mass = np.kron(x[0][0], y[0][0])
    energy = np.kron(x[2][2], y[0][0]) + np.kron(x[0][0], y[2][2])
    energy += poisson * (np.kron(x[0][2], y[2][0]) + np.kron(x[2][0], y[0][2]))
    energy += 2 * (1 - poisson) * np.kron(x[1][1], y[1][1])
    scale = 1 / np.sqrt(np.diag(mass))
    values, vectors = eigh(mass * scale * scale[:, None])
    kept = values > 1e-9  # cosines and polynomials are nearly dependent
    basis = scale[:, None] * vectors[:, kept] / np.sqrt(values[kept])
    return np.sqrt(np.maximum(eigh(basis.T @ energy @ basis, eigvals_only=True), 0))


@pytest.mark.law("Modes of plates: another basis finds the same natural frequencies.")
@pytest.mark.parametrize("edges", [FREE, CLAMPED, MIXED, MIXED[::-1]])
def test_another_basis(edges: Pair) -> None:
    """Cosines and polynomials, 18 to 23 along each side: the first 40 modes within 0.5 %."""
    modes = plate_modes(1.4, edges, 0.22, 900.0)
    bending = slice(modes.rigid, modes.rigid + 40)
    other = other_numbers(1.4, edges, 0.22)
    assert modes.numbers[bending] == pytest.approx(other[bending], rel=5e-3)


@pytest.mark.law("Modes of plates: shapes are orthogonal, with a mean square of 1/4.")
@pytest.mark.parametrize("edges", [FREE, CLAMPED, MIXED])
def test_orthogonal_shapes(edges: Pair) -> None:
    nodes, weights = legendre(40)
    modes = plate_modes(1.4, edges, 0.3, 600.0)
    x, y = np.meshgrid(nodes, nodes, indexing="ij")
    shapes = modes.shapes(x.ravel(), y.ravel())
    products = (shapes.T * np.outer(weights, weights).ravel() / 4) @ shapes
    assert products == pytest.approx(np.eye(len(products)) / 4, abs=1e-9)


def test_clamped_edges_stay_at_rest() -> None:
    modes = plate_modes(1.4, ("clamped", "free"), 0.3, 600.0)
    near = 1e-4
    along = np.array([-1.0, -1.0 + near, 1.0])
    shapes = modes.shapes(along, np.array([0.3, 0.3, 0.3]))
    assert np.abs(shapes[[0, 2]]).max() == 0
    assert np.abs(shapes[1]).max() < 1e4 * near**2  # neither displacement nor slope


@pytest.mark.law("Plate with computed modes: simply supported, it is the closed form.")
def test_simply_supported_is_the_closed_form() -> None:
    """Two programs of shapes and radiation: frequencies, loss by sound, pressure and power."""
    ritz = steel(SIMPLE)
    own = vars(steel(SIMPLE)) | {}
    own.pop("poissons_ratio")
    own.pop("edges")
    closed = RectangularPlate(**own)
    assert ritz.angular_frequency == pytest.approx(closed.angular_frequency, rel=1e-5)
    assert ritz.loss_factors == pytest.approx(closed.loss_factors, rel=0.02)
    frequency = np.geomspace(100, 20e3, 80)
    contact = [0.086, 0.055]
    powers = [plate.power_per_force(frequency, contact) for plate in (ritz, closed)]
    assert 10 * np.log10(powers[0] / powers[1]) == pytest.approx(np.zeros(80), abs=0.02)
    listener = (0.15, 0.05, 0.4)
    pressures = [plate.pressure_transfer(frequency, contact, listener) for plate in (ritz, closed)]
    assert np.abs(pressures[0] / pressures[1] - 1).max() < 2e-3


@pytest.mark.law("Sound of a plate with edges: power fed in is lost or radiated, for each kind.")
@pytest.mark.parametrize("edges", [FREE, CLAMPED, MIXED])
@pytest.mark.parametrize("loss_factor", [0.01, 1e-4])
def test_power_in_is_power_radiated_and_lost(edges: Pair, loss_factor: float) -> None:
    """As for simply supported plates: 5 % are left between the losses at and off resonances."""
    plate = steel(edges, 8e-3, loss_factor)
    contact = [0.086, 0.055]
    frequency = np.linspace(2500, 6500, 4000 if loss_factor > 1e-3 else 30_000)
    w = 2 * np.pi * frequency[:, None]
    shapes = plate.shapes(contact)[0]
    receptance = plate.mode_receptance(frequency)
    fed = np.sum(np.real(1j * w[:, 0] * (receptance @ np.square(shapes))))
    velocities = w * np.abs(receptance) * shapes
    rates = plate.loss_factor * plate.angular_frequency * plate.modal_mass_kg
    rates[: plate.rigid_modes] = (
        plate.loss_factors * plate.angular_frequency * plate.modal_mass_kg
    )[: plate.rigid_modes]
    lost = np.sum(np.square(velocities) @ rates)
    radiated = 2 * np.sum(plate.power_per_force(frequency, contact))
    assert lost + radiated == pytest.approx(fed, rel=0.05)


def test_many_points_of_a_path() -> None:
    """Shapes of a moving contact are interpolated between stations: 1e-3 of the largest."""
    plate = steel(MIXED)
    share = np.abs(np.linspace(-0.9, 1, 2000))[:, None]
    path = np.array([0.02, 0.13]) + share * np.array([0.15, -0.1])
    one_by_one = np.concatenate([plate.shapes(part) for part in np.array_split(path, 10)])
    assert plate.shapes(path) == pytest.approx(one_by_one, abs=2e-3)
