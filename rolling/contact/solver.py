"""Contact solve: pressures between 0 and the hardness on a window, under a given load.

It minimizes 1/2 p.Cp + e.p over p subject to 0 <= p <= H and sum(p) dA = W, by conjugate gradients
projected on both bounds, after Polonsky & Keer, Wear 231 (1999). The solver differs from the paper
in four points: a sparse model problem and its far field on a coarse grid precondition and predict
which nodes go to a bound, these nodes are put on it at once, each trial pressure is made feasible
before its single convolution, after which the step along it is exact, and the last step goes into
the final check without a convolution of its own.

`converge` is the algorithm: judge the state, list the candidates, descend on them, and check on the
whole window. The descent runs in single precision on candidate nodes only: it sums the deflection
directly over few of them, and transforms the block of more. A solution is accepted after a
double-precision check on the full window.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.contact import _condition_kernels
from rolling.contact import _position_kernels as kernels
from rolling.contact._candidate_kernels import STRIP, candidates
from rolling.contact._condition_kernels import has_partial_cells, yielding_overlap
from rolling.contact._descent_kernels import MAX_ITERATIONS, descend
from rolling.contact._direct_kernels import is_direct
from rolling.contact._far_field import coarse_grid, far_field, stencils
from rolling.contact._system import BORDER, OWN_COEFFICIENT, Limits, Progress, Sets
from rolling.contact._transform_kernels import nodes_kernel
from rolling.contact.half_space import Convolution, HalfSpace
from rolling.contact.scratch import Scratch

# The descent aims at this share of the tolerance. The rest allows for the difference between the
# updated deflection and a recomputed deflection.
AIM = 0.98
# The first descent of a solve aims at this multiple, and at the second one where the model moves
# edges. Its last step needs no convolution of its own and leaves a fifth of the violation.
# Multiples of 5 take 0.1 convolutions less, but leave up to 3 dB more error of the release, and so
# does a multiple of 3 where the model moves edges and the window is 190 nodes wide (100 N).
AIM_FIRST = 3.0
AIM_FIRST_LED = 2.5
# Candidates for contact have a gap below this share of the maximum deflection; shares from 0.001 to
# 0.1 take the same number of iterations.
NEAR = 0.01
# Nodes at the hardness rest beyond so many times the reach of the open candidates. With 1 the last
# check refuses more descents, above all on sub-cells; with 8 the candidates are up to 14 % more.
REST = 4
# Single precision serves no tighter tolerance: its error is typically 1e-7 of the maximum
# deflection by transforms, and 2e-7 by direct sums.
SINGLE_TOLERANCE = 1e-6
# Share of the maximum gap that its rounding adds to the violation. Below 32 eps some solves still
# converge, so the limit that is named is four times that.
ROUNDING = 128 * np.finfo(float).eps
# This share of a node's deflection by the hardness on its own cell is the half range of gaps within
# the cell that pressures below the hardness level. At 0.15 to 0.3 scenes that hardly yield keep the
# error of sharp edges (measured on three scenes, by 0.3 dB); at 0 the rims of elastic contact grow
# soft.
LEVELLED = 0.3
_NOTHING = np.empty((0, 0))
NO_POSITION = _NOTHING, _NOTHING, 0, 0


class ContactError(RuntimeError):
    """Error of a contact that cannot be solved.

    It tells the limit in numbers, or the methods tried and the residual that they reached.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> steel, flat = rolling.HalfSpace(1e-6, 230e9), np.zeros((8, 8))
    >>> rolling.solve_contact(steel, flat, load=1.0, hardness=2e9)
    Traceback (most recent call last):
    rolling.contact.solver.ContactError: a load of 1 N is more than the surface can carry: ...
    """


class ConvergenceError(ContactError):
    """Error of a solve whose iterations led nowhere."""


def levelled_range(half_space: HalfSpace, hardness: float) -> float:
    """Return half of the range of gaps over a cell [m] that pressures below the hardness level."""
    return LEVELLED * float(half_space.unit * OWN_COEFFICIENT * hardness)


def foundation(
    gap: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf
) -> Array:
    """Solve a contact on a Winkler foundation of a stiffness [Pa/m]; return its pressure [Pa].

    A stiffness of 4 E* / (pi a) fits a Hertz contact of radius a.
    """
    total = load / spacing**2
    area = gap.size * spacing**2
    if total > hardness * gap.size:
        raise ContactError(
            f"a load of {rounded(load, 6)} N is more than the surface can carry: hardness"
            f" {rounded(hardness, 6)} Pa times {rounded(area, 4)} m2"
            f" is {rounded(hardness * area, 4)} N"
        )
    e = np.ascontiguousarray(gap, dtype=float).ravel()
    limits = Limits(float(hardness), float(total))
    free = Sets(np.arange(e.size, dtype=np.uint32), e.size, 0)
    pressure = np.empty_like(e)
    slope, _ = _condition_kernels.project(
        np.zeros_like(e), e, 0.0, -stiffness * e, free, limits, pressure
    )
    # Heights may be so large that rounding of the springs loses the load. The lowest nodes then
    # carry it.
    if slope == np.inf:
        pressure[:] = 0.0
        _condition_kernels.settle_load(pressure, e, limits, 0.0)
    return pressure.reshape(gap.shape)


@dataclass(frozen=True)
class ContactPlate:
    """All that the solves of a march have in common.

    Parameters
    ----------
    half_space : HalfSpace
        Pressure to deflection.
    hardness : float, Pa
        Maximum pressure.
    single : bool
        Whether single precision may serve.
    blended : bool
        Whether edges of patches at the hardness may end within cells.
    levelled : float, m
        Half the range of gaps over a cell that pressures level (see `levelled_range`).
    scratch : Scratch
        Memory of the march.
    """

    half_space: HalfSpace
    hardness: float
    single: bool
    blended: bool
    levelled: float
    scratch: Scratch = field(default_factory=Scratch)


@dataclass(frozen=True)
class Problem:
    """Contact on its window, under its load.

    Parameters
    ----------
    plate : ContactPlate
        Half-space and hardness.
    gap, shape : (m, n) arrays, m
        Undeformed gap at the nodes, and as it continues within cells.
    total : float, Pa
        Sum of the pressures that carries the load.
    tolerance : float
        Maximum KKT residual.
    """

    plate: ContactPlate
    gap: Array
    shape: Array
    total: float
    tolerance: float


@dataclass(frozen=True)
class Start:
    """Pressures that a solve begins with, and overwrites.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Pressure that carries the load to rounding.
    deflection : (m, n) array, m
        Deflection by it, empty where it is unknown.
    close : bool
        Whether the start is close to the solution.
    before : tuple
        Pressure and deflection at the position before, and the row and column of the window where
        theirs begin. The deflection is extrapolated from them, unless they are empty.
    """

    pressure: Array
    deflection: Array
    close: bool
    before: tuple[Array, Array, int, int] = NO_POSITION


@dataclass
class Solution:
    """State of a solve on its window, in the end the solution.

    The violation of the contact conditions, `worst` [m], is infinite while the deflection is not
    that of the pressure. Edges are empty unless they may be blended, and zero where they are sharp.
    """

    pressure: Array
    deflection: Array
    edge: Array
    edge_share: float = 0.0
    approach: float = 0.0
    max_deflection: float = 0.0
    worst: float = np.inf
    iterations: int = 0
    convolutions: int = 0


def solve(problem: Problem, start: Start, sharp: bool) -> Solution:
    """Solve a contact, with blended edges where it yields and with sharp edges elsewhere.

    Between both the maximum overlap at the hardness, over the half range that pressures level, is
    the share of their range that edges take. It is the overlap of the solution with whole edges, so
    that the contact follows continuously from its surface and load. The first solve has sharp edges
    if `sharp`, else whole ones.
    """
    shape = problem.gap.shape
    solution = Solution(
        pressure=start.pressure,
        deflection=np.empty(shape),
        edge=np.zeros(shape) if problem.plate.blended else _NOTHING,
        edge_share=0.0 if sharp else 1.0,
    )
    converge(problem, solution, start)
    if not problem.plate.blended:
        return solution
    sharp_solution = None
    if sharp:
        # No contact is known to yield with blended edges that does not yield with sharp edges.
        if solution.pressure.max() < problem.plate.hardness:
            return solution
        sharp_solution = _copy(solution)
        solution.edge_share = 1.0
        converge(problem, solution)
    share = _share_of_edges(problem, solution)
    if share == 1.0:
        return solution
    solution.edge_share = share
    if share == 0.0:
        solution.edge[:] = 0.0
        if sharp_solution is not None:
            _restore(solution, sharp_solution)
            return solution
    converge(problem, solution)
    return solution


def _copy(solution: Solution) -> Solution:
    """Return a copy of a solution that keeps its arrays."""
    return replace(
        solution, pressure=solution.pressure.copy(), deflection=solution.deflection.copy()
    )


def _restore(solution: Solution, earlier: Solution) -> None:
    """Return to an earlier solution; iterations and convolutions count on."""
    solution.pressure = earlier.pressure
    solution.deflection = earlier.deflection
    solution.approach = earlier.approach
    solution.max_deflection = earlier.max_deflection
    solution.worst = earlier.worst


def _share_of_edges(problem: Problem, solution: Solution) -> float:
    """Return the share of their range that edges take, from the solution with whole edges."""
    gap = problem.gap.reshape(-1)
    edge = solution.edge.reshape(-1)
    p = solution.pressure.reshape(-1)
    u = solution.deflection.reshape(-1)
    levelled = problem.plate.levelled
    overlap = yielding_overlap(gap, u, p, problem.plate.hardness, solution.approach, levelled)
    if overlap >= levelled or not has_partial_cells(p, edge, problem.plate.hardness):
        return 1.0
    return float(overlap / levelled)


def converge(problem: Problem, solution: Solution, start: Start | None = None) -> None:
    """Iterate until the contact conditions hold, from a start or from a solution with other edges.

    Raise ContactError as `solve_contact` does.
    """
    p = solution.pressure
    edge = solution.edge if solution.edge_share else _NOTHING
    deformed = problem.plate.scratch.array("deformed gap", p.shape)
    # The deflection of a start is known to single precision or so. That of a state which is to be
    # accepted is computed from its pressure: it is fresh.
    known = start is not None and start.deflection.size > 0
    fresh = start is None
    progress = Progress()
    count = 0
    earlier = solution.iterations
    while True:
        if not (known or fresh):
            problem.plate.half_space.deflect(p, solution.deflection)
            solution.convolutions += 1
            fresh = True
        u = solution.deflection
        before = NO_POSITION
        if known and start is not None:
            u = start.deflection
            before = start.before
        solution.approach, solution.max_deflection, solution.worst = kernels.judge(
            (problem.gap, problem.shape),
            (p, u, edge),
            before,
            (problem.plate.hardness, problem.plate.levelled, solution.edge_share),
            fresh,
            deformed,
        )
        _refuse_strange(solution, fresh)
        allowed = problem.tolerance * solution.max_deflection
        accurate = fresh and solution.worst <= allowed
        if accurate and (progress.carried or _carries_load(p, problem.total)):
            return
        spent = progress.iterations >= MAX_ITERATIONS or progress.descents > MAX_ITERATIONS
        if spent or progress.stuck > 1:
            raise _not_converged(problem, solution, progress)
        near_only = start is None or start.close or progress.descents > 0
        candidates = _candidates(problem, solution, (deformed, edge), near_only)
        # Where a descent went as far as it could and left no new candidates, single precision does
        # not suffice.
        single = problem.plate.single and problem.tolerance >= SINGLE_TOLERANCE
        if progress.exhausted and candidates.listed.size <= count:
            single = single and edge.size > 0 and progress.descents <= 4
        fields = p, deformed, edge, problem.shape, problem.gap
        done = _descend(problem, solution, fields, candidates, (u, *before), progress, single)
        convolved = done.convolutions - progress.convolutions
        problem.plate.half_space.count += convolved
        solution.convolutions += convolved
        solution.iterations = earlier + done.iterations
        progress = done
        count = candidates.listed.size
        known = False
        fresh = False


def _refuse_strange(solution: Solution, fresh: bool) -> None:
    """Raise ContactError for a state whose numbers are not finite."""
    finite = math.isfinite(solution.approach) and 0 < solution.max_deflection < np.inf
    if not finite or (fresh and solution.worst == np.inf):
        raise ContactError(
            "the contact solve met numbers that are not finite: check units of load, modulus and"
            " heights"
        )


@dataclass(frozen=True)
class Candidates:
    """Nodes of a window that may be in contact, the iteration's only ones.

    Parameters
    ----------
    listed : (n,) array
        Flat indices in the window.
    block : tuple
        First row and column, and numbers of rows and columns of the block that holds them, in whole
        cells.
    at_rest : float
        Number of nodes that stay at the hardness meanwhile.
    """

    listed: NDArray[np.int64]
    block: tuple[int, int, int, int]
    at_rest: float


def _candidates(
    problem: Problem, solution: Solution, fields: tuple[Array, Array], near_only: bool
) -> Candidates:
    """List the nodes that may move, or all where the state is far from the solution.

    `fields` are the deformed gap and the edges.
    """
    deformed, edge = fields
    near = NEAR * solution.max_deflection if near_only else np.inf
    listed = problem.plate.scratch.array("listed nodes", (deformed.size,), np.int64)
    at_rest, count, *block = candidates(
        solution.pressure,
        deformed,
        problem.plate.hardness,
        solution.approach - REST * near,
        solution.approach + near,
        edge.size > 0,
        problem.plate.half_space.subcells,
        listed,
    )
    row, column, rows, columns = block
    return Candidates(listed[:count], (row, column, rows, columns), at_rest)


def _descend(
    problem: Problem,
    solution: Solution,
    fields: tuple[Array, ...],
    candidates: Candidates,
    before: tuple[Any, ...],
    progress: Progress,
    single: bool,
) -> Progress:
    """Descend on candidates, after all that it takes is made; return the progress.

    `fields` and `before` are arguments of the compiled `descend`.
    """
    half_space = problem.plate.half_space
    edge = fields[2]
    rows, columns = candidates.block[2:]
    # The name keeps the transforms, which a march in another thread may drop meanwhile.
    transforms = half_space.convolution(rows - 1, columns - 1, single)
    tables, memory = _tables(half_space, problem.plate.scratch, transforms, candidates)
    load = problem.total
    if candidates.at_rest:
        load -= candidates.at_rest * problem.plate.hardness
    lift = solution.max_deflection / problem.total
    allowed = problem.tolerance * solution.max_deflection
    goal = _aim(progress, edge.size > 0 and half_space.subcells == 1) * allowed
    answer = descend(
        fields,
        (candidates.listed, candidates.block, half_space.subcells),
        (problem.plate.hardness, load, problem.plate.levelled, solution.edge_share, lift),
        tables,
        before,
        (goal, allowed),
        tuple(progress),
        memory,
    )
    return Progress(*answer)


def _carries_load(pressure: Array, total: float) -> bool:
    """Tell whether pressures carry the load to rounding."""
    return bool(abs(kernels.carried_by(pressure) / total - 1) <= 1e-12)


def _aim(progress: Progress, model_moves_edges: bool) -> float:
    """Return the share of the allowed violation that the next descent aims at."""
    if progress.descents:
        return AIM
    return AIM_FIRST_LED if model_moves_edges else AIM_FIRST


def _tables(
    half_space: HalfSpace, scratch: Scratch, transforms: Convolution, candidates: Candidates
) -> tuple[tuple[Any, ...], tuple[Array, ...]]:
    """Make all that a descent on a block of candidates needs; return its tables and memory.

    The tables are the argument `half_space` of `descend`: stencils, transforms, and the far field.
    """
    count = candidates.listed.size
    (rows, columns) = candidates.block[2:]
    coefficients = transforms.influence()
    kernel = nodes_kernel(half_space.subcells, transforms.single)
    along = rows + 2 * BORDER
    across = columns + 2 * BORDER
    coarse_rows, coarse_columns, tile = coarse_grid(along, across)
    tables = (
        (half_space.unit, *stencils(half_space.unit)),
        (transforms.planned_entry(rows), coefficients, kernel),
        far_field(coarse_rows, coarse_columns, tile),
    )
    pairs = 0
    if _sums_directly(transforms, count):
        pairs = count * (count + 1) // 2
    size = along * across
    coarse_size = 2 * coarse_rows * coarse_columns
    places = max(transforms.real.size, rows * columns)
    memory = (
        scratch.array("doubles", (10 * count + 2 * size + places,)),
        scratch.array("singles", (7 * (size + coarse_size),), np.float32),
        scratch.array("indices", (4 * count,), np.uint32),
        scratch.array("strips", (size // STRIP + 1, 2), np.uint64),
        scratch.array("triangle", (pairs,), np.float32),
    )
    return tables, memory


def _sums_directly(transforms: Convolution, count: int) -> bool:
    """Tell whether a descent sums over pairs of candidates instead of transforming their block.

    Direct sums are in single precision, so a descent in double precision does not take them. They
    need coefficients by distance, which sub-cells and large transforms do not have.
    """
    has_coefficients = transforms.influence().size > 0
    return transforms.single and has_coefficients and is_direct(count, transforms.real.size)


def _not_converged(problem: Problem, solution: Solution, progress: Progress) -> ContactError:
    """Make the error of a solve that stopped, with the tolerance that rounding of gaps allows."""
    highest = float(np.abs(problem.gap).max())
    u_max = solution.max_deflection
    tolerance = problem.tolerance
    limit = ROUNDING * highest / u_max
    text = (
        f"the contact solve stopped after {solution.iterations} iterations at a residual of"
        f" {rounded(solution.worst / u_max)}, {rounded(tolerance)} was asked for (tried:"
        f" preconditioned conjugate gradients, {progress.restarts} restarts,"
        f" {progress.plain_steps} plain gradient steps)"
    )
    if tolerance <= limit:
        text += (
            f"; gaps of up to {rounded(highest)} m, rounded in double precision, need a tolerance"
            f" of at least {rounded(limit)} for a deflection of {rounded(u_max)} m"
        )
    return ConvergenceError(text)
