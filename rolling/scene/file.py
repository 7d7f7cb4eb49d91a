"""Scenes as YAML within limits of size and depth, overrides, and the JSON Schema for editors."""

import io
import math
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq, TaggedScalar
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import AliasEvent

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.scene import library, messages
from rolling.scene.bodies import VIBRATING_PLATE, Sphere
from rolling.scene.height_files import read_regular, reason_of
from rolling.scene.messages import Key, SceneError, all_keys, cut, dotted, first_line, shown
from rolling.scene.quantities import motion_of
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT, Rolling, Sound
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import with_value

MAX_BYTES = 1_000_000  # maximum size of a file
MAX_VALUES = 100_000  # maximum number of keys and values of a text, with its aliases expanded
MAX_ALIASES = 100  # maximum number of aliases; each may merge a whole section into another
MAX_NESTING = 7  # maximum depth of values, such as a speed profile in a swept section
_MAX_DEPTH = 20  # maximum depth of a text; deeper values are reported without their key
_MAX_BITS = 1000  # maximum length of a whole number; Python refuses to write much longer numbers
_LONG_NUMBER = re.compile(r"[0-9_]{4301,}")  # Python reads no longer numbers


# ---- reading, writing, overriding


@ignoring_underflow
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
    >>> import rolling
    >>> rolling.read_scene("quickstart", ["rolling.load_n=50"]).rolling.load_n
    50.0
    """
    instance("path", path, str, Path)
    path, overrides = Path(path), [overrides] if isinstance(overrides, str) else overrides
    file = library.find(path)
    text = read_text(file)
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
    data, lines = parse(text, where)
    if data is None:
        needed = ", ".join(name for name, key in Scene.model_fields.items() if key.is_required())
        raise SceneError([f"{where}: empty, a scene needs at least name, {needed}"])
    if not isinstance(data, dict):
        words = "a scene of keys and values, the first being name"
        raise SceneError([f"{where}:1: got {shown(data)}, allowed: {words}"])
    places = {key: f"{where}:{line}" for key, line in lines.items()}
    return Scene.from_dict(data, folder, places, _override(data, places, overrides))


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
                data |= with_value(data, name, parse(text, "--set")[0])
            except SceneError as error:
                words = re.sub(r"^[^ ]*: (\d+: )?", "", str(error))  # without its place
                faults.append(f"--set: {name}: {words}")
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
    result: dict[str, Any] = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    result |= Scene.model_json_schema()
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


# ---- YAML text


def read_text(path: Path) -> str:
    """Read a regular file of UTF-8 text of at most MAX_BYTES; raise SceneError where it is none."""
    try:
        return read_regular(path, MAX_BYTES).decode("utf-8-sig")
    except OSError as error:
        words = reason_of(error)
        if isinstance(error, FileNotFoundError):
            words += library.hint(path)
        elif words.startswith("is larger"):
            words += ", allowed: a scene file of at most that size"
        elif words.startswith("is "):
            words += ", a scene file is needed"
        raise SceneError([f"{path}: {words}"]) from error
    except UnicodeDecodeError as error:
        line, byte = error.object[: error.start].count(b"\n") + 1, error.object[error.start]
        raise SceneError([f"{path}:{line}: not UTF-8 text (byte {byte:#04x})"]) from error


def parse(text: str, where: str) -> tuple[Any, dict[Key, int]]:
    """Read plain values and the line of every key; `where` names the text in messages.

    Raises
    ------
    SceneError
        The text is no YAML 1.2 of plain values, or beyond a limit.
    """
    if len(text) > MAX_BYTES:
        raise SceneError([f"{where}: got {len(text):,} letters, allowed: at most {MAX_BYTES:,}"])
    if number := _LONG_NUMBER.search(text):
        line = text.count("\n", 0, number.start()) + 1
        digits = f"{len(number[0]):,} digits, allowed: shorter ones"
        raise SceneError([f"{where}:{line}: got a whole number of {digits}"])
    yaml = YAML(typ="rt")
    yaml.Composer = _LimitedComposer
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # YAML 1.2 allows anchors that are given twice
            loaded = yaml.load(text)
    except SceneError as error:
        raise SceneError([f"{where}:{error}"]) from error
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        problem = getattr(error, "problem", None) or getattr(error, "reason", None)
        problem = (problem or first_line(error)).replace("<stream end>", "the end").splitlines()[0]
        place = f"{where}:{mark.line + 1}" if mark else where
        if (position := getattr(error, "position", None)) is not None:  # of a letter
            place = f"{where}:{text[:position].count(chr(10)) + 1}"
        raise SceneError([f"{place}: not YAML: {problem}"]) from error
    except Exception as error:  # ruamel.yaml raises any kind, as on a directive of YAML 1.164
        raise SceneError([f"{where}: not YAML: {first_line(error)}"]) from error
    return _plain(loaded, where)


class _LimitedComposer(Composer):
    """Composer that limits the depth of a text and the number of its aliases."""

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self._aliases = 0
        self._open: list[str | None] = []  # anchors of the nodes that are being composed

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose a node and the nodes in it; raise SceneError beyond a limit."""
        event = self.parser.peek_event()
        line, is_alias = event.start_mark.line + 1, isinstance(event, AliasEvent)
        self._aliases += is_alias
        if len(self._open) >= _MAX_DEPTH:
            raise SceneError([f"{line}: nested too deeply"])
        if self._aliases > MAX_ALIASES:
            raise SceneError([f"{line}: more than {MAX_ALIASES} aliases"])
        if is_alias and event.anchor in self._open:
            raise SceneError([f"{line}: an alias of a value that contains it"])
        self._open.append(None if is_alias else event.anchor)
        node = super().compose_node(parent, index)
        self._open.pop()
        return node


def _plain(loaded: Any, where: str) -> tuple[Any, dict[Key, int]]:
    """Turn the values of ruamel.yaml into plain values, and list the line of every key."""
    lines: dict[Key, int] = {(): 1}

    def at(key: Key) -> str:
        return f"{where}:{lines[key]}: {cut(dotted(key))}"

    def plain(value: Any, key: Key) -> Any:
        if len(key) > MAX_NESTING:
            raise SceneError([f"{at(key)}: nested too deeply"])
        if len(lines) > MAX_VALUES:
            raise SceneError([f"{where}:{lines[key]}: more than {MAX_VALUES:,} keys and values"])
        if isinstance(value, CommentedMap):
            for name in value:
                line = _line(value, name, lines[key])
                lines[(*key, _name(name, f"{where}:{line}"))] = line
            return {str(name): plain(item, (*key, str(name))) for name, item in value.items()}
        if isinstance(value, CommentedSeq):
            for i in range(len(value)):
                lines[(*key, i)] = _line(value, i, lines[key])
            return [plain(item, (*key, i)) for i, item in enumerate(value)]
        if isinstance(value, TaggedScalar):
            tag = shown(value.tag.value).strip('"')
            raise SceneError([f"{at(key)}: got the tag {tag}, allowed: plain values"])
        if isinstance(value, int) and value.bit_length() > _MAX_BITS:
            digits = f"more than {_MAX_BITS * math.log10(2):.0f} digits, allowed: shorter ones"
            raise SceneError([f"{at(key)}: got a whole number of {digits}"])
        # ruamel keeps the notation of a number. bool comes before int because it is a subclass.
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    return plain(loaded, ()), lines


def _line(container: CommentedMap | CommentedSeq, name: Any, outer: int) -> int:
    """Return the line of a key or place; for merged keys, the line of the container."""
    place = (container.lc.data or {}).get(name)
    return place[0] + 1 if place else outer


def _name(name: Any, at: str) -> str:
    """Return a key as text; raise SceneError for a list, a section or a very long number."""
    if isinstance(name, tuple | Mapping):
        raise SceneError([f"{at}: got a list or section as a key, allowed: the name of a key"])
    if isinstance(name, int) and name.bit_length() > _MAX_BITS:
        raise SceneError([f"{at}: got a very long whole number as a key, allowed: its name"])
    return str(name)
