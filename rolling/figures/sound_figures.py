"""Pictures of the sound of runs: spectra, third octaves, spectrogram, release power, levels."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.axes import Axes

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.level import P_REF_PA
from acoustics.plots import Lines
from acoustics.spectrogram import Spectrogram, spectrogram
from acoustics.spectrum import Psd, article_line_level_db, line_spectrum, welch
from acoustics.weighting import a_weighting_db
from rolling._typing import Array
from rolling.figures import captions
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
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult

# label, levels [dB], standard uncertainty [dB]
LevelCurve = tuple[str, list[float | None], list[float | None]]

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
    """A kind of spectrum in the pictures, with a function that computes its lines for a run."""

    name: str
    title: str
    ylabel: str
    lines: Callable[[RunResult], Lines]


A_WEIGHTED = SpectrumKind(
    "spectrum",
    "A-weighted spectrum",
    "A-weighted line level [dB re 20 µPa]",
    lambda run: views(run).a_weighted,
)
ARTICLE = SpectrumKind(
    "article_spectrum",
    "Per FFT line as Lee, Kim & Kim (2025)",
    "A-weighted line level [dB re 1 pW/m²]",
    lambda run: views(run).article,
)
PSD = SpectrumKind(
    "psd",
    "Power spectral density",
    "density level [dB re (20 µPa)²/Hz]",
    lambda run: views(run).psd,
)


def spectra(shown: Sequence[RunResult], among: Sequence[RunResult]) -> Iterator[Picture]:
    """Draw the spectra of runs, one curve per run, on the axes of all the runs `among`."""
    distance, duration = captions.distance(shown), captions.duration(shown)
    lines = captions.common("lines of", [1 / run.sound.duration for run in shown], "Hz")
    yield _spectrum(A_WEIGHTED, [distance, duration, lines], shown, among)
    steady = [run for run in shown if run.sound.constant_speed]
    if steady:
        q = captions.common("q =", [run.scene.sound.q for run in steady])
        facts = [distance, q, duration, lines, "lines of noise fall as T grows"]
        yield _spectrum(
            ARTICLE, facts, steady, [run for run in among if run.sound.constant_speed], shown
        )
    densities = [views(run).welch for run in shown]
    facts = [
        distance,
        duration,
        f"Welch, {densities[0].window.capitalize()}",
        captions.common("lines of", [density.line_width_hz for density in densities], "Hz"),
        captions.common("ENBW", [density.enbw_hz for density in densities], "Hz"),
    ]
    yield _spectrum(PSD, facts, shown, among)


def _spectrum(
    kind: SpectrumKind,
    facts: Sequence[str],
    shown: Sequence[RunResult],
    among: Sequence[RunResult],
    subject: Sequence[RunResult] = (),
) -> Picture:
    """Draw a kind of spectrum; its title names the `subject`, or by default the runs shown."""
    curves = [(run.label, kind.lines(run)) for run in shown]
    limits = sound_plots.level_limits(level for run in among for level in kind.lines(run).extremes)
    mean = f"mean over 1/{sound_plots.PER_OCTAVE} octave"
    if sound_plots.drawn_as_means(curves):
        facts = [*facts, f"drawn bold: {mean}"]

    def draw(ax: Axes) -> None:
        sound_plots.spectrum(ax, curves, limits)
        ax.set_ylabel(kind.ylabel)

    title = f"{kind.title}: {captions.subject(subject or shown)}"
    columns = _spectrum_columns(curves, kind.ylabel, mean)
    return single(kind.name, title, captions.note(facts), columns, draw, captions.remarks(shown))


def _spectrum_columns(
    curves: Sequence[tuple[str, Lines]], ylabel: str, mean: str
) -> dict[str, Array]:
    """Return the lines, and any means that are drawn, as columns of a table."""
    columns = _line_columns(
        [(label, lines.frequency_hz, lines.level_db) for label, lines in curves], "", ylabel
    )
    means = [(label, *lines.mean) for label, lines in sound_plots.drawn_as_means(curves)]
    return columns | _line_columns(means, f"{mean}: ", ylabel)


def _line_columns(
    curves: Iterable[tuple[str, Array, Array]], kind: str, ylabel: str
) -> dict[str, Array]:
    """Return frequencies and levels as columns of a table.

    Levels at equal frequencies share a column of frequencies.
    """
    columns: dict[str, Array] = {}
    previous: Array | None = None
    for label, frequency, level in curves:
        if previous is None or not np.array_equal(previous, frequency):
            name = f"{kind}frequency of {label} [Hz]" if columns else f"{kind}frequency [Hz]"
            previous = columns[name] = frequency
        columns[f"{kind}{label}: {ylabel}"] = level
    return columns


# ---- third octaves


def third_octaves(shown: Sequence[RunResult], among: Sequence[RunResult]) -> Iterator[Picture]:
    """Draw unweighted and A-weighted third octaves of runs, one curve per run.

    The axes are common to all the runs `among`.
    """
    yield _third_octaves(
        "third_octaves", "Z", lambda run: run.sound.levels.third_octave_db, shown, among
    )
    yield _third_octaves(
        "third_octaves_a", "A", lambda run: run.sound.levels.third_octave_a_db, shown, among
    )


def _third_octaves(
    name: str,
    weighting: str,
    levels: Callable[[RunResult], Mapping[str, float | None]],
    shown: Sequence[RunResult],
    among: Sequence[RunResult],
) -> Picture:
    curves = [(run.label, levels(run), run.sound.uncertainty.third_octave_db) for run in shown]
    limits = sound_plots.level_limits(level for run in among for level in levels(run).values())
    columns: dict[str, Array] = {"mid frequency [Hz]": MID_HZ}
    for label, by_name, uncertainty in curves:
        columns[f"{label} [dB re 20 µPa]"] = captions.gaps(by_name[band] for band in BAND_NAMES)
        columns[f"{label}: standard uncertainty [dB]"] = captions.gaps(
            uncertainty[band] for band in BAND_NAMES
        )
    for run in shown:
        columns |= _error_columns(run, levels(run))
    errors = [run.errors.for_plots if run.errors else None for run in shown]
    # A band that is too uncertain in any run is grey in all of them.
    shortest = min(unrepeated_seconds(run) for run in among)
    facts = [captions.distance(shown), captions.duration(shown)]
    if len(curves) <= sound_plots.FEW and any(
        run.sound.levels.level_db is not None for run in shown
    ):
        facts.append(_UNCERTAINTY)
    return single(
        name,
        f"Third octaves, {weighting}-weighted: {captions.subject(shown)}",
        captions.note(facts),
        columns,
        lambda ax: sound_plots.third_octaves(ax, curves, shortest, limits, errors),
        captions.remarks(shown),
    )


def _error_columns(run: RunResult, levels: Mapping[str, float | None]) -> dict[str, Array]:
    """Return the errors of band levels and the corrected levels as columns; none without errors."""
    errors = run.errors
    if errors is None or errors.levels is None:
        return {}
    return {
        f"{run.label}: {name}": captions.gaps(values[band] for band in BAND_NAMES)
        for name, values in (
            ("grid error [dB]", errors.grid_db),
            ("standard uncertainty of the grid error [dB]", errors.grid_uncertainty_db),
            ("solver error [dB]", errors.solver_db),
            ("corrected level [dB re 20 µPa]", errors.corrected_db(levels)),
        )
    }


def unrepeated_seconds(run: RunResult) -> float:
    """Return the duration of the part of a record that does not repeat itself [s]."""
    return run.sound.duration * min(1.0, run.result.solved_steps / run.result.done_steps)


# ---- pictures over time


def spectrogram_of(run: RunResult, among: Sequence[RunResult]) -> Picture:
    """Draw the spectrogram of a run with the colours of all the runs `among`."""
    shown = views(run).spectrogram
    limits = sound_plots.level_limits(
        level for other in among for level in views(other).density_extremes
    )
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
    sound_plots.spectrogram(ax, bar, shown, run.sound.duration, limits)
    width = WIDTH_IN - LEFT_IN - BAR_ROOM_IN
    places = {
        ax: (LEFT_IN, BOTTOM_IN, width, _TALL_IN),
        bar: (LEFT_IN + width + 0.12, BOTTOM_IN, BAR_IN, _TALL_IN),
    }
    lay_out(figure, title, note, places)
    return Picture("spectrogram", f"{title}: {note}", figure, {})


def release_power(run: RunResult, among: Sequence[RunResult]) -> Picture:
    """Draw the release power of a run, with the limits that all the runs `among` share."""
    sound = run.sound
    shares = np.array(
        [sound_plots.power_share(other.sound.power, other.sound.mean_power) for other in among]
    )
    share = float(shares[:, 0].min()), float(shares[:, 1].max())
    facts = [captions.duration([run]), "q and distance are not in it"]
    if len(among) > 1:
        facts.append(
            f"axis from {share[0]:.3g} to {share[1]:.3g} of the mean, as for all runs compared"
        )
    if sound_plots.is_thinned(sound.time):
        facts.append("drawn: minimum and maximum in each of 1,500 columns")
    return single(
        "release_power",
        f"Release power: {captions.subject([run])}",
        captions.note(facts),
        {"time [s]": sound.time, "release power [W]": sound.power},
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

    @property
    def columns(self) -> dict[str, Array]:
        """The curves as columns of a table."""
        columns: dict[str, Array] = {}
        for label, level, uncertainty in self.curves:
            curve = f"{self.name}, {label}" if label else self.name
            columns[f"{curve} [dB re 20 µPa]"] = captions.gaps(level)
            columns[f"{curve}: standard uncertainty [dB]"] = captions.gaps(uncertainty)
        return columns


def swept_key(runs: Sequence[RunResult]) -> str | None:
    """Return the first key whose value differs between runs.

    The result is None if the swept values do not distinguish the runs.
    """
    for key in runs[0].values:
        if all(key in run.values for run in runs) and len({run.values[key] for run in runs}) > 1:
            distinct = {(run.scene.name, *run.values.items()) for run in runs}
            return key if len(distinct) == len(runs) else None
    return None


def level_panels(key: str, runs: Sequence[RunResult], x: Array) -> list[LevelPanel]:
    """Return LAeq and LZeq of runs at the values x (n,) of a swept key, with gaps."""
    several = len({run.scene.name for run in runs}) > 1

    def others(run: RunResult) -> tuple[str, tuple[tuple[str, float], ...]]:
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
    columns: dict[str, Array] = {xlabel: x}
    for index, panel in enumerate(panels):
        columns |= panel.columns
        ax = figure.add_subplot()
        sound_plots.level_against(ax, x, panel.curves, xlabel, limits)
        ax.set_ylabel("" if index else "level [dB re 20 µPa]")
        ax.tick_params(labelleft=not index)
        ax.text(0.03, 0.97, panel.name, transform=ax.transAxes, va="top", fontweight="bold")
        places[ax] = (LEFT_IN + index * (width + gap), BOTTOM_IN, width, _TALL_IN)
    title = f"Levels against {word}: {captions.subject(runs)}"
    note = captions.note([captions.distance(runs), captions.duration(runs), _UNCERTAINTY])
    lay_out(figure, title, note, places)
    return Picture("levels", f"{title}: {note}", figure, columns, captions.remarks(runs))


def _level(mean_square: Array) -> Array:
    with np.errstate(divide="ignore"):
        return 10 * np.log10(mean_square / P_REF_PA**2)
