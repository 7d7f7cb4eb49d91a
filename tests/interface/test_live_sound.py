"""The engine of the page makes the sound of the program, without clicks."""

from __future__ import annotations

from urllib.parse import quote

import live_engine
import numpy as np
import pytest
from live_engine import EDGES, force_law, node, record, scene, vibration, vibration_data
from scipy.signal import butter, sosfilt

from acoustics import level, wav, weighting
from acoustics.bands import reliable
from acoustics.rectangular_plate import RectangularPlate
from rolling.report.templates import joined_script

STEREO = {"sound.listener_mm": [[100, 150, 500], [250, 60, 700]]}
EDGED = {**EDGES, "plate.thickness_mm": 10}
# Scenes, and settings of their pages by which the sound is compared; {}: those of the scene.
CASES = {
    "infinite plate": ({}, {}, {}),
    "half-space": ({"plate.thickness_mm": None, "plate.loss_factor": None}, {}, {}),
    "plate with edges": (EDGED | STEREO, {}, {}),
    "other ball": ({}, {"sphere.density_kg_m3": 2500}, {"ballDensity": 2500}),
    "other speed": ({}, {"rolling.speed_m_s": 0.25}, {"speed": 0.25}),
    "other plate": (
        EDGED,
        {"plate.length_mm": 220, "plate.loss_factor": 0.03, "sound.distance_m": 0.5},
        {"length": 0.22, "lossFactor": 0.03, "distance": 0.5},
    ),
}
CHANGES = """async ([url, run]) => {
  const changes = [{}, { distance: 0.3 }, { ballDensity: 3000 }, { thickness: 0.012 },
    { load: 24 }, { lossFactor: 0.1 }, { contactLossFactor: 0.05 }, { length: 0.5 }];
  const context = new OfflineAudioContext(1, 19200 * changes.length, 48000);
  await context.audioWorklet.addModule(url);
  let { settings } = run, body = null;
  const change = (setting, position) => {
    settings = { ...settings, ...setting };
    const prepared = prepare(run, settings), from = { position, speed: settings.speed };
    const { output } = instrumentNode(context, { run, settings, prepared, from });
    const next = throughBody(output, prepared.responses, context.destination, !body);
    if (body) leaveBody(body);
    body = next;
  };
  change({}, 0);
  changes.forEach((setting, i) => i && context.suspend(0.4 * i).then(() => {
    change(setting, 0.4 * i * settings.speed);
    context.resume();
  }));
  return Array.from((await context.startRendering()).getChannelData(0));
}"""
RECORD = """async ([url, run, settings]) => {
  const record = await renderedRecord(url, run, settings, prepare(run, settings), 0.25);
  return record.map((channel) => Array.from(channel));
}"""


def differences(
    got: np.ndarray, levels: level.SoundLevels, highest: float = np.inf
) -> tuple[float, float]:
    """Return the largest difference [dB] of a reliable third octave, and that of LAeq."""
    found = level.sound_levels(got, wav.SAMPLE_RATE_HZ, highest)
    bands = zip(
        found.third_octave_db.values(),
        levels.third_octave_db.values(),
        reliable(len(got) / wav.SAMPLE_RATE_HZ),
        strict=True,
    )
    off = [abs(a - b) for a, b, known in bands if known and a is not None and b is not None]
    return max(off), abs(found.laeq_db - levels.laeq_db)


def test_weights_are_those_of_the_program() -> None:
    """The poles of IEC 61672-1 have eight digits."""
    frequency = np.geomspace(10, 20e3, 50)
    got = 20 * np.log10(node("done(data.map(radiation.aWeight))", frequency.tolist()))
    assert got == pytest.approx(weighting.a_weighting_db(frequency), abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [1e-3, 1e-2])
def test_the_response_of_a_plate_has_its_transfer(thickness: float) -> None:
    """The lines of the response are the pressure per force within -43 dB of its energy.

    A hundred-thousandth of the ringing fades at the end, and both interpolate the radiation.
    """
    numbers = {"length_m": 0.3, "width_m": 0.4, "loss_factor": 0.01}
    parts = 7850 * thickness, 210e9 * thickness**3 / 12 / 0.91
    plate = RectangularPlate(
        mass_per_area_kg_m2=parts[0], bending_stiffness_n_m=parts[1], **numbers
    )
    script = """
      const own = new plate.EdgedPlate(data);
      const listener = { bodies: [], radiation: own.radiation([0.129, 0.148], [0.3, 0.2, 0.5]) };
      done(response.impulseResponses([listener], 0.7));
    """
    data = {"massPerArea": parts[0], "bendingStiffness": parts[1], "lossFactor": 0.01}
    got = node(script, data | {"length": 0.3, "width": 0.4})
    samples = np.roll(got["responses"][0], -got["lead"])
    lines = np.unique(np.geomspace(100, len(samples) * 0.45, 300).astype(int))
    frequency = lines * wav.SAMPLE_RATE_HZ / len(samples)
    wanted = plate.pressure_transfer(frequency, [0.129, 0.148], (0.3, 0.2, 0.5), 0.7)
    error = np.fft.rfft(samples)[lines] - wanted
    assert np.sum(np.abs(error) ** 2) < 5e-5 * np.sum(np.abs(wanted) ** 2)


def test_modes_of_the_page_have_the_loss_factors_of_their_frequencies() -> None:
    curve = ((50.0, 0.05), (1000.0, 0.02), (8000.0, 0.004))
    plate = RectangularPlate(78.5, 18.9e3, curve, length_m=0.3, width_m=0.4)
    data = {"massPerArea": 78.5, "bendingStiffness": 18.9e3, "length": 0.3, "width": 0.4}
    data |= {"lossFactor": 0.02, "lossCurve": [[hertz, loss / 0.02] for hertz, loss in curve]}
    got = node("done(new plate.EdgedPlate(data).modes.map(({ loss }) => loss));", data)
    np.testing.assert_allclose(got, plate.loss_factors, rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_record_of_the_engine_is_that_of_the_program(case: str) -> None:
    """Third octaves agree within 0.3 dB where their level is reliable, and LAeq within 0.1 dB.

    The time steps of the program leave 0.04 dB of them.
    """
    start, changes, settings = CASES[case]
    begun = scene(start)
    law = force_law(begun)
    run = vibration_data(begun, law, vibration(begun, law))
    wanted = vibration(begun.with_(changes), law)
    got, _ = record(run, run["settings"] | settings, wanted.pressures.shape[1])
    assert len(got) == len(wanted.pressures)
    for channel, levels in zip(got, wanted.listener_levels(), strict=True):
        bands, laeq = differences(channel, levels)
        assert bands < 0.3 and laeq < 0.1


@pytest.mark.parametrize(
    ("changes", "settings"),
    [
        ({}, {}),
        ({"rolling.speed_m_s": 0.3}, {"speed": 0.3}),
        ({"sound.q": 0.01, "sound.distance_m": 2}, {"q": 0.01, "distance": 2}),
    ],
)
def test_a_record_of_the_release_is_that_of_the_program(changes: dict, settings: dict) -> None:
    """A release has no time steps: 0.05 dB are left by the high-pass and by the cubics."""
    begun = scene({"sound.source": "release"})
    _, run = live_engine.release(begun)
    wanted, _ = live_engine.release(begun.with_(changes))
    got, _ = record(run, run["settings"] | settings, len(wanted.pressure))
    assert max(differences(got[0], wanted.levels)) < 0.05


def rendered(opened, tmp_path, call: str, *arguments) -> np.ndarray:
    """Return the channels that Chromium renders by a call to the engine on an empty page."""
    page = tmp_path / "engine.html"
    page.write_text("<!doctype html><title>engine</title>")
    scripts = joined_script("engine/prepare.js") + joined_script("engine/graph.js")
    with opened(page) as browser:
        browser.add_script_tag(content=f"{scripts}\nwindow.setTimeout = () => {{}};")
        url = f"data:text/javascript;charset=utf-8,{quote(joined_script('engine/worklet.js'))}"
        return np.array(browser.evaluate(call, [url, *arguments]))


@pytest.mark.slow
def test_changes_of_settings_do_not_click(opened, tmp_path) -> None:
    """No step between samples exceeds 6 rms of those within 20 ms, for a tone of 300 Hz.

    The tone alone has 1.4 rms, and a jump by a fifth of its amplitude 7.
    """
    begun = scene(EDGED)
    profile = 1e-8 * np.sin(2 * np.pi * 18 / begun.track.steps * np.arange(begun.track.steps))
    law = force_law(begun, profile)
    run = vibration_data(begun, law, vibration(begun, law))
    heard = rendered(opened, tmp_path, CHANGES, run)
    steps = np.diff(heard)[4800:]
    near = np.convolve(np.square(steps), np.ones(1920) / 1920, mode="same")
    assert np.max(np.abs(steps) / np.sqrt(near)) < 6


@pytest.mark.slow
@pytest.mark.parametrize("listeners", [{}, STEREO])
def test_chromium_renders_the_force_through_the_responses(listeners, opened, tmp_path) -> None:
    """Its convolvers are exact within single precision; a record of a fall begins with it."""
    begun = scene(EDGED | listeners)
    law = force_law(begun)
    run = vibration_data(begun, law, vibration(begun, law))
    settings = run["settings"] | {"dropHeight": 1e-4}
    got = rendered(opened, tmp_path, RECORD, run, settings)
    script = """
      const prepared = prepare.prepare(data.run, data.settings), force = [];
      const own = new worklet.Instrument({ ...data, prepared }), block = new Float64Array(128);
      for (let i = 0; i < 200; i++) {
        own.fill(block);
        force.push(...block);
      }
      done({ ...prepared, force });
    """
    parts = node(script, {"run": run, "settings": settings})
    force = sosfilt(butter(8, 15.5, "highpass", output="sos", fs=48000), parts["force"])
    for channel, response in zip(got, parts["responses"], strict=True):
        wanted = np.convolve(force, response)[parts["delay"] :][:12_000]
        assert channel == pytest.approx(wanted, abs=1e-5 * np.abs(wanted).max())
