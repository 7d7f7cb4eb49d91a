"""Every rule that yields doubts about a ball is called by the program, and yields one in a test."""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest
from finished import VIBRATING, marched
from made_numbers import bands, changed, computed
from memory_scenes import MEMORY
from scene_text import PLAIN, TINY
from source_trees import tree_of

import rolling
from acoustics.bands import BAND_NAMES
from rolling.check import marched as marched_check
from rolling.check import refusals
from rolling.check.findings import check_run, check_scene, conclusion
from rolling.check.in_short import lines_in_short
from rolling.numbers.ball_numbers import InstrumentNumbers, InstrumentOfSource
from rolling.numbers.doubt import Doubt
from rolling.results import run_doubts
from rolling.scene.file import loads
from rolling.scene.scene import Scene

ROOM = Path(rolling.__file__).parent
# Modules of the rules for a ball. Those of bearings and of choices have tests of their own.
RULES = (*(ROOM / "check").glob("*.py"), ROOM / "results/run_doubts.py", ROOM / "results/notes.py")
BODIES = ("sphere.density_kg_m3=7850", "plate.density_kg_m3=7850", "plate.loss_factor=0.01")
ON_PLATE = (*BODIES, "plate.thickness_mm=10", "dynamics={}", "sound.source=vibration")


def rule_names() -> set[str]:
    """Return module and name of each function of the rules that returns or yields doubts."""
    names = set()
    for path in RULES:
        for node in ast.walk(tree_of(path)):
            if not isinstance(node, ast.FunctionDef) or node.returns is None:
                continue
            if "Doubt" in ast.unparse(node.returns):
                names.add(f"{path.stem}.{node.name}")
    return names


class Yielded:
    """Rules that returned or yielded a doubt while this was the profiler of Python."""

    def __init__(self) -> None:
        self.names: set[str] = set()
        self._files = {str(path): path.stem for path in RULES}

    def __call__(self, frame: FrameType, event: str, value: Any) -> None:
        code: CodeType = frame.f_code
        if event != "return" or code.co_filename not in self._files:
            return
        found = value if isinstance(value, list | tuple) else [value]
        if any(isinstance(one, Doubt) for one in found):
            self.names.add(f"{self._files[code.co_filename]}.{code.co_name}")


# ---- what the rules are shown

WIDE = "surface.width_um=256"
BRIEF = "rolling.duration_s=0.002"
LONG_WAVES = "surface.correlation_length_um=30"
NARROW = """\
name: narrow
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, seed: 3, roughness_ra_um: 0.1, correlation_length_um: 12, spacing_um: 4,
  width_um: 128}
rolling: {load_n: 0.35, speed_m_s: 0.1, distance_mm: 0.4}
"""
AFFINE = (
    "surface={kind: self-affine, roughness_ra_um: 0.05, rolloff_um: 100, shortest_um: 8, "
    "hurst: 0.8, spacing_um: 2, width_um: 256, seed: 1}"
)
EDGES = ("plate.length_mm=20", "plate.width_mm=15", "plate.contact_mm=[10, 7]")
# Scenes that break one limit or more each.
SCENES = (
    (PLAIN, (WIDE, "surface.roughness_ra_um=5", "surface.correlation_length_um=3")),
    (PLAIN, (WIDE, "plate.hardness_gpa=0.001", "sphere.radius_mm=50")),
    (PLAIN, (WIDE, "surface.correlation_length_um=100", "numerics.step_nodes=16")),
    (PLAIN, (WIDE, "rolling.speed_m_s=0.01", "sound.q=0.5", "sound.distance_m=0.006")),
    (PLAIN, (WIDE, "rolling.speed_m_s=0.01", "numerics.step_nodes=0.5")),
    (PLAIN, ("surface={kind: smooth, spacing_um: 20, width_um: 1280}", "rolling.load_n=1")),
    (PLAIN, (WIDE, "sphere.material=aluminium-6061-t6", "plate.material=oak")),
    (PLAIN, (WIDE, "surface.skewness=-2.5", "surface.kurtosis=10", LONG_WAVES)),
    (PLAIN, (AFFINE, BRIEF)),
    (PLAIN, (WIDE, *ON_PLATE, "rolling.speed_m_s=2", "rolling.load_n=0.01")),
    (PLAIN, (WIDE, *ON_PLATE, "plate.thickness_mm=0.1", "sound.distance_m=0.1")),
    (PLAIN, (WIDE, *ON_PLATE[:2], "dynamics={}", "sound.source=vibration")),
    (PLAIN, (WIDE, *ON_PLATE, *EDGES, "plate.thickness_mm=0.3", "rolling.load_n=20")),
    (PLAIN, (WIDE, *ON_PLATE, "rolling.load_n=weight", "rolling.drop_mm=50", BRIEF)),
    (PLAIN, (WIDE, *ON_PLATE, "sphere.radius_mm=300", "rolling.load_n=100", BRIEF)),
    (PLAIN, (WIDE, *ON_PLATE, "dynamics={release: true}", "rolling.duration_s=0.0002")),
)


def measured(folder: Path) -> Iterator[Scene]:
    """Yield scenes of files of heights that were cut, tilted, and measured with noise."""
    rng = np.random.default_rng(1)
    noise = 1e-8 * rng.standard_normal((300, 128))
    tilt = np.linspace(0, 3e-6, 300)[:, None] + np.linspace(0, 3e-6, 128)
    np.save(folder / "tilted.npy", tilt + noise)
    surface = {"kind": "file", "path": str(folder / "tilted.npy"), "spacing_um": 2}
    scene = loads(PLAIN).with_({"surface": surface})
    yield scene
    yield scene.with_({"surface": surface | {"level": "none"}, "rolling.across_um": 125})
    seen = {"tip_radius_um": 2, "noise_nm": 10}
    yield scene.with_({"surface": surface | {"instrument": seen}})


def check_all(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check all scenes, and one for which memory and disk are too small."""
    for text, words in SCENES:
        check_run(loads(text, words))
    for scene in measured(folder):
        check_run(scene)
    narrow = check_scene(loads(NARROW))
    assert conclusion(loads(NARROW), narrow) and lines_in_short(loads(NARROW), narrow)
    check_scene(loads(PLAIN, ("rolling.load_n=2000",)))
    marched_check.check_contacts({"hard pressed": [loads(PLAIN, ("rolling.load_n=2000",))]})
    monkeypatch.setattr(refusals, "memory_limit", lambda: 1.0)
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1.0)
    found = check_scene(loads(TINY), solve=False)
    assert found.refusal is not None


def judge_all() -> None:
    """Judge runs and numbers, of a release and of a vibration, that break all limits."""
    run = marched(VIBRATING, ["rolling.distance_mm=0.16", "surface.width_um=128"])
    assert run.vibration_sound is not None
    motion = replace(run.vibration_sound.motion, outside_share=0.1, flight_share=0.1, settled=False)
    motion = replace(motion, plate_m=np.array([0.0, 5e-3]), impacts=2)
    vibration = replace(run.vibration_sound, motion=motion)
    whole = InstrumentOfSource(error_db=1.0, spread_db=1.5)
    seen = InstrumentNumbers(
        cutoff_m=1e-6,
        limit="tip",
        noise_recognized=False,
        vibration=whole,
        released_power=whole,
    )
    errors = {
        "is_asked": True,
        "solver_db": 0.5,
        "grid_db": 1.0,
        "subgrid_db": 0.2,
        "worst_uncertainty_db": 9.0,
        "grid_signal_db": -3.0,
        "stretches": 4,
    }
    of_motion = {
        "impacts_yield": True,
        "comb_spread_db": 2.0,
        "step_error_db": 0.3,
        "baffle_db": 0.4,
        "force_law_error_db": 0.2,
    }
    changes = {
        "errors": errors,
        "motion": of_motion,
        "surface": {"instrument": seen},
        "contact_loss_db": -3.0,
    }
    numbers = changed(computed(40.0), changes)
    run_doubts.doubts(run.scene, run.sound, numbers, vibration)
    silent = changed(numbers, {"record": {"source": "release"}})
    of_length = replace(silent.vibration, value=40.0, parts={"record": 1.0})
    run_doubts.doubts(run.scene, run.sound, replace(silent, vibration=of_length), vibration)
    comb = replace(vibration, spreads=vibration.spreads | {"comb": 9.0})
    run_doubts.doubts(run.scene, run.sound, numbers, comb)
    half_space = run.scene.with_({"plate.thickness_mm": None, "plate.loss_factor": None})
    loud = bands(dict.fromkeys(BAND_NAMES) | {"1000": 40.0})
    heard = changed(computed(40.0), {"bands": {"vibration_a": loud}})
    run_doubts.doubts(half_space, run.sound, heard, vibration)
    still = marched(TINY)
    assert still.numbers.heard is not None
    far_off = replace(still.numbers.heard, departure_db=9.0, gain_db=0.0)
    run_doubts.doubts(still.scene, still.sound, replace(still.numbers, heard=far_off))
    turns = {"reason": "the speed changes"}
    told = changed(still.numbers, {"turns": turns, "surface": {"instrument": seen}})
    told = changed(told, {"errors": {"is_asked": True, "reason": "it is too short"}})
    run_doubts.doubts(still.scene, still.sound, told)
    run_doubts.doubts(loads(MEMORY), still.sound, told)
    hidden = replace(still.sound, audible_rms=1e-12, resolved_rms=1e-9)
    run_doubts.doubts(still.scene, hidden, told)


@pytest.fixture(scope="module")
def yielded(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    """Return the rules that yielded a doubt about the scenes and numbers of this file."""
    seen = Yielded()
    with pytest.MonkeyPatch.context() as monkeypatch:
        sys.setprofile(seen)
        try:
            judge_all()
            check_all(tmp_path_factory.mktemp("heights"), monkeypatch)
        finally:
            sys.setprofile(None)
    return seen.names


def test_every_rule_yields_a_doubt(yielded: set[str]) -> None:
    assert rule_names() - yielded == set()


def test_every_rule_is_called_by_the_program() -> None:
    """A name that stands only where it is defined is that of a rule which nothing calls."""
    words: Counter[str] = Counter()
    for path in ROOM.rglob("*.py"):
        words.update(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    lonely = {name for name in rule_names() if words[name.split(".")[1]] < 2}
    assert lonely == set()
