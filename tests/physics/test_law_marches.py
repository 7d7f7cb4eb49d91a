"""Marches at other loads and under the moving load: their loads, faults and agreement."""

from __future__ import annotations

from itertools import permutations
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import march_all

from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.in_si.physics_of_scene import bodies_of
from rolling.marches import marched_law as laws
from rolling.marches.march_piece import march_piece
from rolling.marches.marched_law import force_law, law_error, law_loads, law_pieces, load_along
from rolling.marches.next_pieces import next_pieces
from rolling.marches.piece import Piece
from rolling.marches.result import LoadMarches, MovingRelease, Result
from rolling.scene.file import loads
from rolling.scene.scene import Scene

TEXT = """\
name: vibrating
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10,
  loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.02, correlation_length_um: 10, spacing_um: 2,
  width_um: 160, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.6, distance_mm: 0.4}
dynamics: {release: true}
sound: {source: vibration}
"""
ROUGHER = ("surface.roughness_ra_um=0.05", "rolling.speed_m_s=0.3", "rolling.distance_mm=0.2")
FASTER = "rolling.speed_m_s=[[0, 0.5], [4e-4, 0.8]]"


def scene(*overrides: str) -> Scene:
    return loads(TEXT, overrides, "s.yaml")


@pytest.fixture(scope="module")
def solved() -> Result:
    return march_all(scene())


@pytest.mark.law("Vibration: a march under the moving load has the approach of the motion.")
def test_release_under_the_moving_load(solved: Result) -> None:
    moving = solved.moving
    assert moving is not None and not moving.failure
    # The load moves by a tenth and more, and the approach with it.
    assert moving.force.min() < 0.9 < 1.1 < moving.force.max()
    fluctuation = np.std(moving.approach)
    assert fluctuation > 1.2 * np.std(solved.series["approach"])
    # The law interpolates between loads: its error is a few percent of the fluctuation.
    assert moving.law_error < 0.03 * fluctuation
    # Over a lap the surface takes up what it gives back.
    loading, release = (moving.steps[f"{kind}_energy"].sum() for kind in ("loading", "release"))
    assert loading == pytest.approx(release, rel=1e-3)
    assert moving.repeats


def test_loads_are_added_until_the_force_lies_inside() -> None:
    given = scene(*ROUGHER, "dynamics.span=1.05", "dynamics.release=false")
    result = march_all(given)
    needed = law_loads(given, result)
    assert len(needed.marched) > 3 and not needed.lacking
    force = motion_of_ball(bodies_of(given), given.travel, force_law(given, result)).force_n
    assert needed.marched[0] <= force.min() < force.max() <= needed.marched[-1]
    assert result.load_marches is not None
    assert len(result.load_marches.judging) == len(needed.marched) - 1
    error = law_error(given, result, needed.marched)
    # Neighbouring loads of 1.05 differ little, so the law between them is off by less than 1 %.
    assert error is not None and 0 < error.newtons < 1e-2 and error.decibels < 1


def test_pieces_of_loads_may_come_in_any_order(solved: Result) -> None:
    """The batches of loads are the same when pieces are asked for after each of them."""
    given = scene()
    result = Result.empty(given)
    while pieces := next_pieces(given, result):
        result.add(pieces[-1], march_piece(pieces[-1]))
    assert result.load_marches is not None and solved.load_marches is not None
    assert result.load_marches.approach.keys() == solved.load_marches.approach.keys()
    assert result.load_marches.judging.keys() == solved.load_marches.judging.keys()
    for load, approach in solved.load_marches.approach.items():
        assert np.array_equal(result.load_marches.approach[load], approach)
    assert result.moving is not None and solved.moving is not None
    for name, series in solved.moving.steps.items():
        assert np.array_equal(result.moving.steps[name], series)


def test_another_speed_takes_one_more_march_and_the_same_law(solved: Result) -> None:
    slower = scene("rolling.speed_m_s=0.5")
    kept = solved.load_marches
    moving = solved.moving
    result = Result.empty(slower)
    assert result.identity == solved.identity
    result.series = solved.series
    result.load_marches = kept
    result.moving = moving
    assert {piece.kind for piece in next_pieces(slower, result)} == {"moving"}
    assert result.moving is not None and moving is not None
    assert not np.allclose(result.moving.force, moving.force, atol=1e-3)


def test_a_sphere_that_gets_faster_passes_each_place_under_one_load() -> None:
    given = scene(FASTER, "rolling.distance_mm=0.25")
    result = march_all(given)
    moving = result.moving
    assert moving is not None and not moving.repeats and not moving.failure
    assert moving.law_error < 0.05 * np.std(moving.approach)
    motion = motion_of_ball(bodies_of(given), given.travel, force_law(given, result))
    positions = np.arange(1, len(moving.force) - 1) * result.step
    between = np.interp(positions, motion.position_m, motion.force_n)
    assert np.allclose(moving.force[1:-1], between, rtol=0, atol=0.01)


@pytest.mark.parametrize("samples", [0, 1, 5])
@pytest.mark.parametrize("speed", ["rolling.speed_m_s=0.6", FASTER])
def test_a_sphere_that_stays_has_the_constant_load(
    samples: int, speed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A spline needs two positions; a sphere at rest, or faster than its motion, has fewer."""
    given = scene(speed, "rolling.distance_mm=0.25")
    still = SimpleNamespace(
        settled=True,
        flight_share=0.0,
        force_n=np.full(samples, 1.0),
        approach_m=np.full(max(samples, 1), 2e-7),
        position_m=np.zeros(samples),
    )
    monkeypatch.setattr(laws, "law_motion", lambda *_: still)
    moving = load_along(given, Result.empty(given))
    assert not moving.failure and moving.repeats
    assert np.all(moving.force == given.load) and np.all(moving.motion_approach == 2e-7)


def test_a_sphere_that_flies_has_no_release_under_the_moving_load() -> None:
    result = march_all(scene("surface.roughness_ra_um=0.2", "rolling.speed_m_s=1"))
    assert result.moving is not None and "loses contact" in result.moving.failure
    assert not result.moving.missing()


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_the_fault_of_a_load_is_that_of_its_first_piece(order: tuple[int, ...]) -> None:
    """Failed pieces may come in any order, after which the load is settled and dropped."""
    given = scene()
    steps = 600
    arrays = [
        {"approach": np.ones(201), "step_time": np.ones(200)},
        {"fault": np.array("second")},
        {"fault": np.array("third")},
    ]
    marches = LoadMarches(steps)
    moving = MovingRelease("", np.ones(601), np.ones(601))
    for number in order:
        assert marches.missing(2.0) and not marches.failure and not moving.failure
        first = 200 * number
        last = 200 * number + 200
        piece = Piece(given, "", "load", first, last, load=2.0)
        marches.add(piece, arrays[number])
        series = dict.fromkeys(("release_energy", "loading_energy", "energy_defect"), np.ones(200))
        moving.add(piece, arrays[number] | ({} if number else series))
    assert not marches.missing(2.0) and 2.0 not in marches.approach
    assert marches.failure == "2 N: second" and moving.failure == "second"


@pytest.mark.parametrize("failed", [[0], [0, 1]])
def test_a_run_goes_on_without_loads_that_cannot_be_marched(
    solved: Result, failed: list[int]
) -> None:
    """Hertz's approach stands in for loads beside the scene's; the force counts as outside."""
    given = scene()
    assert solved.load_marches is not None
    marches = LoadMarches(solved.solved_steps, dict(solved.load_marches.approach))
    for load in [min(marches.approach), max(marches.approach)][slice(0, len(failed))]:
        del marches.approach[load]
        marches.failures[load] = "no room"
    result = Result.empty(given)
    result.series = solved.series
    result.load_marches = marches
    marched = law_loads(given, result).marched
    assert len(marched) == 3 - len(failed) and given.load in marched
    whole, law = (force_law(given, of) for of in (solved, result))
    position = np.asarray(law.position_m)
    approach = whole.approach(position, 1.2)
    # A rough contact is softer than Hertz's, by a tenth here.
    assert law.force(position, approach).mean() == pytest.approx(1.2, rel=0.03)
    assert law.outside([0.5, 0.0, 1.2, 1.0]) >= 0.25


def test_no_load_follows_beyond_a_failed_one(solved: Result) -> None:
    """A narrow span reaches the force in batches; no load is asked for beyond a fault."""
    given = scene(*ROUGHER, "dynamics.span=1.05", "dynamics.release=false")
    result = Result.empty(given)
    failing = ""
    while pieces := next_pieces(given, result):
        batch = {piece.load for piece in pieces if piece.kind == "load"}
        failing = max(batch) if batch and result.is_complete and not failing else failing
        for piece in pieces:
            arrays = march_piece(piece) if piece.load != failing else {"fault": np.array("no")}
            result.add(piece, arrays)
    assert failing and result.load_marches is not None
    assert list(result.load_marches.failures) == [failing]
    assert max(law_loads(given, result).marched) < failing
    assert not law_pieces(given, result)
