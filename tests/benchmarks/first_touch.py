"""Time from the first touch of the instrument to its sound, and from *Drop it* to the first impact.

`python tests/benchmarks/first_touch.py PAGE [--repeats N]` opens a report.html in
Chromium, under its rules of autoplay, waits until the page is idle, and drags the ball. It prints
the time [ms] from the input event to the first sample that is not zero at the way out of the page,
to the first picture in which the ball has moved, and from a click on *Drop it* to the impact, at
which the sound first reaches a third of its maximum: the minimum and the median of the repeats,
with the load of the machine.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from report_browser import FLAGS, browser_path

# Notes the time of the input events, of the first sound at the way out, and of the first picture.
TAP = """
  window.times = {};
  window.peaks = [];
  const note = (name, time) => { times[name] ??= time; };
  const connect = AudioNode.prototype.connect;
  AudioNode.prototype.connect = function (to, ...rest) {
    if (to instanceof AudioDestinationNode) {
      window.tapped = new AnalyserNode(this.context, { fftSize: 2048 });
      connect.call(this, tapped);
    }
    return connect.call(this, to, ...rest);
  };
  const block = new Float32Array(2048);
  const listen = () => {
    if (window.tapped && times.begun !== undefined) {
      tapped.getFloatTimeDomainData(block);
      const peak = block.slice(-256).reduce((most, sample) => Math.max(most, Math.abs(sample)), 0);
      if (peak > 0) note('sound', performance.now());
      peaks.push([performance.now(), peak]);
    }
    setTimeout(listen, 2);
  };
  listen();
  addEventListener('pointerdown', (event) => {
    if (event.target.closest('#play-stage, #play-drop')) note('begun', event.timeStamp);
  }, true);
  const look = () => {
    const stage = document.querySelector('#play-stage');
    if (times.begun !== undefined && parseFloat(stage.style.getPropertyValue('--x')) > 1) {
      requestAnimationFrame(() => note('picture', performance.now()));
    }
    requestAnimationFrame(look);
  };
  addEventListener('DOMContentLoaded', look);
"""
IDLE_MS = 4000  # after loading, in which a reader sees the page
DRAG_PX = 120
STEPS = 30  # of a drag, 8 ms apart


def opened(page: Page, path: Path) -> None:
    """Open the page, with the ball in sight."""
    page.goto(path.resolve().as_uri())
    page.locator("#play-stage").scroll_into_view_if_needed()
    page.wait_for_timeout(IDLE_MS)


def drag(page: Page) -> dict[str, float]:
    """Drag the ball, and return the times of its sound and its picture [ms]."""
    box = page.locator("#play-ball").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(STEPS):
        page.mouse.move(x + DRAG_PX * (step + 1) / STEPS, y)
        page.wait_for_timeout(8)
    page.wait_for_timeout(2000)
    times = page.evaluate("times")
    page.mouse.up()
    return {name: times[name] - times["begun"] for name in ("sound", "picture") if name in times}


def drop(page: Page) -> dict[str, float]:
    """Press *Drop it* first of all, and return the time of its sound [ms]."""
    button = page.locator("#play-drop")
    if not button.is_visible():
        return {}
    button.click()
    page.wait_for_timeout(3000)
    begun, peaks = page.evaluate("[times.begun, peaks]")
    largest = max((peak for _, peak in peaks), default=0.0)
    if largest == 0.0:
        return {}
    impact = next(time for time, peak in peaks if peak > largest / 3)
    return {"drop": impact - begun}


def main() -> None:
    """Repeat the first touch and the first drop, each in a new page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("page", type=Path)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    flags = [flag for flag in FLAGS if not flag.startswith("--autoplay")]
    found: dict[str, list[float]] = {}
    said = set[str]()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path(), args=flags)
        for _ in range(given.repeats):
            for act in (drag, drop):
                page = browser.new_page(viewport={"width": 1400, "height": 900})
                page.on("console", lambda message: said.add(message.text))
                page.add_init_script(TAP)
                opened(page, given.page)
                for name, milliseconds in act(page).items():
                    found.setdefault(name, []).append(milliseconds)
                page.close()
        browser.close()
    print(f"load of the machine {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores")
    for name, values in found.items():
        print(f"{name}: minimum {min(values):.0f} ms, median {statistics.median(values):.0f} ms")
    for text in sorted(said):
        print(f"console: {text}")


if __name__ == "__main__":
    main()
