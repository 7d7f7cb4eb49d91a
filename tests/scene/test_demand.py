"""The estimate of memory and disk is the measured size to twice of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from large_scenes import FILE, LAPS, scene_of
from scene_text import MADE, TEXT

from rolling.check import cost, demand
from rolling.report import page
from rolling.scene import file as scene_file
from rolling.simulation import simulate

# Measured: the peak of the resident memory of all processes, and the size of the folder without the
# copy of result.h5 that stands beside it while it is written [MB]. The constants were fitted to the
# first nine; the others were predicted.
FORTY = f"sweep: {{rolling.load_n: {[round(0.01 * k, 2) for k in range(1, 41)]}}}"
MEASURED = [
    ("laps", FILE, LAPS % (0.1, 10), 1, 592, 106),
    ("many laps", FILE, LAPS % (10, 1), 1, 2498, 877),
    ("long and slow", FILE, LAPS % (0.001, 300), 1, 3917, 447),
    ("varying speed", FILE, LAPS % ("[[0, 0.01], [10, 0.01], [10.001, 1]]", 10.05), 1, 530, 30),
    (
        "oversampling",
        MADE,
        LAPS % ("[[0, 0.001], [2, 0.001], [2.0004, 5]]", 2.0005),
        1,
        1194,
        5,
    ),
    (
        "wide",
        MADE.replace("200", "20000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.02}",
        2,
        1360,
        3,
    ),
    (
        "wide, smooth",
        "surface: {kind: smooth, spacing_um: 2, width_um: 40000}\n",
        LAPS % (0.1, 0.02),
        2,
        608,
        2,
    ),
    (
        "large window",
        MADE.replace("0.1, corr", "1, corr")
        .replace("_um: 2,", "_um: 0.5,")
        .replace("width_um: 200", "width_um: 640"),
        "{load_n: 100, speed_m_s: 0.1, duration_s: 0.0064}\nnumerics: {step_nodes: 16}",
        1,
        1408,
        17,
    ),
    (
        "steep, 2 x 2 sub-cells",
        MADE.replace("0.1, corr", "1, corr").replace("200", "10000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.01}",
        1,
        626,
        3,
    ),
    (
        "4 x 4 sub-cells",
        MADE.replace("0.1, corr", "1, corr").replace("200", "6000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.005}\nnumerics: {subcells: 4}",
        1,
        712,
        3,
    ),
    (
        "flat cells",
        MADE.replace("0.1, corr", "1, autocorrelation: exponential, corr").replace("200", "6000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.005}",
        1,
        419,
        3,
    ),
    (
        "steep, large window",
        MADE.replace("0.1, corr", "1, corr").replace("_um: 2,", "_um: 1,").replace("200", "500"),
        "{load_n: 50, speed_m_s: 0.1, duration_s: 0.005}\nnumerics: {step_nodes: 10}",
        1,
        875,
        5,
    ),
    (
        "events",
        MADE.replace("spacing_um: 2", "spacing_um: 1"),
        "{load_n: 5, speed_m_s: 0.1, duration_s: 0.02}\nrecovery: {events: true}",
        1,
        371,
        7,
    ),
    ("one short run", MADE, "{load_n: 1, speed_m_s: 0.1, duration_s: 0.009}", 2, 626, 2),
    ("loudness", FILE, LAPS % (0.02, 60) + "\nsound: {loudness: true}", 1, 1061, 182),
    (
        "eight runs",
        FILE,
        LAPS % (0.1, 3) + "\nsweep: {rolling.load_n: [1, 2, 3, 4, 5, 6, 7, 8]}",
        1,
        542,
        289,
    ),
    (
        "forty runs",
        MADE.replace("200", "100"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.003}\n" + FORTY,
        2,
        643,
        13,
    ),
    (
        "wider",
        MADE.replace("200", "40000"),
        "{load_n: 1, speed_m_s: 0.1, duration_s: 0.04}",
        2,
        4162,
        3,
    ),
    (
        "coarse",
        MADE.replace("0.1, corr", "0.05, corr")
        .replace("_um: 10", "_um: 40")
        .replace("_um: 2,", "_um: 8,"),
        "{load_n: 0.2, speed_m_s: 0.4, duration_s: 1}",
        2,
        714,
        13,
    ),
]


@pytest.mark.parametrize(
    ("surface", "rest", "workers", "memory_mb", "disk_mb"),
    [case[1:] for case in MEASURED],
    ids=[case[0] for case in MEASURED],
)
def test_estimate_is_the_measured_size_to_twice_of_it(
    tmp_path: Path, surface: str, rest: str, workers: int, memory_mb: float, disk_mb: float
) -> None:
    np.save(tmp_path / "heights.npy", np.random.default_rng(1).standard_normal((64, 64)) * 2e-8)
    scene = scene_file.read_scene(scene_of(tmp_path, surface, rest))
    needed = demand.of_scenes(
        [(single, cost.roughness(single)[0]) for _, single in scene.runs()], workers
    )
    assert memory_mb <= needed.memory.total / 1e6 <= 2 * memory_mb
    if disk_mb > 100:
        assert disk_mb <= needed.disk.total / 1e6 <= 2 * disk_mb
    else:  # pictures, mostly: a few megabytes more or less
        assert disk_mb <= needed.disk.total / 1e6 <= 2 * disk_mb + 20


def test_numbers_that_the_estimate_shares_with_slow_modules() -> None:
    assert (demand.MAPS, demand.MAP_CELLS) == (simulate.MAPS, simulate.MAP_CELLS)
    assert (demand.PIECE_STEPS, demand.PAGE_RUNS) == (simulate.PIECE_STEPS, page.MOST_RUNS)
    assert set(demand.ADVICE) >= {part for scene in (TEXT,) for part, _ in largest_parts(scene)}


def largest_parts(text: str) -> list[tuple[str, float]]:
    scene = scene_file.loads(
        text, ["recovery.events=true", "rolling.speed_m_s=[[0, 0.1], [1, 1000]]"]
    )
    needed = demand.of_scenes(
        [(single, cost.roughness(single)[0]) for _, single in scene.runs()], 2
    )
    return [*needed.memory.parts, *needed.disk.parts, *needed.process.parts]
