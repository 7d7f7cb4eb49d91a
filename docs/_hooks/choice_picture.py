"""The choice of docs/which-finish-is-quieter.md, by the Python code and the scene of that page.

`docs/_hooks/pictures.py choice` stores its picture, and compares its answer with the page.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from build_cache import ROOT

PAGE = ROOT / "docs" / "which-finish-is-quieter.md"
RESULT = Path("outputs") / "finish"
BLOCK = "^```{language}\n(.*?)^```"


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
    return _first("python"), _first("yaml")


def _first(language: str) -> str:
    """Return the first block of a language on the page."""
    pattern = BLOCK.format(language=language)
    found = re.search(pattern, PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert found is not None
    return found[1]
