"""Love's coefficients and the padded convolution agree with a dense matrix and a sum."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref
from collections.abc import Callable
from threading import Thread

import numpy as np
import pytest
from hard_cases.dense import influence_matrix
from helpers import STEEL, convolved, make_track, roll, rough, space_of

from rolling.contact import _plans, half_space
from rolling.contact.half_space import HalfSpace, love, padded_length
from rolling.contact.kept import Kept
from rolling.contact.march import march
from rolling.contact.subcells import half_space_of

SPACING = 2e-6


def nodes(rows: int, columns: int) -> np.ndarray:
    grid = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    return np.stack(grid, axis=-1).reshape(-1, 2) * SPACING


@pytest.mark.law("Half-space: Love's coefficients are the entries of the influence matrix.")
@pytest.mark.kernel
def test_love_coefficients_agree_with_the_influence_matrix() -> None:
    """Two forms of the same closed form agree.

    Corner terms of size r cancel to 1 / r, and plain logarithms to less: measured 4e-12.
    """
    rows = 21
    columns = 14
    dense = influence_matrix(nodes(rows, columns), SPACING, STEEL)[0].reshape(rows, columns)
    closed = love(np.arange(rows), np.arange(columns)) * SPACING / (np.pi * STEEL)
    assert np.abs(closed / dense - 1).max() < 2e-11


def test_love_coefficient_under_the_loaded_square_and_far_away() -> None:
    """The coefficient is 4 ln(1 + sqrt 2) at the centre and 1 / r far away.

    The next term of the point load is 1 / (24 r^3).
    """
    assert love(np.zeros(1), np.zeros(1))[0, 0] == pytest.approx(
        4 * np.log(1 + np.sqrt(2)), rel=1e-15
    )
    far = love(np.array([300.0]), np.array([400.0]))[0, 0] * 500
    assert far - 1 == pytest.approx(
        1 / (24 * 500**2), rel=0.01
    )  # 1.7e-7, known to rounding of 2e-12 after cancellation


@pytest.mark.law("Half-space: the padded FFT convolution equals the direct sum.")
@pytest.mark.parametrize("shape", [(1, 1), (3, 8), (17, 5), (31, 33), (12, 40), (64, 64)])
def test_convolution_equals_direct_summation(shape: tuple[int, int]) -> None:
    """Zero padding makes the convolution exact for any window.

    Measured 4e-16 to 6e-15, mostly from the 4096 additions in a row.
    """
    pressure = np.random.default_rng(sum(shape)).random(shape) * 1e9
    kernel = love(*(np.abs(np.arange(1 - k, k)) for k in shape)) * SPACING / (np.pi * STEEL)
    direct = np.zeros(shape)
    m, n = shape
    for i, j in np.ndindex(*shape):
        direct += pressure[i, j] * kernel[m - 1 - i : 2 * m - 1 - i, n - 1 - j : 2 * n - 1 - j]
    got = HalfSpace(SPACING, STEEL).deflection(pressure)
    assert np.abs(got - direct).max() < 2e-14 * direct.max()


def test_a_window_size_used_before_leaves_nothing_behind() -> None:
    """A larger pressure leaves nothing in work arrays that odd windows share."""
    space = HalfSpace(SPACING, STEEL)
    small = np.random.default_rng(3).random((13, 29)) * 1e9
    before = space.deflection(small)
    space.deflection(np.full((17, 33), 1e12))  # padded alike
    assert padded_length(16) == padded_length(12) or padded_length(32) == padded_length(28)
    assert np.array_equal(space.deflection(small), before)


@pytest.mark.law("Half-space: the deflection scales with the spacing and with 1 / E*.")
def test_deflection_scales_with_spacing_and_modulus() -> None:
    """Squares twice as large double the deflection, and twice the modulus halves it.

    Powers of two make this exact to the bit.
    """
    pressure = np.random.default_rng(4).random((19, 23)) * 1e9
    once = HalfSpace(SPACING, STEEL).deflection(pressure)
    np.testing.assert_array_equal(HalfSpace(2 * SPACING, STEEL).deflection(pressure), 2 * once)
    np.testing.assert_array_equal(HalfSpace(SPACING, 2 * STEEL).deflection(pressure), 0.5 * once)


@pytest.mark.law("Half-space: the deflection is linear and reciprocal.")
@pytest.mark.kernel
def test_deflection_is_linear_and_symmetric() -> None:
    """Superposition and reciprocity p1.u2 = p2.u1 hold to the rounding of a transform."""
    rng = np.random.default_rng(5)
    p1, p2 = rng.random((2, 27, 14)) * 1e9
    space = HalfSpace(SPACING, STEEL)
    u1 = space.deflection(p1)
    u2 = space.deflection(p2)
    assert np.abs(space.deflection(p1 + 3 * p2) - u1 - 3 * u2).max() < 3e-15 * u2.max() * 4
    assert np.vdot(p1, u2) == pytest.approx(np.vdot(p2, u1), rel=3e-15)


@pytest.mark.parametrize("reach", [1, 8, 9, 127, 1000, 8192])
def test_padding_keeps_nodes_apart_at_little_waste(reach: int) -> None:
    """A length is at most a third longer than needed across the track, and twice along it."""
    along = padded_length(reach)
    across = padded_length(reach, across=True)
    assert 2 * reach <= across <= max(16, 1.34 * 2 * reach)
    assert 2 * reach <= along <= max(16, 2.0 * 2 * reach)


def test_a_window_beyond_all_room_is_refused_with_its_size() -> None:
    with pytest.raises(ValueError, match=r"8194 nodes.*8192"):
        padded_length(8193)


@pytest.mark.parametrize(
    ("rows", "columns"), [((0, 4), (20, 33)), ((13, 29), (0, 3)), ((29, 29), (7, 7))]
)
def test_padding_follows_the_loaded_block(rows: tuple[int, int], columns: tuple[int, int]) -> None:
    """A small loaded block anywhere gives the same deflection as padding for a full window."""
    pressure = np.zeros((30, 34))
    block = np.s_[rows[0] : rows[1] + 1, columns[0] : columns[1] + 1]
    pressure[block] = np.random.default_rng(6).random(pressure[block].shape) * 1e9
    alone = HalfSpace(SPACING, STEEL).deflection(pressure)
    corners = np.zeros_like(pressure)
    corners[0, 0] = corners[-1, -1] = 1e9
    space = HalfSpace(SPACING, STEEL)
    assert (
        np.abs(space.deflection(pressure + corners) - space.deflection(corners) - alone).max()
        < 2e-14 * alone.max()
    )


@pytest.mark.parametrize("subcells", [1, 2])
def test_pressures_that_cancel_deflect_the_plate(subcells: int) -> None:
    """A difference of pressures may be negative, and its sum over a cell or a row zero."""
    space = half_space_of(SPACING, STEEL, subcells)
    difference = np.zeros((40, 44))
    difference[2, 2:4] = (1e9, -1e9)
    difference[30, 36:40] = (1e9, -1e9, -1e9, 1e9)
    parts = [np.where(difference > 0, difference, 0.0), np.where(difference < 0, difference, 0.0)]
    expected = space.deflection(parts[0]) + space.deflection(parts[1])
    assert np.abs(space.deflection(difference) - expected).max() < 1e-14 * np.abs(expected).max()


def test_single_precision_is_told_from_double_by_1e_7() -> None:
    rng = np.random.default_rng(7)
    space = HalfSpace(SPACING, STEEL)
    pressure = rng.random((40, 30)) * 1e9
    single = space.convolution(39, 29, single=True)
    got = space.unit * convolved(single, pressure)
    error = np.abs(got - space.deflection(pressure)).max() / space.deflection(pressure).max()
    assert 1e-9 < error < 1e-6


@pytest.mark.parametrize("subcells", [1, 2])
def test_kept_transforms_stay_within_their_memory(
    subcells: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hundred sizes of window once took gigabytes; the sizes used last are kept."""
    monkeypatch.setattr(half_space, "KEPT_BYTES", 2**24)
    plate = half_space_of(SPACING, STEEL, subcells)
    pressure = np.ones((24, 24))
    first = plate.deflection(pressure)
    made = weakref.WeakSet(plate.convolution(reach, reach) for reach in range(40, 200, 8))
    assert len(made) > 1 and sum(transforms.nbytes for transforms in made) <= 2**24
    assert plate.convolution(192, 192) in made
    large = plate.convolution(900, 900)
    assert large.nbytes > 2**24
    assert len(made) == 1
    np.testing.assert_array_equal(plate.deflection(pressure), first)


def test_kept_spectra_stay_within_their_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """They once were 32 of any size: 2 GB where windows have 2,000 nodes across."""
    small = Kept(2**18, lambda half: half.nbytes, fewest=0)
    monkeypatch.setattr(half_space, "_spectra", small)
    first = half_space.half_spectrum(40, 48, 1, love)
    assert half_space.half_spectrum(40, 48, 1, love) is first
    made = [weakref.ref(half_space.half_spectrum(n, n, 1, love)) for n in range(64, 240, 8)]
    spectra = [reference() for reference in made]
    kept = [spectrum for spectrum in spectra if spectrum is not None]
    assert len(kept) > 1 and sum(spectrum.nbytes for spectrum in kept) <= 2**18
    assert half_space.half_spectrum(232, 232, 1, love) is kept[-1]
    half_space.half_spectrum(400, 400, 1, love)  # more than the limit, and displaces none
    assert half_space.half_spectrum(232, 232, 1, love) is kept[-1]
    again = half_space.half_spectrum(40, 48, 1, love)
    np.testing.assert_array_equal(again, first)
    distances = [np.minimum(np.arange(k), k - np.arange(k)) for k in (40, 48)]
    expected = np.fft.rfft2(love(*distances)).real[:21]
    np.testing.assert_allclose(again, expected, rtol=0, atol=1e-14 * expected.max())


@pytest.mark.parametrize("subcells", [1, 2])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda space: pickle.loads(pickle.dumps(space))])
def test_a_copy_has_transforms_of_its_own(
    subcells: int, copied: Callable[[HalfSpace], HalfSpace]
) -> None:
    """Plans are addresses of one process, in which the copy may not live."""
    plate = half_space_of(SPACING, STEEL, subcells)
    pressure = np.random.default_rng(3).random((24, 24))
    deflection = plate.deflection(pressure)
    other = copied(plate)
    assert type(other) is type(plate) and other.count == 0
    np.testing.assert_array_equal(other.deflection(pressure), deflection)
    size = 23, 23
    assert other.convolution(*size) is not plate.convolution(*size)


def test_threads_keep_values_side_by_side() -> None:
    """A thread that asks while the bytes of another one's values are added up waits for the sum."""
    others = []

    def size(value: int) -> int:
        if not others:
            others.append(Thread(target=kept.value, args=("other", lambda: 1)))
            others[0].start()
            others[0].join(timeout=0.1)
        return 1

    kept = Kept(2, size)
    assert [kept.value(key, lambda: 0) for key in "abc"] == [0, 0, 0]
    others[0].join()


def test_coefficients_of_distances_in_single_precision_are_those_of_whole_numbers() -> None:
    distance = np.arange(0, 120, 7)
    np.testing.assert_array_equal(
        love(distance.astype(np.float32), distance.astype(np.float16)), love(distance, distance)
    )


def test_plans_of_pyfftw_serve_where_the_library_tells_no_functions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Compiled code then calls Python for each plan, and the digits are the same."""
    track = make_track(rough(64, 64, 1e-7), load=0.1, hardness=2.1e9, tolerance=1e-4)
    states = roll(track, 0, 4)
    monkeypatch.setattr(_plans, "_functions", lambda kind: None)
    planned = len(_plans._plans)
    for state, other in zip(states, march(track, 0, 4, space := space_of(track)), strict=True):
        assert np.array_equal(state.pressure, other.pressure)
    assert len(_plans._plans) > planned
    del space, state, other
    gc.collect()
    assert len(_plans._plans) == planned


def test_lines_of_a_block_are_planned_once() -> None:
    """Further blocks of as many lines, or of a few rows less, take the same plans."""
    transforms = HalfSpace(SPACING, STEEL).convolution(60, 60)
    entry = transforms.planned_entry(30)
    planned = len(transforms._plans)
    assert transforms.planned_entry(30) is transforms.planned_entry(29) is entry
    assert len(transforms._plans) == planned
    transforms.planned_entry(50)
    assert len(transforms._plans) == planned + 2
