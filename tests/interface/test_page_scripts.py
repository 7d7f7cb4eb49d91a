"""The scripts of the page are small ES modules that join into one text without a clash of names."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from report_browser import without_browser

from rolling.report import templates

ASSETS = Path(templates.__file__).parent / "assets"
MODULES = sorted([*ASSETS.glob("page/*.js"), *ASSETS.glob("engine/*.js")])
DECLARED = re.compile(
    r"^(?:async )?(?:const|let|var|function\*?|class) (\w+|[{\[][^=]*[}\]])", re.M
)


def names_of(script: str) -> list[str]:
    """Return the names that a script declares at its top level."""
    return [name for part in DECLARED.findall(script) for name in re.findall(r"\w+", part)]


@pytest.mark.parametrize("entry", ["page/begin.js", "page/chart.js", "engine/analyst.js"])
def test_joined_scripts_are_javascript_without_doubled_names(entry: str) -> None:
    script = templates.joined_script(entry)
    doubled = {name for name, count in Counter(names_of(script)).items() if count > 1}
    assert not doubled and not re.search(r"^(import|export)\b", script, re.M)
    if (node := shutil.which("node")) is None:
        without_browser("no Node")
    checked = subprocess.run([node, "--check", "-"], input=script, text=True, capture_output=True)
    assert checked.returncode == 0, checked.stderr


def test_modules_import_each_other_in_no_circle() -> None:
    """A sorter of the graph of imports raises CycleError for a circle."""
    graph = {}
    for module in MODULES:
        imported = re.findall(r'from "(\.[^"]+)"', module.read_text())
        graph[module] = {(module.parent / name).resolve() for name in imported}
    order = [*TopologicalSorter(graph).static_order()]
    assert len(order) == len(MODULES) > 30
