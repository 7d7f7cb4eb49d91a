"""Tasks in a worker of a Dask scheduler.

The scheduler imports this module as well, so the solver is imported where a task is done.
"""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Answer:
    """The answer of a worker: a result, or the reason why there is none.

    kind : str. done, failed, stopped, refused or unwritable.
    value : the result, or the reason.
    """

    kind: str
    value: Any


_alone = threading.Lock()  # kernels and transforms keep state, so threads take turns
_stops: set[str] = set()  # tokens of clients that asked for a stop


def stop(token: str) -> None:
    """Stop the tasks of a client after the steps at hand."""
    _stops.add(token)


def sources() -> tuple[str, str]:
    """Return version and digest of the sources of the program in this process."""
    from rolling.folders import program

    identity = program.identity()
    return identity.version, identity.sources


def act(task: bytes, wanted: str, token: str) -> Answer:
    """Carry out a task.

    Parameters
    ----------
    task : bytes. The pickled function of a task, with its arguments.
    wanted : str. Digest of the sources of the program that the client runs.
    token : str. Token of the client.
    """
    version, own = sources()
    if own != wanted:
        return Answer("refused", f"version {version}, sources {own[:12]}")
    from rolling.contact.solver import ContactError
    from rolling.simulation.pool import Interrupted

    function, arguments = pickle.loads(task)
    stopped = _stop_request(token)
    try:
        with _alone:
            result = function(*arguments, stopped, lambda share: None)
            return Answer("stopped" if stopped() else "done", result)
    except (ContactError, MemoryError) as error:
        return Answer("failed", str(error) or "not enough memory")
    except OSError as error:
        return Answer("unwritable", str(error))
    except Interrupted:
        return Answer("stopped", None)
    except Exception as error:  # which may not be sent, and which stops no other run
        return Answer("failed", f"{type(error).__name__}: {error}")


def _stop_request(token: str) -> Callable[[], bool]:
    """Return whether the client asked for a stop or is gone, or the worker closes."""
    from distributed import get_worker

    worker = get_worker()
    key = worker.get_current_task()

    def stopped() -> bool:
        task = worker.state.tasks.get(key)
        forgotten = task is None or task.state == "cancelled"
        return token in _stops or forgotten or worker.status.name not in ("running", "paused")

    return stopped
