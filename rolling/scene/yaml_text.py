"""YAML text as plain values with the line of every key, within limits of size and depth."""

from __future__ import annotations

import re
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from rolling.scene import library
from rolling.scene.height_files import holds_heights, reason_of
from rolling.scene.messages import Key, Mistake, SceneError, first_line, quoted, shortened
from rolling.terminal.whole_files import open_regular, read_regular

MAX_BYTES = 1_000_000  # maximum size of a file
MAX_KEPT = 10_000  # letters of a text whose nodes are kept
MAX_VALUES = 100_000  # maximum number of keys and values of a text, with its aliases expanded
MAX_NESTING = 7  # maximum depth of values, such as a speed profile in a swept section
MAX_MERGES = 100  # maximum number of sections that are merged into others
NAME = re.compile(rb"^name\s*:", re.MULTILINE)  # of a scene
MAX_DIGITS = 300  # of a number; pydantic and Python fail to write much longer ones
_TAG = "tag:yaml.org,2002:"
_NUMBERS = ("int", "float")
_DATE = "timestamp"
_PLAIN = ("map", "seq", "str", "bool", "null", _DATE, *_NUMBERS)  # tags of plain values


def read_text(path: Path) -> str:
    """Read a regular file of UTF-8 text of at most MAX_BYTES; raise SceneError where it is none.

    A file of heights is no scene, and the error says how it gets into one.
    """
    if holds_heights(path) and not _has_name(path):
        raise SceneError(
            [
                f"{path}: holds heights, a scene is needed; `rolling surface {path}` prints its"
                " line `surface: {...}`, which stands in a scene file, or follows a scene of"
                " `rolling scenes`, as in vibrating-ball --set 'surface={...}'"
            ]
        )
    try:
        return read_regular(path, MAX_BYTES).decode("utf-8-sig")
    except OSError as error:
        words = reason_of(error)
        if isinstance(error, FileNotFoundError):
            words += library.hint(path)
        elif words.startswith("is larger"):
            words += ", allowed: a scene file of at most that size"
        elif words.startswith("is "):
            words += ", a scene file is needed"
        raise SceneError([f"{path}: {words}"]) from error
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        byte = error.object[error.start]
        raise SceneError([f"{path}:{line}: not UTF-8 text (byte {byte:#04x})"]) from error


def _has_name(path: Path) -> bool:
    """Tell whether a text names a scene, or is no file that could be read."""
    try:
        with open_regular(path) as file:
            return NAME.search(file.read(MAX_BYTES)) is not None
    except OSError:
        return True


class Parsed(NamedTuple):
    """Content of a YAML text.

    value : Any. Plain values; a value with a mistake is left out.
    lines : dict. Line of every key.
    mistakes : list of Mistake. Keys that stand twice and values that are not plain, with lines.
    """

    value: Any
    lines: dict[Key, int]
    mistakes: list[Mistake]


def parse(text: str, where: str) -> Parsed:
    """Read plain values and the line of every key; `where` names the text in messages.

    Raises
    ------
    SceneError
        The text is no YAML 1.2, or beyond a limit.
    """
    if len(text) > MAX_BYTES:
        raise SceneError([f"{where}: got {len(text):,} letters, allowed: at most {MAX_BYTES:,}"])
    try:
        root = _kept_root(text) if len(text) <= MAX_KEPT else _root(text)
    except RecursionError as error:
        raise SceneError([f"{where}: nested too deeply"]) from error
    except YAMLError as error:
        raise SceneError([_not_yaml(error, text, where)]) from error
    except Exception as error:  # ruamel.yaml raises any kind, as on a directive of YAML 1.164
        raise SceneError([f"{where}: not YAML: {first_line(error)}"]) from error
    if root is None:
        return Parsed(None, {}, [])
    walk = _Walk(YAML(typ="safe", pure=True), where)
    value = walk.value(root, ())
    return Parsed(value, walk.lines, walk.mistakes)


def _root(text: str) -> Node | None:
    """Return the node of a whole text, None for an empty one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # YAML 1.2 allows anchors that are given twice
        root: Node | None = YAML(typ="safe", pure=True).compose(text)
    return root


# Scripts and tests read a text many times with other overrides. Nobody changes its nodes.
_kept_root = lru_cache(maxsize=32)(_root)


def _not_yaml(error: YAMLError, text: str, where: str) -> str:
    """Write the problem that the reader of YAML has with a text, and its line."""
    problem = getattr(error, "problem", None) or getattr(error, "reason", None)
    problem = (problem or first_line(error)).replace("<stream end>", "the end").splitlines()[0]
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    position = getattr(error, "position", None)  # of a letter that YAML does not allow
    if position is not None:
        line = text.count("\n", 0, position) + 1
    elif mark is not None:
        line = mark.line + 1
    else:
        return f"{where}: not YAML: {problem}"
    return f"{where}:{line}: not YAML: {problem}"


class _Item(NamedTuple):
    """Node of the value of a key, and its line."""

    node: Node
    line: int


class _Walk:
    """A walk over the nodes of a text, which collects plain values and the lines of their keys."""

    def __init__(self, yaml: YAML, where: str) -> None:
        self._yaml = yaml
        self._where = where
        self._merges = 0
        self.lines: dict[Key, int] = {(): 1}
        self.mistakes: list[Mistake] = []

    def value(self, node: Node, key: Key) -> Any:
        """Return the plain value of a node, None for any other; raise SceneError beyond a limit."""
        if len(key) > MAX_NESTING:
            raise self._error(key, "nested too deeply")
        if len(self.lines) > MAX_VALUES:
            raise self._error(key, f"more than {MAX_VALUES:,} keys and values")
        kind = str(node.tag).removeprefix(_TAG)
        if kind not in _PLAIN:
            self._note(key, f"got the tag {shortened(str(node.tag))}, allowed: plain values")
            return None
        if isinstance(node, ScalarNode):
            return self._scalar(node, kind, key)
        if isinstance(node, SequenceNode):
            for i, item in enumerate(node.value):
                self.lines[(*key, i)] = item.start_mark.line + 1
            return [self.value(item, (*key, i)) for i, item in enumerate(node.value)]
        assert isinstance(node, MappingNode)
        items = self._items(node, key)
        for name, item in items.items():
            self.lines[(*key, name)] = item.line
        return {name: self.value(item.node, (*key, name)) for name, item in items.items()}

    def _scalar(self, node: ScalarNode, kind: str, key: Key) -> Any:
        """Return the plain value of a text; a date is text in a scene."""
        if kind in _NUMBERS and len(node.value) > MAX_DIGITS:
            words = f"got a number of {len(node.value):,} digits, allowed: at most {MAX_DIGITS}"
            self._note(key, words)
            return None
        if kind == _DATE:
            return node.value
        try:
            return self._yaml.constructor.construct_object(node)
        except Exception:  # ruamel.yaml raises any kind where a tag does not fit the text
            self._note(key, f"got {quoted(node.value)}, allowed: plain values")
            return None

    def _items(self, node: MappingNode, key: Key) -> dict[str, _Item]:
        """Return node and line of each key of a section; its own keys win over merged ones (<<).

        Keys are text as they are written. Merged keys have the line of the section.
        """
        items: dict[str, _Item] = {}
        merged: list[Node] = []
        for name_node, item in node.value:
            line = name_node.start_mark.line + 1
            name = name_node.value
            if not isinstance(name_node, ScalarNode):
                words = "got a list or section as a key, allowed: the name of a key"
                self.mistakes.append(Mistake((), words, f"{self._where}:{line}"))
            elif str(name_node.tag) == f"{_TAG}merge":
                merged += item.value if isinstance(item, SequenceNode) else [item]
            elif name in items:
                words = f"given twice, first in line {items[name].line}"
                self.mistakes.append(Mistake((*key, name), words, f"{self._where}:{line}"))
            else:
                items[name] = _Item(item, line)
        for section in merged:
            self._merges += 1
            if self._merges > MAX_MERGES:
                raise self._error(key, f"more than {MAX_MERGES} sections are merged in")
            if not isinstance(section, MappingNode):
                raise self._error(key, "only a section can be merged in")
            for name, inner in self._items(section, key).items():
                items.setdefault(name, inner._replace(line=self.lines[key]))
        return items

    def _note(self, key: Key, words: str) -> None:
        """Note the mistake of a key, whose value is left out."""
        self.mistakes.append(Mistake(key, words, f"{self._where}:{self.lines[key]}"))

    def _error(self, key: Key, words: str) -> SceneError:
        """Make the error of a key beyond which nothing is read."""
        return SceneError([Mistake(key, words, f"{self._where}:{self.lines[key]}").line])
