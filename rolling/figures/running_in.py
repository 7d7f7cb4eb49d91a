"""Figure of the passes over a plate that remembers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.ticker import MaxNLocator

from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, MARKERS
from rolling.figures.picture import axes_of, distance_and_duration, finish, finish_grid
from rolling.results.run_result import Run
from rolling.results.running_in import pass_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_CURVES = {  # columns of the table with name, unit and factor of the unit
    "laeq_db": ("LAeq of the release", "dB(A)", 1.0),
    "vibration_estimate_laeq_db": ("LAeq of the vibration, estimated", "dB(A)", 1.0),
    "release_power_mean_w": ("release", "µW", 1e6),
    "depth_um": ("maximum depth", "µm", 1.0),
}


def running_in(run: Run, ax: Axes | None = None) -> Axes:
    """Plot level, release, plastic work and depth of the passes of a run over the first pass.

    Parameters
    ----------
    run : Run
        Run to plot, over a plate with `plasticity: permanent`.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with decibels re the first pass, and a right axis with the plastic work, J, against
        the number of the pass.

    Raises
    ------
    ValueError
        The plate of the run has no memory.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.running_in(run)  # doctest: +SKIP
    """
    table, ax = running_in_table(run), axes_of(ax)
    for k, (column, (name, unit, factor)) in enumerate(_CURVES.items()):
        values = table[column].to_numpy(dtype=float)
        if not np.isfinite(values).all() or not values[0]:
            continue  # silent, or nothing has sunk
        ratio = values - values[0] if unit == "dB(A)" else 10 * np.log10(values / values[0])
        label = f"{name}, {rounded(values[0] * factor, 3)} {unit} in pass 1"
        ax.plot(table["pass"], ratio, color=COLOURS[k], marker=MARKERS[k], label=label)
    work, look = table["plastic_work_j"], f"{MARKERS[4]}--"
    if (work > 0).any():
        right = ax.twinx()
        right.semilogy(table["pass"], work.where(work > 0), look, color=COLOURS[4])
        right.set_ylabel("plastic work [J]")
        ax.plot([], [], look, color=COLOURS[4], label="plastic work, right axis")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("pass")
    ax.set_ylabel("over pass 1 [dB]")
    facts = [*distance_and_duration([run]), "10 lg of release and depth over pass 1"]
    return finish(finish_grid(ax), f"Running-in: {run.title}", facts)


def running_in_table(run: Run) -> pd.DataFrame:
    """Tabulate levels [dB], release power [W], plastic work [J] and depth [um] of passes."""
    if run.result.passes is None:
        raise ValueError(f"{run.title}: has no passes, its plate has no memory")
    table = pd.DataFrame(pass_numbers(run.scene, run.result, run.pass_sounds))
    table.insert(0, "pass", np.arange(len(table)) + 1)
    return table
