"""Pictures with a caption: figures as small SVG, drawn once and recoloured for a dark page."""

from __future__ import annotations

import base64
import colorsys
import io
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from picture_parts import Shown, dark_twin
from PIL import Image

from rolling.figures.settings import own_settings

COLUMNS = 500  # of a dense curve, as many as its picture has on a screen
WIDTH_IN = 6.2  # so narrow that letters can be read on a phone
# Letters stay letters, so a file is small, and a reader can search and copy them.
STYLE = {
    "svg.fonttype": "none",
    "font.size": 10.5,
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "sans-serif"],
    "legend.fontsize": 9.5,
    "path.simplify_threshold": 0.7,  # px that a curve may be off
}
PAPER = (30, 32, 41)  # red, green and blue of a dark page
INK = (228, 231, 240)
LIGHTEST = 0.86  # lightness on a dark page of a colour that is black on a light one
FALL = 0.4  # of this lightness with the lightness on a light page
MOST_COLOURS = 256  # of the image of a map
COLOUR = re.compile(r"#[0-9a-f]{6}\b")
PLACES = re.compile(r' (?:d|x|y)="[^"]*"')  # of paths, marks and letters
LONG_NUMBER = re.compile(r"-?\d+\.\d{2,}")
IMAGE = re.compile(r"(data:image/png;base64,)([^\"]+)")
DRAWING = re.compile(r"<svg ")
PLACE = re.compile(r"\{([^{}]+)\}")


class Drawn(NamedTuple):
    """A figure, the numbers that it shows, and its colours that stay as they are on a dark page.

    Colours stay where they are those of a map, which has its own ground.
    """

    figure: Figure
    numbers: dict[str, str]
    kept_colours: frozenset[str] = frozenset()


Draw = Callable[[Mapping[str, Any]], Drawn]


@contextmanager
def picture_style() -> Iterator[None]:
    """Draw in this context with letters and sizes of the pictures of the docs."""
    with own_settings():
        matplotlib.rcParams.update(STYLE)
        yield


def new_figure(height_in: float = 3.5) -> Figure:
    """Return an empty figure as wide as all pictures."""
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plain(ax: Axes) -> Axes:
    """Take title and legend away from axes of `rolling.plot`, and give them letters of full size.

    The caption says what the title says.
    """
    ax.set_title("", loc="left")
    if ax.get_legend() is not None:
        ax.get_legend().remove()
    ax.tick_params(which="both", labelsize="medium")
    for axis in (ax.xaxis, ax.yaxis):
        axis.label.set_fontsize("medium")
    return ax


def thin_out(ax: Axes) -> None:
    """Replace dense curves over rising x by the extremes in each column of the picture."""
    for line in ax.lines:
        x, y = line.get_data()
        if len(x) <= 2 * COLUMNS:
            continue
        places = ax.transData.transform(np.column_stack((x, y)))[:, 0]
        column = np.floor(COLUMNS * (places - places[0]) / (places[-1] - places[0]))
        starts = np.flatnonzero(np.diff(column, prepend=-1.0))
        extremes = (np.minimum.reduceat(y, starts), np.maximum.reduceat(y, starts))
        line.set_data(np.repeat(x[starts], 2), np.column_stack(extremes).ravel())


def legend_below(figure: Figure, ax: Axes, columns: int = 3) -> None:
    """Write the legend of axes below a figure."""
    handles, names = ax.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower left", ncols=columns, frameon=False)


def colours_of_scales(figure: Figure) -> frozenset[str]:
    """Draw the scales of maps as pixels, and return the colours of their ends.

    Pixels and these colours stay as they are on a dark page, as the map itself does.
    """
    ends = set()
    for scale in figure.findobj(QuadMesh):
        scale.set_rasterized(True)
        ends |= {to_hex(patch.get_facecolor()) for patch in scale.axes.patches}
    return frozenset(ends)


def write_svg(drawn: Drawn, path: Path, title: str) -> None:
    """Write a figure as an SVG for light pages, and as its twin for dark ones."""
    content = io.StringIO()
    kept_colours = drawn.kept_colours | colours_of_scales(drawn.figure)
    with matplotlib.rc_context({"svg.hashsalt": path.stem}):  # equal figures have equal ids
        metadata: dict[str, Any] = {"Date": None, "Creator": None, "Title": title}
        drawn.figure.savefig(content, format="svg", metadata=metadata)
    light = PLACES.sub(_with_short_numbers, content.getvalue())
    light = IMAGE.sub(lambda found: found[1] + _with_palette(found[2]), light)
    light = "\n".join(line.rstrip() for line in light.splitlines()) + "\n"
    path.write_text(light, encoding="utf-8")
    dark_twin(path).write_text(darkened(light, kept_colours), encoding="utf-8")


def darkened(svg: str, kept_colours: frozenset[str]) -> str:
    """Return an SVG for a dark page: greys from ink to paper, and colours as light as they need."""

    def dark(found: re.Match[str]) -> str:
        return found[0] if found[0] in kept_colours else dark_colour(found[0])

    # What has no colour of its own is black on a light page.
    return DRAWING.sub(f'<svg fill="{_hex(INK)}" ', COLOUR.sub(dark, svg), count=1)


def dark_colour(colour: str) -> str:
    """Return the colour on a dark page of a colour on a light one, both as #rrggbb."""
    red, green, blue = (int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5))
    hue, lightness, saturation = colorsys.rgb_to_hls(red, green, blue)
    if red == green == blue:
        levels = [ink + lightness * (paper - ink) for ink, paper in zip(INK, PAPER, strict=True)]
        return _hex(levels)
    lighter = colorsys.hls_to_rgb(hue, LIGHTEST - FALL * lightness, saturation)
    return _hex(255 * level for level in lighter)


def _with_short_numbers(places: re.Match[str]) -> str:
    """Return places [pt] with a tenth of a point, which nobody sees."""
    return LONG_NUMBER.sub(lambda found: f"{float(found[0]):.1f}", places[0])


def _with_palette(image: str) -> str:
    """Return an image in base64 with a palette, which is smaller; maps have few colours."""
    content = io.BytesIO()
    drawn = Image.open(io.BytesIO(base64.b64decode(image)))
    drawn.convert("RGB").quantize(MOST_COLOURS).save(content, format="png", optimize=True)
    return base64.b64encode(content.getvalue()).decode()


def _hex(levels: Any) -> str:
    """Return red, green and blue from 0 to 255 as #rrggbb."""
    return "#" + "".join(f"{round(level):02x}" for level in levels)


def make(path: Path, *, draw: Draw, entry: Mapping[str, Any], scenes: Mapping[str, Any]) -> Shown:
    """Draw the picture of an entry of pictures.toml into a file, and return what it shows."""
    with picture_style():
        drawn = draw({label: scene.read() for label, scene in scenes.items()})
        write_svg(drawn, path, entry["title"])
    caption = filled(entry["caption"], drawn.numbers)
    stated = [filled(text, drawn.numbers) for text in entry.get("texts", ())]
    pages = {entry["page"]: [caption, *stated]}
    for page, texts in entry.get("elsewhere", {}).items():
        pages[page] = [filled(text, drawn.numbers) for text in texts]
    return Shown(drawn.numbers, pages, caption)


def filled(text: str, numbers: Mapping[str, str]) -> str:
    """Return a text with numbers in place of their names in braces."""
    return PLACE.sub(lambda found: numbers[found[1]], text)
