"""The model problem of the contact solve: its stencil, its sweeps and the projection.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numpy as np
import pytest

from rolling.contact import _condition_kernels, _model_kernels, _window_kernels
from rolling.contact._far_field import LONGEST_WAVE, inverse_stencil, square_stencil
from rolling.contact._system import Limits, Model, Nodes, Sets
from rolling.contact.half_space import love

pytestmark = pytest.mark.kernel

SIDE = 14  # nodes along the side of a grid, with its border
INNER = slice(2, -2)  # nodes that move


def kernel() -> np.ndarray:
    """Return the 5 x 5 stencil over its centre."""
    return square_stencil() / inverse_stencil()[0]


def pressures_of(moves: np.ndarray) -> np.ndarray:
    """Return the changes of pressure by changes of gap, on the nodes that move."""
    padded = np.pad(moves, 2)
    stencil = kernel()
    n, m = moves.shape
    return sum(stencil[a, b] * padded[a : a + n, b : b + m] for a in range(5) for b in range(5))


def model(seed: int, compliant: bool = False, side: int = SIDE) -> Model:
    """Return a model problem of random gaps and bounds that enclose no change."""
    rng = np.random.default_rng(seed)
    change, gap, low, high, moved = np.zeros((5, side, side), np.float32)
    gap[INNER, INNER] = rng.normal(size=(side - 4, side - 4))
    low[3:-3, 3:-3] = -rng.random((side - 6, side - 6))
    high[3:-3, 3:-3] = rng.random((side - 6, side - 6))
    softening = rng.uniform(0.2, 1, (side, side)) if compliant else np.empty((0, side))
    return Model(
        values=(inverse_stencil() / inverse_stencil()[0]).astype(np.float32),
        change=change,
        gap=gap,
        low=low,
        high=high,
        moved=moved,
        following=np.zeros((side, side), np.float32),
        softening=softening.astype(np.float32),
        node=np.zeros(0, np.uint32),
        strips=np.array([[2 * side, (side - 2) * side]], np.uint64),
        stiffness=1.0,
        lift=0.0,
    )


def energy(state: Model, start: np.ndarray) -> float:
    """Return the energy of the gaps, which the solution of the model problem minimizes."""
    gap, low, high = (x[INNER, INNER].astype(float) for x in (state.gap, state.low, state.high))
    moves = gap - start
    bounds = np.maximum(-low * gap, -high * gap)
    return float(0.5 * np.sum(moves * pressures_of(moves)) + bounds.sum())


@pytest.mark.parametrize(("shortest", "longest", "most"), [(3, 8, 0.11), (3, LONGEST_WAVE, 0.7)])
def test_stencil_inverts_the_half_space(shortest: int, longest: int, most: float) -> None:
    """Waves of 3 to 8 nodes come back within 10 %; long waves come back up to 60 % too high."""
    nodes = 240
    distance = np.minimum(np.arange(nodes), nodes - np.arange(nodes))
    spectrum = np.fft.rfft2(love(distance, distance)).real
    wrapped = np.zeros((nodes, nodes))
    at = np.arange(-2, 3)
    wrapped[at[:, None], at] = kernel() * inverse_stencil()[0]
    frequency = np.hypot(np.fft.fftfreq(nodes)[:, None], np.fft.rfftfreq(nodes))
    counted = (frequency >= 1 / longest) & (frequency <= 1 / shortest)
    error = (np.fft.rfft2(wrapped).real * spectrum)[counted] - 1
    assert np.abs(error).max() < most
    assert np.sqrt(np.mean(error**2)) < 0.065


def test_stencil_lets_sweeps_converge() -> None:
    """Jacobi sweeps lower the energy where no eigenvalue of the stencil exceeds 2."""
    wrapped = np.zeros((64, 64))
    at = np.arange(-2, 3)
    wrapped[at[:, None], at] = kernel()
    symbol = np.fft.rfft2(wrapped).real
    assert symbol.min() > 0
    assert symbol.max() < 2


@pytest.mark.parametrize("offset", [(0, 0), (2, -3), (-4, 5), (9, 1), (30, 0), (0, -30)])
def test_changes_are_those_since_the_previous_position(offset: tuple[int, int]) -> None:
    """Off the previous window pressures began at 0, and deflections count as unchanged."""
    rng = np.random.default_rng(4)
    state = model(5)
    p, u = rng.random((2, 13, 11))
    p_before, u_before = rng.random((2, 9, 10))
    row, column, rows, columns = block = (3, 2, SIDE - 6, SIDE - 6)
    inner = slice(3, -3)
    nodes = np.s_[row : row + rows, column : column + columns]
    at = np.arange(SIDE * SIDE, dtype=np.uint32).reshape(SIDE, SIDE)[inner, inner].ravel()
    held = p[nodes].ravel()
    gaps = state.gap[inner, inner].astype(float)
    free = Nodes(held, np.zeros_like(held), np.empty(0), np.empty(0))
    scratch = np.empty_like(held), np.empty_like(held)
    approach = _model_kernels.extrapolate_model(
        state._replace(node=at, stiffness=2.0),
        free,
        np.inf,
        0.5,
        (p, u, p_before, u_before, *offset, block),
        *scratch,
    )
    known = np.zeros((13, 11))
    _window_kernels.copy_block(p_before, known, *offset, False)
    change = (p - known)[nodes]
    known[:] = 0.0
    _window_kernels.copy_block(u_before, known, *offset, False)
    opened = np.where(known > 0, 2.0 * (u - known), 0.0)[nodes]
    np.testing.assert_allclose(state.change[inner, inner], change, atol=1e-6)
    np.testing.assert_allclose(state.gap[inner, inner], gaps + opened, atol=1e-6)
    following = held + change.ravel()
    heights = (gaps + opened).ravel() / 2.0
    assert approach == pytest.approx(0.5 + heights[following > 0].mean(), abs=1e-6)


@pytest.mark.parametrize("compliant", [False, True])
@pytest.mark.parametrize("side", [SIDE, 3 * SIDE])
def test_sweep_is_that_of_plain_arrays(compliant: bool, side: int) -> None:
    """Sweeps over the grid as one long row equal sweeps in double precision to 1e-5.

    The long row of the larger grid is summed in two parts.
    """
    state = model(1, compliant, side)
    assert (state.gap.size > _model_kernels.CHUNK) == (side > SIDE)
    change, gap = (x[INNER, INNER].astype(float) for x in (state.change, state.gap))
    low = state.low[INNER, INNER]
    high = state.high[INNER, INNER]
    share = state.softening[INNER, INNER] if compliant else 1.0
    for _ in range(3):
        moves = np.clip((change - gap) * share, low, high) - change
        gap = gap + moves
        change = change + pressures_of(moves)
    _model_kernels.settle_model(state, 3)
    np.testing.assert_allclose(state.change[INNER, INNER], change, rtol=0, atol=1e-5)
    np.testing.assert_allclose(state.gap[INNER, INNER], gap, rtol=0, atol=1e-5)
    border = np.ones((side, side), bool)
    border[INNER, INNER] = False
    assert not state.gap[border].any()


@pytest.mark.parametrize("compliant", [False, True])
def test_sweeps_over_strips_leave_all_other_nodes_at_rest(compliant: bool) -> None:
    """Nodes of strips move as in plain arrays, by columns of the stencil within their strip."""
    state = model(3, compliant)
    first = 2 * SIDE
    last = (SIDE - 2) * SIDE
    strips = np.array([[first + 5, first + 69], [last - 37, last]])
    state = state._replace(strips=strips.astype(np.uint64))
    change, gap = (x.astype(float).ravel() for x in (state.change, state.gap))
    low = state.low.ravel()
    high = state.high.ravel()
    share = state.softening.ravel() if compliant else 1.0
    inside = np.zeros(SIDE**2, bool)
    for a, b in strips:
        inside[a:b] = True
    column = np.arange(SIDE**2) % SIDE
    inner = (column >= 2) & (column < SIDE - 2)
    stencil = kernel()
    for _ in range(3):
        moves = np.where(inside, np.clip((change - gap) * share, low, high) - change, 0.0)
        moves[~inner] = 0.0
        padded = np.pad(moves, 2 * SIDE)
        for a, b in strips:
            sums = np.zeros((5, b - a + 4))  # along the columns of the stencil
            for c, r in np.ndindex(5, 5):
                at = a + 2 * SIDE + (r - 2) * SIDE
                sums[c, 2:-2] += stencil[r, c] * padded[at : at + b - a]
            change[a:b] += sum(sums[c, c : c + b - a] for c in range(5))
        gap += moves
        change[~inner] = 0.0
        gap[~inner & inside] = 0.0
    _model_kernels.settle_model(state, 3)
    got_change = state.change.ravel()
    got_gap = state.gap.ravel()
    np.testing.assert_allclose(got_change[inner], change[inner], rtol=0, atol=1e-5)
    np.testing.assert_allclose(got_gap[inner], gap[inner], rtol=0, atol=1e-5)
    assert not got_change[~inside].any()


@pytest.mark.parametrize("seed", [1, 2])
def test_sweeps_lower_the_energy_and_settle(seed: int) -> None:
    """Each sweep lowers the energy; in the end each node has a closed gap or is on a bound."""
    state = model(seed)
    start = state.gap[INNER, INNER].astype(float)
    energies = [energy(state, start)]
    for _ in range(12):
        _model_kernels.settle_model(state, 1)
        energies.append(energy(state, start))
    falls = -np.diff(energies)
    assert (falls > -1e-5).all()
    assert falls[0] > 0.1
    _model_kernels.settle_model(state, 60)
    change = state.change[INNER, INNER]
    gap = state.gap[INNER, INNER]
    settled = np.clip(change - gap, state.low[INNER, INNER], state.high[INNER, INNER])
    np.testing.assert_allclose(change, settled, rtol=0, atol=1e-4)
    np.testing.assert_allclose(change, pressures_of(gap - start), rtol=0, atol=1e-5)


def test_projection_is_the_nearest_feasible_pressure() -> None:
    """It is the trial plus one shift within the bounds, carries the load, and spares the rest."""
    rng = np.random.default_rng(5)
    n = 60
    free = 40
    bound = 5
    p = rng.uniform(0, 1, n)
    limits = Limits(1.0, float(p.sum()))
    order = rng.permutation(n).astype(np.uint32)
    trial = rng.normal(0.4, 1, n)
    direction = np.empty(n)
    trial[order[free : free + bound]] = 1.0
    asked = trial.copy()
    moving = order[:free]
    sets = Sets(order, free, bound)
    slope, longest = _condition_kernels.project(
        p, rng.normal(size=n), 0.1, trial, sets, limits, direction
    )
    assert np.isfinite(slope)
    assert longest >= 1
    after = p + direction
    assert after.sum() == pytest.approx(limits.total, rel=1e-14)
    assert after.min() >= -1e-15
    assert after.max() <= 1 + 1e-15
    assert not direction[order[free + bound :]].any()
    np.testing.assert_allclose(after[order[free : free + bound]], 1.0, rtol=0, atol=1e-15)
    inside = moving[(after[moving] > 1e-9) & (after[moving] < 1 - 1e-9)]
    shift = after[inside] - asked[inside]
    assert np.ptp(shift) < 1e-12
    np.testing.assert_allclose(
        after[moving], np.clip(asked[moving] + shift[0], 0, 1), rtol=0, atol=1e-12
    )
