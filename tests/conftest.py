"""Scenes small enough to test on, and a check of a contact state that shares no code with the solver."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.signal import fftconvolve

from rolling import recovery, surface
from rolling.half_space import HalfSpace
from rolling.march import ContactState, RollingContact, march

STEEL = 210e9 / (1 - 0.3**2)  # E* [Pa] of the plate under a rigid sphere


def rough(
    along: int, across: int, ra: float, seed: int = 1, spacing: float = 2e-6, length: float = 10e-6
) -> np.ndarray:
    return surface.gaussian((along, across), spacing, ra, (length, length), "gaussian", seed)


def make_track(heights: np.ndarray, **changes: float) -> RollingContact:
    """A steel plate under a 5 mm sphere at 5 N and 2 um spacing, one node per step, but for the changes."""
    scene = {
        "spacing": 2e-6,
        "radius": 5e-3,
        "contact_modulus": STEEL,
        "hardness": np.inf,
        "load": 5.0,
        "start": 0.0,
        "tolerance": 1e-8,
    } | changes
    scene.setdefault("step", scene["spacing"])
    return RollingContact(heights=heights, **scene)


def space_of(track: RollingContact) -> HalfSpace:
    return HalfSpace(track.spacing, track.contact_modulus)


def roll(track: RollingContact, first: int, last: int) -> list[ContactState]:
    return list(march(track, first, last, space_of(track)))


def step_energies(
    track: RollingContact, states: list[ContactState], left_end: bool = False
) -> list[recovery.StepEnergy]:
    space = space_of(track)
    return [recovery.step_energy(old, new, space, left_end) for old, new in pairwise(states)]


def releases(track: RollingContact, states: list[ContactState], left_end: bool = False) -> np.ndarray:
    return np.array([step.release for step in step_energies(track, states, left_end)])


def love_kernel(rows: int, columns: int) -> np.ndarray:
    """Love's coefficients for all node distances within (rows, columns), as logarithms, for pi E* = spacing = 1."""
    x, y = np.arange(1 - rows, rows)[:, None], np.arange(1 - columns, columns)[None, :]
    total = np.zeros((2 * rows - 1, 2 * columns - 1))
    for a, b in ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)):
        s, t = x + a, y + b
        r = np.hypot(s, t)
        # log(t + r) = log((t + r)(r + |t|) / (r + |t|)): for t < 0 written as log(s^2 / (r - t)), which does not cancel.
        log_t = np.where(t > 0, np.log(np.abs(t) + r), 2 * np.log(np.abs(s)) - np.log(np.abs(t) + r))
        log_s = np.where(s > 0, np.log(np.abs(s) + r), 2 * np.log(np.abs(t)) - np.log(np.abs(s) + r))
        total += np.sign(a * b) * (s * log_t + t * log_s)
    return total


def gap_and_deflection(
    track: RollingContact, state: ContactState, around: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Undeformed gap, deflection and pressure on the window grown by `around` nodes, all computed afresh."""
    w = state.window
    rows, columns = np.arange(-around, w.rows + around) + w.row, np.arange(-around, w.columns + around) + w.column
    along, across = track.heights.shape
    x = rows * track.spacing - (track.start + state.position * track.step)
    y = (columns - (across - 1) / 2) * track.spacing
    e = (x[:, None] ** 2 + y[None, :] ** 2) / (2 * track.radius) - track.heights[rows % along][:, columns % across]
    p = np.pad(state.pressure, around)
    m, n = p.shape
    u = fftconvolve(p, love_kernel(m, n))[m - 1 : 2 * m - 1, n - 1 : 2 * n - 1]
    return e, u * track.spacing / (np.pi * track.contact_modulus), p


def violations(track: RollingContact, state: ContactState, around: int = 8) -> dict[str, float]:
    """What a solved contact must hold, as numbers: largest violation over largest deflection, pressure bounds, load error.

    Also looks `around` nodes past the window: the contact must not have been cut off by it.
    """
    e, u, p = gap_and_deflection(track, state, around)
    gap = e + u - state.approach
    wrong = np.where(p <= 0, -gap, np.where(p >= track.hardness, gap, np.abs(gap)))
    return {
        "conditions": float(max(wrong.max(), 0.0) / u.max()),
        "lowest": float(p.min()),
        "above": float(p.max() - track.hardness) if np.isfinite(track.hardness) else -np.inf,
        "load": abs(float(p.sum()) * track.spacing**2 / track.load - 1),
    }


def assert_solved(track: RollingContact, state: ContactState, allowance: float = 1.5) -> None:
    """The state holds the contact conditions within the tolerance, the bounds exactly and the load to 1e-12.

    The allowance is for the rounding of heights against deflection and of the two convolutions; the solver's own residual is
    the same quantity.
    """
    got = violations(track, state)
    rounding = 1e-15 * np.abs(track.heights).max() / state.deflection.max() + 1e-14
    assert got["conditions"] <= allowance * track.tolerance + 10 * rounding, got
    assert got["lowest"] >= 0 and got["above"] <= 0, got
    assert got["load"] <= 1e-12, got
    assert np.isfinite(state.approach) and np.isfinite(state.stored_energy)
