"""What more work would buy a run of a bearing, by its own numbers, and what it left out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from acoustics.numbers import si
from rolling.kinds.page_parts import Part
from rolling.numbers.quantity import Quantity
from rolling.report.work import (
    FINER,
    GRID,
    MORE_STEPS,
    MoreWork,
    Omission,
    with_gain,
    work_part,
)
from rolling.sound.error_estimate import DEFAULT_ORDER

if TYPE_CHECKING:
    from rolling.bearing_kind.bearing_run import BearingRun

NEVER = "oil, friction, the tilt of rings, the mass of the cage, or the room"
WINDOW = "window"


def work_of(runs: Sequence[BearingRun]) -> Part:
    """Return the part of a page with both lists of each run."""
    return work_part(
        [run.label for run in runs],
        [more_work(run) for run in runs],
        [omissions(run) for run in runs],
        NEVER,
    )


def more_work(run: BearingRun) -> list[MoreWork]:
    """Return what longer tracks and half the spacing would buy the most uncertain radial band."""
    name, quantity = _most_uncertain(run)
    number = f"radial {name} band"
    seconds = run.numbers.effort.march_cpu_s or None
    longer = MoreWork(
        what="Ten times the steps, by numerics.window_mm,",
        number=number,
        source=WINDOW,
        seconds=seconds,
        new_seconds=None if seconds is None else MORE_STEPS * seconds,
    )
    finer = MoreWork(what="Half the spacing", number=number, source=GRID)
    return [
        with_gain(longer, quantity, 1 / math.sqrt(MORE_STEPS)),
        with_gain(finer, quantity, FINER**-DEFAULT_ORDER),
    ]


def _most_uncertain(run: BearingRun) -> tuple[str, Quantity]:
    """Return the radial band below the bending whose ± is largest, with its name."""
    radial = run.numbers.below_bending.radial
    bands = {"low": radial.low, "medium": radial.medium, "high": radial.high}
    name = max(bands, key=lambda band: bands[band].uncertainty or 0.0)
    return name, bands[name]


def omissions(run: BearingRun) -> list[Omission]:
    """List what a run left out, with the fact of its scene or the number of the run behind it."""
    scene = run.scene
    bearing = scene.bearing
    left = [
        Omission(
            f"Bending of the rings above {si(run.numbers.ring.bending_hz, 'Hz')}",
            "the bands that lead end there",
        )
    ]
    if not bearing.ball_inertia:
        left.append(Omission("Inertia of the balls", "bearing.ball_inertia is false"))
    if bearing.angle == "fixed":
        left.append(
            Omission("Angles that turn with the load", "the scene keeps them (bearing.angle)")
        )
    for body in ("balls", "inner", "outer"):
        if getattr(bearing.surfaces, body) is None:
            words = "balls" if body == "balls" else f"{body} raceway"
            left.append(Omission(f"Roughness of the {words}", "the scene gives no surface"))
    if not scene.has_faults:
        left.append(Omission("Faults", "the scene has none"))
    if scene.plate is None:
        left.append(Omission("A housing and its sound", "the scene gives no plate"))
    return left
