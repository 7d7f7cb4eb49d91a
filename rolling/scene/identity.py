"""Identities of scenes: keys that change the contact, digests, and differences in words."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from rolling.scene import sweep as sweeps
from rolling.scene.messages import SceneError, plain_number, shown
from rolling.scene.scene import Scene
from rolling.scene.yaml_text import open_regular

# The march does not depend on these keys. The number of steps stands for duration, distance and
# speed. Densities, thickness and loss factor belong to the vibration.
_NOT_CONTACT = {
    "name",
    "title",
    "description",
    "sound",
    "sweep",
    "dynamics",
    "rolling.speed_m_s",
    "rolling.duration_s",
    "rolling.distance_mm",
    "sphere.density_kg_m3",
    "plate.density_kg_m3",
    "plate.thickness_mm",
    "plate.loss_factor",
    "numerics.error_estimate",
}
_PATH, _HEIGHTS = "surface.path", "surface.sha256"
_CHUNK = 2**20  # bytes


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
    keys["numerics.tolerance"] = scene.tolerance
    if scene.height_path is not None:
        del keys[_PATH]
        keys[_HEIGHTS] = file_digest(scene.height_path)
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
    lines = [
        f"{key}: got {shown(after.get(key))}, has {shown(before.get(key))}"
        for key in keys
        if before.get(key) != after.get(key) and not _is_path(key)
    ]
    if lines:
        return lines
    names, runs = [name for name, _ in _runs(old)], [name for name, _ in _runs(new)]
    if names != runs:
        return [f"sweep: got the runs {shown(runs)}, has {shown(names)}"]
    if scene_identity(old) != scene_identity(new):
        return [f"{_PATH}: the heights are others than those of the earlier run"]
    return []


def _is_path(key: str) -> bool:
    """Tell whether a dotted key holds the path of a height file, swept or not."""
    return _PATH in key or key.rpartition(".")[2] == "path"


def contains(small: Scene, large: Scene) -> bool:
    """Tell whether each run of one scene is a run, under the same name, of another scene."""
    runs = dict(_runs(large))
    return all(runs.get(name) == values for name, values in _runs(small))


def digest(values: Any) -> str:
    """Return the SHA-256 of plain values as canonical JSON."""
    text = json.dumps(values, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of the bytes of a height file; raise SceneError if it is unreadable."""
    try:
        stamp = path.stat()
        return _file_digest(path, (stamp.st_mtime_ns, stamp.st_size, stamp.st_ino))
    except OSError as error:
        raise SceneError([f"{_PATH}: {path}: not readable ({error.strerror or error})"]) from error


@lru_cache(maxsize=1000)
def _file_digest(path: Path, stamp: tuple[int, ...]) -> str:
    result = hashlib.sha256()
    with open_regular(path) as file:
        while chunk := file.read(_CHUNK):
            result.update(chunk)
    return result.hexdigest()


def _runs(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Yield name and plain values of each run of a scene."""
    data = {name: value for name, value in scene.to_dict().items() if name != "sweep"}
    for values, forms in sweeps.product(scene.sweep):
        swept = sweeps.with_values(data, forms)
        if "path" in swept["surface"]:
            surface = dict(swept["surface"])
            surface["sha256"] = file_digest(scene.folder / surface.pop("path"))
            swept["surface"] = surface
        yield sweeps.run_name(values), _numbers(swept)


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


# The march does not depend on these keys. `resound` changes speed and duration, and the number of
# steps stands for both, and for a distance. The path may change with the folder, and the digest of
# the heights stands for it. Densities, thickness and loss factor belong to the vibration, whose
# marches at other loads stand beside the march. The error estimate follows the march.
NOT_PHYSICS = {
    "name",
    "title",
    "description",
    "sound",
    "sweep",
    "rolling.speed_m_s",
    "rolling.duration_s",
    "rolling.distance_mm",
    "surface.path",
    "sphere.density_kg_m3",
    "plate.density_kg_m3",
    "plate.thickness_mm",
    "plate.loss_factor",
    "dynamics",
    "numerics.error_estimate",
}
STEPS, KIND = "track.steps", "surface.kind"


@dataclass(frozen=True)
class Identity:
    """Physics of a single run.

    Attributes
    ----------
    physics : dict
        Values by dotted key, with all defaults filled in. A section has the value true, or null
        where it is absent.
    defaults : dict
        Defaults by dotted key in the version that wrote the physics.
    heights_sha256 : str or None
        Digest of the heights that were read from a file; None where the surface is generated.
    """

    physics: dict[str, Any]
    defaults: dict[str, Any]
    heights_sha256: str | None

    @classmethod
    def of(cls, scene: Scene, heights_sha256: str | None) -> Identity:
        """Extract the physics from a scene without a sweep."""
        physics = {
            key: value
            for key, value in _old_flat(scene.model_dump(mode="json")).items()
            if _is_physics(key)
        }
        defaults = {
            key: value for key, value in _old_flat(_defaults(scene)).items() if _is_physics(key)
        }
        return cls(physics | {STEPS: scene.track.steps}, defaults, heights_sha256)

    @cached_property
    def text(self) -> str:
        """Physics as canonical JSON."""
        return canonical(self.physics)

    @property
    def sha256(self) -> str:
        """Digest of the canonical JSON."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def canonical(values: Mapping[str, Any]) -> str:
    """Write values as JSON text that is equal for equal values."""
    return json.dumps(values, sort_keys=True, separators=(",", ":"), allow_nan=False)


def heights_digest(heights: NDArray[np.float64]) -> str:
    """Return the SHA-256 of heights.

    It covers their shape, then their values in little-endian double precision.
    """
    digest = hashlib.sha256(f"{heights.shape[0]} x {heights.shape[1]}\n".encode())
    digest.update(np.ascontiguousarray(heights, dtype="<f8").data)
    return digest.hexdigest()


def identity_differences(
    solved: Identity, own: Identity, result: str, height_path: Path | None
) -> list[str]:
    """List the differences between the identities of a stored result and of a scene.

    Parameters
    ----------
    solved, own : Identity
        Identities of the result and of the scene.
    result : str
        Name of the result file in the messages.
    height_path : Path or None
        File of the scene's heights.
    """
    lines = []
    changed = changes(solved, own)
    for key, (old, new) in changed.items():
        if key == STEPS:
            lines.append(
                f"rolling.duration_s: {result} has {shown(old)} steps, the scene asks for"
                f" {shown(new)}"
            )
        else:
            lines.append(f"{key}: {result} was solved with {said(old)}, the scene says {said(new)}")
    surface = other_surface(solved.heights_sha256, own.heights_sha256, height_path)
    return [*lines, surface] if surface and KIND not in changed else lines


def changes(before: Identity, after: Identity) -> dict[str, tuple[Any, Any]]:
    """Return both values of each key where the physics differs.

    For a surface of another kind, only the kind is returned.

    A key that one side lacks has the default of the other side, which knows it.
    """
    old, new = {**after.defaults, **before.physics}, {**before.defaults, **after.physics}
    keys = sorted({*before.physics, *after.physics})
    if old.get(KIND) != new.get(KIND):
        keys = [key for key in keys if key == KIND or not key.startswith("surface.")]
    return {key: (old.get(key), new.get(key)) for key in keys if old.get(key) != new.get(key)}


def other_surface(solved: str | None, own: str | None, height_path: Path | None) -> str | None:
    """Write a message where the digests of heights differ.

    Return None where they agree or the surface is generated.
    """
    if solved == own:
        return None
    digests = [f"{digest[:16]}..." if digest else "none" for digest in (own, solved)]
    return (
        f"{height_path} is not the surface that was solved: SHA-256 of its heights"
        f" {digests[0]}, of the solved heights {digests[1]}"
    )


def _is_physics(key: str) -> bool:
    return key not in NOT_PHYSICS and key.partition(".")[0] not in NOT_PHYSICS


def _old_flat(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return values by dotted key; a section has the value true."""
    flat: dict[str, Any] = {}
    for name, value in data.items():
        if isinstance(value, Mapping):
            flat |= {f"{prefix}{name}": True, **_old_flat(value, f"{prefix}{name}.")}
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def _defaults(model: BaseModel) -> dict[str, Any]:
    """Return the defaults of the optional keys of a model and of its sections."""
    defaults: dict[str, Any] = {}
    for name, field in type(model).model_fields.items():
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            defaults[name] = _defaults(value)
        elif not field.is_required():
            defaults[name] = field.get_default(call_default_factory=True)
    return defaults


def said(value: Any) -> str:
    """Write a value of the physics in the form of a scene file."""
    return plain_number(value) if isinstance(value, float) else shown(value)
