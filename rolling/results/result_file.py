"""The file result.h5 of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rolling.archive.archive_file import archive_bytes, largest_size, read_archive, refusing
from rolling.archive.hdf5_writer import to_xarray
from rolling.check.memory_and_disk import disk
from rolling.check.run_size import run_size
from rolling.marches.result import Result
from rolling.results.result_arrays import DEFINITION, archive_of, fill_result, fixed_lengths
from rolling.results.solved_run import SolvedRun
from rolling.scene.scene import Scene

if TYPE_CHECKING:
    import xarray


def write_result(run: SolvedRun) -> bytes:
    """Return the bytes of result.h5; equal runs have equal arrays and attributes in it."""
    return archive_bytes(DEFINITION, archive_of(run))


def result_tree(run: SolvedRun) -> xarray.DataTree:
    """Return the content of result.h5 as a tree of named arrays with units."""
    return to_xarray(DEFINITION, archive_of(run))


def read_result(path: Path, scene: Scene) -> Result:
    """Read the result of a scene without a sweep.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, is of another version, or
        holds the result of another scene or surface.
    """
    result = Result.empty(scene)
    archive = read_archive(
        path,
        [DEFINITION],
        lengths=fixed_lengths(scene, result),
        most_bytes=largest_size(disk([run_size(scene)])),
        identity=result.identity,
    )
    with refusing(path, DEFINITION):
        fill_result(result, archive)
    return result
