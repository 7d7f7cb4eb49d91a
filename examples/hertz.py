"""How exact is one smooth contact, against the closed forms of Hertz?"""

import numpy as np

import rolling as rc

RADIUS, LOAD, MODULUS = 5e-3, 20.0, 231e9  # m, N, Pa: a steel plate under a rigid ball

hertz_approach = rc.closed_forms.hertz_approach(LOAD, RADIUS, MODULUS)
hertz_pressure = rc.closed_forms.hertz_pressure(LOAD, RADIUS, MODULUS)
for spacing in (8e-6, 4e-6, 2e-6):
    half = round(160e-6 / spacing)  # of the window, in nodes; the contact radius is 69 um
    x = np.arange(-half, half + 1) * spacing
    gap = (x[:, None] ** 2 + x[None, :] ** 2) / (2 * RADIUS)
    contact = rc.solve_contact(rc.HalfSpace(spacing, MODULUS), gap, LOAD)
    approach_error = contact.approach / hertz_approach - 1
    pressure_error = contact.max_pressure / hertz_pressure - 1
    print(
        f"On nodes of {spacing * 1e6:.0f} um the approach is off by {100 * approach_error:+.3f} %"
        f" and the maximum pressure by {100 * pressure_error:+.2f} %."
    )
