"""Plots of runs: each function draws on given or new axes and returns them.

Title and note stand above the axes; `ax.set_title("", loc="left")` takes them away. In the
examples `run` comes from `simulate`, `runs` come from a sweep over loads and seeds, and `worn` is a
run over a plate of permanent plasticity.

Examples
--------
>>> import matplotlib.pyplot as plt, rolling
>>> fig, ax = plt.subplots(1, 2, layout="constrained")
>>> left = rolling.plot.third_octaves([run], ax=ax[0])
>>> right = rolling.plot.contact_pressure(run, ax=ax[1])
"""

from acoustics.traps import ignoring_underflow
from rolling.figures.article import max_level_over_load, spectra_over_load
from rolling.figures.channels import (
    channel_envelope,
    channel_spectrum,
    channel_third_octaves,
)
from rolling.figures.contact import ball_surface, contact_pressure, recovery_events, surface
from rolling.figures.levels import levels
from rolling.figures.origins import modulation, running_in, wavelengths
from rolling.figures.places import places
from rolling.figures.sound import power_density, release_power, spectrogram, spectrum, third_octaves
from rolling.figures.sweep import contact_areas, mean_third_octaves
from rolling.figures.vibration import contact_filter, contact_force, mobilities, sources

__all__ = [
    "ball_surface", "channel_envelope", "channel_spectrum", "channel_third_octaves",
    "contact_areas", "contact_filter", "contact_force", "contact_pressure",
    "levels", "max_level_over_load", "mean_third_octaves", "mobilities", "modulation",
    "places", "power_density", "recovery_events", "release_power", "running_in", "sources",
    "spectra_over_load", "spectrogram", "spectrum", "surface", "third_octaves", "wavelengths",
]  # fmt: skip

for _name in __all__:
    globals()[_name] = ignoring_underflow(globals()[_name])
