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
from numba import config, types
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array

_uncompiled: dict[int, Callable[..., None]] = {}  # functions by number, where nothing is compiled


def array_at(address, shape, like):
    """Return the array of a shape at an address, with the type of numbers of the array `like`."""
    size = int(np.prod(shape)) * like.itemsize
    memory = (ctypes.c_char * size).from_address(int(address)) if size else b""
    return np.frombuffer(memory, like.dtype).reshape(shape)


# Numba has `carray` for this, which it compiles anew for each shape and type of numbers.
@type_callable(array_at)
def _type_of_array(_):
    return lambda address, shape, like: types.Array(like.dtype, len(shape), "C")


@lower_builtin(array_at, types.Integer, types.BaseTuple, types.Array)
def _make_array(context, builder, signature, arguments):
    """Make the array of a shape at an address, whose memory others own."""
    address, shape = arguments[:2]
    kind = signature.return_type
    lengths = types.UniTuple(types.intp, kind.ndim)
    shape = cgutils.unpack_tuple(builder, context.cast(builder, shape, signature.args[1], lengths))
    itemsize = context.get_constant(
        types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype))
    )
    strides = [itemsize]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], length))
    array = make_array(kind)(context, builder)
    populate_array(
        array,
        data=builder.inttoptr(address, context.get_data_type(kind.dtype).as_pointer()),
        shape=shape,
        strides=strides,
        itemsize=itemsize,
        meminfo=None,
    )
    return array._getvalue()


def call(function, arguments):
    """Call the function at an address with a tuple of numbers."""
    if function in _uncompiled:
        _uncompiled[function](*arguments)
        return
    kinds = [ctypes.c_double if isinstance(x, float) else ctypes.c_int64 for x in arguments]
    numbers = [kind(x) for kind, x in zip(kinds, arguments, strict=True)]
    ctypes.PYFUNCTYPE(None, *kinds)(int(function))(*numbers)


@type_callable(call)
def _type_of_call(_):
    return lambda function, arguments: types.void


@lower_builtin(call, types.Integer, types.BaseTuple)
def _make_call(context, builder, signature, arguments):
    """Call the function at an address."""
    function, numbers = arguments
    parts = cgutils.unpack_tuple(builder, numbers)
    kind = ir.FunctionType(ir.VoidType(), [part.type for part in parts])
    builder.call(builder.inttoptr(function, kind.as_pointer()), parts)
    return context.get_dummy_value()


def address_of_uncompiled(function: Callable[..., None]) -> int:
    """Return a number that `call` takes for the address of a Python function."""
    if not config.DISABLE_JIT:
        raise RuntimeError("compiled code cannot call a function of Python")
    _uncompiled[number := len(_uncompiled) + 1] = function
    return number
