"""The film of a run: its place, its cost, and the energies of its maps."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import march_all
from scene_text import BODIES, NARROW

from rolling.check.error_cost import COLD_STEPS
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.in_si.physics_of_scene import bodies_of
from rolling.marches.march_piece import march_piece
from rolling.marches.marched_law import force_law
from rolling.marches.next_pieces import MIN_MAPS, film_stretch, loudest, next_pieces
from rolling.marches.result import Result
from rolling.scene.file import loads
from rolling.scene.scene import Scene

TEXT = f"""\
name: filmed
{BODIES}{NARROW}\
rolling: {{load_n: 0.3, speed_m_s: 0.1, duration_s: 0.008}}
numerics: {{tolerance: 1.0e-4}}
"""


@pytest.fixture(autouse=True)
def generous(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a run of 400 steps pay for a film."""
    monkeypatch.setattr("rolling.marches.next_pieces.SHARE", 0.3)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return loads(TEXT, [], "s.yaml")


@pytest.fixture(scope="module")
def solved(scene: Scene) -> Result:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rolling.marches.next_pieces.SHARE", 0.3)
        return march_all(scene, film=True)


def test_the_stretch_lies_around_the_loudest_event_and_costs_little(
    scene: Scene, solved: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    stretch = film_stretch(scene, solved)
    assert stretch is not None and stretch.step == 1
    assert stretch[-1] - stretch[0] + COLD_STEPS <= 0.3 * solved.solved_steps
    event = np.convolve(solved.series["release_energy"], np.ones(10), "valid").argmax() + 5
    assert event in stretch
    assert film_stretch(scene, Result.empty(scene)) is None
    monkeypatch.setattr("rolling.marches.next_pieces.SHARE", 0.05)  # too few of 400 steps
    assert film_stretch(scene, solved) is None


def test_the_loudest_place_is_the_middle_of_the_largest_mean() -> None:
    power = np.zeros(100)
    power[40:50] = 1.0
    power[70] = 2.0  # a single step
    assert loudest(power, 10) == 45


def test_maps_hold_the_release_and_the_load_of_the_run(solved: Result) -> None:
    """Releases have 16 bits and pressures 8, of the maximum over all cells and maps."""
    film = solved.slow_motion
    assert film is not None and len(film.positions) >= MIN_MAPS
    steps = solved.series["release_energy"][film.positions[0] : film.positions[-1]]
    released = film.release[1:].sum(axis=(1, 2)) * film.release_unit
    assert released == pytest.approx(steps, rel=0.02)
    load = film.pressure.sum(axis=(1, 2)) * film.pressure_unit * film.cell**2
    assert load == pytest.approx(np.full(len(load), 0.3), rel=0.02)
    # The run's own map of a position in the film has the same pressures at the same place.
    own = solved.maps[next(p for p in sorted(solved.maps) if p in film.positions)]
    k = own.position - film.first
    i, j = (
        round((a - b) / film.cell) for a, b in ((own.along, film.along), (own.across, film.across))
    )
    rows, columns = own.pressure.shape
    shown = film.pressure[k, i : i + rows, j : j + columns] * film.pressure_unit
    assert own.cell == pytest.approx(film.cell)
    assert np.abs(shown - own.pressure).max() < 0.02 * own.pressure.max()


def test_a_contact_that_cannot_be_solved_leaves_the_run_whole(scene: Scene, solved: Result) -> None:
    result = Result.empty(scene)
    result.series = solved.series
    (piece,) = next_pieces(scene, result, film=True)
    assert piece.kind == "film" and not next_pieces(scene, result)
    heavy = scene.with_(load_n=1e6)
    piece = next(iter(next_pieces(heavy, result, film=True)))
    result.add(piece, march_piece(piece))
    assert result.slow_motion is not None and not result.slow_motion.pressure.size
    assert not next_pieces(scene, result, film=True)


def test_a_vibration_is_filmed_where_its_force_departs_most() -> None:
    vibrating = loads(
        TEXT.replace("radius_mm: 5", "radius_mm: 5, density_kg_m3: 7850").replace(
            "hardness_gpa: 2.1", "density_kg_m3: 7850, thickness_mm: 10"
        )
        + "dynamics: {release: false}\nsound: {source: vibration}\n",
        ["rolling.speed_m_s=1", "rolling.duration_s=0.0008"],
        "s.yaml",
    )
    result = march_all(vibrating, film=True)
    motion = motion_of_ball(bodies_of(vibrating), vibrating.travel, force_law(vibrating, result))
    place = motion.position_m[np.argmax(np.abs(motion.force_n / vibrating.load - 1))]
    assert result.slow_motion is not None
    positions = result.slow_motion.positions * result.step
    assert positions[0] <= place <= positions[-1]
