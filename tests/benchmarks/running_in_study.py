"""Start of a pass over a plate that remembers, and the second pass against the first.

`python tests/benchmarks/running_in_study.py` prints the numbers of docs/theory.md for a few scenes
and a short track, in half a minute. `--full` takes 38 random scenes, two seeds and 10 mm of
track, in two minutes of one core.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

import rolling as rc
from acoustics.arrays import Array
from rolling.check import cost
from rolling.contact import closed_forms
from rolling.contact.solver import ContactError
from rolling.marches import passes
from rolling.marches.march_piece import march_piece
from rolling.marches.piece import Piece, contact_identity
from rolling.scene.messages import SceneError

RADII_MM = (0.5, 20.0)
LOADS_N = (0.1, 15.0)
RA_UM = (0.005, 0.6)
HARDNESSES_GPA = (0.3, 6.0)
NODES = 12  # in the radius of the contact, of which 5 are a correlation length
REFERENCE = 10.0  # widths that count as endless
STEPS = 60  # that are compared
ROWS = ((0.1, 10.0, 2.0), (0.3, 20.0, 2.0), (0.3, 20.0, 1.0))  # Ra, length, spacing [um]
BANDS_HZ = ((20.0, 1e3), (1e3, 4e3), (4e3, 1e4), (1e4, 2e4))
SPEED = 0.1  # [m/s]


def scene_of(name: str, **sections: dict[str, Any]) -> rc.Scene:
    """Make a scene of a steel plate that remembers, on a track that closes."""
    plate = {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "plasticity": "permanent"}
    sections["plate"] = plate | sections.get("plate", {})
    return rc.Scene.from_dict({"name": name, "numerics": {"edges": "sharp"}, **sections})


# ---- the start of a march


def random_scene(rng: np.random.Generator) -> rc.Scene:
    """Draw a scene with log-uniform radius, load, roughness and hardness."""
    ranges = RADII_MM, LOADS_N, RA_UM, HARDNESSES_GPA
    draws = [math.exp(rng.uniform(*np.log(limits))) for limits in ranges]
    radius_mm, load_n, ra_um, hardness_gpa = draws
    modulus = 210e9 / (1 - 0.3**2)
    reach = math.hypot(
        closed_forms.hertz_radius(load_n, radius_mm * 1e-3, modulus),
        math.sqrt(2 * radius_mm * 1e-3 * 3 * ra_um * 1e-6),
    )
    spacing_um = round(1e6 * reach / NODES, 3)
    side = 16 * NODES * spacing_um
    return scene_of(
        "random",
        sphere={"radius_mm": radius_mm},
        plate={"hardness_gpa": hardness_gpa},
        surface={
            "kind": "gaussian",
            "roughness_ra_um": ra_um,
            "spacing_um": spacing_um,
            "correlation_length_um": 5 * spacing_um,
            "width_um": side,
            "seed": int(rng.integers(10**6)),
        },
        rolling={"load_n": load_n, "speed_m_s": SPEED, "distance_mm": 2e-3 * side},
    )


def forgotten(scene: rc.Scene, widths: float) -> float:
    """Return the rms error of the release after a start some widths ahead, over its fluctuation."""
    releases = []
    for run_in in (widths, REFERENCE):
        passes.RUN_IN = passes.RUN_IN_GROOVE = run_in
        first = scene.track.solved_steps - STEPS
        piece = Piece(scene, contact_identity(scene), "pass", first, first + STEPS)
        releases.append(march_piece(piece)["release_energy"])
    early, endless = releases
    return float(np.sqrt(np.mean((early - endless) ** 2)) / endless.std())


def starts(count: int, seed: int) -> Iterator[dict[str, float]]:
    """Yield numbers and errors of random scenes whose Hertz pressure stays below the hardness."""
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        scene = random_scene(rng)
        contact = scene.load, scene.radius, scene.contact_modulus
        pressure = closed_forms.hertz_pressure(*contact)
        if pressure > scene.hardness:
            continue
        try:
            errors = {f"{widths:g} widths": forgotten(scene, widths) for widths in (1.0, 2.0)}
        except (ContactError, SceneError):  # too rough or too wide for the plate
            continue
        found += 1
        yield {
            "R [mm]": scene.sphere.radius_mm,
            "load [N]": scene.load,
            "Ra [um]": scene.surface.roughness_ra_um,
            "hardness [GPa]": scene.hardness / 1e9,
            "Hertz / hardness": pressure / scene.hardness,
            "width [steps]": 2 * cost.overlap_radius(scene, cost.roughness(scene)[0]) / scene.step,
        } | errors


# ---- the second pass


def band_change(first: Array, second: Array, step: float) -> list[str]:
    """Return the levels of a closed series over those of another one [dB] in bands."""
    frequency = np.fft.rfftfreq(len(first), step / SPEED)
    power = [np.abs(np.fft.rfft(series)) ** 2 for series in (first, second)]
    inside = [(frequency >= low) & (frequency < high) for low, high in BANDS_HZ]
    return [f"{10 * np.log10(power[1][k].sum() / power[0][k].sum()):+.1f}" for k in inside]


def second_passes(rows: int, seeds: int, length_mm: float) -> Iterator[list[str]]:
    """Yield the changes of release and approach from the first pass to the second."""
    for ra_um, length_um, spacing_um in ROWS[:rows]:
        changes: dict[str, list[list[str]]] = {"release_energy": [], "approach": []}
        for seed in range(1, seeds + 1):
            surface = {
                "kind": "gaussian",
                "roughness_ra_um": ra_um,
                "correlation_length_um": length_um,
                "spacing_um": spacing_um,
                "width_um": 320,
                "seed": seed,
            }
            rolling = {"load_n": 5, "speed_m_s": SPEED, "distance_mm": length_mm, "passes": 2}
            scene = scene_of(
                "second",
                sphere={"radius_mm": 5},
                plate={"hardness_gpa": 2.1},
                surface=surface,
                rolling=rolling,
            )
            run = rc.simulate(scene, workers=1, progress=False)
            for name, columns in changes.items():
                series = run.result.passes.series[name][:, : run.result.solved_steps]
                columns.append(band_change(series[0], series[1], run.result.step))
        for name, columns in changes.items():
            cells = [", ".join(cell) for cell in zip(*columns, strict=True)]
            yield [f"{ra_um:g}, {length_um:g}, {spacing_um:g} um", name, *cells]


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--full", action="store_true", help="38 scenes, two seeds, 10 mm of track")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    table = pd.DataFrame(starts(38 if given.full else 6, given.seed))
    print("rms error of the release after a start some widths ahead, over its fluctuation")
    print(table.to_string(float_format="{:.3g}".format, index=False))
    heads = ["Ra, correlation length, spacing", "signal", *(f"{a:g}-{b:g} Hz" for a, b in BANDS_HZ)]
    rows = second_passes(3, 2, 10.0) if given.full else second_passes(2, 1, 2.0)
    print("\nsecond pass over first [dB]")
    print(pd.DataFrame(rows, columns=heads).to_string(index=False))


if __name__ == "__main__":
    main()
