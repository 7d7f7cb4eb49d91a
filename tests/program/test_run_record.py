"""run.json comes back as it was written, and no damaged or foreign file passes for it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rolling.folders import process, program, run_record
from rolling.folders.files import FolderError
from rolling.folders.process import Process
from rolling.folders.run_record import RunRecord

RECORDS = {
    "new run": run_record.new("run"),
    "running sweep": run_record.new("sweep", ["load_n=5", "load_n=20"]).with_state("running"),
    "failed study": run_record.new("study", ["as-stated/a", "as-stated/b"]).with_state(
        "failed", "2 of 2 cases"
    ),
    "adopted": replace(run_record.new("accuracy", adopted=True), replaces="f" * 32),
}


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_comes_back_as_it_was_written(name: str, tmp_path: Path) -> None:
    run_record.write(tmp_path, RECORDS[name])
    assert run_record.read(tmp_path) == RECORDS[name]
    written = json.loads((tmp_path / "run.json").read_text())
    assert written["format"] == 1 and written["program"] == "rolling-contact-noise"
    assert (written["process"] is not None) == (written["state"] == "running")
    assert [*written] == ["program", "format", *(field.name for field in fields(RunRecord))]


def test_a_folder_without_one_has_no_record(tmp_path: Path) -> None:
    assert run_record.read(tmp_path) is None and run_record.read(tmp_path / "none") is None


def changed(**keys: object) -> str:
    run_json = {"program": "rolling-contact-noise", "format": 1, **json.loads(text())}
    return json.dumps({**run_json, **keys})


def text() -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        run_record.write(Path(folder), RECORDS["running sweep"])
        return (Path(folder) / "run.json").read_text()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "damaged, not JSON"),
        (text()[:200], "damaged, not JSON"),
        ("\x00" * 300, "damaged, not JSON"),
        ("[" * 100_000, "damaged, not JSON"),
        ("[1, 2]", "not a run.json of this program"),
        ('{"name": "a run of another program"}', "not a run.json of this program"),
        (changed(program="mlflow"), "not a run.json of this program"),
        (changed(format=2), "format 2, this version of the program reads format 1"),
        (changed(format=True), "format true"),
        (changed(format=None), "format null"),
        (changed(state="finished"), "damaged: state"),
        (changed(kind="holiday"), "damaged: kind"),
        (changed(process=None), "only while the state is running"),
        (changed(state="done"), "only while the state is running"),
        (
            changed(process={"host": "h", "pid": -1, "started": "", "birth": ""}),
            "damaged: process.pid",
        ),
        (
            changed(process={"host": "h", "pid": "12", "started": "", "birth": ""}),
            "damaged: process.pid",
        ),
        (changed(id="x"), "damaged: id"),
        (changed(sources=None), "damaged: sources"),
        (changed(later="a key"), "damaged: later"),
        (changed(runs="load_n=5"), "damaged: runs"),
        (changed(runs=["../../home"]), "damaged: runs"),
        (changed(runs=["/etc"]), "damaged: runs"),
        (changed(runs=[""]), "damaged: runs"),
        (changed(runs=["a//b"]), "damaged: runs"),
        (changed(runs=["seed=1E5", "seed=1e5"]), "runs that share a folder"),
    ],
)
def test_a_damaged_or_foreign_file_gives_one_message(
    content: str, words: str, tmp_path: Path
) -> None:
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(FolderError, match=words) as error:
        run_record.read(tmp_path)
    assert str(error.value).startswith(str(tmp_path / "run.json")) and "\n" not in str(error.value)


def test_what_is_no_file_gives_one_message(tmp_path: Path) -> None:
    (tmp_path / "a" / "run.json").mkdir(parents=True)
    (tmp_path / "b").mkdir()
    os.mkfifo(tmp_path / "b" / "run.json")  # reading it would wait for ever
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "run.json").write_bytes(b"\xff\xfe{")
    for name in "abc":
        with pytest.raises(FolderError):
            run_record.read(tmp_path / name)


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(position=st.integers(0, 2000), byte=st.integers(0, 255), cut=st.booleans())
def test_random_damage_never_gives_a_traceback(
    tmp_path: Path, position: int, byte: int, cut: bool
) -> None:
    content = bytearray(text().encode())
    position %= len(content)
    content[position] = byte
    (tmp_path / "run.json").write_bytes(content[:position] if cut else content)
    try:
        run_record.read(tmp_path)
    except FolderError as error:
        assert str(tmp_path) in str(error)


# ---- who made it


def test_the_digest_follows_every_module_and_asset(tmp_path: Path) -> None:
    """The digest of a copy changes with any byte of a module or asset, and with a new module."""
    root = Path(program.__file__).parents[2]
    for package in ("rolling", "acoustics"):
        shutil.copytree(
            root / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__")
        )

    def digest() -> str:
        code = "from rolling.folders import program; print(program.sources_digest())"
        printed = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        return printed.stdout.strip()

    digests = [digest()]
    assert digests[0] == program.sources_digest()
    for name in (
        "rolling/lee2025/cases.py",
        "rolling/report/assets/report.css",
        "acoustics/new.py",
    ):
        with (tmp_path / name).open("a") as file:
            file.write("\n")
        digests.append(digest())
    assert len({*digests}) == 4


def test_the_identity_names_the_commit_of_a_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    identity = program.identity()
    assert len(identity.sources) == 64 and (identity.commit is None) == (identity.dirty is None)
    assert identity.commit is None or len(identity.commit) == 40
    monkeypatch.setenv("PATH", "")  # without git
    assert program._checkout() == (None, None)


# ---- processes


def test_processes_are_recognised(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only this process lives.

    A process that ended, a process of its number born at another time and a process from before
    the last boot do not.
    """
    own = process.this_process()
    assert own.pid == os.getpid() and own.started and process.is_alive(own) is True
    boot, space, ticks = own.birth.split()
    assert process.is_alive(replace(own, birth=f"{boot} {space} {int(ticks) + 1}")) is False
    assert process.is_alive(replace(own, birth=f"another-boot {space} {ticks}")) is False
    assert process.is_alive(replace(own, pid=2**31 - 1)) is False
    # Numbers of another host or container say nothing here.
    assert process.is_alive(replace(own, host="elsewhere")) is None
    assert process.is_alive(replace(own, birth=f"{boot} pid:[1] {ticks}")) is None
    assert process.is_alive(Process(own.host, own.pid, "", "")) is None
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    born = process._birth(child.pid)
    assert born is not None
    there = Process(own.host, child.pid, "", born)
    assert process.is_alive(there) is True
    child.kill()
    os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
    assert process.is_alive(there) is False  # ended, though nobody has waited for it yet
    child.communicate()
    assert process.is_alive(there) is False


def test_processes_are_recognised_without_proc(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Systems without /proc use the start that `ps` prints."""
    if shutil.which("ps") is None:
        pytest.skip("no `ps` here, which says when a process began")
    monkeypatch.setattr(process, "PROC", tmp_path)
    own = process.this_process()
    assert own.birth and process.is_alive(own) is True
    assert process.is_alive(replace(own, birth="another")) is False
