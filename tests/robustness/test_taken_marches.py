"""`rolling run --from`: equal marches are taken, damaged and strange ones are left and named."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hostile_npz import rewritten, strange
from scene_text import TINY
from test_bearing_marches import contacts_of, marched_pieces, small_plan

from rolling import cli
from rolling.archive.sealed_file import seal
from rolling.bearing_kind.bearing_forecast import different_marches
from rolling.bearing_kind.contact_marches import march_contacts, march_of_contact
from rolling.bearing_kind.contact_plan import ContactPlan, contact_plan
from rolling.kinds.reading import read_scene
from rolling.marches.piece import Piece, contact_identity
from rolling.results import result_file
from rolling.results.stored_numbers import read_stored
from rolling.run import folder as folders
from rolling.run import march_files
from rolling.run.march_files import Marches, take_march
from rolling.run.taken import TakenMarches
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.scene import Scene
from rolling.terminal import progress
from rolling.terminal.whole_files import FolderError

__all__ = ["marched_pieces"]  # a fixture
LOADS = TINY + "sweep: {rolling.load_n: [1, 2]}\n"


def command(scene: Path, out: Path, source: Path) -> list[str]:
    """Return the words of a run that takes marches, and says so."""
    words = ["run", str(scene), "--out", str(out), "--from", str(source)]
    return [*words, "--no-report", "--workers", "1"]


# ---- spheres


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with runs at two loads, which no test changes."""
    folder = tmp_path_factory.mktemp("swept")
    scene = folder / "scene.yaml"
    scene.write_text(LOADS)
    out = folder / "out"
    assert (
        cli.main(["run", str(scene), "--out", str(out), "--no-report", "--workers", "1", "-q"]) == 0
    )
    return out


@pytest.fixture
def loads(tmp_path: Path) -> Path:
    """A scene at a load that is marched elsewhere, and at one that is not, heard farther away."""
    scene = tmp_path / "loads.yaml"
    text = LOADS.replace("[1, 2]", "[2, 3]") + "sound: {distance_m: 2}\n"
    scene.write_text(text)
    return scene


def test_a_sphere_takes_the_marches_of_another_folder(
    swept: Path,
    loads: Path,
    tmp_path: Path,
    marched_pieces: list[Piece],
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "out"
    assert cli.main(command(loads, out, swept)) == 0
    assert {piece.scene.load for piece in marched_pieces} == {3.0}
    said = " ".join(capsys.readouterr().err.split())
    assert f"{swept}: 1 march is taken: load 2 N" in said
    assert f"{swept}: 1 march is not taken: load 3 N: no finished march there has an equal" in said
    runs = {run.scene.load: run.folder for run in folders.stored_runs(out)}
    costs = {load: read_stored(folder).numbers.effort.march_cpu_s for load, folder in runs.items()}
    assert costs[2.0] == 0 < costs[3.0]
    own = result_file.read_result(runs[2.0] / "result.h5", read_of(out, 2.0))
    theirs = result_file.read_result(folder_of(swept, 2.0) / "result.h5", read_of(swept, 2.0))
    assert np.array_equal(own.series["approach"], theirs.series["approach"])


def read_of(folder: Path, load: float) -> Scene:
    """Return the scene of a run of a folder by its load [N]."""
    return next(run.scene for run in folders.stored_runs(folder) if run.scene.load == load)


def folder_of(folder: Path, load: float) -> Path:
    """Return the folder of a run by its load [N]."""
    return next(run.folder for run in folders.stored_runs(folder) if run.scene.load == load)


def test_a_damaged_result_is_not_taken(
    swept: Path,
    loads: Path,
    tmp_path: Path,
    marched_pieces: list[Piece],
    capsys: pytest.CaptureFixture[str],
) -> None:
    damaged = tmp_path / "damaged"
    shutil.copytree(swept, damaged)
    path = folder_of(damaged, 2.0) / "result.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0x10
    path.write_bytes(content)
    assert cli.main(command(loads, tmp_path / "out", damaged)) == 0
    assert {piece.scene.load for piece in marched_pieces} == {2.0, 3.0}
    said = " ".join(capsys.readouterr().err.split())
    assert "1 march is not taken: load 2 N" in said and "its SHA-256 does not hold" in said


@pytest.mark.parametrize("kind", ["nothing", "files", "bearing"])
def test_a_folder_without_marches_to_take_is_refused_before_anything_is_written(
    kind: str, loads: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = tmp_path / "source"
    if kind != "nothing":
        source.mkdir()
        (source / "scene.yaml").write_text("name: mine\n")
    if kind == "bearing":
        folders.write_scene(source, read_scene("bearing-6204"))
    assert cli.main(command(loads, tmp_path / "out", source)) == 2
    said = capsys.readouterr().err
    assert str(source) in " ".join(said.split())
    assert ("runs of a bearing" if kind == "bearing" else "no run folder") in said
    assert not (tmp_path / "out").exists()


def test_a_bearing_refuses_the_folder_of_a_sphere(
    swept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = command(Path("bearing-waviness"), tmp_path / "out", swept)
    assert cli.main(words) == 2
    assert "a bearing takes the marches of the run folder of a" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


# ---- bearings


@pytest.fixture(scope="module")
def plan() -> ContactPlan:
    """The contacts of a bearing with one rough raceway."""
    return small_plan(balls=None)


@pytest.fixture(scope="module")
def healthy(plan: ContactPlan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the marches of a bearing, as its run leaves them, which no test changes."""
    source = tmp_path_factory.mktemp("healthy")
    march_contacts(contacts_of(plan), name="a", folder=source, workers=1, shown=False)
    (source / "scene.yaml").write_text(f"{folders.MARK}, written by {folders.this_program()}\n")
    return source


@pytest.fixture
def marched(healthy: Path, tmp_path: Path) -> Path:
    """A copy of the folder that a test may change."""
    return Path(shutil.copytree(healthy, tmp_path / "healthy"))


def taken(plan: ContactPlan, folder: Path, source: Path) -> Marches:
    """Return the marches of a bearing that takes those of another folder."""
    note = TakenMarches(source)
    contacts = contacts_of(plan)
    for contact in plan.stages[2]:
        take_march(note, march_of_contact(contact))
    with progress.begin(progress.Level.NORMAL):
        for line in note.lines():
            progress.line(line)
        return march_contacts(
            contacts, name="b", folder=folder, workers=1, shown=False, homes=[source]
        )


def test_a_bearing_takes_the_marches_of_its_healthy_sister(
    plan: ContactPlan,
    marched: Path,
    tmp_path: Path,
    marched_pieces: list[Piece],
    capsys: pytest.CaptureFixture[str],
) -> None:
    faulty = small_plan()  # its balls are rough as well
    marches = taken(faulty, tmp_path / "faulty", marched)
    names = {piece.scene.name for piece in marched_pieces}
    assert names == {"balls-on-inner", "balls-on-outer"}
    said = " ".join(capsys.readouterr().err.split())
    assert f"{marched}: 3 marches are taken: inner at" in said
    assert "6 marches are not taken" in said and "has an equal contact" in said
    for contact in plan.stages[2]:
        identity = contact_identity(contact)
        march = marches[identity]
        assert march.effort.march_s == 0
        theirs = march_files.read_march(marched, contact, identity)
        assert np.array_equal(march.approach_m, theirs.approach_m)
        path = march_files.march_path(tmp_path / "faulty", identity)
        assert path.is_file() and path.with_suffix(".yaml").is_file()


def resealed(change: Callable[[bytes], bytes]) -> Callable[[Path], object]:
    """Return a change of the file of a march, whose digest holds again."""

    def change_file(path: Path) -> None:
        content = change(path.read_bytes())
        path.write_bytes(content + seal(content))

    return change_file


def with_flipped_bit(content: bytes) -> bytes:
    return content[:300] + bytes([content[300] ^ 1]) + content[301:]


STRANGE: dict[str, Callable[[Path], object]] = {
    **{name: resealed(change) for name, change in strange("approach_m").items()},
    "a flipped bit": lambda path: path.write_bytes(with_flipped_bit(path.read_bytes())),
    "another identity": resealed(
        lambda content: rewritten(content, {"identity": np.array("0" * 64)})
    ),
    "no numbers": resealed(
        lambda content: rewritten(content, {"numbers": np.array([np.nan, 1.0])})
    ),
    "endless": lambda path: (path.unlink(), path.symlink_to("/dev/zero")),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
}


@pytest.mark.parametrize("damage", STRANGE)
def test_a_strange_march_is_not_taken(damage: str, plan: ContactPlan, marched: Path) -> None:
    scene = plan.stages[2][0]
    identity = contact_identity(scene)
    path = march_files.march_path(marched, identity)
    STRANGE[damage](path)
    with pytest.raises(FolderError, match=str(path)):
        march_files.read_march(marched, scene, identity)


def test_a_strange_march_is_marched_anew(
    plan: ContactPlan,
    marched: Path,
    tmp_path: Path,
    marched_pieces: list[Piece],
    capsys: pytest.CaptureFixture[str],
) -> None:
    strange = plan.stages[2][0]
    STRANGE["another identity"](march_files.march_path(marched, contact_identity(strange)))
    marches = taken(plan, tmp_path / "own", marched)
    assert len(marches) == 3
    assert {piece.scene.load for piece in marched_pieces} == {strange.load}
    said = " ".join(capsys.readouterr().err.split())
    assert "2 marches are taken" in said and "the march of another contact" in said


def test_a_pit_changes_no_rough_contact() -> None:
    """A bearing with a fault may take all marches of the same bearing without it."""
    rough = {"roughness_ra_um": 0.02, "correlation_length_um": 60, "kind": "gaussian", "seed": 2}
    pit = {"kind": "pit", "at_mm": [20, 0], "size_um": 300, "depth_um": 5}
    marches = []
    for faults in ({}, {"faults": [pit]}):
        surfaces = {"inner": rough | faults}
        scene = BearingScene.from_dict(
            {
                "name": "ring",
                "bearing": {
                    "named": "6204",
                    "speed_rpm": 1800,
                    "axial_load_n": 70,
                    "surfaces": surfaces,
                },
            }
        )
        marches.append(different_marches([contact_plan(scene)]).keys())
    healthy, faulty = marches
    assert healthy and healthy < faulty
