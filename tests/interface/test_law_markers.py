"""The laws can be listed without running the tests: each marker has a literal sentence."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

TESTS = Path(__file__).parents[1]
LAWS = {
    "A-weighting",
    "Ball on plate",
    "Bearing",
    "Capacity",
    "Dense method",
    "Energy ledger",
    "Force law",
    "First yield",
    "Hertz",
    "Impact",
    "Left-end rule",
    "Mean rule",
    "Memory",
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


@cache
def trees() -> list[ast.Module]:
    return [
        ast.parse(file.read_text(encoding="utf-8")) for file in sorted(TESTS.rglob("test_*.py"))
    ]


def is_law(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Attribute)
        and node.attr == "law"
        and ast.unparse(node) == "pytest.mark.law"
    )


@cache
def sentences() -> list[str]:
    """Return the sentences of the markers that decorate a test."""
    tests = [node for tree in trees() for node in tree.body if isinstance(node, ast.FunctionDef)]
    marks = [
        mark
        for test in tests
        for mark in test.decorator_list
        if isinstance(mark, ast.Call) and is_law(mark.func)
    ]
    assert all(len(mark.args) == 1 and not mark.keywords for mark in marks)
    return [ast.literal_eval(mark.args[0]) for mark in marks]


def test_markers_are_literal_decorators_of_tests() -> None:
    """No marker stands where a reader of the source would not see it."""
    assert sum(is_law(node) for tree in trees() for node in ast.walk(tree)) == len(sentences())
    assert all(isinstance(sentence, str) for sentence in sentences())


def test_sentences_name_their_law_once() -> None:
    found = sentences()
    assert len(set(found)) == len(found)
    assert all(": " in sentence and sentence.endswith(".") for sentence in found)


def test_every_law_has_a_test() -> None:
    assert {sentence.partition(":")[0] for sentence in sentences()} >= LAWS
