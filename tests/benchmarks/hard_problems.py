"""Hard scenes as problems that public solvers take: square grids, sharp edges, a round sphere."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

import numpy as np
from against_peers import Problem, SharedProblem
from hard_cases.named_cases import CASES, SOLVED
from hard_cases.optimality import gap_at
from hard_cases.random_cases import random_scene
from scipy.fft import next_fast_len

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.solver import ContactError
from rolling.contact.state import RollingContact, Window

# Scenes of hard_cases whose curves are drawn, each hard in another way, by their titles.
DRAWN = {
    "gel, elastic": "gel, elastic",
    "spike, elastic": "spike of 1e-06 m, elastic",
    "cliff, elastic": "cliff along, elastic",
    "rough, yielding": "1 uN, capped",
    "trench, yielding": "trench along",
    "nearly rigid-plastic": "nearly rigid-plastic, 1 E*",
}
BORDER = 2  # nodes around the contact, on each side of a grid
LEAST = 8  # nodes on a side of a grid
SURE = 1e-6  # tolerance of the march that finds the contact


def hard_problem(
    track: RollingContact, first: int, steps: int, is_fast: bool = False
) -> SharedProblem:
    """Return a scene on the smallest square grid that moves with its sphere and has its contact.

    Where it should be fast, the grid is wider until transforms of its sides are so: a large prime
    in the number of nodes makes them slow.

    The contact is marched, as nobody else knows where it is; so the other programs are spared the
    nodes that are never loaded.

    Raises
    ------
    ContactError : the scene has no solution.
    """
    half_space = HalfSpace(track.spacing, track.contact_modulus)
    states = list(march(track, first, first + steps, half_space))
    corners = []
    reach = LEAST
    for state in states:
        row, column = _apex(track, state.position)
        i, j = np.nonzero(state.pressure)
        loaded = (i + state.window.row - row, j + state.window.column - column)
        corners.append((row, column))
        reach = max(reach, *(2 * int(np.abs(nodes).max()) + 2 * BORDER for nodes in loaded))
    if is_fast:
        reach = next_fast_len(reach, real=True)
    windows = tuple(
        Window(row - reach // 2, column - reach // 2, reach, reach) for row, column in corners
    )
    gaps = [
        gap_at(
            track,
            state.position,
            np.arange(window.row, window.row + reach),
            np.arange(window.column, window.column + reach),
        )
        for state, window in zip(states, windows, strict=True)
    ]
    rows = [window.row for window in windows]
    problem = Problem(
        gaps=np.array(gaps),
        moves=np.diff(rows, prepend=rows[0]),
        spacing=track.spacing,
        radius=track.radius,
        contact_modulus=track.contact_modulus,
        hardness=track.hardness,
        load=track.load,
    )
    return SharedProblem(track, first, windows, problem)


def _apex(track: RollingContact, position: int) -> tuple[int, int]:
    """Return row and column of the node under the middle of the sphere."""
    along = np.floor(track.position(position) / track.spacing + 0.5)
    return int(along), track.heights.shape[1] // 2


def drawn(steps: int) -> dict[str, SharedProblem]:
    """Return the scenes whose curves are drawn, by their titles."""
    cases = {case.name: case for case in CASES}
    return {
        title: hard_problem(cases[name].build(), cases[name].first, steps)
        for title, name in DRAWN.items()
    }


def many(random: int, steps: int) -> dict[str, SharedProblem]:
    """Return all named scenes that have a solution, and the first so many random ones."""
    found = {
        case.name: hard_problem(case.build(), case.first, steps)
        for case in CASES
        if SOLVED in case.right
    }
    for name, track in _random_tracks():
        if random == 0:
            return found
        try:
            found[name] = hard_problem(replace(track, tolerance=SURE), 0, steps)
            random -= 1
        except ContactError:
            continue
    raise AssertionError("seeds do not end")


def _random_tracks() -> Iterator[tuple[str, RollingContact]]:
    """Yield random scenes, by their seeds."""
    for seed in count():
        yield f"random {seed}", random_scene(seed)[0]
