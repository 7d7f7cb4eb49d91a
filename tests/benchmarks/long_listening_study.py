"""Test of long listening: continuations of short tracks against a track solved ten times as long.

`python tests/benchmarks/long_listening_study.py [KIND...]` solves the tracks of `KINDS`, or some of
them, continues each tenth of them, and prints the numbers of docs/dynamics.md. All take a quarter
of an hour of one core.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

import rolling as rc
from acoustics import uncertainty
from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.level import SoundLevels, sound_levels
from acoustics.uncertainty import kurtosis
from rolling.dynamics.force_law import ForceLaw
from rolling.in_si.physics_of_scene import bodies_of, listener_of, turn_of
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.sound.long_listening import Listening, LongTravel, listen_to_vibration

PARTS = 10  # of the solved track, each continued by itself
LENGTHS = 10  # of a continuation, in lengths of the solved track
COARSE = 2.0  # standard uncertainties within which levels agree
BASE: dict[str, Any] = {
    "sphere": {"radius_mm": 5, "density_kg_m3": 7850},
    "plate": {
        "youngs_modulus_gpa": 210,
        "poissons_ratio": 0.3,
        "density_kg_m3": 7850,
        "thickness_mm": 10,
    },
    "surface": {
        "kind": "gaussian",
        "roughness_ra_um": 0.05,
        "correlation_length_um": 10,
        "spacing_um": 2,
        "width_um": 160,
        "seed": 1,
    },
    "rolling": {"load_n": 1, "speed_m_s": 0.3, "distance_mm": 20},
    "dynamics": {"release": False},
}
KINDS: dict[str, dict[str, Any]] = {  # changes of the base scene
    "elastic, 10 mm": {},
    "elastic, 10 mm, 1 m/s": {"rolling.speed_m_s": 1},
    "yielding, 3 mm": {"plate.hardness_gpa": 2.1, "plate.thickness_mm": 3, "surface.seed": 2},
    "exponential, 1 mm": {
        "surface.autocorrelation": "exponential",
        "plate.thickness_mm": 1,
        "plate.hardness_gpa": 2.1,
        "surface.seed": 3,
    },
    "glass, half-space": {
        "sphere.density_kg_m3": 2500,
        "plate.youngs_modulus_gpa": 70,
        "plate.density_kg_m3": 2500,
        "plate.thickness_mm": None,
        "surface.seed": 4,
    },
    "impacts, 10 mm, 1 m/s": {
        "surface.roughness_ra_um": 0.5,
        "surface.width_um": 320,
        "rolling.distance_mm": 10,
        "plate.hardness_gpa": 2.1,
        "rolling.speed_m_s": 1,
        "surface.seed": 5,
    },
}


def scene_of(kind: str, length_mm: float | None = None) -> Scene:
    """Return the scene of a kind, with a track of another length [mm]."""
    changes = {**KINDS[kind], **({"rolling.distance_mm": length_mm} if length_mm else {})}
    return rc.Scene.from_dict({"name": "listening", **BASE}).with_(changes)


def part_of(law: ForceLaw, part: int, parts: int) -> ForceLaw:
    """Return the law on one of the equal parts of a track, which is open."""
    count = len(law.position_m) // parts
    inside = slice(part * count, (part + 1) * count)
    position = law.position_m[inside] - law.position_m[part * count]
    return ForceLaw(position, law.load_n, law.approach_m[:, inside])


def rates(listening: Listening) -> tuple[float, float]:
    """Return impacts per second and kurtosis of a long record without its faded ends."""
    ends = listening.sample_rate // 100
    inner = listening.pressure[ends:-ends]
    return float(listening.numbers.impacts or 0) / _seconds(listening), kurtosis(inner)


def _seconds(listening: Listening) -> float:
    return len(listening.pressure) / listening.sample_rate


def levels_of(pressure: Array, rate: int, highest: float) -> tuple[SoundLevels, Any]:
    """Return the levels of a record with their uncertainty."""
    levels = sound_levels(pressure, rate, highest)
    return levels, uncertainty.level_uncertainty(pressure, rate, levels, False)


def compare(run: Run, parts: int = PARTS, lengths: float = LENGTHS) -> pd.DataFrame:
    """Compare the continuation of each part of a solved track with the whole track."""
    assert run.vibration_sound is not None
    scene = run.scene
    law = run.vibration_sound.law
    rate = run.sound.sample_rate
    solved = run.vibration_sound.levels
    spread = run.vibration_sound.uncertainty
    seconds = run.sound.duration * lengths
    solved_kurtosis = kurtosis(run.sound.pressure)
    motion = run.vibration_sound.motion
    rows = []
    for part in range(parts):
        short = part_of(law, part, parts)
        travel = LongTravel(motion=scene.motion, seconds=seconds, seed=part, turn=turn_of(scene))
        listening = listen_to_vibration(bodies_of(scene), listener_of(scene), short, travel)
        own = levels_of(listening.pressure, rate, run.sound.highest)[0]
        per_second, own_kurtosis = rates(listening)
        agree = []
        for name in BAND_NAMES:
            level = own.third_octave_db[name]
            of_long = solved.third_octave_db[name]
            error = spread.third_octave_db[name]
            if level is not None and of_long is not None and error is not None:
                # A part of the track is less certain by the root of the number of parts.
                both = error * math.sqrt(1 + parts)
                agree.append((level - of_long) / both)
        rows.append(
            {
                "level": (own.laeq_db or 0) - (solved.laeq_db or 0),
                "stated": (spread.laeq_db or 0) * math.sqrt(1 + parts),
                "bands": float(np.mean(np.abs(agree) < COARSE)),
                "kurtosis": own_kurtosis - solved_kurtosis,
                "impacts": per_second,
                "solved impacts": motion.impacts / run.sound.duration,
                "solved kurtosis": solved_kurtosis,
            }
        )
    return pd.DataFrame(rows)


def main(arguments: Sequence[str]) -> int:
    """Print the table of some kinds of scenes."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kinds", nargs="*", default=[*KINDS], metavar="KIND")
    parser.add_argument("--length", type=float, help="solved length [mm]")
    given = parser.parse_args(arguments)
    print(
        "| scene | LAeq difference: mean, rms, stated [dB] | third octaves | kurtosis | impacts/s |"
    )
    print("|---|---|---|---|---|")
    for kind in given.kinds:
        run = rc.simulate(scene_of(kind, given.length), workers=1, progress=False)
        table = compare(run)
        mean = table.mean()
        rms = float(np.sqrt(np.mean(np.square(table["level"]))))
        print(
            f"| {kind} | {mean['level']:+.1f}, {rms:.1f}, {mean['stated']:.1f} |"
            f" {100 * mean['bands']:.0f} % | {mean['solved kurtosis']:.2f},"
            f" {mean['solved kurtosis'] + mean['kurtosis']:.2f} |"
            f" {mean['solved impacts']:.0f}, {mean['impacts']:.0f} |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
