"""Test of the error estimate: estimated errors against a fine grid over the whole track.

`python tests/benchmarks/estimate_study.py [SCENE...]` runs the scenes of `SCENES`, or some of them,
and prints the numbers of docs/accuracy.md. All scenes take about half an hour of one core.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, reliable
from acoustics.level import SoundLevels
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.physics_of_scene import listener_of
from rolling.in_si.scene_surface import heights
from rolling.numbers.ball_numbers import RunNumbers
from rolling.sound.contact_sound import contact_sound
from rolling.studies.accuracy_variants import Variant, march_variant
from rolling.surface.made import continued

BANDS = [name for name in BAND_NAMES if 100 <= float(name) <= 16000]
DURATION_S = 0.16  # 8,000 steps
FINEST = 4  # divisor of the spacing of the reference
TOLERANCE = 1e-6  # of the reference
SCENES: dict[str, dict[str, Any]] = {  # changes of the base scene
    "Ra 0.1": {},
    "Ra 0.05, L 8, 4 GPa, 0.2 N": {
        "surface.roughness_ra_um": 0.05,
        "surface.correlation_length_um": 8,
        "plate.hardness_gpa": 4,
        "rolling.load_n": 0.2,
    },
    "Ra 0.02, L 6, 0.1 N": {
        "surface.roughness_ra_um": 0.02,
        "surface.correlation_length_um": 6,
        "rolling.load_n": 0.1,
    },
    "Ra 0.2, L 15, 1 GPa, 0.15 N": {
        "surface.roughness_ra_um": 0.2,
        "surface.correlation_length_um": 15,
        "plate.hardness_gpa": 1,
        "rolling.load_n": 0.15,
    },
    "Ra 0.4, L 25, 5 GPa, 1 N": {
        "surface.roughness_ra_um": 0.4,
        "surface.correlation_length_um": 25,
        "surface.width_um": 128,
        "plate.hardness_gpa": 5,
        "rolling.load_n": 1,
    },
    "Ra 0.8, L 20, 3 GPa, 0.5 N": {
        "surface.roughness_ra_um": 0.8,
        "surface.correlation_length_um": 20,
        "surface.width_um": 160,
        "plate.hardness_gpa": 3,
        "rolling.load_n": 0.5,
    },
    "elastic, Ra 0.15, L 12": {
        "surface.roughness_ra_um": 0.15,
        "surface.correlation_length_um": 12,
        "plate.hardness_gpa": None,
    },
    "gaussian_10pct, L 12, 1.5 GPa, 0.1 N": {
        "surface.autocorrelation": "gaussian_10pct",
        "surface.correlation_length_um": 12,
        "plate.hardness_gpa": 1.5,
        "rolling.load_n": 0.1,
    },
    "exponential, 3 GPa": {"surface.autocorrelation": "exponential", "plate.hardness_gpa": 3},
    "exponential, Ra 0.2, L 20, 6 GPa, 0.8 N": {
        "surface.autocorrelation": "exponential",
        "surface.roughness_ra_um": 0.2,
        "surface.correlation_length_um": 20,
        "surface.width_um": 128,
        "plate.hardness_gpa": 6,
        "rolling.load_n": 0.8,
    },
}
_BASE: dict[str, Any] = {
    "name": "estimate",
    "sphere": {"radius_mm": 1},
    "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "hardness_gpa": 2.1},
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.1,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 96,
        "seed": 31,
    },
    "rolling": {"load_n": 0.3, "speed_m_s": 0.1, "duration_s": DURATION_S},
    "numerics": {"error_estimate": True, "tolerance": 1e-4},
}


def scene_of(name: str, **changes: Any) -> rc.Scene:
    """Return a scene of the study with further changes."""
    return rc.Scene.from_dict(_BASE).with_(SCENES[name] | changes)


def reference(scene: rc.Scene) -> tuple[Array, float]:
    """Return release and plastic area of the whole track on a fine grid at a tight tolerance."""
    variant = Variant(FINEST, scene.step_nodes, TOLERANCE, scene.numerics.edges, "single")
    series = march_variant(scene, variant, scene.track.n_along)
    return series["release_energy"], float(series["plastic_area"].mean())


def with_detail(scene: rc.Scene) -> Array:
    """March the whole track on a quarter of the spacing with the detail of the surface's law."""
    contact = rolling_contact(scene)
    surface = scene.surface
    z = heights(scene)
    spacing = scene.spacing
    (law,) = scene.laws
    for octave in (1, 2):
        z = continued(z, spacing, [law.in_si], (surface.seed, octave))
        spacing /= 2
    cells = z.repeat(contact.subcells, axis=0).repeat(contact.subcells, axis=1)
    start = contact.start + (scene.spacing - spacing) / 2
    finer = replace(
        contact, heights=cells, spacing=spacing / contact.subcells, start=start, slopes=False
    )
    release = np.empty(scene.track.n_along)
    old = None
    half_space = half_space_of(finer.spacing, finer.contact_modulus, finer.subcells)
    for state in march(finer, 0, len(release), half_space):
        if old is not None:
            release[old.position] = step_energy(old, state, half_space).release
        old = state
    return release


def compare(scene: rc.Scene) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Return errors, their uncertainty and true errors [dB] by band, and the row of the scene.

    Bands that are too short to be read are left out: they hold a few lines, whose errors scatter.
    """
    run = rc.simulate(scene, workers=1, progress=False)
    fine, plastic = reference(scene)
    numbers = run.numbers
    grid, solver = numbers.bands.grid_error, numbers.bands.solver_error
    levels = _levels(scene, fine)
    certain = dict(zip(BAND_NAMES, reliable(run.sound.duration), strict=True))
    errors = {
        name: {
            "estimated": grid.by_name[name] + solver.by_name[name],
            "uncertainty": grid.uncertainty_by_name[name],
            "true": run.sound.levels.third_octave_db[name] - levels.third_octave_db[name],
        }
        for name in BANDS
        if certain[name] and grid.by_name[name] is not None
    }
    errors["LAeq"] = {
        "estimated": numbers.errors.grid_db + numbers.errors.solver_db,
        "uncertainty": numbers.errors.grid_uncertainty_db,
        "true": numbers.of_record.laeq_db - levels.laeq_db,
    }
    table = pd.DataFrame.from_dict(errors, orient="index")
    table["off"] = (table.estimated - table.true).abs()
    table["right"] = table.off <= 2 * table.uncertainty
    row = _row(table, numbers) | {
        "signal true dB": f"{_signal_db(scene, run.series['release_energy'], fine):.0f}"
    }
    if numbers.errors.plastic_ratio_grid is not None:
        spread = numbers.errors.plastic_ratio_grid_uncertainty
        row["plastic ratio"] = f"{numbers.errors.plastic_ratio_grid:+.3f} ± {spread:.3f}"
        row["plastic true"] = f"{run.series['plastic_area'][1:].mean() / plastic - 1:+.3f}"
    if numbers.errors.subgrid_db:
        row |= detail_row(scene, run)
    return table, row


def _levels(scene: rc.Scene, release: Array) -> SoundLevels:
    """Return the levels of a release at the tolerance of the reference."""
    sound = contact_sound(
        release,
        step=scene.step,
        motion=scene.motion,
        listener=listener_of(scene),
        tolerance=TOLERANCE,
        closed=scene.track.closed,
    )
    return sound.levels


def _signal_db(scene: rc.Scene, own: Array, fine: Array) -> float:
    """Return the rms error of a release within hearing over its rms fluctuation [dB]."""
    speed = scene.motion.distance(1.0)
    lines = np.fft.rfftfreq(len(own), scene.step / speed)
    heard = (lines > EDGES_HZ[0]) & (lines < EDGES_HZ[-1])
    off, signal = (np.abs(np.fft.rfft(x)[heard]) ** 2 for x in (own - fine, fine))
    return float(10 * np.log10(off.sum() / signal.sum()))


def detail_row(scene: rc.Scene, run: rc.Run) -> dict[str, str]:
    """Return stated and true errors [dB] against a surface with two octaves of detail."""
    numbers = run.numbers
    detailed = _levels(scene, with_detail(scene))
    spread = math.hypot(numbers.errors.subgrid_uncertainty_db, numbers.errors.grid_uncertainty_db)
    stated = numbers.errors.subgrid_db + numbers.errors.grid_db
    columns = {
        "LAeq with detail": f"{stated:+.2f} ± {spread:.2f}",
        "LAeq with detail, true": f"{numbers.of_record.laeq_db - detailed.laeq_db:+.2f}",
    }
    for name in ("8000", "16000"):
        stated = numbers.bands.subgrid_error.by_name[name] + numbers.bands.grid_error.by_name[name]
        true = run.sound.levels.third_octave_db[name] - detailed.third_octave_db[name]
        spread = numbers.bands.subgrid_error.uncertainty_by_name[name]
        columns[f"{name} Hz with detail"] = f"{stated:+.1f} ± {spread:.1f} (true {true:+.1f})"
    return columns


def _row(table: pd.DataFrame, numbers: RunNumbers) -> dict[str, Any]:
    """Return stated and true errors of LAeq and bands."""
    laeq = table.loc["LAeq"]
    bands = table.drop(index="LAeq")
    spread = numbers.errors.grid_signal_uncertainty_db
    return {
        "LAeq error, estimated dB": f"{laeq.estimated:+.2f} ± {laeq.uncertainty:.2f}",
        "true dB": f"{laeq.true:+.2f}",
        "bands right": f"{bands.right.sum()} of {len(bands)}",
        "worst off dB": f"{bands.off.max():.1f}",
        "signal dB": f"{numbers.errors.grid_signal_db:.0f} ± {spread:.0f}",
    }


def _row_of(changes: dict[str, Any], name: str) -> dict[str, Any]:
    """Compare a scene with changes in a worker process."""
    return {"scene": name} | compare(scene_of(name, **changes))[1]


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}")
    parser.add_argument("--workers", type=int, default=1, help="processes (1)")
    parser.add_argument("--seed", type=int, default=31, help="seed of the surfaces (31)")
    given = parser.parse_args(arguments)
    if unknown := [name for name in given.scenes if name not in SCENES]:
        parser.error(f"no scene {unknown[0]!r}; the scenes are {', '.join(SCENES)}")
    context = multiprocessing.get_context("spawn")
    task = partial(_row_of, {"surface.seed": given.seed})
    with ProcessPoolExecutor(given.workers, context) as pool:
        rows = []
        for row in pool.map(task, given.scenes or SCENES):
            rows.append(row)
            print(row, file=sys.stderr, flush=True)
    print(pd.DataFrame(rows).fillna("-").to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
