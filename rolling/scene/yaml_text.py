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
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent

from rolling.scene import library
from rolling.scene.messages import Key, cut, dotted, first_line, shown

MAX_BYTES = 1_000_000  # maximum size of a file
MAX_VALUES = 100_000  # maximum number of keys and values of a text, with its aliases expanded
MAX_ALIASES = 100  # maximum number of aliases; each may merge a whole section into another
MAX_NESTING = 7  # maximum depth of values, such as a speed profile in a swept section
_MAX_DEPTH = 20  # maximum depth of a text; deeper values are reported without their key
_MAX_BITS = 1000  # maximum length of a whole number; Python refuses to write much longer numbers
_LONG_NUMBER = re.compile(r"[0-9_]{4301,}")  # Python reads no longer numbers

# Besides its own errors ruamel.yaml raises these, for example on a directive of YAML 1.164.
_READER_ERRORS = (
    *(ArithmeticError, AssertionError, AttributeError, LookupError),
    *(RuntimeError, TypeError, ValueError),
)
_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class TextError(Exception):
    """Fault of a text in one line, with its place."""


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
    kind = next((kind for is_kind, kind in _KINDS if is_kind(mode)), "no regular file")
    raise OSError(0, f"is {kind}")


def read_regular(path: Path, most: int) -> bytes:
    """Read a regular file of at most `most` bytes; raise OSError for any other."""
    with io.BufferedReader(open_regular(path)) as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(0, f"is larger than {most:,} bytes")
    return content


def read_text(path: Path) -> str:
    """Read a regular file of UTF-8 text of at most MAX_BYTES; raise TextError where it is none."""
    try:
        with io.BufferedReader(open_regular(path)) as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise TextError(f"{path}: no such file{library.hint(path)}") from error
    except OSError as error:
        reason = error.strerror or str(error)
        text = f"{reason}, a scene file is needed" if reason.startswith("is ") else None
        raise TextError(f"{path}: {text or f'not readable ({reason})'}") from error
    if len(content) > MAX_BYTES:
        raise TextError(
            f"{path}: is larger than {MAX_BYTES:,} bytes, allowed: a scene file of at most that"
            " size"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        byte = error.object[error.start]
        raise TextError(f"{path}:{line}: not UTF-8 text (byte {byte:#04x})") from error


def parse(text: str, where: str) -> tuple[Any, dict[Key, int]]:
    """Read plain values and the line of every key; `where` names the text in messages.

    Raises
    ------
    TextError
        The text is no YAML 1.2 of plain values, or beyond a limit.
    """
    if len(text) > MAX_BYTES:
        raise TextError(f"{where}: got {len(text):,} letters, allowed: at most {MAX_BYTES:,}")
    if number := _LONG_NUMBER.search(text):
        line = text.count("\n", 0, number.start()) + 1
        digits = f"{len(number[0]):,} digits, allowed: shorter ones"
        raise TextError(f"{where}:{line}: got a whole number of {digits}")
    yaml = YAML(typ="rt")
    yaml.Composer = _LimitedComposer
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # YAML 1.2 allows anchors that are given twice
            loaded = yaml.load(text)
    except TextError as error:
        raise TextError(f"{where}:{error}") from error
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        problem = getattr(error, "problem", None) or getattr(error, "reason", None)
        problem = (problem or first_line(error)).replace("<stream end>", "the end").splitlines()[0]
        place = f"{where}:{mark.line + 1}" if mark else where
        raise TextError(f"{place}: not YAML: {problem}") from error
    except _READER_ERRORS as error:
        raise TextError(f"{where}: not YAML: {first_line(error)}") from error
    return _plain(loaded, where)


class _LimitedComposer(Composer):
    """Composer that limits the depth of a text and the number of its aliases."""

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self._aliases = 0
        self._open: list[str | None] = []  # anchors of the nodes that are being composed

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node and the nodes in it; raise TextError beyond a limit."""
        event = self.parser.peek_event()
        line, is_alias = event.start_mark.line + 1, isinstance(event, AliasEvent)
        self._aliases += is_alias
        if len(self._open) >= _MAX_DEPTH:
            raise TextError(f"{line}: nested too deeply")
        if self._aliases > MAX_ALIASES:
            raise TextError(f"{line}: more than {MAX_ALIASES} aliases")
        if is_alias and event.anchor in self._open:
            raise TextError(f"{line}: an alias of a value that contains it")
        self._open.append(None if is_alias else event.anchor)
        node = super().compose_node(parent, index)
        self._open.pop()
        return node


def _plain(loaded: Any, where: str) -> tuple[Any, dict[Key, int]]:
    """Turn the values of ruamel.yaml into plain values, and list the line of every key."""
    lines: dict[Key, int] = {(): 1}

    def at(key: Key) -> str:
        return f"{where}:{lines[key]}: {cut(dotted(key))}"

    def plain(value: Any, key: Key) -> Any:
        if len(key) > MAX_NESTING:
            raise TextError(f"{at(key)}: nested too deeply")
        if len(lines) > MAX_VALUES:
            raise TextError(f"{where}:{lines[key]}: more than {MAX_VALUES:,} keys and values")
        if isinstance(value, CommentedMap):
            for name in value:
                line = _line(value, name, lines[key])
                lines[(*key, _name(name, f"{where}:{line}"))] = line
            return {str(name): plain(item, (*key, str(name))) for name, item in value.items()}
        if isinstance(value, CommentedSeq):
            for i in range(len(value)):
                lines[(*key, i)] = _line(value, i, lines[key])
            return [plain(item, (*key, i)) for i, item in enumerate(value)]
        if isinstance(value, TaggedScalar):
            tag = shown(value.tag.value).strip('"')
            raise TextError(f"{at(key)}: got the tag {tag}, allowed: plain values")
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            digits = f"more than {_MAX_BITS * math.log10(2):.0f} digits, allowed: shorter ones"
            raise TextError(f"{at(key)}: got a whole number of {digits}")
        # ruamel keeps the notation of a number. bool comes before int because it is a subclass.
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    return plain(loaded, ()), lines


def _line(container: CommentedMap | CommentedSeq, name: Any, outer: int) -> int:
    """Return the line of a key or place; for merged keys, the line of the container."""
    place = (container.lc.data or {}).get(name)
    return place[0] + 1 if place else outer


def _name(name: Any, at: str) -> str:
    """Return a key as text; raise TextError for a list, a section or a very long number."""
    if isinstance(name, tuple | Mapping):
        raise TextError(f"{at}: got a list or section as a key, allowed: the name of a key")
    if isinstance(name, int) and name.bit_length() > _MAX_BITS:
        raise TextError(f"{at}: got a very long whole number as a key, allowed: its name")
    return str(name)
