"""How much less does a free plate in the open radiate than the same plate in a baffle?

`python tests/benchmarks/unbaffled_study.py` solves the field of each of the lowest modes of a free
plate without a baffle, at several frequencies, and prints the decibels by which its power lies
below that in a baffle. The two sides of the plate differ by a pressure mu that vanishes beyond the
edges. With the wave number kz normal to the plate, the transforms of mu and of the velocity v are
related by v = kz mu / (2 w rho), so mu on the plate follows from v on it (Galerkin's method). mu
grows as the root of the distance from an edge: its functions are sqrt(1 - x^2) U_i(x), whose
transforms are pi (i + 1) J_(i+1)(q) / q.

The rigid translation at the lowest frequency has a check: a dipole of the force w m v with the
added mass m radiates (w m v k)^2 / (12 pi rho c), and m = 0.66 pi / 4 rho b^2 a for sides 4 to 3.
"""

from __future__ import annotations

import numpy as np
from scipy.special import eval_chebyu, jv

from acoustics.arrays import Array
from acoustics.radiation import AIR_KG_M3, SOUND_M_S
from acoustics.ritz_plate import RitzPlate

COUNT = 14  # functions of one parity along each side
HIGHEST = 240.0  # phase of the shortest waves over half a side
PANELS = 80
SIDES = (0.4, 0.3)


def side_functions(parity: int, edge: float) -> tuple[Array, Array, Array]:
    """Return wave numbers, weights, and the transforms of the functions of a parity."""
    u, w = np.polynomial.legendre.leggauss(8)
    ends = HIGHEST * np.linspace(0, 1, PANELS + 1) ** 1.5
    half = np.diff(ends)[:, None] / 2
    q = (ends[:-1, None] + half * (1 + u)).ravel()
    weights = (half * w).ravel()
    return 2 * q / edge, 2 * weights / edge, transforms(q, parity)


def transforms(q: Array, parity: int) -> Array:
    """Return the transforms of sqrt(1 - x^2) U_i of a parity at phases over half a side."""
    order = 2 * np.arange(COUNT)[:, None] + parity
    sign = (-1.0) ** np.arange(COUNT)[:, None]
    return np.asarray(sign * np.pi * (order + 1) * jv(order + 1, q) / q)


def radiated(
    jump: Array, parities: tuple[int, int], edges: tuple[float, float], k0: float
) -> Array:
    """Return the power of pressure jumps times w rho, by the waves longer than those of sound."""
    u, w = np.polynomial.legendre.leggauss(24)
    theta = np.pi / 4 * (u + 1)
    phi = theta
    k = k0 * np.sin(theta)
    weights = np.outer(w * k0**3 * np.cos(theta) ** 2 * np.sin(theta), w) * (np.pi / 4) ** 2
    area = edges[0] * edges[1] / 4
    x = transforms(np.outer(k, np.cos(phi)).ravel() * edges[0] / 2, parities[0])
    y = transforms(np.outer(k, np.sin(phi)).ravel() * edges[1] / 2, parities[1])
    waves = np.einsum("ip,jp->ijp", x, y).reshape(COUNT**2, -1)
    squares = np.square(np.abs(area * (jump.T @ waves)))
    return np.asarray(squares @ weights.ravel() / (2 * np.pi**2))


def projections(side, parity: int) -> Array:
    """Return integrals of sqrt(1 - x^2) U_i times the functions of a side of a plate."""
    n = 200
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    weights = np.pi / (n + 1) * np.sin(angle) ** 2  # of Gauss and Chebyshev, second kind
    order = 2 * np.arange(COUNT)[:, None] + parity
    return (eval_chebyu(order, np.cos(angle)) * weights) @ side.values(np.cos(angle))[0].T


def reductions(plate: RitzPlate, frequency_hz: float) -> Array:
    """Return the power in a baffle over that without [dB], for each mode at a frequency."""
    edges = (plate.length_m, plate.width_m)
    w = 2 * np.pi * frequency_hz
    k0 = w / SOUND_M_S
    baffled = 2 * plate.resistances(frequency_hz)
    free = np.zeros(plate.mode_count)
    area = edges[0] * edges[1] / 4
    for family in plate.modes.families:
        parities = family.along[0] % 2, family.across[0] % 2
        x, y = (side_functions(p, edge) for p, edge in zip(parities, edges, strict=True))
        square = k0**2 - np.square(x[0])[:, None] - np.square(y[0])
        kz = np.sqrt(np.maximum(square, 0)) - 1j * np.sqrt(np.maximum(-square, 0))
        kz = kz * x[1][:, None] * y[1] * area**2 / (2 * w * AIR_KG_M3 * np.pi**2)
        along = (x[2][:, None] * x[2]).reshape(COUNT**2, -1)
        across = (y[2][:, None] * y[2]).reshape(COUNT**2, -1)
        matrix = (along @ kz @ across.T).reshape(COUNT, COUNT, COUNT, COUNT)
        matrix = matrix.transpose(0, 2, 1, 3).reshape(COUNT**2, COUNT**2)
        own = [projections(side, p) for side, p in zip(plate.modes.sides, parities, strict=True)]
        velocity = area * np.einsum(
            "im,mnk,jn->ijk",
            own[0][:, family.along],
            family.coefficients,
            own[1][:, family.across],
            optimize=True,
        ).reshape(COUNT**2, -1)
        jump = np.linalg.solve(matrix, velocity)
        parity_pair = (int(parities[0]), int(parities[1]))
        free[family.modes] = radiated(jump, parity_pair, edges, k0) / (w * AIR_KG_M3)
    return np.asarray(10 * np.log10(baffled / np.maximum(free, 1e-30)))


def main() -> None:
    """Print the reductions as means over modes of similar frequency."""
    thickness = 10e-3
    plate = RitzPlate(
        7850 * thickness,
        210e9 * thickness**3 / 12 / 0.91,
        0.01,
        length_m=SIDES[0],
        width_m=SIDES[1],
        poissons_ratio=0.3,
        edges=("free", "free"),
    )
    critical = plate.critical_hz
    root = np.sqrt(SIDES[0] * SIDES[1])
    bending = np.sqrt(plate.modes.numbers) / root  # wave number of each mode
    print(
        "root of area over wavelength of sound, modes by k / k_b: reduction in dB, mean and range"
    )
    print(f"{plate.mode_count} modes, coincidence {critical:.0f} Hz")
    for size in (0.05, 0.1, 0.2, 0.4, 0.8, 1.6):
        k0 = 2 * np.pi * size / root
        found = reductions(plate, k0 * SOUND_M_S / (2 * np.pi))
        cells = []
        for low, high in ((0.05, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 1.25), (1.25, 4.0)):
            ratio = k0 / np.maximum(bending, 1e-9)
            inside = (ratio >= low) & (ratio < high) & (bending * SIDES[0] / 2 < 18)
            if inside.any():
                own = found[inside]
                span = f"{own.min():.1f} to {own.max():.1f}, n {inside.sum()}"
                cells.append(f"{low}-{high}: {own.mean():5.1f} ({span})")
        rigid = ", ".join(f"{x:.1f}" for x in found[:3])
        print(f"{size:5.2f} | rigid {rigid} | " + " | ".join(cells))


if __name__ == "__main__":
    main()
