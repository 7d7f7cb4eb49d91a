"""The maps and playheads of the report page follow the time that it plays, and keys control it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from report_browser import (
    PIXELS,
    data_of,
    hear,
    map_of,
    play,
    seek,
    time_of,
    until,
)
from report_runs import run_results

from rolling import commands
from rolling.contact import closed_forms
from rolling.figures import run_figures
from rolling.report import pressure_maps
from rolling.simulation import result_file


def expected_map(folder: Path, seconds: float) -> int:
    """Return the nearest kept position on the closed lap at 0.1 m/s."""
    result = result_file.load(folder / "result.h5")
    lap = result.solved_steps * result.step
    places = np.array(sorted(result.maps)) * result.step
    away = np.abs(places - 0.1 * seconds % lap)
    return int(np.argmin(np.minimum(away, lap - away)))


def hertz(one: commands.Run) -> float:
    return closed_forms.hertz_radius(one.scene.load, one.scene.radius, one.scene.contact_modulus)


def test_map_follows_the_playhead_and_shows_the_stored_pressure(runs, pages, opened) -> None:
    path = pages("three")
    view = data_of(path)["view"]
    one = commands.read_runs(runs.three())[1]
    result = result_file.load(one.folder / "result.h5")
    maps = [result.maps[position] for position in sorted(result.maps)]
    palette = pressure_maps.palette()
    middle = 49.5 * 2e-6
    with opened(path) as page:
        page.check("input[name=run][value='1']")
        canvas, drawn = page.locator("#map"), set()
        for seconds in (0.0, 0.00141, 0.00333, 0.0051, 0.00599, 0.4444, 0.8765):
            seek(page, seconds)
            number = map_of(page)
            assert number == expected_map(one.folder, seconds), seconds
            assert float(page.text_content("#map-position").split()[0]) == pytest.approx(
                maps[number].distance * 1e3
            )
            pressure = float(page.text_content("#map-pressure").split()[0])
            assert pressure == pytest.approx(maps[number].pressure.max() * 1e-9, rel=1e-3)
            each = maps[number]
            width = canvas.evaluate("c => c.width")
            per_m = width / (2e-6 * view["half_um"])
            cells, places = [], []
            for i, j in np.argwhere(each.pressure > 0)[::20]:
                x = width / 2 + (each.along + (i + 0.5) * each.cell - each.distance) * per_m
                y = width / 2 - (each.across + (j + 0.5) * each.cell - middle) * per_m
                # not under the dashed circle
                if abs(np.hypot(x - width / 2, y - width / 2) - hertz(one) * per_m) > 4:
                    cells.append((i, j))
                    places.append((x, y))
            assert len(cells) > 5
            for (i, j), pixel in zip(cells, canvas.evaluate(PIXELS, places), strict=True):
                shade = 1 + round(254 * float(each.pressure[i, j]) / 2.1e9)
                assert pixel == palette[shade].tolist(), (seconds, i, j)
            drawn.add(canvas.evaluate("c => c.toDataURL()"))
        assert len(drawn) >= 6


def test_maps_move_while_it_plays_unless_motion_is_not_wanted(runs, pages, opened) -> None:
    for wish, few in (("no-preference", False), ("reduce", True)):
        with opened(pages("three"), reduced_motion=wish) as page:
            page.evaluate("""() => {
              window.drawn = new Set();
              const fill = CanvasRenderingContext2D.prototype.fillRect;
              CanvasRenderingContext2D.prototype.fillRect = function (...place) {
                if (this.canvas.id === 'map') drawn.add(tap.now);
                return fill.call(this, ...place);
              };
            }""")
            play(page)
            page.evaluate("drawn.clear()")
            if few:
                hear(page, 0.8)
                assert page.evaluate("drawn.size") == 0
            else:
                until(page, "drawn.size >= 3")
                drawn = page.evaluate("[...drawn]")
                # A map stays for 0.4 s, long enough to be seen.
                assert np.diff(drawn).min() >= 400
            page.click("#play")  # paused: the map of where it stands
            until(page, "document.querySelector('#play').textContent === 'Play'")
            folder = commands.read_runs(runs.three())[0].folder
            assert map_of(page) == expected_map(folder, float(page.input_value("#seek")))


@pytest.mark.parametrize("name", ["release_power", "spectrogram"])
def test_playheads_stand_where_the_plot_has_that_time(name, runs, pages, opened) -> None:
    """The line stands within a pixel of its place by matplotlib's own transform of the axes."""
    results = run_results(runs.three())
    picture = next((p for p in run_figures.of_run(results[0], results) if p.name == name), None)
    assert picture is not None, f"no picture {name} of {results[0].label}"
    picture.svg()
    axes, (width, _) = picture.figure.axes[0], picture.figure.get_size_inches() * picture.figure.dpi
    unit = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}[re.search(r"\[(.*?)\]", axes.get_xlabel())[1]]
    with opened(pages("three")) as page:
        line = f".timeline[data-name={name}][data-run='0']"
        for seconds in (0.05, 0.3, 0.85):
            seek(page, seconds)
            box = page.locator(f"{line} img").bounding_box()
            stands = page.locator(f"{line} .playhead").bounding_box()
            expected = (
                box["x"] + box["width"] * axes.transData.transform((seconds / unit, 0))[0] / width
            )
            assert stands["x"] == pytest.approx(expected, abs=1.5)
            low, high = (axes.get_position().y0, axes.get_position().y1)
            assert stands["y"] == pytest.approx(box["y"] + (1 - high) * box["height"], abs=1.5)
            assert stands["height"] == pytest.approx((high - low) * box["height"], abs=1.5)
        expected = axes.transData.transform((0.6 / unit, 0))[0] / width
        box = page.locator(f"{line} img").bounding_box()
        page.locator(f"{line} img").click(
            position={"x": box["width"] * expected, "y": box["height"] / 2}
        )
        # in seconds; a click is on a whole one
        pixel = 0.9 / (axes.get_position().width * box["width"])
        assert time_of(page) == pytest.approx(0.6, abs=1.5 * pixel)


def test_a_partial_run_is_marked_and_shows_its_part(runs, pages, opened) -> None:
    with opened(pages("partial")) as page:
        assert "Partial" in page.text_content(".notice")
        # 200 of 300 steps: the maps at positions 0, 2.5, 5, ... up to 200.
        kept = sum(
            position <= 200 for position in result_file.load(runs.partial() / "result.h5").maps
        )
        assert page.text_content("#map-number") == f"map 1 of {kept}"
        seek(page, 0.0039)
        assert map_of(page) >= kept - 3
        assert not page.is_checked("#loop")


def test_alike_runs_are_told_apart_and_old_ones_say_they_have_no_maps(pages, opened) -> None:
    with opened(pages("old")) as page:
        assert page.locator("#map").count() == 0
        assert "No pressure maps are kept" in page.inner_text("main")
    with opened(pages("one", "old")) as page:
        labels = page.locator("#choose option").all_text_contents()
        assert labels == ["load 1 N (one)", "load 1 N (old)"]
        page.check("input[name=run][value='1']")
        assert page.text_content("#map-number") == "no maps kept"


def test_records_of_other_lengths_go_round_or_fall_silent(pages, opened) -> None:
    """Runs of 0.9 s, 0.45 s and a braking run that does not loop keep their own times."""
    with opened(pages("one", "fast", "braking")) as page:
        assert "differ in length" in page.inner_text("main")
        assert not page.is_checked("#loop")
        seconds = [one["seconds"] for one in data_of(pages("one", "fast", "braking"))["runs"]]
        assert seconds[:2] == [0.9, 0.45] and seconds[2] < 0.9
        times = []
        for k in range(3):
            page.check(f"input[name=run][value='{k}']")
            seek(page, 0.7)
            times.append(float(page.text_content("#map-time").split()[0]))
        assert times == pytest.approx([0.7, 0.25, min(0.7, seconds[2])], abs=1e-3)


def test_keys_do_what_the_page_says(pages, opened) -> None:
    with opened(pages("three")) as page:
        press = page.keyboard.press
        press("Space")
        until(page, "parseFloat(document.querySelector('#seek').value) > 0.02")
        assert page.text_content("#play") == "Pause"
        press("Space")
        assert page.text_content("#play") == "Play"
        press("Home")
        assert time_of(page) == 0
        press("ArrowRight")
        press("ArrowRight")
        assert time_of(page) == pytest.approx(0.09)
        press("ArrowLeft")
        assert time_of(page) == pytest.approx(0.045)
        press("3")
        assert page.is_checked("input[name=run][value='2']") and page.input_value("#choose") == "2"
        press("9")  # there is none
        assert page.input_value("#choose") == "2"
        press("g")
        assert page.is_checked("input[name=mode][value=equal]")
        assert page.text_content("#said") == "equal LAeq"
        press("l")
        assert not page.is_checked("#loop")
        press("?")
        assert page.locator(".keys").evaluate("d => d.open")
        page.locator("#map").focus()
        before = map_of(page)
        press("ArrowRight")
        assert map_of(page) == (before + 1) % 120
        press("ArrowLeft")
        assert map_of(page) == before
        # A focused control keeps its own keys.
        page.locator("#choose").focus()
        press("1")
        press("Home")
        assert time_of(page) > 0
        page.locator("#copy-levels").focus()
        press("Space")
        assert page.text_content("#play") == "Play"
