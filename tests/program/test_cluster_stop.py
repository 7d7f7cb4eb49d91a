"""A stop of work on a cluster, where the scheduler cannot be asked any more."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from typing import Any

import pytest

from rolling.scene.messages import SceneError
from rolling.simulation import cluster, cluster_address
from rolling.simulation.cluster import Cluster, _Work
from rolling.simulation.cluster_worker import Answer
from rolling.simulation.pool import Listener, Outcome, Task

pytest.importorskip("distributed", reason="a cluster needs Dask")
from distributed.client import ClosedClientError
from distributed.comm.core import CommClosedError


class Future:
    """A task on a worker, which ends when it is told."""

    status = "pending"

    def add_done_callback(self, ended: Any) -> None:
        self.ended = ended

    def end(self, value: object) -> None:
        self.status, self.value = "finished", value
        self.ended(self)

    def result(self, timeout: float) -> Answer:
        return Answer("done", self.value)

    def release(self) -> None:
        pass


class Client:
    """A client with a worker, whose questions fail with errors."""

    status = "running"

    def __init__(self, *errors: Exception) -> None:
        self.errors, self.futures, self.asked = [*errors], list[Future](), 0

    def submit(self, *arguments: Any, **more: Any) -> Future:
        self.futures.append(Future())
        return self.futures[-1]

    def run(self, *arguments: Any, on_error: str) -> None:
        self.asked += 1
        if self.errors:
            raise self.errors.pop(0)
        self.futures[0].end("the steps at hand")

    def cancel(self, futures: Any, force: bool) -> None:
        raise ClosedClientError("Client is closed. Can't send cancel-keys message.")


def do(client: Client, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Do two tasks of which the first is at hand when a stop is asked for; return the results."""
    monkeypatch.setattr(cluster, "_usable", lambda *_, **__: {"worker"})
    monkeypatch.setattr(cluster, "WAIT_SECONDS", 0.01)
    results: list[Any] = []
    listener = Listener(lambda run, value: results.append(value))
    work = _Work(client, Cluster("here"), listener, Outcome())
    tasks = [Task(run, print, (), 1.0) for run in (0, 1)]
    work.do(deque(tasks), lambda: bool(client.futures))
    assert len(client.futures) == 1
    return results


@pytest.mark.parametrize(
    "error",
    [CommClosedError("gone"), TimeoutError("late"), OSError("Timed out"), ClosedClientError()],
)
def test_a_request_to_stop_that_fails_is_made_again(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = Client(error)
    assert do(client, monkeypatch) == ["the steps at hand"]
    assert client.asked == 2


def test_a_scheduler_that_is_gone_at_the_end_of_a_stop_ends_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cluster, "STOP_SECONDS", 0.05)
    assert do(Client(*[CommClosedError("gone")] * 10000), monkeypatch) == []


def test_a_scheduler_that_stays_away_during_a_stop_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(cluster, "LOST_SECONDS", 0.05)
    client = Client(CommClosedError("gone"))
    monkeypatch.setattr(
        client, "run", lambda *_, **__: setattr(client, "status", "connecting"), raising=False
    )
    start = time.monotonic()
    with pytest.raises(ConnectionError, match=r"^the scheduler at here is gone$"):
        do(client, monkeypatch)
    assert time.monotonic() - start < 5


def test_a_scheduler_is_asked_from_within_a_notebook() -> None:
    """A notebook runs the loop in which its cells are executed."""

    async def cell() -> str:
        return cluster_address.answering("tcp://127.0.0.1:9", 1.0)

    with pytest.raises(SceneError, match="no scheduler answers") as refused:
        asyncio.run(cell())
    assert "not one of Dask" not in str(refused.value)
