"""Scenes that are marched in this process, with the runs that they make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from helpers import march_all

from rolling.kinds.run_folder import RunFolder
from rolling.marches.march_piece import march_piece
from rolling.marches.next_pieces import next_pieces
from rolling.numbers.ball_numbers import RunNumbers
from rolling.results.run_result import Run, make_run
from rolling.scene.file import loads
from rolling.scene.scene import Scene

# A ball that rolls over a plate of steel and is heard by the vibration: 240 steps.
VIBRATING = """\
name: vibrating
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10,
  loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 10, spacing_um: 2,
  width_um: 160, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.3, distance_mm: 0.48}
numerics: {step_nodes: 1}
dynamics: {}
sound: {source: vibration}
"""
_UNSTORED = ("effort", "extremes", "motion")
WITHOUT_DYNAMICS = ("dynamics=", "sound=", "plate.thickness_mm=", "plate.loss_factor=")


def marched(
    text: str, changes: Sequence[str] = (), folder: Path = Path(), film: bool = False
) -> Run:
    """Return the run of a scene that is given as text with changes."""
    return run_of(loads(text, changes), folder, film)


def run_of(scene: Scene, folder: Path = Path(), film: bool = False) -> Run:
    """Return the run of a scene, marched in this process."""
    return make_run(RunFolder({}, scene, folder), "run", march_all(scene, film))


def doubt_lines(run: Run) -> dict[str, str]:
    """Return the lines of the doubts of a run by key."""
    return {doubt.key: doubt.line for doubt in run.numbers.doubts}


def untimed(numbers: RunNumbers) -> RunNumbers:
    """Return numbers without processor times, which differ from run to run."""
    effort = replace(numbers.effort, step_ms=None, march_cpu_s=0.0, parts_cpu_s=None)
    return replace(numbers, effort=effort)


def same(a: Any, b: Any) -> bool:
    """Tell whether two values are equal to the last bit, NaN included, at any depth."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if hasattr(a, "__dataclass_fields__"):
        names = [field.name for field in fields(a) if field.name not in _UNSTORED]
        return all(same(getattr(a, name), getattr(b, name)) for name in names)
    return bool(a == b) or (a != a and b != b)


def heard_again(run: Run, scene: Scene) -> Run:
    """Return the run of another scene over the marches of a run, and over those that it lacks."""
    result = replace(run.result, moving=None)
    while pieces := next_pieces(scene, result):
        for piece in pieces:
            result.add(piece, march_piece(piece))
    return make_run(RunFolder({}, scene, run.folder), "again", result)
