"""Identities of scenes: the keys that make a march, digests of whole scenes, and differences."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rolling.scene import library
from rolling.scene.height_files import file_digest
from rolling.scene.messages import plain_number, quoted
from rolling.scene.scene import Scene
from rolling.scene.sections import VIBRATING_PLATE
from rolling.scene.sweep import product, run_name, with_paths, with_values
from rolling.scene.swept import SweepRun, SweptScene

# The march does not depend on these keys. The number of steps stands for duration, distance and
# speed. Densities, thickness, edges and loss factors belong to the vibration. A name stands beside
# its values. Passes count with memory only.
_NOT_CONTACT = {
    "name",
    "title",
    "description",
    "listen_for",
    "sound",
    "sweep",
    "dynamics",
    "numerics.error_estimate",
    "numerics.slowest_m_s",
    "numerics.within_db",
    "rolling.speed_m_s",
    "rolling.duration_s",
    "rolling.distance_mm",
    "rolling.resistance",
    "rolling.drop_mm",
    "rolling.passes",
    "plate.plasticity",
    "sphere.density_kg_m3",
}.union(library.NAME_KEYS, (f"plate.{name}" for name in VIBRATING_PLATE))


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
    keys |= {
        "numerics.tolerance": scene.tolerance,
        "numerics.step_nodes": scene.step_nodes,
        "rolling.load_n": scene.load,
    }
    del keys["rolling.across_um"]
    if scene.across_nodes:
        keys["across_nodes"] = scene.across_nodes
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


def scene_identity(scene: SweptScene) -> str:
    """Return the SHA-256 of all values of all runs; height files count with their digests.

    A number that `auto` chose counts as the same number in the scene.
    """
    return digest(list(_runs(scene)))


def differences(old: SweptScene, new: SweptScene) -> list[str]:
    """List the keys where two scenes differ, as "key: got VALUE of new, has VALUE of old"."""
    before = _flat(_with_whole_numbers(_with_shared_choices(old)))
    after = _flat(_with_whole_numbers(_with_shared_choices(new)))
    keys = list(dict.fromkeys([*after, *before]))
    if before.get("surface.kind") != after.get("surface.kind"):
        keys = [key for key in keys if key == "surface.kind" or not key.startswith("surface.")]
    # A path of a height file stands at the end of a key, or in the swept section.
    keys = [key for key in keys if not ("surface.path" in key or key.split(".")[-1] == "path")]
    # The runs tell whether auto chose the same.
    keys = [key for key in keys if key not in old.chosen_keys & new.chosen_keys]
    lines = [
        f"{key}: got {quoted(after.get(key))}, has {quoted(before.get(key))}"
        for key in keys
        if before.get(key) != after.get(key)
    ]
    if lines:
        return [*lines, *_other_choices(old, new)]
    old_runs = [name for name, _ in _runs(old)]
    new_runs = [name for name, _ in _runs(new)]
    if old_runs != new_runs:
        return [f"sweep: got the runs {quoted(new_runs)}, has {quoted(old_runs)}"]
    if scene_identity(old) != scene_identity(new):
        section = next(iter(new.height_paths), "surface")
        return [f"{section}.path: the heights are others than those of the earlier run"]
    return []


def contains(small: SweptScene, large: SweptScene) -> bool:
    """Tell whether each run of one scene is a run, under the same name, of another scene."""
    runs = dict(_runs(large))
    return all(runs.get(name) == values for name, values in _runs(small))


def digest(values: Any) -> str:
    """Return the SHA-256 of plain values as canonical JSON."""
    text = json.dumps(values, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _runs(scene: SweptScene) -> Iterator[tuple[str, Any]]:
    """Yield name and plain values of each run of a scene."""
    data = {name: value for name, value in scene.to_dict().items() if name != "sweep"}
    runs: Sequence[SweepRun[Any]] = scene.runs()
    for (values, forms), run in zip(product(scene.sweep), runs, strict=True):
        swept = with_paths(with_values(data, forms), lambda path: file_digest(scene.folder / path))
        swept = _with_taken(swept, run.scene.taken_values)
        yield run_name(values), _with_whole_numbers(swept)


def _with_taken(data: dict[str, Any], taken: Mapping[str, float]) -> dict[str, Any]:
    """Return plain values with the numbers that stand for auto, by dotted key."""
    for key, value in taken.items():
        section, _, name = key.partition(".")
        data = data | {section: {**data[section], name: value}}
    return data


def _with_shared_choices(scene: SweptScene) -> dict[str, Any]:
    """Return the plain values of a scene, with a number for auto where all runs share it."""
    taken = [run.scene.taken_values for run in scene.runs()]
    shared = {
        key: value
        for key, value in taken[0].items()
        if key not in scene.sweep and all(of_run.get(key) == value for of_run in taken)
    }
    return _with_taken(scene.to_dict(), shared)


def _other_choices(old: SweptScene, new: SweptScene) -> Iterator[str]:
    """Yield a line where a sweep grows by a run for which auto takes another number."""
    now = {run_name(run.values): run.scene.taken_values for run in new.runs()}
    named_keys = set[str]()
    for values, scene in old.runs():
        name = run_name(values)
        for key, before in scene.taken_values.items():
            after = now.get(name, {}).get(key)
            if after is None or before == after or key in named_keys:
                continue
            named_keys.add(key)
            yield (
                f"{key}: auto takes {plain_number(after)} for all runs, and {name} has"
                f" {plain_number(before)}: `--set {key}={plain_number(before)}` keeps its march"
            )


def _with_whole_numbers(value: Any) -> Any:
    """Return plain values whose whole numbers are integers, so that 5 and 5.0 are equal text."""
    if isinstance(value, dict):
        return {name: _with_whole_numbers(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_with_whole_numbers(item) for item in value]
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
