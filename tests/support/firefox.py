"""Firefox driven by the protocol that it speaks by itself, WebDriver BiDi over a WebSocket."""

from __future__ import annotations

import base64
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

BROWSERS = ("firefox-esr", "firefox")
PATIENCE = 300.0  # [s] until something surely does not happen


def path() -> str | None:
    """Return the path of the browser, or None where it is not installed."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


class Session:
    """A session of the browser with one page.

    errors : list of str. What the page complained about.
    """

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        key = base64.b64encode(os.urandom(16)).decode()
        self._socket.sendall(
            f"GET /session HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
            f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self._exactly(1)
        assert b" 101 " in head.splitlines()[0], head
        self._number = 0
        self.errors: list[str] = []
        self.command("session.new", capabilities={})
        self.command("session.subscribe", events=["log.entryAdded"])
        tree = self.command("browsingContext.getTree")
        self._context = tree["contexts"][0]["context"]

    def open(self, page: Path) -> None:
        """Open a file, until it is loaded."""
        self.command(
            "browsingContext.navigate", context=self._context, url=page.as_uri(), wait="complete"
        )

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression as JSON carries it."""
        answer = self.command(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({expression})))()",
            target={"context": self._context},
            awaitPromise=True,
            userActivation=True,
        )
        assert answer["type"] == "success", answer
        value = answer["result"].get("value")
        return None if value is None else json.loads(value)

    def until(self, condition: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.evaluate(condition):
            assert time.monotonic() < end, f"never: {condition}"
            time.sleep(0.02)

    def command(self, method: str, **parameters: Any) -> Any:
        """Send a command, and return its result."""
        self._number += 1
        self._send(json.dumps({"id": self._number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._receive())
            if message.get("method") == "log.entryAdded" and message["params"]["level"] == "error":
                self.errors.append(message["params"]["text"])
            if message.get("id") == self._number:
                assert message["type"] == "success", message
                return message["result"]

    def close(self) -> None:
        self._socket.close()

    # ---- frames of RFC 6455

    def _send(self, text: str) -> None:
        content, mask = text.encode(), os.urandom(4)
        length = len(content)
        head = b"\x81" + (
            bytes([0x80 | length]) if length < 126 else b"\xfe" + struct.pack(">H", length)
        )
        assert length < 1 << 16
        masked = bytes(byte ^ mask[k % 4] for k, byte in enumerate(content))
        self._socket.sendall(head + mask + masked)

    def _receive(self) -> str:
        content, whole = b"", False
        while not whole:
            first, second = self._exactly(2)
            length = second & 0x7F
            if length >= 126:
                form, size = (">H", 2) if length == 126 else (">Q", 8)
                (length,) = struct.unpack(form, self._exactly(size))
            part = self._exactly(length)
            if first & 0x0F in (0, 1):
                content, whole = content + part, bool(first & 0x80)
        return content.decode()

    def _exactly(self, count: int) -> bytes:
        content = b""
        while len(content) < count:
            part = self._socket.recv(count - len(content))
            assert part, "the browser closed the connection"
            content += part
        return content


@contextmanager
def session(executable: str, profile: Path) -> Iterator[Session]:
    """Start the browser on a profile of its own, and end it."""
    profile.mkdir()
    (profile / "user.js").write_text(
        'user_pref("media.autoplay.default", 0);\n'
        'user_pref("media.autoplay.block-webaudio", false);\n'
        'user_pref("media.autoplay.blocking_policy", 0);\n'
        'user_pref("app.update.enabled", false);\n'
        'user_pref("datareporting.policy.dataSubmissionEnabled", false);\n'
    )
    command = [executable, "--headless", "--no-remote", "--remote-debugging-port", "0"]
    log = profile / "log"
    with log.open("wb") as said:
        browser = subprocess.Popen(
            [*command, "--profile", str(profile)],
            stdout=said,
            stderr=said,
            env=os.environ | {"HOME": str(profile), "MOZ_DISABLE_AUTO_SAFE_MODE": "1"},
        )
    try:
        opened = Session(_port(browser, log))
        yield opened
        opened.close()
    finally:
        browser.terminate()
        browser.wait(timeout=PATIENCE)


def _port(browser: subprocess.Popen, log: Path) -> int:
    """Wait until the browser says the port at which it listens."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end and browser.poll() is None:
        found = re.search(r"WebDriver BiDi listening on ws://[\d.]+:(\d+)", log.read_text())
        if found:
            return int(found[1])
        time.sleep(0.1)
    raise AssertionError(log.read_text())
