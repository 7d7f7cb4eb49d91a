"""Solve one contact on a rough surface that yields at its hardness."""

import numpy as np

import rolling as rc
from rolling.scene.laws import Roughness
from rolling.surface.made import of_law

RADIUS, LOAD, MODULUS, HARDNESS, SPACING = 5e-3, 20.0, 231e9, 2.1e9, 2e-6  # SI

law = Roughness(roughness_ra_um=0.1, correlation_length_um=10, seed=1)
heights = of_law((128, 128), SPACING, law, law.seed)
x = (np.arange(128) - 63.5) * SPACING
gap = (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS) - heights
half_space = rc.HalfSpace(SPACING, MODULUS)
contact = rc.solve_contact(half_space, gap, LOAD, hardness=HARDNESS)

cell = SPACING**2
hertz_area = np.pi * rc.closed_forms.hertz_radius(LOAD, RADIUS, MODULUS) ** 2
print(f"load carried: {contact.pressure.sum() * cell:.6f} N of {LOAD} N")
print(f"contact area: {(contact.pressure > 0).sum() * cell / hertz_area:.2f} of the Hertz area")
print(
    f"plastic area: {(contact.pressure >= HARDNESS).sum() * cell / hertz_area:.2f} "
    "of the Hertz area"
)
print(f"KKT residual: {contact.residual:.1e} after {contact.iterations} iterations")
