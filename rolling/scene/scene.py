"""Scene: its sections, its sweep, the rules that join them, and its quantities in SI.

`Scene` is built from sections in Python, or from the plain values of a scene file, which `file`
reads and writes. It is frozen, and `with_` gives a changed copy. A scene is refused with its first
faults; the runs of its sweep are all checked before any is solved, and the first faulty run is
named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
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

from acoustics.numbers import rounded
from rolling.scene import library, quantities, sections
from rolling.scene import sweep as sweeps
from rolling.scene.bodies import Plate, Sphere
from rolling.scene.messages import (
    Key,
    SceneError,
    dotted,
    fault,
    first_faults,
    key_of,
    plain_number,
    plain_values,
    quoted,
    shortened,
)
from rolling.scene.models import Fault, faults_of, full_key
from rolling.scene.surfaces import HeightFile, MadeSurface, refuse_ball
from rolling.scene.track import ROUNDING


class SweepRun(NamedTuple):
    """One run of a scene.

    It has the swept values by dotted key, and the scene with them, which sweeps nothing.
    """

    values: dict[str, sweeps.Value]
    scene: Scene


class Scene(quantities.SceneQuantities):
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
        Some values are missing, unknown or not allowed, in the scene or in a run of its sweep.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.Scene(
    ...     sphere=rolling.Sphere(radius_mm=5),
    ...     plate=rolling.Plate(youngs_modulus_gpa=210, poissons_ratio=0.3),
    ...     surface=rolling.Gaussian(
    ...         spacing_um=1, width_um=256, roughness_ra_um=0.1, correlation_length_um=20, seed=1
    ...     ),
    ...     rolling=rolling.Rolling(load_n=20, speed_m_s=0.1, duration_s=0.1),
    ... )
    >>> scene.with_(load_n=50).load
    50.0
    """

    IN_FILES: ClassVar[str] = "name"

    sweep: Annotated[
        dict[str, Any],
        BeforeValidator(sweeps.check_lists),
        WithJsonSchema({"type": "object"}),
    ] = Field(default={})

    # `check` judges the scene before it is run. Its module stands above this one, so
    # `rolling/__init__.py` binds it.
    check: ClassVar[Callable[..., Any]]

    _places: Mapping[Key, str] = PrivateAttr(default={(): "scene"})

    # Each rule sees the sections before its own that are valid.

    @field_validator("rolling")
    @classmethod
    def _check_rolling(cls, rolling: sections.Rolling, info: ValidationInfo) -> sections.Rolling:
        refuse_rolling(rolling, info.data)
        return rolling

    @field_validator("numerics")
    @classmethod
    def _check_numerics(
        cls, numerics: sections.Numerics, info: ValidationInfo
    ) -> sections.Numerics:
        refuse_numerics(numerics, info.data)
        refuse_memory(numerics, info.data)
        return numerics

    @field_validator("dynamics")
    @classmethod
    def _check_dynamics(
        cls, dynamics: sections.Dynamics | None, info: ValidationInfo
    ) -> sections.Dynamics | None:
        refuse_dynamics(dynamics, info.data)
        return dynamics

    @field_validator("sound")
    @classmethod
    def _check_sound(cls, sound: sections.Sound, info: ValidationInfo) -> sections.Sound:
        sound = with_source(sound, info.data)
        refuse_listeners(sound, info.data)
        return sound

    def __repr__(self) -> str:
        load, speed = f"{self.load:.4g} N", self.rolling.speed_m_s
        sphere = f"sphere of {self.radius:g} m under {load}"
        swept = f", sweep of {', '.join(self.sweep)}" if self.sweep else ""
        return f"Scene({self.name}: {sphere}, speed {speed} m/s, {self.duration:g} s{swept})"

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
        return cls.from_dict({"name": quantities.DEFAULT_NAME, **values})

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        folder: Path = Path(),
        places: Mapping[Key, str] = MappingProxyType({(): "scene"}),
    ) -> Self:
        """Build a scene from plain values as `to_dict` gives them.

        All runs of its sweep must be valid.

        Parameters
        ----------
        data : mapping
            Sections of plain values. A key without a value (None) counts as not given.
        folder : Path
            Folder that a relative `surface.path` starts from.
        places : mapping
            File and line of each key, for messages; the key () is needed.

        Raises
        ------
        SceneError
            The data, or a run of the sweep, has faults; its first faults are named.
        """
        values = plain_values(data)
        faults = []
        if values.get("name") is None:
            faults.append(Fault(("name",), f"missing; {quantities.NAME}"))
        try:
            scene = cls.model_validate(values)
        except ValidationError as error:
            faults += faults_of(error, values, cls)
        if faults:
            raise _scene_error(faults, places)
        scene._folder = folder
        scene._places = dict(places)
        scene.runs()  # refuses a faulty run
        return scene

    def to_dict(self) -> dict[str, Any]:
        """Return plain values with every default filled in.

        The folder and keys without a value are left out.
        """
        data: dict[str, Any] = plain_values(self)
        if not self.sweep:
            del data["sweep"]
        if self.sound.source == "vibration":
            del data["sound"]["q"]  # which such a scene may not give
        return data

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
        given = {**(changes or {}), **keys}
        by_key: dict[str, Any] = {}
        for name, value in given.items():
            key = full_key(name, type(self))
            if key in by_key:
                raise SceneError([f"scene: {key}: given twice"])
            by_key[key] = plain_values(value)
        data = self.to_dict()
        if "dynamics" in by_key:
            del data["sound"]["source"]  # because its default follows the dynamics
        for key in sorted(by_key, key=library.names_first):
            data = sweeps.with_value(data, key, by_key[key])
        return type(self).from_dict(data, self.folder)

    def runs(self) -> list[SweepRun]:
        """List the runs of the scene; the last swept key varies fastest.

        A scene without a sweep is its own only run.

        Raises
        ------
        SceneError
            A run has faults; those of the first such run are named.
        """
        if not self.sweep:
            return [SweepRun({}, self)]
        data = self.to_dict()
        del data["sweep"]
        places = {key: at for key, at in self._places.items() if key[:1] != ("sweep",)}
        runs = []
        for values, forms in sweeps.product(self.sweep):
            run_data = sweeps.with_values(data, forms)
            try:
                scene = Scene.model_validate(run_data)
            except ValidationError as error:
                faults = faults_of(error, run_data, Scene)
                raise _scene_error(
                    [self._in_sweep(found, values) for found in faults], self._places
                ) from error
            scene._folder = self._folder
            scene._places = places
            runs.append(SweepRun(values, scene))
        return runs

    def _in_sweep(self, found: Fault, values: Mapping[str, sweeps.Value]) -> Fault:
        """Return a fault of a run at the place of its swept value, or with the name of the run."""
        place = sweeps.place_in_sweep(found.key, values, self.sweep)
        if place is not None:
            return Fault(place, found.message)
        run = sweeps.run_name(values)
        return Fault(found.key, f"{found.message} (in the run {run} of the sweep)")

    def place(self, name: str) -> str:
        """Return file and line (or --set) of a dotted key, for messages."""
        swept: Key = ("sweep", name)
        key = swept if swept in self._places else key_of(name)
        return _place_of(key, self._places)


def _place_of(key: Key, places: Mapping[Key, str]) -> str:
    """Return file and line (or --set) of a key, or of the nearest section around it."""
    return next(places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places)


def _scene_error(faults: list[Fault], places: Mapping[Key, str]) -> SceneError:
    """Make the error of a scene from its faults, each with its place."""
    lines = [
        f"{_place_of(found.key, places)}: {shortened(dotted(found.key))}: {found.message}"
        for found in faults
    ]
    return SceneError(first_faults(lines, _place_of((), places)))


# ---- rules that join sections: each takes the sections that are valid so far, by name


EDGE_RADII = 10  # contact radii from the contact to the nearest edge of the plate, at least
MAX_MODES = 20_000  # of a plate with edges; a second of sound takes them half a minute

Values = Mapping[str, Any]


def refuse_rolling(rolling: sections.Rolling, values: Values) -> None:
    """Refuse a track without a length, a missing load, and a contact too near an edge."""
    has_length = rolling.duration_s or rolling.distance_mm or rolling.resistance
    if not has_length and isinstance(values.get("surface"), MadeSurface):
        raise fault("missing; give it or a rolling.distance_mm", at="rolling.duration_s")
    sphere, plate = values.get("sphere"), values.get("plate")
    if sphere is None:
        return
    if sphere.density_kg_m3 is None:
        if rolling.load_n == sections.WEIGHT:
            words = "missing; give it, or sphere.density_kg_m3 for the weight of the sphere"
            if "load_n" in rolling.model_fields_set:
                words = "got weight, which needs sphere.density_kg_m3"
            raise fault(words, at="rolling.load_n")
        if rolling.resistance is not None:
            raise fault(
                "missing; rolling.resistance needs the mass of the sphere",
                at="sphere.density_kg_m3",
            )
    rest = quantities.motion_of(sphere, rolling).rest_time
    duration = rolling.duration_s
    if rolling.resistance and duration and duration > rest * (1 + ROUNDING):
        raise fault(
            f"the sphere comes to rest after {rounded(rest, 6)} s, rolling.duration_s is"
            f" {plain_number(duration)}: give it more speed, or leave out the duration",
            at="rolling.duration_s",
        )
    if plate is not None and plate.edges_mm is not None:
        _refuse_edges(rolling, sphere, plate)


def _refuse_edges(rolling: sections.Rolling, sphere: Sphere, plate: Plate) -> None:
    """Refuse a contact too near an edge of the plate, and more modes than can be moved."""
    assert plate.edges_mm is not None  # asked for by the caller
    load = quantities.load(sphere, rolling)
    radius = max(sphere.radius_mm, sphere.radius_across_mm or 0.0) * 1e-3
    contact = (3 * load * radius / (4 * quantities.contact_modulus(sphere, plate))) ** (1 / 3)
    least = EDGE_RADII * contact * 1e3
    for key, point in plate.contact_ends_mm.items():
        edge = min(min(x, side - x) for x, side in zip(point, plate.edges_mm, strict=True))
        if edge < least:
            if getattr(plate, key) is None:  # the default point, so the plate is too narrow
                key = "length_mm" if plate.edges_mm[0] < plate.edges_mm[1] else "width_mm"
            raise fault(
                f"the contact is {rounded(edge)} mm from an edge, allowed: at least"
                f" {rounded(least, 3)}, ten contact radii",
                at=f"plate.{key}",
            )
    modes = quantities.plate_modes(plate)
    if modes > MAX_MODES:
        raise fault(
            f"the plate has some {rounded(modes)} modes in hearing, allowed: {MAX_MODES}; choose a"
            " smaller or thicker plate, or an infinite one without edges",
            at="plate.length_mm",
        )


def refuse_numerics(numerics: sections.Numerics, values: Values) -> None:
    """Refuse a surface of the sphere, and a track, that whole nodes and steps do not hold."""
    surface, rolling, sphere = (values.get(name) for name in ("surface", "rolling", "sphere"))
    if surface is None or sphere is None:
        return
    if sphere.surface is not None:
        if surface.spacing_um is None:
            raise fault("missing; the surface of the sphere has the same", at="surface.spacing_um")
        refuse_ball(sphere.surface, sphere.radius_mm, surface.spacing_um)
    if rolling is not None and not isinstance(surface, HeightFile):
        quantities.track_of(sphere, surface, rolling, numerics, Path())


def refuse_memory(numerics: sections.Numerics, values: Values) -> None:
    """Refuse passes without memory, and memory of parts of nodes or of a rough sphere."""
    plate, rolling, sphere = (values.get(name) for name in ("plate", "rolling", "sphere"))
    if plate is None:
        return
    if plate.plasticity != "permanent":
        if rolling is not None and (rolling.passes or 1) > 1:
            raise fault(
                f"got {rolling.passes}, which needs plate.plasticity: permanent: without memory all"
                " passes are equal",
                at="rolling.passes",
            )
        return
    if sphere is not None and sphere.surface is not None:
        raise fault(
            'got "permanent", which only goes with a smooth sphere: each turn of a rough sphere'
            " meets other places of the plate",
            at="plate.plasticity",
        )
    permanent = "allowed with plate.plasticity: permanent"
    if numerics.edges != "sharp":
        raise fault(
            f'got {quoted(numerics.edges)}, {permanent}: "sharp"; nodes sink as a whole',
            at="numerics.edges",
        )
    if numerics.subcells not in (1, "auto"):
        raise fault(
            f"got {numerics.subcells}, {permanent}: 1; nodes sink as a whole",
            at="numerics.subcells",
        )
    if numerics.error_estimate:
        raise fault(
            f"got true, {permanent}: false; its grids have no earlier passes",
            at="numerics.error_estimate",
        )


def refuse_dynamics(dynamics: sections.Dynamics | None, values: Values) -> None:
    """Refuse keys that need dynamics without it, and dynamics of bodies without a mass."""
    bodies = {name: values[name] for name in ("sphere", "plate") if name in values}
    dropped = "rolling" in values and values["rolling"].drop_mm is not None
    if dynamics is not None:
        if dynamics.release and dropped:
            raise fault(
                "got true, which a sphere with rolling.drop_mm has not: nothing is released in"
                " flight",
                at="dynamics.release",
            )
        for name, body in bodies.items():
            if body.density_kg_m3 is None:
                raise fault(
                    f"missing; dynamics needs the mass of the {name}",
                    at=f"{name}.density_kg_m3",
                )
        return
    if dropped:
        raise fault(
            "only goes with dynamics; `dynamics: {}` takes its defaults", at="rolling.drop_mm"
        )
    plate = values.get("plate")
    if plate is not None and plate.thickness_mm is not None:
        raise fault(
            "only goes with dynamics: without that section the plate does not bend",
            at="plate.thickness_mm",
        )
    if plate is not None and plate.contact_loss_factor is not None:
        raise fault(
            "only goes with dynamics: without that section nothing vibrates",
            at="plate.contact_loss_factor",
        )


def with_source(sound: sections.Sound, values: Values) -> sections.Sound:
    """Return the sound with its source; refuse a source that the scene has not."""
    sphere, dynamics = values.get("sphere"), values.get("dynamics", ...)
    if sphere is not None and sound.distance_m <= sphere.radius_mm * 1e-3:
        raise fault(
            f"got {plain_number(sound.distance_m)}, allowed: more than"
            f" {rounded(sphere.radius_mm * 1e-3, 6)}, the sphere's radius in m: the listener"
            " stands outside the sphere",
            at="sound.distance_m",
        )
    if sound.source is None and dynamics is not ...:
        source = "release" if dynamics is None else "vibration"
        sound = sound.model_copy(update={"source": source})
        sections.refuse_free_factors(sound)
    elif sound.source == "vibration" and dynamics is None:
        raise fault(
            'got "vibration", which needs the section dynamics; `dynamics: {}` takes its defaults',
            at="sound.source",
        )
    rolling = values.get("rolling")
    if sound.source == "release" and rolling is not None and rolling.drop_mm is not None:
        raise fault(
            'got "release", which a sphere with rolling.drop_mm has not: nothing is released in'
            " flight",
            at="sound.source",
        )
    return sound


def refuse_listeners(sound: sections.Sound, values: Values) -> None:
    """Refuse listeners of a plate without edges, and listeners inside the sphere."""
    sphere, plate = values.get("sphere"), values.get("plate")
    if sound.listener_mm is None or sphere is None or plate is None:
        return
    if plate.edges_mm is None:
        raise fault(
            "only goes with plate.length_mm and plate.width_mm: an infinite plate is heard on the"
            " axis, at distance_m",
            at="sound.listener_mm",
        )
    ends = list(plate.contact_ends_mm.values())
    (x, y), (to_x, to_y) = ends[0], ends[-1]
    square = (to_x - x) ** 2 + (to_y - y) ** 2
    for at in sound.listener_mm:
        along = (at[0] - x) * (to_x - x) + (at[1] - y) * (to_y - y)
        share = min(max(along / square, 0.0), 1.0) if square else 0.0
        nearest = x + share * (to_x - x), y + share * (to_y - y), sphere.radius_mm
        if math.dist(at, nearest) <= sphere.radius_mm:
            raise fault(
                f"got {quoted(list(at))}, inside the sphere, allowed: more than its radius from the"
                " middle of the sphere",
                at="sound.listener_mm",
            )
