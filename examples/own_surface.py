"""What does a ball sound like on grinding marks of your own, given as an array?"""

import numpy as np

import rolling as rc

SPACING_UM, LENGTH, WIDTH = 4.0, 256, 96  # nodes along and across
random = np.random.default_rng(7)
along = np.arange(LENGTH) / LENGTH
marks = sum(np.cos(2 * np.pi * (n * along + random.uniform())) for n in range(10, 30))
heights = np.repeat(0.02e-6 * marks[:, None], WIDTH, axis=1)  # m, the same across the track

scene = rc.Scene(
    name="marks",
    sphere=rc.Sphere(radius_mm=5, density_kg_m3=7850),
    plate=rc.Plate(youngs_modulus_gpa=210, poissons_ratio=0.3, density_kg_m3=7850, thickness_mm=10),
    surface=rc.HeightArray(heights, spacing_um=SPACING_UM),
    rolling=rc.Rolling(load_n=5, speed_m_s=0.1),  # once round the array
    dynamics=rc.Dynamics(),
)
run = rc.simulate(scene, workers=1, progress=False)
print(f"Vibration: {run.vibration}. A listener at 1 m would hear this.")
print(f"Released power: {run.released_power}.")
