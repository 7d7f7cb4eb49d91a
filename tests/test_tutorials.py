"""The tutorials run from top to bottom, sound, and end with one thing to change."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile

ROOT = Path(__file__).parents[1]
pytest.importorskip("nbclient", reason="the extra `docs` is not installed")
pytest.importorskip("mkdocs", reason="the extra `docs` is not installed")
nbformat = pytest.importorskip("nbformat", reason="the extra `docs` is not installed")
sys.path.append(str(ROOT / "docs" / "_hooks"))
tutorials = pytest.importorskip("tutorials")
NOTEBOOKS = sorted(tutorials.TUTORIALS.glob("*.ipynb"))


def test_there_are_five_tutorials_in_the_navigation():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert len(NOTEBOOKS) == 5
    assert all(f"tutorials/{path.stem}.md" in navigation for path in NOTEBOOKS)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_stored_tutorial_has_no_outputs_and_ends_with_a_change(path: Path):
    cells = nbformat.read(path, as_version=4).cells
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)
    headings = [cell.source for cell in cells if cell.cell_type == "markdown"]
    assert "## Change one thing" in headings[-1] and cells[-1].cell_type == "code"


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_tutorial_runs_and_is_heard_and_seen(path: Path):
    notebook = tutorials.executed(path)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    texts = [output.get("text", "") for output in outputs]
    warnings = [text for text in texts if "Warning" in text]
    assert not warnings
    text, files = tutorials.page(notebook, path.stem)
    assert "data:audio" not in text and all(name in text for name in files)
    assert any(name.endswith(".png") for name in files)
    assert sum(map(len, files.values())) < 1.5e6
    sounds = [content for name, content in files.items() if name.endswith(".mp3")]
    assert len(sounds) + text.count(" dB") >= 2
    for content in sounds:
        samples, rate = soundfile.read(io.BytesIO(content))
        assert len(samples) >= 4.9 * rate
        assert 0.02 < np.abs(samples).max() <= 1
    assert sounds
