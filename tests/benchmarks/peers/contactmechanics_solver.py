"""ContactMechanics: Polonsky and Keer's conjugate gradients with a hardness, warm-started.

The script needs numpy and ContactMechanics; `problem.answer` describes its command line.
"""

import numpy as np
from ContactMechanics import FreeFFTElasticHalfSpace
from ContactMechanics.Optimization import constrained_conjugate_gradients
from problem import Problem, Solve, Unsolved, answer
from SurfaceTopography import Topography

MAX_ITERATIONS = 2000


def solver(problem: Problem, tolerance: float) -> Solve:
    """Return a function that solves one position.

    Tolerances of the program are lengths and forces: those of a smooth elastic contact count.
    """
    n = problem.nodes
    sides = (problem.width, problem.width)
    cell = problem.spacing**2
    half_space = FreeFFTElasticHalfSpace((n, n), problem.contact_modulus, sides)
    hardness = None if np.isinf(problem.hardness) else problem.hardness * cell

    def solve(gap, start):
        forces = None
        if start is not None:
            forces = np.zeros((2 * n, 2 * n))
            forces[:n, :n] = -start * cell
        solved = constrained_conjugate_gradients(
            half_space,
            Topography(-gap, physical_sizes=sides),
            hardness=hardness,
            external_force=problem.load,
            initial_forces=forces,
            pentol=tolerance * problem.hertz_approach,
            forcetol=tolerance * problem.hertz_pressure * cell,
            thermotol=tolerance,
            maxiter=MAX_ITERATIONS,
        )
        if not solved.success:
            raise Unsolved(f"did not converge within {MAX_ITERATIONS} iterations")
        return solved.jac / cell, solved.nfev

    return solve


if __name__ == "__main__":
    answer(solver)
