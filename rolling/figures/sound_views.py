"""Spectra of the sound of runs, each computed once, and the scales that compared runs share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from acoustics import plots as sound_plots
from acoustics.level import P_REF_PA
from acoustics.plots import Lines
from acoustics.spectrogram import Spectrogram, spectrogram
from acoustics.spectrum import Psd, article_line_level_db, line_spectrum, welch
from acoustics.weighting import a_weighting_db
from rolling._typing import Array
from rolling.simulation.run_result import RunResult


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
WEIGHTINGS: dict[str, Callable[[RunResult], Mapping[str, float | None]]] = {
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
                level for run in runs for level in _drawn_levels(run, levels_of(run))
            )
            for weighting, levels_of in WEIGHTINGS.items()
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


def unrepeated_seconds(run: RunResult) -> float:
    """Return the duration of the part of a record that does not repeat itself [s]."""
    return run.sound.duration * min(1.0, run.result.solved_steps / run.result.done_steps)


def _drawn_levels(run: RunResult, levels: Mapping[str, float | None]) -> list[float | None]:
    """Return the levels of the bands [dB], and the levels less their errors if there are any."""
    corrected = run.errors.corrected_db(levels) if run.errors else {}
    return [*levels.values(), *corrected.values()]


def _level(mean_square: Array) -> Array:
    with np.errstate(divide="ignore"):
        return 10 * np.log10(mean_square / P_REF_PA**2)
