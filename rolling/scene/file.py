"""Reading of scenes from YAML, writing, overrides, and the JSON Schema for editors."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedSeq

from rolling.scene import library, messages, yaml_text
from rolling.scene.bodies import VIBRATING_PLATE, Sphere
from rolling.scene.messages import Key, SceneError, all_keys, shown
from rolling.scene.quantities import motion_of
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT, Rolling, Sound
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import with_value
from rolling.scene.yaml_text import TextError

# ---- reading, writing, overriding


def read_scene(path: Path | str, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : Path or str
        File of YAML 1.2 in UTF-8, or the name of a scene of the library, such as "quickstart", if
        there is no such file. A scene found by name reads its height file from the current folder,
        unless the library has that file too.
    overrides : sequence of str
        Values such as "rolling.load_n=50", written in YAML. No value (or null) removes an optional
        key or section. A key that the scene sweeps leaves the sweep when it is set;
        "sweep.rolling.load_n=[5, 20]" sweeps it.

    Raises
    ------
    SceneError
        File or overrides have faults; each is named.

    Examples
    --------
    `read_scene("scenarios/quickstart.yaml", ["rolling.load_n=50"])`
    """
    path = Path(path)
    file = library.find(path)
    try:
        text = yaml_text.read_text(file)
    except TextError as error:
        raise SceneError([str(error)]) from error
    is_whole = file == path or library.companions(file)
    return loads(text, overrides, str(file), file.parent if is_whole else Path())


def loads(
    text: str, overrides: Sequence[str] = (), where: str = "scene", folder: Path = Path()
) -> Scene:
    """Read a scene from text; raise SceneError with all faults of text and overrides.

    Parameters
    ----------
    where : str
        Name of the text in messages.
    folder : Path
        Folder that a relative `surface.path` starts from.
    """
    try:
        data, lines = yaml_text.parse(text, where)
    except TextError as error:
        raise SceneError([str(error)]) from error
    if data is None:
        needed = ", ".join(name for name, key in Scene.model_fields.items() if key.is_required())
        raise SceneError([f"{where}: empty, a scene needs at least name, {needed}"])
    if not isinstance(data, dict):
        words = "a scene of keys and values, the first being name"
        raise SceneError([f"{where}:1: got {shown(data)}, allowed: {words}"])
    places = {key: f"{where}:{line}" for key, line in lines.items()}
    return Scene.from_dict(data, folder, places, _override(data, places, overrides))


def _bare(error: TextError) -> str:
    """Return the message of a fault without its place."""
    return re.sub(r"^[^ ]*: (\d+: )?", "", str(error))


def dump(scene: Scene) -> str:
    """Write a scene as YAML text with every default filled in.

    `loads` makes an equal scene from the text.
    """
    yaml = YAML(typ="rt")
    yaml.width = 4096
    stream = io.StringIO()
    yaml.dump(_flowing(scene.to_dict()), stream)
    return stream.getvalue()


def _flowing(value: Any) -> Any:
    """Mark lists so that YAML writes each on one line."""
    if isinstance(value, dict):
        return {name: _flowing(item) for name, item in value.items()}
    if isinstance(value, list):
        line = CommentedSeq(_flowing(item) for item in value)
        line.fa.set_flow_style()
        return line
    return value


def _override(data: dict[str, Any], places: dict[Key, str], overrides: Sequence[str]) -> list[str]:
    """Put overrides into `data` and `places`, and return the faults of wrong overrides."""
    faults = []
    for override in sorted(overrides, key=lambda text: library.names_first(text.partition("=")[0])):
        name, equals, text = override.partition("=")
        name = name.strip()
        if not equals or not name:
            example = "key=value, as in rolling.load_n=50"
            faults.append(f"--set: got {shown(override)}, allowed: {example}")
        elif name not in all_keys(Scene):
            faults.append(f"--set: {name}: {messages.unknown_name(name, Scene)}")
        else:
            try:
                data |= with_value(data, name, yaml_text.parse(text, "--set")[0])
            except TextError as error:
                faults.append(f"--set: {name}: {_bare(error)}")
                continue
            key = messages.key_of(name)
            for inner in [other for other in places if other[: len(key)] == key]:
                del places[inner]
            places[key] = "--set"
    return faults


# ---- new sound from a stored run


RESOUND_KEYS = (
    "rolling.speed_m_s",
    "rolling.drop_mm",
    "sphere.density_kg_m3",
    *(f"plate.{name}" for name in VIBRATING_PLATE),
    "dynamics.release",
    *(f"sound.{name}" for name in Sound.model_fields),
)


def resound(scene: Scene, overrides: Sequence[str]) -> Scene:
    """Give the scene of a stored run another speed, mass, thickness or sound.

    Track and contact stay as they are. `duration_s`, where the scene has one, becomes the time
    that the same track takes.

    Raises
    ------
    SceneError
        A key needs a new solution, a value is not allowed, or the sphere comes to rest before the
        track ends.
    """
    names = {override: override.partition("=")[0].strip() for override in overrides}
    free = [key for key in RESOUND_KEYS if key not in _bound_keys(scene)]
    solved = {*all_keys(Scene)} - {*free, "sound"}
    faults = [
        f"--set: {name}: needs a new run; without solving again allowed: {', '.join(free)}"
        for name in names.values()
        if name in solved
    ]
    data = scene.to_dict()
    places: dict[Key, str] = {(): "stored scene"}
    faults += _override(data, places, [text for text, name in names.items() if name not in solved])
    if not faults and scene.rolling.duration_s is not None:
        made = not isinstance(scene.surface, HeightFile)
        rolled = float(scene.motion.distance(scene.rolling.duration_s))
        try:
            sphere = Sphere.model_validate(data["sphere"])
            motion = motion_of(sphere, Rolling.model_validate(data["rolling"]))
            duration = motion.duration(scene.track.distance if made else rolled)
            data["rolling"]["duration_s"] = float(f"{duration:.12g}")
        except ValidationError:
            pass  # `from_dict` refuses the new speed
        except ValueError as error:
            faults.append(f"--set: rolling.speed_m_s: {error}, the end of the stored run")
    return Scene.from_dict(data, scene.folder, places, faults)


def _bound_keys(scene: Scene) -> set[str]:
    """Return keys that change the load or the rolling out, and with it the contact or the track."""
    rolls_out = scene.rolling.resistance is not None
    bound = {"rolling.speed_m_s"} if rolls_out else set[str]()
    if rolls_out or scene.rolling.load_n == WEIGHT:
        bound.add("sphere.density_kg_m3")
    return bound


# ---- schema


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a scene file, for editors."""
    result = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Scene.model_json_schema(),
    }
    result["title"] = "Scene of rolling contact noise"
    result["description"] = (
        "A sphere that rolls on a rough surface, how its contact is solved, and where it is heard."
    )
    numbers = {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"type": "number"}}
    names = {**numbers, "items": {"type": "string"}}
    labelled = {"type": "object", "minProperties": 1}
    lists = dict.fromkeys(messages.numeric_keys(Scene), numbers) | {
        key: numbers | {"items": {"anyOf": [{"type": "number"}, {"enum": [*words]}]}}
        for key, words in messages.words_for_numbers(Scene).items()
    }
    result["properties"]["sweep"] |= {
        "properties": {
            key: {"anyOf": [lists.get(key, names), labelled]} for key in messages.keys(Scene)
        }
        | dict.fromkeys(messages.section_keys(Scene), labelled),
        "additionalProperties": False,
    }
    return result
