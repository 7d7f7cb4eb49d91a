"""Track of the sphere in whole nodes and whole steps, in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from rolling.scene import height_files
from rolling.scene.messages import fault, plain_number
from rolling.scene.motion import ROUNDING, Motion

MIN_NODES = 8  # minimum number of nodes along and across
MAX_NODES = 10**9  # maximum of nodes and steps along the track; more is an error of the unit
_DURATION, _SPEED, _PATH = ("rolling", "duration_s"), ("rolling", "speed_m_s"), ("surface", "path")
_WIDTH, _DISTANCE = ("surface", "width_um"), ("rolling", "distance_mm")


@dataclass(frozen=True)
class Rolled:
    """Distance that a scene asks for, as a duration or as a distance.

    Attributes
    ----------
    distance : float, m
        Distance.
    got : str
        Value in the scene.
    key : tuple of str
        Key of the value.
    """

    distance: float
    got: str
    key: tuple[str, str]

    @classmethod
    def during(cls, duration: float, motion: Motion) -> Rolled:
        """Return the distance of a duration [s]."""
        return cls(float(motion.distance(duration)), plain_number(duration), _DURATION)

    @classmethod
    def over(cls, distance_mm: float, motion: Motion) -> Rolled:
        """Return a distance [mm]; raise a fault where the sphere comes to rest before its end."""
        if distance_mm * 1e-3 > motion.final_distance * (1 + ROUNDING):
            raise fault(
                f"the sphere comes to rest after {motion.final_distance * 1e3:.6g} mm,"
                f" rolling.distance_mm is {plain_number(distance_mm)}: give it more speed",
                *_SPEED,
            )
        return cls(distance_mm * 1e-3, plain_number(distance_mm), _DISTANCE)

    def least(self, needed: float, motion: Motion) -> str:
        """Write the value of the key for a distance [m]."""
        value = needed * 1e3 if self.key == _DISTANCE else motion.duration(needed)
        return f"{value:.4g}"


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


def made_track(
    n_across: int, spacing: float, step_nodes: float, motion: Motion, rolled: Rolled
) -> Track:
    """Make the track over a generated surface, rounded so that it closes on itself.

    The track is as long as the sphere rolls. A distance that is too short or too long raises a
    fault.
    """
    step_fraction = _fraction(step_nodes)
    # The track is counted in the larger of step and node; the smaller then fits in whole numbers.
    unit_nodes = max(1, math.ceil(step_fraction))
    unit = unit_nodes * spacing
    distance, got = rolled.distance, rolled.got
    if not distance / min(unit, spacing * float(step_fraction)) < MAX_NODES:
        raise fault(f"got {got}, which is more than {MAX_NODES:g} nodes or steps", *rolled.key)
    units = _within_reach(round(distance / unit), unit, motion)
    least = math.ceil(MIN_NODES / unit_nodes)
    if units < least:
        needed = least * unit
        if needed > motion.final_distance * (1 + ROUNDING):
            raise fault(
                f"the sphere comes to rest after {motion.final_distance * 1e6:.4g} um, the"
                f" shortest track is {needed * 1e6:.4g} um: give it more speed",
                *_SPEED,
            )
        raise fault(
            f"got {got}, in which the sphere rolls {distance * 1e6:.4g} um; the shortest track is"
            f" {least * unit_nodes} nodes, {needed * 1e6:.4g} um: at least"
            f" {rolled.least(needed, motion)}",
            *rolled.key,
        )
    n_along = units * unit_nodes
    steps = int(n_along / step_fraction)
    return Track(n_along, n_across, steps, spacing * float(step_fraction), spacing, True, steps)


def file_track(
    nodes: tuple[int, int],
    spacing: float,
    step_nodes: float,
    motion: Motion,
    rolled: Rolled | None,
) -> Track:
    """Make the track over the heights of a file, by default once round it.

    `nodes` are those along and across. A sphere that rests too early raises a fault.
    """
    n_along, n_across = nodes
    step_fraction, step = _fraction(step_nodes), spacing * step_nodes
    lap = n_along * spacing
    if rolled is None and motion.final_distance * (1 + ROUNDING) < lap:
        raise fault(
            f"the sphere comes to rest after {motion.final_distance:.4g} m, once round the height"
            f" file is {lap:.4g} m: give it more speed or set rolling.duration_s",
            *_SPEED,
        )
    distance, key = (lap, _DURATION) if rolled is None else (rolled.distance, rolled.key)
    if not distance / step < MAX_NODES:
        raise fault(f"the sphere rolls {distance:.4g} m, more than {MAX_NODES:g} steps", *key)
    steps = max(1, _within_reach(round(distance / step), step, motion))
    nodes_round = n_along * step_fraction.denominator
    lap_steps = nodes_round // math.gcd(step_fraction.numerator, nodes_round)
    return Track(n_along, n_across, steps, step, spacing, steps % lap_steps == 0, lap_steps)


def _within_reach(count: int, length: float, motion: Motion) -> int:
    """Return a count, or one less where rounding exceeds the distance of a stopping sphere."""
    return count - 1 if count * length > motion.final_distance * (1 + ROUNDING) else count


def _fraction(step_nodes: float) -> Fraction:
    """Return the step in nodes as a fraction."""
    return Fraction(step_nodes).limit_denominator(16)


def height_nodes(path: Path, said: str, width_nodes: int | None) -> tuple[int, int]:
    """Read the nodes along and across of a height file.

    Parameters
    ----------
    path : Path
        File of heights.
    said : str
        The path as the scene has it.
    width_nodes : int or None
        Nodes across that the scene gives for a profile of one line; None: it gives none.

    Raises
    ------
    PydanticCustomError
        The file has no heights, too few, or a profile without a width.
    """
    try:
        rows, columns = height_files.nodes(path)
    except height_files.HeightFormatError as error:
        looked = f" (looked in {path.parent.absolute()})" if not path.is_file() else ""
        raise fault(f"{error.of(said)}{looked}", *_PATH) from error
    if columns == 1 and width_nodes is None:
        raise fault(
            f"missing, allowed: a number > 0, because {said} is a profile of one line, which is"
            " laid across the track over that width",
            *_WIDTH,
        )
    if columns > 1 and width_nodes is not None:
        raise fault(
            f"only goes with a profile of one line, but {said} has {columns} lines side by side",
            *_WIDTH,
        )
    nodes = rows, columns if width_nodes is None else width_nodes
    if not MIN_NODES <= min(nodes) <= max(nodes) < MAX_NODES:
        raise fault(
            f"{said}: got {nodes[0]} x {nodes[1]} nodes, allowed: at least {MIN_NODES} each way and"
            f" less than {MAX_NODES:g}",
            *_PATH,
        )
    return nodes
