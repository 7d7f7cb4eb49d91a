"""A ball that falls is of another kind than one that rolls, and runs of both may be mixed."""

from __future__ import annotations

from pathlib import Path

import pytest

import rolling as rc
from rolling.ball_kinds.balls import KIND
from rolling.ball_kinds.falling_ball import FALLING
from rolling.ball_kinds.rolling_ball import ROLLING
from rolling.kinds.kind import Kind
from rolling.kinds.registry import kind_of, kind_of_runs
from rolling.kinds.run_folder import RunFolder
from rolling.results.description import runs_sentence

SWEEP = "sweep.rolling.drop_mm={rolls: null, falls: 2}"


def _runs() -> list[RunFolder]:
    """Return a run of a ball that rolls, and one of a ball that falls."""
    scene = rc.read_scene("marble-dropped", [SWEEP])
    return [
        RunFolder(scene=run.scene, folder=Path("run"), values=run.values) for run in scene.runs()
    ]


def test_a_scene_is_of_the_kind_of_its_motion() -> None:
    assert [kind_of(run.scene) for run in _runs()] == [ROLLING, FALLING]
    assert KIND.name == ROLLING.name == FALLING.name  # of the files of their runs


@pytest.mark.parametrize(
    ("chosen", "kind"), [(slice(0, 1), ROLLING), (slice(1, 2), FALLING), (slice(0, 2), KIND)]
)
def test_runs_of_both_kinds_are_shown_together(chosen: slice, kind: Kind) -> None:
    assert kind_of_runs(_runs()[chosen]) is kind


def test_a_sweep_of_both_is_told_in_a_sentence_of_each() -> None:
    rolls, falls = runs_sentence(_runs()).split(". ")
    assert " rolls at " in rolls and "falls" not in rolls
    assert " falls 2 mm onto " in falls and "bounces" in falls


def test_facts_follow_from_the_motion() -> None:
    rolls, falls = (run.scene for run in _runs())
    assert rolls.keeps_its_load and rolls.has_release and not rolls.is_one_event
    assert falls.is_one_event and not falls.keeps_its_load and not falls.has_release
