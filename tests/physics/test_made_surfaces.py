"""Made surfaces: skewness, kurtosis, self-affine spectra, and a lay at an angle."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from checked import checked
from hard_cases.gaussian_heights import gaussian
from scene_text import PLAIN
from scipy.integrate import quad

import rolling as rc
from rolling.check import force_estimate
from rolling.in_si import scene_surface
from rolling.report.assumed import surface_words
from rolling.scene import file as scene_file
from rolling.scene.laws import Roughness, SelfAffineLaw
from rolling.scene.scene import Scene
from rolling.surface import heights as surface
from rolling.surface import made
from rolling.surface.made import johnson_heights

SPACING = 1e-6
SHAPE = (256, 192)
AFFINE = "surface={kind: self-affine, hurst: 0.8, rolloff_um: 16, shortest_um: 4, %s, spacing_um: 1"


def roughness(**keys) -> Roughness:
    return Roughness(**{"roughness_ra_um": 0.1, "correlation_length_um": 6, "seed": 4} | keys)


def affine(**keys) -> SelfAffineLaw:
    size = {} if {"roughness_ra_um", "rdq"} & {*keys} else {"rq_um": 0.2}
    return SelfAffineLaw(
        **{"hurst": 0.8, "rolloff_um": 48, "shortest_um": 4, "seed": 4} | size | keys
    )


def moments(z: np.ndarray) -> tuple[float, float]:
    """Return skewness and kurtosis, by their definitions."""
    z = z - z.mean()
    return tuple(float(np.mean(z**n) / np.mean(z**2) ** (n / 2)) for n in (3, 4))


def wave_numbers(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return both components of all waves of a grid [rad/m]."""
    x, y = (2 * np.pi * np.fft.fftfreq(n, SPACING) for n in shape)
    return np.meshgrid(x, y, indexing="ij")


@pytest.mark.law("Surface: made heights have their skewness, kurtosis and spectrum at once.")
@pytest.mark.parametrize(
    ("law", "pair"),
    [
        (roughness(), (0, 2.1)),
        (roughness(), (-1.3, 5.5)),
        (roughness(), (0.7, 2.9)),
        (roughness(autocorrelation="exponential", correlation_length_um=12), (1.5, 7)),
        (affine(), (-0.4, 12)),
    ],
)
def test_skewness_and_kurtosis_keep_the_waves_of_the_gaussian_surface(law, pair: tuple) -> None:
    """Both moments are within 0.005, and each wave has the share of the same seed's Gaussian one.

    Amplitudes agree within rounding of transforms, 1e-12 of the largest.
    """
    gaussian = made.of_law(SHAPE, SPACING, law.in_si, 4)
    law = law.model_copy(update=dict(zip(("skewness", "kurtosis"), pair, strict=True)))
    heights = made.of_law(SHAPE, SPACING, law.in_si, 4)
    assert moments(heights) == pytest.approx(pair, abs=0.005)
    waves = [np.abs(np.fft.rfft2(z / np.std(z))) for z in (heights, gaussian)]
    np.testing.assert_allclose(*waves, rtol=0, atol=1e-12 * waves[1].max())
    np.testing.assert_array_equal(heights, made.of_law(SHAPE, SPACING, law.in_si, 4))
    described = made.described(heights, SPACING, law.in_si)
    assert (described["skewness"], described["kurtosis"]) == pytest.approx(moments(heights))
    errors = described["spectrum_error_db"]
    chances = described["spectrum_chance_db"]
    assert all(abs(errors[octave]) < 4 * chances[octave] + 0.01 for octave in errors)


@pytest.mark.parametrize(
    ("pair", "reached"), [((0, 1.05), 1.6), ((0, 400), 30), ((-18, 330), 40), ((1.9, 4.62), 5)]
)
def test_unreachable_pairs_end_as_near_as_they_come(pair: tuple, reached: float) -> None:
    """Near the bound, or of few asperities, heights stay finite and their Ra exact."""
    law = roughness(**dict(zip(("skewness", "kurtosis"), pair, strict=True)))
    heights = made.of_law((48, 32), SPACING, law.in_si, 1)
    assert np.abs(heights).mean() == pytest.approx(1e-7, rel=1e-12)
    assert 1 < moments(heights)[1] < max(reached, pair[1])


@pytest.mark.parametrize("skewness", [0.0, 0.4, -2.0, 6.0])
@pytest.mark.parametrize("excess", [0.05, 2.0, 9.0])
def test_johnson_heights_have_their_moments(skewness: float, excess: float) -> None:
    """Any kurtosis above skewness^2 + 1; 2e5 quantiles miss up to 7 % of long tails."""
    wanted = skewness, skewness**2 + 1 + excess * (1 + skewness**2)
    heights = johnson_heights(*wanted, 200_000)
    assert np.all(np.diff(heights) >= 0)
    assert moments(heights) == pytest.approx(wanted, rel=0.08, abs=0.003)


@pytest.mark.law("Surface: Sq and Sdq of a self-affine law are the integrals of its spectrum.")
@pytest.mark.parametrize("hurst", [0.0, 0.3, 0.8, 1.0])
def test_self_affine_sizes_are_integrals_of_the_spectrum(hurst: float) -> None:
    """Sq^2 and Sdq^2 are int C q dq/(2 pi) and int C q^3 dq/(2 pi), by quadrature."""
    law = affine(hurst=hurst)
    first, last = (2e6 * np.pi / x for x in (law.rolloff_um, law.shortest_um))

    def integral(power: int) -> float:
        falling = quad(lambda q: (q / first) ** (-2 * (1 + hurst)) * q**power, first, last)[0]
        return first ** (power + 1) / (power + 1) + falling

    assert law.rms_slope(1) / law.rq_m == pytest.approx(math.sqrt(integral(3) / integral(1)))
    slope = law.rms_slope(1)
    assert affine(hurst=hurst, rdq=slope).rq_m == pytest.approx(law.rq_m)
    # Over the plane of wave numbers the density adds up to Sq^2.
    q = np.linspace(0, last * 1.01, 40_001)
    plane = made.plane_density(law.in_si, q, np.zeros(1))
    assert 2 * np.pi * np.trapezoid(plane * q, q) == pytest.approx(law.rq_m**2, rel=1e-3)


@pytest.mark.law("Surface: a self-affine surface has the spectrum of its law, and ends with it.")
def test_self_affine_spectrum_follows_its_law() -> None:
    """Rings of the mean of 12 surfaces are within 4 standard errors of 1/sqrt(waves)."""
    law = affine(hurst=0.6, rolloff_um=16)
    count = 12
    qx, qy = wave_numbers(SHAPE)
    q = np.hypot(qx, qy)
    total = np.zeros(SHAPE)
    for seed in range(count):
        total += np.abs(np.fft.fft2(made.of_law(SHAPE, SPACING, law.in_si, seed))) ** 2 / count
    first = 2e6 * np.pi / 16
    last = 2e6 * np.pi / 4
    assert total[q > last * 1.001].max() < 1e-20 * total.max()
    wanted = np.where((q > 0) & (q < last * 1.001), np.maximum(q / first, 1) ** -3.2, 0.0)
    wanted *= law.rq_m**2 * total.size**2 / wanted.sum()
    edges = np.array([0.5, 1, 1.6, 2.5, 3.9]) * first
    for low, high in pairwise(edges):
        ring = (q >= low) & (q < high)
        allowed = 4 / math.sqrt(ring.sum() * count / 2) + 0.01  # 1 % for the scale by Sq
        assert np.mean(total[ring] / wanted[ring]) == pytest.approx(1, abs=allowed)


@pytest.mark.parametrize("pair", [(0, 3), (-0.8, 4)])
def test_the_requested_size_is_exact(pair: tuple) -> None:
    shape = dict(zip(("skewness", "kurtosis"), map(float, pair), strict=True))
    qx, qy = wave_numbers((128, 96))
    for law, size in (
        (affine(rolloff_um=24, **shape), lambda z: z.std() * 1e6 / 0.2),
        (affine(rolloff_um=24, roughness_ra_um=0.3, **shape), lambda z: np.abs(z).mean() / 3e-7),
        (
            affine(rolloff_um=24, rdq=0.05, **shape),
            lambda z: np.sqrt(sum(np.mean(slope(z, q) ** 2) for q in (qx, qy))) / 0.05,
        ),
    ):
        heights = made.of_law((128, 96), SPACING, law.in_si, 2)
        assert size(heights) == pytest.approx(1, rel=1e-10)
        assert law.rq_m == pytest.approx(heights.std(), rel=0.15)


def slope(z: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the derivative of band-limited heights along a direction."""
    return np.fft.ifft2(1j * q * np.fft.fft2(z)).real


@pytest.mark.law("Surface: a lay turns the ellipse of the autocorrelation, from x to y.")
@pytest.mark.parametrize("lay", [30.0, -50.0, 120.0])
def test_lay_turns_the_ellipse_of_the_autocorrelation(lay: float) -> None:
    """Gradients of the law exp(-(r/L)^2) have the variances 2 rq^2/L^2 along both directions.

    Over 10 surfaces of 200 patches each the angle is certain within 1 degree, 3 are allowed.
    """
    law = roughness(correlation_length_across_um=16, lay_deg=lay)
    tensor = np.zeros((2, 2))
    qx, qy = wave_numbers(SHAPE)
    for seed in range(10):
        z = made.of_law(SHAPE, SPACING, law.in_si, seed)
        gradient = np.array([slope(z, q).ravel() for q in (qx, qy)])
        tensor += gradient @ gradient.T / z.size / np.mean(z**2) / 10
    steepness, axes = np.linalg.eigh(tensor)
    assert steepness == pytest.approx(2 / np.array([16e-6, 6e-6]) ** 2, rel=0.1)
    steepest = math.degrees(math.atan2(axes[1, 1], axes[0, 1]))  # across the short length, 6 um
    assert abs((steepest - lay + 90) % 180 - 90) < 3
    along, across = 1e-6 * np.array(law.lengths_um)
    assert 2 / along**2 == pytest.approx(tensor[0, 0], rel=0.1)
    assert 2 / across**2 == pytest.approx(tensor[1, 1], rel=0.1)


@pytest.mark.parametrize(("lay", "lengths"), [(0, (6, 16)), (180, (6, 16)), (-90, (16, 6))])
def test_lay_along_and_across_is_that_of_both_lengths(lay: float, lengths: tuple) -> None:
    law = roughness(correlation_length_across_um=16, lay_deg=lay)
    plain = [1e-6 * length for length in lengths]
    np.testing.assert_array_equal(
        made.of_law(SHAPE, SPACING, law.in_si, 4),
        gaussian(SHAPE, SPACING, 1e-7, tuple(plain), "gaussian", 4),
    )


@pytest.mark.parametrize(
    ("name", "nodes"), [("gaussian", 64), ("exponential", 64), ("gaussian", 16)]
)
def test_a_turned_lay_on_a_narrow_period_has_the_spectrum_of_its_law(name: str, nodes: int) -> None:
    """The waves of a period are those of the plane (Poisson's sum), but for folded ones.

    The nearest lag alone left steps: Sdq was 1.68 times that of the Gaussian law on 64 nodes.
    """
    lengths = {"correlation_length_um": 100, "correlation_length_across_um": 10, "lay_deg": 37}
    law = roughness(autocorrelation=name, **lengths)
    shape = (512, nodes)
    spacing = 2e-6
    density = surface.spectral_density(shape, spacing, law.in_si)
    along = np.fft.fftfreq(shape[0], spacing)
    across = np.fft.rfftfreq(nodes, spacing)
    waves = 2 * np.pi * along[:, None], 2 * np.pi * across
    kept = np.hypot(*waves) < 2 * np.pi / 32e-6
    both = density, made.plane_density(law.in_si, *waves)
    shares = [values[kept] / values[kept].sum() for values in both]
    assert shares[0] == pytest.approx(shares[1], rel=0.1, abs=1e-7)
    if name == "gaussian":
        slopes = [((waves[0] ** 2 + waves[1] ** 2) * values).sum() for values in both]
        assert slopes[0] / density.sum() == pytest.approx(slopes[1] / both[1].sum(), rel=0.01)


def test_a_lay_that_reaches_too_far_is_refused() -> None:
    lengths = {"correlation_length_um": 1e9, "correlation_length_across_um": 10, "lay_deg": 37}
    with pytest.raises(surface.SurfaceError, match="too far to be turned, allowed: up to"):
        made.of_law(SHAPE, SPACING, roughness(**lengths).in_si, 4)


def scene(*overrides: str) -> Scene:
    return scene_file.loads(PLAIN, list(overrides))


def test_force_estimate_of_a_turned_lay_is_between_those_along_and_across() -> None:
    def force(*keys: str) -> float | None:
        masses = "dynamics={}", "sphere.density_kg_m3=7850", "plate.density_kg_m3=7850"
        return force_estimate.force_rms(
            scene("surface.correlation_length_across_um=4", *masses, *keys)
        )

    along = force()
    across = force("surface.lay_deg=90")
    swapped = force("surface.correlation_length_across_um=20", "surface.correlation_length_um=4")
    if scene().surface.correlation_length_um == 20:
        assert across == swapped
    low, high = sorted((along, across))
    assert low < force("surface.lay_deg=35") < high
    assert force("surface.lay_deg=35") == pytest.approx(force("surface.lay_deg=-35"))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("surface.kurtosis=1", "kurtosis: got 1, allowed: more than 1, the square of the skewness"),
        ("surface.skewness=-2", "kurtosis: got 3, allowed: more than 5,.*nearest: 5.05"),
        ("surface.lay_deg=20", "lay_deg: got 20, allowed: none without correlation_length_acro"),
        (
            AFFINE % "rq_um: 1, rdq: 1" + ", width_um: 64, seed: 1}",
            "rq_um: got rq_um and rdq, allowed: ex",
        ),
        (AFFINE % "seed: 1" + ", width_um: 64}", "rq_um: missing, allowed: exactly one of"),
        (AFFINE % "rq_um: 1" + ", width_um: 8, seed: 1}", "rolloff_um: got 16, allowed: from"),
        (
            (AFFINE % "rq_um: 1" + ", width_um: 64, seed: 1}").replace("_um: 4", "_um: 3.9"),
            "shortest_um: got 3.9, allowed: at least 4 spacings, 4",
        ),
    ],
)
def test_impossible_laws_are_refused(override: str, words: str) -> None:
    with pytest.raises(rc.SceneError, match=words):
        scene(override)


@pytest.mark.parametrize(
    ("override", "quantity", "value", "warning"),
    [
        ("surface.kurtosis=4", "skewness and kurtosis", "0 and 4, requested 0 and 4", None),
        ("surface.kurtosis=1.05", "skewness and kurtosis", "requested 0 and 1.05", "another pair"),
        (
            AFFINE % "rq_um: 0.02" + ", width_um: 48, seed: 1}",
            "spectrum against its law, by octave",
            "dB at",
            "at least 64 um",
        ),
    ],
)
def test_check_states_the_made_heights(
    override: str, quantity: str, value: str, warning: str | None
) -> None:
    judged = {finding.quantity: finding for finding in checked(scene(override))}
    assert value in judged[quantity].value.replace("-0 ", "0 ")
    assert (warning or "") in (judged[quantity].warning or "")
    assert bool(warning) == bool(judged[quantity].warning)
    assert not {"skewness and kurtosis", "spectrum against its law, by octave"} & {
        finding.quantity for finding in checked(scene())
    }


def test_a_run_reports_its_made_heights() -> None:
    """Plate and sphere are described in the summary."""
    ball = "sphere.surface={kind: gaussian, roughness_ra_um: 0.01, correlation_length_um: 8"
    short = "rolling.duration_s=null", "rolling.distance_mm=0.064", "rolling.load_n=0.1"
    small = scene(*short, AFFINE % "rq_um: 0.05" + ", width_um: 64, seed: 1, skewness: -0.5}")
    numbers = rc.simulate(small, workers=1, progress=False).numbers
    assert numbers.surface.made.skewness == pytest.approx(-0.5, abs=0.3)
    assert "4 to 8" in numbers.surface.made.spectrum_error_db
    assert "self-affine from 16 to 4 µm" in surface_words(small)
    assert not scene_surface.has_detail(small)
    both = scene(*short, f"{ball}, seed: 1, kurtosis: 4}}")
    assert [*scene_surface.scene_surface(both).made] == ["ball_surface_made"]
