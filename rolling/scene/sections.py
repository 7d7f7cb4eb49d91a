"""Sections of a scene: frozen models, units in the key names, and checks of single sections.

Lengths are in mm or um and moduli in GPa here; the properties of `Scene` are SI. Sections are built
in Python as `Sphere(radius_mm=5)`; a value that is not allowed then raises SceneError with the same
message as in a scene file.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, dataclass_transform

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    WithJsonSchema,
    field_validator,
    model_validator,
)

from rolling.scene.messages import (
    SceneError,
    Words,
    cut,
    dotted,
    explained,
    fault,
    is_number,
    plain_number,
    shown,
)
from rolling.scene.track import MAX_NODES, MIN_NODES

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

# Minimum magnitude of a number other than zero, in the units of the scene; its inverse is the
# maximum.
SMALLEST = 1e-15
MAX_FAULTS = 100  # maximum number of faults that are named
_MAX_BITS = 1000  # maximum length of a whole number: pydantic fails to show much longer ones
_MAX_DEPTH = 16  # maximum nesting of values typed in Python
STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]


# ---- construction from Python


def plain(value: Any, depth: int = 0) -> Any:
    """Turn a value typed in Python into the plain value of a scene file.

    Keys without a value are dropped.

    Parameters
    ----------
    value : any
        The value.
    depth : int
        Number of mappings and lists around it. Default: 0.

    Raises
    ------
    SceneError
        The value is nested too deeply, for example in itself.
    """
    if depth > _MAX_DEPTH:
        raise SceneError([f"scene: values are nested more than {_MAX_DEPTH} times"])
    if isinstance(value, BaseModel):
        value = value.model_dump()
    if isinstance(value, Mapping):
        return {name: plain(item, depth + 1) for name, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [plain(item, depth + 1) for item in value]
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, int) and value.bit_length() > _MAX_BITS:
        return math.inf if value > 0 else -math.inf
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def required_in_files(key: str) -> Any:
    """Change the JSON Schema of a model so that scene files must give a key.

    In Python the key has a default.
    """

    def change(schema: dict[str, Any]) -> None:
        schema["properties"][key].pop("default", None)
        schema["required"] = [key, *schema.get("required", [])]

    return change


@dataclass_transform(kw_only_default=True, field_specifiers=(Field,))
class _SceneErrors(ModelMetaclass):
    """Metaclass of models that raise SceneError instead of the errors of pydantic."""

    def __call__(cls, *positional: Any, **values: Any) -> Any:
        if positional:
            raise TypeError(
                f"{cls.__name__} takes keys by name only, as in {cls.__name__}(key=value)"
            )
        return cls.from_values(plain(values))  # type: ignore[attr-defined]


class Section(BaseModel, metaclass=_SceneErrors):
    """Section of a scene, frozen and strict: text is no number, and unknown keys are faults."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)
    SECTION: ClassVar[str] = ""  # its name in a scene

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Self:
        """Validate plain values.

        Raises
        ------
        SceneError
            Some values are missing, unknown or not allowed; each fault names its key within a
            scene.
        """
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            faults = []
            for listed in error.errors(include_url=False)[:MAX_FAULTS]:
                key, message = explained(listed, values, cls)
                key = key if key[:1] == (cls.SECTION,) else (cls.SECTION, *key)
                faults.append(f"scene: {cut(dotted(key))}: {message}")
            raise SceneError(faults) from error

    @field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Refuse sizes whose powers and quotients overflow or underflow."""
        for number in np.ravel(value) if isinstance(value, float | tuple) else ():
            if number and not SMALLEST <= abs(number) <= 1 / SMALLEST:
                raise fault(
                    f"got {shown(float(number))}, allowed: a size from {SMALLEST:g} to"
                    f" {1 / SMALLEST:g}"
                )
        return value


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
    """Half-space that the sphere rolls on."""

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


# ---- surfaces


class MadeSurface(Section):
    """Surface of a given width that the program generates."""

    SECTION: ClassVar[str] = "surface"

    kind: str
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    width_um: float = Field(
        gt=0, description="Width across the track [um], a whole number of nodes, at least 8"
    )

    @model_validator(mode="after")
    def _whole_width(self) -> MadeSurface:
        _refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int:
        """Nodes across the track."""
        return round(self.width_um / self.spacing_um)


def _refuse_width(width_um: float, spacing_um: float) -> None:
    """Raise a fault for a width that is no whole number of nodes, too small or too large."""
    nodes = width_um / spacing_um
    if not nodes < MAX_NODES:
        raise fault(
            f"got {plain_number(width_um)}, allowed: less than {MAX_NODES:g} nodes",
            "surface",
            "width_um",
        )
    if round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
        fitting = max(MIN_NODES, round(nodes)) * spacing_um
        raise fault(
            f"got {plain_number(width_um)}, allowed: a whole number of nodes of {spacing_um:g} um,"
            f" at least {MIN_NODES}; nearest: {fitting:.10g}",
            "surface",
            "width_um",
        )


class Gaussian(MadeSurface):
    """Random periodic surface with Gaussian heights."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))

    kind: Literal["gaussian"] = Field(
        default="gaussian", description="A random surface with Gaussian heights"
    )
    autocorrelation: Literal["gaussian", "gaussian_10pct", "exponential", "exponential_10pct"] = (
        Field(
            default="gaussian",
            description="Law in the distance r and the correlation length L: gaussian"
            " exp(-(r/L)^2), gaussian_10pct exp(-2.3 (r/L)^2), exponential exp(-r/L),"
            " exponential_10pct exp(-2.3 r/L)",
        )
    )
    roughness_ra_um: float = Field(gt=0, le=1000, description="Arithmetic mean roughness Ra [um]")
    correlation_length_um: float = Field(
        gt=0, description="Correlation length [um], along the track"
    )
    correlation_length_across_um: float | None = Field(
        default=None,
        gt=0,
        description="Correlation length across the track [um]; absent: the same as along",
    )
    seed: int = Field(ge=0, description="Seed of the random heights")


class Smooth(MadeSurface):
    """Perfectly flat surface."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))

    kind: Literal["smooth"] = Field(default="smooth", description="A perfectly flat surface")


class HeightFile(Section):
    """Surface read from a file, which holds one period of it."""

    model_config = ConfigDict(json_schema_extra=required_in_files("kind"))
    SECTION: ClassVar[str] = "surface"

    kind: Literal["file"] = Field(
        default="file", description="Heights from a file; the track is the file"
    )
    path: str = Field(
        min_length=1,
        description="File of heights, .npy, .npz, .csv or .txt, shape (along track, across),"
        " relative to the scene file",
    )
    height_unit: Literal["m", "mm", "um", "nm"] = Field(
        default="m", description="Unit of the heights in the file"
    )
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    level: Literal["auto", "plane", "none"] = Field(
        default="auto",
        description="Tilt: auto takes the least-squares plane off where the step from the last"
        " row to the first stands out and the plane lowers it, plane always, none"
        " never",
    )
    width_um: float | None = Field(
        default=None,
        gt=0,
        description="Width across the track [um] of a profile of one line, whose heights are the"
        " same all across: a whole number of nodes, at least 8; absent: the file holds lines side"
        " by side",
    )

    @model_validator(mode="after")
    def _whole_width(self) -> HeightFile:
        if self.width_um is not None:
            _refuse_width(self.width_um, self.spacing_um)
        return self

    @property
    def n_across(self) -> int | None:
        """Nodes across the track that a profile is laid over; None: those of the file."""
        return None if self.width_um is None else round(self.width_um / self.spacing_um)


Surface = Annotated[Gaussian | Smooth | HeightFile, Field(discriminator="kind")]


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
        " in every level, for at most 25 % more time",
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
        default=1.4, gt=1, le=4, description="Ratio of a marched load to the next lower one [-]"
    )
    release: bool = Field(
        default=False,
        description="Whether the release is computed under the moving load, by one more march of"
        " each run; otherwise under the constant load",
    )


class Sound(Section):
    """Source, listener, and conversion of release power to sound pressure."""

    SECTION: ClassVar[str] = "sound"

    source: Literal["release", "vibration"] = Field(
        default="release",
        description="Origin of the sound pressure: release of elastic energy, or vibration of"
        " sphere and plate, which needs dynamics and takes neither q nor gain",
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
    def _of_release_only(self) -> Sound:
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
