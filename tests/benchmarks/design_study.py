"""Does a design keep what it promises on surfaces that it has not seen?

`python tests/benchmarks/design_study.py` draws three scenes and their falls by a fixed seed, makes
a design of each, and marches the surface as it is and with lower waves on 12 other seeds. It prints
the table of docs/what-would-help.md. A second call goes on where the first one stopped.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import rolling
from rolling.choice.audition import audition_of
from rolling.choice.choosing import open_choice
from rolling.choice.design import Design
from rolling.choice.design_search import design_scene
from rolling.choice.difference import Difference

SEED = 71
OTHERS = 12  # surfaces that no design has seen
BEYOND = 500  # distance of their seeds from those of the design
KINDS = (
    {"kind": "gaussian", "autocorrelation": "gaussian"},
    {"kind": "gaussian", "autocorrelation": "exponential"},
    {"kind": "self-affine", "hurst": 0.8, "shortest_um": 12.0},
)


def drawn() -> list[tuple[rolling.Scene, float]]:
    """Draw the scenes and the falls that are asked for [dB]."""
    rng = np.random.default_rng(SEED)

    def between(low: float, high: float) -> float:
        return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.3g}")

    scenes = []
    for number, kind in enumerate(KINDS, start=1):
        surface: dict[str, Any] = {
            **kind,
            "roughness_ra_um": between(0.03, 0.2),
            "spacing_um": 3.0,
            "width_um": 192.0,
            "seed": int(rng.integers(1, 400)),
        }
        if kind["kind"] == "gaussian":
            surface["correlation_length_um"] = between(12, 25)
        else:
            surface["rolloff_um"] = between(60, 150)
        scene = rolling.Scene.model_validate(
            {
                "name": f"drawn-{number}",
                "sphere": {"radius_mm": between(1, 3), "material": "steel-100cr6"},
                "plate": {
                    "material": "steel-100cr6",
                    "thickness_mm": between(2, 8),
                    "contact_loss_factor": 0.01,
                },
                "surface": surface,
                "rolling": {
                    "load_n": between(0.5, 2),
                    "speed_m_s": between(0.1, 0.5),
                    "distance_mm": 4.0,
                },
                "dynamics": {},
            }
        )
        scenes.append((scene, round(float(rng.uniform(2, 5)), 1)))
    return scenes


def on_others(found: Design, folder: Path, workers: int) -> Difference:
    """Return the fall of the level on surfaces that a design has not seen."""
    audition = audition_of(found.scene)
    seed = {"surface.seed": int(found.scene.surface.seed) + BEYOND}
    now = audition.unchanged(found.scene.with_(seed))
    lower = replace(audition.unchanged(found.changed.with_(seed)), label="lower")
    with open_choice([now, lower], folder, workers) as work:
        ((first, second), _) = work.hear([now, lower], OTHERS)
    return audition.difference(found.quantity.name, first.heard, second.heard)


def row(found: Design, others: Difference) -> str:
    """Write a row of the table."""
    first = found.rounds[0]
    surface = found.scene.surface
    kind = getattr(surface, "autocorrelation", surface.kind)
    words = f"{kind}, Ra {surface.roughness_ra_um:g} um"
    apart = others.db - found.fall.db
    both = float(np.hypot(others.uncertainty_db, found.fall.uncertainty_db))
    cells = [
        words,
        f"{found.quieter_db:g}",
        f"{first.fall_db:.2f}",
        f"{found.fall.db:.2f} ± {found.fall.uncertainty_db:.2f}",
        f"{others.db:.2f} ± {others.uncertainty_db:.2f}",
        f"{apart:+.2f} ± {both:.2f}",
        str(int(np.count_nonzero(found.lowered_db))),
        f"{found.lowered_db.max():.1f}",
    ]
    return f"|{'|'.join(cells)}|"


def main() -> None:
    """Design the scenes, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("outputs/design-study"))
    parser.add_argument("--workers", type=int, default=0)
    parser.add_argument("--only", nargs="*", default=(), help="names of scenes, such as drawn-2")
    given = parser.parse_args()
    rows = []
    for scene, quieter_db in drawn():
        if given.only and scene.name not in given.only:
            continue
        folder = given.out / scene.name
        found = design_scene(scene, quieter_db, folder, workers=given.workers)
        others = on_others(found, given.out / f"{scene.name}-others", given.workers)
        rows.append(row(found, others))
        print(found, rows[-1], sep="\n", flush=True)
    print("\n".join(rows))


if __name__ == "__main__":
    main()
