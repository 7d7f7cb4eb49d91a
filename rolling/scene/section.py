"""Base of all sections of a scene: frozen models whose faults are scene errors."""

from __future__ import annotations

import inspect
import math
import os
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self, dataclass_transform

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ValidationError,
    field_validator,
    model_validator,
)

from acoustics.numbers import rounded
from rolling.scene import named
from rolling.scene.messages import SceneError, cut, dotted, explained, fault, shown, writable

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

MAX_FAULTS = 100  # maximum number of faults that are named
# Minimum magnitude of a number other than zero, in the units of the scene; its inverse is the
# maximum.
_SMALLEST = 1e-15
_MAX_BITS = 1000  # maximum length of a whole number: pydantic fails to show much longer ones
_MAX_DEPTH = 16  # maximum nesting of values typed in Python


def plain(value: Any, depth: int = 0) -> Any:
    """Turn a value typed in Python into the plain value of a scene file, without keys of None."""
    if depth > _MAX_DEPTH:
        raise SceneError([f"scene: values are nested more than {_MAX_DEPTH} times"])
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        return {
            writable(name) if isinstance(name, str) else name: plain(item, depth + 1)
            for name, item in value.items()
            if item is not None
        }
    if isinstance(value, list | tuple):
        return [plain(item, depth + 1) for item in value]
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return math.inf if value > 0 else -math.inf
    value = os.fspath(value) if isinstance(value, os.PathLike) else value
    return writable(value) if isinstance(value, str) else value


@dataclass_transform(kw_only_default=True, field_specifiers=(Field,))
class _SceneErrors(ModelMetaclass):
    """Metaclass of models that raise SceneError instead of the errors of pydantic."""

    def __call__(cls, *positional: Any, **values: Any) -> Any:
        if positional:
            name = cls.__name__
            raise TypeError(f"{name} takes keys by name only, as in {name}(key=value)")
        return cls.from_values(plain(values))  # type: ignore[attr-defined]


class Section(BaseModel, metaclass=_SceneErrors):
    """Section of a scene, frozen and strict: text is no number, and unknown keys are faults."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    SECTION: ClassVar[str] = ""  # its name in a scene; by default that of the class
    IN_FILES: ClassVar[str] = ""  # key that scene files must give, and that has a default in Python
    NAMED: ClassVar[str] = ""  # section of `named.NAMES` whose name gives values

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
    def __get_pydantic_json_schema__(cls, core: Any, handler: GetJsonSchemaHandler) -> Any:
        """Describe the model by its first sentence, and each key by its text."""
        reference = handler(core)
        schema = handler.resolve_ref_schema(reference)
        schema["description"] = inspect.cleandoc(cls.__doc__ or "").partition("\n\n")[0]
        for name, text in cls.descriptions().items():
            schema["properties"][name]["description"] = text
        if cls.IN_FILES:
            schema["properties"][cls.IN_FILES].pop("default", None)
            schema["required"] = [cls.IN_FILES, *schema.get("required", [])]
        by_name = named.NAMES.get(cls.NAMED)
        if by_name and cls.NAMED != "sphere":  # whose named keys are optional anyway
            given = [key for key in schema["required"] if key in (*by_name.gives, "kind")]
            schema["required"] = [key for key in schema["required"] if key not in given]
            schema["anyOf"] = [{"required": [by_name.key]}, {"required": given}]
        return reference

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Self:
        """Validate plain values; raise SceneError with all faults, by their keys in a scene."""
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            section, faults = cls.SECTION or cls.__name__.lower(), []
            for listed in error.errors(include_url=False)[:MAX_FAULTS]:
                key, message = explained(listed, values, cls)
                key = key if key[:1] == (section,) else (section, *key)
                faults.append(f"scene: {cut(dotted(key))}: {message}")
            raise SceneError(faults) from error

    @model_validator(mode="before")
    @classmethod
    def _of_name(cls, values: Any) -> Any:
        return named.validated(cls.NAMED, values) if cls.NAMED else values

    @field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Refuse sizes whose powers and quotients overflow or underflow."""
        for number in np.ravel(value) if isinstance(value, float | tuple) else ():
            if number and not _SMALLEST <= abs(number) <= 1 / _SMALLEST:
                sizes = f"a size from {rounded(_SMALLEST)} to {rounded(1 / _SMALLEST)}"
                raise fault(f"got {shown(float(number))}, allowed: {sizes}")
        return value
