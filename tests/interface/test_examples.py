"""The scripts in examples/ and the examples in docstrings run."""

from __future__ import annotations

import doctest
import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from bearing_runs import turning
from finished import VIBRATING, marched
from matplotlib import pyplot
from report_runs import runs_of

import acoustics
import rolling

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
WITH_DOCTESTS = sorted(
    ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("rolling", "acoustics")
    for file in (ROOT / package).rglob("*.py")
    if ">>> " in file.read_text(encoding="utf-8")
)


@pytest.mark.slow
@pytest.mark.parametrize("script", EXAMPLES, ids=lambda script: script.stem)
def test_example_runs(script: Path, tmp_path: Path) -> None:
    """Each example prints in an empty folder, without a screen."""
    environment = os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}
    run = subprocess.run(
        [sys.executable, script], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()


@pytest.mark.parametrize("package", [rolling, acoustics], ids=lambda package: package.__name__)
def test_every_exported_class_and_function_has_an_example(package: ModuleType) -> None:
    exported = {name: getattr(package, name) for name in package.__all__}
    lacking = [
        x for x, thing in exported.items() if callable(thing) and ">>> " not in thing.__doc__
    ]
    assert not lacking


# A run that nearly every plot can draw: it vibrates, and its ball has a surface and turns twice.
DRAWN = (
    "plate.hardness_gpa=2.1",
    "sphere.radius_mm=0.1",
    "rolling.load_n=0.01",
    "rolling.distance_mm=1.3",
    "recovery.events=true",
    "sound.channels=[{of: contact, quantity: force}]",
    "sphere.surface={kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, seed: 1}",
)


@pytest.fixture(scope="module")
def drawn() -> dict[str, Any]:
    """Return the names that examples of plots take as given."""
    (worn,) = runs_of("memory")
    return {
        "run": marched(VIBRATING, DRAWN),
        "runs": runs_of("seeds"),
        "worn": worn,
        "turning": turning(),
    }


# Their examples choose between scenes, or compute the loudness in a room.
LONG = (
    "acoustics.audibility",
    "rolling.choice.choice",
    "rolling.interface.choices",
    "rolling.interface.runs",
    "rolling.results.channels",
    "rolling.sound.vibration_sound",
)


@pytest.mark.usefixtures("short_sounds")
@pytest.mark.parametrize(
    "module",
    [
        pytest.param(module, marks=pytest.mark.slow) if module in LONG else module
        for module in WITH_DOCTESTS
    ],
)
def test_docstrings_say_what_comes_out(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    """Examples run in an empty folder; a scene is named by scenarios/."""
    places = (
        "rolling.plot",
        "rolling.figures",
        "rolling.bearing_kind.bearing_figures",
        "rolling.bearing_kind.pulse_figures",
    )
    is_plot = module.startswith((*places, "rolling.kinds.shown_run"))
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    outcome = doctest.testmod(
        importlib.import_module(module),
        extraglobs=request.getfixturevalue("drawn") if is_plot else None,
        optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE,
        verbose=False,
    )
    pyplot.close("all")
    assert outcome.failed == 0
