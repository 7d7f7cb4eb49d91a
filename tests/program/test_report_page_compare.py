"""The report page compares two runs: blind by ear, in their spectra, and in tables that sort."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from report_browser import MINUS, hear, until

from rolling import commands


def test_a_blind_test_counts_and_says_what_chance_gives(pages, opened) -> None:
    """X is the run whose gain is open; three right answers come by chance in an eighth of tests."""
    with opened(pages("three")) as page:
        assert page.locator("[data-abx]").first.is_disabled()
        page.click("#abx-begin")
        shown = page.input_value("#choose")
        seen = set()
        for trial in range(1, 4):
            page.click("[data-abx=x]")
            until(page, "tap.gains.length > 0 && tap.gains.some((node) => node.gain.value > 0)")
            hear(page)
            gains = page.evaluate("tap.gains.slice(-3).map((node) => node.gain.value)")
            x = int(np.argmax(gains))
            assert x in (0, 2) and sum(gain > 0 for gain in gains) == 1
            seen.add(x)
            page.click("[data-abx=is-a]" if x == 0 else "[data-abx=is-b]")
            result = page.text_content("#abx-result")
            assert result.startswith(f"Right. {trial} of {trial} right")
        assert "in 13 % of tests" in result  # 1/8, with two digits
        page.click("[data-abx=x]")
        hear(page)
        gains = page.evaluate("tap.gains.slice(-3).map((node) => node.gain.value)")
        page.click("[data-abx=is-b]" if int(np.argmax(gains)) == 0 else "[data-abx=is-a]")
        result = page.text_content("#abx-result")
        assert result.startswith("Wrong. 3 of 4 right")
        assert f"in {100 * sum(math.comb(4, k) for k in (3, 4)) / 16:.0f} % of tests" in result
        # Nothing on the page tells which run is heard, and a choice of a run ends the test.
        assert page.input_value("#choose") == shown
        page.keyboard.press("n")
        assert page.input_value("#choose") == "1" and page.text_content("#abx-result") == ""
        page.keyboard.press("p")
        page.keyboard.press("p")
        assert page.input_value("#choose") == "2"


def test_the_difference_of_two_spectra_has_its_uncertainty(runs, pages, opened) -> None:
    first, _, last = (
        json.loads((run.folder / "summary.json").read_text())
        for run in commands.read_runs(runs.three())
    )
    with opened(pages("three")) as page:
        rows = page.locator("#difference-numbers tbody tr").all_text_contents()
        written = dict(zip(first["third_octave_db"], rows, strict=True))
        for band, text in written.items():
            levels = [each["third_octave_db"][band] for each in (first, last)]
            if None in levels:
                assert text == f"{band}-"
                continue
            spread = math.hypot(
                *(each["third_octave_uncertainty_db"][band] for each in (first, last))
            )
            value, _, plus_minus = text.removeprefix(band).replace(MINUS, "-").partition(" ± ")
            assert float(value) == pytest.approx(levels[1] - levels[0], abs=0.051)
            assert float(plus_minus) == pytest.approx(spread, abs=0.051)
        page.select_option("#compare-b", "0")
        rows = page.locator("#difference-numbers tbody td").all_text_contents()
        assert {row.partition(" ")[0] for row in rows} <= {"0.0", "-"}
        assert "load 0.5 N less those of load 0.5 N" in page.get_attribute(
            "#difference", "aria-label"
        )


def test_tables_of_several_runs_sort(pages, opened) -> None:
    with opened(pages("smooth", "three")) as page:
        laeq = page.locator("#levels-table th:has-text('LAeq [dB]') button").first
        laeq.click()
        column = "#levels-table tbody tr td:nth-child(3)"
        up = page.locator(column).all_text_contents()
        levels = [float(text.split()[0]) for text in up[:-1]]
        assert levels == sorted(levels) and len(levels) == 3 and up[-1] == "silent"
        laeq.click()
        down = page.locator(column).all_text_contents()
        assert down == [*up[2::-1], "silent"]
        head = page.locator("#levels-table th[aria-sort]")
        assert head.count() == 1 and head.get_attribute("aria-sort") == "descending"


def test_contents_lead_to_sections(pages, opened) -> None:
    with opened(pages("three")) as page:
        for link in page.locator("nav a").all():
            assert page.locator(link.get_attribute("href")).count() == 1
        assert page.locator("nav a").count() == page.locator("main h2").count()
