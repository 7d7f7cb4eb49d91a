"""Plans of FFTW, which compiled code executes by their address.

The library is the one that pyfftw brings; its own plans do not tell their address. It is loaded
without the package, whose interface to Dask would import all of that and pandas, a third of the
time that a process of this program takes to start. Where the functions of the library cannot be
found, compiled code calls Python, which executes plans of pyfftw.
"""

from __future__ import annotations

import ctypes
import weakref
from functools import cache as once
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array

ALIGNMENT = 64  # bytes; FFTW then finds the same plans wherever an array lies
# flags of FFTW
ESTIMATE = 1 << 6
DESTROY_INPUT = 1 << 0


def zeros(shape: tuple[int, ...], dtype: str) -> Array:
    """Return an array of zeros that begins at a multiple of ALIGNMENT."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    memory = np.zeros(size + ALIGNMENT, np.uint8)
    first = -memory.ctypes.data % ALIGNMENT
    aligned: Array = memory[first : first + size].view(dtype).reshape(shape)
    return aligned


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
        source_along, source_across = _strides(source, axis)
        target_along, target_across = _strides(target, axis)
        self.address = plan(
            1,
            ctypes.byref(ctypes.c_int(source.shape[axis])),
            source.shape[1 - axis],
            source.ctypes.data,
            None,
            source_along,
            source_across,
            target.ctypes.data,
            None,
            target_along,
            target_across,
            1 if backward else -1,
            ESTIMATE | DESTROY_INPUT,
        )
        weakref.finalize(self, destroy, self.address)

    def _plan_of_pyfftw(self, source: Array, target: Array, axis: int, backward: bool) -> None:
        """Plan by pyfftw, with a number in place of the address of the plan."""
        import pyfftw

        direction = "FFTW_BACKWARD" if backward else "FFTW_FORWARD"
        flags = ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")
        self.address = next(_numbers)
        self.execute = _EXECUTE_HERE
        _plans[self.address] = pyfftw.FFTW(
            source, target, axes=(axis,), direction=direction, flags=flags
        )
        weakref.finalize(self, _plans.pop, self.address)


def _strides(array: Array, axis: int) -> tuple[int, int]:
    """Return the numbers from one entry to the next along an axis, and along the other axis."""
    along = array.strides[axis]
    across = array.strides[1 - axis]
    return along // array.itemsize, across // array.itemsize


_numbers = count(1)  # 0 stands for no plan
_plans: dict[int, Any] = {}  # plans of pyfftw by number


@ctypes.PYFUNCTYPE(None, ctypes.c_int64)  # type: ignore[untyped-decorator]
def _execute_here(number: int) -> None:
    """Execute a plan of pyfftw by its number."""
    _plans[number].execute()


_EXECUTE_HERE = ctypes.cast(_execute_here, ctypes.c_void_p).value or 0


@once
def _library() -> ctypes.PyDLL:
    """Return the module of pyfftw that holds FFTW; raise OSError where it is not found."""
    spec = find_spec("pyfftw")
    folders = (spec.submodule_search_locations if spec else None) or []
    for folder in folders:
        for suffix in EXTENSION_SUFFIXES:
            path = Path(folder) / f"pyfftw{suffix}"
            if path.exists():
                return ctypes.PyDLL(str(path))
    raise OSError("the library of pyfftw is not found")


@once
def _functions(kind: str) -> tuple[Any, Any, int] | None:
    """Return FFTW's functions to plan and to destroy, and the address of that to execute.

    None where the library does not give them. `kind` is the character of the type of numbers.
    """
    prefix = {"F": "fftwf", "D": "fftw"}[kind]
    try:
        library = _library()
        plan = getattr(library, f"{prefix}_plan_many_dft")
        destroy = getattr(library, f"{prefix}_destroy_plan")
        execute = getattr(library, f"{prefix}_execute")
    except (OSError, AttributeError):
        return None
    whole = ctypes.c_int
    place = ctypes.c_void_p
    layout = [place, place, whole, whole]
    plan.restype = place
    plan.argtypes = [whole, place, whole, *layout, *layout, whole, whole]
    destroy.restype = None
    destroy.argtypes = [place]
    return plan, destroy, ctypes.cast(execute, place).value or 0
