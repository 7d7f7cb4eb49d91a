"""Single faults of a surface: pits, scratches, dents, bumps, steps and grooves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from acoustics.numbers import rounded
from rolling.scene.laws import HeightLaw
from rolling.scene.messages import Key, fault, plain_number
from rolling.scene.sections import Section

MOST_FAULTS = 10_000  # of a count
# Maximum slope of a kind times its size over its depth.
_STEEPEST = {"pit": 4.0, "dent": 2.8, "step": math.pi / 2}


class SurfaceFault(Section):
    """Fault of a surface at a place, or several equal faults at random places.

    Attributes
    ----------
    kind : str
        pit: a paraboloid hole; dent: a hole whose raised rim holds the displaced volume; bump: a
        rounded hill; scratch: a line; groove: a line across the whole surface; step: a rise over
        size_um that falls back evenly over the rest of the surface
    at_mm : list of float, optional
        Place [x, y] [mm]: x along the surface from its start, y from the line of the sphere;
        absent: random places
    count : int, optional
        Number of faults at random places, in place of at_mm
    seed : int, optional
        Seed of the random places
    size_um : float
        Diameter, or width of a scratch, of a groove or of the flank of a step [um]
    depth_um : float
        Depth, or height of a bump or step [um]
    length_um : float, optional
        Length of a scratch [um]
    angle_deg : float, optional
        Angle of a scratch to the track [degrees]; absent: 90, across it
    """

    SECTION: ClassVar[str] = "faults"

    kind: Literal["pit", "scratch", "dent", "bump", "step", "groove"]
    at_mm: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None
    count: int | None = Field(default=None, ge=1, le=MOST_FAULTS)
    seed: int | None = Field(default=None, ge=0)
    size_um: float = Field(gt=0)
    depth_um: float = Field(gt=0, le=1e4)
    length_um: float | None = Field(default=None, gt=0)
    angle_deg: float | None = Field(default=None, ge=-180, le=180)

    @model_validator(mode="after")
    def _one_place(self) -> SurfaceFault:
        random = self.count is not None, self.seed is not None
        if random != (self.at_mm is None,) * 2:
            raise fault("a fault needs either at_mm, or count and seed")
        if (self.kind == "scratch") != (self.length_um is not None):
            words = "missing; a scratch" if self.length_um is None else "only a scratch"
            raise fault(f"length_um: {words} has a length")
        if self.kind != "scratch" and self.angle_deg is not None:
            raise fault("angle_deg: only a scratch has an angle")
        return self

    @property
    def crosses(self) -> bool:
        """Whether the fault crosses the whole surface."""
        return self.kind in ("groove", "step")

    @property
    def steepest(self) -> float:
        """Maximum slope [-]."""
        return _STEEPEST.get(self.kind, math.pi) * self.depth_um / self.size_um


class SurfaceKind(Section):
    """Surface of plate or sphere, of any kind.

    Attributes
    ----------
    faults : list of SurfaceFault, optional
        Single faults, added to the other heights of the surface
    """

    IN_FILES: ClassVar[str] = "kind"

    kind: str

    @property
    def law(self) -> HeightLaw | None:
        """Law of the random heights, None without random heights."""
        return None


def refuse_misplaced(
    faults: Sequence[SurfaceFault], length_um: float, width_um: float, spacing_um: float, at: Key
) -> None:
    """Raise a fault for the first that lies beyond its surface, or that no node or surface holds.

    `at` is the key of the list.
    """
    for number, listed in enumerate(faults):
        size, longest = max(listed.size_um, listed.length_um or 0.0), length_um
        if not listed.crosses:
            longest = min(length_um, width_um)
        if listed.size_um < spacing_um:
            words = f"got {plain_number(listed.size_um)}, allowed: at least a node of"
            raise fault(f"{words} {spacing_um:g} um", *at, number, "size_um")
        if size > longest:
            name = "size_um" if size == listed.size_um else "length_um"
            words = f"got {plain_number(size)}, allowed: at most {rounded(longest, 6)}"
            raise fault(f"{words}, the size of the surface in um", *at, number, name)
        x, y = listed.at_mm or (0.0, 0.0)
        if not 0 <= x * 1e3 < length_um or abs(y) * 2e3 > width_um:
            words = (
                f"x from 0 to {rounded(length_um * 1e-3, 6)} mm, y within"
                f" {rounded(width_um * 5e-4, 6)} mm of the line of the sphere"
            )
            got = f"got [{plain_number(x)}, {plain_number(y)}], which is beyond the surface"
            raise fault(f"{got}, allowed: {words}", *at, number, "at_mm")
