"""The program in processes of its own, and small scenes whose marches have several pieces."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from stored_arrays import content_of

ROOT = Path(__file__).parents[2]
PATIENCE = 600.0  # [s] until a command has surely hung, on whatever machine

# Two runs of 450 steps in three pieces each, of 5 ms per step.
SWEEP = """\
name: pieces
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2, \
width_um: 200, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.009}
sweep: {rolling.load_n: [1, 2]}
"""


def words_of(scene: Path, out: Path, *more: str) -> list[str]:
    """Return the words of a quiet run without a page."""
    return ["run", str(scene), "--out", str(out), "--no-report", "-q", *more]


def rolling(
    words: Sequence[object], folder: Path, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end in a folder."""
    return subprocess.run(
        [sys.executable, "-m", "rolling", *map(str, words)],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


@contextmanager
def started(words: Sequence[object], folder: Path) -> Iterator[subprocess.Popen[str]]:
    """Start a command in a folder, and kill it in the end."""
    with (folder / "said").open("w") as output:
        process = subprocess.Popen(
            [sys.executable, "-m", "rolling", *map(str, words)],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=output,
            stderr=output,
            text=True,
            # A shell that starts the tests in its background ignores ctrl-c for all below.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def wait_for(condition: Callable[[], object]) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited for nothing"
        time.sleep(0.02)


def pieces(out: Path) -> list[Path]:
    """Return the files of solved pieces in a run folder, whose folders may vanish meanwhile."""
    found = (Path(folder, name) for folder, _, names in os.walk(out / "pieces") for name in names)
    return [path for path in found if path.suffix == ".npz"]


def contents(out: Path) -> dict[str, Any]:
    """Return the bytes of sounds and the arrays of results in a folder by path.

    They hold no times of the machine. The bytes of a result may differ between equal runs.
    """
    names = ("result.h5", "signal.wav", "listen.wav", "passes.wav")
    return {
        str(path.relative_to(out)): content_of(path)
        for path in out.rglob("*.*")
        if path.name in names
    }


def tree(folder: Path) -> dict[str, str]:
    """Return the content below a folder by path."""
    return {
        path.relative_to(folder).as_posix(): f"-> {path.readlink()}"
        if path.is_symlink()
        else (path.read_bytes().decode("utf-8", "replace") if path.is_file() else "folder")
        for path in sorted(folder.rglob("*"))
    }
