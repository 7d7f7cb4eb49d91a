"""Figures 8 and 9 of Lee, Kim and Kim (2025) for a sweep of one's own over loads.

Their level is a line of the A-weighted spectrum of the released power, as in the article. It
depends on the length of the record, and it is not what a listener would hear.
"""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics import plots
from acoustics.plot_style import NOTHING_DB, PER_OCTAVE, Lines, curve_style, error_bars
from acoustics.spectrum import article_line_level_db
from rolling.figures import picture, sweep_figures
from rolling.figures.picture import axes_of, compared, finish, subject
from rolling.results.labels import SEED
from rolling.results.run_result import Run

LOAD = "rolling.load_n"
LEVEL = "dB re 1 pW/m²"


def has_loads(runs: Sequence[Run]) -> bool:
    """Return whether runs that roll at a constant speed differ in their load."""
    loads = {run.scene.load for run in runs}
    return len(loads) > 1 and all(_has_lines(run) and LOAD in run.values for run in runs)


def has_loads_and_seeds(runs: Sequence[Run]) -> bool:
    """Return whether runs of several loads have a spread over seeds."""
    return has_loads(runs) and sweep_figures.has_seeds(runs)


def runs_by_surface(runs: Sequence[Run]) -> list[tuple[str, list[Run]]]:
    """Return the runs of all loads and seeds for each combination of the other swept values."""
    frame = sweep_figures.sweep_table(runs)
    groups = sweep_figures.groups_of(frame, _surface_keys(runs))
    return [(label, [runs[row] for row in group.index]) for label, group in groups]


# ---- figure 9


def max_level_over_load(runs: Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot the maximum A-weighted line of the released power of runs against their load.

    This is figure 9 of the article, with a curve for each combination of the other swept values,
    such as the roughness. Runs that differ in their seed have their mean and standard deviation.

    Parameters
    ----------
    runs : iterable of Run
        Runs of several loads, best with several seeds.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with maximum line levels, dB re 1 pW/m², over the load, N.

    Raises
    ------
    ValueError
        A run falls or changes its speed, so that it has no lines.

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equations (10) and (11), figure 9.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.max_level_over_load(runs)
    """
    shown = compared(runs)
    ax = axes_of(ax)
    table = max_level_table(shown)
    groups = [*sweep_figures.groups_of(table, _surface_keys(shown))]
    for k, (label, group) in enumerate(groups):
        style = curve_style(k, len(groups))
        ax.plot(group[LOAD], group["maximum_db"], markersize=6, label=label or None, **style)
        deviation = group["standard_deviation_db"]
        error_bars(ax, group[LOAD], group["maximum_db"], deviation, style["color"], f"_{label}")
    sweep_figures.label_values(ax, LOAD, sweep_figures.places_of(table[LOAD]))
    ax.set_ylabel(f"maximum A-weighted line of the released power [{LEVEL}]")
    facts = ["as figure 9 of Lee, Kim and Kim (2025): upper bound (q = 1)", *_facts(shown)]
    if table["seeds"].max() > 1:
        facts.append(f"mean of {_counts(table['seeds'])} seeds, bars: their standard deviation")
    return finish(ax, f"Maximum level of the released power: {subject(shown)}", facts)


def max_level_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate mean and standard deviation of the maximum lines over seeds [dB re 1 pW/m²]."""
    frame = sweep_figures.sweep_table(runs)
    frame[LOAD] = [run.scene.load for run in runs]
    frame["maximum_db"] = [float(_lines(run).level_db.max()) for run in runs]
    keys = [*_surface_keys(runs), LOAD]
    groups = frame.groupby(keys, sort=False, dropna=False)["maximum_db"]
    table = pd.DataFrame(
        {
            "maximum_db": groups.mean(),
            "standard_deviation_db": groups.std(),
            "seeds": groups.size(),
        }
    )
    return table.reset_index().sort_values(LOAD, kind="stable", ignore_index=True)


# ---- figure 8


def spectra_over_load(runs: Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot the A-weighted lines of the released power of runs, a curve for each load.

    This is a part of figure 8 of the article, which has one for each roughness. A curve is the mean
    power of the lines in each 1/12 octave, over all runs of a load.

    Parameters
    ----------
    runs : iterable of Run
        Runs of several loads over one kind of surface.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with line levels, dB re 1 pW/m², over frequency, Hz.

    Raises
    ------
    ValueError
        A run falls or changes its speed, so that it has no lines.

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equations (10) and (11), figure 8.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectra_over_load(runs)
    """
    shown = compared(runs)
    curves = _curves_by_load(shown)
    ax = plots.spectrum(axes_of(ax), curves, ordered=True)
    ax.set_ylabel(f"A-weighted line of the released power [{LEVEL}]")
    facts = [
        "as figure 8 of Lee, Kim and Kim (2025): upper bound (q = 1)",
        *_facts(shown),
        f"mean over 1/{PER_OCTAVE} octave",
    ]
    return finish(ax, f"Spectra of the released power: {subject(shown)}", facts)


def spectra_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate the mean lines [dB re 1 pW/m²] of each load over frequency [Hz]."""
    frames = []
    for label, lines in _curves_by_load(runs):
        columns = {"frequency_hz": lines.frequency_hz, "a_weighted_line_level_db": lines.level_db}
        frames.append(pd.DataFrame({"curve": label, **columns}))
    return pd.concat(frames, ignore_index=True)


def _curves_by_load(runs: Sequence[Run]) -> list[tuple[str, Lines]]:
    """Return the mean power of the lines in each 1/12 octave, for each load."""
    curves = []
    for load in sorted({run.scene.load for run in runs}):
        means = [_lines(run).mean for run in runs if run.scene.load == load]
        frequency = means[0][0]
        power = np.mean([np.interp(frequency, hz, 10 ** (db / 10)) for hz, db in means], axis=0)
        level = np.maximum(10 * np.log10(np.maximum(power, 1e-300)), NOTHING_DB)
        curves.append((f"load {load:g} N", Lines(frequency, level)))
    return curves


# ---- lines of runs


def _has_lines(run: Run) -> bool:
    """Tell whether the lines of the released power of a run have a meaning."""
    return run.scene.has_release and run.sound.constant_speed


def _lines(run: Run) -> Lines:
    """Return the audible A-weighted lines of the released power of a run [dB re 1 pW/m²]."""
    if not _has_lines(run):
        raise ValueError(f"{run.title}: falls or changes its speed, so its release has no lines")
    power = run.release_power
    sample_rate_hz = len(power) / run.sound.duration
    return Lines.audible(
        *article_line_level_db(power, sample_rate_hz, run.scene.listener_distance_m)
    )


def _surface_keys(runs: Sequence[Run]) -> list[str]:
    """Return the swept keys other than load and seed."""
    return [key for key in sweep_figures.other_keys(runs, LOAD) if key != SEED]


def _facts(runs: Sequence[Run]) -> list[str]:
    """Say where the lines hold, and on what they depend."""
    width_hz = [1 / run.sound.duration for run in runs]
    return [
        picture.distance_text(runs),
        picture.common("lines of", width_hz, "Hz") + ", lower in longer records",
    ]


def _counts(numbers: pd.Series) -> str:
    """Write the smallest and the largest of counts."""
    ends = dict.fromkeys((int(numbers.min()), int(numbers.max())))
    return " to ".join(map(str, ends))
