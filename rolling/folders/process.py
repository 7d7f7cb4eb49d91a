"""Processes identified by host, number and birth.

The number alone does not suffice, because it is used again after its process has ended.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Annotated

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

PROC = Path("/proc")


@dataclass(frozen=True, config=ConfigDict(strict=True, extra="forbid"))
class Process:
    """Process in a form that other processes can recognize.

    Attributes
    ----------
    host : str
        Name of the host.
    pid : int
        Number of the process.
    started : str
        Time of the start, for people.
    birth : str
        Birth, for programs; no two processes of a host and number share it. It is empty where the
        system does not tell it.
    """

    host: str
    pid: Annotated[int, Field(gt=0)]
    started: str
    birth: str

    def __str__(self) -> str:
        return f"process {self.pid} on host {self.host}"


@cache
def _host() -> str:
    return socket.gethostname()


def this_process() -> Process:
    """Return the calling process."""
    pid = os.getpid()
    birth = _birth(pid) or ""
    return Process(_host(), pid, _started(birth), birth)


def is_alive(process: Process) -> bool | None:
    """Tell whether a process still runs; return None where that cannot be seen from here."""
    if process.host != _host():
        return None
    ours, theirs = (_birth(os.getpid()) or "").split(), process.birth.split()
    if len(ours) != len(theirs):
        return None
    if len(ours) == 3:
        if ours[0] != theirs[0]:
            return False  # the host was started anew since
        if ours[1] != theirs[1]:
            return None  # numbers of another container
        birth = _birth(process.pid)
        return None if birth is None and _is_hidden(process.pid) else birth == process.birth
    if sys.platform == "win32":  # Windows has no harmless signal
        return None
    birth = _birth(process.pid)
    return birth is not None and birth == process.birth


def _is_hidden(pid: int) -> bool:
    """Tell whether the system hides a process of another user (/proc mounted with hidepid)."""
    try:
        os.kill(pid, 0)
    except PermissionError:
        return True
    except (OSError, OverflowError):
        return False
    return False


def _birth(pid: int) -> str | None:
    """Return the birth of a process; return None without such a process.

    It holds boot, number space and start on Linux, and the start elsewhere.
    """
    if (PROC / "self" / "stat").exists():
        with suppress(OSError, ValueError, IndexError):
            # The second field is the name of the command in brackets, which may hold brackets and
            # spaces itself.
            fields = (PROC / str(pid) / "stat").read_bytes().rpartition(b")")[2].split()
            if fields[0] not in (
                b"Z",
                b"X",
            ):  # excludes killed processes that are not yet waited for
                boot = (PROC / "sys/kernel/random/boot_id").read_text().strip()
                return f"{boot} {(PROC / 'self/ns/pid').readlink()} {int(fields[19])}"
        return None
    with suppress(OSError, subprocess.SubprocessError):
        command = ["ps", "-o", "lstart=", "-p", str(pid)]
        text = subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=10
        ).stdout
        return "-".join(text.split()) or None
    return None


def _started(birth: str) -> str:
    """Return the time of a birth for people, empty where it is unknown."""
    parts = birth.split()
    if len(parts) != 3:
        return birth
    with suppress(OSError, ValueError, StopIteration):
        lines = (PROC / "stat").read_text().splitlines()
        boot = next(int(line.split()[1]) for line in lines if line.startswith("btime "))
        seconds = boot + int(parts[2]) / os.sysconf("SC_CLK_TCK")
        return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
    return ""
