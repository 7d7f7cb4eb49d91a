"""Make the pictures of README and docs, each with a JSON of the numbers that it shows.

    python docs/_hooks/pictures.py [NAME...]

makes all of them in scenarios/pictures, or those of the names: quickstart (its page and spectrum),
vibrating-ball and python (the table and the example of the README, which are no pictures), choice,
accuracy and gallery. A JSON
has the version of the program, the digests of the scenes, the numbers, and the texts by which pages
state them. tests/test_pictures.py compares these with the pages, and the command prints the texts
that a page lacks. Runs are kept in outputs/pictures, by the sources of the program. Chromium (extra
`dev`) draws the pages. The picture of a step's cost shows times of a machine and is made by
tests/benchmarks/step_cost.py.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import choice_picture
import gallery
from build_cache import ROOT

if TYPE_CHECKING:
    from rolling.numbers.ball_numbers import RunNumbers

PICTURES = ROOT / "scenarios" / "pictures"
OUT = Path("outputs") / "pictures"
GALLERY_SIZE = (1400, 1400)
PAGE_SIZE = (1100, 1290)
COLOURS = 128  # of the picture of a page
COLOURS_OF_CHOICE = 32
SETTLED_MS = 5000  # until scripts have drawn, the spectrogram too
AT_5_N = ["sweep=", "rolling.load_n=5"]
# Variants of `rolling accuracy` that docs/accuracy.md lists, by the beginnings of their names.
VARIANTS = (
    "the scene",
    "spacing 2 µm, sharp edges",
    "spacing 1 µm, blended edges",
    "spacing 1 µm, sharp edges",
    "step 4 µm",
)

Scenes = Mapping[str, Sequence[str]]


class Shown(NamedTuple):
    """What a picture shows.

    numbers : dict. The numbers, as they are printed.
    pages : dict of lists of str. Texts that state them, by the page that must contain them.
    """

    numbers: dict[str, Any]
    pages: dict[str, list[str]]


class Picture(NamedTuple):
    """A picture, or a table of a page, and how it is made.

    name : str. Name of its command.
    stem : str. Name of its files in scenarios/pictures, without an ending.
    make : function of the file of the picture. Writes it, and returns what it shows.
    scenes : dict. The scenes that are run, with their settings; of the choice none, because the
        page has its scene.
    is_drawn : bool. Whether there is a picture beside the JSON.
    """

    name: str
    stem: str
    make: Callable[[Path], Shown]
    scenes: Scenes
    is_drawn: bool = True

    @property
    def digests(self) -> dict[str, str]:
        """The digests of what is computed, by the names of the scenes."""
        sys.path.insert(0, str(ROOT))
        from rolling import read_scene
        from rolling.scene.identity import scene_identity

        if not self.scenes:
            blocks = "\0".join(choice_picture.blocks()).encode()
            page = choice_picture.PAGE.relative_to(ROOT).as_posix()
            return {page: hashlib.sha256(blocks).hexdigest()}
        return {
            name: scene_identity(read_scene(ROOT / "scenarios" / f"{name}.yaml", settings))
            for name, settings in self.scenes.items()
        }


def main(names: list[str]) -> int:
    """Make the pictures of some names, or all; return the exit code."""
    sys.path.insert(0, str(ROOT))
    known = dict.fromkeys(picture.name for picture in ALL)
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no picture: {', '.join(unknown)}, allowed: {', '.join(known)}", file=sys.stderr)
        return 2
    for picture in ALL:
        if names and picture.name not in names:
            continue
        print(f"== {picture.stem}", flush=True)
        stored = write(picture)
        for page, texts in missing(stored["pages"]).items():
            print(f"{page} lacks:", *texts, sep="\n")
    return 0


def write(picture: Picture) -> dict[str, Any]:
    """Make a picture, and write its JSON beside it; return the content of the JSON."""
    from rolling import __version__

    path = PICTURES / f"{picture.stem}.png"
    shown = picture.make(path)
    content = {
        "program": __version__,
        "command": f"python docs/_hooks/pictures.py {picture.name}",
        "picture_sha256": digest_of(path) if picture.is_drawn else None,
        "scenes": picture.digests,
        **shown._asdict(),
    }
    text = json.dumps(content, indent=2, ensure_ascii=False)
    path.with_suffix(".json").write_text(f"{text}\n", encoding="utf-8")
    return content


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def missing(pages: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return the texts that pages lack, by page; the spaces and ends of lines may differ."""
    lacking = {}
    for page, texts in pages.items():
        content = _folded((ROOT / page).read_text(encoding="utf-8"))
        absent = [text for text in texts if _folded(text) not in content]
        if absent:
            lacking[page] = absent
    return lacking


def _folded(text: str) -> str:
    """Return a text with single spaces."""
    return " ".join(text.split())


# ---- runs


def _folder(name: str) -> Path:
    """Return the folder of a run of these sources of the program."""
    from rolling.terminal import program

    return OUT / program.identity().sources[: program.SHOWN] / name


def _run(name: str, scenes: Scenes) -> Path:
    """Run a scene with its settings unless it has run; return its folder."""
    from rolling import read_scene
    from rolling.commands.run import run_scene

    folder = _folder(name)
    failures = run_scene(read_scene(name, scenes[name]), folder)
    if failures:
        raise SystemExit(f"{name}: {failures}")
    return folder


def _answers(folder: Path) -> dict[str, dict[str, str]]:
    """Return the two numbers of each run of a folder as they are printed, by its label."""
    from rolling.results.labels import labels
    from rolling.results.stored_numbers import read_stored
    from rolling.run.folder import done_runs

    runs = done_runs(folder)
    return {
        label: _numbers(read_stored(run.folder).numbers)
        for label, run in zip(labels(runs), runs, strict=True)
    }


def _numbers(numbers: RunNumbers) -> dict[str, str]:
    """Return the two numbers of a run as they are printed."""
    return {
        "vibration": numbers.vibration.number,
        "released power": numbers.released_power.number,
    }


QUICKSTART: Scenes = {"quickstart": []}


def _quickstart_page(path: Path) -> Shown:
    """Draw the page of the quickstart, whose answer docs/getting-started.md shows."""
    from rolling.kinds.run_folder import PAGE
    from rolling.results.run_lines import answer_lines
    from rolling.run.folder import done_runs

    folder = _run("quickstart", QUICKSTART)
    draw(folder / PAGE, path, PAGE_SIZE)
    texts = [line for line in answer_lines(done_runs(folder)) if line]
    lines = [line for text in texts for line in text.splitlines()]
    return Shown(_answers(folder), {"docs/getting-started.md": lines})


def _quickstart_spectrum(path: Path) -> Shown:
    """Store the spectra of the quickstart."""
    folder = _run("quickstart", QUICKSTART)
    shutil.copyfile(folder / "figures" / "spectrum.png", path)
    return Shown(_answers(folder), {})


TABLE: Scenes = {"quickstart": [], "vibrating-ball": []}


def _readme_table(path: Path) -> Shown:
    """Compute the vibration of the ball of the quickstart, which the README tabulates."""
    quickstart = _answers(_run("quickstart", TABLE))
    vibrating = _answers(_run("vibrating-ball", TABLE))
    rows = []
    for label, numbers in vibrating.items():
        load = label.removeprefix("load ")
        rows.append(f"|{load}|{numbers['vibration']}|{quickstart[label]['released power']}|")
    first, *_, last = (_level(numbers["vibration"]) for numbers in vibrating.values())
    *others, heaviest = (f"{_level(numbers['vibration']):.1f}" for numbers in vibrating.values())
    quieter = f"At 100 N the ball is {first - last:.1f} dB quieter than at 5 N"
    computed = f"the vibration of the same ball: {', '.join(others)} and {heaviest} dB(A)"
    pages = {"README.md": [*rows, quieter], "docs/getting-started.md": [computed]}
    return Shown({"quickstart": quickstart, "vibrating-ball": vibrating}, pages)


def _level(number: str) -> float:
    """Return the level of a number such as `14.5 ± 0.6`."""
    return float(number.split()[0])


PYTHON: Scenes = {"quickstart": ["sweep=", "rolling.load_n=20", "rolling.duration_s=0.1"]}


def _readme_example(path: Path) -> Shown:
    """Run the example of the README, which prints the two numbers as the terminal does."""
    from rolling import read_scene, simulate
    from rolling.results.run_lines import answer_lines

    run = simulate(read_scene("quickstart", PYTHON["quickstart"]))
    both = _numbers(run.numbers)
    printed = "\n".join(answer_lines([run]))
    if not all(number in printed for number in both.values()):
        raise SystemExit(f"the terminal prints other numbers than {both}:\n{printed}")
    lines = [
        f"# {run.vibration}",
        f"# {run.released_power}",
        f"run.vibration.value, run.vibration.verdict"
        f"  # {run.vibration.value:.1f}, {run.vibration.verdict!r}",
    ]
    return Shown(both, dict.fromkeys(("README.md", "docs/getting-started.md"), lines))


def _choice(path: Path) -> Shown:
    """Choose between the finishes of docs/which-finish-is-quieter.md, and store the picture."""
    from PIL import Image

    folder = _folder("choice")
    answer = choice_picture.choose(folder)
    drawn = Image.open(folder / choice_picture.RESULT / "choice.png")
    drawn.convert("RGB").quantize(COLOURS_OF_CHOICE).save(path, optimize=True)
    page = choice_picture.PAGE.relative_to(ROOT).as_posix()
    return Shown({"answer": answer.splitlines()}, {page: [answer]})


ACCURACY: Scenes = {"quickstart": AT_5_N}


def _accuracy(path: Path) -> Shown:
    """Draw the work-precision diagram of the quickstart at 5 N, whose errors a page tabulates."""
    import pandas as pd

    from rolling import read_scene
    from rolling.studies.accuracy import run_study

    folder = _folder("accuracy")
    run_study(read_scene("quickstart", ACCURACY["quickstart"]), folder)
    shutil.copyfile(folder / "accuracy.png", path)
    table = pd.read_csv(folder / "accuracy.csv", index_col="variant")
    numbers = {}
    for variant in VARIANTS:
        row = table[table.index.str.startswith(variant)].iloc[0]
        numbers[variant] = f"|{row.error_signal_db:.1f}|{row.error_laeq_db:+.3f}|"
    return Shown(numbers, {"docs/accuracy.md": [*numbers.values()]})


def _gallery(path: Path) -> Shown:
    """Draw the gallery of the scenes on short tracks, which the site plays."""
    site = gallery.site()
    draw(site / "gallery.html", path, GALLERY_SIZE)
    cards = json.loads((site / "cards.json").read_text(encoding="utf-8"))
    numbers = {}
    for of_scene in cards.values():
        for card in of_scene:
            answer = {"vibration": card["vibration"], "released power": card["released"]}
            numbers[card["title"]] = answer
    return Shown(numbers, {})


ALL = (
    Picture("quickstart", "quickstart-report", _quickstart_page, QUICKSTART),
    Picture("quickstart", "quickstart-spectrum", _quickstart_spectrum, QUICKSTART),
    Picture("vibrating-ball", "readme-table", _readme_table, TABLE, is_drawn=False),
    Picture("python", "readme-example", _readme_example, PYTHON, is_drawn=False),
    Picture("choice", "choice", _choice, {}),
    Picture("accuracy", "quickstart-accuracy", _accuracy, ACCURACY),
    Picture("gallery", "gallery", _gallery, gallery.SITE),
)


# ---- pages as pictures


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
