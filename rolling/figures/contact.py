"""Figures of the contact of a run: heights of its surface, contact pressure, recovery events."""

import math
from collections.abc import Iterable

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Colormap
from matplotlib.ticker import EngFormatter

from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS
from acoustics.traps import ignoring_underflow
from rolling.figures.picture import axes_of, finish, listed, number
from rolling.marches.observers import Snapshot
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
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
