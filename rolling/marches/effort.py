"""Processor time of a run by its parts, in whichever processes they were done."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from acoustics.arrays import short_repr
from rolling.contact.processor_time import ProcessorTime

ARRAY = "effort"  # name of the processor times of a piece, among its arrays
COMPILATION = "compilation"  # of kernels, and loading of compiled ones
SURFACE = "surface"  # its making, in each process that marches it
MARCH = "march"  # of the track, or of the rough contacts of a bearing at their middle load
LOAD_MARCHES = "load_marches"  # at other loads
MOVING_RELEASE = "moving_release"  # of the release under the moving load
FAULT_STRETCHES = "fault_stretches"  # of a bearing, with a single fault and without
SOUND = "sound"  # motions, sound, numbers and files of a run
PAGE = "page"  # share of a run in figures and page of its folder
# Parts that a run of a sphere and a run of a bearing state, but for the last two.
OF_SPHERE = (
    *(COMPILATION, SURFACE, MARCH, LOAD_MARCHES),
    *("error_stretches", MOVING_RELEASE, "slow_motion"),
)
OF_BEARING = (COMPILATION, SURFACE, MARCH, LOAD_MARCHES, FAULT_STRETCHES)
# Part of the marches of each kind of piece.
PARTS_OF_MARCHES = {
    "track": MARCH,
    "pass": MARCH,
    "error": "error_stretches",
    "load": LOAD_MARCHES,
    "judge": LOAD_MARCHES,
    "moving": MOVING_RELEASE,
    "film": "slow_motion",
}


class PieceEffort(NamedTuple):
    """Processor times of a piece, all in seconds: its surface, its march, and compilation."""

    surface_s: float
    march_s: float
    compilation_s: float


@dataclass
class Effort:
    """Processor times of a run.

    seconds : dict. Processor time [s] by part; a part that was not done has none.
    """

    __repr__ = short_repr

    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, part: str, seconds: float) -> None:
        """Add processor time [s] to a part."""
        self.seconds[part] = self.seconds.get(part, 0.0) + seconds

    def add_piece(self, part: str, piece: PieceEffort) -> None:
        """Add the times of a piece, whose march belongs to a part."""
        self.add(part, piece.march_s)
        self.add(SURFACE, piece.surface_s)
        self.add(COMPILATION, piece.compilation_s)

    def of_march(self) -> PieceEffort:
        """Return the processor times of a run that has no other march than that of its track."""
        return PieceEffort(
            surface_s=self.seconds.get(SURFACE, 0.0),
            march_s=self.march_s,
            compilation_s=self.seconds.get(COMPILATION, 0.0),
        )

    @property
    def march_s(self) -> float:
        """Processor time [s] of the march; 0 for a march that was taken from another run."""
        return self.seconds.get(MARCH, 0.0)

    def numbers(self, parts: tuple[str, ...]) -> dict[str, float | None]:
        """Return the processor times [s] of parts for summary.json; sound and page are to come."""
        marched = {part: self.seconds.get(part, 0.0) for part in parts}
        return marched | {SOUND: None, PAGE: None}


def with_work(
    numbers: Mapping[str, float | None], part: str, spent: ProcessorTime
) -> dict[str, float | None]:
    """Return the processor times [s] of parts with more of one; compilation has its own."""
    return dict(numbers) | {
        part: (numbers.get(part) or 0.0) + spent.work_s,
        COMPILATION: (numbers.get(COMPILATION) or 0.0) + spent.compilation_s,
    }


def with_page(
    parts: Mapping[str, float | None], spent: ProcessorTime, runs: int
) -> dict[str, float | None]:
    """Return the processor times [s] of a run with its share in a page of so many runs."""
    return dict(parts) | {PAGE: (spent.work_s + spent.compilation_s) / runs}
