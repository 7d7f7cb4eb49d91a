"""YAML text as plain values with the line of each key, within limits of size and depth."""

from __future__ import annotations

import io
import math
import os
import re
import stat
import warnings
from collections.abc import Mapping
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

MAX_BYTES = 1_000_000  # maximum size of a file
MAX_VALUES = 100_000  # maximum number of keys and values of a text, with its aliases expanded
MAX_NESTING = 4  # maximum depth of values in a scene
MAX_SWEEP_NESTING = 7  # such as a speed profile, in a section with a label, under sweep.zip
_MAX_BITS = 1000  # maximum length of a whole number; Python refuses to write much longer numbers
_LONG_NUMBER = re.compile(r"[0-9_]{4301,}")  # Python reads no longer numbers
# Maximum depth of a text; values nested deeper than this are reported without their key.
_MAX_DEPTH = 20

# Besides its own errors ruamel.yaml raises these, for example on a directive of YAML 1.164.
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
    """Fault of a text in one line, with its place."""


def kind_of_file(mode: int) -> str | None:
    """Name the kind of an irregular file by its mode; return None for a regular file."""
    return (
        None
        if stat.S_ISREG(mode)
        else next((kind for is_kind, kind in _KINDS if is_kind(mode)), "no regular file")
    )


def read_text(path: Path) -> str:
    """Read a regular file of UTF-8 text of at most MAX_BYTES.

    A file of another kind is not even opened.

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
            f"{path}: is larger than {MAX_BYTES:,} bytes, allowed: a scene file of at most that"
            " size"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise TextError(
            f"{path}:{line}: not UTF-8 text (byte {error.object[error.start]:#04x})"
        ) from error


def open_at_once(path: Path) -> io.FileIO:
    """Open a file for reading without waiting.

    A pipe that took its place must not block the program.
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
            warnings.simplefilter("ignore")  # YAML 1.2 allows anchors that are given twice
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
            f"{where}:{second.line + 1}: {name}: given twice in the section that begins in line"
            f" {section.line + 1}"
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
        if number := _LONG_NUMBER.search(text):
            line = text.count("\n", 0, number.start()) + 1
            raise TextError(
                f"{where}:{line}: got a whole number of {len(number[0]):,} digits, allowed: shorter"
                " ones"
            ) from error
        raise TextError(f"{where}: not YAML: {first_line(error)}") from error


class _BeyondLimit(Exception):
    """Error for a text that is too long or nested too deeply, with the line."""

    def __init__(self, message: str, line: int) -> None:
        super().__init__(message)
        self.line = line


class _Counted(Composer):
    """Composer that counts the values of a text and stops beyond a limit.

    An alias counts as all its values.
    """

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        # number of values in each completed node, by its id; the nodes live as long as this object
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
                raise _BeyondLimit("an alias of a value that contains it", line)
            size = self._sizes[id(node)]
        self._sizes[id(node)] = size
        self._total += size if alias else 1
        if self._total > MAX_VALUES:
            raise _BeyondLimit(
                f"more than {MAX_VALUES:,} keys and values, each alias counted with all its values",
                line,
            )
        if self._open:
            self._open[-1] += size
        return node


def _line_of(container: CommentedMap | CommentedSeq, name: Any, outer: int) -> int:
    """Return the line of a key or place; for merged keys, the line of the container."""
    place = (container.lc.data or {}).get(name)
    return place[0] + 1 if place else outer


def _refuse_key(name: Any, where: str) -> None:
    """Raise TextError for a key that is no text nor a short number."""
    if isinstance(name, tuple | CommentedMap | CommentedSeq | Mapping):
        raise TextError(f"{where}: got a list or section as a key, allowed: the name of a key")
    if isinstance(name, int) and name.bit_length() > _MAX_BITS:
        raise TextError(f"{where}: got a very long whole number as a key, allowed: its name")


def _plain(loaded: Any, where: str) -> tuple[Any, dict[Key, int]]:
    """Turn the values of ruamel.yaml into plain values, and list the line of every key."""
    lines: dict[Key, int] = {(): 1}

    def plain(value: Any, key: Key) -> Any:
        if len(key) > (MAX_SWEEP_NESTING if key[:1] == ("sweep",) else MAX_NESTING):
            raise TextError(f"{where}:{lines[key]}: {cut(dotted(key))}: nested too deeply")
        if isinstance(value, CommentedMap):
            for name in value:
                _refuse_key(name, f"{where}:{_line_of(value, name, lines[key])}")
            for name in value:
                lines[(*key, str(name))] = _line_of(value, name, lines[key])
            return {str(name): plain(item, (*key, str(name))) for name, item in value.items()}
        if isinstance(value, CommentedSeq):
            for i in range(len(value)):
                lines[(*key, i)] = _line_of(value, i, lines[key])
            return [plain(item, (*key, i)) for i, item in enumerate(value)]
        if isinstance(value, TaggedScalar):
            tag = shown(value.tag.value).strip('"')
            raise TextError(
                f"{where}:{lines[key]}: {cut(dotted(key))}: got the tag {tag}, allowed: plain"
                " values"
            )
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            digits = f"a whole number of more than {_MAX_BITS * math.log10(2):.0f} digits"
            raise TextError(
                f"{where}:{lines[key]}: {cut(dotted(key))}: got {digits}, allowed: shorter ones"
            )
        # ruamel keeps the notation of a number. bool comes before int because it is a subclass.
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    return plain(loaded, ()), lines
