"""How much of a rough surface does a ball touch, and how much of it yields?"""

import numpy as np

import rolling as rc

RADIUS, LOAD, MODULUS, HARDNESS = 5e-3, 20.0, 231e9, 2.1e9  # SI
SPACING, NODES = 2e-6, 128
ROUGHNESS, LENGTH = 0.1e-6, 10e-6  # m: Ra, and 1/e of the autocorrelation

# A Gaussian surface: white noise whose waves have the amplitudes of the autocorrelation.
noise = np.random.default_rng(1).standard_normal((NODES, NODES))
waves = np.fft.fftfreq(NODES, SPACING)  # 1/m
amplitudes = np.exp(-((np.pi * LENGTH) ** 2) * (waves[:, None] ** 2 + waves**2) / 2)
heights = np.fft.ifft2(np.fft.fft2(noise) * amplitudes).real
heights *= ROUGHNESS / np.abs(heights).mean()

x = (np.arange(NODES) - (NODES - 1) / 2) * SPACING
gap = (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS) - heights
contact = rc.solve_contact(rc.HalfSpace(SPACING, MODULUS), gap, LOAD, hardness=HARDNESS)

hertz_area = np.pi * rc.closed_forms.hertz_radius(LOAD, RADIUS, MODULUS) ** 2
touching = contact.contact_area / hertz_area
yielding = contact.plastic_area / hertz_area
print(f"The ball touches {100 * touching:.0f} % of the area of a smooth contact (Hertz).")
print(f"{100 * yielding:.0f} % of that area yields at {HARDNESS * 1e-9:.1f} GPa.")
print(f"The asperities carry {contact.load:.4f} N of {LOAD:.0f} N.")
print(f"The KKT residual is {contact.residual:.0e} after {contact.iterations} iterations.")
