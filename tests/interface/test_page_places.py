"""A patch of the track is heard by a click or a key on the chart of the sound by place."""

from __future__ import annotations

import pytest
from report_browser import data_of, hear, play, until
from report_runs import runs_of

CHART = "figure[data-name=places] .plot > svg"

SOUNDS = """(() => {
  const block = new Float32Array(2048);
  tap.analyser.getFloatTimeDomainData(block);
  return block.some((x) => x !== 0);
})()"""


def test_the_patches_of_the_page_have_the_times_of_the_run(pages) -> None:
    (run,) = runs_of("fast")
    places = run.sound_by_place
    assert places is not None
    (chart,) = [chart for chart in data_of(pages("fast"))["charts"] if chart["name"] == "places"]
    assert len(chart["patches"]) == len(places.position)
    for patch, begin in zip(chart["patches"], places.first_s, strict=True):
        assert patch["begin"] == pytest.approx(begin, abs=1e-6)
        seconds = (patch["to"] - patch["from"]) * 1e-6 / 0.2  # at 0.2 m/s
        assert patch["end"] - patch["begin"] == pytest.approx(seconds, rel=1e-2)


@pytest.mark.slow
def test_a_click_and_a_key_play_a_patch_and_the_player_rests(pages, opened) -> None:
    with opened(pages("fast")) as page:
        play(page)
        hear(page)
        starts = page.evaluate("tap.starts")
        chart = page.locator(CHART)
        chart.scroll_into_view_if_needed()
        box = chart.bounding_box()
        page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"])
        until(page, f"tap.starts > {starts}")
        assert "patch at" in page.text_content("#said")
        assert page.text_content("#play").strip() == "Play"  # the player has stopped
        until(page, SOUNDS)  # between silences
        before = page.text_content("#said")
        chart.focus()
        page.keyboard.press("Home")
        page.keyboard.press("Enter")
        until(page, f"tap.starts > {starts + 1}")
        until(page, f"document.querySelector('#said').textContent !== {before!r}")
        page.click("#play")
        until(page, "document.querySelector('#play').textContent.trim() === 'Pause'")
