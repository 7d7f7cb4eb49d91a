"""Nothing foreign is lost when a folder with any contents is replaced."""

from __future__ import annotations

import os
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from made_folders import finish, run_in, tree

from rolling.folders import own_files, run_record
from rolling.folders.files import FolderError
from rolling.folders.run_record import RunRecord

OWN = [
    "run.json",
    "scene.yaml",
    "result.h5",
    "spectrum.svg",
    ".result.h5.partial",
    ".lock",
    "load_n=5",
]
NAMES = st.sampled_from(
    [*OWN, "run.json~", "Result.h5", "notes", "load_n=6", ".git", ".notes.partial", "variants", "ü"]
)
LEAVES = st.sampled_from(["mine", "", "link"])
TREES = st.recursive(LEAVES, lambda inner: st.dictionaries(NAMES, inner, max_size=4), max_leaves=8)


def plant(folder: Path, contents: dict) -> None:
    for name, content in contents.items():
        path = folder / name
        if path.is_symlink() or path.is_file():
            path.unlink()
        if isinstance(content, dict):
            path.mkdir(exist_ok=True)
            plant(path, content)
        elif not path.is_dir():
            path.symlink_to("/etc") if content == "link" else path.write_text(content)


def foreign_by_oracle(folder: Path, names: frozenset[str], runs: tuple[str, ...]) -> set[str]:
    """Return the paths that may not vanish, by an independent rule.

    A path is foreign unless it is a regular file of a known name in its place.
    """
    kept = set()
    for top, folders, files in os.walk(folder):
        inside = Path(top).relative_to(folder).parts
        for name in [*folders, *files]:
            path = Path(top) / name
            base = name[1:-8] if name.startswith(".") and name.endswith(".partial") else name
            if not inside:
                known = base in names or name in runs
            else:
                known = (
                    len(inside) == 1
                    and inside[0] in runs
                    and base in own_files.FILES["run"] | {".lock"}
                )
            is_folder_of_a_run = (
                path.is_dir() and not path.is_symlink() and len(inside) == 0 and name in runs
            )
            if path.is_symlink() or not known or (path.is_dir() and not is_folder_of_a_run):
                kept.add(path.relative_to(folder).as_posix())
    return kept


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    contents=st.dictionaries(NAMES, TREES, max_size=4),
    runs=st.sampled_from([(), ("load_n=5",)]),
    state=st.sampled_from(["done", "failed"]),
)
def test_forced_over_any_contents_nothing_foreign_is_ever_lost(
    tmp_path: Path, contents: dict, runs: tuple[str, ...], state: str
) -> None:
    import shutil

    top = tmp_path / "top"
    shutil.rmtree(top, ignore_errors=True)
    out = run_in(top / "out", state=state, kind="sweep" if runs else "run", runs=runs)
    if not runs or "result.h5" not in contents:
        plant(out, contents)
    before = tree(out)
    names = own_files.FILES["sweep" if runs else "run"] | {".lock"}
    foreign = foreign_by_oracle(out, names, runs)
    try:
        finish(out)
    except FolderError:
        assert tree(out) == before
    else:
        assert not foreign
        assert [path.name for path in top.iterdir()] == ["out"]
    record: RunRecord | None
    try:
        record = run_record.read(out)
    except FolderError:
        record = None
    if foreign:
        assert tree(out) == before and (record is None or record.state != "running")
