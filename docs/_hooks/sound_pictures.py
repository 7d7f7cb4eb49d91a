"""Pictures of sounds: spectra over the load and over single keys, sources, and a spectrogram."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from drawn_pictures import Drawn, legend_below, new_figure, plain
from matplotlib.figure import Figure
from picture_parts import kept_run

import rolling
from acoustics import plots
from acoustics.plot_style import band_ticks
from acoustics.spectrum import spectrogram

SHOWN_DB = 50.0  # below the highest level of a spectrogram


def loads(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the spectra of a ball under several loads."""
    return _compared(scenes, 3.7)


def knob(scenes: Mapping[str, Any]) -> Drawn:
    """Draw what a single key does to a spectrum."""
    return _compared(scenes, 3.2)


def _compared(scenes: Mapping[str, Any], height_in: float) -> Drawn:
    """Draw the third octaves of runs, labelled as their scenes."""
    runs = {label: kept_run(scene) for label, scene in scenes.items()}
    figure = new_figure(height_in)
    ax = plain(rolling.plot.third_octaves([*runs.values()], ax=figure.add_subplot()))
    band_ticks(ax, octaves=True)
    _label(figure, ax, [*runs])
    numbers = {label: str(run.numbers.vibration.number) for label, run in runs.items()}
    for label, run in runs.items():
        numbers[f"peak {label}"] = _loudest_band(run)
    return Drawn(figure, numbers)


def _loudest_band(run: Any) -> str:
    """Name the loudest third octave of the vibration of a run."""
    levels = {name: level for name, level in run.numbers.bands.vibration.by_name.items() if level}
    loudest_hz = float(max(levels, key=lambda name: levels[name]))
    return f"{loudest_hz * 1e-3:g} kHz" if loudest_hz >= 1000 else f"{loudest_hz:g} Hz"


def _label(figure: Figure, ax: Any, labels: list[str]) -> None:
    """Name the curves of axes in their order, and write their legend below."""
    ax.set_ylabel("level [dB re 20 µPa]")
    handles, names = ax.get_legend_handles_labels()
    shown = [*labels, *names[len(labels) :]]
    figure.legend(handles, shown, loc="outside lower left", ncols=2, frameon=False)


def sources(scenes: Mapping[str, Any]) -> Drawn:
    """Draw what one run says of vibration, released power and sound powers."""
    run = kept_run(scenes["ball"])
    figure = new_figure(4.4)
    ax = plain(rolling.plot.sources(run, ax=figure.add_subplot()))
    band_ticks(ax, octaves=True)
    legend_below(figure, ax, columns=1)
    vibration, released = run.numbers.vibration, run.numbers.released_power
    numbers = {
        "vibration": str(vibration.number),
        "released power": str(released.number),
        "difference": f"{released.value - vibration.value:.0f} dB",
    }
    return Drawn(figure, numbers)


def rolling_out(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the spectrogram of the long record of a ball that comes to rest."""
    run = kept_run(scenes["ball"])
    heard = run.listen(scenes["ball"].sound.listen_s)
    shown = spectrogram(heard.pressure, heard.sample_rate, run.sound.highest, closed=False)
    level_db = plots.resolved_levels(shown)
    highest_db = float(np.nanmax(level_db[np.isfinite(level_db)]))
    figure = new_figure(3.6)
    seconds = len(heard.pressure) / heard.sample_rate
    limits_db = plots.level_limits([highest_db - SHOWN_DB, highest_db])
    plots.spectrogram(figure.add_subplot(), shown, seconds, limits_db)
    numbers = {
        "duration": f"{seconds:.0f} s",
        "distance": f"{scenes['ball'].rolling.distance_mm:g} mm",
    }
    return Drawn(figure, numbers)
