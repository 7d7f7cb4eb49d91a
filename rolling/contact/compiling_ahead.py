"""Compilation of the longest kernels of the solver beside a march, in processes of their own.

A first march compiles half a minute of other kernels meanwhile; it finds these in the cache. Each
function compiles what a process can do alone.
"""

from __future__ import annotations

import numpy as np

from rolling.contact import _far_field, _model_kernels, _solver_kernels, _window_kernels
from rolling.contact._descent import NEARLY_WHOLE, SWEEPS, Candidates, Descent, Goal
from rolling.contact._system import Limits, System, system_of
from rolling.contact.half_space import HalfSpace


def compile_step() -> None:
    """Compile the step of a descent, which takes longer than any other kernel."""
    descent = _descent()
    descent.step_along(NEARLY_WHOLE, 0.0, descent.goal, SWEEPS, 0, finishing=True)


def compile_parts() -> None:
    """Compile parts of the step, and the kernels that a march needs last."""
    descent = _descent()
    system: System = system_of(descent.packed)  # type: ignore[no-untyped-call]
    model, far = system.model, system.far
    _model_kernels.settle_model(model, SWEEPS)
    _far_field.answer(far)
    _far_field.restrict(model.change, far.tile, far.row_length, far.known)
    _far_field.prolong(far.field, np.float32(1), far.tile, far.row_length, model.gap)
    descent.transforms.apply(*descent.block)
    p, u, gap, edge, out = np.ones((5, 4, 4))
    _window_kernels.measures(p, u, np.inf, edge, 1.0)
    _window_kernels.copy_block(p, out, 0, 0)
    _window_kernels.towards_the_sphere(p, u, gap, 0, 0, 1)
    _window_kernels.node_work((p, u), (0, 0), (p, u), False, 1.0, out)
    _window_kernels.extrapolate(u, u, 0, 0, out)
    _solver_kernels.carry_load(descent.packed, 0.0)


def _descent() -> Descent:
    """Return a descent on a contact of a few nodes, with arrays of the types of a march."""
    pressure, gap = np.ones((2, 4, 4))
    candidates = Candidates(np.arange(gap.size), 0.0, 0, 0, *gap.shape)
    limits, goal = Limits(np.inf, float(pressure.sum())), Goal(1e-4, 1.0)
    half_space = HalfSpace(1e-6, 1e11)
    return Descent(half_space, candidates, pressure, gap, None, limits, goal, single=True)
