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
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, gridded
from acoustics.traps import ignoring_underflow
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
_LEAST_UM = 1e-3  # end of a scale of heights; it hides the rounding of a smooth surface


@ignoring_underflow
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
    instance("shown", shown, Run, Scene)
    if isinstance(shown, Scene):
        scene = shown
        title = shown.name
    else:
        scene = shown.scene
        title = shown.title
    plate = scene_surface.scene_surface(scene)
    heights_um = plate.heights * 1e6
    nodes = min(len(heights_um), max(2, round(SHOWN_M / scene.spacing)))
    stride = math.ceil(math.sqrt(nodes * heights_um.shape[1] / _MAX_DOTS))
    highest_um = max(float(np.abs(heights_um).max()), _LEAST_UM)
    ax = axes_of(ax)
    _draw_map(
        ax,
        heights_um[:nodes:stride, ::stride],
        corner=(0.0, 0.0),
        spacing=stride * scene.spacing,
        limits=(-highest_um, highest_um),
        label="height [µm]",
        colours=matplotlib.colormaps["cividis"].resampled(_SHADES),
    )
    ra_um = rounded(1e6 * plate.statistics.ra, 4)
    rq_um = rounded(1e6 * plate.statistics.rq, 4)
    facts = [
        f"Ra {ra_um} µm, Rq {rq_um} µm",
        f"{rounded(len(heights_um) * scene.spacing * 1e3, 4)} mm of track",
    ]
    if stride > 1:
        facts.append(f"every {stride} nodes")
    return finish(ax, f"Surface: {title}", facts)


@ignoring_underflow
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
    instance("run", run, Run)
    snapshot = run.result.snapshot
    if snapshot is None:
        raise ValueError(f"{run.title}: has no snapshot, its first steps are not solved")
    pressures_gpa = []
    reaches_um = []
    for other in listed(among) or [run]:
        if other.result.snapshot is not None:
            pressures_gpa.append(float(other.result.snapshot.pressure.max()) * 1e-9)
            reaches_um.append(_reach(other, other.result.snapshot) * 1e6)
    ax = axes_of(ax)
    _draw_map(
        ax,
        snapshot.pressure * 1e-9,
        corner=(snapshot.along, snapshot.across),
        spacing=run.scene.spacing,
        limits=(0.0, max(pressures_gpa)),
        label="pressure [GPa]",
        colours="magma",
    )
    reach_um = max(reaches_um)
    along_um, across_um = (1e6 * place for place in _sphere_position(run, snapshot))
    ax.set_xlim(along_um - reach_um, along_um + reach_um)
    ax.set_ylim(across_um - reach_um, across_um + reach_um)
    ax.set_facecolor("black")
    facts = [f"load {rounded(run.scene.load, 6)} N", f"sphere at {rounded(along_um, 4)} µm"]
    if np.isfinite(run.scene.hardness):
        facts.append(f"hardness {rounded(run.scene.hardness * 1e-9, 4)} GPa")
    if len(reaches_um) > 1:
        facts.append("same scales for all runs")
    return finish(ax, f"Contact pressure: {run.title}", facts)


def _sphere_position(run: Run, snapshot: Snapshot) -> tuple[float, float]:
    """Return the sphere's position in the snapshot, along and across [m]."""
    return snapshot.distance, (run.scene.track.n_across - 1) / 2 * run.scene.spacing


def _reach(run: Run, snapshot: Snapshot) -> float:
    """Return the distance from the sphere to the farthest edge of the snapshot's window [m]."""
    half = run.scene.spacing / 2
    low = np.array([snapshot.along, snapshot.across]) - half - _sphere_position(run, snapshot)
    high = low + np.array(snapshot.pressure.shape) * 2 * half
    return float(np.abs([low, high]).max())


def _draw_map(
    ax: Axes,
    values: Array,
    *,
    corner: tuple[float, float],
    spacing: float,
    limits: tuple[float, float],
    label: str,
    colours: str | Colormap,
) -> None:
    """Draw values (along, across) of nodes as a map with a colour bar.

    `corner` is the place of the first node [m], and `limits` are the values of the first and the
    last colour.
    """
    low = np.array(corner) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    image = ax.imshow(values.T, colours, origin="lower", extent=extent, interpolation="none")
    image.set_clim(*limits)
    beside = ax.inset_axes((1.03, 0.0, 0.04, 1.0))  # as high as the map
    ax.figure.colorbar(image, cax=beside, label=label)
    ax.set(xlabel="along the track [µm]", ylabel="across [µm]")


@ignoring_underflow
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
    instance("run", run, Run)
    table = recovery_event_table(run)
    ax = axes_of(ax)
    edges = np.append(table["lower_edge_j"], table["upper_edge_j"].iloc[-1])
    ax.stairs(
        100 * table["share_of_events"],
        edges,
        color=COLOURS[0],
        linestyle="-",
        label="share of the events",
    )
    ax.stairs(
        100 * table["share_of_release"],
        edges,
        color=COLOURS[1],
        linestyle="--",
        label="share of the release",
    )
    ax.set(xscale="log", xlabel="energy of an event [J]", ylabel="share [%]")
    ax.set_xlim(max(edges[0], _SMALLEST_SHARE * edges[-1]), None)
    ax.set_ylim(0.0, None)
    statistics = run.event_statistics
    assert statistics is not None  # the table exists
    joule = EngFormatter("J", places=1)
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
    events, _ = np.histogram(energy, edges)
    release, _ = np.histogram(energy, edges, weights=energy)
    return pd.DataFrame(
        {
            "lower_edge_j": edges[:-1],
            "upper_edge_j": edges[1:],
            "share_of_events": events / events.sum(),
            "share_of_release": release / release.sum(),
        }
    )


# ---- surface with its parameters


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
