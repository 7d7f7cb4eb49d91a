"""Kinds of scenes that there are: those of the program, and those that are registered.

The kinds of the program stand above the rooms that ask for them, so each is imported when it is
asked for. The classes of their scenes stand below, so a scene is read without them.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from rolling.kinds.kind import Kind
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError, quoted
from rolling.scene.scene import Scene
from rolling.scene.swept import SweptScene
from rolling.scene.yaml_text import parse, read_text

USUAL = "ball"
SCENE_TYPES: Mapping[str, type[SweptScene]] = {USUAL: Scene, "bearing": BearingScene}
MODULES = {USUAL: "rolling.built_in.rolling_ball", "bearing": "rolling.built_in.bearing"}
_added: dict[str, Kind] = {}


def register(kind: Kind) -> None:
    """Add a kind of scene, whose scenes are then run, shown and chosen as all others.

    Parameters
    ----------
    kind : Kind
        The kind. It takes the place of another one of its name that was added.

    Raises
    ------
    ValueError
        The program has a kind of this name.

    Examples
    --------
    >>> import rolling
    >>> rolling.register(rolling.read_scene("quickstart"))
    Traceback (most recent call last):
    TypeError: kind: got Scene(...), allowed: a Kind
    """
    if not isinstance(kind, Kind):
        raise TypeError(f"kind: got {kind!r}, allowed: a Kind")
    if kind.name in MODULES:
        raise ValueError(f"kind: got {quoted(kind.name)}, which is a kind of the program")
    _added[kind.name] = kind


def scene_types() -> dict[str, type[SweptScene]]:
    """Return the classes of scenes by the names of their kinds, first those of the program."""
    return {**SCENE_TYPES, **{name: kind.scene_type for name, kind in _added.items()}}


def kind_named(name: str) -> Kind:
    """Return a kind by its name; raise KeyError where there is none."""
    if name in _added:
        return _added[name]
    kind: Kind = import_module(MODULES[name]).KIND
    return kind


def kind_of(scene: Any) -> Kind:
    """Return the kind of a scene.

    Raises
    ------
    TypeError : it is no scene of a registered kind.
    """
    for name, scene_type in scene_types().items():
        if isinstance(scene, scene_type):
            return kind_named(name)
    raise TypeError(f"scene: got {type(scene).__name__}, allowed: a scene of a registered kind")


def name_of_file(path: Path | str) -> str:
    """Return the name of the kind of a scene file, or of a scene of the library by its name.

    A file that is of no kind, or cannot be read, is taken for one of a ball on a plate, whose
    reader says what is wrong with it.
    """
    file = library.find(Path(path))
    try:
        data = parse(read_text(file), str(file)).value
    except SceneError:
        data = None
    if not isinstance(data, dict):
        return USUAL
    types = scene_types()
    for name, scene_type in types.items():
        if scene_type.SECTION in data:
            return name
    for name, scene_type in types.items():
        if scene_type.misspelt_section(data):
            return name
    return USUAL
