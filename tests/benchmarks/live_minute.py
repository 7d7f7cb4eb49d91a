"""A minute of the instrument in Chromium: its clock beside that of the page, and its load.

`python tests/benchmarks/live_minute.py [PAGE] [--seconds N]` plays a report.html, or a short march.
It prints the share of a core that the browser takes while the instrument plays, and after *Stop*.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import live_engine
import psutil
from playwright.sync_api import sync_playwright
from report_browser import FLAGS, browser_path

import rolling as rc

# Keeps the audio context that plays the instrument.
LISTEN = """
  window.AudioWorkletNode = class extends AudioWorkletNode {
    constructor(context, ...rest) {
      super(context, ...rest);
      window.playing = context;
    }
  };
"""
CLOCK = "[performance.now() / 1000, playing.currentTime]"
REST_S = 4.0  # after Stop, until the sound has died away


def processor_seconds() -> float:
    """Return the processor time that the browser has taken, which runs below this process [s]."""
    total = 0.0
    for process in psutil.Process().children(recursive=True):
        try:
            times = process.cpu_times()
        except psutil.NoSuchProcess:
            continue
        total += times.user + times.system
    return total


def main() -> None:
    """Play a page and print the time [s] by which the clock of its sound falls behind."""
    parser = argparse.ArgumentParser()
    parser.add_argument("page", nargs="?", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        if (path := given.page) is None:
            scene = live_engine.scene({"surface.width_um": 256, **live_engine.EDGES})
            run = rc.simulate(scene.with_({"plate.thickness_mm": 3}), workers=1, progress=False)
            path = run.save(Path(folder) / "run") / "report.html"
        browser = playwright.chromium.launch(executable_path=browser_path(), args=FLAGS)
        page = browser.new_page()
        page.add_init_script(LISTEN)
        page.goto(path.resolve().as_uri())
        page.click("#play-roll")
        page.wait_for_timeout(3000)  # preparation and compilation
        begun = page.evaluate(CLOCK)
        taken = processor_seconds()
        page.wait_for_timeout(1000 * given.seconds)
        wall, sounded = page.evaluate(CLOCK)
        playing = processor_seconds() - taken
        page.click("#play-roll")  # which is Stop now
        page.wait_for_timeout(1000 * REST_S)
        taken = processor_seconds()
        page.wait_for_timeout(1000 * given.seconds)
        stopped = processor_seconds() - taken
        browser.close()
    seconds = wall - begun[0]
    lag = (wall - begun[0]) - (sounded - begun[1])
    print(f"{seconds:.1f} s: lag {lag:+.3f} s")
    print(f"share of a core: {playing / seconds:.3f} while it plays, ", end="")
    print(f"{stopped / given.seconds:.3f} after Stop")


main()
