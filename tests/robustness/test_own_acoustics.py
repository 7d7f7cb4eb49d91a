"""A foreign package `acoustics`, which the package index has, is named instead of failing later."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rolling import _own_acoustics

ROOT = Path(__file__).parents[2]
USE = "import rolling; rolling.read_scene('quickstart')"


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a folder that has a copy of `rolling`, as if installed there."""
    shutil.copytree(
        ROOT / "rolling", folder / "rolling", ignore=shutil.ignore_patterns("__pycache__")
    )
    return subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | {"PYTHONPATH": str(folder)},
        cwd=folder,
        capture_output=True,
        text=True,
    )


def foreign(folder: Path) -> str:
    package = folder / "acoustics"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('imported')\n")
    return f"{package / '__init__.py'} belongs to another project"


def uninstalled(folder: Path) -> str:
    """Leave the folder that remains when a foreign package is removed: ours, less the files that
    both had.
    """
    shutil.copytree(ROOT / "acoustics", folder / "acoustics")
    (folder / "acoustics" / "__init__.py").unlink()
    return f"{folder / 'acoustics'} is incomplete"


def missing(folder: Path) -> str:
    return "acoustics is missing"


@pytest.mark.parametrize("state", [foreign, uninstalled, missing])
def test_another_acoustics_ends_the_command_in_one_line(state, tmp_path: Path) -> None:
    named = state(tmp_path)
    # without site-packages, where ours may be installed; Python's own library is enough to get here
    done = run(tmp_path, "-S", "-m", "rolling", "run", "quickstart")
    assert done.returncode == 2 and not done.stdout
    assert done.stderr.count("\n") == 1 and named in done.stderr
    assert "environment of its own" in done.stderr


def test_another_acoustics_is_an_import_error_in_python(tmp_path: Path) -> None:
    named = foreign(tmp_path)
    done = run(tmp_path, "-c", USE)
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ImportError: the package acoustics") and named in last
    assert "RuntimeError" not in done.stderr  # it was not even imported


def test_our_own_acoustics_is_recognised() -> None:
    assert _own_acoustics.foreign_package() is None
