"""Write the figures of tamaas that `rolling validate` compares with.

    pip install tamaas==2.9.0     # beside this program; AGPL licence, a job of its own
    python tests/benchmarks/tamaas_figures.py > scenarios/validation/tamaas.csv

Both solve the same non-periodic elastic contact on the same grid: a ball on a self-affine surface.
"""

from __future__ import annotations

import numpy as np
import tamaas as tm

from rolling import validate
from rolling.scene.file import read_scene
from rolling.scene.library import folder

TOLERANCE = 1e-8


def main() -> None:
    _, scene = next(iter(read_scene(folder() / "validation" / "rough-contact.yaml").runs()))
    gap, spacing = validate.rough_gap(scene, validate.COARSE)
    side = len(gap) * spacing
    tm.set_log_level(tm.LogLevel.error)
    print(f"# tamaas {tm.__version__} (AGPL): pip install tamaas=={tm.__version__}")
    print("# python tests/benchmarks/tamaas_figures.py > scenarios/validation/tamaas.csv")
    print("load_n,area_um2,max_pressure_gpa")
    for load in validate.LOADS_N:
        model = tm.Model(tm.model_type.basic_2d, [1.0, 1.0], list(gap.shape))  # side and E* are 1
        model.E, model.nu = 1.0, 0.0
        tm.ModelFactory.registerNonPeriodic(model, "dcfft")
        heights = np.ascontiguousarray((gap.min() - gap) / side)
        solver = tm.PolonskyKeerRey(model, heights, TOLERANCE)
        solver.setIntegralOperator("dcfft")
        solver.max_iter = 20000
        solver.solve(load / side**2 / scene.contact_modulus)
        pressure = np.array(model.traction) * scene.contact_modulus
        area = 1e12 * np.count_nonzero(pressure > 0) * spacing**2
        print(f"{load:g},{area:.6g},{1e-9 * pressure.max():.6g}", flush=True)


if __name__ == "__main__":
    main()
