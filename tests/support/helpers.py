"""Small scenes, and a check of a contact state that shares no code with the solver."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from hard_cases import optimality
from hard_cases.named_cases import STEEL, make_track, rough
from hard_cases.optimality import gap_and_deflection

from rolling.contact import _transform_kernels, _window_kernels, recovery
from rolling.contact.compiling import njit
from rolling.contact.half_space import Convolution, HalfSpace
from rolling.contact.march import ContactState, RollingContact, march
from rolling.contact.subcells import half_space_of
from rolling.dynamics.force_law import ForceLaw
from rolling.marches.march_piece import march_piece
from rolling.marches.next_pieces import next_pieces
from rolling.marches.piece_archive import archive_of, arrays_of
from rolling.marches.result import Result
from rolling.scene.scene import Scene

__all__ = [
    "STEEL",
    "assert_solved",
    "contact_energy",
    "convolved",
    "gap_and_deflection",
    "hertz_law",
    "make_track",
    "march_all",
    "measures",
    "releases",
    "roll",
    "rough",
    "space_of",
    "sphere_mass",
    "step_energies",
    "track_work",
]


@njit(cache=True)
def measures(*arguments: Any) -> Any:
    """Measure the loaded nodes of a window in compiled code."""
    return _window_kernels.measures(*arguments)


def convolved(transforms: Convolution, pressure: np.ndarray) -> np.ndarray:
    """Return the deflection by a pressure on all nodes, in units of spacing / (pi E*)."""
    rows, columns = pressure.shape
    i, j = np.indices(pressure.shape)
    width = transforms.real.shape[1]
    node = (i // 2 * 2 * width + i % 2 + 2 * j).ravel().astype(np.uint32)
    image = np.full(transforms.real.size, np.nan)
    kernel = _transform_kernels.nodes_kernel(1, transforms.single)
    block = (0, 0, rows, columns)
    d = pressure.ravel()
    nodes = (node, np.empty(0, np.int64))
    entry = transforms.planned_entry(rows)
    _transform_kernels.deflect_nodes(kernel, entry, block, d, 1.0, image, nodes)
    return image[node].reshape(pressure.shape)


def space_of(track: RollingContact) -> HalfSpace:
    return half_space_of(track.spacing, track.contact_modulus, track.subcells)


def roll(track: RollingContact, first: int, last: int) -> list[ContactState]:
    return list(march(track, first, last, space_of(track)))


def step_energies(
    track: RollingContact, states: list[ContactState], left_end: bool = False
) -> list[recovery.StepEnergy]:
    space = space_of(track)
    return [recovery.step_energy(old, new, space, left_end) for old, new in pairwise(states)]


def releases(
    track: RollingContact, states: list[ContactState], left_end: bool = False
) -> np.ndarray:
    return np.array([step.release for step in step_energies(track, states, left_end)])


def assert_solved(track: RollingContact, state: ContactState, allowance: float = 1.5) -> None:
    """Assert the contact conditions to the tolerance, the bounds exactly, the load to 1e-12."""
    assert not optimality.broken(track, state, allowance)


def hertz_law(
    load_n: float, radius_m: float, contact_modulus_pa: float, track_m: Sequence[float] = (0,) * 4
) -> ForceLaw:
    """Return the law F = 4/3 E* sqrt(R) d^(3/2) of a smooth sphere, on heights spaced 1 m apart."""
    height = np.asarray(track_m, dtype=float)
    loads = load_n * np.array([0.5, 1.0, 2.0])
    depth = (loads / (4 / 3 * contact_modulus_pa * np.sqrt(radius_m))) ** (2 / 3)
    return ForceLaw(np.arange(height.size, dtype=float), loads, depth[:, None] - height)


def march_all(scene: Scene, film: bool = False) -> Result:
    """March all pieces of a scene without a sweep in this process, and return the result.

    The arrays of each piece go through its archive, as those of a run in a folder do.
    """
    result = Result.empty(scene)
    while pieces := next_pieces(scene, result, film):
        for piece in pieces:
            result.add(piece, arrays_of(piece, archive_of(piece, march_piece(piece))))
    return result


def sphere_mass(radius_m: float, density_kg_m3: float) -> float:
    """Return the mass [kg] of a solid sphere, 4/3 pi R^3 rho."""
    return float(4 / 3 * np.pi * radius_m**3 * density_kg_m3)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)


def contact_energy(law: ForceLaw, position: np.ndarray, approach: np.ndarray) -> np.ndarray:
    """Return the integral of the force of a law over the approach from lift-off [J]."""
    t = (_NODES + 1) / 2  # F grows as the power 3/2 from lift-off, which t^2 makes smooth
    lift_off = law.approach(position, 0.0)
    reach = np.maximum(approach - lift_off, 0.0)
    force = law.force(position[:, None], lift_off[:, None] + reach[:, None] * t**2)
    return np.asarray(reach * (force @ (_WEIGHTS * t)))


def track_work(law: ForceLaw, position: np.ndarray, approach: np.ndarray) -> np.ndarray:
    """Return the change of the contact energy along the track at fixed approaches [N]."""
    h = 1e-3 * law.spacing_m
    ahead, behind = (contact_energy(law, position + way, approach) for way in (h, -h))
    return (ahead - behind) / (2 * h)
