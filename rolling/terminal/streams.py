"""Standard streams that may be closed, ASCII, full, or a pipe whose reader went away.

None of this may cost a run its work: a command that cannot be heard still finishes.
"""

import errno
import io
import os
import re
import shutil
import sys
import textwrap
import unicodedata
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO, cast

_NO_BREAK = "\N{NO-BREAK SPACE}"
# The space between a number and its unit, and that after a sign of uncertainty or of size.
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=[mµkun]?[mNsW]\b|m/s|dB|k?Hz|[GM]Pa|%)|(?<=[±>]) ")
FILE_WIDTH = 80  # letters of a line in a file or a pipe
_JOINERS = "\u200c\u200d"  # of Persian words and of emoji
# Errors of writing to a pipe or terminal that nobody reads any more.
_WITHOUT_A_READER = (errno.EPIPE, errno.EBADF, errno.EIO)


class LastingStream:
    """A text stream whose writing never raises; the first error is kept and the rest is dropped.

    Texts may come from strangers' files, so letters that steer a terminal are written as escapes.

    Attributes
    ----------
    error : OSError or None. The first error of writing, unless the reader just went away.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._lost = False
        self.error: OSError | None = None

    def write(self, text: str) -> int:
        """Write a text, or drop it when the stream is lost."""
        if not self._lost:
            try:
                self._stream.write(harmless(text))
            except (OSError, ValueError) as error:
                self._lose(error)
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        """Write several texts."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Write the buffered text, or drop it when the stream is lost."""
        if not self._lost:
            try:
                self._stream.flush()
            except (OSError, ValueError) as error:
                self._lose(error)

    def isatty(self) -> bool:
        """Return whether somebody looks at the stream."""
        return not self._lost and not self._stream.closed and self._stream.isatty()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _lose(self, error: OSError | ValueError) -> None:
        """Give the stream up after an error of writing."""
        if isinstance(error, ValueError) and not self._stream.closed:
            raise error  # a mistake of the program, not of the stream
        self._lost = True
        if isinstance(error, OSError) and error.errno not in _WITHOUT_A_READER:
            self.error = error
        # The buffered text would be written once more, and fail, when Python ends.
        with suppress(OSError, ValueError):
            null = _null()
            os.dup2(null, self._stream.fileno())
            os.close(null)


@contextmanager
def lasting() -> Iterator[tuple[LastingStream, LastingStream]]:
    """Put lasting streams in the place of stdout and stderr.

    Closed ones are opened to nowhere, so that no file of a run gets their number. Signs that the
    encoding lacks are written as escapes.
    """
    _open_closed()
    before = sys.stdout, sys.stderr
    for stream in before:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    output = LastingStream(before[0])
    errors = LastingStream(before[1])
    sys.stdout = cast(TextIO, output)
    sys.stderr = cast(TextIO, errors)
    try:
        yield output, errors
    finally:
        output.flush()
        errors.flush()
        sys.stdout, sys.stderr = before


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Print warnings for a user in this context as a line, without a place in the source."""
    with warnings.catch_warnings():
        show = warnings.showwarning

        def show_plain(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if issubclass(category, UserWarning):
                print(f"warning: {message}", file=file or sys.stderr)
            else:
                show(message, category, filename, lineno, file, line)

        warnings.showwarning = show_plain
        yield


def harmless(text: str) -> str:
    r"""Escape all letters that steer a terminal, such as those that move its cursor.

    Lines and tabs stay. So does the return with which a progress bar begins: it moves to the
    beginning of a line alone.

    >>> harmless("\rdone\n\x1b]0;title\x07")
    '\rdone\n\\x1b]0;title\\x07'
    """
    first = ""
    rest = text
    if text.startswith("\r"):
        first = "\r"
        rest = text[1:]
    if rest.isprintable():
        return text
    return first + "".join(map(_without_control, rest))


def _without_control(letter: str) -> str:
    """Return a letter, or its escape if it steers a terminal."""
    if _is_shown(letter):
        return letter
    return _escaped(letter)


def _is_shown(letter: str) -> bool:
    """Tell whether a letter steers no terminal: spaces of any width and joiners do not."""
    if letter.isprintable() or letter in "\n\t" or letter in _JOINERS:
        return True
    return unicodedata.category(letter) == "Zs"


def _escaped(letter: str) -> str:
    """Write a letter as Python writes it in a text, or the byte of a file name behind it."""
    if 0xDC80 <= ord(letter) <= 0xDCFF:
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return letter.encode("unicode_escape").decode("ascii")


def wrapped(text: str, indent: str = "  ") -> str:
    """Break a text into lines of the terminal's width; a file or pipe gets it on one line."""
    return folded(text, indent) if sys.stdout.isatty() else text


def folded(text: str, indent: str = "  ") -> str:
    """Break a text into lines of the terminal's width, or of 80 letters where there is none.

    Paths and other long words stay whole, and a number stays with its unit.
    """
    filled = textwrap.fill(
        unbroken(text),
        line_width(),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace(_NO_BREAK, " ")


def unbroken(text: str) -> str:
    """Join numbers with their units by spaces at which no line breaks."""
    return _BEFORE_UNIT.sub(_NO_BREAK, text)


def line_width() -> int:
    """Return the letters of a line: those of the terminal, or 80 where there is none."""
    if not sys.stdout.isatty():
        return FILE_WIDTH
    return max(40, shutil.get_terminal_size().columns)


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Write rows of equal length in aligned columns, two spaces apart, for a terminal."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def _open_closed() -> None:
    """Open closed standard streams to nowhere, for this process and those it starts."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            null = _null()  # the lowest free number, which is this one
            os.set_inheritable(null, True)
    # Python has None in the place of a stream that was closed when it started.
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115


def _null() -> int:
    """Open the null device."""
    return os.open(os.devnull, os.O_RDWR)
