"""Tables of all numbers of a run by subject, made from the fields of their data classes."""

from __future__ import annotations

import dataclasses
import importlib
import typing
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from rolling.numbers import views
from rolling.numbers.fields import NumberField, said_of
from rolling.numbers.quantity import BandQuantity, Quantity
from rolling.numbers.summary_schema import hints_of, options_of


class Kind(NamedTuple):
    """Numbers of a kind of scene: their data class, where a run has it, and the page of its tables.

    A kind whose module is not there has no tables.
    """

    page: str
    module: str
    name: str

    @property
    def root(self) -> type:
        """The data class."""
        kind: type = getattr(importlib.import_module(self.module), self.name)
        return kind


KINDS = (Kind("numbers.md", "rolling.numbers.ball_numbers", "RunNumbers"),)

ROOT = "run.numbers"  # of a run in Python
BANDS = ("bands",)  # place of the third octaves that bands.csv has
HEAD = ("name", "unit", "meaning", "column")
_NO_UNITS = {str: "text", bool: "yes or no", int: "count"}  # of a field without a unit


class Group(NamedTuple):
    """A data class of numbers with all places that have it."""

    kind: type
    paths: list[tuple[str, ...]]


def reference(kind: Kind) -> str:
    """Return headings and tables of all numbers of a kind of run."""
    columns = columns_of(kind.root)
    parts = []
    for group in _groups(kind.root):
        parts += [_heading(group), "", *_introduction(group), ""]
        parts += [table(HEAD, _rows(group, columns)), ""]
    return "\n".join(parts).rstrip()


def columns_of(kind: type) -> dict[str, views.Cell]:
    """Return all columns that a data class of numbers may have, by their names."""
    return views.columns(_specimen(kind))


def paths_of(kind: type) -> set[str]:
    """Return the paths of all fields of a data class of numbers, such as `surface.ra_m`."""
    return {
        ".".join((*path, one.name))
        for group in _groups(kind)
        for path in group.paths
        for one in dataclasses.fields(group.kind)
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
    groups: dict[type, Group] = {root: Group(root, [()])}
    _add_groups(root, (), groups)
    return [*groups.values()]


def _add_groups(kind: type, path: tuple[str, ...], groups: dict[type, Group]) -> None:
    """Add the data classes of numbers in a data class."""
    for one in dataclasses.fields(kind):
        said = said_of(one)
        inner, is_list = _inner(hints_of(kind)[one.name])
        if said is None or inner is None:
            continue
        place = (*path, f"{one.name}[i]" if is_list else one.name)
        groups.setdefault(inner, Group(inner, [])).paths.append(place)
        _add_groups(inner, place, groups)


def _inner(hint: Any) -> tuple[type | None, bool]:
    """Return the data class of numbers that a field has, or a list of; None for another field."""
    for option in options_of(hint):
        is_list = typing.get_origin(option) is tuple
        kind = typing.get_args(option)[0] if is_list else option
        if dataclasses.is_dataclass(kind) and any(map(said_of, dataclasses.fields(kind))):
            return typing.cast(type, kind), is_list
    return None, False


def _heading(group: Group) -> str:
    """Return the heading of a group: its place, or its places."""
    depth = "###" if len(group.paths[0]) > 1 else "##"
    names = [".".join(path).replace("[i]", "") or "The run as a whole" for path in group.paths]
    return f"{depth} {', '.join(names)}"


def _introduction(group: Group) -> Iterator[str]:
    """Yield the paragraph of a group: what it is, and where it stands in Python."""
    places = " and ".join(f"`{'.'.join((ROOT, *path))}`" for path in group.paths)
    if not group.paths[0]:
        yield f"In Python these are fields of `{ROOT}`."
        return
    first = (group.kind.__doc__ or "").partition("\n")[0].rstrip(".")
    yield f"{first}. In Python: {places}."


# ---- rows


def _rows(group: Group, columns: dict[str, views.Cell]) -> Iterator[list[str]]:
    """Yield the row of each field of a group that is no group with a table of its own."""
    for one in dataclasses.fields(group.kind):
        said = said_of(one)
        hint = hints_of(group.kind)[one.name]
        inner, _ = _inner(hint)
        if said is None or inner is not None:
            continue
        places = [(*path, one.name) for path in group.paths]
        cells = [cell for place in places for cell in _columns(place, said, hint, columns)]
        yield [f"`{one.name}`", _unit(said, hint), said.meaning, "<br>".join(cells) or "-"]


def _unit(said: NumberField, hint: Any) -> str:
    """Return the unit of a field, or what it is instead of a number."""
    options = options_of(hint)
    if Quantity in options:
        return "quantity"
    if BandQuantity in options:
        return "bands"
    if said.is_group:
        is_mapping = any(typing.get_origin(option) is dict for option in options)
        return "by name" if is_mapping else "list"
    if said.unit not in ("", "1"):
        return said.unit
    known = [_NO_UNITS[option] for option in options if option in _NO_UNITS]
    if known and float not in options:
        return known[0]
    return said.unit or "text"


def _columns(
    place: tuple[str, ...], said: NumberField, hint: Any, columns: dict[str, views.Cell]
) -> Iterator[str]:
    """Yield the columns of a field; those that runs.csv has are bold."""
    name = "_".join(place)
    if Quantity in options_of(hint):
        quantity = _value(hint)
        names = [*views.quantity_cells(name, said, quantity)]
    elif BandQuantity in options_of(hint):
        if place[:-1] == BANDS:
            yield f"**bands.csv**: `{place[-1]}`"
        return
    else:
        names = [name]
    for column in names:
        if column in columns:
            in_table = columns[column].said.in_table
            yield f"**`{column}`**" if in_table else f"`{column}`"


# ---- a run that has all numbers


def _specimen(kind: type) -> Any:
    """Return numbers of a run that has every group, so that all columns are there."""
    return kind(**{one.name: _value(hints_of(kind)[one.name]) for one in dataclasses.fields(kind)})


def _value(hint: Any) -> Any:
    """Return a value of a type."""
    inner, is_list = _inner(hint)
    if inner is not None:
        return (_specimen(inner),) if is_list else _specimen(inner)
    option = options_of(hint)[0]
    if option is Quantity:
        return Quantity("level", 0.0, unit="dB(A)")
    if option is BandQuantity:
        return BandQuantity(unit="dB", frequency_hz=(), value=())
    origin = typing.get_origin(option)
    if origin in (dict, tuple):
        return origin()
    return option() if isinstance(option, type) else ""
