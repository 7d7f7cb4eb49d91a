"""Pictures of a bearing that turns: its spectrum, and signal and envelope with a fault."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from drawn_pictures import Drawn, legend_below, new_figure, plain, thin_out
from picture_parts import kept_run

import rolling
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, envelope, gridded

PASSES = 8  # of balls over the fault, in the signal that is drawn


def spectrum(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the spectrum of the ring with its bands and lines."""
    run = kept_run(scenes["bearing"])
    figure = new_figure(4.2)
    ax = plain(rolling.plot.spectrum(run, ax=figure.add_subplot()))
    thin_out(ax)
    legend_below(figure, ax)
    radial = run.numbers.below_bending.radial
    numbers = {name: f"{rounded(um_s, 2)} µm/s" for name, um_s in radial.um_s.items()}
    return Drawn(figure, numbers)


def fault(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the acceleration of the ring over time, and the spectrum of its envelope."""
    run = kept_run(scenes["bearing"])
    record = run.record
    passing_hz = run.kinematics.ball_pass_outer_hz
    count = min(len(record.acceleration_m_s2), round(PASSES / passing_hz * record.rate_hz))
    time_ms = 1e3 * np.arange(count) / record.rate_hz
    figure = new_figure(5.2)
    above, below = figure.subplots(2, 1)
    x, y = envelope(time_ms, record.acceleration_m_s2[:count, 0])
    above.plot(x, y, color=COLOURS[0], linewidth=0.6)
    gridded(above, xlabel="time [ms]", ylabel="acceleration of\nthe ring [m/s²]")
    above.set_xlim(0.0, time_ms[-1])
    plain(rolling.plot.envelope(run, ax=below))
    thin_out(above)
    signal = record.acceleration_m_s2[:, 0] - record.acceleration_m_s2[:, 0].mean()
    numbers = {
        "outer pass": f"{passing_hz:.1f} Hz",
        "interval": f"{1e3 / passing_hz:.1f} ms",
        "crest": f"{np.abs(signal).max() / signal.std():.1f}",
    }
    return Drawn(figure, numbers)
