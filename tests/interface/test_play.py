"""The instrument of the page: it sounds as its run, obeys hand and keys, and exports."""

from __future__ import annotations

import io
import re
import statistics

import numpy as np
import pytest
import soundfile
from firefox import Firefox, firefox_path
from report_browser import MINUS, until, without_browser
from report_runs import runs_of
from ruamel.yaml import YAML

from rolling.scene import file

LEVEL = "document.querySelector('#play-level').textContent"
SPEED = f"parseFloat(document.querySelector('#play-speed-now').textContent.replace('{MINUS}', '-'))"

OUTPUT = """() => {
  const heard = new Float32Array(tap.analyser.fftSize);
  tap.analyser.getFloatTimeDomainData(heard);
  const square = heard.reduce((sum, value) => sum + value ** 2, 0) / heard.length;
  return [Math.sqrt(square), heard.reduce((top, value) => Math.max(top, Math.abs(value)), 0)];
}"""


@pytest.fixture
def playing(opened, pages):
    """Return a function that opens the page of runs at its instrument, which is ready."""

    def open_instrument(*names: str, **settings):
        return opened(pages(*names), **settings)

    return open_instrument


def set_slider(page, name: str, share: float) -> None:
    page.locator(f"#play-{name}").evaluate(
        "(s, x) => { s.value = x; s.dispatchEvent(new Event('input')); }", share
    )


def roll(page) -> None:
    page.click("#play-roll")
    until(page, f"Number.isFinite(parseFloat({LEVEL}))")


def level(page) -> float:
    """Return the mean of the Fast level over half a second, once it has settled."""
    page.wait_for_timeout(700)
    levels = []
    for _ in range(10):
        levels.append(float(page.evaluate(LEVEL)))
        page.wait_for_timeout(50)
    return statistics.mean(levels)


def keys(page) -> dict:
    return YAML(typ="safe").load(page.text_content("#play-yaml"))


def overrides(page) -> list[str]:
    """Return the assignments of the command that the page names."""
    words = page.text_content("#play-yaml").splitlines()[0]
    return [a or b for a, b in re.findall(r"--set (?:'([^']*)'|(\S+))", words)]


def test_the_ball_sounds_as_its_run_and_a_slider_changes_it(playing) -> None:
    """The level is that of the run within 0.5 dB, and falls with the distance r by 20 lg r.

    The record repeats every 6 ms, so that the Fast level is steady, 0.2 dB off.
    """
    run = runs_of("flying")[0]
    with playing("flying") as page:
        roll(page)
        near = level(page)
        assert near == pytest.approx(run.sound.levels.laeq_db, abs=0.5)
        assert page.evaluate(SPEED) == pytest.approx(0.1, rel=0.02)
        page.locator("#play-distance").evaluate(
            "(s) => { const [low, high] = JSON.parse(document.querySelector('#data').textContent)"
            ".runs[0].live.limits.distance; s.value = Math.log(2 / low) / Math.log(high / low);"
            " s.dispatchEvent(new Event('input')); }"
        )
        far = keys(page)["sound"]["distance_m"]
        assert level(page) == pytest.approx(near - 20 * np.log10(far), abs=0.5)
        page.click("#play-back")
        assert level(page) == pytest.approx(near, abs=0.5)
        page.click("#play-roll")
        until(page, f"Math.abs({SPEED}) < 1e-3")


def test_runs_without_dynamics_take_turns(playing) -> None:
    """Each release has the level of its run within 0.5 dB; another player ends it."""
    runs = runs_of("three")
    with playing("three") as page:
        roll(page)
        assert level(page) == pytest.approx(runs[0].sound.levels.laeq_db, abs=0.5)
        page.check("input[name=play-run][value='2']", force=True)
        assert level(page) == pytest.approx(runs[2].sound.levels.laeq_db, abs=0.5)
        page.click("#play")
        until(page, "document.querySelector('#play-roll').textContent.trim() === 'Roll'")


def test_a_page_without_worklets_says_so(opened, pages) -> None:
    with opened(pages("three")) as page:
        page.evaluate(
            "Object.defineProperty(BaseAudioContext.prototype, 'audioWorklet', { value: null })"
        )
        page.click("#play-roll")
        until(page, "!document.querySelector('#play-note').hidden")
        assert "AudioWorklet" in page.text_content("#play-note")


def test_a_hand_drags_the_ball_which_rolls_on(playing) -> None:
    with playing("flying") as page:
        page.locator("#play-stage").scroll_into_view_if_needed()
        box = page.locator("#play-stage").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        until(page, "/[0-9]/.test(document.querySelector('#play-force-now').textContent)")
        for step in range(40):
            page.mouse.move(x - 6 * step, y)
            page.wait_for_timeout(10)
        page.mouse.up()
        until(page, f"{SPEED} < -0.005")
        assert page.text_content("#play-roll").strip() == "Stop"
        assert keys(page)["rolling"]["speed_m_s"] != 0.1
        page.mouse.click(x, y, delay=600)  # a hand that holds the ball
        until(page, f"Math.abs({SPEED}) < 1e-3")


def test_keys_play_the_ball(playing) -> None:
    with playing("flying") as page:
        page.focus("#play-stage")
        page.keyboard.down("ArrowLeft")
        until(page, f"{SPEED} < -0.09")
        page.keyboard.up("ArrowLeft")
        until(page, f"Math.abs({SPEED}) < 1e-3")
        page.keyboard.press("ArrowUp")
        assert keys(page)["rolling"]["speed_m_s"] > 0.1
        page.keyboard.press("Space")
        until(page, f"{SPEED} > 0.09")
        page.keyboard.press("d")
        until(page, "document.querySelector('#play-flight').textContent.includes('mm high')")
        page.keyboard.press("Home")
        assert keys(page) == {"rolling": {"speed_m_s": 0.1}, "sweep": {}}
        until(page, "document.querySelector('[aria-valuetext*=\"rolls at 0.1 m/s\"]')")
        page.keyboard.press("d")
        set_slider(page, "dropHeight", 0)
        assert keys(page)["rolling"] == {"speed_m_s": 0.1, "drop_mm": None}
        set_slider(page, "speed", 0)  # which a scene refuses
        assert keys(page) is None


@pytest.mark.parametrize("name", ["flying", "edged"])
def test_settings_are_keys_of_the_scene(playing, name: str) -> None:
    """The scene with the keys, and the stored run with the assignments, have the settings."""
    scene = runs_of(name)[0].scene
    with playing(name) as page:
        until(page, "document.querySelectorAll('#play-settings :not([hidden]) > input').length > 3")
        names = page.locator("#play-settings :not([hidden]) > input").evaluate_all(
            "(s) => s.map((x) => x.id)"
        )
        for number, slider in enumerate(names):
            if slider != "play-load":
                set_slider(page, slider.removeprefix("play-"), 0.55 + 0.03 * number)
        given, words = keys(page), overrides(page)
        shown = page.locator("#play-speed").get_attribute("aria-valuetext")
    given.pop("sweep", None)
    flat = {
        f"{part}.{key}": value for part, values in given.items() for key, value in values.items()
    }
    made, heard = scene.with_(flat), file.resound(scene, words)
    assert made.plate == heard.plate and made.sphere == heard.sphere and made.sound == heard.sound
    assert made.rolling.speed_m_s == heard.rolling.speed_m_s == float(shown.split()[0])
    assert made.plate.thickness_mm != scene.plate.thickness_mm


def test_firefox_plays_it_without_a_complaint(pages, tmp_path) -> None:
    if (program := firefox_path()) is None:
        without_browser("no Firefox")
    with Firefox(program, tmp_path) as page:
        page.goto(pages("flying"))
        page.click("#play-roll")
        page.until(f"{SPEED} > 0.09")
        page.until(f"Number.isFinite(parseFloat({LEVEL}))")
        assert page.complaints == []


def test_a_record_is_saved_with_its_full_scale(playing) -> None:
    """60 s at 48 kHz with the peak at -1 dB, and the level of the run within 0.5 dB."""
    run = runs_of("flying")[0]
    with playing("flying") as page:
        page.locator("#play-wav").scroll_into_view_if_needed()
        with page.expect_download() as saved:
            page.click("#play-wav")
        download = saved.value
        full_scale = float(re.search(r"full_scale_([\d.e-]+)_Pa", download.suggested_filename)[1])
        content = download.path().read_bytes()
    samples, rate = soundfile.read(io.BytesIO(content))
    assert rate == 48000 and len(samples) == 60 * rate
    assert 20 * np.log10(np.abs(samples).max()) == pytest.approx(-1, abs=0.01)
    rms = 20 * np.log10(full_scale * np.sqrt(np.mean(np.square(samples))) / 20e-6)
    assert rms == pytest.approx(run.sound.levels.level_db, abs=0.5)
    assert f"full scale = {full_scale:g} Pa" in content[-200:].decode("latin-1")


def test_the_limiter_leaves_quiet_sound_and_holds_the_loudest(playing) -> None:
    """The output has the level of the run within 0.5 dB; 30 dB louder it stays in full scale."""
    run = runs_of("three")[0]
    with playing("three") as page:
        scale, volume = page.evaluate(
            "[JSON.parse(document.querySelector('#data').textContent).runs[0].playback"
            ".calibrated_pa, Number(document.querySelector('#volume').value)]"
        )
        roll(page)
        level(page)
        rms, _ = page.evaluate(OUTPUT)
        assert page.locator("#play-limit").is_hidden()
        quiet = 20 * np.log10(rms / volume * scale / 20e-6)
        assert quiet == pytest.approx(run.sound.levels.level_db, abs=0.5)
        set_slider(page, "volume", 30)
        level(page)
        _, peak = page.evaluate(OUTPUT)
        assert 0.5 < peak / volume < 1 + 1e-6
        assert "limiter lowers" in page.text_content("#play-limit")
