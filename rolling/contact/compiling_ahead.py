"""Compilation of the longest kernels of the solver beside a march, in a process of its own.

A first march compiles half a minute of other kernels meanwhile; it finds these in the cache.
"""

from __future__ import annotations

import numpy as np

from rolling.contact._descent import NEARLY_WHOLE, SWEEPS, Candidates, Descent, Goal
from rolling.contact._system import Limits
from rolling.contact.half_space import HalfSpace


def compile_longest() -> None:
    """Step and lead on a contact of a few nodes, with arguments of the types of a march."""
    pressure, deflection, gap = np.ones((3, 4, 4))
    candidates = Candidates(np.arange(gap.size), 0.0, 0, 0, *gap.shape)
    limits, goal = Limits(np.inf, float(pressure.sum())), Goal(1e-4, 1.0)
    descent = Descent(
        HalfSpace(1e-6, 1e11), candidates, pressure, gap, None, limits, goal, single=True
    )
    descent.step_along(NEARLY_WHOLE, 0.0, goal.violation, SWEEPS, 0, finishing=True)
    descent.lead(pressure, deflection, pressure, deflection, (0, 0))
