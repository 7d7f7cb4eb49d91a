"""Figures of sweeps: levels and areas of runs against a swept key, and means over seeds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import pandas as pd

from acoustics.plots import LINE_STYLES, bars, look_of
from rolling.figures.picture import (
    axes_of,
    distance_and_duration,
    finish,
    finish_grid,
    listed,
    subject,
)
from rolling.figures.table_figures import (
    SCENE,
    groups_of,
    mean_band_table,
    mean_bands,
    name_axis,
    x_words,
)
from rolling.results.labels import value_at
from rolling.results.run_result import Run
from rolling.results.runs_table import SEED, runs_table
from rolling.scene.scene import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST_SEEDS = 3  # that have a spread worth drawing
_LEVELS = {  # columns of runs.csv with label and column of the standard uncertainty
    "laeq_db": ("LAeq", "laeq_uncertainty_db"),
    "level_db": ("LZeq", "level_uncertainty_db"),
    "vibration_laeq_db": ("LAeq of the vibration", ""),
    "release_laeq_db": ("level of the release, A", ""),
}
_AREAS = {
    "contact_area_mean_m2": ("contact area", ""),
    "plastic_area_mean_m2": ("plastic area", ""),
}


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
    names = dict(_LEVELS)
    if {run.sound.source for run in shown} == {"release"}:
        for name, weighting in (("laeq_db", "A"), ("level_db", "Z")):
            names[name] = f"released power, {weighting}", _LEVELS[name][1]
    ax = _against_key(shown, key, names, ax)
    ax.set_ylabel("level [dB re 20 µPa]")
    facts = [*distance_and_duration(shown), "bars: standard uncertainty of that duration"]
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
    >>> rolling.plot.contact_areas(runs, "rolling.load_n")  # doctest: +SKIP
    """
    shown = listed(runs)
    ax = _against_key(shown, key, _AREAS, ax, 1e12)
    ax.set_ylabel("mean area [µm²]")
    ax.set_ylim(bottom=0.0)
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
    if frame[SCENE].nunique() > 1 or SEED not in frame:
        return False
    seeds = [group[SEED].nunique() for _, group in groups_of(frame, _others(runs, SEED))]
    return bool(min(seeds) >= FEWEST_SEEDS)


def seed_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of third octaves of runs over their seeds [dB]."""
    return mean_band_table(sweep_table(runs), _others(runs, SEED))


def level_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values and levels of runs with their standard uncertainty [dB]."""
    return _columns(runs, [name for pair in _LEVELS.items() for name in (pair[0], pair[1][1])])


def area_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate swept values and mean areas of runs [m²]."""
    return _columns(runs, [*_AREAS])


def _columns(runs: Sequence[Run], names: Sequence[str]) -> pd.DataFrame:
    """Return columns of the table of runs, with the runs, their scenes and their swept values."""
    frame, keys = sweep_table(runs), dict.fromkeys(key for run in runs for key in run.values)
    return frame[[name for name in ("run", SCENE, *keys, *names) if name in frame]]


def sweep_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Return the table of runs with the columns of runs.csv and the names of their scenes."""
    frame = runs_table(runs).reset_index()
    return frame.assign(**{SCENE: [run.scene.name for run in runs]})


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
    name_axis(ax, "x", key, sorted(set(frame[key])))
    return finish_grid(ax)


def _others(runs: Sequence[Run], key: str) -> list[str]:
    """Return the swept keys other than one, after the scene's name where scenes differ."""
    keys = dict.fromkeys(name for run in runs for name in run.values if name != key)
    several = len({run.scene.name for run in runs}) > 1
    return [SCENE, *keys] if several else [*keys]


def _number(scene: Scene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    # The weight is a number, too.
    value = scene.load if key == "rolling.load_n" else value_at(scene, key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{key}: the scene {scene.name} has no number there")
    return float(value)
