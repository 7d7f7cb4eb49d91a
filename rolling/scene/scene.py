"""Scene: its sections, its sweep, and its quantities in SI.

`Scene` is built from sections in Python, or from the plain values of a scene file, which `file`
reads and writes. It is frozen, and `with_` gives a changed copy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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

from rolling.scene import library, messages, rules
from rolling.scene import sweep as sweeps
from rolling.scene.messages import Key, SceneError
from rolling.scene.quantities import DEFAULT_NAME, NAME, SceneQuantities
from rolling.scene.sections import MAX_FAULTS, Dynamics, Numerics, Rolling, Sound, plain


class SweepRun(NamedTuple):
    """One run of a scene.

    It has the swept values by dotted key, and the scene with them, which sweeps nothing.
    """

    values: dict[str, sweeps.Value]
    scene: Scene


class Scene(SceneQuantities):
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
    >>> from rolling.scene.bodies import Plate, Sphere
    >>> from rolling.scene.sections import Rolling
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

    sweep: Annotated[
        dict[str, Any],
        BeforeValidator(lambda value: sweeps.validated(value, Scene)),
        WithJsonSchema({"type": "object"}),  # the keys are filled in by `schema`
    ] = Field(default={})

    # `check` judges the scene before it is run. Its module stands above this one, so
    # `rolling/__init__.py` binds it.
    check: ClassVar[Callable[..., Any]]

    _places: Mapping[Key, str] = PrivateAttr(default={(): "scene"})

    @field_validator("rolling")
    @classmethod
    def _can_roll(cls, rolling: Rolling, info: ValidationInfo) -> Rolling:
        rules.refuse_rolling(rolling, info.data)
        return rolling

    @field_validator("numerics")
    @classmethod
    def _has_track(cls, numerics: Numerics, info: ValidationInfo) -> Numerics:
        rules.refuse_numerics(numerics, info.data)
        rules.refuse_memory(numerics, info.data)
        return numerics

    @field_validator("dynamics")
    @classmethod
    def _has_masses(cls, dynamics: Dynamics | None, info: ValidationInfo) -> Dynamics | None:
        rules.refuse_dynamics(dynamics, info.data)
        return dynamics

    @field_validator("sound")
    @classmethod
    def _has_source(cls, sound: Sound, info: ValidationInfo) -> Sound:
        sound = rules.with_source(sound, info.data)
        rules.refuse_listeners(sound, info.data)
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
        data: dict[str, Any] = plain(self)
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
        data, faults = self.to_dict(), list[str]()
        if "dynamics" in {*(changes or {}), *keys}:  # the default of the source follows it
            del data["sound"]["source"]
        given: set[str] = set()
        listed = [*(changes or {}).items(), *keys.items()]
        for short, value in sorted(listed, key=lambda item: library.names_first(item[0])):
            try:
                key = messages.full_key(short, type(self))
                if key in given:
                    raise SceneError([f"scene: {key}: given twice"])
            except SceneError as error:
                faults += error.faults
                continue
            given.add(key)
            data = sweeps.with_value(data, key, plain(value))
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
        swept: Key = ("sweep", name)
        key = swept if swept in self._places else messages.key_of(name)
        return messages.place(key, self._places)
