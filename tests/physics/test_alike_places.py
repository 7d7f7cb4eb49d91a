"""Laws of places on one scan: how much alike they are, and as how many they count."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import rolling as rc
from acoustics.arrays import Array
from acoustics.pairs import independent_pairs, paired_mean, sureness
from rolling.ball_kinds import linear_level
from rolling.ball_kinds.ball_candidates import candidate
from rolling.ball_kinds.ball_specimens import BallSpecimens
from rolling.ball_kinds.linear_level import error_db, linear_change_db
from rolling.ball_kinds.linear_response import linear_response
from rolling.choice.difference import paired_difference
from rolling.in_si.scene_surface import scene_surface
from rolling.surface.alike_places import alike_levels

SMALL = rc.Scene.from_dict(
    {
        "name": "my-ball",
        "sphere": {"radius_mm": 1.5, "material": "steel-100cr6"},
        "plate": {"material": "steel-100cr6", "thickness_mm": 3, "contact_loss_factor": 0.01},
        "surface": {
            "kind": "gaussian",
            "roughness_ra_um": 0.1,
            "correlation_length_um": 15,
            "spacing_um": 3,
            "width_um": 192,
            "seed": 1,
        },
        "rolling": {"load_n": 1, "speed_m_s": 0.2, "distance_mm": 4},
        "dynamics": {},
    }
)


def ridges(shape: tuple[int, int], along: float, across: float, seed: int) -> Array:
    """Make closed heights of unit variance, with correlation lengths in nodes."""
    x = 2 * np.pi * np.fft.fftfreq(shape[0]) * along
    y = 2 * np.pi * np.fft.rfftfreq(shape[1]) * across
    noise = np.random.default_rng(seed).normal(size=shape)
    law = np.exp(-(x[:, None] ** 2 + y**2) / 8)
    heights = np.fft.irfft2(np.fft.rfft2(noise) * law, s=shape)
    return np.asarray(heights / heights.std())


@pytest.mark.law("Choice: correlated pairs count as fewer independent ones, and their ± holds.")
@pytest.mark.parametrize("length", [0.5, 1.5, 3.0])
def test_the_uncertainty_of_correlated_pairs_holds(length: float) -> None:
    """Six places in a row whose levels are correlated as the square of a Gaussian."""
    places = np.arange(6.0)
    correlation = np.exp(-2 * ((places[:, None] - places) / length) ** 2)
    root = np.linalg.cholesky(correlation)
    draws = np.random.default_rng(4).normal(size=(1500, 6)) @ root.T
    means = [paired_mean(values, correlation) for values in draws]
    independent = independent_pairs(correlation)
    assert means[0].independent == independent
    assert np.var([one.mean for one in means]) == pytest.approx(1 / independent, rel=0.15)
    squares = [one.error**2 for one in means]
    assert np.mean(squares) == pytest.approx(1 / independent, rel=0.1)
    signs = [sureness(one.mean, one.error, one.freedom) for one in means]
    assert np.mean(np.array(signs) > 0.95) == pytest.approx(0.1, abs=0.03)


def test_pairs_without_correlation_are_what_they_were() -> None:
    values = np.array([1.0, 2.0, 4.0, 1.5, 0.5, 3.0, 2.5])
    of_pairs = paired_mean(values)
    assert of_pairs == pytest.approx(paired_mean(values, np.eye(7)))
    assert of_pairs.freedom == pytest.approx(5) and of_pairs.independent == pytest.approx(7)
    assert of_pairs.error == pytest.approx(np.std(values[:6], ddof=1) / math.sqrt(7))


def test_places_that_are_all_alike_have_no_uncertainty() -> None:
    apart = paired_difference("vibration", np.full(6, 2.0), {}, correlation=np.ones((6, 6)))
    assert apart.uncertainty_db is None and apart.sureness is None
    assert apart.independent == 1.0 and apart.further_scan_db is None


@pytest.mark.law("Choice: a further scan of each halves the variance of the mean of places.")
def test_a_further_scan_brings_as_many_places_again() -> None:
    values = np.array([1.0, 2.0, 4.0, 1.5, 0.5, 3.0])
    alike = np.full((6, 6), 0.3) + 0.7 * np.eye(6)
    one = paired_difference("vibration", values, {}, correlation=alike)
    assert one.uncertainty_db is not None and one.further_scan_db is not None
    assert one.independent == pytest.approx(6 / 2.5)
    assert one.further_scan_db < one.uncertainty_db / math.sqrt(2)  # more degrees of freedom, too
    shared = paired_difference("vibration", values, {"grid": 9.0}, correlation=alike)
    assert shared.further_scan_db == pytest.approx(9, rel=0.02)


@pytest.mark.law("Choice: levels of places covary as the square of what they hear does.")
@pytest.mark.parametrize("window", [600, 150])
def test_levels_of_places_are_alike_as_the_square_of_the_autocorrelation(window: int) -> None:
    """Gaussian ridges of 10 nodes across: exp(-2 (d / 10)^2) at the same stretch."""
    alike = alike_levels(ridges((600, 600), 4, 10, seed=2), window)
    across = alike.correlation[0, [0, 5, 10, 15]]
    assert across == pytest.approx(np.exp(-2 * np.array([0, 0.5, 1, 1.5]) ** 2), abs=0.06)
    # the mean square over a window of a Gaussian with the correlation exp(-(m / 4)^2)
    lags = np.arange(-20, 21)
    assert alike.variance == pytest.approx(
        2 * np.sum(np.exp(-2 * (lags / 4) ** 2)) / window, rel=0.15
    )
    beside = alike.between(np.array([0, 0, window // 2]), np.array([0, 300, 0]))
    assert beside[0, 0] == pytest.approx(1) and abs(beside[0, 1]) < 0.06
    half = 1.0 if window == 600 else 0.5  # of a stretch that is heard in both
    assert beside[0, 2] == pytest.approx(half, abs=0.1)


def test_a_scan_with_lay_has_fewer_independent_places(tmp_path: Path) -> None:
    """Ridges of 300 um on 0.6 mm: two or three places; heights without lay: nearly all six."""
    counts = []
    for across in (4, 75):
        heights = 2e-8 * ridges((320, 300), 4, across, seed=across)[:, :150]
        np.save(tmp_path / "scan.npy", heights)
        one = candidate("scan", scene_of(tmp_path / "scan.npy"))
        specimens = BallSpecimens([one])
        alike = specimens.correlation(one, one, range(6))
        assert alike is not None and np.all(np.linalg.eigvalsh(alike) > -0.02)
        counts.append(independent_pairs(alike))
    assert counts[0] > 4 and counts[1] < 3


def scene_of(path: Path) -> rc.Scene:
    """Return the scene of a scan."""
    surface = {"kind": "file", "path": str(path), "spacing_um": 4, "periodic": "blend"}
    return rc.Scene.from_dict(
        {
            "name": "scan",
            "sphere": {"radius_mm": 3, "material": "steel-100cr6"},
            "plate": {"material": "steel-100cr6", "thickness_mm": 3},
            "surface": surface,
            "rolling": {"load_n": 1, "speed_m_s": 0.1},
            "dynamics": {},
        }
    )


# ---- level by the linear response


@pytest.mark.law("Choice: the linear level of heights is that of the law that they follow.")
@pytest.mark.parametrize("length_um", [6, 30])
def test_the_linear_level_of_heights_is_that_of_their_law(length_um: float) -> None:
    """Spectra of heights on a grid, and densities of a law, by separate code."""
    scene = SMALL.with_({"surface.correlation_length_um": length_um, "rolling.distance_mm": 8})
    made = scene_surface(scene)
    rq_m = float(made.heights.std())
    of_heights = linear_response(scene, rq_m).mean_square(made.heights, made.spacing)
    of_law = linear_level.mean_square(scene, rq_m)
    assert 10 * math.log10(of_heights / of_law) == pytest.approx(0, abs=0.3)


def test_a_linear_change_is_that_of_a_march() -> None:
    """Marched on six surfaces (docs/what-would-help.md): +2.48, -0.70 and +0.49 dB per 10 %."""
    for key, value, marched_db in (
        ("sphere.radius_mm", 1.65, 2.48),
        ("plate.thickness_mm", 3.3, -0.70),
        ("surface.roughness_ra_um", 0.11, 0.49),
        ("rolling.load_n", 1.1, -0.34),
    ):
        linear_db = linear_change_db(SMALL, SMALL.with_({key: value}))
        assert linear_db is not None
        stated_db = error_db(key, linear_db)
        assert stated_db is not None
        assert linear_db == pytest.approx(marched_db, abs=1.5 * stated_db)
    assert error_db("surface.correlation_length_um", 0.5) is None
