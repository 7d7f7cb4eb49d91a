"""A number has one home, its field: nothing reads it by a text, and its type is known."""

from __future__ import annotations

import ast
import dataclasses
import typing
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from finished import marched
from scene_text import TINY
from source_trees import tree_of

import rolling
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.bearing_numbers import BearingNumbers
from rolling.numbers.fields import number_field_of
from rolling.numbers.run_file import StoredBearing, StoredNumbers

ROOM = Path(rolling.__file__).parent
# What writes numbers, reads them back, and knows the names of version 0.8.
WRITERS = {
    ROOM / "numbers" / "stored.py",
    ROOM / "numbers" / "summary_schema.py",
    ROOM / "results" / "former_numbers.py",
    ROOM / "bearing_kind" / "former_bearing.py",
}
HOLDERS = {"numbers", "summary", "summaries"}


def trees() -> list[tuple[Path, ast.AST]]:
    """Return the syntax trees of the program."""
    return [(path, tree_of(path)) for path in sorted(ROOM.rglob("*.py"))]


def last_name(node: ast.AST) -> str:
    """Return the last name of an expression, such as `numbers` of `run.numbers`."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def is_text(node: ast.AST) -> bool:
    """Tell whether an expression is a literal text."""
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def reads_by_text(node: ast.AST) -> bool:
    """Tell whether an expression reads a number by a literal text."""
    if isinstance(node, ast.Subscript):
        return last_name(node.value) in HOLDERS and is_text(node.slice)
    if not isinstance(node, ast.Call) or not node.args:
        return False
    if isinstance(node.func, ast.Attribute) and node.func.attr == "get":
        return last_name(node.func.value) in HOLDERS and is_text(node.args[0])
    if isinstance(node.func, ast.Name) and node.func.id == "getattr":
        return last_name(node.args[0]) in HOLDERS and is_text(node.args[1])
    return False


def test_no_number_is_read_by_a_text() -> None:
    found = [
        f"{path.relative_to(ROOM)}:{node.lineno}: {ast.unparse(node)}"
        for path, tree in trees()
        if path not in WRITERS
        for node in ast.walk(tree)
        if reads_by_text(node)
    ]
    assert found == []


def test_the_program_does_not_read_the_former_names() -> None:
    found = [
        f"{path.relative_to(ROOM)}:{node.lineno}"
        for path, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and node.attr == "summary"
        and last_name(node.value) != "given"  # an option of the command line
    ]
    assert found == []


def test_no_doubt_is_made_from_a_mapping() -> None:
    found = [
        f"{path.relative_to(ROOM)}:{node.lineno}"
        for path, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and last_name(node.func) == "Doubt"
        and any(keyword.arg is None for keyword in node.keywords)
    ]
    assert found == []


def test_no_table_names_numbers_beside_their_fields() -> None:
    assert [*ROOM.rglob("levels.toml")] == []


def loose_types(hint: Any, path: str) -> Iterator[str]:
    """Yield the places in a type where a number could be of any kind."""
    if hint in (Any, object, dict, list, tuple):
        yield f"{path}: {hint}"
    for inner in typing.get_args(hint):
        yield from loose_types(inner, path)
    if dataclasses.is_dataclass(hint):
        for name, of_field in typing.get_type_hints(hint).items():
            yield from loose_types(of_field, f"{path}.{name}")


@pytest.mark.parametrize("kind", [RunNumbers, BearingNumbers, StoredNumbers, StoredBearing])
def test_the_type_of_every_number_is_known(kind: type) -> None:
    assert [*loose_types(kind, kind.__name__)] == []


def groups(kind: Any) -> Iterator[Any]:
    """Yield the data classes of numbers in the type of a field, at any depth."""
    for inner in typing.get_args(kind):
        yield from groups(inner)
    if dataclasses.is_dataclass(kind) and any(map(number_field_of, dataclasses.fields(kind))):
        yield kind
        for of_field in typing.get_type_hints(kind).values():
            yield from groups(of_field)


@pytest.mark.parametrize("kind", [RunNumbers, BearingNumbers])
def test_every_field_says_what_it_is(kind: type) -> None:
    silent = [
        f"{group.__name__}.{field.name}"
        for group in dict.fromkeys(groups(kind))
        for field in dataclasses.fields(group)
        if (number_field := number_field_of(field)) is None or not number_field.meaning
    ]
    assert silent in (
        [],
        [f"{kind.__name__}.name"],
        [f"{kind.__name__}.{x}" for x in ("name", "title")],
    )


def test_the_former_names_are_read_with_a_warning() -> None:
    run = marched(TINY)
    with pytest.warns(DeprecationWarning, match=r"numbers\.contact\.max_pressure_pa"):
        former = run.summary
    assert former["max_pressure_pa"] == run.numbers.contact.max_pressure_pa
    assert former["laeq_db"] == run.released_power.value
    with pytest.raises(TypeError):
        former["laeq_db"] = 0.0  # type: ignore[index]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert repr(run) and run._repr_html_() and run.to_xarray() is not None
