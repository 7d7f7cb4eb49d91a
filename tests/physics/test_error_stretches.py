"""Stretches of the error estimate: their places, their cost, and the errors that they tell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from finished import doubt_lines, run_of
from hard_cases.gaussian_heights import gaussian
from helpers import march_all
from scene_text import BODIES, NARROW, PLAIN

from rolling.check import error_cost
from rolling.check.error_cost import LEVELS
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.scene_surface import has_detail, heights
from rolling.kinds.reading import read_scene
from rolling.marches import error_stretches
from rolling.marches.march_piece import march_piece
from rolling.marches.next_pieces import next_pieces
from rolling.marches.piece import Piece, contact_identity
from rolling.marches.result import Result
from rolling.results import run_lines
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.error_estimate import (
    LevelErrors,
    RecordLevels,
    detail_errors,
    level_errors,
)
from rolling.surface.refined import dies_out

TEXT = f"""\
name: short
{BODIES}{NARROW}\
rolling: {{load_n: 0.1, speed_m_s: 0.1, duration_s: 0.012}}
numerics: {{error_estimate: true, tolerance: 1.0e-4}}
"""
FLAT = RecordLevels(np.ones(31), np.ones(31), own_factor=False)


@pytest.fixture
def generous(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let short runs pay for stretches."""
    monkeypatch.setattr(error_cost, "SHARE", 8.0)
    monkeypatch.setattr(error_cost, "MIN_STEPS", 32)
    monkeypatch.setattr(error_cost, "MAX_STEPS", 64)


def scene_of(*overrides: str) -> Scene:
    return loads(TEXT, overrides, "s.yaml")


def long_scene(*overrides: str) -> Scene:
    settings = ["rolling.duration_s=0.5", "numerics.error_estimate=true", "numerics.tolerance=1e-4"]
    return loads(PLAIN, [*settings, *overrides], "s.yaml")


def stretch(scene: Scene, level: str, first: int, steps: int = 64) -> dict:
    """March a stretch on a level."""
    identity = contact_identity(scene)
    return march_piece(Piece(scene, identity, "error", first, first + steps, level=level))


def errors_of(scene: Scene, result: Result) -> LevelErrors:
    return level_errors(error_stretches.stretch_powers(scene, result), FLAT)


# ---- places and cost


@pytest.mark.parametrize("change", ["rolling.load_n=20", "numerics.tolerance=1e-6"])
@pytest.mark.parametrize("seconds", [0.2, 5.0])
def test_stretches_cost_no_more_than_their_share_of_the_run(change: str, seconds: float) -> None:
    given = long_scene(change, f"rolling.duration_s={seconds}")
    layout = error_cost.layout(given)
    assert layout is not None
    steps = len(layout.firsts) * (layout.steps + error_cost.COLD_STEPS)
    cost = steps * sum(error_cost.level_cost(given, level) for level in LEVELS)
    assert error_cost.cost_share(given) == pytest.approx(cost / given.track.solved_steps)
    assert error_cost.cost_share(given) <= error_cost.SHARE
    assert 4 <= len(layout.firsts) <= 8 and 64 <= layout.steps <= 400
    # More than four stretches are marched only when they are as long as they may be.
    assert len(layout.firsts) == 4 or layout.steps == 400


def test_stretches_lie_all_along_the_track_without_overlap() -> None:
    for seconds, count in ((0.5, 4), (4, 8)):
        given = long_scene(f"rolling.duration_s={seconds}")
        layout = error_cost.layout(given)
        solved = given.track.solved_steps
        assert layout is not None and len(layout.firsts) == count
        assert np.diff(layout.firsts).min() >= layout.steps
        assert layout.firsts[-1] + layout.steps <= solved
        gaps = np.diff([*layout.firsts, solved])
        assert gaps == pytest.approx(np.full(count, solved / count), abs=layout.steps)


def test_a_short_track_has_the_shortest_stretches() -> None:
    """They cost more than their share of a run that takes a few seconds, and few seconds more."""
    longest = long_scene("rolling.duration_s=0.05")
    for steps in (2500, 256):
        layout = error_cost.layout(long_scene(f"rolling.duration_s={steps * 2e-5}"))
        assert layout is not None and layout.steps == 64 and len(layout.firsts) == 4
        assert layout.firsts[-1] + 64 <= steps
    assert error_cost.cost_share(longest) > error_cost.SHARE
    assert error_cost.too_short(longest) is None
    few = long_scene("rolling.duration_s=0.0051")
    assert error_cost.layout(few) is None and error_cost.cost_share(few) == 0.0
    assert (
        error_cost.too_short(few) == "the track has 255 different steps, and the estimate needs 256"
    )


def test_a_short_track_with_long_steps_says_how_long_it_has_to_be() -> None:
    """On 1,000 nodes a side a step takes a quarter of a second."""
    wide = ["surface.spacing_um=0.5", "surface.width_um=512", "rolling.load_n=100"]
    per_step = 0.5e-6 / 0.1
    short = long_scene(*wide, f"rolling.duration_s={2500 * per_step}")
    text = error_cost.too_short(short) or ""
    assert error_cost.layout(short) is None and "2500 different steps" in text
    assert "more than 20 s" in text
    needed = int(text.split("steps, and ")[1].split()[0])
    seconds = [(needed + more) * per_step for more in (1, -1)]
    layouts = [error_cost.layout(long_scene(*wide, f"rolling.duration_s={x}")) for x in seconds]
    assert layouts[0] is not None and layouts[1] is None


@pytest.mark.parametrize(("own", "tight"), [(1e-4, 1e-5), (3e-10, 1e-10), (1e-11, 1e-11)])
def test_the_tight_tolerance_stays_above_rounding(own: float, tight: float) -> None:
    scene = long_scene(f"numerics.tolerance={own}")
    assert error_cost.tight_tolerance(scene) == pytest.approx(tight)


# ---- marches


def test_a_measured_error_of_the_grid_stands_for_a_rule() -> None:
    """Few nodes across the Hertz radius are doubtful; the estimate measures what they leave."""
    measured = scene_of("rolling.load_n=0.01", "rolling.duration_s=0.006")
    by_rule = measured.with_({"numerics.error_estimate": False})
    of_rule = run_of(by_rule)
    run = run_of(measured)
    assert "hertz_nodes" in doubt_lines(of_rule) and "hertz_nodes" not in doubt_lines(run)
    assert run.numbers.errors.grid_db is not None


def test_a_surface_of_few_correlation_lengths_continues_between_its_nodes() -> None:
    """The edge of its period leaves a tail of 1 %; flat cells made the error 18 dB larger there."""
    narrow = scene_of("surface.correlation_length_um=30")
    assert not dies_out(heights(narrow)) and rolling_contact(narrow).slopes
    assert not rolling_contact(scene_of("surface.autocorrelation=exponential")).slopes


@pytest.mark.parametrize(("nodes", "ends"), [(1, False), (2, False), (8, True)])
def test_a_gaussian_law_ends_before_its_grid_unless_it_is_short(nodes: int, ends: bool) -> None:
    """Waves have exp(-(k L)^2 / 8) of the longest: 0.06 at L of two nodes and 3/4 of Nyquist."""
    short = scene_of(f"surface.correlation_length_um={nodes * 1e6 * scene_of().spacing}")
    assert has_detail(short) != ends
    assert rolling_contact(short).slopes == ends


def test_stretches_are_marched_over_the_positions_of_the_run() -> None:
    """At the scene's own grid a stretch releases the energy of the run, but for the tolerance."""
    scene = scene_of()
    lap = march_all(scene_of("numerics.error_estimate=false")).series["release_energy"]
    for first in (0, 30):
        release = stretch(scene, "tight", first)["release_energy"]
        off = release - lap[first : first + 64]
        assert np.sqrt(np.mean(off**2)) < 0.01 * np.std(release)


@pytest.mark.parametrize("level", ["fine", "coarse"])
def test_other_grids_see_the_same_asperities(level: str) -> None:
    """An elastic contact at Ra 0.02 um converges: releases on two grids are nearly equal."""
    scene = scene_of("surface.roughness_ra_um=0.02", "plate.hardness_gpa=null")
    releases = [stretch(scene, each, 590)["release_energy"] for each in ("tight", level)]
    assert np.corrcoef(releases)[0, 1] > 0.97  # across the end of the track


@pytest.mark.usefixtures("generous")
def test_a_run_knows_its_errors() -> None:
    scene = scene_of()
    result = march_all(scene)
    layout = error_cost.layout(scene)
    assert result.stretches is not None and layout is not None
    assert set(result.stretches.marches) == {(k, level) for k in layout.firsts for level in LEVELS}
    errors = errors_of(scene, result)
    assert 0.5 <= errors.order <= 1.5 and errors.order_measured
    # The grid is off by more than the solver, and neither by as much as the signal.
    assert -100 < errors.solver_signal_db < errors.grid_signal_db < 0
    assert abs(errors.grid_db[-1]) < 3
    areas = [error_stretches.plastic_areas(scene, result, level) for level in ("tight", "fine")]
    assert areas[0].mean() == pytest.approx(areas[1].mean(), rel=0.3)
    assert error_stretches.detail_powers(scene, result) is None  # the Gaussian law ends before
    # The same lines stand an octave lower at half the speed.
    half = scene.with_(speed_m_s=0.05, duration_s=0.024)
    slower = errors_of(half, replace(result, identity=contact_identity(half)))
    k = {name: 17 + 3 * n for n, name in enumerate(("1k", "2k", "4k", "8k", "16k"))}
    assert slower.grid_db[k["8k"]] == pytest.approx(errors.grid_db[k["16k"]], abs=0.5)
    assert np.isnan(slower.grid_db[k["16k"]])


@pytest.mark.usefixtures("generous")
def test_four_stretches_have_the_detail_of_an_exponential_law() -> None:
    """Without the detail below 2 um an exponential surface is too loud at 16 kHz."""
    scene = scene_of("surface.autocorrelation=exponential", "surface.roughness_ra_um=0.03")
    run = run_of(scene)
    result = run.result
    numbers = run.numbers
    layout = error_cost.layout(scene)
    assert numbers.released_power.parts["subgrid"] > abs(numbers.errors.subgrid_db)
    assert "from missing detail below the spacing" in run_lines.error_line("run", numbers)
    assert result.stretches is not None and layout is not None
    detailed = [first for first, level in result.stretches.marches if level == error_cost.DETAIL]
    assert detailed == list(layout.firsts[:: len(layout.firsts) // 4][:4])
    powers = error_stretches.detail_powers(scene, result)
    assert powers is not None
    errors = detail_errors(powers, FLAT)
    assert errors[0, 29] > 3.0 and abs(errors[0, 20]) < 2.0
    assert 0.0 < errors[1, -1] < 3.0
    assert error_cost.cost_share(scene) > error_cost.cost_share(scene_of()) > 0


@pytest.mark.usefixtures("generous")
def test_a_stretch_that_cannot_be_solved_is_a_failure_of_the_estimate() -> None:
    scene = scene_of()
    result = march_all(scene_of("numerics.error_estimate=false"))
    pieces = next_pieces(scene, result)
    for piece in reversed(pieces):
        failure = {"fault": np.array("no room")}
        failing = piece.level == "fine" and piece.first > 0
        result.add(piece, failure if failing else stretch(scene, piece.level, piece.first, 64))
    assert not next_pieces(scene, result)
    assert result.stretches is not None and result.stretches.failure == "fine: no room"
    assert error_stretches.stretch_firsts(scene, result) == ()


@pytest.mark.usefixtures("generous")
@pytest.mark.parametrize(
    "changes",
    [
        {"surface": {"kind": "smooth", "spacing_um": 2, "width_um": 128}},
        {"numerics.error_estimate": False},
    ],
)
def test_runs_without_an_estimate_march_no_stretches(changes: dict) -> None:
    assert march_all(scene_of().with_(changes)).stretches is None


@pytest.mark.usefixtures("generous")
def test_laps_of_a_height_file_at_changing_speed_have_an_estimate(tmp_path: Path) -> None:
    z = gaussian((301, 65), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 4)
    np.save(tmp_path / "heights.npy", z)
    (tmp_path / "scene.yaml").write_text(
        f"name: file\n{BODIES}"
        "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
        "rolling: {load_n: 0.1, speed_m_s: [[0, 0.05], [0.02, 0.15]], duration_s: 0.02,"
        " start_um: 30}\n"
        "numerics: {error_estimate: true, tolerance: 1.0e-4}\n"
    )
    scene = read_scene(tmp_path / "scene.yaml")
    assert scene.track.solved_steps == 301 and scene.track.steps > 900
    run = run_of(scene)
    numbers = run.numbers
    assert abs(numbers.errors.grid_db) < 3 and -60 < numbers.errors.grid_signal_db < 0
    assert "nothing is known of the surface below its spacing" in doubt_lines(run)["unknown_detail"]
    assert numbers.errors.subgrid_db is None
    assert 0 < numbers.errors.plastic_ratio_grid_uncertainty < 1


@pytest.mark.usefixtures("generous")
def test_a_faster_ball_hears_less_of_the_grid() -> None:
    """The short waves are the grid's, and a chain of sphere and contact filters them."""
    scene = loads(
        TEXT.replace("radius_mm: 5", "radius_mm: 5, density_kg_m3: 7850")
        .replace("hardness_gpa: 2.1", "density_kg_m3: 7850, thickness_mm: 10")
        .replace("roughness_ra_um: 0.1", "roughness_ra_um: 0.05")
        .replace("load_n: 0.1", "load_n: 0.5")
        + "dynamics: {release: false}\nsound: {source: vibration}\n",
        ["rolling.duration_s=0.008", "numerics.step_nodes=1"],
        "s.yaml",
    )
    result = march_all(scene)
    faster = scene.with_(speed_m_s=0.3, duration_s=0.008 / 3)
    assert contact_identity(faster) == result.identity
    errors = errors_of(scene, result)
    of_faster = errors_of(faster, result)
    assert of_faster.grid_db[-1] != errors.grid_db[-1]
    assert of_faster.grid_signal_db < errors.grid_signal_db
