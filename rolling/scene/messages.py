"""Faults of a scene in words: known keys, allowed values, and nearest names.

`root` is the model of a whole scene or of one section. A scene has sections of plain values and a
sweep; the surface has several kinds.
"""

import difflib
import json
import math
import os
import re
import tomllib
import types
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from acoustics.numbers import rounded
from acoustics.texts import printable

# place of a value: ("rolling", "load_n"), ("sweep", "rolling.load_n", 0)
Key = tuple[str | int, ...]

_LONGEST = 60  # letters of a value in a message


def table(package: str, name: str) -> dict[str, Any]:
    """Read the table NAME.toml of texts or numbers beside the modules of a package."""
    return tomllib.loads(files(package).joinpath(f"{name}.toml").read_text(encoding="utf-8"))


TABLES = table("rolling.scene", "tables")


class Plausible(NamedTuple):
    """Sizes that a property of a material has, and units that are taken for its own by a slip."""

    least: float
    most: float
    words: str
    slips: Mapping[str, float]  # size of each unit in the unit of the key


MATERIALS = {key: Plausible(**sizes) for key, sizes in TABLES["materials"].items()}


class SceneError(Exception):
    """Faults of a scene.

    Attributes
    ----------
    faults : list of str
        One line for each fault: file and line (or --set, or scene), key, the value and the allowed
        values.

    Examples
    --------
    >>> import rolling
    >>> rolling.read_scene("quickstart", ["rolling.load_n=-5"])
    Traceback (most recent call last):
    rolling.scene.messages.SceneError: --set: rolling.load_n: got -5, allowed: ...
    """

    def __init__(self, faults: Sequence[str]) -> None:
        self.faults = [printable(writable(fault)) for fault in faults]
        super().__init__("\n".join(self.faults))

    def __reduce__(self) -> tuple[Any, ...]:
        return SceneError, (self.faults,)


# ---- faults


def fault(message: str, at: str | Key = ()) -> PydanticCustomError:
    """Make a fault for pydantic to collect, at the validated key or at another key of the scene."""
    key = key_of(at) if isinstance(at, str) else at
    return PydanticCustomError("fault", "{message}", {"message": writable(message), "at": key})


def explained(error: Any, data: Mapping[str, Any], root: type[BaseModel]) -> tuple[Key, str]:
    """Return key and message of a pydantic fault of plain values."""
    kind, value = error["type"], error["input"]
    context, words = error.get("ctx", {}), re.sub(r"^\w+ should (be )?|'", "", error["msg"])
    if kind == "fault":
        return context["at"] or _held(error["loc"], root).key, context["message"]
    key, model, field, outer = _held(error["loc"], root)
    choices = re.findall(r"'([^']*)'", context.get("expected", ""))
    if field and kind.startswith("union_tag"):
        by = str(field.discriminator)
        key = (*key, by)
        value = _value(data, key)
        choices = [_default(kinds, by) for kinds in _models(field)]
        words = ", ".join(choices)
        if value is None:
            return key, f"missing, allowed: {words}"
    siblings = list(model.model_fields) if model else []
    if kind == "missing":
        text = model.descriptions().get(str(key[-1]), "") if model else ""  # type: ignore[attr-defined]
        return key, f"missing{f'; {text}' * bool(text)}"
    if kind == "extra_forbidden":
        # A key of another kind of the section is no slip.
        elsewhere = [] if dotted(key) in keys(root) else [*root.model_fields, *keys(root)]
        kind_of = outer.discriminator if outer else None
        of = f" of kind {_value(data, (*key[:-1], str(kind_of)))}" if kind_of else ""
        comma = "; a decimal point stands in place of a comma" * str(key[-1]).isdecimal()
        like = nearest(str(key[-1]), siblings, elsewhere) + comma
        return key, f"unknown key{of}{like}, allowed: {', '.join(siblings)}"
    if kind in ("greater_than_equal", "less_than_equal") and key[-1] in MATERIALS:
        return key, implausible(value, MATERIALS[str(key[-1])])
    like = nearest(value, choices) if isinstance(value, str) else ""
    return key, f"got {shown(value)}, allowed: {TABLES['kinds'].get(kind, words)}{like}"


def implausible(value: float, sizes: Plausible) -> str:
    """Write that no material has a size, and the size that was meant if it is a slip of units."""
    meant = [
        f"{rounded(value * size, 4)} ({rounded(value, 6)} {unit})"
        for unit, size in sizes.slips.items()
        if sizes.least <= value * size <= sizes.most
    ]
    near = f"; nearest: {min(max(value, sizes.least), sizes.most):g}"
    return f"got {shown(value)}, allowed: {sizes.least:g} to {sizes.most:g} {sizes.words}" + (
        f"; did you mean {' or '.join(meant)}?" if meant else near
    )


def unknown_name(name: str, root: type[BaseModel]) -> str:
    """Write that a name is unknown or ambiguous, with the nearest names or those it stands for."""
    if len(fitting := _fitting(name, root)) > 1:
        return f"stands for {' or '.join(fitting)}, give one of these"
    known = all_keys(root)
    section = name.rpartition(".")[0]
    siblings = [key for key in known if section and key.rpartition(".")[0] == section != "sweep"]
    listed = ", ".join(key.rpartition(".")[2] for key in siblings)
    return f"unknown key{nearest(name, siblings or known)}{f', allowed: {listed}' * bool(listed)}"


def place(key: Key, places: Mapping[Key, str]) -> str:
    """Return file and line (or --set) of a key, or of the nearest section around it."""
    return next(places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places)


def nearest(got: str, *families: Sequence[str]) -> str:
    """Write ", nearest: name" with a name of the first family that has one like a misspelt name.

    Names are compared by their last part, or as a whole where the section is unknown.
    """
    got = got.lower().replace("-", "_").replace(" ", "_")[: 2 * _LONGEST]
    section, _, last = got.rpartition(".")
    for names in families:
        if "diameter" in last and (radii := [name for name in names if "radius" in name]):
            return f", nearest: {radii[0]}, half of it"
        whole = section and not any(name.startswith(f"{section}.") for name in names)
        forms = {name if whole else name.rpartition(".")[2]: name for name in reversed(names)}
        if close := difflib.get_close_matches(got if whole else last, forms, 1):
            return f", nearest: {forms[close[0]]}"
    return ""


# ---- values


def is_number(value: Any) -> bool:
    """Tell whether a value is a finite number; true and false are no numbers."""
    return isinstance(value, int | float) and not isinstance(value, bool) and -1e300 < value < 1e300


def numbers(value: Any, count: int) -> tuple[float, ...] | None:
    """Return a list of so many numbers as a tuple, None for any other value."""
    if isinstance(value, list | tuple) and len(value) == count and all(map(is_number, value)):
        return tuple(map(float, value))
    return None


def plain_number(value: float) -> str:
    """Write a number without a needless decimal point."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def shown(value: Any) -> str:
    """Write a value nearly as the user did, with text in quotes."""
    if value is None:
        return "nothing"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' * (value < 0)}.inf"
    # The beginning of a long value is enough.
    value = value[:_LONGEST] if isinstance(value, str | list | tuple) else value
    try:
        return cut(json.dumps(value, ensure_ascii=False, default=str))
    except (TypeError, ValueError, RecursionError):  # a very long number, an odd key, or itself
        return f"a value that cannot be written ({type(value).__name__})"


def cut(text: str) -> str:
    """Shorten a text to at most 60 letters."""
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def writable(text: str) -> str:
    """Replace halves of pairs of surrogates, which UTF-8 cannot write."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def first_line(error: BaseException) -> str:
    """Return the first line of the message of an error."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


# ---- plain values


_MAX_BITS = 1000  # maximum length of a whole number: pydantic fails to show much longer ones
_MAX_DEPTH = 16  # maximum nesting of values typed in Python


def plain(value: Any, known: Collection[str] | None = None, depth: int = 0) -> Any:
    """Turn a value typed in Python into the plain value of a scene file, without keys of None.

    Where the `known` names of keys are given, other keys stay, to be refused.
    """
    if depth > _MAX_DEPTH:
        raise SceneError([f"scene: values are nested more than {_MAX_DEPTH} times"])
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        return {
            writable(name) if isinstance(name, str) else name: plain(item, known, depth + 1)
            for name, item in value.items()
            if item is not None or (known and str(name).rpartition(".")[2] not in known)
        }
    if isinstance(value, list | tuple):
        return [plain(item, known, depth + 1) for item in value]
    if hasattr(value, "tolist"):  # numbers and arrays of numpy, which is slow to import
        return value.tolist()
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return math.inf if value > 0 else -math.inf
    value = os.fspath(value) if isinstance(value, os.PathLike) else value
    return writable(value) if isinstance(value, str) else value


# ---- keys


def dotted(key: Key) -> str:
    """Write ("rolling", "load_n") as "rolling.load_n", and places in a list in brackets."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")


def key_of(name: str) -> Key:
    """Return the place of a dotted name; the keys of a sweep are dotted names themselves."""
    head, _, rest = name.partition(".")
    return ("sweep", rest) if head == "sweep" and rest else tuple(name.split("."))


@cache
def keys(root: type[BaseModel]) -> dict[str, FieldInfo]:
    """Map every dotted key inside the sections to its field, keys of inner sections last."""

    def inside(fields: Mapping[str, FieldInfo]) -> dict[str, FieldInfo]:
        return {
            f"{section}.{name}": field
            for section, outer in fields.items()
            for model in _models(outer)
            for name, field in model.model_fields.items()
        }

    listed = inside(root.model_fields)
    return listed | inside(listed)


@cache
def names(model: type[BaseModel]) -> frozenset[str]:
    """List the names of the keys of a model and of all sections inside."""
    fields = model.model_fields.values()
    inner = [part for field in fields for part in (*_models(field), *_listed(field))]
    return frozenset(model.model_fields).union(*map(names, inner))


@cache
def section_keys(root: type[BaseModel]) -> dict[str, FieldInfo]:
    """Map every section to its field."""
    fields = {**root.model_fields, **keys(root)}
    return {name: field for name, field in fields.items() if any(_models(field))}


@cache
def numeric_keys(root: type[BaseModel]) -> frozenset[str]:
    """List the dotted keys that hold a number."""
    kinds = {name: _kinds(field.annotation) for name, field in keys(root).items()}
    return frozenset(
        name for name, listed in kinds.items() if {int, float} & {*listed, *map(type, listed)}
    )


@cache
def words_for_numbers(root: type[BaseModel]) -> dict[str, tuple[str, ...]]:
    """Return the words that may stand for a number, by dotted key."""
    words = {
        name: tuple(word for word in _kinds(keys(root)[name].annotation) if isinstance(word, str))
        for name in sorted(numeric_keys(root))
    }
    return {name: listed for name, listed in words.items() if listed}


def full_key(name: str, root: type[BaseModel]) -> str:
    """Return the dotted key for a bare or dotted name; raise SceneError if none or several fit."""
    fitting = [name] if name in all_keys(root) else _fitting(name, root)
    if len(fitting) == 1:
        return fitting[0]
    raise SceneError([f"scene: {name}: {unknown_name(name, root)}"])


def _fitting(name: str, root: type[BaseModel]) -> list[str]:
    """Return the dotted keys that end in a bare name; keys of outer sections win."""
    fitting = [key for key in keys(root) if key.rpartition(".")[2] == name]
    return [key for key in fitting if key.count(".") == fitting[0].count(".")]


@cache
def all_keys(root: type[BaseModel]) -> list[str]:
    """List every name that an override can set, including sections and swept keys."""
    swept = [f"sweep.{key}" for key in dict.fromkeys((*keys(root), *section_keys(root)))]
    return [*root.model_fields, *keys(root), *swept]


class _Held(NamedTuple):
    """Place of a value, with the model that has its last part.

    It has the field of that part, and the field of the section around it.
    """

    key: Key
    model: type[BaseModel] | None
    field: FieldInfo | None
    outer: FieldInfo | None


def _held(place: Key, root: type[BaseModel]) -> _Held:
    """Find the model of a place, without the kinds of sections that pydantic names in it."""
    held, inner = _Held((), None, None, None), root if place else None
    parts = iter(place)
    for part in parts:
        field = inner.model_fields.get(str(part)) if inner and isinstance(part, str) else None
        if isinstance(part, int):  # a place in a list of sections
            held = held._replace(key=(*held.key, part))
            inner = next(_listed(held.field), None) if held.field else None
            continue
        held = _Held((*held.key, part), inner, field, held.field)
        models, by = list(_models(field)) if field else [], field and field.discriminator
        if by and (kind := next(parts, None)) is not None:
            models = [model for model in models if _default(model, str(by)) == kind]
        inner = models[0] if models else None
    return held


def _default(model: type[BaseModel], key: str) -> Any:
    return model.model_fields[key].default


def _models(field: FieldInfo) -> Iterator[type[BaseModel]]:
    """Yield the models of a section, one for each of its kinds, and none for a plain value."""
    for kind in _kinds(field.annotation):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield kind


def _listed(field: FieldInfo) -> Iterator[type[BaseModel]]:
    """Yield the models of a list of sections."""
    for kind in _kinds(field.annotation):
        if get_origin(kind) is list and issubclass(get_args(kind)[0], BaseModel):
            yield get_args(kind)[0]


def _kinds(annotation: Any) -> tuple[Any, ...]:
    """Return the types of an annotation and the choices of a Literal, without None."""
    if get_origin(annotation) is Literal:
        return get_args(annotation)
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        parts = [part for part in get_args(annotation) if part is not type(None)]
        return tuple(kind for part in parts for kind in _kinds(part))
    return (annotation,)


def _value(data: Any, key: Key) -> Any:
    """Return the plain value at a key, None where there is none."""
    for part in key:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data
