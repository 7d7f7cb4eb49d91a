"""A figure with the numbers drawn in it, as PNG, SVG and CSV. Depends on matplotlib; the same figure gives the same bytes."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from rolling.store import write_bytes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Picture:
    """A figure and its curves.

    name : stem of its files.
    alt : what it shows, in words, for those who do not see it.
    columns : every plotted curve, by name with unit; columns of different lengths stand side by side. Maps have none.
    """

    name: str
    alt: str
    figure: Figure
    columns: Mapping[str, Array]

    def png(self) -> bytes:
        content = io.BytesIO()
        self.figure.savefig(content, format="png", dpi=110)
        return content.getvalue()

    def svg(self) -> bytes:
        content = io.BytesIO()
        # Ids from the name instead of at random, and no date: the same figure gives the same file.
        with matplotlib.rc_context({"svg.hashsalt": self.name}):
            self.figure.savefig(content, format="svg", dpi=150, metadata={"Date": None})
        return content.getvalue()

    def csv(self) -> bytes:
        """The curves as columns under their names; what is not a finite number is left empty."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(self.columns)
        for values in zip_longest(*self.columns.values()):
            table.writerow("" if value is None or not np.isfinite(value) else f"{value:.9g}" for value in values)
        return text.getvalue().encode()

    def plot_area(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of the first pair of axes, as shares of the figure."""
        self.figure.draw_without_rendering()
        left, bottom, right, top = self.figure.axes[0].get_position().extents
        return float(left), float(bottom), float(right), float(top)

    def write(self, folder: Path) -> None:
        """Write name.png and name.svg into a folder, and name.csv if it has curves."""
        write_bytes(folder / f"{self.name}.png", self.png())
        write_bytes(folder / f"{self.name}.svg", self.svg())
        if self.columns:
            write_bytes(folder / f"{self.name}.csv", self.csv())


def blank(width: float, height: float) -> Figure:
    """An empty figure of that size in inches, drawn without a display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def single(name: str, alt: str, columns: Mapping[str, Array], draw: Callable[[Axes], object]) -> Picture:
    """A picture with one pair of axes."""
    figure = blank(8.5, 4.8)
    draw(figure.subplots())
    return Picture(name, alt, figure, columns)
