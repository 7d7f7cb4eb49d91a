"""Rooms of physics take data classes and arrays: they know no scene, no file, no terminal."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from source_trees import tree_of

ROOT = Path(__file__).parents[2] / "rolling"
PHYSICS = ("bearing", "contact", "dynamics", "sound", "surface")
SCENES = {"Scene", "SceneQuantities", "BearingScene", "BearingQuantities", "AnyScene", "SweptScene"}
STRANGERS = ("pydantic", "rolling.scene", "rolling.terminal", "ruamel")
NAMES = ("scene", "bearing_scene")  # of parameters and attributes that hold a scene
SECTIONS = ("rolling", "numerics", "recovery")  # of a scene, and of nothing else


def modules(room: str) -> list[Path]:
    """Return the files of a room, which has to exist."""
    files = sorted((ROOT / room).rglob("*.py"))
    assert files, f"no room of this name: {room}"
    return files


def imported(tree: ast.Module) -> Iterator[str]:
    """Yield the dotted names that a module imports, anywhere in it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def named(annotation: ast.expr | None) -> Iterator[str]:
    """Yield the names within an annotation: in unions, in containers, and in strings."""
    if annotation is None:
        return
    for node in ast.walk(annotation):
        if isinstance(node, ast.Name):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            try:
                text = ast.parse(node.value, mode="eval").body
            except SyntaxError:  # the text of a literal
                continue
            yield from named(text)


def scenes_taken(tree: ast.AST) -> Iterator[str]:
    """Yield what takes or holds a scene: parameters, fields, and attributes of it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            arguments = node.args
            listed = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
            listed += [x for x in (arguments.vararg, arguments.kwarg) if x is not None]
            for argument in listed:
                if argument.arg in NAMES or SCENES & set(named(argument.annotation)):
                    yield f"line {argument.lineno}: parameter {argument.arg}"
        elif isinstance(node, ast.AnnAssign) and SCENES & set(named(node.annotation)):
            yield f"line {node.lineno}: {ast.unparse(node.target)}"
        elif isinstance(node, ast.Attribute) and node.attr in (*NAMES, *SECTIONS):
            yield f"line {node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize("room", PHYSICS)
def test_a_room_of_physics_imports_neither_scenes_nor_the_terminal(room: str) -> None:
    strangers = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in modules(room)
        for name in imported(tree_of(path))
        if name.startswith(STRANGERS)
    ]
    assert not strangers, "\n".join(strangers)


@pytest.mark.parametrize("room", PHYSICS)
def test_no_function_of_a_room_of_physics_takes_a_scene(room: str) -> None:
    taken = [
        f"{path.relative_to(ROOT)}, {place}"
        for path in modules(room)
        for place in scenes_taken(tree_of(path))
    ]
    assert not taken, "\n".join(taken)


def test_memory_and_disk_are_judged_by_sizes_alone() -> None:
    tree = tree_of(ROOT / "check" / "memory_and_disk.py")
    assert not [*scenes_taken(tree)]
    assert [name for name in imported(tree) if name.startswith("rolling.")] == [
        "rolling.check.run_size.RunSize"
    ]


@pytest.mark.parametrize(
    ("code", "is_taken"),
    [
        ("def load(given: Scene) -> float: ...", True),
        ("def load(given: 'Scene') -> float: ...", True),
        ("def load(given: 'list[Scene]') -> float: ...", True),
        ("def load(given: dict[str, scene.Scene | None]) -> float: ...", True),
        ("def load(*given: Callable[[AnyScene], float]) -> float: ...", True),
        ("class Bodies:\n    given: BearingScene", True),
        ("def load(scene: Any) -> float: ...", True),
        ("loads = map(lambda scene: scene.load, given)", True),
        ("def load(run: Any) -> float:\n    return run.scene.load", True),
        ("def load(given: Any) -> float:\n    return given.rolling.load_n", True),
        ("def load(given: BallOnPlate) -> float: ...", False),
        ("def scenery(kind: Literal['a scene']) -> float: ...", False),
    ],
)
def test_a_scene_is_seen_in_every_form(code: str, is_taken: bool) -> None:
    assert bool([*scenes_taken(ast.parse(code))]) == is_taken
