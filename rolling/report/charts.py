"""Charts of the page: a drawn figure as numbers, thinned to the columns that a screen shows."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

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
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedLocator

from acoustics.arrays import Array
from rolling.figures.picture import Picture
from rolling.figures.settings import own_settings
from rolling.report import maps

COLUMNS = 1500  # across a chart; each keeps its minimum and maximum
_DIGITS = 4  # of numbers, and more where they differ by little
_WHITE = "#ffffff"
Part = dict[str, Any]  # of a chart, as the page reads it; entries of None are left out
Chart = dict[str, Any]  # as the page reads it
Curve = dict[str, Any]  # name, colour, dash and marker of a curve in the legend


@own_settings()
def chart_of(picture: Picture) -> Chart:
    """Read a drawn figure as axes, curves and the parts that draw them, in the order of drawing.

    Thus the page shows the numbers of the figure itself, whatever function draws it.
    """
    ax, *others = picture.figure.axes
    sides = [ax]  # the second has its y axis at the right
    sides += [other for other in others if other.get_shared_x_axes().joined(ax, other)]
    caption = picture.caption
    assert caption is not None  # as all pictures of the page have one
    curves = _named_curves(ax)
    parts = list[Part]()
    places = list[list[float | None]]()  # along x, which curves share
    for side in sides:
        for drawn in sorted(_drawn_parts(side), key=lambda drawn: drawn.artist.get_zorder()):
            part = drawn.part
            if part["kind"] != "image":
                style = _style_of(drawn.artist)
                number = _number_of_curve(drawn.label, style, curves)
                part["of"] = number
                if number is not None and curves[number]["colour"] != style["colour"]:
                    part["pale"] = True
            if side is not ax:
                part["right"] = True
            if "x" in part:
                if part["x"] not in places:
                    places.append(part["x"])
                part["x"] = places.index(part["x"])
            parts.append({key: value for key, value in part.items() if value is not None})
    aspect = ax.get_aspect()
    ground = to_hex(ax.get_facecolor())
    return {
        "name": picture.name,
        "title": caption.title,
        "note": caption.note,
        "x": _axis(ax.xaxis, ax.get_xlim()),
        "y": [_axis(side.yaxis, side.get_ylim()) for side in sides],
        "xs": places,
        "curves": curves,
        "parts": parts,
        "texts": [text.get_text() for text in ax.texts if _is_said(ax, text)],
        "named": [_name(text) for text in ax.texts if _is_name(ax, text)] or None,
        "aspect": None if aspect == "auto" else aspect,
        "ground": None if ground == _WHITE else ground,
    }


def _is_said(ax: Axes, text: Text) -> bool:
    """Tell whether a text belongs to the whole axes, and to no place of them."""
    return _is_in_data(ax, text) == (False, False) and not isinstance(text, Annotation)


def _is_name(ax: Axes, text: Text) -> bool:
    """Tell whether a text names a place along x, at a height of the axes."""
    return _is_in_data(ax, text) == (True, False)


def _name(text: Text) -> dict[str, Any]:
    """Return the name of a place along x: text, height in the axes, and how it stands."""
    at, high = text.get_position()
    return {
        "at": numbers([at])[0],
        "text": text.get_text().strip(),
        "high": high,
        "up": text.get_rotation() == 90,
        "begins": text.get_horizontalalignment() == "left",
        "last": not text.get_visible(),
    }


# ---- axes, numbers and styles


def _axis(axis: Axis, limits: tuple[float, float]) -> dict[str, Any]:
    """Return label, unit, scale, limits and named ticks of an axis."""
    label, _, unit = " ".join(axis.get_label_text().split()).partition(" [")
    places = list[float]()
    if isinstance(axis.get_major_locator(), FixedLocator):
        places = [float(place) for place in axis.get_majorticklocs()]
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
    digits = _DIGITS
    if len(finite) and np.ptp(finite) > 0.0:
        over_span = float(np.abs(finite).max()) / float(np.ptp(finite))
        digits += math.ceil(max(0.0, math.log10(over_span)))
    digits = min(digits, 15)
    written = list[float | None]()
    for value in values:
        number = float(f"{value:.{digits}g}")
        if not math.isfinite(number):
            written.append(None)
        elif number.is_integer() and abs(number) < 1e9:
            written.append(int(number))
        else:
            written.append(number)
    return written


def _named_curves(ax: Axes) -> list[Curve]:
    """Return the curves in the legend of axes."""
    handles, names = ax.get_legend_handles_labels()
    curves = []
    for handle, name in zip(handles, names, strict=True):
        curves.append({"name": name} | _style_of(handle))
    return curves


def _style_of(artist: Any) -> dict[str, Any]:
    """Return colour, line style and marker of an artist or of the first one of a container."""
    if isinstance(artist, ErrorbarContainer):
        data, _, bars = artist.lines
        artist = data or bars[0]
    elif isinstance(artist, BarContainer):
        artist = artist.patches[0]
    if isinstance(artist, Line2D):
        return {
            "colour": to_hex(artist.get_color()),
            "dash": artist.get_linestyle(),
            "marker": artist.get_marker(),
        }
    if isinstance(artist, Patch):
        is_hollow = to_rgba(artist.get_facecolor())[3] == 0.0
        colour = artist.get_edgecolor() if is_hollow else artist.get_facecolor()
        dash = artist.get_linestyle()
        return {"colour": to_hex(colour), "dash": dash if isinstance(dash, str) else "--"}
    colours = artist.get_facecolor()
    if not len(colours):
        colours = artist.get_edgecolor()
    return {"colour": to_hex(colours[0])}


def _number_of_curve(label: str, style: dict[str, Any], curves: list[Curve]) -> int | None:
    """Return the number of the curve of a part, by its label, then by its colour; None: of none.

    A label that begins with _ is not in the legend. A part of a new colour is a curve of its own,
    which is added to the curves, unless it is grey.
    """
    name = label.removeprefix("_")
    colour = style["colour"]
    is_grey = colour[1:3] == colour[3:5] == colour[5:7]
    named = [k for k, curve in enumerate(curves) if curve["name"] == name]
    for k in named or range(len(curves)):
        if curves[k]["colour"] == colour:
            return k
    if is_grey:
        return named[0] if named else None
    curves.append({"name": name if named else ""} | style)
    return len(curves) - 1


# ---- parts


class _Drawn(NamedTuple):
    """An artist of axes with its label and the numbers of a part."""

    artist: Artist
    label: str
    part: Part


def _drawn_parts(ax: Axes) -> Iterator[_Drawn]:
    """Yield all that is drawn on axes."""
    labels = dict[Artist, str]()  # of containers, which their artists lack
    caps = set[Artist]()  # of error bars, which the page draws itself
    for container in ax.containers:
        members: list[Artist] = list(getattr(container, "patches", []))
        if isinstance(container, ErrorbarContainer):
            data, ends, bars = container.lines
            members = [data, *bars]
            caps.update(ends)
        for member in members:
            labels[member] = str(container.get_label())
    for artist in (*ax.images, *ax.patches, *ax.collections, *ax.lines):
        if artist not in caps:
            label = labels.get(artist, str(artist.get_label()))
            for part in _parts_of(ax, artist):
                yield _Drawn(artist, label, part)


def _parts_of(ax: Axes, artist: Any) -> list[Part]:
    """Return the numbers of an artist: none of an empty one, several of one in several pieces."""
    if isinstance(artist, AxesImage):
        return [_image(artist)]
    if isinstance(artist, Line2D):
        return _line(ax, artist)
    if isinstance(artist, StepPatch):
        return [_steps(artist)]
    if isinstance(artist, Rectangle):
        return [_bar(ax, artist)]
    if isinstance(artist, LineCollection):
        return _error_bars(ax, artist)
    if isinstance(artist, PolyCollection):
        return [
            _band(ax, np.asarray(path.vertices)) | {"alpha": artist.get_alpha()}
            for path in artist.get_paths()
        ]
    return []


def _is_in_data(ax: Axes, artist: Artist) -> tuple[bool, bool]:
    """Tell along x and along y whether an artist has places in data, not in parts of the axes."""
    along, across = artist.get_transform().contains_branch_seperately(ax.transData)
    return along, across


def _line(ax: Axes, line: Line2D) -> list[Part]:
    """Return a line, or a rule across the axes."""
    x, y = (np.asarray(np.ma.filled(data, np.nan), dtype=float) for data in line.get_data())
    along, across = _is_in_data(ax, line)
    if not (along and across):
        rule: Part = {"kind": "rule", "along": along, "at": numbers(x if along else y)[0]}
        if along and y[-1] < 1.0:
            rule["high"] = float(y[-1])
        return [rule]
    if not len(x):
        return []
    part = {"kind": "line", **_thinned(ax, x, y=y), "alpha": line.get_alpha()}
    if line.get_linestyle() != "None":
        part["width"] = line.get_linewidth()
    if line.get_marker() != "None":
        part["size"] = line.get_markersize()
    if str(line.get_markerfacecolor()) in ("none", "white"):
        part["open"] = True
    return [part]


def _steps(steps: StepPatch) -> Part:
    """Return steps between edges."""
    heights, edges, base = steps.get_data()
    part: Part = {"kind": "steps", "x": numbers(edges), "y": numbers(heights)}
    if base is not None:
        part["base"] = float(np.ravel(base)[0])
    return part


def _bar(ax: Axes, bar: Rectangle) -> Part:
    """Return a bar, or a span across the axes."""
    left, low = bar.get_xy()
    ends = [left, left + bar.get_width(), low, low + bar.get_height()]
    kind = "bar" if all(_is_in_data(ax, bar)) else "span"
    part: Part = {"kind": kind, "ends": numbers(ends), "alpha": bar.get_alpha()}
    if to_rgba(bar.get_facecolor())[3] == 0.0:
        part["hollow"] = True
    return part


def _error_bars(ax: Axes, bars: LineCollection) -> list[Part]:
    """Return upright error bars."""
    ends = np.array([segment for segment in bars.get_segments() if len(segment) == 2])
    if not len(ends):
        return []
    return [
        {"kind": "errors", **_thinned(ax, ends[:, 0, 0], low=ends[:, 0, 1], high=ends[:, 1, 1])}
    ]


def _band(ax: Axes, outline: Array) -> Part:
    """Return the numbers of a filled band of which `fill_between` drew the outline."""
    count = (len(outline) - 3) // 2
    x, low = outline[1 : count + 1].T
    high = outline[count + 2 : 2 * count + 2][::-1, 1]
    # Steps hold each pair of values until the next place.
    if count > 1 and all(np.array_equal(y[:-1:2], y[1::2]) for y in (low, high)):
        part = _thinned(ax, x[::2], low=low[::2], high=high[::2])
        return {"kind": "band", **part, "step": True}
    return {"kind": "band", **_thinned(ax, x, low=low, high=high)}


def _thinned(ax: Axes, x: Array, **series: Array) -> Part:
    """Return series over x, with the minimum and maximum of each column if there are many."""
    place = ax.xaxis.get_transform().transform(x)
    if len(x) > 2 * COLUMNS and np.isfinite(place).all() and (np.diff(place) >= 0).all():
        share = (place - place[0]) / np.ptp(place)
        column = np.minimum(COLUMNS * share, COLUMNS - 1).astype(int)
        starts = np.flatnonzero(np.diff(column, prepend=-1))
        x = np.repeat(x[starts], 2)
        for name, values in series.items():
            minima = np.fmin.reduceat(values, starts)
            maxima = np.fmax.reduceat(values, starts)
            series[name] = np.column_stack((minima, maxima)).ravel()
    return {"x": numbers(x)} | {key: numbers(y) for key, y in series.items()}


def _image(image: AxesImage) -> Part:
    """Return an image as a PNG with the colours of its palette, and label and limits of these.

    Missing values are transparent. Values beyond the limits have a colour of their own at the end
    of the palette if the figure gives them one: `over` tells that.
    """
    values: Any = np.ma.masked_invalid(np.ma.asarray(image.get_array()))
    count = min(image.cmap.N, 254)
    colours = image.cmap(np.linspace(0.0, 1.0, count), bytes=True)[:, :3]
    shade = np.clip(np.ma.filled(image.norm(values), 0.0) * count, 0, count - 1).astype(np.uint8)
    over = image.cmap(np.array([2.0]), bytes=True)[:, :3]
    has_over = not np.array_equal(over[0], colours[-1])
    if has_over:
        colours = np.vstack([colours, over])
        shade[np.ma.filled(values, -np.inf) > image.get_clim()[1]] = count
    pixels = np.where(np.ma.getmaskarray(values), 0, 1 + shade).astype(np.uint8)
    if image.origin == "lower":
        pixels = pixels[::-1]
    palette = np.vstack([np.zeros(3), colours]).astype(np.uint8)
    scale = None
    if image.colorbar:
        scale = _axis(image.colorbar.ax.yaxis, image.get_clim())
    return {
        "kind": "image",
        "ends": numbers(image.get_extent()),
        "png": maps.png(pixels, palette, 0),
        "colours": [f"#{bytes(colour).hex()}" for colour in colours],
        "over": has_over or None,
        "scale": scale,
    }
