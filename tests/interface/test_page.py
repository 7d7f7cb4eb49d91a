"""The report page opens in a browser from a file, asks for nothing, and shows each text."""

from __future__ import annotations

import base64
import csv
import io
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from report_browser import (
    PIXELS,
    until,
    without_browser,
)
from report_runs import HOSTILE

from acoustics import plots as sound_plots
from rolling import commands
from rolling.report import page, templates
from rolling.scene import file


@pytest.mark.parametrize(
    "names",
    [
        ("three",),
        ("one",),
        ("smooth",),
        ("partial",),
        ("old",),
        ("lap",),
        ("one", "old"),
        ("one", "fast", "braking"),
    ],
)
def test_opens_quietly_and_fits_a_phone(names, pages, opened) -> None:
    with opened(pages(*names), viewport={"width": 360, "height": 740}) as page:
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 360
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 360
        assert (
            "None" not in page.inner_text("body")
            and "nan" not in page.inner_text("main").lower().split()
        )


def test_three_runs_open_quickly(pages, opened) -> None:
    """The first map is drawn after half a second of processor time, a tenth of the limit.

    Pauses of a busy machine have no part in it.
    """
    with opened(pages("three")) as page:
        until(
            page,
            f"({PIXELS})(document.querySelector('#map'), [[320, 320]])[0].some((part) => part > 0)",
        )
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        metrics = session.send("Performance.getMetrics")["metrics"]
        taken = {each["name"]: each["value"] for each in metrics}
        assert taken["ProcessTime"] < 5


def test_text_of_scenes_stays_text(pages, opened) -> None:
    """A description and a file name that try to be markup stay text.

    The fixture refuses dialogs and requests.
    """
    with opened(pages("one")) as page:
        assert page.text_content(".description") == HOSTILE
        assert page.locator("img[src=x]").count() == 0
        assert "z<i>.npy" in page.text_content("#scene-0") and HOSTILE.split(" ")[
            2
        ] in page.text_content("#scene-0")


def test_downloads_are_what_is_shown_and_the_table_can_be_copied(runs, pages, opened) -> None:
    path = pages("three")
    with opened(path, accept_downloads=True) as page:
        figure = page.locator(".exhibit:has([data-file=third_octaves])")
        saved = {}
        for kind, selector in (
            ("svg", "[data-save=svg]"),
            ("png", "[data-save=png]"),
            ("csv", "a[download]"),
        ):
            with page.expect_download() as download:
                figure.locator(selector).click()
            assert download.value.suggested_filename == f"third_octaves.{kind}"
            saved[kind] = Path(download.value.path()).read_bytes()
        shown = figure.locator("img").get_attribute("src").partition(",")[2]
        assert saved["svg"] == base64.b64decode(shown) and b"<svg" in saved["svg"]
        image = Image.open(io.BytesIO(saved["png"]))
        assert image.size[0] == 1700 and np.ptp(np.asarray(image.convert("L"))) > 200
        first = next(csv.DictReader(io.StringIO(saved["csv"].decode())))
        assert first["run"] == "load 0.5 N" and "level_db" in first
        assert float(first["mid_frequency_hz"]) == pytest.approx(19.95, abs=0.01)
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        page.click("#copy-levels")
        until(page, "document.querySelector('#said').textContent === 'copied'")
        assert page.text_content("#copy-levels") == "Copied"
        copied = page.evaluate("navigator.clipboard.readText()").splitlines()
        assert "upper bound" in "".join(line for line in copied if line.startswith("# "))
        rows = [row.split("\t") for row in copied if not row.startswith("#")]
    assert [row[0] for row in rows] == ["run", "load 0.5 N", "load 1 N", "load 2 N"]
    assert len({len(row) for row in rows}) == 1
    column = rows[0].index("LAeq [dB]")
    for row, one in zip(rows[1:], commands.read_runs(runs.three()), strict=True):
        summary = json.loads((one.folder / "summary.json").read_text())
        assert float(row[column]) == pytest.approx(summary["laeq_db"], abs=1e-3)


def test_caveats_stand_beside_the_headline_and_the_levels(pages, opened) -> None:
    """Every level is read within sight of its caveats, which are escaped like all text."""
    for names in (("three",), ("one", "smooth")):
        with opened(pages(*names), viewport={"width": 360, "height": 740}) as page:
            near = page.text_content("#caveats")
            for words in (
                "an upper bound",
                "q = 1",
                "validated against a microphone",
                "± covers the record's length alone",
            ):
                assert words in near
            assert near in page.text_content("section[aria-labelledby=levels] .note")
            headline, caveats = (
                page.locator(name).bounding_box() for name in (".result", "#caveats")
            )
            assert 0 <= caveats["y"] - headline["y"] - headline["height"] < 40


def test_without_scripts_records_pictures_and_tables_are_there(pages, browser) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(pages("three").as_uri())
    assert page.locator("audio").count() == 3 and page.locator("audio").first.is_visible()
    assert not page.locator("#transport").is_visible()
    assert page.locator(".timeline[data-name=release_power]").count() == 3
    assert page.locator("#levels-table tbody tr").count() == 3
    context.close()


def test_targets_are_large_enough_and_boxes_scroll_by_keyboard(pages, opened) -> None:
    """Buttons, links, boxes and sliders are 24 px high at least; what overflows takes the focus."""
    with opened(pages("three"), viewport={"width": 360, "height": 740}) as page:
        page.evaluate("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
        small = page.evaluate("""() => [...document.querySelectorAll(
          'button, select, summary, .tools a, .single a, input[type=range], label:has(input)')]
          .filter((e) => e.checkVisibility() && e.getBoundingClientRect().height < 24)
          .map((e) => e.outerHTML.slice(0, 80))""")
        assert small == []
        box = page.locator(".paper").first
        assert box.evaluate("b => b.scrollWidth > b.clientWidth")
        box.focus()
        page.keyboard.press("ArrowRight")
        until(page, "document.activeElement.scrollLeft > 0")
    with opened(pages("three")) as page:
        assert page.locator(".paper[tabindex]").count() == 0


def test_tables_of_many_runs_scroll_below_their_heads_and_print_whole(pages, opened) -> None:
    """Three runs, repeated to twelve rows: the box takes the focus, arrows scroll it."""
    with opened(pages("three")) as page:
        box = page.locator(".scroll:has(.players)")
        assert box.get_attribute("tabindex") is None
        page.locator(".players tbody").evaluate(
            """(body) => { for (const row of [...body.rows, ...body.rows, ...body.rows])
            body.append(row.cloneNode(true)); }"""
        )
        until(page, "document.querySelector('.scroll:has(.players)').tabIndex === 0")
        assert box.get_attribute("aria-label") == "scrolls down"
        box.focus()
        page.keyboard.press("ArrowDown")
        until(page, "document.activeElement.scrollTop > 0")
        top = "(e) => e.getBoundingClientRect().top"
        head = page.locator(".players thead th").first.evaluate(top)
        assert head == pytest.approx(box.evaluate(top), abs=1)
        page.emulate_media(media="print")
        assert box.evaluate("(b) => getComputedStyle(b).maxHeight") == "none"
        assert (
            page.locator(".players thead th").nth(1).evaluate("(e) => getComputedStyle(e).position")
            == "static"
        )


def test_a_silent_run_says_so_and_is_not_chosen_first(pages, opened) -> None:
    with opened(pages("smooth", "one")) as page:
        assert page.input_value("#choose") == "1"
        assert "(silent)" in page.text_content("#choose option:first-child")
        page.keyboard.press("1")
        assert page.locator("[data-repeats='0']").is_visible()
        assert "nothing to hear" in page.text_content("[data-repeats='0']")


def test_curves_follow_dark_mode_and_maps_keep_their_colours(pages, opened) -> None:
    filters = "getComputedStyle(document.querySelector('{}')).filter"
    for scheme, dark in (("dark", True), ("light", False)):
        with opened(pages("three"), color_scheme=scheme) as page:
            curves = ".lines .sheet"
            assert ("invert" in page.evaluate(filters.format(curves))) == dark
            maps = "[data-name=spectrogram] .sheet"
            assert page.evaluate(filters.format(maps)) == "none"


def test_on_paper_tables_keep_their_heads_and_controls_go(pages, opened) -> None:
    with opened(pages("three"), viewport={"width": 690, "height": 990}) as page:
        page.emulate_media(media="print")
        assert page.locator("#levels-table thead button").first.is_visible()
        for selector in ("#transport", "nav", ".tools", ".ear", "#film-play"):
            assert not page.locator(f"{selector} >> visible=true").count(), selector
        until(page, "document.scrollingElement.scrollWidth <= 690")


def test_any_title_is_text_in_the_style_sheet() -> None:
    for title in ('"; } body { display: none; } a { b: "', "</style><b>", "größe \\ 音\n"):
        written = templates._css_text(title)
        assert re.fullmatch(r"[0-9A-Za-z\\]*", written)


def test_the_scene_on_the_page_is_the_one_that_was_run(runs, pages, opened) -> None:
    with opened(pages("three")) as page:
        again = file.loads(page.text_content("#scene-0"))
        assert again == file.read_scene(runs.three() / "resolved.yaml")


def test_of_a_browser_that_is_not_there_the_tests_say_what_to_install(monkeypatch) -> None:
    monkeypatch.delenv("ROLLING_BROWSER_REQUIRED", raising=False)
    with pytest.raises(pytest.skip.Exception, match="chromium"):
        without_browser("no browser")
    monkeypatch.setenv("ROLLING_BROWSER_REQUIRED", "1")
    with pytest.raises(pytest.fail.Exception, match="chromium"):
        without_browser("no browser")


class _Drawn(SimpleNamespace):
    def plot_area(self) -> tuple[float, float, float, float]:
        return 0.1, 0.1, 0.9, 0.9


@pytest.mark.parametrize("power", range(-16, 8))
def test_the_time_axis_of_a_record_is_read_whatever_its_length(power: int) -> None:
    duration = 3 * 10.0**power
    figure = Figure()
    sound_plots.power(figure.subplots(), duration * np.arange(4) / 4, np.ones(4), 1.0, duration)
    axis = page._time_axis(_Drawn(figure=figure))
    assert axis.end == pytest.approx(duration, rel=1e-9) and axis.begin == 0
