"""Pictures of a run's contact: surface, pressure and deflection, recovery events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact.recovery import EventStatistics
from rolling.figures import axes, captions
from rolling.figures.picture import (
    BAR_IN,
    BAR_ROOM_IN,
    BOTTOM_IN,
    LEFT_IN,
    RIGHT_IN,
    WIDTH_IN,
    Box,
    Picture,
    blank,
    lay_out,
)
from rolling.simulation.run_result import RunResult
from rolling.simulation.simulate import Snapshot
from rolling.surface import scene_surface

_MAP_SIDE_IN = 2.7  # side of the maps of pressure and deflection
_TALLEST_SURFACE_IN, _PROFILE_IN = 3.6, 1.1
_ENERGIES_PER_DECADE = 5
_SMALLEST_SHARE = 1e-6  # share of the maximum energy at which the axis begins
_MOST_DURATIONS = 50  # columns of a distribution of durations


# ---- surface


def surface(run: RunResult) -> Picture:
    """Draw the beginning of the track as a map of heights, with the profile at mid-width below."""
    heights, spacing = scene_surface.heights(run.scene), run.scene.spacing
    nodes = axes.shown_nodes(heights, spacing)
    along = np.linspace(0.0, (nodes - 1) * spacing * 1e6, nodes)
    profile: Array = heights[:nodes, (heights.shape[1] - 1) // 2] * 1e6
    figure = blank()
    plot, bar, below = figure.add_subplot(), figure.add_subplot(), figure.add_subplot()
    axes.surface(plot, bar, heights, spacing)
    axes.profile(below, along, profile)
    below.set_xlim(plot.get_xlim())
    plot.set_xlabel("")
    plot.tick_params(labelbottom=False)
    title, note = f"Surface: {captions.subject([run])}", _surface_note(run, heights)
    boxes = _surface_boxes(heights.shape[1] / nodes)
    lay_out(figure, title, note, dict(zip((plot, bar, below), boxes, strict=True)))
    columns = {"along_um": along, "height_um": profile}
    return Picture("surface", f"{title}: {note}", figure, columns)


def _surface_note(run: RunResult, heights: Array) -> str:
    statistics, spacing = run.summary["surface"], run.scene.spacing
    facts = [
        f"Ra {statistics['ra'] * 1e6:.4g} µm, Rq {statistics['rq'] * 1e6:.4g} µm",
        f"skewness {statistics['skewness']:.2f}, kurtosis {statistics['kurtosis']:.2f}",
        f"rms slope {statistics['rms_slope']:.3g}",
        f"{len(heights) * spacing * 1e3:.4g} mm of track; below: profile at mid-width",
    ]
    stride = axes.map_stride(heights, spacing)
    return captions.note(facts if stride == 1 else [*facts, f"map: every {stride} nodes"])


def _surface_boxes(ratio: float) -> tuple[Box, Box, Box]:
    """Return the boxes of map, colour bar and profile for a map of this height over width.

    The map takes the full width or the full height, whichever it reaches first. A map of extreme
    proportions keeps its own within its box.
    """
    widest = WIDTH_IN - LEFT_IN - BAR_ROOM_IN
    width = min(widest, max(2.0, _TALLEST_SURFACE_IN / ratio))
    height = min(_TALLEST_SURFACE_IN, max(0.3, width * ratio))
    bottom = BOTTOM_IN + _PROFILE_IN + 0.2
    return (
        (LEFT_IN, bottom, width, height),
        (LEFT_IN + width + 0.12, bottom, BAR_IN, height),
        (LEFT_IN, BOTTOM_IN, width, _PROFILE_IN),
    )


# ---- contact


@dataclass(frozen=True)
class ContactScales:
    """Scales that the contact pictures of compared runs share.

    Parameters
    ----------
    reach : float, m. Distance from the sphere to the edge of a map.
    pressure : float, Pa. Maximum pressure.
    deflection : float, m. Maximum deflection.
    runs : int. Number of runs that are compared.
    """

    reach: float
    pressure: float
    deflection: float
    runs: int

    @classmethod
    def of(cls, runs: Sequence[RunResult]) -> ContactScales | None:
        """Derive the scales from all runs that have a snapshot; None where none has."""
        compared = [(run, run.result.snapshot) for run in runs if run.result.snapshot is not None]
        if not compared:
            return None
        return cls(
            max(_reach(run, snapshot) for run, snapshot in compared),
            max(float(snapshot.pressure.max()) for _, snapshot in compared),
            max(float(snapshot.deflection.max()) for _, snapshot in compared),
            len(runs),
        )


def contact(run: RunResult, scales: ContactScales | None) -> Picture | None:
    """Draw pressure and deflection of a run's snapshot on the scales of all runs.

    Returns
    -------
    picture : Picture. None without a snapshot.
    """
    snapshot = run.result.snapshot
    if snapshot is None or scales is None:
        return None
    figure = blank()
    places = _draw_contact(figure, run, snapshot, scales)
    title = f"Contact: {captions.subject([run])}"
    facts = [f"sphere at {snapshot.distance * 1e6:.4g} µm"]
    if np.isfinite(run.scene.hardness):
        facts.append(f"hardness {run.scene.hardness * 1e-9:.4g} GPa")
    if scales.runs > 1:
        facts.append("same scales for all runs compared")
    note = captions.note(facts)
    lay_out(figure, title, note, places)
    return Picture("contact", f"Pressure and deflection. {title}: {note}", figure, {})


def _draw_contact(
    figure: Figure, run: RunResult, snapshot: Snapshot, scales: ContactScales
) -> dict[Axes, Box]:
    """Draw the maps of pressure and deflection, and return the boxes of all axes."""
    along, across = _sphere_position(run, snapshot)
    places: dict[Axes, Box] = {}
    maps = (
        ("pressure [GPa]", snapshot.pressure * 1e-9, scales.pressure * 1e-9, "black"),
        # The deflection outside the window is not known.
        ("deflection [µm]", snapshot.deflection * 1e6, scales.deflection * 1e6, "0.85"),
    )
    for index, (label, values, maximum, outside) in enumerate(maps):
        ax, bar = figure.add_subplot(), figure.add_subplot()
        axes.contact_map(ax, bar, snapshot, values, run.scene.spacing, (0.0, maximum), label)
        ax.set_xlim((along - scales.reach) * 1e6, (along + scales.reach) * 1e6)
        ax.set_ylim((across - scales.reach) * 1e6, (across + scales.reach) * 1e6)
        ax.set_facecolor(outside)
        if index:
            ax.set_ylabel("")
            ax.tick_params(labelleft=False)
        left = LEFT_IN + index * (_MAP_SIDE_IN + 1.3)
        places[ax] = (left, BOTTOM_IN, _MAP_SIDE_IN, _MAP_SIDE_IN)
        places[bar] = (left + _MAP_SIDE_IN + 0.1, BOTTOM_IN, BAR_IN, _MAP_SIDE_IN)
    return places


def _sphere_position(run: RunResult, snapshot: Snapshot) -> tuple[float, float]:
    """Return the sphere's position in the snapshot, along and across [m]."""
    return snapshot.distance, (run.scene.track.n_across - 1) / 2 * run.scene.spacing


def _reach(run: RunResult, snapshot: Snapshot) -> float:
    """Return the distance from the sphere to the farthest edge of the snapshot's window [m]."""
    spacing = run.scene.spacing
    low = (
        np.array([snapshot.along, snapshot.across]) - spacing / 2 - _sphere_position(run, snapshot)
    )
    return float(np.abs([low, low + np.array(snapshot.pressure.shape) * spacing]).max())


# ---- recovery events


@dataclass(frozen=True)
class EventDistribution:
    """Distribution of the recovery events over one quantity.

    Parameters
    ----------
    name, unit : str. Quantity, such as energy in J.
    edges : array (n + 1,). Edges of the bins, in the unit.
    events : array (n,). Share of the events in each bin.
    release : array (n,). Share of the released energy in each bin.
    """

    name: str
    unit: str
    edges: Array
    events: Array
    release: Array

    @classmethod
    def over(
        cls, quantity: tuple[str, str], values: Array, edges: Array, energy: Array
    ) -> EventDistribution:
        """Sort events into bins of a quantity (name, unit)."""
        counts, released = (
            np.histogram(values, edges, weights=weights)[0] for weights in (None, energy)
        )
        return cls(*quantity, edges, counts / counts.sum(), released / released.sum())


def event_distributions(run: RunResult) -> tuple[EventDistribution, EventDistribution] | None:
    """Sort the recovery events of a run by energy and by duration, if it has any."""
    table = run.events
    if table is None or run.event_statistics is None:
        return None
    energy, steps = table["energy"], table["last"] - table["first"]
    low, high = np.log10(energy.min()), np.log10(energy.max())
    bins = np.arange(
        np.floor(low * _ENERGIES_PER_DECADE), np.floor(high * _ENERGIES_PER_DECADE) + 2
    )
    width = -(-int(steps.max()) // _MOST_DURATIONS)
    return (
        EventDistribution.over(
            ("energy", "J"), energy, 10.0 ** (bins / _ENERGIES_PER_DECADE), energy
        ),
        EventDistribution.over(
            ("duration", "steps"), steps, np.arange(0.5, steps.max() + width + 0.5, width), energy
        ),
    )


def recovery_events(run: RunResult) -> Picture | None:
    """Draw the distributions of energy and duration of the recovery events.

    Returns
    -------
    picture : Picture. None without events.
    """
    distributions, statistics = event_distributions(run), run.event_statistics
    if distributions is None or statistics is None:
        return None
    title = f"Recovery events: {captions.subject([run])}"
    note = _events_note(statistics, run.result.step)
    figure = blank()
    places: dict[Axes, Box] = {}
    gap = 0.75
    width = (WIDTH_IN - LEFT_IN - RIGHT_IN - gap) / 2
    for index, each in enumerate(distributions):
        ax = figure.add_subplot()
        axes.shares(
            ax, each.edges, each.events, each.release, f"{each.name} of an event [{each.unit}]"
        )
        places[ax] = (LEFT_IN + index * (width + gap), BOTTOM_IN, width, 3.0)
    energies = distributions[0].edges
    figure.axes[0].set_xscale("log")
    # Energies below a millionth of the maximum are rounding of the solution.
    figure.axes[0].set_xlim(left=max(energies[0], _SMALLEST_SHARE * energies[-1]))
    figure.axes[1].set_ylabel("")
    lay_out(figure, title, note, places)
    return Picture("recovery_events", f"{title}: {note}", figure, _event_columns(distributions))


def _event_columns(distributions: Sequence[EventDistribution]) -> dict[str, NDArray[Any]]:
    """Return the bins of all distributions as a table."""
    names = [f"{each.name}_{each.unit.lower()}" for each in distributions]
    return {
        "quantity": np.repeat(names, [len(each.events) for each in distributions]),
        "lower_edge": np.concatenate([each.edges[:-1] for each in distributions]),
        "upper_edge": np.concatenate([each.edges[1:] for each in distributions]),
        "share_of_events": np.concatenate([each.events for each in distributions]),
        "share_of_release": np.concatenate([each.release for each in distributions]),
    }


def _events_note(statistics: EventStatistics, step: float) -> str:
    joule = EngFormatter("J", places=1)
    return captions.note(
        [
            f"{statistics.count:,} events, {captions.number(statistics.per_metre * 1e-3)} per mm",
            f"median {joule(statistics.energy_median)}, 90 % below {joule(statistics.energy_p90)}",
            f"the top tenth releases {100 * statistics.top_tenth_share:.3g} %",
            f"mean duration {statistics.duration_mean:.3g} steps of {step * 1e6:.3g} µm",
        ]
    )
