"""The two numbers of a run and the sentences about runs: each says what it is a level of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rolling.results.answer import Answer, follows, gap, released_power, vibration
from rolling.results.description import runs_sentence, special
from rolling.results.run_folder import RunFolder
from rolling.scene import library
from rolling.scene.bearing_file import is_bearing_file
from rolling.scene.file import read_scene
from rolling.scene.scene import Scene

ESTIMATED: dict[str, Any] = {
    "source": "release",
    "q": 1.0,
    "laeq_db": 70.2,
    "record_laeq_db": 70.2,
    "lae_db": 67.2,
    "duration_s": 0.5,
    "uncertainty_db": {"laeq": 0.1},
    "vibration_estimate_laeq_db": 14.5,
    "vibration_estimate_uncertainty_db": 0.5,
    "vibration_estimate_force_ratio": 0.01,
    "vibration_estimate_bodies": "a ball of steel on a 10 mm plate of steel",
}
COMPUTED: dict[str, Any] = {
    "source": "vibration",
    "laeq_db": 14.8,
    "uncertainty_db": {"laeq": 0.2},
    "vibration_laeq_db": 14.8,
    "release_laeq_db": 70.2,
    "release_over_vibration_db": 55.4,
    "duration_s": 0.5,
}


class InMemory(RunFolder):
    """A run with a summary that the test gives."""

    summary: dict[str, Any]


def a_run(scene: Scene, summary: dict[str, Any], **values: float | str) -> RunFolder:
    run = InMemory({key.replace("__", "."): value for key, value in values.items()}, scene, Path())
    object.__setattr__(run, "summary", summary)
    return run


def loads(summaries: dict[float, dict[str, Any]]) -> list[RunFolder]:
    scene = read_scene(Path("quickstart"))
    return [
        a_run(scene.with_(load_n=load), summary, rolling__load_n=load)
        for load, summary in summaries.items()
    ]


@pytest.mark.parametrize(
    ("summary", "how", "level"),
    [
        (ESTIMATED, "estimated", 14.5),
        (COMPUTED, "computed", 14.8),
        (ESTIMATED | {"vibration_laeq_db": 15.0}, "computed", 15.0),
        (ESTIMATED | {"single_event": True}, "estimated", 11.5),
        (ESTIMATED | {"vibration_estimate_laeq_db": None}, "none", None),
        (COMPUTED | {"laeq_db": None}, "computed", None),
    ],
)
def test_the_release_never_takes_the_place_of_the_vibration(summary, how, level) -> None:
    answer = vibration(summary)
    assert (answer.how, answer.level_db) == (how, level if level is None else pytest.approx(level))
    assert bool(answer.reason) == (level is None)


@pytest.mark.parametrize(
    ("summary", "how", "level"),
    [
        (ESTIMATED, "upper bound", 70.2),
        (COMPUTED, "upper bound", 70.2),
        (ESTIMATED | {"q": 0.5}, "assumed", 70.2),
        (ESTIMATED | {"q": None}, "assumed", 70.2),
        (COMPUTED | {"drop_mm": 20.0}, "none", None),
        (ESTIMATED | {"laeq_db": None}, "none", None),
    ],
)
def test_the_released_power_says_what_it_is(summary, how, level) -> None:
    answer = released_power(summary)
    assert (answer.how, answer.level_db) == (how, level)
    assert bool(answer.reason) == (level is None)


def test_louder_and_quieter_are_said_of_the_vibration_only() -> None:
    louder = ESTIMATED | {"laeq_db": 81.1, "vibration_estimate_laeq_db": 10.9}
    text = follows(loads({5.0: ESTIMATED, 100.0: louder}))
    assert "3.6 dB" in text and "quieter" in text and "louder" not in text
    assert "about" in text and "although it releases 11 dB more power" in text
    unheard = [x | {"vibration_estimate_laeq_db": None} for x in (ESTIMATED, louder)]
    text = follows(loads({5.0: unheard[0], 100.0: unheard[1]}))
    assert "11 dB more power" in text
    assert "louder" not in text and "quieter" not in text


def test_a_difference_below_its_uncertainty_is_none() -> None:
    alike = ESTIMATED | {"vibration_estimate_laeq_db": 14.0}
    text = follows(loads({5.0: ESTIMATED, 100.0: alike}))
    assert "within the uncertainty" in text and "louder" not in text and "quieter" not in text


def test_an_estimate_is_not_compared_where_the_ball_would_lose_contact() -> None:
    flies = ESTIMATED | {"vibration_estimate_laeq_db": 40.0, "vibration_estimate_force_ratio": 2.0}
    text = follows(loads({5.0: ESTIMATED, 100.0: flies}))
    assert "lose contact" in text and "louder" not in text
    assert "too high" in vibration(flies).meaning


def test_runs_of_several_seeds_are_one_side() -> None:
    scene = read_scene(Path("finishes"))
    runs = []
    for finish, level in (("ground", 16.0), ("lapped", 10.0)):
        for seed in (1, 2, 3):
            summary = COMPUTED | {"laeq_db": level + 0.3 * seed, "release_laeq_db": 70 + level}
            values = {"surface__finish": finish, "surface__seed": seed}
            one = scene.with_({"surface.finish": finish, "surface.seed": seed, "sweep": {}})
            runs.append(a_run(one, summary, **values))
    text = follows(runs)
    assert "On the ground finish the ball is 6.0 dB louder than on the lapped" in text
    assert "three surfaces" in text


def test_runs_of_several_scenes_are_compared_by_their_names() -> None:
    sheet = a_run(read_scene(Path("steel-sheet")), COMPUTED | {"laeq_db": 56.4})
    pit = a_run(read_scene(Path("ball-with-pit")), COMPUTED | {"laeq_db": 18.0})
    assert follows([sheet, pit]).startswith("In steel-sheet the ball is 38 dB louder than in ball")
    fall = COMPUTED | {"single_event": True, "lae_db": 70.0, "drop_mm": 20.0}
    marble = a_run(read_scene(Path("marble-dropped")), fall)
    assert "louder" not in follows([sheet, marble]) and "LAE" in follows([sheet, marble])


def test_the_gap_names_both_levels() -> None:
    assert gap([ESTIMATED]).startswith("Released power is 56 dB above the estimated vibration")
    assert gap([ESTIMATED | {"q": None}]) == ""


@pytest.mark.parametrize("name", [name for name in library.scenes() if not is_bearing_file(name)])
def test_every_scene_of_the_library_has_a_sentence(name: str) -> None:
    runs = [RunFolder(run.values, run.scene, Path()) for run in read_scene(Path(name)).runs()]
    sentence = runs_sentence(runs)
    assert sentence.endswith(".") and "None" not in sentence and "  " not in sentence
    assert f"{2 * runs[0].scene.sphere.radius_mm:g} mm" in sentence


def test_a_pit_ticks_once_a_turn() -> None:
    run = a_run(read_scene(Path("ball-with-pit")), COMPUTED)
    turns = 0.25 / (2 * 3.14159 * 4e-3)
    assert round(turns) == 10 and "ten times a second" in special(run)


def test_what_nobody_hears_is_not_told() -> None:
    scene = read_scene(Path("vibrating-ball")).with_(load_n=20)
    rings = COMPUTED | {"resonance_hz": 60e3, "resonance_q": 30.0}
    assert special(a_run(scene, rings)) == ""
    assert "10 kHz" in special(a_run(scene, rings | {"resonance_hz": 10e3}))
    high = {"third_octave_a_db": {"1000": 5.0, "16000": 15.0}}
    assert "12 kHz" in special(a_run(scene, COMPUTED | high))
    low = {"third_octave_a_db": {"1000": 15.0, "16000": 5.0}}
    assert special(a_run(scene, COMPUTED | low)) == ""


def test_an_answer_never_shows_a_level_without_how_it_was_found() -> None:
    for answer in (vibration(ESTIMATED), released_power(ESTIMATED), vibration(COMPUTED)):
        assert isinstance(answer, Answer) and answer.how in answer.text
