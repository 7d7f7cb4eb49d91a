"""Measure whether sensitivities and limits keep their promises on other surfaces.

Sensitivities from groups of six surfaces are compared with finite differences over all other
surfaces, and the tolerance limits of groups of twelve with the levels of all others. The folder
keeps what is solved.

    python tests/benchmarks/sensitivity_study.py [--surfaces 36] [--scenes steel glass]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from acoustics.pairs import paired_mean, student_factor
from rolling.ball_kinds import ball_drawing
from rolling.ball_kinds.ball_audition import BallAudition
from rolling.ball_kinds.ball_candidates import LOSS_KEY, BallCandidate
from rolling.ball_kinds.chain import chain_levels
from rolling.choice import drawing
from rolling.choice.choosing import OpenChoice, open_choice
from rolling.choice.limit import tolerance_limit
from rolling.scene.scene import Scene

GROUP = 6  # surfaces of a sensitivity
LIMIT_GROUP = 12  # surfaces of a tolerance limit
STEEL = {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3, "density_kg_m3": 7850}
GLASS = {"youngs_modulus_gpa": 70, "poissons_ratio": 0.23, "density_kg_m3": 2500}


def scenes() -> list[Scene]:
    """Return small scenes whose marches take some seconds."""
    made = []
    for name, plate, radius_mm, ra_um, length_um, load_n, speed_m_s, thickness_mm in [
        ("steel", STEEL, 1.5, 0.1, 15, 1.0, 0.2, 3),
        ("rough-steel", STEEL, 2.5, 0.25, 12, 0.5, 0.3, 5),
        ("glass", GLASS, 2.0, 0.05, 12, 1.0, 0.15, 4),
    ]:
        made.append(
            Scene.from_dict(
                {
                    "name": name,
                    "sphere": {"radius_mm": radius_mm, **STEEL},
                    "plate": {**plate, "thickness_mm": thickness_mm, "contact_loss_factor": 0.01},
                    "surface": {
                        "kind": "gaussian",
                        "roughness_ra_um": ra_um,
                        "correlation_length_um": length_um,
                        "spacing_um": 3,
                        "width_um": 192,
                        "seed": 1,
                    },
                    "rolling": {"load_n": load_n, "speed_m_s": speed_m_s, "distance_mm": 2},
                    "dynamics": {},
                }
            )
        )
    return made


class _Rates:
    """Counts of groups, and of those within one and two uncertainties."""

    def __init__(self) -> None:
        self.ratios: list[float] = []

    def add(self, stated: float, stated_error: float, truth: float, truth_error: float) -> None:
        """Add the distance of a statement from the truth over the error of both."""
        error = math.hypot(stated_error, truth_error)
        if error > 0:
            self.ratios.append(abs(stated - truth) / error)

    @property
    def text(self) -> str:
        """Counts in words."""
        ratios = np.array(self.ratios)
        if not len(ratios):
            return "none"
        within = [f"{np.mean(ratios < most):.0%} within {most}" for most in (1, 2)]
        return f"{len(ratios)} groups: {', '.join(within)} ±"


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--surfaces", type=int, default=36)
    parser.add_argument("--scenes", nargs="*", default=[made.name for made in scenes()])
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("outputs/sensitivity-study"))
    given = parser.parse_args()
    rates = _Rates()
    below = []
    print("|scene|value, +10 %|six surfaces, dB|all others, dB|linear chain, dB|")
    print("|---|---|---|---|---|")
    for scene in scenes():
        if scene.name not in given.scenes:
            continue
        base = ball_drawing.unchanged(scene)
        folder = given.out / scene.name
        with open_choice([base], folder, given.workers) as work:
            below += _study(work, scene, base, folder, given.surfaces, rates)
    print(f"\nsensitivities, {rates.text}")
    print(f"tolerance limits of {LIMIT_GROUP} surfaces: share of the others below, by group:")
    print(", ".join(f"{share:.0%}" for share in below), f"; mean {np.mean(below):.1%}")


def _study(
    work: OpenChoice,
    scene: Scene,
    base: BallCandidate,
    folder: Path,
    surfaces: int,
    rates: _Rates,
) -> list[float]:
    """Print the rows of a scene; return the shares of levels below tolerance limits."""
    changes, _ = drawing.changes_of(BallAudition(), scene, base, 1, folder)
    (own,) = work.hear([base], surfaces).contenders
    chain = chain_levels(own.specimens)
    assert chain is not None  # as nothing falls
    for change in changes:
        if change.key in (drawing.DISTANCE, LOSS_KEY, "plate.loss_factor"):
            continue
        (changed,) = work.hear([change.candidate], surfaces).contenders
        apart = changed.levels_db - own.levels_db
        of_chain = chain_levels(changed.specimens)
        assert of_chain is not None
        rows = [_stated(apart, first, rates) for first in range(0, surfaces - GROUP + 1, GROUP)]
        stated, truth = rows[0]
        by_chain = of_chain - chain
        print(
            f"|{scene.name}|{change.name}|{stated}|{truth}|"
            f"{by_chain.mean():+.2f} ± {by_chain.std(ddof=1) / math.sqrt(surfaces):.2f}|",
            flush=True,
        )
    shares = []
    for first in range(0, surfaces - LIMIT_GROUP + 1, LIMIT_GROUP):
        inside = np.arange(surfaces) // LIMIT_GROUP == first // LIMIT_GROUP
        limit = tolerance_limit(own.levels_db[inside])
        shares.append(float(np.mean(own.levels_db[~inside] <= limit)))
    return shares


def _stated(apart: Array, first: int, rates: _Rates) -> tuple[str, str]:
    """Return the change of a level by a group of surfaces, and by all others, in words."""
    inside = np.zeros(len(apart), dtype=bool)
    inside[first : first + GROUP] = True
    of_group = paired_mean(apart[inside])
    others = apart[~inside]
    error = float(np.std(others, ddof=1)) / math.sqrt(len(others))
    stated_error = of_group.error * student_factor(of_group.freedom)
    rates.add(of_group.mean, stated_error, float(others.mean()), error)
    stated = f"{of_group.mean:+.2f} ± {stated_error:.2f}"
    return stated, f"{others.mean():+.2f} ± {error:.2f}"


if __name__ == "__main__":
    main()
