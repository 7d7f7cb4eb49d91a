"""Pictures of the sound of runs: spectra, third octaves, spectrogram, release power, levels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.level import P_REF_PA
from acoustics.plots import Lines
from acoustics.spectrogram import Spectrogram, spectrogram
from acoustics.spectrum import Psd, article_line_level_db, line_spectrum, welch
from acoustics.weighting import a_weighting_db
from rolling._typing import Array
from rolling.figures import captions
from rolling.figures.order import is_ordered
from rolling.figures.picture import (
    BAR_IN,
    BAR_ROOM_IN,
    BOTTOM_IN,
    LEFT_IN,
    RIGHT_IN,
    WIDTH_IN,
    Box,
    Picture,
    blank,
    lay_out,
    single,
)
from rolling.scene.sweep import Value
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult

# label, levels [dB], standard uncertainty [dB]
LevelCurve = tuple[str, list[float | None], list[float | None]]
# label, levels [dB] and standard uncertainty [dB] by band
BandCurve = tuple[str, Mapping[str, float | None], Mapping[str, float | None]]

_TALL_IN = 3.5  # height of axes
_UNCERTAINTY = "bars: standard uncertainty of Gaussian noise of that duration"


class SoundViews:
    """Spectra of a run's sound, each computed when it is first used."""

    def __init__(self, run: RunResult) -> None:
        self._sound, self._scene = run.sound, run.scene

    @cached_property
    def a_weighted(self) -> Lines:
        """A-weighted line levels, dB re 20 µPa."""
        frequency, square = line_spectrum(self._sound.pressure, self._sound.sample_rate)
        return Lines.audible(frequency, _level(square) + a_weighting_db(frequency))

    @cached_property
    def article(self) -> Lines:
        """A-weighted line levels as Lee, Kim & Kim (2025) plot them, dB re 1 pW/m²."""
        power = self._sound.power
        rate = len(power) / self._sound.duration
        sound = self._scene.sound
        frequency, level = article_line_level_db(power, rate, sound.distance_m, sound.q)
        if (
            self._sound.levels.level_db is None
        ):  # the lines of a constant power contain rounding errors only
            level = np.full_like(level, -np.inf)
        return Lines.audible(frequency, level)

    @cached_property
    def welch(self) -> Psd:
        """Power spectral density, Pa²/Hz."""
        return welch(self._sound.pressure, self._sound.sample_rate)

    @cached_property
    def psd(self) -> Lines:
        """Levels of the power spectral density, dB re (20 µPa)²/Hz."""
        return Lines.audible(self.welch.frequency_hz, _level(self.welch.psd))

    @cached_property
    def spectrogram(self) -> Spectrogram:
        """Spectral density against time."""
        sound = self._sound
        return spectrogram(sound.pressure, sound.sample_rate, sound.highest, sound.closed)

    @cached_property
    def density_extremes(self) -> list[float]:
        """The extreme levels of the spectrogram, dB, without the lowest fiftieth.

        The lowest fiftieth consists of gaps between peaks.
        """
        shown = self.spectrogram.level_db[np.isfinite(self.spectrogram.level_db)]
        return [float(np.quantile(shown, 0.02)), float(shown.max())] if len(shown) else []


# The axes of a figure depend on the curves of all runs, so the curves are kept as long as the run.
_views_by_run: WeakKeyDictionary[RunResult, SoundViews] = WeakKeyDictionary()


def views(run: RunResult) -> SoundViews:
    """Return the spectra of a run, kept as long as the run."""
    if run not in _views_by_run:
        _views_by_run[run] = SoundViews(run)
    return _views_by_run[run]


# ---- spectra


@dataclass(frozen=True)
class SpectrumKind:
    """A kind of spectrum in the pictures, with a function that computes its lines for a run.

    column : str. Name of its levels in a table.
    """

    name: str
    title: str
    ylabel: str
    column: str
    lines: Callable[[RunResult], Lines]


A_WEIGHTED = SpectrumKind(
    "spectrum",
    "A-weighted spectrum",
    "A-weighted line level [dB re 20 µPa]",
    "a_weighted_line_level_db",
    lambda run: views(run).a_weighted,
)
ARTICLE = SpectrumKind(
    "article_spectrum",
    "Per FFT line as Lee, Kim & Kim (2025)",
    "A-weighted line level [dB re 1 pW/m²]",
    "a_weighted_line_level_db_re_1_pw_m2",
    lambda run: views(run).article,
)
PSD = SpectrumKind(
    "psd",
    "Power spectral density",
    "density level [dB re (20 µPa)²/Hz]",
    "density_level_db_per_hz",
    lambda run: views(run).psd,
)
_WEIGHTINGS: dict[str, Callable[[RunResult], Mapping[str, float | None]]] = {
    "Z": lambda run: run.sound.levels.third_octave_db,
    "A": lambda run: run.sound.levels.third_octave_a_db,
}


# ---- scales


@dataclass(frozen=True)
class CurveScales:
    """Scales that the spectra and third octaves of compared runs share.

    Parameters
    ----------
    spectra : dict of pairs. Limits of the level axis [dB] by name of the kind.
    third_octaves : dict of pairs. Limits of the level axis [dB] by weighting.
    shortest_s : float, s. Duration of the shortest record without its repetitions. A band that is
        too uncertain in any run is grey in all of them.
    """

    spectra: Mapping[str, tuple[float, float]]
    third_octaves: Mapping[str, tuple[float, float]]
    shortest_s: float

    @classmethod
    def of(cls, runs: Sequence[RunResult]) -> CurveScales:
        """Derive the scales from all runs that are compared."""
        spectra = {}
        for kind in (A_WEIGHTED, ARTICLE, PSD):
            drawn = [run for run in runs if kind is not ARTICLE or run.sound.constant_speed]
            spectra[kind.name] = sound_plots.level_limits(
                level for run in drawn for level in kind.lines(run).extremes
            )
        bands = {
            weighting: sound_plots.level_limits(
                level for run in runs for level in levels_of(run).values()
            )
            for weighting, levels_of in _WEIGHTINGS.items()
        }
        return cls(spectra, bands, min(unrepeated_seconds(run) for run in runs))


@dataclass(frozen=True)
class TimeScales:
    """Scales that the pictures over time of compared runs share.

    Parameters
    ----------
    density : pair of float, dB. Levels of the first and the last colour of a spectrogram.
    power_share : pair of float. Limits of the power axis as shares of the mean.
    runs : int. Number of runs that are compared.
    """

    density: tuple[float, float]
    power_share: tuple[float, float]
    runs: int

    @classmethod
    def of(cls, runs: Sequence[RunResult]) -> TimeScales:
        """Derive the scales from all runs that are compared."""
        density = sound_plots.level_limits(
            level for run in runs for level in views(run).density_extremes
        )
        shares = np.array(
            [sound_plots.power_share(run.sound.power, run.sound.mean_power) for run in runs]
        )
        return cls(density, (float(shares[:, 0].min()), float(shares[:, 1].max())), len(runs))


# ---- pictures of spectra


def spectra(shown: Sequence[RunResult], scales: CurveScales) -> Iterator[Picture]:
    """Draw the spectra of runs, one curve per run, on common scales."""
    distance, duration = captions.distance(shown), captions.duration(shown)
    lines = captions.common("lines of", [1 / run.sound.duration for run in shown], "Hz")
    yield _spectrum(A_WEIGHTED, [distance, duration, lines], shown, scales)
    steady = [run for run in shown if run.sound.constant_speed]
    if steady:
        q = captions.common("q =", [run.scene.sound.q for run in steady])
        facts = [distance, q, duration, lines, "lines of noise fall as T grows"]
        yield _spectrum(ARTICLE, facts, steady, scales, shown)
    densities = [views(run).welch for run in shown]
    facts = [
        distance,
        duration,
        f"Welch, {densities[0].window.capitalize()}",
        captions.common("lines of", [density.line_width_hz for density in densities], "Hz"),
        captions.common("ENBW", [density.enbw_hz for density in densities], "Hz"),
    ]
    yield _spectrum(PSD, facts, shown, scales)


def _spectrum(
    kind: SpectrumKind,
    facts: Sequence[str],
    shown: Sequence[RunResult],
    scales: CurveScales,
    subject: Sequence[RunResult] = (),
) -> Picture:
    """Draw a kind of spectrum; its title names the `subject`, or by default the runs shown."""
    curves = [(run.label, kind.lines(run)) for run in shown]
    if sound_plots.drawn_as_means(curves):
        facts = [*facts, f"drawn bold: mean over 1/{sound_plots.PER_OCTAVE} octave"]

    def draw(ax: Axes) -> None:
        sound_plots.spectrum(ax, curves, scales.spectra[kind.name], ordered=is_ordered(shown))
        ax.set_ylabel(kind.ylabel)

    title = f"{kind.title}: {captions.subject(subject or shown)}"
    columns = _spectrum_columns(curves, kind.column)
    return single(kind.name, title, captions.note(facts), columns, draw)


def _spectrum_columns(curves: Sequence[tuple[str, Lines]], level: str) -> dict[str, NDArray[Any]]:
    """Return the lines of each run, and behind them the means where they are drawn, as a table."""
    means = dict(sound_plots.drawn_as_means(curves))
    parts = [
        (label, smoothed, *of_kind)
        for label, lines in curves
        for smoothed, of_kind in (
            (0, (lines.frequency_hz, lines.level_db)),
            *([(1, lines.mean)] if label in means else []),
        )
    ]
    counts = [len(frequency) for _, _, frequency, _ in parts]
    columns: dict[str, NDArray[Any]] = {
        "smoothed": np.repeat([smoothed for _, smoothed, _, _ in parts], counts),
        "frequency_hz": np.concatenate([frequency for _, _, frequency, _ in parts]),
        level: np.concatenate([level_db for _, _, _, level_db in parts]),
    }
    if len(curves) == 1:
        return columns
    return {"run": np.repeat([label for label, _, _, _ in parts], counts), **columns}


# ---- third octaves


def third_octaves(shown: Sequence[RunResult], scales: CurveScales) -> Iterator[Picture]:
    """Draw unweighted and A-weighted third octaves of runs, one curve per run."""
    yield _third_octaves("third_octaves", "Z", shown, scales)
    yield _third_octaves("third_octaves_a", "A", shown, scales)


def _third_octaves(
    name: str, weighting: str, shown: Sequence[RunResult], scales: CurveScales
) -> Picture:
    levels_of = _WEIGHTINGS[weighting]
    curves = [(run.label, levels_of(run), run.sound.uncertainty.third_octave_db) for run in shown]
    errors = [run.errors.for_plots if run.errors else None for run in shown]
    columns = _band_columns(curves, "a_weighted_level_db" if weighting == "A" else "level_db")
    columns |= _error_columns(shown, levels_of)
    facts = [captions.distance(shown), captions.duration(shown)]
    if len(curves) <= sound_plots.FEW and any(
        run.sound.levels.level_db is not None for run in shown
    ):
        facts.append(_UNCERTAINTY)
    limits = scales.third_octaves[weighting]
    return single(
        name,
        f"Third octaves, {weighting}-weighted: {captions.subject(shown)}",
        captions.note(facts),
        columns,
        lambda ax: sound_plots.third_octaves(
            ax, curves, scales.shortest_s, limits, errors, ordered=is_ordered(shown)
        ),
    )


def _band_columns(curves: Sequence[BandCurve], level: str) -> dict[str, NDArray[Any]]:
    """Return the bands of each run as a table."""
    columns: dict[str, NDArray[Any]] = {
        "mid_frequency_hz": np.tile(MID_HZ, len(curves)),
        level: captions.gaps(levels[band] for _, levels, _ in curves for band in BAND_NAMES),
        "standard_uncertainty_db": captions.gaps(
            uncertainty[band] for _, _, uncertainty in curves for band in BAND_NAMES
        ),
    }
    if len(curves) == 1:
        return columns
    return {"run": np.repeat([label for label, _, _ in curves], len(BAND_NAMES)), **columns}


_ERROR_COLUMNS = (
    "grid_error_db",
    "grid_error_standard_uncertainty_db",
    "solver_error_db",
    "corrected_level_db",
)


def _error_columns(
    shown: Sequence[RunResult], levels_of: Callable[[RunResult], Mapping[str, float | None]]
) -> dict[str, NDArray[Any]]:
    """Return the errors of band levels and the corrected levels as columns of a table.

    The cells of a run without errors are empty; without any errors there are no columns.
    """
    if not any(run.errors and run.errors.levels for run in shown):
        return {}
    nothing: Mapping[str, float | None] = dict.fromkeys(BAND_NAMES)
    rows = [
        (
            (
                errors.grid_db,
                errors.grid_uncertainty_db,
                errors.solver_db,
                errors.corrected_db(levels_of(run)),
            )
            if (errors := run.errors) is not None and errors.levels is not None
            else (nothing,) * len(_ERROR_COLUMNS)
        )
        for run in shown
    ]
    return {
        name: captions.gaps(row[k][band] for row in rows for band in BAND_NAMES)
        for k, name in enumerate(_ERROR_COLUMNS)
    }


def unrepeated_seconds(run: RunResult) -> float:
    """Return the duration of the part of a record that does not repeat itself [s]."""
    return run.sound.duration * min(1.0, run.result.solved_steps / run.result.done_steps)


# ---- pictures over time


def spectrogram_of(run: RunResult, scales: TimeScales) -> Picture:
    """Draw the spectrogram of a run with the colours of all runs compared."""
    shown = views(run).spectrogram
    title = f"Spectrogram: {captions.subject([run])}"
    frames = f"frames of {shown.frame_s * 1e3:.3g} ms every {shown.hop_s * 1e3:.3g} ms"
    note = captions.note(
        [
            captions.distance([run]),
            captions.duration([run]),
            f"{shown.window.capitalize()} {frames}",
            f"lines of {captions.number(shown.line_width_hz)} Hz, "
            f"ENBW {captions.number(shown.enbw_hz)} Hz",
            "rows of 1/12 octave",
        ]
    )
    figure = blank()
    ax, bar = figure.add_subplot(), figure.add_subplot()
    sound_plots.spectrogram(ax, bar, shown, run.sound.duration, scales.density)
    width = WIDTH_IN - LEFT_IN - BAR_ROOM_IN
    places = {
        ax: (LEFT_IN, BOTTOM_IN, width, _TALL_IN),
        bar: (LEFT_IN + width + 0.12, BOTTOM_IN, BAR_IN, _TALL_IN),
    }
    lay_out(figure, title, note, places)
    return Picture("spectrogram", f"{title}: {note}", figure, {})


def release_power(run: RunResult, scales: TimeScales) -> Picture:
    """Draw the release power of a run, with limits that all compared runs share."""
    sound, share = run.sound, scales.power_share
    facts = [captions.duration([run]), "q and distance are not in it"]
    if scales.runs > 1:
        facts.append(
            f"axis from {share[0]:.3g} to {share[1]:.3g} of the mean, as for all runs compared"
        )
    if sound_plots.is_thinned(sound.time):
        facts.append("drawn: minimum and maximum in each of 1,500 columns")
    return single(
        "release_power",
        f"Release power: {captions.subject([run])}",
        captions.note(facts),
        {"time_s": sound.time, "release_power_w": sound.power},
        lambda ax: sound_plots.power(
            ax, sound.time, sound.power, sound.mean_power, sound.duration, share
        ),
    )


# ---- levels against a swept quantity


@dataclass(frozen=True)
class LevelPanel:
    """Curves of a level against a swept quantity.

    Each combination of the other quantities has a curve.
    """

    name: str
    curves: list[LevelCurve]


def swept_key(runs: Sequence[RunResult]) -> str | None:
    """Return the first key whose value differs between runs.

    The result is None if the swept values do not distinguish the runs.
    """
    for key in runs[0].values:
        numbers = all(isinstance(run.values.get(key), int | float) for run in runs)
        if numbers and len({run.values[key] for run in runs}) > 1:
            distinct = {(run.scene.name, *run.values.items()) for run in runs}
            return key if len(distinct) == len(runs) else None
    return None


def level_panels(key: str, runs: Sequence[RunResult], x: Array) -> list[LevelPanel]:
    """Return LAeq and LZeq of runs at the values x (n,) of a swept key, with gaps."""
    several = len({run.scene.name for run in runs}) > 1

    def others(run: RunResult) -> tuple[str, tuple[tuple[str, Value], ...]]:
        return run.scene.name, tuple(
            (name, value) for name, value in run.values.items() if name != key
        )

    laeq, lzeq = LevelPanel("LAeq", []), LevelPanel("LZeq", [])
    for (scene, values), group in groupby(sorted(runs, key=others), key=others):
        label = ", ".join([scene] * several + [labels.worded(*value) for value in values])
        sounds = {run.values[key]: run.sound for run in group}
        for panel, level in ((laeq, "laeq_db"), (lzeq, "level_db")):
            level_db = [
                getattr(sounds[value].levels, level) if value in sounds else None for value in x
            ]
            spread_db = [
                getattr(sounds[value].uncertainty, level) if value in sounds else None
                for value in x
            ]
            panel.curves.append((label, level_db, spread_db))
    return [laeq, lzeq]


def levels(key: str, runs: Sequence[RunResult]) -> Picture:
    """Draw LAeq and LZeq against a swept quantity.

    Each combination of the other quantities has a curve.
    """
    x = np.array(sorted({run.values[key] for run in runs}))
    word, unit = labels.named(key)
    xlabel = f"{word} [{unit}]" if unit else word
    panels = level_panels(key, runs, x)
    limits = sound_plots.level_limits(
        level for panel in panels for _, levels_db, _ in panel.curves for level in levels_db
    )
    figure = blank()
    gap = 0.3
    width = (WIDTH_IN - LEFT_IN - RIGHT_IN - gap) / 2
    places: dict[Axes, Box] = {}
    for index, panel in enumerate(panels):
        ax = figure.add_subplot()
        sound_plots.level_against(ax, x, panel.curves, xlabel, limits)
        ax.set_ylabel("" if index else "level [dB re 20 µPa]")
        ax.tick_params(labelleft=not index)
        ax.text(0.03, 0.97, panel.name, transform=ax.transAxes, va="top", fontweight="bold")
        places[ax] = (LEFT_IN + index * (width + gap), BOTTOM_IN, width, _TALL_IN)
    title = f"Levels against {word}: {captions.subject(runs)}"
    note = captions.note([captions.distance(runs), captions.duration(runs), _UNCERTAINTY])
    lay_out(figure, title, note, places)
    return Picture("levels", f"{title}: {note}", figure, _level_columns(key, x, panels))


def _level_columns(key: str, x: Array, panels: Sequence[LevelPanel]) -> dict[str, NDArray[Any]]:
    """Return the levels of all curves as a table: a row for each value of each curve."""
    labels_of_curves = [label for label, _, _ in panels[0].curves]
    columns: dict[str, NDArray[Any]] = {}
    if len(labels_of_curves) > 1:
        columns["curve"] = np.repeat(labels_of_curves, len(x))
    columns[key.rpartition(".")[2]] = np.tile(x, len(labels_of_curves))
    for panel in panels:
        name = panel.name.lower()
        columns[f"{name}_db"] = captions.gaps(db for _, levels, _ in panel.curves for db in levels)
        columns[f"{name}_standard_uncertainty_db"] = captions.gaps(
            db for _, _, spread in panel.curves for db in spread
        )
    return columns


def _level(mean_square: Array) -> Array:
    with np.errstate(divide="ignore"):
        return 10 * np.log10(mean_square / P_REF_PA**2)
