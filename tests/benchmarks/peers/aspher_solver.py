"""aspher (elastic only) with its FFT solver and preconditioner, warm-started.

The script needs numpy and aspher; `problem.answer` describes its command line.
"""

import aspher
import numpy as np
from problem import Problem, Solve, Unsolved, answer


def solver(problem: Problem, tolerance: float) -> Solve:
    """Return a function that solves one position."""
    if np.isfinite(problem.hardness):
        raise Unsolved("no pressure has a maximum")
    elastic = aspher.ContactSolver(
        grid_size=problem.nodes,
        domain_size=problem.width,
        E_star=problem.contact_modulus,
        backend="fft",
    )

    def solve(gap, start):
        solved = elastic.solve(
            gap.ravel(),
            problem.mean_pressure,
            tol=tolerance,
            precond="fourier",
            p_init=None if start is None else start.ravel(),
        )
        if not solved.converged:
            raise Unsolved("did not converge")
        return solved.pressure, solved.matvec_count

    return solve


if __name__ == "__main__":
    answer(solver)
