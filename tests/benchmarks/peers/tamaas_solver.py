"""tamaas: Polonsky and Keer's conjugate gradients, and Kato's with a hardness, warm-started.

It works in units of its own (contact modulus 1 and a domain of width 4, or 1 where the plate is
elastic): in SI the solver with a hardness stalls. The script needs numpy and tamaas;
`problem.answer` describes its command line.
"""

import numpy as np
import tamaas
from problem import Problem, Solve, Unsolved, answer

MAX_ITERATIONS = 6000
NEVER = 10**9  # iterations between two lines of its progress

tamaas.set_log_level(tamaas.LogLevel.error)


def solver(problem: Problem, tolerance: float) -> Solve:
    """Return a function that solves one position."""
    is_elastic = np.isinf(problem.hardness)
    side = 1.0 if is_elastic else 4.0
    unit = problem.width / side
    model = tamaas.Model(tamaas.model_type.basic_2d, [side, side], [problem.nodes] * 2)
    model.E = 1.0
    model.nu = 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")

    def solve(gap, start):
        surface = np.ascontiguousarray(-gap / unit)
        surface -= surface.max()
        model.traction[:] = 0 if start is None else start / problem.contact_modulus
        if is_elastic:
            contact = tamaas.PolonskyKeerRey(model, surface, tolerance)
        else:
            cap = problem.hardness / problem.contact_modulus
            contact = tamaas.KatoSaturated(model, surface, tolerance, cap)
        contact.setIntegralOperator("dcfft")
        contact.max_iter = MAX_ITERATIONS
        contact.dump_freq = NEVER
        error = contact.solve(problem.mean_pressure / problem.contact_modulus)
        if not error <= tolerance:
            raise Unsolved(f"did not converge within {MAX_ITERATIONS} iterations")
        return np.array(model.traction) * problem.contact_modulus, None

    return solve


if __name__ == "__main__":
    answer(solver)
