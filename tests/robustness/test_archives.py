"""Files of archives: what is written comes back, and a stranger's file is judged before a value.

The laws hold for every definition: a made one, that of the runs of balls, and that of bearings.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from bearing_runs import WAVY, loads_bearing
from finished import run_of
from hostile_hdf5 import (
    LINE,
    Spoil,
    inflated,
    linked_outside,
    put,
    seal,
    spoil,
    stored_outside,
    unwritten,
    virtual,
    with_long_text,
)
from hostile_npz import strange, twice
from scene_text import TINY
from stored_arrays import stored_arrays

import rolling
from rolling.archive.archive_file import archive_bytes, read_archive
from rolling.archive.definition import (
    LETTERS,
    ROOT,
    TEXT,
    Archive,
    ArchiveDefinition,
    ArchiveGroup,
    GroupDefinition,
    Variable,
    by_name,
)
from rolling.archive.hdf5_writer import to_xarray
from rolling.archive.npz_file import npz_bytes, read_npz
from rolling.bearing_kind import stored_run
from rolling.results import result_file
from rolling.scene.file import loads
from rolling.terminal.whole_files import FolderError

MADE = ArchiveDefinition(
    name="a made archive",
    format=7,
    kind="made",
    groups={
        ROOT: GroupDefinition(
            (
                Variable("time", "time", "s", "f8", "time"),
                Variable("phase", "time", "1", "f8", "part of a turn", is_auxiliary=True),
                Variable("axis", "axis", "1", LETTERS, "directions"),
                Variable("velocity", "time axis", "m/s", "f4", "velocity"),
                Variable("count", "time", "1", "u4", "how often"),
            ),
            {"identity": str, "title": str, "gain": float, "turns": int},
        ),
        "film": GroupDefinition(
            (Variable("energy", "shot cell", "J", "u1", "energy", scale_factor="unit"),),
            {"unit": float},
        ),
    },
)
FORMER = ArchiveDefinition(
    name="a made archive",
    format=6,
    kind="made",
    groups={ROOT: GroupDefinition((Variable("speed", "time", "m/s", "f4", "velocity"),))},
)
LENGTH = 4000


def made_archive() -> Archive:
    """Return an archive of the made definition."""
    time = np.arange(LENGTH) / 48000
    arrays = {
        "time": time,
        "phase": time % 1e-3,
        "axis": np.array(["x", "y", "z"]),
        "velocity": np.random.default_rng(1).standard_normal((LENGTH, 3)),
        "count": np.arange(LENGTH, dtype=np.int64),
    }
    film = {"energy": np.arange(12, dtype=np.uint8).reshape(4, 3)}
    facts = {"identity": "own", "title": "ä" * 100, "gain": 2, "turns": 3}
    return {ROOT: ArchiveGroup(arrays, facts), "film": ArchiveGroup(film, {"unit": 0.5})}


def read_made(path: Path, definitions: tuple[ArchiveDefinition, ...] = (MADE, FORMER)) -> Archive:
    """Read an archive of the made definition."""
    lengths = {"time": LENGTH, "axis": 3}
    return read_archive(path, definitions, lengths=lengths, most_bytes=1_000_000, identity="own")


@dataclass(frozen=True)
class Case:
    """A file of a definition, its reader, and what the laws attack of it.

    content : bytes. The file.
    read : function. Reader, which raises FolderError.
    array : str. Name of an array of the root, which is stored in chunks.
    """

    content: bytes
    read: Callable[[Path], Any]
    array: str


@pytest.fixture(scope="module")
def cases() -> dict[str, Case]:
    """Return a case of each definition."""
    ball = loads(TINY.replace("0.0005", "0.03"))
    bearing = rolling.simulate(loads_bearing(WAVY.replace("0.5", "0.1")), progress=False)
    return {
        "made": Case(archive_bytes(MADE, made_archive()), read_made, "velocity"),
        "ball": Case(
            result_file.write_result(run_of(ball)),
            lambda path: result_file.read_result(path, ball),
            "approach",
        ),
        "bearing": Case(
            stored_run.result_bytes(bearing),
            lambda path: stored_run.read_result(path, bearing.scene),
            "velocity",
        ),
    }


@pytest.fixture(params=["made", "ball", "bearing"])
def case(cases: dict[str, Case], request: pytest.FixtureRequest) -> Case:
    """Return the case of one definition."""
    return cases[request.param]


@pytest.fixture
def path(case: Case, tmp_path: Path) -> Path:
    """Return the file of a case."""
    path = tmp_path / "result.h5"
    path.write_bytes(case.content)
    return path


# ---- what is written comes back


def test_all_of_an_archive_comes_back(tmp_path: Path) -> None:
    archive = made_archive()
    path = tmp_path / "archive.h5"
    path.write_bytes(archive_bytes(MADE, archive))
    again = read_made(path)
    for name, group in archive.items():
        assert again[name].attributes == group.attributes
        for variable in MADE.groups[name].variables:
            values = again[name].arrays[variable.name]
            wanted = group.arrays[variable.name]
            if variable.dtype != LETTERS:
                wanted = wanted.astype(variable.dtype)
            assert np.array_equal(values, wanted) and values.dtype == wanted.dtype
    assert isinstance(again[ROOT].attributes["gain"], float)  # as it is defined
    assert stored_arrays(archive_bytes(MADE, again)) == stored_arrays(path)


def test_xarray_has_dimensions_units_and_coordinates() -> None:
    archive = made_archive()
    tree = to_xarray(MADE, archive)
    velocity = tree["velocity"]
    assert velocity.dims == ("time", "axis") and velocity.attrs["units"] == "m/s"
    assert {*velocity.coords} == {"time", "axis", "phase"}
    assert velocity.sel(axis="y").shape == (LENGTH,)
    energy = tree["film/energy"]  # in joules, though stored as whole numbers
    assert np.array_equal(energy, 0.5 * archive["film"].arrays["energy"])
    assert tree.attrs["format"] == 7 and tree.attrs["kind"] == "made"


@pytest.mark.parametrize("name", ["array", "attribute", "group"])
def test_what_is_not_defined_is_not_written(name: str) -> None:
    archive = dict(made_archive())
    root = archive[ROOT]
    if name == "array":
        archive[ROOT] = ArchiveGroup(root.arrays | {"stranger": np.zeros(3)}, root.attributes)
    elif name == "attribute":
        archive[ROOT] = ArchiveGroup(root.arrays, {**root.attributes, "stranger": 1})
    else:
        archive["stranger"] = ArchiveGroup({})
    with pytest.raises(KeyError, match="stranger"):
        archive_bytes(MADE, archive)


def test_a_former_format_is_read_and_another_one_named(tmp_path: Path) -> None:
    path = tmp_path / "archive.h5"
    former = {ROOT: ArchiveGroup({"speed": np.zeros(LENGTH)})}
    path.write_bytes(archive_bytes(FORMER, former))
    spoil(path, lambda file: file.attrs.__setitem__("identity", "own"))
    assert {*read_made(path)[ROOT].arrays} == {"speed"}
    with pytest.raises(FolderError, match=r"format 6, .* this version reads format 7"):
        read_made(path, (MADE,))


def test_a_file_of_another_kind_is_refused(cases: dict[str, Case], tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    for name, case in cases.items():
        path.write_bytes(case.content)
        for other in cases.keys() - {name}:
            with pytest.raises(FolderError, match="its kind is"):
                cases[other].read(path)


# ---- a stranger's file


def refusal(path: Path, case: Case) -> str:
    """Return the sentence that refuses a file; it begins with its path."""
    with pytest.raises(FolderError) as error:
        case.read(path)
    message = str(error.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message


def peak_bytes() -> int:
    """Return the most memory that this process has had."""
    resource = pytest.importorskip("resource")
    return int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) * 1024


def test_no_changed_byte_is_accepted(
    path: Path, case: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The digest refuses flips, truncations, insertions and additions.

    The HDF5 library, which such files could crash, never sees them.
    """
    monkeypatch.setattr(h5py, "File", lambda *_: pytest.fail("the damaged file was opened"))
    for bad in damaged(case.content):
        path.write_bytes(bad)
        assert "damaged" in refusal(path, case)


def damaged(good: bytes) -> Iterator[bytes]:
    """Yield contents that are damaged in various places, the line of the digest too."""
    rng = np.random.default_rng(0)
    for k in range(100):
        at = int(rng.integers(len(good))) if k % 4 else len(good) - 1 - k // 4
        bad = bytearray(good)
        if k % 6 < 3:
            bad[at] ^= 1 << int(rng.integers(8))
        elif k % 6 == 3:
            bad = bad[:at]
        elif k % 6 == 4:
            bad[at:at] = bytes(1)
        else:
            bad += bytes(rng.integers(0, 256, 1 + k % 3, dtype=np.uint8))
        yield bytes(bad)


def linked(name: str, link: h5py.SoftLink | h5py.ExternalLink) -> Spoil:
    """Put a link in place of an array."""

    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = link

    return change


def filtered(name: str, **options: Any) -> Spoil:
    """Store an array through other filters, or in chunks that decompress to far more than it."""

    def change(file: h5py.File) -> None:
        values = file[name][()]
        del file[name]
        file.create_dataset(name, data=values, **options)

    return change


def longer(name: str) -> Spoil:
    """Declare an array of terabytes along its first dimension, of which no chunk is written."""
    return lambda file: unwritten(name, (10**12, *file[name].shape[1:]))(file)


def references(name: str) -> Spoil:
    """Store references to other objects in place of numbers."""

    def change(file: h5py.File) -> None:
        shape = file[name].shape
        del file[name]
        file.create_dataset(name, shape, h5py.ref_dtype)

    return change


def hostile(name: str, outside: Path) -> dict[str, tuple[str, Spoil]]:
    """Return changes of a file by name, each with a word of its refusal; they attack an array."""
    return {
        "stored outside": ("another storage", stored_outside(name, outside)),
        "virtual": ("another storage", virtual(name, outside)),
        "linked outside": (name, linked_outside(name, outside)),
        "linked inside": (name, linked(name, h5py.SoftLink("/time"))),
        "terabytes": ("along", longer(name)),
        "unwritten": ("not all in the file", unwritten(name)),
        "inflated": ("another size", inflated(name, 200_000_000)),
        "texts": ("another storage", put(name, np.full(3, b"text"))),
        "references": ("another storage", references(name)),
        "another filter": ("another storage", filtered(name, compression="lzf")),
        "a stranger": ("stranger", put("stranger", np.zeros(3))),
        "a deep group": ("deep", lambda file: file.create_group("deep")),
        "a loop": ("loop", lambda file: file.__setitem__("loop/sound", file["/"])),
        "another format": ("format 99, ", lambda file: file.attrs.__setitem__("format", 99)),
        "texts for a fact": ("attribute", lambda file: file.attrs.__setitem__("kind", ["a"] * 9)),
    }


@pytest.mark.parametrize("name", hostile("", Path()))
def test_a_hostile_file_is_refused_by_its_declarations(
    name: str, path: Path, case: Case, tmp_path: Path
) -> None:
    """A digest is no signature: nothing is allocated that the scene or the file's size forbids."""
    outside = tmp_path / "secret"
    outside.write_bytes(b"secret!!" * 100_000)
    word, change = hostile(case.array, outside)[name]
    spoil(path, change)
    before = peak_bytes()
    assert word in refusal(path, case)
    assert peak_bytes() < before + 100e6


def test_an_untouched_file_with_a_new_digest_is_read(path: Path, case: Case) -> None:
    spoil(path, lambda file: None)
    assert case.read(path)


@pytest.mark.skipif(sys.platform != "linux", reason="no other system limits a process")
def test_a_text_that_states_four_gigabytes_is_not_made_room_for(path: Path) -> None:
    """Of an attribute that is read."""
    content = archive_bytes(MADE, made_archive())
    seal(path, with_long_text(content[: content.rindex(LINE)], 4_000_000_000))
    before = peak_bytes()
    with pytest.raises(FolderError, match="not a made archive"):
        read_made(path)
    assert peak_bytes() < before + 100e6


def test_a_file_behind_a_user_block_is_none_of_this_program(path: Path, case: Case) -> None:
    seal(path, bytes(512) + case.content[: case.content.rindex(LINE)])
    assert "no HDF5 file" in refusal(path, case)


def test_files_that_are_none_are_refused(path: Path, case: Case) -> None:
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(500))
    assert "version 0.1.0" in refusal(path, case)  # its files had no digest
    path.unlink()
    assert "not readable" in refusal(path, case)
    path.mkdir()
    assert "not readable" in refusal(path, case)


# ---- archives of pieces

VARIABLES = by_name(
    Variable("approach", "place", "m", "f8", "approach"),
    Variable("rows", "row", "1", "u4", "rows"),
    Variable("fault", "", "1", TEXT, "reason"),
)


def piece_archive(**changes: Any) -> bytes:
    """Return the archive of a piece of the variables with changes."""
    arrays = {"approach": np.arange(5.0), "rows": np.arange(3), "fault": np.array("too wide")}
    return npz_bytes(VARIABLES, arrays | changes)


def test_an_archive_of_a_piece_comes_back() -> None:
    again = read_npz(piece_archive() + b"\nbytes behind it\n", VARIABLES, {"place": 5})
    assert np.array_equal(again["approach"], np.arange(5.0))
    assert again["rows"].dtype == np.dtype("u4") and str(again["fault"]) == "too wide"
    assert again["approach"].flags.writeable
    assert piece_archive() == piece_archive()


@pytest.mark.parametrize("name", strange("approach"))
def test_a_strange_archive_of_a_piece_is_refused(name: str) -> None:
    content = strange("approach")[name](piece_archive())
    before = peak_bytes()
    with pytest.raises(Exception) as error:
        read_npz(content, VARIABLES, {"place": 5})
    assert not isinstance(error.value, MemoryError)
    assert peak_bytes() < before + 100e6


def test_an_archive_with_an_array_two_times_is_refused() -> None:
    with pytest.warns(UserWarning, match="Duplicate name"):
        content = twice(piece_archive(), "approach")
    with pytest.raises(ValueError, match="other arrays than defined"):
        read_npz(content, VARIABLES, {"place": 5})


def test_other_arrays_than_defined_are_not_written() -> None:
    with pytest.raises(ValueError, match="more"):
        piece_archive(more=np.zeros(3))
    with pytest.raises(ValueError, match="rows"):
        npz_bytes(VARIABLES, {"approach": np.zeros(3), "fault": np.array("")})
