"""Calls by address in compiled code: of planned transforms and of other kernels, and arrays.

A kernel that is called by its address is compiled once, by itself, perhaps in another process. As
part of its callers it would be compiled with each of them.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,call-arg,attr-defined"
from __future__ import annotations

import ctypes
from typing import Any

from llvmlite import ir
from numba import carray, config, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic, overload

from rolling.contact.compiling import njit


@intrinsic
def _compiled_pointer(_, address):
    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), generate


@intrinsic
def _compiled_execute(_, function, plan):
    def generate(context, builder, signature, arguments):
        kind = ir.FunctionType(ir.VoidType(), [arguments[1].type])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1]])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64), generate


def pointer(address: int) -> ctypes.c_void_p:
    """Return the pointer to an address."""
    return ctypes.c_void_p(int(address))


def execute(function: int, plan: int) -> None:
    """Execute a plan by the address of the function that does so."""
    ctypes.PYFUNCTYPE(None, ctypes.c_int64)(int(function))(int(plan))


@overload(pointer)
def _pointer(address):
    return lambda address: _compiled_pointer(address)


@overload(execute)
def _execute(function, plan):
    return lambda function, plan: _compiled_execute(function, plan)


@njit(cache=True, inner=True)
def array_at(address, shape, like):
    """Return the array of a shape at an address, with the type of numbers of the array `like`."""
    return carray(pointer(address), shape, like.dtype)


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

    overload(call)(
        lambda address, arguments: lambda address, arguments: compiled(address, arguments)
    )
    return call


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
