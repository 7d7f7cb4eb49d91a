"""The program in a process of its own, to which something happens at a known step of its work.

The process does it to itself before it begins a piece of a march. No test therefore has to be
quicker than the work, however quick or slow the machine is.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

PATIENCE = 900.0  # [s] until a command has surely hung, on whatever machine

# Workers import this module because the function of their tasks stands in it.
MODULE = """\
import os
import signal
import time
from pathlib import Path

from rolling.simulation import simulate

HERE = Path(__file__).parent
march, begun, latest = simulate._ordered_piece, [], []


def piece(*arguments):
    begun.append(arguments[1])
    latest[:] = [arguments]
    happen(arguments[-2])
    result = march(*arguments)
    (HERE / f"done-{{arguments[1]}}").touch()
    return result


def once():
    try:
        (HERE / "happened").touch(exist_ok=False)
    except FileExistsError:
        return False
    return True


def happen(stopped):
    {happening}


simulate._ordered_piece = piece
"""

# Each happens before the second piece of a process.
KILL = "if len(begun) == 2: os.kill(os.getpid(), signal.SIGKILL)"
KILL_ONE = "if len(begun) == 2 and once(): os.kill(os.getpid(), signal.SIGKILL)"
STOP = "if len(begun) == 2: os.kill(os.getpid(), signal.SIGSTOP)"
# Each process marches its second piece until it is killed, and says so in a file of its number.
ENDLESS = """\
if len(begun) == 2:
        (HERE / "marching").mkdir(exist_ok=True)
        (HERE / "marching" / str(os.getpid())).touch()
        while True:
            march(*latest[0])"""
# The first piece of the track is done, and no other is begun before the process has understood.
CTRL_C = """\
if len(begun) == 2:
        while not (HERE / "done-0").exists():
            time.sleep(0.01)
        if once():
            os.kill({process}, signal.SIGINT)
        while not stopped():
            time.sleep(0.01)"""
CTRL_C_HERE = CTRL_C.format(process="os.getpid()")
CTRL_C_OF_A_WORKER = CTRL_C.format(process="os.getppid()")


def run(words: Sequence[object], happening: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command, to which the happening happens, to its end.

    Parameters
    ----------
    words : sequence. Words of the command after `rolling`.
    happening : str. Statements before a piece of a march: KILL, KILL_ONE or CTRL_C_....
    folder : Path. An existing folder for the module of the happening.
    """
    command, environment = _prepared(words, happening, folder)
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


@contextmanager
def started(
    words: Sequence[object], happening: str, folder: Path
) -> Iterator[subprocess.Popen[bytes]]:
    """Start a command, to which the happening happens, and kill it in the end."""
    command, environment = _prepared(words, happening, folder)
    with (folder / "said").open("wb") as said:
        process = subprocess.Popen(command, env=environment, stdout=said, stderr=said)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def stopped(words: Sequence[object], folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a command, which stops itself before its second piece, and kill it in the end."""
    with started(words, STOP, folder) as process:
        ended = os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
        assert ended is not None
        assert ended.si_code == os.CLD_STOPPED, (folder / "said").read_text()
        yield process


def _prepared(
    words: Sequence[object], happening: str, folder: Path
) -> tuple[list[str], dict[str, str]]:
    """Write the module of the happening; return the command and its environment."""
    (folder / "happenings_here.py").write_text(MODULE.format(happening=happening))
    argv = [str(word) for word in words]
    program = f"import sys, happenings_here; from rolling import cli; sys.exit(cli.main({argv}))"
    path = os.pathsep.join(filter(None, [str(folder), *sys.path]))
    return [sys.executable, "-c", program], os.environ | {"PYTHONPATH": path}
