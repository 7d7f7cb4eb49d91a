"""Runs that a command has heard, kept as files until its end needs them again.

The end of a command compares its runs: their gain, their figures, their page. It reads the runs
that the processes have made, with their long records, so that no sound is made twice. The file of a
run is read by the command that had it made only, and its digest, which came from that process, must
hold: a pickle of somebody else is never opened. Where a file is missing, the run is made again from
its result.
"""

from __future__ import annotations

import hashlib
import pickle
import shutil
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RunFolder
from rolling.results.stored_numbers import read_stored
from rolling.run import folder as folders
from rolling.terminal.whole_files import FolderError, make_below, read_regular, write_bytes

MAX_BYTES = 100_000_000  # of a run that is kept
MIN_FREE = 20  # times the size of a kept run that the disk must have left


def keep(run: Any) -> str:
    """Write a run for the end of the command; return its digest, empty where it is not kept.

    A run that is large, or too large for what the disk has left, is not worth its place. One whose
    classes this process got from another process cannot be named in a pickle.
    """
    try:
        content = pickle.dumps((run, run.made))
    except pickle.PicklingError:
        return ""
    digest = hashlib.sha256(content).hexdigest()
    pieces = run.home / folders.PIECES
    with suppress(OSError, FolderError):
        if len(content) > MAX_BYTES or shutil.disk_usage(run.home).free < MIN_FREE * len(content):
            return ""
        make_below(run.home, pieces / folders.KEPT)
        write_bytes(pieces / folders.KEPT / digest, content)
        return digest
    return ""


@dataclass
class KeptRuns:
    """Runs that processes of this command have heard.

    folder : Path. The run folder.
    digests : dict. Digest of the file of each kept run, by the folder of the run in the run folder,
        whose own path may be spelled in several ways: the workers of a cluster have the whole one.
    """

    folder: Path
    digests: dict[Path, str] = field(default_factory=dict)

    def add(self, run: RunFolder, digest: str) -> None:
        """Remember the digest of the file of a run."""
        self.digests[_place(run)] = digest

    def only(self, run: RunFolder) -> KeptRuns:
        """Return a run alone, for a process that needs no other."""
        place = _place(run)
        return KeptRuns(self.folder, {place: self.digests.get(place, "")})

    def exchange(self, run: RunFolder, digest: str) -> None:
        """Take another file for a run, and remove the former one."""
        former = self.digests.get(_place(run), "")
        self.add(run, digest)
        if former and former not in self.digests.values():
            with suppress(OSError):
                (self.folder / folders.PIECES / folders.KEPT / former).unlink(missing_ok=True)

    def read(self, run: RunFolder, label: str) -> Any:
        """Return a run that is done, with its stored numbers, under a label.

        Raises
        ------
        FolderError, SceneError : as `read_run`.
        """
        digest = self.digests.get(_place(run))
        if digest:
            with suppress(OSError):
                path = self.folder / folders.PIECES / folders.KEPT / digest
                content = read_regular(path, MAX_BYTES)
                if hashlib.sha256(content).hexdigest() == digest:
                    kept, made = pickle.loads(content)
                    stored = read_stored(run.folder)
                    again = replace(kept, label=label, numbers=stored.numbers, stored=stored)
                    vars(again).update(made)
                    return again
        return kind_of(run.scene).read_run(run, label)

    def remove_others(self) -> None:
        """Remove the runs that killed parts of a sweep kept, where no other command is at work."""
        for path in (self.folder / folders.PIECES / folders.KEPT).glob("*"):
            if path.name not in self.digests.values():
                with suppress(OSError):
                    path.unlink(missing_ok=True)

    def remove(self) -> None:
        """Remove the files of the runs."""
        for digest in self.digests.values():
            with suppress(OSError):
                (self.folder / folders.PIECES / folders.KEPT / digest).unlink(missing_ok=True)
        for place in (self.folder / folders.PIECES / folders.KEPT, self.folder / folders.PIECES):
            with suppress(OSError):  # pieces of other marches are there
                place.rmdir()
        self.digests.clear()


def _place(run: RunFolder) -> Path:
    """Return the folder of a run in its run folder."""
    return run.folder.relative_to(run.home)
