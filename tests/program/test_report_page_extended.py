"""The report page extends records by the algorithm of the program."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import soundfile
from report_browser import RATE, data_of, embedded_record, until

from acoustics.extension import extend, kurtosis


def test_the_browser_extends_as_the_program_does(pages, opened) -> None:
    """The WAV of the page has the samples of `extend`, to the rounding of 16 bits."""
    path = pages("three")
    run = data_of(path)["runs"][0]
    record = embedded_record(path, 0)
    with opened(path, accept_downloads=True) as page:
        page.select_option("#length", "18", force=True)
        page.check("input[name=source][value=extended]")
        until(page, "!document.querySelector('#extension').hidden")
        assert page.text_content("#time").endswith("/ 5.461 s")
        assert page.is_checked("#loop") and not page.locator(".playhead").first.is_visible()
        numbers = page.text_content("#extension-numbers")
        with page.expect_download() as download:
            page.click("#save-extended")
        assert download.value.suggested_filename.startswith("extended-load_0.5_N-full-scale-")
        made, rate = soundfile.read(io.BytesIO(Path(download.value.path()).read_bytes()))
        page.check("input[name=source][value=record]")
        until(page, "document.querySelector('#extension').hidden")
        assert page.text_content("#time").endswith("/ 0.900 s")
    expected = extend(record, 2**18, RATE, run["laps"])
    assert run["laps"] == pytest.approx(150) and rate == RATE and len(made) == 2**18
    scale = made @ expected / (expected @ expected)
    assert np.abs(made - scale * expected).max() < 2**-14
    words = numbers.replace(",", "").split()
    assert float(words[words.index("extended") + 1]) == pytest.approx(kurtosis(made), abs=0.06)


def test_extended_records_play_together_and_never_clip(pages, opened) -> None:
    with opened(pages("one", "braking")) as page:
        page.select_option("#length", "18", force=True)
        page.check("input[name=source][value=extended]")
        until(page, "!document.querySelector('#extension').hidden")
        page.click("#play")
        until(page, "parseFloat(document.querySelector('#seek').value) > 0.05")
        assert (
            page.evaluate(
                "Math.max(...tap.sources.map((s, k) => s.buffer.getChannelData(0)"
                ".reduce((most, x) => Math.max(most, Math.abs(x)), 0) * tap.gains[k].gain.value))"
            )
            <= 10 ** (-1 / 20) + 1e-4
        )
        assert page.evaluate("tap.sources.map((s) => s.buffer.length)") == [2**18, 2**18]
        page.keyboard.press("2")
        assert "one gesture" in page.text_content("#extension-numbers")
        assert page.text_content("#play") == "Pause"
