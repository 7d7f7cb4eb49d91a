"""Profile parameters of waves, noise and steps are those of closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.surface.gaussian_filter import long_waves
from rolling.surface.profile_parameters import (
    CLASSES,
    cut,
    element_spacing,
    fitting_index,
    profile_roughness,
)

UM = 1e-6


def wave(nodes: int, length_um: float, spacing_um: float = 2.0, phase: float = 0.3) -> np.ndarray:
    """Return a sine of 1 um along two lines, whose second one is shifted."""
    x = spacing_um * np.arange(nodes)[:, None]
    return UM * np.sin(2 * np.pi * x / length_um + phase * np.array([1.0, 5.0]))


@pytest.mark.law("Profiles: a sine has Ra = 2 A/pi, Rq = A/sqrt(2), Rt = 2 A and its wavelength.")
def test_a_sine_has_its_closed_forms() -> None:
    """The nesting index of an Ra of 0.64 um is 0.8 mm, which passes waves of 40 um whole."""
    found = profile_roughness(wave(10_000, 40.0), 2 * UM, is_periodic=True)
    assert (found.letter, found.index_m, found.sections) == ("R", 0.8e-3, 5)
    assert found.evaluation_m == pytest.approx(4e-3) and found.profiles == 2 * 5
    expected = {
        "a": 2 / np.pi * UM,
        "q": UM / np.sqrt(2),
        "sk": 0.0,
        "ku": 1.5,
        "p": UM,
        "v": UM,
        "z": 2 * UM,
        "t": 2 * UM,
        "Sm": 40 * UM,
        "dq": np.sqrt(2) * np.pi / 40,
    }
    for name, value in expected.items():
        at_least = 2e-3 * abs(value) + 1e-3 * (name == "sk")
        assert found.values[name] == pytest.approx(value, abs=6 * at_least), name


@pytest.mark.law("Profiles: the L-filter halves a wave at its nesting index.")
@pytest.mark.parametrize(("length_um", "passed"), [(800.0, 0.5), (400.0, 1 / 16), (80.0, 0.0)])
def test_the_filter_passes_half_at_its_index(length_um: float, passed: float) -> None:
    lines = wave(10_000, length_um)
    long = long_waves(lines, 2 * UM, 0.8e-3, wraps=True)
    assert np.abs(long).max() == pytest.approx(passed * UM, abs=1e-3 * UM)


def test_open_ends_leave_half_an_index() -> None:
    """A tilt is no roughness, and what the filter does not know at its ends is left out."""
    lines = wave(3_000, 40.0) + 1e-3 * np.add.outer(2 * UM * np.arange(3_000), np.zeros(2))
    found = profile_roughness(lines, 2 * UM, is_periodic=False)
    assert found.index_m == 0.8e-3 and found.profiles == 2
    # Half an index is what instruments leave out; the filter still knows its end by a per cent.
    assert found.values["a"] == pytest.approx(2 / np.pi * UM, rel=1e-2)
    middle = wave(3_000, 40.0)[200:2800]
    assert long_waves(np.ones((500, 1)), 2 * UM, 0.25e-3, wraps=False) == pytest.approx(1.0)
    assert len(cut(middle, 1000)) == 4


@pytest.mark.parametrize(
    ("length_mm", "usual_mm", "is_periodic", "index_mm"),
    [
        (4.0, 0.8, True, 0.8),
        (4.0, 0.8, False, 0.25),
        (4.8, 0.8, False, 0.8),
        (400.0, 0.8, True, 0.8),
        (1.0, 0.8, True, 0.08),
        (0.3, 0.8, True, None),
    ],
)
def test_the_index_is_the_largest_that_fits(
    length_mm: float, usual_mm: float, is_periodic: bool, index_mm: float | None
) -> None:
    found = fitting_index(1e-3 * length_mm, 2 * UM, 1e-3 * usual_mm, is_periodic)
    assert found == (None if index_mm is None else 1e-3 * index_mm)


def test_a_short_surface_has_a_primary_profile() -> None:
    found = profile_roughness(wave(100, 40.0), 2 * UM, is_periodic=True)
    assert (found.letter, found.index_m, found.sections) == ("P", None, 1)
    assert found.usual_index_m == CLASSES[2].index_m and found.evaluation_m == pytest.approx(2e-4)


def test_flat_and_gappy_lines_are_told() -> None:
    """A flat surface has no elements; a line with a gap is left out, or all of them."""
    flat = profile_roughness(np.zeros((400, 3)), 2 * UM, is_periodic=True)
    assert flat.values["a"] == pytest.approx(0.0) and np.isnan(flat.values["Sm"]).all()
    gappy = wave(400, 40.0)
    gappy[7, 0] = np.nan
    found = profile_roughness(gappy, 2 * UM, is_periodic=True)
    assert (found.gaps, found.lines, found.profiles) == (1, 2, 2)
    gappy[9, 1] = np.nan
    for repeats in (1, 20):  # too short for a filter, and long enough
        longer = np.tile(gappy, (repeats, 1))
        assert profile_roughness(longer, 2 * UM, is_periodic=True).profiles == 0


def test_small_hills_are_no_elements() -> None:
    """A ripple below a tenth of the height divides no element, whatever the direction."""
    x = np.arange(4000)
    profile = np.sin(2 * np.pi * x / 400) + 0.05 * np.sin(2 * np.pi * x / 13)
    assert element_spacing(profile) == pytest.approx(400, rel=0.01)
    assert element_spacing(profile) == element_spacing(profile[::-1])
    assert np.isnan(element_spacing(np.abs(profile)))
