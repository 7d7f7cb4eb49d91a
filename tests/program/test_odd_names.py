"""Reports, pictures, tables and the terminal take folders and height files of any name."""

from __future__ import annotations

import csv
import io
import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from report_runs import Runs
from rolling.simulation import labels, summary

from rolling import cli
from rolling.figures.picture import DPI, SIDE_IN, WIDTH_IN, Picture, drawable, single

NAMES = [
    "$x^$",
    "a$b",
    r"\$\frac{",
    "new\nline",
    "emoji \U0001f600",
    os.fsdecode(b"byte \xff"),
    "<>&\"'",
    "]]>--><!--",
    "#1, 2\t3",
    "_under",
    "x" * 250,
    "W" * 200,
    "\u05e9\u05dc\u05d5\u05dd \u05e2\u05d5\u05dc\u05dd",
    "\u202egnp.exe",
    "\u4e2d" * 60,
    "  ",
]


def drawn(texts: list[str]) -> Picture:
    """Return a picture with these texts in its legend, title and note."""

    def draw(ax) -> None:
        for text in texts:
            ax.plot([0, 1], [0, 1], label=text)

    return single("odd", texts[0], "; ".join(texts), {text: np.zeros(2) for text in texts}, draw)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_pictures_take_any_label_as_it_stands(name: str) -> None:
    """A label causes no formula, no missing letter and no invalid byte, and stays in the figure."""
    texts = [f"load 1 N ({labels.printable(name)})", "load 1 N (plain)"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        picture = drawn(texts)
        assert picture.png()
        ElementTree.fromstring(picture.svg())
    assert next(csv.reader(io.StringIO(picture.csv().decode(), newline=""))) == texts
    (legend,) = picture.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [drawable(text) for text in texts]
    room = (WIDTH_IN - SIDE_IN) * DPI + 1.0
    for each in [legend, *picture.figure.texts]:
        assert each.get_window_extent().x1 <= room


def test_texts_that_differ_look_different() -> None:
    """Two texts look different although the font of the pictures has neither of their letters."""
    assert (
        drawable("\U0001f600") != drawable("\U0001f601")
        and drawable("Ra 0.1 µm, 5 N \u2026 ±") == "Ra 0.1 µm, 5 N \u2026 ±"
    )


@pytest.mark.slow
def test_a_report_of_folders_with_odd_names(runs: Runs, tmp_path: Path, capsys) -> None:
    """The page lies beside the run, in a folder that is not UTF-8, and names both runs."""
    here = tmp_path / os.fsdecode(b"$x^$ \n \xff #<b>&\"' \xf0\x9f\x98\x80")
    there = tmp_path / os.fsdecode(b"$x^$ \n \xfe #<b>&\"' \xf0\x9f\x98\x80")
    for folder in (here, there):
        shutil.copytree(runs.smooth(), folder)
    with (here / "resolved.yaml").open("a") as scene:
        scene.write('description: "half a letter: \\uD800, $x^$\\n and a bell: \\a"\n')
    assert cli.main(["report", str(here), str(there), "--out", str(here / "page.html")]) == 0
    assert "\\udcff" in capsys.readouterr().out
    page = (here / "page.html").read_text()
    for byte in ("ff", "fe"):
        assert f"load 1 N ($x^$ \\n \\x{byte} #&lt;b&gt;&amp;&#34;&#39; \U0001f600)" in page
    assert "<b>&" not in page
    assert "half a letter: \\ud800, $x^$ and a bell: \\x07" in page


@pytest.mark.slow
def test_the_terminal_takes_a_folder_of_any_bytes(runs: Runs, tmp_path: Path) -> None:
    """A strict terminal, an ASCII terminal and a table print such folders."""
    folder = tmp_path / os.fsdecode(b"none \xff")
    for encoding in ("utf-8", "ascii"):
        done = subprocess.run(
            [sys.executable, "-m", "rolling.cli", "report", os.fsencode(folder)],
            env=os.environ | {"PYTHONIOENCODING": f"{encoding}:strict"},
            capture_output=True,
        )
        assert done.returncode == 2
        assert (
            b"\\udcff" in done.stderr
            and b"not a run folder" in done.stderr
            and b"Traceback" not in done.stderr
        )
    assert "none \\xff" in summary.table([("load 1 N", str(folder), None)])
