"""The tutorials are stored with their outputs, and run from top to bottom with outputs alike."""

from __future__ import annotations

import ast
import base64
import io
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import soundfile

ROOT = Path(__file__).parents[1]
pytest.importorskip("nbclient", reason="the extra `docs` is not installed")
nbformat = pytest.importorskip("nbformat", reason="the extra `docs` is not installed")
sys.path.append(str(ROOT / "docs" / "_hooks"))
tutorials = pytest.importorskip("tutorials")
NOTEBOOKS = sorted(tutorials.TUTORIALS.glob("*.ipynb"))
IMPORTED = {"acoustics", "matplotlib.pyplot", "numpy", "rolling"}  # all that a tutorial needs
# Facts of a machine: its folders, the addresses of objects.
MACHINE = re.compile(r"/(home|root|tmp|Users|work)/|site-packages|object at 0x|\b0x[0-9a-f]{6,}")
# The cells run on shorter tracks here than for the reader, whose outputs are stored, and in one
# process: those that solve take longer to start than these tracks take. The first contact has them.
SHORTER = {
    "article-figure": {
        'rc.read_scene("lee2025/as-stated/middle")': (
            'rc.read_scene("lee2025/as-stated/middle").with_(duration_s=0.005)'
        ),
        "rc.simulate_sweep(scene)": "rc.simulate_sweep(scene, workers=1)",
        '{"rolling.load_n": loads}))': '{"rolling.load_n": loads}), workers=1)',
    },
    "bearing": {
        "window_mm=2": 'window_mm=1", "numerics.spacing_um=8',
        "listen_s=4": "listen_s=0.5",
        "duration_s=0.3": "duration_s=0.1",
        "simulate(scene)": "simulate(scene, workers=1)",
        'inner.faults": None}))': 'inner.faults": None}), workers=1)',
        "progress=False": "progress=False, workers=1",
        'tilt="held"))': 'tilt="held"), workers=1)',
        '"bearing-inner-fault", quick': (
            '"bearing-inner-fault", [*quick, "bearing.radial_load_n=0"]'
        ),
    },
    "bearing-ball": {
        "distance_mm=3": "distance_mm=0.5",
        "listen_s=5": "listen_s=1",
        "[1, 2, 3]": "[1, 2]",
        "rc.simulate_sweep(scene)": "rc.simulate_sweep(scene, workers=1)",
        '["G10", "G100"]}))': '["G10", "G100"]}), workers=1)',
    },
    "first-contact": {
        "duration_s=0.03": "duration_s=0.005",
        "scene.with_(load_n=5))": "scene.with_(load_n=5), workers=1)",
    },
    "marble": {
        "distance_mm=8, spacing_um=4": "distance_mm=4, spacing_um=8, drop_mm=5, listen_s=2",
        "rc.simulate(scene)": "rc.simulate(scene, workers=1)",
        "scene.with_(thickness_mm=4))": "scene.with_(thickness_mm=4), workers=1)",
    },
    "my-scan": {"(2700, 800)": "(300, 600)"},
    "which-one": {
        "distance_mm=3": "distance_mm=0.5",
        "fine], progress=False": "fine], pairs=2, progress=False",
        "thick], progress=False": "thick], pairs=2, progress=False",
        "progress=False": "progress=False, workers=1",
    },
}


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request: pytest.FixtureRequest) -> Path:
    """Return the path of each notebook in turn."""
    return request.param


def test_each_tutorial_is_in_the_navigation():
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert all(f"tutorials/{path.stem}.md" in navigation for path in NOTEBOOKS)


def test_a_tutorial_begins_with_a_question_and_ends_with_a_change(path: Path):
    cells = nbformat.read(path, as_version=4).cells
    assert re.search(r"^\*\*.*\?\*\*", cells[0].source, re.MULTILINE)
    texts = [cell.source for cell in cells if cell.cell_type == "markdown"]
    assert "## Change one thing" in texts[-1] and cells[-1].cell_type == "code"


def test_a_tutorial_imports_what_is_public(path: Path):
    cells = nbformat.read(path, as_version=4).cells
    code = "\n".join(cell.source for cell in cells if cell.cell_type == "code")
    imported = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        assert not isinstance(node, ast.ImportFrom)
    assert imported <= IMPORTED


def _pictures(notebook) -> list[bytes]:
    """Return the pictures of a notebook."""
    data = [output.get("data", {}) for output in tutorials.outputs_of(notebook)]
    return [base64.b64decode(x["image/png"]) for x in data if "image/png" in x]


def test_stored_outputs_are_there_small_and_of_no_machine(path: Path):
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == [*range(1, len(code) + 1)]  # by one command
    outputs = tutorials.outputs_of(notebook)
    assert not [output for output in outputs if output.output_type == "error"]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    pictures = _pictures(notebook)
    assert pictures and max(map(len, pictures)) < 40_000
    text, files = tutorials.page(notebook, path.stem)
    assert not MACHINE.search(text)
    assert "data:audio" not in text and all(name in text for name in files)
    sounds = [content for name, content in files.items() if name.endswith(".mp3")]
    assert sounds and max(map(len, sounds)) < 80_000
    for sound in sounds:
        samples, rate = soundfile.read(io.BytesIO(sound))
        assert len(samples) > 3 * rate  # a fall ends where its impacts have died away
        assert 0.02 < np.abs(samples).max() <= 1


def _kinds(notebook) -> list[list[str]]:
    """Return the kinds of the outputs of each cell."""
    return [
        [
            kind
            for output in cell.get("outputs", ())
            for kind in sorted(output.get("data", ["text"]))
        ]
        for cell in notebook.cells
    ]


@pytest.mark.slow
def test_a_tutorial_runs_without_warnings_and_gives_outputs_like_the_stored_ones(path: Path):
    """The stored outputs are of the cells that stand there; their bytes may differ."""
    notebook = tutorials.executed(path, SHORTER.get(path.stem))
    assert not tutorials.warnings_of(notebook)
    assert _kinds(tutorials.tidied(notebook)) == _kinds(nbformat.read(path, as_version=4))
