"""Killed and interrupted processes: the same command goes on, to the same bytes."""

from __future__ import annotations

import mmap
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from commands import (
    PATIENCE,
    SWEEP,
    contents,
    pieces,
    rolling,
    started,
    tree,
    wait_for,
    words_of,
)
from memory_scenes import MEMORY

from rolling import cli
from rolling.run import folder as folders
from rolling.run import leftovers, pools

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL here")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_text(SWEEP)
    return path


def undisturbed(folder: Path, text: str) -> dict[str, bytes]:
    """Return the files of a run that nothing disturbs."""
    scene = folder / "undisturbed.yaml"
    out = folder / "undisturbed"
    scene.write_text(text)
    assert cli.main(words_of(scene, out, "--workers", "1")) == 0
    return contents(out)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return undisturbed(tmp_path_factory.mktemp("whole"), SWEEP)


@pytest.mark.slow
def test_a_killed_command_takes_its_workers_along_and_goes_on_with_its_pieces(
    scene: Path, tmp_path: Path, whole: dict[str, bytes]
) -> None:
    """The kernel or a thread ends workers within 10 s of their parent."""
    out = tmp_path / "out"
    with started(words_of(scene, out, "--workers", "2"), tmp_path) as command:
        wait_for(lambda: len(pieces(out)) >= 2)
        below = psutil.Process(command.pid).children(recursive=True)
        assert len(below) >= 2
        command.kill()
        command.wait()
        assert not psutil.wait_procs(below, 10)[1]
    kept = {path: path.stat().st_mtime_ns for path in pieces(out)}
    with started(words_of(scene, out, "--workers", "1"), tmp_path) as command:
        wait_for(lambda: len(pieces(out)) > len(kept) or command.poll() is not None)
        again = {path: path.stat().st_mtime_ns for path in kept if path.exists()}
        assert again.items() <= kept.items()  # none of them was marched again
        assert command.wait(PATIENCE) == 0
    assert contents(out) == whole


@pytest.mark.slow
def test_a_run_killed_in_a_later_pass_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    """Each pass has two pieces; the finished passes are read from their files."""
    text = MEMORY.replace("passes: 2", "passes: 8")
    whole = undisturbed(tmp_path, text)
    out = tmp_path / "out"
    scene = tmp_path / "scene.yaml"
    scene.write_text(text)
    with started(words_of(scene, out, "--workers", "2"), tmp_path) as command:
        wait_for(lambda: len(pieces(out)) >= 3 or command.poll() is not None)
        command.kill()
        command.wait()
    kept = {path: path.stat().st_mtime_ns for path in pieces(out)}
    assert 3 <= len(kept) < 16
    with started(words_of(scene, out, "--workers", "2"), tmp_path) as command:
        wait_for(lambda: len(pieces(out)) > len(kept) or command.poll() is not None)
        again = {path: path.stat().st_mtime_ns for path in kept if path.exists()}
        assert again.items() <= kept.items()
        assert command.wait(PATIENCE) == 0
    assert contents(out) == whole and "passes.wav" in whole


@pytest.mark.parametrize(
    ("workers", "number"), [("1", signal.SIGINT), ("2", signal.SIGTERM)], ids=["ctrl-c", "term"]
)
def test_an_interruption_ends_with_130_and_keeps_pieces(
    scene: Path, tmp_path: Path, workers: str, number: int
) -> None:
    out = tmp_path / "out"
    # Six loads last several seconds after the first piece, also where this process has to wait.
    scene.write_text(SWEEP.replace("[1, 2]", "[1, 1.2, 1.4, 1.6, 1.8, 2]"))
    with started(words_of(scene, out, "--workers", workers), tmp_path) as command:
        wait_for(lambda: pieces(out))
        below = psutil.Process(command.pid).children(recursive=True)
        command.send_signal(number)
        assert command.wait(PATIENCE) == 130
        assert not any(process.is_running() for process in psutil.wait_procs(below, 10)[1])
    assert "interrupted" in (tmp_path / "said").read_text()
    assert "Traceback" not in (tmp_path / "said").read_text()
    assert pieces(out) and not (out / ".lock").exists()
    assert "waiting" in folders.status(out) and "pieces" in folders.status(out)


# An interruption while Python runs a text, as it does for each data class of a module.
IN_A_TEXT = """\
from rolling import cli

def interrupted(given):
    exec("raise KeyboardInterrupt")

cli.COMMANDS["scenes"] = interrupted
"""


def test_an_interruption_in_a_text_that_python_runs_ends_with_130(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(IN_A_TEXT)
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    done = rolling(["scenes"], tmp_path, PYTHONPATH=path)
    assert "interrupted" in done.stderr
    assert done.returncode == 130


def workers_of(command: subprocess.Popen[str]) -> list[psutil.Process]:
    """Return the worker processes of a command, which have loaded the solver."""
    below = psutil.Process(command.pid).children()
    return [process for process in below if "popen_loky" in " ".join(process.cmdline())]


@pytest.mark.slow
def test_a_killed_worker_costs_its_piece_only(
    scene: Path, tmp_path: Path, whole: dict[str, bytes]
) -> None:
    out = tmp_path / "out"
    words = [word for word in words_of(scene, out, "--workers", "2") if word != "-q"]
    with started(words, tmp_path) as command:
        wait_for(lambda: pieces(out))
        os.kill(workers_of(command)[0].pid, signal.SIGKILL)
        assert command.wait(PATIENCE) == 0
    assert "a worker process was killed" in (tmp_path / "said").read_text()
    assert contents(out) == whole


# A run with seed 13 kills each process that begins its march, as Linux does without memory.
KILLER = """\
import os, signal
from rolling.contact import march

inner = march.march

def killing(contact, *arguments, **named):
    if contact.load == 2.0:
        os.kill(os.getpid(), signal.SIGKILL)
    return inner(contact, *arguments, **named)

march.march = killing
"""


@pytest.mark.slow
def test_a_run_that_kills_its_workers_fails_alone_and_by_name(
    scene: Path, tmp_path: Path, whole: dict[str, bytes]
) -> None:
    (tmp_path / "sitecustomize.py").write_text(KILLER)
    out = tmp_path / "out"
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    done = rolling(words_of(scene, out, "--workers", "2"), tmp_path, PYTHONPATH=path)
    assert done.returncode == 1, done.stderr
    assert "failed: load 2 N: a worker process was killed 3 times" in done.stderr
    assert (out / "load_n=1" / "result.h5").is_file()
    assert [name for name in tree(out) if "load_n=2" in name] == [
        "load_n=2",
        "load_n=2/failed.json",
    ]
    status = folders.status(out)
    assert "1 done, 1 failed" in status and "load_n=2: a worker process was killed" in status
    assert cli.main(words_of(scene, out, "--workers", "1")) == 0  # without the killer
    assert not (out / "load_n=2" / "failed.json").exists()
    assert contents(out) == whole


# Workers say which messages they send that are longer than those that a pipe takes whole.
SPEAKER = """\
import os, sys
from multiprocessing.connection import Connection

inner = Connection._send_bytes

def sending(self, content):
    if len(content) > 4096 and "popen_loky" in " ".join(sys.orig_argv):
        os.write(2, b"a long message, %d bytes\\n" % len(content))
    return inner(self, content)

Connection._send_bytes = sending
"""


@pytest.mark.slow
def test_workers_of_a_folder_send_no_message_that_a_kill_could_cut(
    tmp_path: Path, scene: Path, whole: dict[str, bytes]
) -> None:
    """pipe(7): a write of up to PIPE_BUF = 4096 bytes is whole or not there; pieces are longer."""
    (tmp_path / "sitecustomize.py").write_text(SPEAKER)
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    done = rolling(words_of(scene, tmp_path / "out", "--workers", "2"), tmp_path, PYTHONPATH=path)
    assert done.returncode == 0 and "long message" not in done.stderr
    assert contents(tmp_path / "out") == whole


# ---- semaphores of a pool whose processes were all killed at once

SEMAPHORES = """
import os, time
from loky.backend import get_context
event = get_context("loky").Event()
print(os.getpid(), flush=True)
time.sleep(600)
"""
linux_only = pytest.mark.skipif(
    not Path("/dev/shm").is_dir() or not Path("/proc/self/maps").is_file(),
    reason="semaphores lie in no folder here",
)


def named(process: int) -> set[Path]:
    """Return the semaphores that a process of loky made."""
    return {*Path("/dev/shm").glob(f"*loky-{process}-*")}


@linux_only
def test_semaphores_of_a_killed_group_go_with_the_next_pool() -> None:
    """The names are those that loky gives, and a living process keeps its own."""
    command = [sys.executable, "-c", SEMAPHORES]
    groups = [
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        for _ in range(2)
    ]
    try:
        for group in groups:
            assert int(group.stdout.readline()) == group.pid
        killed, living = groups
        assert len(named(killed.pid)) >= 3
        kept = named(living.pid)
        os.killpg(killed.pid, signal.SIGKILL)  # with the process that would tidy up
        killed.wait()
        left = named(killed.pid)
        assert len(left) >= 3
        assert left <= {*leftovers.remove_leftovers()}
        assert not named(killed.pid) and named(living.pid) == kept
    finally:
        for group in groups:
            with suppress(ProcessLookupError):
                os.killpg(group.pid, signal.SIGKILL)
            group.wait()
            group.stdout.close()
        leftovers.remove_leftovers()


@linux_only
def test_nothing_else_in_shared_memory_is_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    gone = [f"sem.loky-{dead.pid}-abc_12de", f"loky-{dead.pid}-abc_12de"]
    kept = [
        f"sem.loky-{os.getpid()}-abc_12de",
        "sem.loky-1-abc_12de",
        f"sem.mp-{dead.pid}abc",
        f"sem.loky-{dead.pid}-abc_12def",
        f"sem.loky-{dead.pid}-ABC_12DE",
        f"joblib_memmapping_folder_{dead.pid}_abc",
        f"sem.loky-{dead.pid}-in_use_0",
        f"sem.loky-{dead.pid}-theirs_0",
    ]
    for name in (*gone, *kept):
        (tmp_path / name).write_bytes(bytes(32))
    (tmp_path / f"sem.loky-{dead.pid}-folder_0").mkdir()
    (tmp_path / f"sem.loky-{dead.pid}-linked_0").symlink_to(tmp_path / kept[0])
    lstat = Path.lstat

    def of_another_user(path: Path) -> os.stat_result:
        status = lstat(path)
        if path.name.endswith("theirs_0"):
            return os.stat_result([*status[:4], os.getuid() + 1, *status[5:10]])
        return status

    monkeypatch.setattr(Path, "lstat", of_another_user)
    before = {*tmp_path.iterdir()}
    with (
        (tmp_path / f"sem.loky-{dead.pid}-in_use_0").open("r+b") as file,
        mmap.mmap(file.fileno(), 32),
    ):
        removed = leftovers.remove_leftovers(tmp_path)
    assert {path.name for path in removed} == {*gone}
    assert {*tmp_path.iterdir()} == before - {tmp_path / name for name in gone}


def test_a_pool_removes_leftovers_as_it_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    monkeypatch.setattr(leftovers, "remove_leftovers", lambda: calls.append(1))
    monkeypatch.setattr(pools.LocalPool, "_start", lambda pool: None)
    monkeypatch.setattr(pools.LocalPool, "_stop", lambda pool: None)
    with pools.LocalPool(2):
        assert calls == [1]
