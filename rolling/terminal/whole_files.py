"""Safe reading and writing of whole files, and the error of a folder."""

import errno
import io
import json
import os
import secrets
import stat
import tempfile
from pathlib import Path
from typing import Any

from rolling.terminal import streams
from rolling.terminal.notebook import short_traceback

PARTIAL = ".partial"  # end of the names of files that are being written
# By the letter that `ls -l` shows.
_KINDS = {"d": "a folder", "p": "a pipe", "c": "a device", "b": "a device"}


class FolderError(Exception):
    """Error of a folder or a file in it, with the way out.

    Examples
    --------
    >>> import rolling
    >>> rolling.open_run("nothing")
    Traceback (most recent call last):
    rolling.terminal.whole_files.FolderError: nothing: no run folder, there is no scene.yaml
    """

    _render_traceback_ = short_traceback

    def __init__(self, message: str) -> None:
        super().__init__(streams.harmless(message))  # it may have text of a stranger's file


def kind_of(mode: int) -> str:
    """Name the kind of something that is no regular file, by its mode."""
    return _KINDS.get(stat.filemode(mode)[0], "no regular file")


def open_regular(path: Path) -> io.FileIO:
    """Open a regular file for reading; raise OSError for any other, and never wait for a pipe."""
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(path, flags)
    except ValueError as error:  # a zero byte in the name
        raise OSError(0, str(error)) from error
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISREG(mode):
        return io.FileIO(descriptor, "rb")
    os.close(descriptor)
    raise OSError(0, f"is {kind_of(mode)}")


def read_regular(path: Path, most: int) -> bytes:
    """Read a regular file of at most `most` bytes; raise OSError for any other."""
    with io.BufferedReader(open_regular(path)) as file:
        # A read makes room for all that it may return.
        content = file.read(min(os.fstat(file.fileno()).st_size, most) + 1)
    if len(content) > most:
        raise OSError(0, f"is larger than {most:,} bytes")
    return content


def refuse_link_below(root: Path, folder: Path) -> None:
    """Refuse a folder below a root folder to which a link leads; the root itself may be a link.

    Raises
    ------
    FolderError : a link stands on the way, through which files would reach another place.
    """
    if folder.resolve() != root.resolve() / folder.relative_to(root):
        raise FolderError(f"{folder}: a link, but results are written into real folders only")


def make_below(root: Path, folder: Path) -> None:
    """Make a folder below a root folder, as `refuse_link_below` allows it."""
    refuse_link_below(root, folder)
    if not folder.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        _sync(folder.parent)


def write_bytes(path: Path, content: bytes | memoryview) -> None:
    """Write a file under a random name beside it, then rename it.

    The file is therefore either whole or absent, after a power cut too, and nobody can prepare a
    link of that name through which the content would reach another file.

    Raises
    ------
    OSError : the file cannot be written; the error names it, and an earlier file is kept.
    """
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}{PARTIAL}")
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(partial, flags, 0o666)
        try:
            try:
                rest = memoryview(content)
                while rest:
                    rest = rest[os.write(descriptor, rest) :]
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
            partial.replace(path)
        except BaseException:  # includes Ctrl-C
            partial.unlink(missing_ok=True)
            raise
        _sync(path.parent)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def _sync(folder: Path) -> None:
    """Let the names in a folder outlast a power cut, where the system can."""
    if os.name == "nt":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # of a file system that cannot
            raise
    finally:
        os.close(descriptor)


def write_temporary(prefix: str, suffix: str, content: bytes) -> Path:
    """Write a temporary file, which stays until the system removes it, and return its path."""
    with tempfile.NamedTemporaryFile(prefix=prefix, suffix=suffix, delete=False) as file:
        file.write(content)
    return Path(file.name)


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file, whole or not at all."""
    write_bytes(path, (json.dumps(content, indent=2, allow_nan=False) + "\n").encode())
