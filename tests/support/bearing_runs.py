"""Scenes of bearings that need no march: smooth surfaces with waves, and how they are run.

Their ring is rigid at a fixed angle, for which the laws of waves are closed forms.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

from rolling.bearing.ring_record import RingRecord
from rolling.bearing.tracks import BearingTracks
from rolling.bearing_kind.bearing_run import BearingRun, numbered
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.interface.runs import simulate
from rolling.scene import file
from rolling.scene.bearing_scene import BearingScene

WAVY = """\
name: wavy
title: A bearing with waves
bearing:
  named: "6204"
  speed_rpm: 1800
  axial_load_n: 70
  angle: fixed
  ring: rigid
  contact_angle_deg: 12
  radial_clearance_um: null
  surfaces:
    inner: {kind: smooth, waviness: {9: 0.1}}
    outer: {kind: smooth, waviness: {8: 0.05}}
sound: {duration_s: 0.5, listen_s: 0.5}
"""
SWEPT = WAVY.replace("0.5", "0.2") + "sweep: {bearing.axial_load_n: [65, 70, 75]}\n"
PLATE = """\
plate: {material: steel-s235, thickness_mm: 3, length_mm: 100, width_mm: 80, edges: clamped}
"""


def written(folder: Path, text: str = WAVY, name: str = "wavy.yaml") -> Path:
    """Write a scene file into a folder."""
    path = folder / name
    path.write_text(text)
    return path


@cache
def turning() -> BearingRun:
    """Return a run of 0.2 s of a bearing with waves, solved once."""
    words = ["sound.duration_s=0.2", "sound.listen_s=0.2"]
    return simulate(loads_bearing(WAVY, words), progress=False)


def solved(scene: BearingScene, record: RingRecord, tracks: BearingTracks) -> SolvedBearing:
    """Return a bearing in memory, from the motion of its ring."""
    return SolvedBearing({}, scene, Path(), label="", record=record, tracks=tracks)


def moved_as(run: BearingRun, record: RingRecord, scene: BearingScene | None = None) -> BearingRun:
    """Return a run with the numbers of another record of its ring, and maybe of another scene."""
    return numbered(solved(scene or run.scene, record, run.tracks))


def loads_bearing(
    text: str, overrides: Sequence[str] = (), where: str = "scene", folder: Path = Path()
) -> BearingScene:
    """Read the scene of a bearing from text, as `file.loads` reads that of a sphere."""
    return file.loads(text, overrides, where, folder, BearingScene)
