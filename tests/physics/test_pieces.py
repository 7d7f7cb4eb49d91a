"""Pieces of a march: cold starts, any order, plain arrays, and the identity of their contact."""

from __future__ import annotations

import pickle
import random
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian
from helpers import march_all
from scene_text import PLAIN, TINY

from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import RollingContact
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.kinds.reading import read_scene
from rolling.marches import march_piece as marching
from rolling.marches.march_piece import march_piece
from rolling.marches.march_variables import STATE_SERIES, STEP_SERIES
from rolling.marches.next_pieces import next_pieces
from rolling.marches.piece import PIECE_STEPS, Piece, contact_identity
from rolling.marches.result import Result
from rolling.results.run_numbers import joint_error
from rolling.scene.file import loads
from rolling.scene.scene import Scene

SHORT = ("rolling.load_n=0.3", "rolling.duration_s=0.0088", "surface.width_um=96")  # 440 steps


def scene(*overrides: str) -> Scene:
    return loads(PLAIN, [*SHORT, *overrides], "s.yaml")


@pytest.fixture(scope="module")
def reference() -> Result:
    return march_all(scene("recovery.events=true"))


def solve(given: Scene) -> tuple[Result, list[tuple[Piece, dict]]]:
    """Return an empty result of a scene, and the pieces of its track with their arrays."""
    result = Result.empty(given)
    return result, [(piece, march_piece(piece)) for piece in next_pieces(given, result)]


@pytest.mark.law("Pieces: the series of a piece are the march's from its cold start, to the bit.")
def test_a_piece_is_a_march_from_a_cold_start(reference: Result) -> None:
    contact = rolling_contact(scene())
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    first = PIECE_STEPS
    last = 2 * PIECE_STEPS
    states = list(march(contact, first, last, half_space))
    for name in STATE_SERIES:
        series = reference.series[name][first + 1 : last + 1]
        assert series.tolist() == [getattr(state, name) for state in states[1:]], name
    energies = [step_energy(*pair, half_space) for pair in pairwise(states)]
    assert reference.series["release_energy"][first:last].tolist() == [e.release for e in energies]
    assert reference.series["energy_defect"][first:last].tolist() == [e.defect for e in energies]


@pytest.mark.law("Pieces: where two of them join, the ledger misses the difference of two solves.")
def test_the_joint_error_is_the_difference_of_two_solves_of_a_position(reference: Result) -> None:
    """The track of 440 steps closes, so its joints are the positions 200, 400, and 440 on 0."""
    given = scene()
    contact = rolling_contact(given)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    stored = reference.series["stored_energy"]
    differences = [abs(float(stored[440] - stored[0]))]
    for joint in (PIECE_STEPS, 2 * PIECE_STEPS):
        (cold,) = march(contact, joint, joint, half_space)
        differences.append(abs(float(stored[joint] - cold.stored_energy)))
    error = joint_error(given, reference)
    assert error == pytest.approx(max(differences) / stored.max(), rel=1e-6)
    # The tolerance of a solve is 1e-5, of the maximum deflection; its energy is as exact.
    assert 1e-12 < error < 1e-4


def test_pieces_in_any_order_make_the_same_result(reference: Result) -> None:
    result, marched = solve(scene("recovery.events=true"))
    random.Random(1).shuffle(marched)
    for piece, arrays in marched:
        assert not result.is_complete
        result.add(piece, arrays)
    assert result.is_complete and not result.missing()
    for name in {*STEP_SERIES, *STATE_SERIES} - {"step_time"}:  # a time of the clock
        assert np.array_equal(result.series[name], reference.series[name]), name
    assert result.maps.keys() == reference.maps.keys()
    events = result.events()
    expected = reference.events()
    assert events is not None and expected is not None
    for name, column in expected.items():
        assert np.array_equal(events[name], column), name
    # An event releases a part of the energy of the run.
    assert events["energy"].sum() == pytest.approx(result.series["release_energy"].sum(), rel=1e-9)


def test_arrays_of_a_piece_are_those_of_its_archive(reference: Result) -> None:
    """The arrays of the reference went through archives."""
    result, marched = solve(scene("recovery.events=true"))
    for piece, arrays in marched:
        result.add(pickle.loads(pickle.dumps(piece)), arrays)
    assert result.snapshot is not None and reference.snapshot is not None
    assert np.array_equal(result.snapshot.pressure, reference.snapshot.pressure)
    for position, pressure_map in reference.maps.items():
        assert np.array_equal(result.maps[position].pressure, pressure_map.pressure)
        assert result.maps[position].along == pressure_map.along


def test_maps_carry_the_load(reference: Result) -> None:
    """Single precision of the maps leaves seven digits."""
    forces = [float(m.pressure.sum()) * m.cell**2 for m in reference.maps.values()]
    assert forces == pytest.approx([0.3] * len(forces), rel=1e-6)
    assert reference.snapshot is not None and len(forces) == 120


def test_keys_of_pieces_differ_and_name_files(reference: Result) -> None:
    given = scene()
    forces = np.full(441, 0.3)
    base = {"scene": given, "identity": reference.identity, "first": 0, "last": 200}
    pieces = [
        Piece(**base, kind="track"),
        Piece(**base, kind="load", load=0.2),
        Piece(**base, kind="load", load=np.nextafter(0.2, 1)),
        Piece(**base, kind="judge", load=0.2),
        Piece(**base, kind="moving", forces=forces),
        Piece(**base, kind="moving", forces=2 * forces),
        Piece(**base, kind="error", level="fine"),
        Piece(**base, kind="error", level="tight"),
        Piece(**base, kind="film", stride=1),
        Piece(**base, kind="film", stride=2),
        Piece(**{**base, "first": 100}, kind="track"),
    ]
    keys = [piece.key for piece in pieces]
    assert len(set(keys)) == len(pieces)
    assert all(set(key) <= set("abcdefghijklmnopqrstuvwxyz0123456789-") for key in keys)
    assert Piece(**base, kind="track").key == keys[0]


@pytest.mark.parametrize(
    ("changes", "same"),
    [
        ({"name": "other", "sound.distance_m": 3}, True),
        ({"sphere.density_kg_m3": 7000, "plate.density_kg_m3": 7000}, True),
        ({"numerics.error_estimate": True}, True),
        ({"rolling.speed_m_s": 0.2, "rolling.duration_s": 0.0044}, True),
        ({"rolling.duration_s": 0.0044}, False),
        ({"rolling.load_n": 0.31}, False),
        ({"rolling.start_um": 2}, False),
        ({"surface.seed": 2}, False),
        ({"plate.hardness_gpa": 3}, False),
        ({"numerics.tolerance": 1e-5}, False),
        ({"recovery.rule": "left_end"}, False),
    ],
)
def test_the_identity_knows_the_contact_alone(changes: dict, same: bool) -> None:
    assert (contact_identity(scene().with_(changes)) == contact_identity(scene())) == same


def measured(folder: Path) -> Scene:
    """Return a scene over a height file in a folder."""
    heights = gaussian((64, 64), 2e-6, 2e-8, (1e-5, 1e-5), "gaussian", 4)
    np.save(folder / "heights.npy", heights)
    surface = "surface: {kind: file, path: heights.npy, spacing_um: 2}"
    lines = TINY.splitlines()
    (folder / "scene.yaml").write_text("\n".join([*lines[:3], surface, lines[6]]))
    return read_scene(folder / "scene.yaml")


def test_heights_that_were_replaced_or_removed_are_refused(tmp_path: Path) -> None:
    given = measured(tmp_path)
    pieces = next_pieces(given, Result.empty(given))
    march_piece(pieces[0])
    path = tmp_path / "heights.npy"
    content = path.read_bytes()
    np.save(path, 1.01 * np.load(path))
    with pytest.raises(ContactError, match="not the surface that was solved"):
        march_piece(pieces[0])
    path.unlink()
    with pytest.raises(ContactError, match="gone"):
        march_piece(pieces[0])
    path.write_bytes(content)
    march_piece(pieces[0])


def test_a_contact_over_replaced_heights_is_not_kept(tmp_path: Path) -> None:
    """The heights are replaced before the first piece makes its contact, and restored after."""
    given = measured(tmp_path)
    pieces = next_pieces(given, Result.empty(given))
    expected = march_piece(pieces[0])["approach"]
    marching._last_contact.clear()
    path = tmp_path / "heights.npy"
    content = path.read_bytes()
    np.save(path, 1.5 * np.load(path))
    with pytest.raises(ContactError, match="not the surface that was solved"):
        march_piece(pieces[0])
    path.write_bytes(content)
    assert march_piece(pieces[0])["approach"].tolist() == expected.tolist()


def test_pieces_of_a_track_share_its_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its surface is looked through once, not once in each piece; another scene has another."""
    made: list[Scene] = []

    def making(given: Scene, *over: np.ndarray) -> RollingContact:
        made.append(given)
        return rolling_contact(given, *over)

    monkeypatch.setattr(marching, "rolling_contact", making)
    given = [scene("rolling.load_n=0.31"), scene("rolling.load_n=0.32")]
    release = [[arrays["release_energy"] for _, arrays in solve(other)[1]] for other in given]
    assert made == given
    assert release[0][0].mean() < release[1][0].mean()


def test_stretches_of_a_run_share_its_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stretch replaces heights and spacing of the contact of its run, which is made once."""
    made: list[Scene] = []

    def making(given: Scene, *over: np.ndarray) -> RollingContact:
        made.append(given)
        return rolling_contact(given, *over)

    given = scene("rolling.load_n=0.33")
    expected = marching.level_contact(given, "fine", 5, 10)
    monkeypatch.setattr(marching, "rolling_contact", making)
    for level in ("tight", "fine", "coarse"):
        piece = Piece(given, contact_identity(given), "error", 5, 15, level=level)
        contact = marching._contact_of(piece)
        assert (contact.spacing == expected.spacing) == (level == "fine")
        if level == "fine":
            assert contact.heights.tolist() == expected.heights.tolist()
            assert contact.tolerance == expected.tolerance and contact.start == expected.start
    assert made == [given]


def test_the_same_bytes_elsewhere_are_the_same_surface(tmp_path: Path) -> None:
    identities = set()
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
        identities.add(contact_identity(measured(tmp_path / name)))
    assert len(identities) == 1


def test_a_track_that_cannot_be_solved_raises_and_a_load_returns_its_fault() -> None:
    """1 MN is more than the surface can carry."""
    given = scene()
    (piece, *_) = next_pieces(given.with_(load_n=1e6), Result.empty(given))
    with pytest.raises(ContactError, match="more than the surface can carry"):
        march_piece(piece)
    base = {"scene": given, "identity": contact_identity(given), "first": 0, "last": 20}
    for kind in ("load", "judge"):
        arrays = march_piece(Piece(**base, kind=kind, load=1e6))
        assert list(arrays) == ["fault", "effort"] and "can carry" in str(arrays["fault"])
