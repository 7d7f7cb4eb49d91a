"""Kinds of scenes that there are: those of the program, and those that are registered.

The kinds of the program stand above the rooms that ask for them, so each is imported when it is
asked for. The classes of their scenes stand below, so a scene is read without them.
"""

from __future__ import annotations

import copyreg
import dataclasses
import pickle
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from rolling.kinds.kind import Kind
from rolling.kinds.run_folder import RunFolder
from rolling.scene import library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError, quoted
from rolling.scene.scene import Scene
from rolling.scene.swept import SweptScene
from rolling.scene.yaml_text import parse, read_text

USUAL = "ball"
SCENE_TYPES: Mapping[str, type[SweptScene]] = {USUAL: Scene, "bearing": BearingScene}
MODULES = {
    USUAL: "rolling.ball_kinds.balls",
    "bearing": "rolling.bearing_kind.turning_bearing",
}
_added: dict[str, Kind] = {}


def register(kind: Kind) -> None:
    """Add a kind of scene, whose scenes are then run, shown and chosen as all others.

    Worker processes get the kind from this process, with the code of its modules, which they need
    not find. Such a module does without `from __future__ import annotations`: where it cannot be
    imported, the text of an annotation has no meaning.

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
    _send_code_of(kind)
    _added[kind.name] = kind


def _send_code_of(kind: Kind) -> None:
    """Let pickles of this process hold the code of a kind, its scenes and its numbers.

    It is that of their modules, or of the whole package where they stand in one.
    """
    import cloudpickle  # type: ignore[import-untyped]  # slow to import

    # A field without a default holds the one object MISSING, which has to stay the same one.
    copyreg.pickle(type(dataclasses.MISSING), lambda _: "MISSING")
    stored = kind.stored_type.__dataclass_fields__.values()
    of_fields = [field.type for field in stored if isinstance(field.type, type)]
    classes = [type(kind), kind.scene_type, *of_fields]
    for name in {class_.__module__.partition(".")[0] for class_ in classes}:
        if name not in ("rolling", "__main__", "builtins"):  # these need not, or do it anyway
            cloudpickle.register_pickle_by_value(sys.modules[name])


def packed(*values: Any) -> bytes:
    """Return a pickle of the kinds that were added, and of some values, for `unpacked`."""
    import cloudpickle

    return bytes(cloudpickle.dumps([[*_added.values()], *values]))


def unpacked(content: bytes) -> list[Any]:
    """Add the kinds of the process that packed them, with their code, and return the values."""
    kinds, *values = pickle.loads(content)
    assert isinstance(values, list)
    for kind in kinds:
        _added[kind.name] = kind
    return values


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
            return kind_named(name).of_scene(scene)
    raise TypeError(f"scene: got {type(scene).__name__}, allowed: a scene of a registered kind")


def kind_of_runs(runs: Sequence[RunFolder]) -> Kind:
    """Return the kind of the scenes of runs.

    Kinds of one name have the same files and tables, so their runs may be mixed; what holds for all
    of them is then told by the kind that has the name.

    Raises
    ------
    ValueError : there is no run, or the runs are of several kinds.
    """
    every = list(dict.fromkeys(kind_of(run.scene) for run in runs))
    names = list(dict.fromkeys(kind.name for kind in every))
    if len(names) != 1:
        listed = ", ".join(names) or "none"
        raise ValueError(f"runs: got {listed}, allowed: runs of one kind of scene")
    return every[0] if len(every) == 1 else kind_named(names[0])


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
