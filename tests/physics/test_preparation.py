"""Steps of ISO 25178-3 between a measurement and a period: each against a closed form."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian

from rolling.in_si import measured, plate_file
from rolling.scene.height_grid import height_grid
from rolling.scene.surfaces import HeightFile
from rolling.surface import gaussian_filter, levelling, preparation
from rolling.surface.heights import SurfaceError
from rolling.surface.period_grid import HeightGrid

UM = 1e-6


def rough(rows: int, columns: int, length: float = 8.0, seed: int = 1) -> np.ndarray:
    """Return a crop of Gaussian heights, Ra 0.1 um, spacing 1 um: no period."""
    shape = rows + 60, columns + 60
    z = gaussian(shape, UM, 1e-7, (length * UM, length * UM), "gaussian", seed)
    return z[:rows, :columns] - z[:rows, :columns].mean()


@pytest.mark.law("Preparation: the Gaussian filter halves a wave at its cut-off.")
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("wraps", [True, False])
@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_transmission_of_the_gaussian_filter(axis: int, wraps: bool, ratio: float) -> None:
    """A wave of `ratio` cut-offs passes with exp(-pi (0.4697 / ratio)^2): 6.25, 50 and 84.1 %.

    Sums over whole waves far from the edges are exact to the reach of the weights, 3e-6.
    """
    n = 512
    wave = 32
    line = np.cos(2 * np.pi * np.arange(n) / wave)
    z = np.moveaxis(np.tile(line, (40, 1)), 1, axis)
    passed = gaussian_filter.smoothed(z, (UM, UM), wave / ratio * UM, wraps)
    middle = np.moveaxis(passed, axis, 0)[128:384, 20]
    got = middle @ line[128:384] / (line[128:384] @ line[128:384])
    assert got == pytest.approx(np.exp(-np.log(2) / ratio**2), abs=1e-5)


def test_the_filter_ends_at_the_edges() -> None:
    """A plane passes as it is, and one edge knows nothing of the other but through the plane.

    A step at one edge changes the other by 0.3 if the filter wraps. The plane of the step rises by
    1.4e-3 a node, and is off by three nodes at most.
    """
    x = np.arange(90.0)[:, None]
    y = np.arange(70.0)
    plane = 3 * x - 2 * y + 5
    out = gaussian_filter.smoothed(plane, (UM, 2 * UM), 20 * UM, wraps=False)
    np.testing.assert_allclose(out, plane, atol=1e-10)
    step = np.where(np.arange(200)[:, None] < 190, 0.0, np.ones(60))
    for wraps, least, most in ((True, 0.3, 1.0), (False, 0.0, 4e-3)):
        change = np.abs(gaussian_filter.smoothed(step, (UM, UM), 20 * UM, wraps)[:100])
        assert least <= change.max() <= most


@pytest.mark.law("Preparation: filled points fulfil the equation of Laplace.")
def test_gaps_are_filled_harmonically() -> None:
    """x^2 - y^2 + x y is harmonic on the grid too, so that its gaps are filled exactly."""
    x = np.arange(40.0)[:, None]
    y = np.arange(33.0)
    exact = x**2 - y**2 + 0.3 * x * y - 7 * x
    gappy = exact.copy()
    gappy[5:20, 7:22] = gappy[30, 3] = np.nan
    np.testing.assert_allclose(preparation.filled(gappy), exact, atol=1e-9)


def test_filled_heights_lie_between_their_neighbours() -> None:
    """Gaps at edges and corners and a third of scattered nodes keep within the measured range."""
    z = rough(120, 90)
    z[np.random.default_rng(2).random(z.shape) < 0.3] = np.nan
    z[:30, :25] = z[-1] = np.nan
    out = preparation.filled(z)
    assert np.nanmin(z) <= out.min() and out.max() <= np.nanmax(z)


def test_gaps_at_an_edge_know_nothing_of_the_opposite_side(tmp_path: Path) -> None:
    """With zero slope at the edge a lone gap is the mean of its three neighbours, or of two in a
    corner, and an edge without a row stays below the other one, which lies 2 um higher.

    The array counts as a period. Rounding of heights of 2 um is below 1e-20 m.
    """
    z = rough(40, 32)
    z[30:] += 2e-6
    gappy = z.copy()
    gappy[0, 7] = gappy[20, 31] = gappy[0, 0] = gappy[1, 14:] = gappy[0, 14:] = np.nan
    out = prepared(tmp_path, gappy, unmeasured="fill")[0]
    out += gappy[10, 10] - out[10, 10]
    assert out[0, 7] == pytest.approx((z[0, 6] + z[0, 8] + z[1, 7]) / 3, abs=1e-20)
    assert out[20, 31] == pytest.approx((z[19, 31] + z[21, 31] + z[20, 30]) / 3, abs=1e-20)
    assert out[0, 0] == pytest.approx((z[1, 0] + z[0, 1]) / 2, abs=1e-20)
    assert out[:2, 14:].max() < z[:30].max()


@pytest.mark.slow
def test_a_third_of_a_million_nodes_is_filled_in_seconds() -> None:
    """The direct solution fulfils the equation to 1e-12 of the heights; this takes 4 s."""
    z = gaussian((1000, 1000), UM, 1.0, (1e-5, 1e-5), "gaussian", 1)
    z[200:748, 200:748] = np.nan
    out = preparation.filled(z)
    mean = (out[:-2, 1:-1] + out[2:, 1:-1] + out[1:-1, :-2] + out[1:-1, 2:]) / 4
    assert np.abs(mean - out[1:-1, 1:-1])[np.isnan(z[1:-1, 1:-1])].max() < 1e-12


def test_more_gaps_than_half_are_refused() -> None:
    z = np.where(np.arange(100).reshape(10, 10) < 51, np.nan, 0.0)
    with pytest.raises(SurfaceError, match=r"51 % of the nodes .* up to 50 %"):
        preparation.filled(z)


@pytest.mark.parametrize("length", [1.0, 8.0, 30.0])
@pytest.mark.parametrize("tilt", [0.0, 1e-8])
def test_outliers_are_the_spikes_and_nothing_else(length: float, tilt: float) -> None:
    """Gaussian heights of any correlation, tilted or not, have no outlier beyond 6."""
    z = rough(150, 130, length, seed=4) + tilt * np.arange(150)[:, None]
    spikes = [(0, 0), (0, 60), (70, 65), (149, 129), (71, 66)]
    for place in spikes:
        z[place] += 2e-6
    z[40:44, 20:30] = np.nan
    out, count = preparation.without_outliers(z, 6)
    assert count == len(spikes) and all(np.isnan(out[place]) for place in spikes)
    assert preparation.without_outliers(np.zeros((9, 9)), 3)[1] == 0


def test_second_order_is_taken_off_exactly() -> None:
    """What is left of plane, parabolas and twist is rounding; heights of others stay."""
    x, y = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(-1, 1, 41), indexing="ij")
    form = 1e-5 * (x + 2 * y + 3 * x**2 - y**2 + 4 * x * y)
    out, how = levelling.level(form - form.mean(), UM, "quadratic")
    assert np.abs(out).max() < 1e-18 and how.form == "second order"
    rest = rough(60, 41)
    both, alone = (
        levelling.level(z, UM, "quadratic")[0] for z in (form - form.mean() + rest, rest)
    )
    np.testing.assert_allclose(both, alone, atol=1e-18)


@pytest.mark.law("Preparation: blending an overlap keeps Sq and leaves no seam.")
def test_a_blend_keeps_the_roughness_and_leaves_no_seam() -> None:
    """Over 24 crops Sq of the blended nodes is that of the others within 4 %.

    A zone holds some 20 independent patches, so a crop leaves 16 % and 24 of them 3 %.
    """
    ratios = []
    seams = 0
    for seed in range(24):
        z = rough(200, 120, seed=seed)
        out, text = preparation.blended(z, (40, 24), UM)
        assert out.shape == (160, 96) and "40 um blended along" in text
        ratios.append(np.mean(out[:40] ** 2) / np.mean(out[40:] ** 2))
        seams += levelling.seam(out, 0).stands_out + levelling.seam(out, 1).stands_out
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.1) and seams == 0


def test_a_blend_of_equal_parts_is_that_part() -> None:
    """A measurement of more than a period gives the period back."""
    z = gaussian((100, 64), UM, 1e-7, (8e-6, 8e-6), "gaussian", 3)
    out, _ = preparation.blended(np.concatenate([z, z[:25]]), (25, 0), UM)
    np.testing.assert_allclose(out, z, atol=1e-15)


def prepared(folder: Path, z: np.ndarray, **keys: object) -> tuple:
    np.save(folder / "h.npy", z)
    keys = {"spacing_um": 1, "level": "none", **keys}
    file = HeightFile(path="h.npy", **keys)  # type: ignore[arg-type]
    grid = height_grid(folder / "h.npy", file)
    out = plate_file.prepared_file(folder / "h.npy", file)
    assert out[0].shape == grid.nodes
    return out


def test_steps_follow_the_standard_and_each_begins_where_the_last_ended(tmp_path: Path) -> None:
    z = rough(120, 100) + 1e-8 * np.arange(120)[:, None]
    z[10, 10] = 1e-5
    z[50:60, 40:50] = np.nan
    out, how, effects = prepared(
        tmp_path, z, outliers=6, unmeasured="fill", s_filter_um=4, level="plane", l_filter_um=80,
        periodic="blend", overlap_um=20,
    )  # fmt: skip
    steps = ["outliers", "unmeasured", "s_filter", "f_operator", "l_filter", "periodic"]
    assert [effect.step for effect in effects] == steps
    assert all(a.after == b.before for a, b in itertools.pairwise(effects))
    want = preparation.known_roughness(out, (UM, UM))
    assert effects[-1].after == want and want["Sq"] == pytest.approx(out.std(), rel=1e-9)
    assert how.seams[0] == levelling.seam(out, 0)
    # The plane of 1e-8 m a node makes Sdq 0.01 of its own, and the S-filter takes slope off.
    falls = [effect.after["Sdq"] < effect.before["Sdq"] for effect in effects[:1] + effects[2:4]]
    assert all(falls)


def test_a_period_stays_as_it_is_unless_a_key_says_otherwise(tmp_path: Path) -> None:
    z = rough(64, 48)
    out, _, effects = prepared(tmp_path, z)
    assert np.array_equal(out, z - z.mean()) and effects == []
    mirrored = prepared(tmp_path, z, periodic="mirror")
    assert mirrored[0].shape == (126, 94) and "palindromic" in mirrored[2][0].warning
    np.testing.assert_array_equal(mirrored[0][1:], mirrored[0][:0:-1])
    turned = prepared(tmp_path, z, along="x")[0]
    np.testing.assert_array_equal(turned, out.T)


def test_statistics_of_a_plane_wave() -> None:
    """Sa 2/pi, Sq 1/sqrt 2, Ssk 0, Sku 1.5, Sdq the rms of differences over unequal steps."""
    z = np.sin(2 * np.pi * (np.arange(64) + 0.5) / 64)[:, None] * np.ones(5)
    got = preparation.known_roughness(np.where(np.arange(5) == 2, np.nan, z), (2.0, 3.0))
    assert [*got.values()][:4] == pytest.approx([2 / np.pi, 0.5**0.5, 0, 1.5], abs=1e-3)
    assert got["Sdq"] == pytest.approx(2 * np.sin(np.pi / 64) / 2 * 0.5**0.5, rel=0.02)


def test_resampling_keeps_waves_and_lengths() -> None:
    """Cubic splines hold a wave of 16 nodes within 1e-3 between its nodes."""
    grid = HeightGrid((2 * UM, 3 * UM), 1.5 * UM, (106, 119), (0, 0), (106, 119))
    x = 2.0 * np.arange(80)[:, None]
    y = 3.0 * np.arange(60)
    out = preparation.resampled(np.cos(x * np.pi / 16) * np.cos(y * np.pi / 24), grid, False)
    x = 1.5 * np.arange(106)[:, None]
    y = 1.5 * np.arange(119)
    want = np.cos(x * np.pi / 16) * np.cos(y * np.pi / 24)
    assert np.abs(out - want)[8:-8, 8:-8].max() < 1e-3


@pytest.mark.parametrize("spacing_um", [0.5, 2.3, 3.0])
def test_resampling_keeps_a_period_closed(tmp_path: Path, spacing_um: float) -> None:
    """Whole waves stay whole: the interpolation is exact to 1e-3 on the seam as elsewhere.

    A resampled crop that ends with the last node would miss up to a node at the seam.
    """
    along, across = (np.arange(n) / n for n in (64, 40))
    z = 1e-7 * np.cos(4 * np.pi * along[:, None] + 1) * np.cos(2 * np.pi * across)
    measured.write(path := tmp_path / "wave.xyz", z, (2 * UM, 3 * UM))
    keys = HeightFile(path=str(path), spacing_um=spacing_um, periodic="none", level="none")
    grid = height_grid(path, keys)
    assert grid.nodes == (round(128 / spacing_um), round(120 / spacing_um))
    out, levelling_of, _ = plate_file.prepared_file(path, keys)
    along, across = (np.arange(n) / n for n in grid.nodes)
    want = 1e-7 * np.cos(4 * np.pi * along[:, None] + 1) * np.cos(2 * np.pi * across)
    assert np.abs(out - want).max() < 1e-3 * 1e-7
    assert not any(seam.stands_out for seam in levelling_of.seams)


@pytest.mark.parametrize("ending", [".csv", ".xyz", ".npy"])
def test_nan_in_text_is_a_point_that_was_not_measured(tmp_path: Path, ending: str) -> None:
    """It is refused with its place or filled, alike in each format."""
    z = rough(24, 18)
    z[3, 5] = np.nan
    measured.write(path := tmp_path / f"z{ending}", z, (UM, UM))
    if ending == ".xyz":
        path.write_text(path.read_text() + f"{5 * UM} {3 * UM} nan\n")
    keys = {"path": str(path), "spacing_um": 1, "periodic": "none", "level": "none"}
    with pytest.raises(
        SurfaceError, match=r"1 of 432 heights are not numbers, the first at \(3, 5"
    ):
        plate_file.read(path, HeightFile(**keys))
    filling = HeightFile(**keys, unmeasured="fill")
    out, _, _ = plate_file.prepared_file(path, filling)
    want = (z[2, 5] + z[4, 5] + z[3, 4] + z[3, 6]) / 4 - np.nanmean(z)
    assert out[3, 5] == pytest.approx(want, abs=1e-15)


@pytest.mark.filterwarnings("error")
def test_an_overlap_of_a_whole_half_leaves_nothing_elsewhere() -> None:
    heights, text = preparation.blended(rough(40, 30), (20, 15), UM)
    assert heights.shape == (20, 15) and np.isfinite(heights).all()
    assert "there, - um elsewhere" in text and "nan" not in text


def test_gaps_without_neighbours_have_no_slope() -> None:
    """On a checkerboard of gaps no slope is known, and nothing is not a number."""
    z = np.where(np.add.outer(np.arange(8), np.arange(9)) % 2, np.nan, rough(8, 9))
    assert [*preparation.known_roughness(z, (UM, UM))] == ["Sa", "Sq", "Ssk", "Sku"]
    assert set(preparation.known_roughness(np.zeros((4, 4)), (UM, UM)).values()) == {0.0}
