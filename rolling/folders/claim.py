"""Claims: one process at a time works on a folder.

The claim is the state `running` in run.json. A sweep and the runs in it respect each other's
claims. The claim of a process that has ended does not count.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

from rolling.folders import run_record
from rolling.folders.files import FolderError
from rolling.folders.process import Process, is_alive, this_process
from rolling.folders.run_record import Kind, RunRecord, State
from rolling.scene.messages import SceneError

try:
    import fcntl
except ImportError:  # Windows cannot separate two commands within the same millisecond
    fcntl = None  # type: ignore[assignment]

PARTS = "parts"  # folder of a sweep, with a folder for each part that was claimed
LOCK = ".lock"  # empty file, held for milliseconds while claims are read and changed
PATIENCE = 10.0  # [s]
INTERRUPTED = "interrupted"

_held: set[str] = set()  # ids of the records that this process has claimed and not given back


class Claim:
    """Folder that this process works on.

    Leaving the context gives the folder back with the state of the work.
    """

    def __init__(self, folder: Path, record: RunRecord, before: RunRecord) -> None:
        self.folder, self.record = folder, record
        self._before = before
        self._running: dict[Path, RunRecord] = {}  # runs in the folder
        _held.add(record.id)

    def __enter__(self) -> Claim:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        try:
            # On a full disk the claim ends with the process.
            with suppress(OSError, FolderError):
                state, reason = self._left(error)
                for run in [*self._running]:
                    self.mark(run, state, reason)
                if (
                    self.record.state == "running"
                    and _is_refusal(error)
                    and self._before.state != "running"
                ):
                    run_record.write(
                        self.folder, self._before
                    )  # restores every byte, because nothing was done
                elif self.record.state == "running":
                    self.mark(self.folder, state, reason)
        finally:
            _held.difference_update(
                {self.record.id, *(record.id for record in self._running.values())}
            )

    def end(self, interrupted: bool, failed: str | None = None) -> None:
        """Write the last state of the claimed folder: done, unless it was interrupted or failed.

        Parameters
        ----------
        interrupted : bool
            Whether work is left.
        failed : str or None
            Reason of a failure. Default: none.
        """
        if interrupted:
            self.mark(self.folder, "waiting", INTERRUPTED)
        elif failed:
            self.mark(self.folder, "failed", failed)
        else:
            self.mark(self.folder, "done")

    def mark(self, folder: Path, state: State, reason: str | None = None) -> None:
        """Write the state of the claimed folder, or of a run in it.

        Raises
        ------
        OSError
            The state cannot be written.
        """
        if folder == self.folder:
            if state != self.record.state:
                self.record = self.record.with_state(state, reason)
                run_record.write(folder, self.record)
            return
        before = run_record.read(folder) or run_record.new("run", adopted=self.record.adopted)
        if (before.state, before.reason) == (state, reason) and (
            state != "running" or folder in self._running
        ):
            return
        record = before.with_state(state, reason)
        run_record.write(folder, record)
        if state == "running":
            _held.add(record.id)
            self._running[folder] = record
        else:
            _held.discard(record.id)
            self._running.pop(folder, None)

    def note_trial(self, folder: Path, trial: dict[str, Any]) -> None:
        """Write the choice of a tolerance into the record of the folder, or of a run in it.

        Raises
        ------
        OSError
            The record cannot be written.
        """
        if folder == self.folder:
            self.record = replace(self.record, trial=trial)
            self._before = replace(self._before, trial=trial)
            run_record.write(folder, self.record)
            return
        before = run_record.read(folder) or run_record.new("run", adopted=self.record.adopted)
        run_record.write(folder, replace(before, trial=trial))

    def forget_replaced(self) -> None:
        """Write that the replaced folder is gone."""
        self.record = replace(self.record, replaces=None)
        run_record.write(self.folder, self.record)

    def _left(self, error: BaseException | None) -> tuple[State, str | None]:
        """Return state and reason of the work after an error."""
        if error is None or _is_refusal(error):  # without any work
            before = self._before
            return (
                ("waiting", "the process was killed")
                if before.state == "running"
                else (before.state, before.reason)
            )
        if isinstance(error, KeyboardInterrupt | SystemExit):
            return "waiting", INTERRUPTED
        return "failed", (str(error).strip().splitlines() or [type(error).__name__])[0]


def _is_refusal(error: BaseException | None) -> bool:
    return isinstance(error, FolderError | SceneError)


def take(folder: Path, kind: Kind, runs: Sequence[str] = (), take_over: bool = False) -> Claim:
    """Claim an existing folder.

    Parameters
    ----------
    kind : Kind
        Kind for a folder of version 0.1.0, which has no run.json.
    runs : sequence of str
        Names of the folders of its runs; a study adds them to its earlier runs.
    take_over : bool
        If true, claim the folder even from a process that cannot be seen from here. Default: false.

    Raises
    ------
    FolderError
        Another process works on the folder, on a run in it or on its sweep.
    """
    owner = owner_of(folder)
    with guard(owner or _unmarked_sweep(folder) or folder):
        if not folder.is_dir():
            raise FolderError(f"{folder}: no such folder")
        record = run_record.read(folder) or run_record.new(kind, runs, adopted=True)
        # A run of a sweep may be worked on while others of the sweep are not.
        around = run_record.read(owner) if owner else None
        parts = _parts_with(owner, {folder.resolve().name}) if owner else ()
        for place, other in ((owner, around), *parts, *_with_runs(folder, record)):
            if other is not None and place is not None:
                refuse_in_use(place, other, take_over)
        claimed = replace(record, runs=tuple(dict.fromkeys([*record.runs, *runs]))).with_state(
            "running"
        )
        run_record.write(folder, claimed)
        return Claim(folder, claimed, record)


def take_part(sweep: Path, name: str, runs: Sequence[str], take_over: bool = False) -> Claim:
    """Claim some runs of a sweep, beside other processes that claim others.

    Parameters
    ----------
    sweep : Path
        Folder of the sweep.
    name : str
        Name of the part.
    runs : sequence of str
        Names of the folders of its runs.
    take_over : bool
        As in `take`.

    Raises
    ------
    FolderError
        Another process works on the sweep, or on one of the runs.
    """
    folder = sweep / PARTS / name
    with guard(sweep):
        whole = run_record.read(sweep)
        if whole is None:
            raise FolderError(f"{sweep}: no sweep of this version")
        refuse_in_use(sweep, whole, take_over)
        for place, other in _parts_with(sweep, {*runs}):
            refuse_in_use(place, other, take_over)
        for each in runs:
            own = run_record.read(sweep / each)
            if own is not None:
                refuse_in_use(sweep / each, own, take_over)
        folder.mkdir(parents=True, exist_ok=True)
        record = run_record.read(folder) or run_record.new("part", runs)
        claimed = replace(record, runs=tuple(runs)).with_state("running")
        run_record.write(folder, claimed)
        return Claim(folder, claimed, record)


def parts(sweep: Path) -> Iterator[tuple[Path, RunRecord]]:
    """Yield the parts of a sweep that were ever claimed, with their records."""
    with suppress(OSError):
        for folder in sorted((sweep / PARTS).iterdir()):
            record = run_record.read(folder)
            if record is not None and record.kind == "part":
                yield folder, record


def _parts_with(sweep: Path, runs: set[str]) -> Iterator[tuple[Path, RunRecord]]:
    """Yield the parts of a sweep that have one of the runs."""
    yield from ((folder, record) for folder, record in parts(sweep) if runs & {*record.runs})


def take_run(folder: Path, take_over: bool = False) -> Claim:
    """Claim a run of a sweep for a worker of the process that has claimed the sweep.

    Only a process of an earlier client may still work on the run, and it begins no other run.

    Raises
    ------
    FolderError
        Another process works on the run.
    """
    record = run_record.read(folder) or run_record.new("run")
    refuse_in_use(folder, record, take_over)
    claimed = record.with_state("running")
    run_record.write(folder, claimed)
    return Claim(folder, claimed, record)


def begin(folder: Path, record: RunRecord) -> Claim:
    """Claim a new folder by writing its first run.json."""
    claimed = record.with_state("running")
    run_record.write(folder, claimed)
    return Claim(folder, claimed, record)


def refuse_folder_in_use(folder: Path, record: RunRecord) -> None:
    """Raise FolderError if a process works on a folder or on a run in it."""
    for place, other in _with_runs(folder, record):
        if other is not None:
            refuse_in_use(place, other, False)


def refuse_in_use(folder: Path, record: RunRecord, take_over: bool) -> None:
    """Raise FolderError if the record is claimed.

    `take_over` ignores claims that cannot be judged from here.
    """
    process = record.process
    if process is None:
        return
    alive = record.id in _held if process == this_process() else is_alive(process)
    if alive is False or (alive is None and take_over):
        return
    message = f"{folder}: in use by {process} since {record.changed}"
    if alive:
        raise FolderError(f"{message}; wait for it to end, or stop it")
    raise FolderError(
        f"{message}, which cannot be seen from here; {_way_out(folder, record, process)}"
    )


def owner_of(folder: Path) -> Path | None:
    """Return the folder of the sweep or study of a run, None if the run stands alone."""
    own = folder.resolve()
    for above in (own.parent, own.parent.parent):
        try:
            record = run_record.read(above)
        except FolderError:  # a folder of another program
            continue
        if record is not None and own.relative_to(above).as_posix() in record.runs:
            return above
    return None


def _unmarked_sweep(folder: Path) -> Path | None:
    """Return the sweep of version 0.1.0 that a run belongs to.

    Such a sweep has no record until it is resumed.
    """
    above = folder.resolve().parent
    return (
        above
        if (above / "resolved.yaml").is_file() and not (above / run_record.FILE).exists()
        else None
    )


@contextmanager
def guard(folder: Path) -> Iterator[None]:
    """Keep other processes from reading or changing the claims of a folder and its runs.

    Raises
    ------
    FolderError
        Another process holds the lock for too long.
    """
    deadline = time.monotonic() + PATIENCE
    while (lock := _locked(folder / LOCK)) == -1:
        if time.monotonic() > deadline:
            raise FolderError(
                f"{folder / LOCK}: held by another process for {PATIENCE:g} s; try again"
            )
        time.sleep(0.005)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


def _locked(path: Path) -> int | None:
    """Lock a file and return its descriptor.

    Return -1 to try again, or None where the file system has no locks.
    """
    if fcntl is None:
        return None
    try:
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
    except OSError:  # an unwritable folder is reported when its run.json is written
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # The folder may have been renamed since the file was opened.
        if path.exists() and os.path.samestat(os.fstat(lock), path.stat()):
            return lock
    except BlockingIOError:
        pass
    except OSError:  # some network file systems
        os.close(lock)
        return None
    os.close(lock)
    return -1


def _with_runs(folder: Path, record: RunRecord) -> Iterator[tuple[Path, RunRecord | None]]:
    yield folder, record
    yield from ((folder / name, run_record.read(folder / name)) for name in record.runs)
    yield from parts(folder)


def _way_out(folder: Path, record: RunRecord, process: Process) -> str:
    if record.kind == "part":
        return "if it is gone, the same command with --take-over goes on"
    if record.kind in ("run", "sweep"):
        return f"if it is gone, `rolling resume {folder} --take-over` goes on"
    if record.kind == "study":
        return "if it is gone, the same command with --take-over goes on"
    return f"take another --out, or remove {folder} if it is gone"
