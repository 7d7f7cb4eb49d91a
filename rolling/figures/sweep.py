"""Figures of sweeps and of tables of runs: numbers against swept keys, and means over seeds."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import NullLocator

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ, NOMINAL_HZ
from acoustics.numbers import rounded
from acoustics.plot_style import LINE_STYLES, band_ticks, curve_style, error_bars
from acoustics.texts import printable
from acoustics.traps import ignoring_underflow
from rolling.figures import picture
from rolling.figures.picture import MAX_NAMED, axes_of, compared, finish, subject
from rolling.figures.settings import left_out_if_it_fails
from rolling.results import labels
from rolling.results.labels import SEED
from rolling.results.run_result import Run
from rolling.results.runs_table import runs_table
from rolling.scene.scene import Scene
from rolling.terminal.files import write_bytes


class Quantity(NamedTuple):
    """The label of a column of runs.csv."""

    label: str


class _Words(NamedTuple):
    """The words and the unit of a column of runs.csv, and whether it is one of the source."""

    text: str
    unit: str
    of_source: bool = False


Quantities = Mapping[str, Quantity]  # by their columns of runs.csv
SCENE = "scene"  # column of the scene's name beside the swept keys
FEWEST_SEEDS = 3  # that have a spread worth drawing
AREAS: Quantities = {
    "contact_area_mean_m2": Quantity("contact area"),
    "plastic_area_mean_m2": Quantity("plastic area, at the hardness"),
}
_WIDE_M2 = 1e-8  # area from which on areas are given in mm²
_MAX_CURVES = 100  # more would hide one another
_MAX_TICKS = 8  # of an axis that names all its numbers
_MAX_CELLS = 100  # of a map whose numbers are written in it
_WORDS = {
    "laeq_db": _Words("LAeq", "dB(A)", of_source=True),
    "level_db": _Words("LZeq", "dB", of_source=True),
    "lae_db": _Words("LAE (re 1 s)", "dB(A)", of_source=True),
    "laf_max_db": _Words("LAFmax", "dB(A)", of_source=True),
    "las_max_db": _Words("LASmax", "dB(A)", of_source=True),
    "lz_peak_db": _Words("LZpeak", "dB", of_source=True),
    "vibration_db": _Words("A-weighted level of the vibration", "dB(A)"),
    "released_power_db": _Words("A-weighted level of the released power", "dB(A)"),
    "steady_level_db": _Words("steady level of the released power", "dB re 1 pW/m²"),
    "vibration_laeq_db": _Words("LAeq of the vibration", "dB(A)"),
    "vibration_estimate_laeq_db": _Words("LAeq of the vibration, estimated", "dB(A)"),
    "release_laeq_db": _Words("LAeq of the released power", "dB(A)"),
    "contact_area_mean_m2": _Words("mean contact area", "m²"),
    "plastic_area_mean_m2": _Words("mean plastic area", "m²"),
    "plastic_ratio": _Words("plastic area over Hertz's area", "-"),
    "max_pressure_pa": _Words("maximum pressure", "Pa"),
    "release_power_mean_w": _Words("mean released power", "W"),
    "release_power_rms_w": _Words("rms fluctuation of the released power", "W"),
}
_UNITS = {
    "db": "dB", "hz": "Hz", "j": "J", "kg": "kg", "m": "m", "m2": "m²", "n": "N", "pa": "Pa",
    "s": "s", "um": "µm", "w": "W",
}  # fmt: skip
_BAND_COLUMN = re.compile(r"third_octave_(?P<a>a_)?db_(?P<hz>[\d.]+)")
_BANDS = [f"third_octave_a_db_{name}" for name in BAND_NAMES]


# ---- figures of runs


@ignoring_underflow
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
        Axes with areas, µm² or mm².

    Raises
    ------
    ValueError
        A scene has no number at the key, or the runs have no swept key.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.contact_areas(runs, "rolling.load_n")
    """
    shown = compared(runs)
    key = key or some_swept_key(shown)
    ax = axes_of(ax)
    unit, factor = "µm²", 1e12
    if max(run.summary["contact_area_mean_m2"] for run in shown) >= _WIDE_M2:
        unit, factor = "mm²", 1e6
    _draw_against_key(ax, shown, key, AREAS, factor)
    ax.set(ylabel=f"mean area [{unit}]", ylim=(0.0, None))
    facts = ["mean over the track", "plastic area: nodes at the hardness"]
    if any(SEED in run.values for run in shown):
        facts.append("means over seeds, bars: their standard deviation")
    return finish(ax, f"Contact areas against {x_quantity(ax)}: {subject(shown)}", facts)


@ignoring_underflow
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
    shown = compared(runs)
    return mean_bands(sweep_table(shown), other_keys(shown, SEED), axes_of(ax), subject(shown))


def area_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values and mean areas of runs [m²]."""
    return _swept_table(runs, AREAS)


def swept_key(runs: Sequence[Run]) -> str | None:
    """Return the first swept key with several values if the swept values tell all runs apart.

    A key with numbers comes before a key with names, and the seed is no key.
    """
    distinct = {(run.scene.name, *run.values.items()) for run in runs}
    if len(distinct) != len(runs):
        return None
    names = list[str]()
    for key in runs[0].values:
        values = [run.values.get(key) for run in runs]
        if key == SEED or None in values or len(set(values)) == 1:
            continue
        if not any(isinstance(value, str) for value in values):
            return key
        names.append(key)
    return names[0] if names else None


def some_swept_key(runs: Sequence[Run]) -> str:
    """Return the swept key of runs, or raise ValueError if there is none."""
    key = swept_key(runs)
    if key is None:
        raise ValueError("the runs have no swept key, name one, such as rolling.load_n")
    return key


def has_seeds(runs: Sequence[Run]) -> bool:
    """Return whether runs of one scene repeat each of their other swept values over seeds."""
    frame = sweep_table(runs)
    if frame[SCENE].nunique() > 1 or SEED not in frame:
        return False
    seeds = [group[SEED].nunique() for _, group in groups_of(frame, other_keys(runs, SEED))]
    return bool(min(seeds) >= FEWEST_SEEDS)


def seed_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of third octaves of runs over their seeds [dB]."""
    return mean_band_table(sweep_table(runs), other_keys(runs, SEED))


def _swept_table(runs: Sequence[Run], quantities: Quantities) -> pd.DataFrame:
    """Tabulate swept values and numbers of runs."""
    frame = sweep_table(runs)
    names = ["run", SCENE]
    names += dict.fromkeys(key for run in runs for key in run.values)
    names += quantities
    return frame[[name for name in names if name in frame]]


def sweep_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return the table of runs with the columns of runs.csv and the names of their scenes."""
    return runs_table(runs).reset_index().assign(**{SCENE: [run.scene.name for run in runs]})


def _draw_against_key(
    ax: Axes, runs: Sequence[Run], key: str, quantities: Quantities, factor: float
) -> None:
    """Draw quantities of runs, times a factor, against a key of the scenes.

    The runs of each combination of the other swept values have a curve. Runs that differ in their
    seed have their mean with its standard deviation.
    """
    frame = sweep_table(runs)
    frame[key] = values_at(runs, key)
    places = places_of(frame[key])
    others = [name for name in other_keys(runs, key) if name != SEED]
    groups = [*groups_of(frame, others)]
    columns = [name for name in quantities if name in frame and frame[name].notna().any()]
    for k, (label, group) in enumerate(groups):
        for number, column in enumerate(columns):
            quantity = quantities[column]
            # Colours tell the groups apart, or the quantities of a single group.
            if len(groups) > 1:
                style = curve_style(k, len(groups))
            else:
                style = curve_style(number, len(columns))
            style["linestyle"] = LINE_STYLES[number]
            if are_names(frame[key]):
                style["linestyle"] = "none"
            if number > 0:
                style["markerfacecolor"] = "white"
            name = f"{label}, {quantity.label}" if label else quantity.label
            values = (factor * group[column].astype(float)).groupby(group[key])
            mean = values.mean().reindex([*places])
            deviation = values.std().reindex([*places])
            x = np.array([*places.values()])
            ax.plot(x, mean, markersize=6, label=name, **style)
            error_bars(ax, x, mean, deviation, style["color"], label=f"_{name}")
    label_values(ax, key, places)


def are_names(values: pd.Series) -> bool:
    """Tell whether the values of a key are names, between which nothing lies."""
    return any(isinstance(value, str) for value in values)


def values_at(runs: Sequence[Run], key: str) -> list[Any]:
    """Return the numbers of runs at a dotted key, or the names under which it is swept."""
    names = [run.values.get(key) for run in runs]
    if all(isinstance(name, str) for name in names):
        return names
    return [_number_at(run.scene, key) for run in runs]


def other_keys(runs: Sequence[Run], key: str) -> list[str]:
    """Return the swept keys other than one, after the scene's name where scenes differ."""
    keys = dict.fromkeys(name for run in runs for name in run.values if name != key)
    if len({run.scene.name for run in runs}) > 1:
        return [SCENE, *keys]
    return [*keys]


def _number_at(scene: Scene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    value = labels.value_at(scene, key)
    if key == "rolling.load_n":  # which may be the weight, a number too
        value = scene.load
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
    swept = [key for key in frame if key.partition(".")[0] in Scene.model_fields and key != SEED]
    draw: Callable[..., Axes]
    draw = partial(mean_bands, frame, swept, title=title)
    contents = dict[Path, bytes]()
    _draw_into(contents, folder, "mean_third_octaves", draw)
    for number in numbers:
        if len(against) == 2:
            draw = partial(number_map, frame, number, (against[0], against[1]), title=title)
        else:
            curves = [key for key in swept if key != against[0]]
            draw = partial(number_against, frame, number, against[0], curves, title=title)
        _draw_into(contents, folder, f"{number}_against_{'_'.join(against)}", draw)
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
    groups = [*groups_of(frame, curves)]
    places = places_of(frame[key])
    x = np.array([*places.values()])
    for k, (label, group) in enumerate(groups[:_MAX_CURVES]):
        style = curve_style(k, len(groups))
        if are_names(frame[key]):
            style["linestyle"] = "none"
        values = group[number].astype(float).groupby(group[key])
        mean = values.mean().reindex([*places])
        deviation = values.std().reindex([*places])
        ax.plot(x, mean, markersize=5, label=label or None, **style)
        error_bars(ax, x, mean, deviation, style["color"])
    label_values(ax, key, places)
    quantity = _quantity_of(number, frame)
    ax.set_ylabel(quantity)
    facts = _facts_of_means(frame, [key, *curves], "bars", len(groups))
    return finish(ax, f"{_capital(quantity)} against {x_quantity(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame, number: str, keys: tuple[str, str], ax: Axes, title: str
) -> Axes:
    """Plot the mean of a column of runs.csv over two swept keys, along x and y, as a map."""
    values_x, values_y = ([*places_of(frame[key])] for key in keys)
    frame = frame.astype({number: float})
    table = frame.pivot_table(number, keys[1], keys[0], "mean", observed=True)
    means = table.reindex(values_y, columns=values_x).to_numpy(dtype=float)
    image = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    quantity = _quantity_of(number, frame)
    ax.figure.colorbar(image, ax=ax, label=quantity)
    ax.set_xlabel(_label_of(keys[0]))
    ax.set_ylabel(_label_of(keys[1]))
    _name_ticks(ax.xaxis, {value: place for place, value in enumerate(values_x)})
    _name_ticks(ax.yaxis, {value: place for place, value in enumerate(values_y)})
    if means.size <= _MAX_CELLS:
        _write_numbers(ax, means)
    quantities = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{_capital(quantity)} against {quantities}: {title}", facts)


def _quantity_of(number: str, frame: pd.DataFrame) -> str:
    """Return the words of a column of runs.csv with its unit; a level says what it belongs to."""
    band = _BAND_COLUMN.fullmatch(number)
    if band is not None:
        weighting = "A-weighted " if band["a"] else ""
        return f"{weighting}third octave at {band['hz']} Hz{_of_source(frame)} [dB]"
    if number in _WORDS:
        words = _WORDS[number]
        of = _of_source(frame) if words.of_source else ""
        return f"{words.text}{of} [{words.unit}]"
    word, _, ending = number.rpartition("_")
    if ending in _UNITS:
        return f"{word.replace('_', ' ')} [{_UNITS[ending]}]"
    return number.replace("_", " ")


def _of_source(frame: pd.DataFrame) -> str:
    """Say what the levels of a table are levels of."""
    sources = {*frame["source"].dropna()} if "source" in frame else set()
    if sources == {"vibration"}:
        return " of the vibration"
    if sources == {"release"}:
        gain = frame["q"].isna().all() if "q" in frame else True
        return " of the release under a fixed gain" if gain else " of the released power"
    return ""


def _capital(quantity: str) -> str:
    """Return a quantity without its unit, with a capital."""
    words = quantity.partition(" [")[0]
    return words[:1].upper() + words[1:]


def _write_numbers(ax: Axes, means: Array) -> None:
    """Write the numbers of a map into its cells, in black on bright cells."""
    middle = np.nanmean(means)
    for (row, column), value in np.ndenumerate(means):
        if np.isfinite(value):
            colour = "black" if value > middle else "white"
            text = rounded(value, 3)
            ax.text(column, row, text, ha="center", va="center", color=colour)


def mean_bands(frame: pd.DataFrame, curves: Sequence[str], ax: Axes, title: str) -> Axes:
    """Plot the mean A-weighted third octaves of a table, a line per value of `curves`."""
    table = mean_band_table(frame, curves)
    # Values that are equal in print have curves of one name.
    groups = [rows for _, rows in table.groupby(np.arange(len(table)) // len(MID_HZ))]
    for k, rows in enumerate(groups[:_MAX_CURVES]):
        style = curve_style(k, len(groups))
        label = rows["curve"].iloc[0]
        mean = rows["mean_a_weighted_level_db"]
        deviation = rows["standard_deviation_db"]
        ax.plot(MID_HZ, mean, markersize=4, label=label or None, **style)
        if len(groups) <= MAX_NAMED:
            ax.fill_between(
                MID_HZ, mean - deviation, mean + deviation, color=style["color"], alpha=0.18, lw=0
            )
    ax.set(xscale="log", xlim=AUDIBLE_HZ)
    ax.set_ylabel(f"A-weighted level{_of_source(frame)} [dB re 20 µPa]")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.minorticks_off()
    band_ticks(ax)
    facts = _facts_of_means(frame, curves, "shaded", len(groups))
    return finish(ax, f"Mean third octaves{_of_source(frame)}: {title}", facts)


def mean_band_table(frame: pd.DataFrame, curves: Sequence[str]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of A-weighted third octaves by curve [dB]."""
    tables = []
    for label, group in groups_of(frame, curves):
        levels_db = group.reindex(columns=_BANDS).astype(float)
        columns = {
            "curve": label,
            "band_hz": NOMINAL_HZ,
            "mid_frequency_hz": MID_HZ,
            "mean_a_weighted_level_db": levels_db.mean().to_numpy(),
            "standard_deviation_db": levels_db.std().to_numpy(),
        }
        tables.append(pd.DataFrame(columns))
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


def _facts_of_means(
    frame: pd.DataFrame, keys: Sequence[str], spread: str, curves: int
) -> list[str]:
    """Write how many runs a figure of means has, and the meaning of bars or bands."""
    facts = [f"{len(frame)} runs"]
    fewest = most = len(frame)
    if keys:
        sizes = frame.groupby([*keys]).size()
        fewest = sizes.min()
        most = sizes.max()
    if most > 1:
        count = f"{most}" if fewest == most else f"{fewest} to {most}"
        facts.append(f"mean of {count} runs")
        facts.append(f"{spread}: their standard deviation")
    if curves > _MAX_CURVES:
        facts.append(f"first {_MAX_CURVES} of {curves} curves")
    return facts


def places_of(values: pd.Series) -> dict[Any, float]:
    """Return the values of a swept key with their places along an axis; names stand evenly."""
    distinct = [*dict.fromkeys(values)]
    if all(isinstance(value, int | float | np.number) for value in distinct):
        return {value: float(value) for value in sorted(distinct)}
    return {name: float(place) for place, name in enumerate(distinct)}


def label_values(ax: Axes, key: str, places: dict[Any, float]) -> None:
    """Label the x axis by a swept key; values that are few, or that are names, have ticks."""
    ax.set_xlabel(_label_of(key))
    first = min(places.values())
    last = max(places.values())
    if first > 0.0 and last > 10.0 * first:
        ax.set_xscale("log")
    has_names = any(isinstance(value, str) for value in places)
    if has_names:
        ax.set_xlim(first - 0.5, last + 0.5)
    if has_names or len(places) <= _MAX_TICKS:
        _name_ticks(ax.xaxis, places)


def _label_of(key: str) -> str:
    """Return the label of an axis for a swept key, with its unit."""
    word, unit = labels.named(key)
    return f"{word} [{unit}]" if unit else word


def _name_ticks(axis: Axis, places: dict[Any, float]) -> None:
    """Name the ticks of an axis by values at their places."""
    names = [printable(value) if isinstance(value, str) else f"{value:g}" for value in places]
    axis.set_ticks([*places.values()], names)
    axis.set_minor_locator(NullLocator())


def x_quantity(ax: Axes) -> str:
    """Return the quantity along x without its unit."""
    return ax.get_xlabel().partition(" [")[0]
