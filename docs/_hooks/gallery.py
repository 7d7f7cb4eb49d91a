"""Run the scenes that come with the program, and make their gallery and its picture.

    python docs/_hooks/gallery.py [--out outputs/gallery] [--workers N] [SCENE...]

Without scenes it runs those of `rolling scenes` whose estimated cost is moderate. A scene that is
done is not run again. The gallery is OUT/gallery.html. Chromium (extra `dev`) draws its picture
into scenarios/pictures, and with the quickstart also the pictures of its page and spectrum.
"""

from __future__ import annotations

import argparse
import io
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURES = ROOT / "scenarios" / "pictures"
LEFT_OUT = {
    "vibrating-ball": "it takes as long as the other scenes together; ball-on-plate is like it",
    "left-end-rule": "it sounds like the quickstart",
    "sharp-edges": "it sounds like the quickstart",
    "sub-node-steps": "it sounds like the quickstart",
    "fixed-gain": "it sounds like the quickstart",
    "loudness": "it sounds like the quickstart",
    "events": "it sounds like the quickstart",
}
GALLERY_SIZE, PAGE_SIZE = (1400, 1400), (1100, 1520)
COLOURS = 128  # of a picture
SETTLED_MS = 1500  # until scripts have drawn


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
    print(*commands.gallery([given.out / name for name in names], page))
    draw(page, PICTURES / "gallery.png", GALLERY_SIZE)
    if "quickstart" in names:
        quickstart = given.out / "quickstart"
        draw(quickstart / commands.PAGE, PICTURES / "quickstart-report.png", PAGE_SIZE)
        spectrum = quickstart / "figures" / "spectrum.png"
        shutil.copyfile(spectrum, PICTURES / "quickstart-spectrum.png")
    return 0


def draw(page: Path, picture: Path, size: tuple[int, int]) -> None:
    """Draw the beginning of a page as a small PNG of a size [px]."""
    sys.path.insert(0, str(ROOT / "tests" / "support"))
    from PIL import Image
    from playwright.sync_api import sync_playwright
    from report_browser import FLAGS, browser_path

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path(), args=FLAGS)
        view = browser.new_page(viewport={"width": size[0], "height": size[1]})
        view.goto(page.resolve().as_uri())
        view.evaluate(
            "document.querySelectorAll('img').forEach((image) => { image.loading = 'eager'; })"
        )
        view.wait_for_load_state("networkidle")
        view.wait_for_timeout(SETTLED_MS)
        content = view.screenshot()
        browser.close()
    Image.open(io.BytesIO(content)).convert("RGB").quantize(COLOURS).save(picture, optimize=True)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
