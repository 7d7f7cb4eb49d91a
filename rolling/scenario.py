"""What a scene can say: frozen models, units in the key names, all checks and their messages. Depends on `motion` only.

Outside (YAML, overrides) lengths are in mm or um and moduli in GPa; the properties of `Scene` and `Track` are SI.
"""

from __future__ import annotations

import difflib
import io
import itertools
import json
import math
import types
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin

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
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq, TaggedScalar
from ruamel.yaml.constructor import DuplicateKeyError
from ruamel.yaml.error import YAMLError

from rolling.motion import ROUNDING, Motion

Key = tuple[str | int, ...]  # where a value stands: ("rolling", "load_n"), ("sweep", "rolling.load_n", 0)

MIN_NODES = 8  # along and across
MAX_NODES = 10**9  # along the track, and steps: whatever is longer is a slip of the unit
SMALLEST = 1e-15  # of any number but zero, in the units of the scene; one over it is the largest
MAX_RUNS = 10_000  # of a sweep
MAX_NESTING = 4  # of values in a scene; aliases of aliases could otherwise grow without end
STEP_NODES = [1 / k for k in range(16, 1, -1)] + [float(k) for k in range(1, 65)]


class SceneError(Exception):
    """All that is wrong with a scene: `faults`, one line each, with file and line (or --set), key, got and allowed."""

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = list(faults)

    def __reduce__(self) -> tuple[type[SceneError], tuple[list[str]]]:
        return SceneError, (self.faults,)


def _fault(message: str, *at: str | int) -> PydanticCustomError:
    """A fault for pydantic to collect; `at` is the key it belongs to when that is not the one being validated."""
    return PydanticCustomError("fault", "{message}", {"message": message, "at": at})


# ---- the models ------------------------------------------------------------------------------------------------------


def _speed(value: Any) -> Any:
    """A number, or pairs as tuples; raises the first fault of the pairs at its own place."""
    at = ("rolling", "speed_m_s")
    allowed = "allowed: a number > 0, or at least two [time_s, speed_m_s] pairs"
    if _is_number(value) and value > 0:
        return float(value)
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise _fault(f"got {_shown(value)}, {allowed}", *at)
    for i, pair in enumerate(value):
        if not isinstance(pair, list | tuple) or len(pair) != 2 or not all(_is_number(x) for x in pair):
            raise _fault(f"got {_shown(pair)}, allowed: [time_s, speed_m_s], two numbers", *at, i)
        if i == 0 and pair[0] != 0:
            raise _fault(f"got {_shown(pair[0])}, allowed: 0, the time of the first pair", *at, 0)
        if i and pair[0] <= value[i - 1][0]:
            raise _fault(
                f"got time {_shown(pair[0])} after {_shown(value[i - 1][0])}, allowed: increasing times", *at, i
            )
        if pair[1] < 0:
            raise _fault(f"got speed {_shown(pair[1])}, allowed: a number >= 0", *at, i)
    if not any(v > 0 for _, v in value):
        raise _fault("got speeds that are all 0, allowed: at least one > 0", *at)
    return tuple((float(t), float(v)) for t, v in value)


def _step_nodes(value: float) -> float:
    """The allowed value that is meant: 0.333333 is a third."""
    nearest = min(STEP_NODES, key=lambda allowed: abs(math.log(value / allowed)))
    if abs(value / nearest - 1) > 1e-5:
        raise _fault(
            f"got {_plain_number(value)}, allowed: a whole number from 1 to 64, or one over a whole number down to 1/16;"
            f" nearest: {_plain_number(nearest)}"
        )
    return nearest


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @field_validator("*")
    @classmethod
    def _within_reason(cls, value: Any) -> Any:
        """Sizes whose powers and quotients are still numbers."""
        for number in np.ravel(value) if isinstance(value, float | tuple) else ():
            if number and not SMALLEST <= abs(number) <= 1 / SMALLEST:
                raise _fault(f"got {_shown(float(number))}, allowed: a size from {SMALLEST:g} to {1 / SMALLEST:g}")
        return value


class Sphere(_Section):
    """The rolling sphere: rigid unless it has a modulus."""

    radius_mm: float = Field(gt=0, description="Radius [mm]")
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
                raise _fault(
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
            raise _fault(
                f"got {_plain_number(self.width_um)}, allowed: less than {MAX_NODES:g} nodes", "surface", "width_um"
            )
        if round(nodes) < MIN_NODES or abs(nodes - round(nodes)) > 1e-6 * nodes:
            nearest = max(MIN_NODES, round(nodes)) * self.spacing_um
            raise _fault(
                f"got {_plain_number(self.width_um)}, allowed: a whole number of nodes of {self.spacing_um:g} um, at least"
                f" {MIN_NODES}; nearest: {nearest:.10g}",
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
    """Measured or made heights, periodic."""

    kind: Literal["file"] = Field(description="Heights from a file; the track is the file")
    path: str = Field(
        min_length=1, description=".npy file of heights [m], shape (along track, across), relative to the scene file"
    )
    spacing_um: float = Field(gt=0, description="Node spacing [um], along and across")


Surface = Annotated[Gaussian | Smooth | HeightFile, Field(discriminator="kind")]
SURFACES: dict[str, type[_Section]] = {"gaussian": Gaussian, "smooth": Smooth, "file": HeightFile}


class Rolling(_Section):
    """How the sphere rolls."""

    load_n: float = Field(gt=0, description="Normal load [N], constant")
    speed_m_s: Annotated[
        float | tuple[tuple[float, float], ...],
        BeforeValidator(_speed),
        WithJsonSchema(
            {
                "anyOf": [
                    {"type": "number", "exclusiveMinimum": 0},
                    {
                        "type": "array",
                        "minItems": 2,
                        "items": {
                            "type": "array",
                            "prefixItems": [{"type": "number", "minimum": 0}, {"type": "number", "minimum": 0}],
                            "minItems": 2,
                            "maxItems": 2,
                        },
                    },
                ]
            }
        ),
    ] = Field(
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


class Scene(_Section):
    """A scene. Equal scenes say the same; the folder they were read from does not count."""

    name: str = Field(
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
            allowed = _allowed(Rolling.model_fields["duration_s"])
            raise _fault(f"missing, allowed: {allowed}", "rolling", "duration_s")
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
    def from_dict(cls, data: Mapping[str, Any], folder: Path = Path()) -> Scene:
        """A scene from plain values as `to_dict` gives them; raises SceneError with the keys but no lines."""
        return _validated(dict(data), {(): "scene"}, folder)

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


@dataclass(frozen=True)
class Track:
    """Where the sphere goes.

    n_along, n_across : nodes of the surface.  steps : positions less one.  step, spacing : [m].
    lap_steps : steps after which the positions repeat.  closed : the last position is the first one again.
    """

    n_along: int
    n_across: int
    steps: int
    step: float
    spacing: float
    closed: bool
    lap_steps: int

    @property
    def distance(self) -> float:
        """Distance rolled [m]."""
        return self.steps * self.step


def track(scene: Scene) -> Track:
    """The track of a scene: as long as the sphere rolls when the surface is made, round the file when it is read.

    A made track is rounded to whole nodes and whole steps, so it closes on itself. Of a file only the header is read.

    Raises
    ------
    SceneError : the height file is missing or is no 2-D array of numbers, or the sphere never gets round it.
    """
    if isinstance(scene.surface, HeightFile):
        return _file_track(scene)
    return _made_track(scene.surface, scene.rolling, scene.numerics)


def _made_track(surface: _Made, rolling: Rolling, numerics: Numerics) -> Track:
    assert rolling.duration_s is not None  # refused before
    at = ("rolling", "duration_s")
    motion, spacing = Motion.of(rolling.speed_m_s), surface.spacing_um * 1e-6
    step_nodes = _fraction(numerics)
    # The track is counted in the larger of step and node; the smaller then fits in whole numbers.
    unit_nodes = max(1, math.ceil(step_nodes))
    unit = unit_nodes * spacing
    distance = float(motion.distance(rolling.duration_s))
    if not distance / min(unit, spacing * float(step_nodes)) < MAX_NODES:
        raise _fault(f"got {_plain_number(rolling.duration_s)}, which is more than {MAX_NODES:g} nodes or steps", *at)
    units = round(distance / unit)
    if units * unit > motion.final_distance * (1 + ROUNDING):  # a sphere that stops must not be asked for more
        units -= 1
    least = math.ceil(MIN_NODES / unit_nodes)
    if units < least:
        needed = least * unit
        if needed > motion.final_distance * (1 + ROUNDING):
            raise _fault(
                f"the sphere comes to rest after {motion.final_distance * 1e6:.4g} um, the shortest track is"
                f" {needed * 1e6:.4g} um: give it more speed",
                "rolling",
                "speed_m_s",
            )
        raise _fault(
            f"got {_plain_number(rolling.duration_s)}, in which the sphere rolls {distance * 1e6:.4g} um; the shortest track"
            f" is {least * unit_nodes} nodes, {needed * 1e6:.4g} um: at least {motion.duration(needed):.4g}",
            *at,
        )
    n_along = units * unit_nodes
    steps = int(n_along / step_nodes)
    return Track(n_along, surface.n_across, steps, spacing * float(step_nodes), spacing, True, steps)


def _file_track(scene: Scene) -> Track:
    n_along, n_across = _file_shape(scene)
    step_nodes = _fraction(scene.numerics)
    lap = n_along * scene.spacing
    duration, motion = scene.rolling.duration_s, scene.motion
    if duration is None and motion.final_distance * (1 + ROUNDING) < lap:
        raise SceneError(
            [
                f"rolling.speed_m_s: the sphere comes to rest after {motion.final_distance:.4g} m, once round the height"
                f" file is {lap:.4g} m: give it more speed or set rolling.duration_s"
            ]
        )
    distance = lap if duration is None else float(motion.distance(duration))
    if not distance / scene.step < MAX_NODES:
        raise SceneError([f"rolling.duration_s: the sphere rolls {distance:.4g} m, more than {MAX_NODES:g} steps"])
    steps = round(distance / scene.step)
    if steps * scene.step > motion.final_distance * (1 + ROUNDING):
        steps -= 1
    steps = max(1, steps)
    nodes_round = n_along * step_nodes.denominator
    lap_steps = nodes_round // math.gcd(step_nodes.numerator, nodes_round)
    return Track(n_along, n_across, steps, scene.step, scene.spacing, steps % lap_steps == 0, lap_steps)


def _file_shape(scene: Scene) -> tuple[int, int]:
    """Shape of the height file, from its header."""
    path, said = scene.height_path, f"surface.path: {scene.surface.path}"  # type: ignore[union-attr]
    assert path is not None
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "no such file"
        raise SceneError([f"{said}: {what} (looked in {path.parent.absolute()})"])
    try:
        stored = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise SceneError([f"{said}: no readable .npy file ({_first_line(error)})"]) from error
    if not isinstance(stored, np.ndarray) or stored.ndim != 2 or stored.dtype.kind not in "fiu":
        got = f"{stored.ndim}-D {stored.dtype}" if isinstance(stored, np.ndarray) else "an archive"
        raise SceneError([f"{said}: got {got}, allowed: one 2-D array of real heights in m, (along track, across)"])
    if min(stored.shape) < MIN_NODES:
        raise SceneError(
            [f"{said}: got {stored.shape[0]} x {stored.shape[1]} nodes, allowed: at least {MIN_NODES} each way"]
        )
    return int(stored.shape[0]), int(stored.shape[1])


def _fraction(numerics: Numerics) -> Fraction:
    return Fraction(numerics.step_nodes).limit_denominator(16)


# ---- reading, writing, overriding ------------------------------------------------------------------------------------


def load(path: Path | str, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene file.

    Parameters
    ----------
    path : YAML 1.2 in UTF-8.
    overrides : "rolling.load_n=50" each, the value in YAML. Nothing (or null) takes an optional key or section out.
        A key that the scene sweeps leaves the sweep when it is set; "sweep.rolling.load_n=[5, 20]" sweeps it.

    Raises
    ------
    SceneError : all faults of file and overrides.
    """
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise SceneError([f"{path}:{line}: not UTF-8 text (byte {error.object[error.start]:#04x})"]) from error
    except FileNotFoundError as error:
        raise SceneError([f"{path}: no such file"]) from error
    except IsADirectoryError as error:
        raise SceneError([f"{path}: is a folder, a scene file is needed"]) from error
    except OSError as error:
        raise SceneError([f"{path}: not readable ({error.strerror})"]) from error
    return loads(text, overrides, str(path), path.parent)


def loads(text: str, overrides: Sequence[str] = (), where: str = "scene", folder: Path = Path()) -> Scene:
    """Read a scene from text; `where` names it in messages, `folder` is what `surface.path` is relative to."""
    data, lines = _read(text, where)
    if data is None:
        raise SceneError([f"{where}: empty, a scene needs at least {', '.join(_required(Scene))}"])
    if not isinstance(data, dict):
        raise SceneError([f"{where}:1: got {_shown(data)}, allowed: a scene of keys and values, the first being name"])
    places = {key: f"{where}:{line}" for key, line in lines.items()}
    return _validated(data, places, folder, _override(data, places, overrides))


def dump(scene: Scene) -> str:
    """The scene as YAML text with every default filled in; `loads` gives an equal scene back."""
    yaml = YAML(typ="rt")
    yaml.width = 4096
    stream = io.StringIO()
    yaml.dump(_flowing(scene.to_dict()), stream)
    return stream.getvalue()


def _read(text: str, where: str) -> tuple[Any, dict[Key, int]]:
    """Plain values and the line of every key."""
    lines: dict[Key, int] = {(): 1}

    def plain(value: Any, key: Key) -> Any:
        if len(key) > MAX_NESTING:
            raise SceneError(
                [f"{where}:{lines[()] if key not in lines else lines[key]}: {_dotted(key)}: nested too deeply"]
            )
        if isinstance(value, CommentedMap):
            for name in value:
                place = (value.lc.data or {}).get(name)  # none for what a merge brought in
                lines[(*key, str(name))] = place[0] + 1 if place else lines[key]
            return {str(name): plain(item, (*key, str(name))) for name, item in value.items()}
        if isinstance(value, CommentedSeq):
            for i in range(len(value)):
                place = (value.lc.data or {}).get(i)
                lines[(*key, i)] = place[0] + 1 if place else lines[key]
            return [plain(item, (*key, i)) for i, item in enumerate(value)]
        if isinstance(value, TaggedScalar):
            raise SceneError(
                [f"{where}:{lines[key]}: {_dotted(key)}: got the tag {value.tag.value}, allowed: plain values"]
            )
        # ruamel keeps how a number was written; bool before int, whose child it is.
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        return value

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of anchors given twice, which YAML 1.2 allows
            return plain(YAML(typ="rt").load(text), ()), lines
    except DuplicateKeyError as error:
        section, second = error.context_mark, error.problem_mark
        name = second.buffer[second.pointer :].split(":")[0].strip() if second.buffer else "key"
        raise SceneError(
            [f"{where}:{second.line + 1}: {name}: given twice in the section that begins in line {section.line + 1}"]
        ) from error
    except YAMLError as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        place = f"{where}:{mark.line + 1}" if mark else where
        problem = getattr(error, "problem", None) or getattr(error, "reason", None) or _first_line(error)
        raise SceneError([f"{place}: not YAML: {problem.replace('<stream end>', 'the end')}"]) from error
    except (ValueError, RecursionError, NotImplementedError) as error:
        raise SceneError([f"{where}: not YAML: {_first_line(error)}"]) from error


def _override(data: dict[str, Any], places: dict[Key, str], overrides: Sequence[str]) -> list[str]:
    """Put overrides into `data` and `places`; the faults of those that cannot be."""
    faults = []
    for override in overrides:
        dotted, equals, text = override.partition("=")
        dotted = dotted.strip()
        known = _all_keys()
        if not equals or not dotted:
            faults.append(f"--set: got {_shown(override)}, allowed: key=value, as in rolling.load_n=50")
            continue
        if dotted not in known:
            section = dotted.rpartition(".")[0] + "."
            siblings = [other for other in known if other.startswith(section) and section != "sweep."]
            allowed = f", allowed: {', '.join(other.removeprefix(section) for other in siblings)}" if siblings else ""
            faults.append(f"--set: {dotted}: unknown key{_nearest(dotted, siblings or known)}{allowed}")
            continue
        try:
            value, _ = _read(text, "--set")
        except SceneError as error:
            faults += [
                f"--set: {dotted}: {fault.removeprefix('--set:').lstrip('1234567890: ')}" for fault in error.faults
            ]
            continue
        key = _split(dotted)
        inside = data
        for depth, part in enumerate(key[:-1]):
            if inside.get(part) is None:
                inside[part] = {}
                places[key[: depth + 1]] = "--set"
            inside = inside[part]
            if not isinstance(inside, dict):
                break  # the file has something else where a section must be, and is told so
        else:
            inside[key[-1]] = value
            for old in [old for old in places if old[: len(key)] == key]:
                del places[old]
            places[key] = "--set"
            sweep = data.get("sweep")
            if isinstance(sweep, dict) and key[0] != "sweep":
                sweep.pop(dotted, None)
    return faults


def _validated(data: dict[str, Any], places: dict[Key, str], folder: Path, faults: Sequence[str] = ()) -> Scene:
    """The scene of the data, all its combinations valid; or all faults."""
    data = _without_nothing(data)
    scene, found = _tried(data)
    unswept = {name: value for name, value in data.items() if name != "sweep"}
    sweep_is_sound = not any(key[:1] == ("sweep",) for key, _ in found)
    if sweep_is_sound and data.get("sweep"):
        sweep = {name: tuple(values) for name, values in data["sweep"].items()}
        for values in _product(sweep):
            for key, message in _tried(_with(unswept, values))[1]:
                dotted = _dotted(key)
                if dotted in values:
                    key = ("sweep", dotted, sweep[dotted].index(values[dotted]))
                    found.append((key, message))
                elif (key, message) not in found and all(key != other for other, _ in found):
                    found.append((key, f"{message} (in the run {run_name(values)} of the sweep)"))
    lines = list(faults) + [
        f"{_place(key, places)}: {_dotted(key)}: {message}" for key, message in dict.fromkeys(found)
    ]
    if lines or scene is None:
        raise SceneError(list(dict.fromkeys(lines)))
    scene._folder = folder
    return scene


def _tried(data: dict[str, Any]) -> tuple[Scene | None, list[tuple[Key, str]]]:
    try:
        return Scene.model_validate(data), []
    except ValidationError as error:
        return None, [_explained(fault, data) for fault in error.errors(include_url=False)]


def _explained(error: Any, data: dict[str, Any]) -> tuple[Key, str]:
    """Key and message of one pydantic fault."""
    key: Key = error["loc"]
    if key[0] == "surface" and len(key) > 1:  # pydantic names the kind of surface in between
        key = ("surface", *key[2:])
    kind = error["type"]
    if kind == "fault":
        return error["ctx"]["at"] or key, error["ctx"]["message"]
    if kind.startswith("union_tag"):
        key = ("surface", "kind")
    value = _value(data, key)
    if kind == "extra_forbidden":
        name, siblings = str(key[-1]), _siblings(key[:-1], data)
        known = [other for other in _all_keys() if not other.startswith("sweep.")]
        elsewhere = [] if _dotted(key) in known else known  # a key of another kind of surface is no slip
        of = f" of kind {_value(data, ('surface', 'kind'))}" if key[0] == "surface" else ""
        return key, f"unknown key{of}{_nearest(name, siblings, elsewhere)}, allowed: {', '.join(siblings)}"
    field = _field(key, data)
    allowed = _allowed(field) if field else "a section of keys (kind, ...)"
    if kind in ("missing", "union_tag_not_found") and value is None:
        return key, f"missing, allowed: {allowed}"
    choices = [str(c) for c in _choices(field)] if field else []
    return key, f"got {_shown(value)}, allowed: {allowed}{_nearest(value, choices) if isinstance(value, str) else ''}"


# ---- the sweep -------------------------------------------------------------------------------------------------------


def expand(scene: Scene) -> list[tuple[dict[str, float], Scene]]:
    """Every run of a scene: the swept values by dotted key and the scene with them, without sweep; last key fastest."""
    if not scene.sweep:
        return [({}, scene)]
    data = scene.to_dict()
    del data["sweep"]
    return [(values, Scene.from_dict(_with(data, values), scene.folder)) for values in _product(scene.sweep)]


def run_name(values: Mapping[str, float]) -> str:
    """Name of a run: "load_n=5,radius_mm=2", each key by its last part unless two share it; empty for no values."""
    last = [dotted.rpartition(".")[2] for dotted in values]
    return ",".join(
        f"{short if last.count(short) == 1 else dotted}={_plain_number(value)}"
        for short, (dotted, value) in zip(last, values.items(), strict=True)
    )


def _sweep(value: Any) -> Any:
    """The sweep's lists as tuples; raises its first fault at its own place."""
    if not isinstance(value, dict):
        raise _fault(
            f"got {_shown(value)}, allowed: lists of numbers by dotted key, as in rolling.load_n: [5, 20]", "sweep"
        )
    keys = _numeric_keys()
    for dotted, values in value.items():
        if dotted not in keys:
            known = dotted in _all_keys()
            raise _fault(
                "cannot be swept, only numbers can" if known else f"unknown key{_nearest(dotted, keys)}",
                "sweep",
                dotted,
            )
        if not isinstance(values, list | tuple) or not values:
            raise _fault(f"got {_shown(values)}, allowed: a list of numbers, at least one", "sweep", dotted)
        for i, number in enumerate(values):
            if not _is_number(number):
                raise _fault(f"got {_shown(number)}, allowed: a number", "sweep", dotted, i)
            if number in values[:i]:
                raise _fault(f"got {_shown(number)} twice, allowed: different values", "sweep", dotted, i)
    runs = math.prod(len(values) for values in value.values())
    if runs > MAX_RUNS:
        raise _fault(f"got {runs} runs, allowed: at most {MAX_RUNS}", "sweep")
    return {dotted: tuple(values) for dotted, values in value.items()}


def _product(sweep: Mapping[str, Sequence[float]]) -> Iterator[dict[str, float]]:
    for values in itertools.product(*sweep.values()):
        yield dict(zip(sweep, values, strict=True))


def _with(data: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """The data with values put in by dotted key."""
    result = dict(data)
    for dotted, value in values.items():
        section, _, name = dotted.partition(".")
        if isinstance(result.get(section, {}), dict):
            result[section] = {**result.get(section, {}), name: value}
    return result


# ---- new sound from a stored run -------------------------------------------------------------------------------------


RESOUND_KEYS = ("rolling.speed_m_s", *(f"sound.{name}" for name in Sound.model_fields))


def resound(scene: Scene, overrides: Sequence[str]) -> Scene:
    """The scene of a stored run with another speed or sound; track and contact stay as they are.

    `duration_s`, where the scene has one, becomes the time the same track takes.

    Raises
    ------
    SceneError : keys that need a new solve, values that are not allowed, a speed that ends before the track does.
    """
    known = {override: override.partition("=")[0].strip() for override in overrides}
    solved = [override for override in overrides if known[override] in set(_all_keys()) - {*RESOUND_KEYS, "sound"}]
    faults = [
        f"--set: {known[override]}: needs a new run; without solving again allowed: {', '.join(RESOUND_KEYS)}"
        for override in solved
    ]
    data = scene.to_dict()
    places: dict[Key, str] = {(): "stored scene"}
    faults += _override(data, places, [override for override in overrides if override not in solved])
    if not faults and scene.rolling.duration_s is not None and data["rolling"].get("speed_m_s") is not None:
        try:
            motion = Motion.of(_speed(data["rolling"]["speed_m_s"]))
        except PydanticCustomError:
            pass  # validation tells
        else:
            distance = (
                track(scene).distance
                if isinstance(scene.surface, _Made)
                else scene.motion.distance(scene.rolling.duration_s)
            )
            try:
                data["rolling"]["duration_s"] = float(f"{motion.duration(float(distance)):.12g}")
            except ValueError as error:
                faults.append(f"--set: rolling.speed_m_s: {error}, the end of the stored run")
    return _validated(data, places, scene.folder, faults)


# ---- keys and wording ------------------------------------------------------------------------------------------------


def schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of a scene file, for editors."""
    result = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scene.model_json_schema()}
    result["title"] = "Scene of rolling contact noise"
    numbers = {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"type": "number"}}
    sweep = result["properties"]["sweep"]
    sweep["properties"] = {
        dotted: {**numbers, "description": f"Values of {dotted}: {field.description}"}
        for dotted, field in _numeric_keys().items()
    }
    sweep["additionalProperties"] = False
    return result


def _sections() -> Iterator[tuple[str, type[BaseModel]]]:
    """Every section with its model, surface once per kind."""
    for name, field in Scene.model_fields.items():
        if name == "surface":
            yield from ((name, model) for model in SURFACES.values())
        elif isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield name, field.annotation


def _numeric_keys() -> dict[str, FieldInfo]:
    """Every key that holds a number, by its dotted name."""
    return {
        f"{section}.{name}": field
        for section, model in _sections()
        for name, field in model.model_fields.items()
        if {int, float} & set(_kinds(field.annotation))
    }


def _all_keys() -> list[str]:
    """Every name that an override can set, sections and swept keys included."""
    inner = [f"{section}.{name}" for section, model in _sections() for name in model.model_fields]
    return list(dict.fromkeys([*Scene.model_fields, *inner, *(f"sweep.{key}" for key in _numeric_keys())]))


def _kinds(annotation: Any) -> tuple[Any, ...]:
    """What a field may hold: the types of an annotation without None and Annotated."""
    if get_origin(annotation) is Annotated:
        return _kinds(get_args(annotation)[0])
    if get_origin(annotation) in (Union, types.UnionType):
        return tuple(kind for part in get_args(annotation) for kind in _kinds(part) if kind is not type(None))
    return (annotation,)


def _choices(field: FieldInfo) -> tuple[Any, ...]:
    """The names a field chooses from; none when it holds something else."""
    if field is Scene.model_fields["surface"]:
        return tuple(SURFACES)
    return tuple(
        choice for kind in _kinds(field.annotation) if get_origin(kind) is Literal for choice in get_args(kind)
    )


def _allowed(field: FieldInfo) -> str:
    """What a field may hold, in words."""
    if choices := _choices(field):
        return " or ".join(filter(None, [", ".join(map(str, choices[:-1])), str(choices[-1])]))
    kinds = _kinds(field.annotation)
    if any(get_origin(kind) is tuple for kind in kinds):
        return "a number > 0, or at least two [time_s, speed_m_s] pairs"
    if field is Scene.model_fields["name"]:
        return "1 to 64 letters, digits, dots, dashes or underscores, a letter or digit first (numbers in quotes)"
    if kinds[0] in (int, float):
        signs: list[tuple[str, str]] = [("gt", ">"), ("ge", ">="), ("lt", "<"), ("le", "<=")]
        bounds = [f"{sign} {getattr(m, name):g}" for name, sign in signs for m in field.metadata if hasattr(m, name)]
        return " ".join(["a whole number" if kinds[0] is int else "a number", " and ".join(bounds)]).strip()
    if isinstance(kinds[0], type) and issubclass(kinds[0], BaseModel):
        return f"a section of keys ({', '.join(_required(kinds[0]) or kinds[0].model_fields)})"
    return "true or false" if kinds[0] is bool else "text"


def _field(key: Key, data: Mapping[str, Any]) -> FieldInfo | None:
    model: Any = Scene
    field = None
    for part in key:
        if not isinstance(model, type) or not issubclass(model, BaseModel) or part not in model.model_fields:
            return field
        field = model.model_fields[str(part)]
        model = _surface_model(data) if part == "surface" else _kinds(field.annotation)[0]
        if key == ("surface", "kind"):
            return Scene.model_fields["surface"]
    return None if key == ("surface",) else field


def _surface_model(data: Mapping[str, Any]) -> type[BaseModel]:
    surface = data.get("surface")
    kind = surface.get("kind") if isinstance(surface, Mapping) else None
    return SURFACES.get(kind, Gaussian) if isinstance(kind, str) else Gaussian


def _siblings(section: Key, data: Mapping[str, Any]) -> list[str]:
    """The names a section knows, the required ones first as they stand in the model."""
    if not section:
        return list(Scene.model_fields)
    model = _surface_model(data) if section == ("surface",) else dict(_sections())[str(section[0])]
    return list(model.model_fields)


def _required(model: type[BaseModel]) -> list[str]:
    return [name for name, field in model.model_fields.items() if field.is_required()]


def _nearest(got: str, *families: Sequence[str] | Mapping[str, Any]) -> str:
    """ ", nearest: name" from the first family that has a name like it; nothing when none has.

    Names are compared by their last part, or as a whole when the section is misspelt as well; the unit may be missing.
    """

    def norm(name: str) -> str:
        return name.lower().replace("-", "_").replace(" ", "_")

    def alike(name: str) -> float:
        one, two = norm(got), norm(name)
        (section, _, last), (its_section, _, its_last) = one.rpartition("."), two.rpartition(".")
        if its_last.startswith(f"{last}_"):
            near = 0.95
        else:
            pairs = [(last, its_last)] if section == its_section else [(last, its_last), (one, two)]
            near = max(difflib.SequenceMatcher(None, *pair).ratio() for pair in pairs)
        return near

    for names in families:
        best = max(names, key=alike, default="")
        if best and alike(best) >= 0.6:
            return f", nearest: {best}"
    return ""


def _split(dotted: str) -> tuple[str, ...]:
    """The key of a dotted name; what follows "sweep." is one name."""
    first, dot, rest = dotted.partition(".")
    return (first, rest) if dot else (first,)


def _dotted(key: Key) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key).removeprefix(".")


def _place(key: Key, places: Mapping[Key, str]) -> str:
    """File and line (or --set) of a key, or of the nearest section around it that stands somewhere."""
    return next(places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places)


def _value(data: Any, key: Key) -> Any:
    for part in key:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -1e300 < value < 1e300


def _plain_number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _shown(value: Any) -> str:
    """A value as the user wrote it, or nearly: text in quotes, so that "20" is seen to be text."""
    if value is None:
        return "nothing"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' * (value < 0)}.inf"
    text = json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


def _without_nothing(data: Any) -> Any:
    """A key without a value is a key not given, at any depth."""
    if isinstance(data, dict):
        return {name: _without_nothing(value) for name, value in data.items() if value is not None}
    return data


def _listed(value: Any) -> Any:
    """Tuples as lists, whole floats as they are."""
    if isinstance(value, dict):
        return {name: _listed(item) for name, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, list | tuple) else value


def _flowing(value: Any) -> Any:
    """Lists that YAML writes on one line."""
    if isinstance(value, dict):
        return {name: _flowing(item) for name, item in value.items()}
    if isinstance(value, list):
        line = CommentedSeq(_flowing(item) for item in value)
        line.fa.set_flow_style()
        return line
    return value
