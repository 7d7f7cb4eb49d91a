"""The drawing of a machine with its numbers on it: one SVG that needs no script.

The picture stands at the left, and its numbers below each other at its right, each with a line to
its place. The numbers are pushed apart until none covers another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from markupsafe import Markup, escape

from acoustics.texts import printable
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.machine import PICTURE, Callout, Machine
from rolling.kinds.registry import kind_of
from rolling.terminal.streams import unbroken

WIDTH = 360.0  # of the drawing, which a phone of 390 pixels shows at its size
COLUMN = 210.0  # where the numbers begin
LETTER = 12.0  # height of letters; 11 are the least that one reads
LINE = 14.5  # from line to line
GAP = 6.0  # between two numbers
EDGE = 4.0  # above the first number and below the last one
# Widths of letters over their height, those of DejaVu Sans, the widest of usual fonts of pages.
_NARROW = "fijlrtIJ.,;:'()[]|!/- \N{NO-BREAK SPACE}"
_WIDE = "mwMW@%±"
_WIDTH_OF_NARROW = 0.4
_WIDTH = 0.65
_WIDTH_OF_CAPITAL = 0.76
_WIDTH_OF_WIDE = 0.98
_BOLD = 1.13  # width of bold letters over that of others


class TextBox(NamedTuple):
    """The lines of a number, and where they stand.

    callout : Callout. The number and its place in the picture.
    lines : tuple of str. Its words, broken into lines.
    values : int. How many of them have the value, the others say what it is.
    top : float. Upper end of the first line.
    """

    callout: Callout
    lines: tuple[str, ...]
    values: int
    top: float

    @property
    def height(self) -> float:
        """Height of all lines."""
        return LINE * len(self.lines)

    @property
    def middle(self) -> float:
        """Middle of all lines."""
        return self.top + self.height / 2

    @property
    def width(self) -> float:
        """Estimated width of the longest line."""
        return max(
            text_width(line, is_bold=number < self.values) for number, line in enumerate(self.lines)
        )


class MachineDrawing(NamedTuple):
    """The drawing of the machine of some runs, and which ones they are unless they are all."""

    svg: Markup
    note: str


def drawing_of(
    scenes: Sequence[Any], numbers: Sequence[Any] = (), name: str = "machine"
) -> MachineDrawing | None:
    """Draw the machine of the first of some scenes; None where its kind has no drawing.

    Parameters
    ----------
    scenes : sequence of scenes, at least one
        Scenes without a sweep. Those of the same name and kind as the first have their numbers on
        the drawing.
    numbers : sequence of numbers
        Those of the solved runs of all scenes. Default: none is solved.
    name : str
        Name of the drawing, which no other on its page has.
    """
    first = scenes[0]
    kind = kind_of(first)
    alike = [
        place
        for place, scene in enumerate(scenes)
        if scene.name == first.name and kind_of(scene) is kind
    ]
    solved = [numbers[place] for place in alike] if numbers else []
    with left_out_if_it_fails(f"of the machine of {first.name}"):
        machine = kind.machine([scenes[place] for place in alike], solved)
        if machine is not None:
            note = "" if len(alike) == len(scenes) else f"Drawn: {printable(first.name)}."
            return MachineDrawing(machine_svg(machine, name), note)
    return None


def machine_svg(machine: Machine, name: str = "machine") -> Markup:
    """Draw a machine as an SVG, whose colours are those of the page.

    Parameters
    ----------
    machine : Machine
        Shapes and numbers.
    name : str
        Name of the drawing, which no other on its page has.

    Returns
    -------
    Markup
        The element, with a title and a description for those who do not see it.
    """
    boxes = text_boxes(machine)
    height = drawing_height(machine)
    down = (height - machine.height) / 2
    shapes = []
    for shape in machine.shapes:
        load = f' style="--share:{shape.share:.2f}"' if shape.role == "load" else ""
        shapes.append(f'<path class="{shape.role}"{load} d="{shape.path}"/>')
    leaders = [_leader(box, down) for box in boxes]
    texts = [_text(box) for box in boxes]
    return Markup(
        f'<svg class="machine" viewBox="0 0 {WIDTH:g} {height:g}" role="img"'
        f' aria-labelledby="{name}-title {name}-words">'
        f'<title id="{name}-title">{escape(printable(machine.title))}</title>'
        f'<desc id="{name}-words">{escape(in_words(machine))}</desc>'
        f'<g transform="translate(0 {down:.1f})">{"".join(shapes)}</g>'
        f'<path class="leader" d="{"".join(leaders)}"/>{"".join(texts)}</svg>'
    )


def in_words(machine: Machine) -> str:
    """Return the numbers of a drawing as a sentence."""
    texts = [f"{callout.words}: {callout.value}" for callout in machine.callouts]
    return printable(f"{'; '.join(texts)}.")


def text_boxes(machine: Machine) -> list[TextBox]:
    """Return the numbers of a drawing from top to bottom, none of which covers another one.

    Each stands as near to the height of its place as the others allow.
    """
    height = drawing_height(machine)
    down = (height - machine.height) / 2
    callouts = sorted(machine.callouts, key=lambda callout: (callout.at[1], callout.at[0]))
    boxes = [_broken(callout) for callout in callouts]
    placed = []
    top = EDGE
    for box in boxes:
        wanted = box.callout.at[1] + down - box.height / 2
        top = max(top, wanted)
        placed.append(box._replace(top=top))
        top += box.height + GAP
    bottom = height - EDGE
    for k, box in reversed([*enumerate(placed)]):
        top = min(box.top, bottom - box.height)
        placed[k] = box._replace(top=top)
        bottom = top - GAP
    return placed


def drawing_height(machine: Machine) -> float:
    """Return the height of a drawing: that of its picture, or of all its numbers."""
    numbers = sum(_broken(callout).height + GAP for callout in machine.callouts)
    return max(machine.height, numbers - GAP + 2 * EDGE)


def _broken(callout: Callout) -> TextBox:
    """Break value and words of a number into lines."""
    value = _lines(unbroken(printable(callout.value)), is_bold=True)
    words = _lines(unbroken(printable(callout.words)), is_bold=False)
    return TextBox(callout=callout, lines=(*value, *words), values=len(value), top=0.0)


def _lines(text: str, is_bold: bool) -> list[str]:
    """Break a text between words, and within one that is too long, into lines that fit."""
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and not _fits(f"{lines[-1]} {word}", is_bold):
            lines.append("")
        if lines[-1]:
            lines[-1] += " "
        for letter in word:
            if not _fits(lines[-1] + letter, is_bold):
                lines.append("")
            lines[-1] += letter
    return [line for line in lines if line]


def _fits(text: str, is_bold: bool) -> bool:
    """Tell whether a text fits beside the picture."""
    return text_width(text, is_bold) <= WIDTH - COLUMN


def text_width(text: str, is_bold: bool = False) -> float:
    """Estimate the width of a text, within which the fonts of pages keep."""
    width = LETTER * sum(_letter_width(letter) for letter in text)
    return _BOLD * width if is_bold else width


def _letter_width(letter: str) -> float:
    """Return the width of a letter over its height."""
    if letter in _NARROW:
        return _WIDTH_OF_NARROW
    if letter in _WIDE or not letter.isascii():
        return _WIDTH_OF_WIDE
    return _WIDTH_OF_CAPITAL if letter.isupper() else _WIDTH


def _leader(box: TextBox, down: float) -> str:
    """Return the line from a number to its place, with a dot at its end."""
    x, y = box.callout.at
    y += down
    return (
        f"M{COLUMN - 4:.1f} {box.middle:.1f}L{PICTURE + 4:.1f} {box.middle:.1f}L{x:.1f} {y:.1f}"
        f"m-1.2 0a1.2 1.2 0 1 0 2.4 0a1.2 1.2 0 1 0-2.4 0"
    )


def _text(box: TextBox) -> str:
    """Return the element of the lines of a number."""
    spans = []
    for number, words in enumerate(box.lines):
        kind = "value" if number < box.values else "words"
        y = box.top + LINE * number + LETTER
        spans.append(f'<tspan class="{kind}" x="{COLUMN:g}" y="{y:.1f}">{escape(words)}</tspan>')
    return f"<text>{''.join(spans)}</text>"
