"""Slips in Python: copies, odd values, wrong names and damaged folders end in one plain message."""

from __future__ import annotations

import copy
import json
import pickle
import threading
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scene_text import TINY

import rolling as rc
from rolling.scene.file import loads


@pytest.fixture(scope="module")
def run() -> rc.Run:
    return rc.simulate(loads(TINY), workers=1, progress=False)


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))]
)
def test_copies_of_scenes_and_runs_equal_them(run: rc.Run, copied: Any) -> None:
    assert copied(run.scene) == run.scene
    assert run.series  # which is kept, and must not go into a copy
    again = copied(run)
    assert again.numbers == run.numbers and again.scene == run.scene
    np.testing.assert_array_equal(again.release_power, run.release_power)
    np.testing.assert_array_equal(again.sound.pressure, run.sound.pressure)


@pytest.mark.parametrize(
    "load", [np.float32(0.5), np.float64(0.5), np.array(0.5), xr.DataArray(0.5), 0.5]
)
def test_a_number_of_any_library_is_a_number(load: Any) -> None:
    assert loads(TINY).with_(load_n=load).rolling.load_n == 0.5


@pytest.mark.parametrize("seeds", [range(3), np.arange(3), xr.DataArray([0, 1, 2]), (0, 1, 2)])
def test_values_of_any_library_are_swept_under_a_bare_key(seeds: Any) -> None:
    scene = loads(TINY).with_(sweep={"seed": seeds})
    assert [run.values for run in scene.runs()] == [{"surface.seed": k} for k in range(3)]


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"lod_n": 5}, rc.SceneError, "nearest: rolling.load_n"),
        ({"lod_n": 5, "sed": 1}, rc.SceneError, "sed: unknown key"),
        ({5: 5}, rc.SceneError, "a key is a text"),
        (5, TypeError, "values by key"),
        ({"load_n": Fraction(1, 2)}, rc.SceneError, "greater than 0"),
        ({"sweep": {"lod_n": [1]}}, rc.SceneError, "nearest: rolling.load_n"),
    ],
)
def test_wrong_changes_are_named(changes: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        loads(TINY).with_(changes)


def test_a_scene_does_not_change_and_says_how_to_change_a_copy() -> None:
    scene = loads(TINY)
    with pytest.raises(AttributeError, match=r"with_\(load_n="):
        scene.rolling.load_n = 5  # type: ignore[misc]
    with pytest.raises(AttributeError, match="does not change"):
        scene.name = "other"  # type: ignore[misc]


@pytest.mark.parametrize("overrides", [{"rolling.load_n": 5}, [5]])
def test_overrides_are_texts(overrides: Any) -> None:
    with pytest.raises(TypeError, match=r"with_\(load_n=50\)"):
        rc.read_scene("quickstart", overrides)


def test_a_run_that_is_not_there_names_those_that_are(run: rc.Run) -> None:
    with pytest.raises(KeyError, match=r"the runs are 1\.0, 2\.0"):
        rc.Runs({1.0: run, 2.0: run})[3.0]


def test_a_file_is_no_folder(run: rc.Run, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("text")
    with pytest.raises(rc.FolderError, match="is a file"):
        run.save(tmp_path / "taken")


def test_workers_of_numpy_are_counted(run: rc.Run) -> None:
    again = rc.simulate(run.scene, workers=np.int64(1), progress=False)  # type: ignore[arg-type]
    assert again.numbers.of_record.laeq_db == run.numbers.of_record.laeq_db


def test_threads_simulate_at_the_same_time(capsys: pytest.CaptureFixture[str]) -> None:
    """Each thread has the numbers that it has alone, and silence ends with the last of them."""
    levels: dict[int, float] = {}

    def solve(seed: int) -> None:
        scene = loads(TINY).with_(seed=seed)
        levels[seed] = rc.simulate(scene, workers=1, progress=False).numbers.of_record.laeq_db

    threads = [threading.Thread(target=solve, args=(seed,)) for seed in (1, 2, 3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    together = dict(levels)
    for seed in (1, 2, 3):
        solve(seed)
    assert levels == together
    rc.simulate(loads(TINY), workers=1, progress=True)
    assert "100%" in capsys.readouterr().err


def test_a_damaged_file_of_numbers_is_refused_whatever_is_wrong_in_it(
    run: rc.Run, tmp_path: Path
) -> None:
    """Without a key, and with a list in its place, the run opens or is refused in words."""
    folder = run.save(tmp_path / "run", report=False)
    path = folder / "numbers.json"
    whole = json.loads(path.read_text())
    own = whole["numbers"]
    for key in own:
        for damaged in ({k: v for k, v in own.items() if k != key}, {**own, key: ["odd"]}):
            path.write_text(json.dumps({**whole, "numbers": damaged}))
            try:
                opened = rc.open_run(folder)
                assert repr(opened) and opened._repr_html_()
            except rc.FolderError as error:
                assert key in str(error)
