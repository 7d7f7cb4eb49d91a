"""Record `run.json`, which marks a folder of this program.

It holds kind and state of the folder, the process that works on it, and its maker.

A process changes the file only while it holds the folder (see `claim`).
"""

from __future__ import annotations

import json
import stat
import uuid
from collections.abc import Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    model_validator,
)
from pydantic.dataclasses import dataclass

from rolling.folders import files, program
from rolling.folders.files import FolderError
from rolling.folders.process import Process, this_process

FILE = "run.json"
FORMAT = 1
LARGEST = 100_000_000  # [bytes]; ten thousand runs take one million

Kind = Literal["run", "sweep", "accuracy", "hard-cases", "study", "part"]
State = Literal["waiting", "running", "done", "failed"]


def _inner(path: str) -> str:
    """Check that a path stays below the folder that it starts from."""
    parts = PurePosixPath(path).parts
    if (
        not parts
        or path != "/".join(parts)
        or {"..", "/"} & {*parts}
        or "\\" in path
        or "\0" in path
    ):
        raise ValueError("not a path below the folder")
    return path


@dataclass(frozen=True, config=ConfigDict(strict=True, extra="forbid"))
class RunRecord:
    """Contents of run.json.

    Attributes
    ----------
    kind : Kind
        Kind of the folder.
    state : State
        State of the work.
    reason : str or None
        Reason why the work failed, or why it waits after it was begun.
    process : Process or None
        Process that works on the folder while its state is running.
    id : str
        Id that belongs to this folder alone.
    version, sources, commit, dirty : str or None, and bool or None
        Program that worked on it last (see `program.Identity`).
    created, changed : str
        Times of the first and of the last record.
    completed : str or None
        Time when the work was first done; later work does not change it.
    runs : tuple of str
        Folders of its runs, in the order of the sweep of the scene; each has a run.json of its own.
        The record of a part of a sweep names the runs of the part.
    replaces : str or None
        Id of OUT.previous beside it, which is removed when the work is done.
    adopted : bool
        If true, version 0.1.0 made the folder, and it is never replaced.
    starts : int
        Number of times that work on it began.
    trial : dict or None
        Choice of a tolerance that the scene left open (`stretches.Trial`), from before there is a
        result.
    """

    kind: Kind
    state: State
    reason: str | None
    process: Process | None
    id: Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]
    version: str
    sources: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    commit: str | None
    dirty: bool | None
    created: str
    changed: str
    completed: str | None = None
    runs: tuple[Annotated[str, AfterValidator(_inner)], ...] = ()
    replaces: str | None = None
    adopted: bool = False
    starts: Annotated[int, Field(ge=0)] = 0
    trial: dict[str, Any] | None = None

    @model_validator(mode="after")
    def _consistent(self) -> RunRecord:
        if (self.state == "running") != (self.process is not None):
            raise ValueError("a process, and only while the state is running")
        if len({name.casefold() for name in self.runs}) != len(self.runs):
            raise ValueError("runs that share a folder")
        return self

    def with_state(self, state: State, reason: str | None = None) -> RunRecord:
        """Return the record with another state from now on.

        It names this process if the state is running.
        """
        process = this_process() if state == "running" else None
        made_by = asdict(program.identity()) if state == "running" else {}
        now = _now()
        completed = self.completed or (now if state == "done" else None)
        return replace(
            self,
            state=state,
            reason=reason,
            process=process,
            changed=now,
            completed=completed,
            starts=self.starts + (state == "running"),
            **made_by,
        )


def new(kind: Kind, runs: Sequence[str] = (), adopted: bool = False) -> RunRecord:
    """Return the record of a new folder, whose state is waiting."""
    now = _now()
    return RunRecord(
        kind=kind,
        state="waiting",
        reason=None,
        process=None,
        id=uuid.uuid4().hex,
        created=now,
        changed=now,
        runs=tuple(runs),
        adopted=adopted,
        **asdict(program.identity()),
    )


def write(folder: Path, record: RunRecord) -> None:
    """Write run.json into a folder.

    Raises
    ------
    OSError
        The file cannot be written; an earlier file is kept.
    """
    files.write_json(folder / FILE, {"program": program.NAME, "format": FORMAT, **asdict(record)})


def read(folder: Path) -> RunRecord | None:
    """Return the record of a folder, None when the folder has no run.json.

    Raises
    ------
    FolderError
        The file is damaged, or from a later version or another program.
    """
    path = folder / FILE
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise FolderError(f"{path}: not a file")
        if status.st_size > LARGEST:
            raise FolderError(
                f"{path}: {status.st_size} bytes, too large for a run.json of this program"
            )
        content = json.loads(path.read_bytes())
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error})") from error
    except (ValueError, RecursionError) as error:
        raise FolderError(
            f"{path}: damaged, not JSON; the state of this folder is not known"
        ) from error
    if not isinstance(content, dict) or content.pop("program", None) != program.NAME:
        raise FolderError(f"{path}: not a run.json of this program; it belongs to something else")
    form = content.pop("format", None)
    if form != FORMAT or isinstance(form, bool):
        raise FolderError(
            f"{path}: format {_short(form)}, this version of the program reads format {FORMAT}"
        )
    try:
        return _ADAPTER.validate_json(json.dumps(content))
    except (ValidationError, ValueError, RecursionError) as error:
        raise FolderError(f"{path}: damaged: {_first_fault(error)}") from error


_ADAPTER = TypeAdapter(RunRecord)


def _first_fault(error: Exception) -> str:
    if not isinstance(error, ValidationError):
        return str(error)
    fault = error.errors(include_url=False)[0]
    place = ".".join(map(str, fault["loc"]))
    return f"{place}: {fault['msg']}" if place else fault["msg"]


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
