"""Names of the runs of a sweep: short, and always different on every file system."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from rolling.scene.messages import plain_number

LONGEST = 120  # bytes; temporary names add to it, and some file systems end at 143
DIGEST = 16  # hexadecimal digits
_TEXT = 40  # letters of a text value

Values = Mapping[str, float | str]


def short_value(value: float | str) -> str:
    """Write a number, or the end of a text in letters that every file system takes."""
    if not isinstance(value, str):
        return plain_number(value)
    return re.sub(r"[^A-Za-z0-9._+-]+", "-", value.strip("./\\ "))[-_TEXT:].strip("-") or "-"


def exact_value(value: float | str) -> str:
    """Write a number with all digits, or the end of a text with a digest of the whole."""
    if not isinstance(value, str):
        return repr(value)
    return f"{short_value(value)}-{hashlib.sha256(value.encode()).hexdigest()[:8]}"


def run_name(values: Values, written: Callable[[float | str], str] = short_value) -> str:
    """Return the short name of a run, such as "load_n=5,radius_mm=2".

    Each key stands with its last part unless two keys share it.

    Runs without values have an empty name; values that print alike share a name.
    """
    last = [name.rpartition(".")[2] for name in values]
    return ",".join(
        f"{short if last.count(short) == 1 else name}={written(value)}"
        for short, (name, value) in zip(last, values.items(), strict=True)
    )


def run_names(runs: Sequence[Values]) -> list[str]:
    """Return a different name for each run of a sweep.

    Names that would be equal are written with all digits.

    Names that are too long end in a digest of their values. Upper and lower case make no
    difference.
    """
    names = [run_name(values) for values in runs]
    shared = Counter(name.casefold() for name in names)
    names = [
        run_name(values, exact_value) if shared[name.casefold()] > 1 else name
        for values, name in zip(runs, names, strict=True)
    ]
    names = [_shortened(name, values) for name, values in zip(names, runs, strict=True)]
    if len({name.casefold() for name in names}) < len(names):
        raise AssertionError("two runs of a sweep share a name")
    return names


def _shortened(name: str, values: Values) -> str:
    if len(name.encode()) <= LONGEST:
        return name
    exact = ",".join(f"{key}={value!r}" for key, value in values.items())
    digest = hashlib.sha256(exact.encode()).hexdigest()[:DIGEST]
    return f"{name[: LONGEST - DIGEST - 1]}-{digest}"
