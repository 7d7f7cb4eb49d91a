"""The picture of a surface with its parameters by ISO 25178-2, which needs no run."""

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, gridded
from rolling.figures import picture
from rolling.figures.settings import own_settings
from rolling.surface import parameters as iso

_LEAST_UM = 1e-3  # end of a scale of heights; it hides the rounding of a smooth surface
_HEIGHT_IN = 7.0
_MAX_NODES = 500  # of a map, in each direction
_LONGEST = 1.6  # times its shorter side, the longer side of a map
_HIDDEN = 0.002  # of the heights at either end, which have no colour of their own
_SHOWN = 1e-4  # of the maximum of a spectrum, the least that is shown
_TITLED = ("Sa", "Sq", "Ssk", "Sku", "Str")
_DIRECTIONS: tuple[dict[str, Any], ...] = (  # label, colour and line of the curves of an axis
    {"label": "along", "color": COLOURS[0], "linestyle": "-"},
    {"label": "across", "color": COLOURS[1], "linestyle": "--"},
)


@own_settings()
def topography(
    name: str,
    values: dict[str, float],
    heights: Array,
    steps: Array,
    wrap: bool,
    str_is_bound: bool = False,
) -> picture.Picture:
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
    str_is_bound : bool
        Whether Str is an upper bound.
    """
    heights_um = 1e6 * iso.about_mean(heights)
    steps_um = 1e6 * steps
    descending = np.sort(heights_um[~np.isnan(heights_um)])[::-1]
    extremes = int(_HIDDEN * len(descending))
    shown = descending[extremes : len(descending) - extremes]
    figure = Figure(figsize=(picture.WIDTH_IN, _HEIGHT_IN), dpi=picture.DPI, layout="constrained")
    FigureCanvasAgg(figure)
    (on_map, on_ratio), (on_spectrum, on_correlation) = figure.subplots(2, 2)
    _draw_heights(on_map, heights_um, steps_um, shown)
    _draw_material_ratio(on_ratio, shown, iso.core(descending))
    if values["Sq"] > 0:
        _draw_spectrum(on_spectrum, heights_um, steps_um, wrap)
        _draw_autocorrelation(on_correlation, heights_um, steps_um, wrap, 1e6 * values["Sal"])
    else:
        on_spectrum.set_axis_off()
        on_correlation.set_axis_off()
    facts = ", ".join(f"{short} {written(short, values)}" for short in _TITLED)
    title = f"Surface: {name}: {facts.replace(' um', ' µm')}"
    if str_is_bound:
        title += " at most"
    figure.suptitle(picture.drawable(title), x=0.012, ha="left", fontsize=11, parse_math=False)
    return picture.Picture("surface", figure, parameter_table(values, str_is_bound))


@own_settings()
def before_and_after(
    name: str, before: Array, before_steps: Array, after: Array, after_steps: Array
) -> picture.Picture:
    """Draw heights as they were measured and as they are prepared, one map beside the other.

    Parameters
    ----------
    name : str
        Name of the surface.
    before, after : (m, n) array, m
        Heights along and across, NaN at unmeasured points, which stay empty.
    before_steps, after_steps : (2,) array, m
        Node spacings along and across.
    """
    figure = Figure(
        figsize=(picture.WIDTH_IN, _HEIGHT_IN / 2), dpi=picture.DPI, layout="constrained"
    )
    FigureCanvasAgg(figure)
    rows = []
    pairs = (("as measured", before, before_steps), ("prepared", after, after_steps))
    for ax, (words, heights, steps) in zip(figure.subplots(1, 2), pairs, strict=True):
        heights_um = 1e6 * iso.about_mean(heights)
        descending = np.sort(heights_um[~np.isnan(heights_um)])[::-1]
        extremes = int(_HIDDEN * len(descending))
        _draw_heights(
            ax, heights_um, 1e6 * steps, descending[extremes : len(descending) - extremes]
        )
        values = iso.roughness(heights, steps)
        ax.set_title(f"{words}: Sa {written('Sa', values).replace(' um', ' µm')}", loc="left")
        rows.append({"heights": words, "Sa_m": values["Sa"], "Sq_m": values["Sq"]})
    title = picture.drawable(f"Preparation of {name}")
    figure.suptitle(title, x=0.012, ha="left", fontsize=11, parse_math=False)
    return picture.Picture("preparation", figure, pd.DataFrame(rows))


def parameter_table(values: dict[str, float], str_is_bound: bool = False) -> pd.DataFrame:
    """Tabulate the parameters of a surface with their units and meanings."""
    meanings = iso.meanings(str_is_bound)
    rows = [(short, values[short], unit, meanings[short]) for short, (unit, _) in iso.NAMES.items()]
    return pd.DataFrame(rows, columns=["parameter", "value", "unit", "meaning"])


def written(short: str, values: dict[str, float]) -> str:
    """Write a parameter with its unit, lengths in um; a dash without a value."""
    value = values[short]
    unit = iso.NAMES[short][0]
    if math.isnan(value):
        return "-"
    if unit == "m":
        return f"{rounded(1e6 * value, 4)} um"
    return f"{rounded(value, 4)} {unit}".rstrip()


def parameter_lines(values: dict[str, float], str_is_bound: bool = False) -> list[str]:
    """Write parameters with their units and meanings, one on each line."""
    meanings = iso.meanings(str_is_bound).items()
    return [f"{short:6}{written(short, values):>12}  {text}" for short, text in meanings]


def _draw_heights(ax: Axes, heights_um: Array, steps_um: Array, descending: Array) -> None:
    """Draw heights at the beginning, no longer than 1.6 times their width; a profile whole."""
    shape = np.array(heights_um.shape)
    is_profile = min(shape) == 1
    longest_um = math.inf if is_profile else _LONGEST * min(steps_um * shape)
    nodes = np.minimum(shape, np.ceil(np.minimum(longest_um / steps_um, shape))).astype(int)
    strides = -(-nodes // _MAX_NODES)
    shown = heights_um[: nodes[0] : strides[0], : nodes[1] : strides[1]]
    along, across = strides * steps_um * shown.shape
    extent = (0.0, along, 0.0, across)
    image = ax.imshow(shown.T, "cividis", origin="lower", interpolation="none", extent=extent)
    image.set_clim(min(descending[-1], -_LEAST_UM), max(descending[0], _LEAST_UM))
    ax.set_aspect("auto" if is_profile else "equal")
    ax.set_facecolor("0.7")  # unmeasured points
    ax.figure.colorbar(image, ax=ax, label="height [µm]", shrink=0.8, extend="both")
    ax.set(xlabel="along [µm]", ylabel="across [µm]")


def _draw_material_ratio(ax: Axes, descending: Array, line: tuple[float, float]) -> None:
    """Draw the distribution of heights [um], their material ratio, and the line of the core."""
    ratio = np.linspace(_HIDDEN, 1 - _HIDDEN, 1001)
    curve = descending[np.linspace(0, len(descending) - 1, 1001).round().astype(int)]
    count, edges = np.histogram(descending, 80)
    ax.stairs(
        100 * count / count.max(),
        edges,
        orientation="horizontal",
        fill=True,
        color="0.8",
        label="distribution of heights",
    )
    ax.plot(100 * ratio, curve, color=COLOURS[0], label="material ratio")
    ax.plot((0, 100), line, "--", color=COLOURS[1], label="equivalent line")
    ax.set_xlim(0, 100)
    gridded(ax, xlabel="material ratio [%]", ylabel="height [µm]")
    ax.legend(fontsize="small")


def _draw_spectrum(ax: Axes, heights_um: Array, steps_um: Array, wrap: bool) -> None:
    """Draw the rms height [um] of each octave of wavelength, of all lines of a direction."""
    ax.set(xscale="log", yscale="log")
    for axis, step_um in enumerate(steps_um):
        lines = np.nan_to_num(np.moveaxis(heights_um, axis, 0))
        n = len(lines)
        if n < 4 or not np.ptp(lines, axis=0).any():
            continue
        window = np.ones(n) if wrap else iso.taper(n)
        power = np.mean(np.abs(np.fft.rfft(lines * window[:, None], axis=0)) ** 2, axis=1)
        octaves = 2 ** np.arange(int(np.log2(n // 2)) + 1)  # waves of the length of the surface
        edges = np.append(octaves, (n + 1) / 2)  # the last octave is a part of one
        square = 2 * np.add.reduceat(power, octaves) / (n * np.sum(window**2))
        rms_um = np.sqrt(square / np.diff(np.log2(edges)))
        rms_um[rms_um < _SHOWN * rms_um.max()] = np.nan
        ax.stairs(rms_um[::-1], n * step_um / edges[::-1], baseline=None, **_DIRECTIONS[axis])
    gridded(ax, xlabel="wavelength [µm]", ylabel="rms height per octave [µm]")
    ax.legend(fontsize="small")


def _draw_autocorrelation(
    ax: Axes, heights_um: Array, steps_um: Array, wrap: bool, length_um: float
) -> None:
    """Draw the autocorrelation along and across over the lag, with its decay to 0.2."""
    correlation = iso.autocorrelation(heights_um, wrap)
    middle = np.array(correlation.shape) // 2
    along = correlation[middle[0] :, middle[1]]
    across = correlation[middle[0], middle[1] :]
    for axis, curve in enumerate((along, across)):
        if len(curve) > 1:
            ax.plot(steps_um[axis] * np.arange(len(curve)), curve, **_DIRECTIONS[axis])
    ax.axhline(iso.DECAY, color="0.4", linewidth=0.8)
    if math.isfinite(length_um):
        ax.plot(length_um, iso.DECAY, "ko", label=f"Sal {rounded(length_um, 3)} µm")
        ax.set_xlim(0, min(12 * length_um, max(middle * steps_um)))
    gridded(ax, xlabel="lag [µm]", ylabel="autocorrelation")
    ax.legend(fontsize="small")
