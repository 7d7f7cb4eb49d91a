"""A figure with its curves, written as PNG, SVG and CSV; the same figure gives the same bytes.

Sizes are fixed in inches and not fitted to the content. Plots of the same kind therefore have the
same layout, and drawing takes half the time.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import zip_longest
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from numpy.typing import NDArray

from rolling.folders.files import write_bytes
from rolling.simulation.labels import printable

DPI = 110
MOST_NAMED = 24  # curves; a legend of more takes more room than they do
WIDTH_IN = 8.5
SIDE_IN = 0.12  # white margin on either side of titles and legends
# margins of the axes for tick labels, axis label and titles
LEFT_IN, RIGHT_IN, BOTTOM_IN, TOP_IN = 0.85, 0.2, 0.6, 0.68
BAR_IN = 0.16  # width of a colour bar
BAR_ROOM_IN = 1.0  # from the axes to the edge of the figure: gap, bar, tick labels, label
Box = tuple[float, float, float, float]  # left, bottom, width and height of axes [inches]
_ROW_IN = 0.2  # height of a row in a legend
_TALL_IN = 3.5  # height of single axes


@dataclass(frozen=True)
class Picture:
    """A figure and its curves.

    Parameters
    ----------
    name : str. Stem of its files.
    alt : str. Description for readers who do not see it.
    figure : matplotlib figure.
    columns : mapping of arrays, of numbers or text. The plotted curves as a table; names end in the
        unit. Maps have none.
    """

    name: str
    alt: str
    figure: Figure
    columns: Mapping[str, NDArray[Any]]

    def png(self) -> bytes:
        """Return the figure as a PNG file."""
        content = io.BytesIO()
        self.figure.savefig(content, format="png", dpi=DPI)
        return content.getvalue()

    def svg(self) -> bytes:
        """Return the figure as an SVG file."""
        return self._svg

    @cached_property  # folder and page both need it, and drawing takes long
    def _svg(self) -> bytes:
        content = io.BytesIO()
        # Ids derive from the name and the date is left out, so the same figure gives the same file.
        with matplotlib.rc_context({"svg.hashsalt": self.name}):
            self.figure.savefig(content, format="svg", dpi=DPI, metadata={"Date": None})
        return content.getvalue()

    def csv(self) -> bytes:
        """Return the curves as a table, with their names in its first line.

        A value that is not finite leaves its cell empty.
        """
        return self._csv

    @cached_property
    def _csv(self) -> bytes:
        rows = [
            [quoted(name, ",") for name in self.columns],
            *zip_longest(*map(_cells, self.columns.values()), fillvalue=""),
        ]
        return "".join(f"{','.join(row)}\n" for row in rows).encode()

    def plot_area(self) -> tuple[float, float, float, float]:
        """Return left, bottom, right and top of the first axes, as shares of the figure."""
        left, bottom, right, top = self.figure.axes[0].get_position().extents
        return float(left), float(bottom), float(right), float(top)

    def write(self, folder: Path) -> None:
        """Write name.png and name.svg into a folder, and name.csv if it has curves."""
        write_bytes(folder / f"{self.name}.png", self.png())
        write_bytes(folder / f"{self.name}.svg", self.svg())
        if self.columns:
            write_bytes(folder / f"{self.name}.csv", self.csv())


def blank() -> Figure:
    """Make an empty figure that needs no display."""
    figure = Figure(dpi=DPI)
    FigureCanvasAgg(figure)
    return figure


def lay_out(figure: Figure, title: str, note: str, places: Mapping[Axes, Box]) -> None:
    """Place axes, title, note and legend, and set the height of the figure.

    Title, note and legend are set smaller where they are too long for the width. The legend shows
    the curves of the first axes, unless there are more than `MOST_NAMED`. Text is drawn as it
    stands: a dollar begins no formula.

    Parameters
    ----------
    figure : figure to lay out.
    title : str. First line.
    note : str. Second line, with the assumptions.
    places : mapping of boxes, inches. Box of each pair of axes, above the legend and below the
        titles.
    """
    handles, labels = next(iter(places)).get_legend_handles_labels()
    if len(labels) > MOST_NAMED:
        handles, labels, note = [], [], f"{note}; {len(labels)} curves, named in the table"
    labels = [drawable(label) for label in labels]
    room = WIDTH_IN - 2 * SIDE_IN
    across = max(1, int(room / (0.75 + 0.068 * max(map(len, labels), default=0))))
    below = 0.08 + _ROW_IN * -(-len(labels) // across) if labels else 0.0
    height = max(bottom + tall for _, bottom, _, tall in places.values()) + TOP_IN + below
    figure.set_size_inches(WIDTH_IN, height)
    for ax, (left, bottom, wide, tall) in places.items():
        ax.set_position(
            (left / WIDTH_IN, (bottom + below) / height, wide / WIDTH_IN, tall / height)
        )
    if labels:
        legend = figure.legend(
            handles,
            labels,
            loc="lower left",
            bbox_to_anchor=(SIDE_IN / WIDTH_IN, 0.04 / height),
            borderaxespad=0.0,
            ncols=across,
            fontsize=8.5,
            handlelength=3.4,  # long enough to distinguish the line styles
            frameon=False,
        )
        for text in legend.get_texts():
            text.set_parse_math(False)
        _fit(legend, legend.get_texts(), room * figure.dpi)
    for words, size, colour, from_top in ((title, 12.0, "black", 0.28), (note, 9.0, "0.25", 0.52)):
        place = SIDE_IN / WIDTH_IN, 1.0 - from_top / height
        line = figure.text(*place, drawable(words), fontsize=size, color=colour, parse_math=False)
        _fit(line, [line], room * figure.dpi)


def _fit(drawn: Artist, texts: Sequence[Text], room: float) -> None:
    """Shrink texts until the artist that holds them is no wider than the room [dots]."""
    size = float(texts[0].get_fontsize())
    # Letters snap to dots, so a line shrinks only roughly in proportion to its letters.
    while (wide := drawn.get_window_extent().width) > room:
        size *= min(0.99, room / wide)
        for text in texts:
            text.set_fontsize(size)


def drawable(text: str) -> str:
    """Escape letters that the font of the pictures lacks.

    Different texts therefore look different.
    """
    known = _letters()
    return "".join(
        x if ord(x) in known else x.encode("unicode_escape").decode("ascii") for x in text
    )


@cache
def _letters() -> frozenset[int]:
    """Return the code points of the letters that the font has."""
    return frozenset(get_font(findfont(FontProperties())).get_charmap())


def single(
    name: str,
    title: str,
    note: str,
    columns: Mapping[str, NDArray[Any]],
    draw: Callable[[Axes], object],
) -> Picture:
    """Make a picture with one pair of axes.

    Parameters
    ----------
    name, title, note, columns : see `Picture` and `lay_out`.
    draw : function of axes. It draws the curves.
    """
    figure = blank()
    ax = figure.add_subplot()
    draw(ax)
    lay_out(
        figure, title, note, {ax: (LEFT_IN, BOTTOM_IN, WIDTH_IN - LEFT_IN - RIGHT_IN, _TALL_IN)}
    )
    return Picture(name, f"{title}: {note}", figure, columns)


# ---- tables as text


def _cells(values: NDArray[Any]) -> list[str]:
    """Write a column of a table, numbers with nine digits."""
    if values.dtype.kind in "US":
        return [quoted(text, ",") for text in values.tolist()]
    return [
        "" if gap else f"{value:.9g}"
        for value, gap in zip(values.tolist(), ~np.isfinite(values), strict=True)
    ]


def comment(remark: str) -> str:
    """Write a remark as a comment line of a table, as pandas skips it with `comment="#"`."""
    return f"# {printable(remark)}"


def quoted(cell: str, separator: str) -> str:
    """Write a text cell of a table, quoted if it holds a separator, a quotation mark or a `#`."""
    return (
        '"' + cell.replace('"', '""') + '"'
        if any(sign in cell for sign in (separator, '"', "#"))
        else cell
    )
