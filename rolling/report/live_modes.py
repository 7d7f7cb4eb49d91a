"""Modes of a plate with free or clamped edges, as the engine of the page stores them.

They belong to a side ratio, to edges and to a Poisson's ratio, at any size, thickness and density.
A shape is a sum of products of the shapes of beams along both sides, of which few matter.
"""

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.plate_modes import POWERS, PlateModes, SideFunctions
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, legendre
from acoustics.rectangular_plate import MODES_HZ
from acoustics.ritz_plate import RitzPlate

MOST_MODES = 1300  # that the page holds
ROOM = 2.0  # highest number of a stored mode over that of the run, for larger or thinner plates
# Parts of the mean square of a shape that its stored products may miss; the first that fits counts.
LEFT_OUT = (1e-4, 3e-4, 1e-3)
MOST_PRODUCTS = 50_000
PHASES = (0.3, 300.0)  # range of wave number times root of the area in the table of efficiencies
EFFICIENCIES = 32  # of each mode
LEAST = 1e-9  # efficiency


class StoredModes(NamedTuple):
    """Modes as arrays."""

    data: dict[str, Any]  # plain numbers
    arrays: dict[str, Array]
    beams: list[Array]


def stored_modes(plate: RitzPlate) -> StoredModes | None:
    """Return the modes of a plate and of larger or thinner ones; None if they are too many."""
    if plate.mode_count > MOST_MODES:
        return None
    own = 2 * math.pi * MODES_HZ / plate.number_unit
    # The number of modes is about that of an infinite plate, number / (4 pi).
    highest = min(ROOM * own, max(own, 4 * math.pi * MOST_MODES * 0.8))
    # A plate of less stiffness has these modes up to MODES_HZ.
    wider = replace(plate, bending_stiffness_n_m=plate.bending_stiffness_n_m * (own / highest) ** 2)
    modes = wider.modes
    beams = [_beams(side) for side in modes.sides]
    for left_out in LEFT_OUT:
        starts, places, values = _products(modes, beams, left_out)
        if len(places) <= MOST_PRODUCTS:
            break
    data = {
        "rigid": modes.rigid,
        "counts": [side.count for side in modes.sides],
        "powers": [POWERS[side.kind] for side in modes.sides],
        "starts": starts,
        "phases": list(PHASES),
        "highest": highest,
    }
    arrays = {
        "numbers": modes.numbers,
        "places": places,
        "values": values,
        "efficiencies": _log_efficiencies(wider),
    }
    return StoredModes(data=data, arrays=arrays, beams=beams)


def _beams(side: SideFunctions) -> Array:
    """Return the shapes of beams by the functions of a side, (functions, beams)."""
    nodes, weights = legendre(side.count + 2 * POWERS[side.kind] + 1)
    curvature = side.values(nodes, derivatives=2)[2]
    energy = np.asarray((curvature * weights) @ curvature.T)
    beams = np.zeros_like(energy)
    for first in (0, 1):
        own = np.ix_(np.arange(first, side.count, 2), np.arange(first, side.count, 2))
        beams[own] = np.linalg.eigh(energy[own])[1]
    return beams


def _products(
    modes: PlateModes, beams: list[Array], left_out: float
) -> tuple[list[int], Array, Array]:
    """Return the products of beams in each mode: where they start, their places and shares."""
    along, across = beams
    width = modes.sides[1].count
    empty: Array = np.zeros(0)
    products = [(empty, empty)] * len(modes.numbers)
    for family in modes.families:
        x = along[np.ix_(family.along, family.along)]
        y = across[np.ix_(family.across, family.across)]
        places = np.asarray(family.along[:, None] * width + family.across, dtype=float).ravel()
        for mode, coefficients in zip(family.modes, family.coefficients.T, strict=True):
            shares = (x.T @ coefficients.T @ y).ravel()
            order = np.argsort(-np.square(shares))
            missing = 1 - np.cumsum(np.square(shares[order]))
            kept = order[: int(np.sum(missing > left_out)) + 1]
            norm = math.sqrt(float(np.sum(np.square(shares[kept]))))
            products[mode] = (places[kept], shares[kept] / norm)
    starts = np.concatenate(([0], np.cumsum([len(places) for places, _ in products])))
    all_places = np.concatenate([places for places, _ in products])
    all_values = np.concatenate([values for _, values in products])
    return starts.astype(int).tolist(), all_places, all_values


def _log_efficiencies(plate: RitzPlate) -> Array:
    """Return the logarithm of the radiation efficiency of each mode over PHASES."""
    area = plate.length_m * plate.width_m
    phases = np.geomspace(*PHASES, EFFICIENCIES)
    frequencies = phases / math.sqrt(area) * SOUND_M_S / (2 * math.pi)
    rows = [plate.resistances(min(frequency, MODES_HZ)) for frequency in frequencies]
    efficiency = np.array(rows).T / (AIR_KG_M3 * SOUND_M_S * area / 4)
    return np.asarray(np.log(np.maximum(efficiency, LEAST)).ravel())
