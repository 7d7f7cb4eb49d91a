"""Tasks in worker processes: a piece of a march, and the files of a complete run.

A Dask scheduler imports this module as well, so the solver is imported where a task needs it.
"""

from __future__ import annotations

import ctypes
import io
import os
import pickle
import signal
import sys
import threading
import time
import zipfile
import zlib
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rolling.terminal.files import write_bytes

if TYPE_CHECKING:
    from rolling.marches.piece import Piece
    from rolling.marches.result import Result
    from rolling.run.folder import RunFolder

Arrays = dict[str, NDArray[Any]]

_PR_SET_PDEATHSIG = 1  # of prctl(2)
_DAMAGED = (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error)
_alone = threading.Lock()  # kernels and transforms keep state, so threads of a worker take turns


@dataclass(frozen=True)
class Failure:
    """A task that failed, with the reason for the user."""

    reason: str


class OtherProgramError(Exception):
    """A worker of a cluster that runs another version of the program."""


def piece_path(pieces: Path, piece: Piece) -> Path:
    """Return the file of a piece in the folder of pieces."""
    return pieces / piece.identity[:16] / f"{piece.key}.npz"


def solve_piece(piece: Piece, pieces: Path | None) -> Arrays | Failure:
    """March a piece, or read its file; a folder of pieces receives the file of a new piece."""
    path = None if pieces is None else piece_path(pieces, piece)
    if path is not None and (arrays := read_piece(path)) is not None:
        return arrays
    from rolling.contact.solver import ContactError
    from rolling.marches.piece import march_piece
    from rolling.scene.messages import SceneError

    try:
        arrays = march_piece(piece)
    except (ContactError, SceneError, MemoryError) as error:
        return Failure(str(error) or "not enough memory")
    if path is not None:
        content = io.BytesIO()
        np.savez(content, allow_pickle=False, **arrays)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, content.getvalue())
    return arrays


def read_piece(path: Path) -> Arrays | None:
    """Read the file of a piece; return None for a missing or damaged file."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except _DAMAGED:
        return None


def finish_run(run: RunFolder, label: str, result: Result) -> Failure | None:
    """Make the sound of a complete run and write the files of its folder."""
    from rolling.contact.solver import ContactError
    from rolling.results.run_files import write_run
    from rolling.results.run_result import hear
    from rolling.scene.messages import SceneError

    try:
        heard = hear(label, run.values, run.folder, run.scene, result)
    except (ContactError, SceneError, MemoryError) as error:
        return Failure(str(error) or "not enough memory")
    write_run(heard)
    return None


def act(task: bytes, digest: str) -> Any:
    """Carry out a pickled task in a worker of a cluster that runs the same program.

    Raises
    ------
    OtherProgramError : the sources of this worker have another digest.
    """
    from rolling.terminal import program

    own = program.identity()
    if own.sources != digest:
        raise OtherProgramError(f"version {own.version}, sources {own.sources[:12]}")
    import dask

    function, arguments = pickle.loads(task)
    with _alone, dask.config.set(scheduler="synchronous"):  # or xarray asks the scheduler for locks
        return function(*arguments)


def begin(parent: int, compiles: Any) -> None:
    """Prepare a local worker process, which ends with its parent and reports compilation."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent alone acts on Ctrl-C
    if sys.platform.startswith("linux"):
        with suppress(OSError, AttributeError):  # without prctl the thread below remains
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    threading.Thread(target=_end_with, args=(parent,), name="lifeline", daemon=True).start()

    from rolling.contact import compiling

    compiling.tell_always(compiles.set)


def _end_with(parent: int) -> None:
    """End this process at once when its parent has ended."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)
