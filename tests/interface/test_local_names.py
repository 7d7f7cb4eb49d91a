"""Local variables are nouns of their class."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NO_NOUNS = {"apart", "found", "heard", "one", "told"}  # of a class
ROOMS = (
    "acoustics",
    "rolling/check",
    "rolling/figures",
    "rolling/report",
    "rolling/scene",
    "rolling/studies",
)


def locals_of(tree: ast.AST) -> set[str]:
    """Return the names that code assigns, and those of its arguments."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
    return names


@pytest.mark.parametrize("room", ROOMS)
def test_local_names_are_nouns(room: str) -> None:
    files = sorted((ROOT / room).rglob("*.py"))
    assert files
    for file in files:
        wrong = NO_NOUNS & locals_of(ast.parse(file.read_text(encoding="utf-8")))
        assert not wrong, f"{file.relative_to(ROOT)}: {sorted(wrong)}"
