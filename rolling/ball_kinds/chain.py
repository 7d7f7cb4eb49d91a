"""Levels of specimens by the linear chain, beside the computed ones.

Sphere, contact and plate as linear bodies are moved by the approach under the constant load. Their
level is no second solution of the contact, but one of the vibration: where both changes of a level
agree, neither flights nor the stiffness that changes with the force decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from rolling.ball_kinds.ball_candidates import LOSS_KEY
from rolling.ball_kinds.ball_heard import loss_factors_of
from rolling.choice.heard_specimen import Specimen
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.kinds.run_folder import RESULT
from rolling.marches import marched_law
from rolling.marches.result import Result
from rolling.numbers.number_files import from_bytes, to_bytes
from rolling.results import result_file
from rolling.scene.scene import Scene
from rolling.sound import radiators
from rolling.terminal.whole_files import read_regular, write_bytes

CHAIN = "chain.json"
POSITIONS = 12  # along the track, whose stiffness enters
_MAX_BYTES = 100_000


@dataclass(frozen=True)
class StoredLevel:
    """Level of a specimen by the linear chain [dB(A)], as chain.json has it; None of silence."""

    loss_factors: tuple[float, ...]
    laeq_db: float | None


def chain_levels(specimens: Sequence[Specimen]) -> Array | None:
    """Return the levels of specimens by the linear chain, (specimens,) [dB(A)].

    They are means over the loss factors. A sphere that falls is no linear chain, and a specimen
    without sound has no level: None.
    """
    levels = []
    for specimen in specimens:
        level = _chain_level(specimen)
        if level is None:
            return None
        levels.append(level)
    return np.array(levels)


def _chain_level(specimen: Specimen) -> float | None:
    """Return the level of a specimen [dB(A)], from its file if there is one."""
    if not specimen.scene.keeps_its_load:
        return None
    path = specimen.folder / CHAIN
    level = _stored_level(path, loss_factors_of(specimen))
    if level is None:
        level = _computed_level(specimen)
        write_bytes(path, to_bytes(StoredLevel(loss_factors_of(specimen), level)))
    return level


def _stored_level(path: Path, loss_factors: Sequence[float]) -> float | None:
    """Return the stored level of a specimen [dB(A)]; None without one, or for a damaged file."""
    try:
        stored = from_bytes(StoredLevel, read_regular(path, _MAX_BYTES))
    except (OSError, ValueError, RecursionError):
        return None
    return stored.laeq_db if stored.loss_factors == tuple(loss_factors) else None


def _computed_level(specimen: Specimen) -> float | None:
    """Return the level of a specimen from its march [dB(A)]; None where nothing sounds."""
    scene = specimen.scene
    result = result_file.read_result(specimen.folder / RESULT, scene)
    stiffness = stiffness_along(scene, result)
    closed = scene.track.closed and result.steps % result.solved_steps == 0
    approach = result.whole_series("approach")
    if closed and scene.motion.is_constant(scene.duration):
        approach = result.series["approach"]
    levels = []
    for loss_factor in loss_factors_of(specimen):
        damped = with_loss(scene, loss_factor)
        estimate = radiators.vibration_estimate(
            bodies_of(damped),
            listener_of(damped),
            damped.motion,
            approach=approach,
            step=result.step,
            closed=closed,
            stiffness_n_m=stiffness,
        )
        if estimate.laeq_db is None:
            return None
        levels.append(estimate.laeq_db)
    return float(np.mean(levels))


def stiffness_along(scene: Scene, result: Result) -> Array:
    """Return the stiffness of a marched contact at a few positions along the track [N/m]."""
    law = marched_law.force_law(scene, result)
    places = law.position_m[:: max(1, len(law.position_m) // POSITIONS)]
    return law.stiffness(places, law.approach(places, scene.load))


def with_loss(scene: Scene, loss_factor: float) -> Scene:
    """Return a scene with another loss factor of the contact."""
    return scene.with_({LOSS_KEY: loss_factor})
