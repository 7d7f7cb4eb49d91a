"""A kind of scene that the program does not know: a ball that rolls between two plates.

The upper plate rests on the ball and rises with the ball's diameter. A ball with an even number of
waves around it lifts the plate by twice their amplitude; one with an odd number has the same
diameter everywhere (a curve of constant width), and the plate stays at rest.
"""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from pydantic import Field

import rolling
from acoustics import resampling, wav
from rolling.archive.definition import Variable
from rolling.numbers.fields import group
from rolling.numbers.quantity import Quantity
from rolling.plain_kind.plain_kind import PlainKind
from rolling.plain_kind.plain_run import PlainNumbers, RunSound, Solved
from rolling.scene.models import Section
from rolling.scene.swept import PlainScene

STEPS = 400  # of a turn of the ball
NODES = 16  # of a step
AIR = 413.0  # N s/m3, characteristic impedance


class Plates(Section):
    """Ball and plates, and how the ball rolls.

    Attributes
    ----------
    radius_mm : float
        Radius of the ball [mm]
    waves : int
        Waves around the ball
    amplitude_um : float
        Their amplitude [um]
    load_n : float
        Load of the upper plate [N]
    speed_m_s : float
        Speed of the centre of the ball [m/s]
    turns : int
        Turns of the ball
    """

    SECTION: ClassVar[str] = "plates"

    radius_mm: float = Field(gt=0)
    waves: int = Field(ge=2)
    amplitude_um: float = Field(gt=0)
    load_n: float = Field(gt=0)
    speed_m_s: float = Field(gt=0)
    turns: int = Field(default=2, ge=1)


class BetweenPlates(PlainScene):
    """Scene of a ball between two plates."""

    SECTION: ClassVar[str] = "plates"
    TITLE: ClassVar[str] = "Scene of a ball between two plates"

    plates: Plates

    @property
    def turn_m(self) -> float:
        """Circumference of the ball."""
        return 2e-3 * math.pi * self.plates.radius_mm

    @property
    def tone_hz(self) -> float:
        """Waves that pass a contact in a second."""
        return self.plates.waves * self.plates.speed_m_s / self.turn_m


@dataclass(frozen=True, kw_only=True)
class PlateNumbers(PlainNumbers):
    """Numbers of a ball between two plates."""

    approach: Quantity = group("mean approach of the plates", word="approach")
    velocity: Quantity = group("rms velocity of the upper plate", word="velocity of the plate")


class BallBetweenPlates(PlainKind):
    """A ball that rolls between two plates."""

    name = "ball-between-plates"
    scene_type = BetweenPlates
    description = "A ball between two plates: its waves, the load and the speed."
    numbers_type = PlateNumbers
    variables = (
        Variable("time", "time", "s", "f8", "time"),
        Variable("height", "time", "m", "f8", "height of the upper plate over its mean"),
    )

    def marches(self, scene: BetweenPlates, film: bool = False) -> list[rolling.March]:
        """Return the march of the lower contact; the upper one sees the ball half a turn later."""
        plates = scene.plates
        spacing_um = 1e6 * scene.turn_m / (STEPS * NODES)
        waves = {"kind": "smooth", "waviness": {plates.waves: plates.amplitude_um}}
        contact = rolling.Scene.from_dict(
            {
                "name": "lower",
                "sphere": {"radius_mm": plates.radius_mm, "material": "steel-100cr6"}
                | {"surface": waves},
                "plate": {"material": "steel-100cr6", "hardness_gpa": "none"},
                "surface": {"kind": "smooth", "spacing_um": spacing_um}
                | {"width_um": 40 * spacing_um},
                "rolling": {"load_n": plates.load_n, "speed_m_s": plates.speed_m_s}
                | {"distance_mm": 1e3 * scene.turn_m},
                "numerics": {"step_nodes": NODES},
            }
        )
        return [rolling.March(contact, name=f"contact at {plates.load_n:g} N")]

    def solve(self, scene: BetweenPlates, marched: Any) -> Solved:
        """Add both contacts; a load that does not change lets the plate follow them."""
        (lower,) = marched
        both = lower.approach_m + np.roll(lower.approach_m, STEPS // 2)
        turn_s = scene.turn_m / scene.plates.speed_m_s
        height = np.tile(both.mean() - both, scene.plates.turns)
        rate_hz = STEPS / turn_s
        velocity = 0.5 * rate_hz * (np.roll(height, -1) - np.roll(height, 1))
        samples = round(scene.plates.turns * turn_s * wav.SAMPLE_RATE_HZ)
        heard = resampling.resample_closed(velocity, samples)
        rms = 1e6 * float(np.sqrt(np.mean(np.square(velocity))))
        speed = Quantity("velocity", rms, unit="um/s")
        return Solved(
            numbers=PlateNumbers(
                sentences=(f"The upper plate moves at {speed}.",),
                approach=Quantity("approach", 1e6 * float(both.mean()), unit="um"),
                velocity=speed,
            ),
            arrays={"time": np.arange(len(height)) / rate_hz, "height": height},
            sound=RunSound(AIR * heard, "Pa", "plane wave above the upper plate"),
        )


KIND = BallBetweenPlates()
