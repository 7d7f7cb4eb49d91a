"""result.h5 is read as it was written or is refused; a full disk costs nothing."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr
from old_results import save_old

from rolling import cli, commands
from rolling.commands import work
from rolling.folders import run_record
from rolling.folders.files import FolderError
from rolling.simulation import _hdf5_probe, batch, result_file, simulate
from rolling.simulation.result import Result

SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 200, seed: 3}
rolling: {load_n: 0.3, speed_m_s: [[0, 0.1], [0.004, 0.2]], duration_s: 0.006}
recovery: {events: true}
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a finished run folder of three pieces, with events and a changing speed."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "s.yaml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert (
            cli.main(
                ["run", str(folder / "s.yaml"), "--out", str(folder / "out"), "--workers", "1"]
            )
            == 0
        )
    return folder / "out"


@pytest.fixture
def path(whole: Path, tmp_path: Path) -> Path:
    shutil.copy(whole / "resolved.yaml", tmp_path)
    return Path(shutil.copy(whole / "result.h5", tmp_path))


def part(whole: Path) -> Result:
    """Return the first and third piece, as an interrupted run on two workers leaves them."""
    one = commands.read_runs(whole)[0]
    result = Result.empty(one.scene.track, one.scene.start)
    for first, last in simulate.pieces(result.solved_steps)[::2]:
        result.add(simulate.simulate_piece(one.scene, first, last))
    result.identity = simulate.identity_of(one.scene)
    return result


@pytest.fixture(scope="module")
def partial(whole: Path) -> Result:
    return part(whole)


def same(a: Any, b: Any) -> bool:
    """Tell whether two values are equal to the last bit, NaN included, at any depth."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    return bool(a == b)


def refusal(path: Path) -> str:
    with pytest.raises(FolderError) as error:
        result_file.load(path)
    message = str(error.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message


# ---- what is written is what is read


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


# ---- damage


def test_no_changed_byte_is_accepted(path: Path, monkeypatch) -> None:
    """The digest refuses flips, runs of zeros, truncations, insertions and additions.

    The HDF5 library never sees such a file.
    """
    monkeypatch.setattr(result_file, "_probed", lambda path: "the probe was reached")
    monkeypatch.setattr(
        result_file, "_read", lambda path, source: pytest.fail("the damaged file was opened")
    )
    good, rng = path.read_bytes(), np.random.default_rng(0)
    for k in range(400):
        # the digest's own bytes, too
        at = int(rng.integers(len(good))) if k % 4 else len(good) - 1 - k // 4
        bad = bytearray(good)
        kind = k % 7
        if kind < 4:
            bad[at] ^= 1 << int(rng.integers(8))
        elif kind == 4:
            bad = bad[:at]
        elif kind == 5:
            bad[at:at] = bytes(1)
        else:
            bad += bytes(rng.integers(0, 256, 1 + k % 3, dtype=np.uint8))
        path.write_bytes(bad)
        assert "damaged" in refusal(path) and "the probe was reached" in refusal(path)


def test_damaged_bytes_are_refused_by_the_command_with_one_message(path: Path, capsys) -> None:
    """The true probe refuses a few damaged files, and the message names the remedy."""
    run_record.write(path.parent, run_record.new("run"))
    good = path.read_bytes()
    for at in (9, 700, len(good) // 2, len(good) - 40):
        bad = bytearray(good)
        bad[at] ^= 4
        path.write_bytes(bad)
        assert cli.main(["resume", str(path.parent)]) == 2
        message = capsys.readouterr().err
        assert (
            "result.h5: " in message and "Traceback" not in message and message.count("\n") == 1
        ), message
    path.write_bytes(good[: len(good) // 2])
    assert cli.main(["resume", str(path.parent)]) == 2
    assert "delete the file, and `rolling resume` solves it again" in capsys.readouterr().err
    path.unlink()
    path.mkdir()
    assert "no such file" in refusal(path)


def test_a_file_that_another_program_changed_is_refused(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["release_energy"][7] *= 2
    assert "events: their energy is" in refusal(path)  # the field that shows it
    with h5py.File(path, "r+") as file:
        file["release_energy"][7] /= 2
    assert "not the ones that were written" in refusal(path)


@pytest.mark.slow
def test_damaged_old_files_never_crash_and_never_hang(whole: Path, tmp_path: Path) -> None:
    """A file without a digest may pass with a flipped value, but ends in no traceback."""
    path = tmp_path / "result.h5"
    save_old(path, result_file.load(whole / "result.h5"), True)
    good, rng = path.read_bytes(), np.random.default_rng(1)
    for k in range(12):
        bad = bytearray(good)
        if k % 4 == 3:
            bad = bad[: int(rng.integers(len(good)))]
        else:  # the structure lies in the first and the last kilobytes
            for at in (
                rng.integers(0, 4000, 8) if k % 2 else len(good) - 1 - rng.integers(0, 30000, 30)
            ):
                bad[int(at)] ^= 1 << int(rng.integers(8))
        path.write_bytes(bad)
        try:
            result_file.load(path)
        except FolderError as error:
            assert str(error).startswith(str(path))


@pytest.mark.parametrize(
    ("program", "message"),
    [
        ("import os; os.kill(os.getpid(), 11)", "crashes the HDF5 library"),
        ("while True: pass", "does not come to an end"),
        ("bytearray(1 << 36)", "MemoryError"),
    ],
)
def test_a_probe_that_dies_is_a_refusal(
    program: str, message: str, tmp_path: Path, monkeypatch
) -> None:
    (tmp_path / "probe.py").write_text(program)
    (tmp_path / "result.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(500))
    monkeypatch.setattr(_hdf5_probe, "__file__", str(tmp_path / "probe.py"))
    monkeypatch.setattr(_hdf5_probe, "SECONDS", 0.5)
    assert message in refusal(tmp_path / "result.h5")


Spoil = Callable[[h5py.File], object]


def put(name: str, index: Any, value: float) -> Spoil:
    def spoil(file: h5py.File) -> None:
        data = file[name]
        values = data[()]
        values[index] = value
        attributes = dict(data.attrs)
        del file[name]
        file[name] = values
        file[name].attrs.update({k: v for k, v in attributes.items() if k == "units"})

    return spoil


def shaped(name: str, change: Callable[[np.ndarray], Any]) -> Spoil:
    def spoil(file: h5py.File) -> None:
        values = file[name][()]
        del file[name]
        file[name] = change(values)

    return spoil


def attribute(name: str, value: Any, group: str = "/") -> Spoil:
    return lambda file: file[group].attrs.__setitem__(name, value)


def without(name: str) -> Spoil:
    return lambda file: file.__delitem__(name)


HAND_MADE: list[tuple[str, Spoil]] = [
    ("steps", attribute("steps", 0)),
    ("steps", attribute("steps", -1)),
    ("steps", attribute("steps", 10**12)),
    ("steps", attribute("steps", "many")),
    ("steps", attribute("steps", np.array([450, 450]))),
    ("steps", lambda file: file.attrs.__delitem__("steps")),
    ("solved_steps", attribute("solved_steps", 10**8)),
    ("solved_steps", attribute("solved_steps", 2.5)),
    ("step_m", attribute("step_m", 0.0)),
    ("step_m", attribute("step_m", np.nan)),
    ("step_m", attribute("step_m", "2 um")),
    ("start_m", attribute("start_m", np.inf)),
    ("complete", attribute("complete", False)),
    ("complete", attribute("complete", "yes")),
    ("release_energy", without("release_energy")),
    ("release_energy", shaped("release_energy", lambda values: values[:-1])),
    ("release_energy", shaped("release_energy", lambda values: values.reshape(2, -1))),
    ("release_energy", shaped("release_energy", lambda values: values.astype("S8"))),
    ("release_energy", shaped("release_energy", lambda values: 1.0)),
    ("release_energy", put("release_energy", 3, -1e-9)),
    ("release_energy", put("release_energy", 3, np.inf)),
    ("loading_energy", put("release_energy", 3, np.nan)),
    ("step_time", put("step_time", 0, np.nan)),
    ("energy_defect", put("energy_defect", 0, np.inf)),
    ("approach", put("approach", 5, np.nan)),
    ("approach", shaped("approach", lambda values: np.append(values, 1.0))),
    ("contact_area", put("contact_area", 5, -1.0)),
    ("stored_energy", put("stored_energy", 0, -1.0)),
    ("max_deflection", put("max_deflection", 5, -1.0)),
    ("iterations", put("iterations", 5, 2.5)),
    ("iterations", lambda file: (without("iterations")(file), file.create_group("iterations"))),
    (
        "residual",
        lambda file: (
            without("residual")(file),
            file.__setitem__("residual", h5py.SoftLink("/approach")),
        ),
    ),
    ("snapshot/pressure", put("snapshot/pressure", (0, 0), np.nan)),
    ("snapshot/pressure", shaped("snapshot/pressure", lambda values: values.ravel())),
    ("snapshot/deflection", shaped("snapshot/deflection", lambda values: values[1:])),
    ("snapshot/along_m", attribute("along_m", "here", "snapshot")),
    ("snapshot", lambda file: (without("snapshot")(file), file.__setitem__("snapshot", 1.0))),
    ("pressure_maps/position", put("pressure_maps/position", 3, 10**9)),
    ("pressure_maps/position", put("pressure_maps/position", 3, 0)),
    ("pressure_maps/cell", put("pressure_maps/cell", 3, 0.0)),
    ("pressure_maps/distance", put("pressure_maps/distance", 3, 1.0)),
    ("pressure_maps/along", shaped("pressure_maps/along", lambda values: values[1:])),
    ("pressure_maps/pressure", put("pressure_maps/pressure", (3,), -1.0)),
    ("events/energy", put("events/energy", 0, -1.0)),
    ("events/peak", put("events/peak", 0, 1.0)),
    ("events/last", put("events/last", 0, -5)),
    ("events/first", put("events/last", 0, 10**6)),
    ("events/node", shaped("events/node", lambda values: values[:, 0])),
    ("events/first", without("events/first")),
    ("events", lambda file: shorter(file["events"])),
]


def shorter(group: h5py.Group) -> None:
    for name in ("node", "first", "last", "energy", "peak"):
        shaped(f"{group.name}/{name}", lambda values: values[len(values) // 2 :])(group.file)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("field", "spoil"), HAND_MADE, ids=[f"{k}-{field}" for k, (field, _) in enumerate(HAND_MADE)]
)
def test_hand_made_damage_is_refused_by_its_field(
    field: str, spoil: Spoil, path: Path, monkeypatch
) -> None:
    """A file of this version and an old one without a digest are refused by the damaged field."""
    # half a second each; the library reads all of these
    monkeypatch.setattr(result_file, "_probed", lambda path: None)
    old = path.with_name("old.h5")
    save_old(old, result_file.load(path), True)
    for each in (path, old):
        with h5py.File(each, "r+") as file:
            spoil(file)
        assert f": {field}: " in refusal(each)


@pytest.mark.parametrize(
    ("field", "spoil"),
    [
        ("format", attribute("format", 3)),
        ("format", attribute("format", "two")),
        ("physics", attribute("physics", "{")),
        ("physics", attribute("physics", "[]")),
        ("physics_sha256", attribute("physics_sha256", "0")),
        ("physics_defaults", lambda file: file.attrs.__delitem__("physics_defaults")),
        ("heights_sha256", attribute("heights_sha256", 5)),
        ("pressure_maps/rows", put("pressure_maps/rows", 3, 10**6)),
        ("pressure_maps/pressure", put("pressure_maps/pressure", (3, 0, 0), np.nan)),
        ("max_deflection", without("max_deflection")),
        ("events", without("events")),
    ],
)
def test_hand_made_damage_of_this_format_is_refused(
    field: str, spoil: Spoil, path: Path, monkeypatch
) -> None:
    monkeypatch.setattr(result_file, "_probed", lambda path: None)
    with h5py.File(path, "r+") as file:
        spoil(file)
    assert f": {field}" in refusal(path)


def test_a_result_of_the_future_is_not_read_as_one_of_today(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = 3
    assert "format 3, this version of the program reads up to 2" in refusal(path)


# ---- older files


@pytest.mark.parametrize("deflection", [False, True])
def test_old_files_are_read_and_gone_on_with(
    deflection: bool, whole: Path, partial: Result, tmp_path: Path
) -> None:
    for given in (result_file.load(whole / "result.h5"), partial):
        save_old(tmp_path / "result.h5", given, deflection)
        result = result_file.load(tmp_path / "result.h5")
        assert result.identity is None
        expected = given.series | (
            {} if deflection else {"max_deflection": np.full(given.steps + 1, np.nan)}
        )
        assert same(result, replace(given, identity=None, trial=None, series=expected))
    # The missing piece, then the file of today.
    shutil.copy(whole / "resolved.yaml", tmp_path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        shutil.copy(whole / "scene.yaml", tmp_path)
        assert cli.main(["resume", str(tmp_path), "--workers", "1"]) == 0
    result, once = result_file.load(tmp_path / "result.h5"), result_file.load(whole / "result.h5")
    assert result.complete and result.identity == once.identity
    for name in ("release_energy", "approach", "iterations"):
        assert np.array_equal(result.series[name], once.series[name])
    assert np.isnan(result.series["max_deflection"]).any() != deflection


def test_an_old_file_of_another_length_is_refused(
    whole: Path, partial: Result, tmp_path: Path, capsys
) -> None:
    save_old(tmp_path / "result.h5", partial, True)
    text = (whole / "resolved.yaml").read_text()
    (tmp_path / "resolved.yaml").write_text(text.replace("duration_s: 0.006", "duration_s: 0.004"))
    assert cli.main(["resume", str(tmp_path)]) == 2
    assert f"has {partial.steps} steps, the scene asks for" in capsys.readouterr().err


# ---- a full disk, size and time

COMMAND = """\
import sys, resource
from rolling import cli
from rolling.commands import work
from rolling.folders import files as run_folder
work.write_pictures = lambda *_: []
run_folder.Keeper.due = lambda self: True
LIMIT
sys.exit(cli.main(sys.argv[1:]))
"""


FREE = "from rolling.check import machine; machine.free_disk = lambda folder: 1e12"


def limited(arguments: list[str], limit: str = "") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", COMMAND.replace("LIMIT", limit), *arguments, "--workers", "1"]
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


@pytest.mark.slow
def test_a_file_that_may_not_grow_ends_in_one_message(whole: Path, tmp_path: Path) -> None:
    """A limit on the size of result.h5 ends in exit code 1 and keeps earlier work whole."""
    size = (whole / "result.h5").stat().st_size
    limit = f"resource.setrlimit(resource.RLIMIT_FSIZE, ({size // 2}, {size // 2}))"
    done = limited(["run", str(whole.parent / "s.yaml"), "--out", str(tmp_path / "out")], limit)
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("could not be written") == 1 and "resume" in done.stderr
    assert "Traceback" not in done.stderr and "HDF5" not in done.stderr
    # The limit is below the size of any part, so nothing is there, and nothing half written.
    assert not (tmp_path / "out" / "result.h5").exists()
    assert not list((tmp_path / "out").glob(".*partial"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(work, "write_pictures", lambda *_: [])
        assert cli.main(["resume", str(tmp_path / "out"), "--workers", "1"]) == 0
    assert np.array_equal(
        result_file.load(tmp_path / "out" / "result.h5").series["approach"],
        result_file.load(whole / "result.h5").series["approach"],
    )


@pytest.mark.slow
def test_a_full_disk_ends_in_one_message(whole: Path, tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    size = (whole / "result.h5").stat().st_size
    mounted = ["mount", "-t", "tmpfs", "-o", f"size={int(1.2 * size)}", "tmpfs", str(disk)]
    if (
        os.getuid()
        or shutil.which("mount") is None
        or subprocess.run(mounted, capture_output=True).returncode
    ):
        pytest.skip("no file system may be mounted here; the limit on files covers it")
    try:
        # Somebody else fills the disk after the run has begun: it was free when the run asked.
        done = limited(["run", str(whole.parent / "s.yaml"), "--out", str(disk / "out")], FREE)
        assert done.returncode == 1, done.stderr
        assert done.stderr.count("No space left on device") == 1 and "Traceback" not in done.stderr
        assert result_file.load(disk / "out" / "result.h5").done_steps >= 0
        assert not list((disk / "out").glob(".*partial"))
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def test_a_long_run_is_kept_in_bounded_time_memory_and_space(whole: Path, tmp_path: Path) -> None:
    """2500 pieces of events in 500,000 steps do not slow the writing.

    With a group for each piece it took minutes.
    """
    steps, each = 500_000, 8
    scene = commands.read_runs(whole)[0].scene.to_dict()
    scene["rolling"] |= {"speed_m_s": 0.1, "duration_s": steps * 2e-5}
    one = batch.Run({}, type(commands.read_runs(whole)[0].scene).from_dict(scene), tmp_path)
    result = Result.empty(one.scene.track, 0.0)
    rng = np.random.default_rng(0)
    for name, values in result.series.items():
        values[: len(values) - 200] = (
            1e-9 if name == "release_energy" else np.floor(rng.uniform(1, 9, len(values) - 200))
        )
    peak = np.full(each, 200e-9 / each)
    for first, last in simulate.pieces(steps)[:-1]:
        first_column = np.full(each, first)
        result.event_pieces[first] = {
            "node": np.zeros((each, 2), np.int32),
            "first": first_column,
            "last": np.full(each, last),
            "energy": peak,
            "peak": peak,
        }
    assert len(result.event_pieces) == 2499
    resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    batch.keep(one, result)
    written = time.process_time() - began
    assert written < 5  # 1 s measured; the Keeper writes for a twentieth of the time at most
    size = (tmp_path / "result.h5").stat().st_size
    values = 19 * 8 * steps  # of the series, without coordinates
    assert size < 1.1 * values
    assert 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident) < 5 * size
    assert same(result_file.load(tmp_path / "result.h5"), result)
