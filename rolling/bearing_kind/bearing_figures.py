"""Figures of a bearing run: spectrum with its lines, envelope, load distribution, ball forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from pandas import DataFrame

from acoustics.arrays import Array, instance
from acoustics.plot_style import COLOURS
from acoustics.plot_style import envelope as thinned
from rolling.bearing import lines
from rolling.bearing.lines import BearingLine
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import AXIAL, PLACES, RADIAL, UM_S
from rolling.bearing.static_load import ball_loads
from rolling.bearing_kind import bearing_sentences
from rolling.bearing_kind.bearing_tables import SHOWN_HZ, spectrum_table
from rolling.bearing_kind.pulse_figures import (
    acceleration_signal,
    run_title,
    shown_samples,
    signal_table,
    velocity_spectrogram,
)
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.figures.picture import axes_of, drawable, finish
from rolling.figures.quantity_figures import has_sweep, quantities, quantity_table
from rolling.kinds.figure_kind import FigureKind

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

_DECADES = 5  # of velocity, at most
_ENVELOPE_LINES = 20  # at least, where the bearing hardly turns in the record
_ENVELOPE_MULTIPLES = 3.2  # of the highest line of a fault, up to which an envelope is drawn
_FIRST_LINE = 3  # of an envelope that is drawn; those below are its slow drift
_NAMED_BALLS = 4  # of which the forces are drawn
_NOTHING_UM_S = 1e-12  # in the place of 0 on a logarithmic axis
_BAND_COLOURS = ("0.93", "0.88", "0.93")


# ---- curves


def spectrum(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the velocity of the ring over frequency with the three bands and the lines of a bearing.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with rms velocities of lines, µm/s, over frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectrum(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax)
    largest = 0.0
    for direction, colour in ((AXIAL, COLOURS[1]), (RADIAL, COLOURS[0])):
        narrow = run.record.spectra[direction]
        shown = (narrow.frequency_hz >= SHOWN_HZ[0]) & (narrow.frequency_hz <= SHOWN_HZ[1])
        um_s = UM_S * narrow.rms[shown]
        largest = max(largest, float(um_s.max()))
        log_hz = np.asarray(np.log(narrow.frequency_hz[shown]), dtype=float)
        x, y = thinned(log_hz, np.maximum(um_s, _NOTHING_UM_S))
        width = 0.9 if direction == RADIAL else 0.5
        label = direction
        if direction == AXIAL and run.numbers.axial_doubt is not None:
            label = f"{direction} ({run.numbers.axial_doubt.severity.word})"
        ax.plot(np.exp(x), y, color=colour, linewidth=width, label=label)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(*SHOWN_HZ)
    top = 10 ** math.ceil(math.log10(max(largest, _NOTHING_UM_S)) + 0.6)
    ax.set_ylim(top / 10**_DECADES, top)
    bands_hz = run.bands_below_bending_hz
    velocities = run.numbers.below_bending.radial.um_s
    marked = False
    for colour, (name, (low, high)) in zip(_BAND_COLOURS, bands_hz.items(), strict=True):
        if not high > low:  # the ring bends from below the band on
            continue
        label = "_" if marked else "one of three bands, with its radial velocity"
        marked = True
        ax.axvspan(low, high, color=colour, zorder=0, label=label)
        ax.text(
            math.sqrt(low * high),
            0.985,
            f"{bearing_sentences.velocity(velocities[name])} µm/s",
            transform=ax.get_xaxis_transform(),
            ha="center",
            va="top",
            fontsize=10,
        )
    _draw_lines(ax, run.lines)
    if run.scene.ring_holds_hz < SHOWN_HZ[1]:
        ax.axvspan(
            run.scene.ring_holds_hz,
            SHOWN_HZ[1],
            fill=False,
            hatch="//",
            alpha=0.25,
            label=_beyond(run),
        )
    ax.set(xlabel="frequency [Hz]", ylabel="rms velocity of a line [µm/s]")
    ax.xaxis.set_major_formatter("{x:g}")
    return finish(ax, f"Velocity of the {run.moving} ring: {run_title(run)}", _facts(run))


def _beyond(run: BearingRun) -> str:
    """Say what lies above the frequency up to which the ring is as a real one."""
    return "modes left out" if run.model.bending else "the ring bends"


def envelope(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the spectrum of the squared envelope of a band, with the lines of faults.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with shares of the mean square, %, over frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.envelope(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax)
    narrow = run.envelope
    highest = highest_envelope_hz(run)
    shown = shown_of_envelope(run)
    x, y = thinned(narrow.frequency_hz[shown], 100 * narrow.rms[shown])
    ax.plot(
        x,
        y,
        color=COLOURS[0],
        linewidth=0.9,
        label=f"squared envelope {run.scene.seen_at('along x')}",
    )
    ax.set_xlim(0, highest)
    ax.set_ylim(0, 1.3 * max(float(y.max()), _NOTHING_UM_S))
    _draw_lines(ax, lines.envelope_lines(run.kinematics))
    ax.set(xlabel="frequency [Hz]", ylabel="line over the mean square [%]")
    low, high = run.envelope_band.band_hz
    return finish(ax, f"Envelope from {low:,.0f} to {high:,.0f} Hz: {run_title(run)}", _facts(run))


def shown_of_envelope(run: BearingRun) -> NDArray[np.bool_]:
    """Return which lines of the envelope are shown."""
    narrow = run.envelope
    first_hz = _FIRST_LINE * narrow.line_width_hz
    is_low = narrow.frequency_hz <= highest_envelope_hz(run)
    return np.asarray(is_low & (narrow.frequency_hz >= first_hz))


def highest_envelope_hz(run: BearingRun) -> float:
    """Return the frequency up to which an envelope is shown [Hz]: some lines of it at least."""
    speeds = run.kinematics
    narrow = run.envelope
    passes = max(speeds.ball_pass_outer_hz, speeds.ball_pass_inner_hz, 2 * speeds.ball_spin_hz)
    highest = max(_ENVELOPE_MULTIPLES * passes, _ENVELOPE_LINES * narrow.line_width_hz)
    return min(highest, float(narrow.frequency_hz[-1]))


def _draw_lines(ax: Axes, shown: Sequence[BearingLine]) -> None:
    """Mark lines from below, with their names where there is room for them."""
    low, high = ax.get_xlim()
    logarithmic = ax.get_xscale() == "log"
    scale = np.log if logarithmic else np.asarray
    last = -math.inf
    for line in sorted(shown, key=lambda line: line.frequency_hz):
        if not low < line.frequency_hz < high:
            continue
        place = float((scale(line.frequency_hz) - scale(low)) / (scale(high) - scale(low)))
        has_room = place - last > 0.019 and not line.minor
        ax.axvline(
            line.frequency_hz,
            ymax=0.9 if has_room else 0.04,
            color="0.35",
            linewidth=0.7,
            linestyle=(0, (2, 2)),
            zorder=1,
        )
        if has_room:
            last = place
        if not line.minor:
            ax.text(
                line.frequency_hz,
                0.9,
                drawable(line.name),
                transform=ax.get_xaxis_transform(),
                rotation=90,
                ha="right",
                va="top",
                fontsize=7.5,
                visible=has_room,  # the page shows more names as one zooms in
            )


def ball_forces(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the loads of some balls over two turns of the cage.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with loads, N, over time, ms.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.ball_forces(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax)
    record = run.record
    samples = shown_samples(run)
    time_ms = 1e3 * np.arange(samples) / record.rate_hz
    balls = record.ball_load_n.shape[1]
    for ball in range(min(balls, _NAMED_BALLS)):
        x, y = thinned(np.asarray(time_ms, dtype=float), record.ball_load_n[:samples, ball])
        ax.plot(x, y, color=COLOURS[ball], linewidth=0.8, label=f"ball {ball}")
    ax.set_xlim(0, time_ms[-1])
    ax.set(xlabel="time [ms]", ylabel="load of a ball [N]")
    return finish(ax, f"Loads of balls on the {run.moving} ring: {run_title(run)}", _facts(run))


def load_distribution(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the mean load of a ball over its angle, beside that of the static balance.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new polar axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with loads, N, over the angle from the middle of the load zone, degrees.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.load_distribution(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax, is_polar=True)
    turn = 2 * np.pi * np.arange(PLACES + 1) / PLACES
    around = mean_loads_n(run)
    loads = np.append(around, around[0])
    known = ~np.isnan(loads)
    static = static_loads(run.model, turn)
    polar: Any = ax  # matplotlib's types know no polar axes here
    is_polar = ax.name == "polar"
    angle = turn if is_polar else np.degrees(turn)
    ax.plot(angle[known], loads[known], color=COLOURS[0], linewidth=1.6, label="mean, in motion")
    ax.plot(angle, static, color="0.3", linestyle="--", linewidth=1, label="static balance")
    largest = max(float(np.nanmax(loads)), float(static.max()))
    if is_polar:
        ax.fill(angle[known], loads[known], color=COLOURS[0], alpha=0.15)
        polar.set_theta_zero_location("S")
        polar.set_rlabel_position(135)
        ax.set_xlabel("angle [degrees]")
    else:
        ax.set(xlabel="angle [degrees]", ylabel="load of a ball [N]", xlim=(0, 360))
    ax.set_ylim(0, 1.08 * largest)
    return finish(ax, f"Load of a ball over its angle [N]: {run_title(run)}", _facts(run))


def mean_loads_n(run: BearingRun) -> Array:
    """Return the mean load of a ball [N] at 72 angles; NaN where no ball has been."""
    return np.array(run.numbers.loads.mean_at_angles_n, dtype=float)


def static_loads(model: BearingModel, angle: Array) -> Array:
    """Return the load of a ball [N] at angles [rad] in the static balance with ball 0 below."""
    pressed = model.lines(angle).at(model.balance().displacements)
    return ball_loads(pressed.approach_m, model.geometry.series_stiffness)


# ---- tables and files


def envelope_table(run: BearingRun) -> DataFrame:
    """Tabulate the spectrum of the squared envelope over its mean."""
    narrow = run.envelope
    shown = narrow.frequency_hz <= highest_envelope_hz(run)
    return DataFrame({"frequency_hz": narrow.frequency_hz[shown], "share": narrow.rms[shown]})


def load_table(run: BearingRun) -> DataFrame:
    """Tabulate the mean and the static load of a ball [N] over its angle [degrees]."""
    angle = 2 * np.pi * np.arange(PLACES) / PLACES
    return DataFrame(
        {
            "angle_deg": np.degrees(angle),
            "mean_load_n": mean_loads_n(run),
            "static_load_n": static_loads(run.model, angle),
        }
    )


# ---- the figures


def _facts(run: BearingRun) -> list[str]:
    """Return the condition of a run and the length of its record, for the note of a figure."""
    return [bearing_sentences.condition(run.scene), f"{run.record.duration_s:.3g} s"]


_WORDS_OF_BANDS = {
    name: bearing_sentences.BAND_WORDS[band]
    for band, name in bearing_sentences.QUANTITY_NAMES.items()
}
FIGURES = {
    "spectrum": FigureKind(spectrum, spectrum_table, is_single=True, is_written=True),
    "quantities": FigureKind(
        partial(quantities, words=_WORDS_OF_BANDS), quantity_table, is_shown=has_sweep
    ),
    "acceleration_signal": FigureKind(acceleration_signal, signal_table, is_single=True),
    "velocity_spectrogram": FigureKind(velocity_spectrogram, is_single=True),
    "envelope": FigureKind(envelope, envelope_table, is_single=True, is_written=True),
    "load_distribution": FigureKind(
        load_distribution, load_table, is_single=True, is_written=True, is_polar=True
    ),
    "ball_forces": FigureKind(ball_forces, is_single=True, is_written=True),
}
