"""Rules of every test: invalid numbers are errors, a test with a browser is slow, and the longest
tests are the first.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
import pytest

from rolling.run.worker import ENVIRONMENT
from rolling.terminal import progress

# Files with tests of a minute. A process that begins one at the end leaves the other one idle.
LONGEST = ("test_docs", "test_tutorials", "test_every_write", "test_validate", "test_audibility")


def pytest_configure() -> None:
    """Run libraries on one thread in all processes of the tests, as the command line does.

    Beside another process on each core, threads that wait for each other took 180 s of processor
    time for a test of 20 s.
    """
    for name, value in ENVIRONMENT.items():
        if name.endswith("_NUM_THREADS"):
            os.environ.setdefault(name, value)


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


@pytest.hookimpl(tryfirst=True)  # before pytest selects by -m
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")
            item.add_marker("slow")
    items.sort(key=lambda item: item.path.stem not in LONGEST)
