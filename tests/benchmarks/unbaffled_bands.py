"""How far does the baffle change the level of a free plate that is struck at some place?

`python tests/benchmarks/unbaffled_bands.py` solves free plates without and with a baffle, for all
modes together, and strikes them: many places, thicknesses, loss factors, forces, listeners and
sizes. It prints what the baffle changes in third octaves, and the A-weighted level of random
scenes beside the stated uncertainty of `acoustics.unbaffled`. It takes a few minutes a plate;
`--sides 3` solves some plates only, and `--coarse` octaves only.

The method is that of unbaffled_study.py, which unbaffled_panels.py has checked. Lengths are in
roots of the area, so a plate has one number, k_c = w_c/c at coincidence times the root of the area.
The rule was read from sides of 1 and 1.5; sides of 4/3, 2 and 3 are those on which it is judged.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import eval_chebyu, jv

from acoustics.arrays import Array
from acoustics.plate_modes import Family, PlateModes, SideFunctions, plate_modes
from acoustics.radiation import SOUND_M_S, legendre
from acoustics.unbaffled import baffle_difference_db, baffle_uncertainty_db
from acoustics.weighting import a_weighting_db

Complex = NDArray[np.complex128]
Listener = tuple[float, float, float]
READ_FROM = (1.0, 1.5)
JUDGED_ON = (4 / 3, 2.0, 3.0)
HIGHEST = 72.0  # wave number of the modes times the root of the area
SIZES = 0.25 * 2 ** (np.arange(25) / 3)  # wave number of sound times the root of the area
COINCIDENCES = (2, 4, 8, 16, 32, 64, 100)  # the same at coincidence
LOSS_FACTORS = (0.003, 0.01, 0.03)
PLACES = 6
HEIGHTS = (1.2, 4.0)  # of listeners
SCENES = 4000


# ---- field without a baffle


class SideWaves(NamedTuple):
    """Waves along a side, and functions sqrt(1 - x^2) U_i of one parity of the pressure jump."""

    phases: Array  # over half the side
    weights: Array
    transforms: Array  # (functions, waves)


def function_count(edge: float, k: float) -> int:
    """Return the number of functions of one parity for waves up to k along a side."""
    phase = max(k, HIGHEST) * edge / 2
    return int(np.ceil((phase + 6 * np.cbrt(phase) + 6) / 2))


def orders(count: int, parity: int) -> NDArray[np.int64]:
    """Return the orders i of the functions of a parity, (count, 1)."""
    return 2 * np.arange(count)[:, None] + parity


def side_waves(count: int, parity: int) -> SideWaves:
    """Return the waves along a side, dense near zero, and the transforms of its functions."""
    u, weights = legendre(8)
    highest = max(300.0, 16.0 * count)
    ends = highest * np.linspace(0, 1, int(highest / 3) + 1) ** 1.5
    half = np.diff(ends)[:, None] / 2
    phases = (ends[:-1, None] + half * (1 + u)).ravel()
    i = orders(count, parity)
    signs = (-1.0) ** np.arange(count)[:, None]
    functions = signs * np.pi * (i + 1) * jv(i + 1, phases) / phases
    return SideWaves(phases, (half * weights).ravel(), functions)


def chebyshev(count: int, parity: int, nodes: int) -> tuple[Array, Array]:
    """Return nodes, and weights times functions of a parity, that integrate along half a side."""
    angle = np.pi * np.arange(1, nodes + 1) / (nodes + 1)
    weights = np.pi / (nodes + 1) * np.sin(angle) ** 2
    return np.cos(angle), eval_chebyu(orders(count, parity), np.cos(angle)) * weights


def projections(side: SideFunctions, count: int, parity: int) -> Array:
    """Return integrals of the functions of the jump times those of the shapes of a plate."""
    x, functions = chebyshev(count, parity, 400)
    return functions @ side.values(x)[0].T


def jump_matrix(waves: tuple[SideWaves, SideWaves], edges: tuple[float, float], k: float) -> Array:
    """Return the matrix of velocities by jumps, over rho c, (functions, functions)."""
    along = 2 * waves[0].phases / edges[0]
    across = 2 * waves[1].phases / edges[1]
    square = k**2 - np.square(along)[:, None] - np.square(across)
    factor = np.outer(waves[0].weights, waves[1].weights) / (8 * k * np.pi**2)
    running = np.sqrt(np.maximum(square, 0)) * factor
    fading = np.sqrt(np.maximum(-square, 0)) * factor
    pairs = [np.triu_indices(len(wave.transforms)) for wave in waves]
    products = [
        wave.transforms[pair[0]] * wave.transforms[pair[1]]
        for wave, pair in zip(waves, pairs, strict=True)
    ]
    inside = int(np.sum(along < k))  # waves along the length that may run
    integrals = products[0][:, :inside] @ running[:inside] @ products[1].T
    integrals = integrals - 1j * (products[0] @ fading @ products[1].T)
    places = []
    for wave, pair in zip(waves, pairs, strict=True):
        count = len(wave.transforms)
        place = np.empty((count, count), dtype=np.int64)
        place[pair] = np.arange(len(pair[0]))
        place.T[pair] = np.arange(len(pair[0]))
        places.append(place)
    matrix = integrals[places[0][:, None, :, None], places[1][None, :, None, :]]
    return np.asarray(matrix.reshape(matrix.shape[0] * matrix.shape[1], -1))


class FamilyField(NamedTuple):
    """Sound of the modes of one symmetry, over rho c, at one wave number of sound."""

    modes: NDArray[np.int64]
    free_power: Array  # (modes, modes), to both sides, of velocities
    baffled_power: Array
    free_pressure: Complex  # (listeners, modes)
    baffled_pressure: Complex


def family_field(
    modes: PlateModes, family: Family, ratio: float, k: float, listeners: list[Listener]
) -> FamilyField:
    """Solve the field of the modes of a family of a plate of the area 1."""
    edges = (ratio**0.5, ratio**-0.5)
    parities = (int(family.along[0] % 2), int(family.across[0] % 2))
    counts = [function_count(edge, k) for edge in edges]
    waves = [side_waves(n, parity) for n, parity in zip(counts, parities, strict=True)]
    matrix = jump_matrix((waves[0], waves[1]), edges, k)
    sides = zip(modes.sides, counts, parities, strict=True)
    own = [projections(side, n, parity) for side, n, parity in sides]
    coefficients = family.coefficients
    velocity = np.einsum(
        "im,mnk,jn->ijk",
        own[0][:, family.along],
        coefficients,
        own[1][:, family.across],
        optimize=True,
    )
    velocity = velocity.reshape(len(matrix), -1) / 4
    jump = np.linalg.solve(matrix, velocity)
    power = np.real(velocity.T @ jump)
    free_pressure = []
    baffled_pressure = []
    for x, y, z in listeners:
        nodes = int((k + HIGHEST) * max(edges)) + 40
        along, weighted_along = chebyshev(counts[0], parities[0], nodes)
        across, weighted_across = chebyshev(counts[1], parities[1], nodes)
        distance = _distances(edges, (along, across), (x, y, z))
        dipole = np.exp(-1j * k * distance) / (4 * np.pi * distance)
        dipole *= (1j * k + 1 / distance) * z / distance
        of_functions = (weighted_along @ dipole @ weighted_across.T).ravel()
        free_pressure.append(of_functions @ jump / 4)
        u, weights = legendre(nodes)
        distance = _distances(edges, (u, u), (x, y, z))
        monopole = 1j * k * np.exp(-1j * k * distance) / (2 * np.pi * distance)
        shapes = [side.values(u)[0] * weights for side in modes.sides]
        products = shapes[0][family.along] @ monopole @ shapes[1][family.across].T
        of_modes = products.ravel() @ coefficients.reshape(products.size, -1)
        baffled_pressure.append(of_modes / 4)
    return FamilyField(
        modes=family.modes,
        free_power=(power + power.T) / 2,
        baffled_power=baffled_power(modes, family, edges, k),
        free_pressure=np.array(free_pressure),
        baffled_pressure=np.array(baffled_pressure),
    )


def _distances(edges: tuple[float, float], nodes: tuple[Array, Array], listener: Listener) -> Array:
    """Return the distances of a listener from nodes on both halves of the sides, -1 to 1."""
    x, y, z = listener
    along = edges[0] / 2 * nodes[0] - x
    across = edges[1] / 2 * nodes[1] - y
    return np.asarray(np.sqrt(np.square(along)[:, None] + np.square(across) + z**2))


def baffled_power(modes: PlateModes, family: Family, edges: tuple[float, float], k: float) -> Array:
    """Return the power to both sides in a baffle over rho c, (modes, modes)."""
    u, weights = legendre(int(30 + k * max(edges) / 2))
    angle = np.pi / 4 * (u + 1)
    length = k * np.sin(angle)[:, None]
    along = modes.sides[0].transforms((length * np.cos(angle)).ravel() * edges[0] / 2)
    across = modes.sides[1].transforms((length * np.sin(angle)).ravel() * edges[1] / 2)
    coefficients = family.coefficients.reshape(-1, len(family.modes))
    amplitudes = []
    for part in np.array_split(np.arange(along.shape[1]), 1 + along.shape[1] // 2000):
        x = along[family.along][:, part]
        y = across[family.across][:, part]
        products = np.einsum("ip,jp->pij", x, y).reshape(len(part), -1)
        amplitudes.append(products @ coefficients / 4)
    whole = np.concatenate(amplitudes)
    shares = np.outer(weights * np.sin(angle), weights).ravel() * (np.pi / 4) ** 2
    return np.asarray(2 * (k / np.pi) ** 2 * (whole.T * shares) @ whole)


# ---- plates that are struck


class Struck(NamedTuple):
    """A plate with a loss factor that is struck at a place, over ascending wave numbers."""

    coincidence: float  # wave number at coincidence times the root of the area
    loss_factor: float
    sizes: Array  # wave number of sound times the root of the area, (sizes,)
    power_db: Array  # power without over that with a baffle, (sizes,)
    pressure_db: Array  # the same of the mean square pressure, (listeners, sizes)
    baffled_db: Array  # mean square pressure in the baffle, (listeners, sizes)


def struck_plates(ratio: float, sizes: Array, seed: int = 1) -> Iterator[Struck]:
    """Solve a plate and strike it at places by a force of all frequencies."""
    modes = plate_modes(ratio, ("free", "free"), 0.3, HIGHEST**2)
    listeners = [(0.13 * ratio**0.5, 0.17 * ratio**-0.5, height) for height in HEIGHTS]
    fields = [
        [family_field(modes, family, ratio, k, listeners) for family in modes.families]
        for k in sizes
    ]
    places = np.random.default_rng(seed).uniform(-0.9, 0.9, (PLACES, 2))
    shapes = modes.shapes(places[:, 0], places[:, 1])
    for coincidence in COINCIDENCES:
        known = sizes[1.3 * coincidence * sizes < HIGHEST**2]
        for loss_factor in LOSS_FACTORS:
            solved = partial(_bands, modes.numbers / coincidence, loss_factor)
            for shape in shapes:
                rows = [solved(k, field, shape) for k, field in zip(known, fields, strict=False)]
                power, pressure, baffled = (np.array(column) for column in zip(*rows, strict=True))
                yield Struck(coincidence, loss_factor, known, power, pressure.T, baffled.T)


def _bands(
    own: Array, loss_factor: float, k: float, fields: list[FamilyField], shape: Array
) -> tuple[float, Array, Array]:
    """Return what the baffle changes in the third octave around k [dB], and what it leaves.

    `own` are the wave numbers of sound at the natural frequencies.
    """
    count = int(np.clip(0.7 / loss_factor, 24, 200))
    lines = k * 2 ** ((np.arange(count) + 0.5) / count / 3 - 1 / 6)
    powers = np.zeros(2)
    pressures = np.zeros((2, len(HEIGHTS), count), dtype=complex)
    for field in fields:
        answer = np.square(own[field.modes]) * (1 + 1j * loss_factor)
        velocity = lines[:, None] / (answer - np.square(lines)[:, None]) * shape[field.modes]
        for i, power in enumerate((field.free_power, field.baffled_power)):
            powers[i] += np.sum(np.real(velocity.conj() * (velocity @ power)))
        for i, pressure in enumerate((field.free_pressure, field.baffled_pressure)):
            pressures[i] += pressure @ velocity.T
    squares = np.mean(np.square(np.abs(pressures)), axis=-1)
    ratio_db = 10 * np.log10(squares[0] / squares[1])
    return float(10 * np.log10(powers[0] / powers[1])), ratio_db, 10 * np.log10(squares[1])


# ---- what it means for a level


def show_bands(plates: list[Struck]) -> None:
    """Print the change of third octaves by the wave number, and by the place of coincidence."""
    for low, high in ((0.2, 1), (1, 2), (2, 4), (4, 8), (8, 16), (16, 32), (32, 65)):
        for below, above in ((0, 0.5), (0.5, 2), (2, 4), (4, 1000)):
            found = []
            for plate in plates:
                over = plate.sizes / plate.coincidence
                is_in = (plate.sizes >= low) & (plate.sizes < high)
                is_in &= (over >= below) & (over < above)
                table = np.vstack((plate.power_db, plate.pressure_db))
                found.append(table[:, is_in])
            changes = np.concatenate(found, axis=1)
            if changes.shape[1] < 10:
                continue
            cells = [f"{row.mean():5.1f} ({row.std():.1f})" for row in changes]
            names = ["power", *(f"listener at {height}" for height in HEIGHTS)]
            texts = [f"{name} {cell}" for name, cell in zip(names, cells, strict=True)]
            print(f"k {low:g} to {high:g}, f/f_c {below:g} to {above:g}: " + ", ".join(texts))


class Force(NamedTuple):
    """Third octaves of a force: a slope, and the resonance of the contact."""

    slope_db: float  # in an octave
    resonance_hz: float
    quality: float

    def levels(self, frequency: Array) -> Array:
        """Return the levels of third octaves [dB]."""
        ratio = frequency / self.resonance_hz
        resonant = (1 - np.square(ratio)) ** 2 + np.square(ratio / self.quality)
        return np.asarray(self.slope_db * np.log2(frequency) + 10 * np.log10(frequency / resonant))


def random_force(random: np.random.Generator) -> Force:
    """Return a force of any kind."""
    return Force(
        slope_db=random.uniform(-4, 0),
        resonance_hz=np.exp(random.uniform(np.log(1500), np.log(12000))),
        quality=random.uniform(1, 30),
    )


def similar_force(force: Force, random: np.random.Generator) -> Force:
    """Return a force that is close to another."""
    return Force(
        slope_db=force.slope_db + random.uniform(-0.5, 0.5),
        resonance_hz=force.resonance_hz * np.exp(random.uniform(-0.25, 0.25)),
        quality=force.quality * np.exp(random.uniform(-0.5, 0.5)),
    )


class Level(NamedTuple):
    """What the baffle changes in a level [dB], and what its third octaves state.

    shares : array. Share of each third octave in the energy.
    of_bands : array, dB. Stated uncertainty of each.
    """

    change_db: float
    shares: Array
    of_bands: Array


def level_change(plate: Struck, root_m: float, listener: int, force: Force) -> Level | None:
    """Return what the baffle changes in LAeq.

    None where the frequencies of the plate do not reach over hearing.
    """
    frequency = plate.sizes * SOUND_M_S / (2 * np.pi * root_m)
    critical_hz = plate.coincidence * SOUND_M_S / (2 * np.pi * root_m)
    reaches = frequency[-1] > 7000 and frequency[0] < 800
    if not reaches or not 300 < critical_hz < 30e3:
        return None
    levels = plate.baffled_db[listener] + force.levels(frequency) + a_weighting_db(frequency)
    shares = np.where((frequency > 60) & (frequency < 20e3), 10 ** (levels / 10), 0)
    shares /= shares.sum()
    change = 10 * np.log10(shares @ 10 ** (plate.pressure_db[listener] / 10))
    return Level(
        change_db=float(change),
        shares=shares,
        of_bands=baffle_uncertainty_db(frequency, root_m**2, critical_hz),
    )


def show_levels(plates: list[Struck], seed: int = 3) -> None:
    """Print what the baffle changes in LAeq of random scenes, beside the stated uncertainty."""
    random = np.random.default_rng(seed)
    rows = []
    pairs: dict[str, list[tuple[float, float]]] = {"similar": [], "other": []}
    for _ in range(SCENES):
        plate = plates[random.integers(len(plates))]
        root_m = np.exp(random.uniform(np.log(0.05), np.log(0.6)))
        listener = int(random.integers(len(HEIGHTS)))
        force = random_force(random)
        row = level_change(plate, root_m, listener, force)
        similar = level_change(plate, root_m, listener, similar_force(force, random))
        other = level_change(plate, root_m, listener, random_force(random))
        if row is None or similar is None or other is None:
            continue
        rows.append((row.change_db, float(row.shares @ row.of_bands)))
        for name, second in (("similar", similar), ("other", other)):
            stated_db = baffle_difference_db(row.shares, second.shares, row.of_bands)
            pairs[name].append((row.change_db - second.change_db, stated_db))
    change, stated = np.array(rows).T
    print(
        f"LAeq of {len(rows)} scenes without a baffle: {change.mean():.1f} dB higher in the mean, "
        f"standard deviation {change.std():.1f}, stated {stated.mean():.1f} dB"
    )
    _show_within(change, stated)
    for name, values in pairs.items():
        change, stated = np.array(values).T
        print(
            f"  differences of {name} forces on the same plate change by {change.std():.1f} dB "
            f"(rms), stated {stated.mean():.1f} dB"
        )
        _show_within(change, stated)


def _show_within(change: Array, stated: Array) -> None:
    """Print how many changes lie within once and twice the stated uncertainty."""
    shares = [np.mean(np.abs(change) <= factor * stated) for factor in (1, 2)]
    print(f"    within once {100 * shares[0]:.1f} %, within twice {100 * shares[1]:.1f} %")


def main() -> None:
    """Solve plates and print what the baffle changes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--sides", type=float, nargs="+", default=[*READ_FROM, *JUDGED_ON])
    parser.add_argument("--coarse", action="store_true")
    arguments = parser.parse_args()
    sizes = SIZES[::3] if arguments.coarse else SIZES
    solved = []
    for ratio in arguments.sides:
        plates = list(struck_plates(ratio, sizes))
        print(f"sides {ratio:.3g} to 1", flush=True)
        show_levels(plates)
        solved.extend(plates)
    print("all together")
    show_bands(solved)
    show_levels(solved)


if __name__ == "__main__":
    main()
