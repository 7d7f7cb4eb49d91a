"""Systems that lack what others have: a place for compiled code, and semaphores for workers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from commands import ROOT, contents, words_of
from loky.backend import get_context
from scene_text import TINY

from rolling import cli

COMPILE = """\
import os, numpy as np
from rolling.contact import _window_kernels, solver
z = np.ones((8, 8))
print(_window_kernels.node_work((z, z), (0, 0), (z, z / 2), False, 1.0, np.empty((8, 8))))
print(os.environ.get("NUMBA_CACHE_DIR"))
"""
SUMS = "(32.0, 0.0)"  # 64 nodes of pressure 1 fall by a half


@pytest.fixture
def sealed(tmp_path: Path) -> dict[str, str]:
    """Environment of a copy of the program whose kernels have no place for a cache.

    A file in place of a folder stops root as well, who may write whatever is read-only.
    """
    shutil.copytree(
        ROOT / "rolling", tmp_path / "rolling", ignore=shutil.ignore_patterns("__pycache__")
    )
    (tmp_path / "rolling" / "contact" / "__pycache__").touch()
    kept = {name: value for name, value in os.environ.items() if "CACHE" not in name}
    return kept | {"HOME": os.devnull, "PYTHONPATH": str(tmp_path), "TMPDIR": str(tmp_path)}


def compiled(environment: dict[str, str], before: str = "") -> tuple[list[str], str]:
    """Compile and call a kernel; return the lines printed, and the warnings."""
    done = subprocess.run(
        [sys.executable, "-c", before + COMPILE],
        capture_output=True,
        text=True,
        env=environment,
        cwd=environment["PYTHONPATH"],
        timeout=900,
    )
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    return done.stdout.splitlines(), done.stderr


@pytest.mark.slow
def test_a_read_only_program_without_a_home_compiles_into_a_temporary_folder(
    sealed: dict[str, str], tmp_path: Path
) -> None:
    (sums, folder), warnings = compiled(sealed)
    assert sums == SUMS
    assert warnings.count("set NUMBA_CACHE_DIR to a folder of your own") == 1
    assert Path(folder).parent == tmp_path and not Path(folder).exists()  # gone with the process


def test_a_program_that_can_write_nowhere_works_all_the_same(sealed: dict[str, str]) -> None:
    full = "import tempfile\ndef refuse(**how): raise OSError\ntempfile.mkdtemp = refuse\n"
    (sums, _), warnings = compiled(sealed, full)
    assert sums == SUMS and warnings.count("NUMBA_CACHE_DIR") == 1


@pytest.mark.slow
def test_a_given_folder_keeps_the_compiled_code(sealed: dict[str, str], tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    (sums, folder), warnings = compiled(sealed | {"NUMBA_CACHE_DIR": str(kept)})
    assert (sums, folder, warnings) == (SUMS, str(kept), "")
    assert list(kept.rglob("*node_work*.nbi"))


# ---- no semaphores


@pytest.mark.slow
@pytest.mark.parametrize(
    "error", [FileNotFoundError(2, "No such file"), OSError(38, "ENOSYS"), ImportError("sem_open")]
)
def test_without_semaphores_one_process_does_all(
    error: Exception,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def refuse(self: object) -> None:
        raise error

    monkeypatch.setattr(type(get_context("loky")), "Lock", refuse)
    scene = tmp_path / "scene.yaml"
    out = tmp_path / "out"
    scene.write_text(TINY + "sweep: {surface.seed: [1, 2]}\n")
    assert cli.main(words_of(scene, out, "--workers", "2")) == 0
    assert "is /dev/shm there and writable?" in capsys.readouterr().err
    assert len(contents(out)) == 6


# A namespace of its own hides /dev/shm from one process without rights of an administrator. Systems
# other than Linux have none, and some distributions and containers forbid it to users.
IN_A_CONTAINER = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c"]


@pytest.mark.slow
@pytest.mark.skipif(
    not shutil.which("unshare")
    or subprocess.run([*IN_A_CONTAINER, "true"], capture_output=True).returncode != 0,
    reason="`unshare` is missing or makes no namespace for this user, so /dev/shm cannot be hidden",
)
def test_a_run_without_shared_memory_is_done(tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(TINY + "sweep: {surface.seed: [1, 2]}\n")
    words = " ".join(words_of(scene, tmp_path / "out", "--workers", "2"))
    done = subprocess.run(
        [
            *IN_A_CONTAINER,
            f"mount -t tmpfs -o ro none /dev/shm && {sys.executable} -m rolling {words}",
        ],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        timeout=900,
    )
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert done.stderr.count("warning: no worker processes") == 1


@pytest.mark.slow
def test_a_kernel_is_compiled_anew_when_a_kernel_in_another_file_changes(tmp_path: Path) -> None:
    """Numba would go on with cached code that holds the old kernel."""
    for package in ("rolling", "acoustics"):
        skip = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / package, tmp_path / package, ignore=skip)
    called = tmp_path / "rolling" / "contact" / "_called.py"
    calling = tmp_path / "rolling" / "contact" / "_calling.py"
    head = "from rolling.contact.compiling import njit\n"
    calling.write_text(
        f"{head}from rolling.contact._called import number\n\n\n"
        "@njit(cache=True)\ndef twice():\n    return 2 * number()\n\n\nprint(twice())\n"
    )
    kept = {name: value for name, value in os.environ.items() if "CACHE" not in name}
    kept["PYTHONPATH"] = str(tmp_path)
    printed = []
    for value in (1, 7):
        called.write_text(f"{head}\n\n@njit(cache=True)\ndef number():\n    return {value}\n")
        command = [sys.executable, "-B", "-c", "import rolling.contact._calling"]
        done = subprocess.run(
            command,
            cwd=tmp_path,
            env=kept,
            text=True,
            capture_output=True,
            check=True,
        )
        printed.append(int(done.stdout))
    assert printed == [2, 14]
