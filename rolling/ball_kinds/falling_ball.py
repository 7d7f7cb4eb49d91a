"""A ball that falls on a plate, bounces, and rolls on."""

from __future__ import annotations

from rolling.ball_kinds.one_ball import OneBall
from rolling.kinds.kind import Still
from rolling.results.run_result import Run


class FallingBall(OneBall):
    """A ball that falls on a plate, bounces, and rolls on: one event, which is heard once."""

    def still(self, run: Run) -> Still | None:
        """Return no picture: maps of a contact under its load show no impact."""
        return None


FALLING = FallingBall()
