"""Pictures that the program draws by its own commands: pages of runs, tables of the README."""

from __future__ import annotations

import io
import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import choice_picture
import gallery
from build_cache import ROOT
from picture_parts import Picture, Shown, run_folder, scenes_of

if TYPE_CHECKING:
    from rolling.numbers.ball_numbers import RunNumbers

Scenes = Mapping[str, Sequence[str]]

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


def _run(name: str, scenes: Scenes) -> Path:
    """Run a scene with its settings unless it has run; return its folder."""
    from rolling import read_scene
    from rolling.commands.run import run_scene

    folder = run_folder(name)
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
    """Run the example of Getting started, which prints the two numbers as the terminal does."""
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
    return Shown(both, {"docs/getting-started.md": lines})


def _choice(path: Path) -> Shown:
    """Choose between the finishes of docs/which-finish-is-quieter.md, and store the picture."""
    from PIL import Image

    folder = run_folder("choice")
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

    folder = run_folder("accuracy")
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


PAGE_PICTURES = (
    Picture("quickstart", "quickstart-report", _quickstart_page, scenes_of(QUICKSTART)),
    Picture("quickstart", "quickstart-spectrum", _quickstart_spectrum, scenes_of(QUICKSTART)),
    Picture("vibrating-ball", "readme-table", _readme_table, scenes_of(TABLE), ending=""),
    Picture("python", "readme-example", _readme_example, scenes_of(PYTHON), ending=""),
    Picture("choice", "choice", _choice, {}, choice_picture.PAGE.relative_to(ROOT).as_posix()),
    Picture("accuracy", "quickstart-accuracy", _accuracy, scenes_of(ACCURACY)),
    Picture("gallery", "gallery", _gallery, scenes_of(gallery.SITE)),
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
