"""Parts of a sweep: in any order, side by side, again after a loss, and never twice at once."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from processes import Child
from scene_text import TINY

from rolling import cli
from rolling.check import demand
from rolling.commands import work
from rolling.folders import claim, new_folder, run_record
from rolling.report import page

SCENE = TINY + "sweep: {surface.seed: [1, 2, 3, 4, 5]}\n"


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A sweep of five runs, which are many here, without pictures."""
    monkeypatch.setattr(demand, "PAGE_RUNS", 2)
    monkeypatch.setattr(page, "MOST_RUNS", 2)
    monkeypatch.setattr(work, "write_pictures", lambda *_: [])
    path = tmp_path / "tiny.yaml"
    path.write_text(SCENE)
    return path


def run(scene: Path, out: Path, part: str, *more: str) -> int:
    words = ["run", str(scene), "--out", str(out), "--workers", "1", *more]
    return cli.main([*words, "--part", part] if part else words)


def states(folder: Path) -> dict[str, str]:
    return {
        name: record.state if (record := run_record.read(folder / name)) else "none"
        for name in run_record.read(folder).runs
    }


def table(folder: Path) -> list[dict]:
    """Return the runs of a sweep without the times that they took."""
    rows = json.loads((folder / "sweep.json").read_text())
    for row in rows:
        for key in [key for key in row["summary"] if key.endswith(("seconds", "step_ms"))]:
            del row["summary"][key]
    return rows


def test_parts_in_any_order_give_the_table_of_the_whole(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole, out = tmp_path / "whole", tmp_path / "out"
    assert run(scene, whole, "") == 0
    assert run(scene, out, "2/3") == 0
    done = ["seed=2", "seed=5"]
    assert states(out) == {
        f"seed={k}": "done" if f"seed={k}" in done else "none" for k in range(1, 6)
    }
    assert not (out / "runs.csv").exists() and run_record.read(out).state == "waiting"
    assert run(scene, out, "3/3") == 0
    capsys.readouterr()
    assert run(scene, out, "1/3") == 0
    assert "that was the last run" in capsys.readouterr().err
    assert set(states(out).values()) == {"done"} and run_record.read(out).state == "done"
    assert table(out) == table(whole)
    for name in states(whole):
        assert (out / name / "signal.wav").read_bytes() == (
            whole / name / "signal.wav"
        ).read_bytes()
    # All of it is this program's own to replace, and a finished part is left alone.
    before = (out / "sweep.json").stat().st_mtime_ns
    assert run(scene, out, "1/3") == 0
    assert (out / "sweep.json").stat().st_mtime_ns == before
    assert run_record.read(out / "seed=1").starts == 1
    assert run(scene, out, "", "--force") == 0
    assert not (out / "parts").exists()


def test_the_second_of_the_same_part_is_refused_and_a_lost_part_runs_again(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert run(scene, out, "2/2") == 0

    def hold(child: Child) -> None:
        with claim.take_part(out, "1-of-2", ["seed=1", "seed=3", "seed=5"]):
            child.say("held")
            child.hear()

    first = Child(hold)
    assert first.hear() == "held"
    capsys.readouterr()
    assert run(scene, out, "1/2") == 2
    assert f"process {first.pid}" in capsys.readouterr().err
    assert run(scene, out, "1/3") == 2  # shares runs with it
    assert cli.main(["resume", str(out)]) == 2
    assert cli.main(["status", str(out)]) == 0
    assert "part 1-of-2: running" in capsys.readouterr().out
    first.kill()
    assert run(scene, out, "1/2") == 0
    assert set(states(out).values()) == {"done"}
    assert run_record.read(out / "parts" / "1-of-2").starts == 2
    assert run_record.read(out).state == "done"


def test_a_part_beyond_the_last_run_does_nothing(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An array job may have more parts than its sweep has runs."""
    out = tmp_path / "out"
    assert run(scene, out, "6/7") == 0
    said = capsys.readouterr()
    assert "part 6/7: 0 of 5 runs" in said.err and said.out == f"files: {out}\n"
    assert set(states(out).values()) == {"none"}


def test_a_failed_run_stops_no_part_and_is_named_in_the_end(scene: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    load = ["--set", "sweep.rolling.load_n=[0.005, 5000, 0.006]", "--set", "surface.seed=1"]
    assert run(scene, out, "2/3", *load) == 1
    failed = {"load_n=5000": "failed"}
    assert states(out) == {"load_n=0.005": "none", "load_n=0.006": "none"} | failed
    assert run(scene, out, "1/3", *load) == 0
    assert run(scene, out, "3/3", *load) == 1
    assert states(out) == {"load_n=0.005": "done", "load_n=0.006": "done"} | failed
    assert run_record.read(out).state == "failed"
    assert run_record.read(out / "load_n=5000").starts == 1  # the last part does not try it again
    assert len(json.loads((out / "sweep.json").read_text())) == 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--part", "4/3", "--out", "out"], "got '4/3', allowed: K/N"),
        (["--part", "0/3", "--out", "out"], "got '0/3', allowed: K/N"),
        (["--part", "a/b", "--out", "out"], "got 'a/b', allowed: K/N"),
        (["--part", "1/2"], "--out FOLDER"),
        (["--part", "1/2", "--out", "out", "--force"], "without --force"),
        (["--part", "1/2", "--out", "out", "--set", "surface.seed=1"], "the scene has none"),
        (["--part", "1/2", "--out", "taken"], "another scene, which differs in rolling"),
    ],
)
def test_bad_parts_are_refused(
    scene: Path,
    tmp_path: Path,
    words: list[str],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if "taken" in words:
        assert run(scene, tmp_path / "taken", "1/5", "--set", "rolling.load_n=0.006") == 0
    try:
        assert cli.main(["run", str(scene), *words]) == 2
    except SystemExit as end:  # of the parser
        assert end.code == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_of_parts_that_begin_at_once_one_makes_the_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"

    def make(child: Child) -> None:
        child.hear()
        made = new_folder.make_shared(
            out,
            run_record.new("sweep", ["a"]),
            lambda folder: (folder / "resolved.yaml").write_text("name: x\n"),
        )
        child.say(f"{made} {(out / 'resolved.yaml').is_file()}")

    children = [Child(make) for _ in range(6)]
    for child in children:
        child.say("go")
    assert sorted(child.hear() for child in children) == ["False True"] * 5 + ["True True"]
    assert [child.wait() for child in children] == [0] * 6
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
