"""The numbers of a sweep that lead, over a swept key, for every kind of scene."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from acoustics.arrays import instance
from acoustics.plot_style import LINE_STYLES, curve_style
from rolling.figures import sweep_figures
from rolling.figures.picture import axes_of, finish, listed, subject
from rolling.kinds.registry import kind_of_runs
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.quantity import Quantity

_DECADES = 4  # of an axis of velocities, at most; smaller values are not drawn
_LOGARITHMIC = 10.0  # ratio of values from which on the axis is logarithmic
_ROOM = 1.25  # above the largest value of a logarithmic axis


def quantities(
    runs: Iterable[Any],
    key: str | None = None,
    ax: Axes | None = None,
    words: Mapping[str, str] | None = None,
) -> Axes:
    """Plot the numbers of runs that lead, with their ±, against a number of their scenes.

    The numbers are those of the unit of the first one. Those of a bearing are the velocities of its
    ring in three bands.

    Parameters
    ----------
    runs : iterable of runs of one kind
        Runs to plot, such as the runs of a sweep.
    key : str
        Dotted key of the scene, such as `bearing.speed_rpm`. Default: the first swept key.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    words : mapping
        Words for the legend by the names of the numbers. Default: their names.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with the numbers in their unit, and bars of ± one standard uncertainty.

    Raises
    ------
    ValueError
        There is no run, a scene has no number at the key, or the runs have no swept key.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.quantities(runs, "rolling.load_n")
    """
    shown = listed(runs)
    for run in shown:
        instance("runs", run, RunFolder)
    by_name = _of_one_unit(shown)
    key = key or sweep_figures.some_swept_key(shown)
    ax = axes_of(ax)
    table = _table(shown, by_name)
    table[key] = sweep_figures.values_at(shown, key)
    places = sweep_figures.places_of(table[key])
    table["place"] = table[key].map(places).astype(float)
    others = sweep_figures.other_keys(shown, key)
    groups = [*sweep_figures.groups_of(table.sort_values("place"), others)]
    for number, (label, group) in enumerate(groups):
        for of_name, name in enumerate(by_name):
            # Colours tell the groups apart, or the numbers of a single group.
            style = curve_style(of_name, len(by_name))
            if len(groups) > 1:
                style = curve_style(number, len(groups))
                style["linestyle"] = LINE_STYLES[of_name % len(LINE_STYLES)]
            if sweep_figures.are_names(table[key]):
                style["linestyle"] = "none"
            legend = ", ".join(filter(None, (label, (words or {}).get(name, name))))
            _draw(ax, group, name, legend, style)
    first = next(iter(by_name.values()))[0]
    _scale(ax, table, [*by_name])
    ax.set_ylabel(f"{first.measure or 'value'} [{_unit(first)}]")
    sweep_figures.label_values(ax, key, places)
    head = first.measure or next(iter(by_name))
    title = f"{head[0].upper()}{head[1:]} against {sweep_figures.x_quantity(ax)}"
    return finish(ax, f"{title}: {subject(shown)}", ["bars: ± standard uncertainty"])


def has_sweep(runs: Sequence[Any]) -> bool:
    """Tell whether a swept key tells runs apart, over which numbers are drawn."""
    return len(runs) > 1 and sweep_figures.swept_key(runs) is not None


def quantity_table(runs: Sequence[Any]) -> pd.DataFrame:
    """Tabulate swept values and the numbers of runs that lead, with the ends of their ±."""
    return _table(runs, _of_one_unit(runs))


def _of_one_unit(runs: Sequence[Any]) -> dict[str, list[Quantity]]:
    """Return the numbers that lead by name, one of each run: those of the unit of the first one."""
    kind = kind_of_runs(runs)
    of_runs = [kind.quantities(run.numbers) for run in runs]
    unit = next(iter(of_runs[0].values())).unit
    return {
        name: [of_run.get(name, Quantity(name, None)) for of_run in of_runs]
        for name, quantity in of_runs[0].items()
        if quantity.unit == unit
    }


def _unit(quantity: Quantity) -> str:
    """Write the unit of a number as people read it."""
    return quantity.unit.replace("um", "µm")


def _table(runs: Sequence[Any], by_name: Mapping[str, Sequence[Quantity]]) -> pd.DataFrame:
    """Tabulate swept values and numbers; NaN where there is none."""
    table = sweep_figures.sweep_table(runs)
    for name, of_runs in by_name.items():
        ends = [_ends(quantity) for quantity in of_runs]
        table[name] = [math.nan if of_run.value is None else of_run.value for of_run in of_runs]
        table[f"{name}, low"] = [low for low, _ in ends]
        table[f"{name}, high"] = [high for _, high in ends]
    return table


def _ends(quantity: Quantity) -> tuple[float, float]:
    """Return value less and value plus the uncertainty, which may be in dB; NaN without one."""
    value = quantity.value
    spread = quantity.uncertainty
    if value is None or spread is None:
        return math.nan, math.nan
    if quantity.uncertainty_unit == "dB":
        factor = 10 ** (spread / 20)
        return value / factor, value * factor
    return value - spread, value + spread


def _draw(ax: Axes, group: pd.DataFrame, name: str, legend: str, style: dict[str, Any]) -> None:
    """Draw a number of a group of runs with its ±."""
    place = group["place"]
    value = group[name]
    ax.plot(place, value, markersize=6, label=legend, **style)
    known = group[f"{name}, low"].notna()
    below = (value - group[f"{name}, low"])[known]
    above = (group[f"{name}, high"] - value)[known]
    ax.errorbar(
        place[known],
        value[known],
        [below, above],
        fmt="none",
        label=f"_{legend}",
        ecolor=style["color"],
        elinewidth=0.9,
        capsize=2.5,
        capthick=0.9,
    )


def _scale(ax: Axes, table: pd.DataFrame, names: Sequence[str]) -> None:
    """Give positive values that are far apart a logarithmic axis of a few decades."""
    values = table[names].to_numpy(dtype=float)
    positive = values[values > 0]
    if not len(positive) or (values < 0).any():
        return
    largest = float(positive.max())
    least = max(float(positive.min()), largest / 10**_DECADES)
    if largest / least < _LOGARITHMIC:
        return
    ax.set_yscale("log", nonpositive="mask")
    ax.set_ylim(least / _ROOM, largest * _ROOM)
