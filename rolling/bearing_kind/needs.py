"""Memory and disk that the runs of a bearing need, and doubts where they do not suffice.

The marches of its contacts are judged as those of every scene, without sound. The motion is judged
by the samples that are kept of the ring and of each ball.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from rolling.bearing_kind.contact_plan import ContactPlan
from rolling.bearing_kind.joined_tracks import points_of_turn
from rolling.check import cost, memory_and_disk, refusals
from rolling.check.run_size import run_size
from rolling.numbers.doubt import Doubt
from rolling.scene.bearing_scene import BearingScene

# Bytes while the files of a run are written. 1,020 and 2,570 per sample were measured for 20 and 60
# balls, which is 240 and 39 for each ball.
SAMPLE = 240.0
SAMPLE_BALL = 40.0
SAMPLE_BENDING = 80.0
# Bytes of each point of a track at each load: as it is given, at up to four times the points for
# the steps of the motion, and as it is written.
TRACK_POINT = 52.0
# Bytes on disk of each sample of the ring and its sounds, of a ball, and of a point of a track at
# each load.
SAMPLE_FILE = 38.0
SAMPLE_BALL_FILE = 4.0
SAMPLE_BENDING_FILE = 8.0
TRACK_POINT_FILE = 4.0
SHORTER = "shorten sound.listen_s or sound.duration_s"
# Advice for the largest part of a memory that does not suffice.
ADVICE = {
    "program": "give fewer --workers",
    "surface": "shorten numerics.window_mm, or choose a larger numerics.spacing_um",
    "window": "choose a larger numerics.spacing_um, or fewer --workers",
    "tracks": "choose a larger numerics.spacing_um",
    "record": SHORTER,
}


def excess(
    scene: BearingScene, plan: ContactPlan, workers: int, folder: Path | None
) -> Iterator[Doubt]:
    """Yield the doubts "memory" and "disk" where a run does not fit: need, limit and advice.

    Parameters
    ----------
    scene : BearingScene
        Scene without a sweep.
    plan : ContactPlan
        Its contacts.
    workers : int
        Number of processes; 0 means one per core.
    folder : Path or None
        Folder of the results; None if nothing is written.
    """
    marches = [march for stage in plan.stages for march in stage]
    if marches:
        sizes = [run_size(march) for march in marches]
        parts = memory_and_disk.memory(sizes, workers or cost.cores())
        del parts["record"]  # no sound is made of a contact
        yield from refusals.lacking_memory(parts, ADVICE, " of the contacts")
    yield from refusals.lacking_memory(motion_memory(scene, plan), ADVICE)
    if folder is not None:
        yield from refusals.lacking_disk(motion_disk(scene, plan), folder, SHORTER)


def motion_memory(scene: BearingScene, plan: ContactPlan) -> dict[str, float]:
    """Estimate the memory [bytes] that the motion of a ring takes, by its largest parts."""
    per_sample = SAMPLE + SAMPLE_BALL * scene.bearing.balls + SAMPLE_BENDING * _bending(scene)
    return {
        "record": per_sample * _samples(scene),
        "tracks": TRACK_POINT * _track_points(plan),
        "program": memory_and_disk.ALONE,
    }


def motion_disk(scene: BearingScene, plan: ContactPlan) -> float:
    """Estimate the size [bytes] of the files of a run."""
    per_sample = SAMPLE_FILE + SAMPLE_BALL_FILE * scene.bearing.balls
    per_sample += SAMPLE_BENDING_FILE * _bending(scene)
    tracks = TRACK_POINT_FILE * _track_points(plan)
    return memory_and_disk.RUN_FILES + per_sample * _samples(scene) + tracks


def _track_points(plan: ContactPlan) -> int:
    """Return the number of points of all tracks, at all loads."""
    points = points_of_turn(plan, "inner") + points_of_turn(plan, "outer")
    points += 2 * plan.geometry.balls * points_of_turn(plan, "balls")
    return len(plan.loads_n) * points


def _bending(scene: BearingScene) -> int:
    """Return the number of displacements of a ring beside x, y and z."""
    return len(scene.model.columns) - 3


def _samples(scene: BearingScene) -> int:
    """Return the number of samples of the motion of a ring."""
    return math.ceil(scene.moved * memory_and_disk.SAMPLE_RATE)
