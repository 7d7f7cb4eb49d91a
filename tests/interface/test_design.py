"""Which waves to lower: the least change, lower waves, the linear response, and its promise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

import rolling as rc
from rolling import cli
from rolling.choice.audition import audition_of
from rolling.choice.choosing import open_choice
from rolling.choice.design_search import design_scene, write_design
from rolling.choice.least_change import fall_of, least_change
from rolling.choice.wave_bands import PlateBands
from rolling.contact.load_shares import approach_of_part, load_shares
from rolling.contact.march import march
from rolling.surface.lowered_waves import bands_of_track, lower_waves, waves_of_band

SMALL = """\
name: small
sphere: {radius_mm: 1.5, material: steel-100cr6}
plate: {material: steel-100cr6, thickness_mm: 3, contact_loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 15, spacing_um: 4,
          width_um: 128, seed: 1}
rolling: {load_n: 1, speed_m_s: 0.2, distance_mm: 0.6}
dynamics: {}
"""


@pytest.fixture
def scene(tmp_path: Path) -> rc.Scene:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return rc.read_scene(path)


@pytest.mark.law("Design: the least change is the minimum that a general optimizer finds.")
def test_the_least_change_is_the_minimum() -> None:
    response = np.array([0.0, 0.02, 0.3, 0.2, 0.05])
    lowered = least_change(response, 4.0)
    assert fall_of(response, lowered) == pytest.approx(4.0, abs=1e-9)
    assert lowered[0] == 0.0
    found = minimize(
        lambda x: float(x @ x),
        np.full(5, 5.0),
        bounds=[(0, None)] * 5,
        constraints={"type": "ineq", "fun": lambda x: fall_of(response, x) - 4.0},
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert found.success
    # a line search ends within the root of its tolerance
    assert lowered == pytest.approx(found.x, abs=2e-3)
    # A sound that is linear in its waves: the remaining shares add up, however much is lowered.
    whole = response / response.sum()
    assert whole @ 10 ** (-least_change(whole, 9.0) / 10) == pytest.approx(10**-0.9)


def test_bands_that_are_known_by_chance_do_not_stand_for_all() -> None:
    def of(mean: float, scatter: float) -> PlateBands:
        responses = np.random.default_rng(6).normal(mean, scatter, size=(6, 20))
        return PlateBands(np.geomspace(1e-4, 1e-6, 20), np.full(20, 1e-8), responses)

    finest, *_, alike = of(0.05, 0.002).resolutions
    assert np.all(finest.response > 0)
    assert not finest.doubt
    assert alike.doubt
    assert np.ptp(alike.response) == 0.0
    assert alike.response.sum() == pytest.approx(of(0.05, 0.002).response.sum())
    noisy = of(0.01, 0.1)
    coarser = [one for one in noisy.resolutions if one.doubt]
    assert all(np.all(one.response >= 0) and one.response.any() for one in coarser)
    assert len(coarser) == 2
    few = PlateBands(np.geomspace(1e-4, 5e-5, 4), np.full(4, 1e-8), noisy.responses[:, :4])
    assert all(one.response.shape == (4,) for one in few.resolutions)


@pytest.mark.law("Design: the error of a response holds for specimens that are alike.")
def test_the_error_of_a_response_counts_places_that_are_alike() -> None:
    places = np.arange(8.0)
    correlation = np.exp(-np.abs(places[:, None] - places) / 4)
    root = np.linalg.cholesky(correlation)
    of_bands = 0.1 + 0.02 * (root @ np.random.default_rng(8).normal(size=(8, 3000)))
    wavelengths, rms = np.geomspace(1e-3, 1e-5, 3000), np.full(3000, 1e-8)
    as_single = PlateBands(wavelengths, rms, of_bands)
    alike = replace(as_single, correlation=correlation)
    assert as_single.error == pytest.approx(of_bands.std(axis=0, ddof=1) / np.sqrt(8))
    true_error = float(np.std(alike.response))
    assert np.sqrt(np.mean(alike.error**2)) == pytest.approx(true_error, rel=0.05)
    assert np.sqrt(np.mean(as_single.error**2)) < 0.6 * true_error
    # A response that single places would make sure stays open on places that are alike.
    few = PlateBands(wavelengths[:1], rms[:1], 0.1 + 0.08 * np.array([[-1], [0], [1.0]]))
    assert few.is_known and not replace(few, correlation=0.5 + 0.5 * np.eye(3)).is_known
    # Places that are as good as one count as a single specimen does: without an error.
    one = replace(few, correlation=np.ones((3, 3)))
    assert np.isnan(one.error).all() and one.is_known
    assert np.isnan(PlateBands(wavelengths[:1], rms[:1], few.responses[:1]).error).all()


@pytest.mark.law("Lower waves: amplitudes by their factors, phases and all other waves as before.")
def test_waves_are_lowered_with_their_phases(scene: rc.Scene) -> None:
    spacing = 3e-6
    heights = np.random.default_rng(1).normal(size=(400, 8))
    changed = heights.copy()
    lower_waves(changed, spacing, {100e-6: 6.0, 31.5e-6: 20.0})
    before = np.fft.rfft(heights, axis=0)[1:]
    ratio = np.fft.rfft(changed, axis=0)[1:] / before
    wavelength = 400 * spacing / np.arange(1, 201)
    wanted = np.ones(200)
    wanted[(wavelength > 89.2e-6) & (wavelength < 112.2e-6)] = 10 ** (-6 / 20)
    wanted[(wavelength > 28.2e-6) & (wavelength < 35.5e-6)] = 0.1
    assert ratio == pytest.approx(np.repeat(wanted[:, None], 8, axis=1), abs=1e-9)
    # The third octaves of the track hold all waves but the mean.
    parts = [
        waves_of_band(heights, spacing, float(middle)) for middle in bands_of_track(12e-4, spacing)
    ]
    short = np.abs(np.fft.rfft(heights - heights.mean(axis=0) - sum(parts), axis=0))[1:]
    assert short[wavelength > 2 * spacing * 10**0.1].max() < 1e-9


@pytest.mark.law("Linear response: a small change of the surface moves the approach as predicted.")
def test_load_shares_predict_the_approach_over_a_changed_surface() -> None:
    rng = np.random.default_rng(3)
    waves = np.fft.rfft2(rng.normal(size=(96, 48)))
    along = np.fft.fftfreq(96)[:, None]
    waves *= np.exp(-(((along) ** 2 + np.fft.rfftfreq(48)[None] ** 2) * 150))
    heights = np.fft.irfft2(waves, (96, 48))
    heights *= 1e-7 / heights.std()
    contact = rc.RollingContact(
        heights=heights,
        spacing=2e-6,
        radius=2e-3,
        contact_modulus=115e9,
        hardness=np.inf,
        load=0.5,
        step=2e-6,
        start=0.0,
        tolerance=1e-6,
    )
    half_space = rc.HalfSpace(2e-6, 115e9)
    part = waves_of_band(heights, 2e-6, 31.6e-6)
    predicted = approach_of_part(part, load_shares(contact, half_space, 12))
    small = 0.02

    def approach(over: np.ndarray) -> np.ndarray:
        states = march(replace(contact, heights=over), 0, 12, half_space)
        return np.array([state.approach for state in states])

    lower = approach(heights - small * part)
    higher = approach(heights + small * part)
    actual = (higher - lower) / (2 * small)
    # The two loads are 6 % apart, within which some nodes come into contact.
    assert np.std(predicted - actual) < 0.06 * np.std(actual)
    assert predicted.mean() == pytest.approx(actual.mean(), abs=0.06 * float(np.std(actual)))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--quieter", "90"], "up to 60 dB"),
        (["--quieter", "-3"], "quieter"),
        (["--quieter", "3", "--pairs", "1"], "from 2 to 30"),
        (["--quieter", "3", "--set", "sweep.rolling.load_n=[1, 2]"], "without a sweep"),
        (["--quieter", "3", "--set", "rolling.drop_mm=0.01"], "the sphere falls"),
        (
            ["--quieter", "3", "--set", "surface={kind: smooth, spacing_um: 4, width_um: 128}"],
            "without waves",
        ),
        (["--quieter", "3", "--set", "surface.lowered_db={110: 3}"], "nearest: 100"),
        (["--quieter", "3", "--set", "surface.lowered_db={100: -3}"], "0 to 100 dB"),
    ],
)
def test_bad_input_gets_one_sentence(
    words: list[str],
    told: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    monkeypatch.chdir(tmp_path)
    try:
        code = cli.main(["design", str(path), *words, "--workers", "1"])
    except SystemExit as error:  # of argparse
        code = int(error.code or 0)
    said = capsys.readouterr().err
    assert code == 2
    assert told in said, said
    assert not (tmp_path / "outputs").exists()


def test_a_bearing_is_told_why_it_has_no_design() -> None:
    with pytest.raises(rc.SceneError, match="two raceways"):
        rc.design(rc.read_scene("bearing-6204"), 3, progress=False)


DRAWN = np.random.default_rng(71)  # of the scenes of the test below


def drawn(scene: rc.Scene) -> list[rc.Scene]:
    """Draw two scenes."""
    scenes = []
    for number in range(2):
        scenes.append(
            scene.with_(
                {
                    "name": f"drawn-{number}",
                    "surface.roughness_ra_um": round(float(DRAWN.uniform(0.03, 0.15)), 3),
                    "surface.correlation_length_um": round(float(DRAWN.uniform(12, 25)), 1),
                    "rolling.load_n": round(float(DRAWN.uniform(0.5, 2.0)), 2),
                    "rolling.speed_m_s": round(float(DRAWN.uniform(0.1, 0.5)), 2),
                    "surface.seed": int(DRAWN.integers(1, 1000)),
                }
            )
        )
    return scenes


@pytest.mark.slow
@pytest.mark.usefixtures("short_sounds")
@pytest.mark.law("Design: surfaces that it has not seen get quieter by its promise, within its ±.")
def test_unseen_surfaces_get_quieter_by_what_was_promised(scene: rc.Scene, tmp_path: Path) -> None:
    for number, (one, wanted) in enumerate(zip(drawn(scene), (3.0, 2.0), strict=True)):
        found = design_scene(one, wanted, tmp_path / str(number), pairs=2, workers=1)
        # The surfaces that are marched are not those whose response was taken.
        assert found.fall.db == pytest.approx(wanted, abs=found.fall.uncertainty_db)
        label = f"others-{number}"
        if number:
            (fall,) = falls_of_others(found, [found.changed], tmp_path / label)
        else:
            half = {
                wavelength: round(db / 2, 2)
                for wavelength, db in found.changed.surface.lowered_db.items()
            }
            lower = [found.scene.with_({"surface.lowered_db": half}), found.changed]
            by_half, fall = falls_of_others(found, lower, tmp_path / label)
            assert 0 < by_half.db < fall.db
        both = float(np.hypot(found.fall.uncertainty_db, fall.uncertainty_db))
        assert fall.db == pytest.approx(found.fall.db, abs=2 * both)
        if number == 0:
            files = write_design(found)
            assert all(path.is_file() for path in files)
            again = rc.read_scene(tmp_path / "0" / "design.yaml")
            assert again.surface == found.changed.surface


def falls_of_others(found: rc.Design, lower: list[rc.Scene], folder: Path) -> list[rc.Difference]:
    """March four surfaces that a design has not seen, and return how much each scene is quieter."""
    audition = audition_of(found.scene)
    other = {"surface.seed": found.scene.surface.seed + 500}
    base = audition.unchanged(found.scene.with_(other))
    quiet = [
        replace(base, label=f"lower {number}", scene=one.with_(other))
        for number, one in enumerate(lower)
    ]
    with open_choice([base, *quiet], folder, workers=1) as work:
        ((now, *lowered), _) = work.hear([base, *quiet], 4)
    return [audition.difference(found.quantity.name, now.heard, one.heard) for one in lowered]
