"""Figures of sweeps: numbers against swept keys, as maps, and mean third octaves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import NullLocator

from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ
from acoustics.plots import LINE_STYLES, bars, look_of, short_name
from rolling._typing import Array
from rolling.figures.picture import (
    MOST_NAMED,
    axes_of,
    distance_and_duration,
    finish,
    finish_grid,
    listed,
    picture,
    subject,
)
from rolling.results import labels, runs_table
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.terminal.files import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SEED = runs_table.SEED
FEWEST_SEEDS = 3  # that have a spread worth drawing
_MOST_CURVES = 100  # more would hide one another
_MOST_CELLS = 100  # of a map whose numbers are written in it
_SCENE = "scene"  # column of the scene's name beside the swept keys
_LEVELS = {  # columns of runs.csv with label and column of the standard uncertainty
    "laeq_db": ("LAeq", "laeq_uncertainty_db"),
    "level_db": ("LZeq", "level_uncertainty_db"),
    "vibration_laeq_db": ("LAeq of the vibration", ""),
    "release_laeq_db": ("LAeq of the release", ""),
}
_AREAS = {
    "contact_area_mean_m2": ("contact area", ""),
    "plastic_area_mean_m2": ("plastic area", ""),
}
_BANDS = [f"third_octave_a_db_{name}" for name in BAND_NAMES]


# ---- figures of runs


def levels(runs: Iterable[Run], key: str | None = None, ax: Axes | None = None) -> Axes:
    """Plot LAeq and LZeq of runs against a number of their scenes.

    Runs with dynamics also have the LAeq of the vibration and of the release.

    Parameters
    ----------
    runs : iterable of Run
        Runs to plot, such as the runs of a sweep.
    key : str
        Dotted key of the scene, such as `rolling.load_n`. Default: the first swept key.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, with their standard uncertainty.

    Raises
    ------
    ValueError
        A scene has no number at the key, or the runs have no swept key.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.levels(runs, "rolling.load_n")  # doctest: +SKIP
    """
    shown = listed(runs)
    ax = _against_key(shown, key, _LEVELS, ax)
    ax.set_ylabel("level [dB re 20 µPa]")
    facts = [*distance_and_duration(shown), "bars: standard uncertainty of that duration"]
    return finish(ax, f"Levels against {_x_words(ax)}: {subject(shown)}", facts)


def contact_areas(runs: Iterable[Run], key: str | None = None, ax: Axes | None = None) -> Axes:
    """Plot the mean contact area and plastic area of runs against a number of their scenes.

    Parameters
    ----------
    runs : iterable of Run
        Runs to plot, such as the runs of a sweep.
    key : str
        Dotted key of the scene, such as `rolling.load_n`. Default: the first swept key.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with areas, µm².

    Raises
    ------
    ValueError
        A scene has no number at the key, or the runs have no swept key.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.contact_areas(runs, "rolling.load_n")  # doctest: +SKIP
    """
    shown = listed(runs)
    ax = _against_key(shown, key, _AREAS, ax, 1e12)
    ax.set_ylabel("mean area [µm²]")
    ax.set_ylim(bottom=0.0)
    facts = ["mean over the track", "dashed: plastic area"]
    return finish(ax, f"Contact areas against {_x_words(ax)}: {subject(shown)}", facts)


def mean_third_octaves(runs: Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot the mean A-weighted third octaves of runs that differ in their seed alone.

    Parameters
    ----------
    runs : iterable of Run
        Runs to plot, a curve for each combination of the other swept values.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with mean levels, dB re 20 µPa, in a band of one standard deviation over the seeds.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.mean_third_octaves(runs)  # doctest: +SKIP
    """
    shown = listed(runs)
    return mean_bands(sweep_table(shown), _others(shown, SEED), ax, subject(shown))


def swept_key(runs: Sequence[Run]) -> str | None:
    """Return the first swept key with several numbers if the swept values tell all runs apart."""
    for key in runs[0].values:
        numbers = all(isinstance(run.values.get(key), int | float) for run in runs)
        if numbers and len({run.values[key] for run in runs}) > 1:
            distinct = {(run.scene.name, *run.values.items()) for run in runs}
            return key if len(distinct) == len(runs) else None
    return None


def has_seeds(runs: Sequence[Run]) -> bool:
    """Return whether runs of one scene repeat each of their other swept values over seeds."""
    frame = sweep_table(runs)
    if frame[_SCENE].nunique() > 1 or SEED not in frame:
        return False
    seeds = [group[SEED].nunique() for _, group in _groups(frame, _others(runs, SEED))]
    return bool(min(seeds) >= FEWEST_SEEDS)


def seed_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of third octaves of runs over their seeds [dB]."""
    return mean_band_table(sweep_table(runs), _others(runs, SEED))


def sweep_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return the table of runs with the columns of runs.csv and the names of their scenes."""
    frame = runs_table.runs_table(runs).reset_index()
    return frame.assign(**{_SCENE: [run.scene.name for run in runs]})


def _against_key(
    runs: Sequence[Run],
    key: str | None,
    names: dict[str, tuple[str, str]],
    ax: Axes | None,
    factor: float = 1.0,
) -> Axes:
    """Draw columns of a table of runs, with label and uncertainty, against a key of the scenes."""
    key = key or swept_key(runs)
    if key is None:
        raise ValueError("the runs have no swept key, name one, such as rolling.load_n")
    frame, ax = sweep_table(runs), axes_of(ax)
    frame[key] = [_number(run.scene, key) for run in runs]
    groups = [*_groups(frame.sort_values(key), _others(runs, key))]
    present = [name for name in names if name in frame and frame[name].notna().any()]
    if "vibration_laeq_db" in present and frame["vibration_laeq_db"].equals(frame["laeq_db"]):
        present.remove("vibration_laeq_db")
    for k, (label, group) in enumerate(groups):
        for number, name in enumerate(present):
            word, spread = names[name]
            look = look_of(k, len(groups)) if len(groups) > 1 else look_of(number, len(present))
            look["linestyle"] = LINE_STYLES[number]
            values = factor * group[name].astype(float)
            text = ", ".join(filter(None, [label, word]))
            ax.plot(group[key], values, markersize=5, label=text, **look)
            if spread in frame:
                bars(ax, group[key], values, group[spread].astype(float), look["color"])
    _name_axis(ax, "x", key, sorted(set(frame[key])))
    return finish_grid(ax)


def _others(runs: Sequence[Run], key: str) -> list[str]:
    """Return the swept keys other than one, after the scene's name where scenes differ."""
    keys = dict.fromkeys(name for run in runs for name in run.values if name != key)
    several = len({run.scene.name for run in runs}) > 1
    return [_SCENE, *keys] if several else [*keys]


def _number(scene: Scene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    section, _, last = key.partition(".")
    value: Any = getattr(getattr(scene, section, None), last, None)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{key}: the scene {scene.name} has no number there")
    return float(value)


# ---- figures of tables


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
    pictures = [
        picture("mean_third_octaves", lambda ax: mean_bands(frame, _without(keys, SEED), ax, title))
    ]
    for number in numbers:
        name = f"{number}_against_{'_'.join(against)}"
        if len(against) == 2:
            draw = partial(number_map, frame, number, (against[0], against[1]), title=title)
        else:
            curves = _without(keys, SEED, against[0])
            draw = partial(number_against, frame, number, against[0], curves, title=title)
        pictures.append(picture(name, draw))
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{drawn.name}.png" for drawn in pictures]
    for path, drawn in zip(paths, pictures, strict=True):
        write_bytes(path, drawn.file("png") or b"")
    return paths


def _without(keys: Sequence[str], *left_out: str) -> list[str]:
    return [key for key in keys if key not in left_out]


def number_against(
    frame: pd.DataFrame,
    number: str,
    key: str,
    curves: Sequence[str],
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Plot the mean of a column of runs.csv against a swept key, a line per value of `curves`."""
    ax, groups, ticks = axes_of(ax), [*_groups(frame, curves)], _ticks(frame[key])
    x = _places(ticks)
    for k, (label, group) in enumerate(groups[:_MOST_CURVES]):
        look = look_of(k, len(groups))
        values = group[number].astype(float).groupby(group[key])
        mean, spread = (table.reindex(ticks) for table in (values.mean(), values.std()))
        ax.plot(x, mean, markersize=5, label=label or None, **look)
        bars(ax, x, mean, spread, look["color"])
    _name_axis(ax, "x", key, ticks)
    ax.set_ylabel(number)
    facts = _facts(frame, [key, *curves], "bars", len(groups))
    return finish(finish_grid(ax), f"{number} against {_x_words(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame,
    number: str,
    keys: tuple[str, str],
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Plot the mean of a column of runs.csv over two swept keys, along x and y, as a map."""
    ax, ticks = axes_of(ax), [_ticks(frame[key]) for key in keys]
    values = frame.astype({number: float})
    table = values.pivot_table(number, keys[1], keys[0], "mean", observed=True)
    means = table.reindex(ticks[1], columns=ticks[0]).to_numpy(dtype=float)
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=number)
    for axis, key, places in zip(("x", "y"), keys, ticks, strict=True):
        _name_axis(ax, axis, key, places, numeric=False)
    if means.size <= _MOST_CELLS:
        middle = np.nanmean(means)
        for (row, place), value in np.ndenumerate(means):
            colour = "black" if value > middle else "white"
            text = f"{value:.3g}" if np.isfinite(value) else ""
            ax.text(place, row, text, ha="center", va="center", color=colour)
    words = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{number} against {words}: {title}", facts)


def mean_bands(
    frame: pd.DataFrame, curves: Sequence[str], ax: Axes | None = None, title: str = ""
) -> Axes:
    """Plot the mean A-weighted third octaves of a table, a line per value of `curves`."""
    ax, table = axes_of(ax), mean_band_table(frame, curves)
    groups = [*table.groupby("curve", sort=False)]
    for k, (label, rows) in enumerate(groups[:_MOST_CURVES]):
        look, mean = look_of(k, len(groups)), rows["mean_a_weighted_level_db"]
        spread = rows["standard_deviation_db"]
        ax.plot(MID_HZ, mean, markersize=4, label=label or None, **look)
        if len(groups) <= MOST_NAMED:
            low, high = mean - spread, mean + spread
            ax.fill_between(MID_HZ, low, high, color=look["color"], alpha=0.18, lw=0)
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.minorticks_off()
    ax.set_xticks(MID_HZ, [short_name(name) for name in BAND_NAMES], rotation=90, fontsize="small")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.set_ylabel("A-weighted level [dB re 20 µPa]")
    facts = _facts(frame, curves, "shaded", len(groups))
    return finish(finish_grid(ax), f"Mean third octaves: {title}", facts)


def mean_band_table(frame: pd.DataFrame, curves: Sequence[str]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of A-weighted third octaves by curve [dB]."""
    tables = []
    for label, group in _groups(frame, curves):
        levels_db = group.reindex(columns=_BANDS).astype(float)
        columns = {
            "mean_a_weighted_level_db": levels_db.mean().to_numpy(),
            "standard_deviation_db": levels_db.std().to_numpy(),
        }
        tables.append(pd.DataFrame({"curve": label, "mid_frequency_hz": MID_HZ, **columns}))
    return pd.concat(tables, ignore_index=True)


# ---- parts of figures


def _groups(frame: pd.DataFrame, keys: Sequence[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the rows of equal values of keys, in the order of the table, with their label."""
    if not keys:
        yield "", frame
        return
    for values, group in frame.groupby([*keys], sort=False, dropna=False):
        words = [
            str(value) if key == _SCENE else labels.worded(key, value)
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


def _name_axis(ax: Axes, axis: str, key: str, ticks: Sequence[Any], numeric: bool = True) -> None:
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


def _x_words(ax: Axes) -> str:
    """Return the quantity along x without its unit."""
    return ax.get_xlabel().partition(" [")[0]
