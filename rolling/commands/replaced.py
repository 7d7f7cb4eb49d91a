"""Files that a command may replace: its own, of the same source, by what the files say.

A table names its source in a column, a picture and a page in their heads, and JSON under a key. A
file that says nothing, or another source, is a person's.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path

from PIL import PngImagePlugin

from rolling.terminal.whole_files import FolderError, read_regular

SOURCE = "Source"  # text of a picture, and in small letters the column of a table
_PAGE_SOURCE = re.compile(
    rb'<meta name="generator" content="rolling-contact-noise [^"]*">\s*'
    rb'<meta name="source" content="([^"]*)">'
)
MAX_BYTES = 50_000_000  # of an earlier file, of which the command writes far less


def source_name(source: Path, folder: Path) -> str:
    """Name a source as seen from the folder of its files; a scene of the program by its name."""
    if not source.exists():
        return source.as_posix()
    return Path(os.path.relpath(source.resolve(), folder.resolve())).as_posix()


def refuse_others(path: Path, content: bytes) -> None:
    """Raise FolderError where a file exists that a content of the same name may not replace."""
    if not path.exists():
        return
    try:
        is_own = _origin(path.suffix, read_regular(path, MAX_BYTES)) == _origin(
            path.suffix, content
        )
    except OSError:
        is_own = False
    if not is_own:
        raise FolderError(f"{path}: exists; take another folder, or remove it")


def _origin(ending: str, content: bytes) -> object:
    """Return what a table or a picture says of its origin; bytes that say nothing are their own."""
    if ending == ".csv":
        return _origin_of_table(content) or content
    if ending == ".json":
        return _origin_of_json(content) or content
    if ending in (".html", ".htm"):
        match = _PAGE_SOURCE.search(content)
        return content if match is None else match.group(1)
    return _origin_of_picture(content) or content


def _origin_of_table(content: bytes) -> tuple[list[str], set[str]] | None:
    """Return the head of a table and the sources of its rows; None without a source.

    A table may have other rows when it is made again, such as those of runs done meanwhile.
    """
    try:
        head, *rows = csv.reader(io.StringIO(content.decode()))
        column = head.index(SOURCE.lower())
        return head, {row[column] for row in rows}
    except (ValueError, IndexError, csv.Error):
        return None


def _origin_of_json(content: bytes) -> tuple[str, str] | None:
    """Return program, without its version, and source of a JSON; None without them."""
    try:
        values = json.loads(content)
        return str(values["program"]).partition(" ")[0], str(values["source"])
    except (ValueError, TypeError, KeyError, RecursionError):
        return None


def _origin_of_picture(content: bytes) -> tuple[str, str] | None:
    """Return program and source in the header of a PNG; None without them."""
    try:
        info = PngImagePlugin.PngImageFile(io.BytesIO(content)).info
        return info["Software"], info[SOURCE]
    except (OSError, SyntaxError, ValueError, KeyError):
        return None
