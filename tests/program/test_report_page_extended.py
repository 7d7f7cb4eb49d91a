"""The report page extends records by the algorithm of the program."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from report_browser import RATE, data_of, embedded_record, hear, until
from report_runs import run_results

from acoustics.extension import extend, kurtosis
from rolling.report import page as report_page
from rolling.scene.surfaces import Gaussian


@pytest.fixture
def seeds(runs, tmp_path, monkeypatch) -> Path:
    """Return the page of a run under three seeds, whose sound is the same."""
    made = []
    for seed in (1, 2, 3):
        (run,) = run_results(runs.one())
        surface = Gaussian(
            kind="gaussian",
            roughness_ra_um=0.1,
            correlation_length_um=10,
            spacing_um=2,
            width_um=200,
            seed=seed,
        )
        scene = run.scene.model_copy(update={"surface": surface})
        made.append(replace(run, scene=scene, values={"surface.seed": seed}, label=f"seed {seed}"))
    monkeypatch.setattr(report_page, "_surfaces", lambda views: [])
    monkeypatch.setattr(report_page.report_text, "recipes", lambda runs: [])
    monkeypatch.setattr(report_page.assumed, "surface_words", lambda scene: "random")
    path = tmp_path / "seeds.html"
    shelf = [(run, _picture(name)) for run in made for name in report_page.TIMELINES]
    path.write_bytes(report_page.page(made, shelf))
    return path


def _picture(name: str) -> report_page.Exhibit:
    axis = report_page.TimeAxis(10.0, 90.0, 10.0, 90.0, 0.0, 0.9)
    return report_page.Exhibit(name, name, "data:image/svg+xml,<svg/>", None, False, axis, (8, 6))


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


def test_a_single_run_can_be_extended_too(pages, opened) -> None:
    with opened(pages("one")) as page:
        page.check("input[name=source][value=extended]")
        until(page, "!document.querySelector('#extension').hidden")
        assert page.text_content("#time").endswith("/ 10.923 s")


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


def test_seeds_play_in_a_row_and_blend_without_a_step(seeds, opened) -> None:
    """The row holds each record, is shorter by the blends, and is as loud as the records."""
    records = [embedded_record(seeds, k) for k in range(3)]
    gains = [run["playback"]["calibrated"] for run in data_of(seeds)["runs"]]
    with opened(seeds) as page:
        page.check("input[name=source][value=row]")
        until(page, "!document.querySelector('#row').hidden")
        page.click("#play")
        until(page, "tap.sources.length === 1")
        row = np.array(page.evaluate("[...tap.sources[0].buffer.getChannelData(0)]"))
        assert len(row) == sum(len(record) - 2400 for record in records)
        middle = slice(2400, len(records[1]) - 2400)
        begin = len(records[0]) - 2400
        inside = row[begin + middle.start : begin + middle.stop]
        assert np.abs(inside - gains[1] * records[1][middle]).max() < 1e-3
        powers = [
            np.mean((gain * record) ** 2) for gain, record in zip(gains, records, strict=True)
        ]
        assert np.mean(row**2) == pytest.approx(np.mean(powers), rel=0.1)
        slider = "(s) => { s.value = 1.2; s.dispatchEvent(new Event('input')); }"
        page.click("#play")
        page.locator("#seek").evaluate(slider)
        assert page.text_content("#row-run") == "now: seed 2"


def test_a_blind_test_leaves_the_row_and_the_row_ends_the_test(seeds, opened) -> None:
    """In a row A, B and X would sound the same, so the row and the test exclude each other."""
    heard = "tap.gains.slice(-3).map((node) => node.gain.value > 0.01)"
    with opened(seeds) as page:
        page.check("input[name=source][value=row]")
        until(page, "!document.querySelector('#row').hidden")
        page.click("#play")
        until(page, "tap.sources.length === 1")
        page.click("#abx-begin")
        until(page, "tap.sources.length === 4")
        assert page.is_checked("input[name=source][value=record]")
        assert not page.locator("#row").is_visible()
        page.click("[data-abx=a]")
        hear(page)
        assert page.evaluate(heard) == [True, False, False]
        page.click("[data-abx=b]")
        hear(page)
        assert page.evaluate(heard) == [False, False, True]
        page.check("input[name=source][value=row]")
        until(page, "!document.querySelector('#row').hidden")
        assert page.is_disabled("[data-abx=x]") and page.text_content("#abx-result") == ""


def test_runs_of_other_loads_have_no_row(pages, opened) -> None:
    with opened(pages("three")) as page:
        assert page.locator("input[value=row]").count() == 0
