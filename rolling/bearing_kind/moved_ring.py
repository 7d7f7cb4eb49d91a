"""Motion of a ring while a person watches a bar."""

from rolling.bearing.model import BearingModel
from rolling.bearing.ring_motion import RingMotion, move_ring
from rolling.bearing.tracks import BearingTracks
from rolling.terminal import progress


def moved_ring(
    bearing: BearingModel, tracks: BearingTracks, duration_s: float, rate_hz: int = 48000
) -> RingMotion:
    """Move the ring of a bearing over its tracks, and show a bar until it has moved."""
    with progress.Bar(1.0, "moving the ring") as bar:
        return move_ring(bearing, tracks, duration_s, rate_hz, progress=bar.update)
