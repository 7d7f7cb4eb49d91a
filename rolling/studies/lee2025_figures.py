"""Figures 1 and 5 to 9 of the article for each reading, on axes that all readings share."""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib

# isort: split

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from acoustics.plot_style import curve_style
from acoustics.plots import Lines, level_limits, spectrum
from rolling.check.validity import MAX_SLOPE
from rolling.studies.lee2025_cases import CELLS, Maps
from rolling.studies.lee2025_conditions import LOAD, OUTLOOK, ROUGHNESS, label, swept

MAP_FIGURES = (
    ("height [µm]", "fig1_surfaces", "cividis"),
    ("pressure [GPa]", "fig5_contact_pressure", "magma"),
    ("deflection [µm]", "fig6_deflection", "viridis"),
)


def gallery(
    readings: dict[str, pd.DataFrame], maps: dict[str, Maps]
) -> Iterator[tuple[str, str, Figure]]:
    """Draw all figures: yield reading, name and figure."""
    everything = pd.concat(readings.values())
    maps = {reading: maps[reading] for reading in readings}
    curve_limits = level_limits(np.concatenate(list(everything["curve_db"])))
    plastic_limits = (-0.02, 1.05 * max(float(everything["plastic_ratio"].max()), 0.1))
    maximum_limits = [
        level_limits(everything["maximum_10_db"]),
        level_limits(everything["maximum_20_db"]),
    ]
    for reading, cases in readings.items():
        column = swept(cases)
        if column is not None:
            figure, axes = _blank(reading, 1)
            spectra(axes[0], cases[cases[LOAD] == cases[LOAD].min()], column, curve_limits)
            yield reading, OUTLOOK[column], figure
            continue
        for quantity, name, colours in MAP_FIGURES:
            sheets = _map_figure(reading, maps, quantity, colours)
            if sheets is not None:
                yield reading, name, sheets
        figure, axes = _blank(reading, 1)
        against_load(axes[0], cases, "plastic_ratio", "plastic area over Hertz's area [-]")
        axes[0].set_ylim(plastic_limits)
        yield reading, "fig7_plastic_ratio", figure
        roughnesses = sorted(cases[ROUGHNESS].unique())
        figure, axes = _blank(reading, len(roughnesses))
        for ax, roughness in zip(axes, roughnesses, strict=True):
            spectra(ax, cases[cases[ROUGHNESS] == roughness], LOAD, curve_limits)
            ax.set_title(title(cases, roughness), fontsize="small")
        yield reading, "fig8_spectra", figure
        figure, axes = _blank(reading, 2)
        against_load(
            axes[0],
            cases,
            "maximum_10_db",
            "maximum A-weighted line of the\nreleased power [dB re 1 pW/m²]",
        )
        against_load(
            axes[1], cases, "maximum_20_db", "the same with 20 lg [dB],\nonly differences count"
        )
        for ax, limits in zip(axes, maximum_limits, strict=True):
            ax.set_ylim(limits)
        yield reading, "fig9_maximum_level", figure


def title(cases: pd.DataFrame, roughness: float) -> str:
    """Write a roughness, with a remark where its slope exceeds the limit of half-space theory."""
    slope = cases.loc[cases[ROUGHNESS] == roughness, "rms_slope"].max()
    remark = " (too steep for half-space theory)" if slope > MAX_SLOPE else ""
    return f"{label(ROUGHNESS, roughness)}{remark}"


def against_load(ax: Axes, cases: pd.DataFrame, column: str, ylabel: str) -> Axes:
    """Draw a column against load: a curve of means and standard deviations for each roughness."""
    for number, (roughness, group) in enumerate(cases.groupby(ROUGHNESS)):
        by_load = group.groupby(LOAD)[column].agg(["mean", "std"]).dropna(subset=["mean"])
        ax.errorbar(
            by_load.index,
            by_load["mean"],
            by_load["std"].fillna(0.0),
            label=title(cases, float(roughness)),
            capsize=3,
            **curve_style(number, cases[ROUGHNESS].nunique()),
        )
    loads = sorted(cases[LOAD].unique())
    ax.set_xscale("log")
    ax.set_xticks(loads, [f"{load:g}" for load in loads], minor=False)
    ax.set_xticks([], minor=True)
    ax.set_xlabel("load [N]")
    ax.set_ylabel(ylabel)
    ax.legend(fontsize="small")
    return ax


def spectra(ax: Axes, cases: pd.DataFrame, by: str, limits_db: tuple[float, float]) -> Axes:
    """Draw the article's line spectra in 1/12 octaves: the mean power for each value of `by`."""
    curves = []
    for value, group in cases.groupby(by):
        power = np.mean(np.stack([10 ** (curve / 10) for curve in group["curve_db"]]), axis=0)
        level = 10 * np.log10(np.where(np.isnan(power), 0.0, power) + 1e-30)
        curves.append((label(by, float(value)), Lines(group["curve_hz"].iloc[0], level)))
    spectrum(ax, curves, limits_db, ordered=True)
    ax.set_ylabel("A-weighted line of the\nreleased power [dB re 1 pW/m²]")
    ax.legend(fontsize="small")
    return ax


def _map_figure(reading: str, maps: dict[str, Maps], quantity: str, colours: str) -> Figure | None:
    """Draw the maps of a quantity in space, on the vertical scale of all readings; None without."""
    lowest = math.inf
    highest = -math.inf
    for sheets in maps.values():
        for key, sheet in sheets.items():
            if key.quantity == quantity:
                lowest = min(lowest, sheet.values.min())
                highest = max(highest, sheet.values.max())
    shown = [
        (key, sheet) for key, sheet in sorted(maps[reading].items()) if key.quantity == quantity
    ]
    if not shown:
        return None
    figure, axes = _blank(reading, len(shown), "3d")
    for ax, (key, sheet) in zip(axes, shown, strict=True):
        along, across = np.indices(sheet.values.shape) * sheet.cell_um
        ax.plot_surface(along, across, sheet.values, rcount=CELLS, ccount=CELLS, cmap=colours)
        ax.set_xlabel("along [µm]", fontsize="small")
        ax.set_ylabel("across [µm]", fontsize="small")
        ax.set_zlabel(quantity, fontsize="small")
        ax.set_zlim(lowest, highest)
        heading = label(ROUGHNESS, key.roughness_um)
        if quantity.startswith("deflection"):
            ax.set_zlim(highest, lowest)  # downwards
        if not quantity.startswith("height"):
            heading += f", {label(LOAD, key.load_n)}"
        ax.set_title(heading, fontsize="small")
    return figure


def _blank(reading: str, count: int, projection: str | None = None) -> tuple[Figure, list[Any]]:
    """Make a figure with a number of axes, two in a row."""
    columns = min(count, 2)
    rows = -(-count // columns)
    figure = Figure(figsize=(8.5, 3.6 * rows), layout="constrained")
    figure.suptitle(reading)
    places = range(1, count + 1)
    return figure, [figure.add_subplot(rows, columns, k, projection=projection) for k in places]
