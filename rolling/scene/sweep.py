"""Sweep of a scene: its lists of values, their product, and the faults of single runs.

Values are numbers, names, or anything under labels, such as two surfaces or two speed profiles.

The model of a scene is handed in as `root`, because a scene holds its sweep.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from rolling.scene.messages import (
    Key,
    dotted,
    explained,
    fault,
    is_number,
    nearest,
    numeric_keys,
    section_keys,
    shown,
    text_keys,
)
from rolling.scene.run_names import run_name
from rolling.scene.section import MAX_FAULTS

MAX_RUNS = 10_000  # maximum number of runs of a sweep
ZIP = "zip"  # key of the values that go together, beside the product of the others
LONGEST_LABEL = 100
Fault = tuple[Key, str]  # key and message
Value = float | str  # number, text, or label of a swept value
Choice = tuple[Value, Any]  # value as names and tables show it, and its plain form for the scene


def validated(sweep: Any, root: type[BaseModel]) -> dict[str, Any]:
    """Turn the lists of a sweep into tuples; raise its first fault at its own place."""
    if not isinstance(sweep, dict):
        raise fault(
            f"got {shown(sweep)}, allowed: lists of numbers by dotted key, as in rolling.load_n:"
            " [5, 20]",
            "sweep",
        )
    zipped = sweep.get(ZIP, {})
    if not isinstance(zipped, dict) or (ZIP in sweep and not zipped):
        raise fault(f"got {shown(zipped)}, allowed: lists by dotted key", "sweep", ZIP)
    free = {name: values for name, values in sweep.items() if name != ZIP}
    numeric, text, sections = numeric_keys(root), text_keys(root), section_keys(root)
    known = [*numeric, *text, *sections]
    for key in ((name,) for name in free):
        _refuse_form(key, free[key[0]], known, numeric, sections)
    for name, values in zipped.items():
        if name in free:
            raise fault("is swept beside it, too", "sweep", ZIP, name)
        _refuse_form((ZIP, name), values, known, numeric, sections)
    runs = math.prod(len(values) for values in free.values())
    lengths = {name: len(values) for name, values in zipped.items()}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{count} of {name}" for name, count in lengths.items())
        raise fault(f"got {said}, allowed: equally many values of each key", "sweep", ZIP)
    runs *= max(lengths.values(), default=1)
    if runs > MAX_RUNS:  # refused before any value is looked at
        raise fault(f"got {runs} runs, allowed: at most {MAX_RUNS}", "sweep")
    for name, values in free.items():
        _refuse_values((name,), values, name in numeric, name in sections)
    for name, values in zipped.items():
        _refuse_values((ZIP, name), values, name in numeric, name in sections, repeated=True)
    _refuse_repeated_rows(zipped)
    made: dict[str, Any] = {name: _frozen(values) for name, values in free.items()}
    if zipped:
        made[ZIP] = {name: _frozen(values) for name, values in zipped.items()}
    return made


def _frozen(values: Any) -> Any:
    return dict(values) if isinstance(values, dict) else tuple(values)


def _refuse_form(
    key: tuple[str, ...],
    values: Any,
    known: Sequence[str],
    numeric: Collection[str],
    sections: Collection[str],
) -> None:
    """Raise a fault for an unknown key, or for values that are no list and have no labels."""
    name = key[-1]
    if name not in known:
        raise fault(f"unknown key{nearest(name, known)}", "sweep", *key)
    if isinstance(values, dict) and values:
        return
    if name in sections:
        raise fault(
            f"got {shown(values)}, allowed: sections by label, as in {name}: {{first: {{...}},"
            " second: {...}}",
            "sweep",
            *key,
        )
    kind = "numbers" if name in numeric else "names"
    if not isinstance(values, list | tuple) or not values:
        raise fault(f"got {shown(values)}, allowed: a list of {kind}, at least one", "sweep", *key)


def _refuse_values(
    key: tuple[str, ...], values: Any, numeric: bool, section: bool, repeated: bool = False
) -> None:
    """Raise the first fault of the values of one key."""
    if isinstance(values, dict):
        for label, value in values.items():
            if not isinstance(label, str) or not 0 < len(label) <= LONGEST_LABEL:
                raise fault(
                    f"got {shown(label)} as a label, allowed: text of 1 to {LONGEST_LABEL} letters",
                    "sweep",
                    *key,
                )
            if section and not isinstance(value, dict):
                raise fault(f"got {shown(value)}, allowed: a section", "sweep", *key, label)
        return
    before: set[Value] = set()
    for i, value in enumerate(values):
        if numeric and not is_number(value):
            raise fault(f"got {shown(value)}, allowed: a number", "sweep", *key, i)
        if not numeric and (not isinstance(value, str) or not value):
            raise fault(f"got {shown(value)}, allowed: text", "sweep", *key, i)
        if value in before and not repeated:
            raise fault(f"got {shown(value)} twice, allowed: different values", "sweep", *key, i)
        before.add(value)


def _refuse_repeated_rows(zipped: Mapping[str, Any]) -> None:
    """Raise a fault where values that go together stand twice."""
    columns = [[value for value, _ in choices(listed)] for listed in zipped.values()]
    rows = [*zip(*columns, strict=True)]
    if len(set(rows)) < len(rows):
        raise fault("the same values stand together twice, allowed: different ones", "sweep", ZIP)


def choices(listed: Any) -> list[Choice]:
    """Return the values of one key, each with the form that a scene takes."""
    return [*listed.items()] if isinstance(listed, dict) else [(value, value) for value in listed]


def product(sweep: Mapping[str, Any]) -> Iterator[tuple[dict[str, Value], dict[str, Any]]]:
    """Yield the values of each run by dotted key, and their plain forms.

    The last key varies fastest. Values that go together are the last.
    """
    axes = [
        [{name: choice} for choice in choices(listed)]
        for name, listed in sweep.items()
        if name != ZIP
    ]
    if zipped := sweep.get(ZIP):
        columns = [choices(listed) for listed in zipped.values()]
        axes.append([dict(zip(zipped, row, strict=True)) for row in zip(*columns, strict=True)])
    for combination in itertools.product(*axes):
        chosen = {name: choice for part in combination for name, choice in part.items()}
        yield (
            {name: value for name, (value, _) in chosen.items()},
            {name: form for name, (_, form) in chosen.items()},
        )


def with_values(data: Mapping[str, Any], forms: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plain values of a scene with the values of one run, sections first."""
    result = dict(data)
    for name, form in sorted(forms.items(), key=lambda item: "." in item[0]):
        section, dot, last = name.partition(".")
        if not dot:
            result[section] = form
        elif isinstance(result.get(section, {}), dict):
            result[section] = {**result.get(section, {}), last: form}
    return result


def with_first_sections(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plain values of a scene with the first of swept sections that it lacks."""
    result, sweep = dict(data), data.get("sweep")
    if isinstance(sweep, dict):
        zipped = sweep.get(ZIP)
        for name, listed in [*sweep.items(), *(zipped.items() if isinstance(zipped, dict) else ())]:
            if name not in data and isinstance(listed, dict) and listed and "." not in str(name):
                result.setdefault(name, next(iter(listed.values())))
        result.pop(ZIP, None)
    return result


def drop(sweep: dict[str, Any], name: str) -> None:
    """Remove a key from the plain values of a sweep."""
    sweep.pop(name, None)
    zipped = sweep.get(ZIP)
    if isinstance(zipped, dict):
        zipped.pop(name, None)
        if not zipped:
            del sweep[ZIP]


def with_paths(data: Mapping[str, Any], moved: Callable[[str], str]) -> dict[str, Any]:
    """Return the plain values of a scene with other paths of height files, swept ones as well.

    Swept paths keep their text as labels.
    """

    def section(surface: Any) -> Any:
        there = isinstance(surface, dict) and isinstance(surface.get("path"), str)
        return {**surface, "path": moved(surface["path"])} if there else surface

    def listed(name: str, values: Any) -> Any:
        if name == "surface":
            return {label: section(value) for label, value in values.items()}
        if name == "surface.path":
            return {str(label): moved(path) for label, path in choices(values)}
        return values

    result = {**data, "surface": section(data["surface"])}
    if "sweep" in data:
        sweep = data["sweep"]
        result["sweep"] = {
            name: {key: listed(key, inner) for key, inner in values.items()}
            if name == ZIP
            else listed(name, values)
            for name, values in sweep.items()
        }
        if _same_paths(result, data):
            return dict(data)
    return result


def _same_paths(result: Mapping[str, Any], data: Mapping[str, Any]) -> bool:
    """Tell whether no path of a scene has changed."""
    before, after = product(data["sweep"]), product(result["sweep"])
    surface = result["surface"] == data["surface"]
    return surface and all(old == new for (_, old), (_, new) in zip(before, after, strict=True))


def _places(sweep: Mapping[str, Any]) -> dict[str, dict[Value, Key]]:
    """Return the place of each value of each key in a scene."""
    places: dict[str, dict[Value, Key]] = {}
    zipped = sweep.get(ZIP, {})
    keys: list[tuple[Key, str, Any]] = [
        (("sweep", name), name, listed) for name, listed in sweep.items() if name != ZIP
    ]
    keys += [(("sweep", ZIP, name), name, listed) for name, listed in zipped.items()]
    for key, name, listed in keys:
        labelled = isinstance(listed, dict)
        places[name] = {
            value: (*key, str(value) if labelled else i)
            for i, (value, _) in enumerate(choices(listed))
        }
    return places


def faults_of_runs(
    data: Mapping[str, Any], known_faults: Sequence[Fault], root: type[BaseModel]
) -> list[Fault]:
    """List the faults of the runs of a sweep that are not known yet.

    A fault of a swept value stands at its place in the sweep. Any other fault is listed once, with
    the first run that has it.
    """
    unswept = {name: value for name, value in data.items() if name != "sweep"}
    try:
        sweep = validated(data.get("sweep", {}), root)
    except PydanticCustomError:  # where other faults kept pydantic from looking at it
        return []
    places = _places(sweep)
    known, named = {key for key, _ in known_faults}, set[Fault]()
    # Many runs share a fault, and wording it takes longer than detecting it.
    in_words: dict[Any, Fault] = {}
    faults: list[Fault] = []
    for values, forms in product(sweep) if sweep else ():
        swept = with_values(unswept, forms)
        for error in _errors(swept, root):
            alike = (error["loc"], error["type"], error["msg"], shown(_plain_input(error)))
            if alike not in in_words:
                in_words[alike] = explained(error, swept, root)
            key, message = in_words[alike]
            name = dotted(key)
            section = str(key[0])
            if name in values or section in values:
                inner = () if name in values else key[1:]
                name = name if name in values else section
                swept_fault = (*places[name][values[name]], *inner), message
                if swept_fault not in named:
                    named.add(swept_fault)
                    faults.append(swept_fault)
            elif key not in known:
                known.add(key)
                faults.append((key, f"{message} (in the run {run_name(values)} of the sweep)"))
        if len(faults) > MAX_FAULTS:
            break
    return faults


def first_errors(error: ValidationError) -> list[Any]:
    """List the faults that pydantic reports, at most one more than are named."""
    return error.errors(include_url=False)[: MAX_FAULTS + 1]


def _errors(data: Mapping[str, Any], root: type[BaseModel]) -> list[Any]:
    """List the faults of a scene, before they are put into words."""
    try:
        root.model_validate(data)
    except ValidationError as error:
        return first_errors(error)
    return []


def _plain_input(error: Any) -> Any:
    """Return the value that has a fault, None for a whole section."""
    return error["input"] if isinstance(error["input"], bool | int | float | str) else None
