"""The picture of the instrument of the page, as a browser draws it on a light and a dark screen."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from build_cache import ROOT
from drawn_pictures import filled
from picture_parts import PictureScene, Shown, dark_twin, run_folder

STEM = "instrument"
WIDTH_PX = 760
COLOURS = 48
HEIGHT_PX = 1500
PATIENCE_MS = 60_000  # until the instrument is prepared and plays
ROLLING_MS = 1500  # that the ball rolls before the picture is taken
HIDE_WHAT_FLOATS = """() => {
  for (const element of document.querySelectorAll('body *')) {
    if (['fixed', 'sticky'].includes(getComputedStyle(element).position)) {
      element.style.visibility = 'hidden';
    }
  }
}"""
STAGE_AND_SLIDERS = """() => {
  const section = document.querySelector('section.playing').getBoundingClientRect();
  const sliders = document.getElementById('play-settings').getBoundingClientRect();
  const height = sliders.bottom - section.top + 12;
  const { x, y } = { x: section.x + scrollX, y: section.y + scrollY };
  return { x, y, width: section.width, height };
}"""
SECTION = "section.playing"


def make(path: Path, *, entry: Mapping[str, Any], scenes: Mapping[str, PictureScene]) -> Shown:
    """Roll the ball on the page of a run, and take a picture of the instrument."""
    from PIL import Image

    from rolling.commands.run import run_scene
    from rolling.kinds.run_folder import PAGE
    from rolling.results.stored_numbers import read_stored
    from rolling.run.folder import done_runs
    from rolling.scene.identity import scene_identity

    scene = scenes["ball"].read()
    folder = run_folder(f"page-{scene_identity(scene)[:16]}")
    failures = run_scene(scene, folder)
    if failures:
        raise SystemExit(f"{STEM}: {failures}")
    for scheme, file in (("light", path), ("dark", dark_twin(path))):
        content = _screenshot(folder / PAGE, scheme)
        image = Image.open(io.BytesIO(content)).convert("RGB")
        image.quantize(COLOURS).save(file, optimize=True)
    (run,) = done_runs(folder)
    numbers = {"vibration": str(read_stored(run.folder).numbers.vibration.number)}
    caption = filled(entry["caption"], numbers)
    return Shown(numbers, {entry["page"]: [caption]}, caption)


def _screenshot(page: Path, scheme: Any) -> bytes:
    """Return a picture of the instrument of a page in a colour scheme, while the ball rolls."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from playwright.sync_api import expect, sync_playwright
    from report_browser import FLAGS, browser_path

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path(), args=FLAGS)
        size: Any = {"width": WIDTH_PX, "height": HEIGHT_PX}
        view = browser.new_page(viewport=size, color_scheme=scheme)
        view.goto(page.resolve().as_uri())
        view.locator(SECTION).scroll_into_view_if_needed()
        view.locator("#play-roll").click()
        expect(view.locator("#play-level")).to_have_text(re.compile("[0-9]"), timeout=PATIENCE_MS)
        view.wait_for_timeout(ROLLING_MS)
        view.evaluate(HIDE_WHAT_FLOATS)
        content = view.screenshot(clip=view.evaluate(STAGE_AND_SLIDERS), full_page=True)
        browser.close()
    return content
