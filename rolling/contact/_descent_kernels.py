"""Compiled descent of a contact solve: conjugate gradients on the candidates of a window.

`descend` is the one compiled loop. It makes its system from plain arrays, iterates until the
violation is small enough, and returns the pressures to the window with the load restored.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,arg-type"
from __future__ import annotations

import numpy as np

from rolling.contact import _candidate_kernels as search
from rolling.contact import _direct_kernels as direct
from rolling.contact import _solver_kernels as solver
from rolling.contact import _system as parts
from rolling.contact import _transform_kernels as transforms
from rolling.contact._condition_kernels import project, settle_load
from rolling.contact._far_field import coarse_grid
from rolling.contact._linked import reference
from rolling.contact._system import (
    BORDER,
    OWN_COEFFICIENT,
    Direction,
    Limits,
    Rules,
    Solutions,
    System,
)
from rolling.contact.compiling import inlined, njit

MAX_ITERATIONS = 1000
# A descent ends after so many iterations, so that Python hears an interrupt.
LONGEST = 100
# Sweeps before the far field of the model, first from the extrapolation, then in each iteration.
# With half as many, steps take 0.1 to 0.7 convolutions more.
FIRST_SWEEPS = 8
SWEEPS = 4
# Sweeps in each iteration on blocks of more than so many nodes. With 4 sweeps the last check
# refuses a third of the descents on contacts 600 nodes wide at Ra 1 um; on smaller blocks 6 save
# less time than they take.
WIDE_SWEEPS = 6
WIDE_BLOCK = 300_000
# After so many iterations the preconditioned residual leads instead of the model, whose steps are
# fewer but need not lower the energy.
MODELLED = 15
# From this step length on a step is taken as a whole, so that nodes on their way to a bound arrive.
# The energy still falls, as it does up to twice the best length.
NEARLY_WHOLE = 0.8
# On wide contacts hundreds of nodes stay on their way while the violation stalls, at more than this
# share of its minimum so far. Shorter steps are then taken as a whole.
STALLED = 0.9
NEARLY_WHOLE_STALLED = 0.55
MAX_MOVES = 100  # of the edges in a solve, one in each iteration, before they stay


@inlined()
def vectors(memory, rows, columns):
    """Return an array (rows, columns) of the first numbers of flat memory, and the rest of it."""
    return memory[: rows * columns].reshape(rows, columns), memory[rows * columns :]


@inlined()
def system_of(window, listed, block, numbers, half_space, memory):
    """Return the System of a descent on listed candidates: see `descend` for the arguments.

    Its arrays lie in the memory side by side. Those that only blended edges have are otherwise
    empty.
    """
    p, g, edge, shape, gap = window
    hardness, load, levelled, share, lift = numbers
    stencils, convolution, far_table = half_space
    unit, preconditioner, inverse, centre, own, common = stencils
    entry = convolution[0]
    coefficients = convolution[1]
    doubles, singles, indices, strips, triangle = memory
    rows = block[2] + 2 * BORDER
    columns = block[3] + 2 * BORDER
    blended = edge.size > 0
    compliant = listed.size if blended else 0
    soft_rows = rows if blended else 0
    # Vectors of the candidates: pressure, gap and work vectors, then those of blended edges.
    v, doubles = vectors(doubles, 6, listed.size)
    v[2:6] = 0.0
    edges, doubles = vectors(doubles, 4, compliant)
    # Grids of the preconditioner and of the gaps within cells, and the image of the transforms.
    residuals, doubles = vectors(doubles, 1, rows * columns)
    fields, image = vectors(doubles, 1, soft_rows * columns)
    fields[:] = np.nan
    # Grids of the model; the passes set the first two and the last before they read them.
    grids, singles = vectors(singles, 6, rows * columns)
    grids[2:6] = 0.0
    softening, singles = vectors(singles, soft_rows, columns)
    coarse_rows, coarse_columns, tile = coarse_grid(rows, columns)
    row_length = 2 * coarse_columns - 1
    coarse, _ = vectors(singles, 7, coarse_rows * row_length)
    coarse[:] = 0.0
    index, _ = vectors(indices, 4, listed.size)
    length, side = transforms.row_of(entry, block[3])
    row_lengths = (length, side), columns, 2 * (entry[transforms.WIDTH] // 2) + 1
    corner = (block[0], block[1])
    state = (p.reshape(-1), g.reshape(-1))
    out = (v, index, strips)
    count = search.take_nodes(listed, p.shape[1], corner, row_lengths, rows, state, out)
    if triangle.size:
        direct.collect_triangle(coefficients, index[3], triangle)
        # Direct sums leave the deflections in the order of the candidates, not in the array of the
        # transforms.
        for a in range(listed.size):
            index[1, a] = a
    stiffness = 1 / (unit * OWN_COEFFICIENT)
    system = System(
        parts.Nodes(v[0], v[1], edges[0], edges[1]),
        parts.Transform(image, index[1], unit),
        parts.Stencil(preconditioner, residuals[0], index[2], columns, stiffness),
        parts.Work(v[2], v[3], v[4], v[5], index[0]),
        Limits(hardness, load),
        parts.Edges(edges[2], edges[3], fields[0], levelled, share),
        parts.Model(
            inverse,
            grids[0].reshape(rows, columns),
            grids[1].reshape(rows, columns),
            grids[2].reshape(rows, columns),
            grids[3].reshape(rows, columns),
            grids[4].reshape(rows, columns),
            grids[5].reshape(rows, columns),
            softening,
            index[2],
            strips[:count],
            centre,
            lift,
        ),
        parts.FarField(
            tile,
            row_length,
            own,
            common,
            far_table,
            coarse[0],
            coarse[1],
            coarse[2],
            coarse[3],
            coarse[4],
            coarse[5],
            coarse[6],
        ),
        parts.Influence(coefficients, index[3], triangle),
    )
    if blended:
        search.take_edges(system, listed, edge.reshape(-1), shape.reshape(-1), gap.reshape(-1))
    return system


@inlined()
def sweeps_of(iterations, stuck, nodes):
    """Return the sweeps that settle a model of so many nodes, 0 where it does not lead."""
    if iterations >= MODELLED or stuck:
        return 0
    return WIDE_SWEEPS if nodes > WIDE_BLOCK else SWEEPS


@inlined()
def deflect_direction(system, block, convolution, cells):
    """Set the image to the deflection by the direction."""
    transform = system.transform
    triangle = system.influence.triangle
    d = system.work.d
    if triangle.size:
        direct.multiply_triangle(triangle, d, transform.unit, transform.image)
    else:
        entry, _, kernel = convolution
        nodes = transform.node, cells
        transforms.deflect_nodes(kernel, entry, block, d, transform.unit, transform.image, nodes)


@njit(
    cache=True,
    calls=(
        solver.iterate,
        project,
        settle_load,
        search.list_strips,
        direct.collect_triangle,
        direct.multiply_triangle,
    ),
)
def descend(window, candidates, numbers, half_space, before, aims, progress, memory):
    """Descend by conjugate gradients until the violation is within the goal, stuck or spent.

    It ends after LONGEST iterations at the latest, so that Python hears an interrupt.

    Parameters
    ----------
    window : arrays
        Pressures, which become those of the descent, deformed gaps, edges, which are empty where
        all are sharp, and the undeformed gap as it continues within cells and at the nodes.
    candidates : tuple
        Their flat indices, their block (first row and column, rows and columns), and the number of
        sub-cells along the side of a cell.
    numbers : tuple
        Hardness, sum of the candidates' pressures, levelled range and share of the edges, and the
        violation that counts for a missing sum of pressures.
    half_space : tuple
        Deflection per pressure and coefficient with the fields of Stencils; the numbers that
        describe the transforms, coefficients by distance or none, and the kernel of the transforms
        (see `deflect_nodes`); and the table of the far field.
    before : tuple
        Deflection of the window, pressure and deflection of the position before, and the row and
        column of the window where theirs begin. The last two solutions give the first direction,
        unless the pressure is empty.
    aims : tuple
        Violation that ends the descent, and the violation allowed to the solution [m].
    progress : tuple
        Fields of Progress.
    memory : arrays
        Doubles, singles, indices, strips of the grid, and room for the triangle of coefficients,
        empty where the block is transformed. They are overwritten (see Scratch).

    Returns
    -------
    tuple
        Fields of Progress. The pressures are `exhausted` unless this was the first descent, or one
        that the model led to its last iteration.
    """
    listed, block, subcells = candidates
    goal, allowed = aims
    (
        iterations,
        convolutions,
        restarts,
        plain_steps,
        edge_moves,
        descents,
        stuck,
        load_missed,
        _,
        _,
    ) = progress
    system = reference(system_of(window, listed, block, numbers, half_space, memory))
    convolution = half_space[1]
    pressures = window[0].reshape(-1)
    cells = listed[:0]
    if subcells > 1:
        cells = transforms.cells_of(listed, window[0].shape[1], block, subcells)
    blended = system.nodes.compliance.size > 0
    descents += 1
    direction = Direction(0.0, 0.0, 0.0, solver.FIRST_LENGTH)
    u, p_before, u_before, row, column = before
    nothing = p_before[:0]
    none = Solutions(nothing, nothing, nothing, nothing, row, column, block)
    leading = p_before.size > 0
    if leading:
        solutions = Solutions(window[0], u, p_before, u_before, row, column, block)
        # Literal numbers would make another variant of each kernel that takes them.
        no = not leading
        rules = Rules(NEARLY_WHOLE, 0.0, 0.0, np.int64(FIRST_SWEEPS), no, no)
        step, direction = solver.iterate(system, direction, solutions, rules)
    snap = 0.0 if load_missed else 0.01 * allowed * system.stencil.stiffness
    # The snap is divided by the number of nodes, so that its sum makes no difference.
    share = listed.size
    if direction.slope < 0:
        deflect_direction(system, block, convolution, cells)
        convolutions += 1
        iterations += 1
    minimum = np.inf
    nearly = NEARLY_WHOLE
    end = iterations + LONGEST
    while True:
        last = iterations >= MAX_ITERATIONS
        sweeps = sweeps_of(iterations, stuck, block[2] * block[3])
        edge_moves += blended
        within = np.inf if last else goal
        edges_move = 0 < edge_moves <= MAX_MOVES
        # Where the check refused a last step once, the residual has waves too long for the model.
        finishing = descents == 1 and not last
        rules = Rules(nearly, snap / share, within, sweeps, edges_move, finishing)
        step, direction = solver.iterate(system, direction, none, rules)
        worst = step.worst
        if last or not worst > goal:
            break
        nearly = NEARLY_WHOLE_STALLED if worst > STALLED * minimum else NEARLY_WHOLE
        minimum = min(minimum, worst)
        share = max(step.bound, 1)
        restarts += step.restarts
        plain_steps += step.plain_steps
        model_ends = sweeps and iterations >= MODELLED - 1
        if not direction.slope < 0 or model_ends or iterations >= end:
            iterations += 1
            break
        stuck = 0
        deflect_direction(system, block, convolution, cells)
        convolutions += 1
        iterations += 1
    carried = False
    exhausted = False
    if not step.worst > goal:
        carried = carry(system, step)
        exhausted = descents > 1
        load_missed = load_missed or not carried
    elif not direction.slope < 0:
        exhausted = True
        stuck += 1
        restart(system)
    else:
        settle_load(system.nodes.p, system.nodes.g, system.limits, 0.0)
    for a in range(listed.size):
        pressures[listed[a]] = system.nodes.p[a]
    return (
        iterations,
        convolutions,
        restarts,
        plain_steps,
        edge_moves,
        descents,
        stuck,
        load_missed,
        carried,
        exhausted,
    )


@inlined()
def carry(system, step):
    """Make the pressures carry the load after a descent; tell whether they do so exactly.

    A node that was put on a bound took its share of the load along. The last step or the free nodes
    make up for it, or else the nodes that are nearest to moving.
    """
    nodes = system.nodes
    limits = system.limits
    carried = step.load
    if carried == 0:
        carried = solver.carry_load(nodes, system.work, limits, step.approach)
    if abs(carried / limits.total - 1) <= 1e-13:
        return True
    settle_load(nodes.p, nodes.g, limits, 0.0)
    return False


@inlined()
def restart(system):
    """Replace the pressures by a feasible restart where no step descends.

    Pressures of the order of rounding errors can pass for free nodes and set the approach, so the
    projection becomes the state.
    """
    p = system.nodes.p
    trace = 0.0
    for k in range(p.size):
        p[k] += system.work.d[k]
        trace = max(trace, p[k])
    settle_load(p, system.nodes.g, system.limits, 1e-9 * trace)
