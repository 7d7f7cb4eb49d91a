"""The stretches of the error estimate and their cost, as functions of the scene alone."""

import math

import numpy as np
import pytest
from scene_text import PLAIN

from rolling.check import cost, error_cost
from rolling.check.findings import check_scene
from rolling.scene.file import loads
from rolling.scene.scene import Scene


def scene(*overrides: str) -> Scene:
    return loads(PLAIN, ["rolling.duration_s=0.5", *overrides], "s.yaml")


def test_stretches_cost_no_more_than_their_share_of_the_run() -> None:
    for overrides in ([], ["numerics.tolerance=1e-6"], ["numerics.step_nodes=2"]):
        given = scene("numerics.error_estimate=true", *overrides)
        steps = error_cost.stretch_steps(given)
        layout = error_cost.layout(given, steps)
        cost = len(layout.firsts) * error_cost.stretch_cost(given, steps)
        assert len(layout.firsts) >= error_cost.FIRST_STRETCHES
        assert 0.6 * error_cost.SHARE < cost / given.track.solved_steps <= error_cost.SHARE
        assert error_cost.cost_share(given) == pytest.approx(cost / given.track.solved_steps)


def test_stretches_lie_on_the_track_without_overlap_and_all_along_it() -> None:
    given = scene("rolling.duration_s=4")
    layout = error_cost.layout(given, error_cost.stretch_steps(given))
    firsts = np.sort(layout.firsts)
    solved = given.track.solved_steps
    assert np.diff(firsts).min() >= layout.steps
    assert firsts[-1] + layout.steps <= solved
    for count in (4, 8):
        quarters = np.array(layout.firsts[:count]) * 4 // solved
        assert np.bincount(quarters, minlength=4).tolist() == [count / 4] * 4


def test_a_longer_round_begins_with_the_shorter() -> None:
    given = scene("rolling.duration_s=4")
    shorter = error_cost.layout(given, 200).firsts
    assert error_cost.layout(given, 200).firsts[:4] == shorter[:4]
    assert len(set(shorter)) == len(shorter)


def test_a_stretch_resolves_1_khz_where_the_cost_allows_it() -> None:
    long = scene("rolling.duration_s=5", "rolling.speed_m_s=0.05")
    lines = long.motion.speed(0.0) / (long.step * error_cost.stretch_steps(long))
    assert lines == pytest.approx(231 / 2, rel=0.02)
    least, most = error_cost.STRETCH_STEPS
    assert error_cost.stretch_steps(scene("rolling.duration_s=5")) == most
    assert least <= error_cost.stretch_steps(scene("rolling.duration_s=0.2")) < 100


def test_a_short_track_says_how_long_it_has_to_be() -> None:
    short = scene("rolling.duration_s=0.05")
    assert error_cost.stretch_steps(short) == 0
    text = error_cost.too_short(short) or ""
    assert "2500 different steps" in text
    needed = int(text.split("needs ")[1].split()[0])
    assert error_cost.stretch_steps(scene(f"rolling.duration_s={(needed + 1) * 2e-5}"))
    assert not error_cost.stretch_steps(scene(f"rolling.duration_s={(needed - 1) * 2e-5}"))
    assert error_cost.too_short(scene()) is None


def test_the_tight_tolerance_stays_above_rounding() -> None:
    assert error_cost.tight_tolerance(scene()) == pytest.approx(1e-5)
    assert error_cost.tight_tolerance(scene("numerics.tolerance=3e-10")) == 1e-10
    assert error_cost.tight_tolerance(scene("numerics.tolerance=1e-11")) == 1e-11


def test_no_estimate_costs_nothing() -> None:
    assert error_cost.cost_share(scene()) == 0.0
    assert error_cost.cost_share(scene("numerics.error_estimate=true")) > 0.0


def test_the_check_expects_the_time_of_the_estimate_by_the_laws_of_a_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The stretches stay where the laws are measured anew, and their expected time follows."""
    given = scene("numerics.error_estimate=true", "surface.width_um=256")

    def seconds() -> tuple[str, float, float]:
        found = {each.key: each for each in check_scene(given, False).runs[0].findings}
        estimate, run = found["error_estimate"], found["expected_time"]
        assert estimate.seconds and run.seconds
        return estimate.value.split(",")[0], estimate.seconds, run.seconds

    law = cost.step_law(given, cost.roughness(given)[0])
    stretches, before, of_run = seconds()
    at_100, power = cost.STEP_LAWS[law]
    steps = error_cost.stretch_steps(given)
    levels = 4 ** (power / 2), 4 ** (-power / 2)
    tighter = math.log(error_cost.tight_tolerance(given)) / math.log(given.tolerance)
    of_stretch = (steps + error_cost.START_STEPS) * (tighter * (1 + levels[0]) + levels[1])
    count = len(error_cost.layout(given, steps).firsts)
    assert before == pytest.approx(count * of_stretch * of_run / given.track.steps)
    monkeypatch.setitem(cost.STEP_LAWS, law, (at_100, power + 1))
    again, after, of_run_after = seconds()
    assert again == stretches and after / of_run_after > 1.5 * before / of_run
