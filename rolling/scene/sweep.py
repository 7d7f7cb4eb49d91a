"""Sweep of a scene: its lists of values, their product, and names, faults, identities of its runs.

Values are numbers, names, or anything under labels, such as two surfaces or two speed profiles.
The model of a scene is handed in as `root`, because a scene holds its sweep. Keys that change the
contact identify a march, and digests whole scenes.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import PydanticCustomError

from rolling.scene import library, messages
from rolling.scene.bodies import VIBRATING_PLATE
from rolling.scene.height_files import file_digest
from rolling.scene.messages import Key, dotted, fault, plain_number, shown
from rolling.scene.sections import MAX_FAULTS

if TYPE_CHECKING:
    from rolling.scene.scene import Scene

MAX_RUNS = 10_000  # maximum number of runs of a sweep
LONGEST_LABEL = 100  # letters
LONGEST_NAME = 120  # bytes; temporary names add to it, and some file systems end at 143
_LONGEST_TEXT = 40  # letters of a text in a name
Fault = tuple[Key, str]  # key and message
_Model = TypeVar("_Model", bound=BaseModel)
Value = float | str  # number, text, or label of a swept value
Choice = tuple[Value, Any]  # value as names and tables show it, and its plain form for the scene


# ---- names of runs


def run_name(values: Mapping[str, Value]) -> str:
    """Return the name of a run by its own values alone, such as "load_n=5,radius_mm=2".

    Each key stands with its last part unless two keys share it. Numbers stand with all digits; a
    text that is not fit for every file system ends in a digest. Runs without values have an empty
    name.
    """
    last = [key.rpartition(".")[2] for key in values]
    name = ",".join(
        f"{short if last.count(short) == 1 else key}={_written(value)}"
        for short, (key, value) in zip(last, values.items(), strict=True)
    )
    if len(name) <= LONGEST_NAME:
        return name
    exact = ",".join(f"{key}={value!r}" for key, value in values.items())
    return f"{name[: LONGEST_NAME - 17]}-{_digest(exact)}"


def _written(value: Value) -> str:
    """Write a number with all digits, or a text in letters that every file system takes."""
    if not isinstance(value, str):
        return repr(value) if isinstance(value, int) else plain_number(value)
    short = re.sub(r"[^A-Za-z0-9._+-]+", "-", value.strip("./\\ "))[-_LONGEST_TEXT:].strip("-")
    return short if short == value else f"{short or '-'}-{_digest(value)[:6]}"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()[:16]


# ---- validation


def validated(sweep: Any, root: type[BaseModel]) -> dict[str, Any]:
    """Turn the lists of a sweep into tuples; raise its first fault at its own place."""
    if not isinstance(sweep, dict):
        raise fault(
            f"got {shown(sweep)}, allowed: lists of numbers by dotted key, as in rolling.load_n:"
            " [5, 20]",
            at="sweep",
        )
    for name, listed in sweep.items():
        _refuse_form(name, listed, root)
    runs = math.prod(map(len, sweep.values()))
    if runs > MAX_RUNS:  # refused before any value is looked at
        raise fault(f"got {runs} runs, allowed: at most {MAX_RUNS}", at="sweep")
    for name, listed in sweep.items():
        _refuse_values(name, listed, root)
    return {
        name: dict(listed) if isinstance(listed, dict) else tuple(listed)
        for name, listed in sweep.items()
    }


def _refuse_form(name: Any, listed: Any, root: type[BaseModel]) -> None:
    """Raise a fault for an unknown key, or for values that are no list and have no labels."""
    known = [*messages.keys(root), *messages.section_keys(root)]
    if name not in known:
        like = messages.nearest(name, known) if isinstance(name, str) else ""
        raise fault(f"unknown key{like}", at=("sweep", str(name)))
    if isinstance(listed, dict) and listed:
        return
    if name in messages.section_keys(root):
        form = f"sections by label, as in {name}: {{first: {{...}}, second: {{...}}}}"
    elif not isinstance(listed, list | tuple) or not listed:
        kind = "numbers" if name in messages.numeric_keys(root) else "names"
        form = f"a list of {kind}, at least one"
    else:
        return
    raise fault(f"got {shown(listed)}, allowed: {form}", at=("sweep", name))


def _refuse_values(name: str, listed: Any, root: type[BaseModel]) -> None:
    """Raise the first fault of the values of one key."""
    numeric, seen = name in messages.numeric_keys(root), dict[str, Value]()
    words_too = messages.words_for_numbers(root).get(name, ())
    for i, (value, form) in enumerate(choices(listed)):
        at: Key = ("sweep", name, i)
        labelled = ""
        if isinstance(value, list | tuple | dict | bool):
            labelled = f"; any other value has a label, as in {name}: {{first: {shown(value)}}}"
        if isinstance(listed, dict):
            at = ("sweep", name)
            if not isinstance(value, str) or not 0 < len(value) <= LONGEST_LABEL:
                raise fault(
                    f"got {shown(value)} as a label, allowed: text of 1 to {LONGEST_LABEL} letters",
                    at=at,
                )
            if name in messages.section_keys(root) and not isinstance(form, dict):
                raise fault(f"got {shown(form)}, allowed: a section", at=(*at, value))
        elif numeric and not messages.is_number(value) and value not in words_too:
            numbers = " or ".join(["a number", *words_too])
            raise fault(f"got {shown(value)}, allowed: {numbers}{labelled}", at=at)
        elif not numeric and (not isinstance(value, str) or not value):
            raise fault(f"got {shown(value)}, allowed: text{labelled}", at=at)
        before = seen.setdefault(_written(value).casefold(), value)
        if before != value:
            raise fault(
                f"got {shown(value)} beside {shown(before)}, allowed: texts that differ in more"
                " than upper and lower case",
                at=at,
            )
        if len(seen) <= i:
            raise fault(f"got {shown(value)} twice, allowed: different values", at=at)


# ---- runs


def choices(listed: Any) -> list[Choice]:
    """Return the values of one key, each with the form that a scene takes."""
    return [*listed.items()] if isinstance(listed, dict) else [(value, value) for value in listed]


def product(sweep: Mapping[str, Any]) -> Iterator[tuple[dict[str, Value], dict[str, Any]]]:
    """Yield the values of each run by dotted key, and their plain forms; the last is fastest."""
    for row in itertools.product(*map(choices, sweep.values())):
        values = {name: value for name, (value, _) in zip(sweep, row, strict=True)}
        forms = {name: form for name, (_, form) in zip(sweep, row, strict=True)}
        yield values, forms


def with_values(data: Mapping[str, Any], forms: Mapping[str, Any]) -> dict[str, Any]:
    """Return the plain values of a scene with the values of one run, sections first."""
    result: Any = data
    for name in sorted(forms, key=lambda name: (name.count("."), library.names_first(name))):
        result = library.freed(result, name, forms[name])
        result = _changed(result, messages.key_of(name), forms[name])
    return {
        name: library.filled(name, part) if name in library.NAMES else part
        for name, part in result.items()
    }


def with_value(data: Mapping[str, Any], name: str, value: Any) -> dict[str, Any]:
    """Return plain values with the value of a dotted name, which leaves the sweep."""
    key, material = messages.key_of(name), library.name_of("plate", data.get("plate"))
    if name == "plate.hardness_gpa" and value is None and material:
        value = library.NONE  # which the material would give again
    result: dict[str, Any] = _changed(library.freed(data, name, value), key, value)
    if len(key) > 1 and key[0] != "sweep" and isinstance(swept := result.get("sweep"), dict):
        result["sweep"] = {other: listed for other, listed in swept.items() if other != name}
    return result


def _changed(values: Any, key: Key, form: Any) -> Any:
    """Return plain values with another value at a key; values in place of a section stay."""
    if not key:
        return form
    values = {} if values is None else values
    if not isinstance(values, Mapping):
        return values
    name = str(key[0])
    return {**values, name: _changed(values.get(name), key[1:], form)}


def with_paths(data: Mapping[str, Any], moved: Callable[[str], str]) -> dict[str, Any]:
    """Return the plain values of a scene with other paths of height files, swept ones as well.

    Swept paths keep their text as labels.
    """

    def section(name: str, values: Any) -> Any:
        if name == "path" and isinstance(values, str):
            return moved(values)
        inner = {"surface": "path", "sphere": "surface"}.get(name)
        if inner and isinstance(values, dict) and inner in values:
            return {**values, inner: section(inner, values[inner])}
        return values

    result = {name: section(name, values) for name, values in data.items()}
    for name, listed in data.get("sweep", {}).items():
        last = name.rpartition(".")[2]
        if last in ("path", "surface", "sphere"):
            moved_forms = {str(label): section(last, form) for label, form in choices(listed)}
            result["sweep"] = {**result["sweep"], name: moved_forms}
    return result


# ---- faults of runs


def faults_of_runs(
    data: Mapping[str, Any], known_faults: list[Fault], root: type[BaseModel]
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
    known, faults = {key for key, _ in known_faults}, dict[Fault, None]()
    # Many runs share a fault, and wording it takes longer than detecting it.
    in_words: dict[Any, Fault] = {}
    for values, forms in product(sweep) if sweep else ():
        swept = with_values(unswept, forms)
        for error in checked(swept, root)[1]:
            plain = isinstance(error["input"], bool | int | float | str)
            alike = (error["loc"], error["type"], error["msg"], shown(error["input"]) * plain)
            if alike not in in_words:
                in_words[alike] = messages.explained(error, swept, root)
            key, message = in_words[alike]
            outer = {dotted(key[:n]): n for n in range(len(key), 0, -1)}
            name = next((name for name in outer if name in values), None)
            if name is not None:
                inner = key[outer[name] :]
                listed, value = sweep[name], values[name]
                place = str(value) if isinstance(listed, dict) else listed.index(value)
                faults[("sweep", name, place, *inner), message] = None
            elif key not in known:
                known.add(key)
                faults[key, f"{message} (in the run {run_name(values)} of the sweep)"] = None
        if len(faults) > MAX_FAULTS:
            break
    return list(faults)


def checked(data: Mapping[str, Any], root: type[_Model]) -> tuple[_Model | None, list[Any]]:
    """Return the scene of plain values, or its faults: at most one more than are named."""
    try:
        return root.model_validate(data), []
    except ValidationError as error:
        return None, error.errors(include_url=False)[: MAX_FAULTS + 1]


# ---- identities


# The march does not depend on these keys. The number of steps stands for duration, distance and
# speed. Densities, thickness, edges and loss factors belong to the vibration. A name stands beside
# its values. Passes count with memory only.
_NOT_CONTACT = {
    *("name", "title", "description", "sound", "sweep", "dynamics", "numerics.error_estimate"),
    *("rolling.speed_m_s", "rolling.duration_s", "rolling.distance_mm", "rolling.resistance"),
    *("rolling.drop_mm", "rolling.passes", "plate.plasticity", "sphere.density_kg_m3"),
    *library.NAME_KEYS,
    *(f"plate.{name}" for name in VIBRATING_PLATE),
}


def contact_keys(scene: Scene) -> dict[str, Any]:
    """Return the values by dotted key that change the march of a scene without a sweep.

    The digest of a height file stands for its path. Raise SceneError for a missing height file.
    """
    track = scene.track
    keys = {
        key: value
        for key, value in _flat(scene.model_dump(mode="json", exclude_none=True)).items()
        if key not in _NOT_CONTACT and key.partition(".")[0] not in _NOT_CONTACT
    }
    keys |= {"numerics.tolerance": scene.tolerance, "rolling.load_n": scene.load}
    if scene.is_permanent:
        keys["passes"] = scene.passes
    for section, path in scene.height_paths.items():
        del keys[f"{section}.path"]
        keys[f"{section}.sha256"] = file_digest(path)
    return keys | {
        "track.n_along": track.n_along,
        "track.n_across": track.n_across,
        "track.solved_steps": track.solved_steps,
    }


def scene_identity(scene: Scene) -> str:
    """Return the SHA-256 of all values of all runs; height files count with their digests."""
    return digest(list(_runs(scene)))


def differences(old: Scene, new: Scene) -> list[str]:
    """List the keys where two scenes differ, as "key: got VALUE of new, has VALUE of old"."""
    before, after = _flat(_numbers(old.to_dict())), _flat(_numbers(new.to_dict()))
    keys = list(dict.fromkeys([*after, *before]))
    if before["surface.kind"] != after["surface.kind"]:
        keys = [key for key in keys if key == "surface.kind" or not key.startswith("surface.")]
    # A path of a height file stands at the end of a key, or in the swept section.
    keys = [key for key in keys if not ("surface.path" in key or key.split(".")[-1] == "path")]
    lines = [
        f"{key}: got {shown(after.get(key))}, has {shown(before.get(key))}"
        for key in keys
        if before.get(key) != after.get(key)
    ]
    if lines:
        return lines
    names, runs = [name for name, _ in _runs(old)], [name for name, _ in _runs(new)]
    if names != runs:
        return [f"sweep: got the runs {shown(runs)}, has {shown(names)}"]
    if scene_identity(old) != scene_identity(new):
        section = next(iter(new.height_paths), "surface")
        return [f"{section}.path: the heights are others than those of the earlier run"]
    return []


def contains(small: Scene, large: Scene) -> bool:
    """Tell whether each run of one scene is a run, under the same name, of another scene."""
    runs = dict(_runs(large))
    return all(runs.get(name) == values for name, values in _runs(small))


def digest(values: Any) -> str:
    """Return the SHA-256 of plain values as canonical JSON."""
    text = json.dumps(values, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _runs(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Yield name and plain values of each run of a scene."""
    data = {name: value for name, value in scene.to_dict().items() if name != "sweep"}
    for values, forms in product(scene.sweep):
        swept = with_paths(with_values(data, forms), lambda path: file_digest(scene.folder / path))
        yield run_name(values), _numbers(swept)


def _numbers(value: Any) -> Any:
    """Return plain values whose whole numbers are integers, so that 5 and 5.0 are equal text."""
    if isinstance(value, dict):
        return {name: _numbers(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_numbers(item) for item in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _flat(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return values by dotted key; an empty section has the value true."""
    flat: dict[str, Any] = {}
    for name, value in data.items():
        if isinstance(value, Mapping) and value:
            flat |= _flat(value, f"{prefix}{name}.")
        else:
            flat[f"{prefix}{name}"] = True if isinstance(value, Mapping) else value
    return flat
