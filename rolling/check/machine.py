"""Memory and disk of this machine that a run may take.

Memory is the minimum of the built-in memory and the limits of the control groups of Linux. Quotas
of users on a disk are unknown here.
"""

from __future__ import annotations

import math
import os
import shutil
from pathlib import Path

# A run may take this share of memory or free disk; the rest belongs to the system and to others.
SHARE = 0.8
_GROUPS_OF_PROCESS = Path("/proc/self/cgroup")
_GROUPS = Path("/sys/fs/cgroup")


def memory() -> float:
    """Return the memory [bytes] that all processes of a run share, infinite if unknown."""
    return min(_built_in(), group_limit(_GROUPS_OF_PROCESS, _GROUPS))


def address_space() -> float:
    """Return the bytes that a process may address, infinite without a limit."""
    try:
        import resource
    except ImportError:  # not on Windows
        return math.inf
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if limit == resource.RLIM_INFINITY else float(limit)


def free_disk(folder: Path) -> float:
    """Return the free bytes where a folder is or will be, infinite if unknown."""
    there = next(
        (place for place in (folder, *folder.absolute().parents) if place.exists()), Path()
    )
    try:
        return float(shutil.disk_usage(there).free)
    except OSError:
        return math.inf


def _built_in() -> float:
    """Return the built-in memory [bytes]."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf


def group_limit(of_process: Path, groups: Path) -> float:
    """Return the minimum memory limit [bytes] of a process's control groups.

    Groups above them count too. The limit is infinite without any groups.

    Parameters
    ----------
    of_process : Path
        File of lines "number:controllers:path", as /proc/self/cgroup; version 2 has no controllers.
    groups : Path
        Folder under which the groups are mounted, as /sys/fs/cgroup.
    """
    try:
        lines = of_process.read_text().splitlines()
    except (OSError, UnicodeDecodeError):
        return math.inf
    limits = [math.inf]
    for line in lines:
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if not controllers:
            tops, file = [groups, groups / "unified"], "memory.max"
        elif "memory" in controllers.split(","):
            tops, file = [groups / "memory", groups / controllers], "memory.limit_in_bytes"
        else:
            continue
        parts = [part for part in path.split("/") if part not in ("", "..")]
        # In a container the path may be the path on the host; the top is then the group of the
        # container itself.
        limits += [
            _limit(top.joinpath(*parts[:depth], file))
            for top in tops
            for depth in range(len(parts), -1, -1)
        ]
    return min(limits)


def _limit(file: Path) -> float:
    """Read the number in a file; return infinity for "max" or without a file."""
    try:
        return float(int(file.read_text()))
    except (OSError, ValueError):
        return math.inf
