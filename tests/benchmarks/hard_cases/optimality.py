"""An independent check of a contact state: separate gaps, convolution, and outside search.

It imports the types of the march and shares no code with the solver.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from acoustics.arrays import Array
from hard_cases import subcell_deflection
from rolling.contact import solver
from rolling.contact.state import ContactState, RollingContact

Nodes = NDArray[np.signedinteger]

# relative; the allowance covers another order of summation than the solver's
LOAD_ERROR = 1.001e-12
ENERGY_ERROR = 1e-11  # relative; the two convolutions round differently
STEEPEST = 100.0  # half range of gaps over a cell, in ranges that pressures level
AROUND = 8  # nodes past the window that the convolution checks
BLOCK = 1_000_000  # nodes per block in the search outside the window


def love_coefficients(x: Nodes, y: Nodes) -> Array:
    """Compute Love's (1929) coefficients at node distances x, y [spacings].

    They hold for pi E* = spacing = 1. The logarithmic form is used; x and y broadcast.
    """
    total = np.zeros(np.broadcast_shapes(x.shape, y.shape))
    for a, b in ((0.5, 0.5), (0.5, -0.5), (-0.5, 0.5), (-0.5, -0.5)):
        s = x + a
        t = y + b
        r = np.hypot(s, t)
        # log(t + r) = log((t + r)(r + |t|) / (r + |t|)): for t < 0 written as log(s^2 / (r - t)),
        # which does not cancel.
        log_t = np.where(
            t > 0, np.log(np.abs(t) + r), 2 * np.log(np.abs(s)) - np.log(np.abs(t) + r)
        )
        log_s = np.where(
            s > 0, np.log(np.abs(s) + r), 2 * np.log(np.abs(t)) - np.log(np.abs(s) + r)
        )
        total += np.sign(a * b) * (s * log_t + t * log_s)
    return total


@lru_cache(maxsize=32)
def _kernel(rows: int, columns: int) -> Array:
    """Compute the coefficients for all node distances within (rows, columns)."""
    return love_coefficients(
        np.arange(1 - rows, rows)[:, None], np.arange(1 - columns, columns)[None, :]
    )


def gap_and_deflection(
    track: RollingContact, state: ContactState, around: int = 0
) -> tuple[Array, Array, Array]:
    """Compute gap [m], deflection [m] and pressure [Pa] on the window grown by `around` nodes."""
    w = state.window
    rows = np.arange(-around, w.rows + around) + w.row
    columns = np.arange(-around, w.columns + around) + w.column
    p = np.pad(state.pressure, around)
    m, n = p.shape
    if track.subcells > 1:
        u = subcell_deflection.deflection(p, track.subcells, love_coefficients)
    else:
        u = fftconvolve(p, _kernel(m, n))[m - 1 : 2 * m - 1, n - 1 : 2 * n - 1]
    return (
        gap_at(track, state.position, rows, columns),
        u * track.spacing / (np.pi * track.contact_modulus),
        p,
    )


def gap_at(track: RollingContact, position: int, rows: Nodes, columns: Nodes) -> Array:
    """Compute the undeformed gap [m] at rows and columns of the plate and a position."""
    along, across = track.heights.shape
    heights = track.heights[np.ix_(rows % along, columns % across)]
    gap: Array = _sphere(track, position, rows, columns) - heights
    return gap


def _sphere(track: RollingContact, position: int, rows: Nodes, columns: Nodes) -> Array:
    """Compute the undeformed gap of a flat plate [m] at rows and columns."""
    # position 0 is the centre of a cell
    x = (rows - (track.subcells - 1) / 2) * track.spacing
    x = x - (track.start + position * track.step)
    y = (columns - (track.heights.shape[1] - 1) / 2) * track.spacing
    along, across = track.radii
    rise: Array = x[:, None] ** 2 / (2 * along) + y[None, :] ** 2 / (2 * across)
    return rise


def _levelled(track: RollingContact) -> float:
    """Return half of the range of gaps over a cell [m] that elastic pressures level."""
    own = 4 * np.log(1 + np.sqrt(2)) * track.spacing / (np.pi * track.contact_modulus)
    return float(solver.LEVELLED * own * track.hardness)


def edges(track: RollingContact, state: ContactState, gap: Array, u: Array, around: int) -> Array:
    """Compute half the range of gaps [m] over the cells of the window of a state and around it.

    Parameters
    ----------
    gap, u : arrays on the window grown by `around` nodes, m
        Undeformed gap and deflection.
    around : int
        Nodes around the window.
    """
    shape = gap
    if not track.slopes:
        w = state.window
        rows = np.arange(-around, w.rows + around) + w.row
        columns = np.arange(-around, w.columns + around) + w.column
        shape = _sphere(track, state.position, rows, columns)
    return _edge(track, state, np.hypot(*np.gradient(shape + u)) / 2)


def _edge(track: RollingContact, state: ContactState, half: Array) -> Array:
    """Return the half range of gaps [m] that counts, of a half range over a cell."""
    level = _levelled(track)
    most = np.minimum(half, STEEPEST * level)
    edge: Array = state.edge_share * np.minimum(np.maximum(2 * (half - level), 0.0), most)
    return edge


def violations(
    track: RollingContact, state: ContactState, around: int = AROUND
) -> dict[str, float]:
    """Measure the violation of each condition of a solved contact.

    Returns
    -------
    conditions : maximum violation of the gap conditions over the maximum deflection, also `around`
        nodes past the window.
    lowest, above : minimum pressure, and maximum pressure minus the hardness [Pa]. `lowest` must
        not be negative and `above` not positive.
    load : relative error of the load.
    energy, deflection, contact area : relative errors of the state's own values.
    plastic area : error of the state's own value [nodes].
    outside : maximum penetration [m] outside the window over the maximum deflection; 0 without
        penetration.
    """
    e, u, p = gap_and_deflection(track, state, around)
    gap = e + u - state.approach
    # a share s of a cell in contact bears s * hardness at a gap of edge * (1 - 2 s)
    edge = np.zeros_like(p)
    if track.has_blended_edges:
        edge = edges(track, state, e, u, around)
        gap -= edge * (1 - 2 * p / track.hardness)
    wrong = np.where(p <= 0, -gap, np.where(p >= track.hardness, gap, np.abs(gap)))
    inner = u[around : u.shape[0] - around, around : u.shape[1] - around]
    cell = track.spacing**2

    own = _levelled(track)
    between = (p > 0) & (p < track.hardness) & (edge > 0) & (p.max() >= track.hardness)
    c = edge[between]
    s = p[between] / track.hardness
    crossed = np.minimum(1, 2 * c / (c + 2 * own))
    # A cell that bears little touches on a small share, which no difference of counts may round.
    whole = np.count_nonzero(p > 0) - np.count_nonzero(between)
    touching = whole + float(((1 - crossed) + crossed * s).sum())
    capped = np.count_nonzero(p >= track.hardness) + float((crossed * s).sum())
    stored = 0.5 * float(np.vdot(p, u)) * cell
    return {
        "conditions": float(max(wrong.max(), 0.0) / u.max()),
        "lowest": float(p.min()),
        "above": float(p.max() - track.hardness) if np.isfinite(track.hardness) else -np.inf,
        "load": abs(float(p.sum()) * cell / track.load - 1),
        "energy": abs(state.stored_energy / stored - 1),
        "deflection": float(np.abs(state.deflection - inner).max() / u.max()),
        "contact area": abs(state.contact_area / (touching * cell) - 1),
        "plastic area": abs(state.plastic_area / cell - capped),
        "outside": contact_outside(track, state) / float(u.max()),
    }


def contact_outside(track: RollingContact, state: ContactState) -> float:
    """Return the maximum penetration [m] of sphere and deflected plate outside the window.

    It is 0 without penetration. Deflections are never negative, so contact needs an undeformed gap
    below the approach, or one that is wide within its cell. Few nodes remain to be checked, and
    their deflections are summed directly.
    """
    reach = 2 * max(track.radii) * (state.approach + float(track.heights.max()))
    blended = track.has_blended_edges and state.edge_share > 0
    if not reach > 0:
        return 0.0
    nodes = np.sqrt(reach) / track.spacing
    across = track.heights.shape[1]
    centre = (track.start + state.position * track.step) / track.spacing
    rows = _low_lines(track, state, centre, nodes, track.heights.max(axis=1))
    columns = _low_lines(track, state, (across - 1) / 2, nodes, track.heights.max(axis=0))
    if not rows.size or not columns.size:
        return 0.0
    w = state.window
    deepest = 0.0
    beside = ~((columns >= w.column) & (columns < w.column + w.columns))
    for piece in np.array_split(rows, 1 + rows.size * columns.size // BLOCK):
        before_or_after = ~((piece >= w.row) & (piece < w.row + w.rows))
        room = state.approach - gap_at(track, state.position, piece, columns)
        wide = np.zeros_like(room)
        if blended:
            shape = gap_at if track.slopes else _sphere
            along, across = (
                shape(track, state.position, piece + a, columns + b)
                - shape(track, state.position, piece - a, columns - b)
                for a, b in ((1, 0), (0, 1))
            )
            wide = np.hypot(along, across) / 4
        i, j = np.nonzero((room + wide > 0) & (before_or_after[:, None] | beside[None, :]))
        if not i.size:
            continue
        rows_here = piece[i]
        columns_here = columns[j]
        depth = room[i, j] - _deflection_at(track, state, rows_here, columns_here)
        if blended:
            along, across = (
                change[i, j]
                + _deflection_at(track, state, rows_here + a, columns_here + b)
                - _deflection_at(track, state, rows_here - a, columns_here - b)
                for change, a, b in ((along, 1, 0), (across, 0, 1))
            )
            depth += _edge(track, state, np.hypot(along, across) / 4)
        deepest = max(deepest, float(depth.max()))
    return deepest


def _low_lines(
    track: RollingContact, state: ContactState, centre: float, nodes: float, highest: Array
) -> Nodes:
    """Return rows or columns within `nodes` of the centre whose gap may lie below the approach."""
    lines = np.arange(np.floor(centre - nodes), np.ceil(centre + nodes) + 1).astype(np.int64)
    distance = (lines - centre) * track.spacing
    return lines[
        distance**2 / (2 * max(track.radii)) - highest[lines % highest.size] < state.approach
    ]


def _deflection_at(
    track: RollingContact, state: ContactState, rows: Nodes, columns: Nodes
) -> Array:
    """Compute the deflection [m] at single nodes, each by a sum over the loaded nodes."""
    i, j = np.nonzero(state.pressure)
    p = state.pressure[i, j]
    i = i + state.window.row
    j = j + state.window.column
    u = np.empty(rows.size)
    for piece in np.array_split(np.arange(rows.size), 1 + rows.size * p.size // BLOCK):
        u[piece] = love_coefficients(rows[piece, None] - i, columns[piece, None] - j) @ p
    return u * track.spacing / (np.pi * track.contact_modulus)


def _area_error(track: RollingContact, state: ContactState, rounding: float) -> float:
    """Return the relative error of the contact area that rounding leaves.

    The area of a shared cell follows from slopes of the deflected gap over the range that pressures
    level. `rounding` is the rounding error of the gap over the maximum deflection.
    """
    if not track.has_blended_edges:
        return LOAD_ERROR
    slopes = 10 * rounding * float(state.deflection.max()) / _levelled(track)
    return max(ENERGY_ERROR, slopes)


def broken(track: RollingContact, state: ContactState, allowance: float = 1.5) -> list[str]:
    """List the conditions that a state violates, as "name: amount"; empty for a solved contact.

    The allowance covers the rounding of heights against deflection and of the two convolutions. The
    solver's own residual is the same quantity.
    """
    if not all(
        np.isfinite(x)
        for x in (state.approach, state.stored_energy, state.max_pressure, state.residual)
    ):
        return [f"finite: approach {state.approach:g} m, stored energy {state.stored_energy:g} J"]
    if not (np.isfinite(state.pressure).all() and np.isfinite(state.deflection).all()):
        return ["finite: a pressure or a deflection is not a number"]
    measured = violations(track, state)
    rounding = 1e-15 * float(np.abs(track.heights).max()) / float(state.deflection.max()) + 1e-14
    allowed = allowance * track.tolerance + 10 * rounding
    limits = {
        "conditions": allowed,
        "outside": allowed,
        "above": 0.0,
        "load": LOAD_ERROR,
        "energy": ENERGY_ERROR,
        "deflection": ENERGY_ERROR,
        "contact area": _area_error(track, state, rounding),
        "plastic area": 1e-6,
    }
    broken_conditions = [
        f"{name}: {measured[name]:.3g}, allowed {limit:.3g}"
        for name, limit in limits.items()
        if not measured[name] <= limit
    ]
    if not measured["lowest"] >= 0:
        broken_conditions.append(f"lowest: a pressure of {measured['lowest']:.3g} Pa")
    if not state.residual <= track.tolerance:
        broken_conditions.append(
            f"residual: the solver's own is {state.residual:.3g}, tolerance {track.tolerance:.3g}"
        )
    return broken_conditions
