"""Pool of the workers of a Dask scheduler."""

from __future__ import annotations

import asyncio
import json
import logging
import socket
import time
from collections.abc import Hashable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, Self, cast
from urllib.parse import urlsplit

from rolling.kinds import registry
from rolling.run import worker
from rolling.run.pools import Pool, Task
from rolling.scene.messages import SceneError
from rolling.terminal import program
from rolling.terminal.whole_files import read_regular

CONNECT_SECONDS = 10.0
COUNT_SECONDS = 5.0  # between two counts of the workers of a cluster
MAX_FILE = 1_000_000  # bytes of a scheduler file
PORT = 8786  # of a scheduler whose address names none


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
        address = _answering_address(self.address)
        dask: Any = distributed
        self._client = dask.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
        self._executor = self._client.get_executor(pure=False)
        self.callback(self._leave)
        try:
            self._refuse_other_programs()
        except BaseException:
            self.close()
            raise
        self._count_workers()
        return self

    def _leave(self) -> None:
        """Give up all tasks and leave the scheduler."""
        with suppress(Exception):  # a scheduler that is gone cannot be told
            self._executor.shutdown(wait=False, cancel_futures=True)
            self._client.close(timeout=2)

    def _refuse_other_programs(self) -> None:
        """Raise SceneError where the scheduler has no worker, or one that runs another program."""
        own = program.identity()
        programs = self._client.run(program.identity, on_error="return")
        others = [f"  {place}: {other}" for place, other in programs.items() if other != own]
        if not programs:
            others = ["  it has no worker"]
        if others:
            lines = "\n".join(others)
            raise SceneError([f"--cluster: {self.address}: all workers must run {own}\n{lines}"])

    def _count_workers(self) -> None:
        """Count the workers; without any, tasks wait at the scheduler for the next one."""
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        if workers:
            self.teams = dict.fromkeys(workers, 1)
        self._counted_at = time.monotonic()

    def submit(self, task: Task, team: Hashable = 0) -> Future[Any]:
        """Hand a task to the scheduler, which gives it to another worker if one is killed."""
        future: Future[Any] = self._executor.submit(
            worker.run_task,
            registry.packed(task.function, task.arguments),
            program.identity(),
            workers=[team],
            allow_other_workers=True,
        )
        return future

    def rebuild(self) -> None:
        """Raise ConnectionError: a scheduler cannot be replaced from here."""
        raise ConnectionError(f"the scheduler at {self.address} is gone")

    def poll(self) -> None:
        """Count the workers now and then; raise ConnectionError when the scheduler is gone."""
        status = self._client.status
        if status == "closed":
            self.rebuild()
        if status == "running" and time.monotonic() - self._counted_at > COUNT_SECONDS:
            self._count_workers()

    def failure_reason(self, error: Exception) -> str:
        """Return the reason why a task failed on its workers, or raise its error."""
        from distributed.scheduler import KilledWorker

        if isinstance(error, KilledWorker):
            return "its workers were killed again and again; out of memory?"
        if isinstance(error, worker.OtherProgramError):
            raise OSError(f"a worker that joined late runs another program: {error}") from error
        raise error


def _answering_address(text: str) -> str:
    """Return the address of a scheduler that answers; a scheduler file (.json) may name it.

    A client of Dask waits for ever for a program that takes its call and never answers, so it is
    asked here first, with a time-out.
    """
    address = text
    reason = "not one of Dask"
    try:
        if text.endswith(".json"):
            address = str(json.loads(read_regular(Path(text), MAX_FILE))["address"])
        if not address.rpartition(":")[2].isdecimal():
            address += f":{PORT}"
        _connect_plainly(address)
        with ThreadPoolExecutor(1) as thread:  # a notebook has a loop of its own in this one
            thread.submit(asyncio.run, _connect_as_client(address)).result()
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


def _connect_plainly(address: str) -> None:
    """Open and close a plain connection, whose error is always the system's own.

    Dask tries again and again, and may end with a time-out instead.
    """
    place = urlsplit(address if "://" in address else f"tcp://{address}")
    if place.scheme in ("tcp", "tls") and place.hostname and place.port:
        socket.create_connection((place.hostname, place.port), CONNECT_SECONDS).close()


async def _connect_as_client(address: str) -> None:
    """Connect to an address as a client of Dask does, and hang up."""
    from distributed import comm, security

    dask: Any = comm
    arguments = cast(Any, security.Security)().get_connection_args("client")
    connecting = dask.connect(address, timeout=CONNECT_SECONDS, **arguments)
    connection = await asyncio.wait_for(connecting, CONNECT_SECONDS + 1)
    connection.abort()
