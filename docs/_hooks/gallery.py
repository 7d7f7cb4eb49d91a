"""Run the scenes that come with the program, and make their gallery.

    python docs/_hooks/gallery.py [--out outputs/gallery] [--workers N] [SCENE...]

Without scenes it runs those of `rolling scenes` whose estimated cost is moderate. A scene that is
done is not run again. The gallery is OUT/gallery.html.

The site runs the scenes that docs/gallery.md lists on shorter tracks, shows their cards with the
parts of the gallery, and links to it, of which `docs/_hooks/pictures.py gallery` draws a picture.
"""

from __future__ import annotations

import argparse
import html
import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from build_cache import ROOT, cached_build, compressed

LEFT_OUT = {
    "vibrating-ball": "it takes as long as the other scenes together; ball-on-plate is like it",
    "round-ball-on-sheet": "it sounds like noise beside the steel sheet",
    "left-end-rule": "it sounds like the quickstart",
    "sharp-edges": "it sounds like the quickstart",
    "sub-node-steps": "it sounds like the quickstart",
    "fixed-gain": "it sounds like the quickstart",
    "loudness": "it sounds like the quickstart",
    "events": "it sounds like the quickstart",
}
# Settings with which the site runs its scenes on short tracks, to be built in minutes.
BRIEF = "sound.listen_s=6"
SITE = {
    "steel-sheet": [BRIEF],
    "ball-with-flat": [BRIEF],
    "marble-dropped": ["rolling.distance_mm=8", "surface.spacing_um=4"],
    "marble-rolling-out": ["rolling.distance_mm=4"],
    "ball-with-pit": ["rolling.distance_mm=25.134", BRIEF],
    "bearing-grades": ["surface.spacing_um=4", BRIEF],
    "damping": [],
    "quickstart": ["sweep=", "rolling.duration_s=0.05", "numerics.error_estimate=false", BRIEF],
    "accelerating": [],
}
# With ROLLING_SHORT_SITE in the environment, as in the tests, these tracks are shorter and coarser
# still, records last a second, one process marches them, and the sheet and the tables are small,
# with few modes. The marble's track lasts until it has landed.
IS_SHORT = bool(os.environ.get("ROLLING_SHORT_SITE"))
SHORTEST = ["sound.listen_s=1", "numerics.error_estimate=false"]
SMALL_TABLE = ["plate.length_mm=300", "plate.width_mm=200", "sound.listener_mm=[150, 100, 500]"]
SHORT = {
    "steel-sheet": [
        "surface.spacing_um=16",
        "sphere.radius_mm=5",
        "rolling.distance_mm=31.408",
        "plate.edges=simply_supported",
        "plate.length_mm=120",
        "plate.width_mm=90",
        "plate.contact_mm=[24, 22]",
        "plate.contact_end_mm=[96, 68]",
        *SHORTEST,
    ],
    "ball-with-flat": [
        "surface.spacing_um=16",
        "sphere.radius_mm=5",
        "rolling.distance_mm=31.408",
        "plate.length_mm=150",
        "plate.width_mm=100",
        "plate.contact_mm=[30, 25]",
        "plate.contact_end_mm=[120, 75]",
        "sound.listener_mm=[75, 50, 500]",
        *SHORTEST,
    ],
    "marble-dropped": [
        "surface.spacing_um=8",
        "plate.contact_mm=[130, 70]",
        *SMALL_TABLE,
        *SHORTEST,
    ],
    "marble-rolling-out": [
        "rolling.distance_mm=1.5",
        "surface.spacing_um=3",
        "plate.contact_mm=[60, 70]",
        "plate.contact_end_mm=[240, 120]",
        *SMALL_TABLE,
        *SHORTEST,
    ],
    "ball-with-pit": ["surface.spacing_um=6", *SHORTEST],
    "bearing-grades": ["surface.spacing_um=8", "rolling.distance_mm=3", *SHORTEST],
    "damping": ["surface.spacing_um=4", *SHORTEST],
    "quickstart": ["rolling.duration_s=0.02", *SHORTEST],
    "accelerating": ["rolling.distance_mm=2", *SHORTEST],
}
CARD = "title", "stem", "vibration", "released", "played", "word", "reason"
COLOURS = {  # of drawings, by those of the theme
    "ground": "var(--md-default-bg-color)",
    "ink": "var(--md-default-fg-color)",
    "pale": "var(--md-default-fg-color--light)",
    "raised": "var(--md-code-bg-color)",
    "accent": "var(--md-typeset-a-color)",
    "notice-line": "#c98a00",
}
ITEM = re.compile(r"^- `([\w-]+)`: (.*)$", re.MULTILINE)
SHOWN = "![Gallery of scenes that come with the program](pictures/gallery.png)"


def main(words: list[str]) -> int:
    """Run the scenes and write the gallery; return the exit code."""
    sys.path.insert(0, str(ROOT))
    from rolling.kinds.registry import name_of_file
    from rolling.scene import library

    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--out", type=Path, default=Path("outputs") / "gallery")
    parser.add_argument("--workers", type=int, default=0)
    given = parser.parse_args(words)
    names = given.scenes
    if not names:
        titles = library.titles()
        names = [x for x, _ in titles if x not in LEFT_OUT and name_of_file(x) == "ball"]
    made(dict.fromkeys(names, ()), given.out, given.workers)
    return 0


def made(scenes: Mapping[str, Sequence[str]], out: Path, workers: int, report: bool = True) -> Path:
    """Run scenes with their settings into folders of their names; return the gallery of them."""
    from rolling import read_scene
    from rolling.commands import run, stored_runs

    for name, settings in scenes.items():
        print(f"== {name}", flush=True)
        scene = read_scene(name, settings)
        run.run_scene(scene, out / name, workers=workers, report=report)
    page = out / stored_runs.GALLERY
    page.unlink(missing_ok=True)
    print(*stored_runs.gallery([out / name for name in scenes], page))
    return page


# ---- the site


def on_files(files, config):
    """Add the players and the gallery of the scenes that the site runs."""
    from mkdocs.structure.files import File

    for path in sorted(site().glob("*.[hm]*")):  # pages and sounds
        files.append(File.generated(config, f"gallery/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Put a card in place of each scene of the gallery, and a link above its picture."""
    if page.file.src_uri != "gallery.md":
        return markdown
    size = (site() / "gallery.html").stat().st_size / 1e6
    text = f"The [gallery of the scenes above](gallery/gallery.html) weighs {size:.1f} MB."
    cards = ITEM.sub(_figures, markdown).replace(SHOWN, f"{text}\n\n{SHOWN}")
    return f"<style>{_look_of_drawings()}</style>\n\n{cards}"


def _look_of_drawings() -> str:
    """Return the rules of drawings on pages, with the colours of the site."""
    from rolling.report.text import asset

    rules = [line for line in asset("report.css").splitlines() if line.startswith(".machine")]
    colours = " ".join(f"--{name}: {colour};" for name, colour in COLOURS.items())
    return "\n".join([f".run {{ {colours} }}", *rules])


def site() -> Path:
    """Return the folder of the scenes that the site runs."""
    settings = json.dumps(_scenes()).encode()
    return cached_build("gallery/site", Path(__file__).read_bytes() + settings, _make_site)


def _scenes() -> dict[str, list[str]]:
    """Return the scenes that the site runs, with their settings."""
    short = SHORT if IS_SHORT else {}
    return {name: [*settings, *short.get(name, ())] for name, settings in SITE.items()}


def _make_site(folder: Path) -> None:
    """Run the scenes of the site, and write sound, drawing and level of each run."""
    from rolling.report import text
    from rolling.report.machine_drawing import drawing_of
    from rolling.results.listening import ListenSound
    from rolling.run.folder import stored_runs
    from rolling.run.solving import open_runs

    made(_scenes(), folder, workers=1 if IS_SHORT else 0, report=False)
    cards: dict[str, list[dict[str, str]]] = {}
    for name in SITE:
        for run in open_runs(stored_runs(folder / name)):
            stem = f"{name}-{len(cards.setdefault(name, [])) + 1}"
            sound = (run.folder / "listen.wav").read_bytes()
            (folder / f"{stem}.mp3").write_bytes(compressed(sound))
            title = text.titles([run])
            if run.values:
                title += f", {run.label}"
            heard = ListenSound(run).stated
            numbers = run.numbers
            judged = numbers.leading.judged
            drawing = drawing_of([run.scene], [numbers], name=stem)
            card = {
                "title": title,
                "stem": stem,
                "vibration": str(numbers.vibration),
                "released": str(numbers.released_power),
                "played": f"The record that plays is the {heard.name}, {heard.level.words}",
                "word": judged.word,
                "reason": judged.worst.text,
                "drawing": "" if drawing is None else drawing.svg,
            }
            cards[name].append(card)
    (folder / "cards.json").write_text(json.dumps(cards), encoding="utf-8")


def _figures(match: re.Match[str]) -> str:
    """Return the card of each run of a scene that the page lists, which says what to listen for."""
    name, text = match.groups()
    cards = json.loads((site() / "cards.json").read_text(encoding="utf-8"))[name]
    return "\n\n".join(_figure(card, html.escape(text), name) for card in cards)


def _figure(card: Mapping[str, str], text: str, scene: str) -> str:
    """Return the parts of the card of a run as HTML: drawing, both levels, player, what to hear."""
    title, stem, vibration, released, played, word, reason = (html.escape(card[x]) for x in CARD)
    return f"""<figure class="run">
<div class="drawing">{card["drawing"]}</div>
<figcaption>
<strong>{title}</strong> <code>{scene}</code>
<p>Vibration: <b>{vibration}</b>. Released power: {released}.</p>
<audio controls preload="none" aria-label="{title}" src="gallery/{stem}.mp3"></audio>
<p>Listen for {text}.</p>
<p>Verdict: {word}, {reason}. {played}.</p>
</figcaption>
</figure>"""


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
