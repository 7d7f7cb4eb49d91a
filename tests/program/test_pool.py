"""Tasks on processes: a killed worker is replaced, and only the task that kills it fails."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from rolling.simulation import pool

TASKS = """\
import os, signal
from pathlib import Path

def note(place, number, kills, stopped, progress):
    begun = Path(place) / f"{number}"
    times = int(begun.read_text()) + 1 if begun.exists() else 1
    begun.write_text(str(times))
    if times <= kills:
        os.kill(os.getpid(), signal.SIGKILL)
    return number
"""


# The task kills its worker as Linux does when memory runs out. Windows has no such signal.
@pytest.mark.skipif(
    not hasattr(signal, "SIGKILL"), reason="no SIGKILL here, with which a task kills its worker"
)
def test_a_task_that_kills_its_worker_fails_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Task 1 kills every worker, task 3 its first one; all others are done."""
    (tmp_path / "noting.py").write_text(TASKS)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    import noting

    kills = {1: 100, 3: 1}
    tasks = [pool.Task(k, noting.note, (str(tmp_path), k, kills.get(k, 0)), 1.0) for k in range(6)]
    done: list[int] = []
    outcome = pool.work(tasks, 2, lambda run, number: done.append(number))
    assert sorted(done) == [0, 2, 3, 4, 5]
    assert [*outcome.failures] == [1] and "killed twice" in outcome.failures[1]
    assert (tmp_path / "1").read_text() in (
        "2",
        "3",
    )  # perhaps once beside others, then twice alone
    assert not outcome.interrupted
