"""Pieces of the variants of a study on disk, so that a study that was stopped goes on."""

from __future__ import annotations

import io
import json
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from rolling.accuracy.variants import Study, Variant
from rolling.folders import files, own_files
from rolling.folders.files import FolderError
from rolling.scene.identity import Identity
from rolling.scene.identity import identity_differences as differences
from rolling.simulation import simulate
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES, Piece

STUDY = "study.json"  # identity and extent of a study, from its beginning


def write_study(folder: Path, study: Study) -> None:
    """Write the identity and the extent of a study into its new folder."""
    (folder / own_files.VARIANTS).mkdir()
    files.write_json(
        folder / STUDY, {"identity": asdict(simulate.identity_of(study.scene)), **_extent(study)}
    )


def refuse_other_study(folder: Path, study: Study) -> None:
    """Refuse the folder of a study that was stopped if it belongs to another study.

    Raises
    ------
    FolderError : scene, surface or extent differ, or cannot be read. The message names all
        differences.
    """
    path = folder / STUDY
    try:
        content = json.loads(path.read_bytes())
        before = Identity(**content.pop("identity"))
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise FolderError(
            f"{path}: not readable, so the study in {folder} cannot go on; take another --out, or"
            " --force to replace it"
        ) from error
    own = simulate.identity_of(study.scene)
    faults = differences(before, own, "the study", study.scene.height_path)
    if not faults:
        faults = [
            f"{name}: the study has {content.get(key)}, this command asks for {value}"
            for (key, value), name in zip(
                _extent(study).items(), ("--finest", "--duration in nodes of track"), strict=True
            )
            if content.get(key) != value
        ]
    if faults:
        lines = "\n".join(f"  {fault}" for fault in faults)
        raise FolderError(
            f"{folder}: holds an unfinished study of something else; take another --out, or --force"
            f" to replace it\n{lines}"
        )


def _extent(study: Study) -> dict[str, Any]:
    """Return the settings of a study beside its scene."""
    return {"finest": study.finest, "nodes": study.nodes}


def write_piece(folder: Path, variant: Variant, piece: Piece) -> None:
    """Write the series of a piece of a study."""
    save(_path(folder, variant, piece.first, piece.last), piece)


def read_piece(folder: Path, variant: Variant, first: int, last: int) -> Piece | None:
    """Read a piece of a study, or return None where it has to be marched."""
    return load(_path(folder, variant, first, last), first, last)


def save(path: Path, piece: Piece) -> None:
    """Write the series of a piece, complete or not at all."""
    content = io.BytesIO()
    series = {**piece.steps, **piece.states}
    np.savez(content, allow_pickle=False, **series)
    files.write_bytes(path, content.getvalue())


def load(path: Path, first: int, last: int) -> Piece | None:
    """Read a piece, or return None where it is missing or damaged."""
    with suppress(OSError, ValueError, KeyError, EOFError, BadZipFile):
        content = path.read_bytes()
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            steps = {name: stored[name] for name in STEP_SERIES}
            states = {name: stored[name] for name in STATE_SERIES}
        lengths = {len(values) for values in steps.values()}
        if lengths == {last - first}:
            return Piece(first, last, steps, states, None, None, [])
    return None


def remove_pieces(folder: Path) -> None:
    """Remove all pieces of a study that is done."""
    for path in (folder / own_files.VARIANTS).glob("*.npz"):
        with suppress(OSError):
            path.unlink()


def _path(folder: Path, variant: Variant, first: int, last: int) -> Path:
    """Return the file of a piece."""
    return folder / own_files.VARIANTS / f"{variant.name}_{first}-{last}.npz"
