"""A single process works on a folder at a time, and claims of killed processes are void."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from processes import Child

from rolling.folders import claim, process, run_record
from rolling.folders.files import FolderError


def made(folder: Path, runs: tuple[str, ...] = ()) -> Path:
    """Make a folder of a run, or of a sweep with these runs, that no process works on."""
    folder.mkdir()
    run_record.write(folder, run_record.new("sweep" if runs else "run", runs))
    for name in runs:
        made(folder / name)
    return folder


def holding(folder: Path) -> Child:
    """Start another process that works on a folder."""

    def work(child: Child) -> None:
        with claim.take(folder, "run") as held:
            child.say("taken")
            child.hear()
            held.mark(folder, "done")

    child = Child(work)
    assert child.hear() == "taken"
    return child


def state(folder: Path) -> str:
    record = run_record.read(folder)
    assert record is not None
    return record.state


def test_the_second_is_refused_and_told_of_the_first(tmp_path: Path) -> None:
    run = made(tmp_path / "run")
    first = holding(run)
    record = run_record.read(run)
    assert record is not None and record.state == "running"
    for take_over in (False, True):  # one that is seen to live is never taken over
        with pytest.raises(FolderError, match="in use") as refusal:
            claim.take(run, "run", take_over=take_over)
        message = str(refusal.value)
        assert (
            f"process {first.pid} on host {os.uname().nodename} since {record.changed}" in message
        )
    first.say("end")
    assert first.wait() == 0 and state(run) == "done"
    with claim.take(run, "run") as held:
        held.mark(run, "done")


def test_claims_of_killed_and_of_reborn_processes_count_for_nothing(tmp_path: Path) -> None:
    run = made(tmp_path / "run")
    holding(run).kill()
    record = run_record.read(run)
    assert record is not None and record.state == "running" and record.process is not None
    # Another process has the number now: this one.
    run_record.write(run, replace(record, process=replace(record.process, pid=os.getpid())))
    with claim.take(run, "run") as held:
        assert held.record.process is not None and held.record.process.pid == os.getpid()
        held.mark(run, "done")
    assert state(run) == "done"


def test_a_claim_of_another_host_has_one_way_out(tmp_path: Path) -> None:
    run = made(tmp_path / "run")
    there = replace(process.this_process(), host="node17", pid=4711)
    run_record.write(run, replace(run_record.new("run"), state="running", process=there))
    with pytest.raises(FolderError) as refusal:
        claim.take(run, "run")
    message = str(refusal.value)
    assert (
        "process 4711 on host node17" in message
        and f"`rolling resume {run} --take-over`" in message
    )
    with claim.take(run, "run", take_over=True) as held:
        held.mark(run, "done")


def test_sweep_and_run_respect_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep = made(tmp_path / "sweep", ("load_n=5", "load_n=20"))
    first = holding(sweep)
    with pytest.raises(FolderError, match=f"process {first.pid} ") as refusal:
        claim.take(sweep / "load_n=5", "run")
    assert str(refusal.value).startswith(str(sweep))
    monkeypatch.chdir(sweep / "load_n=5")
    with pytest.raises(FolderError, match=f"process {first.pid} "):
        claim.take(Path(), "run")
    first.kill()
    one = holding(sweep / "load_n=5")
    with pytest.raises(FolderError, match=f"process {one.pid} ") as refusal:
        claim.take(sweep, "sweep")
    assert "load_n=5" in str(refusal.value)
    other = holding(sweep / "load_n=20")  # its neighbours are free
    for child in (one, other):
        child.say("end")
        assert child.wait() == 0
    with claim.take(sweep, "sweep") as held:
        held.mark(sweep, "done")


def test_a_run_of_a_study_two_folders_below_respects_it(tmp_path: Path) -> None:
    study = tmp_path / "study"
    (study / "as-stated").mkdir(parents=True)
    run_record.write(study, run_record.new("study", ["as-stated/load_n=5"]))
    made(study / "as-stated" / "load_n=5")
    first = holding(study)
    with pytest.raises(FolderError, match=f"process {first.pid} "):
        claim.take(study / "as-stated" / "load_n=5", "run")
    first.kill()


@pytest.mark.slow
@pytest.mark.parametrize("runs", [(), ("load_n=5",)])
def test_of_processes_that_begin_at_once_one_wins(tmp_path: Path, runs: tuple[str, ...]) -> None:
    """In each of twelve rounds four of five processes are refused.

    With a sweep, some of them want a run in it.
    """
    folder = made(tmp_path / "folder", runs)
    for _ in range(12):

        def work(child: Child) -> None:
            wanted = folder / runs[0] if runs and os.getpid() % 2 else folder
            child.hear()
            try:
                with claim.take(wanted, "run") as held:
                    child.say("won")
                    child.hear()
                    held.mark(wanted, "done")
            except FolderError as error:
                assert "in use by process" in str(error)
                child.say("refused")

        children = [Child(work) for _ in range(5)]
        for child in children:
            child.say("go")
        answers = [child.hear() for child in children]
        for child, answer in zip(children, answers, strict=True):
            if answer == "won":
                child.say("end")
            assert child.wait() == 0
        assert sorted(answers) == ["refused"] * 4 + ["won"]


def test_two_who_find_the_claim_of_a_killed_process_do_not_both_take_it(tmp_path: Path) -> None:
    folder = made(tmp_path / "folder")
    for _ in range(10):
        holding(folder).kill()

        def work(child: Child) -> None:
            child.hear()
            try:
                claim.take(folder, "run")
                child.say("won")
                child.hear()
            except FolderError:
                child.say("refused")

        children = [Child(work) for _ in range(4)]
        for child in children:
            child.say("go")
        assert sorted(child.hear() for child in children) == ["refused"] * 3 + ["won"]
        for child in children:
            os.kill(child.pid, signal.SIGKILL)
            child.wait()


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (KeyboardInterrupt(), ("waiting", "interrupted")),
        (OSError(28, "No space left on device"), ("failed", "[Errno 28] No space left on device")),
        (ZeroDivisionError(), ("failed", "ZeroDivisionError")),
        (FolderError("results of another scene"), ("waiting", None)),  # as it was
    ],
)
def test_an_error_gives_the_folder_back_and_says_why(
    tmp_path: Path, error: BaseException, expected: tuple[str, str | None]
) -> None:
    sweep = made(tmp_path / "sweep", ("load_n=5", "load_n=20"))
    with pytest.raises(type(error)), claim.take(sweep, "sweep") as held:
        held.mark(sweep / "load_n=5", "running")
        raise error
    for folder in (sweep, sweep / "load_n=5"):
        record = run_record.read(folder)
        assert record is not None and (record.state, record.reason) == expected
    assert state(sweep / "load_n=20") == "waiting"
    claim.take(sweep, "sweep").__exit__(None, None, None)


def test_a_full_disk_leaves_no_claim_that_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same process can take the folder again although the state cannot be written."""
    run = made(tmp_path / "run")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"), claim.take(run, "run"):
        monkeypatch.setattr(run_record.files, "write_bytes", full)
        raise OSError(28, "No space left on device")
    monkeypatch.undo()
    assert state(run) == "running"
    with claim.take(run, "run") as held:
        held.mark(run, "done")


def test_a_folder_of_version_0_1_0_is_given_a_record_that_says_so(tmp_path: Path) -> None:
    sweep = tmp_path / "old"
    (sweep / "load_n=5").mkdir(parents=True)
    (sweep / "resolved.yaml").write_text("name: old\n")
    first = holding(sweep / "load_n=5")
    with pytest.raises(FolderError, match=f"process {first.pid} "):
        claim.take(sweep, "sweep", ["load_n=5"])
    first.kill()
    with claim.take(sweep, "sweep", ["load_n=5"]) as held:
        held.mark(sweep, "done")
    record = run_record.read(sweep)
    assert record is not None and record.adopted and record.runs == ("load_n=5",)
