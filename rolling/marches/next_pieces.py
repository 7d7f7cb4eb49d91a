"""Pieces that a run lacks: its track first, then the marches beside it, and the film last.

The film is a stretch that is marched again around the loudest event: the place where the release
power, averaged over 20 um, is largest; for a run that is heard by its vibration, where the contact
force departs most from the load. It is marched under the load of the scene, at a few percent of the
run's cost at most.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.check import cost
from rolling.check.error_cost import COLD_STEPS
from rolling.contact.solver import ContactError
from rolling.marches.error_stretches import own_stretches, stretch_pieces
from rolling.marches.marched_law import (
    first_law_pieces,
    law_motion,
    law_pieces,
    load_along,
    own_marches,
)
from rolling.marches.passes import Passes
from rolling.marches.piece import Piece
from rolling.marches.result import Result, vibration_key
from rolling.scene.scene import Scene

SECONDS = 3e-3  # [s] of rolling that are shown
SHARE = 0.05  # maximum share of the steps of the run
AVERAGED = 20e-6  # [m] over which the release is averaged to find the event
MIN_STRIDE = 2e-6  # [m] from one map to the next, unless a step is longer
MAX_STRIDE = 4e-6  # [m]
MIN_MAPS = 30
MAX_MAPS = 150


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
    passes = result.passes
    if passes is not None:
        pieces = _pass_pieces(scene, result, passes)
        if pieces:
            return pieces
        if scene.dynamics is not None:
            passes.refuse_yielding()
    if not result.is_complete:
        pieces = [
            Piece(scene, result.identity, "track", first, last, sunk=result.sunk)
            for first, last in result.missing()
        ]
        if scene.dynamics is not None:
            pieces += first_law_pieces(scene, result)
        return pieces
    pieces = stretch_pieces(scene, result)
    law = []
    if scene.dynamics is not None:
        law = law_pieces(scene, result)
        pieces += law
    if scene.moves_release and not law:
        pieces += _moving_pieces(scene, result)
    if film and not pieces:
        pieces = _film_pieces(scene, result)
    return pieces


def _pass_pieces(scene: Scene, result: Result, passes: Passes) -> list[Piece]:
    """Return the pieces that the present pass over a plate that remembers lacks."""
    return [
        Piece(
            scene,
            result.identity,
            "pass",
            first,
            last,
            number=passes.finished,
            sunk=passes.sunk,
            step_cost=1 + cost.RUN_IN_SHARE,
        )
        for first, last in passes.missing(scene)
    ]


def _moving_pieces(scene: Scene, result: Result) -> list[Piece]:
    """Return the pieces under the moving load; the result gets this load first."""
    if result.moving is None or result.moving.key != vibration_key(scene):
        result.moving = load_along(scene, result)
    moving = result.moving
    return [
        Piece(
            scene,
            result.identity,
            "moving",
            first,
            last,
            forces=moving.force,
            sunk=result.sunk,
        )
        for first, last in moving.missing()
    ]


def _film_pieces(scene: Scene, result: Result) -> list[Piece]:
    """Return the piece of the slow motion, if it is possible and not there."""
    sunk = None
    if result.passes is not None:
        if result.passes.before is None:  # the plate before the last pass is not stored
            return []
        sunk = result.passes.before
    positions = film_stretch(scene, result)
    if positions is None:
        result.slow_motion = None
        return []
    if result.slow_motion is not None:
        stored = result.slow_motion.positions.tolist()
        # A film without a map is of a stretch that could not be solved again.
        if not stored or stored == list(positions):
            return []
    return [
        Piece(
            scene,
            result.identity,
            "film",
            positions[0],
            positions[-1],
            stride=positions.step,
            sunk=sunk,
        )
    ]


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


# ---- film


def film_stretch(scene: Scene, result: Result) -> range | None:
    """Choose the positions of the maps around the loudest event of a complete result.

    Return None for a smooth surface, which has no events, and for a run that is too short.
    """
    if scene.is_smooth or not result.is_complete:
        return None
    try:
        if scene.dynamics is not None and scene.sound.source == "vibration":
            event = _largest_departure(scene, result)
        else:
            event = _loudest_release(scene, result)
    except ContactError:
        return None
    step = result.step
    wanted = SECONDS * event.speed / step
    stride = max(
        1,
        math.ceil(MIN_STRIDE / step - 1e-9),
        min(math.floor(MAX_STRIDE / step + 1e-9), math.ceil(wanted / MAX_MAPS - 1e-9)),
    )
    affordable = SHARE * result.solved_steps - COLD_STEPS
    maps = min(MAX_MAPS, int(min(wanted, affordable) // stride))
    if maps < MIN_MAPS:
        return None
    length = (maps - 1) * stride
    first = min(max(0, event.position - length // 2), result.solved_steps - length)
    return range(first, first + length + 1, stride)


class _Event(NamedTuple):
    """Place of the loudest event.

    position : int. Number of the position.
    speed : float, m/s. Speed of the sphere there.
    """

    position: int
    speed: float


def _largest_departure(scene: Scene, result: Result) -> _Event:
    """Return the event where the force departs most from the load in a lap."""
    motion = law_motion(scene, result)
    departure = np.abs(motion.force_n / scene.load - 1.0)
    departure[motion.position_m > result.solved_steps * result.step] = 0.0
    largest = int(np.argmax(departure))
    return _Event(
        position=round(float(motion.position_m[largest]) / result.step),
        speed=float(scene.motion.speed(motion.time_s[largest])),
    )


def _loudest_release(scene: Scene, result: Result) -> _Event:
    """Return the event with the largest release power."""
    energy = result.series["release_energy"]
    step = result.step
    middle = np.minimum((np.arange(len(energy)) + 0.5) * step, scene.motion.final_distance)
    speed = np.asarray(scene.motion.speed(scene.motion.time(middle)), dtype=float)
    position = loudest(energy * speed, max(1, round(AVERAGED / step)))
    return _Event(position, float(speed[position]))


def loudest(power: Array, width: int) -> int:
    """Return the middle of the stretch of so many values with the largest mean."""
    sums = np.cumsum(np.concatenate([[0.0], power]))
    width = min(width, len(power))
    return int(np.argmax(sums[width:] - sums[:-width])) + width // 2
