"""Tasks on any number of processes.

A failed run does not stop the others, nor does the kill of a worker. Ctrl-C stops the work after
the current steps.
"""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Protocol

from rolling.contact import compiling
from rolling.contact.solver import ContactError
from rolling.folders.files import Unwritable
from rolling.simulation import lifeline, spawning
from rolling.terminal import progress as terminal

_LOST = "a worker process was killed; the tasks that it may have had are done again, one by one"
_KILLED = "a worker process was killed twice while it had this run alone; out of memory?"


class Interrupted(Exception):
    """The end of the work at the user's request, before all of it is done."""


@dataclass(frozen=True, eq=False)
class Task:
    """A call `function(*arguments, stopped, progress)` that belongs to one run.

    The function raises Interrupted when `stopped()` is true, and calls `progress` with its share of
    the cost as it proceeds.

    run : int. Number of the run.
    function : callable. It stands in a module that can be imported.
    arguments : tuple. The first arguments of the call.
    cost : float. Sum of the progress that the task reports.
    """

    run: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: float


@dataclass
class Outcome:
    """The end of the work, with its failures.

    failures : dict. Reason of each failed run, by the number of the run.
    interrupted : bool. Whether the work was interrupted.
    """

    failures: dict[int, str] = field(default_factory=dict)
    interrupted: bool = False


def _ignore(value: object) -> None:
    """Do nothing with a value."""


@dataclass(frozen=True)
class Listener:
    """The functions that follow the work.

    finished : callable. It receives the run and the result of each task when the task is done, and
        returns the tasks that follow from it, or None.
    progress : callable. It receives shares of the cost. Default: nothing is done.
    begun : callable. It receives the run of each task when the task is handed out. Default: nothing
        is done.
    """

    finished: Callable[[int, Any], Sequence[Task] | None]
    progress: Callable[[float], object] = _ignore
    begun: Callable[[int], object] = _ignore


class Remote(Protocol):
    """Workers elsewhere, such as the workers of a cluster."""

    @property
    def address(self) -> str:
        """The address of the workers, for messages."""

    def work(
        self,
        tasks: Sequence[Task],
        listener: Listener,
        asked: Callable[[], bool],
        outcome: Outcome,
    ) -> None:
        """Do the tasks, until all are done or `asked` returns true."""


Workers = int | Remote  # local processes, or workers elsewhere


def work(
    tasks: Sequence[Task],
    workers: Workers,
    finished: Callable[[int, Any], Sequence[Task] | None],
    progress: Callable[[float], object] = _ignore,
    begun: Callable[[int], object] = _ignore,
) -> Outcome:
    """Do the tasks on `workers` processes, or on workers elsewhere.

    One worker, one task, or a system that starts no processes: all is done in this process.


    A run that fails with ContactError does not stop the others. The first Ctrl-C or SIGTERM stops
    all runs after the current step.

    Parameters
    ----------
    tasks : sequence of Task.
    workers : int or Remote. Number of processes, or workers elsewhere.
    finished, progress, begun : callable. The functions of the `Listener`.
    """
    listener, outcome = Listener(finished, progress, begun), Outcome()
    with _stop_request() as asked:
        if not isinstance(workers, int):
            workers.work(tasks, listener, asked, outcome)
            outcome.interrupted = asked()
            return outcome
        workers = min(workers, len(tasks))
        with _worker_environment():
            if workers <= 1 or not spawning.can_start_workers():
                with compiling.told(terminal.compiling):
                    _work_here(tasks, listener, asked, outcome)
            else:
                _work_in_parallel(tasks, workers, listener, asked, outcome)
        outcome.interrupted = asked()
    return outcome


def _work_here(
    tasks: Sequence[Task], listener: Listener, asked: Callable[[], bool], outcome: Outcome
) -> None:
    """Do the tasks one after the other in this process."""
    waiting = deque(tasks)
    while waiting:
        task = waiting.popleft()
        if task.run in outcome.failures:
            continue
        if not begin(task, listener, outcome):
            continue
        try:
            done = task.function(*task.arguments, asked, listener.progress)
        except ContactError as error:
            outcome.failures[task.run] = str(error)
        except Interrupted:
            break
        else:
            waiting.extend(finish(task, done, listener, outcome))


def _work_in_parallel(
    tasks: Sequence[Task],
    workers: int,
    listener: Listener,
    asked: Callable[[], bool],
    outcome: Outcome,
) -> None:
    """Do the tasks on worker processes, and once more one by one after the kill of a worker.

    Any of the tasks in hand may have caused the kill. The run of a task that is alone with a worker
    has failed when the worker is killed twice.
    """
    waiting = deque(tasks)
    while waiting:
        suspects = _work_until_a_kill(waiting, waiting, workers, listener, asked, outcome)
        if suspects:
            terminal.line(_LOST)
        for task in suspects:
            alone = [task]
            for _ in range(2):
                if alone and not asked():
                    alone = _work_until_a_kill(deque(alone), waiting, 1, listener, asked, outcome)
            if alone and not asked():
                outcome.failures.setdefault(task.run, _KILLED)


def _work_until_a_kill(
    waiting: deque[Task],
    following: deque[Task],
    workers: int,
    listener: Listener,
    asked: Callable[[], bool],
    outcome: Outcome,
) -> list[Task]:
    """Do waiting tasks on worker processes, with at most one more task in hand per worker.

    Parameters
    ----------
    waiting : deque of Task. It is emptied.
    following : deque of Task. It receives the tasks that follow.

    Returns
    -------
    suspects : The tasks in hand when a worker was killed; empty otherwise.
    """
    context = spawning.context()
    stop, compiles = context.Event(), context.Event()
    events = (stop, compiles)
    running: dict[Future[Any], Task] = {}
    with ProcessPoolExecutor(workers, context, _begin_worker, events) as pool:
        try:
            while waiting or running:
                while waiting and len(running) < 2 * workers:
                    task = waiting[0]
                    if task.run not in outcome.failures and begin(task, listener, outcome):
                        future = pool.submit(_in_worker, task)
                        running[future] = task
                    waiting.popleft()
                done, _ = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                for future in done:
                    following.extend(_collect(future, running[future], listener, outcome))
                    del running[future]
                if compiles.is_set():
                    terminal.compiling()
                if asked():
                    waiting.clear()
                    stop.set()
        except BrokenProcessPool:
            return [] if asked() else [*running.values()]
        finally:
            stop.set()  # before the pool waits for its workers, whatever happened
    return []


def _collect(
    future: Future[Any], task: Task, listener: Listener, outcome: Outcome
) -> Sequence[Task]:
    """Pass on the result of a task, or record the failure of its run; return tasks that follow."""
    try:
        done = future.result()
    except ContactError as error:
        outcome.failures.setdefault(task.run, str(error))
        return ()
    except Interrupted:
        return ()
    following = finish(task, done, listener, outcome)
    listener.progress(task.cost)
    return following


def begin(task: Task, listener: Listener, outcome: Outcome) -> bool:
    """Say that a task begins; return false where its run has failed by that.

    A run fails alone whose folder cannot be written, where the folders beside it can.
    """
    try:
        listener.begun(task.run)
    except Unwritable as error:
        if error.everywhere:
            raise
        outcome.failures.setdefault(task.run, str(error))
    return task.run not in outcome.failures


def finish(task: Task, done: Any, listener: Listener, outcome: Outcome) -> Sequence[Task]:
    """Pass on the result of a task and return the tasks that follow; its run may fail by that."""
    try:
        return listener.finished(task.run, done) or ()
    except ContactError as error:
        outcome.failures.setdefault(task.run, str(error))
    except Unwritable as error:
        if error.everywhere:
            raise
        outcome.failures.setdefault(task.run, str(error))
    return ()


@contextmanager
def _worker_environment() -> Iterator[None]:
    """Limit the numerical libraries of every started process to one thread.

    Workers that run several threads each would compete for the cores. The limits act because
    workers import numpy anew. Nor does a worker import modules from the working directory, where a
    stranger's `pickle.py` may lie.
    """
    pins = dict.fromkeys(
        (
            "OMP_NUM_THREADS",
            "OPENBLAS_NUM_THREADS",
            "MKL_NUM_THREADS",
            "NUMBA_NUM_THREADS",
            "PYTHONSAFEPATH",
        ),
        "1",
    )
    before = {name: os.environ.get(name) for name in pins}
    os.environ.update(pins)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


_worker_stop: Any = None


def _begin_worker(stop: Any, compiles: Any) -> None:
    """Prepare a worker process, which ends with its parent.

    It stops when `stop` is set, and sets `compiles` when it compiles a kernel.
    """
    global _worker_stop
    lifeline.end_with_parent()
    _worker_stop = stop
    compiling.tell_always(compiles.set)
    # Ctrl-C reaches the whole process group; the parent alone decides and sets the event.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _in_worker(task: Task) -> Any:
    return task.function(*task.arguments, _worker_stop.is_set, _ignore)


class _stop_request:
    """A context in which the first SIGINT or SIGTERM sets a flag and the second acts as usual."""

    def __enter__(self) -> Callable[[], bool]:
        self.asked = False
        self.before: dict[int, Any] = {}
        try:
            for number in (signal.SIGINT, signal.SIGTERM):
                self.before[number] = signal.signal(number, self._ask)
        except ValueError:  # only the main thread may handle signals
            pass
        return lambda: self.asked

    def _ask(self, number: int, frame: Any) -> None:
        self.asked = True
        signal.signal(number, self.before[number])

    def __exit__(self, *error: object) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)
