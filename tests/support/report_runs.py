"""Runs in memory for the tests of figures and page, each solved once in a third of a second."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
import pytest
from finished import run_of
from hard_cases.gaussian_heights import gaussian
from memory_scenes import MEMORY

from rolling.figures.catalogue import single_picture
from rolling.figures.picture import Picture
from rolling.kinds.reading import read_scene
from rolling.results import labels
from rolling.results.run_result import Run
from rolling.scene.scene import Scene

STEPS = 300  # once round: 0.6 mm, 6 ms
HOSTILE = "quoted \"one\" 'two' & </script><img src=x onerror=alert(1)><!-- <script>"
SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: file, path: z<i>.npy, spacing_um: 2}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.9}
numerics: {tolerance: 1.0e-3}
"""
SMOOTH = """\
name: silence
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: smooth, spacing_um: 2, width_um: 120}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.002}
numerics: {tolerance: 1.0e-3}
"""
FLYING = """\
name: flying
sphere: {radius_mm: 3, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10}
surface: {kind: file, path: z<i>.npy, spacing_um: 2}
rolling: {load_n: 0.3, speed_m_s: 1, distance_mm: 0.6}
numerics: {tolerance: 1.0e-3}
dynamics: {}
sound: {source: vibration}
"""
EDGED = {
    "rolling.speed_m_s": 0.1,
    "plate.length_mm": 120,
    "plate.width_mm": 100,
    "plate.loss_factor": 0.1,
}
PLACED = {"sound.listener_mm": [20, 30, 250]}  # 0.252 m from the contact at [51.6, 37, 0] mm
TO_AND_FRO = {
    "plate.contact_path": "to-and-fro",
    "plate.contact_mm": [30, 40],
    "plate.contact_end_mm": [90, 60],
}
FALL = {"rolling.speed_m_s": 0.02, "rolling.drop_mm": 0.1, "rolling.load_n": "weight"}
BESIDE = """\
name: beside
sphere: {radius_mm: 10}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 8}
surface: {kind: gaussian, roughness_ra_um: 1, correlation_length_um: 20, spacing_um: 2,
  width_um: 512, seed: 1}
rolling: {load_n: 0.1, speed_m_s: 0.1, duration_s: 0.006}
"""
SEEDS = """\
name: seeds
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2,
  width_um: 128, seed: 1}
rolling: {load_n: 0.1, speed_m_s: 0.1, duration_s: 0.004}
recovery: {events: true}
numerics: {tolerance: 1.0e-3}
"""


@cache
def folder() -> Path:
    """Return a folder with the height file of the scenes."""
    made = Path(mkdtemp(prefix="report-runs-"))
    rough = gaussian((STEPS, 100), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 3)
    np.save(made / "z<i>.npy", rough)
    return made


def scene_of(text: str) -> Scene:
    """Read a scene beside its height file."""
    path = folder() / "scene.yaml"
    path.write_text(text)
    return read_scene(path)


def solved(scene: Scene, values: dict[str, Any] | None = None, film: bool = False) -> Run:
    """March a scene in this process and make its sound."""
    with pytest.MonkeyPatch.context() as patch:
        # A run that is too short for a film gets one.
        patch.setattr("rolling.marches.next_pieces.SHARE", 0.3)
        return replace(run_of(scene, folder(), film), values=values or {})


def swept(text: str, key: str, *values: float, film: bool = False) -> list[Run]:
    """March a scene at several values of a key."""
    return [solved(scene_of(text).with_({key: v}), {key: v}, film) for v in values]


def labelled(runs: list[Run]) -> list[Run]:
    """Return runs with labels that tell them apart."""
    return [replace(run, label=label) for run, label in zip(runs, labels.labels(runs), strict=True)]


def _seeds() -> list[Run]:
    scene = scene_of(SEEDS)
    pairs = [(load, seed) for load in (0.1, 0.2) for seed in (1, 2, 3)]
    return [
        solved(scene.with_(load_n=load, seed=seed), {"rolling.load_n": load, "surface.seed": seed})
        for load, seed in pairs
    ]


RUNS: dict[str, Callable[[], list[Run]]] = {
    "three": lambda: swept(SCENE, "rolling.load_n", 0.5, 1, 2),
    "one": lambda: [solved(scene_of(SCENE).with_(description=HOSTILE))],
    "smooth": lambda: [solved(scene_of(SMOOTH))],
    "lap": lambda: [solved(scene_of(SCENE).with_(duration_s=0.006))],
    "fast": lambda: [solved(scene_of(SCENE).with_(speed_m_s=0.2, duration_s=0.45))],
    "long": lambda: [solved(scene_of(SCENE).with_(duration_s=0.3, listen_s=2))],
    "braking": lambda: [solved(scene_of(SCENE).with_(speed_m_s=[[0, 0.4], [0.1, 0.2]]))],
    "filmed": lambda: [solved(scene_of(SCENE).with_(duration_s=0.006), film=True)],
    "flying": lambda: swept(FLYING, "rolling.speed_m_s", 0.1, 1, film=True),
    "edged": lambda: [solved(scene_of(FLYING).with_(EDGED))],
    "placed": lambda: [solved(scene_of(FLYING).with_(EDGED | PLACED))],
    "to-and-fro": lambda: [solved(scene_of(FLYING).with_(EDGED | TO_AND_FRO))],
    "falling": lambda: [solved(scene_of(FLYING).with_(FALL), film=True)],
    "beside": lambda: [solved(scene_of(BESIDE))],
    "seeds": _seeds,
    "memory": lambda: [solved(scene_of(MEMORY))],
}


@cache
def made(name: str) -> tuple[Run, ...]:
    """Return the runs of a name, solved once."""
    return tuple(RUNS[name]())


def runs_of(*names: str) -> list[Run]:
    """Return the runs of names with labels that tell all of them apart."""
    return labelled([run for name in names for run in made(name)])


def single(name: str, run: Run, among: Sequence[Run] = ()) -> Picture:
    """Return a figure of a run, on the axes of the runs among which it is compared."""
    drawn = single_picture(name, run, among or [run])
    assert drawn is not None
    return drawn
