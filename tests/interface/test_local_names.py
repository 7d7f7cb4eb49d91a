"""Variables and fields are nouns of their class."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from source_trees import tree_of

ROOT = Path(__file__).parents[2]
NO_NOUNS = {"apart", "found", "heard", "one", "said", "told"}  # of a class
FIELDS = {"heard"}  # of a sound and of a contender, beside what else is known of them
PACKAGES = ("acoustics", "rolling")


def rooms() -> list[Path]:
    """Return the files and folders at the top of both packages."""
    paths = [path for package in PACKAGES for path in sorted((ROOT / package).iterdir())]
    return [path for path in paths if path.suffix == ".py" or (path / "__init__.py").is_file()]


def is_kernels(file: Path) -> bool:
    """Tell whether a file is compiled, where `one` is the number: a change compiles all anew."""
    return file.stem.startswith("_") and "rolling.contact.compiling" in file.read_text(
        encoding="utf-8"
    )


def variables_of(tree: ast.AST) -> set[str]:
    """Return the names that code assigns, those of its arguments, and those of fields."""
    names = set()
    fields = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            for line in node.body:
                if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name):
                    fields.add(line.target)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            if not (node in fields and node.id in FIELDS):
                names.add(node.id)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
    return names


@pytest.mark.parametrize("room", rooms(), ids=lambda path: str(path.relative_to(ROOT)))
def test_variables_are_nouns(room: Path) -> None:
    files = [room] if room.is_file() else sorted(room.rglob("*.py"))
    for file in files:
        if is_kernels(file):
            continue
        wrong = NO_NOUNS & variables_of(tree_of(file))
        assert not wrong, f"{file.relative_to(ROOT)}: {sorted(wrong)}"


@pytest.mark.parametrize(
    "code",
    [
        "one = 1",
        "[one for one in runs]",
        "def compare(apart): ...",
        "def f():\n    heard = 1",
        "class Cell:\n    said: str",
    ],
)
def test_a_variable_that_is_no_noun_is_seen(code: str) -> None:
    assert NO_NOUNS & variables_of(ast.parse(code))
