"""A kind of scene that the program does not know has all that the kinds of the program have."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ball_between_plates import AIR, KIND, BetweenPlates
from commands import PATIENCE, ROOT, pieces, wait_for
from report_browser import data_of

import rolling
from rolling import cli
from rolling.contact.closed_forms import hertz_approach
from rolling.kinds import registry
from rolling.run import folder as folders

AMPLITUDE_UM = 0.05
SCENE = f"""\
name: pair
title: A ball between two plates
plates: {{radius_mm: 5, waves: 4, amplitude_um: {AMPLITUDE_UM}, load_n: 1, speed_m_s: 2}}
"""
SWEEP = f"{SCENE}sweep: {{plates.load_n: [1, 2]}}\n"
# A program that knows the kind by a call alone: its worker processes cannot import it.
PROGRAM = """\
import sys
sys.path.insert(0, {support!r})
from ball_between_plates import KIND
import rolling
from rolling import cli
rolling.register(KIND)
sys.exit(cli.main(sys.argv[1:]))
"""


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let the program know the kind for a test."""
    monkeypatch.setattr(registry, "_added", dict(registry._added))
    rolling.register(KIND)
    yield


def written(folder: Path, text: str = SCENE) -> Path:
    """Write a scene file into a folder."""
    path = folder / "pair.yaml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a sweep over two loads, run by the command."""
    home = tmp_path_factory.mktemp("pair")
    words = ["run", str(written(home, SWEEP)), "--out", str(home / "out"), "--workers", "1", "-q"]
    with pytest.MonkeyPatch.context() as patch:  # tests of other files know no such kind
        patch.setattr(registry, "_added", dict(registry._added))
        rolling.register(KIND)
        assert cli.main(words) == 0
    return home / "out"


def test_the_answer_is_that_of_hertz_and_of_a_rigid_ball(kept: Path) -> None:
    """Both contacts give way by Hertz, and an even number of waves lifts the plate twice."""
    for load_n in (1, 2):
        run = rolling.open_run(kept / f"load_n={load_n}")
        hertz_m = hertz_approach(load_n, 5e-3, KIND.marches(run.scene)[0].scene.contact_modulus)
        assert run.numbers.approach.value == pytest.approx(2e6 * hertz_m, rel=0.01)
        speed_um_s = 2 * np.pi * run.scene.tone_hz * 2 * AMPLITUDE_UM / np.sqrt(2)
        assert run.numbers.velocity.value == pytest.approx(speed_um_s, rel=2e-3)
        pressure = np.sqrt(np.mean(np.square(run.sound.samples)))
        assert pressure == pytest.approx(1e-6 * AIR * speed_um_s, rel=2e-3)


def test_an_odd_number_of_waves_leaves_the_plate_at_rest() -> None:
    scene = BetweenPlates.from_dict(
        {
            "name": "constant-width",
            "plates": {"radius_mm": 5, "waves": 3, "amplitude_um": AMPLITUDE_UM}
            | {"load_n": 1, "speed_m_s": 2},
        }
    )
    run = rolling.simulate(scene, workers=1, progress=False)
    assert run.numbers.velocity.value < 0.01 * 2 * np.pi * scene.tone_hz * AMPLITUDE_UM


def test_a_scene_is_read_by_its_section_and_its_faults_are_named(tmp_path: Path) -> None:
    assert rolling.read_scene(written(tmp_path)).tone_hz == pytest.approx(254.65, rel=1e-4)
    with pytest.raises(rolling.SceneError, match=r"plates\.waves: got 1"):
        rolling.read_scene(written(tmp_path), ["plates.waves=1"])
    schema = cli.main(["schema", "--kind", KIND.name])
    assert schema == 0


def test_check_tells_time_and_nodes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check", str(written(tmp_path))]) == 0
    said = capsys.readouterr().out
    assert said.startswith("It runs in")
    assert "6.5 nodes per Hertz radius" in said
    assert len(rolling.read_scene(written(tmp_path)).check().runs) == 1
    huge = ["check", str(written(tmp_path)), "--set", "plates.radius_mm=1e9"]
    assert cli.main([*huge, "--set", "plates.load_n=1e12"]) != 0


def test_a_folder_has_files_status_table_page_and_gallery(
    kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (kept / "report.html").read_text().count("The upper plate moves at") >= 2
    charts = data_of(kept / "report.html")["charts"]
    assert [(chart["name"], chart["x"]["label"]) for chart in charts] == [
        ("quantities", "plates.load_n")
    ]
    assert len([*(kept / "contacts").glob("*.npz")]) == 2
    assert not pieces(kept)
    assert cli.main(["status", str(kept)]) == 0
    assert "2 runs: 2 done" in capsys.readouterr().out
    assert cli.main(["table", str(kept)]) == 0
    assert "velocity of the plate" in capsys.readouterr().out
    assert (kept / "statistics.csv").is_file()
    assert cli.main(["gallery", str(kept), "--out", str(tmp_path / "gallery.html")]) == 0
    assert "The upper plate moves at" in (tmp_path / "gallery.html").read_text()


def test_a_damaged_result_is_refused(kept: Path, tmp_path: Path) -> None:
    copied = shutil.copytree(kept, tmp_path / "copied") / "load_n=1"
    content = bytearray((copied / "result.h5").read_bytes())
    content[len(content) // 2] ^= 1
    (copied / "result.h5").write_bytes(content)
    with pytest.raises(rolling.FolderError, match="damaged"):
        rolling.open_run(copied)


def test_resound_keeps_the_marches_and_refuses_another_load(
    kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["resound", str(kept), "--no-report", "-q", "--workers", "1"]
    assert cli.main([*words, "--set", "plates.load_n=3"]) == 2
    said = capsys.readouterr().err
    assert "plates.load_n: needs a new run" in said
    assert cli.main([*words, "--set", "plates.speed_m_s=2", "--set", "plates.waves=6"]) == 2
    said = capsys.readouterr().err
    assert "plates.waves: needs a new run" in said and "plates.speed_m_s" not in said
    monkeypatch.setattr("rolling.run.worker.solve_piece", None)  # nothing is marched
    out = tmp_path / "slower"
    assert cli.main([*words, "--set", "plates.turns=3", "--out", str(out)]) == 0
    slower = rolling.open_run(out / "load_n=1")
    assert len(slower.arrays["time"]) == 3 * 400


def test_a_sweep_in_python_has_table_dataset_and_files(kept: Path, tmp_path: Path) -> None:
    runs = rolling.simulate_sweep(rolling.read_scene(kept / "scene.yaml"), 1, progress=False)
    assert runs.table()["velocity_um_s"].notna().all()
    assert "velocity of the plate" in repr(runs) and "<pre>" in runs._repr_html_()
    data = runs.to_xarray()
    np.testing.assert_array_equal(data["height"].sel(load_n=2), runs[2].arrays["height"])
    assert data["time"].dims == ("time",)
    alone = runs[1].save(tmp_path / "alone", report=False)
    back = rolling.open_run(alone)
    assert back.numbers.velocity == runs[1].numbers.velocity
    np.testing.assert_array_equal(back.sound.samples, runs[1].sound.samples)
    assert cli.main(["table", str(alone)]) == 0  # of a single run


def test_a_recording_is_compared_with_its_sound(
    kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "long"
    words = ["resound", str(kept), "--no-report", "-q", "--workers", "1"]
    assert cli.main([*words, "--set", "plates.turns=40", "--out", str(out)]) == 0
    run = out / "load_n=1"
    capsys.readouterr()
    assert cli.main(["compare", str(run), str(run / "signal.wav"), "--calibration", "1"]) == 0
    assert "0.0 ±" in capsys.readouterr().out
    signal = str(run / "signal.wav")
    assert cli.main(["compare", str(run), signal, "--quantity", "velocity"]) == 2
    assert "the record of the run is in Pa" in capsys.readouterr().err


def test_twice_the_waves_are_six_decibels_louder(tmp_path: Path) -> None:
    scene = rolling.read_scene(written(tmp_path), ["sweep.plates.amplitude_um=[0.05, 0.1]"])
    choice = rolling.choose(scene, workers=1, progress=False, folder=tmp_path / "choice")
    assert choice.contenders[0].label == "plates.amplitude_um 0.05"
    assert "6.0 dB(A) quieter" in choice.sentences[0]


def command(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Start a command of a program that registers the kind, in a process of its own."""
    program = folder / "program.py"
    program.write_text(PROGRAM.format(support=str(Path(__file__).parents[1] / "support")))
    return subprocess.Popen(
        [sys.executable, "-P", str(program), *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


@pytest.mark.slow
def test_worker_processes_get_the_kind_from_their_parent_and_a_kill_loses_no_piece(
    tmp_path: Path,
) -> None:
    """The programs of workers find no file of the kind, and nothing that is solved is lost."""
    loads = [round(1 + 0.1 * number, 1) for number in range(6)]
    scene = written(tmp_path, f"{SCENE}sweep: {{plates.load_n: {loads}}}\n")
    out = tmp_path / "out"
    words = ["run", str(scene), "--out", str(out), "--workers", "2"]
    killed = command(tmp_path, *words)
    wait_for(lambda: [*out.glob("contacts/*.npz")] or killed.poll() is not None)
    killed.kill()
    killed.communicate(timeout=PATIENCE)
    kept_marches = {path: path.stat().st_mtime_ns for path in out.glob("contacts/*.npz")}
    kept_pieces = {path: path.stat().st_mtime_ns for path in pieces(out)}
    assert kept_marches and kept_pieces
    again = command(tmp_path, *words)
    said, _ = again.communicate(timeout=PATIENCE)
    assert again.returncode == 0, said
    assert all(path.stat().st_mtime_ns == time for path, time in kept_marches.items())
    states = {state for state, _ in folders.states(out).values()}
    assert states == {"done"} and (out / "report.html").is_file()
    assert not pieces(out)
