"""Pictures of a whole sweep from the numbers of its runs: lines, maps, and mean third octaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator
from numpy.typing import NDArray

from acoustics import plot_style
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ
from rolling._typing import Array
from rolling.figures.picture import (
    BAR_IN,
    BAR_ROOM_IN,
    BOTTOM_IN,
    LEFT_IN,
    MOST_NAMED,
    WIDTH_IN,
    Picture,
    blank,
    lay_out,
    single,
)
from rolling.simulation import labels
from rolling.simulation.seed_statistics import LEVELS, SEED, Group, Statistic

_TALL_IN = 3.5  # height of axes
_MOST_CELLS = 100  # cells of a map whose numbers are written in it
_MOST_CURVES = 100  # more would hide one another, and are drawn as their median and spread


def lines(number: str, key: str, groups: Sequence[Group], subject: str) -> Picture:
    """Draw the mean of a number against a swept key, a line for each combination of other keys.

    Parameters
    ----------
    number : str. A column of runs.csv.
    key : str. A swept key.
    groups : sequence of Group. The runs of the sweep that have the number.
    subject : str. Name of the scene.
    """
    x, ticks = _axis(key, groups)
    curves: dict[str, tuple[Array, Array]] = {}
    for group in groups:
        mean, spread = curves.setdefault(
            _label(group, [key]), (np.full(len(x), np.nan), np.full(len(x), np.nan))
        )
        if (statistic := group.of(number, LEVELS.get(number))) is not None:
            place = ticks.index(group.values[key])
            mean[place], spread[place] = statistic.mean, statistic.deviation or np.nan

    def draw(ax: Axes) -> None:
        if len(curves) > _MOST_CURVES:
            _draw_crowd(ax, x, np.array([mean for mean, _ in curves.values()]))
        else:
            for k, (label, (mean, spread)) in enumerate(curves.items()):
                look = plot_style.look_of(k, len(curves))
                ax.plot(x, mean, markersize=5, label=label or None, **look)
                plot_style.bars(ax, x, mean, spread, look["color"])
        _name_axis(ax, "x", key, x, ticks)
        plot_style.finish(ax, number)

    word = labels.named(key)[0]
    count = len(x)
    columns: dict[str, NDArray[Any]] = {}
    if len(curves) > 1:
        columns["curve"] = np.repeat([*curves], count)
    columns[key] = np.tile(np.array(ticks), len(curves))
    columns[f"{number}_mean"] = np.concatenate([mean for mean, _ in curves.values()])
    columns[f"{number}_standard_deviation"] = np.concatenate([s for _, s in curves.values()])
    name = f"plot_{number}_against_{key}"
    note = _note(groups, "bars", len(curves))
    return single(name, f"{number} against {word}: {subject}", note, columns, draw)


def heat_map(number: str, keys: tuple[str, str], groups: Sequence[Group], subject: str) -> Picture:
    """Draw the mean of a number over two swept keys, averaged over all others.

    Parameters
    ----------
    number, groups, subject : as in `lines`.
    keys : pair of str. Swept keys along x and y.
    """
    (x, x_ticks), (y, y_ticks) = (_axis(key, groups) for key in keys)
    sums, counts = np.zeros((len(y), len(x))), np.zeros((len(y), len(x)))
    for group in groups:
        if (statistic := group.of(number)) is not None:
            place = y_ticks.index(group.values[keys[1]]), x_ticks.index(group.values[keys[0]])
            sums[place] += statistic.mean * statistic.runs
            counts[place] += statistic.runs
    means = np.divide(sums, counts, out=np.full(sums.shape, np.nan), where=counts > 0)
    figure = blank()
    ax, bar = figure.add_subplot(), figure.add_subplot()
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    figure.colorbar(drawn, cax=bar, label=number)
    for axis, key, ticks in (("x", keys[0], x_ticks), ("y", keys[1], y_ticks)):
        _name_axis(ax, axis, key, np.arange(len(ticks), dtype=float), ticks, all_named=True)
    if means.size <= _MOST_CELLS:
        middle = np.nanmean(means) if np.isfinite(means).any() else 0.0
        for (row, column), value in np.ndenumerate(means):
            if np.isfinite(value):
                colour = "black" if value > middle else "white"
                ax.text(column, row, f"{value:.3g}", ha="center", va="center", color=colour)
    width = WIDTH_IN - LEFT_IN - BAR_ROOM_IN
    places = {
        ax: (LEFT_IN, BOTTOM_IN, width, _TALL_IN),
        bar: (LEFT_IN + width + 0.12, BOTTOM_IN, BAR_IN, _TALL_IN),
    }
    words = [labels.named(key)[0] for key in keys]
    title = f"{number} against {words[0]} and {words[1]}: {subject}"
    note = f"{sum(len(group.rows) for group in groups)} runs; mean over all other keys"
    lay_out(figure, title, note, places)
    columns = {
        keys[0]: np.tile(np.array(x_ticks), len(y)),
        keys[1]: np.repeat(np.array(y_ticks), len(x)),
        f"{number}_mean": means.ravel(),
        "runs": counts.ravel(),
    }
    name = f"plot_{number}_against_{keys[0]}_{keys[1]}"
    return Picture(name, f"{title}: {note}", figure, columns)


def mean_third_octaves(groups: Sequence[Group], subject: str) -> Picture:
    """Draw the mean A-weighted third octaves of each group, with their spread over the seeds."""
    curves = {
        _label(group, []): [group.of_band("third_octave_a_db", band) for band in BAND_NAMES]
        for group in groups
    }

    def draw_each(ax: Axes) -> None:
        for k, (label, bands) in enumerate(curves.items()):
            look = plot_style.look_of(k, len(curves))
            mean, spread = _column(bands, "mean"), _column(bands, "deviation")
            ax.plot(MID_HZ, mean, markersize=4, label=label or None, **look)
            if len(curves) <= MOST_NAMED:
                ax.fill_between(
                    MID_HZ, mean - spread, mean + spread, color=look["color"], alpha=0.18, lw=0
                )

    def draw(ax: Axes) -> None:
        if len(curves) > _MOST_CURVES:
            means = [_column(bands, "mean") for bands in curves.values()]
            _draw_crowd(ax, MID_HZ, np.array(means))
        else:
            draw_each(ax)
        ax.set_xscale("log")
        ax.set_xlim(*AUDIBLE_HZ)
        ax.minorticks_off()
        names = [plot_style.short_name(name) for name in BAND_NAMES]
        ax.set_xticks(MID_HZ, names, rotation=90, fontsize="small")
        ax.set_xlabel("third octave, nominal mid frequency [Hz]")
        plot_style.finish(ax, "A-weighted level [dB re 20 µPa]")

    columns: dict[str, NDArray[Any]] = {}
    if len(curves) > 1:
        columns["curve"] = np.repeat([*curves], len(BAND_NAMES))
    columns["mid_frequency_hz"] = np.tile(MID_HZ, len(curves))
    every = [band for bands in curves.values() for band in bands]
    for column, attribute in (
        ("mean_a_weighted_level_db", "mean"),
        ("standard_deviation_db", "deviation"),
        ("standard_error_db", "error"),
        ("stated_uncertainty_db", "stated"),
    ):
        columns[column] = _column(every, attribute)
    title = f"Mean third octaves: {subject}"
    note = _note(groups, "shaded" if len(curves) <= MOST_NAMED else "", len(curves))
    return single("mean_third_octaves", title, note, columns, draw)


def _draw_crowd(ax: Axes, x: Array, curves: Array) -> None:
    """Draw the median of many curves, with the band of 90 % of them and their extremes."""
    known = np.isfinite(curves).any(axis=0)
    shares = np.full((5, len(x)), np.nan)
    shares[:, known] = np.nanpercentile(curves[:, known], (0, 5, 50, 95, 100), axis=0)
    look = plot_style.look_of(0, 1)
    for low, high, alpha in ((0, 4, 0.12), (1, 3, 0.2)):
        ax.fill_between(x, shares[low], shares[high], color=look["color"], alpha=alpha, lw=0)
    ax.plot(x, shares[2], markersize=4, **look)


def _column(statistics: Sequence[Statistic | None], attribute: str) -> Array:
    """Return an attribute of statistics as an array, with NaN where it does not exist."""
    values = [None if each is None else getattr(each, attribute) for each in statistics]
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _axis(key: str, groups: Sequence[Group]) -> tuple[Array, list[Any]]:
    """Return the places and the values of a swept key along an axis; names stand evenly."""
    ticks = list(dict.fromkeys(group.values[key] for group in groups))
    if all(isinstance(value, int | float) for value in ticks):
        ticks = sorted(ticks)
        return np.array(ticks, dtype=float), ticks
    return np.arange(len(ticks), dtype=float), ticks


def _name_axis(
    ax: Axes, axis: str, key: str, x: Array, ticks: Sequence[Any], all_named: bool = False
) -> None:
    """Name an axis by its key, and its ticks where they are names or few."""
    word, unit = labels.named(key)
    getattr(ax, f"set_{axis}label")(f"{word} [{unit}]" if unit else word)
    numeric = all(isinstance(value, int | float) for value in ticks)
    if numeric and not all_named and x.min() > 0.0 and x.max() > 10.0 * x.min():
        getattr(ax, f"set_{axis}scale")("log")
    if not numeric or all_named or len(x) <= 8:
        getattr(ax, f"set_{axis}ticks")(x, [_tick(value) for value in ticks])
        getattr(ax, f"{axis}axis").set_minor_locator(NullLocator())


def _tick(value: Any) -> str:
    return f"{value:g}" if isinstance(value, int | float) else labels.printable(str(value))


def _label(group: Group, without: Sequence[str]) -> str:
    """Write the values of a group except the values of some keys."""
    return _values({k: value for k, value in group.values.items() if k not in without})


def _values(values: Mapping[str, Any]) -> str:
    return ", ".join(labels.worded(key, value) for key, value in values.items())


def _note(groups: Sequence[Group], spread: str, curves: int) -> str:
    """Write how many runs there are, the key of their means, and the meaning of what is shaded.

    Parameters
    ----------
    spread : str. The sign of the standard deviation: bars or shaded; empty where it has none.
    curves : int. Number of curves.
    """
    sizes = sorted({len(group.rows) for group in groups}) or [0]
    text = f"{sum(len(group.rows) for group in groups)} runs"
    if sizes[-1] > 1:
        ends = " to ".join(str(count) for count in dict.fromkeys((sizes[0], sizes[-1])))
        values = groups[0].rows[0].values
        (over,) = [key for key in values if key not in groups[0].values]
        word = "seeds" if over == SEED else f"values of {labels.named(over)[0]}"
        text += f"; mean of {ends} {word}"
        if spread and curves <= _MOST_CURVES:
            text += f"; {spread}: their standard deviation"
    if curves > _MOST_CURVES:
        text += f"; line: median of {curves} curves; shaded: 90 % and all of them"
    return text
