"""Rules of every test: invalid numbers are errors, a test with a browser is slow, and the longest
tests are the first.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator

# Processes that the tests start take compiled modules from the disk, whatever is set outside.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Libraries run on one thread in all processes of the tests, as by the command line, and read so
# when they are loaded. Beside another process on each core, threads that wait for each other took
# 180 s of processor time for a test of 20 s.
for _name in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_name}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import pytest  # noqa: E402

from rolling.results import listening  # noqa: E402
from rolling.terminal import progress  # noqa: E402

# Files with tests of a minute. A process that begins one at the end leaves the other one idle.
LONGEST = (
    "test_docs",
    "test_tutorials",
    "test_examples",
    "test_every_write",
    "test_validate",
    "test_audibility",
    "test_estimate_study",
    "test_wheel_rail",
    "test_choose",
    "test_sound_by_place",
    "test_mutated_bearings",
)


# Objects that are new, and collections of the young and of the middle ones, before each collection.
NEW_OBJECTS = (70_000, 10, 10)


@pytest.fixture(autouse=True)
def floating_point_errors() -> Iterator[None]:
    """Raise where numpy would continue with inf or nan.

    Code that divides by zero on purpose uses `np.errstate`.
    """
    with np.errstate(divide="raise", invalid="raise", over="raise"):
        yield


@pytest.fixture(autouse=True)
def no_lines_of_long_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Say no lines for steps that only a busy machine makes long: tests compare what is printed."""
    monkeypatch.setattr(progress, "PATIENCE", 600.0)
    monkeypatch.setattr(progress, "LINE_SECONDS", 600.0)


@pytest.fixture(scope="module")
def short_sounds() -> Iterator[None]:
    """Let sounds for the ear last 0.1 s instead of 5 s, where nobody listens to them.

    Each file of 5 s takes a tenth of a second, a third of what a small run takes.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(listening, "MIN_S", 0.1)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Collect the tests without the collector of garbage, which never looks at them again.

    Their modules and libraries are millions of objects that last until the end. Afterwards it
    looks at new objects a hundredth as often as by default: figures are many small ones.
    """
    gc.disable()
    result = yield
    gc.collect()
    gc.freeze()
    gc.set_threshold(*NEW_OBJECTS)
    gc.enable()
    return result


@pytest.hookimpl(tryfirst=True)  # before pytest selects by -m
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
            item.add_marker("slow")
    items.sort(key=lambda item: item.path.stem not in LONGEST)
