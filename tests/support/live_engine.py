"""The engine of the page in Node, and runs for it: scenes on a force law that needs no march."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scene_sounds import sound_of_release, vibration_over

from acoustics import wav
from acoustics.arrays import Array
from rolling.dynamics.force_law import ForceLaw
from rolling.report import live
from rolling.scene.file import loads
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

ENGINE = Path(live.__file__).parent / "assets" / "engine"
SCENE = """
name: live
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 3,
  loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2,
  width_um: 128, seed: 1}
rolling: {load_n: 20, speed_m_s: 0.1, distance_mm: 6}
numerics: {step_nodes: 1}
dynamics: {}
"""
EDGES = {"plate.length_mm": 300, "plate.width_mm": 400, "plate.contact_mm": [129, 148]}


def node_path() -> str:
    """Return the program Node, or skip the test without it."""
    path = shutil.which("node")
    if path is None:
        message = "node: install Debian's `nodejs`"
        if os.environ.get("ROLLING_BROWSER_REQUIRED"):
            pytest.fail(message)
        pytest.skip(message)
    return path


def node(script: str, data: Any = None) -> Any:
    """Run a module in Node with `data`; return the value that it hands to `done`."""
    path = node_path()
    names = (
        "law",
        "chain",
        "motion",
        "complex",
        "plate",
        "radiation",
        "response",
        "prepare",
        "ritz",
        "worklet",
        "limiter",
        "effort",
    )
    head = "".join(f'import * as {name} from "{ENGINE / f"{name}.js"}";\n' for name in names)
    head += 'import { readFileSync, writeFileSync } from "node:fs";\n'
    head += 'const data = JSON.parse(readFileSync(0, "utf-8"));\n'
    head += "const plain = (k, v) => (ArrayBuffer.isView(v) ? Array.from(v) : v);\n"
    head += "const done = (v) => writeFileSync(1, JSON.stringify(v, plain));\n"
    arguments = [path, "--input-type=module", "-e", head + script]
    text = json.dumps(data)
    ended = subprocess.run(arguments, input=text, capture_output=True, text=True, check=False)
    assert not ended.returncode, ended.stderr
    return json.loads(ended.stdout)


def scene(changes: dict[str, Any] | None = None) -> Scene:
    """Return the scene with other values."""
    return loads(SCENE).with_(changes or {})


def roughness(count: int, rms: float, rng: np.random.Generator) -> Array:
    """Return a periodic profile of an rms at every 2 um."""
    wave = np.fft.rfftfreq(count, 2e-6) * 2 * np.pi
    height = np.exp(-np.square(wave * 4e-6) / 8) / (1 + np.square(wave * 6e-5))
    lines = height * (rng.standard_normal((2, wave.size)).T @ [1, 1j])
    profile = np.fft.irfft(lines, count)
    return np.asarray(profile * rms / profile.std())


def force_law(scene: Scene, profile: Array | None = None) -> ForceLaw:
    """Return the law on the track of a scene, lifted by a profile [m]; default: a rough contact."""
    count = scene.track.steps
    spacing = scene.track.step
    rng = np.random.default_rng(1)
    loads = scene.load * np.array([0.7, 1.0, 1.4])
    approach = np.cbrt(9 * loads**2 / (16 * scene.radius * scene.contact_modulus**2))
    slope = np.ones(count) if profile is not None else 1 + roughness(count, 0.02, rng)
    lift = roughness(count, 14e-9, rng) if profile is None else profile
    table = approach[1] + lift + (approach - approach[1])[:, None] * slope
    return ForceLaw(spacing * np.arange(count), loads, table, period_m=count * spacing)


def vibration(scene: Scene, law: ForceLaw) -> Vibration:
    return vibration_over(scene, law, wav.SAMPLE_RATE_HZ / 2)


def vibration_data(scene: Scene, law: ForceLaw, vibrating: Vibration) -> dict[str, Any]:
    """Return the data of a vibration for the engine."""
    sound = SimpleNamespace(
        source="vibration",
        duration=scene.duration,
        channels=vibrating.pressures.T,
        has_seam=False,
        levels=SimpleNamespace(laeq_db=None),
    )
    result = SimpleNamespace(solved_steps=len(law.position_m))
    parts = {"scene": scene, "sound": sound, "result": result, "label": "live", "values": {}}
    run: Any = SimpleNamespace(vibration_sound=vibrating, record_laeq_db=None, **parts)
    return json.loads(json.dumps(live.live_of(run)))


def release(scene: Scene) -> tuple[ContactSound, dict[str, Any]]:
    """Return the sound of a rough release, and its data for the engine."""
    step = scene.track.step
    rng = np.random.default_rng(2)
    energy = 1e-9 * (1 + 0.1 * roughness(scene.track.steps, 1.0, rng))
    sound = sound_of_release(scene, energy, step, True)
    heard = {"q": scene.sound.q, "distance": scene.sound.distance_m, "gain": None}
    data = {"kind": "release", "fixed": {"silent": False}, "limits": {"speed": [0, 1]}}
    settings = {"speed": scene.motion.fastest(scene.duration), "load": scene.load} | heard
    energies = {"start": step / 2, **live.release_lines(energy, step)} | heard
    return sound, data | {"settings": settings, "energy": energies}


def convolved(force: Array, responses: list[list[float]]) -> Array:
    """Return the channels of a force that repeats, through the responses of listeners."""
    count = len(force)
    laps = [np.pad(h, (0, -len(h) % count)).reshape(-1, count).sum(axis=0) for h in responses]
    return np.fft.irfft(np.fft.rfft(laps) * np.fft.rfft(force), count)


def record(
    run: dict[str, Any], settings: dict[str, Any], samples: int, most: int | None = None
) -> tuple[Array, dict[str, Any]]:
    """Return the channels [Pa] of whole laps of a run at settings, and what was prepared for them.

    All modes move, or `most` of them; the ball has rolled for two seconds before.
    """
    script = """
      const { run, settings, samples, most } = data;
      const prepared = prepare.prepare(run, settings, most ?? Infinity);
      const own = new worklet.Instrument({ run, settings, prepared });
      const force = [], block = new Float64Array(128);
      for (let done = 0; done < 96000 + samples; done += 128) {
        own.fill(block);
        force.push(...block);
      }
      const { responses, kept } = prepared;
      done({ force: force.slice(-samples), responses, kept });
    """
    data = {"run": run, "settings": settings, "samples": samples, "most": most}
    got = node(script, data)
    return convolved(np.array(got["force"]), got["responses"]), got
