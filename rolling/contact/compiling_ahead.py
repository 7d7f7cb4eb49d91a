"""Compilation of the longest kernels of the solver beside a march, in processes of their own.

A first march compiles half a minute of other kernels meanwhile; it finds these in the cache. Each
function compiles what a process can do alone.
"""

from __future__ import annotations

from numba import types

from rolling.contact import _descent_kernels, _far_field, _model_kernels, _transform_kernels
from rolling.contact import _position_kernels as positions
from rolling.contact import _window_kernels as windows
from rolling.contact._system import FarField, Model, numba_type


def compile_step() -> None:
    """Compile the step of a descent, which takes longer than any other kernel."""
    _descent_kernels.step_address(single=True)


def compile_parts() -> None:
    """Compile parts of the step, and the kernels that a march needs last."""
    number, whole, line = types.float64, types.int64, types.float32[::1]
    grid, field = types.float32[:, ::1], types.float64[:, ::1]
    model, far = (numba_type(kind, types.float32) for kind in (Model, FarField))
    _model_kernels.settle_model.compile((model, whole))
    _far_field.answer.compile((far,))
    _far_field.restrict.compile((grid, whole, whole, line))
    _far_field.prolong.compile((line, types.float32, whole, whole, grid))
    for single in (False, True):
        _transform_kernels.apply_address(1, single)
    positions.converge_address(single=True)
    both, corner = (types.UniTuple(kind, 2) for kind in (field, whole))  # type: ignore[no-untyped-call]
    windows.node_work.compile((both, corner, both, types.boolean, number, field))
