"""`step_nodes: auto`: steps as long as hearing allows, for a scene, its sweep and its resound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rolling as rc
from rolling.commands import run as commands
from rolling.results.long_record import ListeningError
from rolling.run import folder as folders
from rolling.run.folder import FolderError
from rolling.scene import step_rule
from rolling.scene.file import loads, resound
from rolling.scene.identity import contact_keys, scene_identity
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

TEXT = """\
name: steps
sphere: {radius_mm: 2}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.5}
surface: {kind: gaussian, roughness_ra_um: 0.08, correlation_length_um: 11, \
spacing_um: 1.5, width_um: 192, seed: 77}
rolling: {load_n: 4, speed_m_s: 2, distance_mm: 1.2}
"""
SLOW = "rolling.speed_m_s=0.1"
MEDIUM = "rolling.speed_m_s=0.5"
BODIES = ["sphere.density_kg_m3=7850", "plate.density_kg_m3=7850", "plate.thickness_mm=5"]
BODIES += ["dynamics={}"]


def scene_of(*overrides: str) -> Scene:
    return loads(TEXT, overrides)


def run_of(*overrides: str) -> Scene:
    """Return the only run of a scene."""
    ((_, run),) = scene_of(*overrides).runs()
    return run


def folder_of(tmp_path: Path, *overrides: str) -> Path:
    """Run a scene into a folder."""
    folder = tmp_path / "run"
    assert not commands.run_scene(scene_of(*overrides), folder, workers=1, report=False)
    return folder


# ---- the rule


@pytest.mark.law("steps: a faster sphere never has shorter steps.")
@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["plate.hardness_gpa="],
        ["surface.autocorrelation=exponential"],
        ["surface.roughness_ra_um=1"],
        ["rolling.load_n=0.3"],
        ["sphere.radius_across_mm=6", "surface.width_um=384"],
    ],
    ids=["yielding", "elastic", "exponential", "sub-cells", "light", "elliptic"],
)
def test_steps_grow_with_speed_alone(overrides: list[str]) -> None:
    speeds = np.geomspace(0.02, 50, 60)
    steps = [run_of(*overrides, f"rolling.speed_m_s={v:g}").step_nodes for v in speeds]
    assert steps == sorted(steps) and steps[0] == 1
    run = run_of(*overrides)
    for nodes in step_rule.CHOICES:
        lowest = step_rule.lowest_speed(run, nodes)
        if np.isfinite(lowest):  # the band of the steps has its margin over hearing
            assert lowest / (2 * nodes * run.spacing) >= step_rule.MIN_MARGIN * step_rule.HEARD_HZ


def test_the_lengths_by_speed() -> None:
    found = [run_of(f"rolling.speed_m_s={v}").step_nodes for v in (0.1, 0.5, 2)]
    assert found == [1, 2, 4]


@pytest.mark.parametrize(
    "overrides",
    [
        ["numerics.edges=sharp"],
        ["numerics.edges=sharp", "plate.plasticity=permanent"],
        ["surface.faults=[{kind: pit, at_mm: [0.5, 0], size_um: 20, depth_um: 1}]"],
        ["surface={kind: smooth, spacing_um: 1.5, width_um: 192}"],
        ["recovery.rule=left_end"],
        ["recovery.events=true"],
        ["rolling.distance_mm=1.2015"],  # 801 nodes
        ["surface.roughness_ra_um=0.001"],
        ["rolling.load_n=0.001"],
        ["rolling.speed_m_s=[[0, 0.05], [0.2, 3]]"],
        [*BODIES, "rolling.load_n=0.7"],
    ],
    ids=[
        "sharp",
        "permanent",
        "fault",
        "smooth",
        "left end",
        "events",
        "odd",
        "too smooth",
        "small contact",
        "from slow",
        "may bounce",
    ],
)
def test_steps_stay_at_a_node_where_longer_ones_were_not_measured(overrides: list[str]) -> None:
    assert run_of("rolling.speed_m_s=5").step_nodes == 4
    assert run_of("rolling.speed_m_s=5", *BODIES).step_nodes == 4
    run = run_of("rolling.speed_m_s=5", *overrides)
    assert run.step_nodes == 1 and run.step_choice is not None
    assert run.step_choice.text.startswith("1 node: ")


def test_a_drop_a_sphere_with_a_surface_and_a_file_have_steps_of_a_node(tmp_path: Path) -> None:
    fast = "rolling.speed_m_s=5"
    for name in ("marble-dropped", "bearing-grades", "measured-scan"):
        for _, run in rc.read_scene(name, [fast]).runs():
            assert run.step_nodes == 1


def test_a_change_of_speed_counts_for_its_slowest_part() -> None:
    """A start that is slower for less than 1 % of the time does not count."""
    slow = "rolling.speed_m_s=[[0, 0.1], [1, 2]]"
    brief = "rolling.speed_m_s=[[0, 0.1], [1e-6, 2]]"
    assert run_of(slow).step_nodes == 1 and run_of(brief).step_nodes == 4


def test_a_rolling_out_sphere_counts_until_it_is_slow() -> None:
    rolling_out = ["rolling.resistance=0.02", "sphere.density_kg_m3=7850"]
    assert run_of(*rolling_out).step_nodes == 4  # the track ends before it is slow
    assert run_of(*rolling_out, "rolling.distance_mm=").step_nodes == 1


# ---- the error


@pytest.mark.law("steps: at auto the level keeps to that of steps of one node within 0.05 dB.")
@pytest.mark.parametrize("overrides", [[], [MEDIUM], ["plate.hardness_gpa="]])
def test_the_level_is_that_of_steps_of_a_node(overrides: list[str]) -> None:
    """The rule was not fitted to these scenes."""
    length = "rolling.distance_mm=2.4"
    auto = rc.simulate(scene_of(*overrides, length), workers=1, progress=False)
    one = scene_of(*overrides, length, "numerics.step_nodes=1")
    exact = rc.simulate(one, workers=1, progress=False)
    assert auto.scene.step_nodes > 1
    assert auto.sound.levels.laeq_db == pytest.approx(exact.sound.levels.laeq_db, abs=0.05)
    error = auto.sound.pressure / auto.sound.factor - exact.sound.pressure / exact.sound.factor
    fluctuation = exact.sound.pressure / exact.sound.factor
    assert 10 * np.log10(np.mean(error**2) / np.mean(fluctuation**2)) < -30


def test_auto_is_the_number_that_it_takes_to_the_last_bit() -> None:
    auto = scene_of(MEDIUM)
    number = scene_of(MEDIUM, "numerics.step_nodes=2")
    assert scene_identity(auto) == scene_identity(number)
    runs = [rc.simulate(scene, workers=1, progress=False) for scene in (auto, number)]
    for name in ("release_energy", "approach", "iterations"):
        np.testing.assert_array_equal(*(run.series[name] for run in runs))
    assert [run.numbers.effort.step_nodes for run in runs] == [2, 2]
    assert runs[0].numbers.effort.step_choice.startswith("auto, 2 nodes")
    assert runs[1].numbers.effort.step_choice == "a number of the scene"


# ---- sweeps


@pytest.mark.law("steps: the slowest speed of a sweep decides, and its runs share a march.")
def test_the_slowest_speed_of_a_sweep_decides() -> None:
    swept = scene_of("sweep.rolling.speed_m_s=[0.5, 3, 1]")
    runs = [run for _, run in swept.runs()]
    assert [run.step_nodes for run in runs] == [2, 2, 2]
    assert contact_keys(runs[0]) == contact_keys(runs[1]) == contact_keys(runs[2])
    alone = run_of(MEDIUM)
    assert contact_keys(alone) == contact_keys(runs[1])


def test_a_run_of_a_sweep_stays_as_it_is_in_a_grown_sweep_of_the_same_speeds() -> None:
    small = scene_of("sweep.rolling.load_n=[4]")
    large = scene_of("sweep.rolling.load_n=[4, 0.001]")
    assert [run.step_nodes for _, run in small.runs()] == [4]
    assert [run.step_nodes for _, run in large.runs()] == [4, 1]


def test_a_folder_that_grows_by_a_slower_run_says_what_keeps_its_march(tmp_path: Path) -> None:
    folder = tmp_path / "sweep"
    fast = scene_of("sweep.rolling.speed_m_s=[2, 3]", "rolling.distance_mm=0.3")
    assert not commands.run_scene(fast, folder, workers=1, report=False)
    slower = fast.with_(sweep={"rolling.speed_m_s": [0.1, 2, 3]})
    with pytest.raises(FolderError, match=r"auto takes 1 .*speed_m_s=2 has 4.*step_nodes=4"):
        commands.run_scene(slower, folder, workers=1, report=False)
    kept = slower.with_(step_nodes=4)
    assert not commands.run_scene(kept, folder, workers=1, report=False)


def test_slowest_m_s_chooses_for_a_slower_sphere(tmp_path: Path) -> None:
    scene = scene_of("numerics.slowest_m_s=0.5", "rolling.distance_mm=0.6")
    assert [run.step_nodes for _, run in scene.runs()] == [2]
    run = rc.simulate(scene, workers=1, progress=False)
    saved = run.save(tmp_path / "kept", report=False)
    assert rc.open_run(saved).scene == run.scene
    assert resound(folders.stored_scene(saved), [MEDIUM]).runs()[0].scene.step_nodes == 2


# ---- another speed for stored runs


def test_a_run_is_heard_anew_down_to_the_speed_that_its_steps_allow(tmp_path: Path) -> None:
    folder = folder_of(tmp_path)
    (stored,) = folders.stored_runs(folder)
    assert stored.scene.step_nodes == 4 and stored.scene.step_choice is not None
    lowest = stored.scene.step_choice.lowest
    with pytest.raises(SceneError, match="steps of 6 um") as error:
        commands.resound(folder, [SLOW], tmp_path / "slow", report=False)
    text = str(error.value)
    assert "--set numerics.step_nodes=1" in text and not (tmp_path / "slow").exists()
    named = float(text.partition("hearing from ")[2].partition(" m/s")[0])
    assert lowest <= named <= 1.1 * lowest
    target = tmp_path / "again"
    speed = f"rolling.speed_m_s={named}"
    assert not commands.resound(folder, [speed], target, workers=1, report=False)
    again = rc.open_run(target)
    np.testing.assert_array_equal(
        again.series["release_energy"], rc.open_run(folder).series["release_energy"]
    )
    run = rc.open_run(folder)
    with pytest.raises(ListeningError, match="hold hearing from"):
        run.listen(1.0, speed=0.5 * lowest)


def test_a_faster_sound_keeps_the_steps_of_the_stored_run(tmp_path: Path) -> None:
    folder = folder_of(tmp_path, SLOW)
    target = tmp_path / "fast"
    assert not commands.resound(folder, ["rolling.speed_m_s=3"], target, workers=1, report=False)
    fast = rc.open_run(target)
    assert fast.scene.step_nodes == 1 and run_of("rolling.speed_m_s=3").step_nodes == 4
    np.testing.assert_array_equal(
        fast.series["release_energy"], rc.open_run(folder).series["release_energy"]
    )


def test_a_number_is_heard_at_any_speed(tmp_path: Path) -> None:
    scene = scene_of("numerics.step_nodes=4")
    assert resound(scene, [SLOW]).runs()[0].scene.step_nodes == 4


# ---- page


def test_the_page_has_the_length_of_long_steps_alone() -> None:
    from rolling.report.live import live_of

    for overrides, step in (([], 6e-6), ([SLOW], None)):
        run = rc.simulate(scene_of(*overrides), workers=1, progress=False)
        data = live_of(run)
        assert data is not None and data["longStep"] == (step and pytest.approx(step))
        assert data["scene"]["numerics"]["step_nodes"] == "auto"
