"""Sound power of a plate without a baffle by a second method, beside that of unbaffled_study.py.

`python tests/benchmarks/unbaffled_panels.py` divides a plate into small rectangles (panels), on
each of which the pressure jump mu between the two sides is constant. The slope of the pressure
normal to the plate is the sum over the panels of

    mu (integral of dG/dn along the edges + k^2 integral of G over it),  G = exp(-ikR) / (4 pi R),

at the middle of a panel, and it is -i w rho v. The power to both sides is the exchange Re(mu v*),
summed over the panels. So neither functions, nor wave numbers, nor a far field are shared with
unbaffled_study.py. The error falls with the size of the panels, and two sizes extrapolate it.

It prints three things.

1. A disc of the radius a with the velocities 1 and 1 - 2 r^2/a^2, by a third method, whose limits
   at low ka are closed forms: 8/3 rho a^3 is the added mass of the disc that moves up and down, and
   a fifth of it is the momentum of the disc that moves no volume.
2. The same disc by panels.
3. The modes of the plate of unbaffled_study.py by panels and by that study.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import jv, spherical_jn
from unbaffled_study import SIDES, reductions

from acoustics.arrays import Array
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, legendre
from acoustics.ritz_plate import RitzPlate

Complex = NDArray[np.complex128]
RIGID = "1"
NO_VOLUME = "1 - 2 r^2/a^2"
HIGHEST = 4000.0  # phase of the shortest waves of a disc over its radius
SHOWN = (0, 1, 2, 3, 4, 5, 6, 8, 11, 15, 20, 30, 40)  # modes


# ---- panels


class Grid(NamedTuple):
    """Panels of a rectangle, of which a quarter is solved."""

    edges_m: tuple[float, float]
    counts: tuple[int, int]  # of panels along half of each side

    @property
    def panel_m(self) -> tuple[float, float]:
        """Sides of a panel [m]."""
        return (self.edges_m[0] / 2 / self.counts[0], self.edges_m[1] / 2 / self.counts[1])

    def middles(self) -> tuple[Array, Array]:
        """Return the middles of the panels of the quarter from the plate's middle [m]."""
        along, across = self.panel_m
        return (np.arange(self.counts[0]) + 0.5) * along, (np.arange(self.counts[1]) + 0.5) * across


def panel_slopes(grid: Grid, k: float) -> Complex:
    """Return the slope of pressure at a panel by the jump 1 on another, over their offsets."""
    u, weights = legendre(12)
    hx, hy = grid.panel_m
    x = hx * np.arange(2 * grid.counts[0])[:, None, None]
    y = hy * np.arange(2 * grid.counts[1])[None, :, None]

    def edge(normal: Array, beside: Array) -> Complex:
        square = np.square(normal) + np.square(beside)
        distance = np.sqrt(square)
        wave = np.exp(-1j * k * distance) / (4 * np.pi * distance)
        return np.asarray(-(1j * k + 1 / distance) * wave * normal / distance)

    slopes = np.zeros((2 * grid.counts[0], 2 * grid.counts[1]), dtype=complex)
    for side in (1, -1):
        along = edge(x + side * hx / 2, y + hy / 2 * u)
        across = edge(y + side * hy / 2, x + hx / 2 * u)
        slopes += side * (hy / 2 * along + hx / 2 * across) @ weights
    nodes_x = hx / 2 * np.repeat(u, len(u))
    nodes_y = hy / 2 * np.tile(u, len(u))
    areas = hx * hy / 4 * np.outer(weights, weights).ravel() / (4 * np.pi)
    for i in range(2 * grid.counts[0]):
        distance = np.hypot(x[i] + nodes_x, y[0] + nodes_y)
        waves = np.exp(-1j * k * distance) / distance
        if i == 0:
            # At the panel itself 1/R is integrated in closed form.
            distance = distance[0]
            waves[0] = (np.exp(-1j * k * distance) - 1) / distance
            own = 2 * (hx * np.arcsinh(hy / hx) + hy * np.arcsinh(hx / hy))
            slopes[0, 0] += k**2 * own / (4 * np.pi)
        slopes[i] += k**2 * waves @ areas
    return slopes


def quarter_matrix(slopes: Complex, counts: tuple[int, int], parities: tuple[int, int]) -> Complex:
    """Return the matrix of a quarter for jumps that are even (0) or odd (1) along each side."""
    near = [np.abs(np.subtract.outer(np.arange(n), np.arange(n))) for n in counts]
    far = [np.add.outer(np.arange(n), np.arange(n)) + 1 for n in counts]
    size = counts[0] * counts[1]
    matrix = np.zeros((counts[0], counts[1], counts[0], counts[1]), dtype=complex)
    for images in product((0, 1), repeat=2):
        sign = (-1) ** (images[0] * parities[0] + images[1] * parities[1])
        along = far[0] if images[0] else near[0]
        across = far[1] if images[1] else near[1]
        matrix += sign * slopes[along[:, None, :, None], across[None, :, None, :]]
    return matrix.reshape(size, size)


def radiated(grid: Grid, k: float, parities: tuple[int, int], shapes: Array) -> Array:
    """Return the power to both sides of shapes at the panels of a quarter, (panels, shapes).

    It is that of the mean square 1 over time of the velocity where the shape is 1 [W s2/m2].
    """
    matrix = quarter_matrix(panel_slopes(grid, k), grid.counts, parities)
    inside = np.any(shapes != 0, axis=1)
    w = k * SOUND_M_S
    jump = np.linalg.solve(matrix[np.ix_(inside, inside)], -1j * w * AIR_KG_M3 * shapes[inside])
    hx, hy = grid.panel_m
    return np.asarray(4 * hx * hy * np.real(np.sum(jump * shapes[inside], axis=0)))


def extrapolated(power: Callable[[int], Array], count: int) -> Array:
    """Return powers of ever smaller panels, from two sizes, as the error falls with the size."""
    coarse = power(count)
    fine = power(2 * count)
    return np.asarray(2 * fine - coarse)


# ---- disc


def disc_powers(ka: float, profile: str, count: int = 24) -> tuple[float, float, float]:
    """Return the power of a disc in the open by exchange and by its far field, and in a baffle.

    They are to both sides, for the radius 1 and a mean square velocity of 1. The jump is a sum of
    functions whose transforms are j_(2n+1)(q)/q; they vanish as the root at the edge, and at k = 0
    they are orthogonal.
    """
    order = 2 * np.arange(count)[:, None] + 1
    projected = np.zeros(count)  # of 2 pi r v times each function
    if profile == RIGID:
        projected[0] = 1 / 3
    else:
        projected[0] = 1 / 3 - 2 * 4 / 30
        projected[1] = 2 * 4 / 105
    u, weights = legendre(64)
    angle = np.pi / 4 * (u + 1)
    inner = ka * np.sin(angle)
    inner_weights = np.pi / 4 * weights * ka * np.cos(angle)
    # Beyond the wave number of sound, q = ka cosh t.
    ends = np.linspace(0, np.arccosh(HIGHEST / ka), 600)
    half = np.diff(ends)[:, None] / 2
    nodes, own = legendre(24)
    t = (ends[:-1, None] + half * (1 + nodes)).ravel()
    outer = ka * np.cosh(t)
    outer_weights = (half * own).ravel() * ka * np.sinh(t)
    w = ka * SOUND_M_S
    q = np.concatenate((inner, outer))
    all_weights = np.concatenate((inner_weights, outer_weights))
    kz = np.concatenate((ka * np.cos(angle) + 0j, -1j * ka * np.sinh(t)))
    functions = spherical_jn(order, q) / q
    matrix = (functions * (kz * q * all_weights)) @ functions.T / (2 * w * AIR_KG_M3)
    jump = np.linalg.solve(matrix, projected)
    exchange = 2 * np.pi * np.real(np.sum(jump * projected))
    near = functions[:, : len(inner)]
    waves = np.square(np.abs(jump @ near)) * kz[: len(inner)].real * inner * inner_weights
    far = 2 * np.pi * np.sum(waves) / (2 * w * AIR_KG_M3)
    piston = jv(1, inner) / inner
    velocity = piston
    if profile == NO_VOLUME:
        velocity = piston - 2 * (piston - 2 * jv(2, inner) / inner**2)
    baffled = np.sum(np.square(velocity) * inner * inner_weights / kz[: len(inner)].real)
    baffled *= 2 * 2 * np.pi * w * AIR_KG_M3
    return float(exchange), float(far), float(baffled)


def disc_limits(ka: float, profile: str) -> tuple[float, float]:
    """Return the power of a small disc in the open and in a baffle, by closed forms."""
    mass = 8 / 3 * AIR_KG_M3
    w = ka * SOUND_M_S
    if profile == RIGID:
        baffled = 2 * 2 * np.pi * AIR_KG_M3 * SOUND_M_S * ka**2 * (1 / 4)
    else:
        mass /= 5
        # transform (k sin)^2 / 48; the mean of sin^5 over a half circle's angle is 8/15
        baffled = 2 * 2 * np.pi * AIR_KG_M3 * SOUND_M_S * ka**2 * (ka**2 / 48) ** 2 * 8 / 15
    force = w * mass
    return force**2 * ka**2 / (12 * np.pi * AIR_KG_M3 * SOUND_M_S), baffled


def disc_by_panels(ka: float, profile: str, count: int) -> float:
    """Return the power of the disc of the radius 1 by panels whose middles lie within it."""
    grid = Grid((2.0, 2.0), (count, count))
    x, y = grid.middles()
    square = np.square(x)[:, None] + np.square(y)
    inside = square <= 1
    shape = np.where(inside, 1.0 if profile == RIGID else 1 - 2 * square, 0.0)
    shape[inside & (shape == 0)] = 1e-12  # panels at zero shape belong to the disc too
    return float(radiated(grid, ka, (0, 0), shape.reshape(-1, 1))[0])


# ---- plate


def plate_powers(plate: RitzPlate, frequency_hz: float, modes: list[int], count: int) -> Array:
    """Return the power to both sides of modes without a baffle, by panels, extrapolated."""
    edges = (plate.length_m, plate.width_m)
    k = 2 * np.pi * frequency_hz / SOUND_M_S
    result = np.zeros(len(modes))
    for family in plate.modes.families:
        own = [i for i, mode in enumerate(modes) if mode in family.modes]
        if not own:
            continue
        parities = (int(family.along[0] % 2), int(family.across[0] % 2))

        def power(
            cells: int,
            own: list[int] = own,
            parities: tuple[int, int] = parities,
        ) -> Array:
            grid = Grid(edges, (cells, max(2, round(cells * edges[1] / edges[0]))))
            x, y = grid.middles()
            along, across = np.meshgrid(2 * x / edges[0], 2 * y / edges[1], indexing="ij")
            shapes = plate.modes.shapes(along.ravel(), across.ravel())[:, [modes[i] for i in own]]
            return radiated(grid, k, parities, shapes)

        result[own] = extrapolated(power, count)
    return result


def main() -> None:
    """Print discs and modes of a plate by each method."""
    print("disc: power in the open over that in a baffle [dB], and ratios of the power in the open")
    for profile, ka in product((RIGID, NO_VOLUME), (0.05, 0.2, 1.0, 3.0, 10.0)):
        exchange, far, baffled = disc_powers(ka, profile)
        limit, baffled_limit = disc_limits(ka, profile)
        line = f"{profile}, ka {ka:g}: {10 * np.log10(exchange / baffled):.2f} dB, "
        line += f"exchange over far field {exchange / far:.6f}"
        if ka < 1:
            line += f", over closed form {exchange / limit:.3f}"
            line += f", in the baffle {baffled / baffled_limit:.3f}"
        if ka < 5:
            counts = (10, 20, 40)
            panels = [disc_by_panels(ka, profile, count) / exchange for count in counts]
            line += ", by panels " + ", ".join(f"{ratio:.3f}" for ratio in panels)
        print(line)
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
    print("plate: power in a baffle over that in the open [dB], modes " + str(SHOWN))
    for size in (0.1, 0.4, 0.8, 1.6, 3.2):
        frequency = size * SOUND_M_S / np.sqrt(SIDES[0] * SIDES[1])
        baffled = 2 * plate.resistances(frequency)[list(SHOWN)]
        panels = 10 * np.log10(baffled / plate_powers(plate, frequency, list(SHOWN), 24))
        study = reductions(plate, frequency)[list(SHOWN)]
        difference = np.abs(panels - study).max()
        print(f"root of area over wavelength {size}: the methods differ by {difference:.2f} dB")
        print("  panels", np.round(panels, 1).tolist())
        print("  study ", np.round(study, 1).tolist())


if __name__ == "__main__":
    main()
