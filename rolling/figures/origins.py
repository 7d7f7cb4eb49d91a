"""Figures of the origins of a sound: waves of the surface, turns of the sphere, and passes."""

from dataclasses import asdict
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from acoustics.arrays import instance
from acoustics.modulation import envelope_spectrum
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, MARKERS
from rolling.figures.picture import axes_of, distance_text, duration_text, finish, level_of
from rolling.numbers import views
from rolling.numbers.ball_numbers import DB_A, PassNumbers
from rolling.results.run_result import Run
from rolling.sound.wavelengths import FOLLOWS, MIN_SHARE

MULTIPLES = 10  # of the turn's frequency that are shown and marked


# ---- waves of the surface


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
    >>> ax = rolling.plot.wavelengths(run)
    """
    instance("run", run, Run)
    table = wavelength_table(run)
    table = table[table["energy_share"] >= MIN_SHARE]
    low = table["from_um"]
    all_percent = 100 * table["energy_share"]
    linear_percent = all_percent * table["linear_share"].fillna(0.0)
    ax = axes_of(ax)
    _draw_shares(ax, low, all_percent, alpha=0.4, label="at the frequencies of these waves")
    if linear_percent.any():
        _draw_shares(ax, low, linear_percent, alpha=1.0, label="following these waves")
    ax.set_xscale("log")
    ax.set_xticks(low, [f"{edge:g}" for edge in low])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("wavelength along the track, lower edge of the octave [µm]")
    ax.set_ylabel("part of the A-weighted energy [%]")
    of = level_of([run])
    return finish(ax, f"Waves that make the {of.name}: {run.title}", [reading(run)])


def _draw_shares(ax: Axes, low: pd.Series, percent: pd.Series, *, alpha: float, label: str) -> None:
    """Draw bars over octaves of wavelength by their lower edges."""
    ax.bar(
        low,
        percent,
        width=0.92 * low,
        bottom=0,
        align="edge",
        color=COLOURS[0],
        alpha=alpha,
        label=label,
    )


def reading(run: Run) -> str:
    """State the octave of wavelength that makes most of the sound of a run, and the doubts."""
    most = max(run.wavelength_octaves, key=lambda octave: octave.energy_share)
    linear = most.linear_share
    waves = f"{most.from_um:g} to {most.to_um:g} µm"
    percent = f"{100 * most.energy_share:.0f} % of the A-weighted energy"
    if most.fall_db is None:
        made = f"Waves of {waves} make {percent}; without them the record is silent."
    elif linear is None or linear >= FOLLOWS:
        made = f"Waves of {waves} make {percent}; without them LAeq falls by {most.fall_db:.1f} dB."
    else:
        made = (
            f"{percent} sounds at the frequencies of waves of {waves}, but only "
            f"{100 * linear:.0f} % of the approach follows these waves: the nonlinear contact "
            "makes the rest from other waves."
        )
    speed = "speed" if run.sound.constant_speed else "mean speed"
    sentences = [
        made,
        f"A wave along the track sounds at the {speed} over its length, to first order.",
    ]
    if run.vibration_sound and run.vibration_sound.motion.flight_share > 0:
        sentences.append(
            "Impacts spread energy over all frequencies, so these shares are doubtful."
        )
    if linear is None and run.sound.source == "release":
        sentences.append("The release is not linear in the heights, so falls are estimates.")
    elif linear is None:
        sentences.append("Whether the approach follows these waves is unknown.")
    return " ".join(sentences)


def wavelength_table(run: Run) -> pd.DataFrame:
    """Tabulate the octaves of wavelength of a run, short waves first; NaN is unknown."""
    if not run.wavelength_octaves:
        raise ValueError(f"{run.title}: is silent or falls, so it has no octaves of wavelength")
    return pd.DataFrame(run.wavelength_octaves).astype(float)


# ---- turns of the sphere


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
        The record has less than two turns at a constant speed, or is silent.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.modulation(run)
    """
    instance("run", run, Run)
    table = modulation_table(run)
    turns = _heard_turns(run)
    low_hz, high_hz = turns.band_hz
    turn_hz = turns.frequency_hz
    ax = axes_of(ax)
    for multiple in range(1, MULTIPLES + 1):
        name = "turns per second and its multiples" if multiple == 1 else None
        ax.axvline(multiple * turn_hz, color=COLOURS[1], linestyle=":", linewidth=1, label=name)
    ax.plot(table["frequency_hz"], table["modulation"], color=COLOURS[0], linewidth=1)
    ax.set(xlim=(0.0, (MULTIPLES + 0.5) * turn_hz), ylim=(0.0, None))
    ax.set(xlabel="frequency of the modulation [Hz]", ylabel="modulation of the envelope [-]")
    of = level_of([run])
    facts = [
        f"{rounded(turn_hz, 4)} turns per second",
        f"the marked lines have {rounded(turns.prominence)} times the floor under"
        " them (noise: 1 to 3 times)",
        f"envelope of the octave from {low_hz:.0f} to {high_hz:.0f} Hz, where turns stand out most",
        duration_text([run]),
    ]
    return finish(ax, f"Modulation of the {of.name} by the turns: {run.title}", facts)


def modulation_table(run: Run) -> pd.DataFrame:
    """Tabulate the modulation [-] of the octave of the turns over frequency [Hz]."""
    turns = _heard_turns(run)
    sound = run.sound
    spectrum = envelope_spectrum(sound.pressure, sound.sample_rate, turns.band_hz, sound.closed)
    table = pd.DataFrame({"frequency_hz": spectrum.frequency_hz, "modulation": spectrum.modulation})
    return table[table["frequency_hz"] <= (MULTIPLES + 0.5) * turns.frequency_hz]


class HeardTurns(NamedTuple):
    """Turns of a ball that modulate an octave: its ends, their frequency, and their prominence."""

    band_hz: tuple[float, float]
    frequency_hz: float
    prominence: float


def _heard_turns(run: Run) -> HeardTurns:
    """Return the turns of the ball of a run that are heard, or raise ValueError."""
    turns = run.numbers.turns
    if turns is not None and turns.band_hz and turns.frequency_hz and turns.prominence is not None:
        low_hz, high_hz = turns.band_hz
        return HeardTurns((low_hz, high_hz), turns.frequency_hz, turns.prominence)
    reason = None if turns is None else turns.reason
    raise ValueError(
        f"{run.title}: has no modulation by turns of the sphere: "
        f"{reason or 'its sphere has no surface'}"
    )


# ---- passes over a plate that remembers


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
    >>> ax = rolling.plot.running_in(worn)
    """
    instance("run", run, Run)
    passes = _passes(run)
    table = running_in_table(run)
    ax = axes_of(ax)
    cells = views.columns(passes[0])
    shown = {column: cell.number_field for column, cell in cells.items() if cell.number_field.word}
    for k, (column, number_field) in enumerate(shown.items()):
        values = table[column].to_numpy(dtype=float)
        if not np.isfinite(values).all() or not values[0]:
            continue  # silent, or nothing has sunk
        if number_field.unit == DB_A:
            over_first_db = values - values[0]
        else:
            over_first_db = 10 * np.log10(values / values[0])
        unit = number_field.shown_unit or number_field.unit
        first = f"{rounded(values[0] * number_field.factor, 3)} {unit} in pass 1"
        ax.plot(
            table["pass"],
            over_first_db,
            color=COLOURS[k],
            marker=MARKERS[k],
            label=f"{number_field.word}, {first}",
        )
    if (table["plastic_work_j"] > 0).any():
        _draw_plastic_work(ax, table)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("number of the pass")
    ax.set_ylabel("change since pass 1 [dB]")
    facts = [
        distance_text([run]),
        duration_text([run]),
        "powers and depths as 10 lg of their ratio to pass 1",
    ]
    return finish(ax, f"Running-in: {run.title}", facts)


def _draw_plastic_work(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the plastic work of passes [J] on a logarithmic axis at the right."""
    work = table["plastic_work_j"]
    style = f"{MARKERS[4]}--"
    right = ax.twinx()
    right.semilogy(table["pass"], work.where(work > 0), style, color=COLOURS[4])
    right.set_ylabel("plastic work [J]")
    ax.plot([], [], style, color=COLOURS[4], label="plastic work, right axis")


def running_in_table(run: Run) -> pd.DataFrame:
    """Tabulate levels [dB], release power [W], plastic work [J] and depth [um] of passes."""
    table = pd.DataFrame([asdict(row) for row in _passes(run)])
    table.insert(0, "pass", np.arange(len(table)) + 1)
    return table


def _passes(run: Run) -> tuple[PassNumbers, ...]:
    """Return the numbers of the passes of a run, or raise ValueError."""
    if not run.numbers.passes:
        raise ValueError(f"{run.title}: has no passes, its plate has no memory")
    return run.numbers.passes
