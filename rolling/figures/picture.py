"""Axes of figures with title, note and legend, and their files; equal runs give equal bytes."""

import io
import re
import textwrap
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.legend import Legend
from matplotlib.text import Text
from pandas import DataFrame

from acoustics.numbers import rounded
from acoustics.plot_style import gridded
from rolling.figures.settings import own_settings
from rolling.results.run_result import Run
from rolling.results.runs_table import without_formulas

DPI = 110
WIDTH_IN, HEIGHT_IN = 8.5, 4.4
MAX_NAMED = 24  # curves; a legend of more takes more room than they do
_NAMED_SCENES = 4  # scenes named in a title; more scenes are counted
_ROW_IN = 0.19  # height of a row in a legend
_LETTERS_PER_IN = 12  # of a title on axes
_SMALL_IN, _SMALL_PT = 2.4, 7  # side of small axes, as in a grid, and the size of their letters
_MAX_HIGH = 0.7  # largest height of a legend over that of its axes
_DENSE: dict[str, Any] = {"labelspacing": 0.15, "borderpad": 0.2, "handlelength": 1.5}
_TITLE_LETTERS, _NOTE_LETTERS = 88, 125  # of a line across a figure


# ---- axes


def axes_of(ax: Axes | None) -> Axes:
    """Return the given axes, or new axes in a figure of their own.

    A figure without a layout engine gets the tight layout, so that nothing overlaps.
    """
    if ax is not None:
        figure, in_grid = ax.figure, all(axes.get_subplotspec() for axes in ax.figure.axes)
        if isinstance(figure, Figure) and figure.get_layout_engine() is None and in_grid:
            figure.set_layout_engine("tight")
        return ax
    import matplotlib.pyplot as plt

    try:
        return plt.subplots(layout="constrained")[1]
    except ImportError as error:  # of a backend that is not installed, or that needs a screen
        warnings.warn(
            "matplotlib cannot show the new figure, because its backend cannot be loaded"
            f" ({error}); `ax.figure.savefig` writes it into a file",
            stacklevel=2,
        )
        figure = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        return figure.add_subplot()


def listed(runs: Run | Iterable[Run]) -> list[Run]:
    """Return one or several runs as a list; a dictionary gives its values."""
    if isinstance(runs, dict):
        return [*runs.values()]
    return [*runs] if isinstance(runs, Iterable) else [runs]


def finish(ax: Axes, title: str, facts: Iterable[str]) -> Axes:
    """Set title, note and legend of axes, and the grid of curves.

    The label of the axes holds title and note in two lines.
    Axes of a grid have small letters, and a legend only where it leaves room for the curves.
    """
    if not ax.images:
        gridded(ax)
    handles, names = ax.get_legend_handles_labels()
    is_small = min(ax.bbox.size) < _SMALL_IN * ax.figure.dpi
    note = "; ".join(facts)
    if len(names) > MAX_NAMED:
        note += f"; {len(names)} curves"
    ax.set_label(f"{title}\n{note}")
    per_in = _LETTERS_PER_IN / (_SMALL_PT / 10 if is_small else 1)
    letters = [max(12, int(per_in * side / ax.figure.dpi)) for side in ax.bbox.size]
    heading, below = (textwrap.wrap(text, letters[0]) for text in (title, note))
    roomy = not is_small and len(heading + below) < letters[1] / 10
    size: Any = _SMALL_PT if is_small else "medium"
    words = "\n".join(heading + below * roomy)
    _plain([ax.set_title(words, loc="left", fontsize=size, wrap=True)])
    ax.set_xlabel(_broken(ax.get_xlabel(), letters[0]))
    beside = (other for other in ax.figure.axes if (*other.bbox.bounds,) == (*ax.bbox.bounds,))
    bars = (image.colorbar.ax for image in ax.images if image.colorbar)
    for side in dict.fromkeys((ax, *beside, *bars)):
        side.set_ylabel(_broken(side.get_ylabel(), letters[1]))
        if is_small:
            side.tick_params(which="both", labelsize=_SMALL_PT)
            for axis in (side.xaxis, side.yaxis):
                axis.label.set_fontsize(_SMALL_PT)
    if 0 < len(names) <= MAX_NAMED:
        names = [textwrap.fill(drawable(name), letters[0] - 6) for name in names]
        look = {"fontsize": _SMALL_PT - 1, **_DENSE} if is_small else {"fontsize": "small"}
        legend = ax.legend(handles, names, framealpha=0.6, **look)
        legend.__class__ = _Legend  # its axes have their final size when they are drawn
        legend.set_in_layout(False)
        _plain(legend.get_texts())
    return ax


class _Legend(Legend):
    """A legend that is drawn where it leaves room for the curves of its axes."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw the legend if its axes have room for it."""
        own, room = self.get_window_extent(renderer), self.axes.bbox
        if own.height < _MAX_HIGH * room.height and own.width < room.width:
            super().draw(renderer)


def _broken(label: str, letters: int) -> str:
    """Break the label of an axis that is too long between words, but not within its unit."""
    words, sign, unit = label.partition(" [")
    kept = words + sign + unit.replace(" ", "\xa0")
    return textwrap.fill(kept, letters, break_long_words=False)


def subject(runs: Sequence[Run]) -> str:
    """Name the scenes of runs, or count the scenes if there are many; one run has its title."""
    if len(runs) == 1:
        return runs[0].title
    names = dict.fromkeys(run.scene.name for run in runs)
    return ", ".join(names) if len(names) <= _NAMED_SCENES else f"{len(names)} scenes"


def common(word: str, values: Sequence[float], unit: str = "") -> str:
    """Write the value that all runs share, or its range: at 1 m, at 1 to 2 m."""
    ends = dict.fromkeys(number(value) for value in (min(values), max(values)))
    return f"{word} {' to '.join(ends)} {unit}".rstrip()


def number(value: float) -> str:
    """Write a number with three digits, or with all digits before the decimal point."""
    return f"{value:,.0f}" if value >= 1000 else rounded(value, 3)


def distance_and_duration(runs: Sequence[Run]) -> list[str]:
    """Write the distance of the listener [m] and the duration of the records [s]."""
    place = common("at", [run.scene.listener_distance_m for run in runs], "m")
    if any(run.scene.is_listener_placed for run in runs):
        place += " from the contact"
    return [place, common("T =", [run.sound.duration for run in runs], "s")]


# ---- files


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure on one pair of axes with its name and its curves as a table."""

    name: str
    figure: Figure
    table: DataFrame | None

    @own_settings()
    def file(self, form: str) -> bytes | None:
        """Return the picture as the bytes of a png, svg or csv file; a map has no csv."""
        if form == "csv":
            return None if self.table is None else csv_bytes(self.table)
        content = io.BytesIO()
        metadata = {"Date": None} if form == "svg" else {}
        with matplotlib.rc_context({"svg.hashsalt": self.name}):  # equal figures have equal ids
            self.figure.savefig(content, format=form, dpi=DPI, metadata=metadata)
        return content.getvalue()


@own_settings()
def picture(name: str, draw: Callable[..., Axes], table: DataFrame | None = None) -> Picture:
    """Draw axes in a figure of their own, with the title above and the legend below."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    FigureCanvasAgg(figure)
    ax = draw(ax=figure.add_subplot())
    title, note = str(ax.get_label()).split("\n")
    heading = textwrap.fill(title, _TITLE_LETTERS), textwrap.fill(note, _NOTE_LETTERS)
    above = figure.suptitle(heading[0], x=0.012, ha="left", fontsize=12)
    _plain([above, ax.set_title(heading[1], loc="left", fontsize=8.5, color="0.25")])
    _fit(above, [above])
    rows = 0
    if legend := ax.get_legend():
        legend.remove()
        handles, names = ax.get_legend_handles_labels()
        names = [drawable(name) for name in names]
        across = max(1, int(WIDTH_IN / (0.8 + 0.07 * max(map(len, names)))))
        rows = -(-len(names) // across)
        place: dict[str, Any] = {"loc": "outside lower left", "ncols": across}
        below = figure.legend(handles, names, fontsize=8.5, frameon=False, **place)
        _plain(below.get_texts())
        _fit(below, below.get_texts())
    figure.set_size_inches(WIDTH_IN, HEIGHT_IN + _ROW_IN * rows)
    return Picture(name, figure, table)


def _fit(drawn: Artist, texts: Sequence[Text]) -> None:
    """Shrink texts until the artist that holds them is no wider than a figure."""
    size = float(texts[0].get_fontsize())
    while (wide := drawn.get_window_extent().width) > (room := 0.97 * WIDTH_IN * DPI):
        size *= min(0.99, room / wide)  # letters snap to dots, so they shrink only roughly
        for text in texts:
            text.set_fontsize(size)


def _plain(texts: Iterable[Text]) -> None:
    """Show texts letter by letter, without formulas."""
    for text in texts:
        text.set_parse_math(False)
        text.set_text(drawable(text.get_text()))


def drawable(text: str) -> str:
    """Escape letters that the font lacks, so that different texts look different."""
    known = get_font(findfont(FontProperties())).get_charmap()
    escaped = {x: x.encode("unicode_escape").decode("ascii") for x in {*text} - {"\n"}}
    return "".join(escaped[x] if x in escaped and ord(x) not in known else x for x in text)


def csv_bytes(table: DataFrame) -> bytes:
    """Write a table as CSV, numbers with nine digits; a missing value leaves its cell empty."""
    safe = without_formulas(table)
    return str(safe.to_csv(index=False, float_format="%.9g", lineterminator="\n")).encode()


def slug(label: str) -> str:
    """Write a label as part of a file's name."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", label).strip("_")
