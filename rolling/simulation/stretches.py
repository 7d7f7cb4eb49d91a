"""Stretches of a run that were marched for its error estimate and its tolerance, as kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rolling._typing import Array
from rolling.check.error_cost import LEVELS


@dataclass(frozen=True)
class March:
    """The march of a stretch on a level.

    first : int. First position of the stretch.
    level : str. Name of the level.
    release : (steps,) array, J. Release per step; NaN if the march failed.
    plastic_area : float, m2. Mean area at the hardness.
    seconds : float, s. Time of the march.
    fault : str. Reason of a failure; empty if there is none.
    approach : (steps + 1,) array, m. Approach at each position; empty without dynamics.
    """

    first: int
    level: str
    release: Array
    plastic_area: float
    seconds: float
    fault: str = ""
    approach: Array = field(default_factory=lambda: np.empty(0))

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


@dataclass(frozen=True)
class Trial:
    """The choice of a tolerance that the scene left open.

    tolerance : float. The tolerance that was chosen.
    reason : str. Reason why no trial decided; empty if one did.
    stretches, steps : int. Number of stretches, and of steps of each.
    grid_signal_db, solver_signal_db : float, dB. Rms error of the release over its fluctuation from
        the grid, and from the solver at the chosen tolerance; None without a trial.
    seconds : float, s. Time of the marches.
    """

    tolerance: float
    reason: str
    stretches: int = 0
    steps: int = 0
    grid_signal_db: float | None = None
    solver_signal_db: float | None = None
    seconds: float = 0.0
