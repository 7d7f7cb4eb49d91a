"""Figures of sweeps: numbers against swept keys, as maps, and mean third octaves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.ticker import NullLocator

from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ
from acoustics.plots import bars, look_of, short_name
from rolling._typing import Array
from rolling.figures.picture import (
    MOST_NAMED,
    axes_of,
    distance_and_duration,
    finish,
    listed,
    subject,
)
from rolling.figures.sound import SEED, column
from rolling.scene.scene import Scene
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult as Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST_SEEDS = 3  # that have a spread worth drawing
_MOST_CURVES = 100  # more would hide one another, and are drawn as their median and spread
_MOST_CELLS = 100  # of a map whose numbers are written in it
_SCENE = "scene"  # column of the scene's name beside the swept keys


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
    names = {
        "laeq_db": ("LAeq", "laeq_uncertainty_db"),
        "level_db": ("LZeq", "level_uncertainty_db"),
        "vibration_laeq_db": ("LAeq of the vibration", ""),
        "release_laeq_db": ("LAeq of the release", ""),
    }
    ax = _numbers_against(shown, key, names, ax)
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
    names = {"contact_area_um2": ("contact area", ""), "plastic_area_um2": ("plastic area", "")}
    ax = _numbers_against(shown, key, names, ax)
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
    rows = [
        {**run.values, "band_hz": band, "third_octave_a_db": level}
        for run in shown
        for band, level in run.sound.levels.third_octave_a_db.items()
    ]
    return mean_bands(pd.DataFrame(rows), _others(shown, SEED), ax, subject(shown))


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


def sweep_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate scene, swept values, levels [dB] and mean areas [µm²] of runs."""
    rows = []
    for run in runs:
        numbers = {
            "laeq_db": run.sound.levels.laeq_db,
            "laeq_uncertainty_db": run.sound.uncertainty.laeq_db,
            "level_db": run.sound.levels.level_db,
            "level_uncertainty_db": run.sound.uncertainty.level_db,
            "vibration_laeq_db": run.summary.get("vibration_laeq_db"),
            "release_laeq_db": run.summary.get("release_laeq_db"),
            "contact_area_um2": 1e12 * run.summary["contact_area_mean_m2"],
            "plastic_area_um2": 1e12 * run.summary["plastic_area_mean_m2"],
        }
        rows.append({"run": run.label, _SCENE: run.scene.name, **run.values, **numbers})
    return pd.DataFrame(rows).dropna(axis="columns", how="all")


def _numbers_against(
    runs: Sequence[Run], key: str | None, names: Mapping[str, tuple[str, str]], ax: Axes | None
) -> Axes:
    """Draw numbers of runs, with label and column of uncertainty, against a key of their scenes."""
    key = key or swept_key(runs)
    if key is None:
        raise ValueError("the runs have no swept key, name one, such as rolling.load_n")
    frame = sweep_table(runs)
    frame[key] = [_number(run.scene, key) for run in runs]
    ax, curves = axes_of(ax), _others(runs, key)
    present = [name for name in names if name in frame]
    groups = [*_groups(frame, curves)]
    for k, (label, group) in enumerate(groups):
        for style, name in zip(("-", "--", "-.", ":"), present, strict=False):
            word, spread = names[name]
            count = len(groups) if len(groups) > 1 else len(present)
            look = look_of(k if len(groups) > 1 else present.index(name), count)
            rows = group.sort_values(key)
            text = ", ".join(filter(None, [label, word]))
            ax.plot(rows[key], rows[name], markersize=5, label=text, **look | {"linestyle": style})
            if spread in frame:
                bars(ax, rows[key], rows[name], rows[spread], look["color"])
    _name_axis(ax, "x", key, sorted(set(frame[key])))
    ax.grid(True, color="0.85", linewidth=0.5)
    return ax


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


def number_against(
    frame: pd.DataFrame,
    number: str,
    key: str,
    curves: Sequence[str] = (),
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Plot the mean of a column of runs.csv against a swept key, a line per value of `curves`."""
    ax, groups = axes_of(ax), [*_groups(frame, curves)]
    ticks = _ticks(frame[key])
    places = dict(zip(ticks, _places(ticks), strict=True))
    statistics = [
        (label, group.groupby(key)[number].agg(["mean", "std"]).reindex(ticks))
        for label, group in groups
    ]
    x = np.array([*places.values()])
    if len(groups) > _MOST_CURVES:
        _draw_crowd(ax, x, np.array([table["mean"] for _, table in statistics]))
    else:
        for k, (label, table) in enumerate(statistics):
            look = look_of(k, len(groups))
            ax.plot(x, table["mean"], markersize=5, label=label or None, **look)
            bars(ax, x, table["mean"], table["std"], look["color"])
    _name_axis(ax, "x", key, ticks)
    ax.set_ylabel(number)
    ax.grid(True, color="0.85", linewidth=0.5)
    facts = _facts(frame, [key, *curves], "bars", len(groups))
    return finish(ax, f"{number} against {_x_words(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame,
    number: str,
    keys: tuple[str, str],
    ax: Axes | None = None,
    title: str = "",
) -> Axes:
    """Plot the mean of a column of runs.csv over two swept keys, along x and y, as a map."""
    ax, ticks = axes_of(ax), [_ticks(frame[key]) for key in keys]
    table = frame.pivot_table(number, keys[1], keys[0], "mean").reindex(ticks[1], columns=ticks[0])
    means = table.to_numpy(dtype=float)
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=number)
    for axis, key, values in zip(("x", "y"), keys, ticks, strict=True):
        _name_axis(ax, axis, key, values, numeric=False)
    if means.size <= _MOST_CELLS:
        middle = np.nanmean(means) if np.isfinite(means).any() else 0.0
        for (row, place), value in np.ndenumerate(means):
            colour = "black" if value > middle else "white"
            text = f"{value:.3g}" if np.isfinite(value) else ""
            ax.text(place, row, text, ha="center", va="center", color=colour)
    words = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{number} against {words}: {title}", facts)


def mean_bands(
    bands: pd.DataFrame, curves: Sequence[str] = (), ax: Axes | None = None, title: str = ""
) -> Axes:
    """Plot mean A-weighted third octaves of a table with a row per run and `band_hz`."""
    ax, names = axes_of(ax), [float(name) for name in BAND_NAMES]
    bands = bands.assign(band_hz=bands["band_hz"].astype(float))
    statistics = [
        (label, group.groupby("band_hz")["third_octave_a_db"].agg(["mean", "std"]).reindex(names))
        for label, group in _groups(bands, curves)
    ]
    if len(statistics) > _MOST_CURVES:
        _draw_crowd(ax, MID_HZ, np.array([table["mean"] for _, table in statistics]))
    else:
        for k, (label, table) in enumerate(statistics):
            look, mean, spread = look_of(k, len(statistics)), table["mean"], table["std"]
            ax.plot(MID_HZ, mean, markersize=4, label=label or None, **look)
            if len(statistics) <= MOST_NAMED:
                low, high = mean - spread, mean + spread
                ax.fill_between(MID_HZ, low, high, color=look["color"], alpha=0.18, lw=0)
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.minorticks_off()
    ax.set_xticks(MID_HZ, [short_name(name) for name in BAND_NAMES], rotation=90, fontsize="small")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.set_ylabel("A-weighted level [dB re 20 µPa]")
    ax.grid(True, color="0.85", linewidth=0.5)
    runs = bands[bands["band_hz"] == names[0]]
    facts = _facts(runs, curves, "shaded", len(statistics))
    return finish(ax, f"Mean third octaves: {title}", facts)


def mean_band_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of A-weighted third octaves over the seeds [dB]."""
    frames = []
    for label, group in _groups(sweep_table(runs), _others(runs, SEED)):
        levels_db = [column(runs[k].sound.levels.third_octave_a_db) for k in group.index]
        table = pd.DataFrame(np.array(levels_db)).agg(["mean", "std"]).T.to_numpy().T
        columns = {"mean_a_weighted_level_db": table[0], "standard_deviation_db": table[1]}
        frames.append(pd.DataFrame({"curve": label, "mid_frequency_hz": MID_HZ, **columns}))
    return pd.concat(frames, ignore_index=True)


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
            if value == value
        ]
        yield ", ".join(words), group


def _draw_crowd(ax: Axes, x: Array, curves: Array) -> None:
    """Draw the median of many curves, with the band of 90 % of them and their extremes."""
    known = np.isfinite(curves).any(axis=0)
    shares = np.full((5, len(x)), np.nan)
    shares[:, known] = np.nanpercentile(curves[:, known], (0, 5, 50, 95, 100), axis=0)
    look = look_of(0, 1)
    for low, high, alpha in ((0, 4, 0.12), (1, 3, 0.2)):
        ax.fill_between(x, shares[low], shares[high], color=look["color"], alpha=alpha, lw=0)
    ax.plot(x, shares[2], markersize=4, **look)


def _facts(frame: pd.DataFrame, keys: Sequence[str], spread: str, curves: int) -> list[str]:
    """Write how many runs a figure of means has, and the meaning of bars or bands."""
    facts = [f"{len(frame)} runs"]
    sizes = frame.groupby([*keys]).size() if keys else pd.Series([len(frame)])
    if sizes.max() > 1:
        ends = " to ".join(str(count) for count in dict.fromkeys((sizes.min(), sizes.max())))
        facts.append(f"mean of {ends} runs")
        if curves <= _MOST_CURVES:
            facts.append(f"{spread}: their standard deviation")
    if curves > _MOST_CURVES:
        facts.append(f"line: median of {curves} curves; shaded: 90 % and all of them")
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
