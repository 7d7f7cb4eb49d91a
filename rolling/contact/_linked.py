"""Kernels that are compiled once and called by name, and named tuples that they share by reference.

Numba makes the code of a kernel part of each kernel that calls it, and optimizes it there again. A
*linked* kernel is compiled alone, and its callers know no more than its symbol, one per signature.
Arguments of numbers and arrays go by value. A named tuple of many arrays goes by `reference`: as a
single pointer instead of hundreds of numbers, which took half of the time of compilation.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call,misc,attr-defined,override"
from __future__ import annotations

from collections.abc import Callable
from inspect import signature as parameters_of
from typing import Any

from llvmlite import binding, ir
from numba import config, types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    type_callable,
)

from rolling.contact.compiling import njit


class TupleReference(types.Type):
    """Type of a reference to a named tuple, whose attributes are those of the named tuple.

    An attribute that is a named tuple with arrays is a reference, too.
    """

    def __init__(self, of):
        self.of = of
        super().__init__(name=f"TupleReference({of})")

    def attribute(self, name):
        """Return the type of an attribute, None where there is none."""
        if name not in self.of.fields:
            return None
        kind = self.of.types[self.of.fields.index(name)]
        if isinstance(kind, types.BaseNamedTuple) and any(
            isinstance(part, types.Array | types.BaseNamedTuple) for part in kind.types
        ):
            return TupleReference(kind)
        return kind


@register_model(TupleReference)
class _PointerModel(models.PrimitiveModel):
    """A reference is a pointer."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, cgutils.voidptr_t)


@infer_getattr
class _Attributes(AttributeTemplate):
    """Types of the attributes of a reference."""

    key = TupleReference

    def generic_resolve(self, reference, name):
        """Return the type of an attribute."""
        return reference.attribute(name)


@lower_getattr_generic(TupleReference)
def _attribute(context, builder, reference, pointer, name):
    """Read an attribute of a reference."""
    whole = context.get_value_type(reference.of).as_pointer()
    index = reference.of.fields.index(name)
    member = cgutils.gep_inbounds(builder, builder.bitcast(pointer, whole), 0, index)
    kind = reference.attribute(name)
    if isinstance(kind, TupleReference):
        return builder.bitcast(member, cgutils.voidptr_t)
    return impl_ret_borrowed(context, builder, kind, builder.load(member))


def reference(value):
    """Return a reference to a named tuple, for linked kernels; Python takes the tuple itself.

    It holds until the function that called `reference` returns, and so must the memory of arrays.
    That function must not be part of another one.
    """
    return value


@type_callable(reference)
def _type_of_reference(_):
    return lambda value: TupleReference(value) if isinstance(value, types.BaseNamedTuple) else None


@lower_builtin(reference, types.BaseNamedTuple)
def _make_reference(_, builder, __, arguments):
    """Keep a value in the frame of the function that is compiled; return the reference to it."""
    place = cgutils.alloca_once_value(builder, arguments[0])
    return builder.bitcast(place, cgutils.voidptr_t)


class LinkedKernel:
    """A kernel that others call by its symbol.

    Parameters
    ----------
    function : function
        What is compiled.
    signatures : tuple of numba signatures
        Types of the arguments and of the answer of each compiled call. Those of several precisions
        differ in the types of their arrays.
    calls : tuple of LinkedKernel
        The linked kernels that it calls itself, or by functions that are part of it.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        signatures: tuple[Any, ...],
        calls: tuple[LinkedKernel, ...],
    ) -> None:
        self.kernel = njit(cache=True, calls=calls)(function)
        self.signatures = signatures
        self.name = f"{function.__module__}.{function.__qualname__}"
        self.py_func = function
        self._linked = False

    def __call__(self, *arguments: Any) -> Any:
        """Call the kernel from Python, with arguments of any types."""
        return self.kernel(*arguments)

    def link(self) -> None:
        """Compile the kernel, or load it, and make its symbol known."""
        if self._linked:
            return
        for signature in self.signatures:
            self.kernel.compile(signature.args)
            compiled = self.kernel.overloads[signature.args]
            answer = compiled.signature.return_type
            if answer != signature.return_type:
                raise TypeError(f"{self.name} returns {answer}, not {signature.return_type}")
            name = compiled.fndesc.llvm_cfunc_wrapper_name
            pointer = compiled.library.get_pointer_to_function(name)
            binding.add_symbol(self.symbol(signature), pointer)
        self._linked = True

    def symbol(self, signature: Any) -> str:
        """Return the symbol of the code for a signature."""
        number = [known.args for known in self.signatures].index(signature.args)
        return f"{self.name}.{number}"

    def signature_for(self, arguments: Any) -> Any:
        """Return the signature for arguments of some types, None where their arrays fit none."""
        for signature in self.signatures:
            pairs = zip(arguments, signature.args, strict=True)
            if all(given == kind for given, kind in pairs if isinstance(kind, types.Array)):
                return signature
        return None


def linked(
    *signatures: Any, calls: tuple[LinkedKernel, ...] = ()
) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as a linked kernel for some signatures (see LinkedKernel)."""

    def made(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT:
            return function
        kernel = LinkedKernel(function, signatures, calls)
        parameters = parameters_of(function)

        @type_callable(kernel)
        def resolve(_):
            def typed(*arguments):
                signature = kernel.signature_for(arguments)
                return signature and signature.replace(pysig=parameters)

            typed.pysig = parameters
            return typed

        @lower_builtin(kernel, types.VarArg(types.Any))
        def generate(context, builder, called, arguments):
            answer = context.get_value_type(called.return_type)
            kinds = [context.get_value_type(kind) for kind in called.args]
            kind = ir.FunctionType(answer, kinds)
            symbol = kernel.symbol(called)
            callee = cgutils.get_or_insert_function(builder.module, kind, symbol)
            return builder.call(callee, arguments)

        return kernel

    return made
