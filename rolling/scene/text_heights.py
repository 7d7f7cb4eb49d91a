"""Heights in a text: what its table is, in which units, and a sentence that says so.

A table is a matrix of heights, with or without the places of its lines; a list of points x, y, z
on a regular grid, in any order; or a profile, with or without its places. Headings and lines of
metadata decide, and where there are none the numbers do. Where two readings are possible, a doubt
says so and names what decides.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.contact.kept import Kept
from rolling.scene import text_words
from rolling.scene.height_format import UNITS, HeightFormatError
from rolling.scene.text_look import Look, cells_of
from rolling.scene.text_table import TextTable, read_table
from rolling.scene.text_words import Heading, Metadata, Unit

TRIPLES = ".xyz"
MAX_KEPT = 64_000_000  # bytes of the numbers of text files that a process keeps
_EQUAL = 0.02  # of a step, by which places that are rounded may differ from equal steps
_MIN_POINTS = 16  # of triples; the grid of fewer may be chance
_MIN_LINES = 8  # of a matrix of heights or of a profile, in which a line may be places
_SPARSE = 2  # nodes of a grid for each triple, at most, where nothing says that they are points
_SPARSE_POINTS = 4  # the same where the file says so
_OFF_GRID = 0.05  # of a spacing that a point of a regular grid may lie off its node
_MOST_OFF = 0.45  # the same for places with few digits
_FARTHEST = 1e15  # of a place in any unit
_MOST_NODES = 10**9  # along an axis, above all limits
_MOST_DIGITS = 9  # behind the point of a place


@dataclass(frozen=True, eq=False)
class TextHeights:
    """Heights of a text file.

    Attributes
    ----------
    numbers : (rows, columns) array
        Heights in their unit; rows follow y, and a profile is one column. Read-only.
    unit : str or None
        Unit of UNITS that the file names.
    steps : tuple of float, or None
        Spacing along y and x, in their unit; None where the file holds none.
    steps_unit : str or None
        Unit of UNITS of the spacing that the file names.
    taken : str
        What was taken for what, in one line.
    doubts : tuple of str
        A sentence for each other reading that is possible.
    """

    numbers: Array
    unit: str | None
    steps: tuple[float, float] | None
    steps_unit: str | None
    taken: str
    doubts: tuple[str, ...]


@dataclass
class _Work:
    """Heights on their way out of a table, and the words on what was taken for what."""

    heights: Array
    unit: Unit | None = None
    steps: tuple[float, float] | None = None
    steps_unit: Unit | None = None
    words: list[str] = field(default_factory=list)
    doubts: list[str] = field(default_factory=list)


def text_heights(path: Path) -> TextHeights:
    """Read the heights of a text file; the last files are kept.

    Raises
    ------
    HeightFormatError
        The file is missing, too large, no text, or its table holds no heights.
    """
    status = path.stat()
    stamp = status.st_mtime_ns, status.st_size, status.st_ino
    return _kept.value((path, stamp), lambda: _text_heights(path))


_kept: Kept[TextHeights] = Kept(MAX_KEPT, lambda heights: heights.numbers.nbytes)


def _text_heights(path: Path) -> TextHeights:
    """Read the heights of a text file."""
    table = read_table(path)
    if table.commas.is_refused:
        raise HeightFormatError(table.commas.words)
    known = text_words.metadata(table.look.header, table.look.signs.separator)
    work = _laid_out(table, known, path.suffix.lower() == TRIPLES)
    marked = _without_named_marks(work, known)
    if table.commas.is_possible and not _is_flat(work.heights):
        work.doubts.insert(0, table.commas.words)
    unit = work.unit or known.height_unit
    if known.scale is not None:
        unit = _scaled(work, known)
    if unit is not None and unit.factor != 1:
        work.heights *= unit.factor
    steps_unit = work.steps_unit
    steps = work.steps
    if steps is not None and steps_unit is not None and steps_unit.factor != 1:
        steps = (steps[0] * steps_unit.factor, steps[1] * steps_unit.factor)
    work.heights.flags.writeable = False
    return TextHeights(
        numbers=work.heights,
        unit=None if unit is None else unit.name,
        steps=steps,
        steps_unit=None if steps_unit is None else steps_unit.name,
        taken=_sentence(table, work, unit, steps, marked),
        doubts=tuple(work.doubts),
    )


def _is_flat(heights: Array) -> bool:
    """Tell whether all heights are equal."""
    return bool(np.all(heights == heights[0, 0]))


def _without_named_marks(work: _Work, known: Metadata) -> int:
    """Make heights that the file names as marks of missing points NaN; return their count."""
    count = 0
    for mark in known.missing:
        nodes = np.isclose(work.heights, mark, rtol=1e-6, atol=0)
        count += int(np.count_nonzero(nodes))
        work.heights[nodes] = np.nan
    return count


def _scaled(work: _Work, known: Metadata) -> Unit | None:
    """Multiply heights by the scale that the file states with a unit; doubt one without."""
    scale = known.scale
    assert scale is not None
    if scale.unit is None:
        if scale.value != 1:
            work.doubts.append(
                f"line {scale.line} states a scale of {scale.value:g} for heights, which is not"
                " applied, as it has no unit"
            )
        return work.unit or known.height_unit
    if scale.value != 1:
        work.heights *= scale.value
        work.words.append(
            f"heights are multiples of {scale.value:g} {scale.unit.name} (line {scale.line})"
        )
    return scale.unit


def _sentence(
    table: TextTable,
    work: _Work,
    unit: Unit | None,
    steps: tuple[float, float] | None,
    marked: int,
) -> str:
    """Write what was taken for what."""
    rows, columns = work.heights.shape
    look = table.look
    kind = "a profile of" if columns == 1 else "a matrix of"
    size = f"{rows} heights" if columns == 1 else f"{rows} rows (y) x {columns} columns (x)"
    parts = [f"{kind} {size}, {look.signs.words} from line {look.first} on", *work.words]
    if steps is not None:
        name = "" if work.steps_unit is None else f" {work.steps_unit.name}"
        along, across = (f"{rounded(step, 6)}{name}" for step in steps)
        text = f"spacing {across}" if along == across else f"spacing {across} in x, {along} in y"
        parts.append(text)
    parts.append("heights in no named unit" if unit is None else f"heights in {unit.name}")
    missing = int(np.count_nonzero(np.isnan(work.heights)))
    if missing:
        text = f"{missing} unmeasured"
        if marked:
            text += f", {marked} of them by the mark that the file names"
        parts.append(text)
    if table.footer is not None:
        parts.append(f"the text from line {table.footer} on left out")
    return ", ".join(parts)


# ---- layouts


def _laid_out(table: TextTable, known: Metadata, is_points: bool) -> _Work:
    """Find out what the columns of a table are, and return its heights."""
    numbers = table.numbers
    headings = _headings(table)
    axes = [heading.axis for heading in headings]
    if "z" in axes and axes.count("z") == 1:
        z = axes.index("z")
        if "x" in axes and "y" in axes:
            columns = (axes.index("x"), axes.index("y"), z)
            return _points(numbers, columns, headings, known, "by the heading")
        if "x" in axes:
            return _profile(numbers, (axes.index("x"), z), headings, known)
        if len(axes) == 1 or (len(axes) == 2 and _equal_step(numbers[:, 1 - z])):
            return _Work(
                heights=numbers[:, [z]],
                unit=headings[z].unit,
                steps=_step_of_profile(known, len(numbers)),
                steps_unit=_unit_of_steps(known),
            )
    if is_points or table.numbers.shape[1] <= 4 or table.numbers.shape[0] <= 3:
        work = _points_by_numbers(numbers, known, is_points)
        if work is not None:
            return work
    for lines in (numbers, numbers.T):
        if lines.shape[1] == 2 and len(lines) >= _MIN_LINES and _is_place(lines[:, 0], lines[:, 1]):
            return _profile(lines, (0, 1), [Heading("x"), Heading("z")], known)
    return _matrix(table, known)


def _is_place(line: Array, beside: Array) -> bool:
    """Tell whether numbers change in equal steps, unlike those beside them."""
    return bool(_equal_step(line)) and not _equal_step(beside)


def _headings(table: TextTable) -> list[Heading]:
    """Return the headings of the columns; empty where there are none.

    A line of units may stand below that of the names.
    """
    look = table.look
    above = [text for number, text in look.header if number < look.first][-2:]
    for k in (-1, -2):
        if len(above) < -k:
            break
        cells = _heading_cells(above[k], look)
        if cells is None:
            continue
        headings = [text_words.heading_of(cell) for cell in cells]
        if not any(heading.axis for heading in headings):
            continue
        if k == -2:
            units = _heading_cells(above[-1], look) or []
            below = [text_words.unit_of(cell) for cell in units]
            if None in below or not below:
                continue
            pairs = zip(headings, below, strict=True)
            return [Heading(heading.axis, heading.unit or unit) for heading, unit in pairs]
        return headings
    return []


def _heading_cells(line: str, look: Look) -> list[str] | None:
    """Split a heading into as many cells as the table has columns; None where it has others."""
    text = line.lstrip("#%/; ").strip().replace('"', "")
    separators: list[str | None] = [look.signs.separator, "\t", ";", ","]
    for separator in separators:
        if separator is None:
            continue
        cells = [cell.strip() for cell in text.split(separator)]
        if cells and not cells[-1]:
            cells.pop()
        if look.signs.has_labels and len(cells) == look.width + 1:
            cells = cells[1:]
        if len(cells) == look.width:
            return cells
    cells = text_words.words_with_units(text)
    return cells if len(cells) == look.width else None


def _unit_of_steps(known: Metadata) -> Unit | None:
    """Return the unit of the spacing that lines of metadata name."""
    for named in (*known.steps.values(), *known.sizes.values()):
        if named.unit is not None:
            return named.unit
    return known.xy_unit


def _step_of_profile(known: Metadata, count: int) -> tuple[float, float] | None:
    """Return the spacing of a profile without places, by its lines of metadata."""
    steps = _steps(known, (count, count))
    return None if steps is None else (steps[1], steps[1])


def _steps(known: Metadata, shape: tuple[int, int]) -> tuple[float, float] | None:
    """Return the spacings along y and x in the unit of the first one, by lines of metadata."""
    unit = _unit_of_steps(known)
    steps = {}
    for axis, count in zip("yx", shape, strict=True):
        named = known.steps.get(axis) or known.steps.get("both")
        share = 1.0
        if named is None:
            named = known.sizes.get(axis) or known.sizes.get("both")
            share = 1.0 / count
        if named is not None:
            steps[axis] = share * named.value * _ratio(named.unit, unit)
    if not steps:
        return None
    x = steps.get("x", steps.get("y", 0.0))
    return steps.get("y", x), x


def _ratio(unit: Unit | None, other: Unit | None) -> float:
    """Return the size of a unit in another one, 1 where one of them is not known."""
    if unit is None or other is None:
        return 1.0
    return UNITS[unit.name] * unit.factor / (UNITS[other.name] * other.factor)


# ---- matrix


def _matrix(table: TextTable, known: Metadata) -> _Work:
    """Return the heights of a matrix, less the places of its lines."""
    work = _Work(heights=table.numbers)
    look = table.look
    places = _numbers_of_heading(look)
    if places is not None:
        known.xy_unit = known.xy_unit or text_words.unit_in(look.heading)
    own = table.numbers
    has_corner = places is not None and len(places) == look.width - 1
    if places is not None and has_corner and len(own) >= 2 and _equal_step(own[:, 0]):
        own = own[:, 1:]
        _take_places(work, known, y=table.numbers[:, 0], x=places)
        work.words.append("its heading and its first column taken for places")
    elif places is not None and len(places) == look.width and _equal_step(places):
        _take_places(work, known, y=None, x=places)
        work.words.append("its heading taken for places")
    elif _has_places(own):
        _take_places(work, known, y=own[1:, 0], x=own[0, 1:])
        own = own[1:, 1:]
        work.words.append("its first row and column taken for places")
    elif _counts_rows(own):
        own = own[:, 1:]
        work.words.append("its first column taken for the numbers of the rows")
    work.heights = np.ascontiguousarray(own)
    _drop_empty_edges(work)
    _turn(work, known)
    if work.heights.shape[0] == 1:
        work.heights = np.ascontiguousarray(work.heights.T)
    if work.steps is None:
        work.steps = _steps(known, work.heights.shape)
        work.steps_unit = _unit_of_steps(known)
        if work.steps is not None and 1 in work.heights.shape:
            work.steps = (work.steps[1], work.steps[1])
    _doubt_places(work)
    return work


def _numbers_of_heading(look: Look) -> Array | None:
    """Return the numbers of the heading, without a word in its corner; None if it holds others."""
    if not look.heading:
        return None
    text = look.heading.lstrip("#").strip().replace('"', "")
    cells = [cell.strip() for cell in cells_of(text, look.signs.separator)]
    if cells and not cells[-1]:
        cells.pop()
    if len(cells) == look.width:
        cells = cells[1:] if not _as_numbers(cells[:1]) else cells
    elif look.signs.has_labels and len(cells) == look.width + 1:
        cells = cells[1:]
    numbers = _as_numbers(cells)
    if numbers is None or len(numbers) < 2:
        return None
    return np.array(numbers)


def _as_numbers(cells: list[str]) -> list[float] | None:
    """Return the numbers in cells, which may have a letter before them, as in X1; else None."""
    values = []
    for cell in cells:
        text = cell.replace(",", ".").lstrip("XxYyCcRr").strip()
        try:
            values.append(float(text))
        except ValueError:
            return None
    return values or None


def _has_places(numbers: Array) -> bool:
    """Tell whether the first row and the first column are both places, and the others are not."""
    if min(numbers.shape) < _MIN_LINES:
        return False
    rows = _equal_step(numbers[1:, 0])
    columns = _equal_step(numbers[0, 1:])
    if not rows or not columns:
        return False
    inner = numbers[1:, 1:]
    is_beside = not _equal_step(inner[:, 0]) and not _equal_step(inner[0])
    corner = numbers[0, 0]
    is_corner = np.isnan(corner) or corner == 0
    return bool(is_beside and is_corner)


def _counts_rows(numbers: Array) -> bool:
    """Tell whether the first column counts the rows, far beyond all heights beside it."""
    if min(numbers.shape) < _MIN_LINES or _equal_step(numbers[:, 0]) != 1:
        return False
    if numbers[0, 0] not in (0, 1):
        return False
    beside = numbers[:, 1:]
    if np.isnan(beside).all():
        return False
    return bool(np.nanmax(np.abs(beside)) < 0.1 * len(numbers) and not _equal_step(beside[:, 0]))


def _take_places(work: _Work, known: Metadata, y: Array | None, x: Array) -> None:
    """Take the spacings from the places of rows and columns, if their unit is known.

    Otherwise they may be the numbers of the rows and columns as well.
    """
    step_x = abs(_equal_step(x))
    step_y = step_x if y is None else abs(_equal_step(y))
    if not step_x or not step_y or known.xy_unit is None:
        return
    work.steps = (step_y, step_x)
    work.steps_unit = known.xy_unit


def _drop_empty_edges(work: _Work) -> None:
    """Drop rows and columns at the end that are wholly empty, as a table of a spreadsheet has."""
    heights = work.heights
    before = heights.shape
    while len(heights) > 1 and np.isnan(heights[-1]).all():
        heights = heights[:-1]
    while heights.shape[1] > 1 and np.isnan(heights[:, -1]).all():
        heights = heights[:, :-1]
    if heights.shape != before:
        work.heights = np.ascontiguousarray(heights)
        rows = before[0] - heights.shape[0]
        columns = before[1] - heights.shape[1]
        work.words.append(f"{rows} rows and {columns} columns at its end are empty and dropped")


def _turn(work: _Work, known: Metadata) -> None:
    """Turn a matrix whose lines are the columns that the file names; refuse other numbers."""
    x = known.counts.get("x")
    y = known.counts.get("y")
    if x is None or y is None:
        return
    named = int(y.value), int(x.value)
    shape = work.heights.shape
    if shape == named or 1 in shape:
        return
    if shape == named[::-1]:
        work.heights = np.ascontiguousarray(work.heights.T)
        if work.steps is not None:
            work.steps = work.steps[::-1]
        work.words.append("a line of the file is a column, as the numbers of points say")
        return
    raise HeightFormatError(
        f"got {shape[0]} rows of {shape[1]} numbers, but the file names {named[1]} points in x and"
        f" {named[0]} in y: it is not whole, or holds other columns; export it again, or correct"
        f" lines {x.line} and {y.line}"
    )


def _doubt_places(work: _Work) -> None:
    """Doubt a first row or column that changes in equal steps, unlike the one beside it."""
    heights = work.heights
    for lines, name, beside in ((heights, "column", "row"), (heights.T, "row", "column")):
        if len(lines) < _MIN_LINES or lines.shape[1] < _MIN_LINES:
            continue
        # The first number of all stands for nothing where a row and a column are places.
        step = _equal_step(lines[:, 0]) or _equal_step(lines[1:, 0])
        if step and not _equal_step(lines[1:, 1]):
            work.doubts.append(
                f"the first {name} changes in equal steps of {abs(step):.6g}, as numbers or places"
                f" of the {beside}s do: if these are no heights, remove that {name} from the file"
            )


# ---- profiles and points


def _profile(
    numbers: Array, columns: tuple[int, int], headings: list[Heading], known: Metadata
) -> _Work:
    """Return the heights of a profile that stand beside their places."""
    places = numbers[:, columns[0]]
    heights = np.ascontiguousarray(numbers[:, [columns[1]]])
    axis = _axis(places, "x")
    if axis.size != len(places):
        raise HeightFormatError(
            f"got {len(places)} heights on {axis.size} places in equal steps, allowed: a height at"
            " each place; resample the profile"
        )
    laid = np.empty_like(heights)
    laid[axis.nodes] = heights
    return _Work(
        heights=laid,
        unit=headings[columns[1]].unit,
        steps=(axis.spacing, axis.spacing),
        steps_unit=headings[columns[0]].unit or known.xy_unit or _unit_of_steps(known),
        words=[f"places in column {columns[0] + 1}, heights in column {columns[1] + 1}"],
    )


def _points_by_numbers(numbers: Array, known: Metadata, is_points: bool) -> _Work | None:
    """Return the heights of points whose columns no heading names; None where they are none."""
    for lines, name in ((numbers, "column"), (numbers.T, "row")):
        count, width = lines.shape
        if name == "row" and (is_points or count < _MIN_LINES):
            continue
        if width < 3 or width > 4 or (not is_points and count < _MIN_POINTS):
            continue
        order = _order(lines[:, :3])
        if order is None and not is_points:
            continue
        columns = order or (0, 1, 2)
        headings = [Heading("")] * width
        names = ", ".join(
            f"{axis} in {name} {k + 1}" for axis, k in zip("xyz", columns, strict=True)
        )
        return _points(lines, columns, headings, known, names)
    if is_points:
        raise HeightFormatError(
            f"got {numbers.shape[1]} numbers on a line, allowed: x, y, z; a matrix of heights has"
            " the ending .csv or .txt"
        )
    return None


def _order(lines: Array) -> tuple[int, int, int] | None:
    """Return which of three columns are x, y and z: two that are places of a grid, and the rest."""
    for x, y, z in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
        if z != 2 and len(lines) < _MIN_POINTS:
            return None
        if _is_grid(lines[:, x], lines[:, y]):
            return x, y, z
    return None


def _points(
    numbers: Array,
    columns: tuple[int, int, int],
    headings: list[Heading],
    known: Metadata,
    words: str,
) -> _Work:
    """Return the heights of points x, y, z on a regular grid."""
    has_no_place = np.isnan(numbers[:, columns[0]]) | np.isnan(numbers[:, columns[1]])
    if has_no_place.any():
        point = has_no_place.argmax() + 1
        raise HeightFormatError(f"the point {point} has no place, only z may be nan")
    x_unit, y_unit, z_unit = (headings[column].unit for column in columns)
    x = _axis(numbers[:, columns[0]], "x")
    y = _axis(numbers[:, columns[1]], "y")
    if y.size * x.size > _SPARSE_POINTS * len(numbers) + _SPARSE_POINTS:
        raise HeightFormatError(
            f"{len(numbers)} points on {y.size} x {x.size} nodes are no regular grid; export a"
            " grid, or interpolate the points onto one"
        )
    places = y.nodes * x.size + x.nodes
    seen = np.zeros(y.size * x.size, dtype=bool)
    seen[places] = True
    if np.count_nonzero(seen) < len(numbers):
        raise HeightFormatError("several points lie on the same node, allowed: a regular grid")
    del seen
    heights = np.full(y.size * x.size, np.nan)
    heights[places] = numbers[:, columns[2]]
    along = y.spacing * _ratio(y_unit, x_unit)
    across = x.spacing
    # A line of points has the spacing of its only axis across as well.
    steps = (along or across, across or along)
    unit = x_unit or known.xy_unit
    pixel = known.steps.get("both")
    if pixel is not None and x_unit is None:  # places are numbers of pixels
        steps = (steps[0] * pixel.value, steps[1] * pixel.value)
        unit = pixel.unit or unit
    return _Work(
        heights=heights.reshape(y.size, x.size),
        unit=z_unit,
        steps=steps,
        steps_unit=unit,
        words=[f"{len(numbers)} points x, y, z, {words}"],
    )


def _is_grid(x: Array, y: Array) -> bool:
    """Tell whether pairs of numbers are the places of a grid, each place once."""
    if np.isnan(x).any() or np.isnan(y).any():
        return False
    x_axis = np.unique(x)
    y_axis = np.unique(y)
    is_full = len(x) <= len(x_axis) * len(y_axis) <= _SPARSE * len(x)
    is_line = min(len(x_axis), len(y_axis)) == 1
    is_diagonal = not is_line and max(len(x_axis), len(y_axis)) == len(x)
    if not is_full or is_diagonal:
        return False
    if not _is_regular(x_axis) or not _is_regular(y_axis):
        return False
    nodes = np.searchsorted(y_axis, y) * len(x_axis) + np.searchsorted(x_axis, x)
    return len(np.unique(nodes)) == len(x)


def _is_regular(axis: Array) -> bool:
    """Tell whether sorted places lie on nodes of equal distances, of which some may be missing."""
    if len(axis) == 1:
        return True
    steps = np.diff(axis) / np.median(np.diff(axis))
    off = np.abs(steps - np.rint(steps))
    most = max(_EQUAL * steps.max(), 2 * _rounding(axis) / np.median(np.diff(axis)))
    return bool(off.max() <= min(most, _MOST_OFF) and steps.sum() <= _SPARSE * len(axis))


def _equal_step(places: Array) -> float:
    """Return the step of numbers that rise or fall in equal steps, else 0.

    Two places have a step. Rounded places may differ from equal steps.
    """
    if len(places) < 2 or np.isnan(places).any():
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # far apart, these are no places
        step = float(places[-1] - places[0]) / (len(places) - 1)
        off = np.abs(places - (places[0] + step * np.arange(len(places))))
    if not np.isfinite(off).all():
        return 0.0
    return step if off.max() <= _EQUAL * abs(step) else 0.0


class _Axis(NamedTuple):
    """Nodes of points along an axis, their number, and their spacing, 0 for a single one."""

    nodes: Array
    size: int
    spacing: float


def _axis(values: Array, name: str) -> _Axis:
    """Return the nodes of places along an axis; refuse places that lie on no regular grid.

    Places may be rounded to few digits, so that their differences are not all equal.
    """
    places = np.unique(values)
    if len(places) == 1:
        return _Axis(np.zeros(len(values), dtype=np.int64), size=1, spacing=0.0)
    if not abs(places[0]) < _FARTHEST > abs(places[-1]):
        raise HeightFormatError(f"got {name} from {places[0]:g} to {places[-1]:g}, no places")
    span = float(places[-1] - places[0])
    counts = [len(places) - 1, min(round(span / float(np.median(np.diff(places)))), _MOST_NODES)]
    rounding = _rounding(places)
    for count in counts:
        step = span / count
        off = np.abs(places - places[0] - np.rint((places - places[0]) / step) * step)
        if off.max() <= max(_OFF_GRID * step, min(rounding, _MOST_OFF * step)):
            nodes = np.rint((values - places[0]) / step).astype(np.int64)
            return _Axis(nodes, size=count + 1, spacing=step)
    place = places[int(off.argmax())]
    point = int(np.argmax(values == place))
    raise HeightFormatError(
        f"the point {point + 1} with {name} = {values[point]:g} lies on no regular grid; export a"
        " grid, or interpolate the points onto one"
    )


def _rounding(places: Array) -> float:
    """Return by how much places may be rounded: half of their last digit, and a bit more."""
    sample = places[:: max(1, len(places) // 1000)]
    for digits in range(_MOST_DIGITS):
        size = 10.0**-digits
        if np.allclose(sample, np.round(sample, digits), rtol=0, atol=1e-6 * size):
            return 0.51 * size
    return 0.0
