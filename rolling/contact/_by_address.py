"""Memory and functions at an address: the one place where compiled code leaves types behind.

FFTW plans and transforms of either precision are called by their address. The kernels that call
them are therefore compiled once, and know no precision but their own.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,attr-defined,call-arg"
from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
from llvmlite import ir
from numba import carray, config, types
from numba.extending import intrinsic, overload

_uncompiled: dict[int, Callable[..., None]] = {}  # functions by number, where nothing is compiled


@intrinsic
def _pointer(_, address, like):
    """Return an address as a pointer to numbers of the type of the array `like`."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    return types.CPointer(like.dtype)(types.int64, like), generate


def array_at(address, shape, like):
    """Return the array of a shape at an address, with the type of numbers of the array `like`."""
    size = int(np.prod(shape)) * like.itemsize
    memory = (ctypes.c_char * size).from_address(int(address)) if size else b""
    return np.frombuffer(memory, like.dtype).reshape(shape)


@overload(array_at, jit_options={"forceinline": True})
def _compiled_array_at(address, shape, like):
    return lambda address, shape, like: carray(_pointer(address, like), shape)


@intrinsic
def _call(_, function, arguments):
    """Call a C function that takes numbers and returns nothing."""
    kinds = types.Tuple([types.unliteral(kind) for kind in arguments])

    def generate(context, builder, signature, values):
        parts = [builder.extract_value(values[1], k) for k in range(len(kinds))]
        kind = ir.FunctionType(ir.VoidType(), [part.type for part in parts])
        builder.call(builder.inttoptr(values[0], kind.as_pointer()), parts)
        return context.get_dummy_value()

    return types.void(types.int64, kinds), generate


def call(function, arguments):
    """Call the function at an address with a tuple of numbers."""
    if function in _uncompiled:
        _uncompiled[function](*arguments)
        return
    kinds = [ctypes.c_double if isinstance(x, float) else ctypes.c_int64 for x in arguments]
    numbers = [kind(x) for kind, x in zip(kinds, arguments, strict=True)]
    ctypes.PYFUNCTYPE(None, *kinds)(int(function))(*numbers)


@overload(call, jit_options={"forceinline": True})
def _compiled_call(function, arguments):
    return lambda function, arguments: _call(function, arguments)


def address_of_uncompiled(function: Callable[..., None]) -> int:
    """Return a number that `call` takes for the address of a Python function."""
    if not config.DISABLE_JIT:
        raise RuntimeError("compiled code cannot call a function of Python")
    _uncompiled[number := len(_uncompiled) + 1] = function
    return number
