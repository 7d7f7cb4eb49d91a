"""Track of a scene: whole nodes and whole steps of the length that its keys ask for.

A length that no track has raises a mistake at the key that asks for it.
"""

import math
from fractions import Fraction
from typing import NamedTuple

from pydantic_core import PydanticCustomError

from acoustics.numbers import rounded
from rolling.contact.track import MARGIN_WIDTHS, MAX_NODES, MIN_NODES, ROUNDING, Motion, Track
from rolling.scene.messages import mistake, plain_number


class WantedDistance(NamedTuple):
    """Distance [m] that a scene asks for, with the value in the scene and its key."""

    distance: float
    value: float
    key: str


def wanted_distance(
    duration_s: float | None, distance_mm: float | None, resistance: float | None, motion: Motion
) -> WantedDistance | None:
    """Return the distance of a scene; raise a mistake where the sphere comes to rest before it."""
    if distance_mm is not None:
        if distance_mm * 1e-3 > motion.final_distance * (1 + ROUNDING):
            raise mistake(
                f"the sphere comes to rest after {rounded(motion.final_distance * 1e3, 6)} mm,"
                f" rolling.distance_mm is {plain_number(distance_mm)}: give it more speed",
                at="rolling.speed_m_s",
            )
        return WantedDistance(distance_mm * 1e-3, value=distance_mm, key="rolling.distance_mm")
    if duration_s is not None:
        distance = float(motion.distance(duration_s))
        return WantedDistance(distance, value=duration_s, key="rolling.duration_s")
    if resistance:
        return WantedDistance(motion.final_distance, value=resistance, key="rolling.resistance")
    return None


def made_track(
    n_across: int,
    spacing: float,
    step_nodes: float,
    motion: Motion,
    wanted: WantedDistance,
    turn_nodes: int = 0,
) -> Track:
    """Make the track over a generated surface, rounded so that it closes on itself.

    Under a sphere with a surface it closes after whole turns only; otherwise its surface is longer.
    A distance that is too short or too long raises a mistake.
    """
    step = _fraction(step_nodes)
    # The track is counted in the larger of step and node; the smaller then fits in whole numbers.
    unit_nodes = max(1, math.ceil(step))
    unit = unit_nodes * spacing
    step_length = spacing * float(step)
    if not wanted.distance / min(unit, step_length) < MAX_NODES:
        raise mistake(
            f"got {plain_number(wanted.value)}, which is more than {rounded(MAX_NODES)} nodes or"
            " steps",
            at=wanted.key,
        )
    units = _within_reach(wanted.distance, unit, motion)
    least_units = math.ceil(MIN_NODES / unit_nodes)
    if units < least_units:
        raise _too_short(wanted, motion, nodes=least_units * unit_nodes, length=least_units * unit)
    n_along = units * unit_nodes
    steps = int(n_along / step)
    closed = not turn_nodes or n_along % turn_nodes == 0
    lap_steps = steps
    if not closed:
        n_along += MARGIN_WIDTHS * n_across
        lap_steps = _lap_steps(n_along, step)
    return Track(
        n_along=n_along,
        n_across=n_across,
        steps=steps,
        step=step_length,
        spacing=spacing,
        closed=closed,
        lap_steps=lap_steps,
        plate_nodes=n_along,
        turn_nodes=turn_nodes,
    )


def _too_short(
    wanted: WantedDistance, motion: Motion, nodes: int, length: float
) -> PydanticCustomError:
    """Make the mistake of a track that is shorter than some nodes of a length [m] together."""
    shortest = f"the shortest track is {nodes} nodes, {rounded(length * 1e6, 4)} um"
    if length > motion.final_distance * (1 + ROUNDING):
        return mistake(
            f"the sphere comes to rest after {rounded(motion.final_distance * 1e6, 4)} um,"
            f" {shortest}: give it more speed",
            at="rolling.speed_m_s",
        )
    least = motion.duration(length) if wanted.key == "rolling.duration_s" else length * 1e3
    return mistake(
        f"got {plain_number(wanted.value)}, in which the sphere rolls"
        f" {rounded(wanted.distance * 1e6, 4)} um; {shortest}: at least {rounded(least, 4)}",
        at=wanted.key,
    )


def file_track(
    nodes: tuple[int, int],
    spacing: float,
    step_nodes: float,
    motion: Motion,
    wanted: WantedDistance | None,
    turn_nodes: int = 0,
) -> Track:
    """Make the track over the heights of a file of some nodes, by default once round it.

    Under a sphere with a surface it closes after whole turns of both only. A sphere that rests too
    early raises a mistake.
    """
    plate_nodes, n_across = nodes
    step = _fraction(step_nodes)
    step_length = spacing * step_nodes
    if wanted is None:
        lap = plate_nodes * spacing
        if motion.final_distance * (1 + ROUNDING) < lap:
            raise mistake(
                f"the sphere comes to rest after {rounded(motion.final_distance, 4)} m, once round"
                f" the height file is {rounded(lap, 4)} m: give it more speed or set"
                " rolling.duration_s",
                at="rolling.speed_m_s",
            )
        wanted = WantedDistance(lap, value=lap, key="rolling.duration_s")
    if not wanted.distance / step_length < MAX_NODES:
        raise mistake(
            f"the sphere rolls {rounded(wanted.distance, 4)} m, more than {rounded(MAX_NODES)}"
            " steps",
            at=wanted.key,
        )
    steps = max(1, _within_reach(wanted.distance, step_length, motion))
    n_along = plate_nodes
    if turn_nodes:
        rolled_nodes = math.ceil(steps * step) + MARGIN_WIDTHS * n_across
        n_along = min(math.lcm(plate_nodes, turn_nodes), rolled_nodes)
    lap_steps = _lap_steps(n_along, step)
    return Track(
        n_along=n_along,
        n_across=n_across,
        steps=steps,
        step=step_length,
        spacing=spacing,
        closed=steps % lap_steps == 0,
        lap_steps=lap_steps,
        plate_nodes=plate_nodes,
        turn_nodes=turn_nodes,
    )


def _lap_steps(n_along: int, step: Fraction) -> int:
    """Return the steps, in nodes, after which the positions on a surface repeat."""
    nodes = n_along * step.denominator
    return nodes // math.gcd(step.numerator, nodes)


def _within_reach(distance: float, length: float, motion: Motion) -> int:
    """Return a distance in whole lengths [m], one less where a stopping sphere falls short."""
    count = round(distance / length)
    return count - 1 if count * length > motion.final_distance * (1 + ROUNDING) else count


def _fraction(step_nodes: float) -> Fraction:
    """Return the step in nodes as a fraction."""
    return Fraction(step_nodes).limit_denominator(16)
