"""The slow motion of a vibrating ball shows its height, its contact force and its flights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_browser import data_of, until
from report_runs import run_results
from test_slow_motion import LUMINANCE, flashes

from rolling.report import film_motion
from rolling.simulation import slow_march


def test_runs_that_share_a_march_show_the_place_of_the_largest_force(runs, monkeypatch) -> None:
    slow, fast = run_results(runs.flying())
    assert slow.result.slow_motion is not None and fast.result.slow_motion is not None
    assert np.array_equal(slow.result.slow_motion.positions, fast.result.slow_motion.positions)
    assert fast.vibration is not None
    motion = fast.vibration.motion
    place = motion.position_m[np.argmax(np.abs(motion.force_n / 0.3 - 1))]
    event = slow_march.event_of([slow.scene, fast.scene], fast.result)
    assert event is not None and event.speed == 1
    assert event.position * fast.result.step == pytest.approx(place, abs=fast.result.step)
    monkeypatch.setattr(slow_march, "SHARE", 0.3)
    part = slow_march.stretch([slow.scene, fast.scene], fast.result)
    assert part is not None
    assert part.first <= min(event.position, part.last) and part.first == (
        fast.result.slow_motion.first
    )
    # Heard by their release, both speeds have the event of the release.
    released = [run.scene.with_(source="release") for run in (slow, fast)]
    own = slow_march.event_of(released, fast.result)
    assert own is not None and own.speed == 1
    assert own.position == slow_march.event_of(released[:1], fast.result).position


def test_the_curves_are_the_motion_of_the_run(runs) -> None:
    _, fast = run_results(runs.flying())
    assert fast.vibration is not None
    motion = fast.vibration.motion
    begin, end = motion.time_s[40] + 1e-9, motion.time_s[400]
    shown = film_motion.motion_between(fast, begin, end)
    assert shown is not None and shown.load_n == 0.3
    times = shown.begin + shown.step * np.arange(len(shown.force_n))
    assert times[0] <= begin and times[-1] >= end - shown.step
    nearest = np.rint(times / motion.time_step_s - 0.5).astype(int)
    assert shown.force_n == pytest.approx(motion.force_n[nearest], rel=1e-3)
    height = motion.displacement_m.mean() - motion.displacement_m[nearest]
    assert shown.height_nm == pytest.approx(1e9 * height, rel=1e-3, abs=0.1)
    # The flights are the times without force, rounded to a nanosecond, and there are some.
    ns = 1e-9
    assert shown.flights and all(begin - ns < a < b < end + ns for a, b in shown.flights)
    within = (motion.time_s >= begin) & (motion.time_s <= end)
    flown = sum(b - a for a, b in shown.flights)
    share = float(np.mean(motion.force_n[within] == 0))
    assert flown / (end - begin) == pytest.approx(share, abs=0.01)


def test_a_ball_that_flies_all_the_time_is_shown(runs) -> None:
    _, fast = run_results(runs.flying())
    assert fast.vibration is not None
    still = replace(fast.vibration.motion, force_n=np.zeros_like(fast.vibration.motion.force_n))
    flying = replace(fast, vibration=replace(fast.vibration, motion=still))
    shown = film_motion.motion_between(flying, 1e-4, 3e-4)
    assert shown is not None and shown.flights == [(1e-4, 3e-4)]


def test_many_steps_are_thinned_but_no_flight_is_lost(runs, monkeypatch) -> None:
    _, fast = run_results(runs.flying())
    whole = film_motion.motion_between(fast, 0.0, 6e-4)
    monkeypatch.setattr(film_motion, "MOST", 50)
    thin = film_motion.motion_between(fast, 0.0, 6e-4)
    assert whole is not None and thin is not None
    assert len(thin.force_n) <= 50 < len(whole.force_n)
    assert thin.flights == whole.flights


def test_the_page_marks_flights_and_has_no_curves_without_dynamics(pages, opened) -> None:
    path = pages("flying", "filmed")
    slow, fast, filmed = (run["film"] for run in data_of(path)["runs"])
    assert filmed["motion"] is None and slow["motion"]["flights"] == []
    flights = fast["motion"]["flights"]
    with opened(path) as page:
        seek = "(n) => { const s = document.querySelector('#film-seek'); s.value = n;"
        seek += " s.dispatchEvent(new Event('input')); }"
        label = page.locator("#film-motion")
        page.check("input[name=run][value='1']")
        # It opens where the ball presses hardest.
        assert "presses with" in label.get_attribute("aria-label")
        until(page, "tap.images.every((image) => image.complete)")
        picture = "document.querySelector('#film').toDataURL()"
        for number, time in enumerate(fast["times"]):
            page.evaluate(seek, number)
            flies = any(begin <= time <= end for begin, end in flights)
            assert ("and flies" in label.get_attribute("aria-label")) == flies
            assert ("and flies" in page.get_attribute("#film-seek", "aria-valuetext")) == flies
        shown = page.evaluate(LUMINANCE)
        assert (flashes(np.array(shown["frames"])) > 3).mean() * shown["pixels"] < 21824
        before = page.evaluate(picture)
        page.check("input[name=run][value='2']")
        assert not label.is_visible() and not page.locator("#film-motion-note").is_visible()
        until(page, f"{picture} !== '{before}'")


@pytest.mark.parametrize("limit_px", [21824, 0])
def test_a_large_map_does_not_flash_with_short_flights(limit_px, pages, opened, tmp_path) -> None:
    """However short the flights on the screen, a small map is left out and a large one stays."""
    text = pages("flying", "filmed").read_text()
    for old, new in (
        ("const FLASHING_PX = 21824", f"const FLASHING_PX = {limit_px}"),
        ("const FLASH_S = 1 / 3", "const FLASH_S = 1e9"),
        ('<option value="2000">', '<option value="20000">'),  # the film takes a second and a half
    ):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "page.html"
    path.write_text(text)
    film = data_of(path)["runs"][1]["film"]
    flown = [
        k
        for k, time in enumerate(film["times"])
        if any(begin <= time <= end for begin, end in film["motion"]["flights"])
    ]
    with opened(path) as page:
        page.evaluate("""() => {
          window.flights = 0;
          const write = CanvasRenderingContext2D.prototype.fillText;
          CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
            if (text.startsWith('the ball flies: nothing') && this.canvas.id === 'film') flights++;
            return write.call(this, text, ...place);
          };
        }""")
        page.check("input[name=run][value='1']")
        page.select_option("#film-rate", "20000")
        page.locator("#film-seek").evaluate(
            "(s) => { s.value = 0; s.dispatchEvent(new Event('input')); flights = 0; }"
        )
        # A clock that passes every map, however long the page waits for its next frame.
        tick = 20000 * min(np.diff(film["times"])) / 2
        page.evaluate(
            """(tick) => {
              let now = 0;
              const step = () => { now += tick; requestAnimationFrame(step); };
              step();
              Object.defineProperty(BaseAudioContext.prototype, 'currentTime', { get: () => now });
            }""",
            tick,
        )
        page.click("#film-play")
        until(page, f"Number(document.querySelector('#film-seek').value) > {flown[0] + 3}")
        assert (page.evaluate("flights") > 0) == (limit_px > 0)


def test_pages_without_dynamics_say_nothing_of_flights(pages) -> None:
    text = pages("filmed").read_text()
    assert 'id="film-motion"' not in text and "largest. It plays once" in text
