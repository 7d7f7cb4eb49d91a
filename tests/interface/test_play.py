"""The instrument of the page: it sounds as its run, obeys hand and keys, and exports."""

from __future__ import annotations

import io
import re
import statistics
from dataclasses import replace

import live_engine
import numpy as np
import pytest
import soundfile
from firefox import Firefox, firefox_path
from report_browser import MINUS, data_of, hear, until, without_browser
from report_runs import folder, runs_of, solved
from ruamel.yaml import YAML

from acoustics import level as sound_level
from rolling.dynamics import drop
from rolling.in_si.physics_of_scene import bodies_of
from rolling.report.live import USUAL_RESISTANCE, needs_of_a_new_run
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

LEVEL = "document.querySelector('#play-level').textContent"
SPEED = f"parseFloat(document.querySelector('#play-speed-now').textContent.replace('{MINUS}', '-'))"

OUTPUT = """() => {
  const heard = new Float32Array(tap.analyser.fftSize);
  tap.analyser.getFloatTimeDomainData(heard);
  const square = heard.reduce((sum, value) => sum + value ** 2, 0) / heard.length;
  return [Math.sqrt(square), heard.reduce((top, value) => Math.max(top, Math.abs(value)), 0)];
}"""


def slow(*names: str) -> list:
    """Return parameters whose tests take more than a few seconds."""
    return [pytest.param(name, marks=pytest.mark.slow) for name in names]


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
    """Return the mean of the Fast level over half a second of sound, once it has settled."""
    hear(page, 0.7)
    levels = []
    for _ in range(10):
        levels.append(float(page.evaluate(LEVEL)))
        hear(page, 0.05)
    return statistics.mean(levels)


def keys(page) -> dict:
    return YAML(typ="safe").load(page.text_content("#play-yaml"))


def made(copied: dict) -> Scene:
    """Return the scene of a copied text beside the height file of the runs."""
    return Scene.from_dict(copied, folder())


def overrides(page) -> list[str]:
    """Return the assignments of the command that the page names."""
    words = page.text_content("#play-yaml").splitlines()[0]
    return [a or b for a, b in re.findall(r"--set (?:'([^']*)'|(\S+))", words)]


def test_the_ball_sounds_as_its_run_and_a_slider_changes_it(playing) -> None:
    """The level is that of the record within 0.5 dB, and falls with the distance r by 20 lg r.

    The record repeats every 6 ms, so that the Fast level is steady, 0.2 dB off.
    """
    run = runs_of("flying")[0]
    with playing("flying") as page:
        roll(page)
        near = level(page)
        assert near == pytest.approx(run.record_laeq_db, abs=0.5)
        assert page.evaluate(SPEED) == pytest.approx(0.1, rel=0.02)
        page.locator("#play-distance").evaluate(
            "(s) => { const [low, high] = JSON.parse(document.querySelector('#data').textContent)"
            ".runs[0].live.limits.distance; s.value = Math.log(2 / low) / Math.log(high / low);"
            " s.dispatchEvent(new Event('input')); }"
        )
        far = keys(page)["sound"]["distance_m"]  # of an infinite plate
        assert level(page) == pytest.approx(near - 20 * np.log10(far), abs=0.5)
        page.click("#play-back")
        assert level(page) == pytest.approx(near, abs=0.5)
        page.click("#play-roll")
        until(page, f"Math.abs({SPEED}) < 1e-3")


@pytest.mark.slow
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
        page.add_init_script(
            "Object.defineProperty(BaseAudioContext.prototype, 'audioWorklet', { value: null })"
        )
        page.reload()  # because an idle page prepares its instrument at once
        page.click("#play-roll")
        until(page, "!document.querySelector('#play-note').hidden")
        assert "AudioWorklet" in page.text_content("#play-note")


def test_a_hand_drags_the_ball_which_rolls_on(playing) -> None:
    with playing("flying") as page:
        page.locator("#play-stage").scroll_into_view_if_needed()
        box = page.locator("#play-stage").bounding_box()
        x = box["x"] + box["width"] / 2
        y = box["y"] + box["height"] / 2
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
        assert keys(page)["rolling"]["speed_m_s"] == 0.1
        until(page, "document.querySelector('[aria-valuetext*=\"rolls at 0.1 m/s\"]')")
        page.keyboard.press("d")
        set_slider(page, "dropHeight", 0)
        rolling = keys(page)["rolling"]  # without a fall
        assert rolling["speed_m_s"] == 0.1 and "drop_mm" not in rolling
        set_slider(page, "speed", 0)  # which a scene refuses
        assert keys(page) is None


@pytest.mark.parametrize("name", ["flying", *slow("edged", "placed")])
def test_settings_make_a_whole_scene(playing, name: str) -> None:
    """The copied scene, and the stored run with the assignments, have the settings.

    The scene is that of the run but for its name, its settings, and its length, which is a distance
    so that its track and its surface stay the same at every speed.
    """
    scene = runs_of(name)[0].scene
    with playing(name) as page:
        until(page, "document.querySelectorAll('#play-settings :not([hidden]) > input').length > 3")
        unchanged = made(keys(page))
        names = page.locator("#play-settings :not([hidden]) > input").evaluate_all(
            "(s) => s.map((x) => x.id)"
        )
        for number, slider in enumerate(names):
            if slider != "play-load":
                set_slider(page, slider.removeprefix("play-"), 0.55 + 0.03 * number)
        copied = made(keys(page))
        words = overrides(page)
        shown = page.locator("#play-speed").get_attribute("aria-valuetext")
    assert unchanged.sound == scene.sound and unchanged.track == scene.track
    heard = file.resound(scene, words)
    assert copied.plate == heard.plate and copied.sphere == heard.sphere
    assert copied.sound == heard.sound and copied.surface == scene.surface
    assert copied.rolling.speed_m_s == heard.rolling.speed_m_s == float(shown.split()[0])
    assert copied.plate.thickness_mm != scene.plate.thickness_mm
    assert copied.track == scene.track


@pytest.mark.parametrize("name", ["three", *slow("braking", "placed")])
def test_a_copied_scene_sounds_as_it_was_played(playing, pages, name: str) -> None:
    """A run of the copied scene has the level of the engine within 0.5 dB.

    The engine plays at a constant speed, the highest of the run.
    """
    data = data_of(pages(name))["runs"][0]["live"]
    settings = dict(data["settings"])
    with playing(name) as page:
        set_slider(page, "distance", 0.3)
        if data["kind"] == "vibration":
            set_slider(page, "thickness", 0.6)
        copied = solved(made(keys(page)))
    settings["distance"] = copied.scene.listener_distance_m
    if data["kind"] == "vibration":
        settings["thickness"] = 1e-3 * copied.scene.plate.thickness_mm
    record, _ = live_engine.record(data, settings, 48384)  # whole laps
    played = sound_level.sound_levels(record[0], 48000, copied.sound.highest, closed=False)
    assert copied.record_laeq_db == pytest.approx(played.laeq_db, abs=0.5)


def test_a_copied_fall_lasts_until_its_second_impact(playing) -> None:
    """From the largest height the ball of the run would still fall at the end of its own track.

    With a restitution of 1 at most, the second impact comes after three times the fall.
    """
    own = runs_of("flying")[1].scene
    with playing("flying") as page:
        page.check("input[name=play-run][value='1']", force=True)
        set_slider(page, "dropHeight", 1)
        page.click("#play-drop")
        copied = made(keys(page))
        set_slider(page, "speed", 0)
        assert keys(page) is None  # which a scene refuses
    assert drop.fall_s(bodies_of(copied)) > own.duration
    assert copied.duration >= 2.99 * drop.fall_s(bodies_of(copied))


@pytest.mark.slow
def test_a_copied_fall_sounds_as_it_was_played(playing, pages) -> None:
    """From three times the height, the copied run has the energy of the engine within 0.5 dB."""
    data = data_of(pages("falling"))["runs"][0]["live"]
    with playing("falling") as page:
        set_slider(page, "dropHeight", 0.9)
        page.click("#play-drop")
        copied = solved(made(keys(page)))
    height = 1e-3 * copied.scene.rolling.drop_mm
    assert height > 3 * data["settings"]["dropHeight"]
    samples = round(48000 * copied.sound.duration)
    script = """
      const { run, settings, samples } = data, prepared = prepare.prepare(run, settings);
      const own = new worklet.Instrument({ run, settings, prepared });
      const force = [], block = new Float64Array(128);
      while (force.length < prepared.delay + samples) {
        own.fill(block);
        force.push(...block);
      }
      done({ force, response: prepared.responses[0], delay: prepared.delay });
    """
    fall = {"run": data, "settings": data["settings"] | {"dropHeight": height}}
    got = live_engine.node(script, fall | {"samples": samples})
    pressure = np.convolve(got["force"], got["response"])[got["delay"] :][:samples]
    played = sound_level.sound_levels(pressure, 48000, copied.sound.highest, closed=False)
    assert copied.sound.levels.laeq_db == pytest.approx(played.laeq_db, abs=0.5)


def test_an_unchanged_fall_is_copied_as_it_was_run(playing) -> None:
    """The track of the run is longer than its fall, so its scene needs no longer one."""
    scene = runs_of("falling")[0].scene
    with playing("falling") as page:
        assert made(keys(page)).track == scene.track
        set_slider(page, "dropHeight", 1)
        page.click("#play-drop")
        assert made(keys(page)).duration >= 2.99 * drop.fall_s(bodies_of(made(keys(page))))


@pytest.mark.slow
def test_firefox_plays_it_without_a_complaint(pages, tmp_path) -> None:
    if (program := firefox_path()) is None:
        without_browser("no Firefox")
    with Firefox(program, tmp_path) as page:
        page.goto(pages("flying"))
        page.click("#play-roll")
        page.until(f"{SPEED} > 0.09")
        page.until(f"Number.isFinite(parseFloat({LEVEL}))")
        assert page.complaints == []


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_limiter_leaves_quiet_sound_and_holds_the_loudest(playing) -> None:
    """The output has the level of the run within 0.5 dB; 30 dB louder it stays in full scale."""
    run = runs_of("three")[0]  # whose instrument sounds the released power
    with playing("three") as page:
        scale, volume = page.evaluate(
            "[JSON.parse(document.querySelector('#data').textContent).runs[0].released.playback"
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


def test_no_sample_passes_full_scale() -> None:
    """The limiter keeps hostile sound below -1 dB, and gives quiet sound back, 3 ms later."""
    script = """
      const loud = new limiter.Limiter(2), quiet = new limiter.Limiter(2);
      const out = [new Float32Array(128), new Float32Array(128)];
      let [peak, error] = [0, 0];
      const past = [];
      for (let block = 0; block < 400; block++) {
        const rise = 10 ** (6 * Math.random() - 3);
        const channels = [0, 1].map(() => Float32Array.from({ length: 128 }, () =>
          Math.random() < 0.02 ? rise * (Math.random() - 0.5) : 0.5 * (Math.random() - 0.5)));
        if (block % 50 === 7) channels[0][3] = [NaN, Infinity, 1e30][block % 3];
        loud.process(channels, out);
        for (const x of out) for (const y of x) peak = Math.max(peak, Math.abs(y));
        const soft = channels.map((x) => x.map((y) => Math.sin(y) || 0).map((y) => 0.8 * y));
        const least = quiet.process(soft, out);
        past.push(...soft[1]);
        const delayed = past.slice(-128 - 143).slice(0, 128);
        const errors = out[1].map((y, i) => Math.abs(y - delayed[i]));
        if (block > 1) error = Math.max(error, ...errors);
        if (least !== 1) error = Infinity;
      }
      done([peak, error]);
    """
    peak, error = live_engine.node(script)
    assert 0.8 < peak <= 10 ** (-1 / 20) + 1e-6
    assert error == 0


LIT = """() => {
  const { width, height } = document.querySelector('#play-lens');
  const pen = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  pen.drawImage(document.querySelector('#play-lens'), 0, 0);
  const { data } = pen.getImageData(0, 0, width, height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i] + data[i + 1] + data[i + 2] > 60;
  return count / (width * height);
}"""
# Holds back the questions to the worker until they are released.
HELD_BACK = """() => {
  const ask = Worker.prototype.postMessage, waiting = [];
  Worker.prototype.postMessage = function (question) {
    waiting.push(() => ask.call(this, question));
  };
  tap.release = () => {
    Worker.prototype.postMessage = ask;
    waiting.forEach((send) => send());
  };
}"""
PREPARED = "document.querySelector('.stage').ariaBusy === 'false'"


def test_the_lens_shows_the_contact_wherever_it_lies(playing) -> None:
    """At least 1 % of the lens is lit, though the contact lies beside the ball's middle.

    It is so before the ball is touched, and while it rolls.
    """
    with playing("edged", "beside") as page:
        page.locator("#play-stage").scroll_into_view_if_needed()  # it is drawn where it is seen
        for number, radio in enumerate(page.locator("input[name=play-run]").all()):
            radio.check(force=True)
            until(page, f"({LIT})() > 0.01")
            if number == 0:
                roll(page)  # and on, as the other run
            assert page.text_content("#play-roll").strip() == "Stop"
            for _ in range(6):
                hear(page, 0.13)
                assert page.evaluate(LIT) > 0.01


def test_sliders_end_where_the_modes_of_a_plate_are_too_many(playing, pages) -> None:
    """At the ends of its sliders the engine plays a plate; it refuses one that is 5 % larger."""
    data = data_of(pages("edged"))["runs"][0]["live"]
    with playing("edged") as page:
        set_slider(page, "thickness", 0)
        for name in ("plateDensity", "length", "width"):
            set_slider(page, name, 1)
        plate = made(keys(page)).plate
        ends = page.locator("#play-length, #play-width").evaluate_all("s => s.map(x => +x.max)")
        thinnest = float(page.locator("#play-thickness").get_attribute("min"))
    settings = {
        **data["settings"],
        "thickness": 1e-3 * plate.thickness_mm,
        "length": 1e-3 * plate.length_mm,
        "width": 1e-3 * plate.width_mm,
        "plateDensity": plate.density_kg_m3,
    }
    assert min(ends) < 1 and thinnest < 0.02  # at the thinnest plate
    script = """
      const { run, settings } = data, larger = { ...settings, width: 1.05 * settings.width };
      let refusal = "";
      try { prepare.prepare(run, larger); } catch (error) { refusal = error.message; }
      done([effort.isPlayable(run, settings), refusal]);
    """
    is_playable, refusal = live_engine.node(script, {"run": data, "settings": settings})
    assert is_playable and "takes too long" in refusal


def test_the_band_of_long_steps_stands_beside_the_shown_speed(opened, pages, tmp_path) -> None:
    """Steps of a node have no such line."""
    text = pages("flying").read_text(encoding="utf-8")
    assert '"longStep":null' in text
    long = tmp_path / "long.html"
    long.write_text(text.replace('"longStep":null', '"longStep":8e-06'), encoding="utf-8")
    with opened(long) as page:
        words = page.text_content("#play-band")
        set_slider(page, "speed", 0)
        at_rest = page.text_content("#play-band")
        set_slider(page, "speed", 0.9)
        speed = keys(page)["rolling"]["speed_m_s"]
        faster = page.text_content("#play-band")
    assert words == "Steps of 8 µm hold up to 6.25 kHz at 0.1 m/s." and not at_rest
    assert f" at {speed:g} m/s." in faster and words != faster
    with opened(pages("flying")) as page:
        assert not page.text_content("#play-band")


@pytest.mark.slow
def test_the_audio_context_rests_after_the_ball(playing) -> None:
    """Without sound it is suspended; the next roll wakes it with the settings made meanwhile."""
    with playing("edged") as page:
        roll(page)
        before = level(page)
        page.click("#play-roll")
        until(page, "tap.context.state === 'suspended'")
        set_slider(page, "distance", 0)
        until(page, PREPARED)
        roll(page)
        assert page.evaluate("tap.context.state") == "running"
        assert abs(level(page) - before) > 1
        page.click("#play-roll")
        until(page, "tap.context.state === 'suspended'")
        page.click("#play")
        until(page, "tap.context.state === 'running' && tap.starts > 0")
        page.click("#play")
        until(page, "tap.context.state === 'suspended'")


@pytest.mark.parametrize(
    ("button", "sounds"),
    [
        ("roll", f"{SPEED} > 0.09"),
        ("drop", "document.querySelector('#play-flight').textContent.includes('mm high')"),
    ],
)
def test_a_ball_that_is_prepared_late_sounds(playing, button: str, sounds: str) -> None:
    """The audio context stays awake until the worker has prepared the ball that was touched."""
    with playing("edged") as page:
        page.add_init_script(f"({HELD_BACK})()")
        page.reload()
        page.click(f"#play-{button}")
        page.wait_for_timeout(600)  # in which a context without sound would be suspended
        page.evaluate("tap.release()")
        until(page, sounds)


def test_late_settings_are_said_to_be_prepared(playing) -> None:
    """The page says so while the worker has no answer, and is silent after it."""
    said = "document.querySelector('#play-preparing').textContent"
    with playing("edged") as page:
        page.locator("#play-stage").scroll_into_view_if_needed()
        until(page, PREPARED)
        page.evaluate("""() => {
          const ask = Worker.prototype.postMessage;
          Worker.prototype.postMessage = function (question) {
            tap.ask = () => ask.call(this, question);
          };
        }""")
        set_slider(page, "lossFactor", 1)
        until(page, f"{said}.startsWith('Preparing')")
        page.evaluate("tap.ask()")
        until(page, f"{said} === ''")


# ---- axes, path, rest, and what only a new run changes


# Where the load stands, and the texts of the axes, all of one moment: the page writes them anew
# several times a second, and an element that Playwright has found may be gone when it is measured.
AXES = """() => {
  const all = (selector) => [...document.querySelectorAll(selector)];
  const middle = (element) => {
    const { top, bottom } = element.getBoundingClientRect();
    return (top + bottom) / 2;
  };
  const [forces, times, levels] = ['#play-forces span', '#play-times span', '#play-levels span']
    .map((selector) => all(selector).map((tick) => [tick.textContent, middle(tick)]));
  return { load: middle(document.querySelector('#play-strip .load')), forces, times, levels };
}"""


def test_axes_have_decibels_newtons_and_milliseconds(playing) -> None:
    """The tick of the load stands at its dashed line, and levels are 20 dB apart."""
    (run,) = runs_of("edged")
    with playing("edged") as page:
        roll(page)
        until(page, "document.querySelectorAll('#play-forces span').length === 3")
        until(page, "document.querySelectorAll('#play-levels span').length === 4")
        axes = page.evaluate(AXES)
    text, middle = axes["forces"][1]
    assert text == f"{1e3 * run.scene.load:g} mN"
    assert middle == pytest.approx(axes["load"], abs=3)
    assert [text for text, _ in axes["times"]] == [f"{MINUS}4000 ms", f"{MINUS}2000 ms", "now"]
    levels = [float(text.removesuffix(" dB").replace(MINUS, "-")) for text, _ in axes["levels"]]
    assert np.diff(levels).tolist() == [-20, -20, -20]


def test_the_ball_stays_on_its_path_on_the_plate(playing) -> None:
    (run,) = runs_of("to-and-fro")
    ends = np.array([*run.scene.plate.contact_ends_mm.values()])
    length, width = run.scene.plate.edges_mm
    with playing("to-and-fro") as page:
        roll(page)
        until(page, "document.querySelector('#play-plan-ball').hasAttribute('cx')")
        seen = []
        for _ in range(6):
            hear(page, 0.08)  # the ball moves by the clock of the sound
            seen.append(page.evaluate(PLAN))
    plate = np.array(seen[0]["plate"])  # left, bottom, length, height
    scale = plate[2] / length
    assert plate[3] / width == pytest.approx(scale, rel=1e-3)
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    places = []
    for picture in seen:
        x, y = picture["ball"]
        away = np.array([x - plate[0], plate[1] - y]) / scale - ends[0]
        places.append(float(away @ along))
        assert abs(away[0] * along[1] - away[1] * along[0]) < 0.5  # mm beside the path
    assert min(places) >= -0.5 and max(places) <= np.linalg.norm(ends[1] - ends[0]) + 0.5
    assert max(places) - min(places) > 1.0  # it moves


PLAN = """() => {
  const numbers = document.querySelector('#play-plan-plate').getAttribute('d').match(/-?[0-9.]+/g);
  const [left, bottom, length, height] = numbers.map(Number);
  const ball = document.querySelector('#play-plan-ball');
  const place = ['cx', 'cy'].map((name) => Number(ball.getAttribute(name)));
  return { plate: [left, bottom, length, Math.abs(height)], ball: place };
}"""


@pytest.mark.law("instrument: a marble rolls out in the time that its resistance and weight give.")
def test_a_ball_under_its_weight_rolls_out_and_rests(playing) -> None:
    (run,) = runs_of("falling")
    scene = run.scene.with_({"rolling.drop_mm": None, "rolling.resistance": USUAL_RESISTANCE})
    with playing("falling") as page:
        page.click("#play-out")
        until(page, "document.querySelector('#play-out-words').textContent.includes('at rest')")
        words = page.inner_text("#play-out-words")
        seconds = float(re.search(r"at rest ([0-9.]+) s", words).group(1))
        assert seconds == pytest.approx(scene.motion.rest_time, rel=0.03)  # two digits
        until(page, "!document.querySelector('#play-roll').hasAttribute('data-playing')")
        until(page, f"Math.abs({SPEED}) < 1e-3")


@pytest.mark.slow
def test_a_ball_that_something_presses_does_not_roll_out(playing) -> None:
    with playing("edged") as page:
        assert page.locator("#play-out").is_hidden()


@pytest.mark.parametrize("name", ["lap", "edged", "beside"])
def test_what_needs_a_new_run_is_refused_by_resounding(name: str) -> None:
    """Each command names a value that the scene allows, and that its solved contact does not."""
    (run,) = runs_of(name)
    needs = needs_of_a_new_run(run)
    assert {"Radius", "Stiffness of the plate"} <= {need.name for need in needs}
    for need in needs:
        change = re.search(r'--set "([^"]+)"', need.command).group(1)
        with pytest.raises(SceneError, match="needs a new run"):
            file.resound(run.scene, [change])
        assert file.with_overrides(run.scene, [change]).name == run.scene.name


def test_a_hardness_at_its_limit_is_offered_smaller() -> None:
    (run,) = runs_of("lap")
    hard = replace(run, scene=run.scene.with_({"plate.hardness_gpa": 40}))
    (need,) = [need for need in needs_of_a_new_run(hard) if need.name == "Hardness"]
    assert "plate.hardness_gpa=27" in need.command and need.value == "40 GPa"
