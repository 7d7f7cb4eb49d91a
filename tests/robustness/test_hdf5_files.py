"""HDF5 files of strangers: no byte of another file, and no bomb, reaches a result or a scan."""

from __future__ import annotations

import ast
import io
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from bearing_runs import WAVY, loads_bearing
from hostile_hdf5 import (
    Spoil,
    inflated,
    instrument_file,
    linked_outside,
    put,
    seal,
    spoil,
    stored_outside,
    unwritten,
    virtual,
    with_long_text,
)

import rolling
from rolling.archive.definition import TEXT
from rolling.bearing_kind import stored_run
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.scene import hdf5_files, height_grid
from rolling.scene.height_format import HeightFormatError
from rolling.studies import accuracy
from rolling.terminal.whole_files import FolderError

ROOT = Path(__file__).parents[2]
DOORS = {
    "rolling/archive/hdf5_reader.py",
    "rolling/archive/hdf5_writer.py",
    "rolling/archive/mat_file.py",  # reads no HDF5, but scipy's reader could
    "rolling/scene/hdf5_files.py",
}
PACKAGES = {"h5py", "h5netcdf", "netCDF4", "tables", "pyfive"}
OPENERS = {
    *("open_dataset", "load_dataset", "open_dataarray", "load_dataarray", "open_datatree"),
    *("open_mfdataset", "open_groups", "open_zarr", "netcdf_file", "loadmat", "read_hdf"),
    "HDFStore",
}


def test_no_other_module_opens_a_file_of_hdf5() -> None:
    """Files of this program are judged in one place, and those of instruments in another."""
    doors = []
    for path in sorted([*ROOT.glob("rolling/**/*.py"), *ROOT.glob("acoustics/**/*.py")]):
        source = path.read_text(encoding="utf-8")
        if not any(name in source for name in (*PACKAGES, *OPENERS)):
            continue
        imported: list[str] = []
        called: list[str] = []
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Import):
                imported += [alias.name.split(".")[0] for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                imported.append((node.module or "").split(".")[0])
                called += [alias.name for alias in node.names]
            elif isinstance(node, ast.Attribute):
                called.append(node.attr)
        if PACKAGES & {*imported} or OPENERS & {*called}:
            doors.append(path.relative_to(ROOT).as_posix())
    assert {*doors} == DOORS


# ---- results of bearings


@pytest.fixture(scope="module")
def run() -> BearingRun:
    scene = loads_bearing(WAVY.replace("0.5", "0.1"))
    return rolling.simulate(scene, progress=False)


@pytest.fixture
def path(run: BearingRun, tmp_path: Path) -> Path:
    path = tmp_path / "result.h5"
    path.write_bytes(stored_run.result_bytes(run))
    return path


def peak_bytes() -> int:
    """Return the most memory that this process has had."""
    resource = pytest.importorskip("resource")
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024


def former(run: BearingRun) -> xr.Dataset:
    """Return a result as version 0.8.0 wrote it: without coordinates, loads as an array."""
    dataset = stored_run.result_dataset(run)
    loads = dataset["load"].values.astype("f4")
    bare = dataset.drop_vars([*dataset.coords]).assign_attrs(format=1)
    return bare.assign(track_loads=xr.Variable("load", loads, {"units": "N"}))


def same(record_and_tracks: tuple[object, ...], run: BearingRun) -> None:
    record, tracks = record_and_tracks
    assert record.rate_hz == run.record.rate_hz
    for name in ("velocity_m_s", "acceleration_m_s2", "ball_load_n"):
        wanted = getattr(run.record, name).astype("f4")
        np.testing.assert_array_equal(getattr(record, name), wanted)
    assert len(tracks.balls_on_outer) == run.scene.bearing.balls
    inner = run.tracks.inner.at_loads(tracks.inner.loads_n)
    np.testing.assert_allclose(tracks.inner.approach_m, inner, rtol=1e-6, atol=1e-15)


def test_a_result_and_one_of_version_0_8_0_are_read(path: Path, run: BearingRun) -> None:
    same(stored_run.read_result(path, run.scene), run)
    seal(path, bytes(former(run).to_netcdf(engine="h5netcdf")))
    same(stored_run.read_result(path, run.scene), run)


def test_dimensions_of_a_bearing_have_values_and_units(path: Path, run: BearingRun) -> None:
    """Any program that reads netCDF finds seconds, axes, newtons, and metres along the bodies."""
    with xr.open_dataset(path, engine="h5netcdf") as data:
        stored = data.load()
    assert stored["time"].attrs["units"] == "s"
    np.testing.assert_allclose(stored["time"], np.arange(4800) / 48000, rtol=1e-15)
    assert stored["axis"].values.tolist() == ["x", "y", "z"]
    assert stored["ball"].values.tolist() == [*range(8)]
    assert stored["load"].attrs["units"] == "N" and bool((stored["load"] > 0).all())
    turn = run.scene.circumferences["inner"]
    place = stored["inner_place"].values
    assert stored["inner_place"].attrs["units"] == "m"
    assert (
        place[-1] + place[1] == pytest.approx(turn) == pytest.approx(2 * np.pi * 0.01286, rel=0.01)
    )
    assert all("units" in variable.attrs for variable in stored.variables.values())
    assert run.to_xarray()["velocity"].sel(axis="x").shape == (4800,)


def both(*changes: Spoil) -> Spoil:
    def change(file: h5py.File) -> None:
        for one_change in changes:
            one_change(file)

    return change


HOSTILE: dict[str, tuple[str, Spoil]] = {
    "tracks": ("along ball_place", unwritten("balls_on_inner", (8, 4, 10**12))),
    "turn": (
        "bytes, allowed",
        both(unwritten("inner_place", (10**9,)), unwritten("inner_track", (4, 10**9))),
    ),
    "balls": ("along ball", unwritten("ball_load", (4800, 9))),
    "letters": ("single letters", put("axis", np.full((3, 2), b"x"))),
    "nan": ("no finite", put("velocity", np.full((4800, 3), np.nan, "f4"))),
    "fact": ("rate_hz", lambda file: file.attrs.__setitem__("rate_hz", 1e300)),
    "missing": ("outer_track", lambda file: file.__delitem__("outer_track")),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_result_of_another_bearing_is_refused(name: str, path: Path, run: BearingRun) -> None:
    """Beside what `test_archives.py` changes in archives of every definition."""
    word, change = HOSTILE[name]
    spoil(path, change)
    before = peak_bytes()
    with pytest.raises(FolderError, match=word) as error:
        stored_run.read_result(path, run.scene)
    assert str(error.value).startswith(str(path)) and "\n" not in str(error.value)
    assert peak_bytes() < before + 100e6


# ---- studies of accuracy


def study() -> xr.Dataset:
    """Return a study of two variants as it is stored, some settings once for all variants."""
    sizes = {"variant": 2, "band": len(accuracy.BANDS), "sample": 5}
    variables = {}
    for variable in accuracy._STUDY.variables:
        shape = [sizes[axis] for axis in variable.axes]
        values = np.arange(np.prod(shape), dtype=float).reshape(shape)
        if variable.dtype == TEXT:
            values = values.astype(str)
        variables[variable.name] = (variable.axes, values)
    variables["edges"] = ((), "sharp")
    attributes = {"identity": "own", "name": "small", "closed": 1, "length_m": 0.1}
    dataset = xr.Dataset(variables, attrs=attributes)
    return dataset.set_coords(["curve", "edges", "precision", "spacing_um", "step_um", "tolerance"])


@pytest.mark.parametrize(
    "name", ["external", "virtual", "linked", "longer", "inflated", "texts", "text"]
)
def test_a_hostile_study_of_accuracy_is_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / "accuracy.nc"
    outside = tmp_path / "secret"
    outside.write_bytes(b"secret!!" * 100)
    path.write_bytes(bytes(study().to_netcdf(engine="h5netcdf")))
    xr.testing.assert_identical(accuracy.read_study(path), study())
    changes = {
        "external": stored_outside("laeq_db", outside),
        "virtual": virtual("laeq_db", outside),
        "linked": linked_outside("laeq_db", outside),
        "longer": unwritten("intensity_w_m2", (2, 10**12)),
        "inflated": inflated("laeq_db", 200_000_000),
        "text": put("curve", np.array(["a", "b" * 100_000], dtype=h5py.string_dtype())),
        "texts": put("variant", np.array(["a", "b", "c"], dtype=h5py.string_dtype())),
    }
    with h5py.File(path, "r+") as file:
        changes[name](file)
    before = peak_bytes()
    with pytest.raises(ValueError):
        accuracy.read_study(path)
    assert peak_bytes() < before + 100e6
    with pytest.raises(FolderError, match="holds no study of accuracy"):
        accuracy._stored(tmp_path, "own")


# ---- files of instruments

HEIGHTS = np.round(1e3 * np.random.default_rng(5).standard_normal((24, 17))) * 1e-9


def test_a_scan_in_hdf5_is_read(tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography", reason="the extra `surfaces` is not installed")
    instrument_file(tmp_path / "scan.datx", HEIGHTS)
    read = height_grid.read(tmp_path / "scan.datx")
    np.testing.assert_allclose(read.heights, HEIGHTS, rtol=0, atol=1e-20)
    assert read.spacing_m == pytest.approx((2e-6, 3e-6))


@pytest.mark.parametrize("ending", [".datx", ".nc", ".dat"])
@pytest.mark.parametrize("name", ["external", "virtual", "linked", "large", "filter"])
def test_a_hostile_scan_is_refused_before_a_package_reads_it(
    name: str, ending: str, tmp_path: Path
) -> None:
    """A file counts by its content, and it may begin behind a user block."""
    path = tmp_path / f"scan{ending}"
    outside = tmp_path / "secret"
    outside.write_bytes(b"secret!!" * 1000)
    surface = "Data/Surface/{9}"
    instrument_file(path, HEIGHTS, outside if name == "external" else None)
    changes = {
        "external": lambda file: None,
        "virtual": virtual(surface, outside),
        "linked": linked_outside(surface, outside),
        "large": unwritten(surface, (10**6, 10**6)),
        "filter": lambda file: file.create_dataset("x", (9,), "f8", chunks=(9,), compression="lzf"),
    }
    with h5py.File(path, "r+") as file:
        changes[name](file)
    words = {
        **dict.fromkeys(("external", "virtual"), "from other files"),
        "linked": "leads to another file",
        "large": "states arrays of",
        "filter": "a filter that is not known",
    }
    with pytest.raises(HeightFormatError, match=words[name]):
        height_grid.read(path)
    path.write_bytes(bytes(1024) + path.read_bytes())
    if name != "linked":  # its places count from the user block
        assert hdf5_files.is_hdf5(path)


@pytest.mark.skipif(sys.platform != "linux", reason="no other system limits a process")
def test_a_scan_with_a_text_that_states_four_gigabytes_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography", reason="the extra `surfaces` is not installed")
    path = tmp_path / "scan.datx"
    instrument_file(path, HEIGHTS)
    path.write_bytes(with_long_text(path.read_bytes(), 4_000_000_000, place="Data"))
    before = peak_bytes()
    with pytest.raises(HeightFormatError, match="no readable"):
        height_grid.read(path)
    assert peak_bytes() < before + 300e6


def test_a_file_of_many_objects_and_a_circle_of_groups_end(tmp_path: Path) -> None:
    path = tmp_path / "scan.datx"
    with h5py.File(path, "w") as file:
        file["a/b/circle"] = file["/"]
    with hdf5_files.judged(path, 1000):
        pass
    with h5py.File(path, "w") as file:
        for number in range(101):
            group = file.create_group(f"{number}")
            group.attrs.update({f"{k}": k for k in range(99)})
    with (
        pytest.raises(ValueError, match="more than 10000 arrays and attributes"),
        hdf5_files.judged(path, 1000),
    ):
        pass
    assert io.BytesIO(path.read_bytes()).read(4) == b"\x89HDF"
