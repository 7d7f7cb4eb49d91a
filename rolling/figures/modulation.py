"""Figure of the modulation of a record by the turns of the sphere."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from acoustics.modulation import envelope_spectrum
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS
from rolling.figures.picture import axes_of, distance_and_duration, finish, finish_grid
from rolling.results.run_result import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MULTIPLES = 10  # of the turn's frequency that are shown and marked


def modulation(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the envelope spectrum of the octave of a run that the turns of the sphere modulate most.

    Parameters
    ----------
    run : Run
        Run to plot, of a sphere with a surface.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with modulation over frequency, Hz; multiples of the turns per second are marked.

    Raises
    ------
    ValueError
        The record has less than two turns at a constant speed.

    Examples
    --------
    >>> import rolling
    >>> rolling.plot.modulation(run)  # doctest: +SKIP
    """
    table, ax = modulation_table(run), axes_of(ax)
    (low, high), turn_hz = run.summary["turn_band_hz"], run.summary["turn_hz"]
    for multiple in range(1, MULTIPLES + 1):
        name = "multiples of v/(2πR)" if multiple == 1 else None
        ax.axvline(multiple * turn_hz, color=COLOURS[1], linestyle=":", linewidth=1, label=name)
    ax.plot(table["frequency_hz"], table["modulation"], color=COLOURS[0], linewidth=1)
    ax.set(xlim=(0.0, (MULTIPLES + 0.5) * turn_hz), ylim=(0.0, None))
    ax.set(xlabel="frequency of the modulation [Hz]", ylabel="modulation [-]")
    facts = [
        *distance_and_duration([run]),
        f"Hilbert envelope of {low:.0f} to {high:.0f} Hz, the octave where turns stand out most",
        f"they are {rounded(run.summary['turn_prominence'])} times the median; noise has 1 to 3",
        f"{rounded(turn_hz, 4)} turns per second",
    ]
    return finish(finish_grid(ax), f"Modulation: {run.title}", facts)


def modulation_table(run: Run) -> pd.DataFrame:
    """Tabulate the modulation [-] of the octave of the turns over frequency [Hz]."""
    if not run.summary.get("turn_band_hz"):
        raise ValueError(f"{run.title}: has less than two turns of a sphere with a surface")
    (low, high), sound = run.summary["turn_band_hz"], run.sound
    spectrum = envelope_spectrum(sound.pressure, sound.sample_rate, (low, high), sound.closed)
    table = pd.DataFrame({"frequency_hz": spectrum.frequency_hz, "modulation": spectrum.modulation})
    return table[table["frequency_hz"] <= (MULTIPLES + 0.5) * run.summary["turn_hz"]]
