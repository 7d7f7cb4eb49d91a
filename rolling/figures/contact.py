"""Figures of surfaces and contacts: heights, contact pressure, recovery events, parameters.

The picture of a surface with its parameters by ISO 25178-2 needs no run.
"""

import math
from collections.abc import Iterable
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, gridded
from rolling.figures import picture
from rolling.figures.picture import axes_of, finish, listed, number
from rolling.figures.settings import own_settings
from rolling.marches.observers import Snapshot
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.surface import parameters as iso
from rolling.surface import scene_surface

SHOWN_M = 0.8e-3  # length of a track that a map shows, so that single asperities can be seen
_MAX_DOTS = 110_000  # points of a map of heights, which fit into a file of 150 kB
_SHADES = 24  # colours of such a map: more shades make larger files and are hardly distinguishable
_ENERGIES_PER_DECADE = 5
_SMALLEST_SHARE = 1e-6  # of the maximum energy; smaller energies are rounding of the solution
_Pair = tuple[float, float]


def surface(shown: Run | Scene, ax: Axes | None = None) -> Axes:
    """Plot the heights at the beginning of the track as a map, with a colour bar.

    Parameters
    ----------
    shown : Run or Scene
        Run or scene whose surface is plotted.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with heights, µm, over the first 0.8 mm of the plate, µm.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.surface(rolling.read_scene("quickstart"))
    """
    scene, title = (shown, shown.name) if isinstance(shown, Scene) else (shown.scene, shown.title)
    plate = scene_surface.scene_surface(scene)
    heights, spacing = plate.heights * 1e6, scene.spacing
    nodes = min(len(heights), max(2, round(SHOWN_M / spacing)))
    stride = math.ceil(math.sqrt(nodes * heights.shape[1] / _MAX_DOTS))
    drawn = heights[:nodes:stride, ::stride]
    highest = max(float(np.abs(heights).max()), 1e-3)  # the rounding of a smooth surface is hidden
    ra, rq = (rounded(1e6 * value, 4) for value in (plate.statistics.ra, plate.statistics.rq))
    facts = [
        f"Ra {ra} µm, Rq {rq} µm",
        f"{rounded(len(heights) * spacing * 1e3, 4)} mm of track",
        *([f"every {stride} nodes"] if stride > 1 else []),
    ]
    colours = matplotlib.colormaps["cividis"].resampled(_SHADES)
    limits, side = (-highest, highest), stride * spacing
    ax = _map(axes_of(ax), drawn, (0.0, 0.0), side, limits, "height [µm]", colours)
    return finish(ax, f"Surface: {title}", facts)


def contact_pressure(run: Run, ax: Axes | None = None, among: Iterable[Run] = ()) -> Axes:
    """Plot the contact pressure at the snapshot of a run as a map, with a colour bar.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.
    among : iterable of Run
        Runs that share the scales of length and colour. Default: the run alone.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with pressure, GPa, over the plate, µm.

    Raises
    ------
    ValueError
        The run has no snapshot, because its first steps are not solved.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.contact_pressure(run)
    """
    snapshot = run.result.snapshot
    if snapshot is None:
        raise ValueError(f"{run.title}: has no snapshot, its first steps are not solved")
    others = listed(among) or [run]
    compared = [(other, shot) for other in others if (shot := other.result.snapshot)]
    maximum = max(float(shot.pressure.max()) for _, shot in compared) * 1e-9
    reach = max(_reach(other, shot) for other, shot in compared) * 1e6
    spacing, corner = run.scene.spacing, (snapshot.along, snapshot.across)
    pressure, limits = snapshot.pressure * 1e-9, (0.0, maximum)
    ax = _map(axes_of(ax), pressure, corner, spacing, limits, "pressure [GPa]", "magma")
    along, across = (1e6 * place for place in _sphere_position(run, snapshot))
    ax.set(xlim=(along - reach, along + reach), ylim=(across - reach, across + reach))
    ax.set_facecolor("black")
    facts = [f"load {rounded(run.scene.load, 6)} N", f"sphere at {rounded(along, 4)} µm"]
    if np.isfinite(run.scene.hardness):
        facts.append(f"hardness {rounded(run.scene.hardness * 1e-9, 4)} GPa")
    if len(compared) > 1:
        facts.append("same scales for all runs")
    return finish(ax, f"Contact pressure: {run.title}", facts)


def _sphere_position(run: Run, snapshot: Snapshot) -> tuple[float, float]:
    """Return the sphere's position in the snapshot, along and across [m]."""
    return snapshot.distance, (run.scene.track.n_across - 1) / 2 * run.scene.spacing


def _reach(run: Run, snapshot: Snapshot) -> float:
    """Return the distance from the sphere to the farthest edge of the snapshot's window [m]."""
    half = run.scene.spacing / 2
    low = np.array([snapshot.along, snapshot.across]) - half - _sphere_position(run, snapshot)
    return float(np.abs([low, low + np.array(snapshot.pressure.shape) * 2 * half]).max())


def _map(
    ax: Axes, values: Array, corner: _Pair, spacing: float, limits: _Pair, label: str, colours: Any
) -> Axes:
    """Draw values (along, across) of nodes from a corner on [m] as a map with a colour bar."""
    low = np.array(corner) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    image = ax.imshow(values.T, colours, origin="lower", extent=extent, interpolation="none")
    image.set_clim(*limits)
    ax.figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), label=label)  # as high
    ax.set(xlabel="along the track [µm]", ylabel="across [µm]")
    return ax


def recovery_events(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the distribution of the recovery events of a run over their energy.

    Parameters
    ----------
    run : Run
        Run to plot, of a scene with `recovery.events`.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with shares of the events and of the release, %, over energy of an event, J.

    Raises
    ------
    ValueError
        The run has no recovery events.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.recovery_events(run)
    """
    table, statistics = recovery_event_table(run), run.event_statistics
    ax, joule = axes_of(ax), EngFormatter("J", places=1)
    edges = np.append(table["lower_edge_j"], table["upper_edge_j"].iloc[-1])
    for name, colour, style in (("events", COLOURS[0], "-"), ("release", COLOURS[1], "--")):
        share = 100 * table[f"share_of_{name}"]
        ax.stairs(share, edges, color=colour, linestyle=style, label=f"share of the {name}")
    ax.set(xscale="log", xlabel="energy of an event [J]", ylabel="share [%]")
    ax.set(xlim=(max(edges[0], _SMALLEST_SHARE * edges[-1]), None), ylim=(0.0, None))
    assert statistics is not None
    facts = [
        f"{statistics.count:,} events, {number(statistics.per_metre * 1e-3)} per mm",
        f"median {joule(statistics.energy_median)}, 90 % below {joule(statistics.energy_p90)}",
        f"top tenth: {rounded(100 * statistics.top_tenth_share, 3)} % of the release",
        f"mean duration {rounded(statistics.duration_mean, 3)} steps of"
        f" {rounded(run.result.step * 1e6, 3)} µm",
    ]
    return finish(ax, f"Recovery events: {run.title}", facts)


def recovery_event_table(run: Run) -> pd.DataFrame:
    """Tabulate the shares of the events and of the release by energy of an event [J]."""
    if run.events is None or run.event_statistics is None:
        raise ValueError(f"{run.title}: has no recovery events")
    energy = run.events["energy"]
    low, high = np.log10([energy.min(), energy.max()]) * _ENERGIES_PER_DECADE
    edges = 10.0 ** (np.arange(np.floor(low), np.floor(high) + 2) / _ENERGIES_PER_DECADE)
    events, release = (np.histogram(energy, edges, weights=w)[0] for w in (None, energy))
    columns = {"lower_edge_j": edges[:-1], "upper_edge_j": edges[1:]}
    shares = {"share_of_events": events / events.sum(), "share_of_release": release / release.sum()}
    return pd.DataFrame(columns | shares)


# ---- surface with its parameters


_HEIGHT_IN = 7.0
_MAX_NODES = 500  # of a map, in each direction
_LONGEST = 1.6  # times its shorter side, the longer side of a map
_HIDDEN = 0.002  # of the heights at either end, which have no colour of their own
_SHOWN = 1e-4  # of the maximum of a spectrum, the least that is shown
_TITLED = ("Sa", "Sq", "Ssk", "Sku", "Str")
_LOOKS: tuple[dict[str, Any], ...] = (
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
    z = 1e6 * iso.about_mean(heights)
    descending = np.sort(z[~np.isnan(z)])[::-1]
    extremes = int(_HIDDEN * len(descending))
    shown = descending[extremes : len(descending) - extremes]
    figure = Figure(figsize=(picture.WIDTH_IN, _HEIGHT_IN), dpi=picture.DPI, layout="constrained")
    FigureCanvasAgg(figure)
    (on_map, on_ratio), (on_spectrum, on_correlation) = figure.subplots(2, 2)
    _heights_map(on_map, z, 1e6 * steps, shown)
    _material_ratio(on_ratio, shown, iso.core(descending))
    if values["Sq"] > 0:
        _spectrum(on_spectrum, z, 1e6 * steps, wrap)
        _autocorrelation(on_correlation, z, 1e6 * steps, wrap, 1e6 * values["Sal"])
    else:
        on_spectrum.set_axis_off()
        on_correlation.set_axis_off()
    facts = ", ".join(f"{short} {written(short, values)}" for short in _TITLED)
    title = f"Surface: {name}: {facts.replace(' um', ' µm')}"
    if str_is_bound:
        title += " at most"
    figure.suptitle(picture.drawable(title), x=0.012, ha="left", fontsize=11, parse_math=False)
    return picture.Picture("surface", figure, parameter_table(values, str_is_bound))


def parameter_table(values: dict[str, float], str_is_bound: bool = False) -> pd.DataFrame:
    """Tabulate the parameters of a surface with their units and meanings."""
    meanings = iso.meanings(str_is_bound)
    rows = [(short, values[short], unit, meanings[short]) for short, (unit, _) in iso.NAMES.items()]
    return pd.DataFrame(rows, columns=["parameter", "value", "unit", "meaning"])


def written(short: str, values: dict[str, float]) -> str:
    """Write a parameter with its unit, lengths in um; a dash without a value."""
    value, unit = values[short], iso.NAMES[short][0]
    if unit == "m":
        value, unit = 1e6 * value, "um"
    return "-" if math.isnan(value) else f"{rounded(value, 4)} {unit}".rstrip()


def parameter_lines(values: dict[str, float], str_is_bound: bool = False) -> list[str]:
    """Write parameters with their units and meanings, one on each line."""
    meanings = iso.meanings(str_is_bound).items()
    return [f"{short:6}{written(short, values):>12}  {text}" for short, text in meanings]


def _heights_map(ax: Axes, z: Array, steps: Array, descending: Array) -> None:
    """Draw heights [um] at the beginning, no longer than 1.6 times their width; a profile whole."""
    shape = np.array(z.shape)
    longest = _LONGEST * min(steps * shape) if min(shape) > 1 else math.inf
    nodes = np.minimum(shape, np.ceil(np.minimum(longest / steps, shape))).astype(int)
    strides = -(-nodes // _MAX_NODES)
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
    gridded(ax, xlabel="material ratio [%]", ylabel="height [µm]").legend(fontsize="small")


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
    labels = {"xlabel": "wavelength [µm]", "ylabel": "rms height per octave [µm]"}
    gridded(ax, **labels).legend(fontsize="small")


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
    gridded(ax, xlabel="lag [µm]", ylabel="autocorrelation").legend(fontsize="small")
