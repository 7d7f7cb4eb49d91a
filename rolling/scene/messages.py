"""Messages about scenes: their error, the mistakes that rules raise, and values in words.

A mistake names the key, the value, the allowed values, and the nearest name or value where there is
one. The rule that finds it writes the sentence.
"""

import difflib
import json
import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic_core import PydanticCustomError

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.terminal.notebook import short_traceback

# place of a value: ("rolling", "load_n"), ("sweep", "rolling.load_n", 0)
Key = tuple[str | int, ...]

MAX_MISTAKES = 20  # maximum number of mistakes that are listed
_LONGEST = 60  # letters of a value in a message


def table(package: str, name: str) -> dict[str, Any]:
    """Read the table NAME.toml beside the modules of a package."""
    return tomllib.loads(files(package).joinpath(f"{name}.toml").read_text(encoding="utf-8"))


TABLES = table("rolling.scene", "tables")


class SceneError(Exception):
    """Mistakes of a scene.

    Attributes
    ----------
    mistakes : list of str
        One line for each mistake: file and line (or --set, or scene), key, the value and the
        allowed values.

    Examples
    --------
    >>> import rolling
    >>> rolling.read_scene("quickstart", ["rolling.load_n=-5"])
    Traceback (most recent call last):
    rolling.scene.messages.SceneError: --set: rolling.load_n: got -5, allowed: ...
    """

    _render_traceback_ = short_traceback

    def __init__(self, mistakes: Sequence[str]) -> None:
        self.mistakes = [printable(writable(mistake)) for mistake in mistakes]
        super().__init__("\n".join(self.mistakes))

    def __reduce__(self) -> tuple[Any, ...]:
        return SceneError, (self.mistakes,)


# ---- mistakes


class Mistake(NamedTuple):
    """Mistake of a scene.

    key : tuple. Key of the faulty value; () for a text without one.
    message : str. What is wrong, and what is allowed.
    place : str. File and line, where they are not those of the key.
    meant : tuple. Key that a misspelt one stands for; () for other mistakes.
    needs : tuple of tuple. Keys without which the rule is broken.
    """

    key: Key
    message: str
    place: str = ""
    meant: Key = ()
    needs: tuple[Key, ...] = ()

    @property
    def line(self) -> str:
        """Place, key and message, as a person reads them."""
        if not self.key:
            return f"{self.place}: {self.message}"
        return f"{self.place}: {shortened(dotted(self.key))}: {self.message}"


def mistake(message: str, at: str | Key = (), needs: Sequence[str] = ()) -> PydanticCustomError:
    """Make a mistake for pydantic to collect, at the validated key or at another key of the scene.

    A key that begins with a dot is one of the section that is validated. `needs` are the keys
    without which the rule is broken: where one of them is missing because it is faulty itself, the
    mistake follows from its mistake and is not listed.
    """
    key = key_of(at) if isinstance(at, str) else at
    context = {"message": writable(message), "at": key, "needs": [key_of(name) for name in needs]}
    return PydanticCustomError("mistake", "{message}", context)


def mistakes_together(mistakes: Sequence[PydanticCustomError]) -> PydanticCustomError:
    """Join mistakes of one value, at least one, for pydantic to collect."""
    contexts = [single.context or {} for single in mistakes]
    return PydanticCustomError("mistakes", "several mistakes", {"mistakes": contexts})


def first_mistakes(lines: Sequence[str], where: str, more: int | None = 0) -> list[str]:
    """Return the first lines of a list of mistakes, and how many more there are.

    `more` mistakes have no line, because words take long for many; None: their number is unknown.
    """
    different = list(dict.fromkeys(lines))
    listed = different[:MAX_MISTAKES]
    if more is None:
        listed.append(f"{where}: further mistakes are not listed")
        return listed
    more += max(0, len(different) - MAX_MISTAKES)
    if more == 1:
        listed.append(f"{where}: 1 more mistake is not listed")
    elif more > 1:
        listed.append(f"{where}: {more:,} more mistakes are not listed")
    return listed


def order_of_place(place: str) -> float:
    """Return the rank of the place of a mistake: its line in a file, and --set after all lines."""
    line = place.rpartition(":")[2]
    return int(line) if line.isdecimal() else math.inf


class Plausible(NamedTuple):
    """Sizes that a property of a material has, and units that are taken for its own by a slip."""

    least: float
    most: float
    words: str
    slips: Mapping[str, float]  # size of each unit in the unit of the key


MATERIALS = {key: Plausible(**sizes) for key, sizes in TABLES["materials"].items()}


def implausible(value: float, sizes: Plausible) -> str:
    """Write that no material has a size, and the size that was meant if it is a slip of units."""
    words = f"got {quoted(value)}, allowed: {sizes.least:g} to {sizes.most:g} {sizes.words}"
    meant = [
        f"{rounded(value * size, 4)} ({rounded(value, 6)} {unit})"
        for unit, size in sizes.slips.items()
        if sizes.least <= value * size <= sizes.most
    ]
    if meant:
        return f"{words}; did you mean {' or '.join(meant)}?"
    return f"{words}; nearest: {min(max(value, sizes.least), sizes.most):g}"


def nearest(got: str, *families: Sequence[str]) -> str:
    """Write ", nearest: name" with the nearest name to a misspelt one, nothing without one."""
    name = nearest_name(got, *families)
    if not name:
        return ""
    half = ", half of it" if "radius" in name and "diameter" in got.lower() else ""
    return f", nearest: {name}{half}"


def nearest_name(got: str, *families: Sequence[str]) -> str:
    """Return a name of the first family that has one like a misspelt name, "" without one.

    Names are compared by their last part, or as a whole where the section is unknown. A diameter
    stands for a radius.
    """
    got = got.lower().replace("-", "_").replace(" ", "_")[: 2 * _LONGEST]
    section, _, last = got.rpartition(".")
    for names in families:
        radii = [name for name in names if "radius" in name]
        if "diameter" in last and radii:
            return radii[0]
        if section and not any(name.startswith(f"{section}.") for name in names):
            close = difflib.get_close_matches(got, names, 1)
        else:
            last_parts = {name.rpartition(".")[2]: name for name in reversed(names)}
            close = [last_parts[part] for part in difflib.get_close_matches(last, last_parts, 1)]
        if close:
            return close[0]
    return ""


def dotted(key: Key) -> str:
    """Write ("rolling", "load_n") as "rolling.load_n", and places in a list in brackets."""
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return "".join(parts).removeprefix(".")


def key_of(name: str) -> Key:
    """Return the place of a dotted name; the keys of a sweep are dotted names themselves."""
    head, _, rest = name.partition(".")
    if head == "sweep" and rest:
        return "sweep", rest
    return tuple(name.split("."))


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
    if value == int(value) and abs(value) < 1e15:
        return repr(int(value))
    return repr(float(value))


def quoted(value: Any) -> str:
    """Write a value nearly as the user did, with text in quotes."""
    if value is None:
        return "nothing"
    if isinstance(value, float) and math.isnan(value):
        return ".nan"
    if isinstance(value, float) and math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    if isinstance(value, str | list | tuple):
        value = value[:_LONGEST]  # the beginning of a long value is enough
    try:
        return shortened(json.dumps(value, ensure_ascii=False, default=str))
    except (TypeError, ValueError, RecursionError):  # a very long number, an odd key, or itself
        return f"a value that cannot be written ({type(value).__name__})"


def shortened(text: str) -> str:
    """Shorten a text to at most 60 letters."""
    if len(text) <= _LONGEST:
        return text
    return f"{text[: _LONGEST - 3]}..."


def writable(text: str) -> str:
    """Replace halves of pairs of surrogates, which UTF-8 cannot write."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def first_line(error: BaseException) -> str:
    """Return the first line of the message of an error."""
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__


# ---- values from Python


_MAX_BITS = 1000  # maximum length of a whole number: pydantic fails to show much longer ones
_MAX_DEPTH = 16  # maximum nesting


def plain_values(value: Any, depth: int = 0) -> Any:
    """Turn a value typed in Python into the plain value of a scene file.

    Keys of a section that have no value (None) are left out.
    """
    if depth > _MAX_DEPTH:
        raise SceneError([f"scene: values are nested more than {_MAX_DEPTH} times"])
    if isinstance(value, BaseModel):
        fields = {name: getattr(value, name) for name in type(value).model_fields}
        return {
            name: plain_values(item, depth + 1) for name, item in fields.items() if item is not None
        }
    if isinstance(value, Mapping):
        return {
            writable(name) if isinstance(name, str) else name: plain_values(item, depth + 1)
            for name, item in value.items()
        }
    if isinstance(value, list | tuple | range):
        return [plain_values(item, depth + 1) for item in value]
    if hasattr(value, "tolist"):  # numbers and arrays of numpy, which is slow to import
        return value.tolist()
    if hasattr(value, "__array__"):  # of a library beside numpy, such as xarray
        return value.__array__().tolist()
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return math.inf if value > 0 else -math.inf
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    return writable(value) if isinstance(value, str) else value
