"""Figures of tables of runs: columns of runs.csv against swept keys, and mean third octaves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import NullLocator

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ
from acoustics.numbers import rounded
from acoustics.plot_style import band_ticks, bars, look_of
from rolling.figures.picture import MOST_NAMED, axes_of, finish, finish_grid, picture
from rolling.results import labels
from rolling.results.runs_table import SEED
from rolling.scene.scene import Scene
from rolling.terminal.files import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SCENE = "scene"  # column of the scene's name beside the swept keys
_MOST_CURVES = 100  # more would hide one another
_MOST_CELLS = 100  # of a map whose numbers are written in it
_BANDS = [f"third_octave_a_db_{name}" for name in BAND_NAMES]


def write_number_figures(
    frame: pd.DataFrame,
    numbers: Sequence[str],
    against: Sequence[str],
    folder: Path,
    title: str = "",
) -> list[Path]:
    """Write figures of columns of runs.csv against one or over two swept keys, and of mean bands.

    `frame` holds the columns of runs.csv, and the paths of the PNG files are returned.
    """
    keys = [key for key in frame if key.partition(".")[0] in Scene.model_fields]
    others = [key for key in keys if key != SEED]
    pictures = [picture("mean_third_octaves", lambda ax: mean_bands(frame, others, ax, title))]
    for number in numbers:
        name = f"{number}_against_{'_'.join(against)}"
        if len(against) == 2:
            draw = partial(number_map, frame, number, (against[0], against[1]), title=title)
        else:
            curves = [key for key in others if key != against[0]]
            draw = partial(number_against, frame, number, against[0], curves, title=title)
        pictures.append(picture(name, draw))
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{drawn.name}.png" for drawn in pictures]
    for path, drawn in zip(paths, pictures, strict=True):
        write_bytes(path, drawn.file("png") or b"")
    return paths


def number_against(
    frame: pd.DataFrame,
    number: str,
    key: str,
    curves: Sequence[str],
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Plot the mean of a column of runs.csv against a swept key, a line per value of `curves`."""
    ax, groups, ticks = axes_of(ax), [*groups_of(frame, curves)], _ticks(frame[key])
    x = _places(ticks)
    for k, (label, group) in enumerate(groups[:_MOST_CURVES]):
        look = look_of(k, len(groups))
        values = group[number].astype(float).groupby(group[key])
        mean, spread = (table.reindex(ticks) for table in (values.mean(), values.std()))
        ax.plot(x, mean, markersize=5, label=label or None, **look)
        bars(ax, x, mean, spread, look["color"])
    name_axis(ax, "x", key, ticks)
    ax.set_ylabel(number)
    facts = _facts(frame, [key, *curves], "bars", len(groups))
    return finish(finish_grid(ax), f"{number} against {x_words(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame, number: str, keys: tuple[str, str], ax: Axes | None = None, title: str = ""
) -> Axes:
    """Plot the mean of a column of runs.csv over two swept keys, along x and y, as a map."""
    ax, ticks = axes_of(ax), [_ticks(frame[key]) for key in keys]
    values = frame.astype({number: float})
    table = values.pivot_table(number, keys[1], keys[0], "mean", observed=True)
    means = table.reindex(ticks[1], columns=ticks[0]).to_numpy(dtype=float)
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=number)
    for axis, key, places in zip(("x", "y"), keys, ticks, strict=True):
        name_axis(ax, axis, key, places, numeric=False)
    if means.size <= _MOST_CELLS:
        middle = np.nanmean(means)
        for (row, place), value in np.ndenumerate(means):
            colour = "black" if value > middle else "white"
            text = rounded(value, 3) if np.isfinite(value) else ""
            ax.text(place, row, text, ha="center", va="center", color=colour)
    words = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{number} against {words}: {title}", facts)


def mean_bands(
    frame: pd.DataFrame, curves: Sequence[str], ax: Axes | None = None, title: str = ""
) -> Axes:
    """Plot the mean A-weighted third octaves of a table, a line per value of `curves`."""
    ax, table = axes_of(ax), mean_band_table(frame, curves)
    # Values that are equal in print have curves of one name.
    groups = [rows for _, rows in table.groupby(np.arange(len(table)) // len(MID_HZ))]
    for k, rows in enumerate(groups[:_MOST_CURVES]):
        look, mean = look_of(k, len(groups)), rows["mean_a_weighted_level_db"]
        label = rows["curve"].iloc[0]
        spread = rows["standard_deviation_db"]
        ax.plot(MID_HZ, mean, markersize=4, label=label or None, **look)
        if len(groups) <= MOST_NAMED:
            low, high = mean - spread, mean + spread
            ax.fill_between(MID_HZ, low, high, color=look["color"], alpha=0.18, lw=0)
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.minorticks_off()
    band_ticks(ax)
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.set_ylabel("A-weighted level [dB re 20 µPa]")
    facts = _facts(frame, curves, "shaded", len(groups))
    return finish(finish_grid(ax), f"Mean third octaves: {title}", facts)


def mean_band_table(frame: pd.DataFrame, curves: Sequence[str]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of A-weighted third octaves by curve [dB]."""
    tables = []
    for label, group in groups_of(frame, curves):
        levels_db = group.reindex(columns=_BANDS).astype(float)
        columns = {
            "mean_a_weighted_level_db": levels_db.mean().to_numpy(),
            "standard_deviation_db": levels_db.std().to_numpy(),
        }
        tables.append(pd.DataFrame({"curve": label, "mid_frequency_hz": MID_HZ, **columns}))
    return pd.concat(tables, ignore_index=True)


# ---- parts of figures


def groups_of(frame: pd.DataFrame, keys: Sequence[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the rows of equal values of keys, in the order of the table, with their label."""
    if not keys:
        yield "", frame
        return
    for values, group in frame.groupby([*keys], sort=False, dropna=False):
        words = [
            str(value) if key == SCENE else labels.worded(key, value)
            for key, value in zip(keys, values, strict=True)
            if pd.notna(value)
        ]
        yield ", ".join(words), group


def _facts(frame: pd.DataFrame, keys: Sequence[str], spread: str, curves: int) -> list[str]:
    """Write how many runs a figure of means has, and the meaning of bars or bands."""
    facts = [f"{len(frame)} runs"]
    sizes = frame.groupby([*keys]).size() if keys else pd.Series([len(frame)])
    if sizes.max() > 1:
        ends = " to ".join(str(count) for count in dict.fromkeys((sizes.min(), sizes.max())))
        facts += [f"mean of {ends} runs", f"{spread}: their standard deviation"]
    if curves > _MOST_CURVES:
        facts.append(f"first {_MOST_CURVES} of {curves} curves")
    return facts


def _ticks(values: pd.Series) -> list[Any]:
    """Return the different values of a swept key, numbers in ascending order."""
    ticks = [*dict.fromkeys(values)]
    return sorted(ticks) if _are_numbers(ticks) else ticks


def _are_numbers(ticks: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float | np.number) for value in ticks)


def _places(ticks: Sequence[Any]) -> Array:
    """Return the places of values along an axis; names stand evenly."""
    return np.array(ticks if _are_numbers(ticks) else range(len(ticks)), dtype=float)


def name_axis(ax: Axes, axis: str, key: str, ticks: Sequence[Any], numeric: bool = True) -> None:
    """Name an axis by its key, and its ticks where they are names or few."""
    word, unit = labels.named(key)
    numeric = numeric and _are_numbers(ticks)
    places = _places(ticks) if numeric else np.arange(len(ticks), dtype=float)
    getattr(ax, f"set_{axis}label")(f"{word} [{unit}]" if unit else word)
    if numeric and places[0] > 0.0 and places[-1] > 10.0 * places[0]:
        getattr(ax, f"set_{axis}scale")("log")
    if not numeric or len(ticks) <= 8:
        names = [labels.printable(v) if isinstance(v, str) else f"{v:g}" for v in ticks]
        getattr(ax, f"set_{axis}ticks")(places, names)
        getattr(ax, f"{axis}axis").set_minor_locator(NullLocator())


def x_words(ax: Axes) -> str:
    """Return the quantity along x without its unit."""
    return ax.get_xlabel().partition(" [")[0]
