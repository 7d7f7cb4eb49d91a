"""Picture and table of the time and memory of a step over its nodes in contact.

They show what tests/benchmarks/step_cost.py measured and stored.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import log
from typing import Any

import numpy as np
from build_cache import ROOT
from drawn_pictures import Drawn, legend_below, new_figure
from matplotlib.axes import Axes

from acoustics.numbers import rounded
from acoustics.plot_style import COLOURS, MARKERS, gridded

STORED = ROOT / "tests" / "benchmarks" / "step_cost.json"
NODES = (1e2, 1e3, 1e4, 1e5)  # in contact, of the columns of the table
POWERS = "10², 10³, 10⁴, 10⁵"
FINER = 4.0  # times the nodes of a grid with half the spacing
NONE = "-"

Points = Sequence[Mapping[str, Any]]  # measured steps, from few nodes in contact to many


def measured() -> dict[str, Any]:
    """Return the stored measurement: kinds of contact, public solvers and tracks."""
    content: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return content


def at_nodes(points: Points, name: str, nodes: float, over: str = "") -> float | None:
    """Return a measured number, or a ratio of two, at so many nodes in contact.

    It lies on the straight line between two points in logarithms; None where there are no two.
    """
    known = [point for point in points if point[name] and (not over or point[over])]
    places = np.log([point["in_contact"] for point in known])
    if not known or not places[0] <= log(nodes) <= places[-1]:
        return None
    values = np.log([point[name] / (point[over] if over else 1.0) for point in known])
    return float(np.exp(np.interp(log(nodes), places, values)))


def power_of(points: Points) -> float | None:
    """Return the power of the nodes with which the time grows in the last decade of NODES."""
    few, many = (at_nodes(points, "ms", nodes) for nodes in NODES[-2:])
    if few is None or many is None:
        return None
    return log(many / few) / log(NODES[-1] / NODES[-2])


def growth(scenes: Mapping[str, Any]) -> Drawn:
    """Draw time and memory of a step over the nodes in contact, and tabulate them."""
    content = measured()
    kinds = content["kinds"]
    figure = new_figure(6.8)
    times, memory = figure.subplots(2, sharex=True, height_ratios=(2, 1))
    for number, (kind, points) in enumerate(kinds.items()):
        style = {"color": COLOURS[number], "marker": MARKERS[number]}
        _curves(times, memory, points, kind, style)
    for name, peer in content["peers"].items():
        number = list(kinds).index(peer["kind"])
        style = {"color": COLOURS[number], "marker": MARKERS[number], "linestyle": "--"}
        label = f"{name}, contacts of the same colour"
        _curves(times, memory, peer["points"], label, style | {"markerfacecolor": "none"})
    for ax, words in ((times, "time of a step [ms]"), (memory, "memory [MB]")):
        ax.set(xscale="log", yscale="log")
        gridded(ax, xlabel="", ylabel=words)
        ax.minorticks_off()
        ax.yaxis.set_major_formatter("{x:,g}")
    memory.set_xlabel("nodes in contact")
    memory.xaxis.set_major_formatter("{x:,.0f}")
    legend_below(figure, times, columns=2)
    return Drawn(figure, _rows(content) | _ends(content))


def _curves(
    times: Axes, memory: Axes, points: Points, label: str, style: Mapping[str, Any]
) -> None:
    """Draw time and memory of measured steps."""
    for ax, name in ((times, "ms"), (memory, "memory_mb")):
        known = [point for point in points if point[name]]
        ax.plot(
            [point["in_contact"] for point in known],
            [point[name] for point in known],
            markersize=4.5,
            linewidth=1.2,
            label=label,
            **style,
        )


def _rows(content: Mapping[str, Any]) -> dict[str, str]:
    """Return the rows of the table, and where and when they were measured."""
    rows = {}
    for kind, points in content["kinds"].items():
        over = [at_nodes(points, "ms", nodes, over="bare_ms") for nodes in NODES]
        rows[f"row {kind}"] = _row(f"this program, {kind}", points, over)
    for name, peer in content["peers"].items():
        points = peer["points"]
        over = [at_nodes(points, "ms", nodes, over="own_ms") for nodes in NODES]
        rows[f"row {name}"] = _row(f"{name}, {peer['kind']}", points, over)
    one = [track for track in content["tracks"] if track["workers"] == 1]
    lengths = ", ".join(f"{track['steps']:,}" for track in one)
    rows["row steps"] = _line(
        f"steps of the track: {lengths}",
        "quickstart at 20 N",
        _listed(track["cpu_ms"] for track in one),
        NONE,
        NONE,
        _listed((track["memory_mb"] for track in one), digits=3),
    )
    longest = [track for track in content["tracks"] if track["steps"] == one[-1]["steps"]]
    rows["row workers"] = _line(
        f"workers: {', '.join(str(track['workers']) for track in longest)}",
        f"the same, {one[-1]['steps']:,} steps, a core for each worker",
        _listed(track["cpu_ms"] / track["workers"] for track in longest),
        NONE,
        NONE,
        "as much in each process",
    )
    versions = [f"{name} {peer['version']}" for name, peer in content["peers"].items()]
    dates = {content["date"], *(peer["date"] for peer in content["peers"].values())}
    machine = content["machine"]
    note = f"; {machine['note']}" if machine["note"] else ""
    rows["measured"] = (
        f"Measured on {' and '.join(sorted(dates))} with {' and '.join(versions)}"
        f" ({machine['cpu']}, {machine['cores']} cores{note})."
    )
    return rows


def _row(label: str, points: Points, over: Sequence[float | None]) -> str:
    """Return the row of steps over nodes in contact."""
    power = power_of(points)
    return _line(
        f"nodes in contact: {POWERS}",
        label,
        _listed(at_nodes(points, "ms", nodes) for nodes in NODES),
        NONE if power is None else f"{power:.2f}",
        _listed(over),
        _listed(at_nodes(points, "memory_mb", nodes) for nodes in NODES),
    )


def _line(*cells: str) -> str:
    return f"|{'|'.join(cells)}|"


def _listed(values: Any, digits: int = 2) -> str:
    """Return numbers with commas between them, and a dash for those that there are not."""
    return ", ".join(NONE if value is None else rounded(value, digits) for value in values)


def _ends(content: Mapping[str, Any]) -> dict[str, str]:
    """Return the extremes that the caption and the page tell."""
    kinds = content["kinds"].values()
    found = {
        "few": [at_nodes(points, "ms", NODES[0]) for points in kinds],
        "many": [at_nodes(points, "ms", NODES[-1]) for points in kinds],
        "over few": [at_nodes(points, "ms", NODES[0], over="bare_ms") for points in kinds],
        "over many": [at_nodes(points, "ms", NODES[-1], over="bare_ms") for points in kinds],
        "memory": [
            point["own_memory_mb"] / point["memory_mb"]
            for peer in content["peers"].values()
            for point in peer["points"]
            if point["memory_mb"] and point["own_memory_mb"]
        ],
    }
    for name, peer in content["peers"].items():
        found[name] = [
            point["ms"] / point["own_ms"]
            for point in peer["points"]
            if point["ms"] and point["own_ms"]
        ]
    powers = [power for points in kinds if (power := power_of(points)) is not None]
    ends = {
        "power least": f"{min(powers):.2f}",
        "power most": f"{max(powers):.2f}",
        "finer least": rounded(FINER ** min(powers)),
        "finer most": rounded(FINER ** max(powers)),
    }
    for name, values in found.items():
        known = [value for value in values if value is not None]
        ends[f"{name} least"] = rounded(min(known))
        ends[f"{name} most"] = rounded(max(known))
    return ends
