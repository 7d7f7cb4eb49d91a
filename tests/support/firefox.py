"""A page in Firefox, driven by the WebDriver BiDi protocol over a web socket."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any

from report_browser import PATIENCE
from tornado.ioloop import IOLoop
from tornado.websocket import websocket_connect

NAMES = ("firefox-esr", "firefox")
PREFERENCES = {
    "media.autoplay.default": 0,  # a script may start a sound
    "media.cubeb.force_mock_context": True,  # sound without a sound card
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.homepage": "about:blank",
    "datareporting.policy.dataSubmissionEnabled": False,
    "app.update.enabled": False,
}


def firefox_path() -> str | None:
    for name in NAMES:
        path = shutil.which(name)
        if path is not None:
            return path
    return None


class Firefox:
    """A browser with one page; `complaints` holds what its console and its scripts said."""

    def __init__(self, program: str, profile: Path) -> None:
        texts = (f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in PREFERENCES.items())
        (profile / "user.js").write_text("\n".join(texts))
        self._loop = IOLoop(make_current=False)
        self._last = 0
        self.complaints = list[str]()
        self._thread = ThreadPoolExecutor(1)  # playwright has a loop in this one
        words = [program, "--headless", "--no-remote", "--remote-debugging-port=0", "--profile"]
        output = profile / "said.txt"
        with output.open("w") as file:
            self._process = subprocess.Popen([*words, str(profile)], stdout=file, stderr=file)
        end = time.monotonic() + PATIENCE
        while not (address := re.search(r"BiDi listening on (\S+)", output.read_text())):
            assert self._process.poll() is None and time.monotonic() < end, output.read_text()
            time.sleep(0.05)
        self._socket = self._run(websocket_connect, f"{address[1]}/session")
        self.send("session.new", capabilities={})
        self.send("session.subscribe", events=["log.entryAdded"])
        self._page = self.send("browsingContext.getTree")["contexts"][0]["context"]

    def __enter__(self) -> Firefox:
        return self

    def __exit__(self, kind: type | None, error: Exception | None, trace: TracebackType | None):
        self._process.terminate()
        self._process.wait()
        self._thread.submit(self._loop.close).result()
        self._thread.shutdown()

    def _run(self, call, *words):
        task = self._thread.submit(self._loop.run_sync, lambda: call(*words), PATIENCE)
        return task.result()

    def send(self, method: str, **params: Any) -> dict[str, Any]:
        """Send a command and return its result; keep the complaints that come before it."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": params}
        self._run(self._socket.write_message, json.dumps(message))
        while (answer := json.loads(self._run(self._socket.read_message))).get("id") != self._last:
            if answer["method"] == "log.entryAdded":
                self.complaints.append(f"{answer['params']['level']}: {answer['params']['text']}")
        assert answer["type"] == "success", answer
        return answer["result"]

    def goto(self, path: Path, width: int = 1280, height: int = 900) -> None:
        size = {"width": width, "height": height}
        self.send("browsingContext.setViewport", context=self._page, viewport=size)
        address = path.as_uri()
        self.send("browsingContext.navigate", context=self._page, url=address, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression, which may be a promise."""
        text = f"(async () => JSON.stringify(await ({expression})) ?? null)()"
        target = {"context": self._page}
        words = {"expression": text, "target": target, "awaitPromise": True}
        result = self.send("script.evaluate", **words, userActivation=True)
        assert result["type"] == "success", result
        value = result["result"].get("value")
        return None if value is None else json.loads(value)

    def click(self, selector: str) -> None:
        """Click the middle of an element with the pointer."""
        place = f"document.querySelector({json.dumps(selector)})"
        self.evaluate(f"{place}.scrollIntoView({{block: 'center', behavior: 'instant'}})")
        box = self.evaluate(f"{place}.getBoundingClientRect()")
        x, y = (round(box[a] + box[b] / 2) for a, b in (("x", "width"), ("y", "height")))
        moves = [{"type": "pointerMove", "x": x, "y": y}]
        moves += [{"type": kind, "button": 0} for kind in ("pointerDown", "pointerUp")]
        pointer = {"type": "pointer", "id": "pointer", "actions": moves}
        self.send("input.performActions", context=self._page, actions=[pointer])

    def press(self, key: str) -> None:
        strokes = [{"type": kind, "value": key} for kind in ("keyDown", "keyUp")]
        keyboard = {"type": "key", "id": "keyboard", "actions": strokes}
        self.send("input.performActions", context=self._page, actions=[keyboard])

    def until(self, condition: str) -> None:
        end = time.monotonic() + PATIENCE
        while not self.evaluate(condition):
            assert time.monotonic() < end, f"never: {condition}"
            time.sleep(0.02)

    def screenshot(self, path: Path) -> None:
        import base64

        image = self.send("browsingContext.captureScreenshot", context=self._page)["data"]
        path.write_bytes(base64.b64decode(image))
