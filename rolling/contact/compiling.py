"""Compilation by numba: its cache on disk, and notice of its start, which takes a minute."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import cache as once
from typing import Any

import numba
from filelock import FileLock
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import register_jitable

from rolling.contact._by_address import address_of_uncompiled
from rolling.contact.cached_code import KeptFiles, warn_not_kept
from rolling.contact.processor_time import counted_as_compilation

_VARIABLE = "NUMBA_CACHE_DIR"
# Sums are ordered and rounded as the processor does them fastest, the same way in every run on it.
_FUSED = {"reassoc", "contract", "nsz"}
_callbacks: list[Any] = []  # whose addresses are in use


def njit(
    *, cache: bool, fused: bool = False, calls: Sequence[Any] = ()
) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as `numba.njit` does; go on without a lasting cache where none can be.

    Numba caches beside the sources, or else in the home folder. Where neither can be written, a
    temporary folder serves this process and its workers. One process compiles a kernel while all
    others wait, and files of the cache are checked before they are loaded (see `cached_code`).
    `calls` are the linked kernels that it calls (see `_linked`).
    """
    options: dict[str, Any] = {"fastmath": _FUSED, "forceinline": True} if fused else {}

    def compiled(function: Callable[..., Any]) -> Any:
        kernel = _with_cache(lambda **how: numba.njit(**how, **options)(function), cache)
        if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
            return kernel
        if cache:
            _compile_in_one_process(kernel, function, options)
        _link_first(kernel, calls)
        _count_compilation(kernel)
        return kernel

    return compiled


def inlined(*, fused: bool = False) -> Callable[[Callable[..., Any]], Any]:
    """Make a function part of the kernels that call it; Python calls it as it is.

    With `fused` its sums are ordered and rounded as the processor does them fastest. Such a
    function must be part of its callers, because a process that compiles would otherwise link
    another copy of it, with other last digits, than a process that loads the callers from the
    cache.
    """
    # Python takes nothing from its compiled code, so that this needs no wrappers.
    wrappers = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    options = {"forceinline": True, "fastmath": _FUSED if fused else False, **wrappers}
    mark: Callable[[Callable[..., Any]], Any] = register_jitable(**options)
    return mark


def address_of(function: Callable[..., None], signature: Any, calls: Sequence[Any] = ()) -> int:
    """Compile a function of numbers that returns nothing; return its address for `call`.

    `calls` are the linked kernels that it calls.
    """
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return address_of_uncompiled(function)
    example = _with_cache(lambda **how: numba.njit(**how)(function), cache=True)
    files = KeptFiles(function, example.stats.cache_path) if example.stats.cache_path else None

    def compiled(cache: bool) -> Any:
        return numba.cfunc(signature, cache=cache)(function)

    with counted_as_compilation(), _without_collection():
        for called in calls:
            called.link()
        if files is None:
            callback = compiled(cache=False)
        else:
            with global_compiler_lock, _locked(files):
                try:
                    files.remove_what_differs()
                    callback = compiled(cache=True)
                    files.record()
                except OSError as error:
                    warn_not_kept(files.folder, error.strerror or str(error))
                    callback = compiled(cache=False)
    _callbacks.append(callback)
    return int(callback.address)


def _with_cache(make: Callable[..., Any], cache: bool) -> Any:
    """Make a kernel with a cache, in a temporary folder if need be, or without one."""
    with suppress(RuntimeError):  # no folder for the cache; a fault of the code shows below as well
        return make(cache=cache)
    _use_temporary_cache()
    with suppress(RuntimeError):  # no temporary folder either
        return make(cache=cache)
    return make(cache=False)


_locks: dict[tuple[str, int], FileLock] = {}  # a process that was forked must not use its parent's


@contextmanager
def _locked(files: KeptFiles) -> Iterator[None]:
    """Hold the lock of the files of a kernel, where there is one.

    A folder that is read-only, or on a disk without locks, has none: each process compiles then.
    """
    with ExitStack() as stack:
        lock = _locks.setdefault((str(files.lock), os.getpid()), FileLock(files.lock))
        with suppress(OSError, NotImplementedError):
            stack.enter_context(lock)
        yield


def is_kept(kernel: Any) -> bool:
    """Tell whether the compiled code of a kernel is kept, so that this machine need not compile."""
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return True
    folder = kernel.stats.cache_path
    return bool(folder) and KeptFiles(kernel.py_func, folder).are_whole


def _link_first(kernel: Any, calls: Sequence[Any]) -> None:
    """Link the kernels that a kernel calls before it is compiled or loaded, which needs them."""
    compile_now = kernel.compile

    def compile_linked(signature: Any) -> Any:
        for called in calls:
            called.link()
        return compile_now(signature)

    kernel.compile = compile_linked


def _count_compilation(kernel: Any) -> None:
    """Count the processor time in which a kernel is compiled or loaded as compilation."""
    compile_now = kernel.compile

    def compile_counted(signature: Any) -> Any:
        with counted_as_compilation(), _without_collection():
            return compile_now(signature)

    kernel.compile = compile_counted


@contextmanager
def _without_collection() -> Iterator[None]:
    """Let Python collect no garbage while numba compiles a kernel.

    Numba makes millions of objects that live until the kernel is done. Python would look through
    them again and again, for a tenth of the time of compilation.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _compile_in_one_process(
    kernel: Any, function: Callable[..., Any], options: dict[str, Any]
) -> None:
    """Let one process compile a kernel while all others wait, which then take it from the cache."""
    if not kernel.stats.cache_path:
        return
    files = KeptFiles(function, kernel.stats.cache_path)
    compile_now = kernel.compile

    def compile_alone(signature: Any) -> Any:
        # Threads take the lock of the compiler first, so that none waits for a file that another
        # one of them holds.
        with global_compiler_lock, _locked(files):
            try:
                files.remove_what_differs()
                entry = compile_now(signature)
                files.record()
            except OSError as error:
                warn_not_kept(files.folder, error.strerror or str(error))
                entry = compile_uncached(signature)
        return entry

    def compile_uncached(signature: Any) -> Any:
        if signature not in kernel.overloads:
            uncached = numba.njit(**options)(function)
            uncached.compile(signature)
            kernel.add_overload(uncached.overloads[signature])
        return compile_now(signature)

    kernel.compile = compile_alone


@once
def _use_temporary_cache() -> None:
    """Let numba keep compiled code in a new temporary folder until this process ends, and say so.

    The folder is this user's own: code in a folder that others can write must never be loaded.
    """
    print(
        "warning: compiled code cannot be kept, because neither the installed package nor the home"
        f" folder is writable: every start compiles anew; set {_VARIABLE} to a folder of your own"
        " to keep it",
        file=sys.stderr,
    )
    try:
        folder = tempfile.mkdtemp(prefix="rolling-numba-")
    except OSError:
        return
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    os.environ[_VARIABLE] = folder  # for the workers
    numba.config.CACHE_DIR = folder  # type: ignore[attr-defined]


_KIND = "numba:compile"


class _Listener(event.Listener):
    """A listener that calls a function when a kernel begins to be compiled."""

    def __init__(self, tell: Callable[[], object]) -> None:
        self._tell = tell

    def on_start(self, event: Any) -> None:
        """Call the function."""
        self._tell()

    def on_end(self, event: Any) -> None:
        """Do nothing."""


def tell_always(tell: Callable[[], object]) -> None:
    """Call a function whenever this process begins to compile a kernel."""
    event.register(_KIND, _Listener(tell))  # type: ignore[no-untyped-call]


@contextmanager
def reporting(tell: Callable[[], object]) -> Iterator[None]:
    """Call a function in this context when a kernel begins to be compiled."""
    listener = _Listener(tell)
    event.register(_KIND, listener)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister(_KIND, listener)  # type: ignore[no-untyped-call]
