"""Plots of runs.

Each function draws on the axes that it is given, or on new axes, and returns them.

Examples
--------
>>> import matplotlib.pyplot as plt, rolling
>>> fig, ax = plt.subplots(1, 2)                            # doctest: +SKIP
>>> rolling.plot.third_octaves([run], ax=ax[0])             # doctest: +SKIP
>>> rolling.plot.contact_pressure(run, ax=ax[1])            # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics import plots
from acoustics.level import P_REF_PA
from acoustics.plots import Lines
from acoustics.spectrum import line_spectrum
from acoustics.weighting import a_weighting_db
from rolling.figures import axes
from rolling.scene.scene import Scene
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult
from rolling.surface import scene_surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rolling.scene.scene import Scene

__all__ = ["contact_pressure", "levels", "release_power", "spectrum", "surface", "third_octaves"]


def third_octaves(
    runs: RunResult | Iterable[RunResult], ax: Axes | None = None, a_weighted: bool = False
) -> Axes:
    """Plot third-octave levels of runs with their standard uncertainty.

    Up to three runs with an error estimate have a second mark at the level less its error.

    Parameters
    ----------
    runs : RunResult or iterable of RunResult
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    a_weighted : bool
        If true, plot A-weighted levels, otherwise levels without weighting (Z). Default: false.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, over nominal mid frequency, Hz.
    """
    shown = _listed(runs)
    curves = [
        (
            label,
            run.sound.levels.third_octave_a_db if a_weighted else run.sound.levels.third_octave_db,
            run.sound.uncertainty.third_octave_db,
        )
        for label, run in zip(labels.labels(shown), shown, strict=True)
    ]
    errors = [run.errors.for_plots if run.errors else None for run in shown]
    shortest = min(run.sound.duration for run in shown)
    ax = plots.third_octaves(_axes(ax), curves, shortest, errors=errors)
    if a_weighted:
        ax.set_ylabel("A-weighted sound pressure level [dB re 20 µPa]")
    ax.legend(fontsize="small")
    return ax


def spectrum(runs: RunResult | Iterable[RunResult], ax: Axes | None = None) -> Axes:
    """Plot A-weighted line spectra of the sound pressure of runs.

    Parameters
    ----------
    runs : RunResult or iterable of RunResult
        Runs to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with A-weighted line levels, dB re 20 µPa, over frequency, Hz.
    """
    shown = _listed(runs)
    curves = [
        (label, _a_weighted_lines(run))
        for label, run in zip(labels.labels(shown), shown, strict=True)
    ]
    ax = plots.spectrum(_axes(ax), curves)
    ax.set_ylabel("A-weighted line level [dB re 20 µPa]")
    ax.legend(fontsize="small")
    return ax


def release_power(run: RunResult, ax: Axes | None = None) -> Axes:
    """Plot the release power of a run over time, with its mean.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with release power over time, in units that suit the numbers.
    """
    sound = run.sound
    ax = plots.power(_axes(ax), sound.time, sound.power, sound.mean_power, sound.duration)
    ax.legend(fontsize="small")
    return ax


def contact_pressure(run: RunResult, ax: Axes | None = None) -> Axes:
    """Plot the contact pressure at the snapshot of a run as a map, with a colour bar.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with pressure, GPa, over the plate, µm.

    Raises
    ------
    ValueError
        The run has no snapshot, because its first steps are not solved.
    """
    snapshot = run.result.snapshot
    if snapshot is None:
        raise ValueError(f"{run.title}: has no snapshot, its first steps are not solved")
    pressure = snapshot.pressure * 1e-9
    ax = _axes(ax)
    limits = (0.0, float(pressure.max()))
    return axes.contact_map(
        ax, _bar(ax), snapshot, pressure, run.scene.spacing, limits, "pressure [GPa]"
    )


def surface(shown: RunResult | Scene, ax: Axes | None = None) -> Axes:
    """Plot the heights of the surface of a run or scene as a map, with a colour bar.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with heights, µm, over the first 0.8 mm of the plate, µm.
    """
    scene = shown.scene if isinstance(shown, RunResult) else shown
    ax = _axes(ax)
    return axes.surface(ax, _bar(ax), scene_surface.heights(scene), scene.spacing)


def levels(runs: Iterable[RunResult], key: str, ax: Axes | None = None) -> Axes:
    """Plot LAeq and LZeq of runs against a number of their scenes.

    Parameters
    ----------
    runs : iterable of RunResult
        Runs to plot, such as the runs of a sweep.
    key : str
        Dotted key of the scene, such as `rolling.load_n`.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB re 20 µPa, with their standard uncertainty.

    Raises
    ------
    ValueError
        A scene has no number at the key.
    """
    shown = sorted(_listed(runs), key=lambda run: _number(run.scene, key))
    curves = [
        (
            name,
            [getattr(run.sound.levels, attribute) for run in shown],
            [getattr(run.sound.uncertainty, attribute) for run in shown],
        )
        for name, attribute in (("LAeq", "laeq_db"), ("LZeq", "level_db"))
    ]
    word, unit = labels.named(key)
    x = [_number(run.scene, key) for run in shown]
    ax = plots.level_against(_axes(ax), x, curves, f"{word} [{unit}]" if unit else word)
    ax.set_ylabel("level [dB re 20 µPa]")
    ax.legend(fontsize="small")
    return ax


def _axes(ax: Axes | None) -> Axes:
    """Return the given axes, or new axes in a figure of their own."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def _bar(ax: Axes) -> Axes:
    """Make room for a colour bar beside axes."""
    return ax.inset_axes((1.03, 0.0, 0.05, 1.0))


def _listed(runs: RunResult | Iterable[RunResult]) -> Sequence[RunResult]:
    """Return one or several runs as a list; a dictionary gives its values."""
    if isinstance(runs, dict):
        return [*runs.values()]
    return [*runs] if isinstance(runs, Iterable) else [runs]


def _a_weighted_lines(run: RunResult) -> Lines:
    frequency, square = line_spectrum(run.sound.pressure, run.sound.sample_rate)
    with np.errstate(divide="ignore"):
        level = 10 * np.log10(square / P_REF_PA**2)
    return Lines.audible(frequency, level + a_weighting_db(frequency))


def _number(scene: Scene, key: str) -> float:
    """Read the number at a dotted key of a scene."""
    section, _, last = key.partition(".")
    value: Any = getattr(getattr(scene, section, None), last, None)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ValueError(f"{key}: the scene {scene.name} has no number there")
    return float(value)
