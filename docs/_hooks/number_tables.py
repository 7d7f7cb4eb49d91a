"""Tables of all numbers of a run by subject, made from the fields of their data classes."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rolling.numbers import views
from rolling.numbers.ball_numbers import DB_A, RunNumbers
from rolling.numbers.bearing_numbers import UM_PER_S, BandVelocities, BearingNumbers
from rolling.numbers.fields import NumberField, number_field_of
from rolling.numbers.quantity import BandQuantity, Quantity
from rolling.numbers.run_file import StoredBearing, StoredNumbers
from rolling.numbers.summary_schema import hints_of, options_of


class Kind(NamedTuple):
    """Numbers of a kind of scene, and where the docs show them.

    stored : type. What a run folder holds of them.
    root : type. Data class of the numbers.
    page : str. Page of their tables.
    schema : str. File of the JSON Schema of their summary.json.
    """

    stored: type
    root: type
    page: str
    schema: str


KINDS = (
    Kind(StoredNumbers, RunNumbers, "numbers.md", "summary.schema.json"),
    Kind(StoredBearing, BearingNumbers, "bearing-numbers.md", "bearing-summary.schema.json"),
)
UNITS = {BandVelocities: UM_PER_S}  # of the quantities of a data class, if they are no levels

ROOT = "run.numbers"  # of a run in Python
BANDS = ("bands",)  # place of the third octaves that bands.csv has
HEAD = ("name", "unit", "meaning", "column")
_NO_UNITS = {str: "text", bool: "yes or no", int: "count"}  # of a field without a unit


class Group(NamedTuple):
    """A data class of numbers with all places that have it, and what it means there."""

    kind: type
    meanings: dict[tuple[str, ...], str]

    @property
    def paths(self) -> list[tuple[str, ...]]:
        """The places."""
        return [*self.meanings]


def reference(kind: Kind) -> str:
    """Return headings and tables of all numbers of a kind of run."""
    columns = columns_of(kind.root)
    parts = []
    for group in _groups(kind.root):
        parts += [_heading(group), "", *_introduction(group), ""]
        if rows := [*_rows(group, columns)]:
            parts += [table(HEAD, rows), ""]
    return "\n".join(parts).rstrip()


def columns_of(kind: type) -> dict[str, views.Cell]:
    """Return all columns that a data class of numbers may have, by their names."""
    return views.columns(_specimen(kind))


def paths_of(kind: type) -> set[str]:
    """Return the paths of all fields of a data class of numbers, such as `surface.ra_m`."""
    return {
        ".".join((*path, data_field.name))
        for group in _groups(kind)
        for path in group.paths
        for data_field in dataclasses.fields(group.kind)
    }


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(
        "|" + "|".join(cell.replace("|", "\\|") for cell in line) + "|" for line in lines
    )


# ---- groups


def _groups(root: type) -> Sequence[Group]:
    """List the data class of numbers and all in it, each once, in the order of their fields."""
    groups: dict[type, Group] = {root: Group(root, {(): ""})}
    _add_groups(root, (), groups)
    return [*groups.values()]


def _add_groups(kind: type, path: tuple[str, ...], groups: dict[type, Group]) -> None:
    """Add the data classes of numbers in a data class."""
    for data_field in dataclasses.fields(kind):
        number_field = number_field_of(data_field)
        inner, is_list = _inner(hints_of(kind)[data_field.name])
        if number_field is None or inner is None:
            continue
        place = (*path, f"{data_field.name}[i]" if is_list else data_field.name)
        groups.setdefault(inner, Group(inner, {})).meanings[place] = number_field.meaning
        _add_groups(inner, place, groups)


def _inner(hint: Any) -> tuple[type | None, bool]:
    """Return the data class of numbers that a field has, or a list of; None for another field."""
    for option in options_of(hint):
        is_list = typing.get_origin(option) is tuple
        kind = typing.get_args(option)[0] if is_list else option
        if dataclasses.is_dataclass(kind) and any(map(number_field_of, dataclasses.fields(kind))):
            return typing.cast(type, kind), is_list
    return None, False


def _heading(group: Group) -> str:
    """Return the heading of a group: its place, or its places."""
    depth = "###" if len(group.paths[0]) > 1 else "##"
    names = [".".join(path).replace("[i]", "") or "The run as a whole" for path in group.paths]
    return f"{depth} {', '.join(names)}"


def _introduction(group: Group) -> Iterator[str]:
    """Yield the lines that say what a group is, and where it stands in Python."""
    places = {".".join((ROOT, *path)): meaning for path, meaning in group.meanings.items()}
    if group.paths == [()]:
        yield f"In Python these are fields of `{ROOT}`."
        return
    first = (group.kind.__doc__ or "").partition("\n")[0].rstrip(".")
    if len(places) == 1:
        yield f"{first}. In Python: `{next(iter(places))}`."
        return
    yield f"{first}. In Python:"
    yield ""
    for place, meaning in places.items():
        yield f"- `{place}`: {meaning}"


# ---- rows


def _rows(group: Group, columns: Mapping[str, views.Cell]) -> Iterator[list[str]]:
    """Yield the row of each field of a group that is no group with a table of its own."""
    for data_field in dataclasses.fields(group.kind):
        number_field = number_field_of(data_field)
        hint = hints_of(group.kind)[data_field.name]
        inner, _ = _inner(hint)
        if number_field is None or inner is not None:
            continue
        places = [(*path, data_field.name) for path in group.paths]
        cells = [
            cell
            for place in places
            for cell in _columns(place, number_field, hint, group.kind, columns)
        ]
        yield [
            f"`{data_field.name}`",
            _unit(number_field, hint),
            number_field.meaning,
            "<br>".join(cells) or "-",
        ]


def _unit(number_field: NumberField, hint: Any) -> str:
    """Return the unit of a field, or what it is instead of a number."""
    options = options_of(hint)
    if Quantity in options:
        return "quantity"
    if BandQuantity in options:
        return "bands"
    if number_field.is_group:
        is_mapping = any(typing.get_origin(option) is dict for option in options)
        return "by name" if is_mapping else "list"
    if number_field.unit not in ("", "1"):
        return number_field.unit
    known = [_NO_UNITS[option] for option in options if option in _NO_UNITS]
    if known and float not in options:
        return known[0]
    return number_field.unit or "text"


def _columns(
    place: tuple[str, ...],
    number_field: NumberField,
    hint: Any,
    kind: type,
    columns: Mapping[str, views.Cell],
) -> Iterator[str]:
    """Yield the column of a field; one that runs.csv has is bold.

    Of a quantity it is that of the value. The names of its other columns begin as this one does.
    """
    column = "_".join(place)
    options = options_of(hint)
    if BandQuantity in options:
        if place[:-1] == BANDS:
            yield f"**bands.csv**: `{place[-1]}`"
        return
    if Quantity in options:
        column = next(iter(views.quantity_cells(column, number_field, _quantity(kind))))
    if column in columns:
        yield f"**`{column}`**" if columns[column].number_field.in_table else f"`{column}`"


# ---- a run that has all numbers


def _specimen(kind: type) -> Any:
    """Return numbers of a run that has every group, so that all columns are there."""
    hints = hints_of(kind)
    return kind(
        **{
            data_field.name: _value(hints[data_field.name], kind)
            for data_field in dataclasses.fields(kind)
        }
    )


def _value(hint: Any, kind: type) -> Any:
    """Return a value of a type for a field of a data class."""
    inner, is_list = _inner(hint)
    if inner is not None:
        return (_specimen(inner),) if is_list else _specimen(inner)
    option = options_of(hint)[0]
    if option is Quantity:
        return _quantity(kind)
    if option is BandQuantity:
        return BandQuantity(unit="dB", frequency_hz=(), value=())
    origin = typing.get_origin(option)
    if origin in (dict, tuple):
        return origin()
    return option() if isinstance(option, type) else ""


def _quantity(kind: type) -> Quantity:
    """Return a quantity of a data class."""
    return Quantity("level", 0.0, unit=UNITS.get(kind, DB_A))
