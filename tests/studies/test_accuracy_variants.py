"""Variants of an accuracy study: their surfaces, their pieces on disk, and parts of the record."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scene_text import SMALL

from rolling.accuracy import kept, variants
from rolling.accuracy.record import record_check
from rolling.folders.files import FolderError
from rolling.scene.scene import Scene
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES, Piece
from rolling.surface import heights as surface
from rolling.surface import scene_surface

SCENE = SMALL | {
    "surface": SMALL["surface"] | {"width_um": 256, "seed": 3},
    "rolling": {"load_n": 1, "speed_m_s": 0.1, "duration_s": 0.005},
}


def study(**changes: object) -> variants.Study:
    return variants.study_of(Scene.from_dict(SCENE).with_(changes), 1.0, 4)


def of_file(folder: Path, z: np.ndarray) -> variants.Study:
    np.save(folder / "heights.npy", z)
    data = SCENE | {
        "surface": {"kind": "file", "path": "heights.npy", "height_unit": "m", "spacing_um": 2}
    }
    return variants.study_of(Scene.from_dict(data, folder), 1.0, 4)


def test_height_files_are_refined_by_what_they_hold(tmp_path: Path) -> None:
    """Between the nodes a smooth file continues, and pits of one node have flat cells."""
    smooth = surface.gaussian((120, 64), 2e-6, 1e-7, (10e-6, 10e-6), "gaussian", 1)
    pits = smooth.copy()
    pits[np.random.default_rng(2).random(pits.shape) < 0.02] -= 2e-6
    contacts = {}
    for name, z in (("smooth", smooth), ("pits", pits)):
        (tmp_path / name).mkdir()
        what = of_file(tmp_path / name, z)
        own = variants.rolling_contact(what.scene, what.own)
        fine = variants.rolling_contact(what.scene, what.reference("sharp"))
        contacts[name] = own, fine
        assert fine.heights.shape == tuple(4 * n for n in z.shape)
        # either way the sphere rolls over the same heights
        assert fine.position(0) - own.position(0) == pytest.approx(
            {"smooth": 0.0, "pits": 1.5 * fine.spacing}[name]
        )
    own, fine = contacts["pits"]
    assert not fine.slopes and np.array_equal(
        fine.heights, np.repeat(np.repeat(own.heights, 4, axis=0), 4, axis=1)
    )
    own, fine = contacts["smooth"]
    assert fine.slopes and len(np.unique(fine.heights[:4, :4])) == 16
    # the interpolation passes between the nodes, whose heights it has where both grids have nodes
    steps = np.abs(np.diff(fine.heights, axis=0)).max()
    assert steps < 0.4 * np.abs(np.diff(own.heights, axis=0)).max()


@pytest.mark.parametrize(("width", "times"), [(256, 2), (250, 3)])
def test_a_wider_surface_has_the_same_asperities_in_its_middle(width: float, times: int) -> None:
    scene = study(**{"surface.width_um": width, "rolling.duration_s": 0.02}).scene
    assert scene_surface.wider_times(scene) == times
    own = scene_surface.heights(scene)
    wide = scene_surface.wider_heights(scene, times)
    assert wide.shape == (own.shape[0], times * own.shape[1])
    assert np.abs(wide).mean() == pytest.approx(np.abs(own).mean(), rel=0.05)
    first = own.shape[1] * (times - 1) // 2
    middle = wide[:, first : first + own.shape[1]]
    off = middle - own
    # away from the seam of the narrower period; zero means differ by a constant
    assert np.ptp(off[:, 20:-20]) < 1e-6 * np.std(own)
    assert np.std(off[:, :3]) > 0.1 * np.std(own)


def test_the_width_is_varied_where_a_surface_can_be_made(tmp_path: Path) -> None:
    what = study()
    assert what.wider == replace(what.own, width=2) in what.variants()
    assert what.families()["width"] == [what.own, what.wider]
    contact = variants.rolling_contact(what.scene, what.wider)
    assert contact.heights.shape == (what.nodes, 256) and contact.mid_width == pytest.approx(
        variants.rolling_contact(what.scene, what.own).mid_width + 64 * 2e-6
    )
    z = surface.gaussian((120, 64), 2e-6, 1e-7, (10e-6, 10e-6), "gaussian", 1)
    assert of_file(tmp_path, z).wider is None
    smooth = study(surface={"kind": "smooth", "spacing_um": 2, "width_um": 256})
    assert smooth.wider is None and "width" not in smooth.families()


def piece(first: int, last: int) -> Piece:
    rng = np.random.default_rng(first)
    steps = {name: rng.random(last - first) for name in STEP_SERIES}
    states = {name: rng.random(last - first + (first == 0)) for name in STATE_SERIES}
    return Piece(first, last, steps, states, None, None, [])


def test_pieces_are_read_as_they_were_written_and_damaged_ones_are_missing(tmp_path: Path) -> None:
    what = study()
    kept.write_study(tmp_path, what)
    kept.refuse_other_study(tmp_path, what)
    kept.write_piece(tmp_path, what.own, piece(0, 20))
    read = kept.read_piece(tmp_path, what.own, 0, 20)
    assert read is not None
    for name, values in {**piece(0, 20).steps, **piece(0, 20).states}.items():
        assert np.array_equal({**read.steps, **read.states}[name], values)
    assert kept.read_piece(tmp_path, what.own, 20, 40) is None
    assert kept.read_piece(tmp_path, what.solver_reference, 0, 20) is None
    (path,) = (tmp_path / "variants").glob("*.npz")
    content = path.read_bytes()
    for damaged in (b"", content[:100], content[:-30], content[:300] + b"x" * 30 + content[330:]):
        path.write_bytes(damaged)
        assert kept.read_piece(tmp_path, what.own, 0, 20) is None
    with pytest.raises(FolderError, match=r"rolling\.load_n.*1.*2"):
        kept.refuse_other_study(tmp_path, study(**{"rolling.load_n": 2}))
    (tmp_path / "study.json").write_text("{}")
    with pytest.raises(FolderError, match="cannot go on"):
        kept.refuse_other_study(tmp_path, what)


def test_parts_of_white_noise_scatter_as_their_uncertainty_states() -> None:
    what = study(**{"rolling.duration_s": 0.4, "surface.width_um": 64})
    rng = np.random.default_rng(5)
    checks = [record_check(what, 1e-9 * (5 + rng.standard_normal(what.nodes))) for _ in range(20)]
    for k, parts in enumerate((2, 4)):
        known = [check.parts[k] for check in checks if check is not None]
        assert {each.parts for each in known} == {parts} and len(known) == 20
        off = np.sqrt(np.mean([each.scatter_db**2 for each in known]))
        assert off == pytest.approx(np.mean([each.stated_db for each in known]), rel=0.3)
        share = sum(e.bands_within for e in known) / sum(e.bands for e in known)
        assert 0.88 < share < 0.99
    first = checks[0]
    assert first is not None
    assert first.needed_s == pytest.approx(0.4 * (first.uncertainty_db / 0.1) ** 2)


def test_a_changing_speed_or_silence_has_no_parts() -> None:
    noise = 1e-9 * (5 + np.random.default_rng(1).standard_normal(study().nodes))
    assert record_check(study(), np.full(study().nodes, 1e-9)) is None
    changing = study(**{"rolling.speed_m_s": [[0, 0.05], [0.01, 0.1]]})
    assert record_check(changing, noise[: changing.nodes]) is None
