"""Scene files of bearings, and of either kind."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from acoustics.traps import ignoring_underflow
from rolling.scene import file, library
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.yaml_text import parse, read_text


@ignoring_underflow
def read_bearing(path: Path | str, overrides: Sequence[str] = ()) -> BearingScene:
    """Read the scene file of a bearing.

    Parameters
    ----------
    path : Path or str
        File of YAML 1.2 in UTF-8 with a section `bearing`, or the name of such a scene of the
        library, such as "bearing-6204".
    overrides : sequence of str
        Values such as "bearing.speed_rpm=900", written in YAML, as for `read_scene`.

    Raises
    ------
    SceneError
        File or overrides have faults; all are named, in the order of their lines.

    Examples
    --------
    >>> import rolling
    >>> rolling.read_bearing("bearing-6204", ["bearing.speed_rpm=900"]).turns_hz
    15.0
    """
    return file.read(path, overrides, BearingScene)


def read_either(path: Path | str, overrides: Sequence[str] = ()) -> Scene | BearingScene:
    """Read a scene file of either kind; raise SceneError with all its faults."""
    if is_bearing_file(path):
        return read_bearing(path, overrides)
    return file.read_scene(path, overrides)


def is_bearing_file(path: Path | str) -> bool:
    """Tell whether a scene file, or a scene of the library by its name, is that of a bearing.

    A file that cannot be read is none, and its reader says what is wrong with it.
    """
    found = library.find(Path(path))
    try:
        parsed = parse(read_text(found), str(found))
    except SceneError:
        return False
    return file.bearing_key(parsed.value) is not None


def bearing_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of the scene file of a bearing, for editors."""
    return file.schema_of(
        model=BearingScene,
        title="Scene of a bearing that turns",
        description=(
            "A ball bearing: its geometry, surfaces, loads and speed, and the plate on which it is"
            " heard."
        ),
    )
