"""The page opens in two browsers from a file, fits small screens and paper, and compares runs."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from firefox import Firefox, firefox_path
from report_browser import MINUS, axe_findings, hear, until, without_browser
from report_runs import HOSTILE, runs_of

from rolling.report.report_page import page as page_of
from rolling.scene.scene import Scene

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
  return width && !e.closest('.scroll, .plot, pre, .only-spoken')
    && (right > document.documentElement.clientWidth + 1 || left < -1);
}).map((e) => e.outerHTML.slice(0, 80))"""
OPEN_ALL = "document.querySelectorAll('details').forEach((d) => { d.open = true; })"
PHONE = {"width": 360, "height": 740}


DESK = {"width": 1400, "height": 900}
SMALL = {"width": 390, "height": 844}
FIRST = ("h1", ".answers b", ".lead", "#play")


# ---- any run, any screen


@pytest.mark.parametrize(
    "names", ["three", "one", "smooth", "one fast braking lap", "flying filmed seeds"]
)
def test_it_opens_quietly_and_fits_a_phone(names: str, pages, opened) -> None:
    with opened(pages(*names.split()), viewport=PHONE) as page:
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 360
        page.evaluate(OPEN_ALL)
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 360
        words = page.inner_text("body").lower()
        assert not {"none", "nan", "undefined", "null"} & set(
            words[: words.rindex("make it again\n")]
        )


@pytest.mark.parametrize("viewport", [DESK, SMALL], ids=["desk", "phone"])
def test_the_first_view_holds_both_numbers_what_follows_and_play(viewport, pages, opened) -> None:
    """One Play is in sight, at any place of the page; its bar comes when the large one has gone."""
    with opened(pages("three"), viewport=viewport) as page:
        for selector in FIRST:
            shown = page.locator(f"header {selector} >> visible=true").all()
            assert shown, selector
            for box in shown:
                place = box.bounding_box()
                assert place["y"] >= 0 and place["y"] + place["height"] <= viewport["height"]
        page.locator(".hero figure[data-name=levels] .frame").wait_for(state="attached")
        assert page.locator(".hero figure[data-name=levels] .plot .errors").count() == 2
        for place in (0, 3000, 0):
            page.evaluate(f"window.scrollTo(0, {place})")
            until(page, f"document.documentElement.matches('.beyond') === {str(place > 0).lower()}")
            buttons = page.locator("[data-play=played] >> visible=true").all()
            inside = [b for b in buttons if 0 <= b.bounding_box()["y"] < viewport["height"]]
            assert len(inside) == 1


def test_the_first_view_of_one_run_shows_its_contact(pages, opened) -> None:
    with opened(pages("one"), viewport=DESK) as page:
        shades = page.locator("#still").evaluate(
            "(c) => new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size"
        )
        assert shades > 20


def test_a_row_of_the_numbers_chooses_its_run(pages, opened) -> None:
    with opened(pages("three")) as page:
        rows = page.locator(".answers tbody tr")
        for number, run in enumerate(runs_of("three")):
            rows.nth(number).locator("td b").last.click(force=True)  # a label covers the row
            assert page.input_value("#choose") == str(number)
            shown = rows.nth(number).inner_text()
            for quantity in (run.vibration, run.released_power):
                assert f"{quantity.value:.1f}" in shown and quantity.verdict in shown


@pytest.mark.parametrize("names", ["three", "flying"])
def test_axe_finds_nothing_on_any_screen(names: str, pages, opened) -> None:
    with opened(pages(names)) as page:
        page.evaluate(OPEN_ALL)
        for viewport, scheme in ((DESK, "light"), (SMALL, "dark")):
            page.set_viewport_size(viewport)
            page.emulate_media(color_scheme=scheme)
            assert axe_findings(page) == [], (viewport, scheme)


def test_axe_finds_nothing_where_several_records_are_saved(pages, opened) -> None:
    """Long records and passes have buttons beside those of the solved records of both sounds."""
    with opened(pages("long", "memory")) as page:
        for number in range(2):
            page.keyboard.press(str(number + 1))
            assert page.locator(".saves button:visible").count() == (4, 3)[number]
            assert axe_findings(page, ".saves:not([hidden])") == []


@pytest.mark.slow
def test_firefox_opens_and_plays_it_without_a_complaint(pages, tmp_path) -> None:
    if (program := firefox_path()) is None:
        without_browser("no Firefox")
    with Firefox(program, tmp_path) as page:
        page.goto(pages("three"))
        page.click("#play")
        page.until("parseFloat(document.querySelector('#seek').value) > 0.1")
        page.press("3")
        assert page.evaluate("document.querySelector('#choose').value") == "2"
        page.click("#play")
        assert page.evaluate("document.querySelector('#play').textContent.trim()") == "Play"
        assert page.complaints == []


def test_text_of_scenes_stays_text(pages, opened) -> None:
    """A description and a file name that try to be markup stay text."""
    with opened(pages("one")) as page:
        assert page.text_content(".description") == HOSTILE
        assert page.locator("img[src=x]").count() == 0
        assert "z<i>.npy" in page.text_content("#scene-0")


def test_any_label_and_title_stays_in_its_place(tmp_path, opened) -> None:
    """Nothing sticks out at 360 px or 1280 px, and no script of a name runs."""
    (lap,), runs = runs_of("lap"), []
    for label in LABELS.values():
        text = lap.scene.to_dict() | {"title": label, "description": label}
        runs.append(replace(lap, label=label, scene=Scene.from_dict(text, lap.scene.folder)))
    path = tmp_path / "at #1 with spaces?" / "a page.html"
    path.parent.mkdir()
    path.write_bytes(page_of(runs))
    for width in (360, 1280):
        with opened(path, viewport={"width": width, "height": 800}) as page:
            page.evaluate(OPEN_ALL)
            assert page.evaluate(BEYOND) == []
            assert page.locator("#choose option").all_text_contents() == [*LABELS.values()]
            assert page.text_content("h1") == ", ".join(LABELS.values())


def test_a_hundred_runs_fit_a_phone_and_scroll_by_keyboard(tmp_path, opened) -> None:
    (lap,) = runs_of("lap")
    path = tmp_path / "hundred.html"
    path.write_bytes(page_of([replace(lap, label=f"run {k}") for k in range(100)]))
    with opened(path, viewport=PHONE) as page:
        assert page.locator(".answers tbody tr").count() == 100
        assert page.evaluate(BEYOND) == []
        for box in page.locator(".scroll").all():  # no script makes them take the focus
            assert box.get_attribute("tabindex") == "0"


def test_the_levels_are_explained_one_choice_from_the_first_view(pages, opened) -> None:
    with opened(pages("three")) as page:
        assert "upper bound" in page.inner_text("header").lower()
        page.locator(".meanings summary").click()
        near = page.inner_text("header")
        for words in ("upper bound", "q = 1", "estimated", "LAeq"):
            assert words in near
        assert "validated against a microphone" in page.text_content("#notes")


def test_without_scripts_records_pictures_and_tables_are_there(pages, browser) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(pages("three").as_uri())
    assert (
        page.locator("audio[controls]").count() == 6
        and page.locator(".answers b").first.is_visible()
    )
    for selector in ("#transport", ".needs-js"):
        assert not page.locator(f"{selector} >> visible=true").count(), selector
    assert page.locator(".timeline[data-name=release_power]").count() == 3
    assert page.locator(".answers tbody tr").count() == 3
    assert page.locator("#levels-table thead th").count() == 4
    context.close()


def test_targets_fit_fingers_and_tables_are_cards(pages, opened) -> None:
    """On a phone buttons, links, boxes and sliders are 44 px high, and tables are cards."""
    with opened(pages("three"), viewport=PHONE, has_touch=True, is_mobile=True) as page:
        page.evaluate(OPEN_ALL)
        small = page.evaluate("""() => [...document.querySelectorAll(
          'button, select, summary, nav a, .verdict, input[type=range], label:has(input)')]
          .filter((e) => e.checkVisibility() && e.getBoundingClientRect().height < 43.5)
          .map((e) => e.outerHTML.slice(0, 80))""")
        assert small == []
        box = page.locator("#levels-table").locator("..")
        assert box.evaluate("(box) => box.scrollWidth <= box.clientWidth")  # of cards
        for link in page.locator("nav a").all():
            assert page.locator(link.get_attribute("href")).count() == 1


def test_text_has_16_px_at_least(pages, opened) -> None:
    """Axes of charts and of the picture of the record have smaller numbers."""
    small = """() => {
      const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
      while (walker.nextNode()) {
        const { parentElement: box, textContent: text } = walker.currentNode;
        if (!text.trim() || !box.checkVisibility()) continue;
        if (box.closest("svg, #heard, .only-spoken")) continue;
        if (parseFloat(getComputedStyle(box).fontSize) < 16) found.push(box.outerHTML.slice(0, 80));
      }
      return found;
    }"""
    for viewport in (DESK, SMALL):
        with opened(pages("three"), viewport=viewport) as page:
            page.evaluate(OPEN_ALL)
            assert page.evaluate(small) == []


def test_folded_parts_open_by_keyboard_and_are_printed(pages, opened) -> None:
    with opened(pages("three")) as page:
        folds = page.locator("details.fold")
        assert folds.count() > 5
        folds.first.locator("summary").focus()
        page.keyboard.press("Enter")
        assert folds.first.evaluate("(fold) => fold.open")
        page.keyboard.press("Space")
        assert not folds.first.evaluate("(fold) => fold.open")
        assert not page.locator("#levels-table").is_visible()
        page.emulate_media(media="print")
        assert page.locator("#levels-table").is_visible()


def test_dark_pages_have_light_ink_and_print_dark_without_controls(pages, opened) -> None:
    """Charts have light ink on a dark screen, dark ink on paper, and no controls there."""
    ink = """(() => {
      const label = document.querySelector("#difference .label");
      return Number(getComputedStyle(label).fill.match(/\\d+/)[0]);
    })()"""
    viewport = {"width": 690, "height": 990}
    with opened(pages("three"), color_scheme="dark", viewport=viewport) as page:
        page.evaluate(OPEN_ALL)
        page.locator("#difference").scroll_into_view_if_needed()
        until(page, "document.querySelector('#difference .label')")
        assert page.evaluate(ink) > 200
        page.emulate_media(media="print", color_scheme="light")
        assert page.evaluate(ink) < 60
        for selector in ("#transport", "nav", ".tools", ".ear", "#play", ".playing"):
            assert not page.locator(f"{selector} >> visible=true").count(), selector
        until(page, "document.scrollingElement.scrollWidth <= 690")


# ---- two runs compared


def test_a_blind_test_counts_and_states_the_chance(pages, opened) -> None:
    """X is the run whose gain is open; three right answers come by chance in an eighth of tests."""

    def heard_run(page) -> int:
        page.click("[data-abx=x]")
        until(page, "tap.gains.length > 0 && tap.gains.some((node) => node.gain.value > 0)")
        hear(page)
        gains = page.evaluate("tap.gains.slice(-3).map((node) => node.gain.value)")
        assert sum(gain > 0 for gain in gains) == 1
        return int(np.argmax(gains))

    with opened(pages("three")) as page:
        page.evaluate(OPEN_ALL)
        assert page.locator("[data-abx]").first.is_disabled()
        page.click("#abx-begin")
        assert page.is_checked("#equal")  # else the level alone would tell
        shown = page.input_value("#choose")
        for trial in range(1, 4):
            page.click("[data-abx=is-a]" if heard_run(page) == 0 else "[data-abx=is-b]")
            pressed = page.locator("[data-abx][aria-pressed=true]").all_text_contents()
            assert pressed == ["Hear X"]
            result = page.text_content("#abx-result")
            assert result.startswith(f"Right. {trial} of {trial} right")
        assert "in 13 % of tests" in result  # 1/8, with two digits
        page.click("[data-abx=is-b]" if heard_run(page) == 0 else "[data-abx=is-a]")
        result = page.text_content("#abx-result")
        chance = 100 * sum(math.comb(4, k) for k in (3, 4)) / 16
        assert result.startswith("Wrong. 3 of 4 right") and f"in {chance:.0f} % of tests" in result
        # Nothing on the page tells which run is heard, and a choice of a run ends the test.
        assert page.input_value("#choose") == shown
        page.keyboard.press("2")
        assert page.input_value("#choose") == "1" and page.text_content("#abx-result") == ""
        page.select_option("#compare-b", "0")
        page.click("#abx-begin")
        assert "same run" in page.text_content("#abx-result")


def test_the_difference_of_two_spectra_has_its_uncertainty(pages, opened) -> None:
    first, _, last = (run.numbers.bands.released_power for run in runs_of("three"))
    with opened(pages("three")) as page:
        page.evaluate(OPEN_ALL)
        figure = page.locator("#difference")
        figure.locator("svg").first.focus()
        until(page, "document.querySelector('#difference .bar')")
        page.keyboard.press("Home")
        for band, level in first.by_name.items():
            other = last.by_name[band]
            if level is None or other is None:
                continue
            spreads = [bands.uncertainty_by_name[band] for bands in (first, last)]
            read = figure.locator(".reading").inner_text().replace(MINUS, "-")
            row = re.fullmatch(r"([\d.]+ k?Hz)\nB - A\n(.+) ± (.+) dB", read)
            page.keyboard.press("ArrowRight")
            name = f"{float(band) / 1000:g} kHz" if float(band) >= 1000 else f"{band} Hz"
            assert row and row[1] == name
            assert float(row[2]) == pytest.approx(other - level, abs=0.051)
            assert float(row[3]) == pytest.approx(math.hypot(*spreads), abs=0.051)
        page.select_option("#compare-b", "0")
        flat = "[...document.querySelectorAll('#difference .bar')]"
        until(page, f"{flat}.every((bar) => bar.height.baseVal.value < 0.01)")


def test_a_silent_run_is_named_and_not_chosen_first(pages, opened) -> None:
    with opened(pages("smooth", "one")) as page:
        assert page.input_value("#choose") == "1"
        assert "(silent)" in page.text_content("#choose option:first-child")
        page.keyboard.press("1")
        assert page.locator("aside [data-only='0']").is_visible()
        assert "does not fluctuate within hearing" in page.text_content("aside [data-only='0']")


def test_many_runs_share_one_place_for_their_pictures(pages, opened) -> None:
    """Each kind of picture of a single run of six is there once, and is that of the chosen run."""
    with opened(pages("seeds")) as page:
        shown = "[...document.querySelectorAll('figure[data-run]')].filter(f => f.offsetParent)"
        names = page.evaluate(f"{shown}.map(f => f.dataset.name)")
        assert len(names) == len(set(names)) > 1
        page.keyboard.press("5")
        assert set(page.evaluate(f"{shown}.map(f => f.dataset.run)")) == {"4"}
        until(page, f"{shown}.every(f => f.plot.svg.childElementCount || f.offsetTop > 2000)")
