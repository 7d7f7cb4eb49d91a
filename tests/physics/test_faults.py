"""Single faults have their stated depth, size and place, and leave other places as they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rolling.scene.laws import SurfaceFault
from rolling.surface.single_faults import add_faults

NODES = (400, 101)
SPACING = 1e-6
MIDDLE = 50  # column of the line of the sphere
NOTHING = 1e-9  # share of the depth


def fields(kind: str, at_mm: Any = (0.2, 0), **keys: Any) -> Any:
    """Return the heights [depths] of a fault of 20 um and 2 um on a flat surface."""
    heights = np.zeros(NODES)
    at = {} if at_mm is None else {"at_mm": list(at_mm)}
    add_faults(
        heights, [SurfaceFault(kind=kind, size_um=20, depth_um=2, **at, **keys).in_si], SPACING
    )
    return heights / 2e-6


@pytest.mark.law("Faults: depth and size are as stated.")
@pytest.mark.parametrize("kind", ["pit", "dent", "bump", "scratch", "groove"])
def test_a_fault_has_its_depth_in_the_middle_and_ends_at_its_size(kind: str) -> None:
    share = fields(kind, **{"length_um": 60} if kind == "scratch" else {})
    sign = 1 if kind == "bump" else -1
    assert share[200, MIDDLE] == pytest.approx(sign)
    assert abs(share[190, MIDDLE]) < NOTHING  # half the size away
    assert sign * share[193, MIDDLE] > 0.05
    assert (np.abs(share[:150]).max() < NOTHING) and (np.abs(share[250:]).max() < NOTHING)


def test_the_rim_of_a_dent_holds_its_volume() -> None:
    """The rim is e^-2 of the depth high."""
    share = fields("dent")
    assert abs(share.sum()) < 1e-3 * np.abs(share).sum()
    assert share.max() == pytest.approx(np.exp(-2), rel=0.01)


@pytest.mark.law("Faults: a rim has its height, its width and its volume around the edge of a pit.")
def test_a_rim_stands_around_its_pit() -> None:
    """A ring of raised cosines of height h and width w holds pi h w (R + w / 2)."""
    bare = fields("pit")
    rim = (fields("pit", rim_height_um=0.4, rim_width_um=8) - bare) * 2  # [um]
    line = rim[200:, MIDDLE]  # by micrometres from the middle
    expected = np.zeros(len(line))
    expected[10:19] = 0.2 * (1 - np.cos(np.pi * np.arange(9) / 4))
    np.testing.assert_allclose(line, expected, atol=1e-12)
    assert rim[200, MIDDLE + 14] == pytest.approx(0.4)  # all around
    assert rim.sum() == pytest.approx(np.pi * 0.4 * 8 * 14, rel=0.01)
    flat = fields("pit", rim_height_um=0, rim_width_um=8)
    assert np.array_equal(flat, bare)


@pytest.mark.parametrize(("angle", "ends"), [(0, (30, 0)), (90, (0, 30)), (45, (21, 21))])
def test_a_scratch_has_its_length_and_direction(angle: float, ends: tuple[int, int]) -> None:
    share = fields("scratch", length_um=60, angle_deg=angle)
    x, y = ends
    assert share[200 + x, MIDDLE + y] == pytest.approx(-1, abs=0.01)
    assert share[200 + 2 * x, MIDDLE + min(2 * y, 50)] > -0.01
    assert share[200 + y, MIDDLE - x] > -0.01 or angle == 45


def test_a_step_rises_over_its_size_and_falls_back_evenly() -> None:
    """The ramp over the rest of the period is 400 / 20 times gentler."""
    rise = np.diff(fields("step", at_mm=(0.39, 0))[:, 0], append=0.0)
    rise[-1] = fields("step", at_mm=(0.39, 0))[0, 0] - fields("step", at_mm=(0.39, 0))[-1, 0]
    assert rise.max() == pytest.approx(np.pi / 2 / 20, rel=0.05)
    assert rise[20:380] == pytest.approx(-1 / 400)
    assert abs(rise.sum()) < NOTHING


def test_faults_at_the_ends_of_the_surface_go_on_at_its_beginning() -> None:
    share = fields("pit", at_mm=(0.0, 0))
    assert share[-3, MIDDLE] == share[3, MIDDLE] < -0.5


def test_a_thousand_random_faults_follow_from_their_seed() -> None:
    first, again, other = (fields("bump", None, count=1000, seed=k) for k in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    # The volume of a raised cosine is (1/2 - 2/pi^2) pi r^2 of its depth, wherever it lies.
    volume = (0.5 - 2 / np.pi**2) * np.pi * 10**2
    assert first.sum() == pytest.approx(1000 * volume, rel=0.01)
