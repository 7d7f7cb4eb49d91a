"""--out, --force and resume never lose inputs, foreign files or solved runs."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import happenings
import numpy as np
import pytest

from rolling import cli, commands
from rolling.commands import work
from rolling.folders import files, run_record
from rolling.folders.run_record import RunRecord
from rolling.report import page as report
from rolling.scene import run_names
from rolling.simulation import batch, result_file, simulate, sound_files

SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 3}
rolling: {load_n: 0.2, speed_m_s: 0.1, duration_s: 0.002}
"""
PAGE = f'<!doctype html><meta name="generator" content="{report.GENERATOR}">'.encode()
LONG = ("--set", "rolling.duration_s=0.016", "--workers", "1")  # four pieces


@pytest.fixture(autouse=True)
def _without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "proj").mkdir()
    path = tmp_path / "proj" / "scene.yaml"
    path.write_text(SCENE)
    (tmp_path / "proj" / "thesis.tex").write_text("years")
    return path


@pytest.fixture
def out(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """Return the folder of a finished run."""
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "out"), "--workers", "1"]) == 0
    capsys.readouterr()
    return tmp_path / "out"


def record(folder: Path) -> RunRecord:
    found = run_record.read(folder)
    assert found is not None
    return found


def bytes_in(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def as_by_0_1_0(folder: Path) -> None:
    """Turn a folder into one of version 0.1.0, without run.json and with its mark `finished`."""
    for file in [*folder.rglob("run.json"), *folder.rglob(".lock")]:
        (file.parent / "finished").write_text("2026-01-01T00:00:00+00:00\n")
        file.unlink()


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Callable[..., str]:
    """Assert that a command ends with 2 and changes nothing; return its message."""

    def give(*arguments: object) -> str:
        before = bytes_in(tmp_path)
        capsys.readouterr()
        assert cli.main([str(each) for each in arguments]) == 2
        after = {
            name: content
            for name, content in bytes_in(tmp_path).items()
            if Path(name).name != ".lock"
        }
        assert after == {
            name: content for name, content in before.items() if Path(name).name != ".lock"
        }
        message = capsys.readouterr().err
        assert "is kept" not in message and "Traceback" not in message
        return message

    return give


def test_force_never_touches_what_is_not_a_run(scene, tmp_path, refused, monkeypatch) -> None:
    """An earlier version emptied such a folder before it read the scene."""
    proj = scene.parent
    assert "no run of this program" in refused("run", scene, "--out", proj, "--force")
    monkeypatch.chdir(proj)
    for name in (".", "..", "../proj", f"{proj}/", "./", str(tmp_path)):
        assert "the working directory" in refused("run", scene, "--out", name, "--force")
    for name in ("", " ", "\t"):
        for command in (
            ["run", str(scene)],
            ["accuracy", str(scene)],
            ["accuracy", "--hard"],
            ["reproduce", "lee2025"],
        ):
            with pytest.raises(SystemExit) as stopped:
                cli.main([*command, "--out", name])
            assert stopped.value.code == 2
    with pytest.raises(SystemExit):
        cli.main(["resume", ""])
    monkeypatch.chdir(tmp_path)
    assert "no study of accuracy of this program" in refused(
        "accuracy", scene, "--out", proj, "--force"
    )
    assert "no table of hard cases of this program" in refused("accuracy", "--hard", "--out", proj)
    assert "no study of this program" in refused("reproduce", "lee2025", "--quick", "--out", proj)


def test_inputs_are_read_first_and_never_replaced(scene, out, tmp_path, refused) -> None:
    shutil.copy(scene, out / "scene.yaml")
    assert "which this command reads, lies in it" in refused(
        "run", out / "scene.yaml", "--out", out, "--force"
    )
    assert "lies in it" in refused(
        "resound", out, "--set", "sound.distance_m=2", "--out", out, "--force"
    )
    scene.write_text(SCENE.replace("load_n", "laod_n"))
    assert "nearest: load_n" in refused("run", scene, "--out", out, "--force")
    scene.write_text(SCENE.replace("gaussian, r", "file, path: z.npy, r"))
    refused("run", scene, "--out", out, "--force")
    heights = SCENE.replace(
        SCENE.splitlines()[3], "surface: {kind: file, path: ../out/z.npy, spacing_um: 2}"
    )
    np.save(out / "z.npy", np.zeros((250, 40)))
    scene.write_text(heights)
    assert "z.npy, which this command reads, lies in it" in refused(
        "run", scene, "--out", out, "--force"
    )


def test_force_keeps_the_old_run_until_the_new_one_is_done(
    scene, out, tmp_path, monkeypatch, capsys
) -> None:
    before = (out / "result.h5").read_bytes()
    previous = tmp_path / "out.previous"
    again = [
        "run",
        str(scene),
        "--set",
        "rolling.load_n=0.1",
        "--out",
        str(out),
        "--force",
        "--workers",
        "1",
    ]
    inner = result_file.save

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(result_file, "save", full)
    assert cli.main(again) == 1
    message = capsys.readouterr().err
    assert (
        "No space left" in message and "nothing was solved" in message and "is kept" not in message
    )
    assert f"stays in {previous} until this one is done" in message
    assert record(out).state == "failed" and "No space left" in str(record(out).reason)
    assert (previous / "result.h5").read_bytes() == before and record(previous).state == "done"
    monkeypatch.setattr(result_file, "save", inner)
    # More than the surface can carry; and once more, over the failed one.
    assert cli.main([*again, "--set", "plate.hardness_gpa=0.00001"]) == 1
    message = capsys.readouterr().err
    assert (
        "nothing is solved yet" in message
        and f"{previous}, which this run replaces, stays" in message
    )
    assert (previous / "result.h5").read_bytes() == before
    assert cli.main(again) == 0
    assert not previous.exists() and json.loads((out / "summary.json").read_text())["load_n"] == 0.1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "proj"]


def test_a_full_disk_after_some_steps_says_what_is_kept(
    scene, tmp_path, monkeypatch, capsys
) -> None:
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(sound_files, "write", full)
    assert cli.main(["run", str(scene), "--out", str(tmp_path / "out"), "--workers", "1"]) == 1
    message = capsys.readouterr().err
    assert (
        f"the steps solved before are kept in {tmp_path / 'out'}" in message
        and "rolling resume" in message
    )
    monkeypatch.undo()
    # An error of another command says nothing of runs.
    monkeypatch.setattr(commands, "report", full)
    assert cli.main(["report", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err.strip() == "[Errno 28] No space left on device"


def test_resound_replaces_by_the_same_law(scene, out, tmp_path, capsys) -> None:
    new = ["resound", str(out), "--set", "sound.distance_m=2", "--out", str(tmp_path / "new")]
    assert cli.main(new) == 0 and cli.main(new) == 2
    assert cli.main([*new, "--force"]) == 0
    assert record(tmp_path / "new").state == "done" and not (tmp_path / "new.previous").exists()
    (tmp_path / "new" / "notes.txt").write_text("mine")
    assert cli.main([*new, "--force"]) == 2
    assert "did not write notes.txt" in capsys.readouterr().err


def test_a_page_replaces_pages_only(out, tmp_path, refused, monkeypatch) -> None:
    monkeypatch.setattr(report, "exhibits", lambda *_: [])
    monkeypatch.setattr(report, "page", lambda *_: PAGE)
    page = tmp_path / "page.html"
    assert cli.main(["report", str(out), "--out", str(page)]) == 0
    assert "--force" in refused("report", out, "--out", page)
    assert cli.main(["report", str(out), "--out", str(page), "--force"]) == 0
    for name in ("result.h5", "run.json", "scene.yaml"):
        assert "not a page" in refused("report", out, "--out", out / name, "--force")
    (tmp_path / "mine.html").write_text("<!doctype html><title>mine</title>")
    (tmp_path / "link.html").symlink_to(page)
    (tmp_path / "nowhere.html").symlink_to(tmp_path / "none")
    assert "not a page" in refused("report", out, "--out", tmp_path / "mine.html", "--force")
    assert "symbolic link" in refused("report", out, "--out", tmp_path / "link.html", "--force")
    assert "symbolic link" in refused("report", out, "--out", tmp_path / "nowhere.html")
    assert "is a folder" in refused("report", out, "--out", tmp_path, "--force")
    # its own report.html
    assert cli.main(["report", str(out)]) == 0 == cli.main(["report", str(out)])


@pytest.mark.slow
def test_a_run_in_progress_is_left_alone_by_all_commands(scene, tmp_path, refused) -> None:
    """A second resume and --force name the working process; once killed, it blocks nobody."""
    out = tmp_path / "long"
    # stopped, so that its files do not change while this test compares them
    with happenings.stopped(["run", scene, "--out", out, *LONG], tmp_path) as process:
        assert (out / "result.h5").is_file() and record(out).state == "running"
        name = (
            f"in use by process {process.pid} on host {os.uname().nodename}"
            f" since {record(out).changed}"
        )
        assert name in refused("resume", out)
        assert name in refused("run", scene, "--out", out, "--force")
        assert name in refused("run", scene, "--out", out)
    assert record(out).state == "running"  # as it was left
    assert cli.main(["run", str(scene), "--out", str(out), "--force", "--workers", "1"]) == 0
    assert record(out).state == "done" and not (tmp_path / "long.previous").exists()


def test_each_run_of_a_sweep_has_its_state(scene, tmp_path, capsys) -> None:
    out = tmp_path / "out"
    settings = [
        "--set",
        "plate.hardness_gpa=0.0001",
        "--set",
        "sweep.rolling.load_n=[90, 0.0001]",
        "--workers",
        "1",
    ]
    assert cli.main(["run", str(scene), *settings, "--out", str(out)]) == 1
    sweep, bad, good = record(out), record(out / "load_n=90"), record(out / "load_n=0.0001")
    assert (sweep.kind, sweep.state, sweep.runs) == (
        "sweep",
        "failed",
        ("load_n=90", "load_n=0.0001"),
    )
    assert "1 of 2 runs" in str(sweep.reason) and "more than the surface can carry" in str(
        bad.reason
    )
    assert (bad.kind, bad.state, good.kind, good.state) == ("run", "failed", "run", "done")
    assert len({sweep.id, bad.id, good.id}) == 3 and all(
        each.process is None for each in (sweep, bad, good)
    )
    assert cli.main(["resume", str(out), "--workers", "1"]) == 1
    assert record(out).id == sweep.id and record(out).created == sweep.created
    assert record(out / "load_n=0.0001").changed == good.changed  # nothing to write


def test_an_interrupted_sweep_waits(scene, tmp_path, monkeypatch, capsys) -> None:
    out = tmp_path / "out"
    seen: list[tuple[str, str]] = []
    inner = batch.simulate.simulate_piece

    def stop_in_the_second(one, *arguments, **more):
        seen.append((record(out / "load_n=0.1").state, record(out / "load_n=0.2").state))
        if len(seen) == 2:
            os.kill(os.getpid(), 2)
        return inner(one, *arguments, **more)

    monkeypatch.setattr(batch.simulate, "simulate_piece", stop_in_the_second)
    settings = ["--set", "sweep.rolling.load_n=[0.1, 0.2]", "--workers", "1"]
    assert cli.main(["run", str(scene), *settings, "--out", str(out)]) == 130
    assert "rolling resume" in capsys.readouterr().err
    assert ("running", "waiting") in seen or ("waiting", "running") in seen
    states = sorted(
        (record(out / name).state, record(out / name).reason)
        for name in ("load_n=0.1", "load_n=0.2")
    )
    assert states == [("done", None), ("waiting", "interrupted")]
    assert (record(out).state, record(out).reason, record(out).process) == (
        "waiting",
        "interrupted",
        None,
    )
    monkeypatch.undo()
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])
    # One run by itself, the last one: the sweep is done with it, and nothing is solved again.
    waiting = next(name for name in record(out).runs if record(out / name).state == "waiting")
    assert cli.main(["resume", str(out / waiting), "--workers", "1"]) == 0
    assert record(out / waiting).state == "done" and record(out).state == "done"
    monkeypatch.setattr(batch.simulate, "simulate_piece", None)
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
    assert record(out).state == "done"


def test_values_that_print_alike_have_results_of_their_own(scene, tmp_path) -> None:
    """An earlier version replaced the result of the first seed by that of the second."""
    out = tmp_path / "out"
    seeds = "sweep.surface.seed=[10000000000000000, 10000000000000001]"
    assert cli.main(["run", str(scene), "--set", seeds, "--out", str(out), "--workers", "1"]) == 0
    names = ["seed=10000000000000000", "seed=10000000000000001"]
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == names
    releases = [
        result_file.load(out / name / "result.h5").series["release_energy"] for name in names
    ]
    assert not np.array_equal(*releases)
    assert [one.folder.name for one in commands.read_runs(out)] == names
    sounds = tmp_path / "far"
    assert cli.main(["resound", str(out), "--set", "sound.distance_m=2", "--out", str(sounds)]) == 0
    assert np.array_equal(
        result_file.load(sounds / names[0] / "result.h5").series["release_energy"], releases[0]
    )


def test_ten_swept_keys_have_a_folder_that_can_be_made(scene, tmp_path) -> None:
    """An earlier version failed with "File name too long" after it had made the sweep's folder."""
    keys = {
        "sphere.radius_mm": 5.123456789,
        "plate.youngs_modulus_gpa": 210.123456789,
        "plate.poissons_ratio": 0.3123456789,
        "surface.roughness_ra_um": 0.123456789,
        "surface.correlation_length_um": 10.123456789,
        "surface.seed": 123456789,
        "rolling.load_n": 0.123456789,
        "rolling.speed_m_s": 0.1123456789,
        "rolling.duration_s": 0.002123456789,
        "sound.distance_m": 1.123456789,
        "sound.q": 0.5123456789,
        "numerics.tolerance": 1.123456e-4,
    }
    settings = [word for key, value in keys.items() for word in ("--set", f"sweep.{key}=[{value}]")]
    out = tmp_path / "out"
    assert cli.main(["run", str(scene), *settings, "--out", str(out), "--workers", "1"]) == 0
    (name,) = record(out).runs
    assert len(name) == run_names.LONGEST and record(out / name).state == "done"
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0


# ---- folders of version 0.1.0


@pytest.mark.parametrize("sweep", [False, True])
def test_folders_of_version_0_1_0_are_read_with_one_warning_and_never_replaced(
    scene, tmp_path, sweep, refused, capsys, monkeypatch
) -> None:
    monkeypatch.setattr(report, "exhibits", lambda *_: [])
    monkeypatch.setattr(report, "page", lambda *_: PAGE)
    old, settings = tmp_path / "old", ["--workers", "1"]
    if sweep:
        settings += ["--set", "sweep.rolling.load_n=[0.1, 0.2]"]
    assert cli.main(["run", str(scene), *settings, "--out", str(old)]) == 0
    as_by_0_1_0(old)
    assert "version 0.1.0" in refused("run", scene, "--out", old, "--force")
    for command in (
        ["resound", old, "--set", "sound.distance_m=2", "--out", tmp_path / "new"],
        ["report", old, "--out", tmp_path / "page.html"],
        ["resume", old, "--workers", "1"],
    ):
        capsys.readouterr()
        assert cli.main([str(word) for word in command]) == 0
        lines = [line for line in capsys.readouterr().err.splitlines() if "version 0.1.0" in line]
        assert len(lines) == 1 and lines[0].startswith(f"warning: {old}")
    assert (
        record(old).adopted and record(old).state == "done" and not record(tmp_path / "new").adopted
    )
    assert "version 0.1.0" in refused("run", scene, "--out", old, "--force")


def test_runs_that_version_0_1_0_mixed_up_are_refused(scene, tmp_path, refused) -> None:
    old = tmp_path / "old"
    seeds = "sweep.surface.seed=[10000000000000000, 10000000000000001]"
    assert cli.main(["run", str(scene), "--set", seeds, "--out", str(old), "--workers", "1"]) == 0
    (old / "seed=10000000000000000").rename(old / "seed=1e+16")
    shutil.rmtree(old / "seed=10000000000000001")
    as_by_0_1_0(old)
    for command in ("resume", "resound", "report"):
        assert "several runs share the folder seed=1e+16" in refused(command, old)


def test_a_damaged_run_json_is_one_message(out, scene, refused) -> None:
    (out / "run.json").write_text(
        '{"program": "rolling-contact-noise", "format": 1, "state": "done"}'
    )
    for command in (
        ["resume", out],
        ["resound", out],
        ["report", out],
        ["run", scene, "--out", out, "--force"],
    ):
        message = refused(*command)
        assert "run.json: damaged" in message and message.count("\n") == 1


def test_a_result_begun_by_another_state_of_the_program_is_said(out, capsys) -> None:
    result = result_file.load(out / "result.h5")
    for name in simulate.STEP_SERIES:
        result.series[name][50:] = np.nan
    for name in simulate.STATE_SERIES:
        result.series[name][51:] = np.nan
    result.maps = {position: each for position, each in result.maps.items() if position <= 50}
    batch.keep(commands.read_runs(out)[0], result)
    content = json.loads((out / "run.json").read_text())
    files.write_json(out / "run.json", content | {"sources": "0" * 64, "version": "0.1.9"})
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
    assert (
        "begun by version 0.1.9 (sources 000000000000), goes on with version"
        in capsys.readouterr().err
    )
    assert record(out).sources != "0" * 64


def test_the_heights_are_found_again_from_a_linked_folder(scene, tmp_path) -> None:
    """An earlier version looked for the heights relative to the link."""
    np.save(scene.parent / "z.npy", np.random.default_rng(1).standard_normal((250, 40)) * 1e-8)
    scene.write_text(
        SCENE.replace(SCENE.splitlines()[3], "surface: {kind: file, path: z.npy, spacing_um: 2}")
    )
    (tmp_path / "deep" / "er").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "deep" / "er")
    out = tmp_path / "link" / "out"
    assert cli.main(["run", str(scene), "--out", str(out), "--workers", "1"]) == 0
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
