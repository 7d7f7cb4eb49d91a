"""Scene files: reading, writing, overrides, a new sound of a stored run, and the JSON Schema."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedSeq

from acoustics.arrays import instance
from acoustics.numbers import micrometres, rounded_up
from rolling.scene import library
from rolling.scene.messages import Key, Mistake, SceneError, key_of, quoted
from rolling.scene.models import all_keys, unknown_name
from rolling.scene.scene import Scene
from rolling.scene.sections import VIBRATING_PLATE, WEIGHT, Rolling, Sound, Sphere
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import with_value
from rolling.scene.swept import AnyScene, SweptScene
from rolling.scene.values_in_si import motion_of
from rolling.scene.yaml_text import parse, read_text

SET = "--set"  # place of the overrides in messages
STORED_MARK = "# rolling-contact-noise run folder"  # the scene of a run folder begins so

# ---- reading, writing, overriding


def read_as(path: Path | str, model: type[AnyScene], overrides: Sequence[str] = ()) -> AnyScene:
    """Read a scene file of a kind; raise SceneError with all mistakes of file and overrides."""
    instance("path", path, str, Path)
    if isinstance(overrides, Mapping) or not all(isinstance(word, str) for word in overrides):
        raise TypeError(
            f"overrides: got {quoted(overrides)}, allowed: texts, as in ['rolling.load_n=50'];"
            " read_scene(path).with_(load_n=50) takes values"
        )
    path = Path(path)
    file = library.find(path)
    is_whole = file == path or bool(library.companions(file))
    scene: AnyScene = loads(
        read_text(file),
        overrides=[overrides] if isinstance(overrides, str) else overrides,
        where=str(file),
        folder=file.parent if is_whole else Path(),
        model=model,
    )
    return scene


def loads(
    text: str,
    overrides: Sequence[str] = (),
    where: str = "scene",
    folder: Path = Path(),
    model: type[SweptScene] = Scene,
) -> Any:
    """Read a scene of a kind from text; raise SceneError with all mistakes of text and overrides.

    The scene of a run folder has every default filled in. What it lacks, the version that wrote it
    did not know, so it takes what that version did in place of a default of today.

    Parameters
    ----------
    text : str
        YAML.
    overrides : sequence of str
        Values such as "rolling.load_n=50".
    where : str
        Name of the text in messages.
    folder : Path
        Folder that relative paths of height files start from.
    model : type
        Class of the scenes of the kind.
    """
    try:
        parsed = parse(text, where)
    except SceneError as error:  # no YAML, so that only the overrides are left to judge
        wrong = _with_overrides({}, {}, overrides, model).mistakes
        raise SceneError([*error.mistakes, *(entry.line for entry in wrong)]) from error
    data = parsed.value
    if data is None:
        needed = ", ".join(name for name, key in model.model_fields.items() if key.is_required())
        raise SceneError([f"{where}: empty, a scene needs at least name, {needed}"])
    if not isinstance(data, dict):
        words = "a scene of keys and values, the first being name"
        raise SceneError([f"{where}:1: got {quoted(data)}, allowed: {words}"])
    places = {key: f"{where}:{line}" for key, line in parsed.lines.items()}
    _refuse_other_kind(data, places, model)
    if text.startswith(STORED_MARK):
        data = _with_former_values(data, model)
    changed = _with_overrides(data, places, overrides, model)
    return model.from_dict(changed.data, folder, places, [*parsed.mistakes, *changed.mistakes])


def _with_former_values(data: dict[str, Any], model: type[SweptScene]) -> dict[str, Any]:
    """Return the plain values of a stored scene with those of keys that it did not know."""
    for name, value in model.FORMER_VALUES.items():
        section, _, key = name.partition(".")
        known = data.get(section)
        if isinstance(known, dict) and key not in known:
            data = data | {section: {**known, key: value}}
    return data


def _refuse_other_kind(
    data: dict[str, Any], places: Mapping[Key, str], model: type[SweptScene]
) -> None:
    """Refuse a scene of another kind, by the section that tells what it is of."""
    if model.SECTION in data:
        return
    for other in sections_of_scenes(SweptScene):
        if other in data:
            raise SceneError(
                [f"{places[(other,)]}: {other}: allowed here: a scene with {model.SECTION}"]
            )


def sections_of_scenes(base: type[SweptScene]) -> set[str]:
    """Return the sections that tell what scenes are of, of all classes below one."""
    sections = {base.SECTION} if "SECTION" in vars(base) else set()
    return sections.union(*map(sections_of_scenes, base.__subclasses__()))


def dump(scene: SweptScene) -> str:
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


class _Changed(NamedTuple):
    """Plain values with overrides, and the mistakes of the overrides that were left out."""

    data: dict[str, Any]
    mistakes: list[Mistake]


def _with_overrides(
    data: dict[str, Any],
    places: dict[Key, str],
    overrides: Sequence[str],
    model: type[SweptScene],
) -> _Changed:
    """Return plain values with overrides, which `places` then names as their place."""
    mistakes = []
    for override in sorted(overrides, key=_order_of_override):
        name, equals, text = override.partition("=")
        name = name.strip()
        if not equals or not name:
            words = f"got {quoted(override)}, allowed: key=value, as in rolling.load_n=50"
            mistakes.append(Mistake((), words, SET))
            continue
        if name not in all_keys(model):
            mistakes.append(Mistake(key_of(name), unknown_name(name, model), SET))
            continue
        try:
            parsed = parse(text, f"{SET}: {name}")
        except SceneError as error:
            mistakes += [Mistake((), line.removeprefix(f"{SET}: "), SET) for line in error.mistakes]
            continue
        mistakes += [
            Mistake((*key_of(name), *entry.key), entry.message, SET) for entry in parsed.mistakes
        ]
        data = with_value(data, name, parsed.value)
        key = key_of(name)
        for inner in [other for other in places if other[: len(key)] == key]:
            del places[inner]
        places[key] = SET
    return _Changed(data, mistakes)


def _order_of_override(override: str) -> int:
    """Return the rank of an override among others."""
    return library.order_of_change(override.partition("=")[0].strip())


def with_overrides(scene: AnyScene, overrides: Sequence[str]) -> AnyScene:
    """Return the scene of a run folder with other values.

    Raises
    ------
    SceneError : an override is none, or a value is not allowed.
    """
    places: dict[Key, str] = {(): "stored scene"}
    changed = _with_overrides(scene.to_dict(), places, overrides, type(scene))
    return type(scene).from_dict(changed.data, scene.folder, places, changed.mistakes)


# ---- new sound from a stored run


RESOUND_KEYS = ["rolling.speed_m_s", "rolling.drop_mm", "sphere.density_kg_m3"]
RESOUND_KEYS += [f"plate.{name}" for name in VIBRATING_PLATE]
RESOUND_KEYS += ["dynamics.release"]
RESOUND_KEYS += [f"sound.{name}" for name in Sound.model_fields]


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
    scene = scene.with_shared_length()
    free = [key for key in RESOUND_KEYS if key not in _bound_keys(scene)]
    solved = {*all_keys(Scene)} - {*free, "sound"}
    names = [override.partition("=")[0].strip() for override in overrides]
    needed = f"needs a new run; without solving again allowed: {', '.join(free)}"
    mistakes = [Mistake(key_of(name), needed, SET) for name in names if name in solved]
    places: dict[Key, str] = {(): "stored scene"}
    changed = _with_overrides(scene.to_dict(), places, overrides, Scene)
    mistakes += changed.mistakes
    data = changed.data
    if scene.rolling.stated_duration_s is not None and not mistakes:
        data["rolling"]["duration_s"] = _time_of_same_track(scene, data)
    resounded = Scene.from_dict(data, scene.folder, places, mistakes)
    if scene.numerics.step_nodes != "auto":
        return resounded
    return _with_steps_of(scene, resounded)


def _with_steps_of(scene: Scene, resounded: Scene) -> Scene:
    """Return the scene of a new sound with the steps that `auto` took for the stored runs.

    A faster sphere would allow longer steps, and the stored ones stay. They do not hold hearing for
    a slower sphere: raise SceneError with the lowest speed that they allow.
    """
    stored = [run for _, run in scene.runs()]
    speeds = [run.step_choice.speed for run in stored if run.step_choice is not None]
    if not speeds:
        return resounded
    slowest = min(speeds)
    if min(run.slowest_speed for _, run in resounded.runs()) > slowest:
        numerics = resounded.numerics.model_copy(update={"slowest_m_s": slowest})
        kept = resounded.model_copy(update={"numerics": numerics})
        kept_steps = [run.step_nodes for _, run in kept.runs()]
        heard_steps = [run.step_nodes for _, run in resounded.runs()]
        return resounded if kept_steps == heard_steps else kept
    longest = max(stored, key=_lowest_speed)  # the steps that the fewest speeds allow
    if min(run.heard_speed for _, run in resounded.runs()) < _lowest_speed(longest):
        step_um = micrometres(longest.step)
        lowest = rounded_up(_lowest_speed(longest))
        raise SceneError(
            [
                f"{SET}: rolling.speed_m_s: the stored run has steps of {step_um} um, which hold"
                f" hearing from {lowest} m/s on; for a slower sphere march again, with `rolling"
                " run` at that speed or with --set numerics.step_nodes=1"
            ]
        )
    return resounded


def _lowest_speed(run: Scene) -> float:
    """Return the lowest speed [m/s] that the steps of a run allow where auto chose them."""
    return 0.0 if run.step_choice is None else run.step_choice.lowest


def _time_of_same_track(scene: Scene, changed: Mapping[str, Any]) -> float:
    """Return the time [s] that the track of a scene takes with the speed of changed values."""
    duration = scene.rolling.stated_duration_s
    assert duration is not None  # asked for by the caller
    try:
        sphere = Sphere.model_validate(changed["sphere"])
        motion = motion_of(sphere, Rolling.model_validate(changed["rolling"]))
    except ValidationError:
        return duration  # `from_dict` refuses the new speed
    distance = scene.track.distance
    if isinstance(scene.surface, HeightFile):
        distance = float(scene.motion.distance(duration))
    try:
        return float(f"{motion.duration(distance):.12g}")
    except ValueError as error:
        words = f"--set: rolling.speed_m_s: {error}, the end of the stored run"
        raise SceneError([words]) from error


def _bound_keys(scene: Scene) -> set[str]:
    """Return keys that change the load or the rolling out, and with it the contact or the track."""
    rolls_out = scene.rolling.resistance is not None
    bound = set[str]()
    if rolls_out:
        bound.add("rolling.speed_m_s")
    if rolls_out or scene.rolling.load_n == WEIGHT:
        bound.add("sphere.density_kg_m3")
    return bound


# ---- schema


def schema_of(model: type[SweptScene], title: str, description: str) -> dict[str, Any]:
    """Return the JSON Schema of the scene files of a kind."""
    return (
        {"$schema": "https://json-schema.org/draft/2020-12/schema"}
        | model.model_json_schema()
        | {"title": title, "description": description}
    )
