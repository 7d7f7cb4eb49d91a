"""Balls that roll and balls that fall, which scene files, folders and tables of runs may mix."""

from __future__ import annotations

from rolling.ball_kinds.falling_ball import FALLING
from rolling.ball_kinds.one_ball import OneBall
from rolling.ball_kinds.rolling_ball import ROLLING
from rolling.scene.scene import Scene


class Balls(OneBall):
    """Balls on plates, each of which rolls or falls."""

    def of_scene(self, scene: Scene) -> OneBall:
        """Return the kind of a ball that falls, or of one that rolls."""
        return FALLING if scene.rolling.falls else ROLLING


KIND = Balls()
