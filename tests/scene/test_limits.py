"""A scene that cannot fit is refused by measured numbers, before anything is written."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from large_scenes import FILE, LAPS, scene_of
from scene_text import MADE, PLAIN, TEXT

from rolling import cli, commands
from rolling.check import cost, demand, findings, machine, refusals
from rolling.scene import file as scene_file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene


def refusal(
    arguments: Sequence[str | Path], folder: Path, capsys: pytest.CaptureFixture[str]
) -> str:
    """Return the message of a command that ends with 2 and leaves the folder as it was."""
    before = sorted(folder.rglob("*"))
    assert cli.main([str(argument) for argument in arguments]) == 2
    assert sorted(folder.rglob("*")) == before
    return capsys.readouterr().err


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run of some steps."""
    folder = tmp_path_factory.mktemp("limits")
    commands.run(
        scene_of(folder, MADE, "{load_n: 1, speed_m_s: 0.1, duration_s: 0.002}"),
        out=folder / "run",
        wanted=commands.Wanted(workers=1),
    )
    return folder / "run"


def estimate_and_files(folder: Path) -> tuple[Scene, float, int]:
    """Return the scene of a run, its estimated bytes on disk, and its bytes on disk."""
    scene = scene_file.read_scene(folder / "scene.yaml")
    needed = demand.of_scenes([(scene, cost.roughness(scene)[0])], 1).disk.total
    return scene, needed, sum(file.stat().st_size for file in folder.iterdir())


@pytest.mark.slow
def test_files_of_a_run_take_no_more_than_estimated(finished: Path) -> None:
    _, needed, written = estimate_and_files(finished)
    assert 0.8 * written < needed < 3 * written  # pictures, mostly: a few megabytes more or less


@pytest.mark.parametrize(
    ("surface", "rest", "says"),
    [
        (
            MADE.replace("200", "2e7"),
            "{load_n: 1, speed_m_s: 0.1, duration_s: 2}",
            ("memory: needs about", "surface.width_um"),
        ),
        (FILE, LAPS % (0.0001, 1e5), ("for the sound", "rolling.duration_s")),
        (FILE, LAPS % (1.0, 1000), ("for the steps", "rolling.duration_s", "disk: needs about")),
        (
            FILE,
            LAPS % ("[[0, 0.001], [99.9, 0.001], [100, 1000]]", 100),
            ("oversampling", "rolling.speed_m_s"),
        ),
        (
            FILE,
            LAPS % (0.1, 20) + f"\nsweep: {{rolling.start_um: {list(range(1000))}}}",
            ("runs of the sweep", "fewer values"),
        ),
    ],
    ids=["surface", "samples", "laps", "oversampling", "sweep"],
)
def test_run_refuses_what_does_not_fit_into_memory_or_on_disk(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    surface: str,
    rest: str,
    says: tuple[str, ...],
    monkeypatch,
) -> None:
    monkeypatch.setattr(machine, "memory", lambda: 32e9)
    monkeypatch.setattr(machine, "free_disk", lambda folder: 50e9)
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    message = refusal(
        ["run", scene_of(tmp_path, surface, rest), "--out", tmp_path / "out"], tmp_path, capsys
    )
    for part in says:
        assert part in message
    assert (
        "allowed: 26 GB, 80 % of the 32 GB" in message
        or "allowed: 40 GB, 80 % of the 50 GB" in message
    )


def test_resume_resound_and_accuracy_refuse_alike(
    finished: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # 320 MB are allowed, less than the program takes
    monkeypatch.setattr(machine, "memory", lambda: 4e8)
    unfinished = finished.parent / "unfinished"
    shutil.copytree(finished, unfinished)
    (unfinished / "summary.json").unlink()  # a finished run asks for nothing
    for command in (
        ["resume", unfinished],
        ["resound", finished, "--out", finished.parent / "other"],
        ["accuracy", finished / "scene.yaml", "--out", finished.parent / "accuracy"],
    ):
        message = refusal(command, finished.parent, capsys)
        assert (
            "allowed: 320 MB, 80 % of the 400 MB this machine allows; give fewer --workers"
            in message
        )


def test_resume_does_not_ask_for_disk_twice(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, needed, written = estimate_and_files(finished)
    monkeypatch.setattr(machine, "free_disk", lambda folder: needed / machine.SHARE - written / 2)
    refusals.refuse_what_cannot_fit(scene, 1, finished)
    with pytest.raises(SceneError, match="disk: needs about"):
        refusals.refuse_what_cannot_fit(scene, 1, finished.parent / "new")


def test_address_space_of_a_process_counts(monkeypatch) -> None:
    monkeypatch.setattr(machine, "address_space", lambda: 3e8)
    with pytest.raises(SceneError, match="240 MB, 80 % of the 300 MB one process may address"):
        refusals.refuse_what_cannot_fit(scene_file.loads(PLAIN))


def test_check_says_how_much_memory_and_disk(monkeypatch) -> None:
    scene = scene_file.loads(TEXT)
    said = str(findings.check_scene(scene))
    rows = dict(line.split("  ", 1) for line in said.splitlines() if "  " in line)
    assert "GB" in rows["memory of all"] or "MB for the program" in rows["memory of all"]
    assert "about" in rows["disk of all"]
    monkeypatch.setattr(machine, "free_disk", lambda folder: 1e6)
    assert "warning: disk of all: needs about" in str(findings.check_scene(scene))


SPARSE = """\
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000))
from rolling import cli
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as on Linux")
@pytest.mark.parametrize("command", ["run", "check"])
def test_height_file_of_50_gb_is_refused_by_its_header(tmp_path: Path, command: str) -> None:
    """In 3 GB of address space a process that read or mapped the file would fail otherwise."""
    with (tmp_path / "heights.npy").open("wb") as stream:
        np.lib.format.write_array_header_1_0(
            stream, {"descr": "<f8", "fortran_order": False, "shape": (62500, 100000)}
        )
        stream.truncate(stream.tell() + 50_000_000_000)
    path = scene_of(tmp_path, FILE, LAPS % (0.1, 0.01))
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            SPARSE,
            command,
            str(path),
            *(["--out", str(tmp_path / "out")] if command == "run" else []),
        ],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    assert (done.returncode, "Traceback" in done.stderr) == (2, False), done.stderr
    assert "for the height file" in done.stderr
    assert not (tmp_path / "out").exists()
