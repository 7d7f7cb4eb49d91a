"""JSON Schema of summary.json, made from the fields of the numbers."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, Union

from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.fields import NumberField, number_field_of
from rolling.numbers.quantity import ASSUMED, BOUND, PART_WORDS, How, Quantity

Json = dict[str, Any]
_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_JSON_TYPES: Mapping[Any, str] = {
    bool: "boolean",
    int: "integer",
    float: "number",
    str: "string",
    type(None): "null",
}


def summary_schema(stored: type) -> Json:
    """Return the JSON Schema of the summary.json of what a run folder stores.

    Each number has its meaning as `description`, and its unit as `unit`.

    stored : type. A data class of stored numbers, such as `StoredNumbers`.
    """
    definitions: dict[str, Json] = {}
    properties: Json = {}
    required: list[str] = []
    for data_field in dataclasses.fields(stored):
        hint = hints_of(stored)[data_field.name]
        if data_field.name == "numbers":  # whose subjects stand at the top of the file
            numbers = _object(hint, definitions)
            properties |= numbers["properties"]
            required += numbers["required"]
            continue
        is_fixed = data_field.default is not dataclasses.MISSING
        if is_fixed:
            properties[data_field.name] = {"const": data_field.default}
        else:
            properties[data_field.name] = _of_type(hint, definitions)
        required.append(data_field.name)
    return {
        "$schema": _DIALECT,
        "title": "summary.json of a run",
        "description": "A view of numbers.json for people: floats have six digits, a number that a "
        "run does not have is null, and a group that it does not have is missing.",
        **_closed(properties, required),
        "$defs": dict(sorted(definitions.items())),
    }


@cache
def hints_of(kind: type) -> Mapping[str, Any]:
    """Return the types of the fields of a data class."""
    return typing.get_type_hints(kind)


def options_of(hint: Any) -> tuple[Any, ...]:
    """Return the types that a type joins, such as `float` and `None`."""
    if typing.get_origin(hint) in (Union, types.UnionType):
        return typing.get_args(hint)
    return (hint,)


def _object(kind: type, definitions: dict[str, Json]) -> Json:
    """Return the schema of a data class, as `summary_of` shows it; classes in it are defined."""
    properties = {}
    required = []
    for data_field in dataclasses.fields(kind):
        number_field = number_field_of(data_field)
        options = options_of(hints_of(kind)[data_field.name])
        is_left_out = number_field is not None and number_field.is_group and type(None) in options
        if is_left_out:
            options = tuple(option for option in options if option is not type(None))
        else:
            required.append(data_field.name)
        properties[data_field.name] = _described(number_field) | _joined(options, definitions)
    return _closed(properties, required)


def _described(number_field: NumberField | None) -> Json:
    """Return meaning and unit of a field."""
    if number_field is None:
        return {}
    words: Json = {"description": number_field.meaning}
    if number_field.unit:
        words["unit"] = number_field.unit
    return words


def _joined(options: tuple[Any, ...], definitions: dict[str, Json]) -> Json:
    """Return the schema of a value that has one of some types."""
    if len(options) == 1:
        return _of_type(options[0], definitions)
    if all(option in _JSON_TYPES for option in options):
        return {"type": [_JSON_TYPES[option] for option in options]}
    return {"anyOf": [_of_type(option, definitions) for option in options]}


def _of_type(hint: Any, definitions: dict[str, Json]) -> Json:
    """Return the schema of a value of a type."""
    if hint in _JSON_TYPES:
        return {"type": _JSON_TYPES[hint]}
    if dataclasses.is_dataclass(hint):
        return _reference(typing.cast(type, hint), definitions)
    origin = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin is Literal:
        return {"enum": [*arguments]}
    if origin is dict:
        of_values = _joined(options_of(arguments[1]), definitions)
        return {"type": "object", "additionalProperties": of_values}
    if origin is tuple and arguments[-1] is Ellipsis:
        return {"type": "array", "items": _joined(options_of(arguments[0]), definitions)}
    if origin is tuple:
        parts = [_joined(options_of(part), definitions) for part in arguments]
        return {"type": "array", "prefixItems": parts}
    return _joined(options_of(hint), definitions)


def _reference(kind: type, definitions: dict[str, Json]) -> Json:
    """Return the reference to a data class, which is defined."""
    name = kind.__name__
    if name not in definitions:
        if kind is Quantity:
            definitions[name] = _quantity()
        elif kind is Doubt:
            definitions[name] = _doubt()
        else:
            definitions[name] = _object(kind, definitions)
    return {"$ref": f"#/$defs/{name}"}


def _closed(properties: Json, required: list[str] | None = None) -> Json:
    """Return the schema of an object without other names, all of which are required by default."""
    return {
        "type": "object",
        "properties": properties,
        "required": [*properties] if required is None else required,
        "additionalProperties": False,
    }


def _quantity() -> Json:
    """Return the schema of a quantity, as `summary_of` shows it."""
    number = {"type": ["number", "null"]}
    text = {"type": "string"}
    verdict = _closed(
        {
            "word": {"enum": [*_words(Severity.TRUST, Severity.DO_NOT_QUOTE), BOUND, ASSUMED]},
            "severity": {"enum": _words(Severity.TRUST, Severity.DO_NOT_QUOTE)},
            "decibels": number | {"description": "size of the error; null: unknown", "unit": "dB"},
            "reason": text | {"description": "the worst doubt about it"},
            "key": text | {"description": "name of this doubt"},
        }
    )
    record = _closed(
        {
            "heard_s": number | {"description": "length of the record", "unit": "s"},
            "solved_s": number | {"description": "length of its solved part", "unit": "s"},
            "repeats": {"type": "boolean", "description": "whether it repeats"},
        }
    )
    return _closed(
        {
            "value": number | {"description": "the value; null: none, and `reason` says why"},
            "unit": text | {"description": "unit of the value"},
            "uncertainty": number | {"description": "standard uncertainty; null: unknown"},
            "uncertainty_unit": text | {"description": "unit of the uncertainty and its parts"},
            "how": {"enum": [*typing.get_args(How)], "description": "how it was found"},
            "verdict": {
                "anyOf": [verdict, {"type": "null"}],
                "description": "how far to trust it; null without a value",
            },
            "measure": text | {"description": "what the value measures, such as LAeq"},
            "where": text | {"description": "where it is heard"},
            "meaning": text | {"description": "one sentence that explains it"},
            "reason": text | {"description": "why there is no value, or an empty text"},
            "uncertainty_parts": {
                "type": "object",
                "description": "parts of the uncertainty by their source; the uncertainty is the "
                "root of the sum of their squares",
                "properties": {
                    source: number | {"description": words} for source, words in PART_WORDS.items()
                },
                "additionalProperties": False,
            },
            "record": {
                "anyOf": [record, {"type": "null"}],
                "description": "the record that it describes",
            },
        }
    )


def _doubt() -> Json:
    """Return the schema of a doubt, as `summary_of` shows it."""
    text = {"type": "string"}
    return _closed(
        {
            "key": text | {"description": "its name, which never changes with the wording"},
            "text": text | {"description": "what is wrong"},
            "advice": text | {"description": "what follows, and what to do"},
            "severity": {
                "enum": _words(Severity.NOTE, Severity.REFUSED),
                "description": "what it leaves of a level",
            },
            "decibels": {
                "type": ["number", "null"],
                "description": "size of the error; null: unknown",
                "unit": "dB",
            },
            "about": {
                "type": "array",
                "items": text,
                "description": "names of the quantities that it touches; empty: all",
            },
        }
    )


def _words(least: Severity, most: Severity) -> list[str]:
    """Return the words of severities from one to another."""
    return [severity.word for severity in Severity if least <= severity <= most]
