"""The page of key effects has every key, and its numbers follow from runs and from theory."""

from __future__ import annotations

import importlib
import math
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = next(folder for folder in Path(__file__).parents if (folder / "pyproject.toml").exists())
PAGE = (ROOT / "docs" / "key-effects.md").read_text(encoding="utf-8")


def _module(folder: str, name: str) -> ModuleType:
    sys.path.insert(0, str(ROOT / folder))
    return importlib.import_module(name)


study = _module("tests/benchmarks", "key_effects")
generate = _module("docs/_hooks", "generate")


def test_every_key_of_the_schema_has_a_change_or_a_reason():
    """A new key needs a row in key_effects.toml, and a key that is gone has none."""
    listed = {(title, name) for title, names in study.STUDY["keys"].items() for name in names}
    known = set(generate.keys(generate._schema())) | {("surface: smooth", "kind")}
    assert listed == known, listed ^ known


def test_the_page_has_the_base_scene_and_every_key():
    """The page is that of the present table of changes; `study.COMMAND` writes it."""
    assert study.STUDY["base"].strip().replace("SEED", "1") in PAGE
    without = PAGE.partition("equal to the last bit: ")[2].partition(".\n")[0]
    for effect in study.effects():
        row = f"|`{effect.key}`|{effect.change}|{effect.on}|"
        assert row in PAGE or f"`{effect.key}`" in without, f"{row}: {study.COMMAND}"
    for key, reason in study.unmeasured().items():
        assert f"`{key}`: {reason}" in PAGE, key


EXACT_DB = {  # by dotted key: level, release
    "name": (0.0, 0.0),
    "sound.distance_m": (-20 * math.log10(2), -20 * math.log10(2)),  # p ~ 1/r, I ~ 1/r^2
    "sound.q": (-10 * math.log10(2), -10 * math.log10(2)),
    "sound.gain_pa_per_w_m2": (20 * math.log10(2), 20 * math.log10(2)),
}


@pytest.mark.slow
def test_a_short_study_gives_the_effects_of_theory_and_of_the_page():
    wanted = [effect for effect in study.effects() if effect.key in EXACT_DB]
    frame = study.study(wanted, [1], 1, ["rolling.distance_mm=0.8"])
    for effect, changes in zip(wanted, study.changes(frame), strict=True):
        level = changes["level"].mean
        release = changes["release"].mean
        assert (level, release) == pytest.approx(EXACT_DB[effect.key], abs=1e-6), effect.key
        cells = next((line for line in PAGE.splitlines() if f"|`{effect.key}`|" in line), "")
        if level:
            assert f"|**{level:+.1f}±0.0**|" in cells
