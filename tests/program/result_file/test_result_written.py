"""What is written into result.h5 is what is read, by this program and by others."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from stored_results import same

from rolling import cli, commands
from rolling.commands import work
from rolling.simulation import batch, result_file, simulate
from rolling.simulation.result import Result


def test_all_of_a_result_comes_back_to_the_last_bit(
    whole: Path, partial: Result, tmp_path: Path
) -> None:
    result = result_file.load(whole / "result.h5")
    assert result.complete and not partial.complete and len(partial.event_pieces) == 2
    assert len({one.pressure.shape for one in result.maps.values()}) > 1  # ragged
    one = commands.read_runs(whole)[0]
    for given in (result, partial):
        batch.keep(replace(one, folder=tmp_path), given)
        assert same(result_file.load(tmp_path / "result.h5"), given)


def test_events_of_a_partial_run_join_to_those_of_the_whole(
    whole: Path, partial: Result, tmp_path: Path
) -> None:
    one = commands.read_runs(whole)[0]
    batch.keep(replace(one, folder=tmp_path), partial)
    result = result_file.load(tmp_path / "result.h5")
    first, last = simulate.pieces(result.solved_steps)[1]
    result.add(simulate.simulate_piece(one.scene, first, last))
    assert same(result.events(), result_file.load(whole / "result.h5").events())
    assert list(result.event_pieces) == [0]


def test_every_dataset_has_a_checksum_units_and_named_dimensions(
    whole: Path, partial: Result, tmp_path: Path
) -> None:
    batch.keep(replace(commands.read_runs(whole)[0], folder=tmp_path), partial)
    for file_path in (whole / "result.h5", tmp_path / "result.h5"):
        names = []

        def look(name: str, thing: h5py.Group | h5py.Dataset) -> None:
            if isinstance(thing, h5py.Dataset):
                names.append(name)  # noqa: B023
                assert thing.fletcher32, name
                if b"not a netCDF variable" not in thing.attrs.get("NAME", b""):
                    assert thing.attrs["units"], name
                assert thing.is_scale or all(
                    len(dimension.keys()) == 1 for dimension in thing.dims
                ), name

        with h5py.File(file_path) as file:
            file.visititems(look)
        assert len(names) > 30


def test_xarray_opens_the_tree(whole: Path) -> None:
    result = result_file.load(whole / "result.h5")
    with xr.open_datatree(whole / "result.h5", engine="h5netcdf") as tree:
        assert set(tree.children) == {"snapshot", "pressure_maps", "events", "sound"}
        names = [set(map(str, node.to_dataset(inherit=False).dims)) for node in tree.subtree]
        assert sum(map(len, names)) == len(set.union(*names))  # no dimension twice
        release = tree["release_power"]
        assert set(release.coords) == {"step", "time"} and release.attrs["units"] == "W"
        assert set(tree["approach"].coords) == {"position", "position_time"}
        scene = commands.read_runs(whole)[0].scene
        assert np.allclose(
            scene.motion.distance(release["time"].values),
            release["step"].values,
            rtol=1e-12,
            atol=0,
        )
        ends = scene.motion.distance(tree["position_time"].values)
        assert np.allclose(ends, tree["position"].values, rtol=1e-12, atol=1e-18)
        assert np.allclose(release, tree["release_per_metre"] * tree["speed"], rtol=1e-12, atol=0)
        assert np.allclose(
            tree["speed"], scene.motion.speed(release["time"].values), rtol=1e-12, atol=0
        )
        maps = tree["pressure_maps"]
        for k, one in enumerate(result.maps.values()):
            rows, columns = int(maps["rows"][k]), int(maps["columns"][k])
            block = maps["pressure"][k].values
            assert np.array_equal(block[:rows, :columns], one.pressure)
            assert np.isnan(block[rows:]).all() and np.isnan(block[:, columns:]).all()
        pressure = tree["sound/pressure"]
        assert np.allclose(
            np.diff(pressure["sound_time"]), 1 / tree["sound"].attrs["sample_rate_hz"]
        )
        attributes = tree.attrs
        assert attributes["format"] == 2 and attributes["seed"] == 3 and attributes["load_n"] == 0.3
        assert (
            attributes["program"] and attributes["scene"] == (whole / "resolved.yaml").read_text()
        )
    with xr.open_dataset(whole / "result.h5") as data:  # the engine is found by itself
        assert data["release_power"].sizes == {"step": result.steps}


def test_the_sound_in_the_file_is_the_run_s(whole: Path, tmp_path: Path) -> None:
    """After run and resound the mean square of the sound is the level in summary.json."""
    out = tmp_path / "far"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert (
            cli.main(["resound", str(whole), "--set", "sound.distance_m=10", "--out", str(out)])
            == 0
        )
    for folder in (whole, out):
        with h5py.File(folder / "result.h5") as file:
            pressure = file["sound/pressure"][:]
        level = json.loads((folder / "summary.json").read_text())["level_db"]
        assert 20 * np.log10(np.sqrt(np.mean(pressure**2)) / 20e-6) == pytest.approx(
            level, abs=1e-6
        )


def test_empty_tables_and_long_scenes_are_kept(
    partial: Result, whole: Path, tmp_path: Path
) -> None:
    """A piece without events, a seed above 64 bits and a very long scene are kept."""
    one = commands.read_runs(whole)[0]
    data = one.scene.to_dict() | {"description": "ä" * 1_000_000}
    data["surface"]["seed"] = 10**30
    long = type(one.scene).from_dict(data)
    empty = replace(partial, identity=simulate.identity_of(long), event_pieces={})
    empty.series = {name: np.full_like(values, np.nan) for name, values in partial.series.items()}
    empty.series |= {name: values * 0 for name, values in partial.series.items()}
    empty.event_pieces = {
        first: {c: v[:0] for c, v in t.items()} for first, t in partial.event_pieces.items()
    }
    batch.keep(batch.Run({}, long, tmp_path), empty)
    assert same(result_file.load(tmp_path / "result.h5"), empty)
    with h5py.File(tmp_path / "result.h5") as file:
        assert len(file.attrs["scene"]) > 1_000_000 and file.attrs["seed"] == str(10**30)
