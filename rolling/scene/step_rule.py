"""Rule of `numerics.step_nodes: auto`: the longest steps whose error the grid's own error hides.

Two errors of a step add up in power. A release follows from the states at both ends of its step,
which is accurate to second order in the step over the contact radius. And what happens within a
step folds back into hearing, the more the fewer steps there are in the shortest wave that is heard.
Both were fitted to 48 random scenes, and tested on 16 others (`tests/benchmarks/step_study.py`,
docs/accuracy.md).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from acoustics.bands import NOMINAL_HZ
from acoustics.numbers import micrometres, rounded_up
from rolling.scene import grid_error

if TYPE_CHECKING:
    from rolling.scene.values_in_si import SceneQuantities

CHOICES = (4, 2)  # [nodes], tried in turn; otherwise a step has one node
HEARD_HZ = NOMINAL_HZ[-1]  # end of hearing [Hz]
# Wanted error of the release: so far below the grid's, but no less than the second value, beside
# which a grid of -34 dB still leaves third octaves up to 16 kHz within 1 dB, and no more than the
# third.
BELOW_GRID_DB = 10.0
LEAST_DB = -36.0
MOST_DB = -30.0
SAFETY_DB = 3.0  # rms error of the rule
# The rule was fitted where it may be used: up to this step over contact radius, and up to this
# approach of the smooth contact over rms roughness.
MAX_RADII = 0.25
MAX_SMOOTHNESS = 25.0
# With dynamics, a ball on a rougher contact may bounce, where longer steps changed the level by
# 0.4 dB. At this ratio the force stays above a fifth of the load at 1 and 3 m/s.
MIN_SMOOTHNESS_MOVING = 2.9
MIN_MARGIN = 1.5  # of the Nyquist frequency of the steps over the end of hearing
# Error of the release [dB of its fluctuation]: of steps as long as the contact radius, per decade
# of the step, and per decade of the approach over the roughness.
CONTACT_DB = -19.0
PER_RADIUS_DB = 37.5
PER_SMOOTHNESS_DB = 8.4
# The same for steps as long as rms roughness over slope whose band ends with hearing, per decade of
# the margin and of the step.
FOLDED_DB = -26.5
PER_MARGIN_DB = 35.1
PER_LENGTH_DB = 16.8


class StepChoice(NamedTuple):
    """Steps that `auto` takes.

    nodes : float. Length of a step in nodes.
    lowest : float, m/s. Lowest speed that steps of more than one node allow, otherwise 0.
    speed : float, m/s. Speed for which they were chosen.
    text : str. Number and reason.
    """

    nodes: float
    lowest: float
    speed: float
    text: str


def choose(scene: SceneQuantities, speed: float) -> StepChoice:
    """Choose the longest steps that a scene allows at a slowest speed [m/s]."""
    reason = _reason_for_one_node(scene)
    if reason:
        return StepChoice(1.0, 0.0, speed, f"1 node: {reason}")
    lowest = {nodes: lowest_speed(scene, nodes) for nodes in CHOICES}
    for nodes in CHOICES:
        if lowest[nodes] <= speed and scene.node_track.n_along % nodes == 0:
            step_um = micrometres(nodes * scene.spacing)
            least = rounded_up(lowest[nodes])
            text = f"{nodes} nodes: steps of {step_um} um hold hearing from {least} m/s on"
            return StepChoice(float(nodes), lowest[nodes], speed, text)
    least_nodes = min(CHOICES)
    if smoothness(scene) > MAX_SMOOTHNESS:
        reason = "not measured for a surface so smooth under its load"
    elif not math.isfinite(lowest[least_nodes]):
        reason = f"steps of {least_nodes} are too long for this contact"
    elif lowest[least_nodes] > speed:
        least_speed = rounded_up(lowest[least_nodes])
        reason = f"{least_nodes} need at least {least_speed} m/s"
    else:
        reason = f"the {scene.node_track.n_along} nodes of the track are no even number"
    return StepChoice(1.0, 0.0, speed, f"1 node: {reason}")


def _reason_for_one_node(scene: SceneQuantities) -> str:
    """Return why a scene is of a kind for which the rule was not measured; empty if it was."""
    if scene.height_paths:
        return "not measured for height files"
    if not scene.laws:
        return "the surface has no random roughness"
    if scene.surface.faults or scene.sphere.surface is not None:
        return "not measured for single faults, nor a surface of the sphere"
    if scene.is_permanent:
        return "not measured for a plate that remembers"
    if grid_error.has_sharp_edges(scene):
        return "not measured for sharp edges"
    if scene.rolling.falls:
        return "not measured for a drop"
    if scene.dynamics is not None and smoothness(scene) < MIN_SMOOTHNESS_MOVING:
        return "not measured for a ball that may bounce"
    if scene.recovery.rule == "left_end":
        return "the left-end rule needs short steps"
    if scene.recovery.events:
        return "recovery.events needs every position"
    return ""


def lowest_speed(scene: SceneQuantities, nodes: int) -> float:
    """Return the lowest speed [m/s] that steps of some nodes allow a scene; inf if none does."""
    grid_db = grid_error.grid_signal_db(scene)
    if grid_db is None:
        return math.inf
    step = nodes * scene.spacing
    if not is_fitted(scene, step):
        return math.inf
    wanted_db = min(max(grid_db - BELOW_GRID_DB, LEAST_DB), MOST_DB) - SAFETY_DB
    left = _power(wanted_db) - _power(contact_db(scene, step))
    if left <= 0:
        return math.inf
    margin = 10 ** ((folded_db(scene, step, 1.0) - 10 * math.log10(left)) / PER_MARGIN_DB)
    return speed_at(step, max(margin, MIN_MARGIN))


def is_fitted(scene: SceneQuantities, step: float) -> bool:
    """Tell whether the rule was fitted to scenes like this one with steps like these [m]."""
    is_short = step <= MAX_RADII * contact_radius(scene)
    return is_short and smoothness(scene) <= MAX_SMOOTHNESS


def speed_at(step: float, margin: float) -> float:
    """Return the speed [m/s] at which steps [m] sample hearing with a margin [-]."""
    return 2 * step * HEARD_HZ * margin


def error_db(scene: SceneQuantities, step: float, speed: float) -> float:
    """Estimate the rms error of the audible release from steps [m], over its fluctuation [dB]."""
    margin = speed / speed_at(step, 1.0)
    power = _power(contact_db(scene, step)) + _power(folded_db(scene, step, margin))
    return 10 * math.log10(power)


def contact_db(scene: SceneQuantities, step: float) -> float:
    """Estimate the error of the release [dB] of steps [m] that are long for the contact."""
    of_step = PER_RADIUS_DB * math.log10(step / contact_radius(scene))
    return CONTACT_DB + of_step + PER_SMOOTHNESS_DB * math.log10(max(smoothness(scene), 1.0))


def folded_db(scene: SceneQuantities, step: float, margin: float) -> float:
    """Estimate the error of the release [dB] that folds back into hearing from above its band."""
    rq, slope = grid_error.law_roughness(scene)
    of_step = PER_LENGTH_DB * math.log10(step * slope / rq)
    return FOLDED_DB + of_step - PER_MARGIN_DB * math.log10(margin)


def contact_radius(scene: SceneQuantities) -> float:
    """Estimate the larger of the elastic and the fully plastic reach [m] along the track."""
    narrower = scene.radius / scene.radius_across
    elastic = grid_error.hertz_radius(scene) * narrower ** (1 / 3)
    plastic = math.sqrt(scene.load / (math.pi * scene.hardness)) * narrower**0.25
    return float(max(elastic, plastic))


def smoothness(scene: SceneQuantities) -> float:
    """Estimate the approach of the smooth contact over the rms roughness [-]."""
    rq, _ = grid_error.law_roughness(scene)
    return contact_radius(scene) ** 2 / scene.radius / rq


def _power(decibels: float) -> float:
    return float(10 ** (decibels / 10))
