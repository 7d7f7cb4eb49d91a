"""aspher (elastic only) over a sequence, with its FFT solver and preconditioner, warm-started.

The script needs numpy and aspher.

python aspher_sequence.py A 1e-6 20 out.npz    (CPU seconds, convolutions, pressures by position)
"""

from time import process_time

import aspher
import numpy as np
from sequences import CONTACT_MODULUS, SEQUENCES, SPACING, N, arguments, gap, moved_on

name, tolerance, steps, out = arguments()
width = N * SPACING
solver = aspher.ContactSolver(grid_size=N, domain_size=width, E_star=CONTACT_MODULUS, backend="fft")
start = None
seconds = []
convolutions = []
pressures = []
for k in range(steps + 1):
    shape = gap(name, k).ravel()
    began = process_time()
    solved = solver.solve(
        shape, SEQUENCES[name].load / width**2, tol=tolerance, precond="fourier", p_init=start
    )
    seconds.append(process_time() - began)
    if not solved.converged:
        raise SystemExit(
            f"aspher did not converge at position {k} of sequence {name}, tolerance {tolerance:g}"
        )
    convolutions.append(solved.matvec_count)
    pressures.append(np.array(solved.pressure).reshape(N, N))
    start = moved_on(pressures[-1]).ravel()
np.savez(out, seconds=seconds, convolutions=convolutions, pressures=pressures)
