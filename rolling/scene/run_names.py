"""Names of the runs of a sweep: short, and always different on every file system."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from rolling.scene.messages import plain_number

LONGEST = 120  # bytes; temporary names add to it, and some file systems end at 143
DIGEST = 16  # hexadecimal digits

Values = Mapping[str, float]


def run_name(values: Values, number: Callable[[float], str] = plain_number) -> str:
    """Return the short name of a run, such as "load_n=5,radius_mm=2".

    Each key stands with its last part unless two keys share it.

    Runs without values have an empty name; values that print alike share a name.
    """
    last = [name.rpartition(".")[2] for name in values]
    return ",".join(
        f"{short if last.count(short) == 1 else name}={number(value)}"
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
        run_name(values, repr) if shared[name.casefold()] > 1 else name
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
