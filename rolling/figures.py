"""The picture files of a run and of runs compared, drawn without a display. Depends on acoustics.plots and rolling.plots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.level import P_REF_PA
from acoustics.spectrum import article_line_level_db, line_spectrum
from acoustics.weighting import a_weighting_db
from rolling import plots, simulate
from rolling.scenario import Scene
from rolling.simulate import Snapshot
from rolling.sound import ContactSound
from rolling.store import write_bytes

Array = NDArray[np.float64]


def write_run(folder: Path, scene: Scene, label: str, sound: ContactSound, snapshot: Snapshot | None) -> None:
    """Spectrum, the article's spectrum, third octaves, release power, contact maps and surface of one run."""
    title = f"{scene.name}, {label}"
    write_comparison(folder, [(label, scene, sound)])
    _one(folder / "release_power.png", lambda ax: sound_plots.power(ax, sound.time, sound.power, title))
    heights = simulate.heights(scene)
    figure = _figure(9, 4.2)
    plots.surface(figure.subplots(), heights, scene.spacing, f"{title}: surface")
    _save(figure, folder / "surface.png")
    if snapshot is not None:
        figure = _figure(11, 4.4)
        left, right = figure.subplots(1, 2)
        at = f"sphere at {snapshot.distance * 1e6:.4g} µm"
        pressure, deflection = snapshot.pressure * 1e-9, snapshot.deflection * 1e6
        plots.contact_map(left, snapshot, pressure, scene.spacing, "pressure [GPa]", f"{title}: {at}")
        plots.contact_map(right, snapshot, deflection, scene.spacing, "deflection [µm]", f"{title}: {at}")
        _save(figure, folder / "contact.png")


def write_comparison(folder: Path, runs: Sequence[tuple[str, Scene, ContactSound]]) -> None:
    """A-weighted spectrum, the article's view of it and third octaves, one curve per run, on the same axes."""
    _, scene, first = runs[0]
    lines, article, bands = [], [], []
    for label, each, sound in runs:
        frequency, square = line_spectrum(sound.pressure, sound.sample_rate)
        with np.errstate(divide="ignore"):
            level = 10 * np.log10(square / P_REF_PA**2) + a_weighting_db(frequency)
        lines.append((label, frequency, level))
        if each.motion.is_constant:
            rate = len(sound.power) / sound.duration
            article.append((label, *article_line_level_db(sound.power, rate, each.sound.distance_m, each.sound.q)))
        bands.append((label, sound.levels.third_octave_db))
    at = f"{scene.name}, at {scene.sound.distance_m:g} m"
    width = f"lines of {1 / first.duration:.3g} Hz, T = {first.duration:.3g} s"
    _one(
        folder / "spectrum.png",
        lambda ax: _with_unit(
            sound_plots.spectrum(ax, lines, f"{at}: A-weighted spectrum, {width}"), "A-weighted level [dB re 20 µPa]"
        ),
    )
    if article:
        _one(
            folder / "article_spectrum.png",
            lambda ax: _with_unit(
                sound_plots.spectrum(ax, article, f"{at}: per FFT line as Lee, Kim & Kim (2025), {width}"),
                "A-weighted line level [dB re 1 pW/m²]",
            ),
        )
    _one(
        folder / "third_octaves.png",
        lambda ax: sound_plots.third_octaves(ax, bands, min(s.duration for _, _, s in runs), f"{at}: third octaves, Z"),
    )


def write_levels(
    folder: Path, name: str, xlabel: str, curves: dict[str, list[tuple[float, float | None, float | None]]]
) -> None:
    """Levels against the first swept quantity, a pair of curves (A and Z) per combination of the others."""
    x = sorted({point[0] for points in curves.values() for point in points})
    drawn = []
    for others, points in curves.items():
        by_x = {point[0]: point for point in points}
        for column, which in ((1, "LAeq"), (2, "level")):
            values = [by_x[at][column] if at in by_x else None for at in x]
            drawn.append((f"{which}, {others}" if others else which, values))
    _one(
        folder / "levels.png",
        lambda ax: _with_unit(
            sound_plots.level_against(ax, x, drawn, xlabel, f"{name}: sound level"), "level [dB re 20 µPa]"
        ),
    )


def _with_unit(ax: Axes, ylabel: str) -> Axes:
    ax.set_ylabel(ylabel)
    return ax


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _one(path: Path, draw: Callable[[Axes], Axes]) -> None:
    figure = _figure(8.5, 4.8)
    draw(figure.subplots())
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    from io import BytesIO

    content = BytesIO()
    figure.savefig(content, format="png", dpi=110)
    write_bytes(path, content.getvalue())
