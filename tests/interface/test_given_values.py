"""Public functions take any array-like of numbers, or say in one sentence what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from finished import VIBRATING, marched

import rolling as rc
from rolling.contact.state import RollingContact
from rolling.results.run_result import Run

STEEL = rc.HalfSpace(2e-6, 230e9)
PLACES = np.arange(-12, 13) * 2e-6
GAP = (PLACES[:, None] ** 2 + PLACES**2) / (2 * 5e-3)
CONTACT = RollingContact(np.zeros((64, 64)), 4e-6, 5e-3, 230e9, np.inf, 0.5, 4e-6, 0.0, 1e-5)
WRONG = {
    "nothing": None,
    "text": "abc",
    "no number": [],
    "ragged": [[1.0, 2.0], [3.0]],
    "three dimensions": np.zeros((2, 2, 2)),
    "NaN": float("nan"),
    "negative": -1.0,
    "zero": 0,
    "NaN in an array": np.full((25, 25), np.nan),
    "true": True,
    "mapping": {"a": 1},
    "complex": 1j,
}
# Functions of numbers and arrays stand in test_bad_arguments.py.
CALLS: dict[str, Callable[[Any], object]] = {
    "simulate": rc.simulate,
    "simulate_sweep": rc.simulate_sweep,
    "save_run": lambda x: rc.save_run(x, "nowhere"),
    **{f"plot.{name}": getattr(rc.plot, name) for name in rc.plot.__all__},
}


@pytest.mark.parametrize("call", CALLS)
def test_a_wrong_value_is_named_in_one_sentence(call: str) -> None:
    """The sentence names the argument, the value and the allowed values, never an attribute."""
    for kind, value in WRONG.items():
        with pytest.raises((ValueError, TypeError)) as error:
            CALLS[call](value)
        message = str(error.value)
        assert ("allowed: " in message and ": got " in message) or "not finite" in message, kind
        assert "\n" not in message and len(message) < 200


def test_lists_of_numbers_are_arrays() -> None:
    solved = rc.solve_contact(STEEL, GAP, 0.02)
    again = rc.solve_contact(STEEL, GAP.tolist(), 0.02, shape=None, hardness=np.float32(np.inf))
    assert np.array_equal(solved.pressure, again.pressure)
    deflection = STEEL.deflection(solved.pressure.tolist())
    assert np.allclose(deflection, solved.deflection, rtol=1e-9, atol=1e-9 * deflection.max())
    assert replace(CONTACT, heights=[[0, 0], [0, 0]]).heights.shape == (2, 2)
    with pytest.raises(ValueError, match=r"^shape: got .* \(2, 2\), allowed: \(25, 25\)$"):
        rc.solve_contact(STEEL, GAP, 0.02, shape=[[0, 0], [0, 0]])


@pytest.mark.parametrize("workers", [-1, 1.5, "2", True, None, float("nan")])
def test_a_number_of_workers_is_whole(workers: Any) -> None:
    with pytest.raises(ValueError, match="workers: got"):
        rc.simulate_sweep(rc.read_scene("quickstart"), workers=workers)


def test_no_object_prints_its_arrays() -> None:
    run: Run = marched(VIBRATING)
    state = next(rc.march(CONTACT, 0, 0, rc.HalfSpace(4e-6, 230e9)))
    objects = [STEEL, CONTACT, state, rc.solve_contact(STEEL, GAP, 0.02), run, run.result]
    objects += [run.sound, run.sound.levels, run.sound.uncertainty, run.sound.lap, run.vibration]
    objects += [run.vibration_sound.motion, run.vibration_sound.law, run.result.snapshot]
    for shown in objects:
        assert len(repr(shown)) < 1500 and "array(" not in repr(shown), type(shown)
        assert repr(shown).lstrip("<").startswith((type(shown).__name__, "run"))
    texts = map(repr, (STEEL, CONTACT, state, objects[3], run.sound, run.scene))
    for text, units in zip(
        texts, ("m Pa", "m N Pa", "m2 m Pa", "N m2 m Pa", "s", "m N s"), strict=True
    ):
        assert len(text) < 160 and all(f" {unit}" in text for unit in units.split()), text
