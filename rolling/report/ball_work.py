"""What more work would buy a run of a ball, by its own numbers, and what it left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from acoustics.numbers import rounded
from rolling.check import forecast, resolution
from rolling.kinds.page_parts import Part
from rolling.marches import effort
from rolling.numbers.quantity import Quantity
from rolling.report.work import (
    FINER,
    GRID,
    MORE_STEPS,
    RECORD,
    MoreWork,
    Omission,
    with_gain,
    words_of,
    work_part,
)
from rolling.results.run_result import Run
from rolling.scene.messages import SceneError
from rolling.sound.error_estimate import DEFAULT_ORDER

# Parts of the processor time that grow with the track.
ALONG_TRACK = (effort.MARCH, effort.LOAD_MARCHES, effort.MOVING_RELEASE)
# What no run of a ball computes, whatever its scene.
NEVER = "oil, friction, adhesion, yielding below the surface, or the room"


def work_of(runs: Sequence[Run]) -> Part:
    """Return the part of a page with both lists of each run."""
    return work_part(
        [run.label for run in runs],
        [more_work(run) for run in runs],
        [omissions(run) for run in runs],
        NEVER,
    )


# ---- what more work would buy


def more_work(run: Run) -> list[MoreWork]:
    """Return what ten times the steps and half the spacing would buy the number that leads.

    That is the vibration where it has a ±, and otherwise the released power.
    """
    quantity = leading(run)
    return [_more_steps(run, quantity), _finer_grid(run, quantity)]


def leading(run: Run) -> Quantity:
    """Return the number of a run whose ± is known: its vibration, or its released power."""
    for quantity in (run.numbers.vibration, run.numbers.released_power):
        if quantity.value is not None and quantity.uncertainty is not None:
            return quantity
    return run.numbers.vibration


def _more_steps(run: Run, quantity: Quantity) -> MoreWork:
    """Return the gain of a record that is ten times as long: its noise is independent."""
    seconds = _march_seconds(run)
    more = MoreWork(
        what="Ten times the steps",
        number=words_of(quantity),
        source=RECORD,
        seconds=seconds,
        new_seconds=None if seconds is None else MORE_STEPS * seconds,
    )
    if run.scene.is_one_event:
        return replace(more, reason="the record is one event")
    return with_gain(more, quantity, 1 / math.sqrt(MORE_STEPS))


def _finer_grid(run: Run, quantity: Quantity) -> MoreWork:
    """Return the gain of half the spacing: as measured, or by the rule that the doubt states."""
    seconds = _march_seconds(run)
    finer = MoreWork(
        what="Half the spacing",
        number=words_of(quantity),
        source=GRID,
        seconds=seconds,
        new_seconds=_finer_seconds(run, seconds),
    )
    order = run.numbers.errors.order
    doubt = next((doubt for doubt in quantity.doubts if doubt.key == resolution.LEVEL_KEY), None)
    if quantity.parts.get(GRID) or doubt is None:
        return with_gain(finer, quantity, FINER ** -(order or DEFAULT_ORDER))
    if not doubt.decibels:
        return replace(finer, reason=doubt.text)
    estimate_db = doubt.decibels
    return replace(finer, part_db=estimate_db, new_part_db=estimate_db * FINER**-DEFAULT_ORDER)


def _march_seconds(run: Run) -> float | None:
    """Return the measured processor time [s] of all marches along the track; None if unknown.

    It is unknown where the march was done for another run.
    """
    if not run.numbers.effort.march_cpu_s:
        return None
    parts = run.numbers.effort.parts_cpu_s or {}
    return sum(parts.get(part) or 0.0 for part in ALONG_TRACK)


def _finer_seconds(run: Run, seconds: float | None) -> float | None:
    """Return the measured time times the ratio of the forecasts of both grids."""
    scene = run.scene
    if seconds is None or scene.height_paths:  # the grid of a file is that of its points
        return None
    try:
        finer = scene.with_({"surface.spacing_um": 1e6 * scene.spacing / FINER})
        return seconds * forecast.march_seconds(finer) / forecast.march_seconds(scene)
    except SceneError:
        return None


# ---- what a run left out


def omissions(run: Run) -> list[Omission]:
    """List what a run left out, with the fact of its scene or the number of the run behind it."""
    return [*_of_motion(run), *_of_bodies(run), *_of_contact(run), *_of_grid(run)]


def _of_motion(run: Run) -> Iterator[Omission]:
    """Yield what the motion of ball and plate leaves out."""
    scene = run.scene
    motion = run.numbers.motion
    if motion is None:
        yield Omission(
            "Masses and motion",
            "the scene has no dynamics, so the load is held and the vibration is estimated",
        )
        return
    if scene.plate.thickness_mm is None:
        yield Omission("Bending of the plate", "the scene gives no thickness")
    elif scene.plate.edges_mm is None:
        yield Omission("Modes of the plate", "the scene gives no length and width")
    elif motion.plate_modes is not None:
        yield Omission("Modes of the plate above 30 kHz", f"{motion.plate_modes} lie below")
    if scene.keeps_its_load and not scene.moves_release:
        yield Omission("The release under the moving load", "the vibration is what plays")


def _of_bodies(run: Run) -> Iterator[Omission]:
    """Yield what ball and plate do not have."""
    scene = run.scene
    if scene.sphere.surface is None:
        yield Omission("Roughness and form of the ball", "the scene gives the ball no surface")
    if not scene.sphere.youngs_modulus_gpa:
        yield Omission("Elasticity of the ball", "the scene gives the plate alone a modulus")
    if math.isinf(scene.hardness):
        yield Omission("Yielding", "the scene gives no hardness, so the plate is elastic")
    elif not run.numbers.contact.plastic_ratio:
        yield Omission("Yielding", "no pressure reached the hardness")
    elif not scene.is_permanent:
        yield Omission(
            "Marks that the ball leaves", "the scene does not ask for plate.plasticity: permanent"
        )


def _of_contact(run: Run) -> Iterator[Omission]:
    """Yield what the solver does not compute."""
    scene = run.scene
    contact = run.numbers.contact
    nodes = scene.track.n_along * scene.track.n_across
    touching = contact.area_mean_m2 / scene.spacing**2
    yield Omission(
        "Nodes away from the contact",
        f"of {nodes:,} nodes of the surface about {touching:.0f} touch, and each step solves "
        "a window around them",
    )
    if math.isinf(scene.hardness) or not contact.plastic_ratio:
        yield Omission("Cells that touch in part", "no pressure is at the hardness at their edges")
    elif scene.numerics.edges == "sharp":
        yield Omission("Cells that touch in part", "the scene asks for sharp edges")
    if scene.numerics.precision == "single":
        residual = rounded(run.numbers.effort.residual_max)
        yield Omission(
            "Iterations in double precision",
            f"each solution is checked in double, to a residual of {residual} at most",
        )


def _of_grid(run: Run) -> Iterator[Omission]:
    """Yield what lies between the steps, and between the nodes."""
    scene = run.scene
    effort = run.numbers.effort
    if effort.step_nodes > 1:
        highest_khz = rounded(run.numbers.record.highest_frequency_hz / 1e3)
        yield Omission(
            "Positions between the steps",
            f"steps of {effort.step_nodes:g} nodes hold the sound up to {highest_khz} kHz",
        )
    if not scene.numerics.error_estimate:
        yield Omission("An error estimate", "the scene does not ask for numerics.error_estimate")
