"""With and without --force, foreign files and the last finished run are never lost."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest
from made_folders import KINDS, begin, finish, run_in, state, tree
from processes import Child

from rolling.folders import claim, new_folder, run_record
from rolling.folders.files import FolderError

# ---- what is refused


def refused(out: Path, words: str, force: bool = True, inputs: Sequence[Path] = ()) -> None:
    top = out.parent if out.parent.exists() else out
    before = tree(top)
    with pytest.raises(FolderError, match=words):
        begin(out, force, inputs)
    assert tree(top) == before


def test_only_marked_folders_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "proj").mkdir()
    (tmp_path / "proj" / "scene.yaml").write_text("name: mine\n")
    refused(tmp_path / "proj", "no run of this program; take another --out")
    (tmp_path / "proj" / "run.json").write_text("{}")
    refused(tmp_path / "proj", "not a run.json of this program")
    run_in(tmp_path / "study", kind="study")
    refused(tmp_path / "study", r"the folder of another command \(study\)")
    (tmp_path / "file").write_text("years of work")
    refused(tmp_path / "file", "is a file")
    for name in ("run", "old"):
        run_in(tmp_path / name)
    refused(tmp_path / "run", "holds a run already; take another --out, or --force", force=False)
    (tmp_path / "old" / "run.json").unlink()
    (tmp_path / "old" / "finished").write_text("2026\n")
    refused(tmp_path / "old", "version 0.1.0.*never replaced")
    with claim.take(tmp_path / "old", "run") as held:  # resumed: it has a run.json since
        held.mark(tmp_path / "old", "done")
    (tmp_path / "old" / "finished").unlink()
    refused(tmp_path / "old", "version 0.1.0 and never replaced")


def test_foreign_contents_are_named_and_kept(tmp_path: Path) -> None:
    out = run_in(tmp_path / "out", kind="sweep", runs=["load_n=5"])
    for path, text in (
        ("notes.txt", "mine"),
        ("load_n=5/thesis.tex", "mine"),
        ("load_n=7/result.h5", "mine"),
    ):
        (out / path).parent.mkdir(exist_ok=True)
        (out / path).write_text(text)
        refused(out, f"did not write {path.partition('/result')[0]} in it; move that away")
        (out / path).unlink()
        if not (out / path).parent.joinpath("run.json").exists():
            (out / path).parent.rmdir()
    (out / "link.svg").symlink_to(tmp_path)
    refused(out, "link.svg")
    (out / "link.svg").unlink()
    (out / "spectrum.svg").unlink()
    (out / "spectrum.svg").symlink_to("/etc/hostname")
    refused(out, "spectrum.svg")
    (out / "spectrum.svg").unlink()
    (out / "spectrum.svg").mkdir()
    refused(out, "spectrum.svg")
    (out / "spectrum.svg").rmdir()
    run_in(out / "mine")  # another run, put there by hand
    refused(out, "did not write mine")
    (out / "mine").rename(tmp_path / "mine")
    (out / ".sweep.json.partial").write_text("of a killed write")  # ours
    finish(out)


def test_inputs_and_the_working_directory_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = run_in(tmp_path / "out", kind="sweep", runs=["load_n=5"])
    words = "which this command reads, lies in it"
    refused(out, words, inputs=[tmp_path / "elsewhere.yaml", out / "scene.yaml"])
    refused(out, words, inputs=[out])
    (tmp_path / "link").symlink_to(out)
    refused(out, words, inputs=[tmp_path / "link" / "load_n=5"])
    refused(tmp_path / "link", "a symbolic link, which is not replaced; give --out the folder")
    monkeypatch.chdir(out / "load_n=5")
    for path in (out, Path(), Path(".."), Path("../../out"), Path("/")):
        with pytest.raises(FolderError, match="the working directory"):
            begin(path)
    monkeypatch.chdir(tmp_path)
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    refused(Path(), "is the working directory", force=False)
    monkeypatch.chdir(tmp_path)
    # OUT.previous is removed in the end: no input may lie in it.
    old = run_in(tmp_path / "out.previous")
    refused(out, words, inputs=[old])
    monkeypatch.chdir(old)
    refused(out, "working directory")


def test_a_run_of_a_sweep_is_not_replaced_alone(tmp_path: Path) -> None:
    out = run_in(tmp_path / "out", kind="sweep", runs=["load_n=5"])
    refused(out / "load_n=5", "a run of the sweep in .*, which would hold two scenes")


def test_folders_in_use_are_refused(tmp_path: Path) -> None:
    out = run_in(tmp_path / "out", kind="sweep", runs=["load_n=5"], state="waiting")
    old = run_in(tmp_path / "out.previous")
    for used in (out, out / "load_n=5", old):

        def work(child: Child, used: Path = used) -> None:
            with claim.take(used, "run"):
                child.say("taken")
                child.hear()

        child = Child(work)
        child.hear()
        refused(out, f"in use by process {child.pid} ")
        child.kill()
    finish(out)


@pytest.mark.parametrize("what", ["file", "link", "folder", "marked and more", "another command"])
def test_the_name_out_previous_is_not_taken_from_others(tmp_path: Path, what: str) -> None:
    out, old = run_in(tmp_path / "out"), tmp_path / "out.previous"
    if what == "file":
        old.write_text("mine")
    elif what == "link":
        old.symlink_to(tmp_path)
    elif what == "folder":
        old.mkdir()
    else:
        run_in(old, kind="study" if what == "another command" else "run")
        (old / "more.txt").write_text("mine")
    refused(out, "out.previous: ")


def test_a_parent_that_cannot_be_written_gives_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = run_in(tmp_path / "out")

    def denied(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", denied)
    refused(out, r"cannot be made \(Permission denied\)")
    refused(tmp_path / "new", r"cannot be made \(Permission denied\)")


def test_what_cannot_be_made_gives_one_message(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    for out in (tmp_path / "file" / "out", tmp_path / ("x" * 300), tmp_path / "file" / "a" / "b"):
        with pytest.raises(FolderError, match="cannot be"):
            begin(out)
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    refused(tmp_path / "dangling", "a symbolic link to nothing")
    long = run_in(tmp_path / ("y" * 250))  # itself short enough, but not with .previous
    refused(long, "cannot be made|could not be replaced")


# ---- what is made


def test_empty_folders_are_filled_in_place(tmp_path: Path) -> None:
    """An empty folder, perhaps a mount point, stays the same folder, and a link stays a link."""
    out = tmp_path / "out"
    out.mkdir(mode=0o770)
    (out / ".run.json.partial").write_text("{")  # a command was killed before its first file
    number = out.stat().st_ino
    (tmp_path / "link").symlink_to(out)
    finish(tmp_path / "link", force=False)
    assert out.stat().st_ino == number and state(out) == "done" and (tmp_path / "link").is_symlink()


def test_the_old_run_stays_until_the_new_one_is_done(tmp_path: Path) -> None:
    out = run_in(tmp_path / "out", "old")
    with begin(out) as held:
        assert (tmp_path / "out.previous" / "result.h5").read_text() == "old"
        assert state(out) == "running" and not (out / "result.h5").exists()
        assert {path.name for path in tmp_path.iterdir()} == {"out", "out.previous"}
        held.mark(out, "done")
        assert new_folder.drop_previous(held) is None
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    record = run_record.read(out)
    assert record is not None and record.state == "done" and record.replaces is None


def test_the_last_run_that_is_done_outlives_any_number_of_failures(tmp_path: Path) -> None:
    out, old = run_in(tmp_path / "out", "good"), tmp_path / "out.previous"
    for _ in range(3):
        with pytest.raises(KeyboardInterrupt), begin(out):
            raise KeyboardInterrupt
        assert (
            state(out) == "waiting"
            and state(old) == "done"
            and (old / "result.h5").read_text() == "good"
        )
        assert {path.name for path in tmp_path.iterdir()} == {"out", "out.previous"}
    # Resumed to its end, by another process: the old one goes.
    with claim.take(out, "run") as held:
        held.mark(out, "done")
        new_folder.drop_previous(held)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_of_two_that_are_not_done_the_younger_is_kept(tmp_path: Path) -> None:
    out, old = (
        run_in(tmp_path / "out", "second", "failed"),
        run_in(tmp_path / "out.previous", "first", "failed"),
    )
    begin(out).__exit__(None, None, None)
    assert (old / "result.h5").read_text() == "second"


def test_out_previous_of_somebody_else_is_not_removed(tmp_path: Path) -> None:
    """A foreign OUT.previous, made after the new run began, is kept.

    It is another run, or the right run with a file of the user in it.
    """
    out, old = run_in(tmp_path / "out"), tmp_path / "out.previous"
    with begin(out) as held:
        (old / "notes.txt").write_text("mine")
        held.mark(out, "done")
        assert new_folder.drop_previous(held) == old
    assert (old / "notes.txt").read_text() == "mine" and (old / "result.h5").read_text() == "old"
    old.rename(tmp_path / "elsewhere")
    run_in(old, "another")
    with claim.take(out, "run") as held:
        held.mark(out, "done")
        new_folder.drop_previous(held)
    assert (old / "result.h5").read_text() == "another"


def test_inputs_that_cannot_be_written_leave_everything_as_it_was(tmp_path: Path) -> None:
    run_in(tmp_path / "out")
    (tmp_path / "empty").mkdir()
    before = tree(tmp_path)

    def full(folder: Path) -> None:
        (folder / "scene.yaml").write_text("name: n")
        raise OSError(28, "No space left on device")

    for name in ("out", "empty", "new"):
        target = new_folder.aim(tmp_path, tmp_path / name, True, KINDS)
        with pytest.raises(OSError, match="No space"):
            new_folder.make(target, run_record.new("run"), full)
        assert tree(tmp_path) == before


def test_of_commands_that_begin_at_once_one_gets_the_folder(tmp_path: Path) -> None:
    """Of four processes one makes the folder and three are refused.

    The folder is new, empty or replaced; the run that was there stays beside it.
    """
    for k in range(12):
        out = tmp_path / f"out{k}"
        if k % 3 == 1:
            out.mkdir()
        elif k % 3 == 2:
            run_in(out, f"old {k}")

        def work(child: Child, out: Path = out) -> None:
            child.hear()
            try:
                begin(out, force=True)
                child.say("made")
                child.hear()
            except FolderError as error:
                child.say(f"refused: {error}")
                child.hear()

        children = [Child(work) for _ in range(4)]
        for child in children:
            child.say("go")
        answers = sorted(child.hear() for child in children)
        for child in children:
            child.kill()
        assert answers[0] == "made" and all(
            answer.startswith("refused") for answer in answers[1:]
        ), answers
        assert state(out) == "running" and (out / "resolved.yaml").read_text() == "name: new\n"
        if k % 3 == 2:
            assert (tmp_path / f"out{k}.previous" / "result.h5").read_text() == f"old {k}"


def test_a_run_that_was_done_counts_as_done_though_a_resume_of_it_was_killed(
    tmp_path: Path,
) -> None:
    """A killed resume without work does not make a finished run unfinished.

    Its state stays running, and two kills of --force would otherwise lose the run.
    """
    out, old = run_in(tmp_path / "out", "good"), tmp_path / "out.previous"

    def resume(child: Child) -> None:
        with claim.take(out, "run"):
            child.say("taken")
            child.hear()

    child = Child(resume)
    child.hear()
    child.kill()
    assert state(out) == "running"
    for _ in range(2):
        begin(out).__exit__(None, None, None)
        assert (old / "result.h5").read_text() == "good"


def test_a_removal_that_is_killed_is_in_nobodys_way(tmp_path: Path) -> None:
    out = run_in(tmp_path / "out")

    def work(_: Child) -> None:
        inner, calls = Path.unlink, []

        def unlink(path: Path, missing_ok: bool = False) -> None:
            calls.append(path)
            if len(calls) == 3:
                os._exit(9)
            inner(path, missing_ok)

        Path.unlink = unlink  # type: ignore[method-assign]
        finish(out)

    assert Child(work).wait() == 9
    # killed, or not, before it had a run.json
    for number, name in enumerate(("", ".run.json.partial", "notes.txt")):
        folder = tmp_path / f".out.{number:032}.partial"
        folder.mkdir()
        if name:
            (folder / name).write_text("mine")
        os.utime(folder, (0, 0))
    assert state(out) == "done" and not (tmp_path / "out.previous").exists()
    finish(out)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f".out.{2:032}.partial", "out"]
