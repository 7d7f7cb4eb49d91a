"""Compilation of the longest kernels of the solver beside a march, in processes of their own.

A first march compiles other kernels meanwhile; it finds these in the cache. Each
function compiles what a process can do alone, for arguments like those of a march.
"""

# mypy: disable-error-code="no-untyped-call"
from __future__ import annotations

from typing import Any

import numpy as np
from numba import config, typeof

from rolling.contact import _position_kernels as positions
from rolling.contact import _transform_kernels
from rolling.contact import _window_kernels as windows
from rolling.contact._descent_kernels import descend
from rolling.contact._system import Progress

_LINE = np.empty(0)
_FIELD = np.empty((0, 0))
_SINGLES = np.empty(0, np.float32)
_WHOLE = np.empty(0, np.int64)
_INDICES = np.empty(0, np.uint32)
_STRIPS = np.empty((0, 2), np.uint64)
_BLOCK = 0, 0, 0, 0


def compile_step() -> None:
    """Compile the descent, which takes longer than all other kernels."""
    stencils = 1.0, _FIELD, _SINGLES, 1.0, 1.0, 1.0
    _compile(
        descend,
        (_FIELD,) * 5,
        (_WHOLE, _BLOCK, 1),
        (1.0,) * 5,
        (stencils, (_WHOLE, _SINGLES, 0), _SINGLES),
        (_FIELD, _FIELD, _FIELD, 0, 0),
        (1.0, 1.0),
        tuple(Progress()),
        (_LINE, _SINGLES, _INDICES, _STRIPS, _SINGLES),
    )


def compile_parts() -> None:
    """Compile the transforms, and the kernels that a march needs last."""
    _transform_kernels.nodes_kernel(1, True)
    _compile(_transform_kernels.window_kernel(1), _FIELD, 1.0, _WHOLE, _FIELD)
    fields = (_FIELD,) * 3
    sphere = (1.0,) * 5
    _compile(positions.measure, fields, (1.0, 1.0), sphere, 1.0, 1.0, True, (0, 0))
    pair = _FIELD, _FIELD
    _compile(windows.node_work, pair, (0, 0), pair, False, 1.0, _FIELD)


def _compile(kernel: Any, *arguments: Any) -> None:
    """Compile a kernel for arguments of these types, or load it."""
    if not config.DISABLE_JIT:  # type: ignore[attr-defined]
        kernel.compile(tuple(typeof(argument) for argument in arguments))
