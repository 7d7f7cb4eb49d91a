"""Sweeps of many runs: four files per run, which resume, resound, report and Python read; pictures
drawn by several processes; nothing lost when the work is killed between two files.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scene_text import TINY

from rolling import cli
from rolling.check import demand
from rolling.commands import drawing, table, work
from rolling.commands.interface import open_run
from rolling.folders import files, run_record
from rolling.report import page
from rolling.simulation import result_file, simulate
from rolling.terminal import defaults

SCENE = TINY + "sweep: {surface.seed: [1, 2, 3]}\n"
FOUR = ["result.h5", "run.json", "signal.wav", "summary.json"]
TOGETHER = {"report.html", "resolved.yaml", "run.json", "runs.csv", "scene.yaml", "sweep.json"}


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A sweep of three runs, which are many here."""
    monkeypatch.setattr(demand, "PAGE_RUNS", 2)
    monkeypatch.setattr(page, "MOST_RUNS", 2)
    path = tmp_path / "tiny.yaml"
    path.write_text(SCENE)
    return path


def run(scene: Path, out: Path, *more: str) -> int:
    return cli.main(["run", str(scene), "--out", str(out), "--workers", "1", *more])


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir() if path.is_file() and path.name != ".lock"}


def test_each_run_writes_four_files_and_all_share_pictures_and_page(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[0] == f"files: {out}"
    assert str(out / "seed=1" / "signal.wav") in printed and str(out / "report.html") in printed
    for seed in (1, 2, 3):
        folder = out / f"seed={seed}"
        assert sorted(names(folder)) == FOUR
        assert run_record.read(folder).state == "done"
        assert json.loads((folder / "summary.json").read_text())["provenance"]["packages"]
    together = names(out)
    assert together >= TOGETHER | {"levels.svg", "third_octaves.png", "spectrum.csv"}
    assert not together & {"surface.png", "contact.png"}
    html = (out / "report.html").read_text()
    assert page.is_page(out / "report.html")
    for text in ("seed 1", "seed 3", "runs.csv", "rolling run tiny.yaml", "numpy"):
        assert text in html
    assert "<audio" not in html
    # The page is made again, and all of it is this program's own to replace.
    (out / "report.html").unlink()
    assert cli.main(["report", str(out)]) == 0
    assert (out / "report.html").read_text() == html
    assert run(scene, out, "--force", "--no-pictures") == 0
    assert names(out) == TOGETHER - {"report.html"}


def test_very_many_runs_share_pictures_of_their_means_without_a_page(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Curves of more than 400 runs would hide one another."""
    monkeypatch.setattr(defaults, "MOST_RUNS_COMPARED", 2)
    monkeypatch.setattr(defaults, "FEW_RUNS", 1)
    out = tmp_path / "out"
    assert run(scene, out, "--set", "sweep={rolling.load_n: [0.005, 0.01, 0.02]}") == 0
    means = {f"mean_third_octaves.{ending}" for ending in ("csv", "png", "svg")}
    plot = {f"plot_laeq_db_against_rolling.load_n.{ending}" for ending in ("csv", "png", "svg")}
    assert names(out) == (TOGETHER - {"report.html"}) | means | plot
    printed = capsys.readouterr().out
    assert "load 0.005 N" in printed and "load 0.02 N" not in printed
    assert "2 more runs, a row each in runs.csv" in printed


def test_plots_of_the_means_that_fail_hide_no_result(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(defaults, "MOST_RUNS_COMPARED", 2)
    out = tmp_path / "out"

    def fail(*_: object) -> None:
        raise ValueError("an empty third octave")

    with monkeypatch.context() as patch:
        patch.setattr(table, "summarize", fail)
        assert run(scene, out) == 1
    said = capsys.readouterr()
    assert "seed 1" in said.out and (out / "runs.csv").is_file()
    assert said.err.splitlines()[-2:] == [
        "not made: plots of the means: ValueError: an empty third octave",
        f"all runs are solved; `rolling resume {out}` makes the rest",
    ]
    assert {run_record.read(out / f"seed={k}").state for k in (1, 2, 3)} == {"done"}
    assert run_record.read(out).state == "failed"
    with monkeypatch.context() as patch:
        patch.setattr(simulate, "simulate_piece", None)  # all is solved
        assert cli.main(["resume", str(out)]) == 0
    assert (out / "mean_third_octaves.png").is_file() and run_record.read(out).state == "done"


def test_a_page_that_fails_hides_no_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "alone.yaml", tmp_path / "out"
    path.write_text(TINY)
    monkeypatch.setattr(work, "write_pictures", lambda *_: [(None, None)])
    monkeypatch.setattr(work, "page_of", lambda *_: {}["picture"])
    assert run(path, out) == 1
    said = capsys.readouterr()
    assert "not made: page: KeyError: 'picture'" in said.err and "LAeq" in said.out
    with pytest.raises(OSError, match="not made: page: KeyError"):
        open_run(out).save(tmp_path / "saved")


def test_a_run_of_four_files_is_read_like_any_other(
    scene: Path, tmp_path: Path, undrawn: None, capsys: pytest.CaptureFixture[str]
) -> None:
    out, far, alone = tmp_path / "out", tmp_path / "far", tmp_path / "alone"
    assert run(scene, out) == 0
    one = open_run(out / "seed=2")
    assert one.scene.surface.seed == 2 and one.result.complete
    assert (
        one.summary["laeq_db"]
        == json.loads((out / "sweep.json").read_text())[1]["summary"]["laeq_db"]
    )
    settings = ["--set", "sound.distance_m=10"]
    assert cli.main(["resound", str(out), *settings, "--out", str(far)]) == 0
    assert sorted(names(far / "seed=3")) == FOUR
    assert cli.main(["resound", str(out / "seed=2"), *settings, "--out", str(alone)]) == 0
    quieter = json.loads((alone / "summary.json").read_text())
    assert quieter["level_db"] == pytest.approx(one.summary["level_db"] - 20, abs=1e-6)
    assert (alone / "listen.wav").is_file()  # a run alone has all files
    assert cli.main(["resume", str(out / "seed=2")]) == 0


def test_a_run_of_four_files_shows_its_scene_and_maker_on_a_page(
    scene: Path, tmp_path: Path, undrawn: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    assert cli.main(["report", str(out / "seed=1"), "--out", str(tmp_path / "one.html")]) == 0
    html = (tmp_path / "one.html").read_text()
    assert "seed: 1" in html and "<audio" in html and "numpy" in html


def test_runs_csv_has_a_row_per_run(scene: Path, tmp_path: Path, undrawn: None) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    with (out / "runs.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["run"] for row in rows] == ["seed 1", "seed 2", "seed 3"]
    assert [row["surface.seed"] for row in rows] == ["1", "2", "3"]
    for row in rows:
        numbers = json.loads((out / row["folder"] / "summary.json").read_text())
        for key, value in numbers.items():
            if isinstance(value, bool):
                assert row[key] == str(value).lower()
            elif isinstance(value, int | float):
                assert float(row[key]) == value
        assert float(row["laeq_uncertainty_db"]) == numbers["uncertainty_db"]["laeq"]
        assert float(row["surface_rq_m"]) == numbers["surface"]["rq"]
        assert row["caveats"].split() == [caveat["key"] for caveat in numbers["caveats"]]


class Killed(BaseException):
    """The end of the process, as nothing catches it."""


@pytest.mark.parametrize("after", [1, 2, 3, 5, 7, 9, 14])
def test_a_sweep_that_is_killed_between_two_files_is_resumed(
    scene: Path, tmp_path: Path, undrawn: None, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    """Whole files before the kill, none after it; resumed, all is there and solved once."""
    whole, out = tmp_path / "whole", tmp_path / "out"
    assert run(scene, whole) == 0
    inner, written = files.write_bytes, 0

    def write(path: Path, content: bytes) -> None:
        nonlocal written
        if out in path.parents and path.parent != out:
            written += 1
            if written > after:
                raise Killed
        inner(path, content)

    with monkeypatch.context() as patch:
        for module in (files, result_file):
            patch.setattr(module, "write_bytes", write)
        with pytest.raises(Killed):
            run(scene, out)
    kept = [seed for seed in (1, 2, 3) if (out / f"seed={seed}" / "result.h5").is_file()]
    solved: list[int] = []
    march = simulate.simulate_piece
    monkeypatch.setattr(
        simulate,
        "simulate_piece",
        lambda given, *more, **named: (
            solved.append(given.surface.seed),
            march(given, *more, **named),
        )[1],
    )
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
    assert sorted([*kept, *solved]) == [1, 2, 3]
    for seed in (1, 2, 3):
        folder = out / f"seed={seed}"
        assert sorted(names(folder)) == FOUR
        assert run_record.read(folder).state == "done"
        assert (folder / "signal.wav").read_bytes() == (
            whole / folder.name / "signal.wav"
        ).read_bytes()


def test_an_unsolved_run_names_the_sweep_to_resume(
    scene: Path, tmp_path: Path, undrawn: None, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(scene, out) == 0
    (out / "seed=2" / "result.h5").unlink()
    capsys.readouterr()
    assert cli.main(["resume", str(out / "seed=2")]) == 2
    assert f"`rolling resume {out}`" in capsys.readouterr().err
    assert cli.main(["resume", str(out), "--workers", "1"]) == 0
    assert np.isfinite(open_run(out / "seed=2").release_power).all()


def test_pictures_are_the_same_from_any_number_of_processes(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two runs are many here."""
    monkeypatch.setattr(demand, "PAGE_RUNS", 1)
    monkeypatch.setattr(page, "MOST_RUNS", 1)
    out, two = tmp_path / "out", ["--set", "sweep.surface.seed=[1, 2]"]
    assert run(scene, out, *two, "--pictures", "--no-report") == 0
    assert not (out / "report.html").exists()
    inside = out / "seed=2"
    before = {
        path.name: path.read_bytes()
        for path in inside.iterdir()
        if path.suffix in (".svg", ".png", ".csv")
    }
    assert {"surface.png", "contact.svg", "psd.csv", "spectrogram.svg"} <= set(before)
    assert (inside / "listen.wav").is_file() and (inside / "resolved.yaml").is_file()
    for name in before:
        (inside / name).unlink()
    monkeypatch.setattr(drawing, "_WORTH_A_PROCESS", 1)
    assert cli.main(["resume", str(out), "--workers", "2", "--pictures", "--no-report"]) == 0
    assert {name: (inside / name).read_bytes() for name in before} == before


def test_a_worker_that_is_killed_while_it_draws_loses_nothing(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"

    def killed(*_: object) -> drawing.pool.Outcome:
        return drawing.pool.Outcome({0: "a worker process was killed"})

    with monkeypatch.context() as patch:
        # The solver has the same pool.
        patch.setattr(
            work,
            "write_pictures",
            lambda folder, runs, wanted: (
                patch.setattr(drawing.pool, "work", killed),
                drawing.draw(folder, runs, True, False, 1),
            ),
        )
        assert run(scene, out) == 1
    message = capsys.readouterr().err
    assert "a worker process was killed" in message and f"`rolling resume {out}`" in message
    assert run_record.read(out).state == "failed"
    with monkeypatch.context() as patch:
        patch.setattr(simulate, "simulate_piece", None)  # all is solved
        assert cli.main(["resume", str(out), "--no-pictures"]) == 0
    assert run_record.read(out).state == "done"
