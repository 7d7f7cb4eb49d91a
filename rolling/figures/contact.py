"""Figures of the contact of a run: surface, contact pressure and recovery events."""

import math
from collections.abc import Iterable

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.plots import COLOURS
from rolling.figures.picture import axes_of, finish, finish_grid, listed, number
from rolling.marches.observers import Snapshot
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.surface import scene_surface

SHOWN_M = 0.8e-3  # length of a track that a map shows, so that single asperities can be seen
_MOST_DOTS = 110_000  # points of a map of heights, which fit into a file of 150 kB
_SHADES = 24  # colours of such a map: more shades make larger files and are hardly distinguishable
_ENERGIES_PER_DECADE = 5
_SMALLEST_SHARE = 1e-6  # of the maximum energy; smaller energies are rounding of the solution


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
    >>> rolling.plot.surface(rolling.read_scene("scene.yaml"))  # doctest: +SKIP
    """
    scene, title = (shown, shown.name) if isinstance(shown, Scene) else (shown.scene, shown.title)
    plate = scene_surface.scene_surface(scene)
    heights, spacing = plate.heights * 1e6, scene.spacing
    nodes = min(len(heights), max(2, round(SHOWN_M / spacing)))
    stride = math.ceil(math.sqrt(nodes * heights.shape[1] / _MOST_DOTS))
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
    >>> rolling.plot.contact_pressure(run)  # doctest: +SKIP
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
    ax = _map(axes_of(ax), pressure, corner, spacing, limits, "pressure [GPa]")
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
    ax: Axes,
    values: Array,
    corner: tuple[float, float],
    spacing: float,
    limits: tuple[float, float],
    label: str,
    colours: matplotlib.colors.Colormap | str = "magma",
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
    >>> rolling.plot.recovery_events(run)  # doctest: +SKIP
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
    return finish(finish_grid(ax), f"Recovery events: {run.title}", facts)


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
