"""A crash or a full disk at every write of a sweep: the same command goes on, to the same bytes.

The commands run in forks of this warm process, two at a time. The second run of the sweep is
written by the calls of the first one, so its own folder is left out. The crash comes at every call,
the full disk at every kind of call.
"""

from __future__ import annotations

import errno
import io
import itertools
import multiprocessing
import os
import re
import stat
import traceback
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import pytest
from commands import contents, tree, words_of
from scene_text import TINY

from rolling import cli
from rolling.terminal import whole_files

pytestmark = [
    pytest.mark.slow,
    pytest.mark.usefixtures("short_sounds"),
    pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks on Windows"),
    # From Python 3.12 on, which counts threads; those of idle libraries hold no lock.
    pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning"),
]
GROWING = ("open", "mkdir", "write", "fsync", "rename", "replace")  # which a full disk can refuse
SYSTEM = {name: getattr(os, name) for name in (*GROWING, "unlink", "rmdir")}
SECOND = "0.006"  # stands in the name of the folder of the second run
State = dict[str, bytes | None]
Act = Callable[[str, Callable[[], Any], tuple[Any, ...]], Any]


@contextmanager
def watched(act: Act) -> Iterator[None]:
    """Let `act` make all calls of the system that change files, given name, call and arguments."""

    def watching(name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            changes = name != "open" or arguments[1] & os.O_CREAT
            real = lambda: SYSTEM[name](*arguments, **named)  # noqa: E731
            return act(name, real, arguments) if changes else real()

        return call

    with pytest.MonkeyPatch.context() as patch:
        for name in SYSTEM:
            patch.setattr(os, name, watching(name))
        yield


def place_of(name: str, arguments: tuple[Any, ...]) -> Path:
    """Return the file or folder that a call of the system changes."""
    if name in ("write", "fsync"):
        return Path(f"/dev/fd/{arguments[0]}").resolve()
    return Path(os.fsdecode(arguments[-1] if name in ("rename", "replace") else arguments[0]))


def is_of_second(name: str, arguments: tuple[Any, ...]) -> bool:
    """Return whether a call changes the folder of the second run, or a file within it."""
    return SECOND in str(place_of(name, arguments))


def kinds_of_call() -> tuple[Hashable, Hashable]:
    """Return two kinds of the call of the system that is made now: its own line, and its purpose.

    The calls that write a file leave none if one of them fails, so one of them stands for all. The
    one that brings its name to the disk leaves it. Purposes differ by the lines that ask for them.
    """
    package = str(Path(cli.__file__).parent)
    lines = [line for line in traceback.extract_stack() if line.filename.startswith(package)]
    asking = [line for line in lines if line.filename != whole_files.__file__]
    last = lines[-1]
    purpose = (last.name, *((line.filename, line.lineno) for line in asking))
    return (last.filename, last.lineno), purpose


def run(folder: Path, out: Path) -> tuple[int, str]:
    """Return the exit code of a command in this process, and its errors."""
    said = io.StringIO()
    with redirect_stderr(said), redirect_stdout(io.StringIO()):
        code = cli.main(words_of(folder / "scene.yaml", out, "--workers", "1"))
    return code, said.getvalue()


def fault_of_going_on(folder: Path, out: Path, expected: dict[str, bytes]) -> str:
    """Return the fault of the command that goes on in a folder; empty if there is none."""
    code, said = run(folder, out)
    rest = [name for name in tree(out) if name.startswith((".", "pieces")) or "/." in name]
    if code or said or rest:
        return f"{out.name}: code {code}, {rest}, {said}"
    return "" if contents(out) == expected else f"{out.name}: other bytes"


def state_of(out: Path, unsafe: set[int]) -> State:
    """Return the content of all files below a folder, empty for unsafe ones; None for folders."""
    return {
        str(path.relative_to(out)): None
        if path.is_dir()
        else (b"" if path.stat().st_ino in unsafe else path.read_bytes())
        for path in sorted(out.rglob("*"))
    }


def without_random_names(state: State) -> State:
    """Return a state whose partial files have the same names in each run."""
    return {re.sub(r"[0-9a-f]{16}", "", path): content for path, content in state.items()}


def fault_after_crash(folder: Path, out: Path, expected: dict[str, bytes], state: State) -> str:
    """Return the fault of the command that goes on after a crash left a folder in a state."""
    out.mkdir()
    for path, content in state.items():
        if content is None:
            (out / path).mkdir()
        else:
            (out / path).write_bytes(content)
    return fault_of_going_on(folder, out, expected)


def fault_on_full_disk(folder: Path, out: Path, expected: dict[str, bytes], number: int) -> str:
    """Return the fault of a command whose call of this number finds a full disk."""
    numbers = itertools.count()

    def act(name: str, real: Callable[[], Any], arguments: tuple[Any, ...]) -> Any:
        if name in GROWING and not is_of_second(name, arguments) and next(numbers) == number:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return real()

    with watched(act):
        code, said = run(folder, out)
    if (code, said) == (0, ""):  # the lock is tried again
        return fault_of_going_on(folder, out, expected)
    if code not in (1, 2) or "No space left on device" not in said or len(said.split("\n")) > 3:
        return f"{number}: code {code}, {said}"
    return fault_of_going_on(folder, out, expected)


def faults(function: Callable[..., str], jobs: list[tuple[Any, ...]]) -> list[str]:
    """Return the faults of all jobs, done in forks."""
    with multiprocessing.get_context("fork").Pool(2) as pool:
        return [fault for fault in pool.starmap(function, jobs, chunksize=1) if fault]


@pytest.fixture(scope="module")
def whole(
    tmp_path_factory: pytest.TempPathFactory, short_sounds: None
) -> tuple[Path, dict[str, bytes]]:
    """Return the folder of a scene, and the files of its sweep that nothing disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "scene.yaml").write_text(TINY + "sweep: {rolling.load_n: [0.005, 0.006]}\n")
    assert run(folder, folder / "out") == (0, "")
    return folder, contents(folder / "out")


@pytest.mark.slow
def test_a_crash_at_every_write(tmp_path: Path, whole: tuple[Path, dict[str, bytes]]) -> None:
    """The files stand as a kill leaves them before each call and in the middle of each write.

    After a power cut the names are there, without the content that no fsync wrote.
    """
    folder, expected = whole
    out = tmp_path / "out"
    states = dict[Hashable, State]()
    calls = list[tuple[str, Path]]()
    unsafe: set[int] = set()  # inodes of files whose content is not on the disk yet

    def act(name: str, real: Callable[[], Any], arguments: tuple[Any, ...]) -> Any:
        if not is_of_second(name, arguments):
            for lost in (set(), unsafe):
                state = state_of(out, lost)
                states.setdefault(frozenset(without_random_names(state).items()), state)
        calls.append((name, place_of(name, arguments)))
        if name in ("write", "fsync"):
            status = os.fstat(arguments[0])
            if name == "fsync":
                unsafe.discard(status.st_ino)
            elif stat.S_ISREG(status.st_mode):
                unsafe.add(status.st_ino)
                if not status.st_size:
                    return SYSTEM["write"](arguments[0], arguments[1][: len(arguments[1]) // 2])
        return real()

    with watched(act):
        assert run(folder, out) == (0, "")
    renamed = [(k, path) for k, (name, path) in enumerate(calls) if name in ("rename", "replace")]
    assert {path for _, path in renamed} >= {path for path in out.rglob("*") if path.is_file()}
    for k, path in renamed:  # each new name is on the disk before anything else is done
        assert calls[k + 1] == ("fsync", path.parent)
    assert len(states) > 40
    jobs = [(folder, tmp_path / str(n), expected, state) for n, state in enumerate(states.values())]
    assert faults(fault_after_crash, jobs) == []


@pytest.mark.slow
def test_a_full_disk_at_every_kind_of_write(
    tmp_path: Path, whole: tuple[Path, dict[str, bytes]]
) -> None:
    folder, expected = whole
    count = 0
    numbers = dict[Hashable, int]()  # of the last call of each kind

    def act(name: str, real: Callable[[], Any], arguments: tuple[Any, ...]) -> Any:
        nonlocal count
        if name in GROWING and not is_of_second(name, arguments):
            numbers.update(dict.fromkeys(kinds_of_call(), count))
            count += 1
        return real()

    with watched(act):
        assert run(folder, tmp_path / "out") == (0, "")
    failing = sorted({*numbers.values()})
    assert count > 60 and len(failing) > 30
    jobs = [(folder, tmp_path / f"out-{n}", expected, n) for n in failing]
    assert faults(fault_on_full_disk, jobs) == []
