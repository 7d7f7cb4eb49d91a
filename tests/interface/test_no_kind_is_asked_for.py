"""No `if` asks for a kind of scene outside the kinds: what differs is asked of the kind itself."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TypeGuard

from source_trees import tree_of

ROLLING = Path(__file__).parents[2] / "rolling"
# Rooms and files that are of one kind, or make its runs and scenes, and may name it.
OF_A_KIND = {
    "bearing": "motion of a ring",
    "ball_kinds": "balls that roll or fall",
    "bearing_kind": "bearings that turn",
    "dynamics": "motion of a ball",
    "in_si": "bodies of a ball on a plate",
    "plain_kind": "the base of further kinds",
    "studies": "studies of balls",
}
# Classes of scenes and runs of one kind.
CLASSES = {"Scene", "BearingScene", "Run", "BearingRun", "PlainRun", "SolvedRun", "SolvedBearing"}
# Files that still ask, and how often. A number may fall, and a file may go; nothing is added. All
# of them ask for a ball that falls: for the words for it, and for its numbers without a scene.
TO_DO = {
    "results/description.py": 2,
    "results/former_numbers.py": 1,
    "results/run_doubts.py": 1,
    "results/run_quantities.py": 1,
}
# Rooms that may ask for a fall: the keys of a scene, and the sound of bodies, which are at some
# height or not.
WITH_FALLS = ("scene/", "sound/")
# A key, and a property, that tell a ball that falls from one that rolls.
OF_A_FALL = ("drop_mm", "falls")


def questions(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the expressions of a file that ask what kind a scene, a run or a kind is."""
    guards = {id(node.value) for node in ast.walk(tree) if _is_guard(node)}
    for node in ast.walk(tree):
        if id(node) in guards:
            continue
        if _is_of_a_class(node) or _compares_a_kind(node) or _asks_for_a_fall(node):
            yield node


def _is_guard(node: ast.AST) -> TypeGuard[ast.Expr]:
    """Tell whether a statement refuses an argument of another type than its annotation says.

    Nothing is decided by it, so it asks for no kind.
    """
    is_call = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    return is_call and ast.unparse(node.value.func) == "instance"


def _asks_for_a_fall(node: ast.AST) -> bool:
    """Tell whether an expression compares the height of a fall with None, or asks for a fall."""
    if isinstance(node, ast.Attribute):
        return ast.unparse(node).endswith(("rolling.falls", "bodies.falls"))
    if not isinstance(node, ast.Compare):
        return False
    sides = [node.left, *node.comparators]
    with_none = any(isinstance(side, ast.Constant) and side.value is None for side in sides)
    return with_none and any(ast.unparse(side).endswith(OF_A_FALL) for side in sides)


def _is_of_a_class(node: ast.AST) -> bool:
    """Tell whether an expression asks for the class of a scene or run of one kind."""
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name):
        return False
    if node.func.id not in ("isinstance", "issubclass", "instance"):
        return False
    named = {one.id for argument in node.args for one in ast.walk(argument) if _is_name(one)}
    return bool(named & CLASSES)


def _is_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Name)


def _compares_a_kind(node: ast.AST) -> bool:
    """Tell whether an expression compares the name of a kind, or a type, with another one."""
    if not isinstance(node, ast.Compare):
        return False
    sides = [node.left, *node.comparators]
    texts = {side.value for side in sides if isinstance(side, ast.Constant)}
    named = {one.id for side in sides for one in ast.walk(side) if isinstance(one, ast.Name)}
    of_a_name = any(ast.unparse(side).endswith(("kind", "name")) for side in sides)
    return (of_a_name and bool(texts & {"ball", "bearing"})) or bool(named & CLASSES)


def test_the_questions_are_found() -> None:
    text = """
if isinstance(scene, Scene): pass
if kind.name == "bearing": pass
if type(run) is BearingRun: pass
scene = instance("scene", scene, str, Scene)
if isinstance(scene, SweptScene) or scene.name == "ball-on-plate": pass
if channel.of == "ball": pass
if scene.rolling.drop_mm is not None or drop_mm is None: pass
if scene.rolling.falls: pass
if scene.rolling.drop_mm > 2: pass
instance("run", run, Run)
"""
    assert sorted(node.lineno for node in questions(ast.parse(text))) == [2, 3, 4, 5, 8, 8, 9]


def test_rooms_of_kinds_are_there() -> None:
    assert all((ROLLING / name).is_dir() for name in OF_A_KIND)


def test_no_file_asks_for_a_kind_but_those_that_are_listed() -> None:
    found: Counter[str] = Counter()
    places = []
    for path in sorted(ROLLING.rglob("*.py")):
        name = path.relative_to(ROLLING).as_posix()
        if name.split("/")[0] in OF_A_KIND:
            continue
        for node in questions(tree_of(path)):
            if name.startswith(WITH_FALLS) and _asks_for_a_fall(node):
                continue
            found[name] += 1
            places.append(f"{name}:{node.lineno}: {ast.unparse(node)}")
    more = {name: count for name, count in found.items() if count > TO_DO.get(name, 0)}
    assert not more, "ask the kind instead:\n" + "\n".join(places)
    fewer = {name: count for name, count in TO_DO.items() if found[name] < count}
    assert not fewer, f"fewer are left, so lower their numbers in TO_DO: {fewer}"
