"""Compare one smooth contact with the closed forms of Hertz."""

import numpy as np

import rolling as rc

RADIUS, LOAD, MODULUS = 5e-3, 20.0, 231e9  # m, N, Pa: a steel plate under a rigid ball

for spacing in (8e-6, 4e-6, 2e-6):
    half = round(160e-6 / spacing)  # of the window, in nodes; the contact radius is 69 um
    x = np.arange(-half, half + 1) * spacing
    gap = (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)
    contact = rc.solve_contact(rc.HalfSpace(spacing, MODULUS), gap, LOAD)
    approach = rc.closed_forms.hertz_approach(LOAD, RADIUS, MODULUS)
    peak = rc.closed_forms.hertz_pressure(LOAD, RADIUS, MODULUS)
    print(
        f"spacing {spacing * 1e6:.0f} um: approach off by {contact.approach / approach - 1:+.1e},"
        f" maximum pressure off by {contact.pressure.max() / peak - 1:+.1e}"
    )
