"""Sweeps as plain values: their lists, their product, and the names of their runs.

Values are numbers, names, or anything under labels, such as two surfaces or two speed profiles.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticCustomError

from rolling.scene import library
from rolling.scene.messages import (
    MAX_MISTAKES,
    Key,
    is_number,
    key_of,
    mistake,
    mistakes_together,
    nearest,
    plain_number,
    quoted,
    shortened,
)
from rolling.scene.models import sweepable_keys

MAX_RUNS = 10_000  # maximum number of runs of a sweep
LONGEST_LABEL = 100  # letters
LONGEST_NAME = 120  # bytes; temporary names add to it, and some file systems end at 143
_LONGEST_TEXT = 40  # letters of a text in a name
Value = float | str  # number, text, or label of a swept value
Choice = tuple[Value, Any]  # value as names and tables show it, and its plain form for the scene


# ---- names of runs


def run_name(values: Mapping[str, Value]) -> str:
    """Return the name of a run by its own values alone, such as "load_n=5,radius_mm=2".

    Each key stands with its last part unless two keys share it. Numbers stand with all digits; a
    text that is not fit for every file system ends in a digest. Runs without values have an empty
    name.
    """
    last_parts = [key.rpartition(".")[2] for key in values]
    parts = []
    for key, value in values.items():
        last = key.rpartition(".")[2]
        label = last if last_parts.count(last) == 1 else key
        parts.append(f"{label}={_written(value)}")
    name = ",".join(parts)
    if len(name) <= LONGEST_NAME:
        return name
    exact = ",".join(f"{key}={value!r}" for key, value in values.items())
    return f"{name[: LONGEST_NAME - 17]}-{_digest(exact)}"


def _written(value: Value) -> str:
    """Write a number with all digits, or a text in letters that every file system takes."""
    if not isinstance(value, str):
        return repr(value) if isinstance(value, int) else plain_number(value)
    short = re.sub(r"[^A-Za-z0-9._+-]+", "-", value.strip("./\\ "))[-_LONGEST_TEXT:].strip("-")
    return short if short == value else f"{short or '-'}-{_digest(value)[:6]}"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()[:16]


# ---- lists of values


def check_lists(sweep: Any, root: type[BaseModel]) -> dict[str, Any]:
    """Return a sweep with its lists as tuples; raise all mistakes of its keys and lists.

    `root` is the model of the scene.

    The values themselves are checked with the runs that have them. A key without a value (None)
    is not swept.
    """
    if not isinstance(sweep, Mapping):
        raise mistake(
            f"got {quoted(sweep)}, allowed: lists of numbers by dotted key, as in rolling.load_n:"
            " [5, 20]",
            at="sweep",
        )
    known = sweepable_keys(root)
    mistakes: list[PydanticCustomError] = []
    for name, listed in sweep.items():
        if name not in known:
            like = nearest(name, known) if isinstance(name, str) else ""
            mistakes.append(mistake(f"unknown key{like}", at=("sweep", str(name))))
        elif listed is not None and (not isinstance(listed, list | tuple | dict) or not listed):
            mistakes.append(_no_list(name, listed))
    if mistakes:
        raise mistakes_together(mistakes[:MAX_MISTAKES])
    sweep = {name: listed for name, listed in sweep.items() if listed is not None}
    runs = math.prod(map(len, sweep.values()))
    if runs > MAX_RUNS:  # refused before any value is looked at
        raise mistake(f"got {runs} runs, allowed: at most {MAX_RUNS}", at="sweep")
    checked: dict[str, Any] = {}
    for name, listed in sweep.items():
        if isinstance(listed, dict):
            mistakes += _mistakes_of_labels(name, listed)
            checked[name] = dict(listed)
        else:
            mistakes += _mistakes_of_list(name, listed)
            checked[name] = tuple(listed)
    if mistakes:
        raise mistakes_together(mistakes[:MAX_MISTAKES])
    return checked


def _no_list(name: str, value: Any) -> PydanticCustomError:
    """Return the mistake of a swept key that has no list of values, with an example."""
    words = (
        f"got {quoted(value)}, allowed: a list of at least one number or name, or values by label,"
        " as in {first: ..., second: ...}"
    )
    if is_number(value):
        words += f"; write [{value}, {2 * value}] for two runs, or {name}={value} without a sweep"
    elif isinstance(value, str) and value:
        short = shortened(value)
        words += f"; write [{short}, ...] for several runs, or {name}={short} without a sweep"
    return mistake(words, at=("sweep", name))


def _mistakes_of_labels(name: str, listed: Mapping[Any, Any]) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of the labels of a key."""
    at: Key = ("sweep", name)
    seen: dict[str, Value] = {}
    for label in listed:
        if not isinstance(label, str) or not 0 < len(label) <= LONGEST_LABEL:
            yield mistake(
                f"got {quoted(label)} as a label, allowed: text of 1 to {LONGEST_LABEL} letters",
                at=at,
            )
        else:
            yield from _repetition(label, seen, at)


def _mistakes_of_list(name: str, listed: Sequence[Any]) -> Iterator[PydanticCustomError]:
    """Yield the mistakes of the numbers or names of a key."""
    seen: dict[str, Value] = {}
    for i, value in enumerate(listed):
        at: Key = ("sweep", name, i)
        if not is_number(value) and not (isinstance(value, str) and value):
            yield mistake(
                f"got {quoted(value)}, allowed: a number or a name; any other value has a label, as"
                f" in {name}: {{first: {quoted(value)}}}",
                at=at,
            )
        else:
            yield from _repetition(value, seen, at)


def _repetition(value: Value, seen: dict[str, Value], at: Key) -> Iterator[PydanticCustomError]:
    """Yield the mistake of a value that stands twice, or has the folder of another one."""
    form = _written(value).casefold()  # because some file systems do not tell the case of letters
    if form not in seen:
        seen[form] = value
    elif seen[form] == value:
        yield mistake(f"got {quoted(value)} twice, allowed: different values", at=at)
    else:
        yield mistake(
            f"got {quoted(value)} beside {quoted(seen[form])}, allowed: texts that differ in more"
            " than upper and lower case",
            at=at,
        )


# ---- runs


def choices(listed: Any) -> list[Choice]:
    """Return the values of one key, each with the form that a scene takes."""
    if isinstance(listed, dict):
        return list(listed.items())
    return [(value, value) for value in listed]


def product(sweep: Mapping[str, Any]) -> Iterator[tuple[dict[str, Value], dict[str, Any]]]:
    """Yield the values of each run by dotted key, and their plain forms; the last is fastest."""
    for row in itertools.product(*map(choices, sweep.values())):
        values = {name: value for name, (value, _) in zip(sweep, row, strict=True)}
        forms = {name: form for name, (_, form) in zip(sweep, row, strict=True)}
        yield values, forms


def place_in_sweep(key: Key, values: Mapping[str, Value], sweep: Mapping[str, Any]) -> Key | None:
    """Return the place in a sweep that gives a run its value at a key; None for other keys."""
    swept = [name for name in values if key[: len(key_of(name))] == key_of(name)]
    if not swept:
        return None
    name = max(swept, key=len)
    value = values[name]
    if isinstance(sweep[name], dict):
        place: str | int = str(value)
    else:
        place = sweep[name].index(value)
    return ("sweep", name, place, *key[len(key_of(name)) :])


# ---- changes of plain values


def with_values(data: Mapping[str, Any], forms: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plain values of a scene with the values of one run, sections first."""
    result: Mapping[str, Any] = data
    for name in sorted(forms, key=lambda name: (name.count("."), library.order_of_change(name))):
        result = library.without_replaced_values(result, name, forms[name])
        result = _with_value_at(result, key_of(name), forms[name])
    return {
        name: library.with_named_values(name, part) if name in library.NAMES else part
        for name, part in result.items()
    }


def with_value(data: Mapping[str, Any], name: str, value: Any) -> dict[str, Any]:
    """Return plain values with the value of a dotted name, which leaves the sweep."""
    has_material = library.name_of("plate", data.get("plate")) is not None
    if name == "plate.hardness_gpa" and value is None and has_material:
        value = library.NONE  # because the material would give its hardness again
    key = key_of(name)
    kept = library.without_replaced_values(data, name, value)
    result: dict[str, Any] = _with_value_at(kept, key, value)
    swept = result.get("sweep")
    if len(key) > 1 and key[0] != "sweep" and isinstance(swept, dict):
        result["sweep"] = {other: listed for other, listed in swept.items() if other != name}
    return result


def _with_value_at(values: Any, key: Key, form: Any) -> Any:
    """Return plain values with another value at a key; values in place of a section stay."""
    if not key:
        return form
    if values is None:
        values = {}
    if not isinstance(values, Mapping):
        return values
    name = str(key[0])
    return {**values, name: _with_value_at(values.get(name), key[1:], form)}


def with_paths(data: Mapping[str, Any], moved: Callable[[str], str]) -> dict[str, Any]:
    """Return the plain values of a scene with other paths of height files, swept ones as well.

    Swept paths keep their text as labels.
    """

    def section(name: str, values: Any) -> Any:
        if name == "path" and isinstance(values, str):
            return moved(values)
        inner = {"surface": "path", "sphere": "surface"}.get(name)
        if inner and isinstance(values, dict) and inner in values:
            return {**values, inner: section(inner, values[inner])}
        return values

    result = {name: section(name, values) for name, values in data.items()}
    for name, listed in data.get("sweep", {}).items():
        last = name.rpartition(".")[2]
        if last in ("path", "surface", "sphere"):
            moved_forms = {str(label): section(last, form) for label, form in choices(listed)}
            result["sweep"] = {**result["sweep"], name: moved_forms}
    return result
