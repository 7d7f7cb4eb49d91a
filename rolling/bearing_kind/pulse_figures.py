"""Figures in which pulses of a bearing are seen: the motion of its ring over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from pandas import DataFrame

from acoustics import plots
from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, unit_prefix
from acoustics.plot_style import envelope as thinned
from acoustics.spectrum import Spectrogram
from acoustics.spectrum import spectrogram as spectrogram_of
from rolling.bearing_kind.bearing_sentences import condition
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.figures.picture import axes_of, finish
from rolling.results import labels

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

TURNS = 2  # of the cage, which figures over time show
REFERENCE_M_S = 1e-9  # of levels of velocity (ISO 1683)
_FRAMES_IN_PASS = 4  # between two pulses of the fault that comes most often
_LEAST_FRAME_S = 1e-3  # in which a resonance of some kilohertz is still told from others
_GAPS = 0.05  # share of the levels below the first colour: the gaps between peaks


def acceleration_signal(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the acceleration of the ring along x over two turns of the cage.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with acceleration, m/s², over time, ms.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.acceleration_signal(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax)
    shown = shown_samples(run)
    time_ms = np.asarray(1e3 * np.arange(shown) / run.record.rate_hz, dtype=float)
    x, y = thinned(time_ms, run.record.seen_acceleration_m_s2[:shown, 0])
    ax.plot(
        x,
        y,
        color=COLOURS[0],
        linewidth=0.7,
        label=f"radially, {run.scene.seen_at('along the load')}",
    )
    ax.set_xlim(0, time_ms[-1])
    ax.set(xlabel="time [ms]", ylabel="acceleration of the ring [m/s²]")
    return finish(ax, f"Signal of the {run.moving} ring: {run_title(run)}", _facts(run))


def signal_table(run: BearingRun) -> DataFrame:
    """Tabulate the acceleration of the ring [m/s2] over two turns of the cage."""
    shown = shown_samples(run)
    columns = dict(zip("xyz", run.record.seen_acceleration_m_s2[:shown].T, strict=True))
    table = {"time_s": np.arange(shown) / run.record.rate_hz}
    return DataFrame(table | {f"acceleration_{axis}_m_s2": row for axis, row in columns.items()})


def velocity_spectrogram(run: BearingRun, ax: Axes | None = None) -> Axes:
    """Plot the spectrogram of the velocity of the ring along x over two turns of the cage.

    Its frames are shorter than the time between two pulses of a fault.

    Parameters
    ----------
    run : BearingRun
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with density level, dB re (1 nm/s)²/Hz, over time and frequency.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.velocity_spectrogram(turning)
    """
    instance("run", run, SolvedBearing)
    ax = axes_of(ax)
    shown = _spectrogram(run)
    levels_db = plots.resolved_levels(shown)
    known = levels_db[np.isfinite(levels_db)]
    ends = [float(np.quantile(known, _GAPS)), float(known.max())] if len(known) else []
    limits = plots.level_limits(ends)
    duration_s = shown_samples(run) / run.record.rate_hz
    plots.spectrogram(ax, shown, duration_s, limits, unit="dB re (1 nm/s)²/Hz")
    ax.set_ylim(np.log10(plots.lowest_resolved(shown)), np.log10(shown.edges_hz[-1]))
    facts = [
        *_facts(run),
        f"frames of {rounded(shown.frame_s * 1e3, 2)} ms ({shown.window.capitalize()})",
    ]
    return finish(ax, f"Pulses of the {run.moving} ring: {run_title(run)}", facts)


def shown_samples(run: BearingRun) -> int:
    """Return the number of samples in two turns of the cage, or in a record that is shorter."""
    wanted = round(TURNS * run.record.rate_hz / run.kinematics.cage_hz)
    return max(2, min(len(run.record.velocity_m_s), wanted))


def _spectrogram(run: BearingRun) -> Spectrogram:
    """Return the spectrogram of the radial velocity along the load."""
    speeds = run.kinematics
    passes_hz = max(speeds.ball_pass_outer_hz, speeds.ball_pass_inner_hz, 2 * speeds.ball_spin_hz)
    velocity: Array = run.record.seen_velocity_m_s[: shown_samples(run), 0]
    return spectrogram_of(
        np.asarray(velocity, dtype=float),
        run.record.rate_hz,
        closed=False,
        frame_s=max(_LEAST_FRAME_S, 1 / (_FRAMES_IN_PASS * passes_hz)),
        reference=REFERENCE_M_S,
    )


def run_title(run: BearingRun) -> str:
    """Return the scene of a run with its label."""
    return labels.title(run.scene.name, run.label)


def _facts(run: BearingRun) -> list[str]:
    """Return the condition of a run and how long it is seen, for the note of a figure."""
    seconds, prefix = unit_prefix(shown_samples(run) / run.record.rate_hz)
    duration = shown_samples(run) / run.record.rate_hz / seconds
    return [condition(run.scene), f"the first {rounded(duration, 3)} {prefix}s"]
