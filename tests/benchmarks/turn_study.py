"""Prominence of the turns of spheres with and without a pit, in short and open records.

The spheres are smooth or have a texture of their own, which repeats with the turns as a pit does.
"""

import math
import sys
from collections.abc import Iterator
from typing import Any

import pandas as pd

import rolling as rc
from rolling.scene.file import loads

SCENE = """\
name: turns
sphere: {radius_mm: 1, density_kg_m3: 7850, surface: {kind: smooth}}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 4,
  loss_factor: 0.03}
surface: {kind: gaussian, roughness_ra_um: 0.004, correlation_length_um: 20, spacing_um: 4,
  width_um: 256, seed: 3}
rolling: {load_n: 0.4, speed_m_s: 0.2, distance_mm: 10}
dynamics: {}
sound: {distance_m: 0.5}
"""
RADII_AND_SPEEDS = (1.0, 0.2), (0.5, 1.0)  # [mm], [m/s]: 32 and 318 turns per second
TURNS = 2.0, 2.3, 2.6, 3.0, 4.0, 5.5, 8.0
SPACING_MM = 0.004
PIT = {"kind": "pit", "at_mm": [1.0, 0], "size_um": 70, "depth_um": 3}


def texture(ra_um: float) -> dict[str, Any]:
    """Return a rough surface of a sphere."""
    return {"kind": "gaussian", "roughness_ra_um": ra_um, "correlation_length_um": 20, "seed": 7}


# The plate has an Ra of 0.004 um.
SPHERES: dict[str, dict[str, Any]] = {
    "no fault": texture(1e-6),
    "three times as rough": texture(0.012),
    "ten times as rough": texture(0.04),
    "pit of 3 um": {"kind": "smooth", "faults": [PIT]},
    "pit of 0.1 um": {"kind": "smooth", "faults": [PIT | {"depth_um": 0.1}]},
    "pit of 3 um, three times as rough": texture(0.012) | {"faults": [PIT]},
}


def rows(turns: tuple[float, ...]) -> Iterator[dict[str, Any]]:
    """Run the spheres over some turns, and yield the prominence of each."""
    base = loads(SCENE, [])
    for radius_mm, speed in RADII_AND_SPEEDS:
        nodes = round(2 * math.pi * radius_mm / SPACING_MM)
        for number in turns:
            changes = {
                "sphere.radius_mm": radius_mm,
                "rolling.speed_m_s": speed,
                "rolling.distance_mm": round(round(number * nodes) * SPACING_MM, 6),
            }
            for name, surface in SPHERES.items():
                scene = base.with_({**changes, "sphere.surface": surface})
                numbers = rc.simulate(scene, workers=1, progress=False).numbers
                yield {
                    "sphere": name,
                    "turns per second": round(numbers.turns.frequency_hz),
                    "turns": number,
                    "prominence": numbers.turns.prominence,
                }


def main() -> None:
    """Print the prominence by sphere and turns; `--quick` takes two numbers of turns."""
    turns = (2.3, 4.0) if "--quick" in sys.argv else TURNS
    table = pd.DataFrame(rows(turns))
    wide = table.pivot_table("prominence", ["sphere", "turns per second"], "turns", sort=False)
    print(wide.round(1).to_string())


if __name__ == "__main__":
    main()
