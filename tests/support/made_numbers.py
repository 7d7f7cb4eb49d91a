"""Numbers of a run that a test makes up, without a run."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.quantity import BandQuantity
from rolling.results.run_quantities import with_quantities
from rolling.scene.scene import Scene

_PLAIN = {float: 0.0, int: 0, str: "", bool: False}


class WithNumbers(RunFolder):
    """A run with numbers that the test gives."""

    numbers: RunNumbers


def run_with(scene: Scene, numbers: RunNumbers, **values: float | str) -> RunFolder:
    """Return a run without files; a swept key is written as `rolling__load_n`."""
    run = WithNumbers({key.replace("__", "."): x for key, x in values.items()}, scene, Path())
    object.__setattr__(run, "numbers", numbers)
    return run


def blank(kind: Any) -> Any:
    """Return a data class whose fields have their defaults, and zeros and empty texts else."""
    hints = typing.get_type_hints(kind)
    values = {}
    for field in dataclasses.fields(kind):
        if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            values[field.name] = _empty(hints[field.name])
    return kind(**values)


def _empty(hint: Any) -> Any:
    """Return an empty value of a type."""
    if dataclasses.is_dataclass(hint):
        return blank(hint)
    if hint in _PLAIN:
        return _PLAIN[hint]
    origin = typing.get_origin(hint)
    if origin is typing.Literal:
        return typing.get_args(hint)[0]
    return None if origin in (typing.Union, types.UnionType) else origin()


def changed(numbers: Any, changes: Mapping[str, Any]) -> Any:
    """Return numbers with other values by subject and field; a subject that lacks is made."""
    hints = typing.get_type_hints(type(numbers))
    values = dict(changes)
    for name, value in changes.items():
        if isinstance(value, Mapping):
            old = getattr(numbers, name)
            values[name] = changed(blank(_data_class(hints[name])) if old is None else old, value)
    return dataclasses.replace(numbers, **values)


def _data_class(hint: Any) -> Any:
    """Return the data class of the type of a field that may be None."""
    (kind,) = (
        option for option in (hint, *typing.get_args(hint)) if dataclasses.is_dataclass(option)
    )
    return kind


def bands(levels: Mapping[str, float | None], unit: str = "dB(A)") -> BandQuantity:
    """Return third octaves by the names of their bands."""
    return BandQuantity.of(levels, unit)


def released(
    level_db: float | None = 70.2, parts: Mapping[str, float] | None = None, **changes: Any
) -> RunNumbers:
    """Return the numbers of a run that is heard by its released power, with changes by subject.

    The record takes half a second, and nothing estimates its vibration.
    """
    own = {} if level_db is None else {"laeq_db": level_db, "lae_db": level_db - 3.0}
    record = {"source": "release", "duration_s": 0.5, "q": 1.0, "laeq_db": level_db}
    levels = {"released_power": {**own, "spreads": {"laeq_db": 0.1}}}
    return _made({"record": record, "levels": levels}, changes, parts or {"record": 0.1}, {})


def estimated(
    vibration_db: float | None = 14.5,
    released_db: float | None = 70.2,
    parts: Mapping[str, float] | None = None,
    **changes: Any,
) -> RunNumbers:
    """Return the numbers of a run whose vibration a linear chain estimates."""
    estimate = {
        "laeq_db": vibration_db,
        "force_ratio": 0.01,
        "bodies": "a ball of steel on a 10 mm plate of steel",
    }
    own = dataclasses.asdict(released(released_db).levels)["released_power"]
    record = {"source": "release", "duration_s": 0.5, "q": 1.0, "laeq_db": released_db}
    base = {"record": record, "levels": {"released_power": own}, "estimate": estimate}
    return _made(base, changes, {"record": 0.1}, parts or {"chain": 1.0, "comb": 0.5})


def computed(
    vibration_db: float | None = 14.8,
    released_db: float | None = 70.2,
    parts: Mapping[str, float] | None = None,
    **changes: Any,
) -> RunNumbers:
    """Return the numbers of a run whose vibration is computed with its motion, and heard."""
    both_known = vibration_db is not None and released_db is not None
    levels = {
        "vibration": {"laeq_db": vibration_db, "spreads": {"laeq_db": 0.2}},
        "released_power": {"laeq_db": released_db},
        "released_power_at_listener_db": released_db,
        "release_over_vibration_db": released_db - vibration_db if both_known else None,
    }
    record = {"source": "vibration", "duration_s": 0.5, "laeq_db": vibration_db}
    base = {"record": record, "levels": levels, "motion": {"resonance_hz": 60e3}}
    return _made(base, changes, parts or {"record": 0.2}, {})


def _made(
    base: Mapping[str, Any],
    changes: Mapping[str, Any],
    of_sound: Mapping[str, float],
    of_estimate: Mapping[str, float],
) -> RunNumbers:
    """Return blank numbers with values and then changes by subject, and with both quantities."""
    numbers = changed(changed(blank(RunNumbers), base), changes)
    return with_quantities(numbers, of_sound, {}, of_estimate)
