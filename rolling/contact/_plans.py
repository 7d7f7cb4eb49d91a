"""Plans of FFTW, which compiled code executes by their address.

The library is that of pyfftw, whose own plans do not tell their address. Where the functions of the
library cannot be found, compiled code calls Python, which executes plans of pyfftw.
"""

from __future__ import annotations

import ctypes
import sys
import weakref
from functools import cache as once
from itertools import count
from typing import Any

from acoustics.arrays import Array

# The interface of pyfftw to Dask is not used. It imports all arrays of Dask and pandas, a third of
# the time that a process of this program takes to start, so its import fails here.
_unused = sys.modules.setdefault("dask.array.fft", None)  # type: ignore[arg-type]
import pyfftw  # noqa: E402

if _unused is None:
    del sys.modules["dask.array.fft"]

zeros = pyfftw.zeros_aligned
ESTIMATE, DESTROY_INPUT = 1 << 6, 1 << 0  # flags of FFTW


class Plan:
    """Complex transforms of an array along an axis into another array, which may be the same.

    The source may be destroyed. Plans that are chosen by timing would differ from run to run, and
    the last digits with them.

    Attributes
    ----------
    address : int
        First argument of the function that executes the plan.
    execute : int
        Address of that function.
    """

    def __init__(self, source: Array, target: Array, axis: int, backward: bool = False) -> None:
        functions = _functions(source.dtype.char)
        if functions is None:
            self._plan_of_pyfftw(source, target, axis, backward)
            return
        plan, destroy, self.execute = functions
        along, across = (
            [array.strides[k] // array.itemsize for array in (source, target)]
            for k in (axis, 1 - axis)
        )
        lengths = ctypes.c_int(source.shape[axis])
        self.address = plan(
            *(1, ctypes.byref(lengths), source.shape[1 - axis]),
            *(source.ctypes.data, None, along[0], across[0]),
            *(target.ctypes.data, None, along[1], across[1]),
            *(1 if backward else -1, ESTIMATE | DESTROY_INPUT),
        )
        weakref.finalize(self, destroy, self.address)

    def _plan_of_pyfftw(self, source: Array, target: Array, axis: int, backward: bool) -> None:
        """Plan by pyfftw, with a number in place of the address of the plan."""
        direction = "FFTW_BACKWARD" if backward else "FFTW_FORWARD"
        flags = ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")
        self.address, self.execute = next(_numbers), _EXECUTE_HERE
        _plans[self.address] = pyfftw.FFTW(
            source, target, axes=(axis,), direction=direction, flags=flags
        )
        weakref.finalize(self, _plans.pop, self.address)


_numbers = count()
_plans: dict[int, Any] = {}  # plans of pyfftw by number


@ctypes.PYFUNCTYPE(None, ctypes.c_int64)  # type: ignore[untyped-decorator]
def _execute_here(number: int) -> None:
    """Execute a plan of pyfftw by its number."""
    _plans[number].execute()


_EXECUTE_HERE = ctypes.cast(_execute_here, ctypes.c_void_p).value or 0


@once
def _functions(kind: str) -> tuple[Any, Any, int] | None:
    """Return FFTW's functions to plan and to destroy, and the address of that to execute.

    None where the library does not give them. `kind` is the character of the type of numbers.
    """
    prefix = {"F": "fftwf", "D": "fftw"}[kind]
    try:
        library = ctypes.PyDLL(pyfftw.pyfftw.__file__)
        plan, destroy, execute = (
            getattr(library, f"{prefix}_{name}")
            for name in ("plan_many_dft", "destroy_plan", "execute")
        )
    except (OSError, AttributeError):
        return None
    whole, place = ctypes.c_int, ctypes.c_void_p
    layout = [place, place, whole, whole]
    plan.restype, plan.argtypes = place, [whole, place, whole, *layout, *layout, whole, whole]
    destroy.restype, destroy.argtypes = None, [place]
    return plan, destroy, ctypes.cast(execute, place).value or 0
