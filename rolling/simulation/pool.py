"""Tasks on any number of processes: failures kept apart, stopped by Ctrl-C after what is at hand.

Depends on contact (ContactError) and lifeline.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from rolling.contact.solver import ContactError
from rolling.simulation import lifeline


class Interrupted(Exception):
    """The work was asked to stop before its end."""


@dataclass(frozen=True)
class Task:
    """`function(*arguments, stopped, progress)` for one run, by number; `cost` is what it adds to the progress in all.

    The function raises Interrupted when `stopped()` says so, and calls `progress` with its share of the cost as it goes.
    """

    run: int
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    cost: float


@dataclass
class Outcome:
    """How the work ended: runs that failed with their reason, and whether it was interrupted."""

    failures: dict[int, str] = field(default_factory=dict)
    interrupted: bool = False


def work(
    tasks: Sequence[Task],
    workers: int,
    finished: Callable[[int, Any], None],
    progress: Callable[[float], object] = lambda cost: None,
    begun: Callable[[int], object] = lambda run: None,
) -> Outcome:
    """Do the tasks on `workers` processes, in this one when that is 1; `finished` gets run and result as each is done.

    `begun` gets the run of each task as it is handed out.
    A run that fails with ContactError does not stop the others. The first Ctrl-C or SIGTERM stops all after the step at hand.
    """
    outcome = Outcome()
    with _asked_to_stop() as asked:
        if min(workers, len(tasks)) <= 1:
            for task in tasks:
                if task.run in outcome.failures:
                    continue
                begun(task.run)
                try:
                    finished(task.run, task.function(*task.arguments, asked, progress))
                except ContactError as error:
                    outcome.failures[task.run] = str(error)
                except Interrupted:
                    break
        else:
            _work_parallel(tasks, workers, finished, progress, begun, asked, outcome)
        outcome.interrupted = asked()
    return outcome


def _work_parallel(
    tasks: Any, workers: int, finished: Any, progress: Any, begun: Any, asked: Any, outcome: Any
) -> None:
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    waiting = list(reversed(tasks))
    running: dict[Future[Any], Task] = {}
    with _one_thread_each(), ProcessPoolExecutor(min(workers, len(tasks)), context, _begin_worker, (stop,)) as pool:
        try:
            while waiting or running:
                while waiting and len(running) < 2 * workers:
                    task = waiting.pop()
                    if task.run not in outcome.failures:
                        begun(task.run)
                        running[pool.submit(_in_worker, task)] = task
                done, _ = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
                for future in done:
                    task = running[future]
                    try:
                        finished(task.run, future.result())
                        progress(task.cost)
                    except ContactError as error:
                        outcome.failures.setdefault(task.run, str(error))
                    except Interrupted:
                        pass
                    del running[future]
                if asked():
                    waiting.clear()
                    stop.set()
        except BrokenProcessPool:
            for task in (*running.values(), *waiting):
                outcome.failures.setdefault(
                    task.run, "a worker process was killed; out of memory? Fewer --workers need less"
                )
        finally:
            stop.set()  # before the pool waits for its workers, whatever happened


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Workers must not fight over cores; spawned processes read this when they import numpy."""
    pins = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
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


def _begin_worker(stop: Any) -> None:
    global _worker_stop
    lifeline.end_with_parent()
    _worker_stop = stop
    # Ctrl-C reaches the whole process group; the parent decides and tells through the event.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _in_worker(task: Task) -> Any:
    return task.function(*task.arguments, _worker_stop.is_set, lambda cost: None)


class _asked_to_stop:
    """While open, the first SIGINT or SIGTERM only sets a flag; a second one acts as usual."""

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
