"""A result or a summary that is foreign or hostile ends in one sentence, before it is read."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import h5py
import numpy as np
import pytest
from finished import run_of
from hostile_hdf5 import Spoil, put, spoil
from scene_text import TINY

from rolling.kinds.run_folder import RunFolder
from rolling.results.result_file import read_result
from rolling.results.run_result import read_run, write_run
from rolling.scene.file import loads
from rolling.terminal.whole_files import FolderError

SCENE = loads(TINY, ["recovery.events=true"])


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = run_of(SCENE, tmp_path_factory.mktemp("damage"))
    write_run(run)
    return run.folder


@pytest.fixture
def path(written: Path, tmp_path: Path) -> Path:
    """Return a copy of the file."""
    copy = tmp_path / "result.h5"
    copy.write_bytes((written / "result.h5").read_bytes())
    return copy


def refusal(path: Path) -> str:
    """Return the sentence that refuses a file; it begins with its path."""
    with pytest.raises(FolderError) as error:
        read_result(path, SCENE)
    message = str(error.value)
    assert message.startswith(str(path)) and "\n" not in message
    return message


def declared(shapes: dict[str, tuple[int, ...]], kind: str = "f8") -> Spoil:
    """Declare arrays of which no chunk is written, so that the file stays small."""

    def change(file: h5py.File) -> None:
        for name, shape in shapes.items():
            if name in file:
                del file[name]
            chunks = tuple(min(count, 1000) for count in shape)
            file.create_dataset(name, shape, kind, chunks=chunks)

    return change


def filtered(options: dict[str, object]) -> Spoil:
    """Store an array through other filters, or in chunks that decompress to far more than it."""

    def change(file: h5py.File) -> None:
        values = file["approach"][()]
        del file["approach"]
        file.create_dataset("approach", data=values, **options)

    return change


def without(name: str) -> Spoil:
    return lambda file: file.__delitem__(name)


SOUND = ("pressure", "sound_time")
SNAPSHOT = ("pressure", "deflection")
HOSTILE: list[tuple[str, Spoil]] = [
    ("bytes, allowed for this scene", declared({f"sound/{name}": (10**12,) for name in SOUND})),
    (
        "bytes, allowed for this scene",
        lambda file: (
            declared({f"snapshot/{name}": (2**32, 2**32) for name in SNAPSHOT})(file),
            without("snapshot/along")(file),
            without("snapshot/across")(file),
        ),
    ),
    ("release_energy", put("release_energy", np.zeros(24))),
    ("release_energy", put("release_energy", np.zeros((5, 5)))),
    ("events/energy", put("events/energy", np.zeros(3))),
    ("events/node", put("events/node", np.zeros((3, 5), np.int32))),
    ("stranger", declared({"stranger": (10**12,)})),
    ("deep", lambda file: file.create_group("sound/deep")),
    ("sound/step", lambda file: file["sound"].__setitem__("step", file["/"])),
    ("another storage", filtered({"chunks": (10**6,), "maxshape": (None,), "compression": 9})),
    ("attribute", lambda file: file.attrs.__setitem__("title", ["text " * 1000] * 1000)),
    ("release_energy", without("release_energy")),
    ("not a result", without("snapshot/along")),
    ("distance_m", lambda file: file["snapshot"].attrs.__delitem__("distance_m")),
    ("another scene", lambda file: file.attrs.__delitem__("identity")),
    ("solved for another scene", lambda file: file.attrs.__setitem__("identity", "0" * 64)),
    ("format 2, which version 0.", lambda file: file.attrs.__setitem__("format", 2)),
]


@pytest.mark.parametrize(("word", "change"), HOSTILE)
def test_a_result_that_is_none_of_the_scene_is_refused(
    word: str, change: Spoil, path: Path
) -> None:
    """Beside what `test_archives.py` changes in archives of every definition."""
    spoil(path, change)
    assert word in refusal(path)


def test_the_result_of_another_scene_is_refused(path: Path) -> None:
    """Speed and listener do not matter to the contact, but load and surface do."""
    faster = SCENE.with_({"rolling.speed_m_s": 0.2, "rolling.duration_s": 0.00025})
    assert read_result(path, faster.with_({"sound.distance_m": 3})).is_complete
    for change in ({"rolling.load_n": 0.006}, {"surface.seed": 2}):
        with pytest.raises(FolderError, match="another scene or surface"):
            read_result(path, SCENE.with_(change))


FORMER = Path(__file__).parents[1] / "data/folders_0_8_0/ball/summary.json"
DOUBT = {"key": "slope", "text": "steep", "advice": "", "severity": "trust", "decibels": None}


@pytest.mark.parametrize(
    "content",
    [
        *(b"", b"[1]", b"{", b"{}", b"null", b"\xff", b'{"laeq_db": 1}', b"[" * 100_000),
        *({"laeq_db": value} for value in ("loud", [1], math.nan, 1e999, 10**400, {"a": "b"})),
        *({"doubts": value} for value in (None, {}, [1], [{"key": "k"}], [{"text": 1}])),
        *({"doubts": [DOUBT | change]} for change in ({"severity": "x"}, {"decibels": "loud"})),
        *(
            {key: 1}
            for key in ("surface", "uncertainty_db", "third_octave_db", "source", "levelling")
        ),
        *({"surface": {"ra": "rough"}}, {"uncertainty_db": {"laeq": []}}, {"steps": "many"}),
        *({"laeq_db": {"a": 1}}, {"preparation": [1]}, {"preparation": [{"step": 1}]}),
    ],
    ids=lambda content: str(content)[:20],
)
def test_a_damaged_summary_is_refused(content: bytes | dict[str, object], tmp_path: Path) -> None:
    """Of a folder of version 0.8, whose numbers are in its summary."""
    path = tmp_path / "summary.json"
    if isinstance(content, dict):
        content = json.dumps(json.loads(FORMER.read_bytes()) | content).encode()
    path.write_bytes(content)
    with pytest.raises(FolderError, match=r"summary\.json: not readable") as error:
        read_run(RunFolder({}, SCENE, tmp_path), "run")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["result.h5", "numbers.json"])
def test_a_file_of_sixty_gigabytes_is_refused_unread(
    name: str, written: Path, tmp_path: Path
) -> None:
    for other in ("result.h5", "numbers.json", "summary.json"):
        (tmp_path / other).write_bytes((written / other).read_bytes())
    os.truncate(tmp_path / name, 60 * 2**30)  # sparse
    with pytest.raises(FolderError, match=f"{name}.*is larger than"):
        read_run(RunFolder({}, SCENE, tmp_path), "run")
