"""The report page holds any name and number of runs, and can be printed; nothing sticks out."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from report_browser import until
from report_runs import run_results

from rolling import commands
from rolling.report import page as report_page
from rolling.report import sweep_page
from rolling.report import text as report_text
from rolling.scene.scene import Scene
from rolling.simulation.run_result import RunResult

LABELS = {
    "markup": "<b>x</b></script><!-- ${d} `c`",
    "quotes": "\"a\" 'b' \\",
    "right to left": "\u05e9\u05dc\u05d5\u05dd 5 N",
    "emoji": "\U0001f3b1\U0001f3c1",
    "one word": "x" * 300,
    "many words": "very long name " * 20,
}
BEYOND = """() => [...document.querySelectorAll('body *')].filter((e) => {
  const { left, right, width } = e.getBoundingClientRect();
  return width && !e.closest('.scroll, .paper, pre, .only-spoken')
    && (right > document.documentElement.clientWidth + 1 || left < -1);
}).map((e) => e.outerHTML.slice(0, 80))"""


@pytest.fixture
def lap(runs) -> RunResult:
    (run,) = run_results(runs.lap())
    return run


def titled(run: RunResult, title: str) -> RunResult:
    scene = run.scene.to_dict() | {"title": title, "description": title}
    return replace(run, scene=Scene.from_dict(scene, run.scene.folder))


@pytest.fixture(scope="module")
def drawn(runs) -> list[report_page.Exhibit]:
    (run,) = run_results(runs.lap())
    return [exhibit for _, exhibit in report_page.exhibits([run])]


def written(folder: Path, runs: list[RunResult], drawn: list[report_page.Exhibit]) -> Path:
    """Write the page of runs that have the same pictures into a folder of a bad name."""
    shelf = [(run, exhibit) for run in runs for exhibit in drawn]
    path = folder / "at #1 with spaces?" / "a page.html"
    path.parent.mkdir()
    path.write_bytes(report_page.page(runs, shelf))
    return path


def test_any_label_and_title_stays_in_its_place(lap, drawn, tmp_path, opened) -> None:
    """Nothing sticks out at 360 px or 1280 px, and no script of a name runs."""
    runs = [titled(replace(lap, label=label), label) for label in LABELS.values()]
    path = written(tmp_path, runs, drawn)
    for width in (360, 1280):
        with opened(path, viewport={"width": width, "height": 800}) as page:
            page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
            assert page.evaluate(BEYOND) == []
            assert page.locator("#choose option").all_text_contents() == [*LABELS.values()]
            assert page.text_content("h1") == ", ".join(LABELS.values())


def test_letters_that_turn_the_text_around_are_written_out(lap) -> None:
    run = titled(lap, "ab\u202egnp.exe\x07")
    assert report_text.titles([run]) == r"ab\u202egnp.exe\x07"


def test_equal_levels_are_not_a_range(lap) -> None:
    said = report_text.sentence([replace(lap, label=f"{k}") for k in range(3)])
    level = lap.summary["laeq_db"]
    assert said == f"LAeq at 1 m is {level:.1f} dB in all 3 runs that sound."


def test_a_hundred_runs_have_a_page(lap, drawn, tmp_path, opened) -> None:
    runs = [replace(lap, label=f"run {k}") for k in range(100)]
    path = tmp_path / "hundred.html"
    path.write_bytes(sweep_page.page(runs, drawn[:1]))
    with opened(path, viewport={"width": 360, "height": 740}) as page:
        assert page.locator("#levels-table tbody tr").count() == 100
        assert page.evaluate(BEYOND) == []
        for box in page.locator(".paper, .scroll").all():  # no script makes them take the focus
            assert box.get_attribute("tabindex") == "0"


def test_levels_that_are_missing_are_gaps(lap, drawn, tmp_path, opened) -> None:
    levels = lap.sound.levels
    none = dict.fromkeys(levels.third_octave_db)
    quiet = replace(lap.sound, levels=replace(levels, third_octave_db=none))
    gaps = replace(
        lap,
        label="gaps",
        sound=quiet,
        summary=lap.summary | {"third_octave_db": none, "third_octave_uncertainty_db": none},
    )
    with opened(written(tmp_path, [lap, gaps], drawn)) as page:
        cells = page.locator("#difference-numbers tbody td").all_text_contents()
        assert cells == ["-"] * 31
        assert not re.search(r"\b(nan|None|undefined|null)\b", page.inner_text("body"))


def test_a_page_needs_no_sound_files(runs, tmp_path, opened) -> None:
    source, copied = runs.lap(), tmp_path / "without"
    copied.mkdir()
    for path in source.iterdir():
        if path.is_file() and path.suffix != ".wav":
            (copied / path.name).write_bytes(path.read_bytes())
    out = tmp_path / "page.html"
    commands.report([copied], out)
    with opened(out) as page:
        assert page.locator("audio").count() == 1


def test_without_scripts_nothing_is_offered_that_needs_them(pages, browser) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(pages("three", "filmed").as_uri())
    for selector in (".needs-js", "#sources", "nav a[href='#compare']"):
        assert not page.locator(f"{selector} >> visible=true").count(), selector
    assert page.locator("nav a[href='#spectra']").is_visible()
    assert "drawn by JavaScript" in page.inner_text("section[aria-labelledby=slow]")
    context.close()


def test_notes_on_the_record_lie_in_a_landmark(pages, opened) -> None:
    with opened(pages("lap")) as page:
        assert page.locator("aside[aria-label] [data-repeats='0']").is_visible()
        assert (
            page.locator("[data-repeats]").count() == page.locator("aside [data-repeats]").count()
        )


def test_dark_pages_print_light(pages, opened) -> None:
    """Drawings have the ink of paper while the page is printed, and of the screen afterwards."""
    ink = """(canvas) => {
      const pen = new OffscreenCanvas(300, 30).getContext('2d', { willReadFrequently: true });
      pen.drawImage(canvas, 0, 0);
      const { data } = pen.getImageData(0, 0, 300, 30);
      let sum = 0, count = 0;
      for (let k = 0; k < data.length; k += 4) {
        if (data[k + 3] > 200) { sum += data[k]; count += 1; }
      }
      return sum / count;
    }"""
    with opened(pages("three"), color_scheme="dark") as page:
        canvas = page.locator("#difference")
        assert canvas.evaluate(ink) > 150
        page.emulate_media(media="print", color_scheme="light")
        until(page, f"({ink})(document.querySelector('#difference')) < 80")
        assert not page.locator("#listen").is_visible()
        page.emulate_media(media="screen", color_scheme="dark")
        until(page, f"({ink})(document.querySelector('#difference')) > 150")


def test_maps_turn_dark_on_the_page_and_stay_light_when_saved(pages, opened) -> None:
    with opened(pages("three"), color_scheme="dark", accept_downloads=True) as page:
        figure = page.locator(".exhibit[data-name=spectrogram]").first
        figure.scroll_into_view_if_needed()
        corner = """async (image) => {
          await image.decode();
          const pen = new OffscreenCanvas(20, 20).getContext('2d');
          pen.drawImage(image, 0, 0);
          return [...pen.getImageData(3, 3, 1, 1).data];
        }"""
        assert max(figure.locator("img").evaluate(corner)[:3]) < 60
        with page.expect_download() as download:
            figure.locator("[data-save=svg]").click()
        saved = Path(download.value.path()).read_bytes()
        assert b"prefers-color-scheme" not in saved and b"</svg>" in saved
        with page.expect_download() as download:
            figure.locator("[data-save=png]").click()
        shown = np.asarray(Image.open(download.value.path()).convert("RGB"))
        assert shown[3, 3].min() > 250


def test_a_picture_that_cannot_be_drawn_is_saved_as_svg(pages, opened) -> None:
    """The PNG needs a picture that the browser draws, the SVG needs its text alone."""
    with opened(pages("one"), accept_downloads=True) as page:
        page.evaluate("() => { Image.prototype.decode = () => Promise.reject('too large'); }")
        figure = page.locator(".exhibit:has([data-file=third_octaves])")
        figure.locator("[data-save=png]").click()
        until(page, "document.querySelector('#said').textContent.includes('take the SVG')")
        assert figure.locator("[data-save=png]").text_content() == "no PNG here"
        with page.expect_download(timeout=5000) as download:
            figure.locator("[data-save=svg]").click()
        assert b"</svg>" in Path(download.value.path()).read_bytes()
