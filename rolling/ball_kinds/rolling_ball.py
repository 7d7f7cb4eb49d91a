"""A ball that rolls over a rough plate."""

from __future__ import annotations

from rolling.ball_kinds.one_ball import OneBall
from rolling.kinds.kind import Still
from rolling.results.run_result import Run


class RollingBall(OneBall):
    """A ball that rolls over a rough plate under its load."""

    def still(self, run: Run) -> Still | None:
        """Draw the loudest moment of a run from above."""
        from rolling.report import film

        return film.still(run)


ROLLING = RollingBall()
