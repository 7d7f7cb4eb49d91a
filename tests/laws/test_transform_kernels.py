"""Columns in two halves against whole transforms.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numpy as np
import pytest

from rolling.contact import _transform_kernels as kernels
from rolling.contact.half_space import HalfSpace, love, padded_length

pytestmark = pytest.mark.kernel


def turns_of(length: int) -> np.ndarray:
    """Return the roots of unity of half a circle."""
    return np.exp(-2j * np.pi / length * np.arange(length // 2))


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


@pytest.mark.parametrize("halved", [False, True])
def test_coefficients_meet_their_frequencies(halved: bool) -> None:
    """The order of halves is the even frequencies, then the odd ones."""
    coefficients = np.arange(1.0, 28.0).reshape(9, 3)  # of frequencies 0 to 8 of 16
    whole = coefficients[np.minimum(np.arange(16), 16 - np.arange(16))]
    lines = np.ones((16, 3))
    kernels.multiply(lines, coefficients, halved)
    expected = np.concatenate([whole[::2], whole[1::2]]) if halved else whole
    np.testing.assert_array_equal(lines, expected)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("nodes", [100, 128, 137, 158, 171, 199, 245, 310])
def test_lengths_of_all_kinds_give_the_deflection(nodes: int, single: bool) -> None:
    """Columns as a whole, in halves, in place or not agree with a transform by numpy."""
    space = HalfSpace(1e-6, 1e11)
    transforms = space.convolution(nodes - 1, 11, single=single)
    pressure = np.random.default_rng(nodes).random((nodes, 12))
    block = transforms.block(nodes, 12)
    block[:] = 0.0
    block[:nodes, :12] = pressure
    transforms.apply(nodes, 12)
    length = padded_length(nodes)
    kernel = love(*(np.minimum(np.arange(k), k - np.arange(k)) for k in (2 * length, 64)))
    shape = (2 * length, 64)
    direct = np.fft.irfft2(np.fft.rfft2(pressure, s=shape) * np.fft.rfft2(kernel), s=shape)
    error = np.abs(block[:nodes, :12] - direct[:nodes, :12]).max() / direct.max()
    assert error < (6e-7 if single else 2e-15)


def test_deflection_beyond_half_of_the_columns() -> None:
    """A loaded block in the middle of a window needs less padding than its window has rows."""
    space = HalfSpace(1e-6, 1e11)
    pressure = np.zeros((180, 40))
    pressure[90:121, 18:22] = np.random.default_rng(0).random((31, 4))
    assert padded_length(120) // 2 < 180  # rows of the deflection reach into the second half
    shape = (512, 128)
    kernel = love(*(np.minimum(np.arange(k), k - np.arange(k)) for k in shape))
    direct = np.fft.irfft2(np.fft.rfft2(pressure, s=shape) * np.fft.rfft2(kernel), s=shape)
    got = space.deflection(pressure) / space.unit
    assert np.abs(got - direct[:180, :40]).max() < 2e-15 * direct.max()
