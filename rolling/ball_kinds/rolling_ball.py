"""A ball that rolls over a rough plate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rolling.ball_kinds.one_ball import OneBall
from rolling.ball_kinds.pilot_track import pilot_of
from rolling.check.findings import Findings, check_scene
from rolling.kinds.kind import Pilot, Still
from rolling.kinds.machine import Machine
from rolling.marches.piece import contact_identity
from rolling.results.run_result import Run
from rolling.scene.scene import Scene
from rolling.terminal import defaults


class RollingBall(OneBall):
    """A ball that rolls over a rough plate under its load."""

    def check(self, scene: Scene, solve: bool = True) -> Findings:
        """Judge all runs of a scene before they are run, whose time holds that of their pilots."""
        pilots: dict[str, Scene] = {}
        runs = scene.runs()
        if len(runs) <= defaults.MAX_RUNS_ON_PAGE:
            for _, single in runs:
                pilot = pilot_of(single)
                if pilot is not None:
                    pilots.setdefault(contact_identity(pilot.scene), pilot.scene)
        return check_scene(scene, solve=solve, pilots=[*pilots.values()])

    def pilot(self, scene: Scene) -> Pilot | None:
        """Return a short track that tells the first level of a scene."""
        return pilot_of(scene)

    def machine(self, scenes: Sequence[Scene], numbers: Sequence[Any] = ()) -> Machine:
        """Draw the ball as it rolls over its plate."""
        from rolling.ball_kinds.ball_machine import rolling_machine

        return rolling_machine(scenes, numbers)

    def still(self, run: Run) -> Still | None:
        """Draw the loudest moment of a run from above."""
        from rolling.report import film

        return film.still(run)


ROLLING = RollingBall()
