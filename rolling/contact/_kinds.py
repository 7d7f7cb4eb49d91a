"""Numba's types of the arrays and named tuples that linked kernels take and return."""

# mypy: disable-error-code="no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import typeof, types

from rolling.contact import _system as parts
from rolling.contact._linked import TupleReference

NUMBER = types.float64
SINGLE = types.float32
WHOLE = types.int64
FLAG = types.boolean
NOTHING = types.none

_line = np.empty(0)
_field = np.empty((0, 0))
_singles = np.empty(0, np.float32)
_grid = np.empty((0, 0), np.float32)
_indices = np.empty(0, np.uint32)
_strips = np.empty((0, 2), np.uint64)

_system = parts.System(
    parts.Nodes(_line, _line, _line, _line),
    parts.Transform(_line, _indices, 1.0),
    parts.Stencil(_field, _line, _indices, 1, 1.0),
    parts.Work(_line, _line, _line, _line, _indices),
    parts.Limits(1.0, 1.0),
    parts.Edges(_line, _line, _line, 1.0, 1.0),
    parts.Model(
        _singles, _grid, _grid, _grid, _grid, _grid, _grid, _grid, _indices, _strips, 1.0, 1.0
    ),
    parts.FarField(1, 1, 1.0, 1.0, *(_singles,) * 8),
    parts.Influence(_singles, _indices, _singles),
)

LINE = typeof(_line)
FIELD = typeof(_field)
SINGLES = typeof(_singles)
GRID = typeof(_grid)
INDICES = typeof(_indices)
STRIPS = typeof(_strips)
LIMITS = typeof(_system.limits)
SETS = typeof(parts.Sets(_indices, 1, 1))
DIRECTION = typeof(parts.Direction(1.0, 1.0, 1.0, 1.0))
RULES = typeof(parts.Rules(1.0, 1.0, 1.0, 1, True, True))
STEP = typeof(parts.Step(1.0, 1.0, 1, 1, 1, 1.0))
SOLUTIONS = typeof(parts.Solutions(_field, _field, _field, _field, 1, 1, (1, 1, 1, 1)))
SYSTEM = TupleReference(typeof(_system))
NODES = TupleReference(typeof(_system.nodes))
MODEL = TupleReference(typeof(_system.model))
FAR_FIELD = TupleReference(typeof(_system.far))
