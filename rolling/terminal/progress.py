"""Lines and bars that a person sees while a command works, on standard error.

A command of the command line begins with `begin`. Without it, in a program of somebody else, there
are bars on a terminal and in a notebook, and no lines but that of the compilation.
"""

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Self

LAYOUT = "{desc} {percentage:3.0f}%|{bar}| {elapsed} passed, {remaining} left"
PATIENCE = 0.7  # [s] before a step that still goes on gets its line
LINE_SECONDS = 30.0  # between two lines of a bar where nobody watches
COMPILING = "compiling the solver for this machine, once; this takes up to a minute"


class Level(IntEnum):
    """Amount of text that a command prints."""

    QUIET = 0  # refusals, errors and the folder
    NORMAL = 1
    VERBOSE = 2  # times as well


@dataclass(eq=False)
class _Command:
    """State of a command.

    level : Level. Amount of text; None in a program of somebody else, which runs no command.
    is_in_step : bool. Whether a step goes on, whose line stands for the steps in it.
    has_reported_compiling : bool. Whether the line of the compilation was printed.
    has_solved : bool. Whether there are results that an error leaves behind.
    """

    level: Level | None = None
    is_in_step: bool = False
    has_reported_compiling: bool = False
    has_solved: bool = False


# The program of somebody else, and the commands that run in it. Threads may begin and end theirs in
# any order, so each takes away its own.
_commands = [_Command()]


def _current() -> _Command:
    """Return the command that began last of those that run, or the program around them."""
    return _commands[-1]


@contextmanager
def begin(level: Level) -> Iterator[None]:
    """Print as much as the level asks for until the command ends."""
    command = _Command(level)
    _commands.append(command)
    try:
        yield
    finally:
        _commands.remove(command)
        _current().has_solved = command.has_solved


@contextmanager
def shown(is_shown: bool | None) -> Iterator[None]:
    """Print nothing until the end where a caller from Python asks for silence.

    is_shown : bool. False for silence; otherwise nothing changes.
    """
    if is_shown is not False:
        yield
        return
    with begin(Level.QUIET):
        yield


def silence() -> None:
    """Print nothing from now on: a worker process leaves the terminal to its parent."""
    _current().level = Level.QUIET


def solved() -> None:
    """Note that the command has solved something."""
    _current().has_solved = True


def has_solved() -> bool:
    """Return whether the present command, or the last one that ended, has solved something."""
    return _current().has_solved


def is_quiet() -> bool:
    """Return whether the command prints errors and its folder only."""
    return _current().level == Level.QUIET


def is_verbose() -> bool:
    """Return whether the command says more than a person needs."""
    return _current().level == Level.VERBOSE


def line(text: str) -> None:
    """Print a line unless the command is quiet, above a bar if there is one."""
    if _current().level is None or is_quiet():
        return
    tqdm: Any = getattr(sys.modules.get("tqdm"), "tqdm", None)  # imported with the first bar
    if tqdm is not None:
        tqdm.write(text, file=sys.stderr)
    else:
        print(text, file=sys.stderr, flush=True)


def detail(text: str) -> None:
    """Print a line if the command is verbose."""
    if _current().level == Level.VERBOSE:
        line(text)


def compiling() -> None:
    """Say that the solver is compiled, the first time in a command or a program."""
    if _current().has_reported_compiling:
        return
    _current().has_reported_compiling = True
    if _current().level is not None:
        line(COMPILING)
        return
    with begin(Level.NORMAL):
        line(COMPILING)


@contextmanager
def step(text: str) -> Iterator[None]:
    """Print a line for a step that takes longer than a moment; add its time if verbose.

    A step in another step has no line before its time.
    """
    command = _current()
    is_inner = command.is_in_step
    command.is_in_step = True
    timer = threading.Timer(PATIENCE, line, (text,))
    timer.daemon = True
    began = time.monotonic()
    if not is_inner:
        timer.start()
    try:
        yield
    finally:
        timer.cancel()
        command.is_in_step = is_inner
        detail(f"{text}: {time.monotonic() - began:.2f} s")


class Bar:
    """Progress of a long step, used as a context: a bar for a person, or a line now and then."""

    def __init__(self, total: float, name: str, shown: bool | None = None) -> None:
        """Begin with the sum of the progress; `shown` None: where somebody looks."""
        self._name = name
        self._began = time.monotonic()
        self._last_line = self._began
        self._total = total
        self._done = 0.0
        self._largest_share = 0.0
        self._bar: Any = None
        if not is_quiet() and shown is not False:
            from tqdm import tqdm

            is_hidden = None  # unless the stream is a terminal
            if shown or in_notebook():
                is_hidden = False
            self._bar = tqdm(
                total=total, desc=name, disable=is_hidden, file=sys.stderr, bar_format=LAYOUT
            )

    @property
    def share(self) -> float:
        """Share of the progress that is shown. It rests, and never falls, when the sum grows."""
        if self._total > 0:
            share = min(self._done / self._total, 1.0)
            self._largest_share = max(self._largest_share, share)
        return self._largest_share

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        if self._bar is not None:
            self._bar.close()

    def update(self, share: float) -> None:
        """Add to the progress, at most up to its sum."""
        self._done = min(self._done + share, self._total)
        self.tick()

    def grow(self, share: float) -> None:
        """Add to the sum of the progress."""
        self._total = max(self._total + share, self._done)

    def tick(self) -> None:
        """Show the present time, or print a line if it is due."""
        if self._bar is not None and not self._bar.disable:
            self._bar.total = self._total
            self._bar.n = self.share * self._total
            self._bar.refresh()
        elif time.monotonic() - self._last_line > LINE_SECONDS and self._total > 0:
            self._last_line = time.monotonic()
            passed = round(self._last_line - self._began)
            line(f"{self._name}: {100 * self.share:.0f} %, {passed} s passed")


def in_notebook() -> bool:
    """Return whether this code runs in a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"
