"""Figures in three dimensions: surfaces (Fig. 1), contact pressure (Fig. 5), deflection (Fig. 6).

All readings are drawn on the same axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from rolling._typing import Array
from rolling.figures.picture import SIDE_IN, WIDTH_IN, Picture, blank
from rolling.lee2025.figure_data import PATCH_M, Contact, Reading, Scales, positions
from rolling.lee2025.figure_layout import Place, finish, panel_title

# positions along (m,) and across (n,) and values (m, n), as drawn
Sheet = tuple[Array, Array, Array]

_CELLS = 100  # maximum number of cells along a side: more can hardly be distinguished


def surfaces(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 1: the two roughest surfaces."""
    shown = [ra for ra in on.roughnesses if ra in reading.patches][-2:]
    sheets = []
    nodes: set[int] = set()
    for ra in shown:
        patch = reading.patches[ra]
        along, across = (positions(count, patch.spacing * 1e6) for count in patch.heights.shape)
        nodes.add(_stride(patch.heights))
        sheets.append((panel_title(reading, ra), _thinned(along, across, patch.heights * 1e6)))
    side = 1e6 * PATCH_M
    look = _Look(
        "height [µm]",
        (-on.height_um, on.height_um),
        "cividis",
        (0.0, side),
        along_label="along the track [µm]",
    )
    note = f"512 µm x 512 µm; one scale of height; {_drawn(nodes, 'every', 'nodes')}"
    return _sheets("fig1_surfaces", "Surfaces", note, reading, shown, sheets, look, 3.0)


def contact_pressure(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 5: pressure [GPa] under the lowest and the highest load."""
    reach = on.reach_um * 1e-6

    def sheet(contact: Contact) -> Sheet:
        inside = _within(contact, reach)
        every = _stride(inside.pressure)
        maxima = _blocks(inside.pressure, every)
        return inside.along[::every] * 1e6, inside.across[::every] * 1e6, maxima * 1e-9

    look = _Look("pressure [GPa]", (0.0, on.pressure_gpa), "magma", (-on.reach_um, on.reach_um))
    return _contacts(
        "fig5_contact_pressure", "Contact pressure", "a facet shows its maximum",
        reading, on, sheet, look,
        lambda contact: f"maximum {contact.pressure.max() * 1e-9:.2f} GPa",
    )  # fmt: skip


def deflection(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 6: deflection of the plate [um], downwards, under the lowest and highest load."""
    reach = on.reach_um * 1e-6

    def sheet(contact: Contact) -> Sheet:
        inside = _within(contact, reach)
        return _thinned(inside.along * 1e6, inside.across * 1e6, inside.deflection * 1e6)

    look = _Look("deflection [µm]", (on.deflection_um, 0.0), "viridis", (-on.reach_um, on.reach_um))
    return _contacts(
        "fig6_deflection", "Deflection of the plate", "downwards; the solved part, thinned",
        reading, on, sheet, look,
        lambda contact: f"maximum {contact.deflection.max() * 1e6:.2f} µm",
    )  # fmt: skip


@dataclass(frozen=True)
class _Look:
    """The look of sheets in three dimensions.

    Parameters
    ----------
    label, along_label : str. Labels of the vertical axis and of the axis along the track.
    limits : pair of float. Bottom and top of the vertical axis, in the unit of its label.
    colours : str. Name of the colour map.
    sides : pair of float, um. Limits of both horizontal axes.
    """

    label: str
    limits: tuple[float, float]
    colours: str
    sides: tuple[float, float]
    along_label: str = "along [µm]"


def _contacts(
    name: str,
    title: str,
    fact: str,
    reading: Reading,
    on: Scales,
    sheet: Callable[[Contact], Sheet],
    look: _Look,
    number: Callable[[Contact], str],
) -> Picture:
    """Draw a row for each roughness with a contact, and a column for each of the two loads.

    Parameters
    ----------
    name, title, fact : str. File name without suffix, title, and a fact for the note.
    reading, on : Reading and Scales. The data and the common axes.
    sheet : function. It makes the drawn sheet of a contact.
    look : _Look. Look of the sheets.
    number : function. It writes the maximum of a contact.
    """
    shown = [ra for ra in on.roughnesses if any((ra, load) in reading.contacts for load in on.ends)]
    sheets: list[tuple[str, Sheet | None]] = []
    for ra in shown:
        for load in on.ends:
            contact = reading.contacts.get((ra, load))
            heading = f"{panel_title(reading, ra)}, {load:g} N"
            if contact is None:
                sheets.append((f"{heading}: not solved", None))
            else:
                sheets.append((f"{heading}: {number(contact)}", sheet(contact)))
    note = (
        f"one surface at one position; along and across from the sphere's centre; {fact}; "
        "one scale for all readings"
    )
    return _sheets(name, title, note, reading, shown, sheets, look, 2.75)


def _sheets(
    name: str,
    title: str,
    note: str,
    reading: Reading,
    shown: Sequence[float],
    sheets: Sequence[tuple[str, Sheet | None]],
    look: _Look,
    tall: float,
) -> Picture:
    """Draw sheets in three dimensions, two in a row.

    Parameters
    ----------
    name, title, note : str. File name without suffix, title and note.
    reading, shown : Reading and sequence of float, um. The data, and the roughnesses that are
        shown.
    sheets : sequence of (heading, sheet). A sheet is None where the contact was not solved.
    look : _Look. Look of the sheets.
    tall : float, inches. Height of a row.
    """
    figure = blank()
    rows = -(-len(sheets) // 2)
    wide = (WIDTH_IN - 2 * SIDE_IN) / 2
    places: dict[Axes, Place] = {}
    for number, (heading, sheet) in enumerate(sheets):
        ax = cast(Axes3D, figure.add_subplot(projection="3d"))
        row, column = divmod(number, 2)
        # Labels of three-dimensional axes stand outside of their place.
        places[ax] = (
            SIDE_IN + column * wide,
            0.22 + (rows - 1 - row) * (tall + 0.3),
            wide - 0.3,
            tall - 0.1,
        )
        ax.text2D(
            0.5, 0.99, heading, transform=ax.transAxes, ha="center", va="bottom", fontsize=8.5
        )
        if sheet is None:
            ax.set_axis_off()
            continue
        _draw(ax, sheet, look)
    return finish(name, title, note, reading, shown, places, {})


def _draw(ax: Axes3D, sheet: Sheet, look: _Look) -> None:
    """Draw one sheet on its axes."""
    along, across, values = sheet
    grid = np.meshgrid(along, across, indexing="ij")
    drawn = ax.plot_surface(
        *grid,
        values,
        rcount=len(along),
        ccount=len(across),
        cmap=matplotlib.colormaps[look.colours],
        vmin=min(look.limits),
        vmax=max(look.limits),
        linewidth=0.0,
        antialiased=False,
    )
    drawn.set_rasterized(True)  # as an image the thousands of facets need a tenth of the space
    ax.set_xlim(look.sides)
    ax.set_ylim(look.sides)
    ax.set_zlim(look.limits)
    ax.set_box_aspect((1.0, 1.0, 0.55), zoom=1.12)
    ax.view_init(elev=28, azim=-58)
    ax.tick_params(labelsize=7, pad=0)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MaxNLocator(5))
    for set_label, text in (
        (ax.set_xlabel, look.along_label),
        (ax.set_ylabel, "across [µm]"),
        (ax.set_zlabel, look.label),
    ):
        set_label(text, fontsize=8, labelpad=0)


def _within(contact: Contact, reach: float) -> Contact:
    """Return the part of a contact within `reach` [m] of the sphere."""
    rows, columns = np.abs(contact.along) <= reach, np.abs(contact.across) <= reach
    part = np.ix_(rows, columns)
    return Contact(
        contact.along[rows],
        contact.across[columns],
        contact.pressure[part],
        contact.deflection[part],
    )


def _stride(values: Array) -> int:
    """Return the number of nodes per drawn cell along a side."""
    return int(-(-max(values.shape) // _CELLS))


def _thinned(along: Array, across: Array, values: Array) -> Sheet:
    """Return a thinned set of positions along (m,) and across (n,) with its values."""
    every = _stride(values)
    return along[::every], across[::every], values[::every, ::every]


def _blocks(values: Array, every: int) -> Array:
    """Return the maximum in each square block of nodes."""
    rows, columns = (-(-count // every) for count in values.shape)
    whole = np.zeros((rows * every, columns * every))
    whole[: values.shape[0], : values.shape[1]] = values
    highest: Array = whole.reshape(rows, every, columns, every).max(axis=(1, 3))
    return highest


def _drawn(nodes: set[int], every: str, noun: str) -> str:
    """Write the share of the nodes that are drawn."""
    return (
        f"drawn: {every} {' or '.join(map(str, sorted(nodes)))} {noun}"
        if nodes != {1}
        else "drawn: all nodes"
    )
