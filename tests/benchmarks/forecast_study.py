"""Test of forecasts: the time that `rolling check` names against the time that runs take.

`python tests/benchmarks/forecast_study.py` checks and runs the scenes of `SCENES` on one processor,
and prints the forecast, the processor time of the run with start, files and page, and their ratio.
Processor time hardly depends on other programs that run meanwhile. `--cores N` takes more
processors. All spheres take some five minutes, and all bearings some four.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

import rolling as rc
from rolling.check import forecast

SCENES: dict[str, tuple[str, list[str]]] = {
    "tiny": ("quickstart", ["sweep=", "rolling.load_n=5", "rolling.duration_s=0.01"]),
    "quickstart, 5 N": ("quickstart", ["sweep=", "rolling.load_n=5"]),
    "quickstart, three loads": ("quickstart", ["rolling.duration_s=0.01"]),
    "vibrating ball": ("vibrating-ball", ["rolling.duration_s=0.04"]),
    "ball on plate, eight runs": ("ball-on-plate", ["rolling.distance_mm=1"]),
    "round ball on sheet": ("round-ball-on-sheet", ["rolling.distance_mm=4"]),
    "marble dropped": ("marble-dropped", []),
    "running in": ("running-in", []),
}
# Bearings whose contacts are all marched.
DRY = ("bearing.oil=", "bearing.tilt=held", "bearing.ring=rigid", "bearing.angle=fixed")
# Bearings that the laws of `bearing_forecast` were not read from.
BEARINGS: dict[str, tuple[str, list[str]]] = {
    "608, rough balls": (
        "bearing-6204",
        [*DRY, "bearing.named=608", "bearing.axial_load_n=30", "numerics.window_mm=3"],
    ),
    "6305, radial load": (
        "bearing-6204",
        [
            *DRY,
            *("bearing.named=6305", "bearing.axial_load_n=150", "bearing.radial_load_n=200"),
            *("numerics.window_mm=2", "sound.listen_s=1"),
        ],
    ),
    "608, pit of the inner ring": (
        "bearing-inner-fault",
        [*DRY, "bearing.named=608", "numerics.window_mm=2", "sound.listen_s=2"],
    ),
    "6305, balls with mass": (
        "bearing-6204",
        [
            *DRY,
            *("bearing.named=6305", "bearing.ball_inertia=true"),
            *("numerics.window_mm=2", "sound.listen_s=1"),
        ],
    ),
    "6204 in a housing, three speeds": (
        "bearing-in-housing",
        [
            *DRY,
            *("numerics.window_mm=2", "sound.listen_s=0.5", "sound.duration_s=0.5"),
            "sweep.bearing.speed_rpm=[900, 1800, 3600]",
        ],
    ),
}


def measure(source: str, words: Sequence[str], cores: int) -> dict[str, float | str]:
    """Check and run a scene, and return the times [s]."""
    scene = rc.read_scene(source, words)
    seconds = scene.check().seconds
    began = time.perf_counter()
    before = _processor_seconds()
    with tempfile.TemporaryDirectory() as folder:
        sets = [part for word in words for part in ("--set", word)]
        command = [sys.executable, "-m", "rolling", "run", source, *sets]
        options = ["--out", str(Path(folder) / "run"), "--workers", str(cores)]
        subprocess.run([*command, *options], check=True, capture_output=True)
    processor = _processor_seconds() - before
    wall = time.perf_counter() - began
    return {
        "forecast s": seconds / cores,
        "words": forecast.takes(seconds),
        "processor s": processor / cores,
        "wall s": wall,
        "forecast / processor": seconds / processor,
    }


def _processor_seconds() -> float:
    """Return the processor time of the processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the scenes and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES | BEARINGS)}"
    )
    parser.add_argument("--cores", type=int, default=1, help="processors (1)")
    given = parser.parse_args(arguments)
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: given.cores])
    rows = []
    scenes = SCENES | BEARINGS
    for name in given.scenes or scenes:
        rows.append({"scene": name} | measure(*scenes[name], given.cores))
        print(rows[-1], file=sys.stderr, flush=True)
    print(pd.DataFrame(rows).round(2).to_string(index=False))
    return 0


if __name__ == "__main__":
    sys.exit(main())
