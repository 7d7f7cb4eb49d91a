"""The report page works in Firefox as well; without the browser the test is skipped."""

from __future__ import annotations

import firefox
import pytest
from report_browser import data_of


@pytest.mark.browser
def test_firefox_shows_plays_extends_and_compares(pages, tmp_path) -> None:
    executable = firefox.path()
    # Chromium shows the page in all other tests of it. Firefox is the second browser, which few
    # machines have, so its absence is no failure even where a browser is required.
    if executable is None:
        pytest.skip("no Firefox: install Debian's `firefox-esr`")
    path = pages("three", "filmed")
    with firefox.session(executable, tmp_path / "profile") as page:
        page.open(path)
        assert page.evaluate("document.title").endswith("contact noise")
        assert page.evaluate("document.querySelectorAll('audio').length") == 4
        # A single record plays.
        page.evaluate("document.querySelector('audio').play()")
        page.until("document.querySelector('audio').currentTime > 0.1")
        # The player. Its clock stands still in Firefox on a machine without a sound card.
        for text in ("Pause", "Play"):
            page.evaluate("document.querySelector('#play').click()")
            page.until(f"document.querySelector('#play').textContent === '{text}'")
        # The film: another map is another picture.
        page.evaluate("document.querySelector('input[name=run][value=\"3\"]').click()")
        picture = "document.querySelector('#film').toDataURL()"
        before = page.evaluate(picture)
        page.evaluate(
            "(() => { const s = document.querySelector('#film-seek');"
            " s.value = 3; s.dispatchEvent(new Event('input')); })()"
        )
        assert page.evaluate(picture) != before
        assert page.evaluate("Number(document.querySelector('#film-seek').max)") == (
            len(data_of(path)["runs"][3]["film"]["times"]) - 1
        )
        # Extended records, and the comparison.
        page.evaluate("document.querySelector('input[value=extended]').click()")
        page.until("document.querySelector('#extension').hidden === false")
        assert page.evaluate("document.querySelector('#time').textContent").endswith("/ 10.923 s")
        rows = "document.querySelectorAll('#difference-numbers tbody tr').length"
        assert page.evaluate(rows) == 31
        assert page.errors == []
