"""Sweep of a scene: its lists of values, their product, and the faults of single runs.

The model of a scene is handed in as `root`, because a scene holds its sweep.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from rolling.scene.messages import (
    Key,
    all_keys,
    dotted,
    explained,
    fault,
    is_number,
    nearest,
    numeric_keys,
    shown,
)
from rolling.scene.run_names import run_name
from rolling.scene.sections import MAX_FAULTS

MAX_RUNS = 10_000  # maximum number of runs of a sweep
Fault = tuple[Key, str]  # key and message


def validated(sweep: Any, root: type[BaseModel]) -> dict[str, tuple[float, ...]]:
    """Turn the lists of a sweep into tuples; raise its first fault at its own place."""
    if not isinstance(sweep, dict):
        raise fault(
            f"got {shown(sweep)}, allowed: lists of numbers by dotted key, as in rolling.load_n:"
            " [5, 20]",
            "sweep",
        )
    keys = numeric_keys(root)
    for name, values in sweep.items():
        if name not in keys:
            known = name in all_keys(root)
            message = (
                "cannot be swept, only numbers can"
                if known
                else f"unknown key{nearest(name, keys)}"
            )
            raise fault(message, "sweep", name)
        if not isinstance(values, list | tuple) or not values:
            raise fault(
                f"got {shown(values)}, allowed: a list of numbers, at least one", "sweep", name
            )
    runs = math.prod(len(values) for values in sweep.values())
    if runs > MAX_RUNS:  # refused before any value is looked at
        raise fault(f"got {runs} runs, allowed: at most {MAX_RUNS}", "sweep")
    for name, values in sweep.items():
        _refuse_values(name, values)
    return {name: tuple(values) for name, values in sweep.items()}


def _refuse_values(name: str, values: Sequence[Any]) -> None:
    """Raise the first fault of the values of one key."""
    before: set[float] = set()
    for i, number in enumerate(values):
        if not is_number(number):
            raise fault(f"got {shown(number)}, allowed: a number", "sweep", name, i)
        if number in before:
            raise fault(f"got {shown(number)} twice, allowed: different values", "sweep", name, i)
        before.add(number)


def product(sweep: Mapping[str, Sequence[float]]) -> Iterator[dict[str, float]]:
    """Yield the values of each run by dotted key; the last key varies fastest."""
    for values in itertools.product(*sweep.values()):
        yield dict(zip(sweep, values, strict=True))


def with_values(data: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """Return the plain values of a scene with the values of one run by dotted key."""
    result = dict(data)
    for name, value in values.items():
        section, _, last = name.partition(".")
        if isinstance(result.get(section, {}), dict):
            result[section] = {**result.get(section, {}), last: value}
    return result


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
    places = {name: {value: i for i, value in enumerate(values)} for name, values in sweep.items()}
    known, named = {key for key, _ in known_faults}, set[Fault]()
    # Many runs share a fault, and wording it takes longer than detecting it.
    in_words: dict[Any, Fault] = {}
    faults: list[Fault] = []
    for values in product(sweep) if sweep else ():
        swept = with_values(unswept, values)
        for error in _errors(swept, root):
            alike = (error["loc"], error["type"], error["msg"], shown(_plain_input(error)))
            if alike not in in_words:
                in_words[alike] = explained(error, swept, root)
            key, message = in_words[alike]
            name = dotted(key)
            if name in values:
                swept_fault = ("sweep", name, places[name][values[name]]), message
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
