"""Picture and table of a surface and its parameters by ISO 25178-2."""

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plots import COLOURS
from rolling.figures.picture import DPI, WIDTH_IN, Picture, drawable, finish_grid
from rolling.surface import parameters as iso

_HEIGHT_IN = 7.0
_MOST_NODES = 500  # of a map, in each direction
_LONGEST = 1.6  # times its shorter side, the longer side of a map
_HIDDEN = 0.002  # of the heights at either end, which have no colour of their own
_SHOWN = 1e-4  # of the maximum of a spectrum, the least that is shown
_TITLED = ("Sa", "Sq", "Ssk", "Sku", "Str")
_LOOKS: tuple[dict[str, Any], ...] = (
    {"label": "along", "color": COLOURS[0], "linestyle": "-"},
    {"label": "across", "color": COLOURS[1], "linestyle": "--"},
)


def topography(
    name: str, values: dict[str, float], heights: Array, steps: Array, wrap: bool
) -> Picture:
    """Draw map, material ratio, spectrum and autocorrelation of heights, with the parameters.

    Parameters
    ----------
    name : str
        Name of the surface.
    values : dict
        Its parameters, in SI.
    heights : (m, n) array, m
        Heights along and across, NaN at unmeasured points.
    steps : (2,) array, m
        Node spacings along and across.
    wrap : bool
        Whether the heights are one period of the surface.
    """
    z = 1e6 * iso.about_mean(heights)
    descending = np.sort(z[~np.isnan(z)])[::-1]
    extremes = int(_HIDDEN * len(descending))
    shown = descending[extremes : len(descending) - extremes]
    figure = Figure(figsize=(WIDTH_IN, _HEIGHT_IN), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    (on_map, on_ratio), (on_spectrum, on_correlation) = figure.subplots(2, 2)
    _map(on_map, z, 1e6 * steps, shown)
    _material_ratio(on_ratio, shown, iso.core(descending))
    if values["Sq"] > 0:
        _spectrum(on_spectrum, z, 1e6 * steps, wrap)
        _autocorrelation(on_correlation, z, 1e6 * steps, wrap, 1e6 * values["Sal"])
    else:
        on_spectrum.set_axis_off()
        on_correlation.set_axis_off()
    facts = ", ".join(f"{short} {written(short, values)}" for short in _TITLED)
    title = f"Surface: {name}: {facts.replace(' um', ' µm')}"
    figure.suptitle(drawable(title), x=0.012, ha="left", fontsize=11, parse_math=False)
    rows = [(short, values[short], unit, text) for short, (unit, text) in iso.NAMES.items()]
    table = pd.DataFrame(rows, columns=["parameter", "value", "unit", "meaning"])
    return Picture("surface", figure, table)


def written(short: str, values: dict[str, float]) -> str:
    """Write a parameter with its unit, lengths in um; a dash without a value."""
    value, unit = values[short], iso.NAMES[short][0]
    if unit == "m":
        value, unit = 1e6 * value, "um"
    return "-" if math.isnan(value) else f"{rounded(value, 4)} {unit}".rstrip()


def parameter_lines(values: dict[str, float]) -> list[str]:
    """Write parameters with their units and meanings, one on each line."""
    names = iso.NAMES.items()
    return [f"{short:6}{written(short, values):>12}  {text}" for short, (_, text) in names]


def _map(ax: Axes, z: Array, steps: Array, descending: Array) -> None:
    """Draw heights [um] at the beginning, no longer than 1.6 times their width; a profile whole."""
    shape = np.array(z.shape)
    longest = _LONGEST * min(steps * shape) if min(shape) > 1 else math.inf
    nodes = np.minimum(shape, np.ceil(np.minimum(longest / steps, shape))).astype(int)
    strides = -(-nodes // _MOST_NODES)
    shown = z[: nodes[0] : strides[0], : nodes[1] : strides[1]]
    along, across = strides * steps * shown.shape
    extent = (0.0, along, 0.0, across)
    image = ax.imshow(shown.T, "cividis", origin="lower", interpolation="none", extent=extent)
    image.set_clim(min(descending[-1], -1e-3), max(descending[0], 1e-3))  # above any rounding
    ax.set_aspect("equal" if min(shape) > 1 else "auto")
    ax.set_facecolor("0.7")  # unmeasured points
    ax.figure.colorbar(image, ax=ax, label="height [µm]", shrink=0.8, extend="both")
    ax.set(xlabel="along [µm]", ylabel="across [µm]")


def _material_ratio(ax: Axes, descending: Array, line: tuple[float, float]) -> None:
    """Draw the distribution of heights [um], their material ratio, and the line of the core."""
    ratio = np.linspace(_HIDDEN, 1 - _HIDDEN, 1001)
    curve = descending[np.linspace(0, len(descending) - 1, 1001).round().astype(int)]
    count, edges = np.histogram(descending, 80)
    share, name = 100 * count / count.max(), "distribution of heights"
    ax.stairs(share, edges, orientation="horizontal", fill=True, color="0.8", label=name)
    ax.plot(100 * ratio, curve, color=COLOURS[0], label="material ratio")
    ax.plot((0, 100), line, "--", color=COLOURS[1], label="equivalent line")
    ax.set_xlim(0, 100)
    _finish(ax, "material ratio [%]", "height [µm]")


def _spectrum(ax: Axes, z: Array, steps: Array, wrap: bool) -> None:
    """Draw the rms height [um] of each octave of wavelength, of all lines of a direction."""
    ax.set(xscale="log", yscale="log")
    for axis, step in enumerate(steps):
        lines = np.nan_to_num(np.moveaxis(z, axis, 0))
        n = len(lines)
        if n < 4 or not np.ptp(lines, axis=0).any():
            continue
        window = np.ones(n) if wrap else iso.taper(n)
        power = np.mean(np.abs(np.fft.rfft(lines * window[:, None], axis=0)) ** 2, axis=1)
        octaves = 2 ** np.arange(int(np.log2(n // 2)) + 1)  # waves of the length of the surface
        edges = np.append(octaves, (n + 1) / 2)  # the last octave is a part of one
        share = 2 * np.add.reduceat(power, octaves) / (n * np.sum(window**2))
        height = np.sqrt(share / np.diff(np.log2(edges)))
        height[height < _SHOWN * height.max()] = np.nan
        ax.stairs(height[::-1], n * step / edges[::-1], baseline=None, **_LOOKS[axis])
    _finish(ax, "wavelength [µm]", "rms height per octave [µm]")


def _autocorrelation(ax: Axes, z: Array, steps: Array, wrap: bool, length: float) -> None:
    """Draw the autocorrelation along and across over the lag [um], with its decay to 0.2."""
    share = iso.autocorrelation(z, wrap)
    middle = np.array(share.shape) // 2
    for axis, curve in enumerate((share[middle[0] :, middle[1]], share[middle[0], middle[1] :])):
        if len(curve) > 1:
            ax.plot(steps[axis] * np.arange(len(curve)), curve, **_LOOKS[axis])
    ax.axhline(iso.DECAY, color="0.4", linewidth=0.8)
    if math.isfinite(length):
        ax.plot(length, iso.DECAY, "ko", label=f"Sal {rounded(length, 3)} µm")
        ax.set_xlim(0, min(12 * length, max(middle * steps)))
    _finish(ax, "lag [µm]", "autocorrelation")


def _finish(ax: Axes, x: str, y: str) -> None:
    """Label axes, and draw their grid and legend."""
    ax.set(xlabel=x, ylabel=y)
    finish_grid(ax).legend(fontsize="small")
