"""Places where tasks are done: this process, processes of this machine, workers of a cluster.

Each pool is a context, to which `submit` hands tasks.
"""

from __future__ import annotations

import asyncio
import json
import logging
import multiprocessing
import os
import pickle
import socket
import sys
import time
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast
from urllib.parse import urlsplit

from rolling.check import cost
from rolling.run import worker
from rolling.scene.messages import SceneError
from rolling.terminal import program, progress

if TYPE_CHECKING:
    from rolling.marches.piece import Piece
    from rolling.scene.scene import Scene

CONNECT_SECONDS = 10.0
COUNT_SECONDS = 5.0  # between two counts of the workers of a cluster
MAX_TEAMS = 24  # each needs seven open files, of which some systems allow 256
PORT = 8786  # of a scheduler whose address names none


@dataclass(frozen=True, eq=False)
class Task:
    """A call for a pool: the march of a piece, or the last files of a run.

    key : identity and key of the piece, or "finish" and the number of the run.
    function : callable. It stands in a module that can be imported.
    arguments : tuple. The arguments of the call.
    piece : Piece. None for the files of a run.
    """

    key: tuple[str, str]
    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    piece: Piece | None = None


class Pool(ExitStack):
    """Place where tasks are done, used as a context; this one does each at once in this process.

    teams : mapping. Number of processes by the name of their team. The processes of a team take the
        tasks that the team has in hand in turn.
    slots : int. Number of tasks per process that may be in hand at the same time.
    """

    teams: Mapping[Any, int] = {0: 1}
    slots = 1
    _is_told = False  # that a process compiles

    def __enter__(self) -> Self:
        from rolling.contact import compiling

        self.enter_context(compiling.reporting(self._tell_compiling))
        return self

    def _tell_compiling(self) -> None:
        """Say once that a process compiles, and let a spare core compile the longest kernels."""
        if self._is_told:
            return
        self._is_told = True
        progress.compiling()
        if cost.cores() > 1:
            with suppress(OSError):  # no process to be had: all is compiled here
                for part in worker.COMPILED_AHEAD:
                    compiler = worker.compiler(part)
                    self.callback(compiler.wait)
                    self.callback(compiler.kill)  # before the wait; kernels that are done stay

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand out a task to a team."""
        future: Future[Any] = Future()
        try:
            future.set_result(task.function(*task.arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    def rebuild(self) -> None:
        """Replace processes that broke."""

    def look(self) -> None:
        """Pass on messages of the workers."""

    def reason(self, error: Exception) -> str:
        """Return the reason why a task failed, or raise its error, which is none of the physics."""
        raise error


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
        self.enter_context(_worker_environment())
        self._start()
        self.callback(self._stop)
        return self

    def _start(self) -> None:
        from loky import ProcessPoolExecutor
        from loky.backend import get_context

        context = get_context("loky")
        self._compiles = context.Event()
        self._pools = {
            team: ProcessPoolExecutor(
                processes,
                context=context,
                initializer=worker.begin,
                initargs=(os.getpid(), self._compiles),
            )
            for team, processes in self.teams.items()
        }

    def _stop(self) -> None:
        for pool in self._pools.values():
            pool.shutdown(wait=True, kill_workers=True)

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand a task to a team, which stores a piece in its file instead of sending it."""
        has_file = task.function is worker.solve_piece and task.arguments[1] is not None
        function = worker.store_piece if has_file else task.function
        future: Future[Any] = self._pools[team].submit(function, *task.arguments)
        return future

    def rebuild(self) -> None:
        """Start new processes in place of a pool that broke."""
        self._stop()
        self._start()

    def look(self) -> None:
        """Say once that a process compiles."""
        if self._compiles.is_set():
            self._tell_compiling()


def local_pool(workers: int, scenes: Sequence[Scene]) -> Pool:
    """Return a pool for scenes; 0 workers: one per core. One piece needs this process only.

    So does a process of another pool, whatever the number of workers. Scenes with one surface need
    one team.
    """
    from rolling.marches.piece import track_pieces
    from rolling.surface.scene_surface import identity

    pieces = sum(len(track_pieces(scene.track.solved_steps)) for scene in scenes)
    workers = min(workers or cost.cores(), pieces)
    if workers <= 1 or _is_of_a_pool():
        return Pool()
    try:
        from loky.backend import get_context

        with _worker_environment():  # of the process that tidies up after workers, too
            get_context("loky").Lock()  # which needs semaphores, on Linux in /dev/shm
    # A system without semaphores refuses the import or the call, and a sealed /dev/shm the lock.
    except (ImportError, NotImplementedError, OSError) as error:
        print(
            "warning: no worker processes, because the system has no semaphores for them"
            f" (is /dev/shm there and writable? {error}): all is done in one process",
            file=sys.stderr,
        )
        return Pool()
    return LocalPool(workers, min(workers, len({identity(scene) for scene in scenes}), MAX_TEAMS))


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


class Cluster(Pool):
    """Pool of the workers of a Dask scheduler, which share the run folder with this process.

    Each worker is a team, by its address.

    address : str. Address of the scheduler, or the name of its scheduler file.
    """

    slots = 2

    def __init__(self, address: str) -> None:
        super().__init__()
        self.address = address

    def __enter__(self) -> Self:
        """Connect to the scheduler.

        Raises
        ------
        SceneError : Dask is missing, no scheduler answers, or a worker runs another program.
        """
        try:
            import distributed
        except ImportError as error:
            install = 'pip install "rolling-contact-noise[cluster]"'
            raise SceneError([f"--cluster: needs Dask: {install}"]) from error
        for name in ("distributed", "tornado", "tornado.application", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        address = _answering(self.address)
        dask: Any = distributed
        self._client = dask.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        self._executor = self._client.get_executor(pure=False)
        self.callback(self._leave)
        try:
            self._refuse_other_programs()
        except BaseException:
            self.close()
            raise
        self._count()
        return self

    def _leave(self) -> None:
        with suppress(Exception):  # a scheduler that is gone cannot be told
            self._executor.shutdown(wait=False, cancel_futures=True)
            self._client.close(timeout=2)

    def _refuse_other_programs(self) -> None:
        own = program.identity()
        answers = self._client.run(program.identity, on_error="return")
        others = [f"  {name}: {answer}" for name, answer in answers.items() if answer != own]
        if others or not answers:
            lines = "\n".join(others) or "  it has no worker"
            raise SceneError([f"--cluster: {self.address}: all workers must run {own}\n{lines}"])

    def _count(self) -> None:
        """Count the workers; without any, tasks wait at the scheduler for the next one."""
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        self.teams, self._counted = dict.fromkeys(workers or self.teams, 1), time.monotonic()

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand a task to the scheduler, which gives it to another worker if one is killed."""
        content = pickle.dumps((task.function, task.arguments)), program.identity()
        preferred = {"workers": [team], "allow_other_workers": True}
        future: Future[Any] = self._executor.submit(worker.act, *content, **preferred)
        return future

    def rebuild(self) -> None:
        """Raise ConnectionError: a scheduler cannot be replaced from here."""
        raise ConnectionError(f"the scheduler at {self.address} is gone")

    def look(self) -> None:
        """Count the workers now and then; raise ConnectionError when the scheduler is gone."""
        if self._client.status == "closed":
            self.rebuild()
        if self._client.status == "running" and time.monotonic() - self._counted > COUNT_SECONDS:
            self._count()

    def reason(self, error: Exception) -> str:
        """Return the reason why a task failed on its workers, or raise its error."""
        from distributed.scheduler import KilledWorker

        if isinstance(error, KilledWorker):
            return "its workers were killed again and again; out of memory?"
        if isinstance(error, worker.OtherProgramError):
            raise OSError(f"a worker that joined late runs another program: {error}") from error
        raise error


def _answering(text: str) -> str:
    """Return the address of a scheduler that answers; a scheduler file (.json) may name it.

    A client of Dask waits for ever for a program that takes its call and never answers, so the
    question comes first.
    """
    address, reason = text, "not one of Dask"
    try:
        if text.endswith(".json"):
            address = str(json.loads(Path(text).read_text(encoding="utf-8"))["address"])
        if not address.rpartition(":")[2].isdecimal():
            address += f":{PORT}"
        _call(address)
        with ThreadPoolExecutor(1) as thread:  # a notebook has a loop of its own in this one
            thread.submit(asyncio.run, _ask(address)).result()
    except TimeoutError:
        reason = "a time-out"
    except OSError as error:
        cause: BaseException = error  # Dask wraps the error of the system
        while cause.__cause__ is not None:
            cause = cause.__cause__
        # A time-out has no words of its own.
        reason = str(getattr(cause, "strerror", None) or cause) or "a time-out"
    except Exception:  # of any kind where another program answers
        pass
    else:
        return address
    raise SceneError([f"--cluster: {text}: no scheduler answers ({reason})"])


def _call(address: str) -> None:
    """Open and close a plain connection, whose error is always the system's own.

    Dask tries again and again, and may end with a time-out instead.
    """
    place = urlsplit(address if "://" in address else f"tcp://{address}")
    if place.scheme in ("tcp", "tls") and place.hostname and place.port:
        socket.create_connection((place.hostname, place.port), CONNECT_SECONDS).close()


async def _ask(address: str) -> None:
    """Connect to an address as a client of Dask does, and hang up."""
    from distributed import comm, security

    dask: Any = comm
    arguments = cast(Any, security.Security)().get_connection_args("client")
    call = dask.connect(address, timeout=CONNECT_SECONDS, **arguments)
    (await asyncio.wait_for(call, CONNECT_SECONDS + 1)).abort()
