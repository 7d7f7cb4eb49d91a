"""A browser for the tests of the report page, and the reading and handling of an open page."""

from __future__ import annotations

import base64
import io
import json
import os
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile
from axe_playwright_python.sync_playwright import Axe

from acoustics import wav

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# Chromium's flags for a machine without screen, sound card or network.
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-sync",
    "--disable-background-networking",
    "--disable-component-update",
    "--autoplay-policy=no-user-gesture-required",
]
PATIENCE = 60.0  # [s] until something surely does not happen
MINUS = "\N{MINUS SIGN}"
# Axe leaves out the rule that the name of a button contains its label. Waiting for sounds is off.
AXE = {
    "resultTypes": ["violations"],
    "preload": False,
    "rules": {"label-content-name-mismatch": {"enabled": True}},
}
RATE = wav.SAMPLE_RATE_HZ
# Counts what the page starts, keeps its gains, pictures and last look at the clock, and listens at
# its way out. Work that the page puts off by a second or more waits in `later` for the test.
TAP = """
  window.tap = { starts: 0, gains: [], sources: [], images: [], rooms: [], later: [], now: 0 };
  Object.assign(tap, { whens: [], offsets: [] });
  const now = performance.now.bind(performance);
  performance.now = () => (tap.now = now());
  window.Image = class extends Image {
    constructor(...a) { super(...a); tap.images.push(this); }
  };
  const soon = window.setTimeout;
  window.setTimeout = (work, ms, ...rest) =>
    ms >= 1000 ? tap.later.push(work) : soon(work, ms, ...rest);
  const start = AudioBufferSourceNode.prototype.start;
  AudioBufferSourceNode.prototype.start = function (...a) {
    tap.starts++;
    tap.whens.push(a[0]);
    tap.offsets.push(a[1]);
    return start.apply(this, a);
  };
  const connect = AudioNode.prototype.connect;
  AudioNode.prototype.connect = function (to, ...rest) {
    const ears = this instanceof ConvolverNode && this.buffer.numberOfChannels;
    if (ears === 2) tap.rooms.push(to); // that of a plate has one for a listener
    if (this instanceof AudioBufferSourceNode) { tap.gains.push(to); tap.sources.push(this); }
    if (to instanceof AudioDestinationNode) {
      tap.context = this.context;
      tap.analyser = new AnalyserNode(this.context, { fftSize: 2048 });
      connect.call(this, tap.analyser);
    }
    return connect.call(this, to, ...rest);
  };
"""
PIXELS = """(canvas, places) => {
  const options = { willReadFrequently: true };
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', options);
  copy.drawImage(canvas, 0, 0);
  return places.map(([x, y]) => [...copy.getImageData(x, y, 1, 1).data].slice(0, 3));
}"""


def browser_path() -> str | None:
    for name in BROWSERS:
        path = shutil.which(name)
        if path is not None:
            return path
    return None


def without_browser(missing: str) -> None:
    message = f"{missing}: install Debian's `chromium` and the extra `dev`, which has playwright"
    if os.environ.get("ROLLING_BROWSER_REQUIRED"):
        pytest.fail(message)
    pytest.skip(message)


def data_of(path: Path) -> dict:
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', path.read_text())
    assert data
    return json.loads(data.group(1))


def embedded_record(path: Path, number: int) -> np.ndarray:
    """Return the samples of a run's player on the page, in parts of full scale."""
    sounds = re.findall(
        r'data-run="\d+"[^>]* src="data:audio/flac;base64,([^"]+)"', path.read_text()
    )
    samples, rate = soundfile.read(io.BytesIO(base64.b64decode(sounds[number])))
    assert rate == RATE
    return samples


def seek(page, seconds: float) -> None:
    page.locator("#seek").evaluate(
        "(s, t) => { s.value = t; s.dispatchEvent(new Event('input')); }", seconds
    )


def time_of(page) -> float:
    return float(page.text_content("#time").split(" s")[0])


def map_of(page) -> int:
    return int(re.match(r"map (\d+) of", page.text_content("#map-number"))[1]) - 1


def axe_findings(page, part: str | None = None) -> list[tuple[str, list]]:
    """Return the rules that a page breaks, or a part of it, each with the places that break it."""
    violations = Axe().run(page, context=part, options=AXE).response["violations"]
    return [(rule["id"], [node["target"] for node in rule["nodes"]]) for rule in violations]


def until(page, condition: str) -> None:
    """Wait for a condition.

    Playwright's own way evaluates text in the page, which the page forbids.
    """
    end = time.monotonic() + PATIENCE
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"never: {condition}"
        page.wait_for_timeout(5)


def hear(page, seconds: float = 0.1) -> None:
    """Wait until so much more has sounded; crossfades take 10 ms."""
    clock = "tap.context.currentTime"
    until(page, f"{clock} > {page.evaluate(clock) + seconds}")


def play(page) -> None:
    page.click("#play")
    until(page, "parseFloat(document.querySelector('#seek').value) > 0.02")
