"""The file result.h5: written whole or not at all, and refused if a byte has changed.

The last line of the file is a SHA-256 of all bytes before it. HDF5 does not look beyond its own
end, so readers of HDF5 do not notice the line. The digest is checked before the HDF5 library opens
the file, because damage could crash the library.
"""

from __future__ import annotations

import hashlib
import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py

from rolling.folders.files import FolderError, write_bytes
from rolling.scene.scene import Scene
from rolling.simulation import _hdf5_probe, _result_layout, _result_reading
from rolling.simulation._result_layout import UNITS
from rolling.simulation.result import Result
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

__all__ = ["UNITS", "Result", "load", "physics", "save", "scene_text"]

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_DAMAGED = (
    "damaged; its numbers cannot be trusted (delete the file, and `rolling resume` solves it again)"
)


def save(
    path: Path,
    result: Result,
    scene: Scene,
    scene_text: str,
    sound: ContactSound | None = None,
    vibration: Vibration | None = None,
) -> None:
    """Write result.h5.

    Parameters
    ----------
    path : Path. The file to write.
    result : Result. The result of the run.
    scene : Scene. The scene of the run, for time and speed along the track.
    scene_text : str. The scene as YAML, with paths relative to the run folder.
    sound : ContactSound. Default: none yet.
    vibration : Vibration. Default: none.

    Raises
    ------
    OSError : the disk is full, or the file cannot be written for another reason. An earlier file is
        kept.
    """
    content = _result_layout.image(result, scene, scene_text, sound, vibration)
    try:
        write_bytes(path, content + _seal(content))
    except OSError as error:
        raise OSError(f"{path}: could not be written ({error})") from error


def load(path: Path) -> Result:
    """Read result.h5 and check all of it.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, or is not a result. The
        message names the file and the field.
    """
    try:
        content = path.read_bytes() if path.is_file() else None
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror})") from error
    if content is None:
        raise FolderError(f"{path}: no such file")
    if content[-_SEAL_LENGTH:] == _seal(memoryview(content)[:-_SEAL_LENGTH]):
        result, _ = _read(path, io.BytesIO(content))
        return result
    # The file is damaged or of an older version. Another process tests whether the HDF5 library
    # survives it, before it is opened here.
    if fault := _probed(path):
        raise FolderError(f"{path}: {_DAMAGED} ({fault})")
    result, version = _read(path, path)
    if version >= _result_layout.FORMAT or _SEAL in content:
        raise FolderError(
            f"{path}: {_DAMAGED} (the bytes are not the ones that were written: "
            "their SHA-256 differs)"
        )
    return result


def scene_text(path: Path) -> str:
    """Read the scene of a result.h5 of format 2 as YAML, with paths from its folder.

    Raises
    ------
    FolderError : the file cannot be read, was changed since it was written, or has no scene.
    """
    return _attribute(path, "scene")


def physics(path: Path) -> dict[str, Any]:
    """Read the values of all keys that a result.h5 was solved with; none of version 0.1.0.

    Nothing else is read, which matters for the table of many runs.

    Raises
    ------
    FolderError : the file cannot be read, or was changed since it was written.
    """
    try:
        return dict(json.loads(_attribute(path, "physics")))
    except (ValueError, FolderError):  # of an older version, or damaged
        identity = load(path).identity
        return {} if identity is None else identity.physics


def _attribute(path: Path, name: str) -> str:
    """Read a text beside the series of a result.h5."""
    try:
        content = path.read_bytes()
        if content[-_SEAL_LENGTH:] == _seal(memoryview(content)[:-_SEAL_LENGTH]):
            with h5py.File(io.BytesIO(content), "r") as file:
                return str(file.attrs[name])
    except (OSError, KeyError) as error:
        raise FolderError(f"{path}: its {name} is not readable ({error})") from error
    raise FolderError(f"{path}: {_DAMAGED} (its SHA-256 differs)")


def _seal(content: bytes | memoryview) -> bytes:
    return _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def _read(path: Path, source: Path | io.BytesIO) -> tuple[Result, int]:
    """Read an open file and its format, with `path` in the messages."""
    try:
        with h5py.File(source, "r") as file:
            version = _result_reading.format_of(file)
            if version > _result_layout.FORMAT:
                raise FolderError(
                    f"{path}: format {version}, this version of the program reads up to "
                    f"{_result_layout.FORMAT}"
                )
            return _result_reading.read(file), version
    except _result_reading.Damage as damage:
        raise FolderError(f"{path}: not a result that can be used: {damage}") from damage
    except FolderError:
        raise
    except Exception as error:  # h5py raises errors of any kind on damaged files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a result of this program ({text})") from error


def _probed(path: Path) -> str | None:
    """Return the reason why the HDF5 library cannot read a file, or None.

    The library reads the file in a separate process.
    """
    command = [sys.executable, "-P", str(Path(_hdf5_probe.__file__)), str(path)]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=2 * _hdf5_probe.SECONDS
        )
    except subprocess.TimeoutExpired:
        return "reading it does not come to an end"
    if done.returncode == 0:
        return None
    if done.returncode < 0:
        return "reading it crashes the HDF5 library"
    return (done.stderr.strip().splitlines() or ["not readable"])[-1]
