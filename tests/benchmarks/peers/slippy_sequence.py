"""slippy over a sequence.

Its conjugate gradients, bounded by 0 and the hardness, solve at a given approach. A secant in the
approach meets the load. Pressure, approach and slope give the warm start. The script needs numpy
and slippy.

python slippy_sequence.py B 1e-5 20 out.npz    (CPU seconds, convolutions, pressures by position)
"""

import contextlib
import io
import warnings
from time import process_time

import numpy as np
from sequences import (
    POISSONS_RATIO,
    SEQUENCES,
    SPACING,
    YOUNGS_MODULUS,
    N,
    arguments,
    gap,
    moved_on,
)

warnings.simplefilter("ignore")
import slippy  # noqa: E402
from slippy.contact import Elastic, _step_utils  # noqa: E402
from slippy.core import plan_convolve  # noqa: E402

slippy.CORES = 1
MAX_SECANTS = 15
MAX_ITERATIONS = 2000
# times the tolerance: the load need not be met better than the pressures are known
LOAD_TOLERANCE = 10


class Deflection:
    """The convolution of slippy with Love's coefficients, counted."""

    def __init__(self) -> None:
        steel = Elastic(
            "steel", {"E": YOUNGS_MODULUS, "v": POISSONS_RATIO}, use_frequency_domain=False
        )
        love = steel.influence_matrix(
            components=["zz"], grid_spacing=[SPACING] * 2, span=(2 * N, 2 * N)
        )["zz"]
        everywhere = np.ones((N, N), dtype=bool)
        self.convolve = plan_convolve(np.zeros((N, N)), love, everywhere, circular=(False, False))
        self.count = 0

    def __call__(self, pressure):
        self.count += 1
        return self.convolve(pressure)


class Rolling:
    """The state that a position passes on: pressure, approach and slope of the load."""

    def __init__(self, load: float, hardness: float, shape: np.ndarray) -> None:
        self.load = load
        self.hardness = hardness
        self.deflect = Deflection()
        self.pressure = np.zeros(N * N)
        # A first guess: as many nodes overlap as carry the load at the hardness, and Hertz's
        # approach on top (1 um at 50 N).
        nodes = int(load / min(hardness, 5e9) / SPACING**2)
        hertz = 1e-6 * (load / 50) ** (2 / 3)
        self.approach = np.sort(shape)[nodes] + hertz
        self.slope = 1.5 * load / hertz

    def carried(self, shape: np.ndarray, tolerance: float) -> float:
        """Solve for the load carried at the present approach."""
        with contextlib.redirect_stdout(io.StringIO()):
            overlap = self.approach - shape
            solved, _ = _step_utils.bccg(
                self.deflect, overlap, tolerance, MAX_ITERATIONS, self.pressure, 0, self.hardness
            )
        self.pressure = np.nan_to_num(solved)
        return float(self.pressure.sum() * SPACING**2)

    def solve(self, shape: np.ndarray, tolerance: float) -> None:
        """Vary the approach by the secant method until the load is met."""
        before = None
        for _ in range(MAX_SECANTS):
            load = self.carried(shape, tolerance)
            if abs(load / self.load - 1) < LOAD_TOLERANCE * tolerance:
                return
            if before is not None and before[0] != self.approach:
                self.slope = (load - before[1]) / (self.approach - before[0])
            before = (self.approach, load)
            self.approach += (self.load - load) / self.slope
        raise SystemExit(
            f"slippy did not meet the load within {MAX_SECANTS} secants at tolerance {tolerance:g}"
        )


name, tolerance, steps, out = arguments()
sequence = SEQUENCES[name]
rolling = Rolling(sequence.load, sequence.hardness, gap(name, 0).ravel())
seconds = []
convolutions = []
pressures = []
for k in range(steps + 1):
    shape = gap(name, k).ravel()
    count = rolling.deflect.count
    began = process_time()
    rolling.pressure = moved_on(rolling.pressure.reshape(N, N)).ravel()
    rolling.solve(shape, tolerance)
    seconds.append(process_time() - began)
    convolutions.append(rolling.deflect.count - count)
    pressures.append(rolling.pressure.reshape(N, N).copy())
np.savez(out, seconds=seconds, convolutions=convolutions, pressures=pressures)
