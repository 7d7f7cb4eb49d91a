"""Plots of runs: each function draws on given or new axes and returns them.

Title and note stand above the axes; `ax.set_title("", loc="left")` takes them away.

Examples
--------
>>> import matplotlib.pyplot as plt, rolling
>>> fig, ax = plt.subplots(1, 2, layout="constrained")      # doctest: +SKIP
>>> rolling.plot.third_octaves([run], ax=ax[0])             # doctest: +SKIP
>>> rolling.plot.contact_pressure(run, ax=ax[1])            # doctest: +SKIP
"""

from rolling.figures.contact import contact_pressure, recovery_events, surface
from rolling.figures.sound import (
    power_density,
    release_power,
    spectrogram,
    spectrum,
    third_octaves,
)
from rolling.figures.sweep import contact_areas, levels, mean_third_octaves
from rolling.figures.vibration import contact_filter, contact_force, mobilities, sources

__all__ = [
    "contact_areas",
    "contact_filter",
    "contact_force",
    "contact_pressure",
    "levels",
    "mean_third_octaves",
    "mobilities",
    "power_density",
    "recovery_events",
    "release_power",
    "sources",
    "spectrogram",
    "spectrum",
    "surface",
    "third_octaves",
]
