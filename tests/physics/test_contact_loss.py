"""An unknown damping of the contact: how far it changes a level, and what it leaves in ±."""

from __future__ import annotations

import math
from typing import Any

import pytest

import rolling
from rolling import Run, read_scene
from rolling.numbers.quantity import Quantity, difference

STATED = {"plate.contact_loss_factor": 0.02}


def run_of(name: str, **changes: Any) -> Run:
    scene = read_scene(name, ["sweep="]).with_(changes)
    return rolling.simulate(scene, workers=1, progress=False)


@pytest.fixture(scope="module")
def rings() -> dict[str, Any]:
    """Return the changes of a short run on a thick plate, whose contact rings."""
    return {
        "rolling.load_n": 2,
        "rolling.speed_m_s": 0.1,
        "rolling.duration_s": None,
        "rolling.distance_mm": 1,
        "plate.thickness_mm": 8,
    }


@pytest.mark.slow
@pytest.mark.law("Unknown damping: the linear chain tells how far a loss of the contact matters.")
def test_the_change_is_that_of_a_run_with_the_loss(rings: dict[str, Any]) -> None:
    without = run_of("vibrating-ball", **rings).numbers
    stated = run_of("vibrating-ball", **rings, **STATED).numbers
    change = stated.levels.vibration.laeq_db - without.levels.vibration.laeq_db
    assert without.contact_loss_db < -0.5
    assert without.contact_loss_db == pytest.approx(change, abs=0.3)
    part = without.contact_loss_db / 2
    assert without.of_record.spreads.laeq_db > abs(part)
    assert stated.contact_loss_db == 0
    assert not [doubt for doubt in stated.doubts if doubt.key == "contact_loss"]
    (doubt,) = [doubt for doubt in without.doubts if doubt.key == "contact_loss"]
    assert doubt.decibels == pytest.approx(abs(part))


def test_an_estimate_has_it_too() -> None:
    numbers = run_of("quickstart", **{"rolling.load_n": 5, "rolling.duration_s": 0.002}).numbers
    assert numbers.contact_loss_db < -0.5
    assert numbers.vibration.uncertainty > abs(numbers.contact_loss_db) / 2


def test_a_difference_has_half_of_what_the_loss_changes_in_it() -> None:
    def heard(level: float, own: float, change: float) -> Quantity:
        parts = {"record": own, "contact_loss": abs(change) / 2}
        return Quantity(
            "vibration",
            level,
            measure="LAeq",
            uncertainty=math.hypot(*parts.values()),
            parts=parts,
            signed={"contact_loss": change},
        )

    found = difference([heard(30, 0.3, -4)], [heard(36, 0.4, -5)])
    assert found is not None
    assert found.value == 6
    assert found.uncertainty == pytest.approx(math.hypot(0.3, 0.4, 0.5))


def test_a_ball_that_falls_keeps_its_level() -> None:
    changes = {"rolling.drop_mm": 0.02, "rolling.load_n": "weight", "rolling.distance_mm": 1}
    numbers = run_of("vibrating-ball", **changes, **{"rolling.duration_s": None}).numbers
    assert numbers.contact_loss_db == 0
