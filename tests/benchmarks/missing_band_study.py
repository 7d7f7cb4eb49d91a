"""Test of the missing band: what long steps cut off, as estimated and as shorter steps add it.

`python tests/benchmarks/missing_band_study.py` marches surfaces with steps of four, two and one
nodes, at speeds at which the bands end within hearing. The level with the estimated band should be
that of the shortest steps with its own, smaller band. `--scenes N` and `--first SEED` choose other
scenes. 16 scenes take about five minutes of one core.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from small_scenes import small_scene

import rolling as rc

LONGEST = 4  # nodes of a step
BAND_HZ = 1500.0, 6000.0  # Nyquist frequency of the longest steps
SOURCES = ("vibration", "release")


def compare(seed: int) -> list[dict[str, Any]]:
    """Return levels and missing bands of a scene by step and source."""
    scene, ground = small_scene(seed, steps=400, step_nodes=LONGEST)
    nyquist = math.exp(np.random.default_rng(seed).uniform(*np.log(BAND_HZ)))
    speed = float(f"{nyquist * 2 * LONGEST * scene.spacing:.4g}")
    distance = 1e3 * scene.track.distance
    scene = scene.with_({"rolling.speed_m_s": speed, "rolling.distance_mm": distance})
    rows = []
    for source in SOURCES:
        levels = {}
        for nodes in (LONGEST, 2, 1):
            own = {"numerics.step_nodes": nodes, "sound.source": source, "dynamics.release": False}
            numbers = rc.simulate(scene.with_(own), workers=1, progress=False).numbers
            error = numbers.errors.band_db or 0.0
            spread = numbers.errors.band_uncertainty_db or 0.0
            levels[nodes] = numbers.of_record.laeq_db, error, spread
        level, error, spread = levels[1]
        for nodes in (LONGEST, 2):
            own_level, own_error, own_spread = levels[nodes]
            rows.append(
                {
                    "seed": seed,
                    "ground": ground,
                    "source": source,
                    "Nyquist kHz": nyquist * LONGEST / nodes / 1e3,
                    "estimated dB": own_error,
                    "± dB": own_spread,
                    "shorter steps dB": own_level - (level - error),
                    "their ± dB": spread,
                }
            )
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the scenes and print the table and its statistics."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=16, help="number of scenes (16)")
    parser.add_argument("--first", type=int, default=2000, help="first seed (2000)")
    given = parser.parse_args(arguments)
    rows = []
    for seed in range(given.first, given.first + given.scenes):
        rows += compare(seed)
        print(rows[-1], file=sys.stderr, flush=True)
    table = pd.DataFrame(rows)
    print(table.round(2).to_string(index=False))
    for source, part in table.groupby("source"):
        off = (part["estimated dB"] - part["shorter steps dB"]).abs()
        stated = np.hypot(part["± dB"], part["their ± dB"])
        print(f"{source}: {(off <= stated).sum()} of {len(part)} within ±", end=", ")
        print(f"{(off <= 2 * stated).sum()} within twice ±, rms {np.sqrt(np.mean(off**2)):.1f} dB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
