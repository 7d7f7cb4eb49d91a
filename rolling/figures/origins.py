"""Figures of the origins of a sound: waves of the surface, turns of the sphere, and passes."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from acoustics.modulation import envelope_spectrum
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, MARKERS
from rolling.figures.picture import axes_of, distance_and_duration, finish
from rolling.results.run_result import Run
from rolling.results.summary import pass_numbers
from rolling.sound.wavelengths import FOLLOWS, MIN_SHARE

MULTIPLES = 10  # of the turn's frequency that are shown and marked
_CURVES = {  # columns of the table with name, unit and factor of the unit
    "laeq_db": ("LAeq of the release", "dB(A)", 1.0),
    "vibration_estimate_laeq_db": ("LAeq of the vibration, estimated", "dB(A)", 1.0),
    "release_power_mean_w": ("release", "µW", 1e6),
    "depth_um": ("maximum depth", "µm", 1.0),
}


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
    table, ax = wavelength_table(run), axes_of(ax)
    table = table[table["energy_share"] >= MIN_SHARE]
    low, share = table["from_um"], 100 * table["energy_share"]
    linear = share * table["linear_share"].fillna(0.0)
    bars = [(share, 0.4, "at the frequencies of these waves")]
    bars += [(linear, 1.0, "following these waves")] if linear.any() else []
    for height, alpha, label in bars:
        ax.bar(low, height, 0.92 * low, 0, align="edge", color=COLOURS[0], alpha=alpha, label=label)
    ax.set_xscale("log")
    ax.set_xticks(low, [f"{edge:g}" for edge in low])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("wavelength along the track, lower edge of the octave [µm]")
    ax.set_ylabel("part of the A-weighted energy [%]")
    return finish(ax, f"Wavelengths: {run.title}", [reading(run)])


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
    if run.vibration and run.vibration.motion.flight_share > 0:
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
        f"its multiples have {rounded(run.summary['turn_prominence'])} times the floor under them;"
        " noise has 1 to 3 times",
        f"{rounded(turn_hz, 4)} turns per second",
    ]
    return finish(ax, f"Modulation: {run.title}", facts)


def modulation_table(run: Run) -> pd.DataFrame:
    """Tabulate the modulation [-] of the octave of the turns over frequency [Hz]."""
    if not run.summary.get("turn_band_hz"):
        reason = run.summary.get("turn_reason") or "its sphere has no surface"
        raise ValueError(f"{run.title}: has no modulation by turns of the sphere: {reason}")
    (low, high), sound = run.summary["turn_band_hz"], run.sound
    spectrum = envelope_spectrum(sound.pressure, sound.sample_rate, (low, high), sound.closed)
    table = pd.DataFrame({"frequency_hz": spectrum.frequency_hz, "modulation": spectrum.modulation})
    return table[table["frequency_hz"] <= (MULTIPLES + 0.5) * run.summary["turn_hz"]]


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
    table, ax = running_in_table(run), axes_of(ax)
    for k, (column, (name, unit, factor)) in enumerate(_CURVES.items()):
        values = table[column].to_numpy(dtype=float)
        if not np.isfinite(values).all() or not values[0]:
            continue  # silent, or nothing has sunk
        ratio = values - values[0] if unit == "dB(A)" else 10 * np.log10(values / values[0])
        label = f"{name}, {rounded(values[0] * factor, 3)} {unit} in pass 1"
        ax.plot(table["pass"], ratio, color=COLOURS[k], marker=MARKERS[k], label=label)
    work, look = table["plastic_work_j"], f"{MARKERS[4]}--"
    if (work > 0).any():
        right = ax.twinx()
        right.semilogy(table["pass"], work.where(work > 0), look, color=COLOURS[4])
        right.set_ylabel("plastic work [J]")
        ax.plot([], [], look, color=COLOURS[4], label="plastic work, right axis")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("pass")
    ax.set_ylabel("over pass 1 [dB]")
    facts = [*distance_and_duration([run]), "10 lg of release and depth over pass 1"]
    return finish(ax, f"Running-in: {run.title}", facts)


def running_in_table(run: Run) -> pd.DataFrame:
    """Tabulate levels [dB], release power [W], plastic work [J] and depth [um] of passes."""
    if run.result.passes is None:
        raise ValueError(f"{run.title}: has no passes, its plate has no memory")
    table = pd.DataFrame(pass_numbers(run))
    table.insert(0, "pass", np.arange(len(table)) + 1)
    return table
