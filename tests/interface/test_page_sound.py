"""The report page plays each record at its level, without gaps, and loops where that is right."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import soundfile
from report_browser import (
    MINUS,
    RATE,
    data_of,
    embedded_record,
    hear,
    play,
    seek,
    time_of,
    until,
)
from report_runs import runs_of

from acoustics import level, room
from rolling.report.page_room import REVERBERATION_S, page_room


def test_the_records_of_the_page_times_their_scale_are_the_records_of_the_runs(pages) -> None:
    """The peak lies 1 dB below full scale, and 24 bits round by half a step at most."""
    path = pages("three")
    for k, run in enumerate(runs_of("three")):
        record = embedded_record(path, k)
        scale = data_of(path)["runs"][k]["playback"]["full_scale_pa"]
        assert np.abs(record).max() == pytest.approx(10 ** (-1 / 20), abs=2**-23)
        assert np.abs(record - run.stated().sound.pressure / scale).max() <= 2**-24 * (1 + 1e-6)


def test_gains_give_the_stated_levels_and_never_clip(pages, opened) -> None:
    """Calibrated gains keep the differences of the runs' LAeq, and equal gains remove them.

    The level of the output follows from the gains that the page has set. It holds within 0.01 dB,
    since the rounding of 16 bits lies 85 dB below.
    """
    path = pages("three")
    records = [embedded_record(path, k) for k in range(3)]
    stated = [run["playback"] for run in data_of(path)["runs"]]
    got: dict[str, list[tuple[float, float, float]]] = {"calibrated": [], "equal": []}
    with opened(path) as page:
        play(page)
        for mode, levels in got.items():
            page.set_checked("#equal", mode == "equal")
            for k in range(3):
                page.keyboard.press(str(k + 1))
                hear(page)
                gains = page.evaluate("tap.gains.map((node) => node.gain.value)")
                assert [gain for j, gain in enumerate(gains) if j != k] == [0, 0]
                assert np.abs(records[k]).max() * gains[k] <= 10 ** (-1 / 20) + 1e-4
                scale = "equal" if mode == "equal" else "scale"
                pascals = float(page.text_content(f"[data-{scale}='{k}']").split()[0])
                decibels = float(page.text_content(f"[data-gain='{k}']").replace(MINUS, "-"))
                played = level.laeq_db(records[k] * gains[k], RATE)
                levels.append((played, played + 20 * np.log10(pascals), decibels))
        table = [
            float(page.text_content(f"table.players tbody tr:nth-child({k + 1}) td"))
            for k in range(3)
        ]
    for levels in got.values():
        # Digital level times the pascals of full scale is the run's LAeq; both are shown rounded.
        assert [absolute for _, absolute, _ in levels] == pytest.approx(table, abs=0.06)
    played = {mode: [digital for digital, _, _ in levels] for mode, levels in got.items()}
    assert np.ptp(played["equal"]) < 0.01
    assert np.diff(played["calibrated"]) == pytest.approx(np.diff(table), abs=0.11)
    for k in range(3):
        added = played["equal"][k] - played["calibrated"][k]
        assert got["equal"][k][2] == pytest.approx(added, abs=0.05)
        assert stated[k]["equal_db"] == pytest.approx(added, abs=0.001)


def test_a_second_button_plays_the_released_power(pages, opened) -> None:
    """One sound is heard at a time, and each with the gain that the runs share for it."""
    path = pages("three")
    (first, *_) = data_of(path)["runs"]
    assert first["playback"]["full_scale_pa"] < first["released"]["playback"]["full_scale_pa"]
    with opened(path) as page:
        play(page)
        hear(page)
        assert "You hear the vibration of ball and plate, estimated" in page.inner_text(".hear")
        page.click("#play-released")
        until(page, "tap.gains.length === 6")
        hear(page)
        gains = page.evaluate("tap.gains.slice(3).map((node) => node.gain.value)")
        expected = [first["released"]["playback"]["calibrated"], 0, 0]
        assert gains == pytest.approx(expected, abs=1e-3)
        assert page.inner_text("#play") == "Play" and page.inner_text("#play-released") == "Pause"
        page.click("#play")
        until(page, "tap.gains.length === 9")
        hear(page)
        gains = page.evaluate("tap.gains.slice(6).map((node) => node.gain.value)")
        assert gains == pytest.approx([first["playback"]["calibrated"], 0, 0], abs=1e-3)
        assert page.inner_text("#play-released") == "Released power"


def test_switching_keeps_the_playhead_and_the_sound(pages, opened) -> None:
    """Sources start once, the playhead advances with the clock, and no 43 ms are silent."""
    with opened(pages("three")) as page:
        play(page)
        hear(page)
        found = page.evaluate("""async () => {
          const block = new Float32Array(2048);
          let quietest = Infinity;
          const wait = () => new Promise((done) => requestAnimationFrame(done));
          const press = (key) =>
            document.body.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
          // The clock of the sound may advance while the page reads; such a reading is repeated.
          const clock = () => tap.context.currentTime - (tap.context.outputLatency || 0);
          const read = (key) => {
            for (;;) {
              const heard = clock();
              press(key); // a key moves the slider
              if (clock() === heard) return Number(document.querySelector('#seek').value) - heard;
            }
          };
          const jumps = [];
          for (let k = 0; k < 6; k++) {
            await wait();
            const before = read(String(1 + (k + 2) % 3));
            press(String(1 + k % 3));
            for (let n = 0; n < 8; n++) {
              await wait();
              tap.analyser.getFloatTimeDomainData(block);
              const square = block.reduce((s, x) => s + x * x, 0) / block.length;
              quietest = Math.min(quietest, Math.sqrt(square));
            }
            const jump = read(String(1 + k % 3)) - before;
            jumps.push(jump - 0.9 * Math.round(jump / 0.9)); // it goes round after 0.9 s
          }
          const run = document.querySelector('#choose').value;
          return { quietest, jumps, starts: tap.starts, run };
        }""")
    assert found["starts"] == 3
    assert found["run"] == "2"
    assert found["quietest"] > 1e-3
    assert np.abs(found["jumps"]).max() < 1e-6


def test_a_silent_run_alone_plays_and_has_nothing_to_compare(pages, opened) -> None:
    with opened(pages("smooth")) as page:
        for selector in ("#choose", "input[name=run]", "#equal", "[data-gain]"):
            assert page.locator(selector).count() == 0
        assert "is silent" in page.inner_text(".hear")
        page.click("#play")
        until(page, "tap.gains.length === 1")
        hear(page)
        assert page.evaluate("tap.gains.map((node) => node.gain.value)") == [0]


def test_frequencies_stand_beside_the_spectrogram_without_a_solved_part(pages, opened) -> None:
    with opened(pages("lap")) as page:
        assert page.locator("#heard-solved").is_hidden()
        bands = page.locator("#heard-bands").bounding_box()
        frequencies = page.locator("#heard-frequencies").bounding_box()
        assert frequencies["y"] == pytest.approx(bands["y"], abs=3)
        assert frequencies["height"] == pytest.approx(bands["height"], abs=3)
        assert page.locator("#heard-times").bounding_box()["y"] >= bands["y"] + bands["height"]


PAINTED = """() => {
  const canvas = document.querySelector('#heard-bands');
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return data.some((byte) => byte > 0);
}"""


def with_analyst(path: Path, begins_with: str) -> Path:
    """Return a copy of a page whose worker for spectrograms begins with other lines."""
    changed = path.with_name("analyst.html")
    html = path.read_text(encoding="utf-8")
    changed.write_text(html.replace('id="analyst">', f'id="analyst">{begins_with}'), "utf-8")
    return changed


def test_the_wait_for_the_spectrogram_is_told_and_the_page_stays_free(pages, opened) -> None:
    busy = "const begun = performance.now(); while (performance.now() - begun < 1500);"
    with opened(with_analyst(pages("lap"), busy)) as page:
        until(page, "document.querySelector('#heard-wait').textContent.includes('computed: 0')")
        assert page.locator("#heard-wait").is_visible()
        page.click("#play")  # which the worker does not hold up
        until(page, "tap.sources.length > 0")
        assert page.locator("#heard-wait").is_visible()
        until(page, "document.querySelector('#heard-wait').hidden")
        assert page.evaluate(PAINTED)


def test_a_spectrogram_that_cannot_be_computed_leaves_no_empty_box(pages, opened) -> None:
    with opened(with_analyst(pages("lap"), "throw new Error('no');")) as page:
        until(
            page, "document.querySelector('#heard-wait').textContent.includes('does not compute')"
        )
        assert page.locator("#heard-wait").is_visible()
        assert page.get_attribute("#heard-wave path", "d")  # the waveform stands all the same


def test_a_short_record_says_that_its_repetition_is_heard(pages, opened) -> None:
    """A record of 6 ms repeats 167 times a second."""
    with opened(pages("lap")) as page:
        notes = page.locator("aside [data-only]")
        assert notes.count() == 1 and notes.is_visible()
        assert "repeats 167 times a second" in notes.text_content()
        assert "the repetition, not the contact" in notes.text_content()


@pytest.mark.parametrize("name", ["lap", "one"])
def test_play_plays_the_computed_record(name, pages, opened) -> None:
    """Play sends the samples of the record, short or long, times the calibrated gain."""
    path = pages(name)
    record = embedded_record(path, 0)
    gain = data_of(path)["runs"][0]["playback"]["calibrated"]
    with opened(path) as page:
        page.click("#play")
        until(page, "tap.sources.length > 0")
        hear(page)
        played = page.evaluate("[...tap.sources[0].buffer.getChannelData(0)]")
        assert page.evaluate("tap.gains[0].gain.value") == pytest.approx(gain, rel=1e-6)
    assert len(played) == len(record)
    assert np.abs(np.array(played) - record).max() < 2**-15  # the rounding of 16 bits


def test_play_begins_with_the_long_record_at_its_own_level(pages, opened) -> None:
    """A run without one is heard by its own record; the MP3 keeps its level within 0.1 dB."""
    path = pages("long", "fast")
    (long, short) = runs_of("long", "fast")
    playback = data_of(path)["runs"][0]["playback"]
    with opened(path) as page:
        page.click("#play")
        until(page, "tap.starts === 2")
        hear(page)
        played = page.evaluate("tap.sources.map((s) => [...s.buffer.getChannelData(0)])")
        gain = page.evaluate("tap.gains[0].gain.value")
        assert page.evaluate("tap.sources.map((s) => s.loop)") == [True, True]
        pascal = np.array(played[0]) * playback["full_scale_pa"]
        laeq = long.vibration.value
        assert laeq == pytest.approx(long.numbers.heard.level_db)
        assert len(pascal) == len(long.long.pressure)
        assert level.laeq_db(pascal, RATE) == pytest.approx(laeq, abs=0.1)
        assert gain == pytest.approx(playback["calibrated"], rel=1e-4)
        assert len(played[1]) == len(short.sound.pressure)
        # Maps and playheads stay at the end of the solved track while the long record goes on.
        page.click("#play")
        seek(page, 1.5)
        solved = data_of(path)["runs"][0]["solved"]
        assert solved < 0.31 and time_of(page) == pytest.approx(1.5)
        assert float(page.text_content("#map-time").split()[0]) == pytest.approx(solved, abs=0.01)


def test_a_record_is_saved_as_a_wav_at_the_gain_that_is_heard(pages, opened) -> None:
    """The common gain by default, that of equal loudness with the switch; 24 bits."""
    path = pages("three")
    stated = data_of(path)["runs"][1]["playback"]
    with opened(path, accept_downloads=True) as page:
        page.keyboard.press("2")
        for mode in ("calibrated", "equal"):
            page.set_checked("#equal", mode == "equal")
            with page.expect_download() as download:
                page.locator("[data-wav]:visible").first.click()
            content = download.value.path().read_bytes()
            file = soundfile.SoundFile(io.BytesIO(content))
            samples = file.read()
            assert file.subtype == "PCM_24" and file.samplerate == RATE
            expected = embedded_record(path, 1) * stated[mode]
            assert np.abs(samples - expected).max() <= 2**-21
            full_pa = stated["full_scale_pa"] / stated[mode]
            named = float(re.search(r"full scale is (\S+) Pa", file.comment)[1])
            assert named == pytest.approx(full_pa, rel=1e-5)


def test_a_record_that_does_not_close_goes_round_as_listen_wav_does(pages, opened) -> None:
    """Its end leads to its lap as in listen.wav, within the rounding of 16 bits."""
    path = pages("braking")
    (run,) = runs_of("braking")
    playback = data_of(path)["runs"][0]["playback"]
    sound = run.stated().sound
    lap = sound.lap
    heard = lap.samples(sound.pressure) / lap.factor / playback["full_scale_pa"]
    record = sound.pressure / playback["full_scale_pa"]
    with opened(path) as page:
        assert "cross-faded" in page.text_content("main")
        page.click("#play")
        until(page, "tap.sources.length > 0")
        played = np.array(page.evaluate("[...tap.sources[0].buffer.getChannelData(0)]"))
        start, end = page.evaluate("[tap.sources[0].loopStart, tap.sources[0].loopEnd]")
    assert (start * RATE, end * RATE) == pytest.approx((lap.begin + lap.overlap, lap.end))
    assert np.abs(played).max() <= 10 ** (-1 / 20) + 1e-4
    faded = slice(lap.end - lap.overlap, lap.end)
    assert np.abs(played[faded] - heard[: lap.overlap]).max() < 2**-14
    assert np.abs(played[: faded.start] - record[: faded.start]).max() < 2**-14


def test_a_record_that_ends_is_played_once_and_whole(pages, opened) -> None:
    """Play stops at the end of a fall, with no seam in it, and begins it again when pressed."""
    path = pages("falling")
    fall = runs_of("falling")[0].sound
    playback = data_of(path)["runs"][0]["playback"]
    stopped = "document.querySelector('#play').textContent.trim() === 'Play'"
    with opened(path) as page:
        for starts in (1, 2):
            page.click("#play")
            until(page, f"tap.sources.length === {starts} && {stopped}")
            assert time_of(page) == pytest.approx(fall.duration, abs=1e-3)
        assert page.evaluate("tap.sources.map((source) => source.loop)") == [False, False]
        assert page.evaluate("tap.offsets") == pytest.approx([0, 0], abs=1e-3)
        played = np.array(page.evaluate("[...tap.sources[0].buffer.getChannelData(0)]"))
    assert len(played) == len(fall.pressure)
    assert played == pytest.approx(fall.pressure / playback["full_scale_pa"], abs=2**-14)


def test_records_of_other_lengths_go_round_in_their_own_time(pages, opened) -> None:
    """At 0.7 s, records of 0.9, 0.45, 0.9 and 0.006 s have their own times."""
    path = pages("one", "fast", "braking", "lap")
    with opened(path) as page:
        assert "differ in length" in page.text_content("main")
        seek(page, 0.7)
        for k, expected in enumerate((0.7, 0.25, 0.7, 0.7 % 0.006)):
            page.keyboard.press(str(k + 1))
            assert time_of(page) == pytest.approx(expected, abs=1e-3)
            shown = float(page.text_content("#map-time").split()[0])
            assert shown == pytest.approx(expected, abs=1e-3)


def test_a_browser_that_starts_no_sound_is_not_waited_for_in_silence(pages, opened) -> None:
    with opened(pages("lap")) as page:
        page.evaluate("""() => {
          AudioContext.prototype.resume = () => new Promise(() => {});
          Object.defineProperty(BaseAudioContext.prototype, 'state', { get: () => 'suspended' });
        }""")
        page.click("#play")
        assert not page.locator("#no-sound").is_visible()
        page.evaluate("tap.later.forEach((work) => work())")  # two seconds later
        assert page.locator("#no-sound").is_visible()
        assert "sound device" in page.text_content("#no-sound")


@pytest.mark.parametrize("distance_m", [0.3, 1.0, 5.0])
def test_a_room_is_as_loud_as_none_and_has_the_response_of_the_program(distance_m: float) -> None:
    """Direct and diffuse sound together have the power of the direct sound alone."""
    run = runs_of("three")[0]
    scene = run.scene.with_({"sound.distance_m": distance_m})
    shown = page_room([run, replace(run, scene=scene)])
    first, other = shown.gains
    own = room.diffuse_response(REVERBERATION_S, distance_m, RATE, seed=0)
    energy = np.square(own).sum(axis=0).mean()
    assert other["direct"] ** 2 * (1 + energy) == pytest.approx(1, abs=1e-4)
    ratio = other["diffuse"] / other["direct"] * first["direct"] / first["diffuse"]
    assert ratio == pytest.approx(distance_m / run.scene.listener_distance_m, rel=1e-4)


def test_a_room_is_heard_only_when_it_is_asked_for(pages, opened) -> None:
    """It lets a sound ring on, changes no level that is stated, and is dry again when it is off."""
    path = pages("three")
    (direct, diffuse) = data_of(path)["room"]["gains"][0].values()
    with opened(path) as page:
        assert not page.is_checked("#room")
        words = page.inner_text("#room-words")
        assert words.startswith("For listening only: ") and words.endswith("no level includes.")
        before = page.inner_text("table.players")
        decoded = page.evaluate("""async () => {
          const { src } = document.querySelector('#room-response');
          const letters = atob(src.slice(src.indexOf(',') + 1));
          const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
          const offline = new OfflineAudioContext(2, 1, 48000);
          const sound = await offline.decodeAudioData(bytes.buffer);
          const energy = (c) => sound.getChannelData(c).reduce((sum, x) => sum + x * x, 0);
          return [sound.duration, energy(0), energy(1)];
        }""")
        whole = room.diffuse_response(REVERBERATION_S, 1.0, RATE, seed=0)
        assert decoded[0] == pytest.approx(len(whole) / RATE, abs=1 / RATE)
        own = np.sqrt(1 / direct**2 - 1) * direct / diffuse  # rms of the response on the page
        assert np.sqrt(np.mean(decoded[1:])) == pytest.approx(own, rel=0.05)
        page.check("#room")
        play(page)
        until(page, "tap.rooms.length === 1")
        hear(page)
        assert page.evaluate("tap.rooms[0].gain.value") == pytest.approx(diffuse, rel=0.02)
        page.uncheck("#room")
        hear(page)
        assert page.evaluate("tap.rooms[0].gain.value") < 0.01 * diffuse
        assert page.inner_text("table.players") == before
