"""Pictures of advice: what would help, how coarse a value may be, and which waves to lower."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from acoustics.plot_style import COLOURS, gridded
from acoustics.texts import printable
from rolling.figures.picture import DPI, HEIGHT_IN, WIDTH_IN, axes_of, drawable
from rolling.figures.settings import own_settings
from rolling.results import labels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rolling.choice.design import Design
    from rolling.choice.limit import Limit
    from rolling.choice.sensitivity import Sensitivities

LOUDER = COLOURS[1]
QUIETER = COLOURS[0]
_ROW_IN = 0.34  # height of a bar
LEAST_AMPLITUDE = 1e-4  # of the largest, below which a band is not drawn
_TICKS = 10  # on an axis of values
_FRAME_IN = 1.6  # height of a figure beside its bars


def plot_sensitivities(result: Sensitivities, ax: Axes | None = None) -> Axes:
    """Draw changes of a level as bars, with their ± and the linear chain beside them."""
    ax = axes_of(ax)
    rows = result.rows
    places = np.arange(len(rows))
    values = np.array([row.db for row in rows])
    errors = np.array([row.uncertainty_db or 0.0 for row in rows])
    colours = [LOUDER if value > 0 else QUIETER for value in values]
    ax.barh(places, values, height=0.6, color=colours, alpha=0.75, label="computed, with its ±")
    ax.errorbar(values, places, xerr=errors, fmt="none", ecolor="black", capsize=3)
    known = []
    of_chain = []
    of_chain_errors = []
    for number, row in enumerate(rows):
        if row.chain_db is not None:
            known.append(number)
            of_chain.append(row.chain_db)
            of_chain_errors.append(row.chain_uncertainty_db or 0.0)
    if known:
        ax.errorbar(
            of_chain,
            known,
            xerr=of_chain_errors,
            fmt="D",
            color="black",
            markerfacecolor="white",
            markersize=6,
            capsize=2,
            label="linear chain",
        )
    ax.axvline(0, color="black", linewidth=0.8)
    names = [drawable(f"{row.change.name}, +{row.change.step}") for row in rows]
    ax.set_yticks(places, names)
    ax.invert_yaxis()
    gridded(ax)
    subject = "what a listener would hear"
    if not result.quantity.is_level:
        subject = f"the {result.quantity.drawn} from {result.quantity.words}"
    ax.set_xlabel(f"change of {subject}, {result.quantity.decibels}; left is quieter")
    ax.set_title(
        drawable(printable(f"{result.name}: how much louder with a larger value")),
        loc="left",
        fontsize="medium",
        parse_math=False,
    )
    if known:
        ax.legend(fontsize="small", framealpha=0.6)
    return ax


def sensitivities_picture(result: Sensitivities) -> bytes:
    """Return the picture of changes of a level as PNG."""
    height = _FRAME_IN + _ROW_IN * len(result.rows)
    return _png(lambda ax: plot_sensitivities(result, ax), height)


def plot_limit(result: Limit, ax: Axes | None = None) -> Axes:
    """Draw the path of a search: levels of specimens and tolerance limits over the value."""
    ax = axes_of(ax)
    ordered = result.ordered
    unit = result.quantity.level_unit
    if not result.rises:
        ordered = ordered[::-1]
    has_names = isinstance(ordered[0].value, str)
    places = {}
    for number, point in enumerate(ordered):
        places[point.value] = float(number) if has_names else float(point.value)
    for number, point in enumerate(ordered):
        ax.plot(
            [places[point.value]] * len(point.levels_db),
            point.levels_db,
            linestyle="none",
            marker="o",
            markersize=3,
            alpha=0.45,
            color=QUIETER,
            label="_nolegend_" if number else f"single {result.noun}",
        )
    x = [places[point.value] for point in ordered]
    upper = [point.upper_db for point in ordered]
    ax.plot(x, upper, "-", marker="v", color=LOUDER, label="95 % lie below, 95 % confidence")
    for number, point in enumerate(result.points, start=1):
        ax.annotate(
            str(number),
            (places[point.value], point.upper_db),
            textcoords="offset points",
            xytext=(0, 7 + 9 * (number % 3)),
            ha="center",
            fontsize="small",
        )
    ax.margins(y=0.14)  # room for the numbers of the steps
    ax.axhline(
        result.level_db, color="black", linestyle="--", label=f"limit {result.level_db:g} {unit}"
    )
    if result.value is not None:
        ax.axvline(
            places[result.value],
            color=COLOURS[2],
            label=drawable(printable(f"answer: {labels.worded(result.key, result.value)}")),
        )
    gridded(ax)
    name, key_unit = labels.named(result.key)
    if has_names:
        ax.set_xticks(x, [drawable(str(point.value)) for point in ordered])
    else:
        ax.set_xscale("log")
        ticks = _few([float(point.value) for point in ordered])
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel(f"{name} [{key_unit}]" if key_unit else name)
    subject = "what a listener would hear"
    if not result.quantity.is_level:
        subject = f"{result.quantity.drawn}, {result.quantity.words}"
    ax.set_ylabel(f"{subject} [{unit}]")
    title = f"{result.name}: the search for {result.level_db:g} {unit}, its steps numbered"
    ax.set_title(
        drawable(printable(title)),
        loc="left",
        fontsize="medium",
        parse_math=False,
    )
    ax.legend(fontsize="small", framealpha=0.6)
    return ax


def limit_picture(result: Limit) -> bytes:
    """Return the picture of a search as PNG."""
    return _png(lambda ax: plot_limit(result, ax), HEIGHT_IN)


def plot_design(result: Design, ax: Axes | None = None) -> Axes:
    """Draw the amplitudes of bands of waves as they are and as they are aimed at."""
    ax = axes_of(ax)
    table = result.target()
    shown = table[table["amplitude_now_nm"] > LEAST_AMPLITUDE * table["amplitude_now_nm"].max()]
    wavelength = shown["wavelength_um"].to_numpy()
    now = shown["amplitude_now_nm"].to_numpy()
    wanted = shown["amplitude_target_nm"].to_numpy()
    ax.plot(wavelength, now, "-", marker="o", color=LOUDER, label="now")
    ax.plot(wavelength, wanted, "-", marker="v", color=QUIETER, label="target")
    ax.fill_between(wavelength, wanted, now, color=QUIETER, alpha=0.15)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ticks = _few(sorted(wavelength.tolist()))
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.xaxis.set_minor_locator(NullLocator())
    gridded(ax)
    ax.set_xlabel("wavelength along the track [um]")
    ax.set_ylabel("rms of a profile in third octaves [nm]")
    assert result.fall.db is not None  # a surface without any sound is no answer
    title = f"{result.name}: lower waves for {result.fall.db:.2f} {result.quantity.decibels} less"
    ax.set_title(drawable(printable(title)), loc="left", fontsize="medium", parse_math=False)
    ax.legend(fontsize="small", framealpha=0.6)
    return ax


def design_picture(result: Design) -> bytes:
    """Return the picture of a design as PNG."""
    return _png(lambda ax: plot_design(result, ax), HEIGHT_IN)


def _few(values: list[float]) -> list[float]:
    """Return values that have room side by side on a logarithmic axis."""
    least_ratio = (values[-1] / values[0]) ** (1 / _TICKS)
    kept = [values[0]]
    for value in values[1:]:
        if value >= kept[-1] * least_ratio:
            kept.append(value)
    return kept


@own_settings()
def _png(draw: Callable[[Axes], object], height_in: float) -> bytes:
    """Draw axes in a figure of their own and return it as PNG."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    draw(figure.add_subplot())
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=DPI)
    return content.getvalue()
