"""Tasks on any number of processes.

Failures are kept apart, and Ctrl-C stops the work after the steps at hand.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from rolling.contact import compiling
from rolling.contact.solver import ContactError
from rolling.simulation import lifeline, spawning
from rolling.terminal import progress as terminal

_KILLED = "a worker process was killed; out of memory? Fewer --workers need less"


class Interrupted(Exception):
    """The work was asked to stop before its end."""


@dataclass(frozen=True)
class Task:
    """A call `function(*arguments, stopped, progress)` that belongs to one run.

    The function raises Interrupted when `stopped()` is true, and calls `progress` with its share of
    the cost as it goes.

    run : number of the run.
    function : stands in a module that can be imported.
    cost : sum of the progress that the task makes.
    """

    run: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: float


@dataclass
class Outcome:
    """The end of the work: the reasons of failed runs by number, and whether the work was
    interrupted.
    """

    failures: dict[int, str] = field(default_factory=dict)
    interrupted: bool = False


def _ignore(value: object) -> None:
    """Do nothing with a value."""


@dataclass(frozen=True)
class Listener:
    """The functions that are told how the work goes; each does nothing unless it is given.

    finished : gets run and result of each task as it is done.
    progress : gets shares of the cost.
    begun : gets the run of each task as the task is handed out.
    """

    finished: Callable[[int, Any], object]
    progress: Callable[[float], object] = _ignore
    begun: Callable[[int], object] = _ignore


def work(
    tasks: Sequence[Task],
    workers: int,
    finished: Callable[[int, Any], object],
    progress: Callable[[float], object] = _ignore,
    begun: Callable[[int], object] = _ignore,
) -> Outcome:
    """Do the tasks on `workers` processes, or in this process when there is one worker or one task.

    A run that fails with ContactError does not stop the others. The first Ctrl-C or SIGTERM stops
    all after the step at hand.

    Parameters
    ----------
    finished, progress, begun : functions of the `Listener`.
    """
    listener, outcome = Listener(finished, progress, begun), Outcome()
    workers = min(workers, len(tasks))
    with _stop_request() as asked:
        if workers <= 1:
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
    for task in tasks:
        if task.run in outcome.failures:
            continue
        listener.begun(task.run)
        try:
            listener.finished(task.run, task.function(*task.arguments, asked, listener.progress))
        except ContactError as error:
            outcome.failures[task.run] = str(error)
        except Interrupted:
            break


def _work_in_parallel(
    tasks: Sequence[Task],
    workers: int,
    listener: Listener,
    asked: Callable[[], bool],
    outcome: Outcome,
) -> None:
    """Do the tasks on worker processes, of which each has at most one more task in store."""
    context = spawning.context()
    stop, compiles = context.Event(), context.Event()
    events = (stop, compiles)
    waiting = list(reversed(tasks))
    running: dict[Future[Any], Task] = {}
    with _one_thread_each(), ProcessPoolExecutor(workers, context, _begin_worker, events) as pool:
        try:
            while waiting or running:
                while waiting and len(running) < 2 * workers:
                    task = waiting.pop()
                    if task.run not in outcome.failures:
                        listener.begun(task.run)
                        running[pool.submit(_in_worker, task)] = task
                done, _ = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                for future in done:
                    _collect(future, running[future], listener, outcome)
                    del running[future]
                if compiles.is_set():
                    terminal.compiling()
                if asked():
                    waiting.clear()
                    stop.set()
        except BrokenProcessPool:
            for task in (*running.values(), *waiting):
                outcome.failures.setdefault(task.run, _KILLED)
        finally:
            stop.set()  # before the pool waits for its workers, whatever happened


def _collect(future: Future[Any], task: Task, listener: Listener, outcome: Outcome) -> None:
    """Hand the result of a task on, or note that its run failed."""
    try:
        listener.finished(task.run, future.result())
        listener.progress(task.cost)
    except ContactError as error:
        outcome.failures.setdefault(task.run, str(error))
    except Interrupted:
        pass


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Give each process that is started one thread: workers must not fight over cores, and they
    import numpy anew.
    """
    pins = dict.fromkeys(
        ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
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
    # Ctrl-C reaches the whole process group; the parent decides and tells through the event.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _in_worker(task: Task) -> Any:
    return task.function(*task.arguments, _worker_stop.is_set, _ignore)


class _stop_request:
    """A context in which the first SIGINT or SIGTERM only sets a flag; the second acts as usual."""

    def __enter__(self) -> Callable[[], bool]:
        self.asked = False
        self.before: dict[int, Any] = {}
        try:
            for number in (signal.SIGINT, signal.SIGTERM):
                self.before[number] = signal.signal(number, self._ask)
        except ValueError:  # not the main thread: signals are somebody else's
            pass
        return lambda: self.asked

    def _ask(self, number: int, frame: Any) -> None:
        self.asked = True
        signal.signal(number, self.before[number])

    def __exit__(self, *error: object) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)
