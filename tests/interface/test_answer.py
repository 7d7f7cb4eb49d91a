"""The two numbers of a run and the sentences about runs: each says what it is a level of."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_numbers import bands, computed, estimated, run_with
from scene_text import BALLS

from rolling.kinds.reading import read_scene
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.quantity import BandQuantity
from rolling.results.answer import follows, gap
from rolling.results.description import runs_sentence, special


def loads(of_loads: dict[float, RunNumbers]) -> list[RunFolder]:
    scene = read_scene(Path("quickstart"))
    return [
        run_with(scene.with_(load_n=load), numbers, rolling__load_n=load)
        for load, numbers in of_loads.items()
    ]


@pytest.mark.parametrize(
    ("numbers", "how", "level"),
    [
        (estimated(), "estimated", 14.5),
        (computed(), "computed", 14.8),
        (estimated(levels={"vibration": {"laeq_db": 15.0}}), "computed", 15.0),
        (estimated(record={"single_event": True}), "estimated", 11.5),
        (estimated(None), "estimated", None),
        (computed(None), "computed", None),
    ],
)
def test_the_release_never_takes_the_place_of_the_vibration(
    numbers: RunNumbers, how: str, level: float | None
) -> None:
    heard = numbers.vibration
    assert (heard.how, heard.value) == (how, level if level is None else pytest.approx(level))
    assert bool(heard.reason) == (level is None) == (heard.verdict is None)


@pytest.mark.parametrize(
    ("numbers", "how", "level"),
    [
        (estimated(), "upper bound", 70.2),
        (computed(), "upper bound", 70.2),
        (estimated(record={"q": 0.5}), "assumed", 70.2),
        (estimated(record={"q": None}), "assumed", 70.2),
        (computed(motion={"drop_mm": 20.0}), "upper bound", None),
        (estimated(released_db=None), "upper bound", None),
    ],
)
def test_the_released_power_says_what_it_is(
    numbers: RunNumbers, how: str, level: float | None
) -> None:
    power = numbers.released_power
    assert (power.how, power.value) == (how, level)
    assert bool(power.reason) == (level is None)
    word = {"upper bound": "bound", "assumed": "assumed"}[how]
    assert power.verdict == (None if level is None else word)


def test_louder_and_quieter_are_said_of_the_vibration_only() -> None:
    text = follows(loads({5.0: estimated(), 100.0: estimated(10.9, 81.1)}))
    assert "3.6 dB" in text and "quieter" in text and "louder" not in text
    assert "about" in text and "although it releases 11 dB more power" in text
    text = follows(loads({5.0: estimated(None), 100.0: estimated(None, 81.1)}))
    assert "11 dB more power" in text
    assert "louder" not in text and "quieter" not in text


def test_a_difference_below_its_uncertainty_is_none() -> None:
    text = follows(loads({5.0: estimated(), 100.0: estimated(14.0)}))
    assert "within the uncertainty" in text and "louder" not in text and "quieter" not in text


def test_a_difference_leaves_out_what_both_levels_share_and_says_so() -> None:
    """The chain of 1 dB shifts both; two combs of 0.5 dB leave 0.8 dB, rounded up."""
    text = follows(loads({5.0: estimated(), 100.0: estimated(20.5)}))
    assert "± 0.8 dB" in text and "an error by the linear chain would be in both" in text


def on_free_plate(level_db: float, baffle_db: float) -> RunNumbers:
    """Return the numbers of a run on a free plate, whose baffle is that of its size."""
    of_band = {"baffle": (baffle_db,)}
    own = BandQuantity("dB", (1000.0,), (level_db,), (baffle_db,), parts=of_band)
    parts = {"record": 0.2, "baffle": 5.0}
    return computed(level_db, 70.2, parts, bands={"vibration": own})


@pytest.mark.law("Free plates: two runs share what the baffle changes on the same plate only.")
def test_baffles_of_different_plates_are_not_shared() -> None:
    """Five decibels lie within the two parts of 5 dB of different plates, and beyond 0.2 dB."""
    text = follows(loads({5.0: on_free_plate(30.0, 6.0), 100.0: on_free_plate(35.0, 6.0)}))
    assert (
        "5.0 dB louder than at 5 N (an error by the baffle that a free plate does not have" in text
    )
    text = follows(loads({5.0: on_free_plate(30.0, 6.0), 100.0: on_free_plate(35.0, 10.0)}))
    assert "as loud as at 5 N within the uncertainty" in text


def test_an_estimate_is_not_compared_where_the_ball_would_lose_contact() -> None:
    flies = estimated(40.0, estimate={"force_ratio": 2.0})
    text = follows(loads({5.0: estimated(), 100.0: flies}))
    assert "lose contact" in text and "louder" not in text
    assert "too high" in flies.vibration.meaning


def test_runs_of_several_seeds_are_one_side() -> None:
    scene = read_scene(Path("finishes"))
    runs = []
    for finish, level in (("ground", 16.0), ("lapped", 10.0)):
        for seed in (1, 2, 3):
            numbers = computed(level + 0.3 * seed, 70 + level)
            one = scene.with_({"surface.finish": finish, "surface.seed": seed, "sweep": {}})
            runs.append(run_with(one, numbers, surface__finish=finish, surface__seed=seed))
    text = follows(runs)
    assert "On the ground finish the ball is 6.0 dB louder than on the lapped" in text
    assert "three surfaces" in text


def test_runs_of_several_scenes_are_compared_by_their_names() -> None:
    sheet = run_with(read_scene(Path("steel-sheet")), computed(56.4))
    pit = run_with(read_scene(Path("ball-with-pit")), computed(18.0))
    assert follows([sheet, pit]).startswith("In steel-sheet the ball is 38 dB louder than in ball")
    fall = computed(
        record={"single_event": True},
        levels={"vibration": {"lae_db": 70.0}},
        motion={"drop_mm": 20.0},
    )
    marble = run_with(read_scene(Path("marble-dropped")), fall)
    assert "louder" not in follows([sheet, marble]) and "LAE" in follows([sheet, marble])


def test_the_gap_names_both_levels() -> None:
    assert gap([estimated()]).startswith("Released power is 56 dB above the estimated vibration")
    assert gap([estimated(record={"q": None})]) == ""


@pytest.mark.parametrize("name", BALLS)
def test_every_scene_of_the_library_has_a_sentence(name: str) -> None:
    runs = [RunFolder(run.values, run.scene, Path()) for run in read_scene(Path(name)).runs()]
    sentence = runs_sentence(runs)
    assert sentence.endswith(".") and "None" not in sentence and "  " not in sentence
    assert f"{2 * runs[0].scene.sphere.radius_mm:g} mm" in sentence


def test_a_pit_ticks_once_a_turn() -> None:
    turns = 0.25 / (2 * 3.14159 * 4e-3)
    assert round(turns) == 10
    assert "ten times a second" in special(read_scene(Path("ball-with-pit")), computed())


def test_what_nobody_hears_is_not_told() -> None:
    scene = read_scene(Path("vibrating-ball")).with_(load_n=20)
    rings = {"resonance_hz": 60e3, "resonance_q": 30.0}
    assert special(scene, computed(motion=rings)) == ""
    assert "10 kHz" in special(scene, computed(motion=rings | {"resonance_hz": 10e3}))
    high = bands({"1000": 5.0, "16000": 15.0})
    assert "12 kHz" in special(scene, computed(bands={"vibration_a": high}))
    low = bands({"1000": 15.0, "16000": 5.0})
    assert special(scene, computed(bands={"vibration_a": low})) == ""


def test_a_number_never_shows_without_how_it_was_found() -> None:
    numbers = estimated()
    for quantity in (numbers.vibration, numbers.released_power, computed().vibration):
        assert quantity.how in str(quantity)
