"""Pictures of levels against a swept quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from rolling._typing import Array
from rolling.figures import captions
from rolling.figures.picture import (
    BOTTOM_IN,
    LEFT_IN,
    RIGHT_IN,
    WIDTH_IN,
    Box,
    Picture,
    blank,
    lay_out,
)
from rolling.figures.sound_figures import TALL_IN, UNCERTAINTY
from rolling.scene.sweep import Value
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult

# label, levels [dB], standard uncertainty [dB]
LevelCurve = tuple[str, list[float | None], list[float | None]]


@dataclass(frozen=True)
class LevelPanel:
    """Curves of a level against a swept quantity.

    Each combination of the other quantities has a curve.
    """

    name: str
    curves: list[LevelCurve]


def swept_key(runs: Sequence[RunResult]) -> str | None:
    """Return the first key whose value differs between runs.

    The result is None if the swept values do not distinguish the runs.
    """
    for key in runs[0].values:
        numbers = all(isinstance(run.values.get(key), int | float) for run in runs)
        if numbers and len({run.values[key] for run in runs}) > 1:
            distinct = {(run.scene.name, *run.values.items()) for run in runs}
            return key if len(distinct) == len(runs) else None
    return None


def level_panels(key: str, runs: Sequence[RunResult], x: Array) -> list[LevelPanel]:
    """Return LAeq and LZeq of runs at the values x (n,) of a swept key, with gaps."""
    several = len({run.scene.name for run in runs}) > 1

    def others(run: RunResult) -> tuple[str, tuple[tuple[str, Value], ...]]:
        return run.scene.name, tuple(
            (name, value) for name, value in run.values.items() if name != key
        )

    laeq, lzeq = LevelPanel("LAeq", []), LevelPanel("LZeq", [])
    for (scene, values), group in groupby(sorted(runs, key=others), key=others):
        label = ", ".join([scene] * several + [labels.worded(*value) for value in values])
        sounds = {run.values[key]: run.sound for run in group}
        for panel, level in ((laeq, "laeq_db"), (lzeq, "level_db")):
            level_db = [
                getattr(sounds[value].levels, level) if value in sounds else None for value in x
            ]
            spread_db = [
                getattr(sounds[value].uncertainty, level) if value in sounds else None
                for value in x
            ]
            panel.curves.append((label, level_db, spread_db))
    return [laeq, lzeq]


def levels(key: str, runs: Sequence[RunResult]) -> Picture:
    """Draw LAeq and LZeq against a swept quantity.

    Each combination of the other quantities has a curve.
    """
    x = np.array(sorted({run.values[key] for run in runs}))
    word, unit = labels.named(key)
    xlabel = f"{word} [{unit}]" if unit else word
    panels = level_panels(key, runs, x)
    limits = sound_plots.level_limits(
        level for panel in panels for _, levels_db, _ in panel.curves for level in levels_db
    )
    figure = blank()
    gap = 0.3
    width = (WIDTH_IN - LEFT_IN - RIGHT_IN - gap) / 2
    places: dict[Axes, Box] = {}
    for index, panel in enumerate(panels):
        ax = figure.add_subplot()
        sound_plots.level_against(ax, x, panel.curves, xlabel, limits)
        ax.set_ylabel("" if index else "level [dB re 20 µPa]")
        ax.tick_params(labelleft=not index)
        ax.text(0.03, 0.97, panel.name, transform=ax.transAxes, va="top", fontweight="bold")
        places[ax] = (LEFT_IN + index * (width + gap), BOTTOM_IN, width, TALL_IN)
    title = f"Levels against {word}: {captions.subject(runs)}"
    note = captions.note([captions.distance(runs), captions.duration(runs), UNCERTAINTY])
    lay_out(figure, title, note, places)
    return Picture("levels", f"{title}: {note}", figure, _level_columns(key, x, panels))


def _level_columns(key: str, x: Array, panels: Sequence[LevelPanel]) -> dict[str, NDArray[Any]]:
    """Return the levels of all curves as a table: a row for each value of each curve."""
    labels_of_curves = [label for label, _, _ in panels[0].curves]
    columns: dict[str, NDArray[Any]] = {}
    if len(labels_of_curves) > 1:
        columns["curve"] = np.repeat(labels_of_curves, len(x))
    columns[key.rpartition(".")[2]] = np.tile(x, len(labels_of_curves))
    for panel in panels:
        name = panel.name.lower()
        columns[f"{name}_db"] = captions.gaps(db for _, levels, _ in panel.curves for db in levels)
        columns[f"{name}_standard_uncertainty_db"] = captions.gaps(
            db for _, _, spread in panel.curves for db in spread
        )
    return columns
