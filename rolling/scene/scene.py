"""Scene: its sections, its sweep, the rules that join them, and its quantities in SI.

`Scene` is built from sections in Python, or from the plain values of a scene file, which `file`
reads and writes. It is frozen, and `with_` gives a changed copy. A scene is refused with all its
faults, those of the runs of its sweep included, before any run is solved.
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
from pydantic_core import PydanticCustomError

from rolling.scene import channels, library, quantities, rules, step_rule
from rolling.scene import sweep as sweeps
from rolling.scene.messages import (
    MAX_FAULTS,
    Fault,
    Key,
    SceneError,
    first_faults,
    key_of,
    order_of_place,
    plain_values,
)
from rolling.scene.models import faults_of, full_key, judge
from rolling.scene.sections import (
    Dynamics,
    Numerics,
    Rolling,
    Sound,
)


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
        Vibration of sphere and plate. Default: none, so the load is constant and the vibration is
        only estimated.
    sweep : dict
        Lists of values by dotted key, or values by label. All combinations are run.

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
    _step_choice: step_rule.StepChoice | None = PrivateAttr(default=None)

    # Each rule sees the sections before its own that are valid.

    @field_validator("rolling")
    @classmethod
    def _check_rolling(cls, rolling: Rolling, info: ValidationInfo) -> Rolling:
        rules.refuse_rolling(rolling, info.data)
        return rolling

    @field_validator("numerics")
    @classmethod
    def _check_numerics(cls, numerics: Numerics, info: ValidationInfo) -> Numerics:
        rules.refuse_numerics(numerics, info.data)
        rules.refuse_memory(numerics, info.data)
        return numerics

    @field_validator("dynamics")
    @classmethod
    def _check_dynamics(cls, dynamics: Dynamics | None, info: ValidationInfo) -> Dynamics | None:
        rules.refuse_dynamics(dynamics, info.data)
        return dynamics

    @field_validator("sound")
    @classmethod
    def _check_sound(cls, sound: Sound, info: ValidationInfo) -> Sound:
        sound = rules.with_source(sound, info.data)
        rules.refuse_listeners(sound, info.data)
        channels.refuse_channels(sound.channels or [], info.data)
        return sound

    def __repr__(self) -> str:
        sphere = f"sphere of {self.radius:g} m under {self.load:.4g} N"
        text = f"{self.name}: {sphere}, speed {self.rolling.speed_m_s} m/s, {self.duration:g} s"
        if self.sweep:
            text += f", sweep of {', '.join(self.sweep)}"
        return f"Scene({text})"

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
        known: Sequence[Fault] = (),
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
        known : sequence of Fault
            Faults of the text that the data come from.

        Raises
        ------
        SceneError
            The text, the data, or runs of the sweep have faults; all are named, in the order of
            their lines, unless they are too many.
        """
        values = plain_values(data)
        judged = judge(values, cls, known)
        faults = [*known, *judged.faults]
        if values.get("name") is None and not judged.refused.holds(("name",)):
            faults.append(Fault(("name",), f"missing; {quantities.NAME}"))
        scene = judged.model
        if isinstance(scene, cls):
            scene._folder = folder
            scene._places = dict(places)
            of_runs, _ = scene._judged_runs()
        else:
            of_runs = _faults_of_swept_values(judged.rest)
        faults += [found for found in of_runs if not judged.refused.explain(found)]
        if faults:
            more = None if len(of_runs) > MAX_FAULTS else judged.more
            raise _scene_error(faults, places, more)
        assert isinstance(scene, cls)  # as it has no fault
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
        if changes is not None and not isinstance(changes, Mapping):
            example = "{'rolling.load_n': 5}, or load_n=5"
            raise TypeError(f"changes: got {changes!r}, allowed: values by key, as in {example}")
        by_key: dict[str, Any] = {}
        faults = []
        for name, value in [*(changes or {}).items(), *keys.items()]:
            try:
                key = full_key(name, type(self))
            except SceneError as error:
                faults += error.faults
                continue
            if key in by_key:
                faults.append(f"scene: {key}: given twice")
            by_key[key] = plain_values(value)
        if isinstance(by_key.get("sweep"), dict):
            by_key["sweep"] = self._with_full_keys(by_key["sweep"])
        if faults:
            raise SceneError(faults)
        data = self.to_dict()
        if "dynamics" in by_key:
            del data["sound"]["source"]  # because its default follows the dynamics
        for key in sorted(by_key, key=library.order_of_change):
            data = sweeps.with_value(data, key, by_key[key])
        return type(self).from_dict(data, self.folder)

    def _with_full_keys(self, sweep: Mapping[Any, Any]) -> dict[Any, Any]:
        """Return a sweep by its dotted keys; a name that stands for no key stays as it is."""
        by_key = {}
        for name, listed in sweep.items():
            try:
                by_key[full_key(name, type(self))] = listed
            except SceneError:  # the sweep is refused with all that is wrong in it
                by_key[name] = listed
        return by_key

    def runs(self) -> list[SweepRun]:
        """List the runs of the scene; the last swept key varies fastest.

        A scene without a sweep is its own only run. In place of `step_nodes: auto` each run has the
        number of nodes that its own contact and the slowest speed of all runs allow.

        Raises
        ------
        SceneError
            A run has faults; those of the first such run are named.
        """
        faults, runs = self._judged_runs()
        if faults:
            raise _scene_error(faults, self._places, None if len(faults) > MAX_FAULTS else 0)
        if all(isinstance(run.numerics.step_nodes, float) for _, run in runs):
            return runs
        slowest = min(run.slowest_speed for _, run in runs)
        return [SweepRun(values, run._with_steps_for(slowest)) for values, run in runs]

    @property
    def step_choice(self) -> step_rule.StepChoice | None:
        """Steps that `auto` chose, with the reason; None where the scene gave a number."""
        if isinstance(self.numerics.step_nodes, str):
            return step_rule.choose(self, self.slowest_speed)
        return self._step_choice

    @property
    def step_reason(self) -> str:
        """Words on who chose the length of the steps, and why."""
        choice = self.step_choice
        return "a number of the scene" if choice is None else f"auto, {choice.text}"

    def _with_steps_for(self, slowest: float) -> Self:
        """Return a scene with the steps that `auto` takes for a slowest speed [m/s]."""
        if not isinstance(self.numerics.step_nodes, str):
            return self
        choice = step_rule.choose(self, slowest)
        steps = {"step_nodes": choice.nodes, "slowest_m_s": None}
        scene = self.model_copy(update={"numerics": self.numerics.model_copy(update=steps)})
        scene._step_choice = choice
        return scene

    def with_auto_steps(self) -> Self:
        """Return a run of a scene with `step_nodes: auto` where auto chose its steps.

        It keeps the slowest speed of its sweep.
        """
        choice = self._step_choice
        if choice is None:
            return self
        slowest = choice.speed if choice.speed < self.heard_speed else None
        steps = {"step_nodes": "auto", "slowest_m_s": slowest}
        return self.model_copy(update={"numerics": self.numerics.model_copy(update=steps)})

    def _judged_runs(self) -> tuple[list[Fault], list[SweepRun]]:
        """Return the faults of the runs, each once at its swept value, and the runs without any.

        After more than MAX_FAULTS the other runs are not judged.
        """
        if not self.sweep:
            return [], [SweepRun({}, self)]
        data = self.to_dict()
        del data["sweep"]
        usual_source = "release" if self.dynamics is None else "vibration"
        if "dynamics" in self.sweep and self.sound.source == usual_source:
            del data["sound"]["source"]  # because its default follows the dynamics of each run
        places = {key: at for key, at in self._places.items() if key[:1] != ("sweep",)}
        runs: list[SweepRun] = []
        faults: dict[Fault, Fault] = {}  # with the first of its runs, by the fault without it
        for values, forms in sweeps.product(self.sweep):
            run_data = sweeps.with_values(data, forms)
            try:
                scene = Scene.model_validate(run_data)
            except ValidationError as error:
                for found in faults_of(error, run_data, Scene)[0]:
                    faults.setdefault(found, self._in_sweep(found, values))
                if len(faults) > MAX_FAULTS:
                    break
                continue
            scene._folder = self._folder
            scene._places = places
            runs.append(SweepRun(values, scene))
        return list(dict.fromkeys(faults.values())), runs

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


def _faults_of_swept_values(values: Mapping[str, Any]) -> list[Fault]:
    """Return the faults of swept values, each judged alone beside sections that make no scene."""
    try:
        sweep = sweeps.check_lists(values.get("sweep") or {})
    except PydanticCustomError:  # faults that are listed already
        return []
    data = {name: section for name, section in values.items() if name != "sweep"}
    faults: list[Fault] = []
    for name, listed in sweep.items():
        for value, form in sweeps.choices(listed)[: MAX_FAULTS + 1]:
            run_data = sweeps.with_values(data, {name: form})
            try:
                Scene.model_validate(run_data)
            except ValidationError as error:
                for found in faults_of(error, run_data, Scene)[0]:
                    place = sweeps.place_in_sweep(found.key, {name: value}, sweep)
                    if place is not None:
                        faults.append(Fault(place, found.message))
    return faults


def _scene_error(
    faults: Sequence[Fault], places: Mapping[Key, str], more: int | None
) -> SceneError:
    """Make the error of a scene from its faults in the order of their lines, and more of them."""
    placed = [found._replace(place=found.place or _place_of(found.key, places)) for found in faults]
    placed.sort(key=lambda found: order_of_place(found.place))
    return SceneError(first_faults([found.line for found in placed], places[()], more))
