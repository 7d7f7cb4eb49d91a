"""A scene of any kind: its plain values, its changes, and the runs of its sweep.

`Scene` and `BearingScene` are such scenes. They are built from sections in Python, or from the
plain values of a scene file, which `file` reads and writes. A scene is frozen, and `with_` gives a
changed copy. It is refused with all its mistakes, those of the runs of its sweep included, before
any run is solved.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, NamedTuple, Self, TypeVar, cast

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    WithJsonSchema,
    field_validator,
)
from pydantic_core import PydanticCustomError

from rolling.scene import library
from rolling.scene import sweep as sweeps
from rolling.scene.messages import (
    MAX_MISTAKES,
    Key,
    Mistake,
    SceneError,
    first_mistakes,
    key_of,
    mistake,
    order_of_place,
    plain_values,
    quoted,
)
from rolling.scene.models import (
    Section,
    fill,
    full_key,
    independent,
    mistakes_of,
)

if TYPE_CHECKING:
    from rolling.check.findings import Findings

PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$"
LIKE_SECTION = 0.8  # likeness from which on a section is taken for a misspelt one
DEFAULT_NAME = "scene"  # name of a scene that is built in Python
NAME = (
    "1 to 64 letters, digits, dots, dashes or underscores, a letter or digit first (numbers in"
    " quotes)"
)


def _name(value: Any) -> Any:
    """Refuse a name that some file system may not take."""
    if isinstance(value, str) and re.fullmatch(PATTERN, value):
        return value
    raise mistake(f"got {quoted(value)}, allowed: {NAME}")


SceneName = Annotated[str, BeforeValidator(_name)]
AnyScene = TypeVar("AnyScene", bound="SweptScene")


class SweepRun(NamedTuple, Generic[AnyScene]):
    """One run of a scene.

    It has the swept values by dotted key, and the scene with them, which sweeps nothing.
    """

    values: dict[str, sweeps.Value]
    scene: AnyScene


class SweptScene(Section):
    """Scene of any kind, which has a name and may have a sweep."""

    IN_FILES: ClassVar[str] = "name"
    SECTION: ClassVar[str]  # of the scenes of this kind alone
    TITLE: ClassVar[str]  # of their JSON Schema
    # What earlier versions did by dotted keys that they did not know, so that their stored scenes,
    # which have every default filled in, lack them.
    FORMER_VALUES: ClassVar[Mapping[str, Any]] = MappingProxyType({})

    if TYPE_CHECKING:  # fields of each kind of scene, the first and the last of its file
        name: str
        sweep: dict[str, Any]

    _folder: Path = PrivateAttr(default=Path())
    _places: Mapping[Key, str] = PrivateAttr(default={(): "scene"})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and self.model_dump() == other.model_dump()

    __hash__ = None  # type: ignore[assignment]

    @property
    def folder(self) -> Path:
        """Folder that relative paths of height files start from."""
        return self._folder

    @property
    def height_paths(self) -> dict[str, Path]:
        """Files of heights by the section that reads them."""
        return {}

    @property
    def taken_values(self) -> dict[str, float]:
        """Values of a run by dotted key, given or chosen, for which a scene may say `auto`.

        Runs with other such values are other runs. The default has none.
        """
        return {}

    @property
    def chosen_keys(self) -> frozenset[str]:
        """Dotted keys whose values follow from other values of the scene. The default has none."""
        return frozenset()

    @classmethod
    def misspelt_section(cls, data: Mapping[str, Any]) -> str | None:
        """Return a key of plain values that is nearly the section of this kind; None without."""
        return next(iter(get_close_matches(cls.SECTION, data, 1, LIKE_SECTION)), None)

    def check(self, solve: bool = True) -> Findings:
        """Judge all runs of the scene before anything is computed.

        Parameters
        ----------
        solve : bool
            If true, solve a few positions of each run where its kind does so, which tell more than
            closed forms. Default: true.

        Returns
        -------
        Findings
            Quantities and values of each run, and doubts about them; printed, they are a table.

        Raises
        ------
        SceneError
            A contact cannot be made with these values, a height file cannot be used, a package that
            the scene asks for is missing, or its steps are too long.

        Examples
        --------
        >>> import rolling
        >>> len(rolling.read_scene("quickstart").check(solve=False).runs)
        3
        >>> findings = rolling.read_scene("bearing-6204").check()
        >>> {row.key: row.value for row in findings}["BPFO"]
        '92.3 Hz'
        """
        from rolling.kinds.registry import kind_of

        return cast("Findings", kind_of(self).check(self, solve))

    # ---- plain values ----

    def _fill_from(self, values: Mapping[str, Any]) -> None:
        """Take plain values that are given in Python; the name may be missing."""
        self._build({"name": DEFAULT_NAME, **values}, Path(), {(): "scene"}, ())

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        folder: Path = Path(),
        places: Mapping[Key, str] = MappingProxyType({(): "scene"}),
        known: Sequence[Mistake] = (),
    ) -> Self:
        """Build a scene from plain values as `to_dict` gives them.

        All runs of its sweep must be valid.

        Parameters
        ----------
        data : mapping
            Sections of plain values. A key without a value (None) counts as not given.
        folder : Path
            Folder that the relative paths of height files start from.
        places : mapping
            File and line of each key, for messages; the key () is needed.
        known : sequence of Mistake
            Mistakes of the text that the data come from.

        Raises
        ------
        SceneError
            The text, the data, or runs of the sweep have mistakes; all are named, in the order of
            their lines, unless they are too many.
        """
        scene = cls.__new__(cls)
        scene._build(plain_values(data), folder, places, known)
        return scene

    def _build(
        self,
        values: Mapping[str, Any],
        folder: Path,
        places: Mapping[Key, str],
        known: Sequence[Mistake],
    ) -> None:
        """Take plain values; raise SceneError with their mistakes and those of all runs."""
        judged = fill(self, values, known)
        mistakes = [*known, *judged.mistakes]
        if values.get("name") is None:
            mistakes += independent([Mistake(("name",), f"missing; {NAME}")], judged.causes)
        if judged.is_filled:
            self._folder = folder
            self._places = dict(places)
            of_runs, _ = self._judged_runs()
        else:
            of_runs = self._mistakes_of_swept_values(judged.rest)
        mistakes += independent(of_runs, judged.causes)
        if mistakes:
            raise _scene_error(
                mistakes, places, more=None if len(of_runs) > MAX_MISTAKES else judged.more
            )

    def to_dict(self) -> dict[str, Any]:
        """Return plain values with every default filled in.

        The folder and keys without a value are left out.
        """
        data: dict[str, Any] = plain_values(self)
        if not self.sweep:
            del data["sweep"]
        return data

    # ---- changes and runs ----

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
            A key is unknown or ambiguous, or the changed scene has mistakes.

        Examples
        --------
        `scene.with_(load_n=20)`, `scene.with_({"plate.poissons_ratio": 0.3})`,
        `scene.with_(sweep={"rolling.load_n": [5, 20]})`
        """
        if changes is not None and not isinstance(changes, Mapping):
            example = "{'rolling.load_n': 5}, or load_n=5"
            raise TypeError(f"changes: got {changes!r}, allowed: values by key, as in {example}")
        by_key: dict[str, Any] = {}
        mistakes = []
        for name, value in [*(changes or {}).items(), *keys.items()]:
            try:
                key = full_key(name, type(self))
            except SceneError as error:
                mistakes += error.mistakes
                continue
            if key in by_key:
                mistakes.append(f"scene: {key}: given twice")
            by_key[key] = plain_values(value)
        if isinstance(by_key.get("sweep"), dict):
            by_key["sweep"] = self._with_full_keys(by_key["sweep"])
        if mistakes:
            raise SceneError(mistakes)
        data = self._data_to_change(by_key)
        for key in sorted(by_key, key=library.order_of_change):
            data = sweeps.with_value(data, key, by_key[key])
        return type(self).from_dict(data, self.folder)

    def _data_to_change(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Return the plain values that changes by key are made in."""
        return self.to_dict()

    def _with_full_keys(self, sweep: Mapping[Any, Any]) -> dict[Any, Any]:
        """Return a sweep by its dotted keys; a name that stands for no key stays as it is."""
        by_key = {}
        for name, listed in sweep.items():
            try:
                by_key[full_key(name, type(self))] = listed
            except SceneError:  # the sweep is refused with all that is wrong in it
                by_key[name] = listed
        return by_key

    def runs(self) -> list[SweepRun[Self]]:
        """List the runs of the scene; the last swept key varies fastest.

        A scene without a sweep is its own only run.

        Raises
        ------
        SceneError
            A run has mistakes; those of the first such run are named.
        """
        mistakes, runs = self._judged_runs()
        if mistakes:
            raise _scene_error(mistakes, self._places, None if len(mistakes) > MAX_MISTAKES else 0)
        return runs

    def _data_of_runs(self) -> dict[str, Any]:
        """Return the plain values that the runs of the sweep share."""
        data = self.to_dict()
        del data["sweep"]
        return data

    def _judged_runs(self) -> tuple[list[Mistake], list[SweepRun[Self]]]:
        """Return the mistakes of the runs, each once at its swept value, and the runs without any.

        After more than MAX_MISTAKES the other runs are not judged.
        """
        if not self.sweep:
            return [], [SweepRun({}, self)]
        data = self._data_of_runs()
        places = {key: at for key, at in self._places.items() if key[:1] != ("sweep",)}
        runs: list[SweepRun[Self]] = []
        mistakes: dict[
            Mistake, Mistake
        ] = {}  # with the first of its runs, by the mistake without it
        for values, forms in sweeps.product(self.sweep):
            run_data = sweeps.with_values(data, forms)
            try:
                scene = type(self).model_validate(run_data)
            except ValidationError as error:
                for entry in mistakes_of(error, run_data, type(self))[0]:
                    mistakes.setdefault(entry, self._in_sweep(entry, values))
                if len(mistakes) > MAX_MISTAKES:
                    break
                continue
            scene._folder = self._folder
            scene._places = places
            runs.append(SweepRun(values, scene))
        return list(dict.fromkeys(mistakes.values())), runs

    def _in_sweep(self, entry: Mistake, values: Mapping[str, sweeps.Value]) -> Mistake:
        """Return a mistake of a run at its swept value, or with the name of the run."""
        place = sweeps.place_in_sweep(entry.key, values, self.sweep)
        if place is not None:
            return entry._replace(key=place)
        run = sweeps.run_name(values)
        return entry._replace(message=f"{entry.message} (in the run {run} of the sweep)")

    @classmethod
    def _mistakes_of_swept_values(cls, values: Mapping[str, Any]) -> list[Mistake]:
        """Return mistakes of swept values, each judged alone beside sections that make no scene."""
        try:
            sweep = sweeps.check_lists(values.get("sweep") or {}, cls)
        except PydanticCustomError:  # mistakes that are listed already
            return []
        data = {name: section for name, section in values.items() if name != "sweep"}
        mistakes: list[Mistake] = []
        for name, listed in sweep.items():
            for value, form in sweeps.choices(listed)[: MAX_MISTAKES + 1]:
                run_data = sweeps.with_values(data, {name: form})
                try:
                    cls.model_validate(run_data)
                except ValidationError as error:
                    for entry in mistakes_of(error, run_data, cls)[0]:
                        place = sweeps.place_in_sweep(entry.key, {name: value}, sweep)
                        if place is not None:
                            mistakes.append(entry._replace(key=place))
        return mistakes

    def place(self, name: str) -> str:
        """Return file and line (or --set) of a dotted key, for messages."""
        swept: Key = ("sweep", name)
        key = swept if swept in self._places else key_of(name)
        return _place_of(key, self._places)


class PlainScene(SweptScene):
    """Scene with what scenes of every kind have; a kind adds its sections as fields.

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
    sweep : dict
        Lists of values by dotted key, or values by label. All combinations are run.

    Examples
    --------
    >>> import rolling
    >>> class Press(rolling.PlainScene):
    ...     SECTION, TITLE = "load_n", "Scene of a ball that is pressed"
    ...     load_n: float
    >>> Press(name="press", load_n=2).with_(load_n=3).load_n
    3.0
    """

    name: SceneName = Field(default=DEFAULT_NAME, pattern=PATTERN)
    title: str | None = None
    description: str | None = None
    listen_for: str | None = None
    sweep: Annotated[dict[str, Any], WithJsonSchema({"type": "object"})] = Field(default={})

    @field_validator("sweep", mode="before")
    @classmethod
    def _check_sweep(cls, value: Any) -> dict[str, Any]:
        """Return the sweep with its lists as tuples, or refuse it."""
        return sweeps.check_lists(value, cls)


def _place_of(key: Key, places: Mapping[Key, str]) -> str:
    """Return file and line (or --set) of a key, or of the nearest section around it."""
    return next(places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places)


def _scene_error(
    mistakes: Sequence[Mistake], places: Mapping[Key, str], more: int | None
) -> SceneError:
    """Make the error of a scene from its mistakes in the order of their lines, and more of them."""
    placed = [
        entry._replace(place=entry.place or _place_of(entry.key, places)) for entry in mistakes
    ]
    placed.sort(key=lambda entry: order_of_place(entry.place))
    return SceneError(first_mistakes([entry.line for entry in placed], places[()], more))
