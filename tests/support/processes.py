"""Real processes for tests of folders.

They are forked, so that nothing is imported again, and killed without a chance to tidy up.
"""

from __future__ import annotations

import os
import signal
import traceback
from collections.abc import Callable
from contextlib import suppress


class Child:
    """A forked process that runs a function; `say` and `hear` exchange lines with it."""

    def __init__(self, function: Callable[[Child], object]) -> None:
        down, up = os.pipe(), os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            self._read, self._write = down[0], up[1]
            signal.alarm(900)  # it does not outlive a test that fails
            code = 1
            with suppress(BaseException):
                try:
                    function(self)
                    code = 0
                except BaseException:
                    traceback.print_exc()
            os._exit(code)
        self._read, self._write = up[0], down[1]
        os.close(down[0])
        os.close(up[1])

    def say(self, text: str) -> None:
        os.write(self._write, f"{text}\n".encode())

    def hear(self) -> str:
        """Return the next line, empty once the other side has ended."""
        line = b""
        while (byte := os.read(self._read, 1)) not in (b"", b"\n"):
            line += byte
        return line.decode()

    def kill(self) -> None:
        """Kill the process; it is gone when this returns."""
        os.kill(self.pid, signal.SIGKILL)
        self.wait()

    def wait(self) -> int:
        """Return the exit code; a negative one is the signal that ended the process."""
        _, status = os.waitpid(self.pid, 0)
        os.close(self._read)
        os.close(self._write)
        return os.waitstatus_to_exitcode(status)
