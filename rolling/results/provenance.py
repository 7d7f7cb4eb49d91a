"""The provenance of the numbers of a run: versions, source, machine, seed."""

from __future__ import annotations

import platform
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path

import rolling
from rolling.check import cost
from rolling.numbers.file_facts import Provenance
from rolling.scene.scene import Scene
from rolling.terminal import program

_PACKAGES = ("numpy", "scipy", "numba", "pyfftw", "soundfile", "h5netcdf", "xarray", "pydantic")


def provenance(scene: Scene, label: str) -> Provenance:
    """Collect the provenance of the numbers: versions, state of the source, machine, seed, run."""
    packages = (*_PACKAGES, "mosqito") if scene.sound.loudness else _PACKAGES
    facts = program_provenance(label, packages)
    return replace(facts, seed=getattr(scene.surface, "seed", None))


def program_provenance(label: str, packages: Sequence[str] = _PACKAGES) -> Provenance:
    """Collect the provenance of the numbers of a run of any scene."""
    return Provenance(
        program=rolling.__version__,
        sources=program.identity().sources,
        source=_commit(),
        python=platform.python_version(),
        packages={name: _version(name) for name in packages},
        machine=f"{platform.system()} {platform.machine()}, {cost.cores()} processors",
        label=label,
        written=datetime.now(UTC).isoformat(timespec="seconds"),
    )


_version = cache(metadata.version)


@cache
def _commit() -> str | None:
    """Return the commit of the checkout with the mark of changes; None outside a checkout."""
    root = Path(rolling.__file__).parents[1]
    git = ["git", "--git-dir", str(root / ".git"), "--work-tree", str(root)]
    command = [*git, "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
