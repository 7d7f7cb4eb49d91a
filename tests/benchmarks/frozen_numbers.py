"""The numbers of runs, bearings, choices, checks and comparisons by names that never change.

`frozen_numbers.toml` says where each number stands, in this version of the program or an earlier
one. This module follows these places and knows no number by name. It imports nothing of `rolling`,
so that every version of the program is read by it.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from acoustics.bands import BAND_NAMES

EVERY = "*"  # of a place: every entry of a list or mapping; of what is left out: every name
ROOTS = ("numbers", "summary")  # of a run, all numbers of which are to be frozen: the first it has
NOTHING = object()  # what stands at a place that does not exist
NOT_SERIES = ("step_time",)  # processor times
COSTS = ("time", "memory", "disk")  # in the keys of rows of a check that differ from day to day


def _in_full(places: Mapping[str, Sequence[str]], words: Mapping[str, Sequence[str]]) -> Any:
    """Return places by name, with each of some words where `<word>` stands for them."""
    for word, meant in words.items():
        mark = f"<{word}>"
        longer: dict[str, list[str]] = {}
        for name, of_name in places.items():
            for one in meant if any(mark in text for text in (name, *of_name)) else [""]:
                of_one = [place.replace(mark, one) for place in of_name]
                longer.setdefault(name.replace(mark, one), []).extend(of_one)
        places = longer
    return places


def read_table(path: Path) -> dict[str, dict[str, dict[str, list[str]]]]:
    """Return the places of each section of a table, by kind."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    words = table.pop("words")
    return {
        kind: {section: _in_full(places, words) for section, places in sections.items()}
        for kind, sections in table.items()
    }


PLACES = read_table(Path(__file__).with_suffix(".toml"))


class Frozen(NamedTuple):
    """What is frozen of a run, a choice, a check or a comparison.

    series : dict. Digests of the bytes of arrays, by name.
    values : dict. Unrounded numbers and words, by name.
    verdicts : dict. Words and keys of verdicts, by name.
    """

    series: dict[str, str]
    values: dict[str, Any]
    verdicts: dict[str, Any]

    @classmethod
    def of(cls, thing: Any, kind: str) -> Frozen:
        """Return what is frozen of a thing whose places a section of the table has."""
        places = PLACES[kind]
        frozen = cls({}, {}, {})
        for name, found in read_all(thing, places.get("arrays", {})):
            frozen.series.update(digests(name, found))
        for name, found in read_all(thing, places.get("values", {})):
            frozen.values.update(leaves(name, found))
        for name, found in read_all(thing, places.get("bands", {})):
            frozen.values.update(leaves(name, by_band(found)))
        for name, found in read_all(thing, places.get("doubts", {})):
            frozen.values.update(doubts_by_key(name, found))
        for name, found in read_all(thing, places.get("verdicts", {})):
            frozen.verdicts.update(leaves(name, found))
        return frozen

    @classmethod
    def of_check(cls, findings: Any, verdicts: Mapping[str, str]) -> Frozen:
        """Return the forecasts of a check: its doubts, the numbers of its rows, and its verdicts.

        `verdicts` are the words that are expected, by run.
        """
        frozen = cls({}, {}, {})
        for run, rows in findings.runs.items():
            for row in rows:
                if row.seconds or any(word in row.key for word in COSTS):
                    continue
                numbers = re.findall(r"\d+(?:[.,]\d+)*(?:e[+-]?\d+)?", str(row.value))
                frozen.values.update(leaves(f"{run}: row {row.key}", numbers))
        for run, doubts in findings.doubts.items():
            timeless = [doubt for doubt in doubts if doubt.key not in COSTS]
            frozen.values.update(doubts_by_key(f"{run}: doubts", timeless))
        for run, word in verdicts.items():
            frozen.verdicts[f"{run}: verdict"] = word
        return frozen

    @classmethod
    def of_comparison(cls, table: Any) -> Frozen:
        """Return the numbers of a comparison with a recording: all columns of each row."""
        frozen = cls({}, {}, {})
        for row in table.to_dict("records"):
            words = [row["channel"], row["quantity"], row["weighting"], row["mid_frequency_hz"]]
            name = " ".join(str(word) for word in words if plain_value(word) is not None)
            frozen.values.update(leaves(name, row))
        return frozen


# ---- places


def read_all(thing: Any, places: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, Any]]:
    """Yield the names of numbers with what stands at the first of their places that exists."""
    for name, candidates in places.items():
        for place in candidates:
            found = read(thing, place.split("."))
            if found is not NOTHING:
                yield name, found
                break


def read(thing: Any, path: Sequence[str]) -> Any:
    """Return what stands at a path from a thing on, NOTHING where a version has no such place.

    Below a subject that a run has not, which is None, stands None.
    """
    if not path or thing is NOTHING or thing is None:
        return thing
    step, *rest = path
    if step == EVERY:
        if isinstance(thing, Mapping):
            thing = list(thing.values())
        if not isinstance(thing, list | tuple):
            return NOTHING
        entries = [read(entry, rest) for entry in thing]
        return NOTHING if any(entry is NOTHING for entry in entries) else entries
    if isinstance(thing, Mapping):
        return read(thing.get(step, NOTHING), rest)
    if isinstance(thing, list | tuple) and step.isdigit():
        return read(thing[int(step)], rest)
    return read(getattr(thing, step, NOTHING), rest)


def unread(thing: Any, kind: str) -> list[str]:
    """Return the places of numbers of a run that the table has not, neither as left out."""
    listed = set[str]()
    for section in PLACES[kind].values():
        for places in section.values():
            listed.update(places)
    root = next((root for root in ROOTS if hasattr(thing, root)), ROOTS[0])
    found = {*_places_below(read(thing, [root]), root)}
    return sorted(place for place in found if not _is_listed(place, listed))


def _places_below(value: Any, place: str) -> Iterator[str]:
    """Yield the places of all leaves below a value."""
    parts = parts_of(value)
    if not parts and plain_value(value) is not None:
        yield place
    is_list = isinstance(value, list | tuple) and not is_record(value)
    for name, part in parts:
        yield from _places_below(part, f"{place}.{EVERY if is_list else name}")


def _is_listed(place: str, listed: Iterable[str]) -> bool:
    """Tell whether a place stands in the table, or below one that does."""
    steps = place.split(".")
    return any(
        all(wanted in (EVERY, step) for wanted, step in zip(one.split("."), steps, strict=False))
        for one in listed
        if one.count(".") < len(steps)
    )


# ---- values


def parts_of(value: Any) -> list[tuple[str, Any]]:
    """Return the parts of a dictionary, a record or a list by name; none of anything else."""
    if isinstance(value, Mapping):
        return [(str(key), part) for key, part in value.items()]
    if is_record(value):
        return list(value._asdict().items())
    if hasattr(value, "by_name"):  # a quantity of bands
        names = ["by_name", "uncertainty_by_name", "unit", "how", "parts"]
        return [(name, getattr(value, name)) for name in names]
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value)]
        return [(name, getattr(value, name)) for name in names if not name.startswith("_")]
    if isinstance(value, np.ndarray):
        return parts_of(value.tolist())
    if isinstance(value, list | tuple):
        return [(str(number), part) for number, part in enumerate(value)]
    return []


def is_record(value: Any) -> bool:
    """Tell whether a value is a named tuple."""
    return isinstance(value, tuple) and hasattr(value, "_asdict")


def leaves(name: str, value: Any) -> dict[str, Any]:
    """Return the numbers and words of a value by dotted names, without those that are unknown.

    A `*` in the name becomes the number of an entry.
    """
    parts = parts_of(value)
    if EVERY in name:
        found = {}
        for number, entry in parts:
            found.update(leaves(name.replace(EVERY, number, 1), entry))
        return found
    if parts:
        found = {}
        for part_name, part in parts:
            found.update(leaves(f"{name}.{part_name}", part))
        return found
    plain = plain_value(value)
    return {} if plain is None else {name: plain}


def plain_value(value: Any) -> Any:
    """Return a number or a word as JSON has it; None for what is unknown or empty.

    A whole number is a number like any other, and an infinite one is a word.
    """
    if isinstance(value, Enum):
        return value.name.lower().replace("_", " ")
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | float | np.number):
        number = float(value)
        if math.isnan(number):
            return None
        return number if math.isfinite(number) else repr(number)
    if isinstance(value, str):
        return value or None
    return None


def by_band(value: Any) -> Any:
    """Return values of all third octaves by the names of these; a dictionary stays as it is."""
    if value is None or isinstance(value, Mapping):
        return value
    return dict(zip(BAND_NAMES, value, strict=True))


def doubts_by_key(name: str, doubts: Sequence[Any]) -> dict[str, Any]:
    """Return severities and decibels of doubts by their keys, whatever their order is."""
    found: dict[str, Any] = {}
    seen: dict[str, int] = {}
    for doubt in doubts:
        of_doubt = dict(parts_of(doubt))
        key = of_doubt["key"]
        seen[key] = seen.get(key, 0) + 1
        place = f"{name}.{key}" if seen[key] == 1 else f"{name}.{key} {seen[key]}"
        found.update(leaves(f"{place}.severity", of_doubt["severity"]))
        found.update(leaves(f"{place}.decibels", of_doubt["decibels"]))
    return found


# ---- arrays


def digests(name: str, value: Any) -> dict[str, str]:
    """Return the digest of an array, one for each of named arrays, or one of a whole record."""
    if value is None:
        return {}
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        return {
            f"{name}.{key}": digest(part) for key, part in value.items() if key not in NOT_SERIES
        }
    if isinstance(value, list) and not value:
        return {}
    return {name: digest(value)}


def digest(value: Any) -> str:
    """Return the digest of the bytes of all arrays and numbers in a value."""
    found = hashlib.sha256()
    for content in _bytes_of(value):
        found.update(content)
    return found.hexdigest()[:16]


def _bytes_of(value: Any) -> Iterator[bytes]:
    """Yield type, shape and bytes of arrays, and the bytes of numbers, in a fixed order."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, bool | int | float | np.number | np.bool_):
        yield np.float64(value).tobytes()
    elif isinstance(value, Mapping):
        for key in sorted(value):  # its order is that in which pieces came
            yield repr(key).encode()
            yield from _bytes_of(value[key])
    else:
        for _, part in parts_of(value):
            yield from _bytes_of(part)
