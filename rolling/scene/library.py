"""The library of scenes that come with the program: found by name, listed, and copied."""

from __future__ import annotations

import difflib
import itertools
import re
from contextlib import suppress
from pathlib import Path

# In an installed package the scenes stand inside of it, in a checkout beside it.
_PLACES = (Path(__file__).parents[1] / "scenarios", Path(__file__).parents[2] / "scenarios")
_SUFFIX = ".yaml"
_SCHEMA = "scene.schema.json"


class LibraryError(Exception):
    """A scene that the library does not hold, or a copy that would replace a file, in one line."""


def folder() -> Path:
    """Return the folder of the library."""
    return next((place for place in _PLACES if place.is_dir()), _PLACES[0])


def scenes() -> dict[str, Path]:
    """Return the files of the library by name, such as `quickstart`."""
    root = folder()
    files = sorted(root.rglob(f"*{_SUFFIX}"))
    return {file.relative_to(root).with_suffix("").as_posix(): file for file in files}


def find(path: Path) -> Path:
    """Return the library's file if `path` is the name of its scene and no file; else `path`."""
    file = scenes().get(path.as_posix())
    return path if file is None or path.is_file() else file


def companions(file: Path) -> list[Path]:
    """Return the files of heights that a scene of the library has beside it, by its name."""
    return [path for path in sorted(file.parent.glob(f"{file.stem}.*")) if path != file]


def title(file: Path) -> str:
    """Return the title of a scene: the first sentence of the comment that it begins with."""
    lines = file.read_text(encoding="utf-8").splitlines()
    comment = itertools.takewhile(lambda line: line.startswith("#"), lines)
    text = " ".join(line.strip("# ") for line in comment if "$schema=" not in line)
    return re.split(r"(?<=[.?!])\s", text, maxsplit=1)[0]


def titles(inner: bool = False) -> list[tuple[str, str]]:
    """Return name and title of each scene; `inner` includes the scenes in folders, of studies."""
    return [(name, title(file)) for name, file in scenes().items() if inner or "/" not in name]


def copy(name: str, target: Path) -> list[Path]:
    """Copy a scene of the library into a folder, with its heights and the schema that it names.

    Return the files that were written, the scene first; other files that exist stay as they are.
    Raise LibraryError where there is no such scene, or the file exists.
    """
    file = scenes().get(name.removesuffix(_SUFFIX))
    if file is None:
        raise LibraryError(
            f"{name}: no such scene in the library{_nearest(name)}; `rolling scenes` lists them"
        )
    content, written = file.read_bytes(), [target / file.name]
    try:
        _write_new(written[0], content)
    except FileExistsError as error:
        advice = "nothing is replaced; rename it or change to another folder"
        raise LibraryError(f"{written[0]}: exists, and {advice}") from error
    named = [folder() / _SCHEMA] if f"$schema={_SCHEMA}".encode() in content else []
    for other in (*companions(file), *named):
        with suppress(FileExistsError):
            _write_new(target / other.name, other.read_bytes())
            written.append(target / other.name)
    return written


def hint(path: Path) -> str:
    """Return the end of a message about a missing file that looks like the name of a scene here."""
    name = path.as_posix().removesuffix(_SUFFIX)
    if name in scenes():
        return f"; `rolling init {name}` copies the scene of that name into the current folder"
    return f"{_nearest(name)}, a scene of the library" if _nearest(name) else ""


def _nearest(name: str) -> str:
    """Write ", nearest: NAME" with the scene whose name is like a misspelt one, or nothing."""
    names = difflib.get_close_matches(name.removesuffix(_SUFFIX), scenes(), 1)
    return f", nearest: {names[0]}" if names else ""


def _write_new(path: Path, content: bytes) -> None:
    """Write a file that does not exist, or raise FileExistsError; a failed write leaves nothing."""
    with path.open("xb") as file:
        try:
            file.write(content)
            file.flush()
        except OSError:
            path.unlink()
            raise
