"""A new folder is killed, or refused by the system, at every step: no good run is lost."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from made_folders import begin, finish, run_in, state, tree
from processes import Child

from rolling.folders.files import FolderError


class Killed(BaseException):
    """The stand-in for SIGKILL in a forked process."""


def interrupted_at(number: int, stop) -> object:
    """Return a rename that stops at its nth call."""
    inner, calls = Path.rename, []

    def rename(path: Path, name: Path) -> Path:
        calls.append(name)
        if len(calls) == number:
            stop()
        return inner(path, name)

    return rename


CASES = {  # OUT and OUT.previous before; the content that must not be lost
    "done": (("good", "done"), None),
    "both done": (("good", "done"), ("older", "done")),
    "failed, done before": (("bad", "failed"), ("good", "done")),
    "both failed": (("good", "failed"), ("bad", "failed")),
}


def prepared(folder: Path, case: str) -> Path:
    there, before = CASES[case]
    out = run_in(folder / "out", *there)
    if before:
        run_in(folder / "out.previous", *before)
    return out


def contents(folder: Path) -> list[str]:
    """Return the contents of all results below a folder, whatever its folders are called."""
    return sorted(path.read_text() for path in folder.rglob("result.h5"))


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("number", [1, 2, 3])
def test_killed_between_renames_the_good_run_is_there_and_the_next_command_goes_on(
    tmp_path: Path, case: str, number: int
) -> None:
    out = prepared(tmp_path, case)

    def work(_: Child) -> None:
        Path.rename = interrupted_at(number, lambda: os._exit(9))  # type: ignore[method-assign,assignment]
        begin(out)
        os._exit(0)

    code = Child(work).wait()
    assert "good" in contents(tmp_path)
    assert code == 9 or number == 3
    places = [path for path in tmp_path.iterdir() if not path.name.startswith(".")]
    assert any(
        (path / "result.h5").is_file() and (path / "result.h5").read_text() == "good"
        for path in places
    )
    finish(out)
    assert state(out) == "done" and (out / "result.h5").read_text() == "new"
    if code == 0 or case in ("done", "failed, done before"):
        assert [path.name for path in tmp_path.iterdir() if not path.name.startswith(".")] == [
            "out"
        ]
    finish(out)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]  # nothing is left behind for ever


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_rename_that_fails_leaves_everything_as_it_was(
    tmp_path: Path, case: str, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = prepared(tmp_path, case)
    before = tree(tmp_path)

    def fail() -> None:
        raise OSError(18, "Invalid cross-device link")

    monkeypatch.setattr(Path, "rename", interrupted_at(number, fail))
    try:
        begin(out).__exit__(None, None, None)
    except FolderError as error:
        assert "could not be replaced, and is as it was (Invalid cross-device link)" in str(error)
        assert tree(tmp_path) == before
    else:
        assert number == 3
