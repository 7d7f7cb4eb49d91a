"""Figures of sweeps and of tables of runs: numbers against swept keys, and means over seeds."""

import math
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
from rolling.figures import picture
from rolling.figures.picture import MAX_NAMED, axes_of, compared, finish, subject
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.run_folder import RunFolder
from rolling.numbers import views
from rolling.results import labels
from rolling.results.labels import SEED
from rolling.results.run_result import Run
from rolling.results.stored_numbers import numbers_of
from rolling.scene.swept import SweptScene
from rolling.terminal.whole_files import write_bytes

SCENE = "scene"  # column of the scene's name beside the swept keys
FEWEST_SEEDS = 3  # that have a spread worth drawing
AREAS = {  # labels of the areas by their columns
    "contact_area_mean_m2": "contact area",
    "contact_plastic_area_mean_m2": "plastic area, at the hardness",
}
_WIDE_M2 = 1e-8  # area from which on areas are given in mm²
_MAX_CURVES = 100  # more would hide one another
_MAX_TICKS = 8  # of an axis that names all its numbers
_MAX_CELLS = 100  # of a map whose numbers are written in it


# ---- figures of runs


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
    if max(run.numbers.contact.area_mean_m2 for run in shown) >= _WIDE_M2:
        unit, factor = "mm²", 1e6
    _draw_areas(ax, shown, key, factor)
    ax.set(ylabel=f"mean area [{unit}]", ylim=(0.0, None))
    facts = ["mean over the track", "plastic area: nodes at the hardness"]
    if any(SEED in run.values for run in shown):
        facts.append("means over seeds, bars: their standard deviation")
    return finish(ax, f"Contact areas against {x_quantity(ax)}: {subject(shown)}", facts)


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
    return mean_bands(shown, other_keys(shown, SEED), axes_of(ax), subject(shown))


def area_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values and mean areas of runs [m²]."""
    contacts = [run.numbers.contact for run in runs]
    return sweep_table(runs).assign(
        contact_area_mean_m2=[contact.area_mean_m2 for contact in contacts],
        contact_plastic_area_mean_m2=[contact.plastic_area_mean_m2 for contact in contacts],
    )


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
    return mean_band_table(runs, other_keys(runs, SEED))


def sweep_table(runs: Sequence[RunFolder]) -> pd.DataFrame:
    """Tabulate labels, names of the scenes and swept values of runs, one row per run."""
    keys = dict.fromkeys(key for run in runs for key in run.values)
    rows = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        row: dict[str, Any] = {"run": label, SCENE: run.scene.name}
        row |= {key: run.values.get(key) for key in keys}
        rows.append(row)
    return pd.DataFrame(rows).convert_dtypes()


def _draw_areas(ax: Axes, runs: Sequence[Run], key: str, factor: float) -> None:
    """Draw the mean areas of runs, times a factor, against a key of the scenes.

    The runs of each combination of the other swept values have a curve. Runs that differ in their
    seed have their mean with its standard deviation.
    """
    frame = area_table(runs)
    frame[key] = values_at(runs, key)
    places = places_of(frame[key])
    others = [name for name in other_keys(runs, key) if name != SEED]
    groups = [*groups_of(frame, others)]
    for k, (label, group) in enumerate(groups):
        for number, (column, area) in enumerate(AREAS.items()):
            # Colours tell the groups apart, or the areas of a single group.
            if len(groups) > 1:
                style = curve_style(k, len(groups))
            else:
                style = curve_style(number, len(AREAS))
            style["linestyle"] = LINE_STYLES[number]
            if are_names(frame[key]):
                style["linestyle"] = "none"
            if number > 0:
                style["markerfacecolor"] = "white"
            name = f"{label}, {area}" if label else area
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


def other_keys(runs: Sequence[RunFolder], key: str) -> list[str]:
    """Return the swept keys other than one, after the scene's name where scenes differ."""
    keys = dict.fromkeys(name for run in runs for name in run.values if name != key)
    if len({run.scene.name for run in runs}) > 1:
        return [SCENE, *keys]
    return [*keys]


def _number_at(scene: SweptScene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    value = labels.value_at(scene, key)
    if key == "rolling.load_n":  # which may be the weight, a number too
        value = getattr(scene, "load", value)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{key}: the scene {scene.name} has no number there")
    return float(value)


# ---- figures of tables of runs


def write_number_figures(
    runs: Sequence[RunFolder], numbers: Sequence[str], against: Sequence[str], folder: Path
) -> list[Path]:
    """Write figures of numbers of a sweep against one or over two swept keys, and of mean bands.

    Parameters
    ----------
    runs : sequence of RunFolder. Runs that have numbers.
    numbers : sequence of str. Columns of `runs_table`.
    against : sequence of str. One swept key for lines, or two for a map.
    folder : Path. Folder of the files.

    Returns
    -------
    list of Path. The PNG files.
    """
    title = runs[0].scene.name
    frame = sweep_table(runs)
    swept = [key for key in runs[0].values if key != SEED]
    draw: Callable[..., Axes]
    contents = dict[Path, bytes]()
    if any(_a_weighted_bands(run) for run in runs):
        draw = partial(mean_bands, runs, swept, title=title)
        _draw_into(contents, folder, "mean_third_octaves", draw)
    for column in numbers:
        number = number_of(runs, column)
        if len(against) == 2:
            draw = partial(number_map, frame, number, (against[0], against[1]), title=title)
        else:
            curves = [key for key in swept if key != against[0]]
            draw = partial(number_against, frame, number, against[0], curves, title=title)
        _draw_into(contents, folder, f"{column}_against_{'_'.join(against)}", draw)
    folder.mkdir(parents=True, exist_ok=True)
    for path, content in contents.items():
        write_bytes(path, content)
    return [*contents]


class NumberOfRuns(NamedTuple):
    """A number of each run in the unit that people read, its uncertainty, and its name with unit.

    NaN stands for what a run does not have.
    """

    head: str
    values: list[float]
    uncertainties: list[float]

    @property
    def name(self) -> str:
        """Its name without unit, with a capital."""
        words = self.head.partition(" [")[0]
        return words[:1].upper() + words[1:]


def number_of(runs: Sequence[RunFolder], column: str) -> NumberOfRuns:
    """Return a number of runs by its column in `runs_table`, with its standard uncertainty."""
    values = []
    uncertainties = []
    head = column
    for run in runs:
        numbers = numbers_of(run)
        cells = {} if numbers is None else views.columns(numbers)
        cell = cells.get(column)
        if numbers is None or cell is None or cell.value is None:
            values.append(math.nan)
            uncertainties.append(math.nan)
            continue
        spread = cells.get(views.spread_columns(numbers).get(column, ""))
        of_value = None if spread is None else spread.value
        head = cell.head
        values.append(cell.number_field.factor * float(cell.value))
        uncertainties.append(math.nan if of_value is None else float(of_value))
    return NumberOfRuns(head, values, uncertainties)


def _draw_into(
    contents: dict[Path, bytes], folder: Path, name: str, draw: Callable[..., Axes]
) -> None:
    """Add the PNG of a picture to contents of files by path, unless it cannot be drawn."""
    with left_out_if_it_fails(name):
        content = picture.picture(name, draw).file("png")
        assert content is not None
        contents[folder / f"{name}.png"] = content


def number_against(
    frame: pd.DataFrame,
    number: NumberOfRuns,
    key: str,
    curves: Sequence[str],
    ax: Axes,
    title: str,
) -> Axes:
    """Plot a number of runs against a swept key, a line per value of `curves`.

    Runs of equal values have their mean with its standard deviation, a single one its uncertainty.
    """
    frame = frame.assign(number=number.values, uncertainty=number.uncertainties)
    is_single = frame.groupby([key, *curves], dropna=False).size().max() == 1
    groups = [*groups_of(frame, curves)]
    places = places_of(frame[key])
    x = np.array([*places.values()])
    for k, (label, group) in enumerate(groups[:_MAX_CURVES]):
        style = curve_style(k, len(groups))
        if are_names(frame[key]):
            style["linestyle"] = "none"
        values = group["number"].groupby(group[key])
        mean = values.mean().reindex([*places])
        deviation = values.std().reindex([*places])
        if is_single:
            deviation = group.set_index(key)["uncertainty"].reindex([*places])
        ax.plot(x, mean, markersize=5, label=label or None, **style)
        error_bars(ax, x, mean, deviation, style["color"])
    label_values(ax, key, places)
    ax.set_ylabel(number.head)
    facts = _facts_of_means(frame, [key, *curves], "bars", len(groups))
    if is_single and frame["uncertainty"].notna().any():
        facts.append("bars: ± standard uncertainty")
    return finish(ax, f"{number.name} against {x_quantity(ax)}: {title}", facts)


def number_map(
    frame: pd.DataFrame, number: NumberOfRuns, keys: tuple[str, str], ax: Axes, title: str
) -> Axes:
    """Plot the mean of a number of runs over two swept keys, along x and y, as a map."""
    frame = frame.assign(number=number.values)
    values_x, values_y = ([*places_of(frame[key])] for key in keys)
    table = frame.pivot_table("number", keys[1], keys[0], "mean", observed=True)
    means = table.reindex(values_y, columns=values_x).to_numpy(dtype=float)
    image = ax.imshow(means, origin="lower", aspect="auto", cmap="viridis")
    ax.figure.colorbar(image, ax=ax, label=number.head)
    ax.set_xlabel(_label_of(keys[0]))
    ax.set_ylabel(_label_of(keys[1]))
    _name_ticks(ax.xaxis, {value: place for place, value in enumerate(values_x)})
    _name_ticks(ax.yaxis, {value: place for place, value in enumerate(values_y)})
    if means.size <= _MAX_CELLS:
        _write_numbers(ax, means)
    quantities = " and ".join(labels.named(key)[0] for key in keys)
    facts = [f"{len(frame)} runs", "mean over all other keys"]
    return finish(ax, f"{number.name} against {quantities}: {title}", facts)


def _of_source(runs: Sequence[RunFolder]) -> str:
    """Say what the third octaves of runs are levels of; nothing where runs differ."""
    sources = set[str]()
    for numbers in filter(None, map(numbers_of, runs)):
        if numbers.source_of_bands == "vibration":
            sources.add(" of the vibration")
        elif numbers.record.q is None:
            sources.add(" of the release under a fixed gain")
        else:
            sources.add(" of the released power")
    return sources.pop() if len(sources) == 1 else ""


def _write_numbers(ax: Axes, means: Array) -> None:
    """Write the numbers of a map into its cells, in black on bright cells."""
    middle = np.nanmean(means)
    for (row, column), value in np.ndenumerate(means):
        if np.isfinite(value):
            colour = "black" if value > middle else "white"
            text = rounded(value, 3)
            ax.text(column, row, text, ha="center", va="center", color=colour)


def mean_bands(runs: Sequence[RunFolder], curves: Sequence[str], ax: Axes, title: str) -> Axes:
    """Plot the mean A-weighted third octaves of runs, a line per value of `curves`."""
    table = mean_band_table(runs, curves)
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
    of = _of_source(runs)
    ax.set_ylabel(f"A-weighted level{of} [dB re 20 µPa]")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    ax.minorticks_off()
    band_ticks(ax)
    facts = _facts_of_means(sweep_table(runs), curves, "shaded", len(groups))
    return finish(ax, f"Mean third octaves{of}: {title}", facts)


def mean_band_table(runs: Sequence[RunFolder], curves: Sequence[str]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of A-weighted third octaves by curve [dB]."""
    bands = pd.DataFrame([_a_weighted_bands(run) for run in runs], columns=BAND_NAMES, dtype=float)
    tables = []
    for label, group in groups_of(sweep_table(runs), curves):
        levels_db = bands.loc[group.index]
        columns = {
            "curve": label,
            "band_hz": NOMINAL_HZ,
            "mid_frequency_hz": MID_HZ,
            "mean_a_weighted_level_db": levels_db.mean().to_numpy(),
            "standard_deviation_db": levels_db.std().to_numpy(),
        }
        tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


def _a_weighted_bands(run: RunFolder) -> Mapping[str, float | None]:
    """Return the A-weighted third octaves of the sound of a run by their names [dB(A)]."""
    bands = getattr(numbers_of(run), "leading_bands_a", None)  # a kind need not have any
    return {} if bands is None else bands.by_name


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
    """Return the label of an axis for a swept key, with its unit.

    A key whose values need no word, as 900 rpm, has its own name.
    """
    word, unit = labels.named(key)
    word = word or key.rpartition(".")[2].removesuffix(f"_{unit}").replace("_", " ")
    return f"{word} [{unit}]" if unit and unit != word else word


def _name_ticks(axis: Axis, places: dict[Any, float]) -> None:
    """Name the ticks of an axis by values at their places."""
    names = [printable(value) if isinstance(value, str) else f"{value:g}" for value in places]
    axis.set_ticks([*places.values()], names)
    axis.set_minor_locator(NullLocator())


def x_quantity(ax: Axes) -> str:
    """Return the quantity along x without its unit."""
    return ax.get_xlabel().partition(" [")[0]
