"""Is a steel ball louder under a higher load?"""

import matplotlib.pyplot as plt

import rolling as rc

scene = rc.read_scene("vibrating-ball").with_(duration_s=0.01)  # 1 mm of track; it sweeps the load
runs = rc.simulate_sweep(scene, progress=False)
for load, run in runs.items():
    print(
        f"Under {load:.0f} N the vibration has {run.vibration.number} dB(A): a listener at 1 m"
        f" would hear this. The released power, an upper bound, has {run.released_power.number}"
        " dB(A)."
    )

lightest, *_, heaviest = runs.values()
difference = heaviest.vibration.value - lightest.vibration.value
word = "louder" if difference > 0 else "quieter"
print(f"Under 100 N the ball is {abs(difference):.1f} dB {word} than under 5 N.")

fig, ax = plt.subplots()
rc.plot.third_octaves(runs.values(), ax=ax, a_weighted=True)
fig.savefig("load_sweep.png")
