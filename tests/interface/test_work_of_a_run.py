"""Page of a run: what more work would buy by its own numbers, and what it left out."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import pytest
from bearing_runs import turning
from report_runs import runs_of

from rolling.bearing_kind import bearing_work
from rolling.numbers.doubt import sized
from rolling.numbers.quantity import Quantity, joined
from rolling.report import ball_work
from rolling.report.ball_work import leading, more_work
from rolling.report.report_page import page
from rolling.results.run_result import Run

PARTS = {"record": 1.0, "grid": 0.4, "chain": 0.3}


def stating(run: Run, parts: dict[str, float], order: float | None = None, **changes: Any) -> Run:
    """Return a run whose vibration has some parts of ±, and an order of convergence."""
    vibration = replace(
        run.numbers.vibration, value=30.0, uncertainty=joined(parts), parts=parts, **changes
    )
    errors = replace(run.numbers.errors, order=order)
    return replace(run, numbers=replace(run.numbers, vibration=vibration, errors=errors))


def test_ten_times_the_steps_lower_the_part_of_the_record_by_the_root_of_ten() -> None:
    (lap,) = runs_of("lap")
    steps, _ = more_work(stating(lap, PARTS))
    assert steps.new_part_db == pytest.approx(1 / math.sqrt(10))
    assert steps.uncertainty_db == pytest.approx(math.sqrt(1 + 0.16 + 0.09))
    assert steps.new_uncertainty_db == pytest.approx(math.sqrt(0.1 + 0.16 + 0.09))
    spent = lap.numbers.effort.march_cpu_s
    assert spent and steps.seconds == pytest.approx(spent)
    assert steps.new_seconds == pytest.approx(10 * spent)
    assert "from 1 to 0.32 dB, and ± of the vibration from 1.2 to 0.6 dB" in steps.sentence


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_half_the_spacing_lowers_the_part_of_the_grid_by_the_order(order: float) -> None:
    (lap,) = runs_of("lap")
    _, finer = more_work(stating(lap, PARTS, order=order))
    assert finer.new_part_db == pytest.approx(0.4 * 2**-order)
    assert finer.new_seconds is None  # the heights are a file's, whose points are what they are
    assert "processor time" not in finer.sentence


def test_half_the_spacing_of_a_made_surface_costs_what_the_forecast_says() -> None:
    """Twice the steps, each on four times the nodes: the power of a step is 1.45 to 2.3."""
    (run,) = runs_of("beside")
    _, finer = more_work(run)
    assert finer.seconds and finer.new_seconds
    assert 2 * 2**1.4 < finer.new_seconds / finer.seconds < 2 * 2**2.6


def test_an_error_of_the_grid_by_a_rule_stands_beside_the_uncertainty() -> None:
    (lap,) = runs_of("lap")
    doubt = sized("grid", "the grid may leave 0.8 dB, by a rule", 0.8)
    _, finer = more_work(stating(lap, {"record": 1.0}, doubts=(doubt,)))
    assert (finer.part_db, finer.new_part_db, finer.new_uncertainty_db) == (0.8, 0.4, None)
    assert "±" not in finer.sentence


def test_a_gain_that_is_not_known_has_its_reason() -> None:
    (fall,) = runs_of("falling")
    steps, _ = more_work(fall)
    assert steps.new_part_db is None and "the record is one event" in steps.sentence
    (lap,) = runs_of("lap")
    for work in more_work(stating(lap, {"chain": 0.3})):
        assert work.part_db is None and "would buy no decibel that is known" in work.sentence


def test_the_number_that_leads_is_the_one_with_an_uncertainty() -> None:
    (lap,) = runs_of("lap")
    assert leading(lap) is lap.numbers.vibration
    unknown = Quantity("vibration", 30.0, unit="dB(A)")
    numbers = replace(lap.numbers, vibration=unknown)
    assert leading(replace(lap, numbers=numbers)) is numbers.released_power


def whats(run: Run) -> set[str]:
    """Return what a run left out."""
    return {omission.what for omission in ball_work.omissions(run)}


def test_a_run_names_what_its_scene_did_not_need() -> None:
    (still,) = runs_of("lap")
    (edged,) = runs_of("edged")
    moving = runs_of("flying")[0]
    assert "Masses and motion" in whats(still) and "Masses and motion" not in whats(moving)
    assert "Modes of the plate" in whats(moving)
    assert "Modes of the plate above 30 kHz" in whats(edged)
    assert "Yielding" in whats(moving) and "Yielding" not in whats(still)
    assert "Marks that the ball leaves" in whats(still)
    (marked,) = runs_of("memory")
    assert "Marks that the ball leaves" not in whats(marked)
    longer = replace(still.numbers, effort=replace(still.numbers.effort, step_nodes=4.0))
    assert "Positions between the steps" in whats(replace(still, numbers=longer))
    assert "Positions between the steps" not in whats(still)


def test_the_nodes_that_are_left_out_are_those_of_the_run() -> None:
    (run,) = runs_of("lap")
    (text,) = (
        omission.reason
        for omission in ball_work.omissions(run)
        if omission.what.startswith("Nodes")
    )
    nodes, touching = (int(number.replace(",", "")) for number in re.findall(r"[\d,]+\d", text))
    assert nodes == run.scene.track.n_along * run.scene.track.n_across
    assert touching == pytest.approx(
        run.numbers.contact.area_mean_m2 / run.scene.spacing**2, abs=0.5
    )


def test_both_lists_are_folded_below_the_doubts_and_out_of_the_first_view() -> None:
    (run,) = runs_of("lap")
    content = page([run]).decode()
    doubts = content.index('id="doubts"')
    again = content.index('id="again"')
    for place, title in (("more-work", "What more work would buy"), ("left-out", "What was left")):
        begin = content.index(f'<details class="fold" id="{place}">')
        assert doubts < begin < again and title in content[begin : begin + 200]
    assert f"No run computes {ball_work.NEVER}." in content


def test_a_bearing_gains_by_longer_tracks_what_its_window_leaves_uncertain() -> None:
    """The most uncertain band leads; a bearing without a part for the window says so."""
    run = turning()
    radial = run.numbers.below_bending.radial
    parts = {"window": 0.9, "record": 0.3}
    medium = replace(radial.medium, uncertainty=joined(parts), parts=parts)
    below = replace(run.numbers.below_bending, radial=replace(radial, medium=medium))
    uncertain = replace(run, numbers=replace(run.numbers, below_bending=below))
    longer, finer = bearing_work.more_work(uncertain)
    assert longer.number == finer.number == "radial medium band"
    assert longer.new_part_db == pytest.approx(0.9 / math.sqrt(10))
    assert longer.new_uncertainty_db == pytest.approx(math.hypot(0.9 / math.sqrt(10), 0.3))
    assert "has no part for the stretch of track" in bearing_work.more_work(run)[0].reason
    assert "has no part for the grid" in finer.reason


def test_a_bearing_names_what_its_scene_did_not_need() -> None:
    run = turning()
    left = {omission.what for omission in bearing_work.omissions(run)}
    assert "A housing and its sound" in left and "Inertia of the balls" in left
    moved = run.scene.with_({"bearing.ball_inertia": True})
    again = {omission.what for omission in bearing_work.omissions(replace(run, scene=moved))}
    assert left - again == {"Inertia of the balls"}
    content = page([run]).decode()
    assert f"No run computes {bearing_work.NEVER}." in content
