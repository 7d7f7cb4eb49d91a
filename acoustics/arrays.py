"""The type of arrays of numbers, the check of values that users give, and short words for them."""

import math
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_LONGEST = 60  # letters of a value in words


def masked_count(values: Any) -> int:
    """Return the number of masked values in an array, or in a list of arrays or values."""
    if np.ma.isMaskedArray(values):
        return int(np.count_nonzero(np.ma.getmaskarray(values)))
    if isinstance(values, list | tuple):
        return sum(masked_count(part) for part in values if not isinstance(part, int | float))
    return 0


def refuse_masked(name: str, values: Any) -> None:
    """Raise ValueError for an array with masked values, whose numbers underneath mean nothing."""
    count = masked_count(values)
    if count:
        raise ValueError(
            f"{name}: got an array with {count} masked values, allowed: an array without any; fill"
            " them, or leave them out"
        )


def with_nan(values: Any) -> np.ndarray:
    """Return values as an array with NaN in place of masked values of real numbers."""
    if masked_count(values):
        masked = np.ma.array(values)
        if masked.dtype.kind in "biuf":
            return np.asarray(np.ma.filled(masked.astype(float), np.nan))
    return np.asarray(values)


def real_array(name: str, values: Any, dimensions: int | None, gaps: bool = False) -> Array:
    """Return values as an array of floats, finite but for gaps; raise ValueError for all else.

    Masked values are gaps: NaN where gaps are allowed, and refused elsewhere. Any number of
    dimensions is allowed where it is None, and an array without numbers.
    """
    if not gaps:
        refuse_masked(name, values)
    allowed = "allowed: an array of finite numbers"
    allowed += "" if dimensions is None else f" in {dimensions} dimensions"
    try:
        values = with_nan(values)
        if values.dtype.kind not in "biuf":
            raise TypeError
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: got {_short(values)}, {allowed}") from None
    if dimensions is not None and (array.ndim != dimensions or array.size == 0):
        raise ValueError(f"{name}: got an array of shape {array.shape}, {allowed}")
    with np.errstate(all="ignore"):
        total = float(np.sum(array))
    if not (np.isfinite(array).any() if gaps else math.isfinite(total)):
        raise ValueError(f"{name}: got numbers that are not finite, {allowed}")
    return array


def over_largest(record: Array, of_silence: float) -> Array:
    """Return a record (n,) over its largest magnitude, so that its fourth power does not underflow.

    All samples of silence are `of_silence`: 0 where silence has nothing in any band, and NaN where
    it has no value, such as a kurtosis. Raise ValueError for values that are not finite.
    """
    record = real_array("record", record, 1)
    largest = float(np.max(np.abs(record)))
    if not largest > 0.0:
        return np.full(len(record), of_silence)
    return record / largest


def positive(name: str, value: Any, most: float = math.inf, infinite: bool = False) -> float:
    """Return a number as a float; raise ValueError unless it is above zero, and at most `most`.

    Infinity is refused unless it has a meaning (`infinite`), as the hardness of an elastic body.
    """
    number = _as_float(value)
    if number is None or not 0 < number <= most or (math.isinf(number) and not infinite):
        if most < math.inf:
            allowed = f"a number > 0 and <= {most:g}"
        elif infinite:
            allowed = "a number > 0, or infinity"
        else:
            allowed = "a number > 0, and finite"
        raise ValueError(f"{name}: got {_short(value)}, allowed: {allowed}")
    return number


def within(name: str, value: Any, least: float, most: float) -> float:
    """Return a number as a float; raise ValueError unless it lies from `least` to `most`."""
    number = _as_float(value)
    if number is None or not least <= number <= most:
        allowed = f"a number from {least:g} to {most:g}"
        raise ValueError(f"{name}: got {_short(value)}, allowed: {allowed}")
    return number


def finite(name: str, value: Any, most: float = math.inf) -> float:
    """Return a finite number as a float; raise ValueError for all else, and beyond +-`most`."""
    number = _as_float(value)
    if number is None or not math.isfinite(number) or abs(number) > most:
        allowed = "a finite number" if most == math.inf else f"a number from {-most:g} to {most:g}"
        raise ValueError(f"{name}: got {_short(value)}, allowed: {allowed}")
    return number


def truth(name: str, value: Any) -> bool:
    """Return a truth value; raise ValueError for all else, numbers and nothing too."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"{name}: got {_short(value)}, allowed: True or False")
    return bool(value)


def _as_float(value: Any) -> float | None:
    """Return a real number as a float, infinite beyond its range; None for all else.

    Arrays and truth values are no numbers.
    """
    kinds = int | float | np.integer | np.floating
    if not isinstance(value, kinds) or isinstance(value, bool):
        return None
    try:
        return float(value)
    except OverflowError:  # of a whole number with more than 308 digits
        return math.inf if value > 0 else -math.inf


def instance(name: str, value: Any, *kinds: type) -> None:
    """Raise TypeError unless a value is an object of one of the kinds."""
    if not isinstance(value, kinds):
        allowed = " or ".join(kind.__name__ for kind in kinds)
        raise TypeError(f"{name}: got {_short(value)}, allowed: {allowed}")


def short_repr(self: Any) -> str:
    """Write a data class with its fields, arrays by their shape and dictionaries by their size."""
    parts = (f"{field.name}={_short(getattr(self, field.name))}" for field in fields(self))
    return f"{type(self).__name__}({', '.join(parts)})"


def _short(value: Any) -> str:
    """Write a value in few letters."""
    if isinstance(value, np.ndarray):
        return f"array of shape {value.shape}"
    if isinstance(value, dict):
        return f"dict of {len(value)}"
    if isinstance(value, float):
        return f"{value:.6g}"
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
