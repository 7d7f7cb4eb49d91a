"""Figures of the contact of a run: heights of its surfaces, contact pressure, recovery events."""

import math
from collections.abc import Iterable, Sequence

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from acoustics.arrays import Array, instance
from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS
from rolling.figures.picture import axes_of, finish, listed, number
from rolling.in_si import scene_surface
from rolling.kinds.run_folder import RunFolder
from rolling.marches.observers import Snapshot
from rolling.results.run_result import Run
from rolling.scene.laws import SurfaceFault
from rolling.scene.scene import Scene
from rolling.surface.single_faults import fault_places

SHOWN_M = 0.8e-3  # length of a track that a map shows, so that single asperities can be seen
YIELDED = "#FFE945"  # colour of nodes at the hardness, which no pressure below it has
_MAX_DOTS = 110_000  # points of a map of heights, which fit into a file of 150 kB
_SHADES = 24  # colours of such a map: more shades make larger files and are hardly distinguishable
_HIDDEN = 0.002  # of the heights at either end, which have no colour of their own
BELOW_YIELD = 0.75  # of the colours of pressures, the part that the colour of yielding stands off
_AT_HARDNESS = 1.0 - 1e-6  # of the hardness, the pressure from which a node has yielded
_ENERGIES_PER_DECADE = 5
_SMALLEST_SHARE = 1e-6  # of the maximum energy; smaller energies are rounding of the solution
_LEAST_UM = 1e-3  # end of a scale of heights; it hides the rounding of a smooth surface


# ---- surfaces


def surface(shown: Run | Scene, ax: Axes | None = None) -> Axes:
    """Plot the heights that the ball rolls over as a map, with a colour bar.

    Heights of a plate and of a ball with a surface of its own are added up. The map shows the
    beginning of the track, or the place of the first fault.

    Parameters
    ----------
    shown : Run or Scene
        Run or scene whose surface is plotted.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with heights, µm, over 0.8 mm of the plate, µm.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.surface(rolling.read_scene("quickstart"))
    """
    scene, title = _scene_and_title(shown)
    rolled = scene_surface.scene_surface(scene)
    faults = list(scene.surface.faults or ())
    name = "Surface"
    facts = [_roughness_text(rolled.statistics.ra, rolled.statistics.rq)]
    if scene.sphere.surface is not None:
        faults += scene.sphere.surface.faults or ()
        name = "Surface of plate and ball, added up"
        if rolled.part_ra is not None:
            of_plate, of_ball = (rounded(1e6 * ra, 3) for ra in rolled.part_ra)
            facts = [f"{facts[0]} (plate Ra {of_plate} µm, ball Ra {of_ball} µm)"]
    facts.append(f"{rounded(len(rolled.heights) * scene.spacing * 1e3, 4)} mm of track")
    ax = axes_of(ax)
    facts += _draw_surface(ax, rolled.heights, scene.spacing, faults)
    return finish(ax, f"{name}: {title}", facts)


def ball_surface(shown: Run | Scene, ax: Axes | None = None) -> Axes:
    """Plot the heights of a ball along its rolling line as a map, with a colour bar.

    Parameters
    ----------
    shown : Run or Scene
        Run or scene of a ball with a surface.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with heights, µm, over 0.8 mm of the circumference, µm.

    Raises
    ------
    ValueError
        The ball has no surface.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.ball_surface(rolling.read_scene("ball-with-pit"))
    """
    scene, title = _scene_and_title(shown)
    ball = scene.sphere.surface
    if ball is None:
        raise ValueError(f"{title}: its ball has no surface")
    heights, _ = scene_surface.ball_heights(scene, ball)
    about_mean = heights - heights.mean()
    ra = float(np.abs(about_mean).mean())
    rq = float(np.sqrt(np.square(about_mean).mean()))
    facts = [_roughness_text(ra, rq)]
    facts.append(f"{rounded(len(heights) * scene.spacing * 1e3, 4)} mm around the ball")
    ax = axes_of(ax)
    facts += _draw_surface(ax, heights, scene.spacing, list(ball.faults or ()))
    ax.set_xlabel("around the ball [µm]")
    return finish(ax, f"Surface of the ball: {title}", facts)


def _scene_and_title(shown: Run | Scene) -> tuple[Scene, str]:
    """Return the scene of a run or scene, and its title."""
    instance("shown", shown, Run, Scene)
    if isinstance(shown, RunFolder):
        return shown.scene, shown.title
    return shown, shown.name


def _roughness_text(ra: float, rq: float) -> str:
    """Write roughness parameters [m] in µm."""
    return f"Ra {rounded(1e6 * ra, 4)} µm, Rq {rounded(1e6 * rq, 4)} µm"


def _draw_surface(
    ax: Axes, heights: Array, spacing: float, faults: Sequence[SurfaceFault]
) -> list[str]:
    """Draw the heights about the first fault, or at the beginning, and return facts for a note."""
    nodes = min(len(heights), max(2, round(SHOWN_M / spacing)))
    first = 0
    facts = []
    if faults:
        x = _place_of_fault(faults[0], heights, spacing)
        first = int(np.clip(round(x / spacing) - nodes // 2, 0, len(heights) - nodes))
        facts.append(_fault_text(faults, x))
    stride = math.ceil(math.sqrt(nodes * heights.shape[1] / _MAX_DOTS))
    heights_um = 1e6 * heights[first : first + nodes : stride, ::stride]
    low, high = _LEAST_UM * np.array([-1.0, 1.0])
    if faults:  # which are seen whole
        low = min(low, float(heights_um.min()))
        high = max(high, float(heights_um.max()))
    else:
        low = min(low, float(np.quantile(heights_um, _HIDDEN)))
        high = max(high, float(np.quantile(heights_um, 1.0 - _HIDDEN)))
    _draw_map(
        ax,
        heights_um,
        corner=(first * spacing, 0.0),
        spacing=stride * spacing,
        limits=(low, high),
        label="height [µm]",
        colours=matplotlib.colormaps["cividis"].resampled(_SHADES),
        extend="neither" if faults else "both",
    )
    if stride > 1:
        facts.append(f"every {stride} nodes")
    return facts


def _place_of_fault(fault: SurfaceFault, heights: Array, spacing: float) -> float:
    """Return the place [m] of a fault, or of the first of several, along a surface."""
    length, width = spacing * np.array(heights.shape)
    return float(fault_places(fault.in_si, length, width)[0, 0] % length)


def _fault_text(faults: Sequence[SurfaceFault], x: float) -> str:
    """Describe the first fault and its place [m] along the surface."""
    fault = faults[0]
    size = "high" if fault.kind in ("bump", "step") else "deep"
    text = f"{fault.kind} of {fault.size_um:g} µm, {fault.depth_um:g} µm {size}"
    text += f", at {rounded(1e3 * x, 4)} mm"
    others = sum(other.count or 1 for other in faults) - 1
    if others:
        text += f", and {others} more"
    return text


# ---- contact


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
        Axes with pressure, GPa, over the plate, µm. Nodes that have yielded, at the hardness, have
        a colour of their own.

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
    yields = False
    for other in listed(among) or [run]:
        if other.result.snapshot is not None:
            highest = float(other.result.snapshot.pressure.max())
            pressures_gpa.append(highest * 1e-9)
            reaches_um.append(_reach(other, other.result.snapshot) * 1e6)
            yields = yields or highest >= _AT_HARDNESS * other.scene.hardness
    limit_gpa = max(pressures_gpa)
    colours = matplotlib.colormaps["magma"]
    pressure_gpa = snapshot.pressure * 1e-9
    if yields:
        colours = yielding_colours()
        # Each run may have a hardness of its own, so yielding is beyond the scale in all of them.
        pressure_gpa = np.where(_has_yielded(run, snapshot), 2.0 * limit_gpa, pressure_gpa)
    ax = axes_of(ax)
    _draw_map(
        ax,
        pressure_gpa,
        corner=(snapshot.along, snapshot.across),
        spacing=run.scene.spacing,
        limits=(0.0, limit_gpa),
        label="pressure [GPa]",
        colours=colours,
        extend="max" if yields else "neither",
    )
    if yields:
        hardness_gpa = rounded(run.scene.hardness * 1e-9, 4)
        name = f"yielded: pressure at the hardness, {hardness_gpa} GPa"
        ax.plot([], [], "s", color=YIELDED, markeredgecolor="0.4", label=name)
    reach_um = max(reaches_um)
    along_um, across_um = (1e6 * place for place in _sphere_position(run, snapshot))
    ax.set_xlim(along_um - reach_um, along_um + reach_um)
    ax.set_ylim(across_um - reach_um, across_um + reach_um)
    ax.set_facecolor("black")
    facts = [f"load {rounded(run.scene.load, 4)} N", f"ball at {rounded(along_um, 4)} µm"]
    if yields:
        share = float(np.mean(_has_yielded(run, snapshot)[snapshot.pressure > 0]))
        facts.append(f"{rounded(100 * share, 3)} % of the contact area has yielded")
    elif np.isfinite(run.scene.hardness):
        facts.append(f"nothing yields, hardness {rounded(run.scene.hardness * 1e-9, 4)} GPa")
    if len(reaches_um) > 1:
        facts.append("all runs share the scales")
    return finish(ax, f"Contact pressure: {run.title}", facts)


def yielding_colours() -> Colormap:
    """Return colours of pressures below the hardness, and above them the colour of yielding."""
    places = np.linspace(0.0, BELOW_YIELD, 256)
    colours = ListedColormap(matplotlib.colormaps["magma"](places))
    return colours.with_extremes(over=YIELDED)


def _has_yielded(run: Run, snapshot: Snapshot) -> NDArray[np.bool_]:
    """Tell which nodes of a snapshot are at the hardness."""
    return np.asarray(snapshot.pressure >= _AT_HARDNESS * run.scene.hardness)


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
    colours: Colormap,
    extend: str,
) -> None:
    """Draw values (along, across) of nodes as a map with a colour bar.

    `corner` is the place of the first node [m], and `limits` are the values of the first and the
    last colour. Values beyond them are shown by `extend`, as in matplotlib.
    """
    low = np.array(corner) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    image = ax.imshow(values.T, colours, origin="lower", extent=extent, interpolation="none")
    image.set_clim(*limits)
    beside = ax.inset_axes((1.03, 0.0, 0.04, 1.0))  # as high as the map
    ax.figure.colorbar(image, cax=beside, label=label, extend=extend)
    ax.set(xlabel="along the track [µm]", ylabel="across [µm]")


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
