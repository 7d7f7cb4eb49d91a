"""Run the scenes that come with the program, and make their gallery and its picture.

    python docs/_hooks/gallery.py [--out outputs/gallery] [--workers N] [SCENE...]

Without scenes it runs those of `rolling scenes` whose estimated cost is moderate. A scene that is
done is not run again. The gallery is OUT/gallery.html; its picture, for the docs, is
scenarios/pictures/gallery.png, which needs Chromium and the extra `dev`.
"""

from __future__ import annotations

import argparse
import io
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "scenarios" / "pictures" / "gallery.png"
LEFT_OUT = {
    "vibrating-ball": "it takes as long as the other scenes together; ball-on-plate is like it",
    "left-end-rule": "it sounds like the quickstart",
    "sharp-edges": "it sounds like the quickstart",
    "sub-node-steps": "it sounds like the quickstart",
    "fixed-gain": "it sounds like the quickstart",
    "loudness": "it sounds like the quickstart",
    "events": "it sounds like the quickstart",
}
SIZE = {"width": 1400, "height": 1400}
COLOURS = 128  # of the picture


def main(words: list[str]) -> int:
    """Run the scenes and write the gallery with its picture; return the exit code."""
    sys.path.insert(0, str(ROOT))
    from rolling import commands
    from rolling.scene import library

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--out", type=Path, default=Path("outputs") / "gallery")
    parser.add_argument("--workers", type=int, default=0)
    given = parser.parse_args(words)
    files = library.scenes()
    names = given.scenes or [name for name, _ in library.titles() if name not in LEFT_OUT]
    for name in names:
        print(f"== {name}", flush=True)
        commands.run_scene(files[name], out=given.out / name, workers=given.workers)
    page = given.out / commands.GALLERY
    page.unlink(missing_ok=True)
    print(commands.gallery([given.out / name for name in names], page))
    draw(page)
    return 0


def draw(page: Path) -> None:
    """Draw the first rows of a gallery as a small PNG."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from PIL import Image
    from playwright.sync_api import sync_playwright
    from report_browser import FLAGS, browser_path

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path(), args=FLAGS)
        view = browser.new_page(viewport=SIZE)
        view.goto(page.resolve().as_uri())
        view.evaluate(
            "document.querySelectorAll('img').forEach((image) => { image.loading = 'eager'; })"
        )
        view.wait_for_load_state("networkidle")
        content = view.screenshot()
        browser.close()
    Image.open(io.BytesIO(content)).convert("RGB").quantize(COLOURS).save(PICTURE, optimize=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
