"""Test of the estimated vibration: the level without dynamics against that of a run with them.

`python tests/benchmarks/vibration_estimate_study.py` runs small random scenes with dynamics, takes
the approach under the constant load from them, and prints the estimate beside the level of the run,
with three stiffnesses of the contact over that of the force law. `--scenes N` and `--first SEED`
choose other scenes. 36 scenes take about four minutes of one core.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence

import numpy as np
import pandas as pd
from small_scenes import small_scene

import rolling as rc
from rolling.in_si.physics_of_scene import bodies_of, listener_of, smooth_contact_of
from rolling.marches.stiffness import solved_stiffness
from rolling.results.run_errors import LINEAR
from rolling.sound.radiators import vibration_estimate

GOAL_DB = 3.0


def compare(seed: int) -> dict[str, float | str]:
    """Return levels, uncertainty and stiffnesses of a scene."""
    scene, ground = small_scene(seed)
    run = rc.simulate(scene, workers=1, progress=False)
    result = run.result
    numbers = run.numbers
    law = numbers.motion.contact_stiffness_n_m
    area = 2 * scene.contact_modulus * np.sqrt(result.series["contact_area"] / math.pi)
    solved = solved_stiffness(scene, result)
    stiffness = {
        "two loads": float(1 / np.mean(1 / solved)),
        "area": float(1 / np.mean(1 / area)),
        "smooth": smooth_contact_of(scene).stiffness_n_m,
    }
    approach = result.series["approach"]
    step = result.step
    closed = run.sound.closed
    estimate = vibration_estimate(
        bodies_of(scene), listener_of(scene), scene.motion, approach, step, closed, solved
    )
    return {
        "seed": seed,
        "ground": ground,
        "Nyquist kHz": numbers.record.highest_frequency_hz / 1e3,
        "resonance kHz": numbers.motion.resonance_hz / 1e3,
        "plastic": numbers.contact.plastic_area_mean_m2 / numbers.contact.area_mean_m2,
        "force ratio": numbers.motion.force_rms_ratio,
        "run dB(A)": numbers.levels.vibration.laeq_db,
        "off dB": estimate.laeq_db - numbers.levels.vibration.laeq_db,
        "± dB": estimate.uncertainty_db,
        **{name: value / law for name, value in stiffness.items()},
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the scenes and print the table and its statistics."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=36, help="number of scenes (36)")
    parser.add_argument("--first", type=int, default=1000, help="first seed (1000)")
    given = parser.parse_args(arguments)
    rows = []
    for seed in range(given.first, given.first + given.scenes):
        rows.append(compare(seed))
        print(rows[-1], file=sys.stderr, flush=True)
    table = pd.DataFrame(rows)
    print(table.round(3).to_string(index=False))
    for name in ("two loads", "area", "smooth"):
        spread = np.sqrt(np.mean(np.square(np.log(table[name]))))
        print(f"stiffness by {name}: {100 * spread:.0f} % rms from the force law")
    linear = table[table["force ratio"] <= LINEAR]
    off = linear["off dB"].abs()
    stated = linear["± dB"]
    count = len(linear)
    print(f"{count} scenes with a force ratio up to {LINEAR}:")
    print(f"{(off <= GOAL_DB).sum()} within {GOAL_DB:g} dB, {(off <= stated).sum()} within ±")
    print(f"{(off <= 2 * stated).sum()} within twice ±")
    sharp = linear[stated < GOAL_DB / 2]
    print(
        f"largest error of {len(sharp)} scenes with ± below 1.5 dB: "
        f"{sharp['off dB'].abs().max():.1f} dB"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
