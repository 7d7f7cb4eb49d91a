"""Refusals before anything is computed: long steps, a missing package, memory and disk."""

import math
import os
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from acoustics.numbers import byte_size
from rolling.check import cost, long_steps
from rolling.check.memory_and_disk import disk, memory
from rolling.check.run_size import RunSize, run_size
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.messages import SceneError, plain_number
from rolling.scene.scene import Scene
from rolling.scene.sweep import run_name
from rolling.terminal import addresses, system_errors

OUTPUTS = Path("outputs")  # where runs are written unless another folder is given
SHARE = 0.8  # of memory or free disk that a run may take; the rest belongs to others
# Address space that the rest of a run takes beyond the loaded solver: compiler, libraries of files
# and pictures, stacks of threads. A run with a page was seen to take 380 MB, and 464 MB where it
# compiled, from 524 to 594 MB on.
REST_OF_PROGRAM = 540e6
# Advice for the largest part of a memory that does not suffice; less of a record needs less disk.
ADVICE = {
    "program": "give fewer --workers",
    "surface": "choose a smaller surface, a larger surface.spacing_um, or fewer --workers",
    "window": "choose a larger surface.spacing_um, or fewer --workers",
    "record": (
        "shorten rolling.duration_s or rolling.distance_mm, lower rolling.speed_m_s, or give"
        " sweep fewer values"
    ),
}
GROUPS_OF_PROCESS = Path("/proc/self/cgroup")
GROUPS = Path("/sys/fs/cgroup")


def refuse(
    scene: Scene,
    workers: int = 0,
    folder: Path | None = None,
    unsolved: Sequence[Scene] | None = None,
) -> None:
    """Refuse a scene that cannot be run here, with or without a sweep.

    Parameters
    ----------
    workers : int
        Number of processes; 0 means one per core. Default 0.
    folder : Path or None
        Folder of the results; None if nothing is written. Default None.
    unsolved : sequence of Scene, optional
        Runs whose files the folder lacks. Default: all.

    Raises
    ------
    SceneError
        Steps are too long, memory or disk do not suffice, or a height file cannot be used.
    """
    sizes = {run_name(values): run_size(run) for values, run in scene.runs()}
    written = [*sizes.values()]
    if unsolved is not None:
        written = [run_size(run) for run in unsolved]
    long_steps.refuse_runs(scene, sizes)
    _refuse_interleaved(scene, sizes.values())
    needs = excess([*sizes.values()], workers or cost.cores(), None)
    if folder is not None:
        needs += lacking_disk(disk(written), folder, ADVICE["record"])
    if needs:
        raise SceneError([need.line for need in needs])


def _refuse_interleaved(scene: Scene, runs: Iterable[RunSize]) -> None:
    """Refuse steps that meet a height file at other nodes in each lap, on a plate with memory.

    A lap would roll over each place several times.
    """
    for run in runs:
        if run.kept_passes and run.solved_steps * run.step_nodes > run.n_along * (1 + 1e-9):
            place = scene.place("numerics.step_nodes")
            raise SceneError(
                [
                    f"{place}: numerics.step_nodes: got {plain_number(run.step_nodes)}, allowed"
                    f" with plate.plasticity: permanent: a divisor of the {run.n_along} nodes of"
                    " the height file"
                ]
            )


def fits(run: RunSize) -> bool:
    """Tell whether memory holds a run in one process, so that its heights may be made."""
    return not excess([run], 1, None)


def excess(runs: Sequence[RunSize], workers: int, folder: Path | None, of: str = "") -> list[Doubt]:
    """Return the doubts "memory" and "disk" where runs do not fit: need, limit and advice.

    Counts of nodes and steps decide, so that no surface is made and no height file is read. The
    words `of` name the runs.
    """
    needs = lacking_memory(memory(runs, workers), ADVICE, of)
    if folder is not None:
        needs += lacking_disk(disk(runs), folder, ADVICE["record"], of)
    return needs


def lacking_memory(parts: dict[str, float], advice: dict[str, str], of: str = "") -> list[Doubt]:
    """Return the doubt "memory" where its parts [bytes] do not fit, with advice for the largest."""
    limit = memory_limit()
    if sum(parts.values()) <= SHARE * limit:
        return []
    largest = max(parts, key=parts.__getitem__)
    text = f"needs {memory_text(parts)}, allowed: {_share(limit)} this machine allows"
    return [
        Doubt("memory", f"memory{of}: {text}", Severity.REFUSED, advice=advice.get(largest, ""))
    ]


def lacking_disk(size: float, folder: Path, shorter: str, of: str = "") -> list[Doubt]:
    """Return the doubt "disk" where files [bytes] do not fit where a folder is or will be.

    Parameters
    ----------
    size : float, bytes
        Size of the files that are to be written.
    folder : Path
        Their folder.
    shorter : str
        Advice that makes them smaller, for a run that has not begun.
    of : str
        Words that name the runs. Default: none.
    """
    if is_read_only(folder):
        text = f"{system_errors.READ_ONLY} where {folder} is"
        advice = system_errors.ANOTHER_DISK
        return [Doubt("disk", f"disk{of}: {text}", Severity.REFUSED, advice=advice)]
    free = free_disk(folder)
    if size <= SHARE * free:
        return []
    text = f"needs about {byte_size(size)}, allowed: {_share(free)} free where {folder} is"
    is_begun = folder != OUTPUTS and any(folder.glob("*"))
    if is_begun:  # another scene would not go on in this folder
        advice = "free some space, and the same command goes on"
    else:
        advice = f"free some space, {system_errors.ANOTHER_DISK}, or {shorter}"
    return [Doubt("disk", f"disk{of}: {text}", Severity.REFUSED, advice=advice)]


def refuse_large_files(scenes: Sequence[Scene]) -> None:
    """Refuse height files that memory does not hold; their headers tell it before they are read."""
    for scene in scenes:
        needs = excess([run_size(scene)], 1, None) if scene.height_paths else []
        if needs:
            section = next(iter(scene.height_paths))
            raise SceneError([f"{section}.path: {need.line}" for need in needs])


def memory_text(parts: dict[str, float]) -> str:
    """Write the sum of the parts of memory [bytes] with the largest of them."""
    largest = max(parts, key=parts.__getitem__)
    total = sum(parts.values())
    return f"about {byte_size(total)}, {byte_size(parts[largest])} for the {largest}"


def _share(limit: float) -> str:
    return f"{byte_size(SHARE * limit)}, {100 * SHARE:.0f} % of the {byte_size(limit)}"


# ---- this machine


def memory_limit() -> float:
    """Return the memory [bytes] of the machine, or less where a control group of Linux limits it.

    The limits of the groups above count as well.
    """
    try:
        limits = [float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))]
    except (AttributeError, OSError, ValueError):
        limits = [math.inf]
    try:
        lines = GROUPS_OF_PROCESS.read_text().splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []
    for controllers, path in (line.split(":", 2)[1:] for line in lines if line.count(":") > 1):
        top = GROUPS
        name = "memory.max"
        if controllers:
            top = GROUPS / "memory"
            name = "memory.limit_in_bytes"
        if controllers in ("", "memory"):
            # In a container the path may be the path on the host; the top is its own group then.
            group = top / path.strip("/")
            limits += [_number(place / name) for place in (group, *group.parents)]
    return min(limits)


def refuse_few_addresses(scenes: Sequence[Scene]) -> None:
    """Refuse runs for which the address space of a process is too small, where it is limited.

    Libraries that are loaded without room for them, and the compiler, may end the process or wait
    for ever, so that no error could be told later.

    Raises
    ------
    MemoryError
        The limit (`ulimit -v`) leaves less than the runs need.
    """
    limit = addresses.limit()
    taken = addresses.taken()
    if limit is None or taken is None:
        return
    parts = memory([run_size(scene) for scene in scenes], workers=1)
    del parts["program"]  # of which the largest part is loaded by now
    need = REST_OF_PROGRAM + sum(parts.values())
    if taken + need > limit:
        raise MemoryError(
            f"not enough memory: a process may have {byte_size(limit)} of addresses (`ulimit -v`),"
            f" has {byte_size(taken)} and needs about {byte_size(need)} more; allow more, or take"
            " a smaller scene"
        )


def free_disk(folder: Path) -> float:
    """Return the free bytes where a folder is or will be, infinite if unknown."""
    place = _existing(folder)
    try:
        return float(shutil.disk_usage(place).free)
    except OSError:
        return math.inf


def is_read_only(folder: Path) -> bool:
    """Tell whether a folder is or will be on a disk that is mounted read-only."""
    place = _existing(folder)
    try:
        return bool(os.statvfs(place).f_flag & os.ST_RDONLY)
    except (AttributeError, OSError):  # not of Windows
        return False


def _existing(folder: Path) -> Path:
    """Return the first of a folder and those above it that exists."""
    places = (place for place in (folder, *folder.absolute().parents) if place.exists())
    return next(places, Path())


def _number(file: Path) -> float:
    """Read the number in a file; return infinity for "max" or without a file."""
    try:
        return float(int(file.read_text()))
    except (OSError, ValueError):
        return math.inf
