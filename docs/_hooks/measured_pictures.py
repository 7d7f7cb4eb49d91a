"""Pictures of measured times, which docs/performance.md tabulates: speed and growth."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from build_cache import ROOT
from drawn_pictures import Drawn, legend_below, new_figure

from acoustics.plot_style import COLOURS, LINE_STYLES, MARKERS, gridded

PAGE = ROOT / "docs" / "performance.md"
POWER_LAW = re.compile(r"([\d.]+) ms \(n/100\)\^([\d.]+)")


def rows_of_table(heading: str) -> list[dict[str, str]]:
    """Return the rows of the table of the page whose first columns are headed so."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(f"|{heading}|"))
    names = lines[first].strip("|").split("|")
    rows = []
    for line in lines[first + 2 :]:
        if not line.startswith("|"):
            break
        rows.append(dict(zip(names, line[1:-1].split("|"), strict=True)))
    return rows


def speed(scenes: Mapping[str, Any]) -> Drawn:
    """Draw error over time of this program and of others, on sequences that nobody tuned on."""
    rows = rows_of_table("sequence: Ra, L in µm, load in N, hardness in GPa")
    figure = new_figure(4.2)
    ax = figure.add_subplot()
    ratios = []
    for row in rows:
        name, _, kind = row["sequence: Ra, L in µm, load in N, hardness in GPa"].partition(":")
        peer = "aspher" if "elastic" in kind else "slippy"
        ratio = np.mean([float(text) for text in row["other over this program"].split(",")])
        ours, theirs = map(float, row["gap errors of both [1e-12 m]"].split(" and "))
        ratios.append(ratio)
        number = 1 if peer == "aspher" else 2
        ax.plot([1, ratio], [ours, theirs], color="0.75", linewidth=0.7, zorder=1)
        ax.plot(1, ours, "o", color=COLOURS[0], markersize=6)
        ax.plot(ratio, theirs, MARKERS[number], color=COLOURS[number], markersize=6)
        ax.annotate(name, (ratio, theirs), (5, -3), textcoords="offset points", fontsize=9)
    for label, number in (
        ("this program", 0),
        ("aspher (elastic)", 1),
        ("slippy (with a hardness)", 2),
    ):
        marker = "o" if number == 0 else MARKERS[number]
        ax.plot([], [], marker, color=COLOURS[number], label=label)
    ax.set(xscale="log", yscale="log", xlim=(0.7, 700))
    gridded(ax, xlabel="time over that of this program [-]", ylabel="gap error [1e-12 m]")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_major_formatter("{x:g}")
    legend_below(figure, ax)
    numbers = {
        "sequences": f"{len(rows)}",
        "least": f"{min(ratios):.0f}",
        "most": f"{max(ratios):.0f}",
    }
    return Drawn(figure, numbers)


def growth(scenes: Mapping[str, Any]) -> Drawn:
    """Draw the fitted time of a step over the width of its window."""
    figure = new_figure(4.2)
    ax = figure.add_subplot()
    powers = []
    for number, row in enumerate(rows_of_table("scene|nodes a side")):
        fit = POWER_LAW.fullmatch(row["fit"])
        assert fit is not None
        at_100_ms, power = map(float, fit.groups())
        low, high = (float(text.replace(",", "")) for text in row["nodes a side"].split(" to "))
        nodes = np.geomspace(low, high, 20)
        ax.plot(
            nodes,
            at_100_ms * (nodes / 100) ** power,
            color=COLOURS[number],
            linestyle=LINE_STYLES[number],
            label=row["scene"],
        )
        powers.append(power)
    ax.set(xscale="log", yscale="log")
    gridded(ax, xlabel="nodes on a side of the window", ylabel="time of a step [ms]")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_major_formatter("{x:g}")
    legend_below(figure, ax, columns=2)
    return Drawn(figure, {"least": f"{min(powers):.2f}", "most": f"{max(powers):.2f}"})
