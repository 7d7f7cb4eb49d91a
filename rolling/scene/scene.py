"""Scene: its sections, its sweep, and its quantities in SI.

`Scene` is built from sections in Python, or from the plain values of a scene file, which `file`
reads and writes. It is frozen, and `with_` gives a changed copy.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, NamedTuple, Self

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)
from pydantic_core import PydanticCustomError

from acoustics.numbers import rounded
from rolling.scene import messages
from rolling.scene import sweep as sweeps
from rolling.scene.messages import Key, SceneError, fault
from rolling.scene.motion import Motion
from rolling.scene.sections import (
    MAX_FAULTS,
    Dynamics,
    Numerics,
    Plate,
    Recovery,
    Rolling,
    Section,
    Sound,
    Sphere,
    plain,
    refuse_free_factors,
)
from rolling.scene.surfaces import Gaussian, HeightFile, MadeSurface, Surface
from rolling.scene.track import Track, file_track, height_nodes, made_track, rolled

STEEL_DENSITY = 7850.0  # [kg/m3]

# Rule of `numerics.tolerance: auto`. The solver's error of the release over its fluctuation is
# proportional to tolerance times deflection over roughness: a violation of the gap by that length
# shows in a fluctuation that the roughness makes. At TOLERANCE it is -49 dB or less in all of 23
# scenes (Ra 0.001 to 1 um, 0.3 to 100 N, elastic and yielding) whose roughness is a tenth of the
# deflection or more, and rises to -22 dB, above the grid's error, on smoother surfaces. With the
# rule it is -48.7 dB or less in all, and 20 dB or more below the grid's unless that is below -40.
TOLERANCE, LEAST_TOLERANCE = 1e-4, 1e-6
SMOOTH = 0.1  # rms roughness over Hertz deflection, below which the tolerance falls
FILE_TOLERANCE = 2e-5  # for a height file, whose roughness the scene does not know
EDGE_RADII = 10  # contact radii from the contact to the nearest edge of the plate, at least
MOST_MODES = 20_000  # of a plate with edges; a second of sound takes them half a minute
PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
DEFAULT_NAME = "scene"  # name of a scene that is built in Python
NAME = (
    "1 to 64 letters, digits, dots, dashes or underscores, a letter or digit first (numbers in"
    " quotes)"
)


def _name(value: Any) -> Any:
    """Refuse a name that some file system may not take."""
    if isinstance(value, str) and re.fullmatch(PATTERN, value):
        return value
    raise fault(f"got {messages.shown(value)}, allowed: {NAME}")


class SweepRun(NamedTuple):
    """One run of a scene.

    It has the swept values by dotted key, and the scene with them, which sweeps nothing.
    """

    values: dict[str, sweeps.Value]
    scene: Scene


class Scene(Section):
    """Scene: the bodies, the solution of their contact, and the place of the listener.

    Scenes are equal when all their values are equal, wherever they were read from.

    Attributes
    ----------
    name : str
        Name, used for the folder of the results
    title : str, optional
        Title of the page, any text
    description : str, optional
        Subject of the scene
    sphere, plate, surface, rolling, numerics, recovery, sound : Section
        Sections; the last three have defaults.
    dynamics : Dynamics, optional
        Vibration of sphere and plate; absent: the load is held constant
    sweep : dict
        Lists of values by dotted key, or values by label; all combinations are run

    Raises
    ------
    SceneError
        Some values are missing, unknown or not allowed, in any combination of the sweep.

    Examples
    --------
    >>> from rolling.scene.sections import Plate, Rolling, Sphere
    >>> from rolling.scene.surfaces import Gaussian
    >>> scene = Scene(
    ...     sphere=Sphere(radius_mm=5),
    ...     plate=Plate(youngs_modulus_gpa=210, poissons_ratio=0.3),
    ...     surface=Gaussian(
    ...         spacing_um=1, width_um=256, roughness_ra_um=0.1, correlation_length_um=20, seed=1
    ...     ),
    ...     rolling=Rolling(load_n=20, speed_m_s=0.1, duration_s=0.1),
    ... )
    >>> scene.with_(load_n=50).load
    50.0
    """

    IN_FILES: ClassVar[str] = "name"

    name: Annotated[str, BeforeValidator(_name)] = Field(default=DEFAULT_NAME, pattern=PATTERN)
    title: str | None = None
    description: str | None = None
    sphere: Sphere
    plate: Plate
    surface: Surface
    rolling: Rolling
    numerics: Numerics = Field(default_factory=Numerics, validate_default=True)
    recovery: Recovery = Field(default_factory=Recovery)
    dynamics: Dynamics | None = Field(default=None, validate_default=True)
    sound: Sound = Field(default_factory=Sound, validate_default=True)
    sweep: Annotated[
        dict[str, Any],
        BeforeValidator(lambda value: sweeps.validated(value, Scene)),
        WithJsonSchema({"type": "object"}),  # the keys are filled in by `schema`
    ] = Field(default={})

    # `check` judges the scene before it is run. Its module stands above this one, so
    # `rolling/__init__.py` binds it.
    check: ClassVar[Callable[..., Any]]

    _folder: Path = PrivateAttr(default=Path())
    _places: Mapping[Key, str] = PrivateAttr(default={(): "scene"})

    @field_validator("rolling")
    @classmethod
    def _has_duration(cls, rolling: Rolling, info: ValidationInfo) -> Rolling:
        lengths = rolling.duration_s, rolling.distance_mm
        if lengths == (None, None) and isinstance(info.data.get("surface"), MadeSurface):
            words = "missing; give it or a rolling.distance_mm"
            raise fault(words, "rolling", "duration_s")
        return rolling

    @field_validator("rolling")
    @classmethod
    def _has_room(cls, rolling: Rolling, info: ValidationInfo) -> Rolling:
        """Refuse a contact too near an edge of the plate, and more modes than can be moved."""
        sphere, plate = info.data.get("sphere"), info.data.get("plate")
        if sphere is None or plate is None or plate.edges_mm is None:
            return rolling
        part = cls.model_construct(sphere=sphere, plate=plate, rolling=rolling)
        radius = (3 * part.load * part.radius / (4 * part.contact_modulus)) ** (1 / 3)
        least = EDGE_RADII * radius * 1e3
        for key, point in plate.contact_ends_mm.items():
            edge = min(min(x, side - x) for x, side in zip(point, plate.edges_mm, strict=True))
            if edge < least:
                narrow = "length_mm" if plate.edges_mm[0] < plate.edges_mm[1] else "width_mm"
                words = (
                    f"the contact is {rounded(edge)} mm from an edge, allowed: at least"
                    f" {rounded(least, 3)}, ten contact radii"
                )
                raise fault(words, "plate", key if getattr(plate, key) is not None else narrow)
        modes = part.plate_modes
        if modes > MOST_MODES:
            words = (
                f"the plate has some {rounded(modes)} modes in hearing, allowed: {MOST_MODES};"
                " choose a smaller or thicker plate, or an infinite one without edges"
            )
            raise fault(words, "plate", "length_mm")
        return rolling

    @field_validator("numerics")
    @classmethod
    def _has_track(cls, numerics: Numerics, info: ValidationInfo) -> Numerics:
        surface, rolling = info.data.get("surface"), info.data.get("rolling")
        if isinstance(surface, MadeSurface) and rolling is not None:
            _made_track(surface, rolling, numerics)
        return numerics

    @field_validator("dynamics")
    @classmethod
    def _has_masses(cls, dynamics: Dynamics | None, info: ValidationInfo) -> Dynamics | None:
        bodies = {name: info.data.get(name) for name in ("sphere", "plate")}
        if dynamics is None:
            if bodies["plate"] is not None and bodies["plate"].thickness_mm is not None:
                rule = "without that section the plate does not bend"
                raise fault(f"only goes with dynamics: {rule}", "plate", "thickness_mm")
            if bodies["plate"] is not None and bodies["plate"].contact_loss_factor is not None:
                rule = "without that section nothing vibrates"
                raise fault(f"only goes with dynamics: {rule}", "plate", "contact_loss_factor")
            return None
        for name, body in bodies.items():
            if body is not None and body.density_kg_m3 is None:
                words = f"missing; dynamics needs the mass of the {name}"
                raise fault(words, name, "density_kg_m3")
        return dynamics

    @field_validator("sound")
    @classmethod
    def _has_source(cls, sound: Sound, info: ValidationInfo) -> Sound:
        sphere, dynamics = info.data.get("sphere"), info.data.get("dynamics", ...)
        if sphere is not None and sound.distance_m <= sphere.radius_mm * 1e-3:
            words = f"more than {rounded(sphere.radius_mm * 1e-3, 6)}, the sphere's radius in m"
            got = messages.plain_number(sound.distance_m)
            rule = "the listener stands outside the sphere"
            raise fault(f"got {got}, allowed: {words}: {rule}", "sound", "distance_m")
        if sound.source is None and dynamics is not ...:
            source = "release" if dynamics is None else "vibration"
            sound = sound.model_copy(update={"source": source})
            refuse_free_factors(sound)
        elif sound.source == "vibration" and dynamics is None:
            words = "needs the section dynamics; `dynamics: {}` takes its defaults"
            raise fault(f'got "vibration", which {words}', "sound", "source")
        return sound

    @field_validator("sound")
    @classmethod
    def _has_listeners(cls, sound: Sound, info: ValidationInfo) -> Sound:
        """Refuse listeners of a plate without edges, and listeners inside the sphere."""
        sphere, plate = info.data.get("sphere"), info.data.get("plate")
        if sound.listener_mm is None or sphere is None or plate is None:
            return sound
        if plate.edges_mm is None:
            rule = "an infinite plate is heard on the axis, at distance_m"
            words = f"only goes with plate.length_mm and plate.width_mm: {rule}"
            raise fault(words, "sound", "listener_mm")
        ends = list(plate.contact_ends_mm.values())
        (x, y), (to_x, to_y) = ends[0], ends[-1]
        square = (to_x - x) ** 2 + (to_y - y) ** 2
        for at in sound.listener_mm:
            along = (at[0] - x) * (to_x - x) + (at[1] - y) * (to_y - y)
            share = min(max(along / square, 0.0), 1.0) if square else 0.0
            nearest = x + share * (to_x - x), y + share * (to_y - y), sphere.radius_mm
            if math.dist(at, nearest) <= sphere.radius_mm:
                rule = "more than its radius from the middle of the sphere"
                words = f"got {messages.shown(list(at))}, inside the sphere, allowed: {rule}"
                raise fault(words, "sound", "listener_mm")
        return sound

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Self:
        copied = super().__copy__()
        copied.__dict__.pop("track", None)  # a copy may be given other values
        return copied

    # ---- plain values ----

    @classmethod
    def from_values(cls, values: Mapping[str, Any]) -> Self:
        """Build a scene from plain values that were given in Python; the name may be missing."""
        return cls.from_dict({"name": DEFAULT_NAME, **values})

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        folder: Path = Path(),
        places: Mapping[Key, str] = MappingProxyType({(): "scene"}),
        faults: Sequence[str] = (),
    ) -> Self:
        """Build a scene from plain values as `to_dict` gives them.

        All combinations of its sweep must be valid.

        Parameters
        ----------
        data : mapping
            Sections of plain values. A key without a value (None) counts as not given.
        folder : Path
            Folder that a relative `surface.path` starts from.
        places : mapping
            File and line of each key, for messages; the key () is needed.
        faults : sequence of str
            Faults of the data that are known already.

        Raises
        ------
        SceneError
            The data has faults. The known faults come first.
        """
        data = plain(data)
        scene, new_faults = None, list[sweeps.Fault]()
        try:
            scene = cls.model_validate(data)
        except ValidationError as error:
            new_faults += [
                messages.explained(each, data, cls) for each in sweeps.first_errors(error)
            ]
        if "name" not in data:
            new_faults.insert(0, (("name",), f"missing; {NAME}"))
        if not any(key[:1] == ("sweep",) for key, _ in new_faults):
            new_faults += sweeps.faults_of_runs(data, new_faults, cls)
        lines = [
            f"{messages.place(key, places)}: {messages.cut(messages.dotted(key))}: {words}"
            for key, words in new_faults
        ]
        if len(lines) > MAX_FAULTS:
            more = f"more than {MAX_FAULTS} faults, the others are not listed"
            lines[MAX_FAULTS:] = [f"{messages.place((), places)}: {more}"]
        if faults or lines or scene is None:
            raise SceneError(list(dict.fromkeys([*faults, *lines])))
        scene._folder, scene._places = folder, dict(places)
        return scene

    def to_dict(self) -> dict[str, Any]:
        """Return plain values with every default filled in.

        The folder and keys without a value are left out.
        """
        data = self.model_dump(exclude_none=True)
        if not self.sweep:
            del data["sweep"]
        if self.sound.source == "vibration":
            del data["sound"]["q"]  # which such a scene may not give
        listed: dict[str, Any] = _listed(data)
        return listed

    # ---- changes, runs, findings ----

    def with_(self, changes: Mapping[str, Any] | None = None, /, **keys: Any) -> Self:
        """Return a copy with other values.

        Parameters
        ----------
        changes : mapping, optional
            Values by key.
        **keys
            More values by key. A bare key (load_n) stands for the dotted key (rolling.load_n)
            where it is unique. None removes an optional key. A key that the scene sweeps leaves the
            sweep.

        Raises
        ------
        SceneError
            A key is unknown or ambiguous, or the changed scene has faults.

        Examples
        --------
        `scene.with_(load_n=20)`, `scene.with_({"plate.poissons_ratio": 0.3})`,
        `scene.with_(sweep={"rolling.load_n": [5, 20]})`
        """
        data, faults = self.to_dict(), list[str]()
        if "dynamics" in {*(changes or {}), *keys}:  # the default of the source follows it
            del data["sound"]["source"]
        given: set[str] = set()
        for short, value in [*(changes or {}).items(), *keys.items()]:
            try:
                key = _full_key(short)
                if key in given:
                    raise SceneError([f"scene: {key}: given twice"])
            except SceneError as error:
                faults += error.faults
                continue
            given.add(key)
            put(data, key, plain(value))
        if faults:
            raise SceneError(faults)
        return type(self).from_dict(data, self.folder)

    def runs(self) -> list[SweepRun]:
        """List the runs of the scene; the last swept key varies fastest.

        A scene without a sweep is its own only run.
        """
        if not self.sweep:
            return [SweepRun({}, self)]
        data = self.to_dict()
        del data["sweep"]
        places = {key: at for key, at in self._places.items() if key[:1] != ("sweep",)}
        return [
            SweepRun(values, Scene.from_dict(sweeps.with_values(data, forms), self.folder, places))
            for values, forms in sweeps.product(self.sweep)
        ]

    def place(self, name: str) -> str:
        """Return file and line (or --set) of a dotted key, for messages."""
        section, _, last = name.partition(".")
        swept: Key = ("sweep", name)
        return messages.place(swept if swept in self._places else (section, last), self._places)

    # ---- quantities in SI ----

    @property
    def folder(self) -> Path:
        """Folder that a relative `surface.path` starts from."""
        return self._folder

    @property
    def height_path(self) -> Path | None:
        """File of the heights; None when the surface is generated."""
        return self._folder / self.surface.path if isinstance(self.surface, HeightFile) else None

    @cached_property
    def track(self) -> Track:
        """Positions of the sphere.

        The track lasts for the duration on a generated surface, and by default once round a height
        file.

        A track over a generated surface is rounded to whole nodes and whole steps, so that it
        closes on itself. Only the header of a height file in the format of numpy is read.

        Raises
        ------
        SceneError
            The height file is missing or holds no heights, or the sphere never gets round it.
        """
        if isinstance(self.surface, MadeSurface):
            return _made_track(self.surface, self.rolling, self.numerics)
        name, step_nodes = self.surface.path, self.numerics.step_nodes
        try:
            nodes = height_nodes(self.folder / name, name, self.surface.n_across)
            wanted = rolled(self.rolling.duration_s, self.rolling.distance_mm, self.motion)
            return file_track(nodes, self.spacing, step_nodes, self.motion, wanted)
        except PydanticCustomError as error:
            context = error.context or {}
            raise SceneError([f"{messages.dotted(context['at'])}: {context['message']}"]) from error

    @property
    def motion(self) -> Motion:
        """Distance and speed over time."""
        return Motion.of(self.rolling.speed_m_s)

    @property
    def duration(self) -> float:
        """Time [s] that the track takes."""
        # A track round a file has at least one step, even for a sphere that rests before.
        return self.motion.duration(min(self.track.distance, self.motion.final_distance))

    @property
    def radius(self) -> float:
        """Radius of the sphere [m]."""
        return self.sphere.radius_mm * 1e-3

    @property
    def mass(self) -> float:
        """Mass of the sphere [kg]; it is of steel unless the scene gives a density."""
        return (self.sphere.density_kg_m3 or STEEL_DENSITY) * 4 / 3 * math.pi * self.radius**3

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa].

        1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 holds, without the first term for a rigid sphere.
        """
        compliance = (1 - self.plate.poissons_ratio**2) / self.plate.youngs_modulus_gpa
        if self.sphere.youngs_modulus_gpa is not None and self.sphere.poissons_ratio is not None:
            compliance += (1 - self.sphere.poissons_ratio**2) / self.sphere.youngs_modulus_gpa
        return 1e9 / compliance

    @property
    def plate_modes(self) -> float:
        """Approximate number of modes of a plate with edges up to 30 kHz; 0 without edges."""
        plate = self.plate
        if plate.edges_mm is None or plate.thickness_mm is None:
            return 0.0
        area = plate.edges_mm[0] * plate.edges_mm[1] * 1e-6
        density = plate.density_kg_m3 or STEEL_DENSITY
        stretch = plate.youngs_modulus_gpa * 1e9 / (12 * density * (1 - plate.poissons_ratio**2))
        return area * 30e3 / (2 * math.sqrt(stretch) * plate.thickness_mm * 1e-3)

    @property
    def listeners(self) -> list[tuple[float, float, float]]:
        """Listeners [m] of a plate with edges from its corner, by default one above the contact."""
        if self.sound.listener_mm is not None:
            return [(1e-3 * x, 1e-3 * y, 1e-3 * z) for x, y, z in self.sound.listener_mm]
        ends = list(self.plate.contact_ends_mm.values())
        x, y = (5e-4 * (ends[0][i] + ends[-1][i]) for i in (0, 1))
        return [(x, y, self.sound.distance_m)]

    @property
    def listener_place(self) -> str:
        """Place of the first listener in words: a distance, or coordinates from the corner."""
        if self.sound.listener_mm is None or self.sound.source != "vibration":
            return f"{self.sound.distance_m:g} m"
        return f"[{', '.join(f'{x:g}' for x in self.sound.listener_mm[0])}] mm"

    @property
    def hardness(self) -> float:
        """Maximum pressure that the plate bears [Pa], infinite for a purely elastic plate."""
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
    def tolerance(self) -> float:
        """Tolerance of the solver [-], by the rule of `auto` unless the scene gives a number."""
        given = self.numerics.tolerance
        return automatic_tolerance(self) if isinstance(given, str) else given

    @property
    def load(self) -> float:
        """Normal load [N]."""
        return self.rolling.load_n

    @property
    def moves_release(self) -> bool:
        """Whether the release is wanted under the moving load.

        It is the default where the release is heard.
        """
        if self.dynamics is None:
            return False
        wanted = self.dynamics.release
        return self.sound.source == "release" if wanted is None else wanted

    @property
    def start(self) -> float:
        """First position along the track [m]."""
        return self.rolling.start_um * 1e-6


def _made_track(surface: MadeSurface, rolling: Rolling, numerics: Numerics) -> Track:
    spacing, motion = surface.spacing_um * 1e-6, Motion.of(rolling.speed_m_s)
    wanted = rolled(rolling.duration_s, rolling.distance_mm, motion)
    assert wanted is not None  # refused before
    return made_track(surface.n_across, spacing, numerics.step_nodes, motion, wanted)


def automatic_tolerance(scene: Scene) -> float:
    """Return the tolerance [-] of `auto`, with one digit, from roughness and Hertz deflection.

    It is 1e-4, and less in proportion where the rms roughness is below a tenth of the deflection.
    """
    if isinstance(scene.surface, HeightFile):
        return FILE_TOLERANCE
    rq = 0.0
    if isinstance(scene.surface, Gaussian):
        rq = scene.surface.roughness_ra_um * 1e-6 * math.sqrt(math.pi / 2)
    deflection = (9 * scene.load**2 / (16 * scene.radius * scene.contact_modulus**2)) ** (1 / 3)
    tolerance = min(TOLERANCE, max(LEAST_TOLERANCE, TOLERANCE * rq / deflection / SMOOTH))
    digit = 10.0 ** math.floor(math.log10(tolerance) + 1e-9)
    return float(f"{math.floor(tolerance / digit + 1e-9) * digit:.0e}")


def _full_key(name: str) -> str:
    """Return the dotted key for a bare or dotted name; raise SceneError if none or several fit."""
    if name in messages.all_keys(Scene):
        return name
    last = [key for key in messages.keys(Scene) if key.rpartition(".")[2] == name]
    if len(last) == 1:
        return last[0]
    words = f"stands for {' or '.join(last)}, give one of these"
    raise SceneError([f"scene: {name}: {words if last else messages.unknown_name(name, Scene)}"])


def put(data: dict[str, Any], name: str, value: Any) -> None:
    """Put the value of a dotted name into plain values, and take the name out of the sweep."""
    section, dot, last = name.partition(".")
    if dot and data.get(section) is None:
        data[section] = {}
    inside = data[section] if dot else data
    if not isinstance(inside, dict):  # another value in place of the section, a fault by itself
        return
    inside[last or section] = value
    if section != "sweep" and isinstance(data.get("sweep"), dict):
        data["sweep"].pop(name, None)


def _listed(value: Any) -> Any:
    """Turn tuples into lists, recursively."""
    if isinstance(value, dict):
        return {name: _listed(item) for name, item in value.items()}
    return [_listed(item) for item in value] if isinstance(value, list | tuple) else value
