"""Time of the work after the solving: sound, files, pictures and the page."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.check.demand import PAGE_RUNS
from rolling.scene.scene import Scene

# Seconds of one core. They follow from whole commands, timed with all pictures drawn by one
# process: 28 s beside the solving for three runs of 0.5 s of sound, 148 s for 24 of them, and 310 s
# for 200 runs of 0.0005 s.
START = 4.0  # of the program, its libraries, and the libraries that draw
RUN, SOUND = 0.1, 0.4  # of the files of a run; per second of sound, of which levels are made
PICTURE, DENSE_PICTURE = 0.17, 0.73  # of a picture of few lines, and of as many as are drawn
DENSE_S = 0.5  # duration of a record whose pictures have all lines that are drawn
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
        alone += OF_ALL * _picture(sum(durations))
    if len(scenes) > PAGE_RUNS:
        return alone
    own = OF_RUN * sum(_picture(duration) for duration in durations)
    return alone + own / (cores if len(scenes) > 1 else 1)


def _picture(duration: float) -> float:
    """Return the time [s] to draw a picture of a record, which grows until it is dense."""
    return PICTURE + (DENSE_PICTURE - PICTURE) * min(1.0, duration / DENSE_S)
