"""Coverage of the ± of a vibration on short rough tracks, over many seeds of each scene.

`python tests/benchmarks/short_track_study.py` marches five scenes with 30 seeds each, changes of
the ball on ground steel of choice_study.py: a track of 6 mm under 1 N with Ra 0.2 um and a
correlation length of 12 um. It compares the scatter of LAeq over the seeds with the ± that the runs
state, and with the ± of Gaussian noise of the same length. It prints a table of docs/accuracy.md,
in six minutes of one core. The loss factor of the contact is stated, so that seeds alone differ.
"""

from __future__ import annotations

import argparse
import copy
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from choice_study import BASES
from coverage_study import solved

import rolling as rc
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from rolling.kinds.run_folder import RunFolder
from rolling.results.run_result import make_run
from rolling.sound.vibration_sound import Vibration

SEEDS = 30
SCENES: dict[str, dict[str, Any]] = {
    "as it is": {},
    "yielding, 2 GPa": {"plate.hardness_gpa": 2.0},
    "5 N": {"rolling.load_n": 5},
    "Ra 0.4 um": {"surface.roughness_ra_um": 0.4, "surface.width_um": 288},
    "plate of 1 mm": {"plate.thickness_mm": 1},
}


class Row(NamedTuple):
    """Levels of the seeds of a scene and their uncertainties [dB], (seeds, ...)."""

    laeq: Array
    stated: Array
    gaussian: Array
    bands: Array
    bands_stated: Array


def scene_of(changes: dict[str, Any], seed: int) -> rc.Scene:
    """Return the ball on ground steel with changes and a seed of its surface."""
    sections = copy.deepcopy(BASES["steel"])
    sections |= {"name": "short-track", "dynamics": {}, "sound": {"source": "vibration"}}
    return rc.Scene.from_dict(sections).with_(changes | {"surface.seed": seed})


def vibration_of(scene: rc.Scene) -> Vibration:
    """March a scene in this process, and return its vibration."""
    run = make_run(RunFolder({}, scene, Path()), "", solved(scene), {})
    assert run.vibration_sound is not None  # the scene has dynamics
    return run.vibration_sound


def row_of(vibrations: Sequence[Vibration]) -> Row:
    """Gather the levels of the seeds of a scene, and their ± with and without excess variance."""
    gaussian = []
    for vibration in vibrations:
        assert vibration.excess is not None and vibration.uncertainty.laeq_db is not None
        record = vibration.spreads["record"]
        excess = record**2 * (1.0 - 1.0 / vibration.excess.laeq)
        gaussian.append(np.sqrt(vibration.uncertainty.laeq_db**2 - excess))
    levels = [vibration.levels for vibration in vibrations]
    spreads = [vibration.uncertainty for vibration in vibrations]
    return Row(
        laeq=np.array([one.laeq_db for one in levels], dtype=float),
        stated=np.array([one.laeq_db for one in spreads], dtype=float),
        gaussian=np.array(gaussian),
        bands=_bands([one.third_octave_db for one in levels]),
        bands_stated=_bands([one.third_octave_db for one in spreads]),
    )


def _bands(values: Sequence[dict[str, float | None]]) -> Array:
    """Return third octaves of seeds as an array, NaN where one is unknown."""
    return np.array([[one[name] for name in BAND_NAMES] for one in values], dtype=float)


def shares(values: Array, uncertainties: Array) -> str:
    """Write how many values lie within one and two uncertainties of their mean over seeds [%]."""
    known = np.isfinite(values).all(axis=0)
    apart = values - values.mean(axis=0)
    apart *= np.sqrt(len(values) / (len(values) - 1))  # the mean has each value in it
    sizes = np.abs(apart / uncertainties)
    sizes = sizes[:, known] if values.ndim == 2 else sizes
    return f"{100 * np.mean(sizes < 1):.0f}, {100 * np.mean(sizes < 2):.0f}"


def cells_of(name: str, row: Row) -> dict[str, Any]:
    """Return the cells of a scene in the table."""
    scatter = row.laeq.std(ddof=1)
    return {
        "scene": name,
        "seeds": len(row.laeq),
        "scatter [dB]": f"{scatter:.2f} ± {scatter / np.sqrt(2 * len(row.laeq)):.2f}",
        "Gaussian noise [dB]": f"{_rms(row.gaussian):.2f}",
        "within [%]": shares(row.laeq, row.gaussian),
        "stated [dB]": f"{_rms(row.stated):.2f}",
        "stated, within [%]": shares(row.laeq, row.stated),
        "third octaves, within [%]": shares(row.bands, row.bands_stated),
    }


def _rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def main(arguments: Sequence[str] | None = None) -> int:
    """March the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=SEEDS, help=f"of each scene ({SEEDS})")
    given = parser.parse_args(arguments)
    cells = []
    for name, changes in SCENES.items():
        print(name, file=sys.stderr, flush=True)
        seeds = range(1, given.seeds + 1)
        row = row_of([vibration_of(scene_of(changes, seed)) for seed in seeds])
        cells.append(cells_of(name, row))
    print(pd.DataFrame(cells).to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
