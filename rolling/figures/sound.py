"""Figures of the sound of runs: third octaves, spectra, spectrogram and release power."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics import plots
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, DENSE, Lines, envelope, unit_prefix
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import Spectrogram, line_spectrum, welch
from acoustics.spectrum import spectrogram as spectrogram_of
from acoustics.weighting import a_weighting_db
from rolling.figures import picture
from rolling.figures.picture import axes_of, finish, listed, subject
from rolling.results import labels
from rolling.results.run_errors import total_errors_db
from rolling.results.run_result import Run
from rolling.results.runs_table import SEED

_Levels = Mapping[str, float | None]


# ---- runs compared


def third_octaves(
    runs: Run | Iterable[Run], ax: Axes | None = None, a_weighted: bool = False
) -> Axes:
    """Plot third-octave levels of runs with their standard uncertainty.

    Up to three runs with an error estimate have a second mark at the level less its error.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    a_weighted : bool
        If true, plot A-weighted levels, otherwise levels without weighting (Z). Default: false.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, over nominal mid frequency, Hz.

    References
    ----------
    IEC 61260-1:2014 for the bands; Bendat and Piersol, Random Data, for the uncertainty.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.third_octaves([run], a_weighted=True)
    """
    shown = listed(runs)
    curves = [
        (label, _bands(run, a_weighted), run.sound.uncertainty.third_octave_db)
        for label, run in zip(labels.labels(shown), shown, strict=True)
    ]
    errors = [
        (total, run.summary["grid_error_uncertainty_db"])
        if (total := total_errors_db(run.summary))
        else None
        for run in shown
    ]
    # A band that is too uncertain in any run is grey in all of them.
    shortest = min(run.sound.duration / run.laps for run in shown)
    is_ordered = _is_ordered(shown)
    ax = plots.third_octaves(axes_of(ax), curves, shortest, errors=errors, ordered=is_ordered)
    facts = picture.distance_and_duration(shown)
    if len(shown) <= plots.FEW and any(run.sound.levels.level_db is not None for run in shown):
        facts.append("bars: standard uncertainty of Gaussian noise of that duration")
    weighting = "A" if a_weighted else "Z"
    if a_weighted:
        ax.set_ylabel("A-weighted sound pressure level [dB re 20 µPa]")
    return finish(ax, f"Third octaves, {weighting}-weighted: {subject(shown)}", facts)


def third_octave_table(runs: Sequence[Run], a_weighted: bool = False) -> pd.DataFrame:
    """Tabulate third octaves of runs with their uncertainties and errors [dB]."""
    frames = []
    for run in runs:
        columns = {"level_db": _bands(run, a_weighted)}
        columns["standard_uncertainty_db"] = run.sound.uncertainty.third_octave_db
        if total := total_errors_db(run.summary):
            for kind in ("grid_error", "grid_error_uncertainty", "solver_error", "subgrid_error"):
                name = kind.replace("uncertainty", "standard_uncertainty")
                columns[f"{name}_db"] = run.summary[f"{kind}_db"]
            columns["corrected_level_db"] = total
        frame = band_table(columns)
        if total:
            frame["corrected_level_db"] = frame["level_db"] - frame["corrected_level_db"]
        frame.insert(0, "run", run.label)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def spectrum(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot A-weighted line spectra of the sound pressure of runs.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with A-weighted line levels, dB re 20 µPa, over frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectrum([run])
    """
    shown = listed(runs)
    lines = picture.common("lines of", [1 / run.sound.duration for run in shown], "Hz")
    facts = [*picture.distance_and_duration(shown), lines]
    spectra = [_a_weighted_lines(run) for run in shown]
    level = "A-weighted line level [dB re 20 µPa]"
    return _spectrum(shown, spectra, ax, ("A-weighted spectrum", level), facts)


def power_density(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot power spectral densities of the sound pressure of runs, by Welch's method.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with density levels, dB re (20 µPa)²/Hz, over frequency, Hz.

    References
    ----------
    P. Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70-73.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.power_density([run])
    """
    shown = listed(runs)
    densities = [welch(run.sound.pressure, run.sound.sample_rate) for run in shown]
    facts = [
        *picture.distance_and_duration(shown),
        f"Welch, {densities[0].window.capitalize()}",
        picture.common("ENBW", [density.enbw_hz for density in densities], "Hz"),
    ]
    lines = [Lines.audible(density.frequency_hz, _level(density.psd)) for density in densities]
    words = "Power spectral density", "density level [dB re (20 µPa)²/Hz]"
    return _spectrum(shown, lines, ax, words, facts)


def spectrum_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate the A-weighted lines [dB re 20 µPa] of runs over frequency [Hz]."""
    frames = []
    for run in runs:
        lines = _a_weighted_lines(run)
        columns = {"frequency_hz": lines.frequency_hz, "a_weighted_line_level_db": lines.level_db}
        frames.append(pd.DataFrame({"run": run.label, **columns}))
    return pd.concat(frames, ignore_index=True).replace(-np.inf, np.nan)


def _spectrum(
    shown: list[Run], lines: list[Lines], ax: Axes | None, words: tuple[str, str], facts: list[str]
) -> Axes:
    """Draw spectra of runs with their labels, under a title and the label of y."""
    curves = [*zip(labels.labels(shown), lines, strict=True)]
    ax = plots.spectrum(axes_of(ax), curves, ordered=_is_ordered(shown))
    ax.set_ylabel(words[1])
    if plots.drawn_as_means(curves):
        facts = [*facts, f"drawn bold: mean over 1/{plots.PER_OCTAVE} octave"]
    return finish(ax, f"{words[0]}: {subject(shown)}", facts)


# ---- a run over time


def release_power(run: Run, ax: Axes | None = None, among: Iterable[Run] = ()) -> Axes:
    """Plot the release power of a run over time, with its mean.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    among : iterable of Run
        Runs whose power axes span the same share of their means. Default: the run alone.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with release power over time, in units that suit the numbers.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.release_power(run)
    """
    sound, compared = run.sound, listed(among) or [run]
    # The axis spans at least 2 % of the mean, so that a steady power looks steady.
    extremes = np.array([[other.sound.power.min(), other.sound.power.max()] for other in compared])
    means = np.array([[other.sound.mean_power or 1.0] for other in compared])
    shares = extremes / means
    low, high = min(0.99, float(shares.min())), max(1.01, float(shares.max()))
    second, time_unit = unit_prefix(sound.duration)
    watt, unit = unit_prefix(float(np.abs(sound.power).max()))
    time, power = envelope(sound.time, sound.power)
    mean, ax = sound.mean_power / watt, axes_of(ax)
    width = 0.5 if len(time) > DENSE else 1.5
    ax.plot(time / second, power / watt, color=COLOURS[0], linewidth=width, label="release power")
    ax.axhline(mean, color=COLOURS[1], linestyle="--", label=f"mean {rounded(mean, 4)} {unit}W")
    room = 0.05 * (high - low) * mean or 1.0
    ax.set(xlim=(0.0, sound.duration / second), ylim=(low * mean - room, high * mean + room))
    ax.set(xlabel=f"time [{time_unit}s]", ylabel=f"release power [{unit}W]")
    ax.ticklabel_format(useOffset=False)
    facts = [*picture.distance_and_duration([run])[1:], "q and distance are not in it"]
    if run.scene.dynamics is not None:
        moved = any(caveat["key"] == "moving_load_release" for caveat in run.summary["caveats"])
        facts.append(f"under the {'moving' if moved else 'constant'} load")
    if len(compared) > 1:
        facts.append(f"axis from {rounded(low, 3)} to {rounded(high, 3)} of the mean for all runs")
    if len(time) < len(sound.time):
        facts.append("minimum and maximum in each of 1,500 columns")
    return finish(ax, f"Release power: {run.title}", facts)


def release_power_table(run: Run) -> pd.DataFrame:
    """Tabulate the release power [W] of a run over time [s]."""
    return pd.DataFrame({"time_s": run.sound.time, "release_power_w": run.sound.power})


def spectrogram(run: Run, ax: Axes | None = None, among: Iterable[Run] = ()) -> Axes:
    """Plot the spectrogram of the sound pressure of a run, with a colour bar.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    among : iterable of Run
        Runs that share the scale of colours. Default: the run alone.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with density level, dB re (20 µPa)²/Hz, over time and frequency.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectrogram(run)
    """
    shown = _spectrogram(run)
    compared = map(_spectrogram, listed(among) or [run])
    limits = plots.level_limits(level for other in compared for level in _extremes(other))
    ax = plots.spectrogram(axes_of(ax), shown, run.sound.duration, limits)
    facts = [
        *picture.distance_and_duration([run]),
        f"{shown.window.capitalize()} frames of {rounded(shown.frame_s * 1e3, 3)} ms"
        f" every {rounded(shown.hop_s * 1e3, 3)} ms",
        f"ENBW {picture.number(shown.enbw_hz)} Hz",
        "rows of 1/12 octave",
    ]
    return finish(ax, f"Spectrogram: {run.title}", facts)


# The colours of a spectrogram depend on all runs compared, so each is kept as long as its run.
_spectrograms: WeakKeyDictionary[Run, Spectrogram] = WeakKeyDictionary()


def _spectrogram(run: Run) -> Spectrogram:
    """Return the spectrogram of a run, computed once."""
    if run not in _spectrograms:
        s = run.sound
        _spectrograms[run] = spectrogram_of(s.pressure, s.sample_rate, s.highest, s.closed)
    return _spectrograms[run]


def _extremes(shown: Spectrogram) -> list[float]:
    """Return the extreme levels [dB] without the lowest fiftieth, the gaps between peaks."""
    known = shown.level_db[np.isfinite(shown.level_db)]
    return [float(np.quantile(known, 0.02)), float(known.max())] if len(known) else []


# ---- numbers of runs


def band_table(columns: Mapping[str, _Levels]) -> pd.DataFrame:
    """Tabulate levels by band [dB] over nominal mid frequency [Hz]."""
    table = pd.DataFrame(columns, [*BAND_NAMES], dtype=float)
    table.insert(0, "mid_frequency_hz", MID_HZ)
    return table


def _bands(run: Run, a_weighted: bool) -> _Levels:
    """Return third-octave levels of a run by band [dB re 20 µPa]."""
    levels = run.sound.levels
    return levels.third_octave_a_db if a_weighted else levels.third_octave_db


def _a_weighted_lines(run: Run) -> Lines:
    """Return the A-weighted lines of a run [dB re 20 µPa]."""
    frequency, square = line_spectrum(run.sound.pressure, run.sound.sample_rate)
    return Lines.audible(frequency, _level(square) + a_weighting_db(frequency))


def _level(mean_square: Array) -> Array:
    """Return levels of mean squares [Pa²] in dB re 20 µPa, -inf for silence."""
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(mean_square / P_REF_PA**2))


def _is_ordered(runs: Sequence[Run]) -> bool:
    """Return whether runs differ in one swept number, other than the seed, that ascends."""
    keys = {tuple(run.values) for run in runs}
    if len(keys) != 1 or len(key := keys.pop()) != 1 or key == (SEED,):
        return False
    values: list[Any] = [run.values[key[0]] for run in runs]
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    return len(numbers) == len(values) and all(a < b for a, b in pairwise(numbers))
