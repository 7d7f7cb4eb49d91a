"""Pictures of the sound of runs: spectra, third octaves, spectrogram and release power."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.plots import Lines
from rolling.figures import captions
from rolling.figures.order import is_ordered
from rolling.figures.picture import (
    BAR_IN,
    BAR_ROOM_IN,
    BOTTOM_IN,
    LEFT_IN,
    WIDTH_IN,
    Picture,
    blank,
    lay_out,
    single,
)
from rolling.figures.sound_views import (
    A_WEIGHTED,
    ARTICLE,
    PSD,
    WEIGHTINGS,
    CurveScales,
    SpectrumKind,
    TimeScales,
    views,
)
from rolling.simulation.run_result import RunResult

# label, levels [dB] and standard uncertainty [dB] by band
BandCurve = tuple[str, Mapping[str, float | None], Mapping[str, float | None]]

TALL_IN = 3.5  # height of axes
UNCERTAINTY = "bars: standard uncertainty of Gaussian noise of that duration"


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
    levels_of = WEIGHTINGS[weighting]
    curves = [(run.label, levels_of(run), run.sound.uncertainty.third_octave_db) for run in shown]
    errors = [run.errors.for_plots if run.errors else None for run in shown]
    columns = _band_columns(curves, "a_weighted_level_db" if weighting == "A" else "level_db")
    columns |= _error_columns(shown, levels_of)
    facts = [captions.distance(shown), captions.duration(shown)]
    if len(curves) <= sound_plots.FEW and any(
        run.sound.levels.level_db is not None for run in shown
    ):
        facts.append(UNCERTAINTY)
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
        ax: (LEFT_IN, BOTTOM_IN, width, TALL_IN),
        bar: (LEFT_IN + width + 0.12, BOTTOM_IN, BAR_IN, TALL_IN),
    }
    lay_out(figure, title, note, places)
    return Picture("spectrogram", f"{title}: {note}", figure, {})


def release_power(run: RunResult, scales: TimeScales) -> Picture:
    """Draw the release power of a run, with limits that all compared runs share."""
    sound, share = run.sound, scales.power_share
    facts = [captions.duration([run]), "q and distance are not in it"]
    if run.scene.dynamics is not None:
        moved = any(each["key"] == "moving_load_release" for each in run.summary["caveats"])
        facts.append(f"under the {'moving' if moved else 'constant'} load")
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
