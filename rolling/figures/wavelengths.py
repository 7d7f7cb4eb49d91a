"""Figure of the part of the sound that each octave of roughness wavelength makes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from acoustics.plot_style import COLOURS
from rolling.figures.picture import axes_of, finish, finish_grid
from rolling.results.caveats import SENTENCES
from rolling.results.run_result import Run
from rolling.sound.wavelengths import FOLLOWS, LEAST_SHARE

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def wavelengths(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the share of each octave of roughness wavelength in the A-weighted energy of a run.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with shares, %, over wavelength along the track, µm: all of the sound at the
        frequencies of an octave, and the part that follows its waves where it is known.

    Raises
    ------
    ValueError
        The run is silent, or a fall.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.wavelengths(run)  # doctest: +SKIP
    """
    table, ax = wavelength_table(run), axes_of(ax)
    table = table[table["energy_share"] >= LEAST_SHARE]
    low, share = table["from_um"], 100 * table["energy_share"]
    linear = share * table["linear_share"].fillna(0.0)
    bars = [
        (share, 0.4, "at the frequencies of these waves"),
        (linear, 1.0, "following these waves"),
    ]
    for height, alpha, label in bars if linear.any() else bars[:1]:
        ax.bar(low, height, 0.92 * low, 0, align="edge", color=COLOURS[0], alpha=alpha, label=label)
    ax.set_xscale("log")
    ax.set_xticks(low, [f"{edge:g}" for edge in low])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("wavelength along the track, lower edge of the octave [µm]")
    ax.set_ylabel("part of the A-weighted energy [%]")
    return finish(finish_grid(ax), f"Wavelengths: {run.title}", [reading(run)])


def reading(run: Run) -> str:
    """State the octave of wavelength that makes most of the sound of a run, and the doubts."""
    most = max(run.wavelength_octaves, key=lambda octave: octave.energy_share)
    released, linear = run.sound.source == "release", most.linear_share
    kinds = ["made" if linear is None or linear >= FOLLOWS else "elsewhere", "read"]
    if most.fall_db is None:
        kinds[0] = "all"
    if run.vibration and run.vibration.motion.flight_share > 0:
        kinds.append("impacts")
    if linear is None:
        kinds.append("release" if released else "unknown")
    mean = "" if run.sound.constant_speed else "mean "
    numbers = most._asdict() | {"mean": mean, "percent": 100 * most.energy_share}
    numbers |= {"linear": 100 * (linear or 0.0)}
    return " ".join(SENTENCES[f"waves.{kind}"].format(**numbers) for kind in kinds)


def wavelength_table(run: Run) -> pd.DataFrame:
    """Tabulate the octaves of wavelength of a run, short waves first; NaN is unknown."""
    if not run.wavelength_octaves:
        raise ValueError(f"{run.title}: is silent or falls, so it has no octaves of wavelength")
    return pd.DataFrame(run.wavelength_octaves).astype(float)
