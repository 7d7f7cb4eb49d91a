"""Roll a ball under three loads and draw the third octaves."""

from pathlib import Path

import matplotlib.pyplot as plt

import rolling as rc

SCENE = Path(__file__).parents[1] / "scenarios" / "quickstart.yaml"

if __name__ == "__main__":
    scene = rc.read_scene(SCENE).with_(duration_s=0.006)
    runs = rc.simulate_sweep(scene, progress=False)
    for run in runs.values():
        levels = run.sound.levels
        print(f"{run.scene.load:5.0f} N: LAeq {levels.laeq_db:.1f} dB(A), LZeq {levels.level_db:.1f} dB")
    fig, ax = plt.subplots()
    rc.plot.third_octaves(list(runs.values()), ax=ax)
    fig.savefig("load_sweep.png")
