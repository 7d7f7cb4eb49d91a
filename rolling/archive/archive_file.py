"""Files of archives: their bytes, and their reader, which takes a file for a stranger's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from rolling.archive import hdf5_reader
from rolling.archive.definition import Archive, ArchiveDefinition, Attribute
from rolling.archive.hdf5_writer import hdf5_bytes
from rolling.archive.sealed_file import seal, sealed_content
from rolling.terminal.whole_files import FolderError

# The file, and all its arrays together, take at most so many times the disk that is estimated for
# the scene, and so many bytes more.
_MAX_TIMES = 5
_MAX_BESIDE = 100_000_000
# Attributes of the root that tell what a file is, before its definition is known.
_MARKS: dict[str, type[Attribute]] = {
    "format": int,
    "kind": str,
    "program": str,
    "identity": str,
}


def archive_bytes(definition: ArchiveDefinition, archive: Archive) -> bytes:
    """Return the bytes of the file of an archive, with the line of its digest at the end."""
    content = hdf5_bytes(definition, archive)
    return content + seal(content)


def read_archive(
    path: Path,
    definitions: Sequence[ArchiveDefinition],
    *,
    lengths: Mapping[str, int],
    most_bytes: int,
    identity: str = "",
) -> Archive:
    """Read an archive, of which nothing is read before it is judged.

    Parameters
    ----------
    path : Path
        A file that anybody may have changed.
    definitions : sequence of ArchiveDefinition
        Formats that are read, first the one of this version.
    lengths : mapping
        Lengths of dimensions that are known. Others have one length within a group.
    most_bytes : int
        Size of the file, and size of all its arrays together.
    identity : str
        Attribute `identity` that the file must have. Default: any or none.

    Raises
    ------
    FolderError
        The file is missing, has changed since it was written, is of another format, or holds
        another run.
    """
    content = sealed_content(path, most_bytes)
    with refusing(path, definitions[0]), hdf5_reader.reading(content, most_bytes) as file:
        attributes = file.attributes(_MARKS)
        definition = _definition_of(path, attributes, definitions)
        if identity and attributes.get("identity") != identity:
            raise FolderError(f"{path}: solved for another scene or surface")
        return file.groups(definition.groups, lengths)


@contextmanager
def refusing(path: Path, definition: ArchiveDefinition) -> Iterator[None]:
    """Turn an error about a file into a refusal: values of a hostile one lead to any kind."""
    try:
        yield
    except FolderError:
        raise
    except Exception as error:
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not {definition.name} of this program ({text})") from error


def largest_size(disk: float) -> int:
    """Return the size [bytes] of a file and of its arrays that is read, by the estimated disk."""
    return round(_MAX_TIMES * disk + _MAX_BESIDE)


def _definition_of(
    path: Path, attributes: Mapping[str, Attribute], definitions: Sequence[ArchiveDefinition]
) -> ArchiveDefinition:
    """Return the definition of a file by its format; refuse other formats and kinds."""
    kind = attributes.get("kind", "")
    if kind != definitions[0].kind:
        raise ValueError(f"its kind is {kind!r}")
    own = attributes.get("format", 1)
    for definition in definitions:
        if definition.format == own:
            return definition
    program = attributes.get("program", "0.1.0")
    raise FolderError(
        f"{path}: format {own}, which version {program} of the program reads;"
        f" this version reads format {definitions[0].format}"
    )
