"""Pieces of a march in lockstep against the march, and grids of many pieces against the kernels."""

import sys

import gpu_trial
import numpy as np
import pytest
from lockstep import grids
from lockstep.compiled import CompiledBatch
from lockstep.compiled_passes import ACCEPTED, APPROACH, OUTSIDE
from lockstep.interface import follow
from lockstep_trial import APART, Task, contact_of, half_space_for, judge

from rolling.contact import _far_field as far
from rolling.contact import _model_kernels as model
from rolling.contact._system import BORDER, Model
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.state import Window

RANDOM = np.random.default_rng(7)


def uncompiled(kernel):
    """Return the function of a kernel."""
    return getattr(kernel, "py_func", kernel)


def test_many_convolutions_at_once_are_those_of_the_half_space() -> None:
    half_space = HalfSpace(2e-6, 230e9)
    pressure = RANDOM.random((3, 9, 14)).astype(np.float32)
    factors = grids.spectrum(np, 9, 14, half_space.unit)
    deflection = grids.deflect(np, pressure, factors)
    for one, own in zip(pressure, deflection, strict=True):
        expected = half_space.deflection(one.astype(float))
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-6 * expected.max())


@pytest.mark.parametrize("sweeps", [1, 4])
def test_sweeps_of_many_grids_are_those_of_the_model(sweeps: int) -> None:
    shape = (2, 12, 11)
    inner = (slice(None), slice(BORDER, -BORDER), slice(BORDER, -BORDER))
    change, gap, low, high = (np.zeros(shape, np.float32) for _ in range(4))
    for grid in (change, gap):
        grid[inner] = RANDOM.standard_normal(grid[inner].shape)
    low[inner] = -RANDOM.random(low[inner].shape)
    high[inner] = RANDOM.random(high[inner].shape)
    stencil = (far.inverse_stencil() / far.inverse_stencil()[0]).astype(np.float32)
    changed, opened = grids.settle(np, change, gap, (low, high), stencil[1:], sweeps)
    rows, columns = shape[1:]
    strips = np.array([[2 * columns, (rows - 2) * columns]], np.uint64)
    for i in range(shape[0]):
        own = Model(
            values=stencil,
            change=change[i].copy(),
            gap=gap[i].copy(),
            low=low[i],
            high=high[i],
            moved=np.zeros(shape[1:], np.float32),
            following=np.zeros(shape[1:], np.float32),
            softening=np.zeros((0, columns), np.float32),
            node=np.zeros(0, np.uint32),
            strips=strips,
            stiffness=1.0,
            lift=0.0,
        )
        uncompiled(model.settle_model)(own, sweeps)
        still = (slice(2, -2), slice(2, -2))
        np.testing.assert_allclose(changed[i][still], own.change[still], atol=2e-6)
        np.testing.assert_allclose(opened[i][still], own.gap[still], atol=2e-6)


def test_coarse_grids_are_those_of_the_far_field() -> None:
    rows, columns, tile = 21, 19, 8
    along = grids.tile_weights(np, rows, tile)
    across = grids.tile_weights(np, columns, tile)
    values = RANDOM.random((1, rows, columns)).astype(np.float32)
    length = 2 * across.shape[0] - 1
    coarse = np.zeros(along.shape[0] * length, np.float32)
    uncompiled(far.restrict)(values[0], tile, length, coarse)
    expected = coarse.reshape(-1, length)[:, : across.shape[0]]
    np.testing.assert_allclose(grids.restrict(values, along, across)[0], expected, rtol=1e-5)
    field = RANDOM.random((1, *expected.shape)).astype(np.float32)
    padded = np.zeros((expected.shape[0], length), np.float32)
    padded[:, : across.shape[0]] = field[0]
    out = np.zeros((rows, columns), np.float32)
    uncompiled(far.prolong)(padded.reshape(-1), np.float32(1), tile, length, out)
    inner = (slice(BORDER, -BORDER), slice(BORDER, -BORDER))
    got = grids.prolong(field, along, across)[0]
    np.testing.assert_allclose(got[inner], out[inner], rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("one_plan", [True, False])
def test_pieces_in_lockstep_are_those_of_the_march(one_plan: bool) -> None:
    """Four pieces reach the tolerance by a check that shares no code, as those of the march do."""
    load, pieces, steps = 5, 4, 6
    contact = contact_of(load)
    marches = [
        list(march(contact, APART * i, APART * i + 1 + steps, half_space_for(load)))
        for i in range(pieces)
    ]
    starts = [(states[0], states[1]) for states in marches]
    batch = CompiledBatch(contact, half_space_for(load), starts, one_plan)
    for j in range(steps):
        follow(batch)
        assert batch.counts[:, ACCEPTED].all()
        rows, columns = batch.frames.p.shape[1:]
        for i in range(pieces):
            state = marches[i][2 + j]
            window = Window(*(int(x) for x in batch.corners[0, i]), rows, columns)
            judged = judge(contact, state.position, window, batch.frames.p[i])
            # The tolerance holds for the window; deflection and rounding differ by 1e-6 of it.
            assert judged.gap_error <= 1.01 * contact.tolerance * judged.deflection
            assert abs(judged.load_error) < 1e-12
            apart = abs(batch.numbers[i, APPROACH] - state.approach)
            assert apart <= 2 * contact.tolerance * state.max_deflection
    assert batch.counts[:, OUTSIDE].sum() == 0


def test_a_task_is_halved_into_different_pieces() -> None:
    first, second = Task(load=1, first=3, pieces=8, steps=2, in_lockstep=True).halves()
    assert (first.first, first.pieces, second.first, second.pieces) == (3, 4, 7, 4)


def test_gpu_trial_runs_on_numpy(capsys: pytest.CaptureFixture[str]) -> None:
    assert gpu_trial.main(["--numpy", "--pieces", "1"]) == 0
    rows = capsys.readouterr().out.splitlines()
    assert len(rows) == 2 + len(gpu_trial.BLOCKS)
    times = [float(cell) for row in rows[2:] for cell in row.strip("|").split("|")[2:]]
    assert min(times) > 0


def test_gpu_trial_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "cupy", None)  # as if it were not installed
    assert gpu_trial.main([]) == 2
    assert "gpu_trial.py needs the package cupy" in capsys.readouterr().err


def test_bytes_of_a_step_grow_with_each_count() -> None:
    few = gpu_trial.Counts(window=100, block=80, convolutions=3, iterations=2, seconds=1)
    for name in ("window", "block", "convolutions", "iterations"):
        more = few._replace(**{name: getattr(few, name) + 1})
        assert gpu_trial.bytes_of_step(more) > gpu_trial.bytes_of_step(few)
