"""Scenes and height files broken at random: each is read and checked, or refused in words, and
quickly; nothing else ever happens.
"""

from __future__ import annotations

import importlib
import random
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from mutated_texts import mutated
from mutations import CASES, outcome, texts
from scene_text import SCENES

from rolling import Scene
from rolling.check import findings
from rolling.scene import file
from rolling.scene.messages import SceneError

SECONDS = 1.0  # of processor time, up to which a case is quick on any machine
SECONDS_OF_MODES = 10.0  # the same for plates whose modes have no closed form, some 1,000 of them
WORKS = 20  # maximum processor time of a case, over that of `work`; the slowest takes 12
# cases of each kind; tests/support/mutations.py runs any number
NUMBERS = range(200)
# of the scenes that are solved; others draw a sheet of twice the size, which takes 20 s
SEEDS = (1, 2)


def processor_time(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def work() -> None:
    """Do fixed work, some 0.1 s, by which a slow minute of the machine is known."""
    sorted(range(400_000), key=str)


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    """Import the reader of instruments' files, which takes longer than any case."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        importlib.import_module("SurfaceTopography.IO")


def assert_read_or_refused(kind: str, numbers: range, folder: Path) -> None:
    outcomes = set()
    for number in numbers:
        made: list[Scene] = []

        def make() -> Scene:
            made.append(CASES[kind](number, folder))  # noqa: B023
            return made[0]  # noqa: B023

        try:
            took = processor_time(lambda: outcomes.add(outcome(make)))
        except Exception as error:
            raise AssertionError(f"the {kind} of number {number}") from error
        limit = SECONDS
        if made and made[0].plate.edges not in (None, "simply_supported"):
            limit = SECONDS_OF_MODES
        assert took < limit or took < WORKS * processor_time(work), (kind, number)
    assert outcomes == {"read", "refused"}  # neither is rare, so both ways are tried


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_many_mutations_are_checked_or_refused_in_words_and_quickly(
    kind: str, tmp_path: Path
) -> None:
    assert_read_or_refused(kind, NUMBERS, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_solved_positions_of_mutated_scenes_end_in_no_traceback(seed: int) -> None:
    """They have a budget of their own (test_check), so they are not timed here."""
    chance = random.Random(seed)
    read = 0
    for _ in range(40):
        text = mutated(chance.choice(texts()), chance)
        try:
            scene = file.loads(text, where="s.yaml", folder=SCENES[0].parent)
            str(findings.check_scene(scene, solve=True))
            read += 1
        except SceneError:
            continue
    assert read
