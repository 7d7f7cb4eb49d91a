"""Title, note and axes of a figure, and warnings about surfaces too steep for half-space theory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rolling._typing import Array
from rolling.check.validity import MAX_SLOPE
from rolling.figures.picture import SIDE_IN, WIDTH_IN, Picture, lay_out
from rolling.lee2025.figure_data import Reading

Place = tuple[float, float, float, float]

WARNING = "#B34400"
_LINE_IN = 0.2  # height of a line of warnings below a figure


def finish(
    name: str,
    title: str,
    note: str,
    reading: Reading,
    shown: Sequence[float],
    places: dict[Axes, Place],
    columns: dict[str, Array],
) -> Picture:
    """Lay out a picture, with its warnings below the axes.

    Parameters
    ----------
    name, title, note : str. File name without suffix, title and note of the figure.
    reading : Reading. The reading that it shows.
    shown : sequence of float, um. The roughnesses that it shows.
    places : dict from Axes to (left, bottom, width, height), inches. Places of the axes.
    columns : dict from str to array. The plotted numbers, for the CSV file.
    """
    figure = cast(Figure, next(iter(places)).figure)
    too_steep = [text for ra in shown for text in warnings(reading, ra)]
    room = 0.06 + _LINE_IN * len(too_steep) if too_steep else 0.0
    lifted: dict[Axes, Place] = {
        ax: (left, bottom + room, wide, tall) for ax, (left, bottom, wide, tall) in places.items()
    }
    if too_steep:
        strip = figure.add_subplot()
        strip.set_axis_off()
        strip.text(
            0.0,
            0.5,
            "\n".join(too_steep),
            color=WARNING,
            fontsize=8.5,
            va="center",
            fontweight="bold",
        )
        lifted[strip] = (SIDE_IN, 0.0, WIDTH_IN - 2 * SIDE_IN, room)
    full = f"{title}: {reading.name}"
    lay_out(figure, full, note, lifted)
    return Picture(name, ". ".join([f"{full}: {note}", *too_steep]), figure, columns)


def warnings(reading: Reading, roughness_um: float) -> list[str]:
    """Return the warnings about surfaces of this Ra that are too steep.

    Each correlation length has a line.
    """
    lines = []
    for (ra, length), norm in sorted(reading.slopes.items()):
        if ra == roughness_um and norm > MAX_SLOPE:
            surface = f"Ra {ra:g} µm" + (
                f", length {length:g} µm" if len(reading.lengths) > 1 else ""
            )
            each = norm / np.sqrt(2)  # the surface is isotropic
            lines.append(
                f"{surface}: rms slope {each:.2g} along each direction, "
                f"norm {norm:.2g} > {MAX_SLOPE:g}: half-space"
                " theory does not hold"
            )
    return lines


def steep(reading: Reading, roughness_um: float) -> bool:
    """Return whether any surface of this Ra is too steep for half-space theory."""
    return bool(warnings(reading, roughness_um))


def panel_title(reading: Reading, roughness_um: float) -> str:
    """Return the title of a panel, with a mark where the surface is too steep."""
    return f"Ra {roughness_um:g} µm" + (
        " (not valid: too steep)" if steep(reading, roughness_um) else ""
    )
