"""Lines and bars that a person sees while a command works, on standard error.

A command of the command line begins with `begin`. Without it, in a program of somebody else, there
are bars on a terminal and in a notebook, and no lines.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from types import TracebackType
from typing import Any, Protocol, Self

BAR = "{desc} {percentage:3.0f}%|{bar}| {elapsed} passed, {remaining} left"
PATIENCE = 0.7  # [s] before a step that still goes on gets its line
TICK = 1.0  # [s] between two looks of a bar whose step says nothing
FIRST_LINE, NEXT_LINE = 5.0, 30.0  # [s] to the first line of a bar that is no terminal, and between
# From this share on the time left is told. Before, most of the time went into compilation.
FORESEEN = 0.02
COMPILING = "compiling the solver for this machine, once; this takes up to a minute"


class Level(IntEnum):
    """How much a command says."""

    QUIET = 0  # refusals, errors and the folder
    NORMAL = 1
    VERBOSE = 2  # pieces, windows, iterations and times as well


@dataclass
class _Voice:
    """The level of the command at hand.

    level : Level. Level; None in a program of somebody else.
    compiling : bool. Whether it was said that the solver is compiled.
    """

    level: Level | None = None
    compiling: bool = False


_voice = _Voice()


@contextmanager
def begin(level: Level) -> Iterator[None]:
    """Say as much as the level asks for until the command ends."""
    before = _voice.level, _voice.compiling
    _voice.level, _voice.compiling = level, False
    try:
        yield
    finally:
        _voice.level, _voice.compiling = before


def is_quiet() -> bool:
    """Return whether the command says refusals, errors and the folder only."""
    return _voice.level == Level.QUIET


def is_verbose() -> bool:
    """Return whether the command says more than usual."""
    return _voice.level == Level.VERBOSE


def line(text: str) -> None:
    """Say a line unless the command is quiet, beside a bar if there is one."""
    if _voice.level is not None and _voice.level >= Level.NORMAL:
        _write(text)


def detail(text: str) -> None:
    """Say a line if the command is verbose."""
    if is_verbose():
        _write(text)


def compiling() -> None:
    """Say that the solver is compiled, the first time in a command."""
    if not _voice.compiling:
        _voice.compiling = True
        line(COMPILING)


@contextmanager
def step(text: str) -> Iterator[None]:
    """Say a line for a step that takes longer than a moment; a verbose command adds its time."""
    if _voice.level is None or _voice.level == Level.QUIET:
        yield
        return
    timer = threading.Timer(PATIENCE, line, (text,))
    timer.daemon = True
    began = time.monotonic()
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        detail(f"{text}: {time.monotonic() - began:.2f} s")


class Bar(Protocol):
    """The progress of a long step, a context."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> object: ...

    def update(self, share: float) -> object:
        """Add to the progress; zero moves the clock only."""

    def grow(self, share: float) -> object:
        """Add to the sum of the progress: more work has come up."""


def bar(
    total: float,
    name: str,
    shown: bool | None = None,
    *,
    delay: float = 0.0,
    leave: bool = True,
    unit: str | None = None,
) -> Bar:
    """Return a bar on a terminal and in a notebook, and lines now and then elsewhere.

    Parameters
    ----------
    total : float. Sum of the progress.
    name : str. Name of the step.
    shown : bool or None. Whether there is a bar. Default: None, where somebody looks.
    delay : float, s. Time before the bar appears. Default: 0.
    leave : bool. Whether the bar stays when it is full. Default: true.
    unit : str or None. Unit that is counted. Default: None, for a percentage.
    """
    if _voice.level is not None and shown is None and not sys.stderr.isatty():
        return _Clocked(_Lines(total, name), FIRST_LINE)
    from tqdm import tqdm

    layout = {"bar_format": BAR} if unit is None else {"unit": unit}
    watched = tqdm(
        total=total,
        desc=name,
        disable=_is_hidden(shown),
        delay=delay,
        leave=leave,
        file=sys.stderr,
        **layout,
    )
    return _Clocked(watched, delay)


class _Clocked:
    """A bar whose clock goes on while its step says nothing.

    Parameters
    ----------
    shown : tqdm or _Lines. The bar itself.
    delay : float, s. Time before it appears.
    """

    def __init__(self, shown: Any, delay: float) -> None:
        self._shown, self._delay = shown, delay
        self._done = threading.Event()

    def __enter__(self) -> Self:
        self._shown.__enter__()
        if not self._shown.disable:
            threading.Thread(target=self._tick, name="bar", daemon=True).start()
        return self

    def __exit__(self, *error: Any) -> None:
        self._done.set()
        self._shown.__exit__(*error)

    def update(self, share: float) -> object:
        """Add to the progress, up to its sum, which rounded shares may exceed."""
        done, total = self._shown.n, self._shown.total
        share = max(min(share, total - done), 0)
        while done + share > total:  # by the last bit, of which tqdm warns
            share = math.nextafter(share, 0.0)
        return self._shown.update(share)

    def grow(self, share: float) -> None:
        """Add to the sum of the progress."""
        self._shown.total += share

    def _tick(self) -> None:
        """Show the bar anew every second until the step is done."""
        wait = self._delay + TICK
        while not self._done.wait(wait):
            self._shown.refresh()
            wait = TICK


class _Lines:
    """The progress of a long step where nobody watches: a line now and then."""

    def __init__(self, total: float, name: str) -> None:
        self.disable = is_quiet()
        self.total, self._name, self.n = total, name, 0.0
        self._began = time.monotonic()
        self._next = self._began + FIRST_LINE
        self._lock = threading.Lock()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def update(self, share: float) -> None:
        """Add to the progress, and say a line if it is time."""
        self.n += share
        self.refresh()

    def refresh(self) -> None:
        """Say a line if it is time."""
        with self._lock:
            now = time.monotonic()
            if now < self._next or self.total <= 0:
                return
            self._next = now + NEXT_LINE
        part, passed = self.n / self.total, now - self._began
        left = f", {_clock(passed / part - passed)} left" if part >= FORESEEN else ""
        line(f"{self._name}: {100 * part:.0f} %, {_clock(passed)} passed{left}")


def in_notebook() -> bool:
    """Return whether this code runs in a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"


def _is_hidden(shown: bool | None) -> bool | None:
    """Return the value of tqdm's `disable`; None hides the bar unless the stream is a terminal."""
    if is_quiet():
        return True
    if shown is None:
        return False if in_notebook() else None
    return not shown


def _clock(seconds: float) -> str:
    """Write a time as 0:07 or 1:02:03."""
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02d}:{second:02d}" if hours else f"{minute}:{second:02d}"


def _write(text: str) -> None:
    """Write a line on standard error, above the bars."""
    tqdm: Any = getattr(sys.modules.get("tqdm"), "tqdm", None)  # imported with the first bar
    if tqdm is not None:
        tqdm.write(text, file=sys.stderr)
    else:
        print(text, file=sys.stderr, flush=True)
