"""Compiled solve of a position of the march, from its window to its measures, in one call.

`solve` goes from a start to the accepted solution, with blended edges where the contact yields, and
`solve_position` from the states of two positions to the next. Both return early where Python has to
provide something: transforms of a size, the far field of a grid, a kernel or larger fields. Their
progress stays in arrays of the caller, so that the next call goes on, to the same digits.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

from functools import cache as once

import numpy as np
from numba import types

from rolling.contact import _descent_kernels as descent
from rolling.contact import _window_kernels as windows
from rolling.contact._by_address import address_of, caller
from rolling.contact._condition_kernels import has_partial_cells, yielding_overlap
from rolling.contact._transform_kernels import MAX_NODES
from rolling.contact._window_kernels import copy_line
from rolling.contact.compiling import njit

# This is the minimum useful weight of the sphere-fixed start at the second position. Below it the
# plate-fixed start converges as fast and needs no mixing.
MIN_SHARE = 0.2
# Later positions mix above this weight only, which plates of Ra 1 nm or less reach, and yielding
# contacts of more than some 350 nodes across. Below it the extrapolation of two positions takes
# fewer convolutions: 5 instead of 7 or 8 per step at weights of 0.3 to 0.7, as many at 0.97, but 5
# instead of 3 at 1.
STEADY_SHARE = 0.98
# A window has room for a load spread so many times as wide as at the position before.
ROOM = 1.1

# Entries of the progress of a position after the state of its descents: the number of convolutions
# when it began, marks, iterations of earlier solves, two windows, the measures of the solution with
# sharp edges and the share of the edges. All others begin with zeros.
CONVOLVED, BEGUN, LATER, SINGLE, EARLIER, WIDENED = range(descent.STATES, descent.STATES + 6)
WINDOW, NARROWER, KEPT, PROGRESS = (WIDENED + 1 + further for further in (0, 4, 8, 12))

_SINGLE, _DOUBLE = np.empty(0, np.float32), np.empty(0)  # arrays of the transforms' type
_field, _number, _whole = types.float64[:, ::1], types.float64, types.int64
_SOLVED = types.Tuple([_whole, *[_number] * 3, types.UniTuple(_whole, 4)])


def converge_types(real: types.Float) -> tuple[types.Type, ...]:
    """Return the types of the arguments of `converge` of the descents for transforms of a type."""
    pair = types.UniTuple(_field, 2)
    before = types.Tuple([_field, _field, _whole, _whole])
    stencils = types.Tuple([_number, _field, types.float32[::1], *[_number] * 3])
    numbers, flags = types.UniTuple(_number, 5), types.UniTuple(types.boolean, 2)
    tables = _whole[::1], _whole[:, ::1], _whole
    like = types.Array(real, 1, "C", readonly=True)
    return pair, pair, before, pair, numbers, stencils, flags, *tables, like


_converge_at = caller(_SOLVED, converge_types(types.float32), converge_types(types.float64))


@once
def converge_address(single: bool) -> int:
    """Return the address of `converge` of the descents, which is compiled if need be."""
    real = types.float32 if single else types.float64
    return address_of(descent.converge, _SOLVED, converge_types(real))


@njit(cache=True, inner=True)
def converge(problem, progress, kernels):
    """Converge in single or double precision, and go on in the other one where need be."""
    while True:
        single = progress[SINGLE]
        address, of_step = kernels[single]
        if address == 0:
            return descent.KERNEL, 0.0, 0.0, 0.0, (single, 0, 0, 0)
        in_single, in_double = (*problem, of_step, _SINGLE), (*problem, of_step, _DOUBLE)
        answer = _converge_at(address, in_single) if single else _converge_at(address, in_double)
        if answer[0] != descent.PRECISION:
            return answer
        progress[SINGLE] = 1 - single


@njit(cache=True, inner=True)
def field_of(numbers, shape):
    """Return the first numbers of a line as an array of a shape."""
    return numbers[: shape[0] * shape[1]].reshape(shape)


@njit(cache=True)
def solve(window, start, before, numbers, flags, stencils, table, fields, kernels, progress):
    """Solve a contact, with blended edges where it yields and with sharp edges elsewhere.

    Between both the maximum overlap at the hardness, over the half range that pressures level, is
    the share of their range that edges take. It is the overlap of the solution with whole edges, so
    that the contact follows continuously from its surface and load.

    Parameters
    ----------
    window, start, before, stencils, table
        Arguments of `converge` of the descents.
    numbers : tuple
        Hardness, sum of the pressures, tolerance and levelled range of the edges.
    flags : tuple of bool
        Whether the start is close to the solution, whether single precision may serve, whether
        edges may be blended, and whether they are sharp at first.
    fields : (2, 3 or 5, nodes) array
        Pressure and deflection of the solution, half ranges of its edges where they may be blended,
        and room for the solution with sharp edges where they are sharp at first. Numba would hand
        arrays of its own over by Python code, where an interrupt cannot be raised.
    kernels : (2, 2) array
        Addresses of `converge` and of the step of a descent, in double and in single precision.
    progress : (PROGRESS,) array
        Progress of the solve.

    Returns
    -------
    tuple
        Answer and what is missing; approach, maximum deflection, maximum violation [m], share of
        the edges, and the maximum gap [m] of a solve that stopped; iterations, convolutions,
        restarts, plain steps, rounds and whether the last of them are of single precision.
    """
    (gap, _), (hardness, _, tolerance, levelled) = window, numbers
    close, may_be_single, blended, sharp = flags
    nothing, given, shape = np.empty((0, 0)), start[1], gap.shape
    p, u = field_of(fields[0], shape), field_of(fields[1], shape)
    edge = field_of(fields[2], shape) if blended else nothing
    state, kept = progress[: descent.STATES], progress[KEPT:].view(np.float64)
    if not progress[BEGUN]:
        copy_line(start[0].reshape(-1), p.reshape(-1))
        edge[:] = 0.0
        state[:] = 0
        state[descent.DEFLECTION] = descent.GIVEN if given.size else descent.UNKNOWN
        progress[BEGUN], progress[LATER] = 1, 0
        progress[SINGLE] = 1 if may_be_single and tolerance >= descent.SINGLE_TOLERANCE else 0
        kept[3] = 0.0 if sharp or not blended else 1.0
    while True:
        share = kept[3]
        out, kind = (u, edge if share else nothing), (close or progress[LATER] > 0, may_be_single)
        problem = window, (p, given), before, out, (*numbers, share), stencils, kind, state, table
        answer, approach, u_max, worst, missing = converge(problem, progress, kernels)
        if answer != descent.SOLVED or not blended or 0 < share < 1:
            break
        # No contact is known to yield with blended edges that does not yield with sharp edges.
        if share == 0:
            if not sharp or p.max() < hardness:
                break
            copy_line(p.reshape(-1), fields[3][: p.size])
            copy_line(u.reshape(-1), fields[4][: p.size])
            kept[0], kept[1], kept[2], share = approach, u_max, worst, 1.0
        else:
            flat = gap.reshape(-1), u.reshape(-1), p.reshape(-1)
            overlap = yielding_overlap(flat[0], flat[1], flat[2], hardness, approach, levelled)
            if overlap >= levelled or not has_partial_cells(flat[2], edge.reshape(-1), hardness):
                break
            share = overlap / levelled
            if share == 0:
                edge[:] = 0.0
                if sharp:
                    copy_line(fields[3][: p.size], p.reshape(-1))
                    copy_line(fields[4][: p.size], u.reshape(-1))
                    approach, u_max, worst = kept[0], kept[1], kept[2]
                    break
        progress[EARLIER] += state[descent.ITERATIONS]
        progress[LATER], kept[3] = 1, share
        state[:] = 0
        state[descent.DEFLECTION] = descent.FRESH
    highest = np.abs(gap).max() if answer == descent.SPENT else 0.0
    measures = approach, u_max, worst, share, highest
    iterations = progress[EARLIER] + state[descent.ITERATIONS]
    counts = iterations, table[0, 0] - progress[CONVOLVED], state[descent.RESTARTS]
    rounds = state[descent.PLAIN_STEPS], state[descent.ROUNDS], progress[SINGLE]
    return answer, missing, measures, (*counts, *rounds)


@njit(cache=True, inner=True)
def around(window, other):
    """Return the minimum window that covers two windows; one without rows does not count."""
    if not other[2]:
        return window
    row, column = min(window[0], other[0]), min(window[1], other[1])
    end = max(window[0] + window[2], other[0] + other[2])
    return row, column, end - row, max(window[1] + window[3], other[1] + other[3]) - column


@njit(cache=True, inner=True)
def window_in(progress, first):
    """Return the window whose numbers begin at an entry."""
    return progress[first], progress[first + 1], progress[first + 2], progress[first + 3]


@njit(cache=True, inner=True)
def covers(window, other):
    """Tell whether all nodes of another window lie in a window."""
    whole = around(window, other)
    return whole[2] == window[2] and whole[3] == window[3]


@njit(cache=True)
def room(window, subcells):
    """Return the window of the solve: a window and a border of open nodes, in whole cells."""
    row, column = (window[0] - 1) // subcells * subcells, (window[1] - 1) // subcells * subcells
    rows = -((row - window[0] - window[2] - 1) // subcells) * subcells
    return row, column, rows, -((column - window[1] - window[3] - 1) // subcells) * subcells


@njit(cache=True, inner=True)
def moved(values, window, target, continued):
    """Copy values of a window into the target window as `copy_block` does."""
    out = np.empty((target[2], target[3]))
    windows.copy_block(values, out, window[0] - target[0], window[1] - target[1], continued)
    return out


@njit(cache=True, inner=True)
def gap_on(heights, sphere, window):
    """Compute the undeformed gap on a window."""
    out = np.empty((window[2], window[3]))
    windows.undeformed_gap(heights, sphere, window[0], window[1], out)
    return out


@njit(cache=True, inner=True)
def mix(values, others, share, high):
    """Move values towards others by a share of their difference, within rounding up to a bound."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            values[i, j] = min(values[i, j] + share * (others[i, j] - values[i, j]), high)


@njit(cache=True, inner=True)
def towards_the_sphere(track, old, frames, start, hardness):
    """Mix pressures that stayed with the plate with those that moved with the sphere.

    Returns the share of the latter, for a minimum of the energy, and the deflection. That is empty
    where it is unknown on nodes that are needed, and unless the last such start had to be iterated:
    a smooth sphere accepts it as it is, after a check that computes the deflection anew.

    Both deflections are known, so finding the mixture needs no convolution.
    """
    heights, sphere, nodes = track
    held, loaded, (p, u), (_, _, _, share, _), iterated = old
    window, needed = frames
    onward, nothing = (held[0] + nodes, held[1], held[2], held[3]), np.empty((0, 0))
    if not (nodes and covers(window, (loaded[0] + nodes, loaded[1], loaded[2], loaded[3]))):
        return 0.0, nothing
    gap, onward_p = gap_on(heights, sphere, window), moved(p, onward, window, False)
    deflection, onward_u = moved(u, held, window, True), moved(u, onward, window, True)
    slope, curvature = 0.0, 0.0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            towards = onward_p[i, j] - start[i, j]
            slope += (gap[i, j] + deflection[i, j]) * towards
            curvature += (onward_u[i, j] - deflection[i, j]) * towards
    known = iterated and share > 0 and covers(held, needed) and covers(onward, needed)
    share = min(-slope / curvature, 1.0) if slope < 0 < curvature else 0.0
    if share < MIN_SHARE:
        return 0.0, nothing
    mix(start, onward_p, share, hardness)
    mix(deflection, onward_u, share, np.inf)
    return share, deflection if known else nothing


@njit(cache=True, inner=True)
def warm_start(surface, place, states, hardness, blended):
    """Start from pressures that stayed with the plate, or with the sphere on a smooth plate.

    Returns the window, pressure and deflection, the position before where the deflection is to be
    extrapolated, the limits of approach and spread that the window holds, and the share of the
    pressures that moved with the sphere.
    """
    (heights, maxima), (sphere, ahead, load, near2, subcells, nodes) = surface, place
    old, (row, column, p_before, u_before, approach_before) = states
    held, loaded, (p, u), (approach, u_max, spread, share, _), _ = old
    limits = approach + min(4 * abs(approach - approach_before), 0.1 * u_max), ROOM * spread
    least = load, limits[1] ** 2 + near2
    needed = around(loaded, windows.overlap(maxima, sphere, limits[0], least, blended))
    window, nothing = needed, np.empty((0, 0))
    if not np.isnan(ahead):
        sphere_ahead = sphere[0], sphere[1], sphere[2], ahead, sphere[4]
        window = around(window, windows.overlap(maxima, sphere_ahead, limits[0], least, blended))
    window = room(window, subcells)
    start, deflection, last = moved(p, held, window, False), nothing, (nothing, nothing, 0, 0)
    is_second, was, share = not p_before.size, share, 0.0
    if is_second or was > STEADY_SHARE:
        track = heights, sphere, nodes
        share, deflection = towards_the_sphere(track, old, (window, needed), start, hardness)
    if share == 0 and covers(held, needed):
        deflection = moved(u, held, window, True)
        if not is_second:
            last = p_before, u_before, row - window[0], column - window[1]
    return window, (start, deflection), last, limits, share


@njit(cache=True, inner=True)
def measure(fields, blended, maxima, sphere, numbers, approach, window):
    """Return the loaded block of a solved window, and the measures of its nodes.

    The measures are the numbers of nodes in contact and at the hardness, the maximum pressure, the
    sum of p u, and the spread of the load [m].
    """
    hardness, _, _, levelled = numbers
    spacing, radius, radius_across, x, y = sphere
    p, u = field_of(fields[0], window[2:]), field_of(fields[1], window[2:])
    gap = max(windows.farthest_gap(maxima, sphere, approach, blended) + maxima[3], 0.0)
    reach = np.sqrt(2 * max(radius, radius_across) * gap) / spacing
    row, column = x / spacing - window[0], y / spacing - window[1]
    # Below the hardness there is no patch that could end within a cell.
    yields = blended and p.max() >= hardness
    ends = field_of(fields[2], window[2:]) if yields else np.empty((0, 0))
    measures = windows.measures(p, u, hardness, ends, levelled, row, column, reach)
    count, capped, maximum, work, spread, first_row, last_row, first_column, last_column = measures
    rows, columns = last_row - first_row + 1, last_column - first_column + 1
    loaded = window[0] + first_row, window[1] + first_column, rows, columns
    return loaded, (count, capped, maximum, work, spacing * spread)


@njit(cache=True)
def solve_position(
    surface, place, states, numbers, flags, stencils, table, fields, kernels, progress
):
    """Solve the contact at a position, again on a larger window where contact may be outside of it.

    Parameters
    ----------
    surface : tuple
        Heights of the plate, and the fields of their `Maxima`.
    place : tuple
        Spacing, radii and place of the sphere; its next place along if the window is to include it,
        else NaN; load and squared distance of the minimum deflection (see `least_deflection`);
        nodes along the side of a cell, and nodes that the sphere moves on, 0 unless they are whole.
    states : tuple
        State before: window, loaded block, pressure and deflection, (approach, maximum deflection,
        spread, share that moved with the sphere, share of the edges), and whether it was iterated.
        Without a deflection the pressure on the window is a cold start. The position before that
        follows: first node, pressure and deflection, empty where there is none, and approach.
    flags : tuple of bool
        Whether single precision may serve, whether edges may be blended, and whether the surface
        continues between the nodes.
    numbers, stencils, table, fields, kernels, progress
        Arguments of `solve`.

    Returns
    -------
    tuple
        Answer, what is missing, measures and counts of `solve`, window, loaded block, share that
        moved with the sphere, and the measures of the loaded nodes (see `measure`).
    """
    (heights, maxima), (sphere, _, load, near2, subcells, _) = surface, place
    old, (may_be_single, blended, slopes), hardness = states[0], flags, numbers[0]
    warm, nothing = old[2][1].size > 0, np.empty((0, 0))
    window, start, last = old[0], old[2], (nothing, nothing, 0, 0)
    limits, share, close, sharp = (-np.inf, np.inf), 0.0, warm, old[3][4] == 0.0
    if warm:
        window, start, last, limits, share = warm_start(surface, place, states, hardness, blended)
    most = MAX_NODES if subcells == 1 else MAX_NODES - 4  # sub-cells need a border of one cell
    measures, counts, loaded, measured = (0.0,) * 5, (0,) * 6, window, (0.0,) * 5
    while True:
        if progress[WIDENED]:
            window, last = window_in(progress, WINDOW), (nothing, nothing, 0, 0)
            close, sharp = True, False
        sides = window[2] // subcells, window[3] // subcells
        if max(sides) > most:
            answer, missing = descent.TOO_WIDE, (sides[0], sides[1], most, 0)
            break
        if window[2] * window[3] > fields.shape[1]:
            answer, missing = descent.FIELDS, (window[2] * window[3], 0, 0, 0)
            break
        if progress[WIDENED] and not progress[BEGUN]:
            narrower = window_in(progress, NARROWER)
            pressure = field_of(fields[0], narrower[2:])
            start = moved(pressure, narrower, window, False), nothing
        gap = gap_on(heights, sphere, window)
        shape = gap_on(np.zeros((1, 1)), sphere, window) if blended and not slopes else gap
        kind = close, may_be_single, blended, sharp
        answer, missing, measures, counts = solve(
            (gap, shape), start, last, numbers, kind, stencils, table, fields, kernels, progress
        )
        if answer != descent.SOLVED:
            break
        loaded, measured = measure(fields, blended, maxima, sphere, numbers, measures[0], window)
        if measures[0] <= limits[0] and measured[4] <= limits[1]:
            break
        least = load, measured[4] ** 2 + near2
        wider = around(window, windows.overlap(maxima, sphere, measures[0], least, blended))
        if covers(window, wider):
            break
        progress[EARLIER] += progress[descent.ITERATIONS]
        progress[BEGUN], progress[WIDENED] = 0, 1
        for k, number in enumerate(room(wider, subcells)):
            progress[WINDOW + k], progress[NARROWER + k] = number, window[k]
    return answer, missing, measures, counts, window, loaded, share, measured
