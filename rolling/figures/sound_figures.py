"""Figures of the sound of runs: third octaves, spectra, spectrogram and release power."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics import plots
from acoustics.arrays import Array, instance
from acoustics.bands import BAND_NAMES, MID_HZ, NOMINAL_HZ
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, DENSE, Lines, envelope, unit_prefix
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import Spectrogram, line_spectrum, welch
from acoustics.spectrum import spectrogram as spectrogram_of
from acoustics.weighting import a_weighting_db
from rolling.figures import picture
from rolling.figures.picture import axes_of, compared, finish, listed, subject
from rolling.numbers.ball_numbers import Source
from rolling.numbers.quantity import BandQuantity
from rolling.results import labels
from rolling.results.labels import SEED
from rolling.results.run_errors import total_errors_db
from rolling.results.run_result import Run
from rolling.sound.contact_sound import ContactSound

_Levels = Mapping[str, float | None]


# ---- runs compared


def third_octaves(
    runs: Run | Iterable[Run],
    ax: Axes | None = None,
    a_weighted: bool = False,
    source: Source | None = None,
) -> Axes:
    """Plot third-octave levels of runs with their standard uncertainty.

    Where the level of up to three runs is off by more than 1 dB by their error estimate, a second
    mark stands at the level less its error. Those of an estimated vibration have the uncertainty
    that their record leaves.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    a_weighted : bool
        If true, plot A-weighted levels, otherwise levels without weighting (Z). Default: false.
    source : vibration or release
        Sound that is shown. Default: what plays, which is the vibration where there is one.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, over nominal mid frequency, Hz.

    Raises
    ------
    ValueError : a run has no sound of this source.

    References
    ----------
    IEC 61260-1:2014 for the bands; Bendat and Piersol, Random Data, for the uncertainty.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.third_octaves([run], a_weighted=True)
    """
    shown = compared(runs)
    sounds = [sound_of(run, source) for run in shown]
    curves = [
        (label, _bands(sound, a_weighted), _spreads(run, sound))
        for label, run, sound in zip(labels.labels(shown), shown, sounds, strict=True)
    ]
    ax = plots.third_octaves(
        axes_of(ax),
        curves,
        # A band that is too uncertain in any run is grey in all of them.
        duration_s=min(run.sound.duration / run.laps for run in shown),
        errors=[_band_errors(run, sound) for run, sound in zip(shown, sounds, strict=True)],
        ordered=_is_ordered(shown),
    )
    of = picture.level_of(shown, [sound.source for sound in sounds])
    facts = [of.meaning, picture.distance_text(shown), picture.duration_text(shown)]
    if len(shown) <= plots.FEW and any(sound.levels.level_db is not None for sound in sounds):
        facts.append("bars: ± standard uncertainty")
    weighted = "A-weighted" if a_weighted else "without weighting"
    ax.set_ylabel(f"{weighted_level(of, a_weighted)} [dB re 20 µPa]")
    return finish(ax, f"Third octaves of the {of.name}, {weighted}: {subject(shown)}", facts)


def weighted_level(of: picture.LevelOf, a_weighted: bool) -> str:
    """Name a level by its weighting and quantity, for an axis."""
    level = "A-weighted level" if a_weighted else "level"
    return f"{level} of the {of.name}"


def third_octaves_a(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot A-weighted third-octave levels of runs, as `third_octaves` does."""
    return third_octaves(runs, ax, a_weighted=True)


def released_third_octaves_a(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot A-weighted third-octave levels of the released power, as `third_octaves` does.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot, each with a released power.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, over nominal mid frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.released_third_octaves_a([run])
    """
    return third_octaves(runs, ax, a_weighted=True, source="release")


def third_octave_table(
    runs: Sequence[Run], a_weighted: bool = False, source: Source | None = None
) -> pd.DataFrame:
    """Tabulate third octaves of runs with their uncertainties and errors [dB]."""
    frames = []
    for run in runs:
        sound = sound_of(run, source)
        columns = {
            "level_db": _bands(sound, a_weighted),
            "standard_uncertainty_db": _spreads(run, sound),
        }
        errors = _band_errors(run, sound)
        if errors is None:
            frame = band_table(columns)
        else:
            bands = run.numbers.bands
            columns |= {
                "grid_error_db": _by_name(bands.grid_error),
                "grid_error_standard_uncertainty_db": errors.uncertainty_db,
                "solver_error_db": _by_name(bands.solver_error),
                "subgrid_error_db": _by_name(bands.subgrid_error),
                "total_error_db": errors.error_db,
            }
            frame = band_table(columns)
            frame["corrected_level_db"] = frame["level_db"] - frame.pop("total_error_db")
        frame.insert(0, "run", run.label)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def third_octave_a_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate A-weighted third octaves of runs with their uncertainties and errors [dB]."""
    return third_octave_table(runs, a_weighted=True)


def released_third_octave_a_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate A-weighted third octaves of the released power of runs [dB]."""
    return third_octave_table(runs, a_weighted=True, source="release")


def spectrum(
    runs: Run | Iterable[Run], ax: Axes | None = None, source: Source | None = None
) -> Axes:
    """Plot A-weighted line spectra of the sound pressure of runs.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    source : vibration or release
        Sound that is shown. Default: what plays, which is the vibration where there is one.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with A-weighted line levels, dB re 20 µPa, over frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.spectrum([run])
    """
    shown = compared(runs)
    sounds = [sound_of(run, source) for run in shown]
    return _spectrum(
        axes_of(ax),
        shown,
        sounds,
        spectra=[_a_weighted_lines(sound) for sound in sounds],
        title="A-weighted spectrum",
        ylabel="A-weighted line level [dB re 20 µPa]",
        facts=[
            picture.common("lines of", [1 / run.sound.duration for run in shown], "Hz"),
        ],
    )


def released_spectrum(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot A-weighted line spectra of the released power of runs, as `spectrum` does.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot, each with a released power.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with A-weighted line levels, dB re 20 µPa, over frequency, Hz.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.released_spectrum([run])
    """
    return spectrum(runs, ax, source="release")


def power_density(
    runs: Run | Iterable[Run], ax: Axes | None = None, source: Source | None = None
) -> Axes:
    """Plot power spectral densities of the sound pressure of runs, by Welch's method.

    Parameters
    ----------
    runs : Run or iterable of Run
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    source : vibration or release
        Sound that is shown. Default: what plays, which is the vibration where there is one.

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
    shown = compared(runs)
    sounds = [sound_of(run, source) for run in shown]
    densities = [welch(sound.pressure, sound.sample_rate) for sound in sounds]
    return _spectrum(
        axes_of(ax),
        shown,
        sounds,
        spectra=[Lines.audible(density.frequency_hz, _level(density.psd)) for density in densities],
        title="Power spectral density",
        ylabel="density level [dB re (20 µPa)²/Hz]",
        facts=[
            f"Welch's method, {densities[0].window.capitalize()} window",
            picture.common("bandwidth", [density.enbw_hz for density in densities], "Hz"),
        ],
    )


def spectrum_table(runs: Sequence[Run], source: Source | None = None) -> pd.DataFrame:
    """Tabulate the A-weighted lines [dB re 20 µPa] of runs over frequency [Hz]."""
    frames = []
    for run in runs:
        lines = _a_weighted_lines(sound_of(run, source))
        columns = {"frequency_hz": lines.frequency_hz, "a_weighted_line_level_db": lines.level_db}
        frames.append(pd.DataFrame({"run": run.label, **columns}))
    return pd.concat(frames, ignore_index=True).replace(-np.inf, np.nan)


def released_spectrum_table(runs: Sequence[Run]) -> pd.DataFrame:
    """Tabulate the A-weighted lines of the released power of runs over frequency [Hz]."""
    return spectrum_table(runs, source="release")


def _spectrum(
    ax: Axes,
    shown: Sequence[Run],
    sounds: Sequence[ContactSound],
    *,
    spectra: Sequence[Lines],
    title: str,
    ylabel: str,
    facts: Sequence[str],
) -> Axes:
    """Draw spectra of runs with the labels of the runs."""
    curves = [*zip(labels.labels(shown), spectra, strict=True)]
    plots.spectrum(ax, curves, ordered=_is_ordered(shown))
    ax.set_ylabel(ylabel)
    of = picture.level_of(shown, [sound.source for sound in sounds])
    facts = [of.meaning, picture.distance_text(shown), picture.duration_text(shown), *facts]
    if plots.drawn_as_means(curves):
        facts.append(f"bold: mean over 1/{plots.PER_OCTAVE} octave")
    return finish(ax, f"{title} of the {of.name}: {subject(shown)}", facts)


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
    instance("run", run, Run)
    sound = run.sound
    others = listed(among) or [run]
    low, high = _power_span(others)
    second, time_prefix = unit_prefix(sound.duration)
    watt, power_prefix = unit_prefix(float(np.abs(sound.power).max()))
    time, power = envelope(sound.time, sound.power)
    mean = sound.mean_power / watt
    margin = 0.05 * (high - low) * mean or 1.0
    is_dense = len(time) > DENSE
    ax = axes_of(ax)
    ax.plot(
        time / second,
        power / watt,
        color=COLOURS[0],
        linewidth=0.5 if is_dense else 1.5,
        alpha=0.7 if is_dense else None,
        label="released power",
    )
    ax.axhline(
        mean,
        color=COLOURS[1],
        linestyle="--",
        label=f"mean {rounded(mean, 4)} {power_prefix}W",
    )
    ax.set(xlim=(0.0, sound.duration / second), ylim=(low * mean - margin, high * mean + margin))
    ax.set(xlabel=f"time [{time_prefix}s]", ylabel=f"released power [{power_prefix}W]")
    ax.ticklabel_format(useOffset=False)
    facts = ["energy that asperities give back per second, of which the fluctuation is sound"]
    if run.scene.dynamics is not None:
        moved = run.numbers.energy.moving_balance_error is not None
        facts.append("under the moving load" if moved else "under the constant load")
    if len(others) > 1:
        facts.append("all runs share the axis, in parts of their means")
    return finish(ax, f"Released power over time: {run.title}", facts)


def _power_span(runs: Sequence[Run]) -> tuple[float, float]:
    """Return the minimum and maximum release power of runs over their means.

    They lie at least 2 % of the mean apart, so that a steady power looks steady.
    """
    minima = [run.sound.power.min() / (run.sound.mean_power or 1.0) for run in runs]
    maxima = [run.sound.power.max() / (run.sound.mean_power or 1.0) for run in runs]
    return min(0.99, float(min(minima))), max(1.01, float(max(maxima)))


def release_power_table(run: Run) -> pd.DataFrame:
    """Tabulate the release power [W] of a run over time [s]."""
    return pd.DataFrame({"time_s": run.sound.time, "release_power_w": run.sound.power})


def spectrogram(run: Run, ax: Axes | None = None, among: Iterable[Run] = ()) -> Axes:
    """Plot the spectrogram of what plays of a run, with a colour bar.

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
    instance("run", run, Run)
    shown = _spectrogram(run)
    extremes = list[float]()
    for other in listed(among) or [run]:
        extremes += _extremes(_spectrogram(other))
    limits = plots.level_limits(extremes)
    ax = plots.spectrogram(axes_of(ax), shown, run.sound.duration, limits)
    of = picture.level_of([run], [sound_of(run).source])
    frame_ms = rounded(shown.frame_s * 1e3, 3)
    facts = [
        of.meaning,
        picture.distance_text([run]),
        f"frames of {frame_ms} ms ({shown.window.capitalize()}), rows of 1/12 octave",
        f"grey: silent, or below {picture.number(plots.lowest_resolved(shown))} Hz (two periods in"
        " a frame)",
    ]
    return finish(ax, f"Spectrogram of the {of.name}: {run.title}", facts)


# The colours of a spectrogram depend on all runs compared, so each is kept as long as its run.
_spectrograms: WeakKeyDictionary[Run, Spectrogram] = WeakKeyDictionary()


def _spectrogram(run: Run) -> Spectrogram:
    """Return the spectrogram of a run, computed once."""
    if run not in _spectrograms:
        sound = sound_of(run)
        _spectrograms[run] = spectrogram_of(
            sound.pressure, sound.sample_rate, sound.highest, sound.closed
        )
    return _spectrograms[run]


def _extremes(shown: Spectrogram) -> list[float]:
    """Return the extreme levels [dB] without the lowest fiftieth, the gaps between peaks."""
    level_db = plots.resolved_levels(shown)
    known = level_db[np.isfinite(level_db)]
    if not len(known):
        return []
    return [float(np.quantile(known, 0.02)), float(known.max())]


# ---- numbers of runs


def band_table(columns: Mapping[str, _Levels]) -> pd.DataFrame:
    """Tabulate levels by band [dB] over nominal and exact mid frequency [Hz]."""
    table = pd.DataFrame(columns, [*BAND_NAMES], dtype=float)
    table.insert(0, "band_hz", NOMINAL_HZ)
    table.insert(1, "mid_frequency_hz", MID_HZ)
    return table


def sound_of(run: Run, source: Source | None = None) -> ContactSound:
    """Return the sound of a source of a run, by default of what plays, at its stated level.

    Raises
    ------
    ValueError : the run has no sound of this source.
    """
    return run.stated(source).along_track


def _bands(sound: ContactSound, a_weighted: bool) -> _Levels:
    """Return third-octave levels of a sound by band [dB re 20 µPa]."""
    return sound.levels.third_octave_a_db if a_weighted else sound.levels.third_octave_db


def _spreads(run: Run, sound: ContactSound) -> _Levels:
    """Return the standard uncertainties of the third octaves of a sound of a run [dB].

    They are those of its record where the run states no others.
    """
    bands = run.numbers.bands
    own = bands.vibration if sound.source == "vibration" else bands.released_power
    if own is None or own.uncertainty is None:
        return sound.uncertainty.third_octave_db
    return own.uncertainty_by_name


def _band_errors(run: Run, sound: ContactSound) -> plots.BandErrors | None:
    """Return the estimated errors of the third octaves of a sound of a run [dB].

    None without an estimate; it is made of the record that is measured.
    """
    errors_db = total_errors_db(run.numbers)
    of_grid = run.numbers.bands.grid_error
    if not errors_db or of_grid is None or sound.source != run.sound.source:
        return None
    return plots.BandErrors(errors_db, of_grid.uncertainty_by_name)


def _by_name(bands: BandQuantity | None) -> _Levels:
    """Return values by band; None where a run does not have them."""
    return dict.fromkeys(BAND_NAMES) if bands is None else bands.by_name


def _a_weighted_lines(sound: ContactSound) -> Lines:
    """Return the A-weighted lines of a sound [dB re 20 µPa]."""
    frequency, square = line_spectrum(sound.pressure, sound.sample_rate)
    return Lines.audible(frequency, _level(square) + a_weighting_db(frequency))


def _level(mean_square: Array) -> Array:
    """Return levels of mean squares [Pa²] in dB re 20 µPa, -inf for silence."""
    with np.errstate(divide="ignore"):
        return np.asarray(10 * np.log10(mean_square / P_REF_PA**2))


def _is_ordered(runs: Sequence[Run]) -> bool:
    """Return whether runs differ in one swept number, other than the seed, that ascends."""
    swept = {tuple(run.values) for run in runs}
    if len(swept) != 1:
        return False
    keys = swept.pop()
    if len(keys) != 1 or keys[0] == SEED:
        return False
    values: list[Any] = [run.values[keys[0]] for run in runs]
    for value in values:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
    return all(value < following for value, following in pairwise(values))
