"""Track of the sphere in whole nodes and whole steps, in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from rolling.scene.height_header import HeaderError, header
from rolling.scene.messages import fault, plain_number
from rolling.scene.motion import ROUNDING, Motion

MIN_NODES = 8  # minimum number of nodes along and across
MAX_NODES = 10**9  # maximum of nodes and steps along the track; more is an error of the unit
_DURATION, _SPEED, _PATH = ("rolling", "duration_s"), ("rolling", "speed_m_s"), ("surface", "path")


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
    n_across: int, spacing: float, step_nodes: float, motion: Motion, duration: float
) -> Track:
    """Make the track over a generated surface, rounded so that it closes on itself.

    The track is as long as the sphere rolls. A duration [s] that is too short or too long raises a
    fault.
    """
    step_fraction = _fraction(step_nodes)
    # The track is counted in the larger of step and node; the smaller then fits in whole numbers.
    unit_nodes = max(1, math.ceil(step_fraction))
    unit = unit_nodes * spacing
    distance = float(motion.distance(duration))
    got = plain_number(duration)
    if not distance / min(unit, spacing * float(step_fraction)) < MAX_NODES:
        raise fault(f"got {got}, which is more than {MAX_NODES:g} nodes or steps", *_DURATION)
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
            f" {motion.duration(needed):.4g}",
            *_DURATION,
        )
    n_along = units * unit_nodes
    steps = int(n_along / step_fraction)
    return Track(n_along, n_across, steps, spacing * float(step_fraction), spacing, True, steps)


def file_track(
    path: Path, said: str, spacing: float, step_nodes: float, motion: Motion, duration: float | None
) -> Track:
    """Make the track over the heights of a file, by default once round it.

    `said` is the path as the scene gives it. A file without heights, or a sphere that rests too
    early, raises a fault.
    """
    n_along, n_across = _shape(path, said)
    step_fraction, step = _fraction(step_nodes), spacing * step_nodes
    lap = n_along * spacing
    if duration is None and motion.final_distance * (1 + ROUNDING) < lap:
        raise fault(
            f"the sphere comes to rest after {motion.final_distance:.4g} m, once round the height"
            f" file is {lap:.4g} m: give it more speed or set rolling.duration_s",
            *_SPEED,
        )
    distance = lap if duration is None else float(motion.distance(duration))
    if not distance / step < MAX_NODES:
        raise fault(f"the sphere rolls {distance:.4g} m, more than {MAX_NODES:g} steps", *_DURATION)
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


def _shape(path: Path, said: str) -> tuple[int, int]:
    """Return the shape of a height file from its header."""
    try:
        shape, dtype = header(path)
    except HeaderError as error:
        looked = f" (looked in {path.parent.absolute()})" if not path.is_file() else ""
        allowed = (
            ", allowed: one 2-D array of real heights in m, (along track, across)"
            if "archive" in str(error)
            else ""
        )
        raise fault(f"{said}: {error}{looked}{allowed}", *_PATH) from error
    if len(shape) != 2 or dtype.kind not in "fiu":
        got = f"{len(shape)}-D {dtype}"
        raise fault(
            f"{said}: got {got}, allowed: one 2-D array of real heights in m, (along track,"
            " across)",
            *_PATH,
        )
    if min(shape) < MIN_NODES:
        raise fault(
            f"{said}: got {shape[0]} x {shape[1]} nodes, allowed: at least {MIN_NODES} each way",
            *_PATH,
        )
    return shape[0], shape[1]
