"""The model of a section, the keys that sections know, and the mistakes of pydantic by their keys.

Sections are built in Python as `Sphere(radius_mm=5)`; a value that is not allowed then raises
SceneError with the same message as in a scene file. `root` is the model of a whole scene or of one
section.
"""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import (
    Annotated,
    Any,
    ClassVar,
    NamedTuple,
    Union,
    get_args,
    get_origin,
)

import numpy as np
import pydantic
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator
from pydantic.fields import FieldInfo

from acoustics.numbers import rounded
from rolling.scene import library
from rolling.scene.messages import (
    MATERIALS,
    MAX_MISTAKES,
    TABLES,
    Key,
    Mistake,
    SceneError,
    dotted,
    first_mistakes,
    implausible,
    is_number,
    mistake,
    nearest,
    nearest_name,
    plain_values,
    quoted,
    shortened,
)

# Minimum magnitude of a number other than zero, in the units of the scene; its inverse is the
# maximum.
_SMALLEST = 1e-15
_MAX_SHOWN = 5  # values of a list in an example


class Section(BaseModel):
    """Section of a scene, frozen and strict: text is no number, and unknown keys are mistakes."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    SECTION: ClassVar[str] = ""  # its name in a scene; by default that of the class
    IN_FILES: ClassVar[str] = ""  # key that scene files must give, and that has a default in Python
    NAMED: ClassVar[str] = ""  # section of `library.NAMES` whose name gives values

    def __init__(self, *by_name_only: Any, **values: Any) -> None:
        """Take values that are given in Python; raise SceneError with all their mistakes by key."""
        if by_name_only:
            name = type(self).__name__
            raise TypeError(f"{name} takes keys by name only, as in {name}(key=value)")
        self._fill_from(plain_values(values))

    # Pydantic makes the sections inside of a scene itself, not by this method, and so collects all
    # of their mistakes.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def _fill_from(self, values: Mapping[str, Any]) -> None:
        """Take plain values; raise SceneError with all their mistakes by key."""
        judged = fill(self, values)
        if not judged.mistakes:
            return
        section = self.SECTION or type(self).__name__.lower()
        lines = []
        for entry in judged.mistakes:
            name = dotted(entry.key)
            if not name.startswith((f"{section}.", f"{section}[")):
                name = f"{section}.{name}".removesuffix(".")
            lines.append(f"scene: {shortened(name)}: {entry.message}")
        raise SceneError(first_mistakes(lines, "scene", judged.more))

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change, because a scene may have been judged and shared already."""
        if not name.startswith("_"):
            raise AttributeError(
                f"{name}: a scene does not change; scene.with_({name}=...) returns a changed copy"
            )
        super().__setattr__(name, value)

    @classmethod
    def descriptions(cls) -> dict[str, str]:
        """Return the text of each key from the attributes in the documentation of the model."""
        texts: dict[str, str] = {}
        for model in reversed(cls.__mro__):
            doc = inspect.cleandoc(model.__doc__ or "").partition("Attributes\n----------\n")[2]
            listed = re.findall(r"^(\w+) : .*\n((?:    .*\n?)+)", doc, re.MULTILINE)
            texts |= {name: " ".join(text.split()) for name, text in listed}
        return {name: text for name, text in texts.items() if name in cls.model_fields}

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: pydantic.GetJsonSchemaHandler) -> Any:
        """Describe the model by its first sentence, and each key by its text."""
        reference = handler(core)
        schema = handler.resolve_ref_schema(reference)
        schema["description"] = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")[0]
        for name, text in cls.descriptions().items():
            schema["properties"][name]["description"] = text
        if cls.IN_FILES:
            schema["properties"][cls.IN_FILES].pop("default", None)
            schema["required"] = [cls.IN_FILES, *schema.get("required", [])]
        for by_name in library.NAMES.get(cls.NAMED, ()):
            given = [key for key in schema["required"] if key in (*by_name.gives, "kind")]
            schema["required"] = [key for key in schema["required"] if key not in given]
            if given and not by_name.default:  # the keys of a sphere are optional anyway
                schema["anyOf"] = [{"required": [by_name.key]}, {"required": given}]
        return reference

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, values: Any) -> Any:
        """Leave out known keys without a value, and fill in the values that a name gives."""
        if isinstance(values, Mapping):
            values = {
                key: value
                for key, value in values.items()
                if value is not None or key not in cls.model_fields
            }
        return library.fill_in(cls.NAMED, values) if cls.NAMED else values

    @pydantic.field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Refuse sizes whose powers and quotients overflow or underflow."""
        if not isinstance(value, float | tuple):
            return value
        for number in np.ravel(value):
            if number and not _SMALLEST <= abs(number) <= 1 / _SMALLEST:
                sizes = f"a size from {rounded(_SMALLEST)} to {rounded(1 / _SMALLEST)}"
                raise mistake(f"got {quoted(float(number))}, allowed: {sizes}")
        return value


# ---- names of keys


@cache
def keys(root: type[BaseModel]) -> dict[str, FieldInfo]:
    """Map every dotted key inside the sections to its field, keys of inner sections last."""
    fields: dict[str, FieldInfo] = {}
    inner = _inside(root.model_fields)
    while inner:
        fields |= inner
        inner = _inside(inner)
    return fields


def _inside(fields: Mapping[str, FieldInfo]) -> dict[str, FieldInfo]:
    """Map the dotted keys inside the sections among some fields to their fields."""
    return {
        f"{section}.{name}": field
        for section, outer in fields.items()
        for model in _models(outer)
        for name, field in model.model_fields.items()
    }


@cache
def section_keys(root: type[BaseModel]) -> dict[str, FieldInfo]:
    """Map every section to its field."""
    fields = {**root.model_fields, **keys(root)}
    return {name: field for name, field in fields.items() if any(_models(field))}


@cache
def sweepable_keys(root: type[BaseModel]) -> list[str]:
    """List every key and section that a sweep may vary."""
    return list(dict.fromkeys((*keys(root), *section_keys(root))))


@cache
def all_keys(root: type[BaseModel]) -> list[str]:
    """List every name that an override can set, including sections and swept keys."""
    swept = [f"sweep.{key}" for key in sweepable_keys(root)]
    return [*root.model_fields, *keys(root), *swept]


def full_key(name: str, root: type[BaseModel]) -> str:
    """Return the dotted key for a bare or dotted name; raise SceneError if none or several fit."""
    if not isinstance(name, str):
        raise SceneError([f"scene: {quoted(name)}: a key is a text, such as rolling.load_n"])
    if name in all_keys(root):
        return name
    fitting = _keys_that_end_in(name, root)
    if len(fitting) == 1:
        return fitting[0]
    raise SceneError([f"scene: {name}: {unknown_name(name, root)}"])


def unknown_name(name: str, root: type[BaseModel]) -> str:
    """Write that a name is unknown or ambiguous, with the nearest names or those it stands for."""
    fitting = _keys_that_end_in(name, root)
    if len(fitting) > 1:
        return f"stands for {' or '.join(fitting)}, give one of these"
    known = all_keys(root)
    section = name.rpartition(".")[0]
    siblings = [key for key in known if section and key.rpartition(".")[0] == section != "sweep"]
    if not siblings:
        return f"unknown key{nearest(name, known)}"
    allowed = ", ".join(key.rpartition(".")[2] for key in siblings)
    return f"unknown key{nearest(name, siblings)}, allowed: {allowed}"


def _keys_that_end_in(name: str, root: type[BaseModel]) -> list[str]:
    """Return the dotted keys that end in a bare name; keys of outer sections win."""
    fitting = [key for key in keys(root) if key.rpartition(".")[2] == name]
    return [key for key in fitting if key.count(".") == fitting[0].count(".")]


# ---- all mistakes of plain values


class Judged(NamedTuple):
    """Mistakes of plain values.

    mistakes : list of Mistake. Mistakes that do not follow from one another.
    more : int. Number of mistakes that are not listed.
    rest : mapping. Plain values without the faulty ones.
    causes : list of Key. Keys whose values are missing because of a mistake.
    is_filled : bool. Whether the model has the values.
    """

    mistakes: list[Mistake]
    more: int
    rest: Mapping[str, Any]
    causes: list[Key]
    is_filled: bool


def fill(model: BaseModel, values: Mapping[str, Any], known: Sequence[Mistake] = ()) -> Judged:
    """Validate plain values into a model that has none yet, and return all mistakes of the values.

    Pydantic judges a rule only where the values that it joins are valid. So rules are judged again
    without the faulty values. `known` are mistakes of the text, whose values are missing. The model
    has its values only where these make it without a mistake.
    """
    root = type(model)
    causes = missing_by(known, values)
    try:
        root.__pydantic_validator__.validate_python(values, self_instance=model)
        return Judged([], 0, values, causes, is_filled=True)
    except ValidationError as error:
        first, more = mistakes_of(error, values, root)
    # What the values lack by their text or by misspelt keys, no rule may call missing.
    misspelt = [entry for entry in first if entry.meant]
    rest = values
    for entry in independent(first, [*causes, *missing_by(misspelt, values)]):
        rest = _without(rest, entry.key, root)
    further: list[Mistake] = []
    if not more:
        further, more = _mistakes_of_rest(rest, root)
    # A section of a wrong kind has its misspelt keys among the further mistakes.
    misspelt += [entry for entry in further if entry.meant]
    causes += missing_by(misspelt, values)
    mistakes = independent(first, causes)
    causes += [entry.key for entry in mistakes]
    mistakes += independent(further, [*causes, *missing_by(mistakes, rest)])
    causes += [entry.key for entry in mistakes]
    return Judged(mistakes, more, rest, causes, is_filled=False)


def _mistakes_of_rest(rest: Mapping[str, Any], root: type[BaseModel]) -> Listed:
    """Return the mistakes of values without those that are known to be faulty."""
    try:
        root.model_validate(rest)
    except ValidationError as error:
        return mistakes_of(error, rest, root)
    return Listed([], 0)


def missing_by(mistakes: Sequence[Mistake], values: Mapping[str, Any]) -> list[Key]:
    """Return the keys that have no value because of mistakes: meant ones, those of faulty names.

    A faulty material or finish does not give its values.
    """
    keys: list[Key] = []
    for entry in mistakes:
        key = entry.meant or entry.key
        keys.append(key)
        for by_name in library.NAMES.get(str(key[0]), ()) if key else ():
            if key[1:] == (by_name.key,):
                keys += [(key[0], given) for given in by_name.gives]
    return [key for key in keys if key and _value_at(values, key) is None]


def independent(mistakes: Sequence[Mistake], causes: Sequence[Key]) -> list[Mistake]:
    """Return the mistakes that are not at, in or around a cause, and whose rule needs none."""

    def follows(key: Key) -> bool:
        return any(key[: len(cause)] == cause[: len(key)] for cause in causes)

    return [entry for entry in mistakes if not any(map(follows, [entry.key, *entry.needs]))]


def _without(values: Any, key: Key, root: type[BaseModel]) -> Any:
    """Return plain values without a faulty one, or with a kind in place of a wrong or missing one.

    A list goes as a whole, so that the places in it stay those of the scene.
    """
    while key and isinstance(key[-1], int):
        key = key[:-1]
    field = locate(key[:-1], root).field
    if field is not None and field.discriminator and key[-1] == field.discriminator:
        return _changed(values, key, _likely_kind(_value_at(values, key[:-1]), field))
    return _changed(values, key, None)


def _likely_kind(section: Any, field: FieldInfo) -> Any:
    """Return the kind of a section that its own is nearest to, or that knows most of its keys."""
    given = section if isinstance(section, Mapping) else {}
    kinds = {_kind_of(model, field): model for model in _models(field)}
    near = nearest_name(str(given.get(str(field.discriminator), "")), [*kinds])
    return near or max(kinds, key=lambda kind: len({*given} & {*kinds[kind].model_fields}))


def _changed(values: Any, key: Key, other: Any) -> Any:
    """Return plain values with another value at a key, or without the key for None.

    Values without such a place are returned themselves.
    """
    if not key:
        return values
    name = key[0]
    if isinstance(values, list) and isinstance(name, int) and name < len(values):
        inner = _changed(values[name], key[1:], other)
        return values if inner is values[name] else [*values[:name], inner, *values[name + 1 :]]
    if not isinstance(values, Mapping):
        return values
    if len(key) > 1 and name in values:
        inner = _changed(values[name], key[1:], other)
        return values if inner is values[name] else {**values, name: inner}
    if len(key) == 1 and other is not None and values.get(name) != other:
        return {**values, name: other}
    if len(key) == 1 and name in values:
        return {known: value for known, value in values.items() if known != name}
    return values


# ---- mistakes by their keys


class Listed(NamedTuple):
    """First mistakes of plain values, and how many more there are."""

    mistakes: list[Mistake]
    more: int


def mistakes_of(error: ValidationError, data: Mapping[str, Any], root: type[BaseModel]) -> Listed:
    """Return the first mistakes that pydantic found, in the words of a scene, and how many more."""
    listed = error.errors(include_url=False)
    mistakes: list[Mistake] = []
    for number, single in enumerate(listed):
        if len(mistakes) >= MAX_MISTAKES:
            return Listed(mistakes, len(listed) - number)
        key = locate(single["loc"], root).key
        if single["type"] == "mistakes":
            mistakes += [_mistake_of_rule(rule, key) for rule in single["ctx"]["mistakes"]]
        elif single["type"] == "mistake":
            mistakes.append(_with_sweep(_mistake_of_rule(single["ctx"], key), data, root))
        else:
            mistakes.append(_with_sweep(_mistake_of(single, data, root), data, root))
    return Listed(mistakes, 0)


def _mistake_of_rule(context: Mapping[str, Any], key: Key) -> Mistake:
    """Return the mistake that a rule raised where pydantic validated a key."""
    needs = tuple(_absolute(needed, key) for needed in context["needs"])
    return Mistake(_absolute(context["at"], key), context["message"], needs=needs)


def _mistake_of(error: Any, data: Mapping[str, Any], root: type[BaseModel]) -> Mistake:
    """Return key and message of a single mistake of pydantic."""
    kind = error["type"]
    context = error.get("ctx", {})
    located = locate(error["loc"], root)
    key = located.key
    if kind.startswith("union_tag"):
        return _mistake_of_kind(located, data)
    if kind == "missing":
        text = ""
        if located.model is not None:
            text = located.model.descriptions().get(str(key[-1]), "")  # type: ignore[attr-defined]
        return Mistake(key, f"missing; {text}" if text else "missing")
    if kind == "extra_forbidden":
        return _unknown_key(located, data, root)
    value = error["input"]
    if kind in ("greater_than_equal", "less_than_equal") and key[-1] in MATERIALS:
        return Mistake(key, implausible(value, MATERIALS[str(key[-1])]))
    words = re.sub(r"^\w+ should (be )?|'", "", error["msg"])
    message = f"got {quoted(value)}, allowed: {TABLES['kinds'].get(kind, words)}"
    choices = re.findall(r"'([^']*)'", context.get("expected", ""))
    if choices and isinstance(value, str):
        message += nearest(value, choices)
    return Mistake(key, message)


def _absolute(at: Key, key: Key) -> Key:
    """Return the key of a mistake, which may be the validated key or a key of its section."""
    if not at:
        return key
    return (*key, *at[1:]) if at[0] == "" else at


def _with_sweep(entry: Mistake, data: Mapping[str, Any], root: type[BaseModel]) -> Mistake:
    """Return the mistake of a list where one value is allowed with the way to sweep its values."""
    name = dotted(entry.key)
    listed = _value_at(data, entry.key)
    is_list = isinstance(listed, list | tuple) and len(listed) > 0
    if not is_list or "sweep" not in root.model_fields or name not in keys(root):
        return entry
    if "[" in entry.message.partition("allowed: ")[2]:  # lists of another form are allowed
        return entry
    if not all(is_number(value) or isinstance(value, str) for value in listed):
        return entry
    values = ", ".join(str(value)[:20] for value in listed[:_MAX_SHOWN])
    if len(listed) > _MAX_SHOWN:
        values += ", ..."
    advice = f"a sweep tries several, as in `sweep: {{{name}: [{values}]}}`"
    return entry._replace(message=f"{entry.message}; {advice}")


class Located(NamedTuple):
    """A place of a scene: its key, its field with the model around it, and the outer field."""

    key: Key
    model: type[BaseModel] | None
    field: FieldInfo | None
    outer: FieldInfo | None


def locate(place: Key, root: type[BaseModel]) -> Located:
    """Find the model of a place, without the kinds of sections that pydantic names in it."""
    located = Located((), None, None, None)
    inner = root if place else None
    parts = iter(place)
    for part in parts:
        if isinstance(part, int):  # a place in a list of sections
            located = located._replace(key=(*located.key, part))
            inner = next(_listed_models(located.field), None) if located.field else None
            continue
        field = inner.model_fields.get(str(part)) if inner else None
        located = Located((*located.key, part), inner, field, located.field)
        models = list(_models(field)) if field else []
        if field and field.discriminator:
            kind = next(parts, None)
            models = [model for model in models if kind in (None, _kind_of(model, field))]
        inner = models[0] if models else None
    return located


def _mistake_of_kind(located: Located, data: Mapping[str, Any]) -> Mistake:
    """Return the mistake of a section whose kind is missing or unknown."""
    field = located.field
    assert field is not None  # as a section of several kinds has a field
    key = (*located.key, str(field.discriminator))
    choices = [_kind_of(model, field) for model in _models(field)]
    value = _value_at(data, key)
    if value is None:
        return Mistake(key, f"missing, allowed: {', '.join(choices)}")
    message = f"got {quoted(value)}, allowed: {', '.join(choices)}"
    if isinstance(value, str):
        message += nearest(value, choices)
    return Mistake(key, message)


def _unknown_key(located: Located, data: Mapping[str, Any], root: type[BaseModel]) -> Mistake:
    """Return the mistake of a key that a section lacks, with the nearest and all its keys."""
    key = located.key
    name = str(key[-1])
    siblings = list(located.model.model_fields) if located.model else []
    of_kind = ""
    if located.outer and located.outer.discriminator:
        kind = _value_at(data, (*key[:-1], str(located.outer.discriminator)))
        of_kind = f" of kind {kind}"
    elsewhere = [*root.model_fields, *keys(root)]
    if dotted(key) in keys(root):  # a key of another kind of the section is no slip
        elsewhere = []
    like = nearest(name, siblings, elsewhere)
    if name.isdecimal():
        like += "; a decimal point stands in place of a comma"
    message = f"unknown key{of_kind}{like}, allowed: {', '.join(siblings)}"
    near = nearest_name(name, siblings)
    return Mistake(key, message, meant=(*key[:-1], near) if near else ())


# ---- annotations of fields


def _kind_of(model: type[BaseModel], field: FieldInfo) -> Any:
    """Return the kind by which a field distinguishes a model."""
    return model.model_fields[str(field.discriminator)].default


def _models(field: FieldInfo) -> Iterator[type[BaseModel]]:
    """Yield the models of a section, one for each of its kinds, and none for a plain value."""
    for kind in _types(field.annotation):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield kind


def _listed_models(field: FieldInfo) -> Iterator[type[BaseModel]]:
    """Yield the models of a list of sections."""
    for kind in _types(field.annotation):
        if get_origin(kind) is list and issubclass(get_args(kind)[0], BaseModel):
            yield get_args(kind)[0]


def _types(annotation: Any) -> tuple[Any, ...]:
    """Return the types of an annotation without None."""
    if get_origin(annotation) is Annotated:
        return _types(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        parts = [part for part in get_args(annotation) if part is not type(None)]
        return tuple(kind for part in parts for kind in _types(part))
    return (annotation,)


def _value_at(data: Any, key: Key) -> Any:
    """Return the plain value at a key, None where there is none."""
    for part in key:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data
