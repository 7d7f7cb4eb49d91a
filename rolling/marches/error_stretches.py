"""Stretches of a run that are marched again, for the estimate of its errors.

Each stretch is marched from a cold start over the positions of the run: on the run's grid at a
tight tolerance, at half the spacing and the tight tolerance, and at twice the spacing. Where the
law of a generated surface goes on below the spacing, some are marched with its detail at half the
spacing. Where a scene states the instrument of a measurement, some are marched with the law of the
measured spectrum in place of the waves that the instrument does not see.
"""

from __future__ import annotations

import math
from collections.abc import Container, Sequence
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from rolling.check import error_cost
from rolling.check.error_cost import DETAIL, MEASURED, WITH_LAW
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.marches.piece import Piece
from rolling.marches.result import ErrorStretches, Result
from rolling.scene.scene import Scene
from rolling.sound import error_estimate
from rolling.sound.error_estimate import BandPowers, StretchSignals
from rolling.sound.radiators import roughness_gain


def stretch_pieces(scene: Scene, result: Result) -> list[Piece]:
    """Return the marches of stretches that the estimate of a complete run lacks."""
    layout = error_cost.marches(scene)
    if layout is None:
        return []
    marched: Container[tuple[int, str]] = ()
    if result.stretches is not None and result.stretches.steps == layout.steps:
        marched = result.stretches.marches
    return [
        Piece(
            scene,
            result.identity,
            "error",
            first,
            first + layout.steps,
            level=level,
            sunk=result.sunk,
            step_cost=error_cost.level_cost(scene, level),
        )
        for first, level in layout.marches
        if (first, level) not in marched
    ]


def own_stretches(scene: Scene, result: Result) -> ErrorStretches | None:
    """Return the marches of stretches that a run needs, without those of another run."""
    layout = error_cost.marches(scene)
    stretches = result.stretches
    if layout is None or stretches is None or stretches.steps != layout.steps:
        return None
    marched = stretches.marches
    own = {key: marched[key] for key in layout.marches if key in marched}
    return replace(stretches, marches=own)


def stretch_firsts(scene: Scene, result: Result) -> tuple[int, ...]:
    """Return the first positions of a run's stretches; none where they are missing or failed."""
    layout = error_cost.layout(scene)
    stretches = result.stretches
    if layout is None or stretches is None or stretches.failure or stretches.steps != layout.steps:
        return ()
    if not set(layout.marches) <= set(stretches.marches):
        return ()
    return layout.firsts


def stretch_powers(scene: Scene, result: Result) -> BandPowers:
    """Compute the band powers of the complete stretches of a run at the speeds of the scene."""
    assert result.stretches is not None
    steps = result.stretches.steps
    firsts = stretch_firsts(scene, result)
    if scene.sound.source == "vibration":
        series = result.series["approach"]
    else:
        series = result.series["release_energy"]
    return _band_powers(
        scene,
        result,
        firsts,
        own=np.array([series[first : first + steps] for first in firsts]),
        tight=_signals(scene, result, firsts, "tight"),
        fine=_signals(scene, result, firsts, "fine"),
        coarse=_signals(scene, result, firsts, "coarse"),
        tolerance_ratio=error_cost.tight_tolerance(scene) / scene.tolerance,
    )


def detail_powers(scene: Scene, result: Result) -> BandPowers | None:
    """Compute the band powers with and without the detail of the surface's law; None without it.

    The half spacing with the law's detail is the finer level, the half spacing without it the own.
    """
    if result.stretches is None:
        return None
    marches = result.stretches.marches
    firsts = [first for first in stretch_firsts(scene, result) if (first, DETAIL) in marches]
    if not firsts:
        return None
    flat = _signals(scene, result, firsts, "fine")
    return _band_powers(
        scene,
        result,
        firsts,
        own=flat,
        tight=flat,
        fine=_signals(scene, result, firsts, DETAIL),
        coarse=flat,
        tolerance_ratio=1.0,
    )


def instrument_powers(scene: Scene, result: Result, source: str) -> BandPowers | None:
    """Compute the band powers as measured (own) and with the law of the spectrum (fine).

    They are those of the approach that a vibration follows, without its gain, or of the release.
    None where the stretches are not marched.
    """
    layout = error_cost.instrument_layout(scene)
    stretches = result.stretches
    if layout is None or stretches is None or stretches.steps != layout.steps:
        return None
    marches = stretches.marches
    if any(key not in marches or marches[key].failure for key in layout.marches):
        return None
    is_approach = source == "vibration"
    fine = _signals(scene, result, layout.firsts, WITH_LAW, is_approach)
    if error_cost.needs_finer_grid(scene):
        own = _signals(scene, result, layout.firsts, MEASURED, is_approach)
    else:
        series = result.series["approach" if is_approach else "release_energy"]
        own = np.array([series[first : first + layout.steps] for first in layout.firsts])
    signals = StretchSignals(
        own=own,
        tight=own,
        fine=fine,
        coarse=own,
        step=result.step,
        speeds=np.array([_speeds(scene, result, first) for first in layout.firsts]),
        tolerance_ratio=1.0,
        gain=np.ones_like if is_approach else None,
    )
    return error_estimate.band_powers(signals)


def plastic_areas(scene: Scene, result: Result, level: str) -> Array:
    """Return the mean area at the hardness on a level [m2] of each stretch of a run."""
    assert result.stretches is not None
    marches = result.stretches.marches
    firsts = stretch_firsts(scene, result)
    return np.array([marches[first, level].plastic_area for first in firsts])


def _signals(
    scene: Scene,
    result: Result,
    firsts: Sequence[int],
    level: str,
    is_approach: bool | None = None,
) -> Array:
    """Return the release [J] or the approach [m] of stretches on a level.

    By default it is that of the source of the sound.
    """
    assert result.stretches is not None
    marches = [result.stretches.marches[first, level] for first in firsts]
    if is_approach is None:
        is_approach = scene.sound.source == "vibration"
    if is_approach:
        return np.array([march.approach[:-1] for march in marches])
    return np.array([march.release for march in marches])


def _band_powers(
    scene: Scene,
    result: Result,
    firsts: Sequence[int],
    *,
    own: Array,
    tight: Array,
    fine: Array,
    coarse: Array,
    tolerance_ratio: float,
) -> BandPowers:
    """Compute the band powers of stretches from their signals on each level."""
    gain = None
    if scene.sound.source == "vibration":
        bodies = bodies_of(scene)
        gain = roughness_gain(bodies, listener_of(scene), bodies.smooth_chain)
    signals = StretchSignals(
        own=own,
        tight=tight,
        fine=fine,
        coarse=coarse,
        step=result.step,
        speeds=np.array([_speeds(scene, result, first) for first in firsts]),
        tolerance_ratio=tolerance_ratio,
        gain=gain,
    )
    return error_estimate.band_powers(signals)


def _speeds(scene: Scene, result: Result, first: int) -> Array:
    """Return the mean speed at each pass over a stretch [m/s], 0 where the run ends before."""
    assert result.stretches is not None
    length = result.stretches.steps * result.step
    laps = math.ceil(result.steps / result.solved_steps)
    begin = (first + np.arange(laps) * result.solved_steps) * result.step
    whole = begin + length <= result.steps * result.step * (1 + 1e-12)
    reached = scene.motion.final_distance
    begins = np.minimum(begin, reached)
    ends = np.minimum(begin + length, reached)
    times = np.asarray(scene.motion.time(ends) - scene.motion.time(begins))
    rolled = whole & (times > 0)
    speeds: Array = np.divide(ends - begins, times, out=np.zeros(laps), where=rolled)
    return speeds
