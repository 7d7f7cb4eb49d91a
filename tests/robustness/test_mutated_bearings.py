"""Scenes of bearings broken at random: each is read and checked, or refused in words."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest
from bearing_runs import loads_bearing
from mutated_texts import WORDS, mutated
from mutations import VALUES
from scene_text import BEARINGS

from rolling import BearingScene
from rolling.bearing_kind.bearing_check import check_bearing
from rolling.scene.file import dump
from rolling.scene.messages import SceneError
from rolling.scene.yaml_text import parse

FULL = """\
name: full
bearing:
  named: "6204"
  bore_mm: 20
  contact_angle_deg: 12
  material: steel-100cr6
  youngs_modulus_gpa: 208
  turning: outer
  speed_rpm: 1800
  axial_load_n: 70
  radial_load_n: 30
  ring_mass_kg: 0.06
  contact_loss_factor: 0.02
  ball_inertia: true
  surfaces:
    balls: {kind: graded, grade: G10, seed: 1, faults: [
      {kind: pit, at_mm: [5, 0], size_um: 80, depth_um: 3}]}
    inner: {kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 60,
      correlation_length_across_um: 10, seed: 2, waviness: {9: 0.01, 30: 0.002}}
    outer: {kind: smooth, faults: [{kind: pit, count: 3, seed: 1, size_um: 80, depth_um: 3}]}
    fault_ball: 2
plate: {material: steel-s235, length_mm: 300, width_mm: 200, thickness_mm: 5, edges: clamped,
  contact_mm: [100, 80]}
numerics: {spacing_um: 2, window_mm: 4, tolerance: 1e-4}
sound: {duration_s: 1, listen_s: 5, distance_m: 1}
sweep:
  bearing.speed_rpm: [900, 1800]
  bearing.surfaces.balls.grade: [G5, G100]
"""
TEXTS = [FULL, *(path.read_text(encoding="utf-8") for path in BEARINGS)]
KEYS = ["bearing.balls", "bearing", "sweep.bearing.speed_rpm", "plate", "name", "x.y", ""]
FACTORS = [1e-9, 1e-3, 0.1, 0.5, 2, 10, 1e3, 1e9]


def text_case(number: int) -> BearingScene:
    """Read the broken text of a number, with a broken override for some."""
    chance = random.Random(number)
    text = mutated(chance.choice(TEXTS), chance)
    overrides = []
    if chance.random() < 0.3:
        overrides = [mutated(f"{chance.choice(KEYS)}={chance.choice(WORDS)}", chance)]
    return loads_bearing(text, overrides, "b.yaml")


def values_case(number: int) -> BearingScene:
    """Build a scene from plain values, some of which are swapped for others."""
    chance = random.Random(number)
    data = parse(FULL, "b.yaml").value
    for _ in range(chance.choice([1, 1, 2, 4])):
        section = data
        key = chance.choice(list(section))
        while isinstance(section[key], dict) and section[key] and chance.random() < 0.8:
            section = section[key]
            key = chance.choice(list(section))
        section[key] = _other(chance, section[key])
    return BearingScene.from_dict(data)


def _other(chance: random.Random, before: Any) -> Any:
    """Return another value, of the same size for half of the numbers."""
    is_number = isinstance(before, int | float) and not isinstance(before, bool)
    if is_number and abs(before) < 1e300 and chance.random() < 0.6:
        return before * chance.choice(FACTORS)
    return chance.choice([value for value in VALUES if not isinstance(value, np.ndarray | set)])


def sizes_case(number: int) -> BearingScene:
    """Build a bearing of steel whose sizes and loads are far from usual ones."""
    chance = random.Random(number)
    sizes: dict[str, Any] = {
        "balls": chance.choice([3, 4, 8, 9, 100]),
        "ball_diameter_mm": 10 ** chance.uniform(-1, 2.5),
        "conformity_inner": chance.choice([0.5 + 1e-15, 0.5001, 0.52, 0.6]),
        "contact_angle_deg": chance.choice([1e-12, 1e-3, 12.0, 60.0]),
        "axial_load_n": chance.choice([0.0, 10 ** chance.uniform(-15, 6)]),
        "radial_load_n": chance.choice([0.0, 10 ** chance.uniform(-15, 6)]),
        "speed_rpm": 10 ** chance.uniform(-12, 6),
    }
    sizes["pitch_diameter_mm"] = sizes["ball_diameter_mm"] * chance.choice([1.2, 3, 30])
    return BearingScene(bearing=sizes)


CASES = {"text": text_case, "values": values_case, "sizes": sizes_case}


def assert_read_or_refused(kind: str, numbers: range, checked: bool) -> None:
    outcomes = set()
    for number in numbers:
        try:
            scene = CASES[kind](number)
            assert loads_bearing(dump(scene)) == scene
            if checked:
                str(check_bearing(scene))
            outcomes.add("read")
        except SceneError as error:
            assert error.mistakes and all(len(fault) < 2000 for fault in error.mistakes)
            outcomes.add("refused")
        except Exception as error:
            raise AssertionError(f"the {kind} of number {number}") from error
    assert outcomes == {"read", "refused"}


@pytest.mark.parametrize("kind", CASES)
def test_mutated_bearings_are_read_or_refused_in_words(kind: str) -> None:
    assert_read_or_refused(kind, range(40), checked=False)


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_many_mutated_bearings_are_checked_or_refused_in_words(kind: str) -> None:
    assert_read_or_refused(kind, range(100, 160), checked=True)
