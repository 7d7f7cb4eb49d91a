"""YAML text as plain values and the line of each key, within limits of size, depth and number."""

from __future__ import annotations

import io
import math
import os
import stat
import warnings
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq, TaggedScalar
from ruamel.yaml.composer import Composer
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent
from ruamel.yaml.nodes import Node

from rolling.scene import library
from rolling.scene.messages import Key, cut, dotted, first_line, shown

MAX_BYTES = 1_000_000  # of a file
MAX_VALUES = 100_000  # keys and values of a text, its aliases written out
MAX_NESTING = 4  # of values in a scene
_MAX_BITS = 1000  # of a whole number: Python refuses to write much longer ones
# of a text: the places of what is nested deeper than scenes are is not worth naming
_MAX_DEPTH = 20

# Errors of ruamel.yaml: it refuses some constructs, and stumbles over others, such as a directive
# of YAML 1.164.
_STUMBLES = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    LookupError,
    RuntimeError,
    TypeError,
    ValueError,
)

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class TextError(Exception):
    """A fault of a text in one line, with its place."""


def kind_of_file(mode: int) -> str | None:
    """Name the kind of a file that is no regular one, by its mode; None for a regular file."""
    return (
        None
        if stat.S_ISREG(mode)
        else next((kind for is_kind, kind in _KINDS if is_kind(mode)), "no regular file")
    )


def read_text(path: Path) -> str:
    """Read a regular file of UTF-8 text, of at most MAX_BYTES; another kind of file is not even
    opened.

    Raises
    ------
    TextError
        The file is missing, no regular file, too large, not readable, or not UTF-8.
    """
    try:
        kind = kind_of_file(path.stat().st_mode)
        if kind is not None:
            raise TextError(f"{path}: is {kind}, a scene file is needed")
        content = _read_bytes(path, MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise TextError(f"{path}: no such file{library.hint(path)}") from error
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise TextError(
            f"{path}: not readable ({getattr(error, 'strerror', None) or error})"
        ) from error
    if len(content) > MAX_BYTES:
        raise TextError(
            f"{path}: is larger than {MAX_BYTES:,} bytes, allowed: a scene file of at most that size"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise TextError(
            f"{path}:{line}: not UTF-8 text (byte {error.object[error.start]:#04x})"
        ) from error


def open_at_once(path: Path) -> io.FileIO:
    """Open a file for reading without waiting: a pipe that took its place must not hold the program
    up.
    """
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    return io.FileIO(os.open(path, flags), "rb")


def _read_bytes(path: Path, most: int) -> bytes:
    parts, missing = [], most
    with open_at_once(path) as stream:
        while missing and (part := stream.read(missing)):
            parts.append(part)
            missing -= len(part)
    return b"".join(parts)


def parse(text: str, where: str) -> tuple[Any, dict[Key, int]]:
    """Read plain values and the line of every key; `where` names the text in messages.

    Raises
    ------
    TextError
        The text is no YAML 1.2 of plain values, or beyond a limit.
    """
    if len(text) > MAX_BYTES:
        raise TextError(f"{where}: got {len(text):,} letters, allowed: at most {MAX_BYTES:,}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of anchors given twice, which YAML 1.2 allows
            yaml = YAML(typ="rt")
            yaml.Composer = _Counted
            return _plain(yaml.load(text), where)
    except _BeyondLimit as error:
        raise TextError(f"{where}:{error.line}: {error}") from error
    except DuplicateKeyError as error:
        section, second = error.context_mark, error.problem_mark
        name = (
            second.buffer[second.pointer :][:100].split(":")[0].strip() if second.buffer else "key"
        )
        raise TextError(
            f"{where}:{second.line + 1}: {name}: given twice in the section that begins in line {section.line + 1}"
        ) from error
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        place = f"{where}:{mark.line + 1}" if mark else where
        problem = (
            getattr(error, "problem", None) or getattr(error, "reason", None) or first_line(error)
        )
        raise TextError(
            f"{place}: not YAML: {problem.replace('<stream end>', 'the end')}"
        ) from error
    except _STUMBLES as error:
        raise TextError(f"{where}: not YAML: {first_line(error)}") from error


class _BeyondLimit(Exception):
    """A text that holds too much or is nested too deeply, with the line."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


class _Counted(Composer):
    """A composer that counts the values of a text, an alias as all its values, and stops beyond a
    limit.
    """

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        # values in a node that is read, by its id; the nodes live as long as this
        self._sizes: dict[int, int] = {}
        self._open: list[int] = []  # values so far in each node that is being read
        self._total = 0

    def compose_node(self, parent: Any, index: Any) -> Node:
        line = self.parser.peek_event().start_mark.line + 1
        alias = self.parser.check_event(AliasEvent)
        if len(self._open) >= _MAX_DEPTH:
            raise _BeyondLimit("nested too deeply", line)
        self._open.append(1)
        node: Node = super().compose_node(parent, index)
        size = self._open.pop()
        if alias:
            if id(node) not in self._sizes:  # still being read
                raise _BeyondLimit("an alias of what it stands in", line)
            size = self._sizes[id(node)]
        self._sizes[id(node)] = size
        self._total += size if alias else 1
        if self._total > MAX_VALUES:
            raise _BeyondLimit(
                f"more than {MAX_VALUES:,} keys and values, aliases counted as what they stand for",
                line,
            )
        if self._open:
            self._open[-1] += size
        return node


def _plain(loaded: Any, where: str) -> tuple[Any, dict[Key, int]]:
    """Turn the values of ruamel.yaml into plain ones, and list the line of every key."""
    lines: dict[Key, int] = {(): 1}

    def plain(value: Any, key: Key) -> Any:
        if len(key) > MAX_NESTING:
            raise TextError(f"{where}:{lines[key]}: {cut(dotted(key))}: nested too deeply")
        if isinstance(value, CommentedMap):
            for name in value:
                place = (value.lc.data or {}).get(name)  # none for what a merge brought in
                lines[(*key, str(name))] = place[0] + 1 if place else lines[key]
            return {str(name): plain(item, (*key, str(name))) for name, item in value.items()}
        if isinstance(value, CommentedSeq):
            for i in range(len(value)):
                place = (value.lc.data or {}).get(i)
                lines[(*key, i)] = place[0] + 1 if place else lines[key]
            return [plain(item, (*key, i)) for i, item in enumerate(value)]
        if isinstance(value, TaggedScalar):
            tag = shown(value.tag.value).strip('"')
            raise TextError(
                f"{where}:{lines[key]}: {cut(dotted(key))}: got the tag {tag}, allowed: plain values"
            )
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            digits = f"a whole number of more than {_MAX_BITS * math.log10(2):.0f} digits"
            raise TextError(
                f"{where}:{lines[key]}: {cut(dotted(key))}: got {digits}, allowed: shorter ones"
            )
        # ruamel keeps how a number was written; bool before int, whose child it is.
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    return plain(loaded, ()), lines
