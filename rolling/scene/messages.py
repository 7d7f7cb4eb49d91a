"""Keys, values and faults in words: known names, allowed values, nearest names.

`root` is the model of a whole scene or of one section. A scene has sections of plain values and a
sweep; the surface has several kinds.
"""

from __future__ import annotations

import difflib
import json
import math
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

# place of a value: ("rolling", "load_n"), ("sweep", "rolling.load_n", 0)
Key = tuple[str | int, ...]


@dataclass(frozen=True)
class Words:
    """Allowed values in words, for a field whose type does not tell them."""

    allowed: str


# Letters of a misspelt name; the comparison of longer names is slow and fruitless.
_LONGEST_SLIP = 100


class SceneError(Exception):
    """Faults of a scene.

    Attributes
    ----------
    faults : list of str
        One line for each fault: file and line (or --set, or scene), key, the value and the allowed
        values.
    """

    def __init__(self, faults: Sequence[str]) -> None:
        # Values and names of files may hold halves of pairs, which UTF-8 cannot write.
        self.faults = [
            fault.encode("utf-8", "backslashreplace").decode("utf-8") for fault in faults
        ]
        super().__init__("\n".join(self.faults))

    def __reduce__(self) -> tuple[type[SceneError], tuple[list[str]]]:
        return SceneError, (self.faults,)


# ---- faults


def fault(message: str, *at: str | int) -> PydanticCustomError:
    """Make a fault for pydantic to collect.

    `at` is its key where that differs from the validated key.
    """
    # pydantic writes no text that UTF-8 cannot, such as half of a pair of surrogates
    message = message.encode("utf-8", "backslashreplace").decode("utf-8")
    return PydanticCustomError("fault", "{message}", {"message": message, "at": at})


def explained(error: Any, data: Mapping[str, Any], root: type[BaseModel]) -> tuple[Key, str]:
    """Return key and message of a pydantic fault."""
    key: Key = error["loc"]
    outer = root.model_fields.get(str(key[0])) if key else None
    by = outer.discriminator if outer else None
    if by and len(key) > 1:  # pydantic names the kind of a section in between
        key = (key[0], *key[2:])
    kind = error["type"]
    if kind == "fault":
        return error["ctx"]["at"] or key, error["ctx"]["message"]
    if not key:  # the name of a key at the top that UTF-8 cannot write
        name = next((name for name in data if not _is_unicode(name)), "")
        return (ascii(name).strip("'"),), f"unknown key, allowed: {', '.join(root.model_fields)}"
    if kind == "extra_forbidden":
        siblings = _siblings(root, key, data)
        known = [other for other in all_keys(root) if not other.startswith("sweep.")]
        elsewhere = (
            [] if dotted(key) in known else known
        )  # a key of another kind of the section is no slip
        of = f" of {by} {_value(data, (key[0], str(by)))}" if by else ""
        return (
            key,
            f"unknown key{of}{nearest(str(key[-1]), siblings, elsewhere)}, allowed:"
            f" {', '.join(siblings)}",
        )
    if kind.startswith("union_tag") and outer:
        key = (*key, str(by))
        choices = [
            name for model in _models(outer) for name in _choices(model.model_fields[str(by)])
        ]
        words = _either(choices)
    else:
        field = _field(root, key, data)
        choices, words = _choices(field), allowed(field)
    value = _value(data, key)
    if kind in ("missing", "union_tag_not_found") and value is None:
        return key, f"missing, allowed: {words}"
    return (
        key,
        f"got {shown(value)}, allowed:"
        f" {words}{nearest(value, choices) if isinstance(value, str) else ''}",
    )


def _is_unicode(text: Any) -> bool:
    """Tell whether a value is text that UTF-8 can write: no half of a pair of surrogates."""
    try:
        str(text).encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def place(key: Key, places: Mapping[Key, str]) -> str:
    """Return file and line (or --set) of a key.

    Without a place of its own the key has the place of the nearest section around it.
    """
    return next(places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places)


def nearest(got: str, *families: Sequence[str] | Mapping[str, Any]) -> str:
    """Write ", nearest: name" with the known name that is like a misspelt name.

    The first family of names with a similar name decides; without any the text is empty.

    Names are compared by their last part, or as a whole when the section is misspelt as well. The
    unit may be missing.
    """
    if not isinstance(got, str) or len(got) > _LONGEST_SLIP:  # Python gives other keys as well
        return ""

    def norm(name: str) -> str:
        return name.lower().replace("-", "_").replace(" ", "_")

    def alike(name: str) -> float:
        whole, its_whole = norm(got), norm(name)
        (section, _, last), (its_section, _, its_last) = (
            whole.rpartition("."),
            its_whole.rpartition("."),
        )
        if its_last.startswith(f"{last}_"):
            return 0.95
        pairs = (
            [(last, its_last)] if section == its_section else [(last, its_last), (whole, its_whole)]
        )
        return max(difflib.SequenceMatcher(None, *pair).ratio() for pair in pairs)

    for names in families:
        best = max(names, key=alike, default="")
        if best and alike(best) >= 0.6:
            return f", nearest: {best}"
    return ""


# ---- values


def is_number(value: Any) -> bool:
    """Tell whether a value is a finite number; true and false are no numbers."""
    return isinstance(value, int | float) and not isinstance(value, bool) and -1e300 < value < 1e300


def plain_number(value: float) -> str:
    """Write a number without a needless decimal point."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def shown(value: Any) -> str:
    """Write a value nearly as the user did.

    Text stands in quotes, so that "20" is recognized as text.
    """
    if value is None:
        return "nothing"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' * (value < 0)}.inf"
    # The beginning of a long value is enough: a million items need not be written to show sixty
    # letters.
    value = value[:60] if isinstance(value, str | list | tuple) else value
    try:
        return cut(json.dumps(value, ensure_ascii=False, default=str))
    except (TypeError, ValueError, RecursionError):  # a very long number, an odd key, or itself
        return f"a value that cannot be written ({type(value).__name__})"


def cut(text: str) -> str:
    """Shorten a text to at most 60 letters."""
    return text if len(text) <= 60 else f"{text[:57]}..."


def first_line(error: BaseException) -> str:
    """Return the first line of the message of an error."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


# ---- keys


def dotted(key: Key) -> str:
    """Write ("rolling", "load_n") as "rolling.load_n", and places in a list in brackets."""
    return "".join(
        f"[{part}]" if isinstance(part, int) else f".{part}" for part in key
    ).removeprefix(".")


@cache  # a sweep asks once per run
def numeric_keys(root: type[BaseModel]) -> Mapping[str, FieldInfo]:
    """Map every dotted key that holds a number to its field."""
    return {
        name: field for name, field in _inner(root) if {int, float} & set(_kinds(field.annotation))
    }


@cache
def text_keys(root: type[BaseModel]) -> Mapping[str, FieldInfo]:
    """Map every dotted key that holds no number to its field."""
    numeric = numeric_keys(root)
    return {name: field for name, field in _inner(root) if name not in numeric}


@cache
def section_keys(root: type[BaseModel]) -> Mapping[str, FieldInfo]:
    """Map every section to its field."""
    return {name: field for name, field in root.model_fields.items() if _models(field)}


def all_keys(root: type[BaseModel]) -> list[str]:
    """List every name that an override can set, including sections and swept keys."""
    inner = [name for name, _ in _inner(root)]
    swept = [*numeric_keys(root), *text_keys(root), *section_keys(root), "zip"]
    return list(dict.fromkeys([*root.model_fields, *inner, *(f"sweep.{key}" for key in swept)]))


def required(model: type[BaseModel]) -> list[str]:
    """List the keys that must be given."""
    return [name for name, field in model.model_fields.items() if field.is_required()]


def allowed(field: FieldInfo) -> str:
    """Write the allowed values of a field in words."""
    for words in field.metadata:
        if isinstance(words, Words):
            return words.allowed
    if choices := _choices(field):
        return _either(choices)
    if field.discriminator:
        return f"a section of keys ({field.discriminator}, ...)"
    for model in _models(field):
        return f"a section of keys ({', '.join(required(model) or model.model_fields)})"
    kind = _kinds(field.annotation)[0]
    if kind in (int, float):
        signs = [("gt", ">"), ("ge", ">="), ("lt", "<"), ("le", "<=")]
        bounds = [
            f"{sign} {getattr(m, name):g}"
            for name, sign in signs
            for m in field.metadata
            if hasattr(m, name)
        ]
        return " ".join(
            ["a whole number" if kind is int else "a number", " and ".join(bounds)]
        ).strip()
    return "true or false" if kind is bool else "text"


def _inner(root: type[BaseModel]) -> Iterator[tuple[str, FieldInfo]]:
    """Yield every dotted name with its field.

    A name that several kinds of a section share occurs once per kind.
    """
    for section, outer in root.model_fields.items():
        for model in _models(outer):
            yield from ((f"{section}.{name}", field) for name, field in model.model_fields.items())


def _field(root: type[BaseModel], key: Key, data: Mapping[str, Any]) -> FieldInfo:
    """Return the field of a key, or the innermost field around it."""
    field = root.model_fields[str(key[0])]
    model = _model(field, data.get(str(key[0])))
    return model.model_fields.get(str(key[1]), field) if model and len(key) > 1 else field


def _siblings(root: type[BaseModel], key: Key, data: Mapping[str, Any]) -> list[str]:
    """List the names that are known where a key stands."""
    model = _model(root.model_fields[str(key[0])], data.get(str(key[0]))) if len(key) > 1 else root
    return list(model.model_fields) if model else []


def _model(field: FieldInfo, section: Any) -> type[BaseModel] | None:
    """Return the model of a section, None for a plain value.

    The first model is returned when the kind is unknown.
    """
    models = _models(field)
    for model in (
        models if isinstance(field.discriminator, str) and isinstance(section, Mapping) else []
    ):
        if section.get(field.discriminator) in _choices(
            model.model_fields[str(field.discriminator)]
        ):
            return model
    return next(iter(models), None)


def _models(field: FieldInfo) -> list[type[BaseModel]]:
    """List the models of a section, one for each of its kinds.

    The list is empty for a plain value.
    """
    return [
        kind
        for kind in _kinds(field.annotation)
        if isinstance(kind, type) and issubclass(kind, BaseModel)
    ]


def _kinds(annotation: Any) -> tuple[Any, ...]:
    """Return the types of an annotation without None and Annotated."""
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return tuple(
            kind for part in get_args(annotation) for kind in _kinds(part) if kind is not type(None)
        )
    return (annotation,)


def _choices(field: FieldInfo) -> list[str]:
    """List the names that a field chooses from.

    The list is empty for a field of another type.
    """
    return [
        choice
        for kind in _kinds(field.annotation)
        if get_origin(kind) is Literal
        for choice in get_args(kind)
    ]


def _either(choices: Sequence[str]) -> str:
    """Join names as in "a, b or c"."""
    return " or ".join(filter(None, [", ".join(choices[:-1]), choices[-1]]))


def _value(data: Any, key: Key) -> Any:
    for part in key:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data
