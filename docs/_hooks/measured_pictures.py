"""The picture of measured times that docs/performance.md tabulates: growth."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from build_cache import ROOT
from drawn_pictures import Drawn, legend_below, new_figure

from acoustics.plot_style import COLOURS, LINE_STYLES, gridded

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
