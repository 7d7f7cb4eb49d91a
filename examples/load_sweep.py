"""Roll a ball under three loads, and draw the third octaves of all."""

from pathlib import Path

import matplotlib.pyplot as plt

import rolling as rc

SCENE = Path(__file__).parents[1] / "scenarios" / "quickstart.yaml"

scene = rc.read_scene(SCENE).with_(duration_s=0.006)  # 0.6 mm of track; the scene sweeps the load
runs = rc.simulate_sweep(scene, progress=False)
for load, run in runs.items():
    levels = run.sound.levels
    print(f"{load:5.0f} N: level of the released power (q = 1) {levels.laeq_db:.1f} dB(A)")

fig, ax = plt.subplots()
rc.plot.third_octaves(list(runs.values()), ax=ax)
fig.savefig("load_sweep.png")
