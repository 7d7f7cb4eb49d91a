"""Coverage of stated uncertainties: levels of pairs of seeds, and errors of the grid.

`python tests/benchmarks/coverage_study.py` draws small scenes at random, marches each with several
seeds, and counts how many differences lie within one and within two of their stated standard
uncertainties. It prints the table of docs/accuracy.md, in about a quarter of an hour of one core.

- Seeds: the difference of a level of two seeds over the root of the sum of squares of both
  uncertainties. Each run is in one pair.
- Comb: where LAeq is stated as the mean over a comb, the difference of this mean from the LAeq of
  the record of the other seed, over the stated spread.
- Grid: estimated less true error of the grid over its uncertainty. The true one follows from the
  same surface on a grid three times finer, at all loads of the force law.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.level import RecordNumbers, SoundLevels
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.subcells import half_space_of
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.kinds.run_folder import RunFolder
from rolling.marches.march_piece import march_piece
from rolling.marches.next_pieces import next_pieces
from rolling.marches.result import Result, released_energy
from rolling.results.run_result import Run, make_run
from rolling.sound.contact_sound import contact_sound
from rolling.sound.vibration_sound import Vibration, vibrate
from rolling.studies.accuracy_variants import Variant, variant_contact

SCENES = 12
STEPS = 640  # of a scene for pairs, a lap of 128 correlation lengths
GRID_STEPS = 2560  # of a scene for the errors of the grid, which are estimated from stretches
FINER = 3  # divisor of the spacing of the reference
TOLERANCE = 1e-6  # of the reference
RANGES: dict[str, tuple[float, float]] = {  # drawn evenly over the logarithm
    "radius_mm": (1.0, 20.0),
    "youngs_modulus_gpa": (3.0, 400.0),
    "correlation_length_um": (5.0, 40.0),
    "speed_m_s": (0.02, 3.0),
    "hertz_radius_in_lengths": (1.5, 4.0),
    "roughness_in_deflections": (0.03, 0.3),
    "thickness_mm": (1.0, 20.0),
    "loss_factor": (0.003, 0.1),
    "edge_mm": (100.0, 400.0),
}
CONTACT_LOSSES = (None, 0.01, 0.05)


class Difference(NamedTuple):
    """A difference over its stated standard uncertainty, and its kind."""

    source: str
    kind: str
    scene: int
    ratio: float


def scene_of(number: int, seed: int, steps: int, **changes: Any) -> rc.Scene:
    """Return a random scene with a seed of its surface, a lap of so many steps long."""
    random = np.random.default_rng([2026, number])

    def drawn(name: str) -> float:
        """Draw a number, evenly over the logarithm."""
        low, high = np.log(RANGES[name])
        return float(np.exp(random.uniform(low, high)))

    radius_mm = drawn("radius_mm")
    young_gpa = drawn("youngs_modulus_gpa")
    poisson = float(random.uniform(0.2, 0.4))
    length_um = drawn("correlation_length_um")
    spacing_um = length_um / 5
    hertz_um = length_um * drawn("hertz_radius_in_lengths")
    modulus_pa = young_gpa * 1e9 / (1 - poisson**2)
    deflection_um = hertz_um**2 / (1e3 * radius_mm)
    width_nodes = 2 * math.ceil(hertz_um * 1.3 / spacing_um + 18)
    plate: dict[str, Any] = {
        "youngs_modulus_gpa": young_gpa,
        "poissons_ratio": poisson,
        "density_kg_m3": float(random.uniform(1000, 8000)),
        "thickness_mm": drawn("thickness_mm"),
        "loss_factor": drawn("loss_factor"),
        "hardness_gpa": young_gpa / random.uniform(30, 150) if random.random() < 0.5 else None,
        "contact_loss_factor": CONTACT_LOSSES[random.integers(3)],
    }
    if random.random() < 0.4:
        plate |= {"length_mm": drawn("edge_mm"), "width_mm": drawn("edge_mm")}
    sections = {
        "name": f"coverage-{number}",
        "sphere": {"radius_mm": radius_mm, "density_kg_m3": float(random.uniform(1000, 8000))},
        "plate": {key: value for key, value in plate.items() if value is not None},
        "surface": {
            "kind": "gaussian",
            "roughness_ra_um": deflection_um * drawn("roughness_in_deflections"),
            "correlation_length_um": length_um,
            "spacing_um": spacing_um,
            "width_um": width_nodes * spacing_um,
            "seed": 1000 * number + seed,
        },
        "rolling": {
            "load_n": 4 * (hertz_um * 1e-6) ** 3 * modulus_pa / (3 * radius_mm * 1e-3),
            "speed_m_s": drawn("speed_m_s"),
            "distance_mm": steps * spacing_um * 1e-3,
        },
        "dynamics": {},
    }
    return rc.Scene.from_dict(sections).with_(changes)


def solved(scene: rc.Scene) -> Result:
    """March all pieces of a scene in this process."""
    result = Result.empty(scene)
    while pieces := next_pieces(scene, result):
        for piece in pieces:
            result.add(piece, march_piece(piece))
    return result


# ---- pairs of seeds


class Levels(NamedTuple):
    """Levels of one run from one source, with their uncertainties."""

    stated: SoundLevels
    uncertainty: RecordNumbers
    record_laeq_db: float | None
    is_mean_of_comb: bool


def levels_of(scene: rc.Scene) -> dict[str, Levels]:
    """Return the levels of a run by source."""
    result = solved(scene)
    energy, closed = released_energy(scene, result)
    release = contact_sound(
        energy,
        step=result.step,
        motion=scene.motion,
        listener=listener_of(scene),
        tolerance=scene.tolerance,
        closed=closed,
        lap_steps=result.solved_steps,
    )
    run = make_run(RunFolder({}, scene, Path()), "", result, {})
    assert run.vibration_sound is not None  # scenes of the study have dynamics
    return {
        "release": Levels(release.levels, release.uncertainty, release.levels.laeq_db, False),
        "vibration": Levels(
            run.sound.levels,
            run.sound.uncertainty,
            run.record_laeq_db,
            run.vibration_sound.is_mean_of_comb,
        ),
    }


def of_pair(
    number: int, first: dict[str, Levels], other: dict[str, Levels]
) -> Iterator[Difference]:
    """Yield the differences of the levels of two seeds over their uncertainties."""
    for source, a in first.items():
        b = other[source]
        if a.is_mean_of_comb or b.is_mean_of_comb:
            mean, record = (a, b) if a.is_mean_of_comb else (b, a)
            assert mean.stated.laeq_db is not None and mean.uncertainty.laeq_db is not None
            if record.record_laeq_db is not None:
                off = (record.record_laeq_db - mean.stated.laeq_db) / mean.uncertainty.laeq_db
                yield Difference(source, "LAeq, mean over a comb", number, off)
        else:
            yield from _over_uncertainty(
                Difference(source, "LAeq", number, math.nan),
                (a.stated.laeq_db, b.stated.laeq_db),
                (a.uncertainty.laeq_db, b.uncertainty.laeq_db),
            )
        for band in BAND_NAMES:
            yield from _over_uncertainty(
                Difference(source, "third octaves", number, math.nan),
                (a.stated.third_octave_db[band], b.stated.third_octave_db[band]),
                (a.uncertainty.third_octave_db[band], b.uncertainty.third_octave_db[band]),
            )


def _over_uncertainty(
    difference: Difference,
    levels: tuple[float | None, float | None],
    uncertainties: tuple[float | None, float | None],
) -> Iterator[Difference]:
    """Yield the difference of two levels over their joint uncertainty, if both are known."""
    if None in levels or None in uncertainties:
        return
    a, b = levels
    u, v = uncertainties
    assert a is not None and b is not None and u is not None and v is not None
    yield difference._replace(ratio=(a - b) / math.hypot(u, v))


# ---- errors of the grid


def of_grid(number: int, seed: int) -> Iterator[Difference]:
    """Yield estimated less true errors of the grid over their uncertainty."""
    changes = {"numerics.error_estimate": True}
    scene = scene_of(number, seed, GRID_STEPS, **changes)
    result = solved(scene)
    place = RunFolder({}, scene, Path())
    vibrating = make_run(place, "", result)
    released_scene = scene.with_({"sound.source": "release"})
    runs = {
        "vibration": vibrating,
        "release": make_run(RunFolder({}, released_scene, Path()), "", result),
    }
    assert vibrating.vibration_sound is not None  # scenes of the study have dynamics
    known = {source: run for source, run in runs.items() if _has_estimate(run)}
    for source, run in runs.items():
        if source not in known:
            reason = run.numbers.errors.reason
            print(f"scene {number}, {source}: no estimate, {reason}", file=sys.stderr)
    if not known:
        return
    true = reference(scene, result, vibrating.vibration_sound)
    for source, run in known.items():
        numbers = run.numbers
        levels = true[source]
        errors = numbers.errors
        if levels.laeq_db is not None and errors.grid_db is not None:
            off = errors.grid_db + (errors.solver_db or 0.0)
            off -= numbers.of_record.laeq_db - levels.laeq_db
            yield Difference(source, "LAeq, grid", number, off / errors.grid_uncertainty_db)
        for band in BAND_NAMES:
            error = numbers.bands.grid_error.by_name[band]
            own = run.sound.levels.third_octave_db[band]
            level = levels.third_octave_db[band]
            spread_db = numbers.bands.grid_error.uncertainty_by_name[band]
            if error is None or own is None or level is None or not spread_db:
                continue
            off = error + (numbers.bands.solver_error.by_name[band] or 0.0) - (own - level)
            yield Difference(source, "third octaves, grid", number, off / spread_db)


def _has_estimate(run: Run) -> bool:
    """Tell whether a run knows the errors of its grid."""
    return run.numbers.errors.reason is None


def reference(scene: rc.Scene, result: Result, vibration: Vibration) -> dict[str, SoundLevels]:
    """Return the levels of both sources on a fine grid at a tight tolerance."""
    own = vibration.law
    release = np.empty(0)
    approach = []
    for load in own.load_n:
        energy, depth = _marched_finely(scene.with_({"rolling.load_n": float(load)}))
        approach.append(depth)
        if math.isclose(load, scene.load):
            release = energy
    law = replace(own, approach_m=np.array(approach))
    whole_laps = result.steps % result.solved_steps == 0
    listener = listener_of(scene)
    finely = vibrate(bodies_of(scene), listener, scene.travel, law, vibration.highest, whole_laps)
    sound = contact_sound(
        release,
        step=result.step,
        motion=scene.motion,
        listener=listener,
        tolerance=TOLERANCE,
        closed=True,
        lap_steps=result.solved_steps,
    )
    return {"vibration": finely.stated_levels, "release": sound.levels}


def _marched_finely(scene: rc.Scene) -> tuple[Array, Array]:
    """Return release [J] and approach [m] of a lap on the fine grid."""
    variant = Variant(FINER, scene.step_nodes, TOLERANCE, scene.numerics.edges, "single")
    contact = variant_contact(scene, variant)
    steps = scene.track.lap_steps
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    release = np.empty(steps)
    approach = np.empty(steps)
    old = None
    for state in march(contact, 0, steps, half_space):
        if old is not None:
            release[old.position] = step_energy(old, state, half_space).release
            approach[old.position] = old.approach
        old = state
    return release, approach


# ---- table


def table(differences: Sequence[Difference]) -> pd.DataFrame:
    """Count the differences within one and two standard uncertainties, by source and kind."""
    ratios = defaultdict[tuple[str, str], list[Difference]](list)
    for difference in differences:
        ratios[difference.source, difference.kind].append(difference)
    rows = []
    for (source, kind), found in sorted(ratios.items()):
        sizes = np.abs([difference.ratio for difference in found])
        rows.append(
            {
                "source": source,
                "kind": kind,
                "scenes": len({difference.scene for difference in found}),
                "differences": len(sizes),
                "within one [%]": _share(sizes, 1.0),
                "within two [%]": _share(sizes, 2.0),
                "rms": f"{np.sqrt(np.mean(np.square(sizes))):.2f}",
            }
        )
    return pd.DataFrame(rows)


def _share(sizes: Array, limit: float) -> str:
    """Write the share of sizes within a limit with its counting error [%]."""
    share = float(np.mean(sizes < limit))
    count = len(sizes)
    # With one difference more on either side, so that 0 and 100 % have an error, too.
    likely = (share * count + 1) / (count + 2)
    return f"{100 * share:.0f} ± {100 * math.sqrt(likely * (1 - likely) / count):.0f}"


def main(arguments: Sequence[str] | None = None) -> int:
    """March the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=SCENES, help=f"number ({SCENES})")
    parser.add_argument("--first", type=int, default=0, help="number of the first scene (0)")
    parser.add_argument("--pairs", type=int, default=9, help="pairs of seeds of a scene (9)")
    parser.add_argument("--grids", type=int, default=1, help="seeds for errors of the grid (1)")
    parser.add_argument("--out", type=Path, help="CSV of all differences (default: none)")
    given = parser.parse_args(arguments)
    found = list[Difference]()
    began = time.process_time()
    for number in range(given.first, given.first + given.scenes):
        for pair in range(given.pairs):
            seeds = 2 * pair + 1, 2 * pair + 2
            first, other = (levels_of(scene_of(number, seed, STEPS)) for seed in seeds)
            found += of_pair(number, first, other)
        for seed in range(given.grids):
            found += of_grid(number, 501 + seed)
        if given.out is not None:
            pd.DataFrame(found).to_csv(given.out, index=False)
        seconds = time.process_time() - began
        print(f"scene {number}: {seconds:.0f} s so far", file=sys.stderr, flush=True)
    print(table(found).to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
