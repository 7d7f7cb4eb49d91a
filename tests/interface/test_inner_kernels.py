"""Kernels without a wrapper for Python are called by kernels only: from Python they would crash."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = next(folder for folder in Path(__file__).parents if (folder / "pyproject.toml").exists())
INNER = re.compile(r"@njit\([^)]*inner=True[^)]*\)\ndef (\w+)\(")


def inner_kernels() -> dict[str, set[str]]:
    """Return the names of the inner functions of each module of kernels."""
    sources = {path.stem: path.read_text(encoding="utf-8") for path in ROOT.glob("rolling/*/_*.py")}
    listed = {module: set(INNER.findall(text)) for module, text in sources.items()}
    return {module: names for module, names in listed.items() if names}


def is_compiled(part: ast.stmt) -> bool:
    """Return whether a part of a module is a function that is compiled."""
    decorators = part.decorator_list if isinstance(part, ast.FunctionDef) else []
    return any("njit" in ast.unparse(decorator) for decorator in decorators)


def calls(path: Path, inner: dict[str, set[str]]) -> Iterator[str]:
    """Yield the inner functions that a file names outside of compiled functions."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    tree.body = [part for part in tree.body if not is_compiled(part)]
    modules: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                modules |= {alias.asname or alias.name: alias.name} if alias.name in inner else {}
                if alias.name in inner.get((node.module or "").rpartition(".")[2], ()):
                    yield alias.name
    for node in ast.walk(tree):
        is_attribute = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
        if is_attribute and node.attr in inner.get(modules.get(node.value.id, ""), ()):
            yield node.attr


def test_python_calls_no_inner_kernel() -> None:
    inner = inner_kernels()
    assert sum(map(len, inner.values())) > 50
    kernels = {path for path in ROOT.glob("rolling/*/_*.py") if path.stem in inner}
    uncompiled = ROOT / "tests/physics/test_disturbed_descent.py"
    others = {*ROOT.glob("rolling/**/*.py"), *ROOT.glob("tests/**/*.py")} - kernels - {uncompiled}
    named = {str(path): [*calls(path, inner)] for path in others}
    assert not {path: names for path, names in named.items() if names}


def test_the_check_sees_a_call() -> None:
    inner = {"_model_kernels": {"settle"}}
    path = ROOT / "tests" / "interface" / "test_inner_kernels.py"
    assert not [*calls(path, inner)]
    assert "follow_model" in [
        *calls(ROOT / "rolling/contact/_solver_kernels.py", {"_model_kernels": {"follow_model"}})
    ]
