"""Changes of a level by the linear response, beside those that marches give.

`python tests/benchmarks/linear_change_study.py` changes values of the drawing of three small scenes
by a tenth, marches both on two surfaces, and compares the change of the level with that by the
linear response, which ends the answer of `rolling choose`. It prints the table of
docs/what-would-help.md and the root mean square of the relative errors, and keeps what is marched
in outputs/linear-change-study, so that it goes on where it stopped.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from sensitivity_study import scenes

from rolling.ball_kinds import ball_drawing
from rolling.ball_kinds.linear_level import error_db, linear_change_db
from rolling.choice import drawing
from rolling.choice.audition import audition_of
from rolling.choice.sensitivity import improve_scene
from rolling.run.budget import Budget
from rolling.terminal import progress

OUT = Path("outputs/linear-change-study")
KEYS = (
    "sphere.radius_mm",
    "plate.thickness_mm",
    "surface.roughness_ra_um",
    "surface.correlation_length_um",
    "rolling.load_n",
    "rolling.speed_m_s",
)
SMALL_DB = 0.1  # marched changes below tell no relative error


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--workers", type=int, default=0)
    given = parser.parse_args()
    progress.begin(progress.Level.QUIET)
    ratios: dict[str, list[float]] = {key: [] for key in KEYS}
    print("|scene|value, +10 %|marched, dB|linear response, dB|\n|---|---|---|---|")
    for scene in scenes():
        base = ball_drawing.unchanged(scene)
        folder = given.out / scene.name
        changes, _ = drawing.changes_of(audition_of(scene), scene, base, given.workers, folder)
        by_key = {change.key: change for change in changes}
        for key in KEYS:
            found = improve_scene(scene, folder, [key], Budget(pairs=2), given.workers)
            (row,) = found.rows
            linear_db = linear_change_db(base.scene, by_key[key].candidate.scene)
            assert linear_db is not None
            if abs(row.db) >= SMALL_DB:
                ratios[key].append(1 - row.db / linear_db)
            stated_db = error_db(key, linear_db)
            beside = ", left out" if stated_db is None else f" ± {stated_db:.2f}"
            cells = [scene.name, row.change.name, f"{row.db:+.2f}", f"{linear_db:+.2f}{beside}"]
            print(f"|{'|'.join(cells)}|", flush=True)
    print()
    for key, errors in ratios.items():
        if errors:
            rms = float(np.sqrt(np.mean(np.square(errors))))
            print(f"{key}: relative error {rms:.2f} (rms of {len(errors)})")


if __name__ == "__main__":
    main()
