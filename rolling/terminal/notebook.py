"""Errors in a notebook: the line of the cell and the message, without the frames of the program.

IPython asks an error for its text by the method `_render_traceback_`, which classes of errors for
people take from here. Scripts and tests see whole tracebacks as ever.
"""

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Folders whose frames a person did not write: this program, acoustics and IPython.
_ROOT = Path(__file__).parents[2]
_OWN = (_ROOT / "rolling", _ROOT / "acoustics")


def short_traceback(error: BaseException) -> list[str]:
    """Return the lines of a person's own code that led to an error, and its message."""
    lines = []
    for frame in traceback.extract_tb(error.__traceback__):
        if frame.line and not _is_foreign(Path(frame.filename)):
            lines.append(f"line {frame.lineno}: {frame.line}")
    message = str(error)
    name = type(error).__name__
    return [*lines, f"{name}: {message}" if message else name]


class Interrupted(KeyboardInterrupt):
    """An interrupt with a message that a notebook shows without the frames of the program."""

    _render_traceback_ = short_traceback


@contextmanager
def interrupt_with_message() -> Iterator[None]:
    """Say after Ctrl-C that nothing of a simulation in memory is kept."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted("the simulation was interrupted, and nothing of it is kept") from None


def _is_foreign(path: Path) -> bool:
    """Return whether a file belongs to this program, to IPython, or to the library of Python."""
    folders = [*_OWN, Path(traceback.__file__).parent]
    shell = getattr(sys.modules.get("IPython"), "__file__", None)
    if shell is not None:
        folders.append(Path(shell).parent)
    return any(folder in path.parents for folder in folders)
