"""A result belongs to one scene and one surface; every difference is named and refused."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from scene_text import PLAIN

from rolling import cli
from rolling.commands import work
from rolling.folders import run_record
from rolling.scene import identity
from rolling.scene.file import loads, read_scene
from rolling.scene.identity import Identity
from rolling.scene.identity import identity_differences as differences
from rolling.scene.scene import Scene
from rolling.simulation import batch, result_file, simulate
from rolling.surface import heights, scene_surface

SCENE = """\
name: heights
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: file, path: z.npy, spacing_um: 2}
rolling: {load_n: 0.2, speed_m_s: 0.1}
"""
STEPS = 450  # three pieces


def made(seed: int, steps: int = STEPS) -> np.ndarray:
    return heights.gaussian((steps, 60), 2e-6, 2e-8, (1e-5, 1e-5), "gaussian", seed)


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out all pictures, which no test here reads."""
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    np.save(tmp_path / "z.npy", made(1))
    path = tmp_path / "s.yaml"
    path.write_text(SCENE)
    return path


def stopped(
    scene: Path, out: Path, monkeypatch: pytest.MonkeyPatch, after: Callable[[], None] | None = None
) -> None:
    """Run a scene on one worker and call `after` once its first piece is done.

    Without `after` the run stops there.
    """
    inner = simulate.simulate_piece

    def piece(scene: Scene, first: int, *rest: object, **more: object) -> simulate.Piece:
        if first and after is None:
            raise KeyboardInterrupt
        result = inner(scene, first, *rest, **more)
        if first == 0 and after is not None:
            after()
        return result

    with monkeypatch.context() as patch:
        patch.setattr(simulate, "simulate_piece", piece)
        patch.setattr(batch.Keeper, "due", lambda self: True)
        code = cli.main(["run", str(scene), "--out", str(out), "--workers", "1", "--no-report"])
    assert code == (1 if after else 130)


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


def refused(capsys: pytest.CaptureFixture[str], folder: Path, *words: str) -> None:
    """Assert that resume, resound and report end with code 2, give the reason and write nothing."""
    before = contents(folder)
    other = folder.with_name("other")
    commands = (
        ["resume", str(folder), "--workers", "1"],
        ["resound", str(folder), "--set", "sound.distance_m=2", "--out", str(other)],
        ["report", str(folder), "--out", str(other)],
    )
    for command in commands:
        capsys.readouterr()
        assert cli.main(command) == 2, command
        message = capsys.readouterr().err
        assert all(word in message for word in words), message
        assert "Traceback" not in message and not other.exists()
    assert contents(folder) == before


def test_heights_replaced_after_an_interrupt_are_refused(
    scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    out = tmp_path / "out"
    stopped(scene, out, monkeypatch)
    np.save(tmp_path / "z.npy", made(2))
    refused(capsys, out, "z.npy is not the surface that was solved", "SHA-256")
    np.save(tmp_path / "z.npy", made(1))
    assert cli.main(["resume", str(out), "--workers", "1", "--no-report"]) == 0
    whole = tmp_path / "whole"
    assert cli.main(["run", str(scene), "--out", str(whole), "--workers", "1", "--no-report"]) == 0
    both = [
        result_file.load(folder / "result.h5").series["release_energy"] for folder in (out, whole)
    ]
    assert np.array_equal(*both)


@pytest.mark.slow
@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: np.save(path, made(2)),
        lambda path: np.save(path, made(1)[:-50]),
        lambda path: path.unlink(),
        lambda path: path.write_bytes(path.read_bytes()[:1000]),
    ],
    ids=["replaced", "shortened", "removed", "truncated"],
)
def test_heights_that_change_during_a_run_fail_it(
    spoil, scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    """The worker notices the change before its next piece.

    The first piece is kept, and the true heights finish the run.
    """
    out, path = tmp_path / "out", tmp_path / "z.npy"
    stopped(scene, out, monkeypatch, lambda: spoil(path))
    message = capsys.readouterr().err
    assert "z.npy" in message and "Traceback" not in message
    assert (
        "not the surface that was solved" in message
        or "the surface that was solved is gone" in message
    )
    result = result_file.load(out / "result.h5")
    solved = np.isfinite(result.series["release_energy"])
    assert solved[:200].all() and not solved[200:].any()
    assert not (out / "summary.json").exists()  # its statistics would be another surface's
    np.save(path, made(1))
    assert cli.main(["resume", str(out), "--workers", "1", "--no-report"]) == 0


def test_worker_processes_compare_the_heights_that_they_read(scene: Path, tmp_path: Path) -> None:
    """Both workers notice a file that was replaced after the run had begun."""
    one = read_scene(scene)
    order = simulate.Order(surface_sha256=simulate.identity_of(one).heights_sha256)
    np.save(tmp_path / "z.npy", made(2))
    pieces = [(0, *piece) for piece in simulate.pieces(STEPS)]
    outcome = simulate.march_pieces(
        [one], pieces, 2, lambda *_: pytest.fail("a piece was solved"), orders=[order]
    )
    assert "not the surface that was solved" in outcome.failures[0]


def test_heights_replaced_in_the_last_moment_give_no_numbers(
    scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    inner = simulate.simulate_piece

    def replace(given: Scene, first: int, last: int, *more: object) -> object:
        piece = inner(given, first, last, *more)
        if last == STEPS:
            np.save(tmp_path / "z.npy", made(2))
        return piece

    monkeypatch.setattr(simulate, "simulate_piece", replace)
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1"]) == 1
    assert "not the surface that was solved" in capsys.readouterr().err
    assert result_file.load(out / "result.h5").complete and not (out / "summary.json").exists()


def test_heights_replaced_after_the_sound_give_no_pictures(
    scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    """The numbers are of the surface that was solved; a picture would be of the other one."""
    inner = simulate.march_pieces

    def replace(*arguments: object) -> object:
        outcome = inner(*arguments)
        np.save(tmp_path / "z.npy", made(2))
        return outcome

    drawn: list[object] = []
    monkeypatch.setattr(simulate, "march_pieces", replace)
    monkeypatch.setattr(work, "write_pictures", lambda *given: drawn.append(given) or [])
    out, whole = tmp_path / "out", tmp_path / "whole"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1"]) == 1
    assert "not the surface that was solved" in capsys.readouterr().err
    assert not drawn and run_record.read(out).state == "failed"
    monkeypatch.setattr(simulate, "march_pieces", inner)
    np.save(tmp_path / "z.npy", made(1))
    assert cli.main(["run", str(scene), "--out", str(whole), "--workers", "1"]) == 0
    numbers = [json.loads((folder / "summary.json").read_text()) for folder in (out, whole)]
    assert numbers[0]["surface"] == numbers[1]["surface"]
    assert numbers[0]["laeq_db"] == numbers[1]["laeq_db"]


def test_the_same_heights_elsewhere_and_written_anew_are_the_same_surface(
    scene: Path, tmp_path: Path
) -> None:
    """Path, order of values and an exact type do not belong to the physics."""
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1", "--no-report"]) == 0
    (tmp_path / "elsewhere").mkdir()
    shutil.move(out, tmp_path / "elsewhere" / "deep")
    out = tmp_path / "elsewhere" / "deep"
    assert cli.main(["report", str(out)]) == 2  # the path is relative to the run folder
    np.save(tmp_path / "other.npy", np.asfortranarray(made(1)).astype(">f8"))
    said = out / "resolved.yaml"
    said.write_text(said.read_text().replace("path: ../z.npy", "path: ../../other.npy"))
    (tmp_path / "z.npy").unlink()
    assert cli.main(["report", str(out)]) == 0


def test_missing_heights_are_named(scene: Path, tmp_path: Path, monkeypatch, capsys) -> None:
    out = tmp_path / "out"
    stopped(scene, out, monkeypatch)
    (tmp_path / "z.npy").unlink()
    refused(capsys, out, "surface.path: ../z.npy: no such file")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "load_n: 0.2",
            "load_n: 50.0",
            "rolling.load_n: result.h5 was solved with 0.2, the scene says 50",
        ),
        (
            "radius_mm: 5.0",
            "radius_mm: 6.0",
            "sphere.radius_mm: result.h5 was solved with 5, the scene says 6",
        ),
        (
            "  hardness_gpa: 2.1\n",
            "",
            "plate.hardness_gpa: result.h5 was solved with 2.1, the scene says nothing",
        ),
        (
            "spacing_um: 2.0",
            "spacing_um: 3.0",
            "surface.spacing_um: result.h5 was solved with 2, the scene says 3",
        ),
        (
            "start_um: 0.0",
            "start_um: 4.0",
            "rolling.start_um: result.h5 was solved with 0, the scene says 4",
        ),
        (
            "tolerance: 0.0001",
            "tolerance: 0.001",
            "numerics.tolerance: result.h5 was solved with 0.0001",
        ),
        (
            "edges: blended",
            "edges: sharp",
            'numerics.edges: result.h5 was solved with "blended", the scene says "sharp"',
        ),
        (
            "events: false",
            "events: true",
            "recovery.events: result.h5 was solved with false, the scene says true",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: 0.1\n  duration_s: 0.018",
            "result.h5 has 450 steps, the scene asks for 900",
        ),
    ],
)
def test_an_edited_scene_is_refused_key_by_key(
    old, new, message, scene: Path, tmp_path: Path, monkeypatch, capsys
):
    out = tmp_path / "out"
    stopped(scene, out, monkeypatch)
    text = (out / "resolved.yaml").read_text()
    assert old in text
    (out / "resolved.yaml").write_text(text.replace(old, new))
    refused(capsys, out, message)


def test_what_resound_may_change_is_no_physics(scene: Path, tmp_path: Path) -> None:
    one = simulate.identity_of(read_scene(scene))
    changes = (
        ["name=other", "description=words"],
        ["sound.distance_m=7", "sound.q=0.5"],
        ["rolling.speed_m_s=3"],
    )
    for settings in changes:
        other = simulate.identity_of(read_scene(scene, settings))
        assert not differences(one, other, "result.h5", None) and one.sha256 == other.sha256


def test_an_edited_seed_is_refused_in_a_sweep_and_in_its_runs(tmp_path: Path, capsys) -> None:
    path, out = tmp_path / "s.yaml", tmp_path / "out"
    path.write_text(
        PLAIN.replace("width_um: 64", "width_um: 200").replace(
            "duration_s: 0.01", "duration_s: 0.003"
        )
    )
    settings = ["--set", "sweep.rolling.load_n=[0.5, 1]", "--workers", "1", "--no-report"]
    assert cli.main(["run", str(path), *settings, "--out", str(out)]) == 0
    one = out / "load_n=1"
    text = (one / "resolved.yaml").read_text()
    (one / "resolved.yaml").write_text(text.replace("seed: 1", "seed: 2"))
    refused(capsys, one, "surface.seed: result.h5 was solved with 1, the scene says 2")
    # The sweep says 1, its run 2: which one is meant cannot be known.
    refused(
        capsys,
        out,
        "load_n=1/resolved.yaml: surface.seed: got 2, the sweep of the folder above makes 1 of it",
    )
    (one / "resolved.yaml").write_text(text)
    whole = (out / "resolved.yaml").read_text()
    (out / "resolved.yaml").write_text(whole.replace("seed: 1", "seed: 2"))
    refused(
        capsys,
        out,
        "load_n=0.5/resolved.yaml: surface.seed: got 1, "
        "the sweep of the folder above makes 2 of it",
    )
    (out / "resolved.yaml").write_text(whole.replace("[0.5, 1", "[0.5, 2"))
    before = contents(out)
    assert cli.main(["resume", str(out), "--workers", "1"]) == 2
    message = (
        "load_n=1/resolved.yaml: rolling.load_n: got 1, the sweep of the folder above makes 2 of it"
    )
    assert message in capsys.readouterr().err and contents(out) == before


@pytest.mark.parametrize(
    "settings", [(), ("numerics.tolerance=1e-3", "recovery.events=true", "plate.hardness_gpa=")]
)
def test_a_key_that_a_version_lacks_has_its_default(settings) -> None:
    own = Identity.of(loads(PLAIN, settings), None)
    assert not differences(own, own, "result.h5", None)
    for key, value in own.physics.items():
        older = Identity({k: v for k, v in own.physics.items() if k != key}, own.defaults, None)
        expected = key not in own.defaults or own.defaults[key] != value
        assert bool(differences(older, own, "result.h5", None)) == expected, key
    # Written by a later version: keys that this one has never heard of.
    later = {"plate.creep": 0.0, "dynamics": None}
    newer = Identity(own.physics | later, own.defaults | later, None)
    assert not differences(newer, own, "result.h5", None) and not differences(
        own, newer, "result.h5", None
    )
    newer = Identity(own.physics | later | {"plate.creep": 0.5}, own.defaults | later, None)
    assert differences(newer, own, "result.h5", None) == [
        "plate.creep: result.h5 was solved with 0.5, the scene says 0"
    ]
    newer = Identity(own.physics | later | {"dynamics": True}, own.defaults | later, None)
    assert len(differences(newer, own, "result.h5", None)) == 1


def test_another_kind_of_surface_is_one_difference(tmp_path: Path) -> None:
    scene = loads(PLAIN)
    smooth = Scene.from_dict(
        scene.to_dict() | {"surface": {"kind": "smooth", "spacing_um": 2, "width_um": 64}}
    )
    found = differences(Identity.of(scene, None), Identity.of(smooth, None), "result.h5", None)
    assert found == ['surface.kind: result.h5 was solved with "gaussian", the scene says "smooth"']


def test_the_digest_of_heights_is_of_shape_and_values() -> None:
    z = made(1, 16)
    digest = identity.heights_digest(z)
    assert (
        digest
        == identity.heights_digest(np.asfortranarray(z))
        == identity.heights_digest(z[::1].astype(">f8"))
    )
    others = [z.reshape(60, 16), z.T, z[::-1], z + 1e-20, z * (1 + 1e-15), np.roll(z, 1, axis=0)]
    assert len({digest, *map(identity.heights_digest, others)}) == 7


def test_the_file_says_what_was_solved(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1", "--no-report"]) == 0
    # The short track leaves the tolerance at 1e-4, and the file has the number.
    own = simulate.identity_of(read_scene(scene, ["numerics.tolerance=1e-4"]))
    with h5py.File(out / "result.h5") as file:
        assert file.attrs["physics"] == own.text and file.attrs["physics_sha256"] == own.sha256
        assert file.attrs["heights_sha256"] == identity.heights_digest(made(1))
        assert "z.npy" not in file.attrs["physics"] and "speed" not in file.attrs["physics"]


def test_a_resounded_run_keeps_its_identity_whatever_its_duration(
    scene: Path, tmp_path: Path
) -> None:
    """Another speed rounds the duration, and the steps stay as they were on either surface."""
    rng = np.random.default_rng(0)
    from rolling.scene import file as scene_file

    for text in (SCENE.replace("speed_m_s: 0.1", "speed_m_s: 0.1, duration_s: 1"), PLAIN):
        for _ in range(40):
            settings = [f"rolling.duration_s={10 ** rng.uniform(-2.7, 0):.17g}"]
            before = loads(text, settings, folder=tmp_path)
            after = scene_file.resound(
                before, [f"rolling.speed_m_s={10 ** rng.uniform(-4, 2):.17g}"]
            )
            pair = [simulate.identity_of(one) for one in (before, after)]
            assert not differences(*pair, "result.h5", None), (settings, after.rolling)


def test_comparing_costs_little(scene: Path, tmp_path: Path) -> None:
    """A comparison takes 0.3 ms before a piece of 60 ms or more."""
    one = read_scene(scene)
    scene_surface.heights(one)
    began = time.process_time()
    for _ in range(20):
        simulate.surface_fault(one, None)
    assert (time.process_time() - began) / 20 < 0.02
