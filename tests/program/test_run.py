"""Run folders have the same numbers however they are made, and lose nothing."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
from pathlib import Path

import h5py
import happenings
import numpy as np
import pytest
from scene_text import BODIES, MADE

from acoustics import wav
from rolling import cli, commands
from rolling.contact import closed_forms, solver
from rolling.folders import files, run_record
from rolling.scene import file as scene_file
from rolling.simulation import result_file, simulate

SCENE = f"""\
name: small
{BODIES}{MADE}\
rolling: {{load_n: 1, speed_m_s: 0.1, duration_s: 0.009}}
"""
STEPS = 450


@pytest.fixture
def drawn(tmp_path: Path) -> Path:
    path = tmp_path / "small.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def scene(drawn: Path, undrawn: None) -> Path:
    return drawn


def series(folder: Path, name: str = "release_energy") -> np.ndarray:
    with h5py.File(folder / "result.h5") as file:
        return file[name][:]


def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("subcells", ["1", "2"])
def test_same_numbers_whatever_the_workers(scene: Path, tmp_path: Path, subcells: str) -> None:
    for workers in (1, 2):
        assert (
            cli.main(
                [
                    "run",
                    str(scene),
                    "--out",
                    str(tmp_path / str(workers)),
                    "--workers",
                    str(workers),
                    "--set",
                    f"numerics.subcells={subcells}",
                ]
            )
            == 0
        )
    for name in ("release_energy", "approach", "iterations"):
        assert np.array_equal(series(tmp_path / "1", name), series(tmp_path / "2", name))
    sounds = [(tmp_path / w / "signal.wav").read_bytes() for w in ("1", "2")]
    assert sounds[0] == sounds[1]


@pytest.mark.slow
def test_sweep_makes_a_folder_per_run_and_a_table(drawn: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    settings = ["--set", "rolling.duration_s=0.002", "--set", "sweep.rolling.load_n=[0.5, 2]"]
    assert cli.main(["run", str(drawn), *settings, "--out", str(out), "--workers", "1"]) == 0
    assert sorted(f.name for f in out.iterdir() if f.is_dir()) == ["load_n=0.5", "load_n=2"]
    for picture in ("spectrum.png", "third_octaves.png", "levels.png"):
        assert (out / picture).stat().st_size > 5000
    entries = json.loads((out / "sweep.json").read_text())
    assert [entry["values"] for entry in entries] == [
        {"rolling.load_n": 0.5},
        {"rolling.load_n": 2},
    ]
    assert [entry["label"] for entry in entries] == ["load 0.5 N", "load 2 N"]
    assert (
        entries[1]["summary"]["release_power_mean_w"]
        > entries[0]["summary"]["release_power_mean_w"]
    )
    printed = capsys.readouterr().out
    assert "load 0.5 N" in printed and "load 2 N" in printed
    head, *_ = printed.split("\n\n")
    # right under the levels
    assert "upper bound" in head and "microphone" in head and "± covers" in head


@pytest.mark.slow
def test_outputs_are_never_overwritten_without_force(scene: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    short = ["--set", "rolling.duration_s=0.002", "--workers", "1"]
    assert cli.main(["run", str(scene), *short, "--out", str(out)]) == 0
    before = (out / "result.h5").read_bytes()
    assert cli.main(["run", str(scene), *short, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err
    assert (out / "result.h5").read_bytes() == before
    assert (
        cli.main(
            ["run", str(scene), *short, "--set", "rolling.load_n=2", "--out", str(out), "--force"]
        )
        == 0
    )
    assert summary(out)["load_n"] == 2
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "thesis.txt").write_text("years")
    assert cli.main(["run", str(scene), *short, "--out", str(precious), "--force"]) == 2
    assert [f.name for f in precious.iterdir()] == ["thesis.txt"]


def test_bad_scene_writes_nothing(scene: Path, tmp_path: Path, capsys) -> None:
    scene.write_text(SCENE.replace("load_n", "laod_n"))
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert "small.yaml:5" in message and "rolling.laod_n" in message and "load_n" in message
    assert not (tmp_path / "out").exists()
    np.save(tmp_path / "z.npy", np.full((20, 20), np.nan))
    scene.write_text(
        SCENE.replace(
            SCENE.splitlines()[4 - 1], "surface: {kind: file, path: z.npy, spacing_um: 2}"
        )
    )
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "out")]) == 2
    assert "400 of 400 heights are not numbers" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_run_that_fails_says_why_and_leaves_the_others_whole(
    scene: Path, tmp_path: Path, capsys
) -> None:
    out = tmp_path / "out"
    # 2.1 GPa times 200 x 200 um is 84 N
    settings = ["--set", "rolling.duration_s=0.002", "--set", "sweep.rolling.load_n=[90, 1]"]
    assert cli.main(["run", str(scene), *settings, "--out", str(out), "--workers", "1"]) == 1
    message = capsys.readouterr().err
    assert (
        "load 90 N" in message
        and "84 N" in message
        and "more than the surface can carry" in message
    )
    assert summary(out / "load_n=1")["complete"]
    assert run_record.read(out).state != "done"


NARROW = (
    "--set",
    "rolling.duration_s=0.016",  # four pieces
    "--set",
    "surface.width_um=128",
    "--set",
    "rolling.load_n=0.3",
)


def run_until(happening: str, scene: Path, out: Path, *more: str) -> subprocess.CompletedProcess:
    words = ["run", scene, "--out", out, "--no-pictures", *NARROW, *more]
    return happenings.run(words, happening, scene.parent)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "happening"),
    [("1", happenings.CTRL_C_HERE), ("2", happenings.CTRL_C_OF_A_WORKER)],
    ids=["1", "2"],
)
def test_ctrl_c_leaves_a_valid_part(
    scene: Path, tmp_path: Path, workers: str, happening: str
) -> None:
    out = tmp_path / "out"
    ended = run_until(happening, scene, out, "--workers", workers)
    assert ended.returncode == 130, ended.stderr
    assert "partial" in ended.stdout and "resume" in ended.stderr
    part = summary(out)
    assert not part["complete"] and part["steps"] >= simulate.PIECE_STEPS and not part["loops"]
    release = series(out)
    assert np.isfinite(release[: part["steps"]]).all() and np.isnan(release).any()
    pressure, _, _ = wav.read(out / "signal.wav")
    # It does not close, so it is faded; band-limiting afterwards leaves a little at the very ends
    # (measured 0.3 %).
    assert abs(pressure[0]) < 0.01 * np.abs(pressure).max()
    assert run_record.read(out).state != "done"


@pytest.mark.slow
def test_a_killed_run_is_resumed_to_the_same_numbers(scene: Path, tmp_path: Path) -> None:
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    settings = ["--set", "recovery.events=true", "--workers", "1"]
    ended = run_until(happenings.KILL, scene, killed, *settings)
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    assert cli.main(["run", str(scene), *NARROW, *settings, "--out", str(whole)]) == 0
    left = np.isnan(series(killed)).sum()
    assert left == len(series(whole)) - simulate.PIECE_STEPS  # the first piece is kept at once
    solved = []
    inner = simulate.simulate_piece
    try:
        simulate.simulate_piece = lambda *a, **k: (solved.append(a[2] - a[1]), inner(*a, **k))[1]  # type: ignore[assignment]
        assert cli.main(["resume", str(killed), "--workers", "1"]) == 0
    finally:
        simulate.simulate_piece = inner
    assert sum(solved) == left  # what was solved is not solved again
    for name in ("release_energy", "approach", "events/energy", "events/first", "events/node"):
        assert np.array_equal(series(killed, name), series(whole, name))
    assert (killed / "signal.wav").read_bytes() == (whole / "signal.wav").read_bytes()
    assert run_record.read(killed).state == "done"


@pytest.mark.slow
def test_a_killed_worker_is_replaced_and_every_step_is_solved(scene: Path, tmp_path: Path) -> None:
    """One of two workers is killed as it begins its second of four pieces."""
    out = tmp_path / "out"
    ended = run_until(happenings.KILL_ONE, scene, out, "--workers", "2")
    assert ended.returncode == 0, ended.stderr
    assert "a worker process was killed" in ended.stderr
    assert "step/s" not in ended.stderr  # no progress bar where nobody looks
    assert np.isfinite(series(out)).all() and run_record.read(out).state == "done"


@pytest.mark.slow
def test_a_full_disk_keeps_what_was_written(
    scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    out = tmp_path / "out"
    inner, calls = result_file.write_bytes, []

    def full(path: Path, content: bytes) -> None:
        calls.append(path)
        if len(calls) > 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        inner(path, content)

    monkeypatch.setattr(files.Keeper, "due", lambda self: True)
    monkeypatch.setattr(result_file, "write_bytes", full)
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1"]) == 1
    message = capsys.readouterr().err
    assert "No space left on device" in message and "resume" in message
    monkeypatch.undo()
    assert 0 < np.isnan(series(out)).sum() < STEPS
    assert not list(out.glob(".*partial"))
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0


@pytest.mark.slow
@pytest.mark.law("Speed: a speed times c multiplies the release power by c, without a new solve.")
def test_resound_solves_nothing_and_speed_scales(
    scene: Path, tmp_path: Path, monkeypatch, capsys
) -> None:
    first, fast, far = tmp_path / "first", tmp_path / "fast", tmp_path / "far"
    assert cli.main(["run", str(scene), "--out", str(first), "--workers", "1"]) == 0
    monkeypatch.setattr(solver, "solve_contact", None)
    assert (
        cli.main(["resound", str(first), "--set", "rolling.speed_m_s=0.2", "--out", str(fast)]) == 0
    )
    slow, quick = summary(first), summary(fast)
    # Speed times 2: power times 2, half the time, spectrum at twice the frequency (DESIGN: scaling
    # laws).
    assert quick["release_power_mean_w"] == pytest.approx(
        2 * slow["release_power_mean_w"], rel=1e-12
    )
    assert quick["duration_s"] == pytest.approx(slow["duration_s"] / 2, rel=1e-12)
    assert quick["steady_level_db"] == pytest.approx(
        slow["steady_level_db"] + 10 * np.log10(2), abs=1e-9
    )
    assert np.array_equal(series(first), series(fast))
    assert cli.main(["resound", str(fast), "--set", "sound.distance_m=10", "--out", str(far)]) == 0
    assert summary(far)["level_db"] == pytest.approx(quick["level_db"] - 20, abs=1e-6)
    capsys.readouterr()
    assert (
        cli.main(
            ["resound", str(first), "--set", "rolling.load_n=2", "--out", str(tmp_path / "no")]
        )
        == 2
    )
    message = capsys.readouterr().err
    assert "rolling.load_n" in message and "rolling.speed_m_s" in message
    assert not (tmp_path / "no").exists()


@pytest.mark.slow
@pytest.mark.parametrize("subcells", ["auto", "4"])
def test_laps_of_a_file_are_solved_once(scene: Path, tmp_path: Path, subcells: str) -> None:
    np.save(tmp_path / "z.npy", np.random.default_rng(1).standard_normal((40, 60)) * 2e-8)
    text = SCENE.replace(SCENE.splitlines()[3], "surface: {kind: file, path: z.npy, spacing_um: 2}")
    # 160 um: 2 laps
    scene.write_text(text.replace("load_n: 1", "load_n: 0.2").replace("0.009", "0.0016"))
    out = tmp_path / "out"
    settings = ["--workers", "1", "--set", f"numerics.subcells={subcells}"]
    assert cli.main(["run", str(scene), "--out", str(out), *settings]) == 0
    release, approach = series(out), series(out, "approach")
    assert len(release) == 80 and np.array_equal(release[:40], release[40:])
    assert len(approach) == 81 and summary(out)["loops"]
    with h5py.File(out / "result.h5") as file:
        assert file.attrs["solved_steps"] == 40
    # The run folder finds the heights again, from wherever the command is given.
    assert (
        cli.main(
            ["resound", str(out), "--set", "sound.distance_m=2", "--out", str(tmp_path / "a" / "b")]
        )
        == 0
    )
    assert cli.main(["resume", str(tmp_path / "a" / "b")]) == 0
    assert "path: ../../z.npy" in (tmp_path / "a" / "b" / "resolved.yaml").read_text()
    # Back where it began, the contact is the same within the tolerance.
    assert approach[40] == pytest.approx(approach[0], rel=1e-3)


def test_a_smooth_ball_that_accelerates_is_silent(tmp_path: Path, undrawn: None) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(
        "name: s\nsphere: {radius_mm: 5}\nplate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n"
        "surface: {kind: smooth, spacing_um: 2, width_um: 200}\n"
        "rolling: {load_n: 5, speed_m_s: [[0, 0.1], [0.01, 0.3]], duration_s: 0.004}\n"
    )
    out = tmp_path / "out"
    assert cli.main(["run", str(path), "--out", str(out), "--workers", "1"]) == 0
    found = summary(out)
    assert found["laeq_db"] is None and found["level_db"] is None
    speed = scene_file.read_scene(out / "resolved.yaml").motion.distance(0.004) / 0.004
    power = closed_forms.smooth_release_power(5, speed, 5e-3, 210e9 / 0.91)
    # 0.3 % of release at a / spacing = 22, and a track rounded to whole nodes
    assert found["steady_level_db"] == pytest.approx(
        10 * np.log10(power / (4 * np.pi * 1e-12)), abs=0.02
    )


def test_result_is_dimensioned_and_provenance_names_no_path(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert (
        cli.main(
            [
                "run",
                str(scene),
                "--set",
                "rolling.duration_s=0.002",
                "--out",
                str(out),
                "--workers",
                "1",
            ]
        )
        == 0
    )
    with h5py.File(out / "result.h5") as file:
        speed = 0.1
        assert np.allclose(file["release_power"], file["release_per_metre"][:] * speed, rtol=1e-12)
        for name, unit in result_file.UNITS.items():
            assert file[name].attrs["units"] == unit
            assert len(file[name].dims[0].keys()) == 1
    for name in ("provenance.json", "summary.json", "resolved.yaml"):
        assert str(tmp_path) not in (out / name).read_text()
    resolved = scene_file.read_scene(out / "resolved.yaml")
    assert resolved.track.steps == 100


@pytest.mark.slow
def test_workers_pin_their_threads_and_leave_the_environment(
    scene: Path, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    report = commands.run(
        scene, ["rolling.duration_s=0.01"], tmp_path / "out", wanted=commands.Wanted(workers=2)
    )
    assert report.exit_code == 0
    assert os.environ["OMP_NUM_THREADS"] == "7"


@pytest.mark.slow
def test_pressure_maps_carry_the_load_whatever_the_pieces(scene: Path, tmp_path: Path) -> None:
    """The pressures of each map add up to the load in single precision."""
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    result = result_file.load(tmp_path / "out" / "result.h5")
    assert list(result.maps) == simulate.mapped_positions(STEPS).tolist()
    assert len(result.maps) == simulate.MAPS
    for position, one in result.maps.items():
        assert one.distance == pytest.approx(position * 2e-6)
        assert one.pressure.sum() * one.cell**2 == pytest.approx(1.0, rel=1e-6)
        rows, columns = one.pressure.shape
        # The contact lies about the sphere, which runs at mid-width.
        assert one.along < one.distance < one.along + rows * one.cell
        assert one.across < 49.5 * 2e-6 < one.across + columns * one.cell


def test_maps_of_wide_contacts_are_averaged_over_whole_cells(scene: Path, monkeypatch) -> None:
    monkeypatch.setattr(simulate, "MAP_CELLS", 10)
    one = scene_file.read_scene(scene)
    piece = simulate.simulate_piece(one, 0, 4)
    first = piece.maps[0]
    assert max(first.pressure.shape) <= 10 and first.cell > 2e-6
    assert first.pressure.sum() * first.cell**2 == pytest.approx(1.0, rel=1e-6)


def test_a_write_that_is_interrupted_leaves_nothing_half_done(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "signal.wav"
    files.write_bytes(path, b"before")

    def interrupt(number: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files.os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        files.write_bytes(path, b"after")
    assert path.read_bytes() == b"before" and [one.name for one in tmp_path.iterdir()] == [
        "signal.wav"
    ]
