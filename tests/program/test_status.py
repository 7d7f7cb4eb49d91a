"""The status of a folder is what the run.json in it say."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from rolling import cli
from rolling.folders import run_record, status
from rolling.folders.process import Process, this_process
from rolling.folders.run_record import RunRecord, State

NAMES = ("load_n=1", "load_n=2", "load_n=3", "load_n=4", "load_n=5", "load_n=6")


def mark(folder: Path, state: State, reason: str | None = None) -> RunRecord:
    folder.mkdir(exist_ok=True)
    record = run_record.new("run").with_state(state, reason)
    run_record.write(folder, record)
    return record


@pytest.fixture
def sweep(tmp_path: Path) -> Path:
    """A sweep with a run in each state: done, running, killed, failed, interrupted, never begun."""
    folder = tmp_path / "sweep"
    folder.mkdir()
    run_record.write(folder, run_record.new("sweep", NAMES))
    (folder / "resolved.yaml").write_text("name: six\n")
    mark(folder / NAMES[0], "done")
    mark(folder / NAMES[1], "running")
    killed = mark(folder / NAMES[2], "running")
    gone = Process(this_process().host, os.getpid(), "", this_process().birth + "0")
    run_record.write(folder / NAMES[2], replace(killed, process=gone, starts=3))
    mark(folder / NAMES[3], "failed", "the load exceeds the capacity of the surface")
    mark(folder / NAMES[4], "waiting", "interrupted")
    (folder / NAMES[5]).mkdir()
    return folder


def test_every_run_has_its_state(sweep: Path) -> None:
    every = status.statuses(sweep)
    assert [each.name for each in every] == [*NAMES]
    states = ["done", "running", "waiting", "failed", "waiting", "waiting"]
    assert [each.state for each in every] == states
    assert f"process {os.getpid()} on host" in every[1].remark
    assert "was killed" in every[2].remark and "begun 3 times" in every[2].remark
    assert not status.is_at_rest(every)


def test_status_counts_and_names_who_needs_a_look(
    sweep: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["status", str(sweep)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{sweep}: 6 runs: 1 done, 1 running, 3 waiting, 1 failed"
    assert any(NAMES[3] in line and "capacity of the surface" in line for line in lines)
    assert not any(NAMES[0] in line or NAMES[5] in line for line in lines[1:])


def test_a_damaged_record_fails_its_run_alone(sweep: Path) -> None:
    (sweep / NAMES[0] / "run.json").write_text("{")
    every = status.statuses(sweep)
    assert every[0].state == "failed" and "damaged" in every[0].remark
    assert every[3].state == "failed"


def test_a_folder_of_something_else_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["status", str(tmp_path)]) == 2
    assert "not a run folder" in capsys.readouterr().err


def test_watching_ends_when_no_run_is_left(
    sweep: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def finish_one(seconds: float) -> None:
        left = [each for each in status.statuses(sweep) if each.state not in ("done", "failed")]
        mark(sweep / left[0].name, "done")

    monkeypatch.setattr("time.sleep", finish_one)
    assert cli.main(["status", str(sweep), "--watch"]) == 0
    printed = capsys.readouterr().out
    assert "1 done, 1 running" in printed and "5 done, 1 failed" in printed


def test_starts_are_counted(tmp_path: Path) -> None:
    record = run_record.new("run")
    for _ in range(3):
        record = record.with_state("running").with_state("waiting", "interrupted")
    assert record.starts == 3
    run_record.write(tmp_path, record)
    assert run_record.read(tmp_path) == record
