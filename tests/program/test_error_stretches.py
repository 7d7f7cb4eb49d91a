"""Runs with an error estimate: marches, rounds, storage, resume and new sound."""

import csv
import io
import json
import os
import signal
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from report_runs import run_results
from scene_text import BODIES, NARROW

from acoustics.bands import BAND_NAMES
from rolling.check import error_cost
from rolling.check.error_cost import LEVELS
from rolling.check.findings import findings
from rolling.commands import Wanted, report, resound, resume, run
from rolling.commands.interface import simulate as simulate_in_memory
from rolling.contact.solver import ContactError
from rolling.figures.sound_views import CurveScales
from rolling.scene.file import loads, read_scene
from rolling.scene.scene import Scene
from rolling.simulation import (
    _result_reading,
    caveats,
    error_stretches,
    result_file,
    run_errors,
    simulate,
)
from rolling.simulation.result import Result
from rolling.simulation.run_errors import Effort, RunErrors
from rolling.simulation.summary import table as summary_table
from rolling.sound.error_estimate import LevelErrors
from rolling.surface.heights import gaussian

NO_PAGE = Wanted(workers=1, page=False)
TEXT = f"""\
name: short
{BODIES}{NARROW}\
rolling: {{load_n: 0.1, speed_m_s: 0.1, duration_s: 0.012}}
numerics: {{error_estimate: true}}
"""
NUMBERS = (
    "grid_error_db",
    "grid_error_uncertainty_db",
    "solver_error_db",
    "laeq_grid_error_db",
    "laeq_grid_error_uncertainty_db",
    "laeq_solver_error_db",
    "plastic_ratio_grid_error",
    "grid_signal_db",
    "solver_signal_db",
    "laeq_uncertainty_db",
)


@pytest.fixture(autouse=True)
def generous(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let short runs pay for stretches, at most two rounds of them."""
    monkeypatch.setattr(error_cost, "SHARE", 8.0)
    monkeypatch.setattr(error_cost, "STRETCH_STEPS", (32, 64))
    monkeypatch.setattr("rolling.sound.error_estimate.WANTED_DB", 1.0)


@pytest.fixture
def scene_path(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(TEXT)
    return path


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run that one process solved."""
    folder = tmp_path_factory.mktemp("estimate")
    (folder / "scene.yaml").write_text(TEXT)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(error_cost, "SHARE", 8.0)
        patch.setattr(error_cost, "STRETCH_STEPS", (32, 64))
        patch.setattr("rolling.sound.error_estimate.WANTED_DB", 1.0)
        run(folder / "scene.yaml", out=folder / "run", wanted=NO_PAGE)
    return folder / "run"


def scene_of(*overrides: str) -> Scene:
    return loads(TEXT, overrides, "scene.yaml")


def numbers(folder: Path) -> dict:
    summary = json.loads((folder / "summary.json").read_text())
    estimate = {**summary["error_estimate"], "seconds_share": None}
    return {name: summary[name] for name in NUMBERS} | {"error_estimate": estimate}


def test_a_run_knows_its_errors(finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text())
    estimate = summary["error_estimate"]
    assert estimate["stretches"] in (4, 8, 9) and estimate["steps"] == 64
    assert 0.5 <= estimate["order"] <= 1.5 and estimate["order_measured"]
    assert estimate["seconds_share"] > 0
    assert -40 < summary["grid_signal_db"] < 0
    assert summary["solver_signal_db"] < summary["grid_signal_db"]
    assert abs(summary["laeq_grid_error_db"]) < 3
    assert abs(summary["plastic_ratio_grid_error"]) < 0.3
    parts = summary["laeq_uncertainty_parts_db"]
    assert summary["laeq_uncertainty_db"] == pytest.approx(
        np.sqrt(sum(part**2 for part in parts.values()))
    )
    assert parts["record"] == summary["uncertainty_db"]["laeq"]
    known = [name for name, level in summary["third_octave_db"].items() if level is not None]
    assert all(summary["grid_error_db"][name] is not None for name in known)


def test_two_processes_compute_the_same_numbers(scene_path: Path, finished: Path) -> None:
    folder = scene_path.parent / "two"
    run(scene_path, out=folder, wanted=Wanted(workers=2, page=False))
    assert numbers(folder) == numbers(finished)
    one, two = (result_file.load(each / "result.h5").stretches for each in (finished, folder))
    assert one and two and one.marches.keys() == two.marches.keys()
    for key, march in one.marches.items():
        assert np.array_equal(march.release, two.marches[key].release)
        assert march.plastic_area == two.marches[key].plastic_area


def test_a_run_without_the_key_has_no_such_numbers(scene_path: Path, finished: Path) -> None:
    folder = scene_path.parent / "plain"
    run(scene_path, ["numerics.error_estimate=false"], out=folder, wanted=NO_PAGE)
    plain = json.loads((folder / "summary.json").read_text())
    with_estimate = json.loads((finished / "summary.json").read_text())
    added = {*NUMBERS, "error_estimate", "laeq_uncertainty_parts_db"}
    assert with_estimate.keys() - plain.keys() == added
    assert plain["laeq_db"] == with_estimate["laeq_db"]
    assert result_file.load(folder / "result.h5").stretches is None


def test_the_estimate_is_added_to_a_finished_run(scene_path: Path, finished: Path) -> None:
    """The key is no physics, so a finished run may be given it and resumed."""
    folder = scene_path.parent / "later"
    run(scene_path, ["numerics.error_estimate=false"], out=folder, wanted=NO_PAGE)
    resolved = folder / "resolved.yaml"
    resolved.write_text(
        resolved.read_text().replace("error_estimate: false", "error_estimate: true")
    )
    resume(folder, wanted=NO_PAGE)
    assert numbers(folder) == numbers(finished)


def test_resume_takes_up_the_marches_that_are_done(
    scene_path: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = scene_path.parent / "killed"
    run(scene_path, out=folder, wanted=NO_PAGE)
    _drop(folder, scene_of(), keep=5)
    marched = []
    inner = error_stretches.contact_on

    def counted(scene: Scene, grid: error_stretches.Grid, first: int, steps: int) -> object:
        marched.append((first, grid.name))
        return inner(scene, grid, first, steps)

    monkeypatch.setattr(error_stretches, "contact_on", counted)
    resume(folder, wanted=NO_PAGE)
    kept = result_file.load(folder / "result.h5").stretches
    assert kept and len(marched) == len(kept.marches) - 5
    assert numbers(folder) == numbers(finished)
    resume(folder, wanted=NO_PAGE)
    assert len(marched) == len(kept.marches) - 5


def _drop(folder: Path, scene: Scene, keep: int) -> None:
    """Write result.h5 as if a run had been killed after a few marches."""
    result = result_file.load(folder / "result.h5")
    assert result.stretches is not None
    result.stretches.marches = dict([*result.stretches.marches.items()][:keep])
    result_file.save(folder / "result.h5", result, scene, TEXT)


def test_new_sound_makes_the_numbers_again_without_marching(
    scene_path: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulate, "simulate_piece", None)
    folder = scene_path.parent / "same"
    resound(finished, ["sound.distance_m=2"], out=folder, wanted=NO_PAGE)
    for name, value in numbers(finished).items():
        if name != "error_estimate":  # levels at another distance are rounded anew
            assert numbers(folder)[name] == pytest.approx(value, abs=1e-9)
    slower = scene_path.parent / "slower"
    resound(finished, ["rolling.speed_m_s=0.05"], out=slower, wanted=NO_PAGE)
    before, after = numbers(finished)["grid_error_db"], numbers(slower)["grid_error_db"]
    # The same lines stand an octave lower.
    assert after["8000"] == pytest.approx(before["16000"], abs=0.5)
    assert after["16000"] is None
    estimate = numbers(slower)["error_estimate"]
    assert estimate["steps"] == numbers(finished)["error_estimate"]["steps"]


def test_stretches_are_marched_over_the_positions_of_the_run() -> None:
    """At the scene's own tolerance and grid a stretch releases the energy of the run."""
    scene = scene_of()
    whole = simulate.simulate_piece(scene, 0, 100, mapped=False).steps["release_energy"]
    for first in (0, 30):
        contact = error_stretches.contact_of(scene, "tight", first, 64)
        part = simulate.simulate_piece(scene, 0, 64, contact=contact, mapped=False)
        release = part.steps["release_energy"]
        off = release - whole[first : first + 64]
        assert np.sqrt(np.mean(off**2)) < 0.01 * np.std(release)


@pytest.mark.parametrize("level", ["fine", "coarse"])
def test_other_grids_see_the_same_asperities(level: str) -> None:
    scene = scene_of("surface.roughness_ra_um=0.02", "plate.hardness_gpa=null")
    releases = []
    for each in ("tight", level):
        contact = error_stretches.contact_of(scene, each, 590, 64)  # across the end of the track
        piece = simulate.simulate_piece(scene, 0, 64, contact=contact, mapped=False)
        releases.append(piece.steps["release_energy"])
    assert np.corrcoef(releases)[0, 1] > 0.97


def test_a_stretch_that_cannot_be_solved_costs_only_the_estimate(
    scene_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = error_stretches.contact_on

    def failing(scene: Scene, grid: error_stretches.Grid, first: int, steps: int) -> object:
        if grid.name == "fine" and first > 0:
            raise ContactError("no room")
        return inner(scene, grid, first, steps)

    monkeypatch.setattr(error_stretches, "contact_on", failing)
    folder = scene_path.parent / "failed"
    done = run(scene_path, out=folder, wanted=NO_PAGE)
    assert done.exit_code == 0
    summary = json.loads((folder / "summary.json").read_text())
    reason = summary["error_estimate"]["reason"]
    assert reason == "a stretch could not be solved again: fine: no room"
    assert summary["laeq_grid_error_db"] is None and summary["laeq_db"] is not None
    stored = result_file.load(folder / "result.h5").stretches
    assert stored and stored.fault == "fine: no room"


@pytest.mark.parametrize(
    ("overrides", "reason"),
    [
        (["surface={kind: smooth, spacing_um: 2, width_um: 128}"], "a smooth surface"),
        (["rolling.duration_s=0.002"], "the track has 100 different steps"),
    ],
)
def test_scenes_without_an_estimate_say_why(
    tmp_path: Path, overrides: list[str], reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(error_cost, "SHARE", 0.25)
    scene = tmp_path / "scene.yaml"
    scene.write_text(loads_text(overrides))
    run(scene, out=tmp_path / "out", wanted=NO_PAGE)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert reason in summary["error_estimate"]["reason"]
    assert summary["grid_error_db"]["1000"] is None
    assert result_file.load(tmp_path / "out" / "result.h5").stretches is None


def loads_text(overrides: list[str]) -> str:
    """Return the scene's text with overrides, of which one may replace a section."""
    import yaml

    data = yaml.safe_load(TEXT)
    for override in overrides:
        key, _, value = override.partition("=")
        section, _, name = key.partition(".")
        if name:
            data[section][name] = yaml.safe_load(value)
        else:
            data[section] = yaml.safe_load(value)
    return yaml.safe_dump(data)


def test_an_elastic_plate_has_an_estimate_without_plastic_ratio(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TEXT.replace(", hardness_gpa: 2.1", ""))
    run(scene, out=tmp_path / "out", wanted=NO_PAGE)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["plastic_ratio_grid_error"] is None
    assert summary["laeq_grid_error_db"] is not None


def test_rounds_end_when_the_standard_errors_suffice(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, stretches = scene_of(), {}
    result = Result.empty(scene.track, scene.start)
    rng = np.random.default_rng(1)
    for values in result.series.values():
        values[:] = 1 + 0.1 * rng.standard_normal(len(values))

    def march(first: int, level: str) -> None:
        release = result.series["release_energy"][first : first + 64]
        noise = {"tight": 0.0, "fine": 0.05, "coarse": 0.1}[level] * rng.standard_normal(64)
        result.add_march(error_stretches.March(first, level, release + noise, 1.0, 1.0))

    rounds = []
    for wanted in (100.0, 1e-9):
        monkeypatch.setattr("rolling.sound.error_estimate.WANTED_DB", wanted)
        while todo := error_stretches.missing(scene, result):
            rounds.append(len(todo) // len(LEVELS))
            for first, level in todo:
                march(first, level)
    layout = error_stretches.layout_of(scene, result.stretches)
    assert rounds[0] == 4 and len(layout.firsts) > 4
    assert sum(rounds) == len(layout.firsts) and not stretches
    assert error_stretches.marched(scene, result) == layout.firsts


def test_errors_of_a_partial_run_wait_for_it(finished: Path) -> None:
    scene, result = scene_of(), result_file.load(finished / "result.h5")
    result.series["release_energy"][-1] = np.nan
    sound = None
    reason = run_errors._reason(scene, result, sound, ())  # type: ignore[arg-type]
    assert reason == "the run is not complete"
    assert error_stretches.missing(scene, result) == []


def test_terminal_tables_and_page_show_the_errors(scene_path: Path, finished: Path) -> None:
    summary = json.loads((finished / "summary.json").read_text())
    text = summary_table([("a", "folder", summary)])
    grid, spread = summary["laeq_grid_error_db"], summary["laeq_grid_error_uncertainty_db"]
    assert f"{grid:+.2f} ± {spread:.2f}" in text and "grid error dB" in text
    assert "errors of a: LAeq corrected" in text and "Errors of grid and solver" in text
    without = {name: value for name, value in summary.items() if name != "error_estimate"}
    assert "grid error dB" not in summary_table([("a", "folder", without)])
    with (finished / "third_octaves.csv").open(newline="") as table:
        known = [row for row in csv.DictReader(table) if row["level_db"] not in ("", "nan")]
    assert known
    for row in known:
        expected = float(row["level_db"]) - float(row["grid_error_db"])
        expected -= float(row["solver_error_db"])
        assert float(row["corrected_level_db"]) == pytest.approx(expected, abs=1e-5)
    page = report([finished], out=scene_path.parent / "page.html").read_text()
    assert "LAeq corrected for grid and solver" in page and "(error " in page


def test_bands_off_by_more_than_1_db_are_a_warning() -> None:
    values = dict.fromkeys(BAND_NAMES, 0.0)
    levels = LevelErrors(1.0, True, *np.zeros((3, 31)), 0.0, 0.0, 0.0, -20.0, -40.0)  # type: ignore[arg-type]
    levels.grid_db[-2:] = 1.5, -3.0
    levels.grid_uncertainty_db[-2:] = 1.0, 0.5
    effort = Effort(4, 64, 0.2, True, 0.1, [])
    errors = RunErrors(levels, effort, 0.0, "")
    assert errors.off_db() == {"20000": -3.0}
    assert errors.corrected_db(values)["16000"] == -1.5
    (caveat,) = caveats._of_errors(scene_of(), errors)
    assert caveat.key == "band_errors" and "20000 Hz (-3.0)" in caveat.text


def test_the_common_axis_has_room_for_levels_less_their_errors(runs) -> None:
    (run,) = run_results(runs.lap())
    levels = LevelErrors(1.0, True, *np.zeros((3, 31)), 0.0, 0.0, 0.0, -20.0, -40.0)  # type: ignore[arg-type]
    own = run.sound.levels.third_octave_db
    band = max(range(31), key=lambda k: own[BAND_NAMES[k]] or -np.inf)
    levels.grid_db[band] = -20.0
    off = replace(run, errors=RunErrors(levels, Effort(4, 64, 0.2, True, 0.1, []), 0.0, ""))
    before, after = (CurveScales.of([each]).third_octaves["Z"] for each in (run, off))
    level = own[BAND_NAMES[band]]
    assert level is not None and before[1] < level + 20 <= after[1] - 2.5


def test_a_measured_error_of_the_grid_stands_for_the_rule(finished: Path) -> None:
    by_key = {each.key: each for each in findings(scene_of())}
    assert "by a rule" in (by_key["resolution"].warning or "")
    summary = json.loads((finished / "summary.json").read_text())
    told = [each["text"] for each in summary["caveats"] if each["key"] == "resolution"]
    assert not any("by a rule" in text for text in told)
    assert bool(told) == (summary["grid_signal_db"] > -20)
    coarse = LevelErrors(1.0, True, *np.zeros((3, 31)), 0.0, 0.0, 0.0, -17.4, -40.0)  # type: ignore[arg-type]
    errors = RunErrors(coarse, Effort(4, 64, 0.2, True, 0.1, []), 0.0, "")
    (caveat,) = caveats._of_errors(scene_of(), errors)
    assert caveat.key == "resolution" and "-17 dB of the release's fluctuation" in caveat.text
    assert "measured by the error estimate" in caveat.text and "of at most 1.28," in caveat.text


def test_check_states_the_cost(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_cost, "SHARE", 0.25)
    by_key = {each.key: each for each in findings(scene_of("rolling.duration_s=0.5"))}
    # The count of cost, up to 0.25, takes 1.95 for the power of a step; blended edges have 2.25.
    assert "27% more" in by_key["error_estimate"].value
    share = by_key["error_estimate"].seconds / by_key["expected_time"].seconds
    assert error_cost.cost_share(scene_of("rolling.duration_s=0.5")) < 0.25
    assert share == pytest.approx(0.2735, abs=0.001)
    by_key = {each.key: each for each in findings(scene_of())}
    assert by_key["error_estimate"].value.startswith("none: the track has 600 different steps")
    off = scene_of("numerics.error_estimate=false")
    assert "error_estimate" not in {each.key for each in findings(off)}


def test_xarray_opens_the_stretches(finished: Path) -> None:
    xarray = pytest.importorskip("xarray", reason="result.h5 is opened with xarray")
    tree = xarray.open_datatree(finished / "result.h5", engine="h5netcdf")
    group = tree["error_estimate"]
    assert group["release_energy"].dims == ("stretch", "level", "stretch_step")
    assert group["release_energy"].attrs["units"] == "J"
    assert np.isfinite(group["release_energy"].values).all()
    assert tuple(group.attrs["levels"].split()) == LEVELS
    tree.close()


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda group: group["first"].__setitem__(0, 10**6), "error_estimate/first"),
        (lambda group: group["release_energy"].__setitem__((0, 0, 3), np.nan), "NaN in a march"),
        (lambda group: group["seconds"].__setitem__((0, 0), -1.0), "are negative"),
        (lambda group: group["plastic_area"].__setitem__((0, 0), np.inf), "are infinite"),
        (lambda group: group.attrs.__setitem__("levels", "fine"), "error_estimate/levels"),
        (lambda group: group.attrs.__setitem__("faults", "{"), "error_estimate/faults"),
    ],
)
def test_damaged_stretches_are_refused(finished: Path, damage, words: str) -> None:
    content = io.BytesIO((finished / "result.h5").read_bytes())
    with h5py.File(content, "r+") as file:
        damage(file["error_estimate"])
        with pytest.raises(_result_reading.Damage, match=words):
            _result_reading.read(file)


def test_a_stopped_estimate_is_taken_up(
    scene_path: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C between two marches keeps the run and the marches that are done."""
    folder = scene_path.parent / "stopped"
    inner = error_stretches.contact_on
    marched: list[tuple[int, str]] = []

    def stopping(scene: Scene, grid: error_stretches.Grid, first: int, steps: int) -> object:
        marched.append((first, grid.name))
        if len(marched) == 4:
            os.kill(os.getpid(), signal.SIGINT)
        return inner(scene, grid, first, steps)

    monkeypatch.setattr(error_stretches, "contact_on", stopping)
    done = run(scene_path, out=folder, wanted=NO_PAGE)
    assert done.interrupted and done.exit_code == 130
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["complete"]
    assert summary["error_estimate"]["reason"] == "its stretches are not solved yet"
    monkeypatch.setattr(error_stretches, "contact_on", inner)
    assert resume(folder, wanted=NO_PAGE).exit_code == 0
    assert numbers(folder) == numbers(finished)


def test_laps_of_a_height_file_at_changing_speed_have_an_estimate(tmp_path: Path) -> None:
    heights = gaussian((301, 65), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 4)
    np.save(tmp_path / "heights.npy", heights)
    (tmp_path / "scene.yaml").write_text(
        "name: file\n"
        "sphere: {radius_mm: 5}\n"
        "plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}\n"
        "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
        "rolling: {load_n: 0.1, speed_m_s: [[0, 0.05], [0.02, 0.15]], duration_s: 0.02,"
        " start_um: 30}\n"
        "numerics: {error_estimate: true}\n"
    )
    scene = read_scene(tmp_path / "scene.yaml")
    assert scene.track.solved_steps == 301 and scene.track.steps > 900
    result = simulate_in_memory(scene, workers=1, progress=False)
    errors = result.errors
    assert errors and errors.levels and errors.effort
    firsts = error_stretches.marched(scene, result.result)
    assert len(firsts) == errors.effort.stretches >= 4
    speeds = error_stretches._speeds(scene, result.result, firsts[0])
    laps = -(-scene.track.steps // 301)
    assert len(speeds) == laps and np.all(np.diff(speeds[speeds > 0]) > 0)
    assert np.isfinite(errors.levels.laeq_grid_db) and abs(errors.levels.laeq_grid_db) < 3
    assert -60 < errors.levels.grid_signal_db < 0
