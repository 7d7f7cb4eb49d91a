"""A ball that falls on a plate, bounces, and rolls on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rolling.ball_kinds.one_ball import OneBall
from rolling.kinds.kind import Still
from rolling.kinds.machine import Machine
from rolling.results.run_result import Run
from rolling.scene.scene import Scene


class FallingBall(OneBall):
    """A ball that falls on a plate, bounces, and rolls on: one event, which is heard once."""

    def machine(self, scenes: Sequence[Scene], numbers: Sequence[Any] = ()) -> Machine:
        """Draw the ball as it falls on its plate."""
        from rolling.ball_kinds.ball_machine import falling_machine

        return falling_machine(scenes, numbers)

    def still(self, run: Run) -> Still | None:
        """Return no picture: maps of a contact under its load show no impact."""
        return None


FALLING = FallingBall()
