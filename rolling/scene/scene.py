"""What a scene can say: frozen models, units in the key names, all checks. `scene_file` reads and writes it.

Outside (YAML, overrides) lengths are in mm or um and moduli in GPa; the properties of `Scene` and `Track` are SI.
Depends on `motion`, `_track` (the arithmetic of `track`) and `_wording` (the messages).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from rolling.scene.messages import (
    Key,
    Words,
    all_keys,
    allowed,
    cut,
    dotted,
    explained,
    fault,
    is_number,
    nearest,
    numeric_keys,
    place,
    plain_number,
    shown,
)
from rolling.scene.motion import Motion
from rolling.scene.run_names import run_name
from rolling.scene.track import MAX_NODES, MIN_NODES, Track, file_track, made_track

SMALLEST = 1e-15  # of any number but zero, in the units of the scene; one over it is the largest
MAX_RUNS = 10_000  # of a sweep
MOST_FAULTS = 100  # that are named
STEEL_DENSITY = 7850.0  # [kg/m3]
Fault = tuple[Key, str]  # key and message
STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]


class SceneError(Exception):
    """All that is wrong with a scene: `faults`, one line each, with file and line (or --set), key, got and allowed."""

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = list(faults)

    def __reduce__(self) -> tuple[type[SceneError], tuple[list[str]]]:
        return SceneError, (self.faults,)


# ---- the models ------------------------------------------------------------------------------------------------------


NAME = Words("1 to 64 letters, digits, dots, dashes or underscores, a letter or digit first (numbers in quotes)")
SPEED = Words("a number > 0, or at least two [time_s, speed_m_s] pairs")


def _speed(value: Any) -> Any:
    """A number, or pairs as tuples; raises the first fault of the pairs at its own place."""
    at = ("rolling", "speed_m_s")
    if is_number(value) and value > 0:
        return float(value)
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise fault(f"got {shown(value)}, allowed: {SPEED.allowed}", *at)
    for i, pair in enumerate(value):
        if not isinstance(pair, list | tuple) or len(pair) != 2 or not all(is_number(x) for x in pair):
            raise fault(f"got {shown(pair)}, allowed: [time_s, speed_m_s], two numbers", *at, i)
        if i == 0 and pair[0] != 0:
            raise fault(f"got {shown(pair[0])}, allowed: 0, the time of the first pair", *at, 0)
        if i and pair[0] <= value[i - 1][0]:
            raise fault(f"got time {shown(pair[0])} after {shown(value[i - 1][0])}, allowed: increasing times", *at, i)
        if pair[1] < 0:
            raise fault(f"got speed {shown(pair[1])}, allowed: a number >= 0", *at, i)
    if not any(v > 0 for _, v in value):
        raise fault("got speeds that are all 0, allowed: at least one > 0", *at)
    return tuple((float(t), float(v)) for t, v in value)


def _step_nodes(value: float) -> float:
    """The allowed value that is meant: 0.333333 is a third."""
    closest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / closest - 1) > 1e-5:
        raise fault(
            f"got {plain_number(value)}, allowed: a whole number from 1 to 64, or one over a whole number down to 1/16;"
            f" nearest: {plain_number(closest)}"
        )
    return closest


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Sizes whose powers and quotients are still numbers."""
        for number in np.ravel(value) if isinstance(value, float | tuple) else ():
            if number and not SMALLEST <= abs(number) <= 1 / SMALLEST:
                raise fault(f"got {shown(float(number))}, allowed: a size from {SMALLEST:g} to {1 / SMALLEST:g}")
        return value


class Sphere(_Section):
    """The rolling sphere: rigid unless it has a modulus."""

    radius_mm: float = Field(gt=0, description="Radius [mm]")
    density_kg_m3: float | None = Field(
        default=None,
        gt=0,
        description="Density [kg/m3], from which the check of the contact resonance has the mass; absent: 7850, as if steel",
    )
    youngs_modulus_gpa: float | None = Field(
        default=None, gt=0, description="Young's modulus [GPa]; absent: a rigid sphere"
    )
    poissons_ratio: float | None = Field(
        default=None, ge=0, le=0.5, description="Poisson's ratio [-]; absent: a rigid sphere"
    )

    @model_validator(mode="after")
    def _both_or_neither(self) -> Sphere:
        for missing, given in (("youngs_modulus_gpa", "poissons_ratio"), ("poissons_ratio", "youngs_modulus_gpa")):
            if getattr(self, missing) is None and getattr(self, given) is not None:
                raise fault(
                    f"missing beside {given}; an elastic sphere needs both, a rigid one neither", "sphere", missing
                )
        return self


class Plate(_Section):
    """The half-space the sphere rolls on."""

    youngs_modulus_gpa: float = Field(gt=0, description="Young's modulus [GPa]")
    poissons_ratio: float = Field(ge=0, le=0.5, description="Poisson's ratio [-]")
    hardness_gpa: float | None = Field(
        default=None, gt=0, description="Hardness [GPa], the highest pressure it bears; absent: purely elastic"
    )


class _Made(_Section):
    """A surface the program makes, as wide as it is told to."""

    kind: str
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    width_um: float = Field(gt=0, description="Width across the track [um], a whole number of nodes, at least 8")

    @model_validator(mode="after")
    def _whole_width(self) -> _Made:
        nodes = self.width_um / self.spacing_um
        if not nodes < MAX_NODES:
            raise fault(
                f"got {plain_number(self.width_um)}, allowed: less than {MAX_NODES:g} nodes", "surface", "width_um"
            )
        if round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
            fitting = max(MIN_NODES, round(nodes)) * self.spacing_um
            raise fault(
                f"got {plain_number(self.width_um)}, allowed: a whole number of nodes of {self.spacing_um:g} um,"
                f" at least {MIN_NODES}; nearest: {fitting:.10g}",
                "surface",
                "width_um",
            )
        return self

    @property
    def n_across(self) -> int:
        """Nodes across the track."""
        return round(self.width_um / self.spacing_um)


class Gaussian(_Made):
    """A random periodic surface with Gaussian heights."""

    kind: Literal["gaussian"] = Field(description="A random surface with Gaussian heights")
    autocorrelation: Literal["gaussian", "gaussian_10pct", "exponential", "exponential_10pct"] = Field(
        default="gaussian",
        description="Law in the distance r and the correlation length L: gaussian exp(-(r/L)^2), gaussian_10pct"
        " exp(-2.3 (r/L)^2), exponential exp(-r/L), exponential_10pct exp(-2.3 r/L)",
    )
    roughness_ra_um: float = Field(gt=0, le=1000, description="Arithmetic mean roughness Ra [um]")
    correlation_length_um: float = Field(gt=0, description="Correlation length [um], along the track")
    correlation_length_across_um: float | None = Field(
        default=None, gt=0, description="Correlation length across the track [um]; absent: the same as along"
    )
    seed: int = Field(ge=0, description="Seed of the random heights")


class Smooth(_Made):
    """A perfectly flat surface."""

    kind: Literal["smooth"] = Field(description="A perfectly flat surface")


class HeightFile(_Section):
    """Measured or made heights, read as one period of the surface."""

    kind: Literal["file"] = Field(description="Heights from a file; the track is the file")
    path: str = Field(
        min_length=1, description=".npy file of heights [m], shape (along track, across), relative to the scene file"
    )
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")
    level: Literal["auto", "plane", "none"] = Field(
        default="auto",
        description="Tilt: auto takes the least-squares plane off where the step from the last row to the first stands out"
        " and the plane lowers it, plane always, none never",
    )


Surface = Annotated[Gaussian | Smooth | HeightFile, Field(discriminator="kind")]


_PAIR_SCHEMA = {"type": "array", "prefixItems": [{"type": "number", "minimum": 0}] * 2, "minItems": 2, "maxItems": 2}
_PAIRS_SCHEMA = {"type": "array", "minItems": 2, "items": _PAIR_SCHEMA}
Speed = Annotated[
    float | tuple[tuple[float, float], ...],
    SPEED,
    BeforeValidator(_speed),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0}, _PAIRS_SCHEMA]}),
]


class Rolling(_Section):
    """How the sphere rolls."""

    load_n: float = Field(gt=0, description="Normal load [N], constant")
    speed_m_s: Speed = Field(
        description="Speed [m/s], or [time [s], speed [m/s]] pairs: times increasing from 0, linear between them,"
        " constant after the last"
    )
    duration_s: float | None = Field(
        default=None, gt=0, description="Time rolled [s]; only with a height file it may be absent: once round the file"
    )
    start_um: float = Field(default=0.0, description="Where along the track the sphere starts [um]")


class Numerics(_Section):
    """How finely to compute."""

    step_nodes: Annotated[float, AfterValidator(_step_nodes)] = Field(
        default=1.0,
        gt=0,
        description="Step in nodes [-]: a whole number from 1 to 64, or one over a whole number down to 1/16",
    )
    tolerance: float = Field(
        default=1e-4,
        ge=1e-12,
        le=1e-1,
        description="Largest violation of the contact conditions over the largest deflection [-]",
    )
    edges: Literal["sharp", "blended"] = Field(
        default="blended",
        description="Nodes at the edge of yielding patches: all or nothing, or loaded by the share of their cell in contact",
    )
    precision: Literal["single", "double"] = Field(
        default="single",
        description="Of the transforms while iterating; what is accepted is checked and kept in double precision",
    )


class Recovery(_Section):
    """What to keep of the recovering nodes."""

    events: bool = Field(default=False, description="Write a table of recovery events")
    rule: Literal["mean", "left_end"] = Field(
        default="mean",
        description="Pressure of a falling node: mean of both ends of the step, or left_end, the article's",
    )


class Sound(_Section):
    """How release power becomes sound pressure."""

    distance_m: float = Field(default=1.0, gt=0, description="Distance of the listener [m]")
    q: float = Field(default=1.0, gt=0, le=1, description="Share of the released energy that is radiated [-]")
    gain_pa_per_w_m2: float | None = Field(
        default=None,
        gt=0,
        description="Fixed factor from intensity to sound pressure [Pa per W/m2]; absent: energy-true per run",
    )
    loudness: bool = Field(
        default=False, description="Report loudness (ISO 532-1) and sharpness (DIN 45692); needs the package mosqito"
    )


class Scene(_Section):
    """A scene. Equal scenes say the same; the folder they were read from does not count."""

    name: Annotated[str, NAME] = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$", description="Name, used for the folder of the results"
    )
    description: str | None = Field(default=None, description="What the scene shows")
    sphere: Sphere
    plate: Plate
    surface: Surface
    rolling: Rolling
    numerics: Numerics = Field(default_factory=Numerics, validate_default=True)
    recovery: Recovery = Field(default_factory=Recovery)
    sound: Sound = Field(default_factory=Sound)
    sweep: Annotated[
        dict[str, tuple[int | float, ...]],
        BeforeValidator(lambda value: _sweep(value)),
        WithJsonSchema({"type": "object"}),  # the keys are filled in by `schema`
    ] = Field(default={}, description="Lists of values by dotted key; their product is run")

    _folder: Path = PrivateAttr(default=Path())

    @field_validator("rolling")
    @classmethod
    def _has_duration(cls, rolling: Rolling, info: ValidationInfo) -> Rolling:
        surface = info.data.get("surface")
        if rolling.duration_s is None and surface is not None and surface.kind != "file":
            words = allowed(Rolling.model_fields["duration_s"])
            raise fault(f"missing, allowed: {words}", "rolling", "duration_s")
        return rolling

    @field_validator("numerics")
    @classmethod
    def _has_track(cls, numerics: Numerics, info: ValidationInfo) -> Numerics:
        surface, rolling = info.data.get("surface"), info.data.get("rolling")
        if isinstance(surface, _Made) and rolling is not None:
            _made_track(surface, rolling, numerics)
        return numerics

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        folder: Path = Path(),
        places: Mapping[Key, str] = MappingProxyType({(): "scene"}),
        faults: Sequence[str] = (),
    ) -> Scene:
        """A scene from plain values as `to_dict` gives them, valid in all combinations of its sweep.

        Parameters
        ----------
        folder : what `surface.path` is relative to.
        places : file and line of each key, for messages; of () at least.
        faults : what was wrong with the data before.

        Raises
        ------
        SceneError : all that is wrong, those faults first.
        """
        data = _without_nothing(data)
        scene, found = _tried(data)
        if not any(key[:1] == ("sweep",) for key, _ in found):
            found += _swept_faults(data, found)
        lines = [f"{place(key, places)}: {cut(dotted(key))}: {message}" for key, message in found]
        if len(lines) > MOST_FAULTS:
            lines[MOST_FAULTS:] = [f"{place((), places)}: more than {MOST_FAULTS} faults, the others are not listed"]
        if faults or lines or scene is None:
            raise SceneError(list(dict.fromkeys([*faults, *lines])))
        scene._folder = folder
        return scene

    def to_dict(self) -> dict[str, Any]:
        """Plain values, every default filled in, what is absent left out; without the folder."""
        data = self.model_dump(exclude_none=True)
        if not self.sweep:
            del data["sweep"]
        return _listed(data)

    @property
    def folder(self) -> Path:
        """Folder that a relative `surface.path` starts from."""
        return self._folder

    @property
    def height_path(self) -> Path | None:
        """File of the heights, None when the surface is made."""
        return self._folder / self.surface.path if isinstance(self.surface, HeightFile) else None

    @property
    def motion(self) -> Motion:
        """Distance and speed over time."""
        return Motion.of(self.rolling.speed_m_s)

    @property
    def radius(self) -> float:
        """Radius of the sphere [m]."""
        return self.sphere.radius_mm * 1e-3

    @property
    def mass(self) -> float:
        """Mass of the sphere [kg], of steel unless the scene gives a density."""
        return (self.sphere.density_kg_m3 or STEEL_DENSITY) * 4 / 3 * math.pi * self.radius**3

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2, the sphere's share zero when it is rigid."""
        compliance = (1 - self.plate.poissons_ratio**2) / self.plate.youngs_modulus_gpa
        if self.sphere.youngs_modulus_gpa is not None and self.sphere.poissons_ratio is not None:
            compliance += (1 - self.sphere.poissons_ratio**2) / self.sphere.youngs_modulus_gpa
        return 1e9 / compliance

    @property
    def hardness(self) -> float:
        """Highest pressure [Pa], infinite when purely elastic."""
        return math.inf if self.plate.hardness_gpa is None else self.plate.hardness_gpa * 1e9

    @property
    def spacing(self) -> float:
        """Node spacing [m]."""
        return self.surface.spacing_um * 1e-6

    @property
    def step(self) -> float:
        """Distance from one position to the next [m]."""
        return self.spacing * self.numerics.step_nodes

    @property
    def load(self) -> float:
        """Normal load [N]."""
        return self.rolling.load_n

    @property
    def start(self) -> float:
        """First position along the track [m]."""
        return self.rolling.start_um * 1e-6


# ---- the track -------------------------------------------------------------------------------------------------------


def track(scene: Scene) -> Track:
    """The track of a scene: as long as the sphere rolls when the surface is made, round the file when it is read.

    A made track is rounded to whole nodes and whole steps, so it closes on itself. Of a file only the header is read.

    Raises
    ------
    SceneError : the height file is missing or is no 2-D array of numbers, or the sphere never gets round it.
    """
    surface, rolling = scene.surface, scene.rolling
    if not isinstance(surface, HeightFile):
        return _made_track(surface, rolling, scene.numerics)
    path, step_nodes = scene.folder / surface.path, scene.numerics.step_nodes
    try:
        return file_track(path, surface.path, scene.spacing, step_nodes, scene.motion, rolling.duration_s)
    except PydanticCustomError as error:
        context = error.context or {}
        raise SceneError([f"{dotted(context['at'])}: {context['message']}"]) from error


def _made_track(surface: _Made, rolling: Rolling, numerics: Numerics) -> Track:
    assert rolling.duration_s is not None  # refused before
    spacing, motion = surface.spacing_um * 1e-6, Motion.of(rolling.speed_m_s)
    return made_track(surface.n_across, spacing, numerics.step_nodes, motion, rolling.duration_s)


# ---- the sweep -------------------------------------------------------------------------------------------------------


def expand(scene: Scene) -> list[tuple[dict[str, float], Scene]]:
    """Every run of a scene: the swept values by dotted key and the scene with them, without sweep; last key fastest."""
    if not scene.sweep:
        return [({}, scene)]
    data = scene.to_dict()
    del data["sweep"]
    return [(values, Scene.from_dict(_with(data, values), scene.folder)) for values in _product(scene.sweep)]


def _sweep(value: Any) -> Any:
    """The sweep's lists as tuples; raises its first fault at its own place."""
    if not isinstance(value, dict):
        raise fault(
            f"got {shown(value)}, allowed: lists of numbers by dotted key, as in rolling.load_n: [5, 20]", "sweep"
        )
    keys = numeric_keys(Scene)
    for name, values in value.items():
        if name not in keys:
            known = name in all_keys(Scene)
            raise fault(
                "cannot be swept, only numbers can" if known else f"unknown key{nearest(name, keys)}",
                "sweep",
                name,
            )
        if not isinstance(values, list | tuple) or not values:
            raise fault(f"got {shown(values)}, allowed: a list of numbers, at least one", "sweep", name)
    runs = math.prod(len(values) for values in value.values())
    if runs > MAX_RUNS:  # before any of them is looked at
        raise fault(f"got {runs} runs, allowed: at most {MAX_RUNS}", "sweep")
    for name, values in value.items():
        before: set[float] = set()
        for i, number in enumerate(values):
            if not is_number(number):
                raise fault(f"got {shown(number)}, allowed: a number", "sweep", name, i)
            if number in before:
                raise fault(f"got {shown(number)} twice, allowed: different values", "sweep", name, i)
            before.add(number)
    return {name: tuple(values) for name, values in value.items()}


def _product(sweep: Mapping[str, Sequence[float]]) -> Iterator[dict[str, float]]:
    for values in itertools.product(*sweep.values()):
        yield dict(zip(sweep, values, strict=True))


def _with(data: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """The data with values put in by dotted key."""
    result = dict(data)
    for name, value in values.items():
        section, _, last = name.partition(".")
        if isinstance(result.get(section, {}), dict):
            result[section] = {**result.get(section, {}), last: value}
    return result


def _swept_faults(data: Mapping[str, Any], found: Sequence[Fault]) -> list[Fault]:
    """Faults of the runs of a sweep; of those without a swept value only the ones that are not found yet."""
    unswept = {name: value for name, value in data.items() if name != "sweep"}
    sweep = {name: tuple(values) for name, values in data.get("sweep", {}).items()}
    places = {name: {value: i for i, value in enumerate(values)} for name, values in sweep.items()}
    known, named = {key for key, _ in found}, set[Fault]()
    in_words: dict[Any, Fault] = {}  # many runs share a fault, and its words take longer than to find it
    more: list[Fault] = []
    for values in _product(sweep) if sweep else ():
        swept = _with(unswept, values)
        for error in _errors(swept):
            alike = (error["loc"], error["type"], error["msg"], shown(_plain_input(error)))
            if alike not in in_words:
                in_words[alike] = explained(error, swept, Scene)
            key, message = in_words[alike]
            name = dotted(key)
            if name in values:
                swept_fault = ("sweep", name, places[name][values[name]]), message
                if swept_fault not in named:
                    named.add(swept_fault)
                    more.append(swept_fault)
            elif key not in known:
                known.add(key)
                more.append((key, f"{message} (in the run {run_name(values)} of the sweep)"))
        if len(more) > MOST_FAULTS:
            break
    return more


def _plain_input(error: Any) -> Any:
    """The value that a fault is about, None where that is a whole section."""
    return error["input"] if isinstance(error["input"], bool | int | float | str) else None


def _tried(data: Mapping[str, Any]) -> tuple[Scene | None, list[Fault]]:
    try:
        return Scene.model_validate(data), []
    except ValidationError as error:
        return None, [explained(one, data, Scene) for one in _listed_errors(error)]


def _errors(data: Mapping[str, Any]) -> list[Any]:
    """Faults of a scene, not yet in words."""
    try:
        Scene.model_validate(data)
    except ValidationError as error:
        return _listed_errors(error)
    return []


def _listed_errors(error: ValidationError) -> list[Any]:
    return error.errors(include_url=False)[: MOST_FAULTS + 1]


def _without_nothing(data: Any) -> Any:
    """A key without a value is a key not given, at any depth."""
    if isinstance(data, Mapping):
        return {name: _without_nothing(value) for name, value in data.items() if value is not None}
    return data


def _listed(value: Any) -> Any:
    """Tuples as lists, whole floats as they are."""
    if isinstance(value, dict):
        return {name: _listed(item) for name, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, list | tuple) else value
