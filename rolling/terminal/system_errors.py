"""Errors of the system as sentences: what is wrong with a path, and what to do."""

import errno
from pathlib import Path

READ_ONLY = "the disk is read-only"
ANOTHER_DISK = "take a folder on another disk"
_NOT_PERMITTED = "not permitted; change the permissions, or take another folder"
# Errors of a path; another path, or a mended one, is the way out.
_OF_A_PATH = {
    errno.ENOENT: "no such file or folder; a folder on the way is missing, or a link dangles",
    errno.EACCES: _NOT_PERMITTED,
    errno.EPERM: _NOT_PERMITTED,
    errno.EROFS: f"{READ_ONLY}; {ANOTHER_DISK}",
    errno.ELOOP: "links lead in a circle; remove one of them, or take another path",
    errno.ENAMETOOLONG: "the path is too long for the disk; take shorter names",
    errno.ENOTDIR: "a part of the path is a file, not a folder; take another path",
    errno.EISDIR: "a folder, but a file is needed; take another path",
    errno.EEXIST: "a file or a dangling link stands in the place of a folder; remove it, or take"
    " another path",
}
# Errors of the disk or the machine.
_OF_THE_MACHINE = {
    errno.ENOSPC: "no space is left on the disk; free some, or take another folder",
    errno.EDQUOT: "your share of the disk is used up; free some, or take another folder",
    errno.EMFILE: "too many files are open; raise the limit (ulimit -n)",
    errno.ENFILE: "too many files are open on this machine; end other programs",
    errno.EIO: "the disk failed to read or write; check it",
}


def is_of_a_place(error: OSError) -> bool:
    """Return whether an error tells of a path that cannot be used."""
    return error.errno in _OF_A_PATH


def sentence(error: OSError) -> str:
    """Write an error of the system with its path, the reason, and the way out."""
    number = error.errno
    reason = error.strerror
    if number is None or not reason:
        return str(error)
    path = error.filename
    if path is None:
        path = error.filename2
    if path is None and number == errno.ENOENT and _working_folder_is_gone():
        return f"the working folder was deleted ({reason}); change to a folder that exists"
    place = "the system"
    if path is not None:
        place = _path_text(path)
    words = _OF_A_PATH.get(number) or _OF_THE_MACHINE.get(number)
    if words is None:
        return f"{place}: {reason}"
    return f"{place}: {words} ({reason})"


def _working_folder_is_gone() -> bool:
    """Tell whether somebody deleted the folder in which the command works."""
    try:
        Path.cwd()
    except FileNotFoundError:
        return True
    return False


def _path_text(path: object) -> str:
    """Write the path of an error, which may be bytes."""
    if isinstance(path, bytes):
        return path.decode("utf-8", "backslashreplace")
    return str(path)
