"""Public functions and classes that ignore underflow, whatever traps a caller has set.

Numbers that are too small for a double become zero or lose digits, which no result depends on.
`numpy.seterr(all="raise")` in the session of a caller would make errors of them. The doors stand
where a caller comes in: at the names of the package `acoustics` and the functions of its modules
`plots` and `wav`, at the functions and the objects that `rolling` hands out, and at the tasks of
processes. What they call stands behind them, and has none of its own.
"""

from collections.abc import Callable, Iterator
from functools import cached_property, wraps
from inspect import isfunction, isgeneratorfunction
from typing import Any, TypeVar

import numpy as np

_Public = TypeVar("_Public", bound=Callable[..., Any])


def ignoring_underflow(public: _Public) -> _Public:
    """Let a function, or all methods and properties of a class, ignore underflow.

    The setting of the caller comes back with each return. Traps of other errors stay as they are.
    """
    if isinstance(public, type):
        for name, member in list(vars(public).items()):
            shielded = _shielded_member(member)
            if shielded is not member:
                setattr(public, name, shielded)
                if isinstance(shielded, cached_property):
                    shielded.__set_name__(public, name)
        return public
    return _shielded(public)  # type: ignore[return-value]


def _shielded_member(member: Any) -> Any:
    """Return a member of a class that ignores underflow, or the member itself if it has no code."""
    if isfunction(member):
        return _shielded(member)
    if isinstance(member, property) and member.fget is not None:
        return property(_shielded(member.fget), member.fset, member.fdel, member.__doc__)
    if isinstance(member, cached_property):
        return cached_property(_shielded(member.func))
    if isinstance(member, classmethod | staticmethod):
        return type(member)(_shielded(member.__func__))
    return member


def _shielded(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that ignores underflow while it is at work."""
    if isgeneratorfunction(function):

        @wraps(function)
        def generate(*values: Any, **named: Any) -> Iterator[Any]:
            """Advance the generator, and have the setting of the caller between its values."""
            generator = function(*values, **named)
            try:
                while True:
                    with np.errstate(under="ignore"):
                        try:
                            value = next(generator)
                        except StopIteration:
                            return
                    yield value
            finally:
                generator.close()

        return generate

    @wraps(function)
    def call(*values: Any, **named: Any) -> Any:
        with np.errstate(under="ignore"):
            return function(*values, **named)

    return call
