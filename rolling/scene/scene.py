"""Scene of a sphere that rolls: its sections, its sweep, and the rules that join them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from rolling.scene import rules, step_rule, transducers, values_in_si
from rolling.scene import sweep as sweeps
from rolling.scene.length_choice import LengthChoice, longest_choice
from rolling.scene.sections import (
    AUTO,
    LENGTH_KEYS,
    Dynamics,
    Numerics,
    Rolling,
    Sound,
)
from rolling.scene.swept import SweepRun

CACHED = ("track", "motion", "duration")  # properties that a scene keeps


def _sweep(value: Any) -> dict[str, Any]:
    """Return a sweep of a scene with its lists as tuples, or refuse it."""
    return sweeps.check_lists(value, values_in_si.SceneQuantities)


class Scene(values_in_si.SceneQuantities):
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
    listen_for : str, optional
        What to listen for, in one line
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

    SECTION: ClassVar[str] = "sphere"
    TITLE: ClassVar[str] = "Scene of rolling contact noise"

    sweep: Annotated[
        dict[str, Any],
        BeforeValidator(_sweep),
        WithJsonSchema({"type": "object"}),
    ] = Field(default={})

    _step_choice: step_rule.StepChoice | None = PrivateAttr(default=None)
    _length_choice: LengthChoice | None = PrivateAttr(default=None)

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
        transducers.refuse_channels(sound.channels or [], info.data)
        return sound

    def __repr__(self) -> str:
        sphere = f"sphere of {self.radius:g} m under {self.load:.4g} N"
        text = f"{self.name}: {sphere}, speed {self.rolling.speed_m_s} m/s, {self.duration:g} s"
        if self.sweep:
            text += f", sweep of {', '.join(self.sweep)}"
        return f"Scene({text})"

    def __copy__(self) -> Self:
        copied = super().__copy__()
        for name in CACHED:  # a copy may be given other values
            copied.__dict__.pop(name, None)
        return copied

    # ---- plain values and runs ----

    def to_dict(self) -> dict[str, Any]:
        """Return plain values with every default filled in.

        The folder and keys without a value are left out.
        """
        data = super().to_dict()
        if self.sound.source == "vibration":
            del data["sound"]["q"]  # which such a scene may not give
        return data

    def _data_to_change(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Return the plain values that changes by key are made in."""
        data = self.to_dict()
        if "dynamics" in changes:
            del data["sound"]["source"]  # because its default follows the dynamics
        return data

    def _data_of_runs(self) -> dict[str, Any]:
        """Return the plain values that the runs of the sweep share."""
        data = super()._data_of_runs()
        usual_source = "release" if self.dynamics is None else "vibration"
        if "dynamics" in self.sweep and self.sound.source == usual_source:
            del data["sound"]["source"]  # because its default follows the dynamics of each run
        return data

    def runs(self) -> list[SweepRun[Self]]:
        """List the runs of the scene; the last swept key varies fastest.

        A scene without a sweep is its own only run. In place of a length of `auto` all runs have
        the longest that one of them needs. In place of `step_nodes: auto` each run has the number
        of nodes that its own contact and the slowest speed of all runs allow.

        Raises
        ------
        SceneError
            A run has mistakes; those of the first such run are named.
        """
        runs = self._with_shared_length(super().runs())
        if all(isinstance(run.numerics.step_nodes, float) for _, run in runs):
            return runs
        slowest = min(run.slowest_speed for _, run in runs)
        return [SweepRun(values, run._with_steps_for(slowest)) for values, run in runs]

    def _with_shared_length(self, runs: list[SweepRun[Self]]) -> list[SweepRun[Self]]:
        """Return runs with one length in place of `auto`, the longest that one of them needs."""
        choices = {k: run.length_choice for k, (_, run) in enumerate(runs)}
        needs = [choice for choice in choices.values() if choice is not None]
        if not needs:
            return runs
        shared = longest_choice(needs)
        return [
            SweepRun(values, run if choices[k] is None else run.with_length(shared))
            for k, (values, run) in enumerate(runs)
        ]

    @property
    def length_choice(self) -> LengthChoice | None:
        """Length that `auto` chose, with the reason; None where the scene has a length."""
        if not self.chooses_length:
            return self._length_choice
        need = self.length_need
        return LengthChoice(
            seconds=need.seconds,
            distance_m=need.seconds * self.motion.speeds[0],
            key=f"rolling.{self.rolling.length_key}",
            reason=need.reason,
        )

    @property
    def is_one_lap(self) -> bool:
        """Whether a height file is rolled over once, because the scene states no length."""
        has_length = self.rolling.duration_s is not None or self.rolling.distance_mm is not None
        return self.surface.kind == "file" and not has_length

    @property
    def length_reason(self) -> str:
        """Words on who chose the length of the track, and why."""
        choice = self.length_choice
        return "a length of the scene" if choice is None else f"auto, {choice.text}"

    def with_shared_length(self) -> Self:
        """Return a scene with the number in place of a length that `auto` took for its runs."""
        if not self.chooses_length:
            return self
        choice = next(run.length_choice for _, run in self.runs() if run.length_choice)
        return self.with_length(choice)

    def with_length(self, choice: LengthChoice) -> Self:
        """Return a scene with `auto` that takes a length, that of its sweep or of a choice."""
        seconds = choice.seconds_at(self.motion.speeds[0])
        scene = self.model_copy(update={"rolling": self.rolling_for(seconds)})
        scene._length_choice = choice
        return scene

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

    def with_auto_length(self) -> Self:
        """Return a run of a scene with a length of `auto` where auto chose it."""
        choice = self._length_choice
        if choice is None:
            return self
        key = choice.key.partition(".")[2]
        lengths = {**dict.fromkeys(LENGTH_KEYS), key: AUTO}
        return self.model_copy(update={"rolling": self.rolling.model_copy(update=lengths)})

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
