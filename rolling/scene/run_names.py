"""Names of the runs of a sweep: short, and different for different values on every file system."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence

from rolling.scene.messages import plain_number

LONGEST = 120  # bytes; temporary names add to it, and some file systems end at 143
_DIGEST = 16  # hexadecimal digits
_TEXT = 40  # letters of a text value

Values = Mapping[str, float | str]


def run_name(values: Values) -> str:
    """Return the name of a run by its own values alone, such as "load_n=5,radius_mm=2".

    Each key stands with its last part unless two keys share it. Numbers stand with all digits; a
    text that does not fit ends in a digest. Runs without values have an empty name.
    """
    last = [key.rpartition(".")[2] for key in values]
    name = ",".join(
        f"{short if last.count(short) == 1 else key}={_written(value)}"
        for short, (key, value) in zip(last, values.items(), strict=True)
    )
    if len(name.encode()) <= LONGEST:
        return name
    exact = ",".join(f"{key}={value!r}" for key, value in values.items())
    return f"{name[: LONGEST - _DIGEST - 1]}-{_digest(exact, _DIGEST)}"


def run_names(runs: Sequence[Values]) -> list[str]:
    """Return the name of each run of a sweep."""
    return [run_name(values) for values in runs]


def _written(value: float | str) -> str:
    """Write a number with all digits, or a text in letters that every file system takes."""
    if not isinstance(value, str):
        return repr(value) if isinstance(value, int) else plain_number(value)
    short = re.sub(r"[^A-Za-z0-9._+-]+", "-", value.strip("./\\ "))[-_TEXT:].strip("-")
    return short if short == value else f"{short or '-'}-{_digest(value, 6)}"


def _digest(text: str, digits: int) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:digits]
