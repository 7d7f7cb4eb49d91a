"""The address of a Dask scheduler, and whether a scheduler answers there.

A client of Dask that gets no answer leaves a thread that delays the end of the program, so the
question comes first.
"""

from __future__ import annotations

import asyncio
import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

from rolling.scene.messages import SceneError

PORT = 8786  # of a scheduler that is started without one
_ADDRESS = re.compile(
    r"(?:(?:tcp|tls|ws|wss|ucx)://)?(?:[\w.-]+|\[[0-9a-f:.]+\])(?P<port>:\d{1,5})?", re.IGNORECASE
)


def answering(text: str, seconds: float) -> str:
    """Return the address of a scheduler that answers.

    Parameters
    ----------
    text : str. The address, or the name of a scheduler file (.json).
    seconds : float, s. Time for the answer.

    Raises
    ------
    SceneError : the file cannot be read, it holds no address, or no scheduler answers.
    """
    address = _of_file(Path(text)) if text.endswith(".json") else text
    if (parts := _ADDRESS.fullmatch(address)) is None:
        raise SceneError(
            [
                f"--cluster: got {address}, allowed: an address such as tcp://HOST:{PORT}, or the"
                " scheduler file (.json)"
            ]
        )
    address += "" if parts["port"] else f":{PORT}"
    try:
        with ThreadPoolExecutor(1) as thread:  # a notebook has a loop of its own in this one
            thread.submit(_answer, address, seconds).result()
    except Exception as error:  # of any kind where another program answers
        raise SceneError([f"--cluster: {text}: no scheduler answers ({_reason(error)})"]) from error
    return address


def _answer(address: str, seconds: float) -> None:
    """Wait for the answer of an address, in a thread without a loop of events."""
    asyncio.run(asyncio.wait_for(_ask(address, seconds), seconds + 1))


def _reason(error: Exception) -> str:
    """Say why no scheduler answers."""
    if isinstance(error, TimeoutError):
        return "a time-out"
    return str(error.__cause__ or error) if isinstance(error, OSError) else "not one of Dask"


def _of_file(path: Path) -> str:
    """Read the address in a scheduler file."""
    try:
        address = json.loads(path.read_text(encoding="utf-8"))["address"]
    except FileNotFoundError as error:
        raise SceneError([f"--cluster: {path}: no such scheduler file"]) from error
    except OSError as error:
        raise SceneError([f"--cluster: {path}: {error.strerror or error}"]) from error
    except (ValueError, KeyError, TypeError) as error:
        raise SceneError([f"--cluster: {path}: not a scheduler file of Dask"]) from error
    if not isinstance(address, str):
        raise SceneError([f"--cluster: {path}: not a scheduler file of Dask"])
    return address


async def _ask(address: str, seconds: float) -> None:
    """Connect to an address as a client of Dask does."""
    from distributed import comm, security

    dask: Any = comm
    arguments = cast(Any, security.Security)().get_connection_args("client")
    # (Its own time-out does not act on a program that takes the call and never answers.)
    (await dask.connect(address, timeout=seconds, **arguments)).abort()
