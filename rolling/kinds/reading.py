"""Scene files of any kind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from acoustics.traps import ignoring_underflow
from rolling.kinds.registry import kind_named, name_of_file, scene_types
from rolling.scene import file
from rolling.scene.messages import nearest


@ignoring_underflow
def read_scene(path: Path | str, overrides: Sequence[str] = ()) -> Any:
    """Read a scene file.

    Parameters
    ----------
    path : Path or str
        File of YAML 1.2 in UTF-8, or the name of a scene of the library, such as "quickstart" or
        "bearing-6204", if there is no such file. A scene found by name reads its height file from
        the current folder, unless the library has that file too.
    overrides : sequence of str
        Values such as "rolling.load_n=50", written in YAML. No value (or null) removes an optional
        key or section. A key that the scene sweeps leaves the sweep when it is set;
        "sweep.rolling.load_n=[5, 20]" sweeps it.

    Returns
    -------
    scene : Scene or BearingScene
        A scene of a sphere, or of a bearing where the file has a section `bearing`.

    Raises
    ------
    SceneError
        File or overrides have mistakes; all are named, in the order of their lines.

    Examples
    --------
    >>> import rolling
    >>> rolling.read_scene("quickstart", ["rolling.load_n=50"]).rolling.load_n
    50.0
    >>> rolling.read_scene("bearing-6204", ["bearing.speed_rpm=900"]).turns_hz
    15.0
    """
    return file.read_as(path, scene_types()[name_of_file(path)], overrides)


def schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the scene files of a kind, for editors.

    Raises
    ------
    ValueError : there is no kind of this name.
    """
    types = scene_types()
    if kind not in types:
        near = nearest(kind, list(types))
        raise ValueError(f"{kind}: no kind of scene{near}, allowed: {', '.join(types)}")
    model = types[kind]
    return file.schema_of(model, model.TITLE, kind_named(kind).description)
