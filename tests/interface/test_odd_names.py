"""Pictures, tables and the terminal take labels and folders of any name."""

from __future__ import annotations

import csv
import io
import os
import warnings
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest
from scene_text import TINY

from rolling.figures.picture import DPI, WIDTH_IN, drawable, finish, picture
from rolling.kinds.run_folder import RunFolder
from rolling.results.labels import labels, printable
from rolling.results.run_lines import levels_table
from rolling.scene.file import loads

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
    "W" * 200,
    "\u05e9\u05dc\u05d5\u05dd \u05e2\u05d5\u05dc\u05dd",
    "\u202egnp.exe",
    "\u4e2d" * 60,
    "  ",
]


@pytest.mark.parametrize("name", NAMES)
def test_pictures_take_any_label_as_it_stands(name: str) -> None:
    """A label causes no formula, no missing letter and no invalid byte, and stays in the figure."""
    texts = [f"load 1 N ({printable(name)})", "load 1 N (plain)"]

    def draw(ax):
        for text in texts:
            ax.plot([0, 1], [0, 1], label=text)
        return finish(ax, texts[0], texts[1:])

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drawn = picture("odd", draw, pd.DataFrame([texts], columns=["first", "second"]))
        assert drawn.file("png")
        ElementTree.fromstring(drawn.file("svg"))
    rows = list(csv.reader(io.StringIO((drawn.file("csv") or b"").decode(), newline="")))
    assert rows[1] == texts
    (legend,) = drawn.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [drawable(text) for text in texts]
    for artist in [legend, *drawn.figure.texts]:
        assert artist.get_window_extent().x1 <= WIDTH_IN * DPI + 1.0


def test_texts_that_differ_look_different() -> None:
    """Two texts look different although the font of the pictures has neither of their letters."""
    assert drawable("\U0001f600") != drawable("\U0001f601")
    assert drawable("Ra 0.1 µm, 5 N \u2026 ±") == "Ra 0.1 µm, 5 N \u2026 ±"


@pytest.mark.parametrize("name", NAMES)
def test_labels_and_terminal_show_folders_of_any_name_on_one_line(name: str) -> None:
    scene = loads(TINY)
    runs = [RunFolder({}, scene, Path(name)), RunFolder({}, scene, Path("plain"))]
    for label in labels(runs):
        assert label.isprintable() and label.startswith("load 0.005 N (")
    heads, *rows = levels_table(runs).rstrip().splitlines()
    assert len(rows) == 2 and all(line.isprintable() for line in (heads, *rows))
