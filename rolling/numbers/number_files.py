"""Numbers in files: unrounded for the program, and a rounded view for people.

Only this module and the data classes know how a number is written. What is read back has the types
of the fields, or is refused.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any, TypeVar

from rolling.numbers.doubt import Doubt
from rolling.numbers.fields import number_field_of
from rolling.numbers.quantity import Quantity

DIGITS = 6  # of a number in summary.json
LARGEST = 1e100  # no number of a run is larger in any unit
_Numbers = TypeVar("_Numbers")


_ADAPTERS: dict[Any, Any] = {}  # what writes and reads each kind of numbers, made once


def _adapter(kind: Any) -> Any:
    """Return what writes and reads a kind of numbers."""
    from pydantic import TypeAdapter  # slow to import, for files only

    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]


def to_bytes(numbers: Any) -> bytes:
    """Write a data class of numbers, unrounded.

    Raises
    ------
    ValueError : a number is not finite.
    """
    content = _adapter(type(numbers)).dump_python(numbers, mode="json")
    return json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1).encode()


def from_bytes(kind: type[_Numbers], content: bytes) -> _Numbers:
    """Read a data class of numbers.

    Raises
    ------
    ValueError : the content is of another kind, or a number is missing, not finite or of another
        type, or larger than LARGEST. The message names the first such field.
    """
    from pydantic import ValidationError

    try:
        read: _Numbers = _adapter(kind).validate_json(content, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(map(str, first["loc"])) or "the file"
        raise ValueError(f"{place}: {first['msg']}") from error
    _refuse_endless(json.loads(content), ())
    return read


def _refuse_endless(value: Any, path: tuple[Any, ...]) -> None:
    """Raise ValueError for a number that is not finite, or beyond all physics."""
    if isinstance(value, int | float) and not abs(value) <= LARGEST:
        raise ValueError(f"{'.'.join(map(str, path))}: {value} is no number")
    if isinstance(value, Mapping):
        for name, inner in value.items():
            _refuse_endless(inner, (*path, name))
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            _refuse_endless(inner, (*path, number))


# ---- the view for people


def summary_of(numbers: Any) -> Any:
    """Return numbers as summary.json shows them: nested by subject, rounded to six digits.

    Groups that a run does not have are left out. Doubts stand once, in their list, and a quantity
    has its verdict.
    """
    if isinstance(numbers, Quantity):
        return _quantity_view(numbers)
    if isinstance(numbers, Doubt):
        return {
            "key": numbers.key,
            "text": numbers.text,
            "advice": numbers.advice,
            "severity": numbers.severity.word,
            "decibels": summary_of(numbers.decibels),
            "about": list(numbers.about),
        }
    if dataclasses.is_dataclass(numbers):
        shown = {}
        for data_field in dataclasses.fields(numbers):
            value = getattr(numbers, data_field.name)
            number_field = number_field_of(data_field)
            if value is None and number_field is not None and number_field.is_group:
                continue
            shown[data_field.name] = summary_of(value)
        return shown
    if isinstance(numbers, Mapping):
        return {name: summary_of(value) for name, value in numbers.items()}
    if isinstance(numbers, tuple | list):
        return [summary_of(value) for value in numbers]
    if isinstance(numbers, float):
        return float(f"{numbers:.{DIGITS}g}")
    return numbers


def _quantity_view(quantity: Quantity) -> dict[str, Any]:
    """Return a quantity as summary.json shows it: value, ±, origin and verdict first."""
    judged = quantity.judged
    shown = {
        "value": summary_of(quantity.value),
        "unit": quantity.unit,
        "uncertainty": summary_of(quantity.uncertainty),
        "uncertainty_unit": quantity.unit_of_uncertainty,
        "how": quantity.how,
        "verdict": None,
        "measure": quantity.measure,
        "where": quantity.where,
        "meaning": quantity.meaning,
        "reason": quantity.reason,
        "uncertainty_parts": summary_of(quantity.parts),
        "record": summary_of(quantity.record),
    }
    if judged is not None:
        shown["verdict"] = {
            "word": judged.word,
            "severity": judged.worst.severity.word,
            "decibels": summary_of(judged.worst.decibels),
            "reason": judged.worst.text,
            "key": judged.worst.key,
        }
    return shown
