"""A bearing in a plate states the level of the plate, and its folder has a sound of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import soundfile
from bearing_runs import WAVY, loads_bearing

import rolling as rc
from rolling.numbers.quantity import uncertain

PLATE = {"material": "steel-s235", "length_mm": 120, "width_mm": 90, "thickness_mm": 8}


def in_plate(**changes: object) -> rc.BearingScene:
    return loads_bearing(WAVY).with_({"plate": {**PLATE, **changes}, "sound.duration_s": 0.2})


def test_a_folder_has_the_sound_of_the_plate(tmp_path: Path) -> None:
    run = rc.simulate(in_plate(), progress=False)
    run.save(tmp_path / "run", report=False)
    level = rc.open_run(tmp_path / "run").numbers.housing.laeq
    assert level == run.numbers.housing.laeq
    assert level.value == run.housing.levels.laeq_db
    assert "contact_angle" not in {doubt.key for doubt in level.doubts}  # of axial velocities alone
    samples, rate = soundfile.read(tmp_path / "run" / "housing.wav")
    assert rate == 48000 and 0.01 < np.abs(samples).max() <= 1
    assert any("housing" in sentence for sentence in run.numbers.sentences)


def test_the_sound_of_the_plate_is_as_uncertain_as_what_shakes_it() -> None:
    """The plate has the parts of the radial velocity, between those of its bands, and its own."""
    numbers = rc.simulate(in_plate(), progress=False).numbers
    laeq = numbers.housing.laeq
    bands = numbers.velocities.radial.by_band.values()
    assert laeq.parts.keys() >= {"record", "loss_factor"}
    of_ring = [velocity.parts["loss_factor"] for velocity in bands]
    assert min(of_ring) <= laeq.parts["loss_factor"] <= max(of_ring) and max(of_ring) > 0
    assert laeq.uncertainty == pytest.approx(math.hypot(*laeq.parts.values()))
    octaves = numbers.housing.third_octaves
    assert all(spread >= 0.0 for spread in octaves.uncertainty if spread is not None)
    sentence = next(text for text in numbers.sentences if "housing" in text)
    assert uncertain(laeq.value, laeq.uncertainty) in sentence


def test_a_bearing_without_a_plate_has_none(tmp_path: Path) -> None:
    run = rc.simulate(loads_bearing(WAVY), progress=False)
    rc.save_run(run, tmp_path / "run", report=False)
    assert run.housing is None and run.numbers.housing is None
    assert not (tmp_path / "run" / "housing.wav").exists()


def test_twice_the_distance_is_quieter() -> None:
    near = rc.simulate(in_plate(), progress=False).housing.levels.laeq_db
    far_scene = in_plate().with_({"sound.distance_m": 2})
    far = rc.simulate(far_scene, progress=False).housing.levels.laeq_db
    assert 3 < near - far < 9
