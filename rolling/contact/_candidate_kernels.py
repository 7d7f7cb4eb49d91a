"""Compiled search for the candidates of a window, the nodes that may be in contact, and edges.

Their indices lead from flat arrays of candidates to the window, to the array of the transforms and
to the grid of the model problem.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._condition_kernels import sum_inside
from rolling.contact._kinds import FIELD, INDICES, NOTHING, NUMBER, STRIPS, SYSTEM, WHOLE
from rolling.contact._linked import linked
from rolling.contact._system import BORDER
from rolling.contact._window_kernels import copy_line
from rolling.contact.compiling import inlined, njit

# Strips are so many nodes long, or a multiple of them, because shorter loops are not vectorized. A
# further strip takes as long as some 20 nodes, so that strips closer than STRIP_GAP are joined.
STRIP = 32
STRIP_GAP = 16
WIDE = 40_000  # nodes; smaller grids stay in the cache, where strips save nothing
# Nodes rest where so many cells are between the bounds, which take up the changes of the load. In
# random scenes with fewer the approach moves so far that nodes at rest leave the hardness, and the
# last check refuses up to half of the descents.
MIN_FREE = 50
# The half range of gaps over a cell is at most so many times the range that pressures level.
# Without this limit cliffs of many deflections made 2 % of random scenes too soft to converge.
# Surfaces of Ra 1 um at 2.1 GPa hardly reach it: -29.3 and -29.2 dB without and with it.
STEEPEST = 100.0


@inlined(fused=True)
def or_line(line, out):
    """Add the bits of a line to those of another line."""
    for k in range(out.size):
        out[k] |= line[k]


@inlined(fused=True)
def mark_near(p, g, hardness, lowest, highest, marks):
    """Mark the nodes lower than `highest` [m] and the loaded nodes, but not those at rest.

    At rest are nodes at the hardness lower than `lowest` [m].
    """
    for k in range(p.size):
        resting = (p[k] >= hardness) & (g[k] < lowest)
        marks[k] = ((p[k] > 0.0) | (g[k] < highest)) & (not resting)


@inlined(fused=True)
def count_resting(p, hardness, marks):
    """Return the number of nodes at the hardness that are not marked."""
    count = 0.0
    for k in range(p.size):
        count += 1.0 if (p[k] >= hardness) & (marks[k] == 0) else 0.0
    return count


@inlined()
def mark_neighbours(marks, row, near):
    """Mark the marked nodes of a window with rows of `row` nodes, and the neighbours of each."""
    nodes = near.size
    copy_line(marks, near)
    or_line(marks[: nodes - row], near[row:])
    or_line(marks[row:], near[: nodes - row])
    for first in range(0, nodes, row):
        or_line(marks[first : first + row - 1], near[first + 1 : first + row])
        or_line(marks[first + 1 : first + row], near[first : first + row - 1])


@njit(cache=True)
def candidates(p, g, hardness, lowest, highest, neighbours, subcells, node):
    """List the nodes of a window that may move: see `mark_near`.

    Their flat indices go into `node`. With `neighbours` the nodes along and across from them are
    listed, too. No node rests where less than MIN_FREE cells are between the bounds.

    Heights count before the approach is subtracted. Returns the number of nodes at rest, the number
    of candidates, and the first row and column of their block and its numbers of rows and columns,
    in whole cells of so many sub-cells along and across.
    """
    nodes = p.size
    columns = p.shape[1]
    # Most words of eight marks are empty, and a whole word is read as fast as a mark.
    words = nodes // 8 + 1
    marks = np.zeros(8 * words, np.uint8)
    pressure = p.reshape(-1)
    least = MIN_FREE * subcells * subcells
    if hardness == np.inf or sum_inside(pressure, pressure, hardness)[0] < least:
        lowest = -np.inf
    mark_near(pressure, g.reshape(-1), hardness, lowest, highest, marks)
    if neighbours:
        near = np.zeros(8 * words, np.uint8)
        mark_neighbours(marks[:nodes], columns, near[:nodes])
        marks = near
    resting = count_resting(pressure, hardness, marks) if lowest > -np.inf else 0.0
    word = marks.view(np.uint64)
    count = 0
    for w in range(words):
        if word[w]:
            for k in range(8 * w, min(8 * w + 8, nodes)):
                node[count] = k  # the next node overwrites it unless it counts
                count += marks[k] != 0
    if count == 0:
        return resting, 0, 0, 0, 0, 0
    in_column = np.zeros(columns, np.uint8)
    first_row = node[0] // columns
    last_row = node[count - 1] // columns
    for i in range(first_row, last_row + 1):
        or_line(marks[i * columns : (i + 1) * columns], in_column)
    first_column = 0
    while not in_column[first_column]:
        first_column += 1
    last_column = columns - 1
    while not in_column[last_column]:
        last_column -= 1
    row = first_row // subcells * subcells
    column = first_column // subcells * subcells
    rows = whole(last_row - row, subcells)
    columns = whole(last_column - column, subcells)
    return resting, count, row, column, rows, columns


@inlined()
def whole(last, subcells):
    """Return the number of sub-cells in the cells from the first sub-cell, 0, to the last."""
    return (last // subcells + 1) * subcells


@linked(WHOLE(INDICES, WHOLE, WHOLE, STRIPS))
def list_strips(place, rows, row, strips):
    """List the nodes near the candidates as strips of a grid that is passed as one long row.

    A move reaches two nodes along and across. Strips are multiples of STRIP nodes long, and strips
    close to one another are joined. A grid of less than WIDE nodes is a single strip as a whole.
    The first node of each strip and the node after its last go into `strips`; their number is
    returned.
    """
    first = 2 * row
    last = (rows - 2) * row
    if rows * row < WIDE:
        strips[0, 0] = first
        strips[0, 1] = last
        return 1
    words = rows * row // 8 + 1
    marked = np.zeros(8 * words, np.uint8)
    around = np.zeros(8 * words, np.uint8)
    for k in range(place.size):
        marked[place[k]] = 1
    for shift in (0, row, first, 3 * row, 4 * row):
        or_line(marked[shift:], around[first:last])
    count = 0
    end = 0
    word = around.view(np.uint64)
    for w in range(words):
        # from two nodes before the eight nodes of a word, or a word, to two nodes after them
        begin = max(8 * w - 8, first)
        stop = min(8 * w + 10, last)
        if word[w] == 0 or stop <= end:
            continue
        if count == 0 or begin > end + STRIP_GAP:
            strips[count, 0] = begin
            count += 1
        begin = np.int64(strips[count - 1, 0])
        end = min(begin + (stop - begin + STRIP - 1) // STRIP * STRIP, last)
        strips[count - 1, 1] = end
    return count


@inlined()
def take_nodes(node, columns, corner, row_lengths, rows, fields, out):
    """Set the pressures, gaps and indices of the candidates, and the strips (see `list_strips`).

    `fields` are flat pressures and gaps of the window, and `out` holds the vectors of the
    candidates, of which the first two are set, their indices, and the strips.

    `corner` is the first row and column of the candidates' block in a window of `columns` columns;
    `row_lengths` are the numbers of nodes in a row of the transforms (with the number of rows side
    by side), of the grid and of the coefficients by distance. The grid has `rows` rows with a
    border of BORDER nodes. Returns the number of strips.
    """
    (length, side), grid_row, influence_row = row_lengths
    pressure, gap = fields
    vectors, indices, strips = out
    i = -1  # row on the block of the node, and the first node of the next row
    following = corner[0] * columns
    first = 0  # of the row in the array of the transforms
    for a in range(node.size):
        k = node[a]
        vectors[0, a] = pressure[k]
        vectors[1, a] = gap[k]
        while k >= following:
            i += 1
            following += columns
            first = i // side * length * side + i % side
        j = k - (following - columns) - corner[1]
        indices[1, a] = first + j * side
        indices[2, a] = (i + BORDER) * grid_row + j + BORDER
        indices[3, a] = i * influence_row + j
    return list_strips(indices[2], rows, grid_row, strips)


@inlined()
def take_edges(system, listed, edge, shape, gap):
    """Set the compliance and the edges of listed candidates from flat arrays on the window.

    `shape` is the undeformed gap as it continues within cells, `gap` that of the nodes.
    """
    nodes = system.nodes
    edges = system.edges
    place = system.model.node
    left = system.model.softening.reshape(-1)
    stiffness = system.model.stiffness
    per_hardness = 2.0 / system.limits.hardness
    left[:] = 1.0
    for a in range(listed.size):
        k = listed[a]
        nodes.compliance[a] = edge[k] * per_hardness
        edges.edge[a] = edge[k]
        edges.between_nodes[a] = shape[k] - gap[k]
        left[place[a]] = 1.0 / (1.0 + nodes.compliance[a] * stiffness)


@inlined()
def half_range(square, levelled):
    """Return half of the range [m] of the gap over a cell.

    `square` [m2] is the sum of the squares of its differences over two cells, along and across. The
    range is that of a uniform distribution with the variance of the gaps: the gradient times a
    side of the cell. Pressures below the hardness level a small range: up to `levelled` [m] it does
    not count, from twice that on it counts in full, up to STEEPEST times that.
    """
    half = 0.25 * np.sqrt(square)
    return max(min(half, 2.0 * (half - levelled), STEEPEST * levelled), 0.0)


@linked(NOTHING(FIELD, FIELD, NUMBER, NUMBER, FIELD))
def cell_ranges(shape, u, levelled, share, out):
    """Set `out` to a share of half the range [m] of the deflected gap over each cell.

    It is zero on the border of the window.
    """
    rows, columns = u.shape
    out[0] = 0.0
    out[rows - 1] = 0.0
    for i in range(1, rows - 1):
        out[i, 0] = 0.0
        out[i, columns - 1] = 0.0
        ranges_of_row(shape[i - 1 : i + 2], u[i - 1 : i + 2], levelled, share, out[i, 1:-1])


@inlined()
def ranges_of_row(z, u, levelled, share, out):
    """Set a row to a share of half the ranges over its inner cells, from three rows around it."""
    for k in range(out.size):
        along = z[2, k + 1] + u[2, k + 1] - z[0, k + 1] - u[0, k + 1]
        across = z[1, k + 2] + u[1, k + 2] - z[1, k] - u[1, k]
        out[k] = share * half_range(along * along + across * across, levelled)


@inlined()
def move_edges(system, slack):
    """Move the edges of the candidates to the place that the present gaps give them.

    Edges that would move by less than `slack` [m] stay. Returns the maximum change of a gap [m].
    """
    p = system.nodes.p
    g = system.nodes.g
    compliance = system.nodes.compliance
    edge = system.edges.edge
    between_nodes = system.edges.between_nodes
    field = system.edges.field
    place = system.stencil.node
    for k in range(p.size):
        field[place[k]] = g[k] + edge[k] - compliance[k] * p[k] + between_nodes[k]
    return follow_field(system, slack)


@inlined()
def lead_edges(system):
    """Move the edges of the candidates to the place that the gaps of the model give them.

    The gaps of the model follow the edges.
    """
    p = system.nodes.p
    compliance = system.nodes.compliance
    place = system.stencil.node
    edge = system.edges.edge
    between_nodes = system.edges.between_nodes
    field = system.edges.field
    gap = system.model.gap.reshape(-1)
    stiffness = system.model.stiffness
    lifts = system.work.trial
    softness = 1.0 / stiffness
    for k in range(p.size):
        at = place[k]
        # The gap of the model leaves changes by compliance out.
        field[at] = softness * gap[at] + edge[k] - compliance[k] * p[k] + between_nodes[k]
    follow_field(system, 0.0)
    for k in range(p.size):
        gap[place[k]] += stiffness * lifts[k]


@inlined()
def edges_in_field(place, row_length, edges, moved):
    """Set `moved` to the edges that the field of gaps gives; beside unknown gaps they stay."""
    edge = edges.edge
    field = edges.field
    for k in range(moved.size):
        at = place[k]
        along = field[at + row_length] - field[at - row_length]
        across = field[at + 1] - field[at - 1]
        moved[k] = along * along + across * across
    for k in range(moved.size):
        half = edges.share * half_range(moved[k], edges.levelled)
        moved[k] = half if moved[k] == moved[k] else edge[k]


@linked(NUMBER(SYSTEM, NUMBER))
def follow_field(system, slack):
    """Move the edges of the candidates to the place that the field of gaps gives them.

    The edge of a node beside a node that is no candidate stays, and so does an edge that would move
    by less than `slack` [m]. The gaps of the candidates follow the edges, by lifts that are left in
    the trial pressures. Returns the maximum lift [m].

    Loops without branches and with few arrays take several nodes at once.
    """
    p = system.nodes.p
    g = system.nodes.g
    compliance = system.nodes.compliance
    edge = system.edges.edge
    place = system.stencil.node
    lifts = system.work.trial
    edges_in_field(place, system.stencil.row_length, system.edges, lifts)
    per_hardness = 2.0 / system.limits.hardness
    highest = 0.0
    stiffness = system.model.stiffness
    left = system.model.softening.reshape(-1)
    share_left = system.work.r
    for k in range(p.size):
        now = lifts[k] if abs(lifts[k] - edge[k]) > slack else edge[k]
        lifts[k] = (edge[k] - now) * (1.0 - per_hardness * p[k])
        edge[k] = now
    for k in range(p.size):
        g[k] += lifts[k]
    for k in range(p.size):
        compliance[k] = per_hardness * edge[k]
        share_left[k] = 1.0 / (1.0 + compliance[k] * stiffness)
    for k in range(p.size):
        left[place[k]] = share_left[k]
        highest = max(highest, abs(lifts[k]))
    return highest
