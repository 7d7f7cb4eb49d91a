"""Run the commands of docs/which-finish-is-quieter.md, and store the picture of their choice.

    python docs/_hooks/choice_picture.py [FOLDER]

The Python code and the scene of that page are taken from it as they stand, so the picture is that
of the page. FOLDER gets their files; by default a temporary one. The answer is printed, to compare
it with the page.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "which-finish-is-quieter.md"
PICTURE = ROOT / "scenarios" / "pictures" / "choice.png"
COLOURS = 32  # of the picture
BLOCK = "^```{language}\n(.*?)^```"


def main(words: list[str]) -> int:
    """Make the scans and the scene of the page, choose, and store the picture."""
    if words:
        return _choose(Path(words[0]))
    with tempfile.TemporaryDirectory() as folder:
        return _choose(Path(folder))


def _choose(folder: Path) -> int:
    """Choose between the finishes of the page in a folder; return the exit code."""
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([sys.executable, "-c", _first("python")], cwd=folder, check=True)
    (folder / "MyScans.yaml").write_text(_first("yaml"), encoding="utf-8")
    command = ["-m", "rolling", "choose", "MyScans.yaml", "--out", "outputs/finish"]
    code = subprocess.run([sys.executable, *command], cwd=folder, check=False).returncode
    if code == 0:
        drawn = Image.open(folder / "outputs" / "finish" / "choice.png")
        drawn.convert("RGB").quantize(COLOURS).save(PICTURE, optimize=True)
    return code


def _first(language: str) -> str:
    """Return the first block of a language on the page."""
    pattern = BLOCK.format(language=language)
    found = re.search(pattern, PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert found is not None
    return found[1]


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
