"""Processes share the compilation: each kernel is compiled once, and the longest ones ahead."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rolling.contact import compiling
from rolling.contact._far_field import coarse_grid
from rolling.contact.compiling import njit
from rolling.run import pools

SLOW_KERNEL = """
import numpy as np
from rolling.contact.compiling import njit

@njit(cache=True)
def slow(x):
    total = 0.0
    for a in np.linspace(0.0, 1.0, 5).reshape(-1)[::2]:
        total += np.sum(np.sort(np.array([a, x, -x])))
    return total
"""
QUICK_KERNEL = """
from rolling.contact.compiling import njit

@njit(cache=True)
def slow(x):
    return x - 0.5
"""
CALL = """
from rolling.contact import compiling
compiled = []
compiling.tell_always(lambda: compiled.append(1))
import slow_kernel
print(slow_kernel.slow(2.0), len(compiled))
"""
# Damages both files of a kernel in many ways, and tells after each damage: the value computed anew,
# how often that compiled, how often the start after it did, and what the kernel printed of it.
DAMAGE = """
import importlib
import shutil
import sys
from pathlib import Path

from rolling.contact import compiling

compiled = []
compiling.tell_always(lambda: compiled.append(1))


def start():
    compiled.clear()
    sys.modules.pop("slow_kernel", None)
    module = importlib.import_module("slow_kernel")
    return module.slow(2.0), len(compiled)


def flipped(content, place):
    at = int(place * (len(content) - 1))
    return content[:at] + bytes([content[at] ^ 0x10]) + content[at + 1 :]


def folder_in_place(path):
    path.unlink()
    path.mkdir()


def dangling_link(path):
    path.unlink()
    path.symlink_to("nowhere")


damages = {
    "emptied": lambda path: path.write_bytes(b""),
    "zeroed": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "longer": lambda path: path.write_bytes(path.read_bytes() + b"x"),
    "other bytes": lambda path: path.write_bytes(bytes(range(256)) * 40),
    "link": dangling_link,
    "folder": folder_in_place,
}
for share in (0.0, 0.01, 0.3, 0.6, 0.9, 1.0):
    damages[f"flipped at {share}"] = lambda path, share=share: path.write_bytes(
        flipped(path.read_bytes(), share)
    )
for length in (1, 10, 31, 33, 100, -32, -1):
    damages[f"cut to {length}"] = lambda path, length=length: path.write_bytes(
        path.read_bytes()[:length]
    )
start()
(cache,) = {path.parent for path in Path(sys.argv[1]).rglob("*.nbi")}
whole = cache.with_name("whole")
shutil.copytree(cache, whole)
for ending in ("nbi", "nbc"):
    for name, damage in damages.items():
        shutil.rmtree(cache)
        shutil.copytree(whole, cache)
        (path,) = cache.glob(f"slow_kernel.slow-*.{ending}")
        damage(path)
        print(ending, name.replace(" ", "_"), *start(), start()[1])
"""
STALE = """
import importlib
import sys
from pathlib import Path

import os

from rolling.contact import compiling


def start():
    sys.modules.pop("slow_kernel", None)
    return importlib.import_module("slow_kernel").slow(2.0)


def killed(source, target):
    if str(target).endswith(sys.argv[3]):
        raise KeyboardInterrupt
    replace(source, target)


source = Path(sys.argv[2])
print(start())
source.write_text(source.read_text().replace("x - 0.5", "x + 9.5"))
replace, os.replace = os.replace, killed
try:
    start()
except KeyboardInterrupt:
    pass
os.replace = replace
print(start())
"""
SUMS = """
import hashlib
import numpy as np
from rolling.contact import _window_kernels

random, digest = np.random.default_rng(1), hashlib.sha256()
for _ in range(3000):
    p_old, u_old, p_new, u_new, work = random.standard_normal((5, 59, 63))
    sums = _window_kernels.node_work((p_old, u_old), (0, 0), (p_new, u_new), False, 4e-12, work)
    digest.update(np.array(sums).tobytes())
print(digest.hexdigest())
"""
# A kernel that calls linked ones, with references to a named tuple and to another one in it.
LINKED = """
from typing import NamedTuple

import numpy as np
from numba import typeof, types

from rolling.contact import compiling
from rolling.contact._linked import TupleReference, linked, reference
from rolling.contact.compiling import njit


class Line(NamedTuple):
    values: np.ndarray
    factor: float


class Bounds(NamedTuple):
    low: float
    high: float


class Whole(NamedTuple):
    line: Line
    bounds: Bounds


LINE = Line(np.empty(0), 1.0)
LINES = TupleReference(typeof(LINE))
WHOLE = TupleReference(typeof(Whole(LINE, Bounds(1.0, 1.0))))
PAIR = types.UniTuple(types.float64, 2)


@linked(PAIR(LINES, types.int64))
def scale(line, times):
    total = 0.0
    for k in range(line.values.size):
        line.values[k] *= line.factor * times
        total += line.values[k]
    return total, 0.0


@linked(types.float64(WHOLE), calls=(scale,))
def doubled_and_bounded(whole):
    total, _ = scale(whole.line, 2)
    return min(max(total, whole.bounds.low), whole.bounds.high)


DOUBLES = types.Array(types.float64, 1, "C")
SINGLES = types.Array(types.float32, 1, "C")


@linked(types.float64(DOUBLES), types.float32(SINGLES))
def last_of(values):
    return values[values.size - 1]


@njit(cache=True, calls=(scale, doubled_and_bounded, last_of))
def root(values, high):
    whole = reference(Whole(Line(values, 10.0), Bounds(0.0, high)))
    first = doubled_and_bounded(whole)
    singles = np.empty(1, np.float32)
    singles[0] = 0.1
    return first, scale(whole.line, np.int64(3))[0], last_of(singles), last_of(values)


@linked(types.int64(LINES))
def factor_of(line):
    return line.factor


def main():
    compiled = []
    compiling.tell_always(lambda: compiled.append(1))
    values = np.arange(4.0)
    print(*root(values, 100.0), *values, len(compiled) > 0)
"""
# The code of the linked kernels stands in no kernel that calls them.
COPIES = """
import linked_kernels

PARTS = "scale", "doubled", "last_of"

linked_kernels.root.compile((linked_kernels.types.float64[::1], linked_kernels.types.float64))
(library,) = [found.library for found in linked_kernels.root.overloads.values()]
defined = [function.name for function in library.get_defined_functions()]
print(len(defined) > 0, [name for name in defined if any(part in name for part in PARTS)])

try:
    linked_kernels.factor_of.link()
except TypeError as error:
    print(error)
"""
SAME_TYPES = """
import numpy as np
import rolling
from rolling.contact import _descent_kernels, _position_kernels
from rolling.contact import _transform_kernels, _window_kernels
from rolling.contact import compiling_ahead
from rolling.contact.recovery import step_energy
from rolling.contact.subcells import half_space_of

compiling_ahead.compile_step()
compiling_ahead.compile_parts()
heights = 2e-7 * np.random.default_rng(1).standard_normal((96, 96))
locked = heights.T.copy().T
locked.flags.writeable = False
for blended, subcells in ((False, 1), (True, 1), (True, 3)):
    contact = rolling.RollingContact(
        heights=locked if blended else heights, spacing=2e-6, radius=2e-3, tolerance=1e-4,
        contact_modulus=115_000_000_000, hardness=2_100_000_000, load=0.5, step=2e-6 * subcells,
        start=0, blended=blended, subcells=subcells,
    )
    half_space = half_space_of(2e-6, 115e9, subcells)
    states = list(rolling.march(contact, 0, 4, half_space))
    step_energy(*states[-2:], half_space)
names = {
    _descent_kernels: "descend",
    _window_kernels: "node_work overlap", _position_kernels: "judge measure",
}
kernels = [getattr(module, name) for module in names for name in names[module].split()]
kernels.append(_transform_kernels.window_kernel(1))
print(*{len(kernel.signatures) for kernel in kernels}, len(kernels))
"""


def _run(code: str, **environment: str) -> subprocess.Popen[str]:
    """Start Python with a program."""
    pipe = subprocess.PIPE
    return subprocess.Popen(
        [sys.executable, "-c", code], env=os.environ | environment, stdout=pipe, text=True
    )


@pytest.mark.slow
def test_one_of_several_processes_compiles_a_kernel(tmp_path: Path) -> None:
    (tmp_path / "slow_kernel.py").write_text(SLOW_KERNEL, encoding="utf-8")
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    processes = [_run(CALL, **cache) for _ in range(3)]
    answers = [process.communicate()[0].split() for process in processes]
    assert {value for value, _ in answers} == {"1.5"}
    assert sorted(int(count) > 0 for _, count in answers) == [False, False, True]


def test_a_lock_that_cannot_be_had_does_not_stop_a_kernel(tmp_path: Path) -> None:
    """A folder that is read-only refuses the file of the lock."""
    (tmp_path / "slow_kernel.py").write_text(SLOW_KERNEL, encoding="utf-8")
    refuse = (
        "from rolling.contact import compiling\n"
        "def refused(*arguments): raise PermissionError\n"
        "compiling.FileLock.acquire = refused\n"
    )
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    assert _run(refuse + CALL, **cache).communicate()[0].split()[0] == "1.5"


def test_linked_kernels_are_compiled_once_and_called(tmp_path: Path) -> None:
    """A process that loads them finds their symbols, as the one that compiled them did."""
    (tmp_path / "linked_kernels.py").write_text(LINKED, encoding="utf-8")
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)}
    run = "import linked_kernels; linked_kernels.main()"
    compiling, loading = (_run(run, **cache).communicate()[0].split() for _ in range(2))
    single = repr(float(np.float32(0.1)))
    numbers = ["100.0", "3600.0", single, "1800.0", "0.0", "600.0", "1200.0", "1800.0"]
    assert compiling == [*numbers, "True"]
    assert loading == [*numbers, "False"]
    cache["NUMBA_CACHE_DIR"] = str(tmp_path / "anew")  # code that is loaded cannot be looked into
    copies, refusal = _run(COPIES, **cache).communicate()[0].splitlines()
    assert copies == "True []"
    assert refusal.endswith("returns float64, not int64")


@pytest.mark.slow
def test_damaged_files_of_compiled_code_are_compiled_anew(tmp_path: Path) -> None:
    """Each damage costs one compilation, whose files serve the next start.

    A folder in place of a file cannot be replaced, which costs a sentence and each start that time.
    """
    (tmp_path / "slow_kernel.py").write_text(QUICK_KERNEL, encoding="utf-8")
    cache = tmp_path / "cache"
    done = subprocess.run(
        [sys.executable, "-B", "-c", DAMAGE, str(cache)],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    answers = [line.split() for line in done.stdout.splitlines()]
    assert len(answers) == 2 * 19
    for ending, name, value, compiled, compiled_again in answers:
        assert value == "1.5" and int(compiled) > 0, (ending, name)
        assert (int(compiled_again) > 0) == (name == "folder"), (ending, name)
    assert done.stderr.count("cannot be kept") == 1 and str(cache) in done.stderr


@pytest.mark.parametrize("unwritten", [".nbc", ".sha256"])
def test_code_of_older_sources_is_never_taken_for_new(tmp_path: Path, unwritten: str) -> None:
    """A process may be killed after it wrote the index, and before it wrote code or record."""
    source = tmp_path / "slow_kernel.py"
    source.write_text(QUICK_KERNEL, encoding="utf-8")
    cache = tmp_path / "cache"
    done = subprocess.run(
        [sys.executable, "-B", "-c", STALE, str(cache), str(source), unwritten],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["1.5", "11.5"]


def test_a_process_that_compiles_computes_the_digits_of_those_that_load(tmp_path: Path) -> None:
    """Sums in another order, by another copy of an inner kernel, differ in one step of hundreds."""
    cache = {"NUMBA_CACHE_DIR": str(tmp_path)}
    compiling, loading = (_run(SUMS, **cache).communicate()[0] for _ in range(2))
    assert len(loading) == 65 and compiling == loading


@pytest.mark.parametrize("collects", [True, False])
def test_python_collects_no_garbage_while_a_kernel_is_compiled(collects: bool) -> None:
    """Afterwards it does as before."""

    @njit(cache=False)
    def compiled(x: float) -> float:
        return x + 1.0

    collecting = []
    enabled = gc.isenabled()
    try:
        (gc.enable if collects else gc.disable)()
        with compiling.reporting(lambda: collecting.append(gc.isenabled())):
            compiled(1.0)
        assert gc.isenabled() == collects
    finally:
        (gc.enable if enabled else gc.disable)()
    assert collecting and not any(collecting)


def test_python_may_call_a_function_that_kernels_inline() -> None:
    """It is a plain function there, without compiled code that could be called in a wrong way."""

    @njit(cache=False)
    def compiled(rows: int, columns: int) -> tuple[int, int, int]:
        return coarse_grid(rows, columns)

    for shape in ((7, 9), (40, 31), (300, 500), (2000, 1800)):
        assert compiled(*shape) == coarse_grid(*shape)


@pytest.mark.parametrize(
    ("core_count", "parts"),
    [(1, []), (2, ["compile_step"]), (8, ["compile_step", "compile_parts"])],
)
def test_spare_cores_compile_ahead_until_the_pool_is_left(
    monkeypatch: pytest.MonkeyPatch, core_count: int, parts: list[str]
) -> None:
    """Without a core to spare, a further process would only take the time of its own start."""
    done: list[str] = []
    process = SimpleNamespace(kill=lambda: done.append("kill"), wait=lambda: done.append("wait"))
    monkeypatch.setattr(pools.cost, "cores", lambda: core_count)
    monkeypatch.setattr(pools.worker, "compiler", lambda part: done.append(part) or process)
    with pools.Pool() as pool:
        pool._report_compiling()
        pool._report_compiling()
    assert done == [*parts, *["kill", "wait"] * len(parts)]


def test_without_a_process_to_compile_ahead_a_pool_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(part: str) -> None:
        raise BlockingIOError("no more processes")

    monkeypatch.setattr(pools.cost, "cores", lambda: 2)
    monkeypatch.setattr(pools.worker, "compiler", refused)
    with pools.Pool() as pool:
        pool._report_compiling()


@pytest.mark.slow
def test_kernels_compiled_ahead_are_those_of_a_march() -> None:
    """A march with sharp edges, blended edges or sub-cells needs no further code of them.

    Neither do whole numbers and heights in another order of memory, or closed to writing.
    """
    signatures, kernels = _run(SAME_TYPES).communicate()[0].split()
    assert signatures == "1" and int(kernels) == 6
