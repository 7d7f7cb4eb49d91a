"""Loss factors of a plate that change with the frequency: pairs, third octaves and power laws."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rolling
from acoustics.radiation import ThinPlate
from acoustics.rectangular_plate import RectangularPlate
from acoustics.sound_power import plate_power_per_force
from rolling import SceneError, read_scene
from rolling.kinds.run_folder import RunFolder
from rolling.results.labels import labels
from rolling.scene.file import dump, loads
from rolling.scene.sections import loss_text

CURVE = ((100.0, 0.04), (1000.0, 0.01), (10000.0, 0.005))
STEEL = RectangularPlate(78.5, 18.9e3, 0.01, length_m=0.4, width_m=0.3)


@pytest.mark.law("Loss factor over frequency: between two pairs it is a power law.")
def test_between_pairs_it_is_a_power_law_and_beyond_them_it_is_constant() -> None:
    plate = ThinPlate(78.5, 18.9e3, ((100.0, 0.02), (10000.0, 0.002)))
    law = plate.loss_factor_at([100, 1000, 10000])
    np.testing.assert_allclose(law, [0.02, 0.02 * 10**-0.5, 0.002])
    np.testing.assert_allclose(plate.loss_factor_at([0, 50, 2e4]), [0.02, 0.02, 0.002])
    assert plate.least_loss_factor == 0.002


def test_each_mode_and_each_power_has_the_loss_of_its_frequency() -> None:
    curved = replace(STEEL, loss_factor=CURVE)
    hertz = curved.angular_frequency / (2 * np.pi)
    by_sound = STEEL.loss_factors - 0.01
    np.testing.assert_allclose(curved.loss_factors - by_sound, curved.loss_factor_at(hertz))
    infinite = ThinPlate(78.5, 18.9e3, CURVE)
    for frequency in (2000.0, 8000.0):
        local = ThinPlate(78.5, 18.9e3, float(infinite.loss_factor_at(frequency)))
        expected = plate_power_per_force([frequency], local)
        assert plate_power_per_force([frequency], infinite) == pytest.approx(expected, rel=1e-12)


def test_a_scene_takes_it_keeps_it_and_names_it() -> None:
    pairs = "[[100, 0.04], [1000, 0.01], [10000, 0.005]]"
    scene = read_scene("steel-sheet", [f"plate.loss_factor={pairs}"])
    assert scene.plate.loss_factor == CURVE
    assert loads(dump(scene)) == scene
    swept = scene.with_(sweep={"plate.loss_factor": {"a": 0.01, "b": [[100, 0.04], [1000, 0.01]]}})
    runs = swept.runs()
    assert [run.scene.plate.loss_factor for run in runs] == [0.01, CURVE[:2]]
    folders = [RunFolder({}, run.scene, Path("x")) for run in runs]
    assert labels(folders) == ["loss factor 0.01", "loss factor 0.01 to 0.04"]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("[[100, 0.01]]", "at least two"),
        ("[[100, 0.01], [1000, 2]]", "at most 1"),
        ("[[1000, 0.01], [100, 0.02]]", "rising frequency"),
        ("0", "above 0"),
        ("high", "above 0"),
    ],
)
def test_a_wrong_one_is_one_message(value: str, words: str) -> None:
    with pytest.raises(SceneError, match=f"plate.loss_factor: got .*{words}"):
        read_scene("steel-sheet", [f"plate.loss_factor={value}"])


def test_a_flat_curve_sounds_as_its_number() -> None:
    scene = read_scene("vibrating-ball", ["sweep="]).with_(
        load_n=2, duration_s=0.005, length_mm=120, width_mm=90
    )
    number = rolling.simulate(scene, workers=1, progress=False)
    flat = scene.with_({"plate.loss_factor": [[100, 0.01], [1000, 0.01]]})
    curved = rolling.simulate(flat, workers=1, progress=False)
    np.testing.assert_allclose(curved.sound.pressure, number.sound.pressure, rtol=1e-9, atol=1e-15)
    assert loss_text(flat.plate.loss_factor) == "0.01 at 100 Hz to 0.01 at 1000 Hz"
