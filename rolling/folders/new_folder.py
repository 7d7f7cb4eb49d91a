"""New folders of this program, and folders that replace older folders.

All refusals come before anything is touched. A folder that replaces another is made under a
temporary name beside it. The older folder stays as OUT.previous until the work in the new folder is
done.
"""

from __future__ import annotations

import os
import re
import time
import uuid
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from rolling.folders import claim, own_files, run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError
from rolling.folders.replaceable import Target, contains, marked, named, refuse_losses
from rolling.folders.run_record import Kind, RunRecord

PREVIOUS = ".previous"
LATEST = "latest"  # link to the newest of the folders named after the time
MOMENT = 60.0  # [s]; a folder that lacks run.json for longer is no longer being made
Fill = Callable[[Path], object]  # function that writes the inputs of a run into its folder


def aim(
    base: Path, out: Path | None, force: bool, kinds: Sequence[Kind], inputs: Sequence[Path] = ()
) -> Target:
    """Check where a new folder may be made, without touching anything.

    Parameters
    ----------
    base : Path
        Parent of a folder that is named after the time, which is made where `out` is None.
    out : Path
        Folder to make.
    force : bool
        If true, a folder of these kinds at `out` may be replaced, if nothing foreign is in it.
    kinds : sequence of Kind
        Kinds of folders that the command makes.
    inputs : sequence of Path
        Files and folders that the command reads; none may be replaced.

    Raises
    ------
    FolderError
        `out` is taken, or replacing it would lose something.
    """
    if out is None:
        return Target(base, True, False, tuple(kinds), tuple(inputs))
    try:
        return _aim(out.resolve() if out.name in ("", "..") else out, force, kinds, inputs)
    except OSError as error:
        raise FolderError(
            f"{out}: cannot be used ({error.strerror or error}); take another --out"
        ) from error


def _aim(out: Path, force: bool, kinds: Sequence[Kind], inputs: Sequence[Path]) -> Target:
    target = Target(out, False, False, tuple(kinds), tuple(inputs))
    if out.is_symlink() and not out.exists():
        raise FolderError(f"{out}: a symbolic link to nothing; take another --out")
    if not out.exists():
        return target
    if not out.is_dir():
        raise FolderError(f"{out}: is a file, --out is a folder; take another --out")
    if contains(out, Path.cwd()):
        raise FolderError(
            f"{out}: is the working directory or holds it; give --out a folder of its own"
        )
    if is_empty(out):
        return target
    record = marked(out, kinds)
    if not force:
        claim.refuse_folder_in_use(out, record)
        way = ", or --force to replace it" if record.kind in own_files.FILES else ""
        raise FolderError(f"{out}: holds a {named([record.kind])} already; take another --out{way}")
    refuse_losses(target, previous(target.folder), record)
    return replace(target, replaces=True)


def is_unfinished(folder: Path, kind: Kind) -> bool:
    """Tell whether a folder holds work of a kind that was begun and is not done.

    Raises
    ------
    FolderError
        Its run.json cannot be used.
    """
    record = run_record.read(folder)
    return record is not None and record.kind == kind and record.state != "done"


def make(target: Target, record: RunRecord, fill: Fill = lambda folder: None) -> Claim:
    """Make the folder of a target and claim it for this process.

    It writes run.json first, then the inputs.

    Raises
    ------
    FolderError
        The folder cannot be made, or another process was faster.
    OSError
        An input cannot be written; nothing is left.
    """
    if target.stamped:
        return _fill(stamped(target.folder), record, fill, True)
    if target.replaces:
        return _replace(target, record, fill)
    return _make_in_place(target.folder, record, fill)


def make_shared(out: Path, record: RunRecord, fill: Fill) -> bool:
    """Make a folder that several commands make at once, and claim it for none of them.

    The folder appears with its inputs. Return whether this command made it.

    Raises
    ------
    FolderError
        The folder is there and is of another kind, or it cannot be made.
    """
    if not out.exists() or (out.is_dir() and is_empty(out)):
        temporary = _temporary(out)
        _mkdir(temporary)
        with _fill(temporary, record, fill, True):
            pass
        try:
            if out.is_dir():
                (out / claim.LOCK).unlink(missing_ok=True)
            temporary.rename(out)
            return True
        except OSError as error:  # another command was faster
            own_files.remove(temporary, record)
            if not out.is_dir():
                raise FolderError(f"{out}: cannot be made ({error.strerror or error})") from error
    if not out.is_dir():
        raise FolderError(f"{out}: is a file, --out is a folder; take another --out")
    marked(out, [record.kind])
    return False


def stamped(base: Path) -> Path:
    """Make a folder named after the time.

    Raises
    ------
    FolderError
        The folder cannot be made.
    """
    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S")
    for k in range(1, 1000):
        folder = base / (stamp if k == 1 else f"{stamp}-{k}")
        with suppress(FileExistsError):
            _mkdir(folder)
            return folder
    raise FolderError(f"{base}: no free folder name")


def link_latest(folder: Path) -> None:
    """Point the link `latest` beside a folder named after the time to that folder.

    Nothing is done where another file has this name, or where the file system has no links.
    """
    link = folder.with_name(LATEST)
    if link.exists() and not link.is_symlink():
        return
    temporary = _temporary(link)
    try:
        temporary.symlink_to(folder.name, target_is_directory=True)
        temporary.replace(link)
    except (OSError, NotImplementedError):  # Windows asks for a privilege
        with suppress(OSError):
            temporary.unlink()


def previous(folder: Path) -> Path:
    """Return the name of the folder that `folder` replaces."""
    return folder.with_name(f"{folder.name}{PREVIOUS}")


def drop_previous(held: Claim) -> Path | None:
    """Remove the older folder that a claimed folder replaces; return it if it must stay."""
    if held.record.replaces is None:
        return None
    old = previous(held.folder)
    with suppress(FolderError, OSError):
        record = run_record.read(old)
        if record is not None and record.id == held.record.replaces:
            with claim.guard(old):
                claim.refuse_folder_in_use(old, record)
                if contains(old, Path.cwd()) or own_files.foreign(old, record):
                    return old
                discarded = _temporary(held.folder)
                old.rename(discarded)  # so that no process meets it half removed
            own_files.remove(discarded, record)
    held.forget_replaced()
    return None


def is_empty(folder: Path) -> bool:
    """Tell whether a folder is empty.

    Traces of a command that was killed before its first file do not count.
    """
    trace = re.compile(
        rf"{re.escape(claim.LOCK)}|\.{re.escape(run_record.FILE)}(\.[0-9a-f]{{16}})?\.partial"
    )
    return all(
        trace.fullmatch(entry.name) and entry.is_file() and not entry.is_symlink()
        for entry in folder.iterdir()
    )


# ---- making


def _mkdir(folder: Path, exist_ok: bool = False) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=exist_ok)
    except FileExistsError:
        raise
    except OSError as error:
        raise FolderError(f"{folder}: cannot be made ({error.strerror or error})") from error


def _make_in_place(folder: Path, record: RunRecord, fill: Fill) -> Claim:
    record = replace(record, replaces=_interrupted_swap(folder))
    new = not folder.exists()
    _mkdir(folder, exist_ok=True)
    with claim.guard(folder):
        if not is_empty(folder):  # another command was faster
            other = run_record.read(folder)
            if other is not None:
                claim.refuse_folder_in_use(folder, other)
            raise FolderError(f"{folder}: holds something since a moment ago; take another --out")
        held = claim.begin(folder, record)
    return _fill(folder, record, fill, new, held)


def _fill(
    folder: Path, record: RunRecord, fill: Fill, new: bool, held: Claim | None = None
) -> Claim:
    """Write run.json and inputs into a new folder; leave nothing when that fails."""
    try:
        held = held or claim.begin(folder, record)
        fill(folder)
        return held
    except BaseException as error:
        if held is not None:
            held.__exit__(type(error), error, None)
        if own_files.remove(folder, record) and not new:
            with suppress(OSError):
                folder.mkdir()
        raise


def _replace(target: Target, record: RunRecord, fill: Fill) -> Claim:
    """Make the folder under a temporary name, then exchange it for the older folder."""
    out = target.folder
    temporary = _temporary(out)
    _mkdir(temporary)
    new = _fill(temporary, record, fill, True)
    try:
        with _both_guarded(out):
            _exchange(target, new)
    except BaseException as error:
        new.__exit__(type(error), error, None)
        own_files.remove(temporary, new.record)
        raise
    for left, its_record in _left_over(out):
        own_files.remove(left, its_record)
    return new


@contextmanager
def _both_guarded(out: Path) -> Iterator[None]:
    """Keep other processes from beginning work in a folder and in its predecessor."""
    with claim.guard(out), claim.guard(previous(out)) if previous(out).is_dir() else nullcontext():
        yield


def _exchange(target: Target, new: Claim) -> None:
    """Give the new folder the name OUT, and the older folder the name OUT.previous.

    An OUT.previous that was done stays if OUT was never done, so the last finished run is always
    kept. The folder that is not kept is renamed too, and `_left_over` finds it.
    """
    out, old = target.folder, previous(target.folder)
    there = marked(out, target.kinds)
    # Again, because other commands may have changed the folder.
    refuse_losses(target, old, there)
    before = marked(old, target.kinds) if os.path.lexists(old) else None
    kept = before if before is not None and before.completed and not there.completed else there
    new.record = replace(new.record, replaces=kept.id)
    run_record.write(new.folder, new.record)
    if kept is before:
        moves = [(out, _temporary(out))]
    elif before is not None:
        moves = [(old, _temporary(out)), (out, old)]
    else:
        moves = [(out, old)]
    _rename([*moves, (new.folder, out)])
    new.folder = out


def _rename(moves: Sequence[tuple[Path, Path]]) -> None:
    """Rename all folders in order, or none of them."""
    done: list[tuple[Path, Path]] = []
    try:
        for source, name in moves:
            source.rename(name)
            done.append((source, name))
    except BaseException as error:
        for source, name in reversed(done):
            with suppress(OSError):
                name.rename(source)
        if isinstance(error, OSError):
            out = moves[-1][1]
            raise FolderError(
                f"{out}: could not be replaced, and is as it was ({error.strerror or error})"
            ) from error
        raise


def _temporary(out: Path) -> Path:
    return out.with_name(f".{out.name}.{uuid.uuid4().hex}.partial")


def _left_over(out: Path) -> Iterator[tuple[Path, RunRecord]]:
    """Yield the folders under temporary names that killed commands left beside `out`."""
    name = re.compile(rf"\.{re.escape(out.name)}\.[0-9a-f]{{32}}\.partial")
    with suppress(OSError):
        for path in sorted(out.parent.iterdir()):
            if name.fullmatch(path.name) and path.is_dir() and not path.is_symlink():
                with suppress(FolderError):
                    record = run_record.read(path)
                    if record is not None:
                        claim.refuse_folder_in_use(path, record)
                        yield path, record
                    elif time.time() - path.stat().st_mtime > MOMENT:
                        # A command was killed at the start of making it or at the end of removing
                        # it.
                        yield path, run_record.new("run")


def _interrupted_swap(out: Path) -> str | None:
    """Return the id of OUT.previous where a command was killed between its two renamings."""
    with suppress(FolderError):
        old = run_record.read(previous(out))
        for left, record in _left_over(out):
            if old is not None and record.replaces == old.id and not out.exists():
                own_files.remove(left, record)
                return old.id
    return None
