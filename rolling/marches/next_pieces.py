"""Pieces that a run lacks: its track first, then the marches beside it, and the film last."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rolling.check import cost
from rolling.marches.piece import Piece, march_piece
from rolling.marches.result import Result
from rolling.scene.scene import Scene


def next_pieces(scene: Scene, result: Result, film: bool = False) -> list[Piece]:
    """Return the pieces that a run lacks and that can be marched now; none when it is whole.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. Its result so far.
    film : bool. Whether the run gets a slow motion. Default: false.

    Raises
    ------
    ContactError : a force law or a motion is not possible.
    """
    step_seconds = cost.expected_seconds(scene) / result.solved_steps

    def piece(kind: str, first: int, last: int, scale: float = 1.0, **fields: Any) -> Piece:
        seconds = (last - first) * step_seconds * scale
        return Piece(scene, result.identity, kind, first, last, seconds, **fields)

    return [piece("track", first, last) for first, last in result.missing()]


def march_all(
    scene: Scene,
    film: bool = False,
    progress: Callable[[float], object] = lambda seconds: None,
) -> Result:
    """March all pieces of a scene without a sweep in this process, and return the result.

    `progress` receives the expected time [s] of each piece when it is done. Raise ContactError
    where the contact cannot be solved.
    """
    result = Result.empty(scene)
    while pieces := next_pieces(scene, result, film):
        for piece in pieces:
            result.add(piece, march_piece(piece))
            progress(piece.cost)
    return result
