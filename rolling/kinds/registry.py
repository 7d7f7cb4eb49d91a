"""Kinds of scenes that there are: those of the program, and those that are registered.

The kinds of the program stand above the rooms that ask for them, so they are imported when the
first one is asked for.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from rolling.kinds.kind import Kind
from rolling.scene import library
from rolling.scene.messages import SceneError
from rolling.scene.yaml_text import parse, read_text

BUILT_IN = {"ball": "rolling.built_in.ball_on_plate", "bearing": "rolling.built_in.bearing"}
_registered: dict[str, Kind] = {}


def register(kind: Kind) -> None:
    """Add a kind of scene, whose scenes are then run, shown and chosen as all others.

    Processes of a pool get it from the process that starts them.

    Parameters
    ----------
    kind : Kind
        The kind. It takes the place of another one of its name.
    """
    _registered[kind.name] = kind


def kinds() -> dict[str, Kind]:
    """Return all kinds by their names, first those of the program."""
    for name, module in BUILT_IN.items():
        if name not in _registered:
            _registered[name] = import_module(module).KIND
    return {**{name: _registered[name] for name in BUILT_IN}, **_registered}


def kind_of(scene: Any) -> Kind:
    """Return the kind of a scene.

    Raises
    ------
    TypeError : it is no scene of a registered kind.
    """
    for kind in kinds().values():
        if isinstance(scene, kind.scene_type):
            return kind
    raise TypeError(f"scene: got {type(scene).__name__}, allowed: a scene of a registered kind")


def kind_of_file(path: Path | str) -> Kind:
    """Return the kind of a scene file, or of a scene of the library by its name.

    A file that is of no kind, or cannot be read, is taken for one of a ball on a plate, whose
    reader says what is wrong with it.
    """
    file = library.find(Path(path))
    every = kinds()
    try:
        data = parse(read_text(file), str(file)).value
    except SceneError:
        data = None
    if isinstance(data, dict):
        for kind in every.values():
            if kind.scene_type.SECTION in data:
                return kind
        for kind in every.values():
            if kind.scene_type.misspelt_section(data):
                return kind
    return every["ball"]


def added() -> list[Kind]:
    """Return the kinds that are registered beside those of the program."""
    return [kind for name, kind in _registered.items() if name not in BUILT_IN]
