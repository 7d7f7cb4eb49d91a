"""The engine of the page beside the program: the same sound at many settings, and its speed.

`python tests/benchmarks/live_study.py` marches 6 mm of a track and needs Node; two minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import live_engine
from live_engine import EDGES, node, record, vibration, vibration_data

import rolling as rc
from acoustics import level, wav
from acoustics.bands import BAND_NAMES, reliable
from rolling.dynamics.force_law import ForceLaw
from rolling.scene.scene import Scene

THIN = EDGES | {"plate.thickness_mm": 1}
THICK = EDGES | {"plate.thickness_mm": 10}
STEREO = {"sound.listener_mm": [[100, 150, 500], [250, 60, 700]]}
BELOW = {"sound.listener_mm": [100, 150, -500]}
HALF_SPACE = {"plate.thickness_mm": None, "plate.loss_factor": None}
SHARP = THICK | {"plate.loss_factor": 1e-3}
# Scenes, and the settings of their pages that change: keys of the scene and of the engine, factor.
SCENES = {
    "infinite plate, 3 mm": {},
    "half-space": HALF_SPACE,
    "0.3 x 0.4 m, 10 mm": THICK,
    "0.3 x 0.4 m, 10 mm, two listeners": THICK | STEREO,
    "0.3 x 0.4 m, 10 mm, loss factor 0.001": SHARP,
    "0.3 x 0.4 m, 1 mm, heard from below": THIN | BELOW,
}
SETTINGS = {
    "speed 0.3 m/s": ({"rolling.speed_m_s": 0.3}, {"speed": 0.3}),
    "speed 1 m/s": ({"rolling.speed_m_s": 1}, {"speed": 1.0}),
    "thickness 5 mm": ({"plate.thickness_mm": 5}, {"thickness": 5e-3}),
    "ball of glass": ({"sphere.density_kg_m3": 2500}, {"ballDensity": 2500.0}),
    "edges 0.25 x 0.5 m": (
        {"plate.length_mm": 250, "plate.width_mm": 500},
        {"length": 0.25, "width": 0.5},
    ),
    "loss factor 0.05": ({"plate.loss_factor": 0.05}, {"lossFactor": 0.05}),
    "contact loss factor 0.02": (
        {"plate.contact_loss_factor": 0.02},
        {"contactLossFactor": 0.02},
    ),
    "distance 0.3 m": ({"sound.distance_m": 0.3}, {"distance": 0.3}),
}
RENDER = """
  const prepared = prepare.prepare(data.run, data.run.settings, data.most);
  const own = new worklet.Instrument({ run: data.run, settings: data.run.settings, prepared });
  const block = new Float32Array(128);
  const seconds = () => process.cpuUsage().user / 1e6;
  let begun = 0;
  for (let i = 0; i < 1875; i++) {
    if (i === 375) begun = seconds(); // compiled by then
    own.fill(block);
  }
  done({ share: (seconds() - begun) / 4, steps: prepared.steps, modes: prepared.kept.modes });
"""


def differences(got: np.ndarray, wanted: level.SoundLevels, highest: float) -> tuple[str, float]:
    """Return the largest difference of a reliable third octave in words, and that of LAeq [dB]."""
    found = level.sound_levels(got, wav.SAMPLE_RATE_HZ, highest)
    seconds = len(got) / 48000
    bands = [
        (found.third_octave_db[name] - wanted.third_octave_db[name], name)
        for name, known in zip(BAND_NAMES, reliable(seconds), strict=True)
        if known and wanted.third_octave_db[name] is not None
    ]
    off, name = max(bands, key=lambda band: abs(band[0]))
    return f"{off:+.2f} dB at {name} Hz", found.laeq_db - wanted.laeq_db


def row(
    name: str, run: dict[str, Any], settings: dict[str, Any], law: ForceLaw, scene: Scene
) -> None:
    """Print the differences between engine and program at settings."""
    wanted = vibration(scene, law)
    got, prepared = record(run, run["settings"] | settings, wanted.pressures.shape[1])
    for channel, levels in zip(got, wanted.listener_levels(), strict=True):
        bands, laeq = differences(channel, levels, wanted.highest)
        print(f"| {name} | {prepared['kept']['modes']} | {bands} | {laeq:+.3f} dB |", flush=True)


def main() -> None:
    """Print the tables of equality, of kept modes and of speed."""
    base = live_engine.scene({"surface.width_um": 256})
    marched = rc.simulate(base, workers=1, progress=False)
    assert marched.vibration_sound is not None
    law = marched.vibration_sound.law
    print("| scene | modes | largest difference of a third octave | difference of LAeq |")
    print("|---|---|---|---|")
    runs = {}
    for name, changes in SCENES.items():
        scene = base.with_(changes)
        runs[name] = vibration_data(scene, law, vibration(scene, law))
        row(name, runs[name], {}, law, scene)
    for name, (changes, settings) in SETTINGS.items():
        edged = "edges" in name or name.startswith(("loss", "contact", "distance"))
        begun = base.with_(THICK if edged else {})
        run = runs["0.3 x 0.4 m, 10 mm" if edged else "infinite plate, 3 mm"]
        row(name, run, settings, law, begun.with_(changes))
    for changes, settings in (
        ({}, {}),
        ({"rolling.speed_m_s": 0.3}, {"speed": 0.3}),
        ({"sound.q": 0.01, "sound.distance_m": 2}, {"q": 0.01, "distance": 2}),
    ):
        begun = base.with_({"sound.source": "release"})
        _, run = live_engine.release(begun)
        sound, _ = live_engine.release(begun.with_(changes))
        (got,), _ = record(run, run["settings"] | settings, len(sound.pressure))
        bands, laeq = differences(got, sound.levels, sound.highest)
        print(f"| release {settings or ''} | | {bands} | {laeq:+.3f} dB |")
    kept_modes(base, law)
    speed(base, law)


def kept_modes(base: Scene, law: ForceLaw) -> None:
    """Print what it costs to move fewer modes than a plate has: estimated, and heard."""
    print("\n| plate | kept modes | estimated cost | cost |\n|---|---|---|---|")
    for thickness in (1, 3):
        scene = base.with_(THIN | {"plate.thickness_mm": thickness, "rolling.speed_m_s": 0.3})
        run = vibration_data(scene, law, vibration(scene, law))
        settings = run["settings"]
        every = level.laeq_db(record(run, settings, 24_000)[0][0], 48000)
        for most in (30, 100, 300):
            (got,), prepared = record(run, settings, 24_000, most)
            heard = level.laeq_db(got, 48000)
            kept = prepared["kept"]
            print(
                f"| {thickness} mm | {kept['modes']} of {kept['of']} | {kept['costDb']:.2f} dB |"
                f" {abs(heard - every):.2f} dB |",
                flush=True,
            )


def speed(base: Scene, law: ForceLaw) -> None:
    """Print the processor time of the instrument over the time of its sound."""
    print("\n| modes | time steps per sample | share of real time |\n|---|---|---|")
    for most in (0, 30, 100, 300):
        scene = base.with_({**(EDGES if most else {}), "plate.thickness_mm": 3})
        run = vibration_data(scene, law, vibration(scene, law))
        got = node(RENDER, {"run": run, "most": most})
        print(f"| {got['modes']} | {got['steps']} | {got['share']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
