"""Semaphores in shared memory that processes of a pool left when they were all killed at once.

A process of loky that watches them removes them when a pool ends, but a kill of the whole group
ends this one, too. On Linux they lie in /dev/shm until the machine starts again.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

SHARED_MEMORY = Path("/dev/shm")
PROCESSES = Path("/proc")
# loky names a semaphore /loky-PROCESS-LETTERS, and the C library puts "sem." before it.
_NAME = re.compile(r"(?:sem\.)?loky-(\d+)-[a-z0-9_]{8}")
Inode = tuple[int, int]  # device and number of a file


def remove_leftovers(folder: Path = SHARED_MEMORY) -> list[Path]:
    """Remove the semaphores of loky that this user's dead processes left, and return them.

    Nothing else is touched: a semaphore whose process lives, or that any process of this user has
    open, stays. On systems without /dev/shm and /proc nothing is done.
    """
    if not PROCESSES.is_dir():
        return []
    # The processes are asked after the files are listed, so a process that begins meanwhile, with
    # the number of a dead one, has other files.
    semaphores = {path: inode for path, inode in _semaphores(folder) if not _lives(_process(path))}
    if not semaphores:
        return []
    in_use = _open_inodes()
    removed = []
    for path, inode in semaphores.items():
        if inode in in_use:
            continue
        with suppress(OSError):  # another command has removed it meanwhile
            path.unlink()
            removed.append(path)
    return removed


def _semaphores(folder: Path) -> Iterator[tuple[Path, Inode]]:
    """Yield the semaphores of loky that belong to this user, listed before the first is given."""
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            if not _NAME.fullmatch(path.name):
                continue
            with suppress(OSError):  # it has gone
                status = path.lstat()
                if stat.S_ISREG(status.st_mode) and status.st_uid == os.getuid():
                    yield path, (status.st_dev, status.st_ino)


def _process(path: Path) -> int:
    """Return the number of the process that made a semaphore."""
    match = _NAME.fullmatch(path.name)
    assert match is not None
    return int(match[1])


def _lives(process: int) -> bool:
    """Tell whether there is a process of a number, of whatever user."""
    return (PROCESSES / str(process)).exists()


def _open_inodes() -> set[Inode]:
    """Return the files that processes of this user have in their memory."""
    inodes = set()
    for process in PROCESSES.glob("[0-9]*"):
        with suppress(OSError, ValueError, IndexError):  # it has ended, or is of another user
            for line in (process / "maps").read_text(errors="replace").splitlines():
                device, number = line.split(maxsplit=5)[3:5]
                major, minor = (int(part, 16) for part in device.split(":"))
                inodes.add((os.makedev(major, minor), int(number)))
    return inodes
