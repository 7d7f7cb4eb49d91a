"""Axes of figures with title, note and legend, and their files; equal runs give equal bytes."""

import io
import math
import re
import textwrap
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import matplotlib
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.text import Text
from pandas import DataFrame

from acoustics.arrays import instance
from acoustics.numbers import rounded
from acoustics.plot_style import gridded
from acoustics.texts import printable
from rolling.figures.settings import own_settings
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import Source
from rolling.results import labels
from rolling.results.labels import SEED
from rolling.results.run_result import Run
from rolling.results.runs_table import csv_bytes

DPI = 110
WIDTH_IN = 8.5
HEIGHT_IN = 4.4
POLAR_IN = 5.3  # width of a figure around an axis
MAX_NAMED = 24  # curves; a legend of more takes more room than they do
_NAMED_SCENES = 4  # scenes named in a title; more scenes are counted
_NAMED_VALUES = 4  # of a swept key in a title; more values are a range, or are counted
_ROW_IN = 0.19  # height of a row in a legend
_LETTERS_PER_IN = 12.0  # of a title on axes, in letters of normal size
_FEWEST_LETTERS = 12  # of a line on narrow axes
_NORMAL_PT = 10  # size of the letters of a title
_SMALL_PT = 7  # size of the letters on small axes
_SMALL_IN = 2.4  # shorter side of small axes, as in a grid
_MAX_HIGH = 0.7  # largest height of a legend over that of its axes
_LEFT_BY_LAYOUT = 0.2  # of small axes, whose titles and labels take the rest in a layout
_DENSE: dict[str, Any] = {"labelspacing": 0.15, "borderpad": 0.2, "handlelength": 1.5}
_TITLE_LETTERS = 88  # of a line of the title across a figure
_NOTE_LETTERS = 125  # of a line of the note


# ---- axes


def axes_of(ax: Axes | None, is_polar: bool = False) -> Axes:
    """Return the given axes, or new axes in a figure of their own, which may be polar.

    A figure without a layout engine gets the tight layout, so that nothing overlaps.
    """
    if ax is not None:
        figure = ax.figure
        in_grid = all(axes.get_subplotspec() for axes in figure.axes)
        if isinstance(figure, Figure) and figure.get_layout_engine() is None and in_grid:
            figure.set_layout_engine("tight")
        return ax
    import matplotlib.pyplot as plt

    projection = {"projection": "polar" if is_polar else None}
    try:
        return plt.subplots(layout="constrained", subplot_kw=projection)[1]
    except ImportError as error:  # of a backend that is not installed, or that needs a screen
        warnings.warn(
            "matplotlib cannot show the new figure, because its backend cannot be loaded"
            f" ({error}); `ax.figure.savefig` writes it into a file",
            stacklevel=2,
        )
        figure = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        return figure.add_subplot(**projection)


def listed(runs: Run | Iterable[Run]) -> list[Run]:
    """Return one or several runs as a list; a dictionary gives its values."""
    if isinstance(runs, dict):
        return [*runs.values()]
    if isinstance(runs, Iterable):
        return [*runs]
    return [runs]


def compared(runs: Run | Iterable[Run]) -> list[Run]:
    """Return the runs of a plot as a list; raise TypeError or ValueError if they are none."""
    shown = listed(runs)
    for run in shown:
        instance("runs", run, Run)
    if not shown:
        raise ValueError("runs: got none, allowed: at least one run")
    return shown


class Caption(NamedTuple):
    """Title and note of a figure."""

    title: str
    note: str


class CaptionedFigure(Figure):
    """Figure of a picture, around whose axes `picture` writes the caption and the legend."""

    caption = Caption("", "")


def finish(ax: Axes, title: str, facts: Iterable[str]) -> Axes:
    """Set title, note and legend of axes, and the grid of curves.

    Axes of a grid have small letters, and a legend only where it leaves room for the curves. The
    figure of a picture takes the title and the note itself.
    """
    if not ax.images:
        gridded(ax)
    handles, names = ax.get_legend_handles_labels()
    note = "; ".join(facts)
    if len(names) > MAX_NAMED:
        note += f"; {len(names)} curves"
    caption = Caption(title, note[:1].upper() + note[1:])
    size = _Size.of(ax)
    _fit_labels(ax, size)
    if isinstance(ax.figure, CaptionedFigure):
        ax.figure.caption = caption
        return ax
    _write_title(ax, caption, size)
    if 0 < len(names) <= MAX_NAMED:
        _add_legend(ax, handles, names, size)
    return ax


class _Size(NamedTuple):
    """Letters of a title that the sides of axes have room for, and whether the axes are small."""

    is_small: bool
    letters_across: int
    letters_up: int

    @classmethod
    def of(cls, ax: Axes) -> Self:
        """Measure axes."""
        width_in = ax.bbox.width / ax.figure.dpi
        height_in = ax.bbox.height / ax.figure.dpi
        is_small = min(width_in, height_in) < _SMALL_IN
        letters_per_in = _LETTERS_PER_IN
        if is_small:
            letters_per_in = _LETTERS_PER_IN * _NORMAL_PT / _SMALL_PT
        return cls(
            is_small=is_small,
            letters_across=max(_FEWEST_LETTERS, int(letters_per_in * width_in)),
            letters_up=max(_FEWEST_LETTERS, int(letters_per_in * height_in)),
        )


def _write_title(ax: Axes, caption: Caption, size: _Size) -> None:
    """Write the title above axes, with the note below it where there is room."""
    lines = textwrap.wrap(caption.title, size.letters_across)
    note = textwrap.wrap(caption.note, size.letters_across)
    if not size.is_small and len(lines) + len(note) < size.letters_up / 10:
        lines += note
    font_size: Any = _SMALL_PT if size.is_small else "medium"
    title = ax.set_title("\n".join(lines), loc="left", fontsize=font_size, wrap=True)
    _plain([title])


def _fit_labels(ax: Axes, size: _Size) -> None:
    """Break the labels of axes, of axes that share their place, and of colour bars."""
    ax.set_xlabel(_broken(ax.get_xlabel(), size.letters_across))
    sides = [ax]
    sides += [other for other in ax.figure.axes if other.bbox.bounds == ax.bbox.bounds]
    sides += [image.colorbar.ax for image in ax.images if image.colorbar]
    for side in dict.fromkeys(sides):
        side.set_ylabel(_broken(side.get_ylabel(), size.letters_up))
        if size.is_small:
            side.tick_params(which="both", labelsize=_SMALL_PT)
            side.xaxis.label.set_fontsize(_SMALL_PT)
            side.yaxis.label.set_fontsize(_SMALL_PT)


def _add_legend(ax: Axes, handles: Sequence[Any], names: Sequence[str], size: _Size) -> None:
    """Add a legend where the axes have room for it beside their curves."""
    wrapped = [textwrap.fill(drawable(name), size.letters_across - 6) for name in names]
    if size.is_small:
        legend = ax.legend(handles, wrapped, framealpha=0.6, fontsize=_SMALL_PT - 1, **_DENSE)
    else:
        legend = ax.legend(handles, wrapped, framealpha=0.6, fontsize="small")
    legend.set_in_layout(False)
    _plain(legend.get_texts())
    own = legend.get_window_extent()
    room = _LEFT_BY_LAYOUT if size.is_small else 1.0
    if own.height > _MAX_HIGH * room * ax.bbox.height or own.width > room * ax.bbox.width:
        legend.remove()


def _broken(label: str, letters: int) -> str:
    """Break the label of an axis that is too long between words, but not within its unit."""
    words, sign, unit = label.partition(" [")
    unbroken_unit = unit.replace(" ", "\xa0")
    return textwrap.fill(words + sign + unbroken_unit, letters, break_long_words=False)


def subject(runs: Sequence[Run]) -> str:
    """Name the scenes of runs and what is varied; one run has its title."""
    if len(runs) == 1:
        return runs[0].title
    names = dict.fromkeys(run.scene.name for run in runs)
    scenes = ", ".join(names)
    if len(names) > _NAMED_SCENES:
        scenes = f"{len(names)} scenes"
    return ", ".join([scenes, *varied(runs)])


def varied(runs: Sequence[RunFolder]) -> list[str]:
    """Write the values of the swept keys of runs: load 5 to 100 N, Ra 0.1 µm."""
    texts = []
    for key in dict.fromkeys(name for run in runs for name in run.values):
        values = [*dict.fromkeys(run.values[key] for run in runs if key in run.values)]
        if len(values) > 1:
            texts.append(_values_text(key, values))
        elif key != SEED:
            texts.append(labels.worded(key, values[0]))
    return texts


def _values_text(key: str, values: Sequence[Any]) -> str:
    """Write the values of a swept key with its word and unit, many numbers as a range."""
    word, unit = labels.named(key)
    are_numbers = all(isinstance(value, int | float) for value in values)
    if key == SEED:
        return f"{len(values)} seeds"
    if are_numbers and len(values) > _NAMED_VALUES:
        shown = f"{min(values):g} to {max(values):g}"
    elif len(values) > _NAMED_VALUES:
        shown = f"{len(values)} values"
    else:
        names = [f"{value:g}" if are_numbers else printable(str(value)) for value in values]
        shown = f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{word} {shown} {unit}".strip()


class LevelOf(NamedTuple):
    """The quantity that a level belongs to, and a sentence on what that quantity is."""

    name: str
    meaning: str


HEARD = "what a listener would hear of ball and plate"
RELEASED = LevelOf("released power", "upper bound: all released energy counts as sound (q = 1)")
FIXED_GAIN = LevelOf("release under a fixed gain", "fixed gain: only differences have a meaning")
MIXED = LevelOf("vibration or released power", "each level as its scene has it: not comparable")


def level_of(runs: Sequence[Run], sources: Sequence[Source] | None = None) -> LevelOf:
    """Return what the levels of runs are levels of.

    Parameters
    ----------
    runs : sequence of Run
    sources : sequence of vibration or release
        Sources that are shown of the runs. Default: those of the records that are measured.
    """
    if sources is None:
        sources = [run.sound.source for run in runs]
    quantities = {_level_of_run(*both) for both in zip(runs, sources, strict=True)}
    if len({of.name for of in quantities}) > 1:
        return MIXED
    if len(quantities) > 1:  # vibrations of which some are computed, and others estimated
        return LevelOf("vibration", f"vibration: {HEARD}")
    return quantities.pop()


def _level_of_run(run: Run, source: Source) -> LevelOf:
    """Return what the levels of a run are levels of."""
    if source == "vibration":
        return LevelOf("vibration", f"vibration, {run.numbers.vibration.how}: {HEARD}")
    if run.scene.sound.gain_pa_per_w_m2 is not None:
        return FIXED_GAIN
    q = run.scene.sound.q
    if q != 1:
        return LevelOf(RELEASED.name, f"the share q = {q:g} of the released energy counts as sound")
    return RELEASED


def common(word: str, values: Sequence[float], unit: str = "") -> str:
    """Write the value that all runs share, or its range: at 1 m, at 1 to 2 m."""
    smallest = number(min(values))
    largest = number(max(values))
    span = smallest if smallest == largest else f"{smallest} to {largest}"
    return f"{word} {span} {unit}".rstrip()


def number(value: float) -> str:
    """Write a number with three digits, or with all digits before the decimal point."""
    return f"{value:,.0f}" if value >= 1000 else rounded(value, 3)


def distance_text(runs: Sequence[Run]) -> str:
    """Write the distance of the listener [m]."""
    text = common("listener at", [run.scene.listener_distance_m for run in runs], "m")
    if any(run.scene.is_listener_placed for run in runs):
        text += " from the contact"
    return text


def duration_text(runs: Sequence[Run]) -> str:
    """Write the duration of the records [s]."""
    return common("record of", [run.sound.duration for run in runs], "s")


# ---- files


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure on one pair of axes with its name, its curves as a table, and its caption."""

    name: str
    figure: Figure
    table: DataFrame | None
    caption: Caption | None = None

    @own_settings()
    def file(self, form: str, facts: Mapping[str, str] | None = None) -> bytes | None:
        """Return the picture as the bytes of a png, svg or csv file; a map has no csv.

        Facts are texts by their keywords, which the header of a png keeps.
        """
        if form == "csv":
            return None if self.table is None else csv_bytes(self.table)
        content = io.BytesIO()
        metadata: dict[str, str | None] = {"Date": None} if form == "svg" else {**(facts or {})}
        with matplotlib.rc_context({"svg.hashsalt": self.name}):  # equal figures have equal ids
            self.figure.savefig(content, format=form, dpi=DPI, metadata=metadata)
        return content.getvalue()


@own_settings()
def picture(
    name: str,
    draw: Callable[..., Axes],
    table: DataFrame | None = None,
    is_polar: bool = False,
) -> Picture:
    """Draw axes in a figure of their own, with the title above and the legend below."""
    width_in = POLAR_IN if is_polar else WIDTH_IN
    figure = CaptionedFigure(figsize=(width_in, HEIGHT_IN), dpi=DPI)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    FigureCanvasAgg(figure)
    ax = draw(ax=figure.add_subplot(projection="polar" if is_polar else None))
    share = width_in / WIDTH_IN
    title = textwrap.fill(figure.caption.title, round(share * _TITLE_LETTERS))
    note = textwrap.fill(figure.caption.note, round(share * _NOTE_LETTERS))
    above = figure.suptitle(title, x=0.012, ha="left", fontsize=12)
    below = ax.set_title(note, loc="left", fontsize=8.5, color="0.25")
    _plain([above, below])
    _shrink_to_width(above, [above], width_in)
    rows = _add_legend_below(figure, ax)
    figure.set_size_inches(width_in, HEIGHT_IN + _ROW_IN * rows)
    return Picture(name, figure, table, figure.caption)


def _add_legend_below(figure: Figure, ax: Axes) -> int:
    """Add the legend of axes below the figure, and return the number of its rows."""
    handles, texts = ax.get_legend_handles_labels()
    if not 0 < len(texts) <= MAX_NAMED:
        return 0
    names = [drawable(text) for text in texts]
    longest = max(len(name) for name in names)
    width_in = figure.get_figwidth()
    columns = max(1, int(width_in / (0.8 + 0.07 * longest)))
    place: Any = "outside lower left"
    legend = figure.legend(handles, names, loc=place, ncols=columns, fontsize=8.5, frameon=False)
    _plain(legend.get_texts())
    _shrink_to_width(legend, legend.get_texts(), width_in)
    return math.ceil(len(names) / columns)


def _shrink_to_width(drawn: Artist, texts: Sequence[Text], width_in: float) -> None:
    """Shrink texts until the artist that holds them is no wider than a figure."""
    room = 0.97 * width_in * DPI
    size = float(texts[0].get_fontsize())
    width = drawn.get_window_extent().width
    while width > room:
        size *= min(0.99, room / width)  # letters snap to dots, so they shrink only roughly
        for text in texts:
            text.set_fontsize(size)
        width = drawn.get_window_extent().width


def _plain(texts: Iterable[Text]) -> None:
    """Show texts letter by letter, without formulas."""
    for text in texts:
        text.set_parse_math(False)
        text.set_text(drawable(text.get_text()))


def drawable(text: str) -> str:
    """Escape letters that the font lacks, so that different texts look different."""
    known = get_font(findfont(FontProperties())).get_charmap()
    letters = []
    for letter in text:
        if letter == "\n" or ord(letter) in known:
            letters.append(letter)
        else:
            letters.append(letter.encode("unicode_escape").decode("ascii"))
    return "".join(letters)


def slug(label: str) -> str:
    """Write a label as part of a file's name."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", label.replace("µ", "u")).strip("_")
