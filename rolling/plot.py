"""Plots of runs: each function draws on given or new axes and returns them.

Title and note stand above the axes; `ax.set_title("", loc="left")` takes them away. In the
examples `run` comes from `simulate`, `runs` come from a sweep over loads and seeds, `worn` is a run
over a plate of permanent plasticity, and `turning` is a run of a bearing.

Examples
--------
>>> import matplotlib.pyplot as plt, rolling
>>> fig, ax = plt.subplots(1, 2, layout="constrained")
>>> left = rolling.plot.third_octaves([run], ax=ax[0])
>>> right = rolling.plot.contact_pressure(run, ax=ax[1])
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from acoustics import matplotlib_import  # noqa: F401, before matplotlib
from acoustics.traps import ignoring_underflow
from rolling.bearing_kind.bearing_figures import ball_forces, envelope, load_distribution
from rolling.bearing_kind.pulse_figures import acceleration_signal, velocity_spectrogram
from rolling.figures.article import max_level_over_load, spectra_over_load
from rolling.figures.catalogue import draw
from rolling.figures.channel_figures import (
    channel_envelope,
    channel_spectrum,
    channel_third_octaves,
)
from rolling.figures.contact_figures import ball_surface, contact_pressure, recovery_events, surface
from rolling.figures.level_figures import levels
from rolling.figures.origins import modulation, running_in, wavelengths
from rolling.figures.place_figures import places
from rolling.figures.quantity_figures import quantities
from rolling.figures.sound_figures import (
    power_density,
    release_power,
    released_spectrum,
    released_third_octaves_a,
    spectrogram,
    third_octaves,
)
from rolling.figures.sweep_figures import contact_areas, mean_third_octaves
from rolling.figures.vibration_figures import contact_filter, contact_force, mobilities, sources

if TYPE_CHECKING:  # matplotlib is imported by the figures, which guard its settings
    from matplotlib.axes import Axes

__all__ = [
    "acceleration_signal", "ball_forces", "ball_surface", "channel_envelope", "channel_spectrum",
    "channel_third_octaves", "contact_areas", "contact_filter", "contact_force", "contact_pressure",
    "envelope", "levels", "load_distribution", "max_level_over_load", "mean_third_octaves",
    "mobilities", "modulation", "places", "power_density", "quantities", "recovery_events",
    "release_power", "released_spectrum", "released_third_octaves_a", "running_in", "sources",
    "spectra_over_load", "spectrogram", "spectrum", "surface", "third_octaves",
    "velocity_spectrogram", "wavelengths",
]  # fmt: skip


def spectrum(runs: Any, ax: Axes | None = None) -> Axes:
    """Plot the spectrum of what a kind of run is heard or judged by.

    Parameters
    ----------
    runs : run or iterable of runs
        Runs of balls, whose sound pressure is compared; or one run of a bearing, whose ring has
        velocities in three bands and lines.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels of lines, dB re 20 µPa, or with rms velocities of lines, µm/s, over
        frequency, Hz.

    Raises
    ------
    ValueError
        There is no run, or runs of bearings are compared.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectrum([run])
    >>> ax = rolling.plot.spectrum(turning)
    """
    return draw(runs, "spectrum", ax)


for _name in __all__:
    globals()[_name] = ignoring_underflow(globals()[_name])
