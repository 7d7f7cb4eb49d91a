"""A ball that rolls over a rough plate."""

from __future__ import annotations

from rolling.ball_kinds.one_ball import OneBall
from rolling.ball_kinds.pilot_track import pilot_of
from rolling.kinds.kind import Pilot, Still
from rolling.results.run_result import Run
from rolling.scene.scene import Scene


class RollingBall(OneBall):
    """A ball that rolls over a rough plate under its load."""

    def pilot(self, scene: Scene) -> Pilot | None:
        """Return a short track that tells the first level of a scene."""
        return pilot_of(scene)

    def still(self, run: Run) -> Still | None:
        """Draw the loudest moment of a run from above."""
        from rolling.report import film

        return film.still(run)


ROLLING = RollingBall()
