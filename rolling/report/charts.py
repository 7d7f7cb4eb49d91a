"""Charts of the page: a drawn figure as numbers, thinned to the columns that a screen shows."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.container import BarContainer, ErrorbarContainer
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle, StepPatch
from matplotlib.ticker import FixedLocator

from acoustics.arrays import Array
from rolling.figures.picture import Picture
from rolling.figures.settings import own_settings
from rolling.report import maps

COLUMNS = 1500  # across a chart; each keeps its minimum and maximum
_DIGITS = 4  # of numbers, and more where they differ by little
Part = dict[str, Any]


@own_settings()
def chart_of(picture: Picture) -> dict[str, Any]:
    """Read a drawn figure as axes, curves and the parts that draw them, in the order of drawing."""
    ax, *others = picture.figure.axes
    sides = [ax, *(other for other in others if other.get_shared_x_axes().joined(ax, other))]
    title, note = str(ax.get_label()).split("\n")
    handles, names = ax.get_legend_handles_labels()
    curves = [{"name": name} | _look(handle) for handle, name in zip(handles, names, strict=True)]
    parts, xs = list[Part](), list[list[float | None]]()
    for right, side in enumerate(sides):
        for artist, label, part in sorted(_parts(side), key=lambda drawn: drawn[0].get_zorder()):
            if "png" not in part:
                look = _look(artist)
                part["of"] = number = _curve_of(label, look, curves)
                pale = number is not None and curves[number]["colour"] != look["colour"]
                part["pale"] = pale or None
            part["right"] = bool(right) or None
            if "x" in part:  # curves share their places along x
                xs += [part["x"]] if part["x"] not in xs else []
                part["x"] = xs.index(part["x"])
            parts.append({key: value for key, value in part.items() if value is not None})
    aspect, ground = ax.get_aspect(), to_hex(ax.get_facecolor())
    return {
        "name": picture.name,
        "title": title,
        "note": note,
        "x": _axis(ax.xaxis, ax.get_xlim()),
        "y": [_axis(side.yaxis, side.get_ylim()) for side in sides],
        "xs": xs,
        "curves": curves,
        "parts": parts,
        "texts": [text.get_text() for text in ax.texts],
        "aspect": None if aspect == "auto" else aspect,
        "ground": None if ground == "#ffffff" else ground,
    }


# ---- axes, numbers and looks


def _axis(axis: Axis, limits: tuple[float, float]) -> dict[str, Any]:
    """Return label, unit, scale, limits and named ticks of an axis."""
    label, _, unit = " ".join(axis.get_label_text().split()).partition(" [")
    fixed = isinstance(axis.get_major_locator(), FixedLocator)
    places = [float(place) for place in axis.get_majorticklocs()] if fixed else []
    names = axis.get_major_formatter().format_ticks(places)
    return {
        "label": label,
        "unit": unit.removesuffix("]").removeprefix("-"),
        "log": axis.get_scale() == "log",
        "limits": [float(f"{limit:.9g}") for limit in limits],
        "names": [*zip(numbers(places), names, strict=True)],
    }


def numbers(values: Any) -> list[float | None]:
    """Return numbers for JSON with four digits of their differences; None is not finite."""
    values = np.asarray(np.ma.filled(values, np.nan), dtype=float)
    finite = values[np.isfinite(values)]
    span = float(np.ptp(finite)) if len(finite) else 0.0
    extra = math.log10(float(np.abs(finite).max()) / span) if span > 0.0 else 0.0
    digits = min(_DIGITS + math.ceil(max(0.0, extra)), 15)
    rounded = (float(f"{value:.{digits}g}") for value in values)
    return [
        (int(x) if x.is_integer() and abs(x) < 1e9 else x) if math.isfinite(x) else None
        for x in rounded
    ]


def _look(artist: Any) -> dict[str, Any]:
    """Return colour, line style and marker of an artist or of the first one of a container."""
    if isinstance(artist, ErrorbarContainer):
        data, _, bars = artist.lines
        artist = data or bars[0]
    elif isinstance(artist, BarContainer):
        artist = artist.patches[0]
    if isinstance(artist, Line2D):
        colour, marker = artist.get_color(), artist.get_marker()
        return {"colour": to_hex(colour), "dash": artist.get_linestyle(), "marker": marker}
    if isinstance(artist, Patch):
        hollow = to_rgba(artist.get_facecolor())[3] == 0.0
        style = artist.get_linestyle()
        colour = artist.get_edgecolor() if hollow else artist.get_facecolor()
        return {"colour": to_hex(colour), "dash": style if isinstance(style, str) else "--"}
    faces, edges = artist.get_facecolor(), artist.get_edgecolor()
    return {"colour": to_hex((faces if len(faces) else edges)[0])}


def _curve_of(label: str, look: dict[str, Any], curves: list[dict[str, Any]]) -> int | None:
    """Return the number of the curve of a part, by its label, then by its colour; None: of none.

    A label that begins with _ is not in the legend. A part of a new colour is a curve of its own,
    unless it is grey.
    """
    name, colour = label.removeprefix("_"), look["colour"]
    grey = len({colour[1:3], colour[3:5], colour[5:7]}) == 1
    named = [k for k, curve in enumerate(curves) if curve["name"] == name]
    among = named or [*range(len(curves))]
    same = [k for k in among if curves[k]["colour"] == colour]
    if same or (grey and named):
        return (same or named)[0]
    if grey:
        return None
    curves.append({"name": name if named else ""} | look)
    return len(curves) - 1


# ---- parts


def _parts(ax: Axes) -> Iterator[tuple[Artist, str, Part]]:
    """Yield artist, label and numbers of all that is drawn on axes."""
    labels, caps = dict[Artist, str](), set[Artist]()
    for container in ax.containers:
        members: list[Artist] = list(getattr(container, "patches", []))
        if isinstance(container, ErrorbarContainer):
            data, ends, bars = container.lines
            members, caps = [data, *bars], caps | {*ends}
        labels |= dict.fromkeys(members, str(container.get_label()))
    for artist in (*ax.images, *ax.patches, *ax.collections, *ax.lines):
        if artist not in caps:
            label = labels.get(artist, str(artist.get_label()))
            yield from ((artist, label, part) for part in _numbers_of(ax, artist))


def _numbers_of(ax: Axes, artist: Any) -> Iterator[Part]:
    """Yield the numbers of an artist: none of an empty one, several of one in several pieces."""
    along, across = artist.get_transform().contains_branch_seperately(ax.transData)
    if isinstance(artist, AxesImage):
        yield {"kind": "image", **_image(artist)}
    elif isinstance(artist, Line2D):
        x, y = (np.asarray(np.ma.filled(v, np.nan), dtype=float) for v in artist.get_data())
        if not (along and across):
            yield {"kind": "rule", "along": along, "at": numbers(x if along else y)[0]}
        elif len(x):
            look = {"alpha": artist.get_alpha(), "width": artist.get_linewidth()}
            look["width"] = None if artist.get_linestyle() == "None" else look["width"]
            look["size"] = None if artist.get_marker() == "None" else artist.get_markersize()
            look["open"] = str(artist.get_markerfacecolor()) in ("none", "white") or None
            yield {"kind": "line", **_thinned(ax, x, y=y), **look}
    elif isinstance(artist, StepPatch):
        heights, edges, base = artist.get_data()
        part = {"kind": "steps", "x": numbers(edges), "y": numbers(heights)}
        yield part | {"base": None if base is None else float(np.ravel(base)[0])}
    elif isinstance(artist, Rectangle):
        left, low = artist.get_xy()
        corners = [left, left + artist.get_width(), low, low + artist.get_height()]
        part = {"kind": "bar" if along and across else "span", "ends": numbers(corners)}
        yield part | {"alpha": artist.get_alpha(), "hatch": bool(artist.get_hatch()) or None}
    elif isinstance(artist, LineCollection):
        bars = np.array([segment for segment in artist.get_segments() if len(segment) == 2])
        if len(bars):
            ends = {"low": bars[:, 0, 1], "high": bars[:, 1, 1]}
            yield {"kind": "errors", **_thinned(ax, bars[:, 0, 0], **ends)}
    elif isinstance(artist, PolyCollection):
        for path in artist.get_paths():
            band = _band(ax, np.asarray(path.vertices))
            yield {"kind": "band", **band, "alpha": artist.get_alpha()}


def _band(ax: Axes, outline: Array) -> Part:
    """Return the numbers of a filled band of which `fill_between` drew the outline."""
    count = (len(outline) - 3) // 2
    (x, low), high = outline[1 : count + 1].T, outline[count + 2 : 2 * count + 2][::-1, 1]
    # steps hold each pair of values until the next place
    steps = count > 1 and all(np.array_equal(y[:-1:2], y[1::2]) for y in (low, high))
    stride = 2 if steps else 1
    part = _thinned(ax, x[::stride], low=low[::stride], high=high[::stride])
    return part | {"step": steps or None}


def _thinned(ax: Axes, x: Array, **series: Array) -> Part:
    """Return series over x, with the minimum and maximum of each column if there are many."""
    place = ax.xaxis.get_transform().transform(x)
    if len(x) > 2 * COLUMNS and np.isfinite(place).all() and (np.diff(place) >= 0).all():
        share = (place - place[0]) / np.ptp(place)
        column = np.minimum(COLUMNS * share, COLUMNS - 1).astype(int)
        starts = np.flatnonzero(np.diff(column, prepend=-1))
        x, ends = np.repeat(x[starts], 2), (np.fmin.reduceat, np.fmax.reduceat)
        series = {k: np.ravel([end(y, starts) for end in ends], "F") for k, y in series.items()}
    return {"x": numbers(x)} | {key: numbers(y) for key, y in series.items()}


def _image(image: AxesImage) -> Part:
    """Return an image as a PNG with the colours of its palette, and label and limits of these."""
    values: Any = np.ma.masked_invalid(np.ma.asarray(image.get_array()))
    count = min(image.cmap.N, 255)
    colours = image.cmap(np.linspace(0.0, 1.0, count), bytes=True)[:, :3]
    empty = np.array(image.cmap(np.ma.masked, bytes=True))
    shade = np.clip(np.ma.filled(image.norm(values), 0.0) * count, 0, count - 1).astype(np.uint8)
    pixels = np.where(np.ma.getmaskarray(values), 0, 1 + shade).astype(np.uint8)
    upright = pixels[::-1] if image.origin == "lower" else pixels
    palette = np.vstack([empty[:3], colours]).astype(np.uint8)
    label = image.colorbar.ax.yaxis if image.colorbar else None
    return {
        "ends": numbers(image.get_extent()),
        "png": maps.png(upright, palette, None if empty[3] else 0),
        "colours": [f"#{bytes(colour).hex()}" for colour in colours],
        "scale": label and _axis(label, image.get_clim()),
    }
