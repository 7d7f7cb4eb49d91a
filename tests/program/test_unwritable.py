"""Run folders that cannot be written: one line names folder and cause, and other runs go on."""

from __future__ import annotations

import errno
import json
import os
import pickle
from pathlib import Path

import pytest
from scene_text import TINY

from rolling import cli
from rolling.check import demand
from rolling.commands import work
from rolling.folders import files, run_record
from rolling.folders.files import Unwritable
from rolling.report import page

SWEEP = TINY + "sweep: {surface.seed: [1, 2, 3]}\n"


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])
    path = tmp_path / "tiny.yaml"
    path.write_text(SWEEP)
    return path


def many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the runs of the sweep be many, so that each is a task."""
    monkeypatch.setattr(demand, "PAGE_RUNS", 2)
    monkeypatch.setattr(page, "MOST_RUNS", 2)


def break_writing(monkeypatch: pytest.MonkeyPatch, code: int, folder: str, name: str) -> None:
    """Let files of this name fail in folders of this name as the system fails."""
    inner = Path.open

    def broken(path: Path, mode: str = "r", *more: object, **named: object) -> object:
        if "w" in mode and path.parent.name == folder and path.name.startswith(f".{name}"):
            raise OSError(code, os.strerror(code), str(path))
        return inner(path, mode, *more, **named)  # type: ignore[call-overload]

    monkeypatch.setattr(Path, "open", broken)


def run(scene: Path, out: Path, *more: str) -> int:
    return cli.main(["run", str(scene), "--out", str(out), "--workers", "1", "-q", *more])


def summaries(out: Path) -> list[str]:
    return sorted(path.parent.name for path in out.glob("*/summary.json"))


@pytest.mark.parametrize("name", ["run.json", "result.h5", "signal.wav"])
@pytest.mark.parametrize("are_many", [True, False])
def test_a_run_that_cannot_be_written_fails_alone(
    are_many: bool,
    name: str,
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if are_many:
        many(monkeypatch)
    out = tmp_path / "out"
    made = work.solve  # the folders are made before

    with monkeypatch.context() as patch:

        def solve(*arguments: object) -> object:
            break_writing(patch, errno.EACCES, "seed=2", name)
            return made(*arguments)  # type: ignore[arg-type]

        patch.setattr("rolling.commands.solve", solve)
        assert run(scene, out) == 1
    lines = capsys.readouterr().err.splitlines()
    failed = [line for line in lines if "seed=2" in line]
    assert failed == [f"failed: seed 2: {out / 'seed=2'}: cannot be written (Permission denied)"]
    assert summaries(out) == ["seed=1", "seed=3"]
    rows = json.loads((out / "sweep.json").read_text())
    assert [row["summary"] is not None for row in rows] == [True, False, True]
    record = run_record.read(out)
    assert record is not None and record.state == "failed"
    assert record.reason is not None and "cannot be written" in record.reason
    assert cli.main(["resume", str(out), "--workers", "1", "-q"]) == 0
    assert summaries(out) == ["seed=1", "seed=2", "seed=3"]


def test_a_part_goes_on_beside_a_run_that_cannot_be_written(
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    many(monkeypatch)
    out = tmp_path / "out"
    assert run(scene, out, "--part", "2/2") == 0
    (out / "seed=1").rmdir()
    (out / "seed=1").write_text("no folder")
    assert run(scene, out, "--part", "1/2") == 1
    said = capsys.readouterr().err
    assert f"failed: seed 1: {out / 'seed=1'}: cannot be written (Not a directory)" in said
    assert summaries(out) == ["seed=2", "seed=3"]


@pytest.mark.parametrize("are_many", [True, False])
def test_a_full_disk_stops_a_sweep_with_one_line_and_the_way_on(
    are_many: bool,
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if are_many:
        many(monkeypatch)
    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        break_writing(patch, errno.ENOSPC, "seed=2", "result.h5")
        assert run(scene, out) == 1
    cause, *_, way_on = capsys.readouterr().err.strip().splitlines()
    assert cause == f"{out / 'seed=2'}: cannot be written (No space left on device)"
    assert way_on.endswith(f"`rolling resume {out}` continues when the cause is removed")
    assert cli.main(["resume", str(out), "--workers", "1", "-q"]) == 0
    assert summaries(out) == ["seed=1", "seed=2", "seed=3"]


def test_a_run_alone_names_its_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = tmp_path / "tiny.yaml", tmp_path / "out"
    path.write_text(TINY)
    with monkeypatch.context() as patch:
        break_writing(patch, errno.EACCES, "out", "result.h5")
        assert run(path, out, "--no-pictures") == 1
    cause, way_on = capsys.readouterr().err.strip().splitlines()
    assert cause == f"{out}: cannot be written (Permission denied)"
    assert way_on.startswith("nothing was solved; `rolling resume")


def test_the_error_of_a_folder_passes_between_processes(tmp_path: Path) -> None:
    error = pickle.loads(pickle.dumps(Unwritable("here: cannot be written", True)))
    assert str(error) == "here: cannot be written" and error.everywhere
    with pytest.raises(ConnectionError, match=r"^gone$"), files.writing(tmp_path):
        raise ConnectionError("gone")
    with pytest.raises(FileNotFoundError), files.writing(tmp_path / "run"):
        (tmp_path / "heights.npy").read_bytes()
