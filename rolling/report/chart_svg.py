"""Charts as SVG that needs no script, which a page shows until its scripts draw them anew.

They have the same numbers as the charts of the scripts, thinned to what their pixels show.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.texts import printable
from rolling.report.chart_scale import Scale, ticks
from rolling.report.charts import Chart, Curve, Part

# Units are half pixels of a drawing of 480 pixels, so that places are whole numbers.
WIDTH = 960
LETTER = 26  # height of letters: 9.5 pixels on a phone of 390
LETTER_WIDTH = 14.5
ROW = 34  # from line to line of letters
HEIGHT = 460  # of the axes
MOST_HIGH = 840  # of axes with equal scales
MOST_NAMED = 24  # curves of a legend
EDGE = 8
COLUMN = 2  # of a dense line, which has a minimum and a maximum in each
STRAY = 1.2  # by which a line may differ from the numbers
FAR = 4000  # beyond which a place is cut
KEY = 60  # of a line in the legend
DASHES = {"--": "14 6", "-.": "16 6 3 6", ":": "3 6"}
BAR = 26  # width of the colours of an image


class Frame(NamedTuple):
    """The places of a chart: axes, width and height of the whole, and the scales.

    left, top, right, bottom : float. Edges of the axes.
    height : float. Height of the whole drawing.
    x : Scale. Scale along.
    sides : list of Scale. Scales of the left and the right axis.
    """

    left: float
    top: float
    right: float
    bottom: float
    height: float
    x: Scale
    sides: list[Scale]


def chart_svg(chart: Chart) -> Markup:
    """Draw a chart as an SVG with axes, curves and their names.

    Parameters
    ----------
    chart : Chart
        A chart as `charts.chart_of` reads it.

    Returns
    -------
    Markup
        The element. An image in it has the pixels of the chart.
    """
    legend = _legend_rows(chart)
    frame = _frame(chart, len(legend))
    name = f"{chart['title']}: {chart['note']}"
    whole = _box(frame.left, frame.top, frame.right, frame.bottom)
    ground = "" if chart["ground"] is None else f'<path d="{whole}" fill="{chart["ground"]}"/>'
    parts = [
        f'<svg class="drawn" viewBox="0 0 {WIDTH} {math.ceil(frame.height)}" role="img"'
        f' aria-label="{escape(printable(name))}">',
        ground,
        *_axes(chart, frame),
        f'<svg x="{frame.left:.0f}" y="{frame.top - 2:.0f}"'
        f' width="{frame.right - frame.left:.0f}" height="{frame.bottom - frame.top + 4:.0f}"'
        f' viewBox="{frame.left:.0f} {frame.top - 2:.0f}'
        f' {frame.right - frame.left:.0f} {frame.bottom - frame.top + 4:.0f}">',
        *(_part(part, chart, frame) for part in _in_order(chart["parts"])),
        "</svg>",
        *_texts(chart, frame),
        *_legend(chart, legend, frame),
        "</svg>",
    ]
    return Markup("".join(parts))


def _in_order(parts: Sequence[Part]) -> list[Part]:
    """Return the parts of a chart in the order of drawing: fields and areas behind curves."""
    behind = ("image", "span", "band")
    return sorted(parts, key=lambda part: part["kind"] not in behind)


# ---- places


def _frame(chart: Chart, legend_rows: int) -> Frame:
    """Return the places of a chart."""
    image = _image_of(chart)
    second = chart["y"][1:] or ([image["scale"]] if image and image["scale"] else [])
    left = _label_width(chart["y"][0])
    right = _label_width(second[0]) if second else 24.0
    if image and image["scale"]:
        right += 2 * BAR
    top = EDGE + ROW * (2 if second and _heads_collide(chart, second[0]) else 1) + 16
    high: float = HEIGHT
    across = WIDTH - left - right
    if chart["aspect"]:
        width, height = (
            abs(axis["limits"][1] - axis["limits"][0]) for axis in (chart["x"], chart["y"][0])
        )
        share = chart["aspect"] * height / width
        across = min(across, MOST_HIGH / share)
        high = max(120.0, across * share)
    bottom = top + high
    x = Scale.of(chart["x"], left, left + across)
    sides = [Scale.of(axis, bottom, top) for axis in chart["y"]]
    below = 2.4 * ROW + ROW * legend_rows + EDGE
    return Frame(
        left=left,
        top=top,
        right=left + across,
        bottom=bottom,
        height=bottom + below,
        x=x,
        sides=sides,
    )


def _label_width(axis: Mapping[str, Any]) -> float:
    """Return the width of the labels of the ticks of an upright axis, with their distance."""
    longest = max((len(text) for _, text in ticks(axis, 6)), default=1)
    return LETTER_WIDTH * max(2, longest) + 20


def _heads_collide(chart: Chart, second: Mapping[str, Any]) -> bool:
    """Tell whether the labels of both upright axes have no room beside each other."""
    letters = len(_label(chart["y"][0])) + len(_label(second)) + 3
    return LETTER_WIDTH * letters > WIDTH


def _label(axis: Mapping[str, Any]) -> str:
    """Write the label of an axis with its unit."""
    label = f"{axis['label']} [{axis['unit']}]" if axis["unit"] else axis["label"]
    return printable(label)


def _image_of(chart: Chart) -> Part | None:
    """Return the image of a chart; None without one."""
    return next((part for part in chart["parts"] if part["kind"] == "image"), None)


# ---- axes


def _axes(chart: Chart, frame: Frame) -> Iterator[str]:
    """Yield grid, ticks and labels."""
    grid = []
    room = (frame.right - frame.left) / (LETTER_WIDTH * 6)
    for value, text in ticks(chart["x"], max(2.0, room)):
        at = frame.x.place(value)
        grid.append(f"M{at:.0f} {frame.top:.0f}V{frame.bottom:.0f}")
        yield _text(at, frame.bottom + ROW, text, "middle")
    for value, text in ticks(chart["y"][0], 6):
        at = frame.sides[0].place(value)
        grid.append(f"M{frame.left:.0f} {at:.0f}H{frame.right:.0f}")
        yield _text(frame.left - 10, at + 9, text, "end")
    yield f'<path class="grid" d="{"".join(grid)}"/>'
    yield f'<path class="frame" d="M{frame.left:.0f} {frame.bottom:.0f}H{frame.right:.0f}"/>'
    yield _text(EDGE, EDGE + 22, _label(chart["y"][0]), "label")
    middle = (frame.left + frame.right) / 2
    yield _text(middle, frame.bottom + 2.1 * ROW, _label(chart["x"]), "label middle")
    image = _image_of(chart)
    if image and image["scale"]:
        yield from _colour_bar(image, frame)
    for axis, scale in zip(chart["y"][1:], frame.sides[1:], strict=True):
        yield from _right_axis(axis, scale, frame.right + 10, frame)


def _right_axis(axis: Mapping[str, Any], scale: Scale, left: float, frame: Frame) -> Iterator[str]:
    """Yield ticks and label of an axis at the right."""
    for value, text in ticks(axis, 6):
        yield _text(left, scale.place(value) + 9, text, "")
    yield _text(WIDTH - EDGE, frame.top - 28, _label(axis), "label end")


def _colour_bar(image: Part, frame: Frame) -> Iterator[str]:
    """Yield the colours of an image and their values beside it."""
    colours = image["colours"][:-1] if image.get("over") else image["colours"]
    shown = colours[:: max(1, len(colours) // 32)]
    left = frame.right + BAR
    step = (frame.bottom - frame.top) / len(shown)
    for number, colour in enumerate(shown):
        top = frame.bottom - (number + 1) * step
        yield f'<path fill="{colour}" d="{_box(left, top, left + BAR, top + step + 1)}"/>'
    scale = Scale.of(image["scale"], frame.bottom, frame.top)
    yield from _right_axis(image["scale"], scale, left + BAR + 8, frame)


def _text(left: float, top: float, words: str, kind: str) -> str:
    """Write words at a place."""
    named = f' class="{kind}"' if kind else ""
    return f'<text x="{left:.0f}" y="{top:.0f}"{named}>{escape(words)}</text>'


def _texts(chart: Chart, frame: Frame) -> Iterator[str]:
    """Yield the texts of the whole axes, and the names of places along x that have room."""
    middle = (frame.left + frame.right) / 2
    for text in chart["texts"]:
        at = (frame.top + frame.bottom) / 2
        yield _text(middle, at, printable(text), "silent")
    taken: list[tuple[float, float, float]] = []
    for name in sorted(chart["named"] or (), key=lambda name: (name["last"], name["at"])):
        at = frame.x.place(name["at"])
        top = frame.bottom - name["high"] * (frame.bottom - frame.top)
        half = LETTER_WIDTH * len(name["text"]) / 2
        begin, end = (at - half, at + half)
        if name["up"]:
            begin, end = (at - LETTER, at)
        elif name["begins"]:
            begin, end = (at, at + 2 * half + 8)
        overlaps = any(
            name["high"] == high and begin < last and end > first for high, first, last in taken
        )
        if overlaps or not (frame.left <= begin and end <= frame.right + 2):
            continue
        taken.append((name["high"], begin, end))
        words = escape(printable(name["text"]))
        if name["up"]:
            place = f"translate({at - 6:.0f} {top:.0f}) rotate(-90)"
            yield f'<text class="name end" transform="{place}">{words}</text>'
        else:
            yield _text(begin + 8 * name["begins"], top + 24, name["text"], "name")


# ---- curves


def _part(part: Part, chart: Chart, frame: Frame) -> str:
    """Draw a part of a chart."""
    kind = part["kind"]
    if kind == "image":
        left, right, low, high = part["ends"]
        x0, x1 = sorted(frame.x.places([left, right]))
        y0, y1 = sorted(frame.sides[0].places([low, high]))
        return (
            f'<image x="{x0:.0f}" y="{y0:.0f}" width="{x1 - x0:.0f}" height="{y1 - y0:.0f}"'
            f' href="{part["png"]}" preserveAspectRatio="none"/>'
        )
    number = part.get("of")
    curve = None if number is None else chart["curves"][number]
    style = "" if number is None else f' style="--c: {_colour_of(number, chart)}"'
    drawn = _DRAWN[kind](part, chart, frame)
    dash = DASHES.get(str(curve.get("dash"))) if curve else None
    dashed = f' stroke-dasharray="{dash}"' if dash and kind in ("line", "steps", "rule") else ""
    pale = ' opacity=".5"' if part.get("pale") else ""
    return "".join(
        f'<path class="{name}"{style}{dashed if name == "line" else ""}{pale} d="{path}"/>'
        for name, path in drawn
        if path
    )


def _colour_of(number: int, chart: Chart) -> str:
    """Return the colour of a curve by its number; greys are pale, and paler where they fill."""
    colour = chart["curves"][number]["colour"]
    if not is_grey(colour):
        return shades(colour)
    parts = [part for part in chart["parts"] if part.get("of") == number]
    is_line = any(part["kind"] in ("line", "rule") for part in parts)
    return "var(--chart-pale)" if is_line else "var(--chart-shade)"


def shades(colour: str) -> str:
    """Return a colour for light ground, with a lighter one for dark ground."""
    return f"light-dark({colour}, oklch(from {colour} calc(1 - 0.45 * l) c h))"


def is_grey(colour: str) -> bool:
    """Tell whether a colour is a grey, and not black."""
    return colour[1:3] == colour[3:5] == colour[5:7] and colour != "#000000"


Drawn = list[tuple[str, str]]  # classes of paths and the paths


def _line(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return a curve and its marks."""
    x = frame.x.places(chart["xs"][part["x"]])
    y = _side(part, frame).places(part["y"])
    drawn: Drawn = []
    if "width" in part:
        drawn.append(("line" if part["width"] >= 0.8 else "line thin", line_path(x, y)))
    if "size" in part or ("width" in part and len(x) == 1):
        marks = _marks(x, y)
        drawn.append(("dots", marks))
        if part.get("open"):
            drawn.append(("dots open", marks))
    return drawn


def _marks(x: Array, y: Array) -> str:
    """Return the path of marks, which are dots of the width of their line."""
    known = np.isfinite(x) & np.isfinite(y)
    return "".join(f"M{a:.0f} {b:.0f}h0" for a, b in zip(x[known], y[known], strict=True))


def _steps(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return steps between edges."""
    x = np.repeat(frame.x.places(chart["xs"][part["x"]]), 2)[1:-1]
    y = np.repeat(_side(part, frame).places(part["y"]), 2)
    return [("line", line_path(x, y))]


def _rule(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return a rule across the axes."""
    kind = "rule" if part.get("of") is None else "line"
    if part["along"]:
        at = frame.x.place(part["at"])
        top = frame.bottom - part.get("high", 1.0) * (frame.bottom - frame.top)
        path = f"M{at:.0f} {top:.0f}V{frame.bottom:.0f}" if math.isfinite(at) else ""
    else:
        at = _side(part, frame).place(part["at"])
        path = f"M{frame.left:.0f} {at:.0f}H{frame.right:.0f}" if math.isfinite(at) else ""
    return [(kind, path)]


def _bar(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return a bar, or a span over the whole height."""
    left, right, low, high = part["ends"]
    x0, x1 = _cut(frame.x.places([left, right]), frame.left, frame.right)
    y0, y1 = frame.bottom, frame.top
    if part["kind"] == "bar":
        y0, y1 = _cut(_side(part, frame).places([low, high]), frame.bottom, frame.top)
    kind = "missing" if part.get("of") is None else "bar"
    return [("hollow" if part.get("hollow") else kind, _box(x0, min(y0, y1), x1, max(y0, y1)))]


def _cut(places: Array, first: float, last: float) -> tuple[float, float]:
    """Return two places within the axes; one that is not known stands at the first edge."""
    low, high = sorted((first, last))
    kept = np.clip(np.where(np.isfinite(places), places, first), low, high)
    return float(kept[0]), float(kept[1])


def _band(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return a band between two curves."""
    side = _side(part, frame)
    x = frame.x.places(chart["xs"][part["x"]])
    low = side.places(part["low"])
    high = side.places(part["high"])
    if part.get("step"):
        x = np.append(np.repeat(x, 2)[1:], x[-1])
        low, high = np.repeat(low, 2), np.repeat(high, 2)
    paths = []
    for stretch in _stretches(np.isfinite(x) & np.isfinite(low) & np.isfinite(high)):
        around = np.append(x[stretch], x[stretch][::-1])
        edge = np.append(low[stretch], high[stretch][::-1])
        paths.append(f"{line_path(around, edge, is_dense=False)}Z")
    return [("band" if part.get("alpha") else "band full", "".join(paths))]


def _errors(part: Part, chart: Chart, frame: Frame) -> Drawn:
    """Return upright error bars."""
    side = _side(part, frame)
    x = frame.x.places(chart["xs"][part["x"]])
    bars = np.column_stack((x, side.places(part["low"]), side.places(part["high"])))
    known = bars[np.isfinite(bars).all(axis=1)]
    texts = [
        f"M{middle:.0f} {low:.0f}V{high:.0f}m-6 0h12M{middle - 6:.0f} {low:.0f}h12"
        for middle, low, high in known
    ]
    return [("errors", "".join(texts))]


_DRAWN = {
    "line": _line,
    "steps": _steps,
    "rule": _rule,
    "bar": _bar,
    "span": _bar,
    "band": _band,
    "errors": _errors,
}


def _side(part: Part, frame: Frame) -> Scale:
    """Return the upright scale of a part."""
    return frame.sides[1 if part.get("right") else 0]


def _box(left: float, top: float, right: float, bottom: float) -> str:
    """Return the path of a rectangle."""
    return f"M{left:.0f} {top:.0f}H{right:.0f}V{bottom:.0f}H{left:.0f}Z"


# ---- paths


def line_path(x: Array, y: Array, is_dense: bool = True) -> str:
    """Return the path of a line through places, thinned to what its pixels show.

    The line breaks where a place is not known.

    Parameters
    ----------
    x, y : (n,) arrays
        Places.
    is_dense : bool
        Whether several places in a column of pixels may be reduced to their extremes.
    """
    paths = []
    y = np.clip(y, -FAR, FAR)
    for stretch in _stretches(np.isfinite(x) & np.isfinite(y)):
        places = np.column_stack((x[stretch], y[stretch]))
        if is_dense:
            places = _extremes_of_columns(places)
        paths.append(_relative(np.rint(_simplified(places)).astype(int)))
    return "".join(paths)


def _stretches(known: NDArray[np.bool_]) -> Iterator[slice]:
    """Yield the stretches of places that are known."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        yield slice(int(begin), int(end))


def _extremes_of_columns(places: Array) -> Array:
    """Return places with the least and the largest of each column alone, in their order."""
    column = np.floor(places[:, 0] / COLUMN)
    if len(places) < 3 or (np.diff(column) < 0).any():
        return places
    starts = np.flatnonzero(np.diff(column, prepend=-np.inf))
    ends = np.append(starts[1:], len(places))
    kept: set[int] = {0, len(places) - 1}
    for begin, end in zip(starts, ends, strict=True):
        within = places[begin:end, 1]
        kept |= {int(begin + within.argmin()), int(begin + within.argmax())}
    return places[sorted(kept)]


def _simplified(places: Array) -> Array:
    """Leave out places that the line between others passes within `STRAY`.

    This is the algorithm of Ramer, Douglas and Peucker.
    """
    kept = np.zeros(len(places), dtype=bool)
    kept[[0, -1]] = True
    waiting = [(0, len(places) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        begin = places[first]
        along = places[last] - begin
        offsets = places[first + 1 : last] - begin
        length = math.hypot(*along)
        if length > 0:
            stray = np.abs(along[0] * offsets[:, 1] - along[1] * offsets[:, 0]) / length
        else:
            stray = np.hypot(offsets[:, 0], offsets[:, 1])
        farthest = int(stray.argmax())
        if stray[farthest] > STRAY:
            middle = first + 1 + farthest
            kept[middle] = True
            waiting += [(first, middle), (middle, last)]
    return places[kept]


def _relative(places: NDArray[np.int_]) -> str:
    """Write whole places as a path, each but the first by its distance from the one before."""
    (x, y), *_ = places.tolist()
    steps = np.diff(places, axis=0)
    numbers = steps[steps.any(axis=1)].ravel().tolist()
    text = "".join(f"{number}" if number < 0 else f" {number}" for number in numbers).strip()
    return f"M{x} {y}l{text}" if text else f"M{x} {y}h0"


# ---- names of curves


def _legend_rows(chart: Chart) -> list[list[int]]:
    """Return the numbers of the named curves of a chart in rows; none where they are too many."""
    by_name: dict[str, int] = {}
    for number, curve in enumerate(chart["curves"]):
        if curve["name"]:
            by_name.setdefault(curve["name"], number)
    if len(by_name) > MOST_NAMED:
        return []
    rows: list[list[int]] = []
    room = 0.0
    for number in by_name.values():
        width = _width_in_legend(chart["curves"][number])
        if width > room:
            rows.append([])
            room = WIDTH - EDGE
        rows[-1].append(number)
        room -= width
    return rows


def _width_in_legend(curve: Curve) -> float:
    """Return the width of a curve in the legend."""
    return KEY + 40 + LETTER_WIDTH * len(curve["name"])


def _legend(chart: Chart, rows: Sequence[Sequence[int]], frame: Frame) -> Iterator[str]:
    """Yield the keys and names of curves below the axes."""
    for row_number, row in enumerate(rows):
        left: float = EDGE
        middle = frame.bottom + (2.4 + row_number + 0.7) * ROW
        for number in row:
            curve = chart["curves"][number]
            yield _key(number, chart, left, middle - 9)
            yield _text(left + KEY + 12, middle, printable(curve["name"]), "label")
            left += _width_in_legend(curve)


def _key(number: int, chart: Chart, left: float, middle: float) -> str:
    """Return the key of a curve: a line, or a box for what is filled or hollow."""
    parts = [part for part in chart["parts"] if part.get("of") == number]
    style = f'style="--c: {_colour_of(number, chart)}"'
    if any(part["kind"] in ("line", "rule", "steps") for part in parts):
        dash = DASHES.get(str(chart["curves"][number].get("dash")), "")
        path = f"M{left:.0f} {middle:.0f}h{KEY}"
        return f'<path class="line" {style} stroke-dasharray="{dash}" d="{path}"/>'
    kind = "hollow" if any(part.get("hollow") for part in parts) else "bar"
    return f'<path class="{kind}" {style} d="{_box(left, middle - 9, left + KEY, middle + 9)}"/>'
