"""Places where tasks are done: this process, or processes of this machine.

A pool is used as a context. Its tasks are handed out by `rolling.run.executor`; the pool of a
cluster is in `rolling.run.cluster`.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from rolling.check import cost
from rolling.kinds import registry
from rolling.run import leftovers, worker
from rolling.terminal import progress

if TYPE_CHECKING:
    from rolling.marches.piece import Piece
    from rolling.scene.scene import Scene

MAX_TEAMS = 24  # each needs seven open files, of which some systems allow 256


@dataclass(frozen=True, eq=False)
class Task:
    """A call for a pool: the march of a piece, or the last files of a run.

    key : identity and key of the piece, or "finish" and the number of the run.
    function : callable. It stands in a module that can be imported.
    arguments : tuple. The arguments of the call.
    piece : Piece. None for the files of a run.
    seconds : float, s. Expected time of a piece.
    """

    key: tuple[str, str]
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    piece: Piece | None = None
    seconds: float = 0.0


class Pool(ExitStack):
    """Place where tasks are done, used as a context; this one does each at once in this process.

    teams : mapping. Number of processes by the name of their team. The processes of a team take the
        tasks that the team has in hand in turn.
    slots : int. Number of tasks per process that may be in hand at the same time.
    """

    teams: Mapping[Any, int] = {0: 1}
    slots = 1
    _has_reported_compiling = False

    def __enter__(self) -> Self:
        """Open the pool: solves in this process report that they compile."""
        from rolling.contact import compiling

        self.enter_context(compiling.reporting(self._report_compiling))
        return self

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand out a task to a team; raise BrokenExecutor where its processes were killed."""
        future: Future[Any] = Future()
        try:
            future.set_result(task.function(*task.arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def poll(self) -> None:
        """Pass on messages of the workers."""

    def rebuild(self) -> None:
        """Replace processes that were killed."""

    def failure_reason(self, error: Exception) -> str:
        """Return the reason why a task failed, or raise an error of the program."""
        raise error

    def _report_compiling(self) -> None:
        """Say once that a process compiles, and let spare cores compile the longest kernels."""
        if self._has_reported_compiling:
            return
        self._has_reported_compiling = True
        progress.compiling()
        if cost.cores() == 1:
            return
        with suppress(OSError):  # without another process all is compiled here
            for part in worker.COMPILED_AHEAD[: cost.cores() - 1]:
                compiler = worker.compiler(part)
                self.callback(compiler.wait)
                self.callback(compiler.kill)  # before the wait; kernels that are done stay


class LocalPool(Pool):
    """Pool of processes of this machine that end with this process.

    The processes do not import the main module, so scripts need no `__main__` guard.

    workers : int. Number of processes.
    teams : int. Number of teams that they make up.
    """

    slots = 2

    def __init__(self, workers: int, teams: int = 1) -> None:
        super().__init__()
        self.teams = {team: (workers + team) // teams for team in range(teams)}

    def __enter__(self) -> Self:
        """Start the processes, which end with the context."""
        leftovers.remove_leftovers()
        self.enter_context(_worker_environment())
        self._start()
        self.callback(self._stop)
        return self

    def _start(self) -> None:
        """Start an executor for each team."""
        from loky import ProcessPoolExecutor
        from loky.backend import get_context

        context = get_context("loky")
        self._compiles = context.Event()
        kinds = registry.packed()
        self._executors = {
            team: ProcessPoolExecutor(
                processes,
                context=context,
                initializer=worker.begin,
                initargs=(os.getpid(), self._compiles, kinds),
            )
            for team, processes in self.teams.items()
        }

    def _stop(self) -> None:
        """End all processes at once."""
        for executor in self._executors.values():
            executor.shutdown(wait=True, kill_workers=True)

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand a task to a team, which stores a piece in its file instead of sending it."""
        function = task.function
        if function is worker.solve_piece:
            _, pieces = task.arguments
            if pieces is not None:
                function = worker.store_piece
        future: Future[Any] = self._executors[team].submit(function, *task.arguments)
        return future

    def poll(self) -> None:
        """Say once that a process compiles."""
        if self._compiles.is_set():
            self._report_compiling()

    def rebuild(self) -> None:
        """Start new processes in place of those of a broken pool."""
        self._stop()
        self._start()


@contextmanager
def _worker_environment() -> Iterator[None]:
    """Set the environment of processes that start in this context."""
    before = {name: os.environ.get(name) for name in worker.ENVIRONMENT}
    os.environ.update(worker.ENVIRONMENT)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def local_pool(workers: int, scenes: Sequence[Scene]) -> Pool:
    """Return a pool for scenes; 0 workers: one per core.

    A single piece needs this process only. So does a process of another pool, whatever the number
    of workers. Scenes with one surface need one team.
    """
    from rolling.in_si.scene_surface import identity
    from rolling.marches.piece import track_pieces

    pieces = sum(len(track_pieces(scene.track.solved_steps)) for scene in scenes)
    surfaces = {identity(scene) for scene in scenes}
    return pool_for_tasks(workers, pieces, teams=len(surfaces))


def pool_for_tasks(workers: int, tasks: int, teams: int = 1) -> Pool:
    """Return a pool for a number of tasks; 0 workers: one per core.

    Its processes make up as many teams as there are, or fewer where there are fewer processes.
    """
    workers = min(workers or cost.cores(), tasks)
    if workers <= 1 or _is_of_a_pool():
        return Pool()
    try:
        _refuse_missing_semaphores()
    # A system without semaphores refuses the import or the call, and a sealed /dev/shm the lock.
    except (ImportError, NotImplementedError, OSError) as error:
        print(
            "warning: no worker processes, because the system has no semaphores for them"
            f" (is /dev/shm there and writable? {error}): all is done in one process",
            file=sys.stderr,
        )
        return Pool()
    return LocalPool(workers, teams=min(workers, teams, MAX_TEAMS))


def _refuse_missing_semaphores() -> None:
    """Make a lock of worker processes, which needs semaphores, on Linux in /dev/shm."""
    from loky.backend import get_context

    with _worker_environment():  # of the process that tidies up after workers, too
        get_context("loky").Lock()


def _is_of_a_pool() -> bool:
    """Tell whether this process belongs to a pool of another program, whose processes share cores.

    A process of `multiprocessing.Pool` is daemonic and must not have children. A worker of Dask may
    have some, but runs beside others.
    """
    if multiprocessing.current_process().daemon:
        return True
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return False
    try:
        distributed.get_worker()
    except ValueError:  # this thread does no task of a worker
        return False
    return True
