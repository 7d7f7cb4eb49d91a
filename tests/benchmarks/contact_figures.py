"""Write the figures of public contact solvers that `rolling validate` compares with.

    python tests/benchmarks/contact_figures.py tamaas=PYTHON ContactMechanics=PYTHON \\
        slippy=PYTHON > scenarios/validation/contact_solvers.csv

PYTHON is the interpreter of an environment that needs numpy and that solver only; the table of
public solvers in README.md installs them. All solve the same non-periodic contact of a ball on a
self-affine surface on the same grid, elastic and with a hardness, in units of side and contact
modulus. The approach is the mean over the nodes between the bounds of gap plus deflection.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

TOLERANCE = 1e-8
MAX_ITERATIONS = 20000
LOAD_TOLERANCE = 1e-6  # of the secants of slippy
Solved = tuple[np.ndarray, np.ndarray]  # pressure and deflection


def tamaas(gap: np.ndarray, load: float, hardness: float) -> Solved:
    """Solve an elastic contact by Polonsky and Keer; Kato's method for a hardness is left out."""
    import tamaas as tm

    assert np.isinf(hardness)
    tm.set_log_level(tm.LogLevel.error)
    model = tm.Model(tm.model_type.basic_2d, [1.0, 1.0], list(gap.shape))
    model.E = 1.0
    model.nu = 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.PolonskyKeerRey(model, np.ascontiguousarray(gap.min() - gap), TOLERANCE)
    solver.setIntegralOperator("dcfft")
    solver.max_iter = MAX_ITERATIONS
    solver.solve(load)
    deflection = np.zeros(gap.shape)  # the solver leaves gaps in the displacement of its model
    model.operators["dcfft"](model.traction, deflection)
    return np.array(model.traction), deflection


def contact_mechanics(gap: np.ndarray, load: float, hardness: float) -> Solved:
    """Solve by the constrained conjugate gradients of ContactMechanics."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    cell = 1 / gap.size
    half_space = FreeFFTElasticHalfSpace(gap.shape, 1.0, (1.0, 1.0))
    solved = constrained_conjugate_gradients(
        half_space,
        Topography(gap.min() - gap, (1.0, 1.0)),
        hardness=None if np.isinf(hardness) else hardness * cell,
        external_force=load,
        pentol=TOLERANCE * float(np.ptp(gap)),
        forcetol=TOLERANCE * load,
        thermotol=TOLERANCE,
        maxiter=MAX_ITERATIONS,
    )
    if not solved.success:
        raise SystemExit(f"ContactMechanics: {solved.message}")
    rows, columns = gap.shape
    return solved.jac / cell, solved.x[:rows, :columns]


def slippy(gap: np.ndarray, load: float, hardness: float) -> Solved:
    """Solve at given approaches by conjugate gradients of slippy, and meet the load by secants."""
    from slippy.contact import Elastic, _step_utils
    from slippy.core import plan_convolve

    side = gap.shape[0]
    cell = 1 / gap.size
    solid = Elastic("solid", {"E": 1.0, "v": 0.0}, use_frequency_domain=False)
    love = solid.influence_matrix(["zz"], [1 / side] * 2, (2 * side, 2 * side))["zz"]
    everywhere = np.ones(gap.shape, dtype=bool)
    deflect = plan_convolve(np.zeros(gap.shape), love, everywhere, circular=(False, False))
    pressure = np.zeros(gap.size)
    before = None
    approach = float(np.sort(gap, axis=None)[gap.size // 100])
    slope = 0.5 * load / (approach - gap.min())
    for _ in range(40):
        with contextlib.redirect_stdout(io.StringIO()):
            start = pressure
            overlap = approach - gap.ravel()
            solved, _ = _step_utils.bccg(
                deflect, overlap, TOLERANCE, MAX_ITERATIONS, start, 0, hardness
            )
        pressure = np.nan_to_num(solved)
        carried = float(pressure.sum() * cell)
        if abs(carried / load - 1) < LOAD_TOLERANCE:
            deflection = np.asarray(deflect(pressure)).reshape(gap.shape)
            return pressure.reshape(gap.shape), deflection
        if before is not None and before[0] != approach:
            slope = (carried - before[1]) / (approach - before[0])
        before = approach, carried
        approach += (load - carried) / slope
    raise SystemExit("slippy does not meet the load")


SOLVERS: dict[str, Callable[[np.ndarray, float, float], Solved]] = {
    "tamaas": tamaas, "ContactMechanics": contact_mechanics, "slippy": slippy,
}  # fmt: skip
# Pairs of hardness [GPa] and load [N].
ELASTIC = ((math.inf, 10), (math.inf, 50))
YIELDING = ((6, 10), (6, 50))
CONTACTS = {"tamaas": ELASTIC} | dict.fromkeys(("ContactMechanics", "slippy"), ELASTIC + YIELDING)


def solve(name: str, file: str) -> None:
    """Print the figures of one solver for the contact of a file, as JSON in its units."""
    stored = np.load(file)
    gap = stored["gap"]
    hardness = float(stored["hardness"])
    pressure, deflection = SOLVERS[name](gap, float(stored["load"]), hardness)
    plastic = pressure >= hardness * (1 - TOLERANCE)
    between = (pressure > 0) & ~plastic
    approach = float((gap + deflection)[between].mean())
    counts = int((pressure > 0).sum()), int(plastic.sum())
    print(json.dumps([*counts, float(pressure.max()), approach]))


def version(name: str, python: str) -> str:
    """Return the version of a solver that is installed beside an interpreter."""
    words = f"from importlib.metadata import version; print(version('{name}'))"
    return subprocess.check_output([python, "-c", words], text=True, env=environment()).strip()


def environment() -> dict[str, str]:
    """Return an environment for another interpreter; ours may lead to our packages."""
    return {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}


def main(peers: list[str]) -> None:
    """Solve the contacts by each peer NAME=PYTHON and print the table."""
    from rolling.kinds.reading import read_scene
    from rolling.studies import validate

    _, scene = next(iter(read_scene(validate.FOLDER / "rough-contact.yaml").runs()))
    gap, spacing = validate.rough_gap(scene, validate.COARSE)
    side = len(gap) * spacing
    modulus = scene.contact_modulus
    print("# python tests/benchmarks/contact_figures.py > scenarios/validation/contact_solvers.csv")
    print("# hardness in GPa, load in N, areas in um2, pressure in GPa, approach in um")
    print("solver,hardness,load,area,plastic area,pressure,approach")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "contact.npz"
        for name, _, python in (peer.partition("=") for peer in peers):
            solver = f"{name} {version(name, python)}"
            for hardness, load in CONTACTS[name]:
                units = load / side**2 / modulus, 1e9 * hardness / modulus
                np.savez(file, gap=gap / side, load=units[0], hardness=units[1])
                command = [python, __file__, "--solve", name, str(file)]
                answer = subprocess.check_output(command, text=True, env=environment())
                nodes, plastic, pressure, approach = json.loads(answer.splitlines()[-1])
                areas = [f"{1e12 * spacing**2 * number:.6g}" for number in (nodes, plastic)]
                highest = f"{1e-9 * modulus * pressure:.6g}"
                bounds = ["", highest] if math.isinf(hardness) else [areas[1], ""]
                words = (
                    f"{hardness:g}",
                    f"{load:g}",
                    areas[0],
                    *bounds,
                    f"{1e6 * side * approach:.6g}",
                )
                print(solver, *words, sep=",", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--solve"]:
        solve(*sys.argv[2:])
    else:
        main(sys.argv[1:])
