"""Measures of a state are those of plain arrays: gaps, approach, violation, areas and works."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import measures

from rolling.contact import _condition_kernels, _window_kernels

pytestmark = pytest.mark.kernel

HARDNESS = 2e9
LEVELLED = 1e-8
EMPTY = np.empty(0)


def state(seed: int, shape: tuple[int, int] = (9, 13)) -> tuple[np.ndarray, ...]:
    """Return gap, deflection, pressure and edge; a third of the nodes is on each bound."""
    rng = np.random.default_rng(seed)
    pressure = np.clip(rng.uniform(-1, 2, shape), 0, 1) * HARDNESS
    pressure[: seed % 4] = pressure[:, shape[1] - seed % 3 :] = 0.0
    edge = np.where(rng.random(shape) < 0.5, 0.0, rng.random(shape) * 5e-8)
    return rng.normal(size=shape) * 1e-6, rng.random(shape) * 1e-6, pressure, edge


@pytest.mark.parametrize("blended", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_approach_and_violation_are_those_of_plain_arrays(seed: int, blended: bool) -> None:
    gap, u, p, edge = state(seed)
    expected = gap + u - (edge * (1 - 2 * p / HARDNESS) if blended else 0.0)
    free = (p > 0) & (p < HARDNESS)
    approach = expected[free].mean()
    violation = np.where(p > 0, expected - approach, -np.inf)
    violation = np.maximum(violation, np.where(p < HARDNESS, approach - expected, -np.inf))
    flat = [x.ravel() for x in (gap, u, p)]
    g = np.empty(p.size)
    got = _condition_kernels.state_of(*flat, edge.ravel() if blended else EMPTY, HARDNESS, g, True)
    np.testing.assert_allclose(g, expected.ravel(), rtol=1e-13, atol=1e-21)
    assert got == pytest.approx((approach, u.max(), violation.max()), rel=1e-12)
    load = _condition_kernels.worst_and_load(p.ravel(), g, got[0], HARDNESS)[1]
    assert load == pytest.approx(p.sum(), rel=1e-13)


def test_approach_without_a_free_node_is_the_middle_of_the_bounds() -> None:
    p = np.array([0.0, HARDNESS, 0.0, HARDNESS])
    g = np.array([4e-6, 1e-6, 3e-6, 2e-6])
    assert _condition_kernels.approach_of(p, g, HARDNESS) == pytest.approx(2.5e-6)
    assert _condition_kernels.approach_of(p[1::2], g[1::2], HARDNESS) == 2e-6  # no node is open


@pytest.mark.parametrize("node", [0, 5])
def test_a_gap_that_is_no_number_is_no_state(node: int) -> None:
    """Not even on an open node, whose gap counts for nothing else."""
    gap, u, p, _ = (x.ravel() for x in state(3))
    assert p[node] == 0.0
    u[node] = np.nan
    g = np.empty(p.size)
    _, u_max, worst = _condition_kernels.state_of(gap, u, p, EMPTY, HARDNESS, g, True)
    assert np.isnan(u_max) and worst == np.inf


@pytest.mark.parametrize("blended", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_measures_of_loaded_nodes_are_those_of_plain_arrays(seed: int, blended: bool) -> None:
    _, u, p, edge = state(seed)
    crosses = (p > 0) & (p < HARDNESS) & (edge > 0) & blended
    with np.errstate(invalid="ignore"):
        crossed = np.where(crosses, edge / np.maximum(edge, 0.5 * edge + LEVELLED), 0.0)
    share = p / HARDNESS
    rows, columns = np.nonzero(p)
    centre = (6.3, 4.8)
    reach = 17.0
    along, across = np.mgrid[: p.shape[0], : p.shape[1]] - np.reshape(centre, (2, 1, 1))
    moment = np.hypot((p * along).sum(), (p * across).sum())
    square = (p * (along**2 + across**2)).sum() + 2 * reach * moment
    expected = (
        ((p > 0) - crossed * (1 - share)).sum(),
        ((p >= HARDNESS) + crossed * share).sum(),
        p.max(),
        (p * u).sum(),
        np.sqrt(square / p.sum() + 1),
    )
    edge = edge if blended else np.empty((0, 0))
    got = measures(p, u, HARDNESS, edge, LEVELLED, *centre, reach)
    assert got[:5] == pytest.approx(expected, rel=1e-12)
    assert got[5:] == (rows.min(), rows.max(), columns.min(), columns.max())


@pytest.mark.parametrize("left_end", [False, True])
@pytest.mark.parametrize("offset", [(0, 0), (2, -3), (-4, 1), (20, 0)])
def test_work_of_nodes_is_that_of_plain_arrays(offset: tuple[int, int], left_end: bool) -> None:
    _, u_old, p_old, _ = state(1)
    _, u_new, p_new, _ = state(2)
    expected = np.zeros_like(p_new)
    for i, j in np.ndindex(p_old.shape):
        a = i + offset[0]
        b = j + offset[1]
        if 0 <= a < expected.shape[0] and 0 <= b < expected.shape[1]:
            p = p_old[i, j] if left_end else (p_old[i, j] + p_new[a, b]) / 2
            expected[a, b] = p * (u_old[i, j] - u_new[a, b]) * 4e-12
    work = np.full_like(expected, np.nan)
    sums = _window_kernels.node_work((p_old, u_old), offset, (p_new, u_new), left_end, 4e-12, work)
    np.testing.assert_allclose(work, expected, rtol=1e-12, atol=1e-22)
    assert sums == pytest.approx((expected.clip(min=0).sum(), -expected.clip(max=0).sum()))


@pytest.mark.parametrize("loaded", [(), (0,), (39,), (5, 21), (16, 31), (15, 32), (0, 39)])
def test_range_of_loaded_nodes(loaded: tuple[int, ...]) -> None:
    """Any node may be the first or the last, in a row longer than what is searched at once."""
    row = np.zeros(40)
    row[list(loaded)] = 1e-300 * (-1.0) ** np.arange(len(loaded))  # their sum is no measure
    first, end = _window_kernels.loaded_range(row)
    assert (first, end) == (loaded[0], loaded[-1] + 1) if loaded else first == end


@pytest.mark.parametrize("seed", range(4))
def test_overlap_at_the_hardness_is_that_of_plain_arrays(seed: int) -> None:
    gap, u, p, edge = state(seed)
    capped = p >= HARDNESS
    flat = [x.ravel() for x in (gap, u, p)]
    approach = 2e-7
    expected = max(float((approach - gap - u)[capped].max()), 0.0)
    overlap = _condition_kernels.yielding_overlap(*flat, HARDNESS, approach, np.inf)
    assert overlap == pytest.approx(expected, rel=1e-12)
    assert _condition_kernels.yielding_overlap(*flat, HARDNESS, approach, 1e-9) >= 1e-9
    assert _condition_kernels.yielding_overlap(*flat, np.inf, approach, np.inf) == 0.0
    partial = (edge > 0) & (p > 0) & ~capped
    assert _condition_kernels.has_partial_cells(p.ravel(), edge.ravel(), HARDNESS) == partial.any()
    assert not _condition_kernels.has_partial_cells(p.ravel(), 0 * edge.ravel(), HARDNESS)
