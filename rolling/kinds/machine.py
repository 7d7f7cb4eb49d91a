"""The machine of a scene as plain shapes and numbers, which the page draws without knowing it.

Places are in units of the picture, with y downwards. A picture is `PICTURE` units wide.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

PICTURE = 200.0  # width of the picture, beside which the numbers stand
Place = tuple[float, float]
Role = Literal["body", "ground", "edge", "thin", "path", "arrow", "dot", "fault", "sensor", "load"]
_HEAD = 7.0  # length of the head of an arrow
_HEAD_SPREAD = 0.45  # rad, from the line of an arrow to the sides of its head


@dataclass(frozen=True)
class Shape:
    """A shape of a drawing.

    Parameters
    ----------
    role : str
        What it shows, on which its colours depend: a `body` that moves, the `ground` below it, an
        `edge` or a `thin` line, a dashed `path`, an `arrow`, a `dot`, a `fault`, a `sensor`, or a
        body that bears a `load`.
    path : str
        Path of SVG.
    share : float
        Share of the largest load, 0 to 1, that a body of the role `load` bears.
    """

    role: Role
    path: str
    share: float = 0.0


@dataclass(frozen=True)
class Callout:
    """A number of a drawing, to which a line leads from its place.

    Parameters
    ----------
    at : pair of float. Place in the picture to which it belongs.
    value : str. The number with its unit.
    words : str. What it is.
    """

    at: Place
    value: str
    words: str


@dataclass
class Machine:
    """The drawing of a machine: shapes, and the numbers that stand beside them.

    Parameters
    ----------
    title : str. What is drawn, such as `Ball on a plate`.
    height : float. Height of the picture.
    shapes : list of Shape, in the order of drawing.
    callouts : list of Callout.
    """

    title: str
    height: float = 0.0
    shapes: list[Shape] = field(default_factory=list)
    callouts: list[Callout] = field(default_factory=list)

    def draw(self, role: Role, *paths: str, share: float = 0.0) -> None:
        """Add a shape of one path or several."""
        self.shapes.append(Shape(role, "".join(paths), share))

    def say(self, at: Place, value: str, words: str) -> None:
        """Add a number, unless it is empty."""
        if value:
            self.callouts.append(Callout(at, value, words))


# ---- paths


def line(*places: Place) -> str:
    """Return the path of lines from place to place."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)


def outline(*places: Place) -> str:
    """Return the path of a closed outline."""
    return f"{line(*places)}Z"


def box(left: float, top: float, right: float, bottom: float) -> str:
    """Return the path of a rectangle."""
    return outline((left, top), (right, top), (right, bottom), (left, bottom))


def square(centre: Place, half: float) -> str:
    """Return the path of a square about a place."""
    x, y = centre
    return box(x - half, y - half, x + half, y + half)


def circle(centre: Place, radius: float) -> str:
    """Return the path of a circle."""
    x, y = centre
    half = f"a{radius:.1f} {radius:.1f} 0 1 0"
    return f"M{x - radius:.1f} {y:.1f}{half} {2 * radius:.1f} 0{half} {-2 * radius:.1f} 0Z"


def arc(centre: Place, radius: float, first: float, last: float) -> str:
    """Return the path of an arc from one angle to another [rad], 0 to the right, clockwise."""
    steps = max(2, math.ceil(abs(last - first) / 0.15))
    return line(
        *(around(centre, radius, first + (last - first) * k / steps) for k in range(steps + 1))
    )


def around(centre: Place, radius: float, angle: float) -> Place:
    """Return the place at an angle [rad] around a centre, 0 to the right, clockwise."""
    return centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)


def arrow(start: Place, end: Place) -> str:
    """Return the path of an arrow."""
    direction = math.atan2(end[1] - start[1], end[0] - start[0])
    return line(start, end) + head(end, direction)


def head(tip: Place, direction: float) -> str:
    """Return the path of the head of an arrow that points in a direction [rad]."""
    backwards = direction + math.pi
    sides = [around(tip, _HEAD, backwards + turn) for turn in (-_HEAD_SPREAD, _HEAD_SPREAD)]
    return line(sides[0], tip, sides[1])


def listener(centre: Place) -> Sequence[str]:
    """Return the paths of an ear, which stands for who listens."""
    x, y = centre
    shell = f"M{x - 5:.1f} {y - 3:.1f}a6 6.5 0 1 1 9 6c-2 1.5-2 3-2.6 5a3 3 0 0 1-5.6 0"
    fold = f"M{x - 1.6:.1f} {y - 2.5:.1f}a2.8 3.2 0 1 1 4 3.2c-1.2 .8-1.6 1.4-1.6 2.6"
    return [shell, fold]
