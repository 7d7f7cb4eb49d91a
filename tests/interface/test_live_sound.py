"""The engine of the page makes the sound of the program, without clicks."""

from __future__ import annotations

import re

import live_engine
import numpy as np
import pytest
from live_engine import EDGES, ENGINE, force_law, node, record, scene, vibration, vibration_data

from acoustics import level, wav, weighting
from acoustics.bands import reliable
from acoustics.rectangular_plate import RectangularPlate
from rolling.report.scripts import joined

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
RENDER = """async ([script, run]) => {
  const context = new OfflineAudioContext(1, 12800, 48000);
  await context.audioWorklet.addModule("data:text/javascript," + encodeURIComponent(script));
  const processorOptions = { run };
  const own = new AudioWorkletNode(context, "own", { outputChannelCount: [1], processorOptions });
  own.connect(context.destination);
  return Array.from((await context.startRendering()).getChannelData(0));
}"""
PROCESSOR = """
registerProcessor("own", class extends AudioWorkletProcessor {
  constructor({ processorOptions: { run } }) {
    super();
    this.own = new Instrument(run, run.settings, prepare(run, run.settings));
  }
  process(_, [channels]) {
    this.own.render(channels);
    return true;
  }
});
"""


@pytest.fixture(scope="module")
def vibrating() -> dict:
    begun = scene(EDGED)
    law = force_law(begun)
    return vibration_data(begun, law, vibration(begun, law))


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


def test_transforms_and_levels_are_those_of_the_program() -> None:
    """They are the same sums; the A-weighting filter follows its curve within 0.02 dB to 20 kHz."""
    x = np.random.default_rng(3).standard_normal(4801)
    script = """
      const filter = new bands.AWeighting(48000), impulse = new Float64Array(8192);
      impulse[0] = 1;
      const lines = fft.realLines(data);
      done({ ...lines, back: fft.realRecord(lines, data.length),
             levels: bands.soundLevels(data, 48000),
             filter: impulse.map((v) => filter.advance(v)) });
    """
    got = node(script, x.tolist())
    assert np.array(got["re"]) + 1j * np.array(got["im"]) == pytest.approx(np.fft.rfft(x), abs=1e-9)
    assert got["back"] == pytest.approx(x.tolist(), abs=1e-12)
    levels = level.sound_levels(x, 48000)
    assert got["levels"]["laeq"] == pytest.approx(levels.laeq_db, abs=1e-9)
    bands = zip(got["levels"]["bands"], levels.third_octave_db.values(), strict=True)
    assert all(a == (b if b is None else pytest.approx(b, abs=1e-9)) for a, b in bands)
    frequency = np.fft.rfftfreq(8192, 1 / 48000)
    heard = (frequency > 20) & (frequency < 20e3)
    filtered = 20 * np.log10(np.abs(np.fft.rfft(got["filter"])))
    assert filtered[heard] == pytest.approx(weighting.a_weighting_db(frequency[heard]), abs=0.02)


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
      const listener = { bodies: [], modes: own.radiation([0.129, 0.148], [0.3, 0.2, 0.5]) };
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


def test_a_convolver_is_exact_and_changes_over_what_it_has_heard() -> None:
    """It is the direct sum within single precision, from two long blocks after a change on."""
    rng = np.random.default_rng(4)
    first, second = rng.standard_normal((2, 20_000)) * np.exp(-np.arange(20_000) / 5e3)
    x = rng.standard_normal(128 * 250)
    script = """
      const parts = data.responses.map((r) => [convolver.parted(Float64Array.from(r))]);
      const block = new Float64Array(128), heard = [], own = new convolver.Convolver(parts[0]);
      for (let i = 0; i < data.x.length; i += 128) {
        if (i === 128 * 100) own.change(parts[1]);
        own.process(Float64Array.from(data.x.slice(i, i + 128)), [block]);
        heard.push(...block);
      }
      done(heard);
    """
    responses = [first.tolist(), second.tolist()]
    got = np.array(node(script, {"x": x.tolist(), "responses": responses}))
    before, after = (np.convolve(x, h)[: len(x)] for h in (first, second))
    assert got[:12_800] == pytest.approx(before[:12_800], abs=1e-4)
    assert got[24_576:] == pytest.approx(after[24_576:], abs=1e-4)


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
    got = record(run, run["settings"] | settings, wanted.pressures.shape[1])
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
    got = record(run, run["settings"] | settings, len(wanted.pressure))
    assert max(differences(got[0], wanted.levels)) < 0.05


def test_changes_of_settings_do_not_click() -> None:
    """No step between samples exceeds 6 rms of those within 20 ms, for a tone of 300 Hz.

    The tone alone has 1.4 rms, and a jump by a fifth of its amplitude 7.
    """
    begun = scene(EDGED)
    profile = 1e-8 * np.sin(2 * np.pi * 18 / begun.track.steps * np.arange(begun.track.steps))
    law = force_law(begun, profile)
    run = vibration_data(begun, law, vibration(begun, law))
    script = """
      let settings = data.settings;
      const own = new instrument.Instrument(data, settings, prepare.prepare(data, settings));
      const block = [new Float32Array(128)], heard = [];
      const changes = [{}, { distance: 0.3 }, { ballDensity: 3000 }, { thickness: 0.012 },
        { load: 24 }, { lossFactor: 0.1 }, { contactLossFactor: 0.05 }, { length: 0.5 }];
      for (const change of changes) {
        settings = { ...settings, ...change };
        own.take(settings, prepare.prepare(data, settings));
        for (let i = 0; i < 150; i++) {
          own.render(block);
          heard.push(...block[0]);
        }
      }
      done(heard);
    """
    steps = np.diff(node(script, run))[4800:]
    near = np.convolve(np.square(steps), np.ones(1920) / 1920, mode="same")
    assert np.max(np.abs(steps) / np.sqrt(near)) < 6


def test_chromium_renders_what_node_renders(vibrating: dict, opened, tmp_path) -> None:
    """An audio worklet has the same numbers, within the rounding of single precision."""
    page = tmp_path / "engine.html"
    page.write_text("<!doctype html><title>engine</title>")
    own = (ENGINE / "instrument.js").read_text()
    own = re.sub(r"^import .*\n|^export ", "", own, flags=re.MULTILINE)
    with opened(page) as browser:
        got = browser.evaluate(RENDER, [joined("engine/record.js") + own + PROCESSOR, vibrating])
    script = """
      const settings = data.settings, block = [new Float32Array(12800)];
      new instrument.Instrument(data, settings, prepare.prepare(data, settings)).render(block);
      done(block[0]);
    """
    wanted = np.array(node(script, vibrating))
    assert np.abs(np.array(got) - wanted).max() < 1e-5 * np.abs(wanted).max()
