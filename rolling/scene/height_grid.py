"""Grid that a height file becomes: its nodes as read, resampled and made periodic.

The track needs the nodes before the heights are prepared. They follow from the shape and the
spacing of the file and from the keys of the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from acoustics.numbers import rounded
from rolling.scene import height_files, instruments
from rolling.scene.height_files import MAX_BYTES
from rolling.scene.messages import fault, plain_number
from rolling.scene.surfaces import HeightFile, refuse_width
from rolling.scene.track import MAX_NODES, MIN_NODES, readable

DEFAULT_OVERLAP, MOST_OVERLAP = 0.1, 0.5  # of each side
SAME = 1e-6  # relative difference of spacings that count as equal
Pair = tuple[int, int]


@dataclass(frozen=True)
class HeightGrid:
    """Nodes along and across the track, from the file to the period that is rolled over."""

    steps: tuple[float, float]  # [m] spacings of the file
    spacing: float  # [m] of the period
    resampled: Pair  # nodes of the file at that spacing; a profile has its width
    overlap: Pair  # nodes that are blended into the beginning
    nodes: Pair  # of the period


def is_other(steps: Sequence[float], spacing: float) -> bool:
    """Tell whether the spacings [m] of a file differ from that of its period."""
    return any(abs(step / spacing - 1) > SAME for step in steps)


def is_turned(shape: Pair, surface: HeightFile) -> bool:
    """Tell whether columns of a file lie along the track; a profile of one row always does."""
    return shape[0] == 1 if 1 in shape else surface.along == "x"


def height_grid(path: Path, surface: HeightFile) -> HeightGrid:
    """Derive the nodes of the period of a height file from its shape, its spacing and the keys.

    Raise a fault where the file has no heights or does not go with the keys of the surface.
    """
    shape, steps = readable(path, surface.path, ("surface", "path"), lambda: _read(path, surface))
    if is_turned(shape, surface):
        shape, steps = shape[::-1], steps and steps[::-1]
    spacing = min(steps or (0.0,)) if surface.spacing_um is None else surface.spacing_um * 1e-6
    steps = steps or (spacing, spacing)
    is_profile = shape[1] == 1
    if is_profile != (surface.width_um is not None):
        lines = f"{surface.path} has {shape[1]} lines side by side"
        words = f"only goes with a profile of one line, but {lines}"
        if is_profile:
            words = f"missing; {surface.path} is a profile of one line, which is laid across the"
            words += " track over that width"
        raise fault(words, "surface", "width_um")
    if surface.width_um is not None:
        refuse_width(surface.width_um, spacing * 1e6)
        shape, steps = (shape[0], round(surface.width_um * 1e-6 / spacing)), (steps[0], spacing)
    _refuse_filters(surface, 1e6 * min(shape[k] * steps[k] for k in (0, 1)[: 2 - is_profile]))
    resampled = shape
    if is_other(steps, spacing):
        wraps = surface.made_periodic == "none"  # a period keeps its length, to half a node
        sizes = ((shape[k] - (not wraps)) * steps[k] / spacing for k in (0, 1))
        along, across = (
            round(min(size, 2e9)) if wraps else int(min(size, 2e9) + SAME) + 1 for size in sizes
        )
        resampled = along, across
    if resampled != shape and 8 * resampled[0] * resampled[1] > MAX_BYTES:
        got = f"got {rounded(spacing * 1e6, 4)}, which makes {resampled[0]} x {resampled[1]} nodes"
        most = f"less than {rounded(MAX_BYTES / 8)} nodes"
        raise fault(f"{got} of {surface.path}, allowed: {most}", "surface", "spacing_um")
    overlap, nodes = [0, 0], [*resampled]
    for axis in (0,) if is_profile else (0, 1):
        if surface.made_periodic == "blend":
            overlap[axis] = _overlap(surface, resampled[axis], spacing)
            nodes[axis] -= overlap[axis]
        elif surface.made_periodic == "mirror":
            nodes[axis] = 2 * resampled[axis] - 2
    if not MIN_NODES <= min(nodes) <= max(nodes) < MAX_NODES:
        raise fault(
            f"{surface.path}: got {nodes[0]} x {nodes[1]} nodes, allowed: at least {MIN_NODES} each"
            f" way and less than {rounded(MAX_NODES)}",
            *("surface", "path"),
        )
    return HeightGrid(steps, spacing, resampled, (overlap[0], overlap[1]), (nodes[0], nodes[1]))


def _read(path: Path, surface: HeightFile) -> tuple[Pair, tuple[float, float] | None]:
    """Read the shape of a file, and the spacings [m] of a file that has its own."""
    if not instruments.is_instrument(path):
        return height_files.nodes(path), None
    measured = instruments.read(path, surface.channel, surface.height_unit)
    rows, columns = measured.heights.shape
    return (rows, columns), measured.spacing_m


def _overlap(surface: HeightFile, count: int, spacing: float) -> int:
    """Return the nodes of an overlap, by default a tenth of a side; refuse more than half."""
    if surface.overlap_um is None:
        return round(DEFAULT_OVERLAP * count)
    overlap = round(min(surface.overlap_um * 1e-6 / spacing, 2e9))
    if not 1 <= overlap <= MOST_OVERLAP * count:
        got, most = plain_number(surface.overlap_um), int(MOST_OVERLAP * count) * spacing * 1e6
        allowed = f"{rounded(spacing * 1e6, 4)} to {rounded(most, 4)}, half of a side"
        raise fault(f"got {got}, allowed: {allowed}", "surface", "overlap_um")
    return overlap


def _refuse_filters(surface: HeightFile, side_um: float) -> None:
    """Refuse cut-offs above the shorter side of the file [um]."""
    for key in ("s_filter_um", "l_filter_um"):
        cutoff = getattr(surface, key)
        if cutoff is not None and cutoff > side_um * (1 + SAME):
            words = f"up to {rounded(side_um, 4)}, the shorter side of {surface.path}"
            raise fault(f"got {plain_number(cutoff)}, allowed: {words}", "surface", key)
