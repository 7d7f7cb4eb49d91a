"""Parameters of ISO 25178-2 against closed forms, and on surfaces that are hardly any."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian
from scipy.special import ndtr, ndtri

from acoustics.arrays import Array
from rolling.surface import parameters as iso

STEP = 1e-6
Curve = Callable[[Array], Array]
LENGTHS = {"Sa", "Sq", "Sp", "Sv", "Sz", "Sal", "Sk", "Spk", "Svk"}


def random_lay(lay_deg: float, aspect: float, seed: int, nodes: int = 256) -> Array:
    """Make periodic Gaussian heights of length 4 nodes across a lay, `aspect` times that along."""
    along, across = np.meshgrid(np.fft.fftfreq(nodes), np.fft.fftfreq(nodes), indexing="ij")
    turn = np.radians(lay_deg)
    with_lay = along * np.cos(turn) + across * np.sin(turn)
    normal = across * np.cos(turn) - along * np.sin(turn)
    gain = np.exp(-((np.pi * 4) ** 2) * ((aspect * with_lay) ** 2 + normal**2) / 2)
    noise = np.random.default_rng(seed).standard_normal((nodes, nodes))
    return np.asarray(np.fft.ifft2(np.fft.fft2(noise) * gain).real)


def gaussian_curve(ratio: Array) -> Array:
    """Return the heights at material ratios of Gaussian heights, Sq 1."""
    return np.asarray(-ndtri(ratio))


def rayleigh_curve(ratio: Array) -> Array:
    """Return the heights at material ratios of heights with a skewness of 0.63."""
    return np.asarray(np.sqrt(-np.log(ratio)))


def wavy_curve(ratio: Array) -> Array:
    """Return the heights at material ratios of a wave of amplitude 1 with roughness of Sq 0.15.

    The wave is cut at its crests, as by honing. The share above a height is a mean over the phase.
    """
    wave = np.minimum(np.cos(np.pi * (np.arange(800) + 0.5) / 800), 0.5)
    levels = np.linspace(-2.0, 1.5, 800)
    above = np.array([np.mean(ndtr((wave - level) / 0.15)) for level in levels])
    return np.asarray(np.interp(ratio, above[::-1], levels[::-1]))


@pytest.mark.parametrize("curve", [gaussian_curve, rayleigh_curve, wavy_curve])
def test_the_core_is_the_line_through_the_flattest_section(curve: Curve) -> None:
    """All five parameters follow from the curve of a distribution by integrals.

    The section of 40 % falls least, a least-squares line through it has moments of the curve, and
    peaks and dales have the areas beyond the line. 40,000 nodes hold the moments to 1e-4; where
    the section ends depends weakly on its place, and 1e-3 are allowed.
    """
    starts = np.linspace(1e-4, 0.5999, 60_000)
    begin = starts[np.argmin(curve(starts) - curve(starts + 0.4))]
    own, weight = np.polynomial.legendre.leggauss(200)
    heights = curve(begin + 0.2 * (own + 1))
    # Mean and slope of the line of the core.
    mean = heights @ weight / 2
    slope = 1.5 * (heights * own) @ weight / 0.2
    top = mean - slope * (begin + 0.2)
    bottom = top + slope
    ratio = (np.arange(2_000_000) + 0.5) / 2_000_000
    z = curve(ratio)
    peaks = np.maximum(z - top, 0)
    dales = np.maximum(bottom - z, 0)
    above = np.mean(z > top)
    below = np.mean(z < bottom)
    want = {
        "Sk": top - bottom,
        "Spk": 2 * peaks.mean() / above,
        "Svk": 2 * dales.mean() / below,
        "Smrk1": 100 * above,
        "Smrk2": 100 * (1 - below),
    }
    nodes = np.random.default_rng(1).permutation(curve((np.arange(40_000) + 0.5) / 40_000))
    got = iso.material_parameters(nodes.reshape(200, 200))
    for name, value in want.items():
        assert got[name] == pytest.approx(value, rel=1e-3), name


@pytest.mark.slow
@pytest.mark.parametrize(("law", "lengths"), [("gaussian", 1.2686), ("exponential", 1.6094)])
@pytest.mark.parametrize("wrap", [True, False])
def test_autocorrelation_length_of_a_law(law: str, lengths: float, wrap: bool) -> None:
    """The law falls to 0.2 at L sqrt(ln 5) or L ln 5.

    Over 160 lengths the decay of the exponential law scatters by 2.5 % in each direction, and the
    shortest lies up to two deviations below the law: 6 % are allowed.
    """
    made = [gaussian((640, 640), STEP, 1e-7, (4e-6, 4e-6), law, seed) for seed in range(4)]
    got = [iso.parameters(heights, STEP, wrap) for heights in made]
    assert np.mean([values["Sal"] for values in got]) == pytest.approx(lengths * 4e-6, rel=0.06)
    assert min(values["Str"] for values in got) > 0.85


def test_gradient_of_a_law() -> None:
    """Sdq is 2 Sq / L, and 1 / sqrt 2 of it in each direction; Sdr is Sdq^2 / 2 of small slopes."""
    heights = gaussian((512, 512), STEP, 1e-8, (8e-6, 8e-6), "gaussian", 1)
    got = iso.parameters(heights, STEP, wrap=True)
    assert got["Sdq"] == pytest.approx(2 * got["Sq"] / 8e-6, rel=0.03)
    assert got["Sdr"] == pytest.approx(50 * got["Sdq"] ** 2, rel=1e-3)
    for square in iso._squared_slopes(heights, np.full(2, STEP), True):
        assert np.sqrt(square.mean()) == pytest.approx(np.sqrt(2) * got["Sq"] / 8e-6, rel=0.03)


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("lay_deg", [-70.0, -45.0, 0.0, 12.0, 45.0, 90.0])
def test_lay_and_aspect_of_an_anisotropic_surface(lay_deg: float, wrap: bool) -> None:
    """Std finds the lay within 3 degrees, and Str the ratio of the lengths, 1 / 8, within 25 %."""
    got = iso.parameters(random_lay(lay_deg, 8.0, seed=5), STEP, wrap)
    assert abs((got["Std"] - lay_deg + 90) % 180 - 90) < 3
    assert got["Str"] == pytest.approx(1 / 8, rel=0.25)


def test_a_plane_facet_and_a_wave() -> None:
    """A slope of 3/4 has Sdr 25 %; a wave of 40 um decays to 0.2 at acos(0.2) / (2 pi) of it.

    The wave on spacings of 1 and 3 um has its crests along the track.
    """
    tilted = 0.75 * STEP * np.arange(20.0)[:, None] * np.ones(9)
    got = iso.parameters(tilted, STEP)
    assert (got["Sdq"], got["Sdr"]) == pytest.approx((0.75, 25.0))
    wave = 1e-7 * np.cos(2 * np.pi * np.arange(120) / 40)[None, :] * np.ones((60, 1))
    got = iso.parameters(wave, (3 * STEP, STEP), wrap=True)
    assert got["Sal"] == pytest.approx(40e-6 * np.arccos(0.2) / (2 * np.pi), rel=2e-3)
    assert (got["Std"], got["Sku"], got["Sz"]) == pytest.approx((0.0, 1.5, 2e-7))
    assert got["Str"] <= got["Sal"] / 90e-6 * 1.01  # the wave never decays along its crests
    for profile, wrap in ((wave[:1], True), (wave[:1].T, False)):  # three waves, or open ends
        line = iso.parameters(profile, STEP, wrap)
        assert line["Sal"] == pytest.approx(got["Sal"], rel=0.05)
        assert line["Sdq"] == pytest.approx(got["Sdq"], rel=0.05)


def test_the_aspect_ratio_is_a_bound_where_the_lay_goes_beyond_half_the_surface() -> None:
    """Grooves of 8 nodes' length across and 1000 along never decay on 256 nodes along."""
    grooves = random_lay(0.0, 125.0, seed=3)
    for wrap in (True, False):
        assert iso.is_upper_bound(grooves, STEP, wrap)
        assert not iso.is_upper_bound(random_lay(30.0, 2.0, seed=3), STEP, wrap)
    assert not iso.is_upper_bound(grooves[:, :1], STEP, False)
    assert not iso.is_upper_bound(np.zeros((9, 9)), STEP, True)


def test_scaling_and_flipping() -> None:
    """Lengths scale with the whole surface; turned upside down, peaks and dales change places."""
    heights = np.random.default_rng(2).gamma(2.0, size=(61, 44)) * 1e-7
    got, large = (iso.parameters(k * heights, k * STEP) for k in (1, 1000))
    flipped = iso.parameters(-heights, STEP)
    for name in iso.NAMES:
        factor = 1000 if name in LENGTHS else 1
        assert large[name] == pytest.approx(factor * got[name], rel=1e-6), name
    for name, other in (("Sp", "Sv"), ("Spk", "Svk")):
        assert flipped[name] == pytest.approx(got[other], rel=1e-9)
    assert flipped["Ssk"] == pytest.approx(-got["Ssk"])
    assert flipped["Smrk1"] == pytest.approx(100 - got["Smrk2"])


def test_unmeasured_nodes_do_not_count() -> None:
    """With a tenth of the nodes missing all parameters but the extremes stay within 10 %."""
    heights = gaussian((400, 300), STEP, 1e-7, (6e-6, 6e-6), "gaussian", 3)
    whole = iso.parameters(heights, STEP)
    heights[np.random.default_rng(4).random(heights.shape) < 0.1] = np.nan
    gaps = iso.parameters(heights, STEP)
    masked = np.ma.masked_array(np.nan_to_num(heights, nan=1.0), np.isnan(heights))
    assert iso.surface_parameters(masked, 1e6 * STEP)["Sq"] == pytest.approx(gaps["Sq"])
    for name in ("Sa", "Sq", "Sku", "Sdq", "Sdr", "Sal", "Str", "Sk", "Spk", "Svk", "Smrk1"):
        assert gaps[name] == pytest.approx(whole[name], rel=0.1), name


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 2), (64, 1), (5, 3)])
def test_tiny_surfaces(shape: tuple[int, int], wrap: bool) -> None:
    """Every parameter is a number or NaN, never a warning; flat surfaces have no shape."""
    undefined = {"Ssk", "Sku", "Sal", "Str", "Std"}
    flat = iso.parameters(np.full(shape, 0.1), STEP, wrap)
    assert {name for name, value in flat.items() if np.isnan(value)} == undefined
    assert not any(flat[name] for name in flat.keys() - undefined - {"Smrk2"})
    got = iso.parameters(np.random.default_rng(5).standard_normal(shape), STEP, wrap)
    assert [*got] == [*iso.NAMES]
    assert not np.isinf([*got.values()]).any()
    assert 0 <= got["Smrk1"] <= got["Smrk2"] <= 100
    assert got["Sz"] >= got["Sq"] >= got["Sa"]
    assert min(shape) > 1 or np.isnan(got["Std"])
