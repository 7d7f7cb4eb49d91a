"""Status of a run folder: the state of each of its runs, from their run.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from rolling.folders import claim, run_folder, run_record
from rolling.folders.files import FolderError
from rolling.folders.process import is_alive
from rolling.folders.run_record import RunRecord, State

STATES: tuple[State, ...] = ("done", "running", "waiting", "failed")
MOST_NAMED = 20  # runs of a state that the text names


@dataclass(frozen=True)
class RunStatus:
    """State of a run.

    name : str. Folder of the run, below the folder of the sweep.
    state : State.
    remark : str. Process that works on it, or the reason of a failure or an interruption.
    changed : str. Time of the state; empty for a run that was never begun.
    starts : int. Number of times that work on it began.
    """

    name: str
    state: State
    remark: str = ""
    changed: str = ""
    starts: int = 0


def statuses(folder: Path) -> list[RunStatus]:
    """Read the state of each run of a run folder.

    A run that a killed process worked on is waiting.

    Raises
    ------
    FolderError : the folder is no run folder.
    """
    record = run_folder.record_of_runs(folder)
    if record is None:
        raise FolderError(f"{folder}: made by version 0.1.0 (no run.json), its state is not known")
    if record.kind == "run":
        return [_status(folder.name, record)]
    return [_of_run(folder, name) for name in record.runs]


def text(folder: Path) -> str:
    """Write the progress of a run folder: counts of states, and the runs that need a person."""
    every = statuses(folder)
    counts = Counter(each.state for each in every)
    lines = [
        f"{folder}: {len(every)} {'run' if len(every) == 1 else 'runs'}: "
        + ", ".join(f"{counts[state]} {state}" for state in STATES if counts[state])
    ]
    lines += [
        f"  part {part.name}: {each.state}: {each.remark}"
        for part, record in claim.parts(folder)
        if (each := _status(part.name, record)).state == "running"
    ]
    for state in ("running", "failed", "waiting"):
        lines += _named([each for each in every if each.state == state and each.remark])
    return "\n".join(lines)


def is_at_rest(every: Sequence[RunStatus]) -> bool:
    """Tell whether no run is waiting or running."""
    return all(each.state in ("done", "failed") for each in every)


def _of_run(folder: Path, name: str) -> RunStatus:
    """Read the state of a run in a sweep; a run without a record was never begun."""
    try:
        record = run_record.read(folder / name)
    except FolderError as error:
        return RunStatus(name, "failed", str(error))
    return RunStatus(name, "waiting") if record is None else _status(name, record)


def _status(name: str, record: RunRecord) -> RunStatus:
    """Return the state of a record, with its process or reason in words."""
    state, remark = record.state, record.reason or ""
    if record.process is not None:
        alive = is_alive(record.process)
        remark = f"{record.process}{_since(record.changed)}"
        if alive is None:
            remark += ", which cannot be seen from here"
        elif not alive:
            state, remark = "waiting", f"{record.process} was killed"
    if record.starts > 1:
        remark = f"{remark}{'; ' if remark else ''}begun {record.starts} times"
    return RunStatus(name, state, remark, record.changed, record.starts)


def _named(runs: Sequence[RunStatus]) -> list[str]:
    """Write a line for each run, up to a number of them."""
    lines = [f"  {each.state}: {each.name}: {each.remark}" for each in runs[:MOST_NAMED]]
    if len(runs) > MOST_NAMED:
        lines.append(f"  {runs[0].state}: {len(runs) - MOST_NAMED} more")
    return lines


def _since(changed: str) -> str:
    """Write the time that has passed since a moment."""
    try:
        seconds = (datetime.now(UTC) - datetime.fromisoformat(changed)).total_seconds()
    except (ValueError, TypeError):  # a record that somebody edited
        return ""
    return f" since {max(0, round(seconds))} s"
