"""The pictures of a run and of runs compared. Depends on acoustics.plots and rolling.plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.level import P_REF_PA
from acoustics.spectrum import article_line_level_db, line_spectrum
from acoustics.weighting import a_weighting_db
from rolling import plots, simulate
from rolling.heard import Heard
from rolling.picture import Picture, blank, single

Array = NDArray[np.float64]


def of_run(one: Heard) -> Iterator[Picture]:
    """Spectra, release power, surface and contact of one run."""
    yield from of_runs([one])
    title = f"{one.scene.name}, {one.label}"
    sound = one.sound
    yield single(
        "release_power",
        f"Release power of {title} against time",
        {"time [s]": sound.time, "release power [W]": sound.power},
        lambda ax: sound_plots.power(ax, sound.time, sound.power, title),
    )
    yield _surface(one, title)
    if one.result.snapshot is not None:
        yield _contact(one, title)


def of_runs(runs: Sequence[Heard]) -> Iterator[Picture]:
    """A-weighted spectrum, the article's view of it and third octaves, one curve per run, on the same axes."""
    first = runs[0]
    at = f"{first.scene.name}, at {first.scene.sound.distance_m:g} m"
    width = f"lines of {1 / first.sound.duration:.3g} Hz, T = {first.sound.duration:.3g} s"
    lines, article = [], []
    for one in runs:
        sound = one.sound
        frequency, square = line_spectrum(sound.pressure, sound.sample_rate)
        with np.errstate(divide="ignore"):
            level = 10 * np.log10(square / P_REF_PA**2) + a_weighting_db(frequency)
        lines.append((one.label, frequency, level))
        if one.scene.motion.is_constant:
            rate = len(sound.power) / sound.duration
            q = one.scene.sound.q
            article.append((one.label, *article_line_level_db(sound.power, rate, one.scene.sound.distance_m, q)))
    yield _lines("spectrum", f"{at}: A-weighted spectrum, {width}", "A-weighted level [dB re 20 µPa]", lines)
    if article:
        yield _lines(
            "article_spectrum",
            f"{at}: per FFT line as Lee, Kim & Kim (2025), {width}",
            "A-weighted line level [dB re 1 pW/m²]",
            article,
        )
    bands = [(one.label, one.sound.levels.third_octave_db) for one in runs]
    columns = {"mid frequency [Hz]": MID_HZ}
    columns |= {
        f"{label} [dB]": np.array([levels[name] for name in BAND_NAMES], dtype=float) for label, levels in bands
    }
    shortest = min(one.sound.duration for one in runs)
    title = f"{at}: third octaves, Z"
    yield single("third_octaves", title, columns, lambda ax: sound_plots.third_octaves(ax, bands, shortest, title))


def levels(name: str, xlabel: str, curves: dict[str, list[tuple[float, float | None, float | None]]]) -> Picture:
    """Levels against the first swept quantity, a pair of curves (A and Z) per combination of the others."""
    x = np.array(sorted({point[0] for points in curves.values() for point in points}))
    drawn = []
    for others, points in curves.items():
        by_x = {point[0]: point for point in points}
        for column, which in ((1, "LAeq"), (2, "level")):
            values = [by_x[at][column] if at in by_x else None for at in x]
            drawn.append((f"{which}, {others}" if others else which, values))
    columns = {xlabel: x} | {f"{label} [dB re 20 µPa]": np.array(values, dtype=float) for label, values in drawn}
    title = f"{name}: sound level"

    def draw(ax: Axes) -> None:
        sound_plots.level_against(ax, x, drawn, xlabel, title)
        ax.set_ylabel("level [dB re 20 µPa]")

    return single("levels", title, columns, draw)


def _lines(name: str, title: str, ylabel: str, curves: list[tuple[str, Array, Array]]) -> Picture:
    columns: dict[str, Array] = {}
    for label, frequency, level in curves:
        columns |= {f"{label}: frequency [Hz]": frequency, f"{label}: {ylabel}": level}

    def draw(ax: Axes) -> None:
        sound_plots.spectrum(ax, curves, title)
        ax.set_ylabel(ylabel)

    return single(name, title, columns, draw)


def _surface(one: Heard, title: str) -> Picture:
    figure = blank(9, 4.2)
    heights = simulate.heights(one.scene)
    plots.surface(figure.subplots(), heights, one.scene.spacing, f"{title}: surface")
    return Picture("surface", f"Heights of the surface of {title}", figure, {})


def _contact(one: Heard, title: str) -> Picture:
    snapshot, spacing = one.result.snapshot, one.scene.spacing
    assert snapshot is not None
    figure = blank(11, 4.4)
    left, right = figure.subplots(1, 2)
    where = f"{title}: sphere at {snapshot.distance * 1e6:.4g} µm"
    plots.contact_map(left, snapshot, snapshot.pressure * 1e-9, spacing, "pressure [GPa]", where)
    plots.contact_map(right, snapshot, snapshot.deflection * 1e6, spacing, "deflection [µm]", where)
    return Picture("contact", f"Pressure and deflection of {where}", figure, {})
