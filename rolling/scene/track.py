"""Track of the sphere in whole nodes and whole steps, in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from acoustics.numbers import rounded
from rolling.scene import height_files
from rolling.scene.messages import cut, fault, plain_number
from rolling.scene.motion import ROUNDING, Motion

MIN_NODES = 8  # minimum number of nodes along and across
MAX_NODES = 10**9  # maximum of nodes and steps along the track; more is an error of the unit
_SPEED, _PATH = ("rolling", "speed_m_s"), ("surface", "path")
_RESISTANCE = "rolling", "resistance"
_DURATION, _DISTANCE = ("rolling", "duration_s"), ("rolling", "distance_mm")


@dataclass(frozen=True)
class Track:
    """Positions of the sphere on its surface.

    Attributes
    ----------
    n_along, n_across : int
        Nodes of the surface.
    steps : int
        Number of steps; there is one position more.
    step, spacing : float, m
        Distance between positions, and between nodes.
    closed : bool
        If true, the last position coincides with the first.
    lap_steps : int
        Steps after which the positions repeat.
    """

    n_along: int
    n_across: int
    steps: int
    step: float
    spacing: float
    closed: bool
    lap_steps: int

    @property
    def solved_steps(self) -> int:
        """Number of steps that differ from each other and have to be solved."""
        return min(self.steps, self.lap_steps)

    @property
    def distance(self) -> float:
        """Distance rolled [m]."""
        return self.steps * self.step


class Rolled(NamedTuple):
    """Distance [m] that a scene asks for, with the value in the scene and its key."""

    distance: float
    value: float
    key: tuple[str, str]


def rolled(
    duration_s: float | None, distance_mm: float | None, resistance: float | None, motion: Motion
) -> Rolled | None:
    """Return the distance of a scene; raise a fault where the sphere comes to rest before it."""
    if distance_mm is None:
        if duration_s is None:
            return Rolled(motion.final_distance, resistance, _RESISTANCE) if resistance else None
        return Rolled(float(motion.distance(duration_s)), duration_s, _DURATION)
    if distance_mm * 1e-3 > motion.final_distance * (1 + ROUNDING):
        raise fault(
            f"the sphere comes to rest after {rounded(motion.final_distance * 1e3, 6)} mm,"
            f" rolling.distance_mm is {plain_number(distance_mm)}: give it more speed",
            *_SPEED,
        )
    return Rolled(distance_mm * 1e-3, distance_mm, _DISTANCE)


def made_track(
    n_across: int, spacing: float, step_nodes: float, motion: Motion, wanted: Rolled
) -> Track:
    """Make the track over a generated surface, rounded so that it closes on itself.

    A distance that is too short or too long raises a fault.
    """
    step = _fraction(step_nodes)
    # The track is counted in the larger of step and node; the smaller then fits in whole numbers.
    unit_nodes = max(1, math.ceil(step))
    unit = unit_nodes * spacing
    distance, got = wanted.distance, plain_number(wanted.value)
    if not distance / min(unit, spacing * float(step)) < MAX_NODES:
        raise fault(
            f"got {got}, which is more than {rounded(MAX_NODES)} nodes or steps", *wanted.key
        )
    units, least = _within_reach(distance, unit, motion), math.ceil(MIN_NODES / unit_nodes)
    if units < least:
        shortest = f"track is {least * unit_nodes} nodes, {rounded(least * unit * 1e6, 4)} um"
        if least * unit > motion.final_distance * (1 + ROUNDING):
            rest = f"the sphere comes to rest after {rounded(motion.final_distance * 1e6, 4)} um"
            raise fault(f"{rest}, the shortest {shortest}: give it more speed", *_SPEED)
        value = least * unit * 1e3
        if wanted.key == _DURATION:
            value = motion.duration(least * unit)
        raise fault(
            f"got {got}, in which the sphere rolls {rounded(distance * 1e6, 4)} um; the shortest"
            f" {shortest}: at least {rounded(value, 4)}",
            *wanted.key,
        )
    n_along = units * unit_nodes
    steps = int(n_along / step)
    return Track(n_along, n_across, steps, spacing * float(step), spacing, True, steps)


def file_track(
    nodes: tuple[int, int],
    spacing: float,
    step_nodes: float,
    motion: Motion,
    wanted: Rolled | None,
) -> Track:
    """Make the track over the heights of a file of some nodes, by default once round it.

    A sphere that rests too early raises a fault.
    """
    n_along, n_across = nodes
    fraction, step, lap = _fraction(step_nodes), spacing * step_nodes, n_along * spacing
    if wanted is None and motion.final_distance * (1 + ROUNDING) < lap:
        raise fault(
            f"the sphere comes to rest after {rounded(motion.final_distance, 4)} m, once round the"
            f" height file is {rounded(lap, 4)} m: give it more speed or set rolling.duration_s",
            *_SPEED,
        )
    distance, _, key = wanted or Rolled(lap, lap, _DURATION)
    if not distance / step < MAX_NODES:
        raise fault(
            f"the sphere rolls {rounded(distance, 4)} m, more than {rounded(MAX_NODES)} steps", *key
        )
    steps = max(1, _within_reach(distance, step, motion))
    nodes_round = n_along * fraction.denominator
    lap_steps = nodes_round // math.gcd(fraction.numerator, nodes_round)
    return Track(n_along, n_across, steps, step, spacing, steps % lap_steps == 0, lap_steps)


def _within_reach(distance: float, length: float, motion: Motion) -> int:
    """Return a distance in whole lengths [m], one less where a stopping sphere falls short."""
    count = round(distance / length)
    return count - 1 if count * length > motion.final_distance * (1 + ROUNDING) else count


def _fraction(step_nodes: float) -> Fraction:
    """Return the step in nodes as a fraction."""
    return Fraction(step_nodes).limit_denominator(16)


def height_nodes(path: Path, name: str, width_nodes: int | None) -> tuple[int, int]:
    """Read the nodes along and across of a height file; raise a fault where it has no heights.

    Parameters
    ----------
    path : Path
        File of heights.
    name : str
        The path as the scene has it.
    width_nodes : int or None
        Nodes across that the scene gives for a profile of one line; None: it gives none.
    """
    try:
        rows, columns = height_files.nodes(path)
    except height_files.HeightFormatError as error:
        missing = isinstance(error.__cause__, FileNotFoundError)
        place = f" (looked in {path.parent.absolute()})" if missing else ""
        raise fault(f"{error.of(cut(name))}{place}", *_PATH) from error
    if (columns == 1) != (width_nodes is not None):
        words = f"only goes with a profile of one line, but {name} has {columns} lines side by side"
        if columns == 1:
            words = (
                f"missing; {name} is a profile of one line, which is laid across the track over"
                " that width"
            )
        raise fault(words, "surface", "width_um")
    nodes = rows, columns if width_nodes is None else width_nodes
    if not MIN_NODES <= min(nodes) <= max(nodes) < MAX_NODES:
        raise fault(
            f"{name}: got {nodes[0]} x {nodes[1]} nodes, allowed: at least {MIN_NODES} each way and"
            f" less than {rounded(MAX_NODES)}",
            *_PATH,
        )
    return nodes
