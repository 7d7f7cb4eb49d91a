"""Sections of a scene: frozen models, units in the key names, and checks of single sections.

Lengths are in mm or um and moduli in GPa here; the properties of `Scene` are SI. Sections are built
in Python as `Sphere(radius_mm=5)`; a value that is not allowed then raises SceneError with the same
message as in a scene file.
"""

from __future__ import annotations

import math
from itertools import chain
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    WithJsonSchema,
    model_validator,
)

from acoustics.numbers import rounded
from rolling.scene.balls import BallSurface
from rolling.scene.messages import MATERIALS, fault, is_number, plain_number, shown
from rolling.scene.motion import Motion
from rolling.scene.section import Section

YOUNG, HARDNESS = MATERIALS["youngs_modulus_gpa"], MATERIALS["hardness_gpa"]
DENSITY = MATERIALS["density_kg_m3"]
HARDEST = 5  # Young's modulus over hardness is above 5 in every material, and about 8 in diamond

# ---- sphere and plate


class Sphere(Section):
    """Rolling sphere, rigid unless it has a modulus.

    Attributes
    ----------
    radius_mm : float
        Radius [mm]
    density_kg_m3 : float, optional
        Density [kg/m3], for the mass; dynamics needs it. Absent: the check of the contact
        resonance takes 7850, as if steel
    youngs_modulus_gpa : float, optional
        Young's modulus [GPa]; absent: a rigid sphere
    poissons_ratio : float, optional
        Poisson's ratio [-]; absent: a rigid sphere
    surface : section, optional
        Surface of the sphere, wrapped around its circumference; absent: perfectly smooth
    """

    radius_mm: float = Field(gt=0)
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    youngs_modulus_gpa: float | None = Field(default=None, ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float | None = Field(default=None, ge=0, le=0.5)
    surface: BallSurface | None = Field(default=None, discriminator="kind")

    @model_validator(mode="after")
    def _both_or_neither(self) -> Sphere:
        for missing, given in (
            ("youngs_modulus_gpa", "poissons_ratio"),
            ("poissons_ratio", "youngs_modulus_gpa"),
        ):
            if getattr(self, missing) is None and getattr(self, given) is not None:
                rule = "an elastic sphere needs both, a rigid sphere neither"
                raise fault(f"missing beside {given}; {rule}", "sphere", missing)
        return self


def _point(value: Any) -> Any:
    """Return a point on the plate as a tuple."""
    if isinstance(value, list | tuple) and len(value) == 2 and all(is_number(x) for x in value):
        return float(value[0]), float(value[1])
    raise fault(f"got {shown(value)}, allowed: [x, y], two numbers in mm from a corner")


_NUMBERS = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
Point = Annotated[tuple[float, float], BeforeValidator(_point), WithJsonSchema(_NUMBERS)]
# Keys of the plate that change its vibration, and not the march of the contact.
VIBRATING_PLATE = (
    "density_kg_m3",
    "thickness_mm",
    "loss_factor",
    "length_mm",
    "width_mm",
    "contact_mm",
    "contact_path",
    "contact_end_mm",
    "contact_loss_factor",
)
CONTACT_AT = 0.43, 0.37  # default over length and width: many modes have nodal lines in the middle


class Plate(Section):
    """Plate that the sphere rolls on, a half-space to the contact.

    Attributes
    ----------
    youngs_modulus_gpa : float
        Young's modulus [GPa]
    poissons_ratio : float
        Poisson's ratio [-]
    hardness_gpa : float, optional
        Hardness [GPa], the maximum pressure that the plate bears, below a fifth of its modulus;
        absent: purely elastic
    density_kg_m3 : float, optional
        Density [kg/m3]; dynamics needs it
    thickness_mm : float, optional
        Thickness [mm] of an infinite plate that bends, for dynamics; absent: a half-space
    loss_factor : float, optional
        Loss factor of bending waves [-], for the sound power above coincidence; absent: no sound
        power there; a plate with edges needs it
    length_mm : float, optional
        Length [mm] along x of a rectangular plate, simply supported at its edges; absent: an
        infinite plate
    width_mm : float, optional
        Width [mm] along y of a rectangular plate
    contact_mm : pair of float, optional
        Contact point [x, y] [mm] from a corner of a rectangular plate; absent: 0.43 of the length,
        0.37 of the width
    contact_path : str, optional
        Path of the contact on a rectangular plate: fixed at contact_mm, or to-and-fro between
        contact_mm and contact_end_mm at the speed of the sphere; absent: fixed
    contact_end_mm : pair of float, optional
        Other end [x, y] [mm] of a path to-and-fro
    contact_loss_factor : float, optional
        Loss factor of the contact stiffness [-] at the contact resonance; absent: 0
    """

    youngs_modulus_gpa: float = Field(ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float = Field(ge=0, le=0.5)
    hardness_gpa: float | None = Field(default=None, ge=HARDNESS.least, le=HARDNESS.most)
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    thickness_mm: float | None = Field(default=None, gt=0)
    loss_factor: float | None = Field(default=None, gt=0, le=1)
    length_mm: float | None = Field(default=None, gt=0)
    width_mm: float | None = Field(default=None, gt=0)
    contact_mm: Point | None = None
    contact_path: Literal["fixed", "to-and-fro"] | None = None
    contact_end_mm: Point | None = None
    contact_loss_factor: float | None = Field(default=None, ge=0, le=1)

    @property
    def edges_mm(self) -> tuple[float, float] | None:
        """Length and width [mm] of a rectangular plate; None for an infinite one."""
        both = self.length_mm, self.width_mm
        return None if both[0] is None or both[1] is None else (both[0], both[1])

    @property
    def contact_ends_mm(self) -> dict[str, tuple[float, float]]:
        """Contact point, and the other end of its path if it moves, [x, y] [mm] by key."""
        if self.edges_mm is None:
            return {}
        default = CONTACT_AT[0] * self.edges_mm[0], CONTACT_AT[1] * self.edges_mm[1]
        ends = {"contact_mm": self.contact_mm or default, "contact_end_mm": self.contact_end_mm}
        return {key: point for key, point in ends.items() if point is not None}

    @model_validator(mode="after")
    def _softer_than_bonds(self) -> Plate:
        most = self.youngs_modulus_gpa / HARDEST
        if self.hardness_gpa is not None and self.hardness_gpa >= most:
            words = (
                f"got {plain_number(self.hardness_gpa)}, allowed: below a fifth of"
                f" youngs_modulus_gpa, {rounded(most, 4)}; without a hardness the plate is purely"
                " elastic"
            )
            raise fault(words, "plate", "hardness_gpa")
        return self

    @model_validator(mode="after")
    def _loss_of_bending(self) -> Plate:
        if self.loss_factor is not None and self.thickness_mm is None:
            reason = "a half-space has no bending waves"
            raise fault(f"only goes with thickness_mm: {reason}", "plate", "loss_factor")
        return self

    @model_validator(mode="after")
    def _all_edges(self) -> Plate:
        """Refuse half a rectangle, and keys of a contact point without edges."""
        if self.edges_mm is None:
            for missing, given in (("length_mm", "width_mm"), ("width_mm", "length_mm")):
                if getattr(self, given) is not None:
                    rule = "a plate with edges needs both, an infinite plate neither"
                    raise fault(f"missing beside {given}; {rule}", "plate", missing)
            for key in ("contact_mm", "contact_path", "contact_end_mm"):
                if getattr(self, key) is not None:
                    rule = "a point on an infinite plate is like any other"
                    raise fault(f"only goes with length_mm and width_mm: {rule}", "plate", key)
            return self
        for key, part in (("thickness_mm", "bends"), ("loss_factor", "has modes, which decay")):
            if getattr(self, key) is None:
                raise fault(f"missing; a plate with edges {part}", "plate", key)
        return self

    @model_validator(mode="after")
    def _contact_on_the_plate(self) -> Plate:
        """Refuse contact points beyond the edges, and a path without two ends."""
        if self.edges_mm is None:
            return self
        for key, point in self.contact_ends_mm.items():
            for name, place, edge in zip("xy", point, self.edges_mm, strict=True):
                if not 0 < place < edge:
                    within = f"a point within the edges, {name} above 0 and below"
                    words = f"got {shown(list(point))}, allowed: {within} {plain_number(edge)}"
                    raise fault(words, "plate", key)
        moves = self.contact_path == "to-and-fro"
        if moves and self.contact_end_mm is None:
            raise fault("missing; contact_path: to-and-fro needs it", "plate", "contact_end_mm")
        if not moves and self.contact_end_mm is not None:
            words = "only goes with contact_path: to-and-fro"
            raise fault(words, "plate", "contact_end_mm")
        if moves and self.contact_end_mm == self.contact_ends_mm["contact_mm"]:
            got = shown(list(self.contact_end_mm))
            words = f"got {got}, the point contact_mm, allowed: another point"
            raise fault(words, "plate", "contact_end_mm")
        return self


# ---- rolling


WEIGHT: Literal["weight"] = "weight"
SPEED = "a number > 0, or at least two [time_s, speed_m_s] pairs"


def _speed(value: Any) -> Any:
    """Return a speed, or pairs as tuples."""
    if is_number(value) and value > 0:
        return float(value)
    pairs = value if isinstance(value, list | tuple) else []
    lists = [pair for pair in pairs if isinstance(pair, list | tuple) and len(pair) == 2]
    if len(pairs) < 2 or len(lists) < len(pairs) or not all(is_number(x) for x in chain(*lists)):
        raise fault(f"got {shown(value)}, allowed: {SPEED}", "rolling", "speed_m_s")
    try:
        Motion.of(pairs)
    except ValueError as error:
        raise fault(f"got {shown(value)}: {error}", "rolling", "speed_m_s") from error
    return tuple((float(t), float(v)) for t, v in pairs)


_PAIR = {"type": "array", "minItems": 2, "maxItems": 2}
_PAIR |= {"prefixItems": [{"type": "number", "minimum": 0}] * 2}
_SPEEDS = [
    {"type": "number", "exclusiveMinimum": 0},
    {"type": "array", "minItems": 2, "items": _PAIR},
]
Speed = Annotated[
    float | tuple[tuple[float, float], ...],
    *(BeforeValidator(_speed), WithJsonSchema({"anyOf": _SPEEDS})),
]


LOAD = f"greater than 0, or {WEIGHT}"


def _load(value: Any) -> Any:
    """Return a load [N], or the word for the weight of the sphere."""
    if value == WEIGHT:
        return value
    if is_number(value) and value > 0:
        return float(value)
    raise fault(f"got {shown(value)}, allowed: {LOAD}", "rolling", "load_n")


_LOADS = [{"type": "string", "const": WEIGHT}, {"type": "number", "exclusiveMinimum": 0}]
Load = Annotated[
    float | Literal["weight"], *(BeforeValidator(_load), WithJsonSchema({"anyOf": _LOADS}))
]


class Rolling(Section):
    """Load, speed and duration of the rolling.

    Attributes
    ----------
    load_n : float or "weight"
        Normal load [N], constant; weight or absent: the weight of the sphere, which needs
        sphere.density_kg_m3
    speed_m_s : float or pairs of float
        Speed [m/s], or [time [s], speed [m/s]] pairs: times increasing from 0, linear between
        them, constant after the last
    resistance : float, optional
        Coefficient of rolling resistance c [-] of a free solid sphere, which starts at the speed
        and rolls out by 5/7 c load/mass; absent: the speed is kept
    drop_mm : float, optional
        Height [mm] above the surface from which the sphere is let go at the start, while it moves
        at the speed; needs dynamics and the sound of the vibration; absent: it rolls from the start
    duration_s : float, optional
        Time rolled [s]; absent with distance_mm, with resistance: until the sphere rests, and with
        a height file: once round the file
    distance_mm : float, optional
        Distance rolled [mm] instead of a duration, so that every speed meets the same surface
    start_um : float
        Start position along the track [um]
    """

    load_n: Load = WEIGHT
    speed_m_s: Speed
    resistance: float | None = Field(default=None, ge=0, le=1)
    drop_mm: float | None = Field(default=None, gt=0)
    duration_s: float | None = Field(default=None, gt=0)
    distance_mm: float | None = Field(default=None, gt=0)
    start_um: float = 0.0

    @model_validator(mode="after")
    def _one_length(self) -> Rolling:
        if self.duration_s is not None and self.distance_mm is not None:
            raise fault("given beside duration_s, allowed: one of them", "rolling", "distance_mm")
        return self

    @model_validator(mode="after")
    def _rolls_out(self) -> Rolling:
        if self.resistance is not None and isinstance(self.speed_m_s, tuple):
            words = "only goes with one speed_m_s, at which the sphere starts, not with pairs"
            raise fault(words, "rolling", "resistance")
        return self


# ---- numerics


STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]
TOLERANCES = 1e-12, 1e-1  # allowed numbers
TOLERANCE = f"auto, or a number >= {rounded(TOLERANCES[0])} and <= {rounded(TOLERANCES[1])}"


def _step_nodes(value: float) -> float:
    """Return the allowed value that a rounded value stands for, such as a third for 0.333333."""
    closest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / closest - 1) > 1e-5:
        words = "a whole number from 1 to 64, or one over a whole number down to 1/16"
        near = plain_number(closest)
        raise fault(f"got {plain_number(value)}, allowed: {words}; nearest: {near}")
    return closest


def _tolerance(value: Any) -> Any:
    """Return a tolerance that is allowed."""
    if isinstance(value, str) and value == "auto":
        return value
    if is_number(value) and TOLERANCES[0] <= value <= TOLERANCES[1]:
        return float(value)
    raise fault(f"got {shown(value)}, allowed: {TOLERANCE}")


_TOLERANCES = [
    {"type": "string", "const": "auto"},
    {"type": "number", "minimum": TOLERANCES[0], "maximum": TOLERANCES[1]},
]
Tolerance = Annotated[
    float | Literal["auto"],
    *(BeforeValidator(_tolerance), WithJsonSchema({"anyOf": _TOLERANCES})),
]


class Numerics(Section):
    """Resolution and accuracy of the solution.

    Attributes
    ----------
    step_nodes : float
        Step in nodes [-]: a whole number from 1 to 64, or one over a whole number down to 1/16
    tolerance : float or "auto"
        Maximum violation of the contact conditions over the maximum deflection [-]; auto takes
        1e-4, and less on a surface that is smooth for the deflection of the contact
    edges : str
        Nodes at the edge of yielding patches: sharp loads them in full or not at all, blended by
        the share of their cell in contact
    subcells : int or "auto"
        Sub-cells along the side of each node's cell, with heights, pressures and bounds of their
        own; auto takes 2 on steep surfaces that yield with blended edges, else 1
    precision : str
        Precision of the transforms in the iteration; a solution is accepted after a check in
        double precision
    error_estimate : bool
        Whether the run estimates the errors that its grid and its tolerance leave in every level,
        for a quarter more time, and 40 % under an exponential law
    """

    step_nodes: Annotated[float, AfterValidator(_step_nodes)] = Field(default=1.0, gt=0)
    tolerance: Tolerance = "auto"
    edges: Literal["sharp", "blended"] = "blended"
    subcells: Literal["auto", 1, 2, 4] = "auto"
    precision: Literal["single", "double"] = "single"
    error_estimate: bool = False


# ---- recovery, dynamics, sound


class Recovery(Section):
    """Recovery of the nodes that leave the contact.

    Attributes
    ----------
    events : bool
        Write a table of recovery events
    rule : str
        Pressure of a falling node: mean of both ends of the step, or left_end, the article's
    """

    events: bool = False
    rule: Literal["mean", "left_end"] = "mean"


def _odd(value: int) -> int:
    """Refuse an even number of loads."""
    if value % 2 == 0:
        raise fault(f"got {value}, allowed: an odd whole number from 3 to 15")
    return value


class Dynamics(Section):
    """Vibration of the sphere on its contact and on the plate, which makes the force fluctuate.

    Attributes
    ----------
    loads : int
        Minimum number of loads at which the track is marched [-], odd: the scene's in the middle
    span : float
        Ratio of a marched load to the next lower one [-]
    release : bool, optional
        Whether the release is computed under the moving load, by one more march of each run;
        otherwise under the constant load; absent: true for sound.source: release
    """

    loads: Annotated[int, AfterValidator(_odd)] = Field(default=3, ge=3, le=15)
    span: float = Field(default=1.4, ge=1.05, le=4)
    release: bool | None = None


MOST_LISTENERS = 16
_PLACES = f"[x, y, z], three numbers in mm, or a list of 1 to {MOST_LISTENERS} such places"


def _listeners(value: Any) -> Any:
    """Return listeners as tuples."""
    if isinstance(value, list | tuple) and len(value) == 3 and all(is_number(x) for x in value):
        value = [value]
    places = value if isinstance(value, list | tuple) else []
    valid = [
        tuple(map(float, place))
        for place in places
        if isinstance(place, list | tuple) and len(place) == 3 and all(is_number(x) for x in place)
    ]
    if not 0 < len(places) == len(valid) <= MOST_LISTENERS:
        got = f"{len(valid)} places" if len(valid) > MOST_LISTENERS else shown(value)
        raise fault(f"got {got}, allowed: {_PLACES}")
    if any(place[2] == 0 for place in valid):
        raise fault(f"got {shown(value)}, allowed: z above 0, on the ball's side, or below 0")
    return tuple(valid)


_PLACE = _NUMBERS | {"minItems": 3, "maxItems": 3}
_PLACE_LIST = {"type": "array", "minItems": 1, "maxItems": MOST_LISTENERS, "items": _PLACE}
Listeners = Annotated[
    tuple[tuple[float, float, float], ...],
    *(BeforeValidator(_listeners), WithJsonSchema({"anyOf": [_PLACE, _PLACE_LIST]})),
]


class Sound(Section):
    """Source, listener, and conversion of release power to sound pressure.

    Attributes
    ----------
    source : str, optional
        Origin of the sound pressure: release of elastic energy (an upper bound), or vibration of
        sphere and plate, which needs dynamics and takes neither q nor gain; absent: vibration with
        dynamics, otherwise release
    ball : bool
        Whether the vibration of the sphere is heard beside the plate's
    distance_m : float
        Distance of the listener [m], more than the radius of the sphere; beside listener_mm it is
        the radius of the half sphere of the mean level
    listener_mm : three floats, or a list of them, optional
        Listeners [x, y, z] [mm] of a plate with edges, from the corner of contact_mm, z above the
        plate on the ball's side; the first has the main levels, two make the WAVs stereo; absent:
        above the contact, or the middle of its path, at distance_m
    q : float
        Share of the released energy that is radiated [-]
    gain_pa_per_w_m2 : float, optional
        Fixed factor from intensity to sound pressure [Pa per W/m2]; absent: energy-true per run
    listen_s : float, optional
        Length of listen.wav [s], for which the sphere rolls on beyond the solved track, over a
        random continuation of it; absent: laps of the record, at least 5 s
    loudness : bool
        Report loudness (ISO 532-1) and sharpness (DIN 45692); needs the package mosqito
    """

    source: Literal["release", "vibration"] | None = None
    ball: bool = True
    distance_m: float = Field(default=1.0, gt=0)
    listener_mm: Listeners | None = None
    q: float = Field(default=1.0, gt=0, le=1)
    gain_pa_per_w_m2: float | None = Field(default=None, gt=0)
    listen_s: float | None = Field(default=None, ge=0.1, le=120)
    loudness: bool = False

    @model_validator(mode="after")
    def _with_free_factors(self) -> Sound:
        refuse_free_factors(self)
        return self


def refuse_free_factors(sound: Sound) -> None:
    """Refuse the free factors of the release for a vibration, whose pressure has none."""
    for key, default in (("q", 1), ("gain_pa_per_w_m2", None)):
        value = getattr(sound, key)
        if sound.source == "vibration" and value != default:
            rule = "the pressure of the vibration has no free factor"
            words = f"got {plain_number(value)}, which only goes with source: release; {rule}"
            raise fault(words, "sound", key)
