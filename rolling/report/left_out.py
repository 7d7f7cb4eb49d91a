"""What a run of a ball left out because its scene did not need it, for its page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from acoustics.numbers import rounded
from rolling.results.run_result import Run

# What no run computes, whatever its scene.
NEVER = "oil, friction, adhesion, yielding below the surface, and the room"


@dataclass(frozen=True)
class Omission:
    """Something that a run did not compute.

    what : str. What is left out.
    reason : str. What in the scene or in the run says that it is not needed.
    """

    what: str
    reason: str

    @property
    def sentence(self) -> str:
        """The omission as a line of a list."""
        return f"{self.what}: {self.reason}."


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
