"""Calls by address in compiled code: of planned transforms and of other kernels, and arrays.

A kernel that is called by its address is compiled once, by itself, perhaps in another process. As
part of its callers it would be compiled with each of them.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,attr-defined"
from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array


@intrinsic
def _array_at(_, address, shape, like):
    kind = types.Array(like.dtype, len(shape), "C")

    def generate(context, builder, signature, arguments):
        array = make_array(kind)(context, builder)
        number = context.get_data_type(kind.dtype)
        size = step = cgutils.intp_t(context.get_abi_sizeof(number))
        lengths = cgutils.unpack_tuple(builder, arguments[1])
        strides: list[Any] = []
        for length in reversed(lengths):
            strides.insert(0, step)
            step = builder.mul(step, length)
        data = builder.inttoptr(arguments[0], number.as_pointer())
        populate_array(array, data, lengths, strides, size, meminfo=None)
        return array._getvalue()

    whole = types.UniTuple(types.int64, len(shape))
    return kind(types.int64, whole, like), generate


def array_at(address, shape, like):
    """Return the array of a shape at an address, with the type of numbers of the array `like`."""
    size = int(np.prod(shape)) * like.itemsize
    memory = (ctypes.c_char * size).from_address(int(address)) if size else b""
    return np.frombuffer(memory, like.dtype).reshape(shape)


@intrinsic
def _execute(_, function, plan):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), [arguments[1].type])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1]])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


def execute(function, plan):
    """Execute a plan by the address of the function that does so."""
    ctypes.PYFUNCTYPE(None, ctypes.c_int64)(int(function))(int(plan))


# Python has these functions where nothing is compiled. Numba's own way to give one function two
# forms would compile one more function for each combination of types.
if not config.DISABLE_JIT:
    array_at, execute = _array_at, _execute  # type: ignore[assignment]


def caller(returned: types.Type, *allowed: tuple[types.Type, ...]) -> Any:
    """Return a function (address, arguments) of compiled code that calls a kernel by its address.

    Parameters
    ----------
    returned : types.Type
        Type that the kernel returns.
    allowed : tuples of types
        Types of the arguments of each variant of the kernel.

    Returns
    -------
    function
        Function of the address and a tuple of the arguments.
    """

    @intrinsic
    def compiled(_, address, arguments):
        given = tuple(map(types.unliteral, arguments))
        if given not in allowed:
            raise TypingError(f"arguments of a kernel by address: {given}, allowed: {allowed}")

        def generate(context, builder, signature, values):
            convention = context.call_conv
            kind = convention.get_function_type(returned, given)
            kernel = builder.inttoptr(values[0], kind.as_pointer())
            parts = cgutils.unpack_tuple(builder, values[1], len(given))
            status, answer = convention.call_function(builder, kernel, returned, given, parts)
            with cgutils.if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return answer

        return returned(types.int64, arguments), generate

    def call(address, arguments):
        return _uncompiled[address](*arguments)

    return call if config.DISABLE_JIT else compiled


_uncompiled: dict[int, Any] = {}  # kernels by number, where nothing is compiled


def address_of(kernel: Any, returned: types.Type, arguments: tuple[types.Type, ...]) -> int:
    """Compile a kernel for types of arguments, or load it; return the address of its code."""
    if config.DISABLE_JIT:
        _uncompiled[number := len(_uncompiled) + 1] = kernel
        return number
    kernel.compile(arguments)
    variant = kernel.overloads[arguments]
    if variant.signature.return_type != returned:
        raise TypeError(f"{kernel.__name__} returns {variant.signature.return_type}")
    return int(variant.library.get_pointer_to_function(variant.fndesc.llvm_func_name))
