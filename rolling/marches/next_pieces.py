"""Pieces that a run lacks: its track first, then the marches beside it, and the film last."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from rolling.check import cost
from rolling.marches.error_stretches import own_stretches, stretch_pieces
from rolling.marches.force_law import law_pieces, load_along, own_marches
from rolling.marches.piece import Piece
from rolling.marches.result import Result, vibration_key
from rolling.marches.slow_motion import film_stretch
from rolling.scene.scene import Scene


def next_pieces(scene: Scene, result: Result, film: bool = False) -> list[Piece]:
    """Return the pieces that a run lacks and that can be marched now; none when it is whole.

    The result gets the load of its moving march, which needs the motion of the sphere.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. Its result so far.
    film : bool. Whether the run gets a slow motion. Default: false.

    Raises
    ------
    ContactError : a force law or a motion is not possible.
    """
    step_seconds = cost.lap_seconds(scene) / result.solved_steps

    passes = result.passes

    def piece(kind: str, first: int, last: int, scale: float = 1.0, **fields: Any) -> Piece:
        if passes is not None:  # other marches meet the surface that the last pass left
            fields = {"sunk": passes.sunk} | fields
        seconds = (last - first) * step_seconds * scale
        return Piece(scene, result.identity, kind, first, last, seconds, **fields)

    if passes is not None:
        if lacking := passes.missing(scene):
            scale, number = 1 + cost.RUN_IN_SHARE, passes.finished
            return [piece("pass", *ends, scale, number=number) for ends in lacking]
        if scene.dynamics is not None:
            passes.refuse_yielding()
    pieces = [piece("track", first, last) for first, last in result.missing()]
    pieces += stretch_pieces(scene, result, piece)
    law = [] if scene.dynamics is None else law_pieces(scene, result, piece)
    pieces += law
    if scene.moves_release and result.complete and not law:
        if result.moving is None or result.moving.key != vibration_key(scene):
            result.moving = load_along(scene, result)
        moving = result.moving
        pieces += [piece("moving", *ends, forces=moving.force) for ends in moving.missing()]
    if film and not pieces and (passes is None or passes.before is not None):
        positions, film_so_far = film_stretch(scene, result), result.slow_motion
        if positions is None:
            result.slow_motion = None
        # A film without a map is of a stretch that could not be solved again.
        elif film_so_far is None or [*film_so_far.positions] not in ([], [*positions]):
            ends, sunk = (positions[0], positions[-1]), passes and passes.before
            pieces = [piece("film", *ends, stride=positions.step, sunk=sunk)]
    return pieces


def own_part(scene: Scene, result: Result, film: bool) -> Result:
    """Return a whole result with the marches that its own scene needs.

    A result that began with the marches of another run has more of them.
    """
    return replace(
        result,
        load_marches=own_marches(scene, result),
        stretches=own_stretches(scene, result),
        moving=result.moving if scene.moves_release else None,
        slow_motion=result.slow_motion if film else None,
    )
