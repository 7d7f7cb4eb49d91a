"""Generated surfaces have the required statistics, and files without heights are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian
from scene_text import PLAIN

from rolling.contact.kept import Kept
from rolling.in_si import in_metres, scene_surface
from rolling.scene import file as scene_file
from rolling.scene.laws import AUTOCORRELATIONS, Roughness
from rolling.surface import heights as surface
from rolling.surface import made
from rolling.surface.heights import SurfaceError

SPACING = 1e-6
LAWS = {  # written out again, so that the table in the package is tested
    "gaussian": lambda r: np.exp(-(r**2)),
    "gaussian_10pct": lambda r: np.exp(-2.3 * r**2),
    "exponential": lambda r: np.exp(-r),
    "exponential_10pct": lambda r: np.exp(-2.3 * r),
}


def generate(
    law: str = "gaussian", shape=(240, 180), ra: float = 1e-7, lengths=(10e-6, 10e-6), seed: int = 1
) -> np.ndarray:
    return gaussian(shape, SPACING, ra, lengths, law, seed)


@pytest.mark.law("Surface: Ra is the value asked for, the mean is zero.")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    ("ra", "shape"), [(1e-12, (101, 64)), (1e-7, (64, 101)), (5e-6, (1000, 37))]
)
def test_ra_is_exact_and_the_mean_zero(law: str, ra: float, shape: tuple[int, int]) -> None:
    heights = generate(law, shape, ra)
    assert heights.shape == shape
    assert np.abs(heights).mean() == pytest.approx(ra, rel=1e-13)
    assert abs(heights.mean()) < 1e-14 * ra


@pytest.mark.law("Surface: detail below the spacing follows the law, and long waves stay.")
@pytest.mark.parametrize(
    ("law", "lengths"),
    [
        ("exponential", (9e-6, 9e-6)),
        ("gaussian", (2e-6, 2e-6)),
        ("exponential_10pct", (20e-6, 8e-6)),
    ],
)
def test_a_continued_surface_follows_its_law_and_keeps_its_long_waves(
    law: str, lengths: tuple[float, float]
) -> None:
    """Lags below the spacing follow the law; 12 surfaces leave 1 % of the variance uncertain."""
    rq = 1e-7 * np.sqrt(np.pi / 2)
    total = 0.0
    size = (160, 96)
    roughness = Roughness(
        autocorrelation=law,
        roughness_ra_um=0.1,
        correlation_length_um=1e6 * lengths[0],
        correlation_length_across_um=1e6 * lengths[1],
        seed=0,
    )
    for seed in range(12):
        z = generate(law, size, lengths=lengths, seed=seed)
        finer = made.continued(z, SPACING, [roughness.in_si], (seed, 1))
        spectrum = np.abs(np.fft.rfft2(finer)) ** 2
        total = total + np.fft.irfft2(spectrum, s=finer.shape) / finer.size / rq**2 / 12
        means = finer.reshape(size[0], 2, size[1], 2).mean(axis=(1, 3))
        long = [np.fft.rfft2(x)[:10, :10].ravel() for x in (means, z)]
        off = np.linalg.norm(long[0] - long[1]) / np.linalg.norm(long[1])
        assert off < (0.05 if law != "gaussian" else 0.02)
    for axis in (0, 1):
        lag = np.arange(4) * SPACING / 2 / lengths[axis]
        assert np.moveaxis(total, axis, 0)[:4, 0] == pytest.approx(LAWS[law](lag), abs=0.03)


@pytest.mark.law("Surface: the autocorrelation follows its law along and across.")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(
    "lengths", [(8e-6, 8e-6), (16e-6, 5e-6)], ids=["isotropic", "longer along"]
)
def test_autocorrelation_follows_its_law_along_and_across(
    law: str, lengths: tuple[float, float]
) -> None:
    """The mean circular autocorrelation of 24 surfaces follows the law.

    One surface holds about A / (pi Lx Ly) independent patches, so its estimate is uncertain by
    up to sqrt(2 pi Lx Ly / A); five times that over sqrt(24) is allowed at each of 60 lags.
    """
    shape = (240, 180)
    count = 24
    total = np.zeros(shape)
    for seed in range(count):
        z = generate(law, shape, lengths=lengths, seed=seed)
        spectrum = np.abs(np.fft.fft2(z)) ** 2
        total += np.fft.ifft2(spectrum).real / (z**2).sum()
    allowed = 5 * np.sqrt(2 * np.pi * lengths[0] * lengths[1] / (240 * 180 * SPACING**2) / count)
    assert allowed < 0.12
    lags = np.arange(30) * SPACING
    for got, length in ((total[:30, 0] / count, lengths[0]), (total[0, :30] / count, lengths[1])):
        np.testing.assert_allclose(got, LAWS[law](lags / length), atol=allowed)
        # The length itself, off the lag where the law says 1/2: within 10 %.
        half = float(np.interp(-0.5, -got, lags))
        law_half = float(np.interp(-0.5, -LAWS[law](lags / length), lags))
        assert half == pytest.approx(law_half, rel=0.12)


@pytest.mark.law("Surface: the heights are Gaussian.")
def test_heights_are_gaussian() -> None:
    """Skewness is 0 +- 0.09 and kurtosis 3 +- 0.18 (one sigma); three are allowed.

    There are about 43200 / (2 pi 9) = 760 independent heights. Ra / Rq of a Gaussian is sqrt(2
    / pi).
    """
    got = surface.statistics(generate(lengths=(3e-6, 3e-6)), SPACING)
    assert abs(got.skewness) < 0.27
    assert abs(got.kurtosis - 3) < 0.54
    assert got.ra / got.rq == pytest.approx(np.sqrt(2 / np.pi), rel=0.02)


@pytest.mark.law("Surface: a generated surface is periodic.")
@pytest.mark.parametrize("axis", [0, 1])
def test_the_seam_is_like_the_interior(axis: int) -> None:
    """Differences across the seam have the variance of those inside, within 15 %.

    Over 40 surfaces about 40 * 9 of them are independent.
    """
    inside = []
    seam = []
    for seed in range(40):
        z = generate(shape=(90, 90), seed=seed)
        inside.append(np.mean(np.diff(z, axis=axis) ** 2))
        seam.append(np.mean((np.take(z, 0, axis) - np.take(z, -1, axis)) ** 2))
    assert np.mean(seam) == pytest.approx(np.mean(inside), rel=0.2)


def test_seed_reproduces_and_distinguishes() -> None:
    np.testing.assert_array_equal(generate(seed=7), generate(seed=7))
    assert abs(np.corrcoef(generate(seed=7).ravel(), generate(seed=8).ravel())[0, 1]) < 0.2


def test_roughness_scales_without_changing_shape() -> None:
    np.testing.assert_allclose(generate(ra=3e-6), 30 * generate(ra=1e-7), rtol=1e-12)


def test_correlation_length_beyond_the_surface_is_refused() -> None:
    with pytest.raises(SurfaceError, match=r"no roughness left.*correlation lengths of 1e9 and"):
        generate(shape=(16, 16), lengths=(1e3, 1e3))


@pytest.mark.parametrize("law", AUTOCORRELATIONS)
@pytest.mark.parametrize("shape", [(9, 8), (64, 64), (256, 16)])
def test_the_limit_that_a_refusal_for_rounding_names_is_allowed(
    law: str, shape: tuple[int, int]
) -> None:
    with pytest.raises(SurfaceError) as error:
        gaussian(shape, SPACING, 1e-7, (1e12, 1e12), law, 1)
    named = float(str(error.value).split("up to about ")[1].split()[0]) * 1e-6
    assert named > 1e4 * max(shape) * SPACING
    made = gaussian(shape, SPACING, 1e-7, (named, named), law, 1)
    assert np.abs(made).mean() == pytest.approx(1e-7)


def test_statistics_of_a_sine() -> None:
    """Rq = A / sqrt 2, Ra = 2 A / pi, kurtosis 3/2, skewness 0, and slope A k sinc / sqrt 2.

    The sinc is over one spacing. Even sampling makes these exact.
    """
    n = 4096
    amplitude = 1e-6
    z = amplitude * np.sin(2 * np.pi * (np.arange(n) + 0.5) / n)[:, None] + np.zeros(7)
    got = surface.statistics(z + 5e-3, SPACING)
    assert got.rq == pytest.approx(amplitude / np.sqrt(2), rel=1e-9)
    assert got.ra == pytest.approx(2 * amplitude / np.pi, rel=1e-6)
    assert got.skewness == pytest.approx(0, abs=1e-8)
    assert got.kurtosis == pytest.approx(1.5, rel=1e-8)
    assert got.rms_slope == pytest.approx(
        amplitude * 2 * np.sin(np.pi / n) / SPACING / np.sqrt(2), rel=1e-6
    )
    assert got.highest == pytest.approx(amplitude, rel=1e-6)
    assert got.lowest == pytest.approx(-amplitude, rel=1e-6)


def test_statistics_of_a_checkerboard_and_of_nothing() -> None:
    """A checkerboard of +-A has Ra = Rq = A and kurtosis 1; a flat surface has zeros.

    Each slope of the checkerboard is 2 A / spacing, and the norm of the gradient is sqrt 2
    times that.
    """
    z = 1e-6 * (-1.0) ** np.add.outer(np.arange(8), np.arange(6))
    got = surface.statistics(z, SPACING)
    assert (got.ra, got.rq, got.kurtosis) == pytest.approx((1e-6, 1e-6, 1.0))
    assert got.rms_slope == pytest.approx(np.sqrt(2) * 2)
    flat = surface.statistics(np.zeros((8, 6)), SPACING)
    assert (flat.ra, flat.rq, flat.skewness, flat.kurtosis, flat.rms_slope) == (0, 0, 0, 0, 0)


def test_rms_slope_of_a_gaussian_surface() -> None:
    """The rms slope of exp(-(r / L)^2) is sqrt 2 Rq / L each way, 2 Rq / L for the norm.

    At L = 10 nodes differences miss 0.3 %. 10 % is 3 sigma of the 137 independent patches.
    """
    z = generate()
    got = surface.statistics(z, SPACING)
    assert got.rms_slope == pytest.approx(2 * got.rq / 10e-6, rel=0.1)


def saved(path: Path, values: np.ndarray, **how: bool) -> Path:
    np.save(path / "heights.npy", values, **how)
    return path / "heights.npy"


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_file_is_read_as_metres_about_its_mean(tmp_path: Path, kind: type) -> None:
    z = np.random.default_rng(0).standard_normal((12, 9)) * 1e-6
    heights = in_metres.read_heights(saved(tmp_path, (z + 1e-3).astype(kind)))
    assert heights.dtype == np.float64 and heights.shape == (12, 9)
    rounding = 1e-10 if kind is np.float32 else 1e-18
    np.testing.assert_allclose(heights, z - z.mean(), atol=rounding)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda z: np.where(z > z.max() / 2, np.nan, z), "heights are not numbers"),
        (lambda z: z[None], "3-D array"),
        (lambda z: z + 0j, "2-D complex128"),
        (lambda z: np.array([[{}, 1]], dtype=object), "2-D object"),
        (lambda z: z * 1e6, "Ra would be.*set surface.height_unit"),
        (lambda z: z[:0], "heights"),
    ],
)
def test_arrays_that_are_not_heights_are_refused(tmp_path: Path, change, words: str) -> None:
    """The message names the file; an empty array has no mean, and must not raise a warning."""
    z = np.random.default_rng(0).standard_normal((12, 9)) * 1e-6
    path = saved(tmp_path, change(z), allow_pickle=True)
    with pytest.raises(SurfaceError, match=words) as error:
        in_metres.read_heights(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(("most", "times"), [(1e9, 2), (0.0, 4)])
def test_surfaces_that_runs_share_are_made_and_described_once(
    monkeypatch: pytest.MonkeyPatch, most: float, times: int
) -> None:
    """A sweep that alternates between two small surfaces; of large ones only the last is kept."""
    made = []
    make = scene_surface._make
    monkeypatch.setattr(scene_surface, "_make", lambda given: made.append(given) or make(given))
    kept = Kept(int(most), lambda surface: surface.heights.nbytes)
    monkeypatch.setattr(scene_surface, "_kept", kept)
    swept = ["sweep.rolling.load_n=[5, 20]", "sweep.surface.seed=[1, 2]"]
    runs = [single for _, single in scene_file.loads(PLAIN, swept).runs()]
    statistics = [scene_surface.scene_surface(run).statistics for run in runs]
    assert len(made) == times
    assert statistics[:2] == statistics[2:] and statistics[0] != statistics[1]
    assert (statistics[0] is statistics[2]) == (times == 2)
