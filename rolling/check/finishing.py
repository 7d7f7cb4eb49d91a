"""Time of what follows the solving: sound, files, pictures and the page."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.check import cost
from rolling.check.demand import PAGE_RUNS
from rolling.scene.scene import Scene

# Seconds of one core, measured on scenes of 0.0005 to 10 s of sound.
START = 4.0  # of the program and its libraries, and of those of the pictures
RUN = 0.1  # of the files of a run
SOUND = 0.4  # per second of sound, of which levels and files are made
PICTURE, PICTURE_SOUND = 0.35, 0.1  # of a picture; per second of sound that it shows
OF_RUN, OF_ALL = 9, 6  # pictures of a run, and of all runs together


def seconds(scenes: Sequence[Scene], cores: int) -> float:
    """Estimate the time [s] that runs take besides their solving.

    Pictures of each run are drawn on all cores, the rest is done on one.

    Parameters
    ----------
    scenes : Scenes without a sweep, one per run.
    cores : int
        Number of processes that draw.
    """
    durations = [scene.duration for scene in scenes]
    alone = START + sum(RUN + SOUND * duration for duration in durations)
    if len(scenes) > 1:
        alone += OF_ALL * (PICTURE + PICTURE_SOUND * sum(durations))
    if len(scenes) > PAGE_RUNS:
        return alone
    own = sum(OF_RUN * (PICTURE + PICTURE_SOUND * duration) for duration in durations)
    return alone + own / (cores if len(scenes) > 1 else 1)
