"""Transforms of rows side by side, and columns in two halves, against transforms by numpy.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import convolved

from rolling.contact import _transform_kernels as kernels
from rolling.contact.half_space import Convolution, HalfSpace, half_spectrum, love, padded_length

pytestmark = pytest.mark.kernel


def turns_of(length: int) -> np.ndarray:
    """Return the roots of unity of half a circle."""
    return np.exp(-2j * np.pi / length * np.arange(length // 2))


def direct(pressure: np.ndarray, m: int, n: int) -> np.ndarray:
    """Convolve a pressure on a periodic grid of m by n nodes by transforms of real numbers."""
    kernel = love(*(np.minimum(np.arange(k), k - np.arange(k)) for k in (m, n)))
    product = np.fft.rfft2(pressure, s=(m, n)) * np.fft.rfft2(kernel)
    rows, columns = pressure.shape
    return np.fft.irfft2(product, s=(m, n))[:rows, :columns]


@pytest.mark.parametrize("rows", [1, 5, 8, 11, 16])
def test_halves_have_the_even_and_the_odd_frequencies(rows: int) -> None:
    """Columns that are zero from a row on, before or beyond the middle, transform as a whole."""
    rng = np.random.default_rng(rows)
    column = np.zeros((16, 3), complex)
    column[:rows] = rng.normal(size=(rows, 3)) + 1j * rng.normal(size=(rows, 3))
    whole = np.fft.fft(column, axis=0)
    lines = column.copy()
    lines[rows:] = np.nan  # which the pass does not read
    kernels.separate(lines, rows, turns_of(16))
    np.testing.assert_allclose(np.fft.fft(lines[:8], axis=0), whole[::2], atol=1e-13)
    np.testing.assert_allclose(np.fft.fft(lines[8:], axis=0), whole[1::2], atol=1e-13)


@pytest.mark.parametrize("rows", [1, 5, 8, 11, 16])
def test_halves_combine_to_the_whole(rows: int) -> None:
    """The first rows of an inverse transform come back from its even and odd frequencies."""
    rng = np.random.default_rng(rows)
    column = rng.normal(size=(16, 3)) + 1j * rng.normal(size=(16, 3))
    whole = np.fft.fft(column, axis=0)
    lines = np.concatenate([np.fft.ifft(whole[::2], axis=0), np.fft.ifft(whole[1::2], axis=0)])
    kernels.combine(lines, rows, turns_of(16))
    np.testing.assert_allclose(lines[:rows] / 2, column[:rows], atol=1e-13)


@pytest.mark.parametrize("side", [1, 2])
@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (6, 5), (7, 9)])
def test_rows_side_by_side_come_back(side: int, rows: int, columns: int) -> None:
    """An odd last row stands beside zeros, and further lines and columns are zeros."""
    pressure = np.random.default_rng(rows).normal(size=(rows, columns))
    lines = np.full((5 * 2 // side, columns + 3, side), np.nan)
    kernels.load(pressure, lines)
    for i in range(10):
        row = np.zeros(columns + 3)
        row[:columns] = pressure[i] if i < rows else 0.0
        np.testing.assert_array_equal(lines[i // side, :, i % side], row)
    out = np.empty_like(pressure)
    kernels.read(lines, 3.0, out)
    np.testing.assert_array_equal(out, 3.0 * pressure)


@pytest.mark.parametrize("m", [2, 6, 16, 80])
@pytest.mark.parametrize("n", [4, 10])
def test_pairs_of_rows_share_a_transform(m: int, n: int) -> None:
    """Any even lengths, columns with and without a middle frequency, whole or in halves."""
    transforms = Convolution(m, n, False, half_spectrum(m, n, 1, love))
    for rows in {m, max(m - 1, 1), (m + 1) // 2}:
        pressure = np.random.default_rng(rows).normal(size=(rows, n))
        got = convolved(transforms, pressure)
        expected = direct(pressure, m, n)
        assert np.abs(got - expected).max() < 3e-15 * np.abs(expected).max() * max(m, 10)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("nodes", [9, 40, 137, 245, 390])
def test_lengths_of_all_kinds_give_the_deflection(nodes: int, single: bool) -> None:
    """Columns as a whole, in halves, in place or not agree with a transform by numpy."""
    space = HalfSpace(1e-6, 1e11)
    transforms = space.convolution(nodes - 1, 11, single=single)
    pressure = np.random.default_rng(nodes).random((nodes, 12))
    got = convolved(transforms, pressure)
    expected = direct(pressure, 2 * padded_length(nodes), 64)
    error = np.abs(got - expected).max() / expected.max()
    assert error < (8e-7 if single else 3e-15)


def test_deflection_beyond_half_of_the_columns() -> None:
    """A loaded block in the middle of a window needs less padding than its window has rows."""
    space = HalfSpace(1e-6, 1e11)
    pressure = np.zeros((180, 40))
    pressure[90:121, 18:22] = np.random.default_rng(0).random((31, 4))
    assert padded_length(120) // 2 < 180  # rows of the deflection reach into the second half
    expected = direct(pressure, 512, 128)
    got = space.deflection(pressure) / space.unit
    assert np.abs(got - expected).max() < 2e-15 * expected.max()
