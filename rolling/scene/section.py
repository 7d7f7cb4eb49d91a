"""A section of a scene: a frozen, strict model with faults in words, also when built in Python."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Self, dataclass_transform

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from rolling.scene.messages import SceneError, cut, dotted, explained, fault, shown

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

# Minimum magnitude of a number other than zero, in the units of the scene; its inverse is the
# maximum.
SMALLEST = 1e-15
MAX_FAULTS = 100  # maximum number of faults that are named
_MAX_BITS = 1000  # maximum length of a whole number: pydantic fails to show much longer ones
_MAX_DEPTH = 16  # maximum nesting of values typed in Python


def plain(value: Any, depth: int = 0) -> Any:
    """Turn a value typed in Python into the plain value of a scene file.

    Keys without a value are dropped.

    Parameters
    ----------
    value : any
        The value.
    depth : int
        Number of mappings and lists around it. Default: 0.

    Raises
    ------
    SceneError
        The value is nested too deeply, for example in itself.
    """
    if depth > _MAX_DEPTH:
        raise SceneError([f"scene: values are nested more than {_MAX_DEPTH} times"])
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        return {name: plain(item, depth + 1) for name, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [plain(item, depth + 1) for item in value]
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return math.inf if value > 0 else -math.inf
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def required_in_files(key: str) -> Any:
    """Change the JSON Schema of a model so that scene files must give a key.

    In Python the key has a default.
    """

    def change(schema: dict[str, Any]) -> None:
        schema["properties"][key].pop("default", None)
        schema["required"] = [key, *schema.get("required", [])]

    return change


@dataclass_transform(kw_only_default=True, field_specifiers=(Field,))
class _SceneErrors(ModelMetaclass):
    """Metaclass of models that raise SceneError instead of the errors of pydantic."""

    def __call__(cls, *positional: Any, **values: Any) -> Any:
        if positional:
            raise TypeError(
                f"{cls.__name__} takes keys by name only, as in {cls.__name__}(key=value)"
            )
        return cls.from_values(plain(values))  # type: ignore[attr-defined]


class Section(BaseModel, metaclass=_SceneErrors):
    """Section of a scene, frozen and strict: text is no number, and unknown keys are faults."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    SECTION: ClassVar[str] = ""  # its name in a scene

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Self:
        """Validate plain values.

        Raises
        ------
        SceneError
            Some values are missing, unknown or not allowed; each fault names its key within a
            scene.
        """
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            faults = []
            for listed in error.errors(include_url=False)[:MAX_FAULTS]:
                key, message = explained(listed, values, cls)
                key = key if key[:1] == (cls.SECTION,) else (cls.SECTION, *key)
                faults.append(f"scene: {cut(dotted(key))}: {message}")
            raise SceneError(faults) from error

    @field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Refuse sizes whose powers and quotients overflow or underflow."""
        for number in np.ravel(value) if isinstance(value, float | tuple) else ():
            if number and not SMALLEST <= abs(number) <= 1 / SMALLEST:
                raise fault(
                    f"got {shown(float(number))}, allowed: a size from {SMALLEST:g} to"
                    f" {1 / SMALLEST:g}"
                )
        return value
