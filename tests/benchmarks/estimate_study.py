"""Test of the error estimate: estimated errors against a fine grid over the whole track.

`python tests/benchmarks/estimate_study.py [SCENE...]` runs the scenes of `SCENES`, or some of them,
and prints the table of docs/accuracy.md. All scenes take about half an hour of one core.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any

import pandas as pd

import rolling as rc
from acoustics.bands import BAND_NAMES, reliable
from rolling.accuracy.variants import Variant, march_variant
from rolling.sound.contact_sound import contact_sound

BANDS = [name for name in BAND_NAMES if 100 <= float(name) <= 16000]
DURATION_S = 0.16  # 8,000 steps
FINEST, TOLERANCE = 4, 1e-6  # of the reference
NEAR_DB = 0.3  # an estimate is right within this error, or within twice its standard uncertainty
SCENES: dict[str, dict[str, Any]] = {  # changes of the base scene
    "Ra 0.01, 0.3 N": {"surface.roughness_ra_um": 0.01},
    "Ra 0.1, 0.3 N": {},
    "Ra 0.3, L 20, 0.5 N": {
        "surface.roughness_ra_um": 0.3,
        "surface.correlation_length_um": 20,
        "surface.width_um": 224,
        "rolling.load_n": 0.5,
    },
    "Ra 0.5, 3 GPa, 0.3 N": {
        "surface.roughness_ra_um": 0.5,
        "surface.width_um": 224,
        "plate.hardness_gpa": 3,
    },
    "Ra 1, 0.3 N": {"surface.roughness_ra_um": 1.0, "surface.width_um": 384},
    "L 6, 6.3 GPa, 0.5 N": {
        "plate.hardness_gpa": 6.3,
        "surface.correlation_length_um": 6,
        "rolling.load_n": 0.5,
    },
    "exponential, 4 GPa, 0.3 N": {
        "plate.hardness_gpa": 4,
        "surface.autocorrelation": "exponential",
        "surface.width_um": 192,
    },
    "elastic, 0.5 N": {
        "plate.hardness_gpa": None,
        "surface.width_um": 192,
        "rolling.load_n": 0.5,
    },
}
_BASE: dict[str, Any] = {
    "name": "estimate",
    "sphere": {"radius_mm": 5},
    "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "hardness_gpa": 2.1},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.1,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 128,
        "seed": 11,
    },
    "rolling": {"load_n": 0.3, "speed_m_s": 0.1, "duration_s": DURATION_S},
    "numerics": {"error_estimate": True, "tolerance": 1e-4},
}


def scene_of(name: str, **changes: Any) -> rc.Scene:
    """Return a scene of the study with further changes."""
    return rc.Scene.from_dict(_BASE).with_(SCENES[name] | changes)


def reference(scene: rc.Scene) -> Any:
    """March the whole track on a fine grid at a tight tolerance and return its sound."""
    track, numerics = scene.track, scene.numerics
    variant = Variant(FINEST, numerics.step_nodes, TOLERANCE, numerics.edges, "single")
    release = march_variant(scene, variant, track.n_along)["release_energy"]
    solved = scene.with_({"numerics.tolerance": TOLERANCE})
    return contact_sound(solved, release, scene.step, track.closed)


def compare(scene: rc.Scene) -> pd.DataFrame:
    """Return estimated errors, their uncertainty and true errors [dB] of LAeq and third octaves.

    Bands that are too short to be read are left out: they hold a few lines, whose errors scatter.
    """
    run = rc.simulate(scene, workers=1, progress=False)
    fine, numbers = reference(scene).levels, run.summary
    certain = dict(zip(BAND_NAMES, reliable(run.sound.duration), strict=True))
    errors = {
        name: {
            "estimated": numbers["grid_error_db"][name] + numbers["solver_error_db"][name],
            "uncertainty": numbers["grid_error_uncertainty_db"][name],
            "true": numbers["third_octave_db"][name] - fine.third_octave_db[name],
        }
        for name in BANDS
        if certain[name] and numbers["grid_error_db"][name] is not None
    }
    errors["LAeq"] = {
        "estimated": numbers["laeq_grid_error_db"] + numbers["laeq_solver_error_db"],
        "uncertainty": numbers["laeq_grid_error_uncertainty_db"],
        "true": numbers["laeq_db"] - fine.laeq_db,
    }
    table = pd.DataFrame.from_dict(errors, orient="index")
    table["off"] = (table.estimated - table.true).abs()
    table["right"] = table.off <= (2 * table.uncertainty).clip(lower=NEAR_DB)
    return table.assign(stretches=numbers["error_estimate"]["stretches"])


def row(name: str, table: pd.DataFrame) -> dict[str, Any]:
    """Return the row of a scene in the table of docs/accuracy.md."""
    laeq, bands = table.loc["LAeq"], table.drop(index="LAeq")
    return {
        "scene": name,
        "LAeq error, estimated dB": f"{laeq.estimated:+.2f} ± {laeq.uncertainty:.2f}",
        "true dB": f"{laeq.true:+.2f}",
        "bands right": f"{bands.right.sum()} of {len(bands)}",
        "worst off dB": f"{bands.off.max():.1f}",
        "stretches": laeq.stretches,
    }


def _row_of(changes: dict[str, Any], name: str) -> dict[str, Any]:
    """Compare a scene with changes in a worker process."""
    return row(name, compare(scene_of(name, **changes)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}")
    parser.add_argument("--workers", type=int, default=1, help="processes (1)")
    parser.add_argument("--seed", type=int, default=11, help="seed of the surfaces (11)")
    given = parser.parse_args(arguments)
    if unknown := [name for name in given.scenes if name not in SCENES]:
        parser.error(f"no scene {unknown[0]!r}; the scenes are {', '.join(SCENES)}")
    context = multiprocessing.get_context("spawn")
    task = partial(_row_of, {"surface.seed": given.seed})
    with ProcessPoolExecutor(given.workers, context) as pool:
        rows = list(pool.map(task, given.scenes or SCENES))
    print(pd.DataFrame(rows).to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
