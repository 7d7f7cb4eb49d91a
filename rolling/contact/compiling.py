"""Compilation by numba: its cache on disk, and notice of its start, which takes a minute."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache as once
from pathlib import Path
from typing import Any

import numba
from filelock import FileLock
from numba.core import event
from numba.core.compiler_lock import global_compiler_lock

from rolling.contact.cached_code import CheckedFiles

_VARIABLE = "NUMBA_CACHE_DIR"


def njit(
    *, cache: bool, fused: bool = False, inner: bool = False, apart: bool = False
) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as `numba.njit` does; go on without a lasting cache where none can be.

    Numba caches beside the sources, or else in the home folder. Where neither can be written, a
    temporary folder serves this process and its workers.

    With `fused` sums are ordered and rounded as the processor does them fastest, the same way in
    every run on it. An `inner` function is called by compiled code only, and would crash in Python.
    Without the wrapper that takes its arguments from Python, the kernels compile in two thirds of
    the time. A function `apart` has none either, and is compiled by one process for its callers.

    Fused and inner functions become part of their callers, because a process that compiles would
    otherwise link another copy of them, with other last digits, than a process that loads the
    callers from the cache.
    """
    options: dict[str, Any] = {"fastmath": {"reassoc", "contract", "nsz"}} if fused else {}
    options |= {"no_cpython_wrapper": inner or apart, "forceinline": inner or fused}

    def compiled(function: Callable[..., Any]) -> Any:
        try:
            return _kept(numba.njit(cache=cache, **options)(function), inner)
        except RuntimeError:  # no folder for the cache; a fault of the code shows below as well
            _use_temporary_cache()
        try:
            return _kept(numba.njit(cache=cache, **options)(function), inner)
        except RuntimeError:  # no temporary folder either
            return numba.njit(**options)(function)

    return compiled


def _kept(kernel: Any, inner: bool) -> Any:
    """Prepare a kernel whose code the cache keeps."""
    _use_checked_files(kernel)
    if not inner:
        _compile_in_one_process(kernel)
    return kernel


def _compile_in_one_process(kernel: Any) -> None:
    """Let one process compile a kernel while all others wait, which then take it from the cache."""
    folder = getattr(getattr(kernel, "_cache", None), "_cache_path", None)
    if folder is None:  # it is not compiled at all
        return
    path = Path(folder) / f"{kernel.__name__}.lock"
    locks = dict[int, FileLock]()  # by process: one that was forked must not use its parent's
    compile_now = kernel.compile

    def compile_alone(signature: Any) -> Any:
        # Threads take the lock of the compiler first, so that none waits for a file that another
        # one of them holds.
        with global_compiler_lock, ExitStack() as stack:
            # A folder that is read-only, or on a disk without locks: each process compiles then.
            with suppress(OSError, NotImplementedError):
                stack.enter_context(locks.setdefault(os.getpid(), FileLock(path)))
            return compile_now(signature)

    kernel.compile = compile_alone


def _use_checked_files(kernel: Any) -> None:
    """Let the cache of a kernel find damaged files, and tie its code to the sources of all kernels.

    Numba looks at the kernel's own file only. The cached code also holds the kernels that it calls,
    which may stand in other files and be newer.
    """
    cache = getattr(kernel, "_cache", None)
    numba_files: Any = getattr(cache, "_cache_file", None)
    if cache is None or numba_files is None:  # it is not compiled, or without a cache
        return
    cache._cache_file = CheckedFiles(  # type: ignore[no-untyped-call]
        cache_path=cache._cache_path,
        filename_base=cache._impl.filename_base,
        source_stamp=(numba_files._source_stamp, _digest_of_sources()),
    )


@once
def _digest_of_sources() -> str:
    """Return the digest of the modules beside this one and of the kernels of the motion."""
    digest = hashlib.sha256()
    here = Path(__file__).parent
    for path in sorted([*here.glob("*.py"), *here.parent.glob("dynamics/_*.py")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()


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
