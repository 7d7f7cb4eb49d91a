"""Roll a ball over a surface of your own: grinding marks as an array, to a level."""

import tempfile
from pathlib import Path

import numpy as np

import rolling as rc

SPACING = 4e-6  # m
along = np.arange(256) * SPACING
period = 256 * SPACING
rng = np.random.default_rng(7)
marks = sum(
    np.cos(2 * np.pi * n * along / period + rng.uniform(0, 2 * np.pi)) for n in range(10, 30)
)
heights = np.repeat(0.02e-6 * marks[:, None], 96, axis=1)  # the same across the track

scene = rc.read_scene(Path(__file__).parents[1] / "scenarios" / "quickstart.yaml").to_dict()
scene.pop("sweep", None)
with tempfile.TemporaryDirectory() as folder:
    np.save(Path(folder) / "marks.npy", heights)
    scene |= {"name": "marks", "surface": {"kind": "file", "path": "marks.npy", "spacing_um": 4.0}}
    scene["rolling"] = {"load_n": 20.0, "speed_m_s": 0.1}  # once round the file
    run = rc.simulate(rc.Scene.from_dict(scene, Path(folder)), workers=1, progress=False)
print(
    f"release power {np.mean(run.release_power):.2e} W,"
    f" its level with q = 1: {run.sound.levels.laeq_db:.1f} dB(A), an upper bound"
)
