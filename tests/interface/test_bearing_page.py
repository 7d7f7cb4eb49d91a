"""The page of a bearing turns, follows its sliders, and its small model agrees with the program."""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bearing_runs import WAVY, loads_bearing, solved
from firefox import Firefox, firefox_path
from live_engine import node_path
from report_browser import axe_findings, until, without_browser

import rolling
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_motion import move_ring
from rolling.bearing.ring_record import AXIAL, RADIAL, record_of
from rolling.bearing.tracks import BodyTrack, smooth_tracks
from rolling.bearing_kind import bearing_page as pages_of_bearings
from rolling.bearing_kind.bearing_run import BearingRun, numbered
from rolling.report import templates
from rolling.report.report_page import page as page_of

ENGINE = Path(templates.__file__).parent / "assets" / "bearing"
FASTER = """(name) => {
  const slider = document.querySelector(name);
  slider.value = slider.max;
  slider.dispatchEvent(new Event('input'));
}"""
BPFO = """() => {
  const names = [...document.querySelectorAll('#live-spectrum .name')];
  return Number(names.find((text) => text.textContent === 'BPFO').getAttribute('x'));
}"""
IDLE = "document.querySelector('#model').getAttribute('aria-busy') === 'false'"


@pytest.fixture(scope="module")
def run() -> BearingRun:
    return rolling.simulate(loads_bearing(WAVY, ["bearing.radial_load_n=40"]), progress=False)


@pytest.fixture(scope="module")
def page_file(run: BearingRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "bearing.html"
    path.write_bytes(page_of([run]))
    return path


MODEL = f"""
  import {{ readFileSync }} from "node:fs";
  import {{ moveRing }} from "{ENGINE / "model.js"}";
  import {{ bandRms, narrowSpectrum }} from "{ENGINE / "fourier.js"}";
  const {{ bearing, settings, bands }} = JSON.parse(readFileSync(0, "utf-8"));
  const count = 2 ** 15;
  const {{ velocity }} = moveRing(bearing, settings, count);
  const spectra = velocity.map((record) => narrowSpectrum(record));
  const levels = (rms) => bands.map((band) => bandRms(rms, 48000 / count, band));
  console.log(JSON.stringify(spectra.map(levels)));
"""


OIL = "bearing.oil={viscosity_40_mm2_s: 32}"


def rough(seed: int, places: int = 16384) -> BodyTrack:
    """Return a track of waves of random phase up to order 4096, some nanometres high."""
    random = np.random.default_rng(seed)
    orders = np.arange(places // 2 + 1)
    height = np.where((orders > 1) & (orders < 4096), 1 / (1 + orders / 500), 0)
    lines = height * (random.standard_normal((2, len(orders))).T @ [1, 1j])
    return BodyTrack(np.ones(1), 5e-8 * np.fft.irfft(lines, places)[None] * places / 100)


@pytest.mark.law("Bearing page: the small model has the bands of the program.")
@pytest.mark.parametrize(
    "words", [["bearing.angle=fixed"], ["bearing.angle=moving", OIL]], ids=["fixed", "moving"]
)
def test_the_small_model_has_the_bands_of_the_program(words: list[str]) -> None:
    """Tracks are straight between points, which counts where lines stand on the resonance."""
    scene = loads_bearing(WAVY, ["bearing.speed_rpm=2700", "bearing.radial_load_n=40", *words])
    smooth = smooth_tracks(scene.geometry)
    tracks = replace(smooth, inner=rough(1), balls_on_outer=tuple(map(rough, range(2, 10))))
    record = record_of(move_ring(scene.model, tracks, 32768 / 48000), scene.kinematics)
    run = numbered(solved(scene, record, tracks))
    data = pages_of_bearings.data_of(run)
    data["bearing"]["tracks"] = {
        "inner": tracks.inner.approach_m.tolist(),
        "outer": [[0, 0]],
        "ballsOnInner": [[[0, 0]]] * 8,
        "ballsOnOuter": [track.approach_m.tolist() for track in tracks.balls_on_outer],
    }
    data["bands"] = [*VELOCITY_BANDS_HZ.values()]
    arguments = [node_path(), "--input-type=module", "-e", MODEL]
    ended = subprocess.run(arguments, input=json.dumps(data), capture_output=True, text=True)
    assert not ended.returncode, ended.stderr
    x, y, axial = np.array(json.loads(ended.stdout))
    for own, direction in ((np.sqrt((x**2 + y**2) / 2), RADIAL), (axial, AXIAL)):
        wanted = np.array([*record.bands[direction].rms_m_s.values()])
        assert 20 * np.log10(own / wanted) == pytest.approx(0, abs=0.5)
    assert x.min() > 1e-9


def test_scripts_join_without_doubled_names() -> None:
    for entry in ("bearing/begin.js", "bearing/worker.js"):
        script = templates.joined_script(entry)
        names = re.findall(r"^(?:const|let|function|class) (\w+)", script, re.M)
        assert len(names) == len(set(names))
        checked = subprocess.run([node_path(), "--check", "-"], input=script, text=True)
        assert checked.returncode == 0


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_fits_a_phone_and_stays_quiet(page_file: Path, opened, scheme: str) -> None:
    viewport = {"width": 400, "height": 800}
    with opened(page_file, viewport=viewport, color_scheme=scheme) as page:
        until(page, IDLE)
        assert page.evaluate("document.scrollingElement.scrollWidth") <= 400
        words = page.inner_text("body").lower().partition("make it again")[0]
        assert not {"nan", "undefined", "null"} & set(words.split())
        assert "bearing 6204 at 1800 rpm under 70" in words


def test_the_speed_moves_lines_picture_and_numbers(page_file: Path, opened) -> None:
    with opened(page_file) as page:
        until(page, IDLE)
        before = page.evaluate(BPFO)
        levels = page.inner_text("#levels")
        turned = page.locator("#bearing g").nth(1).get_attribute("transform")
        page.evaluate(FASTER, "#rpm")
        assert page.evaluate(BPFO) > before
        until(page, IDLE)
        assert page.inner_text("#levels") != levels
        until(
            page,
            "document.querySelectorAll('#bearing g')[1].getAttribute('transform')"
            f" !== {json.dumps(turned)}",
        )
        page.click("#reset")
        until(page, IDLE)
        assert page.inner_text("#levels") == levels


def test_keys_and_sound(page_file: Path, opened) -> None:
    """The model sounds once it is asked to, and falls silent again."""
    with opened(page_file, reduced_motion="reduce") as page:
        until(page, IDLE)
        assert page.get_attribute("#turn", "aria-pressed") == "false"
        page.focus("#turn")
        page.keyboard.press("Enter")
        assert page.get_attribute("#turn", "aria-pressed") == "true"
        page.focus("#radial")
        page.keyboard.press("ArrowRight")
        assert page.inner_text("#radial-value") != "40.0 N"
        until(page, IDLE)
        page.click("#hear")
        until(page, "tap.starts === 1")
        page.click("#hear")
        assert page.get_attribute("#hear", "aria-pressed") == "false"


def test_a_page_of_two_runs_shows_the_chosen_one(run: BearingRun, tmp_path: Path, opened) -> None:
    slower = loads_bearing(WAVY, ["bearing.speed_rpm=900"])
    other = rolling.simulate(slower, progress=False)
    runs = [replace(run, label="40 N"), replace(other, label="900 rpm")]
    path = tmp_path / "two.html"
    path.write_bytes(page_of(runs, ["70 N"]))
    with opened(path) as page:
        until(page, IDLE)
        assert page.locator(".bars").first.locator("dt").count() == 2
        page.select_option("#choose", "1")
        until(page, IDLE)
        assert page.inner_text("#rpm-value") == "900.0 rpm"
        assert "at 900 rpm" in page.locator(".what >> visible=true").last.inner_text()


@pytest.mark.slow
def test_firefox_turns_and_plays_it_without_a_complaint(page_file: Path, tmp_path: Path) -> None:
    if (program := firefox_path()) is None:
        without_browser("no Firefox")
    with Firefox(program, tmp_path) as page:
        page.goto(page_file)
        page.until(IDLE)
        page.click("#hear")
        page.until("document.querySelector('#hear').getAttribute('aria-pressed') === 'true'")
        page.click("#turn")
        page.click("#hear")
        assert page.complaints == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_is_accessible(page_file: Path, opened, scheme: str) -> None:
    with opened(page_file, color_scheme=scheme) as page:
        until(page, IDLE)
        assert axe_findings(page) == []


def test_names_of_strangers_stay_text(run: BearingRun, tmp_path: Path, opened) -> None:
    """A title that tries to be markup, and a scene file that tries to end its place."""
    hostile = "</script><img src=x onerror=alert(1)>"
    scene = run.scene.with_(title=hostile)
    path = tmp_path / "hostile.html"
    named = replace(run, scene=scene, label=hostile)
    path.write_bytes(page_of([named, replace(named, label="other")]))
    with opened(path) as page:
        until(page, IDLE)
        assert page.inner_text("h1") == hostile
        assert page.locator("img[src=x]").count() == 0
