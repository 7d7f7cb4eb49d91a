"""slippy, warm-started.

Its conjugate gradients, bounded by 0 and the hardness, solve at a given approach. A secant in the
approach meets the load. Pressure, approach and slope give the warm start. The script needs numpy
and slippy; `problem.answer` describes its command line.
"""

import contextlib
import io
import itertools
import warnings

import numpy as np
from problem import Problem, Solve, Unsolved, answer

warnings.simplefilter("ignore")
import slippy  # noqa: E402
from slippy.contact import Elastic, _step_utils  # noqa: E402
from slippy.core import plan_convolve  # noqa: E402

slippy.CORES = 1
MAX_SECANTS = 15
MAX_ITERATIONS = 2000
# times the tolerance: the load need not be met better than the pressures are known
LOAD_TOLERANCE = 10

plate_names = map("plate {}".format, itertools.count())  # materials have unique names


class Deflection:
    """The convolution of slippy with Love's coefficients, counted."""

    def __init__(self, problem: Problem) -> None:
        n = problem.nodes
        moduli = {"E": problem.contact_modulus, "v": 0}
        plate = Elastic(next(plate_names), moduli, use_frequency_domain=False)
        love = plate.influence_matrix(
            components=["zz"], grid_spacing=[problem.spacing] * 2, span=(2 * n, 2 * n)
        )["zz"]
        everywhere = np.ones((n, n), dtype=bool)
        self.convolve = plan_convolve(np.zeros((n, n)), love, everywhere, circular=(False, False))
        self.count = 0

    def __call__(self, pressure):
        self.count += 1
        return self.convolve(pressure)


class Rolling:
    """The state that a position passes on: pressure, approach and slope of the load."""

    def __init__(self, problem: Problem, tolerance: float) -> None:
        self.problem = problem
        self.tolerance = tolerance
        self.deflect = Deflection(problem)
        self.pressure = np.zeros(problem.nodes**2)
        self.approach: float | None = None
        self.slope = 0.0

    def begin(self, gap) -> None:
        """Guess the approach: that of Hertz, over as many nodes as carry the load."""
        problem = self.problem
        pressure = min(problem.hardness, 2.5 * problem.hertz_pressure)
        nodes = int(problem.load / pressure / problem.spacing**2)
        lowest = np.sort(gap.ravel())[min(nodes, gap.size - 1)]
        self.approach = lowest + 0.6 * problem.hertz_approach
        self.slope = 1.5 * problem.load / problem.hertz_approach

    def carried(self, gap) -> float:
        """Solve for the load carried at the present approach."""
        with contextlib.redirect_stdout(io.StringIO()):
            overlap = self.approach - gap.ravel()
            solved, _ = _step_utils.bccg(
                self.deflect,
                overlap,
                self.tolerance,
                MAX_ITERATIONS,
                self.pressure,
                0,
                self.problem.hardness,
            )
        self.pressure = np.nan_to_num(solved)
        return float(self.pressure.sum() * self.problem.spacing**2)

    def __call__(self, gap, start):
        """Vary the approach by the secant method until the load is met."""
        count = self.deflect.count
        if start is None:
            self.begin(gap)
        else:
            self.pressure = start.ravel()
        before = None
        target = self.problem.load
        for _ in range(MAX_SECANTS):
            load = self.carried(gap)
            if abs(load / target - 1) < LOAD_TOLERANCE * self.tolerance:
                return self.pressure, self.deflect.count - count
            if before is not None and before[0] != self.approach:
                self.slope = (load - before[1]) / (self.approach - before[0])
            before = (self.approach, load)
            self.approach += (target - load) / self.slope
        raise Unsolved(f"did not meet the load within {MAX_SECANTS} secants")


def solver(problem: Problem, tolerance: float) -> Solve:
    """Return a function that solves one position after another."""
    return Rolling(problem, tolerance)


if __name__ == "__main__":
    answer(solver)
