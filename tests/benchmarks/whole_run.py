"""A run of the 20 N scene in a fresh process, for speed.py.

It measures wall seconds, start-up of the workers and peak memory.

python tests/benchmarks/whole_run.py run STEPS WORKERS        prints a line of JSON
python tests/benchmarks/whole_run.py convolutions SECONDS     prints bare convolutions per second
"""

from __future__ import annotations

import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from against_peers import peak_memory

from rolling.contact.half_space import HalfSpace
from rolling.in_si.scene_surface import heights
from rolling.kinds.reading import read_scene
from rolling.marches.march_piece import march_piece
from rolling.marches.piece import Piece, contact_identity, track_pieces
from rolling.scene.scene import Scene

QUICKSTART = Path(__file__).parent.parent.parent / "scenarios" / "quickstart.yaml"
# Speed and spacing of that scene.
SPEED = 0.1
SPACING = 2e-6


def scene_20_n(*overrides: str) -> Scene:
    """Return the quickstart's run under 20 N."""
    runs = read_scene(QUICKSTART, overrides).runs()
    return next(scene for values, scene in runs if values["rolling.load_n"] == 20)


Arrays = dict[str, np.ndarray]


def simulated(
    scene: Scene, todo: list[tuple[int, int]], workers: int
) -> tuple[np.ndarray, list[Arrays]]:
    """Return wall and CPU seconds, workers included, and the arrays of the pieces."""
    identity = contact_identity(scene)
    pieces = [Piece(scene, identity, "track", first, last) for first, last in todo]
    began = clocks()
    if workers == 1:
        arrays = [march_piece(piece) for piece in pieces]
        return clocks() - began, arrays
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        arrays = list(pool.map(march_piece, pieces))
    return clocks() - began, arrays


def clocks() -> np.ndarray:
    """Return wall and CPU seconds of this process and the children that it has waited for."""
    return np.array([time.perf_counter(), sum(os.times()[:4])])


def run(steps: int, workers: int) -> dict[str, float]:
    """Time a run in which every piece is kept.

    The first piece loads the compiled code, and a step for each worker is its start-up.
    """
    scene = scene_20_n(f"rolling.duration_s={steps * SPACING / SPEED:.10g}")
    heights(scene)
    surface_peak = peak_memory()
    simulated(scene, [(0, 1)], 1)
    start_up, _ = simulated(scene, [(0, 1)] * workers, workers)
    resident = peak_memory(afresh=True)
    seconds, marched = simulated(scene, track_pieces(steps), workers)
    means = {
        name: np.concatenate([arrays[name] for arrays in marched]).mean()
        for name in ("iterations", "convolutions")
    }
    return {
        "steps": sum(len(arrays["release_energy"]) for arrays in marched),
        "workers": workers,
        "seconds": seconds[0],
        "cpu_s": seconds[1],
        "start_up_s": start_up[0],
        "start_up_cpu_s": start_up[1],
        "peak_bytes": max(surface_peak, peak_memory()),
        "march_bytes": peak_memory() - resident,
        **means,
    }


def convolutions_per_second(seconds: float) -> float:
    """Count convolutions of windows about as large as the scene's."""
    scene = scene_20_n()
    pressure = np.random.default_rng(0).uniform(0, 1e9, (96, 96))
    half_space = HalfSpace(scene.spacing, scene.contact_modulus)
    half_space.deflection(pressure)  # plans its transforms
    began = time.perf_counter()
    before = half_space.count
    while (took := time.perf_counter() - began) < seconds:
        half_space.deflection(pressure)
    return (half_space.count - before) / took


if __name__ == "__main__":
    what, *numbers = sys.argv[1:]
    print(
        json.dumps(
            run(*map(int, numbers)) if what == "run" else convolutions_per_second(float(numbers[0]))
        )
    )
