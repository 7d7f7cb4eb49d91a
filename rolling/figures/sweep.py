"""Figures of sweeps and of tables of runs: numbers against swept keys, and means over seeds."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ
from acoustics.numbers import rounded
from acoustics.plot_style import LINE_STYLES, band_ticks, bars, look_of
from acoustics.texts import printable
from rolling.figures import picture
from rolling.figures.picture import MAX_NAMED, axes_of, finish, listed, subject
from rolling.figures.settings import left_out_if_it_fails
from rolling.results import labels
from rolling.results.run_result import Run
from rolling.results.runs_table import SEED, runs_table
from rolling.scene.scene import Scene
from rolling.terminal.files import write_bytes

Numbers = Mapping[str, tuple[str, str]]  # columns of runs.csv with label and uncertainty
SCENE = "scene"  # column of the scene's name beside the swept keys
FEWEST_SEEDS = 3  # that have a spread worth drawing
EVENT_LEVELS: Numbers = {
    "lae_db": ("LAE (re 1 s)", "lae_uncertainty_db"),
    "laf_max_db": ("LAFmax", "laf_max_uncertainty_db"),
}
LEVELS: Numbers = {
    "laeq_db": ("LAeq", "laeq_uncertainty_db"),
    "level_db": ("LZeq", "level_uncertainty_db"),
    "vibration_laeq_db": ("LAeq of the vibration", ""),
    "release_laeq_db": ("level of the release, A", ""),
}
AREAS: Numbers = {
    "contact_area_mean_m2": ("contact area", ""),
    "plastic_area_mean_m2": ("plastic area", ""),
}
_MAX_CURVES = 100  # more would hide one another
_MAX_CELLS = 100  # of a map whose numbers are written in it
_BANDS = [f"third_octave_a_db_{name}" for name in BAND_NAMES]


# ---- figures of runs


def levels(runs: Iterable[Run], key: str | None = None, ax: Axes | None = None) -> Axes:
    """Plot LAeq and LZeq of runs against a number of their scenes, or LAE and LAFmax of events.

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
    >>> ax = rolling.plot.levels(runs, "rolling.load_n")
    """
    shown = listed(runs)
    names = level_columns(shown)
    released = {run.sound.source for run in shown} == {"release"}
    if released and names == EVENT_LEVELS:
        names["lae_db"] = "LAE (re 1 s) of the released power", "lae_uncertainty_db"
        names["laf_max_db"] = "LAFmax of the released power", "laf_max_uncertainty_db"
    elif released:
        names["laeq_db"] = "released power, A", "laeq_uncertainty_db"
        names["level_db"] = "released power, Z", "level_uncertainty_db"
    ax = _against_key(shown, key, names, ax)
    ax.set_ylabel("level [dB re 20 µPa]")
    facts = [*picture.distance_and_duration(shown), "bars: standard uncertainty of that duration"]
    return finish(ax, f"Levels against {x_words(ax)}: {subject(shown)}", facts)


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
    >>> ax = rolling.plot.contact_areas(runs, "rolling.load_n")
    """
    shown = listed(runs)
    ax = _against_key(shown, key, AREAS, ax, 1e12)
    ax.set(ylabel="mean area [µm²]", ylim=(0.0, None))
    facts = ["mean over the track", "dashed: plastic area"]
    return finish(ax, f"Contact areas against {x_words(ax)}: {subject(shown)}", facts)


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
    >>> ax = rolling.plot.mean_third_octaves(runs)
    """
    shown = listed(runs)
    return mean_bands(sweep_table(shown), _others(shown, SEED), axes_of(ax), subject(shown))


def level_columns(runs: Sequence[Run]) -> dict[str, tuple[str, str]]:
    """Return the levels that a sweep is compared by: LAE and LAFmax if all runs are events."""
    events = [run.summary.get("single_event") for run in runs if run.summary["laeq_db"] is not None]
    return dict(EVENT_LEVELS if events and all(events) else LEVELS)


def level_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values and levels of runs with their standard uncertainty."""
    return swept_table(runs, level_columns(runs))


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
    if frame[SCENE].nunique() > 1 or SEED not in frame:
        return False
    seeds = [group[SEED].nunique() for _, group in groups_of(frame, _others(runs, SEED))]
    return bool(min(seeds) >= FEWEST_SEEDS)


def seed_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of third octaves of runs over their seeds [dB]."""
    return mean_band_table(sweep_table(runs), _others(runs, SEED))


def swept_table(runs: Sequence[Run], names: Numbers) -> pd.DataFrame:
    """Tabulate swept values and numbers of runs with their standard uncertainty."""
    frame, keys = sweep_table(runs), dict.fromkeys(key for run in runs for key in run.values)
    columns = [column for name, (_, spread) in names.items() for column in (name, spread)]
    return frame[[name for name in ("run", SCENE, *keys, *columns) if name in frame]]


def sweep_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return the table of runs with the columns of runs.csv and the names of their scenes."""
    return runs_table(runs).reset_index().assign(**{SCENE: [run.scene.name for run in runs]})


def _against_key(
    runs: Sequence[Run], key: str | None, names: Numbers, ax: Axes | None, factor: float = 1.0
) -> Axes:
    """Draw columns of a table of runs, with label and uncertainty, against a key of the scenes."""
    key = key or swept_key(runs)
    if key is None:
        raise ValueError("the runs have no swept key, name one, such as rolling.load_n")
    frame, ax = sweep_table(runs), axes_of(ax)
    frame[key] = [_number(run.scene, key) for run in runs]
    groups = [*groups_of(frame.sort_values(key), _others(runs, key))]
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
    _name_axis(ax, "x", key, _ticks(frame[key]))
    return ax


def _others(runs: Sequence[Run], key: str) -> list[str]:
    """Return the swept keys other than one, after the scene's name where scenes differ."""
    keys = dict.fromkeys(name for run in runs for name in run.values if name != key)
    several = len({run.scene.name for run in runs}) > 1
    return [SCENE, *keys] if several else [*keys]


def _number(scene: Scene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    # The weight is a number, too.
    value = scene.load if key == "rolling.load_n" else labels.value_at(scene, key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{key}: the scene {scene.name} has no number there")
    return float(value)


# ---- figures of tables of runs


def write_number_figures(
    frame: pd.DataFrame, numbers: Sequence[str], against: Sequence[str], folder: Path, title: str
) -> list[Path]:
    """Write figures of columns of runs.csv against one or over two swept keys, and of mean bands.

    `frame` holds the columns of runs.csv, and the paths of the PNG files are returned.
    """
    keys = [key for key in frame if key.partition(".")[0] in Scene.model_fields]
    others = [key for key in keys if key != SEED]
    draw = partial(mean_bands, frame, others, title=title)
    contents = dict[Path, bytes]()
    _draw_into(contents, folder, "mean_third_octaves", draw)
    for number in numbers:
        name = f"{number}_against_{'_'.join(against)}"
        if len(against) == 2:
            draw = partial(number_map, frame, number, (against[0], against[1]), title=title)
        else:
            curves = [key for key in others if key != against[0]]
            draw = partial(number_against, frame, number, against[0], curves, title=title)
        _draw_into(contents, folder, name, draw)
    folder.mkdir(parents=True, exist_ok=True)
    for path, content in contents.items():
        write_bytes(path, content)
    return [*contents]


def _draw_into(
    contents: dict[Path, bytes], folder: Path, name: str, draw: Callable[..., Axes]
) -> None:
    """Add the PNG of a picture to contents of files by path, unless it cannot be drawn."""
    with left_out_if_it_fails(name):
        content = picture.picture(name, draw).file("png")
        assert content is not None
        contents[folder / f"{name}.png"] = content


def number_against(
    frame: pd.DataFrame, number: str, key: str, curves: Sequence[str], ax: Axes, title: str
) -> Axes:
    """Plot the mean of a column of runs.csv against a swept key, a line per value of `curves`."""
    groups, ticks = [*groups_of(frame, curves)], _ticks(frame[key])
    x = np.array([*ticks.values()])
    for k, (label, group) in enumerate(groups[:_MAX_CURVES]):
        look = look_of(k, len(groups))
        values = group[number].astype(float).groupby(group[key])
        mean, spread = (table.reindex([*ticks]) for table in (values.mean(), values.std()))
        ax.plot(x, mean, markersize=5, label=label or None, **look)
        bars(ax, x, mean, spread, look["color"])
    _name_axis(ax, "x", key, ticks)
    ax.set_ylabel(number)
    facts = _facts(frame, [key, *curves], "bars", len(groups))
    return finish(ax, f"{number} against {x_words(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame, number: str, keys: tuple[str, str], ax: Axes, title: str
) -> Axes:
    """Plot the mean of a column of runs.csv over two swept keys, along x and y, as a map."""
    ticks = [_ticks(frame[key]) for key in keys]
    values = frame.astype({number: float})
    table = values.pivot_table(number, keys[1], keys[0], "mean", observed=True)
    means = table.reindex([*ticks[1]], columns=[*ticks[0]]).to_numpy(dtype=float)
    drawn = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    ax.figure.colorbar(drawn, ax=ax, label=number)
    for axis, key, places in zip(("x", "y"), keys, ticks, strict=True):
        _name_axis(ax, axis, key, {value: place for place, value in enumerate(places)}, True)
    if means.size <= _MAX_CELLS:
        middle = np.nanmean(means)
        for (row, place), value in np.ndenumerate(means):
            colour = "black" if value > middle else "white"
            text = rounded(value, 3) if np.isfinite(value) else ""
            ax.text(place, row, text, ha="center", va="center", color=colour)
    words = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{number} against {words}: {title}", facts)


def mean_bands(frame: pd.DataFrame, curves: Sequence[str], ax: Axes, title: str) -> Axes:
    """Plot the mean A-weighted third octaves of a table, a line per value of `curves`."""
    table = mean_band_table(frame, curves)
    # Values that are equal in print have curves of one name.
    groups = [rows for _, rows in table.groupby(np.arange(len(table)) // len(MID_HZ))]
    for k, rows in enumerate(groups[:_MAX_CURVES]):
        look, mean = look_of(k, len(groups)), rows["mean_a_weighted_level_db"]
        label = rows["curve"].iloc[0]
        spread = rows["standard_deviation_db"]
        ax.plot(MID_HZ, mean, markersize=4, label=label or None, **look)
        if len(groups) <= MAX_NAMED:
            low, high = mean - spread, mean + spread
            ax.fill_between(MID_HZ, low, high, color=look["color"], alpha=0.18, lw=0)
    ax.set(xscale="log", xlim=AUDIBLE_HZ, ylabel="A-weighted level [dB re 20 µPa]")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.minorticks_off()
    band_ticks(ax)
    facts = _facts(frame, curves, "shaded", len(groups))
    return finish(ax, f"Mean third octaves: {title}", facts)


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
    if curves > _MAX_CURVES:
        facts.append(f"first {_MAX_CURVES} of {curves} curves")
    return facts


def _ticks(values: pd.Series) -> dict[Any, float]:
    """Return the values of a swept key with their places along an axis; names stand evenly."""
    ticks = [*dict.fromkeys(values)]
    if all(isinstance(value, int | float | np.number) for value in ticks):
        return {value: float(value) for value in sorted(ticks)}
    return {name: float(place) for place, name in enumerate(ticks)}


def _name_axis(ax: Axes, axis: str, key: str, ticks: dict[Any, float], named: bool = False) -> None:
    """Name an axis by its key, and its ticks where they are names, few, or all to be named."""
    word, unit = labels.named(key)
    names = [printable(v) if isinstance(v, str) else f"{v:g}" for v in ticks]
    places = [*ticks.values()]
    getattr(ax, f"set_{axis}label")(f"{word} [{unit}]" if unit else word)
    if places[0] > 0.0 and places[-1] > 10.0 * places[0]:
        getattr(ax, f"set_{axis}scale")("log")
    if named or len(ticks) <= 8 or any(isinstance(value, str) for value in ticks):
        getattr(ax, f"set_{axis}ticks")(places, names)
        getattr(ax, f"{axis}axis").set_minor_locator(NullLocator())


def x_words(ax: Axes) -> str:
    """Return the quantity along x without its unit."""
    return ax.get_xlabel().partition(" [")[0]
