"""The levels of a sweep: vibration and released power of its runs against a swept key."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, MaxNLocator

from acoustics.plot_style import curve_style, error_bars
from rolling.figures import picture, sweep_figures
from rolling.figures.picture import axes_of, compared, finish, subject
from rolling.results.labels import SEED
from rolling.results.run_quantities import LAE, heard_levels
from rolling.results.run_result import Run

_LEAST_SPAN_DB = 4.0  # of the levels of a quantity, so that equal levels look equal
_ROOM = 0.15  # of the span of the levels, above and below them


class _Quantity(NamedTuple):
    """A quantity of a sweep: column, name, column of its uncertainty, and mark and line."""

    column: str
    name: str
    uncertainty: str
    linestyle: Any = "-"
    is_hollow: bool = False


_VIBRATION = _Quantity("vibration_db", "vibration", "vibration_uncertainty_db")
_RELEASED = _Quantity(
    "released_power_db",
    "released power",
    "released_power_uncertainty_db",
    linestyle="--",
    is_hollow=True,
)
_FAST_MAXIMUM = _Quantity(
    "laf_max_db", "LAFmax", "laf_max_uncertainty_db", linestyle=":", is_hollow=True
)


def levels(runs: Iterable[Run], key: str | None = None, ax: Axes | None = None) -> Axes:
    """Plot the vibration and the released power of runs against a swept key or another number.

    Where both are known, the vibration has the left axis and the lower half, and the released power
    the right axis and the upper half, with as many decibels in each. Runs that differ in their
    seed have their mean with its standard deviation. Names have marks only, numbers lines too.

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
        Axes with A-weighted levels, dB(A), with their standard uncertainty: LAeq, or LAE (re 1 s)
        and LAFmax of single events.

    Raises
    ------
    ValueError
        A scene has no number at the key, or the runs have no swept key.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.levels(runs, "rolling.load_n")
    """
    shown = compared(runs)
    key = key or sweep_figures.some_swept_key(shown)
    ax = axes_of(ax)
    frame = level_table(shown)
    frame[key] = sweep_figures.values_at(shown, key)
    others = [name for name in sweep_figures.other_keys(shown, key) if name != SEED]
    seeds = _seeds_per_point(frame, [key, *others])
    if seeds > 1:
        frame = _means_over_seeds(frame, [*others, key])
    left = _known(frame, [_VIBRATION, _FAST_MAXIMUM])
    right = _known(frame, [_RELEASED])
    name = _level_name(shown)
    places = sweep_figures.places_of(frame[key])
    groups = [*sweep_figures.groups_of(_sorted(frame, key), others)]
    for k, (label, group) in enumerate(groups):
        for quantity in left or right:
            _draw(ax, ax, group, places, key, quantity, label, k, len(groups))
    if left and right:
        other = ax.twinx()
        for k, (label, group) in enumerate(groups):
            _draw(ax, other, group, places, key, _RELEASED, label, k, len(groups))
        _stand_one_above_the_other(ax, other, frame)
        other.set_ylabel(f"{name} of the released power [dB(A)]")
    own = picture.level_of(shown).name
    if right and own not in (_VIBRATION.name, picture.MIXED.name):
        release_name = own
    else:
        release_name = _RELEASED.name
    ax.set_ylabel(f"{name} of the {_VIBRATION.name if left else release_name} [dB(A)]")
    sweep_figures.label_values(ax, key, places)
    facts = _facts(shown, bool(left), bool(right), seeds)
    quantities = []
    if left:
        quantities.append(_VIBRATION.name)
    if right:
        quantities.append(release_name)
    title = f"{' and '.join(quantities)} against {sweep_figures.x_quantity(ax)}"
    return finish(ax, f"{title[:1].upper()}{title[1:]}: {subject(shown)}", facts)


def level_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values, vibration and released power of runs [dB] with uncertainties."""
    rows = []
    for run in runs:
        vibration = run.vibration
        released = run.released_power
        row: dict[str, Any] = {"run": run.label, sweep_figures.SCENE: run.scene.name}
        row |= run.values
        row |= {
            "measure": vibration.measure,
            "vibration_how": vibration.how,
            "vibration_db": vibration.value,
            "vibration_uncertainty_db": vibration.uncertainty,
            "vibration_verdict": vibration.verdict,
            "released_power_how": released.how,
            "released_power_db": released.value,
            "released_power_uncertainty_db": released.uncertainty,
            "released_power_verdict": released.verdict,
        }
        if vibration.measure == LAE and run.sound.source == "vibration":
            own = heard_levels(run.numbers)
            row["laf_max_db"] = own.laf_max_db
            row["laf_max_uncertainty_db"] = None if own.spreads is None else own.spreads.laf_max_db
        rows.append(row)
    frame = pd.DataFrame(rows)
    numbers = [name for name in frame if name.endswith("_db")]
    return frame.astype(dict.fromkeys(numbers, float))


# ---- parts of the figure


def _level_name(runs: Sequence[Run]) -> str:
    """Name the level of runs: LAeq, or LAE of single events."""
    names = dict.fromkeys(run.vibration.measure for run in runs)
    return " or ".join(f"{name} (re 1 s)" if name == LAE else name for name in names)


def _known(frame: pd.DataFrame, quantities: Sequence[_Quantity]) -> list[_Quantity]:
    """Return the quantities that a run of a table has."""
    return [x for x in quantities if x.column in frame and frame[x.column].notna().any()]


def _seeds_per_point(frame: pd.DataFrame, keys: Sequence[str]) -> int:
    """Return the largest number of seeds that runs of equal other values have."""
    if SEED not in frame:
        return 1
    return int(frame.groupby([*keys], dropna=False)[SEED].nunique().max())


def _means_over_seeds(frame: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return means of levels over seeds, with standard deviations in place of uncertainties."""
    groups = frame.groupby([*keys], sort=False, dropna=False)
    means = pd.DataFrame()
    for quantity in (_VIBRATION, _RELEASED, _FAST_MAXIMUM):
        if quantity.column in frame:
            means[quantity.column] = groups[quantity.column].mean()
            means[quantity.uncertainty] = groups[quantity.column].std()
    return means.reset_index()


def _sorted(frame: pd.DataFrame, key: str) -> pd.DataFrame:
    """Sort the rows of a table by the numbers of a key; names keep their order."""
    if pd.api.types.is_numeric_dtype(frame[key]):
        return frame.sort_values(key)
    return frame


def _draw(
    named_on: Axes,
    ax: Axes,
    group: pd.DataFrame,
    places: dict[Any, float],
    key: str,
    quantity: _Quantity,
    label: str,
    number: int,
    count: int,
) -> None:
    """Draw a quantity of a group of runs on axes, and name it in the legend of other axes.

    Groups differ by colour and mark, quantities by line and by full or hollow marks. The two
    quantities of a single group differ by colour too.
    """
    is_second = quantity is not _VIBRATION
    style = curve_style(number, count)
    if count == 1:
        style = curve_style(int(is_second), 2)
    style["linestyle"] = quantity.linestyle
    if sweep_figures.are_names(group[key]):
        style["linestyle"] = "none"
    if quantity.is_hollow:
        style["markerfacecolor"] = "white"
    name = f"{label}, {quantity.name}" if label else quantity.name
    if ax is not named_on:
        name += " (right axis)"
        named_on.plot([], [], markersize=6, label=name, **style)
        name = f"_{name}"
    x = group[key].map(places).astype(float)
    level = group[quantity.column]
    ax.plot(x, level, markersize=6, label=name, **style)
    hidden = f"_{name.removeprefix('_')}"
    error_bars(ax, x, level, group[quantity.uncertainty], style["color"], label=hidden)


def _stand_one_above_the_other(left: Axes, right: Axes, frame: pd.DataFrame) -> None:
    """Give two axes as many decibels each, the left levels below the right ones, with a border."""
    middles = []
    spans = []
    for quantities in ([_VIBRATION, _FAST_MAXIMUM], [_RELEASED]):
        low, high = _extremes(frame, _known(frame, quantities))
        middles.append(0.5 * (low + high))
        spans.append(high - low)
    half = (1.0 + 2.0 * _ROOM) * max(_LEAST_SPAN_DB, *spans)
    left.set_ylim(middles[0] - 0.5 * half, middles[0] + 1.5 * half)
    right.set_ylim(middles[1] - 1.5 * half, middles[1] + 0.5 * half)
    left.axhline(middles[0] + 0.5 * half, color="0.6", linewidth=0.8, linestyle=":")
    for ax, (low, high) in ((left, (0.0, 0.5)), (right, (0.5, 1.0))):
        bottom, top = ax.get_ylim()
        ends = bottom + (top - bottom) * low, bottom + (top - bottom) * high
        ticks = [x for x in MaxNLocator(5).tick_values(*ends) if ends[0] <= x <= ends[1]]
        ax.yaxis.set_major_locator(FixedLocator(ticks))
        ax.yaxis.set_major_formatter("{x:g}")


def _release_text(runs: Sequence[Run]) -> str:
    """Say what the released power of runs means."""
    of_release = [run for run in runs if run.sound.source != "vibration"]
    own = picture.level_of(of_release) if of_release else picture.RELEASED
    if own == picture.RELEASED:
        return "released power (q = 1): upper bound"
    return own.meaning


def _extremes(frame: pd.DataFrame, quantities: Sequence[_Quantity]) -> tuple[float, float]:
    """Return the ends of the levels of quantities with their uncertainties [dB]."""
    lows = []
    highs = []
    for quantity in quantities:
        spread = frame[quantity.uncertainty].fillna(0.0)
        lows.append(float((frame[quantity.column] - spread).min()))
        highs.append(float((frame[quantity.column] + spread).max()))
    return min(lows), max(highs)


def _facts(runs: Sequence[Run], has_vibration: bool, has_release: bool, seeds: int) -> list[str]:
    """Say what the two levels are, where they hold, and what the bars are."""
    facts = []
    if has_vibration:
        hows = {run.vibration.how for run in runs if run.vibration.value is not None}
        facts.append(f"vibration ({' or '.join(sorted(hows))}): what a listener would hear")
    else:
        reasons = {run.vibration.reason for run in runs}
        facts.append(f"no vibration: {'; '.join(sorted(reasons))}")
    if has_release:
        facts.append(_release_text(runs))
    if has_vibration and has_release:
        facts.append("each has its own axis, with equal decibels")
    facts.append(picture.distance_text(runs))
    if seeds > 1:
        facts.append(f"means over up to {seeds} seeds, bars: their standard deviation")
    else:
        facts.append("bars: ± standard uncertainty")
    return facts
