"""Long steps lose release as a table says; a scene gets a warning with numbers or a refusal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from checked import checked
from helpers import STEEL, make_track, releases, roll, rough
from scene_text import SCENES

from acoustics import resampling
from rolling.check import resolution
from rolling.check.long_steps import refuse_long_steps
from rolling.contact import closed_forms
from rolling.kinds.reading import read_scene
from rolling.scene.file import loads
from rolling.scene.messages import SceneError
from rolling.studies import lee2025 as reproduce

SCENE = """\
name: long
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 3}
rolling: {load_n: 0.5, speed_m_s: 1, duration_s: 0.002}
"""  # 20.1 um of Hertz radius: four of them are 80.4 um, 40.2 nodes
LOAD = 20.0
RADIUS = 5e-3
A = closed_forms.hertz_radius(LOAD, RADIUS, STEEL)
NODES = 8  # per radius, twice as many for the smooth sphere


def per_metre(
    heights: np.ndarray, nodes: int, hardness: float = np.inf, times: int = 1
) -> np.ndarray:
    """Return the release [J/m] of each step of a march with `times` 8 nodes per radius."""
    track = make_track(
        heights, spacing=A / NODES / times, load=LOAD, radius=RADIUS, hardness=hardness
    )
    track = replace(track, step=nodes * track.spacing)
    return releases(track, roll(track, 0, len(heights) // nodes)) / track.step


@pytest.mark.law("Long steps: a smooth sphere loses the tabulated share of its release.")
@pytest.mark.parametrize("radii", [0.25, 0.5, 1.0, 2.0, 3.0, 4.0])
def test_a_smooth_elastic_sphere_loses_what_the_table_says(radii: float) -> None:
    """The loss agrees with the table within its errors.

    16 nodes per radius leave 0.1 % where the table was marched at 32, and its straight lines
    leave 0.1 %.
    """
    got = per_metre(np.zeros((256, 80)), round(2 * radii * NODES), times=2)[
        :2
    ] / closed_forms.smooth_release_power(LOAD, 1.0, RADIUS, STEEL)
    assert 1 - got == pytest.approx(resolution.lost_release(radii), abs=0.002)


@pytest.mark.law("Long steps: a rough contact loses no more than a smooth one.")
@pytest.mark.parametrize(("hardness", "height"), [(np.inf, 1e-7), (1.4e9, 1e-7), (2.1e9, 4e-7)])
def test_rough_contacts_lose_no_more_and_levels_stay_within_their_bound(
    hardness: float, height: float
) -> None:
    """Surfaces other than those of the bounds keep to them.

    The release itself may be lower by 0.02 more. Levels are those of the fluctuation up to the
    Nyquist frequency of the longer steps.
    """
    heights = rough(720, 60, height)
    fine = per_metre(heights, 1, hardness)
    for nodes in (4, 8, 20):
        coarse = per_metre(heights, nodes, hardness)
        radii = nodes * A / NODES / max(A, np.sqrt(LOAD / (np.pi * hardness)))
        lost = 1 - coarse.mean() / fine.mean()
        assert -0.01 < lost < resolution.lost_release(radii) + 0.02
        below = [resampling.undo_step_mean(series) for series in (coarse, fine)]
        lines = [
            np.abs(np.fft.rfft(series)[1 : len(coarse) // 2]) / len(series) for series in below
        ]
        off = 5 * np.log10(np.sum(lines[0] ** 2) / np.sum(lines[1] ** 2))  # 10 lg of the rms
        assert abs(off) < resolution.LEVEL_ERROR_DB * radii


def test_the_radius_is_the_larger_of_elastic_and_plastic() -> None:
    # (3 W R / 4 E*)^(1/3)
    assert resolution.contact_radius(loads(SCENE)) == pytest.approx(20.1e-6, rel=1e-2)
    soft = loads(SCENE, ["plate.hardness_gpa=0.1"])
    assert resolution.contact_radius(soft) == pytest.approx(np.sqrt(0.5 / (np.pi * 1e8)))  # 39.9 um
    assert resolution.contact_radius(loads(SCENE, ["plate.hardness_gpa="])) == pytest.approx(
        20.1e-6, rel=1e-2
    )


def test_steps_beyond_four_radii_are_refused_with_the_longest_step() -> None:
    """Four radii of 20.1 um are 40.2 nodes of 2 um; a sweep is refused by its shortest contact."""
    refuse_long_steps(loads(SCENE, ["numerics.step_nodes=40"]))
    with pytest.raises(SceneError, match=r"step_nodes: got 41.*4\.08 times.*nearest: 40"):
        refuse_long_steps(loads(SCENE, ["numerics.step_nodes=41"]))
    swept = loads(SCENE, ["numerics.step_nodes=41", "sweep.rolling.load_n=[0.5, 5]"])
    with pytest.raises(SceneError, match=r"step_nodes: got 41.*load_n=0\.5") as error:
        refuse_long_steps(swept)
    assert len(error.value.mistakes) == 1
    with pytest.raises(SceneError, match=r"surface\.spacing_um, 0\.101"):
        refuse_long_steps(loads(SCENE, ["rolling.load_n=1e-9"]))


@pytest.mark.parametrize(("radius", "millimetres"), [(0.005, "5"), (0.0127, "12.7")])
def test_a_radius_in_metres_is_told_as_such(radius: float, millimetres: str) -> None:
    """Not the steps are wrong, nor the load: both messages name the radius and its likely unit."""
    words = ["rolling.load_n=weight", "sphere.density_kg_m3=7850", f"sphere.radius_mm={radius}"]
    with pytest.raises(SceneError, match=r"sphere\.radius_mm: got 0\.0") as error:
        refuse_long_steps(loads(SCENE, words))
    (text,) = error.value.mistakes
    assert "step_nodes" not in text
    assert f"likely a radius in metres: write {millimetres}" in text
    (doubt,) = [
        finding.warning
        for finding in checked(loads(SCENE, [f"sphere.radius_mm={radius}"]))
        if finding.key == "contact_radius"
    ]
    assert f"sphere.radius_mm is {radius}" in doubt and f"write {millimetres}" in doubt
    small = loads(SCENE, ["sphere.radius_mm=0.1", "rolling.load_n=1e-9"])
    with pytest.raises(SceneError, match="step_nodes: got"):  # a small ball of a real bearing
        refuse_long_steps(small)


def test_warning_gives_the_expected_errors() -> None:
    """A step of a radius loses 6.4 % by the table, and levels up to 3 dB."""

    def warning(*overrides: str) -> str | None:
        return {f.key: f.warning for f in checked(loads(SCENE, overrides))}["step_length"]

    assert warning("numerics.step_nodes=2") is None  # 0.2 radii
    text = str(warning("numerics.step_nodes=10"))
    assert all(number in text for number in ("0.99 contact radii", "6.4 %", "3 dB", "5 um"))
    assert warning("numerics.step_nodes=2", "surface.spacing_um=4") is not None  # 0.4 radii


def test_scenes_of_the_repository_have_short_steps() -> None:
    """No scene is refused or warned, nor the quick study with steps three times as long."""
    for path in SCENES:
        scene = read_scene(path)
        if scene.height_path is None:
            refuse_long_steps(scene)
            assert all(
                run.step <= resolution.DOUBTFUL_RADII * resolution.contact_radius(run)
                for _, run in scene.runs()
            )
    files = sorted((SCENES[0].parent / "lee2025").glob("*/*.yaml"))
    assert files
    for path in files:
        quick = read_scene(path, reproduce.quick_overrides(read_scene(path)))
        for _, run in quick.runs():
            assert run.step <= resolution.DOUBTFUL_RADII * resolution.contact_radius(run)
