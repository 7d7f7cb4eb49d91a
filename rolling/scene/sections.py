"""Sections of a scene: frozen models, units in the key names, and checks of single sections.

Lengths are in mm or um and moduli in GPa here; the properties of `Scene` are SI. Sections are built
in Python as `Sphere(radius_mm=5)`; a value that is not allowed then raises SceneError with the same
message as in a scene file.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    WithJsonSchema,
    model_validator,
)

from rolling.scene.messages import (
    Words,
    fault,
    is_number,
    plain_number,
    shown,
)
from rolling.scene.section import Section

STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]


# ---- sphere and plate


class Sphere(Section):
    """Rolling sphere, rigid unless it has a modulus."""

    SECTION: ClassVar[str] = "sphere"

    radius_mm: float = Field(gt=0, description="Radius [mm]")
    density_kg_m3: float | None = Field(
        default=None,
        gt=0,
        description="Density [kg/m3], for the mass; dynamics needs it. Absent: the check of the"
        " contact resonance takes 7850, as if steel",
    )
    youngs_modulus_gpa: float | None = Field(
        default=None, gt=0, description="Young's modulus [GPa]; absent: a rigid sphere"
    )
    poissons_ratio: float | None = Field(
        default=None, ge=0, le=0.5, description="Poisson's ratio [-]; absent: a rigid sphere"
    )

    @model_validator(mode="after")
    def _both_or_neither(self) -> Sphere:
        for missing, given in (
            ("youngs_modulus_gpa", "poissons_ratio"),
            ("poissons_ratio", "youngs_modulus_gpa"),
        ):
            if getattr(self, missing) is None and getattr(self, given) is not None:
                raise fault(
                    f"missing beside {given}; an elastic sphere needs both, a rigid sphere neither",
                    "sphere",
                    missing,
                )
        return self


class Plate(Section):
    """Plate that the sphere rolls on, a half-space to the contact."""

    SECTION: ClassVar[str] = "plate"

    youngs_modulus_gpa: float = Field(gt=0, description="Young's modulus [GPa]")
    poissons_ratio: float = Field(ge=0, le=0.5, description="Poisson's ratio [-]")
    hardness_gpa: float | None = Field(
        default=None,
        gt=0,
        description="Hardness [GPa], the maximum pressure that the plate bears; absent: purely"
        " elastic",
    )
    density_kg_m3: float | None = Field(
        default=None, gt=0, description="Density [kg/m3]; dynamics needs it"
    )
    thickness_mm: float | None = Field(
        default=None,
        gt=0,
        description="Thickness [mm] of an infinite plate that bends, for dynamics; absent: a"
        " half-space",
    )
    loss_factor: float | None = Field(
        default=None,
        gt=0,
        le=1,
        description="Loss factor of bending waves [-], for the sound power above coincidence;"
        " absent: no sound power there",
    )

    @model_validator(mode="after")
    def _loss_of_bending(self) -> Plate:
        if self.loss_factor is not None and self.thickness_mm is None:
            raise fault(
                "only goes with thickness_mm: a half-space has no bending waves",
                "plate",
                "loss_factor",
            )
        return self


# ---- rolling, numerics, recovery, sound


SPEED = Words("a number > 0, or at least two [time_s, speed_m_s] pairs")


def _speed(value: Any) -> Any:
    """Return a speed, or pairs as tuples.

    The first fault of the pairs is raised at its own place.
    """
    at = ("rolling", "speed_m_s")
    if is_number(value) and value > 0:
        return float(value)
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise fault(f"got {shown(value)}, allowed: {SPEED.allowed}", *at)
    for i, pair in enumerate(value):
        if (
            not isinstance(pair, list | tuple)
            or len(pair) != 2
            or not all(is_number(x) for x in pair)
        ):
            raise fault(f"got {shown(pair)}, allowed: [time_s, speed_m_s], two numbers", *at, i)
        if i == 0 and pair[0] != 0:
            raise fault(f"got {shown(pair[0])}, allowed: 0, the time of the first pair", *at, 0)
        if i and pair[0] <= value[i - 1][0]:
            raise fault(
                f"got time {shown(pair[0])} after {shown(value[i - 1][0])}, allowed: increasing"
                " times",
                *at,
                i,
            )
        if pair[1] < 0:
            raise fault(f"got speed {shown(pair[1])}, allowed: a number >= 0", *at, i)
    if not any(v > 0 for _, v in value):
        raise fault("got speeds that are all 0, allowed: at least one > 0", *at)
    return tuple((float(t), float(v)) for t, v in value)


def _step_nodes(value: float) -> float:
    """Return the allowed value nearest to a rounded value.

    0.333333 stands for a third, for example.
    """
    closest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / closest - 1) > 1e-5:
        raise fault(
            f"got {plain_number(value)}, allowed: a whole number from 1 to 64, or one over a whole"
            f" number down to 1/16; nearest: {plain_number(closest)}"
        )
    return closest


_PAIR_SCHEMA = {
    "type": "array",
    "prefixItems": [{"type": "number", "minimum": 0}] * 2,
    "minItems": 2,
    "maxItems": 2,
}
_PAIRS_SCHEMA = {"type": "array", "minItems": 2, "items": _PAIR_SCHEMA}
Speed = Annotated[
    float | tuple[tuple[float, float], ...],
    SPEED,
    BeforeValidator(_speed),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, _PAIRS_SCHEMA]}),
]


class Rolling(Section):
    """Load, speed and duration of the rolling."""

    SECTION: ClassVar[str] = "rolling"

    load_n: float = Field(gt=0, description="Normal load [N], constant")
    speed_m_s: Speed = Field(
        description="Speed [m/s], or [time [s], speed [m/s]] pairs: times increasing from 0,"
        " linear between them, constant after the last"
    )
    duration_s: float | None = Field(
        default=None,
        gt=0,
        description="Time rolled [s]; absent with distance_mm, and with a height file: once round"
        " the file",
    )
    distance_mm: float | None = Field(
        default=None,
        gt=0,
        description="Distance rolled [mm] instead of a duration, so that every speed meets the"
        " same surface",
    )
    start_um: float = Field(default=0.0, description="Start position along the track [um]")

    @model_validator(mode="after")
    def _one_length(self) -> Rolling:
        if self.duration_s is not None and self.distance_mm is not None:
            raise fault("given beside duration_s, allowed: one of them", "rolling", "distance_mm")
        return self


TOLERANCES = 1e-12, 1e-1  # allowed numbers
UNTRIED_TOLERANCE = 1e-4  # stands for `auto` until a trial has chosen a number
TOLERANCE = Words(f"auto, or a number >= {TOLERANCES[0]:g} and <= {TOLERANCES[1]:g}")


def _tolerance(value: Any) -> Any:
    """Return a tolerance that is allowed."""
    if (isinstance(value, str) and value == "auto") or (
        is_number(value) and TOLERANCES[0] <= value <= TOLERANCES[1]
    ):
        return value if isinstance(value, str) else float(value)
    raise fault(f"got {shown(value)}, allowed: {TOLERANCE.allowed}")


Tolerance = Annotated[
    float | Literal["auto"],
    TOLERANCE,
    BeforeValidator(_tolerance),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "const": "auto"},
                {"type": "number", "minimum": TOLERANCES[0], "maximum": TOLERANCES[1]},
            ]
        }
    ),
]


class Numerics(Section):
    """Resolution and accuracy of the solution."""

    SECTION: ClassVar[str] = "numerics"

    step_nodes: Annotated[float, AfterValidator(_step_nodes)] = Field(
        default=1.0,
        gt=0,
        description="Step in nodes [-]: a whole number from 1 to 64, or one over a whole number"
        " down to 1/16",
    )
    tolerance: Tolerance = Field(
        default="auto",
        description="Maximum violation of the contact conditions over the maximum deflection [-];"
        " auto chooses it by a trial on the track, so that the solver's error stays below the"
        " grid's",
    )
    edges: Literal["sharp", "blended"] = Field(
        default="blended",
        description="Nodes at the edge of yielding patches: sharp loads them in full or not at"
        " all, blended by the share of their cell in contact",
    )
    subcells: Literal["auto", 1, 2, 4] = Field(
        default="auto",
        description="Sub-cells along the side of each node's cell, with heights, pressures and"
        " bounds of their own; auto takes 2 on steep surfaces that yield with blended edges, else"
        " 1",
    )
    precision: Literal["single", "double"] = Field(
        default="single",
        description="Precision of the transforms in the iteration; a solution is accepted after a"
        " check in double precision",
    )
    error_estimate: bool = Field(
        default=False,
        description="Whether the run estimates the errors that its grid and its tolerance leave"
        " in every level, for about a quarter more time",
    )


class Recovery(Section):
    """Recovery of the nodes that leave the contact."""

    SECTION: ClassVar[str] = "recovery"

    events: bool = Field(default=False, description="Write a table of recovery events")
    rule: Literal["mean", "left_end"] = Field(
        default="mean",
        description="Pressure of a falling node: mean of both ends of the step, or left_end, the"
        " article's",
    )


def _odd(value: int) -> int:
    """Refuse an even number of loads."""
    if value % 2 == 0:
        raise fault(f"got {value}, allowed: {LOADS.allowed}")
    return value


LOADS = Words("an odd whole number from 3 to 15")


class Dynamics(Section):
    """Vibration of the sphere on its contact and on the plate, which makes the force fluctuate."""

    SECTION: ClassVar[str] = "dynamics"

    loads: Annotated[int, LOADS, AfterValidator(_odd)] = Field(
        default=3,
        ge=3,
        le=15,
        description="Minimum number of loads at which the track is marched [-], odd: the scene's"
        " in the middle",
    )
    span: float = Field(
        default=1.4, ge=1.05, le=4, description="Ratio of a marched load to the next lower one [-]"
    )
    release: bool | None = Field(
        default=None,
        description="Whether the release is computed under the moving load, by one more march of"
        " each run; otherwise under the constant load; absent: true for sound.source: release",
    )


class Sound(Section):
    """Source, listener, and conversion of release power to sound pressure."""

    SECTION: ClassVar[str] = "sound"

    source: Literal["release", "vibration"] | None = Field(
        default=None,
        description="Origin of the sound pressure: release of elastic energy (an upper bound), or"
        " vibration of sphere and plate, which needs dynamics and takes neither q nor gain; absent:"
        " vibration with dynamics, otherwise release",
    )
    ball: bool = Field(
        default=True, description="Whether the vibration of the sphere is heard beside the plate's"
    )

    distance_m: float = Field(default=1.0, gt=0, description="Distance of the listener [m]")
    q: float = Field(
        default=1.0, gt=0, le=1, description="Share of the released energy that is radiated [-]"
    )
    gain_pa_per_w_m2: float | None = Field(
        default=None,
        gt=0,
        description="Fixed factor from intensity to sound pressure [Pa per W/m2]; absent:"
        " energy-true per run",
    )
    loudness: bool = Field(
        default=False,
        description="Report loudness (ISO 532-1) and sharpness (DIN 45692); needs the package"
        " mosqito",
    )

    @model_validator(mode="after")
    def of_release_only(self) -> Sound:
        """Refuse free factors of a pressure that has none."""
        if self.source == "vibration":
            for key, given in (
                ("q", self.q != 1),
                ("gain_pa_per_w_m2", self.gain_pa_per_w_m2 is not None),
            ):
                if given:
                    raise fault(
                        f"got {plain_number(getattr(self, key))}, which only goes with source:"
                        " release; the pressure of the vibration has no free factor",
                        "sound",
                        key,
                    )
        return self
