"""The laws that tests guard can be listed without running them: literal markers, one sentence each, none of the laws missing."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).parents[1]
LAWS = {
    "A-weighting",
    "Capacity",
    "Dense method",
    "Energy ledger",
    "First yield",
    "Hertz",
    "Left-end rule",
    "Mean rule",
    "Optimality",
    "Parseval",
    "Radiation",
    "Recovery events",
    "Rigid-plastic limit",
    "Rolling back",
    "Scaling",
    "Second lap",
    "Silence",
    "Smooth release",
    "Speed",
    "Tangential force",
    "Third octaves",
    "Translation",
    "Warm equals cold",
    "Window",
}


def markers() -> Iterator[ast.Call | ast.expr]:
    for file in sorted(TESTS.rglob("test_*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and ast.unparse(node) == "pytest.mark.law":
                yield node
            if isinstance(node, ast.FunctionDef):
                yield from (mark for mark in node.decorator_list if ast.unparse(mark).startswith("pytest.mark.law"))


def sentences() -> list[str]:
    calls = [node for node in markers() if isinstance(node, ast.Call)]
    return [ast.literal_eval(call.args[0]) for call in calls]


def test_markers_are_literal_decorators_of_tests() -> None:
    """Each marker is seen twice: as an attribute anywhere and as a decorator with one text."""
    seen = list(markers())
    calls = [node for node in seen if isinstance(node, ast.Call)]
    assert len(seen) == 2 * len(calls)
    assert all(len(call.args) == 1 and not call.keywords for call in calls)
    assert all(isinstance(sentence, str) for sentence in sentences())


def test_sentences_name_their_law_once() -> None:
    found = sentences()
    assert len(set(found)) == len(found)
    assert all(": " in sentence and sentence.endswith(".") for sentence in found)


def test_every_law_has_a_test() -> None:
    assert {sentence.partition(":")[0] for sentence in sentences()} >= LAWS
