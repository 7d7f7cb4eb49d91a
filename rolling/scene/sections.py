"""Sphere, plate, rolling, numerics, recovery, dynamics and sound: the sections but the surfaces.

Units stand in the names of keys: lengths are in mm or um and moduli in GPa. The properties of
`Scene` are SI.
"""

from __future__ import annotations

import math
from difflib import get_close_matches
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, NoReturn, Self

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from acoustics.bands import (
    BAND_NAMES,
    MAX_ROOM_DB,
    MIN_ROOM_DB,
    nearest_nominal,
)
from acoustics.loss_factors import LossFactor
from acoustics.numbers import rounded
from rolling.contact.track import Motion
from rolling.scene import library, messages
from rolling.scene.messages import MATERIALS, is_number, mistake, numbers, plain_number, quoted
from rolling.scene.models import Section
from rolling.scene.surfaces import BallSurface
from rolling.scene.transducers import MAX_CHANNELS, SoundChannel, refuse_equal_names

# ---- numbers that a word may stand for


def number_or(
    word: str, allowed: str, sizes: messages.Plausible | None = None, **limits: float
) -> tuple[BeforeValidator, WithJsonSchema]:
    """Return validator and schema of a word, or of a number within limits of JSON Schema."""
    if sizes is not None:
        limits = {"minimum": sizes.least, "maximum": sizes.most}
    above = limits.get("exclusiveMinimum", -math.inf)
    least = limits.get("minimum", -math.inf)
    most = limits.get("maximum", math.inf)

    def word_or_number(value: Any) -> Any:
        if isinstance(value, str) and value == word:
            return value
        if is_number(value) and value > above and least <= value <= most:
            return float(value)
        if is_number(value) and sizes is not None:
            raise mistake(messages.implausible(value, sizes))
        raise mistake(f"got {quoted(value)}, allowed: {allowed}")

    kinds = [{"type": "number", **limits}, {"type": "string", "const": word}]
    return BeforeValidator(word_or_number), WithJsonSchema({"anyOf": kinds})


# ---- sphere


YOUNG = MATERIALS["youngs_modulus_gpa"]
HARDNESS = MATERIALS["hardness_gpa"]
DENSITY = MATERIALS["density_kg_m3"]
Material = Annotated[str, library.listed("materials")]
MAX_OBLONG = 1e6  # one radius over the other
HARDEST = 5  # Young's modulus over hardness is above 5 in every material, and about 8 in diamond


def _refuse_half(section: Section, keys: tuple[str, str], rule: str) -> None:
    """Refuse one key of a pair without the other."""
    for missing, given in (keys, keys[::-1]):
        if getattr(section, missing) is None and getattr(section, given) is not None:
            raise mistake(f"missing beside {given}; {rule}", at=f".{missing}")


class Sphere(Section):
    """Rolling sphere, rigid unless it has a modulus.

    Attributes
    ----------
    radius_mm : float
        Radius along the track [mm]. Mass, circumference and sound follow from it.
    radius_across_mm : float, optional
        Radius across the track [mm], for a wheel or a crowned roller. Default: radius_mm.
    material : str, optional
        Material by name. It gives Young's modulus, Poisson's ratio and density; values beside it
        win.
    density_kg_m3 : float, optional
        Density [kg/m3]. Dynamics needs it; checks without it take 7850.
    youngs_modulus_gpa : float, optional
        Young's modulus [GPa]. Default: a rigid sphere.
    poissons_ratio : float, optional
        Poisson's ratio [-]. Default: a rigid sphere.
    surface : section, optional
        Surface around the circumference. Default: smooth.

    Examples
    --------
    >>> import rolling
    >>> rolling.Sphere(radius_mm=5, material="steel-100cr6").density_kg_m3
    7810.0
    """

    NAMED: ClassVar[str] = "sphere"

    radius_mm: float = Field(gt=0)
    radius_across_mm: float | None = Field(default=None, gt=0)
    material: Material | None = None
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    youngs_modulus_gpa: float | None = Field(default=None, ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float | None = Field(default=None, ge=0, le=0.5)
    surface: BallSurface | None = Field(default=None, discriminator="kind")

    @model_validator(mode="after")
    def _check_bodies(self) -> Self:
        """Refuse radii that are too different, and half of the constants of elasticity."""
        if self.radius_across_mm is not None:
            ratio = self.radius_across_mm / self.radius_mm
            if not 1 / MAX_OBLONG <= ratio <= MAX_OBLONG:
                least = plain_number(self.radius_mm / MAX_OBLONG)
                most = plain_number(self.radius_mm * MAX_OBLONG)
                raise mistake(
                    f"got {plain_number(self.radius_across_mm)}, allowed: {least} to {most},"
                    " a millionth of radius_mm to a million times it",
                    at="sphere.radius_across_mm",
                )
        rule = "an elastic sphere needs both, a rigid sphere neither"
        _refuse_half(self, ("youngs_modulus_gpa", "poissons_ratio"), rule)
        return self


# ---- plate


def _point(value: Any) -> Any:
    """Return a point on the plate as a tuple."""
    point = numbers(value, 2)
    if point is None:
        raise mistake(f"got {quoted(value)}, allowed: [x, y], two numbers in mm from a corner")
    return point


_PAIR = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}
Point = Annotated[tuple[float, float], BeforeValidator(_point), WithJsonSchema(_PAIR)]
EDGE_KINDS = ("simply_supported", "free", "clamped")
EDGE_PAIRS = ("length", "width")


def _edges(value: Any) -> Any:
    """Return the kind of all edges, or the kinds of opposite pairs."""
    if isinstance(value, str):
        return _edge_kind(value, "plate.edges")
    if isinstance(value, dict) and set(value) == set(EDGE_PAIRS):
        return {pair: _edge_kind(value[pair], f"plate.edges.{pair}") for pair in EDGE_PAIRS}
    kinds = ", ".join(EDGE_KINDS)
    raise mistake(
        f"got {quoted(value)}, allowed: one of {kinds}, or opposite pairs such as"
        " {length: free, width: clamped}"
    )


def _edge_kind(value: Any, at: str) -> str:
    """Return the kind of edges, or refuse it."""
    if value in EDGE_KINDS:
        return str(value)
    words = f"got {quoted(value)}, allowed: {', '.join(EDGE_KINDS)}"
    nearest = get_close_matches(str(value), EDGE_KINDS, 1)
    if nearest:
        words += f"; did you mean {nearest[0]}?"
    raise mistake(words, at=at)


_EDGE_KIND = {"type": "string", "enum": list(EDGE_KINDS)}
_EDGE_PAIRS = {
    "type": "object",
    "title": "opposite pairs",
    "properties": dict.fromkeys(EDGE_PAIRS, _EDGE_KIND),
    "required": list(EDGE_PAIRS),
    "additionalProperties": False,
}
Edges = Annotated[
    str | dict[str, str],
    BeforeValidator(_edges),
    WithJsonSchema({"anyOf": [_EDGE_KIND, _EDGE_PAIRS]}),
]
Hardness = Annotated[
    float | Literal["none"], *number_or(library.NONE, "a finite number, or none", HARDNESS)
]
LOSS = "above 0 and at most 1, or at least two [frequency_hz, loss_factor] pairs"


def _loss_factor(value: Any) -> Any:
    """Return a loss factor, or pairs of rising frequency as tuples."""
    if is_number(value) and 0 < value <= 1:
        return float(value)
    listed = value if isinstance(value, list | tuple) else []
    pairs = [numbers(pair, 2) for pair in listed]
    valid = [pair for pair in pairs if pair is not None and pair[0] > 0 and 0 < pair[1] <= 1]
    if len(valid) < 2 or len(valid) < len(pairs):
        raise mistake(f"got {quoted(value)}, allowed: {LOSS}", at="plate.loss_factor")
    if any(later[0] <= earlier[0] for earlier, later in pairwise(valid)):
        raise mistake(
            f"got {quoted(value)}, allowed: pairs of rising frequency", at="plate.loss_factor"
        )
    return tuple(valid)


def loss_text(loss_factor: LossFactor) -> str:
    """Write a loss factor, or its pairs: 0.01, or 0.02 at 100 Hz to 0.005 at 10000 Hz."""
    if isinstance(loss_factor, float):
        return f"{loss_factor:g}"
    (first_hz, first), *_, (last_hz, last) = loss_factor
    return f"{first:g} at {first_hz:g} Hz to {last:g} at {last_hz:g} Hz"


_Loss = Annotated[float, Field(gt=0, le=1)]
_LossPair = tuple[Annotated[float, Field(gt=0)], _Loss]
Loss = Annotated[
    _Loss | Annotated[tuple[_LossPair, ...], Field(min_length=2)],
    BeforeValidator(_loss_factor),
]
# Keys of the plate that change its vibration, and not the march of the contact.
VIBRATING_PLATE = (
    "density_kg_m3",
    "thickness_mm",
    "loss_factor",
    "damping",
    "length_mm",
    "width_mm",
    "edges",
    "contact_mm",
    "contact_path",
    "contact_end_mm",
    "contact_loss_factor",
)
CONTACT_AT = 0.43, 0.37  # default over length and width: many modes have nodal lines in the middle


class Plate(Section):
    """Plate that the sphere rolls on. For the contact it is a half-space.

    Attributes
    ----------
    material : str, optional
        Material by name. It gives modulus, Poisson's ratio, hardness, density and, with a
        thickness, the loss factor; values beside it win.
    youngs_modulus_gpa : float
        Young's modulus [GPa]
    poissons_ratio : float
        Poisson's ratio [-]
    hardness_gpa : float or "none", optional
        Hardness [GPa]: no pressure exceeds it. It is below a fifth of the modulus. Default, or
        none: the plate never yields.
    yield_strength_gpa : float, optional
        Yield strength [GPa], in place of the hardness, which is three times as large
    plasticity : str, optional
        What a yielded place remembers. memoryless (default): nothing, so every position meets the
        virgin surface. permanent: it keeps its dent; this needs a hardness.
    density_kg_m3 : float, optional
        Density [kg/m3]. Dynamics needs it.
    thickness_mm : float, optional
        Thickness [mm] of a plate that bends as it vibrates. Default: a half-space.
    loss_factor : float or pairs of float, optional
        Loss factor of bending waves [-], or pairs of frequency [Hz] and loss factor, such as those
        of third octaves. Between pairs it is a power law, beyond them it is constant. A plate with
        edges needs it, and so does the sound power above coincidence.
    damping : str, optional
        Damping that a material by name gives, where loss_factor is absent. handled (default): that
        of objects as one meets them, if it is larger than the material's own. intrinsic: the
        material's own.
    length_mm : float, optional
        Length [mm] along x of a rectangular plate. Default: an infinite plate.
    width_mm : float, optional
        Width [mm] along y of a rectangular plate
    edges : str or mapping, optional
        Edges of a rectangular plate: simply_supported (default), free or clamped, all four alike.
        Opposite pairs are {length: clamped, width: free}: length names the two edges at the ends of
        the length (x = 0 and x = length_mm), width those at the ends of the width.
    contact_mm : pair of float, optional
        Contact point (x, y) [mm] from a corner of a rectangular plate. Default: 0.43 of the length,
        0.37 of the width.
    contact_path : str, optional
        Path of the contact on the plate. fixed (default): it stays at contact_mm. to-and-fro: it
        moves to contact_end_mm and back.
    contact_end_mm : pair of float, optional
        Other end (x, y) [mm] of a path to-and-fro
    contact_loss_factor : float, optional
        Loss factor of the contact stiffness [-] at the contact resonance. Default: 0.

    Examples
    --------
    >>> import rolling
    >>> rolling.Plate(material="glass", thickness_mm=8).youngs_modulus_gpa
    70.0
    """

    NAMED: ClassVar[str] = "plate"

    material: Material | None = None
    youngs_modulus_gpa: float = Field(ge=YOUNG.least, le=YOUNG.most)
    poissons_ratio: float = Field(ge=0, le=0.5)
    hardness_gpa: Hardness | None = None
    yield_strength_gpa: float | None = Field(default=None, gt=0, le=HARDNESS.most / library.YIELDS)
    plasticity: Literal["memoryless", "permanent"] | None = None
    density_kg_m3: float | None = Field(default=None, ge=DENSITY.least, le=DENSITY.most)
    thickness_mm: float | None = Field(default=None, gt=0)
    loss_factor: Loss | None = None
    damping: Literal["handled", "intrinsic"] | None = None
    length_mm: float | None = Field(default=None, gt=0)
    width_mm: float | None = Field(default=None, gt=0)
    edges: Edges | None = None
    contact_mm: Point | None = None
    contact_path: Literal["fixed", "to-and-fro"] | None = None
    contact_end_mm: Point | None = None
    contact_loss_factor: float | None = Field(default=None, ge=0, le=1)

    @property
    def cap_gpa(self) -> float:
        """Maximum pressure [GPa] that the plate bears, infinite for a purely elastic plate."""
        if self.yield_strength_gpa is not None:
            return library.YIELDS * self.yield_strength_gpa
        return self.hardness_gpa if isinstance(self.hardness_gpa, float) else math.inf

    @property
    def edges_mm(self) -> tuple[float, float] | None:
        """Length and width [mm] of a rectangular plate; None for an infinite one."""
        both = self.length_mm, self.width_mm
        return None if both[0] is None or both[1] is None else (both[0], both[1])

    @property
    def edge_pair(self) -> tuple[str, str]:
        """Kinds of the edges at the ends of the length, and at those of the width."""
        kinds = self.edges or "simply_supported"
        if isinstance(kinds, str):
            return kinds, kinds
        return kinds["length"], kinds["width"]

    @property
    def contact_ends_mm(self) -> dict[str, tuple[float, float]]:
        """Contact point (x, y) by key, and the other end of its path if it moves [mm]."""
        if self.edges_mm is None:
            return {}
        default = CONTACT_AT[0] * self.edges_mm[0], CONTACT_AT[1] * self.edges_mm[1]
        ends = {"contact_mm": self.contact_mm or default, "contact_end_mm": self.contact_end_mm}
        return {key: point for key, point in ends.items() if point is not None}

    @model_validator(mode="after")
    def _check_yielding(self) -> Self:
        """Refuse a hardness beside a yield strength, a hardness above E/5, and memory without."""
        if self.yield_strength_gpa is not None and self.hardness_gpa is not None:
            raise mistake(
                f"not beside hardness_gpa, which is {library.YIELDS} times as much",
                at="plate.yield_strength_gpa",
            )
        if self.youngs_modulus_gpa / HARDEST <= self.cap_gpa < math.inf:
            if self.yield_strength_gpa is None:
                self._refuse_hard("hardness_gpa", self.cap_gpa, "fifth", HARDEST)
            share = HARDEST * library.YIELDS
            self._refuse_hard("yield_strength_gpa", self.yield_strength_gpa, "fifteenth", share)
        if self.plasticity == "permanent" and math.isinf(self.cap_gpa):
            raise mistake(
                "missing; plasticity: permanent needs it, an elastic plate keeps its surface",
                at="plate.hardness_gpa",
                needs=["plate.yield_strength_gpa"],
            )
        return self

    def _refuse_hard(self, key: str, got: float, part: str, share: float) -> NoReturn:
        """Refuse a hardness or yield strength above a share of Young's modulus."""
        raise mistake(
            f"got {plain_number(got)}, allowed: below a {part} of youngs_modulus_gpa,"
            f" {rounded(self.youngs_modulus_gpa / share, 4)}; without a hardness the plate is"
            " purely elastic",
            at=f"plate.{key}",
        )

    @model_validator(mode="after")
    def _check_edges(self) -> Self:
        """Refuse half a rectangle, and keys of a contact point without edges."""
        if self.loss_factor is not None and self.thickness_mm is None:
            raise mistake(
                "only goes with thickness_mm: a half-space has no bending waves",
                at="plate.loss_factor",
                needs=["plate.thickness_mm"],
            )
        if self.damping is not None and self.material is None:
            raise mistake(
                "only goes with material, which gives a loss factor; without one, give loss_factor",
                at="plate.damping",
                needs=["plate.material"],
            )
        if self.edges_mm is None:
            sides = ["plate.length_mm", "plate.width_mm"]
            rule = "a plate with edges needs both, an infinite plate neither"
            _refuse_half(self, ("length_mm", "width_mm"), rule)
            if self.edges is not None:
                raise mistake(
                    "only goes with length_mm and width_mm: an infinite plate has no edges",
                    at="plate.edges",
                    needs=sides,
                )
            for key in ("contact_mm", "contact_path", "contact_end_mm"):
                if getattr(self, key) is not None:
                    raise mistake(
                        "only goes with length_mm and width_mm: a point on an infinite plate is"
                        " like any other",
                        at=f"plate.{key}",
                        needs=sides,
                    )
            return self
        if self.thickness_mm is None:
            raise mistake("missing; a plate with edges bends", at="plate.thickness_mm")
        if self.loss_factor is None:
            raise mistake(
                "missing; a plate with edges has modes, which decay", at="plate.loss_factor"
            )
        for key, point in self.contact_ends_mm.items():
            for axis, place, edge in zip("xy", point, self.edges_mm, strict=True):
                if not 0 < place < edge:
                    raise mistake(
                        f"got {quoted(list(point))}, allowed: a point within the edges, {axis}"
                        f" above 0 and below {plain_number(edge)}",
                        at=f"plate.{key}",
                    )
        end = self.contact_end_mm
        moves = self.contact_path == "to-and-fro"
        if moves and end is None:
            raise mistake("missing; contact_path: to-and-fro needs it", at="plate.contact_end_mm")
        if end is not None and not moves:
            raise mistake(
                "only goes with contact_path: to-and-fro",
                at="plate.contact_end_mm",
                needs=["plate.contact_path"],
            )
        if end is not None and end == self.contact_ends_mm["contact_mm"]:
            raise mistake(
                f"got {quoted(list(end))}, the point contact_mm, allowed: another point",
                at="plate.contact_end_mm",
            )
        return self


# ---- rolling


WEIGHT: Literal["weight"] = "weight"
MAX_PASSES = 100  # plastic work falls by half or more from pass to pass
SPEED = "a number > 0, or at least two [time_s, speed_m_s] pairs"


def _speed(value: Any) -> Any:
    """Return a speed, or pairs as tuples."""
    if is_number(value) and value > 0:
        return float(value)
    listed = value if isinstance(value, list | tuple) else []
    pairs = [numbers(pair, 2) for pair in listed]
    valid = [pair for pair in pairs if pair is not None]
    if len(valid) < 2 or len(valid) < len(pairs):
        raise mistake(f"got {quoted(value)}, allowed: {SPEED}", at="rolling.speed_m_s")
    try:
        Motion.of(valid)
    except ValueError as error:
        raise mistake(f"got {quoted(value)}: {error}", at="rolling.speed_m_s") from error
    return tuple(valid)


_Pair = tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(ge=0)]]
Speed = Annotated[
    Annotated[float, Field(gt=0)] | Annotated[tuple[_Pair, ...], Field(min_length=2)],
    BeforeValidator(_speed),
]


LOAD = f"greater than 0, or {WEIGHT}"
Load = Annotated[float | Literal["weight"], *number_or(WEIGHT, LOAD, exclusiveMinimum=0)]


AUTO: Literal["auto"] = "auto"
LENGTH = f"greater than 0, or {AUTO}"
Length = Annotated[float | Literal["auto"], *number_or(AUTO, LENGTH, exclusiveMinimum=0)]
LENGTH_KEYS = ("duration_s", "distance_mm")  # which auto may stand for


class Rolling(Section):
    """Load, speed and duration of the rolling.

    Attributes
    ----------
    load_n : float or "weight"
        Normal load [N]. weight: that of the sphere, which needs sphere.density_kg_m3.
    speed_m_s : float or pairs of float
        Speed [m/s], or pairs of time [s] and speed [m/s]. The times increase from 0. The speed is
        linear between them, and constant after the last.
    resistance : float, optional
        Coefficient c of rolling resistance [-]. A free solid sphere slows down by 5/7 c load/mass.
        Default: the speed is kept.
    drop_mm : float, optional
        Height [mm] from which the sphere falls at the start. It needs dynamics, and the sound of
        the vibration.
    duration_s : float or "auto", optional
        Time rolled [s]. auto takes the shortest closed track on which the levels are known within
        numerics.within_db; the runs of a sweep share the longest. Default: auto; with resistance
        until the sphere rests; with a height file once round it.
    distance_mm : float or "auto", optional
        Distance rolled [mm], in place of a duration. Every speed then meets the same surface. auto
        takes the distance that auto takes for a duration.
    start_um : float
        Start position along the track [um]
    across_um : float
        Distance of the track from the middle line of the plate's surface [um], rounded to whole
        nodes. The surface is periodic across, and its faults keep their places in it.
    passes : int, optional
        Number of passes over the track, each on the surface that the pass before left. The record
        is the last. More than 1 needs plate.plasticity: permanent.

    Examples
    --------
    >>> import rolling
    >>> rolling.Rolling(load_n=20, speed_m_s=[[0, 0.1], [1, 0.3]], duration_s=1).start_um
    0.0
    """

    load_n: Load = WEIGHT
    speed_m_s: Speed
    resistance: float | None = Field(default=None, ge=0, le=1)
    drop_mm: float | None = Field(default=None, gt=0)
    duration_s: Length | None = None
    distance_mm: Length | None = None
    start_um: float = 0.0
    across_um: float = 0.0
    passes: int | None = Field(default=None, ge=1, le=MAX_PASSES)

    @property
    def falls(self) -> bool:
        """Whether the sphere falls at the start."""
        return self.drop_mm is not None

    @property
    def stated_duration_s(self) -> float | None:
        """Duration [s] where it is a number."""
        return None if isinstance(self.duration_s, str) else self.duration_s

    @property
    def stated_distance_mm(self) -> float | None:
        """Distance [mm] where it is a number."""
        return None if isinstance(self.distance_mm, str) else self.distance_mm

    @property
    def length_key(self) -> str | None:
        """Key that auto stands for, or that a scene without a length leaves to it; None without."""
        for key in LENGTH_KEYS:
            if getattr(self, key) == AUTO:
                return key
        has_length = self.duration_s or self.distance_mm or self.resistance
        return None if has_length else LENGTH_KEYS[0]

    @model_validator(mode="after")
    def _check_length(self) -> Self:
        if self.duration_s is not None and self.distance_mm is not None:
            raise mistake("given beside duration_s, allowed: one of them", at="rolling.distance_mm")
        if self.resistance is not None and isinstance(self.speed_m_s, tuple):
            raise mistake(
                "only goes with one speed_m_s, at which the sphere starts, not with pairs",
                at="rolling.resistance",
            )
        return self


# ---- numerics


STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]
WITHIN_DB = 0.3  # usual wanted ± of LAeq by the length of the record
LEAST_TOLERANCE = 1e-12
MOST_TOLERANCE = 1e-1
TOLERANCE = f"auto, or a number >= {rounded(LEAST_TOLERANCE)} and <= {rounded(MOST_TOLERANCE)}"


STEPS = "auto, a whole number from 1 to 64, or one over a whole number down to 1/16"


def _step_nodes(value: float | str) -> float | str:
    """Return the allowed value that a rounded value stands for, such as a third for 0.333333."""
    if isinstance(value, str):
        return value
    closest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / closest - 1) > 1e-5:
        raise mistake(
            f"got {plain_number(value)}, allowed: {STEPS}; nearest: {plain_number(closest)}",
            at="numerics.step_nodes",
        )
    return closest


StepNodes = Annotated[
    float | Literal["auto"],
    AfterValidator(_step_nodes),
    *number_or("auto", STEPS, exclusiveMinimum=0),
]
Tolerance = Annotated[
    float | Literal["auto"],
    *number_or("auto", TOLERANCE, minimum=LEAST_TOLERANCE, maximum=MOST_TOLERANCE),
]


class Numerics(Section):
    """Resolution and accuracy of the solution.

    Attributes
    ----------
    step_nodes : float or "auto"
        Distance between two solved positions, in nodes [-]: 1 to 64, or one over a whole number
        down to 1/16. auto takes 4, 2 or 1, the most that the slowest speed of the scene and its
        sweep allows.
    within_db : float
        Wanted ± of LAeq by the length of the record [dB], for which a length of auto is chosen. The
        wanted ± of the third octaves within 10 dB of the loudest one is 10/3 of it.
    slowest_m_s : float, optional
        Lowest speed [m/s] for which auto chooses steps, so that the run can be heard anew at this
        speed. Default: the slowest that is heard in the scene and its sweep.
    tolerance : float or "auto"
        Allowed violation of the contact conditions, over the maximum deflection [-]. auto takes
        1e-4, less for smooth surfaces, and without dynamics up to 1e-3 for random surfaces where
        the contact is a few steps wide or yields.
    edges : str
        Pressure where a yielding patch ends within a cell. blended: the cell bears the share that
        is in contact. sharp: it bears all or nothing.
    subcells : int or "auto"
        Sub-cells along the side of a cell, with heights and pressures of their own. auto takes 2 on
        steep surfaces that yield, with blended edges.
    precision : str
        Precision of the transforms within the iteration. The final check of a solution is always in
        double precision.
    error_estimate : bool
        Whether the errors of grid and tolerance are estimated for every level. It takes a quarter
        more time, or 40 % more under an exponential law; on a short track up to 20 s.

    Examples
    --------
    >>> import rolling
    >>> rolling.Numerics(step_nodes=2).tolerance
    'auto'
    """

    step_nodes: StepNodes = "auto"
    within_db: float = Field(default=WITHIN_DB, ge=0.05, le=5)
    slowest_m_s: float | None = Field(default=None, gt=0)
    tolerance: Tolerance = "auto"
    edges: Literal["sharp", "blended"] = "blended"
    subcells: Literal["auto", 1, 2, 4] = "auto"
    precision: Literal["single", "double"] = "single"
    error_estimate: bool = False


# ---- recovery, dynamics, sound


class Recovery(Section):
    """Energy that the nodes give back as they leave the contact.

    Attributes
    ----------
    events : bool
        Whether a table of recovery events is written
    rule : str
        Pressure of a node whose deflection falls in a step. mean: that of both ends of the step.
        left_end: that at its beginning, as in the article.

    Examples
    --------
    >>> import rolling
    >>> rolling.Recovery(events=True).rule
    'mean'
    """

    events: bool = False
    rule: Literal["mean", "left_end"] = "mean"


def _odd(value: int) -> int:
    """Refuse an even number of loads."""
    if value % 2 == 0:
        raise mistake(f"got {value}, allowed: an odd whole number from 3 to 15")
    return value


class Dynamics(Section):
    """Vibration of sphere and plate, which makes the contact force fluctuate.

    Attributes
    ----------
    loads : int
        Minimum number of loads at which the track is marched [-], odd
    span : float
        Ratio of a marched load to the next lower one [-]
    release : bool, optional
        Whether one more march computes the release under the moving load, in place of the constant
        load. Default: true for sound.source: release.

    Examples
    --------
    >>> import rolling
    >>> rolling.Dynamics(loads=5).span
    1.4
    """

    loads: Annotated[int, AfterValidator(_odd)] = Field(default=3, ge=3, le=15)
    span: float = Field(default=1.4, ge=1.05, le=4)
    release: bool | None = None


MAX_LISTENERS = 16
_PLACES = f"[x, y, z], three numbers in mm, or a list of 1 to {MAX_LISTENERS} such places"


def _listeners(value: Any) -> Any:
    """Return listeners as tuples."""
    places = value if isinstance(value, list | tuple) else []
    if numbers(value, 3) is not None:
        places = [value]
    listeners = [numbers(place, 3) for place in places]
    valid = [place for place in listeners if place is not None]
    if not valid or len(valid) < len(listeners):
        raise mistake(f"got {quoted(value)}, allowed: {_PLACES}")
    if len(valid) > MAX_LISTENERS:
        raise mistake(f"got {len(valid)} places, allowed: {_PLACES}")
    if any(height == 0 for _, _, height in valid):
        raise mistake(f"got {quoted(value)}, allowed: z above 0, on the ball's side, or below 0")
    return tuple(valid)


_PLACE = {"type": "array", "minItems": 3, "maxItems": 3, "items": {"type": "number"}}
_PLACE_LIST = {"type": "array", "minItems": 1, "maxItems": MAX_LISTENERS, "items": _PLACE}
Listeners = Annotated[
    tuple[tuple[float, float, float], ...],
    BeforeValidator(_listeners),
    WithJsonSchema({"anyOf": [_PLACE, _PLACE_LIST]}),
]


_ROOM = "levels in dB by nominal mid frequency of third octaves, as in {63: 25, 125: 22}"


def _room(value: Any) -> Any:
    """Return the third octaves of a room by the names of their bands, lowest first."""
    if not isinstance(value, dict) or not value:
        raise mistake(f"got {quoted(value)}, allowed: {_ROOM}")
    levels: dict[str, float] = {}
    for key, level in value.items():
        try:
            frequency_hz = float(key)
        except (TypeError, ValueError):
            raise mistake(f"got the frequency {quoted(key)}, allowed: {_ROOM}") from None
        name = f"{frequency_hz:g}"
        if name not in BAND_NAMES:
            closest = nearest_nominal(frequency_hz)
            raise mistake(
                f"got the frequency {quoted(key)}, allowed: nominal mid frequencies of third "
                f"octaves from 20 to 20000 Hz; nearest: {closest:g}"
            )
        if not (is_number(level) and MIN_ROOM_DB <= level <= MAX_ROOM_DB):
            words = f"a level from {MIN_ROOM_DB:g} to {MAX_ROOM_DB:g} dB re 20 uPa"
            raise mistake(f"{name} Hz: got {quoted(level)}, allowed: {words}")
        levels[name] = float(level)
    return {name: levels[name] for name in BAND_NAMES if name in levels}


_ROOM_LEVEL = {"type": "number", "minimum": MIN_ROOM_DB, "maximum": MAX_ROOM_DB}
_ROOM_LEVELS = {"type": "object", "minProperties": 1, "additionalProperties": False} | {
    "patternProperties": {r"^[0-9.]+$": _ROOM_LEVEL},
    "title": "level by frequency",
}
Room = Annotated[dict[str, float], BeforeValidator(_room), WithJsonSchema(_ROOM_LEVELS)]


def _channels(value: Any) -> Any:
    """Refuse anything but a list of some channels, and keep the list for the model."""
    is_list = isinstance(value, list | tuple)
    if is_list and 1 <= len(value) <= MAX_CHANNELS:
        return list(value)
    got = f"{len(value)} channels" if is_list else quoted(value)
    raise mistake(
        f"got {got}, allowed: a list of 1 to {MAX_CHANNELS} channels, as in"
        " [{of: plate, quantity: acceleration, x_mm: 30, y_mm: 40}]"
    )


Channels = Annotated[list[SoundChannel], BeforeValidator(_channels)]


class Sound(Section):
    """Source, listener, and conversion of release power to sound pressure.

    Attributes
    ----------
    source : str, optional
        Whose record is measured, in levels, spectra and errors. vibration: that of sphere and
        plate, which needs dynamics. release: the released elastic energy, an upper bound. The
        vibration plays wherever there is one, computed or estimated. Default: vibration with
        dynamics, otherwise release.
    ball : bool
        Whether the vibration of the sphere is heard beside that of the plate
    distance_m : float
        Distance of the listener [m], more than the sphere's radius. Beside listener_mm it is the
        radius of the half sphere of the mean level.
    listener_mm : three floats, or a list of them, optional
        Listeners (x, y, z) [mm] of a plate with edges, from the corner of contact_mm; z above 0 is
        on the ball's side. The main levels are those of the first, and two make stereo. Default: at
        distance_m above the contact, or above the middle of its path.
    q : float
        Share of the released energy that is radiated [-]
    gain_pa_per_w_m2 : float, optional
        Fixed factor from intensity to sound pressure [Pa per W/m2]. Default: each run has the
        factor that keeps its energy.
    listen_s : float, optional
        Length [s] of listen.wav as a long record, in which the ball rolls on beyond the solved
        track. Default: the record repeats, for at least 5 s.
    loudness : bool
        Whether loudness (ISO 532-1), sharpness (DIN 45692), roughness and prominence of tones are
        reported. Where the sound is not steady, N5 and the maximum of the loudness in time stand in
        place of loudness and sharpness.
    room_db : dict, optional
        Noise of the listener's room, in which differences are audible or not: levels of third
        octaves [dB re 20 uPa] by nominal mid frequency, as in {63: 25, 125: 22}. Missing bands are
        silent. No level of a run includes it. Default: pink noise of 30 dB(A), 50 Hz to 10 kHz.
    channels : list of SoundChannel, optional
        What else is recorded: motion of plate and ball, contact force and blocked force, each with
        `of`, `quantity` and, on the plate, `x_mm` and `y_mm`. They need dynamics.

    Examples
    --------
    >>> import rolling
    >>> rolling.Sound(distance_m=0.5, listen_s=10).q
    1.0
    """

    source: Literal["vibration", "release"] | None = None
    ball: bool = True
    distance_m: float = Field(default=1.0, gt=0)
    listener_mm: Listeners | None = None
    q: float = Field(default=1.0, gt=0, le=1)
    gain_pa_per_w_m2: float | None = Field(default=None, gt=0)
    listen_s: float | None = Field(default=None, ge=0.1, le=120)
    loudness: bool = False
    room_db: Room | None = None
    channels: Channels | None = None

    @model_validator(mode="after")
    def _check_channels(self) -> Self:
        refuse_equal_names(self.channels or [])
        return self

    @model_validator(mode="after")
    def _check_free_factors(self) -> Self:
        refuse_free_factors(self)
        return self


def refuse_free_factors(sound: Sound) -> None:
    """Refuse the free factors of the release for a vibration, whose pressure has none."""
    if sound.source != "vibration":
        return
    words = "which only goes with source: release; the pressure of the vibration has no free factor"
    if sound.q != 1:
        raise mistake(f"got {plain_number(sound.q)}, {words}", at="sound.q", needs=["sound.source"])
    if sound.gain_pa_per_w_m2 is not None:
        gain = plain_number(sound.gain_pa_per_w_m2)
        raise mistake(f"got {gain}, {words}", at="sound.gain_pa_per_w_m2", needs=["sound.source"])
