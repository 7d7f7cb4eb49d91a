"""Stretches of a run that were marched again for its error estimate, as they are kept."""

from __future__ import annotations

from dataclasses import dataclass, field

from rolling._typing import Array
from rolling.check.error_cost import LEVELS


@dataclass(frozen=True)
class March:
    """The march of a stretch on a level.

    first : int. First position of the stretch.
    level : str. Key of LEVELS.
    release : (steps,) array, J. Release per step; NaN if the march failed.
    plastic_area : float, m2. Mean area at the hardness.
    seconds : float, s. Time of the march.
    fault : str. Reason of a failure; empty if there is none.
    """

    first: int
    level: str
    release: Array
    plastic_area: float
    seconds: float
    fault: str = ""

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.release)


@dataclass
class ErrorStretches:
    """All marches of the stretches of a run.

    steps : int. Number of steps of a stretch.
    marches : dict. Marches by first position and level.
    """

    steps: int
    marches: dict[tuple[int, str], March] = field(default_factory=dict)

    def add(self, march: March) -> None:
        """Add a march."""
        self.marches[march.first, march.level] = march

    def complete(self, first: int) -> bool:
        """Return whether a stretch is marched on all levels."""
        return all((first, level) in self.marches for level in LEVELS)

    @property
    def fault(self) -> str:
        """The reason of the first failure along the track; empty if there is none."""
        order = sorted(self.marches, key=lambda key: (key[0], LEVELS.index(key[1])))
        return next((text for key in order if (text := self.marches[key].fault)), "")

    @property
    def seconds(self) -> float:
        """Time of all marches [s]."""
        return sum(march.seconds for march in self.marches.values())
