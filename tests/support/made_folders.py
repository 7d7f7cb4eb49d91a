"""Folders of runs, made and finished without a solver, for the tests of new folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rolling.folders import claim, new_folder, run_record
from rolling.folders.run_record import Kind

KINDS: tuple[Kind, ...] = ("run", "sweep")


def fill(folder: Path) -> None:
    (folder / "scene.yaml").write_text("name: new\n")
    (folder / "resolved.yaml").write_text("name: new\n")


def begin(out: Path, force: bool = True, inputs: Sequence[Path] = ()) -> claim.Claim:
    return new_folder.make(
        new_folder.aim(out, out, force, KINDS, inputs), run_record.new("run"), fill
    )


def finish(out: Path, force: bool = True) -> None:
    with begin(out, force) as held:
        (out / "result.h5").write_text("new")
        held.mark(out, "done")
        new_folder.drop_previous(held)


def run_in(
    folder: Path,
    content: str = "old",
    state: str = "done",
    kind: Kind = "run",
    runs: Sequence[str] = (),
) -> Path:
    """Make a folder of a run with some files, in a state."""
    folder.mkdir(parents=True)
    run_record.write(folder, run_record.new(kind, runs).with_state(state))  # type: ignore[arg-type]
    for name in ("scene.yaml", "resolved.yaml", "spectrum.svg", *([] if runs else ["result.h5"])):
        (folder / name).write_text(content)
    for name in runs:
        run_in(folder / name, content, state)
    return folder


def tree(folder: Path) -> dict[str, str]:
    """Return the content below a folder by path."""
    return {
        path.relative_to(folder).as_posix(): f"-> {path.readlink()}"
        if path.is_symlink()
        else (path.read_bytes().decode("utf-8", "replace") if path.is_file() else "folder")
        for path in sorted(folder.rglob("*"))
        if path.name != claim.LOCK
    }


def state(folder: Path) -> str:
    record = run_record.read(folder)
    return record.state if record else "none"
