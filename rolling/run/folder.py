"""Run folders: their scene, their runs, states that the files tell, and the lock of a command.

A folder holds scene.yaml, report.html, runs.csv and figures/. Each run has result.h5, summary.json,
signal.wav and listen.wav, a single run in the folder itself, a run of a sweep in a folder below.
"""

import os
import shutil
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from rolling.kinds.former_folder import refuse_former
from rolling.kinds.reading import read_scene
from rolling.kinds.run_folder import FAILED, RESULT, RunFolder
from rolling.scene import file
from rolling.scene.identity import contains, differences, scene_identity
from rolling.scene.sweep import run_name, with_paths
from rolling.scene.swept import AnyScene
from rolling.terminal import program, whole_files
from rolling.terminal.whole_files import FolderError, open_regular

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

SCENE = "scene.yaml"
PIECES = "pieces"
KEPT = "heard"  # runs that a command keeps for its end, in the folder of the pieces
FIRST_ANSWER = "first-answer.txt"  # in the folder of a run that has nothing else yet
MARK = f"{file.STORED_MARK}, format 2"  # the first line of scene.yaml begins so
LOCK = ".lock"
LOCK_SECONDS = 2.0  # of waiting for `status`, which locks a folder for a moment
MAX_NAMED = 20  # runs of a state that the status names
STATES = ("done", "running", "waiting", "failed")

Part = tuple[int, int]  # number from 1 on, and count of the parts of a sweep


def runs_in(folder: Path, scene: Any) -> list[RunFolder]:
    """Return the runs of a scene in a folder; a single run lies in the folder itself."""
    return [RunFolder(values, single, folder / run_name(values)) for values, single in scene.runs()]


def stored_runs(folder: Path) -> list[RunFolder]:
    """Return the runs of a run folder, or the run of a folder inside the folder of a sweep.

    Raises
    ------
    FolderError : the folder is no run folder of this version.
    SceneError : its scene cannot be read.
    """
    above = folder.absolute().parent
    if not (folder / SCENE).is_file() and _is_marked(above):
        for run in runs_in(above, stored_scene(above)):
            if run.folder.name == folder.name:
                return [RunFolder(run.values, run.scene, folder)]
    return runs_in(folder, stored_scene(folder))


def done_runs(folder: Path) -> list[RunFolder]:
    """Return the runs of a run folder; raise FolderError for a run that is not done."""
    runs = stored_runs(folder)
    for run in runs:
        _refuse_undone(run)
    return runs


def done_run(folder: Path, verb: str) -> RunFolder:
    """Return the only run of a run folder; raise FolderError where it is not done, or not alone.

    The verb tells what a person wants to do with the run, such as "open".
    """
    runs = stored_runs(folder)
    if len(runs) > 1:
        names = ", ".join(run.folder.name for run in runs[:3])
        raise FolderError(
            f"{folder}: holds {len(runs)} runs; {verb} one of the folders in it ({names}, ...)"
        )
    _refuse_undone(runs[0])
    return runs[0]


def _refuse_undone(run: RunFolder) -> None:
    """Refuse a run that is not done."""
    if not run.is_done:
        raise FolderError(f"{run.folder}: not done; the same `rolling run` goes on with it")


def stored_scene(folder: Path) -> Any:
    """Read the scene of a run folder.

    Raises
    ------
    FolderError : the folder is no run folder of this version.
    SceneError : its scene cannot be read.
    """
    if not _is_marked(folder):
        above = folder.absolute().parent
        if (folder / RESULT).is_file() and _is_marked(above):
            raise FolderError(f"{folder}: a single run of a sweep; name the folder of it, {above}")
        reason = _foreign_content(folder) or "no run folder, there is no scene.yaml"
        raise FolderError(f"{folder}: {reason}")
    return read_scene(folder / SCENE)


def _is_marked(folder: Path) -> bool:
    """Return whether this program wrote the scene of a folder."""
    try:
        with open_regular(folder / SCENE) as stream:
            return stream.read(len(MARK)) == MARK.encode()
    except OSError:
        return False


def _foreign_content(folder: Path) -> str:
    """Say why a folder that exists, or a link, cannot become a run folder; empty if it can."""
    if not folder.exists():
        if folder.is_symlink():
            return "a link that leads nowhere"
        return ""
    if not folder.is_dir():
        return "not a folder"
    # Locks and files half written may stand in a folder without a scene.
    strangers = [
        path.name
        for path in folder.iterdir()
        if not path.match(f"{LOCK}*") and not path.match(f".*{whole_files.PARTIAL}")
    ]
    if SCENE in strangers:
        return f"no run folder, its {SCENE} is not that of a run folder, or damaged"
    if strangers:
        return f"no run folder, it holds {', '.join(sorted(strangers)[:3])}"
    return ""


def refuse_other(folder: Path, scene: Any) -> bool:
    """Refuse a folder that holds something else than runs of a scene.

    Returns
    -------
    is_same : Whether the folder holds exactly this scene; false for a new folder, and for a sweep
        whose runs are a part of the scene's.

    Raises
    ------
    FolderError : the folder is foreign, or holds another scene.
    """
    if not _is_marked(folder):
        reason = _foreign_content(folder)
        if reason:
            raise FolderError(f"{folder}: {reason}; {_way_out(folder)}")
        return False
    old = read_scene(folder / SCENE)
    if type(old) is not type(scene):
        raise FolderError(f"{folder}: holds runs of another scene; {_way_out(folder)}")
    new = with_relative_paths(folder, scene)
    lines = differences(old, new)
    adds_runs = old.sweep and new.sweep and contains(old, new)
    if lines and not adds_runs:
        text = "".join(f"\n  {text}" for text in lines)
        raise FolderError(f"{folder}: holds runs of another scene; {_way_out(folder)}{text}")
    refuse_former(runs_in(folder, new))
    maker = made_by(folder)
    if maker != this_program() and not all(run.is_done for run in runs_in(folder, new)):
        raise FolderError(
            f"{folder}: holds runs or pieces of {maker}, and this is {this_program()}; numbers of"
            f" two programs are not mixed, so {_way_out(folder)}, or delete the folder"
        )
    return not lines


def _way_out(folder: Path) -> str:
    """Advise to take another folder, by a name that is free."""
    return f"take another --out, such as {free_name(folder)}"


def this_program() -> str:
    """Return version and sources of this program, as they stand in the scene of a run folder."""
    own = program.identity()
    return f"version {own.version}, sources {own.sources[: program.SHOWN]}"


def made_by(folder: Path) -> str:
    """Return version and sources of the program that began a run folder; this one for a new one."""
    if not _is_marked(folder):
        return this_program()
    with open_regular(folder / SCENE) as stream:
        line = stream.read(200).split(b"\n")[0]
    text = line.removeprefix(f"{MARK}, written by ".encode()).decode("utf-8", "replace")
    return "".join(filter(str.isprintable, text))


def free_name(folder: Path) -> Path:
    """Return the first name like that of a folder which does not exist."""
    if not folder.name:  # such as "."
        folder = folder.resolve()
    number = 2
    while True:
        free = folder.with_name(f"{folder.name}-{number}")
        if not free.exists():
            return free
        number += 1


def new_folder(folder: Path) -> Path:
    """Make a folder for a run that is saved from memory, and return it.

    Raises
    ------
    FolderError : there is a file of this name, or a folder that holds files.
    """
    if folder.exists() and not folder.is_dir():
        raise FolderError(f"{folder}: is a file; take another name for the folder")
    if folder.exists() and any(folder.iterdir()):
        raise FolderError(f"{folder}: holds files; take another, as {free_name(folder)}")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_scene(folder: Path, scene: Any) -> None:
    """Write the resolved scene of a run folder."""
    head = f"{MARK}, written by {this_program()}\n"
    text = head + file.dump(with_relative_paths(folder, scene))
    whole_files.write_bytes(folder / SCENE, text.encode())


def with_relative_paths(folder: Path, scene: AnyScene) -> AnyScene:
    """Return a scene whose paths to height files are relative to a run folder."""

    def relative(path: str) -> str:
        if Path(path).is_absolute():
            return path
        # Links are resolved first, because ".." of a linked folder leads elsewhere.
        heights = (scene.folder / path).parent.resolve() / Path(path).name
        return Path(os.path.relpath(heights, folder.resolve())).as_posix()

    before = scene.to_dict()
    data = with_paths(before, relative)
    if data == before:
        return scene
    return type(scene).from_dict(data, folder)


def default_folder(scene: Any) -> Path:
    """Return the folder of a scene that is given without --out."""
    return Path("outputs") / f"{scene.name}-{scene_identity(scene)[:8]}"


# ---- the lock


@contextmanager
def locked(folder: Path, part: Part | None = None) -> Iterator[None]:
    """Hold the lock of a folder, or of a part of its sweep, while a command hands out pieces.

    Parts exclude a command for the whole folder, and equal parts exclude each other.

    Raises
    ------
    FolderError : another command holds a lock, or the folder cannot be written.
    """
    from filelock import FileLock, Timeout

    path = folder / LOCK
    others = [*folder.glob(f"{LOCK}-*")]
    if part is not None:
        number, count = part
        path = folder / f"{LOCK}-{number}-of-{count}"
        others = [folder / LOCK]
    lock = FileLock(path)
    try:
        lock.acquire(timeout=LOCK_SECONDS)
    except Timeout as error:
        raise _in_use(folder, path) from error
    except OSError as error:
        raise FolderError(f"{folder}: cannot be written ({error.strerror or error})") from error
    try:
        for other in others:
            if is_locked(other):
                raise _in_use(folder, other)
        yield
    finally:
        with suppress(OSError):  # a waiting command notices that the file is gone
            path.unlink()
        lock.release()


def _in_use(folder: Path, lock: Path) -> FolderError:
    return FolderError(
        f"{folder}: in use, another command works on it; wait for it to end, or stop it. Where none"
        f" does, because the disk keeps the lock of a dead command, delete {lock}"
    )


def is_locked(path: Path) -> bool:
    """Return whether a process holds a lock file, without creating or keeping anything."""
    try:
        flags = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # or a pipe waits
        lock = os.open(path, os.O_RDONLY | flags)
    except OSError:
        return False
    try:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return False
    except OSError:  # held, or a disk without locks, where the file itself is the lock
        return True
    finally:
        os.close(lock)


# ---- files that a killed command left


def tidy(folder: Path, runs: Sequence[RunFolder], alone: bool) -> None:
    """Remove failures of earlier attempts and files half written in a folder and its runs.

    Unless the command is `alone`, another part may just write a file into the folder itself.

    Raises
    ------
    FolderError : the folder of a run or of the pieces is a link, which leads elsewhere.
    """
    pieces = folder / PIECES
    written = [pieces, *pieces.glob("*")]
    written += [run.folder for run in runs if run.values]
    for place in written:
        if place.is_symlink():
            raise FolderError(f"{place}: a link, but results are written into real folders only")
    places = {run.folder for run in runs}
    if alone:
        places.add(folder)
        shutil.rmtree(pieces / KEPT, ignore_errors=True)
    for place in places:
        with suppress(OSError):  # a place that is no folder
            (place / FAILED).unlink(missing_ok=True)
            for path in place.glob(".*.partial"):
                path.unlink(missing_ok=True)


def drop_pieces(folder: Path, contact: str) -> None:
    """Remove the pieces of a contact identity whose runs are done."""
    pieces = folder / PIECES
    shutil.rmtree(pieces / contact[:16], ignore_errors=True)
    with suppress(OSError):  # pieces of other marches are there
        pieces.rmdir()


def drop_all_pieces(folder: Path) -> None:
    """Remove all pieces of a folder whose runs are done; runs that are kept for the end stay."""
    for place in (folder / PIECES).glob("*"):
        if place.name != KEPT:
            shutil.rmtree(place, ignore_errors=True)
    with suppress(OSError):
        (folder / PIECES).rmdir()


# ---- status


def states(folder: Path) -> dict[str, tuple[str, str]]:
    """Return state and reason of each run of a folder by the name of its folder."""
    is_running = any(map(is_locked, folder.glob(f"{LOCK}*")))
    by_name = {}
    for run in stored_runs(folder):
        state = "waiting"
        reason = ""
        if run.is_done:
            state = "done"
        elif (failure := run.failure) is not None:
            state = "failed"
            reason = failure
        elif is_running:
            state = "running"
        by_name[run.folder.name] = state, reason
    return by_name


def status(folder: Path) -> str:
    """Return the progress of a run folder in words: counts of states, and runs that failed."""
    runs = states(folder)
    counts = Counter(state for state, _ in runs.values())
    named = ", ".join(f"{counts[state]} {state}" for state in STATES if counts[state])
    total = "1 run" if len(runs) == 1 else f"{len(runs)} runs"
    lines = [f"{folder}: {total}: {named}"]
    pieces = len(list((folder / PIECES).glob("*/*.npz")))
    if pieces:
        lines.append(f"  {pieces} pieces of unfinished runs are solved")
    first = sum((run.folder / FIRST_ANSWER).is_file() for run in stored_runs(folder))
    if first:
        lines.append(f"  {first} of them with a first answer, in {FIRST_ANSWER}")
    failed = []
    for name, (state, reason) in runs.items():
        if state == "failed":
            failed.append(f"  failed: {name}: {reason}")
    lines += failed[:MAX_NAMED]
    if len(failed) > MAX_NAMED:
        lines.append(f"  failed: {len(failed) - MAX_NAMED} more")
    return "\n".join(lines)


def is_at_rest(folder: Path) -> bool:
    """Return whether no run of a folder is waiting or running."""
    return all(state in ("done", "failed") for state, _ in states(folder).values())
