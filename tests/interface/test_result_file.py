"""A result.h5 holds what was solved to the last bit, and readers of netCDF understand it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from finished import VIBRATING, WITHOUT_DYNAMICS, marched, run_of, same, untimed
from scene_text import BODIES, MADE
from stored_arrays import stored_arrays

from rolling.check import error_cost
from rolling.kinds.run_folder import RunFolder
from rolling.marches.next_pieces import next_pieces
from rolling.marches.observers import SlowMotion
from rolling.marches.result import MovingRelease
from rolling.results.result_file import read_result, write_result
from rolling.results.run_result import Run, make_run, read_run, write_run
from rolling.scene import file

SCENE = f"""\
name: small
{BODIES}{MADE}\
rolling: {{load_n: 0.3, speed_m_s: [[0, 0.1], [0.004, 0.2]], duration_s: 0.006}}
recovery: {{events: true}}
"""
MOVED = ["dynamics.release=true", "rolling.speed_m_s=0.6", "surface.roughness_ra_um=0.02"]
ESTIMATED = ["numerics.error_estimate=true"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Return a run of three pieces, with events and a changing speed."""
    run = marched(SCENE, folder=tmp_path_factory.mktemp("whole"))
    write_run(run)
    return run


def test_all_of_a_run_comes_back_to_the_last_bit(
    tmp_path: Path, whole: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Everything comes back but the times of the clock, so that nothing is solved again."""
    monkeypatch.setattr(error_cost, "SHARE", 3.0)  # a short run pays for its stretches
    monkeypatch.setattr(error_cost, "MIN_STEPS", 16)
    monkeypatch.setattr(error_cost, "MAX_STEPS", 50)
    filmed = marched(SCENE, ["rolling.duration_s=0.015"], tmp_path / "filmed", film=True)
    moved = marched(VIBRATING, MOVED, tmp_path / "moved")
    estimated = marched(VIBRATING, ESTIMATED, tmp_path / "estimated")
    assert moved.result.moving is not None and filmed.result.slow_motion is not None
    assert estimated.result.stretches is not None
    assert len({each.pressure.shape for each in whole.result.maps.values()}) > 1  # ragged
    for run, film in ((whole, False), (filmed, True), (moved, False), (estimated, False)):
        write_run(run)
        again = read_run(run, "run")
        assert np.isnan(again.result.series["step_time"]).all()
        again.result.series["step_time"] = run.result.series["step_time"]
        for name in vars(again.result):
            if name not in ("extremes", "motion", "effort"):
                assert same(getattr(again.result, name), getattr(run.result, name)), name
        assert next_pieces(run.scene, again.result, film) == []
        assert np.array_equal(again.sound.pressure, run.sound.pressure)
        assert untimed(again.numbers) == untimed(run.numbers)  # writing took time as well
        assert stored_arrays(write_result(again)) == stored_arrays(run.folder / "result.h5")


def test_equal_runs_have_equal_arrays_and_attributes(whole: Run) -> None:
    """The time that a step takes differs from march to march, and stands in no result."""
    again = run_of(whole.scene, whole.folder)
    assert not np.array_equal(again.result.series["step_time"], whole.result.series["step_time"])
    assert stored_arrays(write_result(again)) == stored_arrays(write_result(whole))


def test_marches_that_failed_come_back_as_failed(tmp_path: Path) -> None:
    run = marched(VIBRATING, ["dynamics.release=true"], tmp_path)
    assert run.result.moving is not None and run.result.load_marches is not None
    steps = run.result.solved_steps
    run.result.moving = MovingRelease.impossible(run.result.moving.key, steps, "no load")
    run.result.load_marches.failures = {2.5: "too wide"}
    run.result.slow_motion = SlowMotion.none()
    write_run(run)
    again = read_result(tmp_path / "result.h5", run.scene)
    assert again.moving is not None and again.moving.failure == "no load"
    assert again.load_marches is not None and again.load_marches.failures == {2.5: "too wide"}
    assert again.slow_motion is not None and not again.slow_motion.pressure.size


def test_readers_of_netcdf_find_names_units_and_places(whole: Run) -> None:
    path = whole.folder / "result.h5"
    scene = whole.scene
    result = whole.result
    with xr.open_datatree(path, engine="h5netcdf") as tree:
        assert set(tree.children) == {"snapshot", "pressure_maps", "events", "sound"}
        for node in tree.subtree:
            for variable in node.dataset.data_vars.values():
                assert variable.attrs["units"] and variable.attrs["long_name"]
        release = tree["release_power"]
        assert set(release.coords) == {"step", "time"} and release.attrs["units"] == "W"
        assert set(tree["approach"].coords) == {"position", "position_time"}
        middles = scene.motion.distance(release["time"].values)
        assert np.allclose(middles, release["step"].values, rtol=1e-12, atol=0)
        assert np.allclose(release, tree["release_per_metre"] * tree["speed"], rtol=1e-12, atol=0)
        maps = tree["pressure_maps"]
        for k, pressure_map in enumerate(result.maps.values()):
            rows = int(maps["rows"][k])
            columns = int(maps["columns"][k])
            block = maps["pressure"][k].values
            assert np.array_equal(block[:rows, :columns], pressure_map.pressure)
            assert np.isnan(block[rows:]).all() and np.isnan(block[:, columns:]).all()
        assert file.loads(tree.attrs["scene"]) == scene and tree.attrs["load_n"] == 0.3
        assert tree.attrs["identity"] == result.identity and tree.attrs["format"] == 5
    with xr.open_dataset(path) as data:  # the engine is found by itself
        assert data["release_power"].sizes == {"step": result.steps}


def test_the_sound_in_the_file_has_the_level_of_the_summary(whole: Run) -> None:
    pressure = whole.to_xarray()["sound/pressure"].values
    level = 20 * np.log10(np.sqrt(np.mean(pressure**2)) / 20e-6)
    assert level == pytest.approx(whole.numbers.of_record.level_db, abs=1e-6)


def test_a_force_law_holds_the_load_of_the_run(tmp_path: Path) -> None:
    run = marched(VIBRATING, folder=tmp_path)
    tree = run.to_xarray()
    law = tree["force_law/approach"]
    force = tree["contact_force"]
    assert np.array_equal(law.sel(load=1.0), tree["approach"])
    assert np.all(np.diff(law, axis=0) > 0)
    assert float(force["force"].mean()) == pytest.approx(1.0, rel=1e-9)
    loads = law["load"].values
    assert loads[0] <= force.attrs["minimum_n"] < 1 < force.attrs["maximum_n"] <= loads[-1]
    plain = marched(VIBRATING, [*WITHOUT_DYNAMICS, "rolling.distance_mm=0.1"])
    assert not {"force_law", "contact_force", "moving_release"} & set(plain.to_xarray().children)


def test_long_scenes_large_seeds_and_empty_tables_are_kept(tmp_path: Path) -> None:
    """A description of 2 MB, a seed above 64 bits and a table without events are kept."""
    data = file.loads(SCENE).to_dict() | {"description": "ä" * 1_000_000}
    data["surface"]["seed"] = 10**30
    data["rolling"]["duration_s"] = 0.002
    scene = file.Scene.from_dict(data)
    run = run_of(scene)
    result = run.result
    result.event_pieces = {0: {name: column[:0] for name, column in (run.events or {}).items()}}
    short = make_run(RunFolder({}, scene, tmp_path), "run", result)
    write_run(short)
    again = read_result(tmp_path / "result.h5", scene)
    assert again.event_pieces[0]["node"].shape == (0, 2)
    assert len(short.to_xarray().attrs["scene"]) > 1_000_000
