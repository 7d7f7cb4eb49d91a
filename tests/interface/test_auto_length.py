"""`rolling.duration_s: auto`: the shortest track whose levels are known, of a scene and a sweep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rolling as rc
from acoustics.bands import BAND_NAMES
from acoustics.level import sound_levels
from acoustics.uncertainty import expected_uncertainty, level_uncertainty
from rolling.ball_kinds.ball_candidates import candidates_of
from rolling.commands import run as commands
from rolling.run.folder import FolderError
from rolling.scene.file import loads, resound
from rolling.scene.identity import scene_identity
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.sound.needed_record import ExpectedVibration, needed_record, two_digits_up

TEXT = """\
name: length
sphere: {radius_mm: 2}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.5}
surface: {kind: gaussian, roughness_ra_um: 0.08, correlation_length_um: 11, \
spacing_um: 1.5, width_um: 192, seed: 77}
rolling: {load_n: 4, speed_m_s: 0.5}
"""
# A wide aim, so that a march takes a moment.
WIDE = "numerics.within_db=2"


def scene_of(*overrides: str) -> Scene:
    return loads(TEXT, overrides)


def run_of(*overrides: str) -> Scene:
    """Return the only run of a scene."""
    ((_, run),) = scene_of(*overrides).runs()
    return run


def seconds_of(scene: Scene) -> list[float | None]:
    """Return the lengths of the runs of a scene."""
    return [run.rolling.stated_duration_s for _, run in scene.runs()]


# ---- the rule


def even(low_hz: float, high_hz: float, quality: float = 1.0) -> ExpectedVibration:
    """Return an even spectrum between two frequencies."""
    frequency = np.geomspace(10, 20e3, 4000)
    density = np.where((frequency > low_hz) & (frequency < high_hz), 1.0, 0.0)
    return ExpectedVibration(frequency, density, resonance_hz=1e4, quality=quality)


@pytest.mark.law("length: N lines of equal strength leave 4.34/sqrt(N) dB.")
def test_the_length_is_that_of_the_lines_that_are_needed() -> None:
    """An even third octave of 1 kHz needs 19 lines for 1 dB, and 209 for 0.3 dB of LAeq."""
    width_hz = 1122 - 891
    need = needed_record(even(891.3, 1122.0), within_db=0.3, most_s=100)
    assert need.seconds * width_hz == pytest.approx((4.343 / 0.3) ** 2, rel=0.06)
    assert need.reason == "LAeq within ± 0.3 dB"
    # Of a wide spectrum the lowest third octave that counts needs most.
    wide = needed_record(even(400, 16e3), within_db=0.3, most_s=100)
    assert wide.reason.startswith("third octaves within ± 1 dB, the lowest at 800 Hz")
    assert wide.seconds * (891.3 - 707.9) == pytest.approx(4.343**2, rel=0.1)


def test_what_is_far_below_hearing_needs_no_record() -> None:
    """At 1e-10 m/s the spectrum ends at 25 uHz, where the A-weighting leaves nothing."""
    slow = ExpectedVibration(
        np.geomspace(1.25e-5, 2.5e-5, 4000), np.full(4000, 1e-42), resonance_hz=1e4, quality=10.0
    )
    need = needed_record(slow, within_db=0.3, most_s=100)
    assert (need.seconds, need.reason) == (0.0, "nothing is heard")


def test_a_resonance_needs_three_lines_or_leaves_its_comb_in_the_uncertainty() -> None:
    frequency = np.sort(
        np.concatenate((np.geomspace(20, 20e3, 2000), np.linspace(9e3, 11e3, 9000)))
    )
    for quality in (100.0, 1000.0):
        width = 1e4 / quality
        density = 1 / ((frequency - 1e4) ** 2 + width**2 / 4)
        expected = ExpectedVibration(frequency, density, 1e4, quality)
        need = needed_record(expected, within_db=5, most_s=0.1)
        assert (need.reason == "3 lines in the resonance at 10000 Hz") == (quality == 100)
        assert need.seconds <= 0.1


def test_the_longest_length_says_what_it_leaves() -> None:
    need = needed_record(even(891.3, 1122.0), within_db=0.1, most_s=1)
    assert need.seconds == 1
    assert "as far as the longest track of auto allows: ± 0.3 dB of LAeq" in need.reason


def test_an_expected_uncertainty_is_the_mean_of_those_of_records() -> None:
    rng = np.random.default_rng(3)
    frequency = np.arange(1, 4001) * 4.0
    square = 1 / (1 + ((frequency - 2000) / 300) ** 2)
    expected = expected_uncertainty(frequency, square)
    laeq, bands = [], []
    for _ in range(30):
        line = np.sqrt(square) * (rng.standard_normal(4000) + 1j * rng.standard_normal(4000))
        record = np.fft.irfft(np.concatenate(([0], line, np.zeros(2000))))
        rate = len(record) * 4.0
        found = level_uncertainty(record, rate, sound_levels(record, rate), own_factor=False)
        laeq.append(found.laeq_db)
        bands.append(found.third_octave_db["2000"])
    assert expected.laeq_db == pytest.approx(np.mean(laeq), rel=0.05)
    of_band = expected.third_octave_db[BAND_NAMES.index("2000")]
    assert of_band == pytest.approx(np.mean(bands), rel=0.05)


@pytest.mark.parametrize(
    ("value", "rounded"), [(0.2061, 0.21), (0.2, 0.2), (0.20001, 0.21), (1e-3, 1e-3), (99.1, 100)]
)
def test_lengths_have_two_digits(value: float, rounded: float) -> None:
    assert two_digits_up(value) == rounded


# ---- scenes


@pytest.mark.law("length: a narrower aim never takes a shorter track.")
def test_a_narrower_aim_takes_a_longer_track() -> None:
    aims = [3, 1, 0.5, 0.3, 0.1]
    lengths = [run_of(f"numerics.within_db={aim}").track.n_along for aim in aims]
    assert lengths == sorted(lengths) and lengths[0] < lengths[-1]


def test_a_scene_without_a_length_has_that_of_auto() -> None:
    without = run_of()
    stated = run_of("rolling.duration_s=auto")
    assert without.track == stated.track and without.track.closed
    assert without.track.n_along % 4 == 0
    assert without.length_choice is not None and without.length_choice.reason
    assert scene_identity(without) == scene_identity(stated)
    number = scene_of(f"rolling.duration_s={without.rolling.duration_s}")
    assert number.runs()[0].scene.length_choice is None
    assert number.track == without.track


def test_a_distance_of_auto_is_that_of_a_duration() -> None:
    assert run_of("rolling.distance_mm=auto").track == run_of().track


@pytest.mark.law("length: the runs of a sweep share the longest length.")
def test_runs_of_a_sweep_share_the_longest() -> None:
    loads = [0.5, 4, 30]
    alone = [run_of(f"rolling.load_n={load}").track.n_along for load in loads]
    swept = scene_of(f"sweep.rolling.load_n={loads}").runs()
    assert len(set(alone)) > 1
    assert {run.track.n_along for _, run in swept} == {max(alone)}
    speeds = "sweep.rolling.speed_m_s=[0.2, 0.5]"
    by_time = [run.duration for _, run in scene_of(speeds, "rolling.duration_s=auto").runs()]
    assert by_time[0] == pytest.approx(by_time[1], rel=1e-3)
    by_way = [run.track.n_along for _, run in scene_of(speeds, "rolling.distance_mm=auto").runs()]
    assert by_way[0] == by_way[1]


def test_candidates_share_the_longest_or_the_one_that_is_stated() -> None:
    light, heavy = scene_of("rolling.load_n=0.5", "name=light"), scene_of("name=heavy")
    lengths = {one.scene.track.n_along for one in candidates_of([light, heavy])}
    assert len(lengths) == 1
    stated = scene_of("rolling.duration_s=0.25", "name=stated")
    lengths = {one.scene.track.n_along for one in candidates_of([light, stated])}
    assert lengths == {stated.track.n_along}


def test_a_ball_with_a_surface_makes_whole_turns() -> None:
    run = run_of(
        WIDE,
        "sphere.surface={kind: gaussian, roughness_ra_um: 0.02, "
        "correlation_length_um: 20, seed: 2}",
    )
    assert run.track.closed and run.track.n_along % run.track.turn_nodes == 0
    assert run.length_choice is not None and "whole turn" in run.length_choice.reason


def test_a_file_is_taken_once_round() -> None:
    scene = rc.read_scene("measured-scan")
    auto = scene.with_({"rolling.duration_s": "auto", "rolling.distance_mm": None})
    assert auto.length_choice is None
    assert auto.track.steps == scene.with_({"rolling.duration_s": None}).track.steps


@pytest.mark.parametrize(
    ("overrides", "reason"),
    [
        (["rolling.speed_m_s=[[0, 0.1], [1, 2]]"], "a speed that changes"),
        (["rolling.resistance=0.01", "sphere.density_kg_m3=7850"], "a speed that changes"),
        (["plate.plasticity=permanent", "numerics.edges=sharp"], "a plate that remembers"),
        (["surface={kind: smooth, spacing_um: 1.5, width_um: 192}"], "without random heights"),
        (
            ["surface.faults=[{kind: pit, at_mm: [0.5, 0], size_um: 20, depth_um: 1}]"],
            "a plate with faults",
        ),
    ],
)
def test_auto_is_refused_with_the_key_to_give(overrides: list[str], reason: str) -> None:
    with pytest.raises(SceneError, match=rf"rolling\.duration_s: got auto.*{reason}.*a number"):
        scene_of("rolling.duration_s=auto", *overrides)


def test_check_says_which_length_it_would_take() -> None:
    (rows,) = scene_of().check(solve=False).runs.values()
    (row,) = [row for row in rows if row.key == "length_choice"]
    assert row.quantity == "duration_s: auto"
    assert row.value.startswith(f"{run_of().duration:.3g}") and "within" in row.value


# ---- stored runs


def test_a_stored_run_keeps_its_length(tmp_path: Path) -> None:
    """A resumed sweep finds its runs done, one that needs more is told the number to pin."""
    folder = tmp_path / "run"
    scene = scene_of(WIDE, "sweep.rolling.load_n=[4, 8]")
    assert not commands.run_scene(scene, folder, workers=1, report=False)
    before = rc.open_run(folder / "load_n=4")
    assert before.numbers.effort.length_choice.startswith("auto, ")
    assert before.scene.track == scene.runs()[0].scene.track
    assert not commands.run_scene(scene, folder, workers=1, report=False)
    assert rc.open_run(folder / "load_n=4").numbers == before.numbers
    with pytest.raises(FolderError, match=r"--set rolling\.duration_s=.*keeps its march"):
        commands.run_scene(
            scene.with_(sweep={"rolling.load_n": [4, 8, 0.02]}), folder, workers=1, report=False
        )
    # Another distance of the listener changes what is needed, and not what is stored.
    heard = resound(scene, ["sound.distance_m=0.5", "rolling.speed_m_s=0.6"])
    assert {run.track.n_along for _, run in heard.runs()} == {before.scene.track.n_along}
