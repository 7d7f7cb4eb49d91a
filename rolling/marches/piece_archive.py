"""Archives of pieces: the variables of result.h5, and what is joined when pieces come together.

An array of a group has the name GROUP/NAME. A piece that failed has its reason in place of arrays.
"""

from __future__ import annotations

from rolling.archive.definition import Arrays, Variable, by_name
from rolling.archive.npz_file import npz_bytes, read_npz
from rolling.marches.effort import PieceEffort
from rolling.marches.march_variables import (
    EFFORT,
    EVENTS,
    EVENTS_GROUP,
    FAILURE,
    FILM,
    FILM_GROUP,
    MAPS,
    MAPS_GROUP,
    SERIES_OF_KIND,
    SNAPSHOT,
    SNAPSHOT_GROUP,
    STATES,
    STEP_TIME,
    STEPS,
)
from rolling.marches.piece import Piece

_SERIES = by_name(*STEPS, STEP_TIME, *STATES)
_SNAPSHOT_PLACE = Variable("place", "place", "m", "f8", "distance, and the corner of the cells")
_FILM_PLACE = Variable("place", "place", "m", "f8", "corner and side of the cells, and both units")
_SINKING = by_name(
    Variable("plastic_work", "step", "J", "f8", "plastic work in each step"),
    Variable("sunk_row", "sunk_row", "1", "i8", "rows of nodes that have sunk"),
    Variable("sunk_depth", "sunk_row node_across", "m", "f8", "depth by which they have sunk"),
)

_FAILED = by_name(FAILURE, EFFORT)  # of a piece that failed


def archive_of(piece: Piece, arrays: Arrays) -> bytes:
    """Return the archive of the arrays that `march_piece` returns of a piece."""
    variables = _FAILED if FAILURE.name in arrays else _variables(piece)
    return npz_bytes(variables, arrays)


def arrays_of(piece: Piece, archive: bytes) -> Arrays:
    """Return the arrays of a piece from its archive, which anybody may have changed.

    Raises
    ------
    Exception : of any kind, where the archive is damaged or holds no such piece.
    """
    lengths = _lengths(piece)
    try:
        return read_npz(archive, _variables(piece), lengths)
    except ValueError:
        return read_npz(archive, _FAILED, lengths)


def _variables(piece: Piece) -> dict[str, Variable]:
    """Return the definitions of the arrays of a piece by name, as `march_piece` returns them."""
    variables = {EFFORT.name: EFFORT}
    if piece.kind == "film":
        return variables | _in_group(FILM_GROUP, (_FILM_PLACE, *FILM))
    for name in SERIES_OF_KIND.get(piece.kind, _SERIES):
        variables[name] = _SERIES[name]
    if piece.kind == "pass":
        variables |= _SINKING
    if piece.has_maps:
        variables |= _in_group(MAPS_GROUP, MAPS)
        if piece.first == 0:
            variables |= _in_group(SNAPSHOT_GROUP, (_SNAPSHOT_PLACE, *SNAPSHOT))
        if piece.scene.recovery.events:
            variables |= _in_group(EVENTS_GROUP, EVENTS)
    return variables


def _lengths(piece: Piece) -> dict[str, int]:
    """Return the lengths of the dimensions that a piece fixes."""
    steps = piece.last - piece.first
    begins_with_state = piece.first == 0 or piece.kind == "error"
    return {
        "step": steps,
        "position": steps + begins_with_state,
        "axis": 2,
        "node_across": piece.scene.track.n_across,
        "part": len(PieceEffort._fields),
        "place": 5 if piece.kind == "film" else 3,
    }


def _in_group(group: str, variables: tuple[Variable, ...]) -> dict[str, Variable]:
    """Return the variables of a group by their names in the archive of a piece."""
    return {f"{group}/{variable.name}": variable for variable in variables}
