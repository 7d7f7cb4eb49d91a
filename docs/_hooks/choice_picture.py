"""The choice of docs/which-finish-is-quieter.md, by the Python code and the scene of that page.

`docs/_hooks/pictures.py choice` stores its picture, and compares its answer with the page.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from build_cache import ROOT
from picture_parts import first_block

PAGE = ROOT / "docs" / "which-finish-is-quieter.md"
RESULT = Path("outputs") / "finish"


def choose(folder: Path) -> str:
    """Make the scans and the scene of the page in a folder, choose, and return the answer.

    The answer is what the command prints before the paths of its files.
    """
    scans, scene = blocks()
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([sys.executable, "-c", scans], cwd=folder, check=True)
    (folder / "MyScans.yaml").write_text(scene, encoding="utf-8")
    command = ["-m", "rolling", "choose", "MyScans.yaml", "--out", str(RESULT)]
    done = subprocess.run(
        [sys.executable, *command], cwd=folder, check=True, stdout=subprocess.PIPE, text=True
    )
    print(done.stdout)
    answer, _, _ = done.stdout.rstrip().rpartition("\n\n")
    return answer


def blocks() -> tuple[str, str]:
    """Return the Python code that makes the scans of the page, and its scene."""
    return first_block(PAGE, "python"), first_block(PAGE, "yaml")
