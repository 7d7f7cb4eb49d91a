"""Stretches of a run that are marched again, for the estimate of its errors.

Each stretch is marched from a cold start over the positions of the run: on the run's grid at a
tight tolerance, at half the spacing and the tight tolerance, and at twice the spacing. Where the
law of a generated surface goes on below the spacing, some are marched with its detail at half the
spacing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from rolling.check import error_cost
from rolling.check.error_cost import DETAIL, LEVELS
from rolling.marches.piece import Piece
from rolling.marches.result import ErrorStretches, Result
from rolling.scene.scene import Scene
from rolling.sound import error_estimate
from rolling.sound.error_estimate import BandPowers, StretchSignals
from rolling.sound.radiators import roughness_gain


def stretch_pieces(scene: Scene, result: Result, piece: Callable[..., Piece]) -> list[Piece]:
    """Return the marches of stretches that the estimate of a run lacks.

    `piece` makes a piece from its kind, first and last position, cost of a step in steps of the
    run, and level.
    """
    layout = error_cost.layout(scene)
    if layout is None or not result.complete:
        return []
    stretches = result.stretches
    known = stretches.marches if stretches and stretches.steps == layout.steps else {}
    return [
        piece("error", first, first + layout.steps, scale, level=level)
        for first, level in layout.marches
        if (first, level) not in known
        for scale in [error_cost.level_cost(scene, level)]
    ]


def own_stretches(scene: Scene, result: Result) -> ErrorStretches | None:
    """Return the marches of stretches that a run needs, without those of another run."""
    layout, stretches = error_cost.layout(scene), result.stretches
    if layout is None or stretches is None or stretches.steps != layout.steps:
        return None
    known = stretches.marches
    return replace(stretches, marches={key: known[key] for key in layout.marches if key in known})


def stretch_firsts(scene: Scene, result: Result) -> tuple[int, ...]:
    """Return the first positions of a run's stretches; none where they are missing or failed."""
    layout, stretches = error_cost.layout(scene), result.stretches
    if layout is None or stretches is None or stretches.fault or stretches.steps != layout.steps:
        return ()
    complete = set(layout.marches) <= set(stretches.marches)
    return layout.firsts if complete else ()


def stretch_powers(scene: Scene, result: Result) -> BandPowers:
    """Compute the band powers of the complete stretches of a run at the speeds of the scene."""
    stretches, firsts = result.stretches, stretch_firsts(scene, result)
    assert stretches is not None
    series = result.series["approach" if scene.sound.source == "vibration" else "release_energy"]
    own = np.array([series[first : first + stretches.steps] for first in firsts])
    tight, fine, coarse = (_signals(scene, result, firsts, level) for level in LEVELS)
    ratio = error_cost.tight_tolerance(scene) / scene.tolerance
    return _band_powers(scene, result, firsts, (own, tight, fine, coarse), ratio)


def detail_powers(scene: Scene, result: Result) -> BandPowers | None:
    """Compute the band powers with and without the detail of the surface's law; None without it.

    The half spacing with the law's detail is the finer level, the half spacing without it the own.
    """
    marches = result.stretches.marches if result.stretches else {}
    firsts = [first for first in stretch_firsts(scene, result) if (first, DETAIL) in marches]
    if not firsts:
        return None
    flat, fine = _signals(scene, result, firsts, "fine"), _signals(scene, result, firsts, DETAIL)
    return _band_powers(scene, result, firsts, (flat, flat, fine, flat), 1.0)


def plastic_areas(scene: Scene, result: Result, level: str) -> Array:
    """Return the mean area at the hardness on a level [m2] of each stretch of a run."""
    assert result.stretches is not None
    marches, firsts = result.stretches.marches, stretch_firsts(scene, result)
    return np.array([marches[first, level].plastic_area for first in firsts])


def _signals(scene: Scene, result: Result, firsts: Sequence[int], level: str) -> Array:
    """Return the release [J] or the approach [m] of stretches on a level."""
    assert result.stretches is not None
    marches = [result.stretches.marches[first, level] for first in firsts]
    vibrates = scene.sound.source == "vibration"
    return np.array([m.approach[:-1] if vibrates else m.release for m in marches])


def _band_powers(
    scene: Scene,
    result: Result,
    firsts: Sequence[int],
    signals: tuple[Array, Array, Array, Array],
    tolerance_ratio: float,
) -> BandPowers:
    """Compute the band powers of stretches from their signals: own, tight, fine and coarse."""
    return error_estimate.band_powers(
        StretchSignals(
            *signals,
            step=result.step,
            speeds=np.array([_speeds(scene, result, first) for first in firsts]),
            tolerance_ratio=tolerance_ratio,
            gain=roughness_gain(scene) if scene.sound.source == "vibration" else None,
        )
    )


def _speeds(scene: Scene, result: Result, first: int) -> Array:
    """Return the mean speed at each pass over a stretch [m/s], 0 where the run ends before."""
    assert result.stretches is not None
    length = result.stretches.steps * result.step
    laps = math.ceil(result.steps / result.solved_steps)
    begin = (first + np.arange(laps) * result.solved_steps) * result.step
    whole = begin + length <= result.steps * result.step * (1 + 1e-12)
    reached = scene.motion.final_distance
    begins, ends = np.minimum(begin, reached), np.minimum(begin + length, reached)
    times = np.asarray(scene.motion.time(ends) - scene.motion.time(begins))
    rolled = whole & (times > 0)
    speeds: Array = np.divide(ends - begins, times, out=np.zeros(laps), where=rolled)
    return speeds
