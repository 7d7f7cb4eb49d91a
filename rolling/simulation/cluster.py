"""Tasks on the workers of a Dask scheduler, behind the same interface as the local pool.

A worker is asked for the digest of its sources before it computes, and computes one task at a time.
Scenes travel as validated models; workers write runs to the shared folder themselves.
"""

from __future__ import annotations

import logging
import pickle
import queue
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, cast

from rolling.scene.messages import SceneError
from rolling.simulation import cluster_address, cluster_worker
from rolling.simulation.cluster_worker import Answer
from rolling.simulation.pool import Listener, Outcome, Task, begin, finish
from rolling.terminal import progress as terminal

CONNECT_SECONDS = 10.0
LOST_SECONDS = 5.0  # without the scheduler, before the work is given up
STOP_SECONDS = 60.0  # for steps at hand, after Ctrl-C
LOOK_SECONDS = 1.0  # between two looks at the workers
WAIT_SECONDS = 0.2  # for the end of a task
RESULT_SECONDS = 10.0  # for a few kB of a task that has ended
MOST_KILLS = 4  # of the workers of a task, before its run has failed
_INSTALL = 'pip install "rolling-contact-noise[cluster]"'


# ---- in the client


@dataclass(frozen=True)
class Cluster:
    """A Dask scheduler, whose workers do tasks in place of local processes.

    address : str. Address, such as tcp://127.0.0.1:8786, or the name of its scheduler file.
    """

    address: str

    def work(
        self,
        tasks: Sequence[Task],
        listener: Listener,
        asked: Callable[[], bool],
        outcome: Outcome,
    ) -> None:
        """Do the tasks on the workers of the scheduler, one at a time on each.

        Raises
        ------
        OSError : the scheduler is gone, or no worker can write.
        SceneError : no worker can be used.
        """
        if not tasks:
            return
        with _client(self) as client:
            _Work(client, self, listener, outcome).do(deque(tasks), asked)


@contextmanager
def _client(cluster: Cluster) -> Iterator[Any]:
    """Connect to the scheduler.

    Raises
    ------
    SceneError : the package is missing, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise SceneError([f"--cluster: needs Dask: {_INSTALL}"]) from error
    for name in ("distributed", "tornado", "asyncio"):  # their lines would stand between ours
        logging.getLogger(name).setLevel(logging.CRITICAL)
    address = cluster_address.answering(cluster.address, CONNECT_SECONDS)
    client: Any = cast(Any, Client)(address, timeout=CONNECT_SECONDS, set_as_default=False)
    try:
        yield client
    finally:
        with suppress(Exception):  # a scheduler that is gone cannot be told
            client.close(timeout=2)


def workers(cluster: Cluster) -> int:
    """Count the workers that can do tasks.

    Raises
    ------
    SceneError : there is no scheduler, or none of its workers runs this version.
    """
    with _client(cluster) as client:
        return len(_usable(client, cluster, told=True))


def _usable(client: Any, cluster: Cluster, told: bool) -> set[str]:
    """Return the addresses of the workers that run this version of the program.

    Raises
    ------
    SceneError : there is none.
    """
    ours = cluster_worker.sources()
    answers = client.run(cluster_worker.sources, on_error="return")
    usable = {address for address, answer in answers.items() if answer == ours}
    others = {
        address: f"version {answer[0]}, sources {answer[1][:12]}"
        if isinstance(answer, tuple)
        else f"the program is not there ({answer})"
        for address, answer in answers.items()
        if address not in usable
    }
    if told:
        for address, text in others.items():
            terminal.line(_refusal(address, text))
    if not usable:
        named = "".join(f"\n  {address}: {text}" for address, text in others.items())
        raise SceneError(
            [
                f"--cluster: {cluster.address}: no worker runs version {ours[0]}, sources"
                f" {ours[1][:12]}{named}"
            ]
        )
    return usable


def _refusal(address: str, text: str) -> str:
    return f"worker {address} is not used: {text}, not {cluster_worker.sources()[1][:12]}"


class _Work:
    """Tasks in hand, each on a worker of its own, so that a kill has one possible cause.

    client : distributed.Client.
    """

    def __init__(self, client: Any, cluster: Cluster, listener: Listener, outcome: Outcome) -> None:
        self.client, self.cluster = client, cluster
        self.listener, self.outcome = listener, outcome
        self.token = f"rolling-{time.time_ns()}"
        self.running: dict[Any, tuple[Task, str]] = {}  # task and worker by future
        self.ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self.kills: Counter[Task] = Counter()
        self.submitted = 0
        self.usable: set[str] = set()  # workers
        self.looked = time.monotonic()  # at the workers
        self.avoided: dict[str, str] = {}  # reasons by worker
        self.lost_since: float | None = None
        self.stopping = 0.0  # time of the request to stop
        self.has_stopped = False  # whether the workers have the request

    def do(self, waiting: deque[Task], asked: Callable[[], bool]) -> None:
        """Do tasks until none waits or runs, or until a stop is asked for."""
        from distributed.client import ClosedClientError
        from distributed.comm.core import CommClosedError

        lost = CommClosedError, ClosedClientError
        try:
            self.usable = _usable(self.client, self.cluster, told=False)
        except lost as error:
            raise self._gone() from error
        while waiting or self.running:
            try:
                self._go_on(waiting)
            except lost:  # in the middle of a question; `_is_connected` tells more
                time.sleep(WAIT_SECONDS)
            if asked():
                waiting.clear()
                # A failure is no reason to lose the ends of tasks at hand: the question is asked
                # again, and `_is_connected` says when nobody is left to ask.
                with suppress(OSError, ClosedClientError):
                    self._stop()
            if self.stopping and time.monotonic() - self.stopping > STOP_SECONDS:
                with suppress(OSError, ClosedClientError):  # a lost connection cancels as well
                    self.client.cancel(list(self.running), force=True)
                return

    def _stop(self) -> None:
        """Ask the workers once to stop after the steps at hand.

        Raises
        ------
        OSError, ClosedClientError : they cannot be asked.
        """
        self.stopping = self.stopping or time.monotonic()
        if not self.has_stopped and self.client.status == "running":
            self.client.run(cluster_worker.stop, self.token, on_error="ignore")
            self.has_stopped = True

    def _go_on(self, waiting: deque[Task]) -> None:
        """Look at the workers where it is time, hand out tasks, and take the end of one."""
        connected = self._is_connected()
        if connected and time.monotonic() - self.looked > LOOK_SECONDS:
            self.usable = self._look(waiting)
            self.looked = time.monotonic()
        idle = self.usable - self.avoided.keys() - {worker for _, worker in self.running.values()}
        while connected and waiting and idle:
            self._submit(waiting[0], idle.pop())
            waiting.popleft()
        with suppress(queue.Empty):
            self._take(self.ended.get(timeout=WAIT_SECONDS), waiting)

    def _look(self, waiting: deque[Task]) -> set[str]:
        """Return the addresses of all workers, and take back the tasks of those that are gone."""
        there = set(self.client.scheduler_info(n_workers=-1)["workers"])
        for future, (task, worker) in [*self.running.items()]:
            if worker in there:
                continue
            del self.running[future]
            with suppress(OSError):  # a lost connection cancels it as well
                self.client.cancel([future], force=True)
            self.kills[task] += 1
            if self.kills[task] >= MOST_KILLS:
                reason = f"its worker was killed {MOST_KILLS} times; out of memory?"
                self.outcome.failures.setdefault(task.run, reason)
            elif not self.stopping:
                terminal.line(f"worker {worker} is gone; its task is done again")
                waiting.append(task)
        return there

    def _submit(self, task: Task, worker: str) -> None:
        """Hand a task to a worker."""
        if task.run in self.outcome.failures or not begin(task, self.listener, self.outcome):
            return
        self.submitted += 1
        future = self.client.submit(
            cluster_worker.act,
            pickle.dumps((task.function, task.arguments)),
            cluster_worker.sources()[1],
            self.token,
            pure=False,
            key=f"{self.token}-{task.run}-{self.submitted}",
            workers=[worker],
        )
        self.running[future] = task, worker
        future.add_done_callback(self.ended.put)

    def _take(self, future: Any, waiting: deque[Task]) -> None:
        """Take the end of a task."""
        if future not in self.running:
            return None
        task, worker = self.running[future]
        try:
            if not self._is_connected():
                time.sleep(WAIT_SECONDS)
                self.ended.put(future)
                return None
            # A result that is lost with its worker never comes.
            done = future.status == "finished"
            answer = future.result(timeout=RESULT_SECONDS) if done else None
            if answer is None and future.status != "error" and not self.stopping:
                return self._do_again(future, waiting)
        except (TimeoutError, CancelledError):  # its worker or the connection is just being lost
            self.ended.put(future)
            return None
        except OSError:
            self.ended.put(future)
            raise
        del self.running[future]
        if answer is not None:
            self._answer(task, worker, answer, waiting)
        elif future.status == "error":
            error = future.exception()
            self.outcome.failures.setdefault(task.run, f"{type(error).__name__}: {error}")
        future.release()
        return None

    def _do_again(self, future: Any, waiting: deque[Task]) -> None:
        """Hand a task out again that was lost with its worker, or with the connection.

        A worker that lives may still be at it, and holds its run meanwhile, so it has it again.
        """
        self._look(waiting)
        if future in self.running:
            self._submit(*self.running[future])
            del self.running[future]  # after it, because a lost connection ends `_submit`

    def _answer(self, task: Task, worker: str, answer: Answer, waiting: deque[Task]) -> None:
        """Act on the answer of a worker."""
        if answer.kind == "failed":
            self.outcome.failures.setdefault(task.run, answer.value)
        elif answer.kind in ("refused", "unwritable"):
            waiting.append(task)
            self._avoid(worker, answer, waiting)
        elif answer.kind == "stopped" and not self.stopping:  # its worker closes
            waiting.append(task)
        elif answer.value is not None:
            following = finish(task, answer.value, self.listener, self.outcome)
            waiting.extend(() if self.stopping else following)
            self.listener.progress(task.cost)

    def _avoid(self, worker: str, answer: Answer, waiting: deque[Task]) -> None:
        """Give no more tasks to a worker of another version, or to one that cannot write.

        Raises
        ------
        OSError : no worker is left.
        """
        if answer.kind == "refused":
            text = _refusal(worker, answer.value)
        else:
            text = f"worker {worker} is not used any more: {answer.value}"
        terminal.line(text)
        self.avoided[worker] = text
        if not self._look(waiting) - self.avoided.keys():
            raise OSError(f"no worker is left; {text}")

    def _is_connected(self) -> bool:
        """Tell whether the scheduler answers.

        Raises
        ------
        OSError : it has not answered for a while.
        """
        if self.client.status == "running":
            self.lost_since = None
            return True
        self.lost_since = self.lost_since or time.monotonic()
        if time.monotonic() - self.lost_since > LOST_SECONDS or self.client.status == "closed":
            raise self._gone()
        return False

    def _gone(self) -> ConnectionError:
        return ConnectionError(f"the scheduler at {self.cluster.address} is gone")
