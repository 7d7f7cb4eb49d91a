"""A scene that cannot fit is refused by its numbers, before anything large is made or read."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from bearing_runs import WAVY, loads_bearing
from commands import PATIENCE, ROOT, SWEEP
from large_scenes import FILE, LAPS, scene_of
from scene_text import MADE, TEXT, TINY

import rolling
from rolling import cli
from rolling.bearing_kind import bearing_simulation
from rolling.check import findings, refusals
from rolling.check.memory_and_disk import disk
from rolling.check.run_size import run_size
from rolling.kinds.reading import read_scene
from rolling.run.executor import RunLoop
from rolling.scene.file import loads
from rolling.scene.messages import SceneError


@pytest.mark.slow
@pytest.mark.parametrize(
    ("surface", "rest", "words"),
    [
        (
            MADE.replace("200", "2e7"),
            "{load_n: 1, speed_m_s: 0.1, duration_s: 2}",
            ("memory: needs about", "for the surface", "surface.spacing_um"),
        ),
        (FILE, LAPS % (0.0001, 1e5), ("for the record", "rolling.duration_s")),
        (FILE, LAPS % (1.0, 1000), ("for the record", "disk: needs about")),
        (
            FILE,
            LAPS % (0.1, 20) + f"\nsweep: {{rolling.start_um: {list(range(2000))}}}",
            ("for the record", "fewer values"),
        ),
    ],
    ids=["surface", "samples", "laps", "sweep"],
)
def test_a_scene_that_does_not_fit_is_refused(
    tmp_path: Path,
    surface: str,
    rest: str,
    words: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(refusals, "memory_limit", lambda: 32e9)
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 50e9)
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    scene = read_scene(scene_of(tmp_path, surface, rest))
    with pytest.raises(SceneError) as error:
        refusals.refuse(scene, 2, tmp_path / "out")
    assert all(part in str(error.value) for part in words)
    assert "allowed: 26 GB, 80 % of the 32 GB" in str(error.value)
    assert not (tmp_path / "out").exists()


def test_check_says_how_much_memory_and_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = loads(TEXT)
    rows = dict(findings.check_scene(scene, solve=False).of_all)
    assert "MB for the program" in rows["memory of all"] and "about" in rows["disk of all"]
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e6)
    text = str(findings.check_scene(scene, solve=False))
    assert "warning: disk of all: needs about" in text


MANY_BALLS = """
name: many
bearing: {balls: 200, ball_diameter_mm: 5, pitch_diameter_mm: 400, contact_angle_deg: 15,
  speed_rpm: 600, axial_load_n: 500, surfaces: {inner: {kind: smooth, waviness: {9: 0.1}}}}
sound: {listen_s: 120}
"""


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize("lacking", ["memory", "disk"])
def test_a_bearing_that_does_not_fit_is_refused(
    tmp_path: Path,
    command: str,
    lacking: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Loads of 200 balls over two minutes take 50 GB, and are 5 GB on disk."""
    monkeypatch.setattr(refusals, "memory_limit", lambda: 32e9 if lacking == "memory" else 1e12)
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e12 if lacking == "memory" else 1e9)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "many.yaml").write_text(MANY_BALLS)
    assert cli.main([command, "many.yaml"]) == 2
    said = capsys.readouterr()
    text = " ".join((said.out + said.err).split())
    assert f"{lacking}: needs about" in text and "sound.listen_s" in text
    assert [path.name for path in tmp_path.iterdir()] == ["many.yaml"]


def test_a_bearing_that_hardly_turns_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its contacts are marched over days of rolling, of which no sound is made."""
    monkeypatch.setattr(refusals, "memory_limit", lambda: 8e9)
    scene = rolling.read_scene("bearing-6204", ["bearing.speed_rpm=0.001"])
    assert scene.check().refusal is None


def test_height_file_of_50_gb_is_refused_by_its_header(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file is sparse; reading it would take minutes and fill the memory."""
    monkeypatch.setattr(refusals, "memory_limit", lambda: 32e9)
    with (tmp_path / "heights.npy").open("wb") as stream:
        header = {"descr": "<f8", "fortran_order": False, "shape": (62500, 100000)}
        np.lib.format.write_array_header_1_0(stream, header)
        stream.truncate(stream.tell() + 50_000_000_000)
    scene = read_scene(scene_of(tmp_path, FILE, LAPS % (0.1, 0.01)))
    with pytest.raises(SceneError, match="for the surface"):
        refusals.refuse(scene)
    with pytest.raises(SceneError, match="for the surface"):
        findings.check_scene(scene)


LIMITED = """
import resource
import sys

from rolling import cli

limit = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
sys.exit(cli.main(sys.argv[2:]))
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="address space is limited so on Linux only")
@pytest.mark.parametrize("workers", ["1", "2"])
@pytest.mark.parametrize("megabytes", [200, 270, 600, 700])
def test_too_little_address_space_ends_with_a_sentence(
    megabytes: int, workers: str, tmp_path: Path
) -> None:
    """The solver alone takes about 600 MB of addresses, libraries of files and pictures the rest.

    Without room for them a compiler aborts, an import fails, or a worker waits for ever.
    """
    scene = tmp_path / "scene.yaml"
    scene.write_text(SWEEP)
    words = ["run", str(scene), "--out", str(tmp_path / "out"), "--workers", workers]
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(megabytes * 10**6), *words],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert done.returncode == 1, done.stderr
    assert "not enough memory" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        OSError(errno.ENOMEM, "Cannot allocate memory"),
        ImportError("libhdf5.so: failed to map segment from shared object"),
        RuntimeError("can't start new thread"),
    ],
)
def test_lack_of_memory_of_any_kind_is_one_error_in_python(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: object, pool: object) -> None:
        raise error

    monkeypatch.setattr(RunLoop, "finished_runs", fail)
    with pytest.raises(MemoryError):
        rolling.simulate(loads(TINY), workers=1)


def test_memory_is_limited_by_control_groups(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The smallest limit counts, of the group of the process and of those above it."""
    whole = refusals.memory_limit()
    assert 1e8 < whole < 1e14
    groups = tmp_path / "cgroup"
    group = groups / "job" / "task"
    group.mkdir(parents=True)
    (group / "memory.max").write_text("max\n")
    (groups / "job" / "memory.max").write_text("123456789\n")
    lines = tmp_path / "lines"
    lines.write_text("0::/job/task\n")
    monkeypatch.setattr(refusals, "GROUPS_OF_PROCESS", lines)
    monkeypatch.setattr(refusals, "GROUPS", groups)
    assert refusals.memory_limit() == 123456789


# ---- disks


def test_a_disk_that_is_mounted_read_only_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It has no free space either, and no shorter run would fit."""
    real = os.statvfs

    def read_only(path: object) -> os.statvfs_result:
        fields = list(real(path))
        fields[4] = 0  # bytes that are free to this user
        fields[8] |= os.ST_RDONLY
        return os.statvfs_result(fields)

    (tmp_path / "tiny.yaml").write_text(TINY)
    (tmp_path / "many.yaml").write_text(MANY_BALLS.replace("listen_s: 120", "listen_s: 1"))
    monkeypatch.setattr(os, "statvfs", read_only)
    for name in ("tiny.yaml", "many.yaml"):
        assert cli.main(["run", str(tmp_path / name), "--out", str(tmp_path / "out")]) == 2
        said = capsys.readouterr().err
        assert "disk: the disk is read-only where" in said
        assert "take a folder on another disk" in said
        assert "needs" not in said and "shorten" not in said
    assert not (tmp_path / "out").exists()


def test_a_disk_that_filled_half_way_is_to_be_freed_and_done_runs_need_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another scene, such as a shorter one, would not go on in this folder."""
    scene = tmp_path / "tiny.yaml"
    scene.write_text(TINY + "sweep: {sound.distance_m: [1, 2]}\n")
    out = tmp_path / "out"
    words = ["run", str(scene), "--out", str(out), "--no-report", "-q", "--workers", "1"]
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e6)
    assert cli.main(words) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "free some space, take a folder on another disk, or shorten rolling.duration_s" in said
    one_run = 1.1 * disk([run_size(loads(TINY))]) / refusals.SHARE
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e12)
    assert cli.main([*words, "--part", "1/1"]) == 0
    next(out.glob("*distance*=2/summary.json")).unlink()
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e6)
    assert cli.main(words) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "free some space, and the same command goes on" in said and "shorten" not in said
    monkeypatch.setattr(refusals, "free_disk", lambda folder: one_run)
    assert cli.main(words) == 0  # the other run needs no disk


def test_a_bearing_that_is_done_needs_no_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = loads_bearing(WAVY.replace("0.5", "0.1"))
    for name in ("result.h5", "summary.json"):
        (tmp_path / name).touch()
    monkeypatch.setattr(refusals, "free_disk", lambda folder: 1e6)
    bearing_simulation.refuse(scene, workers=1, folder=tmp_path, unsolved=[])
    (tmp_path / "summary.json").unlink()
    with pytest.raises(SceneError, match="free some space, and the same command"):
        bearing_simulation.refuse(scene, workers=1, folder=tmp_path, unsolved=[scene])
