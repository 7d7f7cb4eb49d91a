"""Tasks in worker processes: a piece of a march, and the files of a complete run.

A Dask scheduler imports this module as well, so the solver is imported where a task needs it.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow
from rolling.archive.definition import Arrays
from rolling.terminal import progress
from rolling.terminal.program import Program, identity
from rolling.terminal.whole_files import make_below, read_regular, write_bytes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rolling.kinds.run_folder import RunFolder
    from rolling.marches.piece import Piece

MAX_BREAKS = 3  # of processes by a task, before its runs have failed
KILLED = f"a worker process was killed {MAX_BREAKS} times while it had this run; out of memory?"
_MAX_PIECE = 2**30  # bytes of the file of a piece
_one_task = threading.Lock()  # a worker of a cluster may have threads, and surfaces are large
# A process imports nothing from the working directory, and runs its libraries on one thread. Large
# surfaces are no leak of memory.
ENVIRONMENT = {
    "PYTHONSAFEPATH": "1",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "LOKY_MAX_MEMORY_LEAK_SIZE": "1e15",
}
COMPILED_AHEAD = "compile_step", "compile_parts"  # functions of `compiling_ahead`


class OtherProgramError(Exception):
    """A worker of a cluster that runs another version of the program."""


def piece_path(pieces: Path, piece: Piece) -> Path:
    """Return the file of a piece in the folder of pieces."""
    return pieces / piece.identity[:16] / f"{piece.key}.npz"


@ignoring_underflow
def solve_piece(piece: Piece, pieces: Path | None) -> Arrays:
    """March a piece, or read its file; a folder of pieces receives the file of a new piece."""
    from rolling.marches.march_piece import march_piece
    from rolling.marches.piece_archive import archive_of

    if pieces is None:
        return march_piece(piece)
    stored = read_piece(pieces, piece)
    if stored is not None:
        return stored
    arrays = march_piece(piece)
    path = piece_path(pieces, piece)
    make_below(pieces.parent, path.parent)
    write_bytes(path, archive_of(piece, arrays))
    return arrays


def store_piece(piece: Piece, pieces: Path) -> None:
    """March a piece into its file, and return nothing that could fill a pipe.

    A worker that is killed while it sends more than the pipe takes at once leaves a reader that
    waits for ever, because the reader's own process keeps the other end open as well.
    """
    solve_piece(piece, pieces)


def read_piece(pieces: Path, piece: Piece) -> Arrays | None:
    """Read the file of a piece; return None for a missing, damaged or strange file."""
    from rolling.marches.piece_archive import arrays_of

    try:
        return arrays_of(piece, read_regular(piece_path(pieces, piece), _MAX_PIECE))
    except MemoryError:  # which says nothing about the file
        raise
    except Exception:  # of any kind on files that are cut off, damaged or strange
        return None


@ignoring_underflow
def finish_run(run: RunFolder, label: str, marched: Sequence[Any]) -> None:
    """Make the run that its marches give, and write the files of its folder."""
    from rolling.kinds.registry import kind_of

    kind = kind_of(run.scene)
    kind.write_run(kind.make_run(run, label, marched))


@ignoring_underflow
def finish_and_keep_run(run: RunFolder, label: str, marched: Sequence[Any]) -> str:
    """Finish a run as `finish_run` does, and keep it for the end of the command.

    Return the digest of its file, empty where it is not kept.
    """
    from rolling.kinds.registry import kind_of
    from rolling.run.kept_runs import keep

    kind = kind_of(run.scene)
    made = kind.make_run(run, label, marched)
    kind.write_run(made)
    return keep(made)


def run_task(task: bytes, program: Program) -> Any:
    """Do a packed task in this thread of a Dask worker, one task at a time in each process.

    The task is not unpickled before the programs are compared, since another program may lack its
    function.

    Raises
    ------
    OtherProgramError : this worker runs another program, or has other packages.
    """
    if identity() != program:
        raise OtherProgramError(str(identity()))
    from rolling.kinds.registry import unpacked

    function, arguments = unpacked(task)
    with _one_task, progress.shown(False):
        return function(*arguments)


def compiler(part: str) -> subprocess.Popen[bytes]:
    """Start a process that compiles a part of the solver into the cache, and says nothing."""
    package = str(Path(__file__).parents[2])
    call = f"compile_ahead({os.getpid()}, {part!r})"
    code = (
        f"import sys; sys.path.append({package!r}); from rolling.run import worker; worker.{call}"
    )
    return subprocess.Popen(
        [sys.executable, "-P", "-c", code],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | ENVIRONMENT,
    )


def compile_ahead(parent: int, part: str) -> None:
    """Compile a part of the solver, a function of `compiling_ahead`; end with the parent."""
    begin(parent)
    from rolling.contact import compiling_ahead

    getattr(compiling_ahead, part)()


def begin(parent: int, compiles: Any = None, kinds: bytes = b"") -> None:
    """Prepare a worker process, which ends with its parent and reports compilation.

    `kinds` has the kinds of scenes that were added in the parent.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent alone acts on Ctrl-C
    progress.silence()
    threading.Thread(target=_end_with, args=(parent,), name="lifeline", daemon=True).start()
    if compiles is not None:
        from rolling.contact import compiling

        compiling.tell_always(compiles.set)
    if kinds:
        from rolling.kinds.registry import unpacked

        unpacked(kinds)


def _end_with(parent: int) -> None:
    """End this process at once when its parent has ended."""
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)
