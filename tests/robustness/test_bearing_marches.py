"""Marches of bearings: equal contacts are shared, and a stopped command goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import rolling
from rolling.archive.definition import Arrays
from rolling.bearing.static_load import LoadedRing
from rolling.bearing_kind.contact_marches import march_contacts
from rolling.bearing_kind.contact_plan import ContactPlan, plan_contacts
from rolling.bearing_kind.joined_tracks import bearing_tracks
from rolling.bearing_kind.rough_contacts import contact_loads
from rolling.kinds.reading import read_scene
from rolling.marches.piece import Piece, contact_identity
from rolling.run import executor, march_files, worker
from rolling.run.march_files import CONTACTS, Marches
from rolling.scene.surfaces import GaussianBall
from tests.support.bearings import bearing

BODY: dict[str, float | str] = {"youngs_modulus_gpa": 210.0, "poissons_ratio": 0.3}
ROUGH = GaussianBall(roughness_ra_um=0.01, correlation_length_um=40, seed=1)


def small_plan(seed_of_ring: int = 2, balls: GaussianBall | None = ROUGH) -> ContactPlan:
    """Return the contacts of a bearing under a small load on a coarse grid."""
    return plan_contacts(
        bearing(),
        {"balls": balls, "inner": ROUGH.model_copy(update={"seed": seed_of_ring}), "outer": None},
        contact_loads(bearing(), LoadedRing(axial_load_n=10.0, radial_load_n=0.0)),
        speed_m_s=1.5,
        body=BODY,
        numerics=rolling.BearingNumerics(window_mm=1.5, spacing_um=8),
    )


@pytest.fixture
def marched_pieces(monkeypatch: pytest.MonkeyPatch) -> list[Piece]:
    """Return a list of the pieces that are marched from now on."""
    marched: list[Piece] = []
    solve = worker.solve_piece

    def counted(piece: Piece, pieces: Path | None) -> Arrays:
        stored = pieces is not None and worker.read_piece(pieces, piece)
        if not stored:
            marched.append(piece)
        return solve(piece, pieces)

    monkeypatch.setattr(executor, "solve_piece", counted)
    return marched


def contacts_of(plan: ContactPlan) -> list[rolling.Scene]:
    return [scene for stage in plan.stages for scene in stage]


def marched_into(folder: Path, plan: ContactPlan) -> Marches:
    """March the contacts of a plan into a folder."""
    return march_contacts(contacts_of(plan), name="a", folder=folder, workers=1, shown=False)


def test_equal_contacts_are_marched_once(marched_pieces: list[Piece]) -> None:
    """Two bearings that differ in the seed of one raceway share the contacts of their balls."""
    plans = [small_plan(2), small_plan(3), small_plan(2)]
    contacts = [scene for plan in plans for scene in contacts_of(plan)]
    marches = march_contacts(contacts, name="sweep", workers=1, shown=False)
    assert len(marches) == 12  # four contacts at three loads
    assert len({(piece.identity, piece.key) for piece in marched_pieces}) == len(marched_pieces)
    assert len({piece.identity for piece in marched_pieces}) == 12


def test_a_stopped_command_goes_on_with_its_pieces(
    tmp_path: Path, marched_pieces: list[Piece], monkeypatch: pytest.MonkeyPatch
) -> None:
    plan = small_plan(balls=None)
    whole = march_contacts(contacts_of(plan), name="whole", workers=1, shown=False)
    count = len(marched_pieces)
    marched_pieces.clear()
    counted = executor.solve_piece
    stop_at = 2

    def stopped(piece: Piece, pieces: Path | None) -> Arrays:
        if len(marched_pieces) == stop_at:
            raise KeyboardInterrupt
        return counted(piece, pieces)

    with monkeypatch.context() as patch:
        patch.setattr(executor, "solve_piece", stopped)
        with pytest.raises(KeyboardInterrupt):
            marched_into(tmp_path, plan)
    again = marched_into(tmp_path, plan)
    assert len(marched_pieces) == count
    assert again.keys() == whole.keys()
    for identity, march in again.items():
        assert np.array_equal(march.approach_m, whole[identity].approach_m)
    assert not (tmp_path / "pieces").exists()
    for scene in plan.stages[2]:  # beside each march stands a scene that can be run alone
        path = march_files.march_path(tmp_path, contact_identity(scene)).with_suffix(".yaml")
        assert read_scene(path) == scene


def test_a_damaged_march_is_solved_again(tmp_path: Path, marched_pieces: list[Piece]) -> None:
    plan = small_plan(balls=None)
    first = marched_into(tmp_path, plan)
    marched_pieces.clear()
    marched_into(tmp_path, plan)
    assert not marched_pieces
    damaged = sorted((tmp_path / CONTACTS).glob("*.npz"))[0]
    damaged.write_bytes(damaged.read_bytes()[:100])
    again = marched_into(tmp_path, plan)
    assert len({piece.identity for piece in marched_pieces}) == 1
    tracks = [bearing_tracks(plan, marches) for marches in (first, again)]
    assert np.array_equal(tracks[0].inner.approach_m, tracks[1].inner.approach_m)
