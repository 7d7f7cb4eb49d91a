"""`Runs.to_xarray()`: the numbers and series of a sweep by their swept keys."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scene_text import TINY

import rolling as rc
from rolling.scene.file import loads


def swept(text: str, folder: Path = Path()) -> rc.Runs:
    scene = loads(f"{TINY}sweep: {text}\n", folder=folder)
    return rc.simulate_sweep(scene, workers=1, progress=False)


@pytest.fixture(scope="module")
def runs() -> rc.Runs:
    return swept("{rolling.load_n: [0.01, 0.005], surface.seed: [1, 2, 3]}")


def test_two_keys_are_dimensions_in_the_order_of_the_scene(runs: rc.Runs) -> None:
    data = runs.to_xarray()
    assert dict(data["vibration_db"].sizes) == {"load_n": 2, "seed": 3}
    assert data["load_n"].values.tolist() == [0.01, 0.005]
    assert data["load_n"].attrs == {"long_name": "load", "key": "rolling.load_n", "units": "N"}
    for (load, seed), run in runs.items():
        single = data.sel(load_n=load, seed=seed)
        assert single["vibration_db"] == run.vibration.value
        assert single["vibration_uncertainty_db"] == run.vibration.uncertainty
        assert single["vibration_how"] == "estimated"
        assert single["vibration_verdict"] == run.vibration.verdict
        assert single["released_power_db"] == run.sound.levels.laeq_db
        assert single["released_power_how"] == "upper bound"
        assert single["released_power_verdict"] == "bound"
        assert single["contact_area_mean_m2"] == run.numbers.contact.area_mean_m2
        octaves = run.numbers.bands.released_power_a
        highest = single.sel(band=16000)
        assert highest["bands_released_power_a"] == octaves.by_name["16000"]
        spread = highest["bands_released_power_a_uncertainty"]
        assert spread == octaves.uncertainty_by_name["16000"]


def test_series_share_the_places_of_the_track(runs: rc.Runs) -> None:
    data = runs.to_xarray()
    run = runs[0.005, 2]
    single = data.sel(load_n=0.005, seed=2)
    np.testing.assert_array_equal(data["position"], run.position)
    np.testing.assert_array_equal(data["step"], run.distance)
    np.testing.assert_array_equal(single["time"], run.time)
    for name in ("release_power", "contact_area", "approach"):
        np.testing.assert_array_equal(single[name], run.series[name])


def test_every_variable_has_a_unit_and_survives_a_file(runs: rc.Runs, tmp_path: Path) -> None:
    data = runs.to_xarray()
    assert rc.__version__ in data.attrs["program"]
    for name, variable in data.variables.items():
        assert variable.attrs["long_name"], name
        is_text = variable.dtype == object
        assert is_text or name == "seed" or "units" in variable.attrs, name
    data.to_netcdf(tmp_path / "sweep.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as back:
        xr.testing.assert_equal(back, data)
    xr.testing.assert_identical(pickle.loads(pickle.dumps(runs)).to_xarray(), data)


def test_a_run_that_failed_is_nan() -> None:
    with pytest.raises(rc.SweepError) as error:
        swept("{rolling.load_n: [0.005, 1e4], surface.seed: [1, 2]}")
    data = error.value.runs.to_xarray()
    assert data["load_n"].values.tolist() == [0.005, 1e4]
    assert np.isnan(data["released_power_db"].sel(load_n=1e4)).all()
    assert np.isnan(data["release_power"].sel(load_n=1e4)).all()
    assert np.isfinite(data["released_power_db"].sel(load_n=0.005)).all()


def test_runs_with_places_of_their_own_are_padded() -> None:
    """The same time at twice the speed has twice the steps."""
    runs = swept("{rolling.speed_m_s: [0.1, 0.2]}")
    data = runs.to_xarray()
    slow = data.sel(speed_m_s=0.1)
    count = runs[0.1].result.steps
    assert data.sizes["step_number"] == 2 * count
    np.testing.assert_array_equal(slow["step"][:count], runs[0.1].distance)
    np.testing.assert_array_equal(slow["release_power"][:count], runs[0.1].release_power)
    assert np.isnan(slow["release_power"][count:]).all()


def test_materials_and_files_are_dimensions_of_text(tmp_path: Path) -> None:
    heights = np.random.default_rng(1).normal(0, 1e-8, (64, 64))
    np.save(tmp_path / "a.npy", heights)
    np.save(tmp_path / "b.npy", heights[::-1])
    text = TINY.partition("surface:")[0] + (
        "surface: {kind: file, path: a.npy, spacing_um: 2}\n"
        "rolling: {load_n: 0.005, speed_m_s: 0.1}\n"
        "sweep:\n  surface.path: [a.npy, b.npy]\n  plate.material: [glass, pmma]\n"
        "  sphere.material: [glass, steel-100cr6]\n"
    )
    scene = loads(text, folder=tmp_path)
    data = rc.simulate_sweep(scene, workers=1, progress=False).to_xarray()
    assert set(data["vibration_db"].dims) == {"path", "plate.material", "sphere.material"}
    chosen = data.sel({"path": "b.npy", "plate.material": "pmma", "sphere.material": "glass"})
    assert np.isfinite(chosen["released_power_db"])


def test_runs_that_are_of_no_sweep_are_refused(runs: rc.Runs) -> None:
    with pytest.raises(ValueError, match="there is none"):
        rc.Runs().to_xarray()
    alone = rc.simulate(loads(TINY), workers=1, progress=False)
    with pytest.raises(ValueError, match=r"run\.to_xarray"):
        rc.Runs({1: alone}).to_xarray()
    other = swept("{rolling.speed_m_s: [0.1]}")
    with pytest.raises(ValueError, match=r"sweeps rolling\.speed_m_s, allowed: rolling\.load_n"):
        rc.Runs({**runs, **other}).to_xarray()
