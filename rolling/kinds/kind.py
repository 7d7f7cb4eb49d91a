"""What a kind of scene tells: its marches, what it makes of them, and how its runs are shown.

Rooms above know runs, folders, pools, pages and the terminal, and no kind. A kind knows its scene,
its motion, its numbers and its pictures, and neither pools nor folders of sweeps. The kinds of the
program are in `rolling.ball_kinds` and `rolling.bearing_kind`, and a new one begins with
`rolling.plain_kind`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from rolling.kinds.run_folder import RunFolder
from rolling.numbers import views
from rolling.numbers.conditions import Condition, Method
from rolling.numbers.quantity import Quantity
from rolling.scene import file
from rolling.scene.swept import SweptScene
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:  # a scene is read without the solver
    from rolling.archive.definition import Series
    from rolling.kinds.figure_kind import FigureKind
    from rolling.kinds.heard_sound import FileGain, HeardSound
    from rolling.kinds.machine import Machine
    from rolling.kinds.needed_marches import March, MarchStore
    from rolling.kinds.page_parts import PageParts
    from rolling.numbers.sheet import Sheet

NOT_IN_0_8 = -1


class Still(NamedTuple):
    """A field of pixels of a run, such as its contact seen from above.

    png : str. The picture, a PNG in a data URI.
    words : str. What it shows, for those who do not see it.
    at : int. Where it is looked at, percent of its width.
    """

    png: str
    words: str
    at: int = 50


class Pilot(NamedTuple):
    """A short run that gives the first answer, and is no part of the run for which it stands.

    scene : scene. The scene of the short run.
    marches : list of March. The marches that it needs, the first ones of its scene, or none.
    words : str. What it has solved, such as 1,000 steps.
    is_of_one_run : bool. Whether another run with these marches needs a pilot of its own.
    """

    scene: Any
    marches: list[March]
    words: str
    is_of_one_run: bool = False


class Kind(ABC):
    """A kind of scene.

    Attributes
    ----------
    name : str
        Name, such as ball, which files of its runs have.
    scene_type : type
        Class of its scenes.
    description : str
        What its scenes describe, for the JSON Schema.
    stored_type : type
        What the numbers of a run are stored as, a data class with format, kind, numbers, files and
        provenance.
    former_format : int or None
        What version 0.8 wrote as the format of a summary.json, None where it wrote no format;
        NOT_IN_0_8 for a kind that it did not know.
    noise : str
        Words for what its pages are about. Default: contact noise.
    gallery_note : str
        What the numbers and pictures of its cards mean. Default: empty.
    card_figure : str
        Name of the figure of one run that its card shows as a chart. Default: none.
    leading : tuple of str
        Columns of runs.csv that are plotted unasked, the first one leads. Default: the values of
        all quantities.
    """

    name: ClassVar[str]
    scene_type: ClassVar[type[SweptScene]]
    description: ClassVar[str]
    stored_type: ClassVar[type[Any]]
    former_format: ClassVar[int | None] = NOT_IN_0_8
    noise: ClassVar[str] = "contact noise"
    gallery_note: ClassVar[str] = ""
    card_figure: ClassVar[str] = ""
    leading: ClassVar[tuple[str, ...]] = ()

    # ---- scenes

    def of_scene(self, scene: Any) -> Kind:
        """Return the kind of a scene: this one, or one of its name that tells more."""
        return self

    @abstractmethod
    def refuse(
        self, scene: Any, workers: int, folder: Path | None, unsolved: Sequence[Any] | None = None
    ) -> None:
        """Refuse a scene, with or without a sweep, that cannot be run here.

        Parameters
        ----------
        scene : scene
            The scene.
        workers : int
            Number of processes; 0 means one per core.
        folder : Path or None
            Folder of the results; None if nothing is written.
        unsolved : sequence of scene, optional
            Runs whose files the folder lacks. Default: all.

        Raises
        ------
        SceneError
            Memory or disk do not suffice, a package is missing, or a height file cannot be used.
        """

    @abstractmethod
    def check(self, scene: Any, solve: bool = True) -> Any:
        """Judge all runs of a scene before anything is computed; solve a contact if asked to."""

    @abstractmethod
    def conclusion(self, scene: Any, findings: Any) -> str:
        """State in a sentence how long a scene takes, and with which verdict at best."""

    @abstractmethod
    def lines_in_short(self, scene: Any, findings: Any) -> list[str]:
        """Return the conclusion of a check, and the lines that a person reads first."""

    def resound(self, scene: Any, overrides: Sequence[str]) -> Any:
        """Return the scene of stored runs with other values, which its marches have to allow.

        Raises
        ------
        SceneError : a value is not allowed.
        """
        return file.with_overrides(scene, overrides)

    def with_heights(self, scene: Any, heights: Any) -> Any:
        """Return a scene on other heights in place of its surface.

        Raises
        ------
        TypeError : scenes of this kind have no such surface.
        """
        raise TypeError(f"heights: got some, and a scene of a {self.name} has no one surface")

    def kept_scene(self, scene: Any, folder: Path) -> Any:
        """Return the scene of a run in memory as a folder keeps it."""
        return scene

    # ---- marches

    @abstractmethod
    def marches(self, scene: Any, film: bool = False) -> list[March]:
        """Return the marches that a scene without a sweep needs, those of its pilot first."""

    def pilot(self, scene: Any) -> Pilot | None:
        """Return a short run that tells a first answer of a scene without a sweep.

        None, the default, where a scene has none, or is short itself.
        """
        return None

    def first_answer(self, numbers: Any) -> str:
        """Say what a pilot has found, from its numbers; by default the quantity that leads."""
        subject, quantity = next(iter(self.quantities(numbers).items()))
        return f"{subject[:1].lower()}{subject[1:]} {quantity}"

    @abstractmethod
    def march_store(
        self,
        folder: Path | None = None,
        done: Sequence[RunFolder] = (),
        sources: Sequence[RunFolder] = (),
    ) -> MarchStore:
        """Return the place of the marches of runs.

        Parameters
        ----------
        folder : Path or None
            Folder of the runs; None where nothing is written.
        done : sequence of RunFolder
            Runs of the folder that are done, whose marches are taken.
        sources : sequence of RunFolder
            Runs elsewhere that are done, whose marches are taken.
        """

    @abstractmethod
    def take_marches(
        self, start_from: Path, elsewhere: Sequence[RunFolder], own: Sequence[RunFolder]
    ) -> Sequence[RunFolder]:
        """Return runs elsewhere whose marches own runs lack, and say what is taken and what not."""

    # ---- runs

    @abstractmethod
    def make_run(self, place: RunFolder, label: str, marched: Sequence[Any]) -> Any:
        """Return the run that its whole marches give, with its numbers.

        Parameters
        ----------
        place : RunFolder
            Scene, swept values and folder.
        label : str
            Label of the run.
        marched : sequence
            What the store kept of each march, in the order of `marches`; of a pilot, of its own
            marches.

        Raises
        ------
        ContactError
            The marches make no run.
        """

    @abstractmethod
    def write_run(self, run: Any) -> None:
        """Write the files of a run into its folder, last summary.json."""

    @abstractmethod
    def read_run(self, place: RunFolder, label: str) -> Any:
        """Read a run from its folder, with its stored numbers, under a label.

        Raises
        ------
        FolderError : a file is missing or damaged, or the result is that of another scene.
        """

    def refuse_edited(self, runs: Sequence[RunFolder]) -> None:
        """Raise SceneError where the height file of a run that is done has other bytes now.

        By default nothing is done: the identity of a march holds the digest of its heights.
        """
        return

    def former_stored(self, content: bytes) -> Any:
        """Return the stored numbers of a run of version 0.8 from its summary.json.

        Raises
        ------
        ValueError : it is none.
        """
        raise ValueError(f"numbers of version 0.8, which knew no {self.name}")

    # ---- sounds of runs

    def sounds(self, run: Any) -> Sequence[HeardSound]:
        """Return the sounds of a run that a person listens to, that of listen.wav first."""
        return ()

    def file_gains(self, stored: Any) -> Iterable[FileGain]:
        """Return the gains of the sound files of a run that share a gain with other runs.

        The default finds all facts of plain sounds among the facts of the files.
        """
        from rolling.kinds.heard_sound import plain_gains

        return plain_gains(stored.files)

    def write_long(
        self,
        run: Any,
        seconds: float,
        speed: float | tuple[float, float] | None,
        seed: int,
        reverberation_s: float | None,
    ) -> Path:
        """Write a long record of a run, and say what it is; return its file.

        With a reverberation time [s] it is heard in a room, for listening only.

        Raises
        ------
        ValueError : the run has no long record, or a number is not allowed.
        """
        raise ValueError(f"a run of a {self.name} has no record longer than its own")

    def series(self, run: Any) -> Series:
        """Return the arrays of a run that a Dataset of a sweep has."""
        return {}

    def compared(self, run: Any, quantity: Any) -> Any:
        """Return the records of a run of a measured quantity, for comparison with recordings.

        Raises
        ------
        FolderError : the run has none; the message says which ones it has.
        """
        raise FolderError(f"{run.folder}: a run of a {self.name} has no record of {quantity.name}")

    # ---- how runs are shown

    @abstractmethod
    def answer_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the answer of runs as the terminal prints it first."""

    def html_answer(self, done: Sequence[RunFolder]) -> str:
        """Return the answer of runs as HTML for a notebook; by default that of the terminal."""
        return f"<pre>{escape(chr(10).join(self.answer_lines(done)))}</pre>"

    @abstractmethod
    def doubt_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines on doubts and channels below the answer."""

    @abstractmethod
    def further_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return all other lines on runs, for --verbose."""

    @abstractmethod
    def listen_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines that name the sounds that a person opens first."""

    def quantities(self, numbers: Any) -> Mapping[str, Quantity]:
        """Return the numbers that lead, by the names that people read, the first one first.

        The default has all quantities of the numbers.
        """
        return views.quantities(numbers)

    def number_rows(self, every: Sequence[Any]) -> Sequence[views.NumberRow]:
        """Return the rows of the table of all numbers of runs.

        The default has the single numbers that runs.csv has.
        """
        return views.table_rows(every)

    def card_sentence(self, run: Any) -> str:
        """Return what follows from a run in a sentence; empty without one."""
        return ""

    def heard(self, run: Any, is_alone: bool) -> str:
        """Say what one hears of a run, and what is special about it unless it is alone."""
        from rolling.kinds.heard_sound import played_sound

        sound = played_sound(self.sounds(run))
        return "" if sound is None else f"You hear: {sound.words}."

    def still(self, run: Any) -> Still | None:
        """Return a field of pixels of a run for its card; None without one."""
        return None

    def machine(self, scenes: Sequence[Any], numbers: Sequence[Any] = ()) -> Machine | None:
        """Return the drawing of what scenes describe, with its numbers on it; None without one.

        Parameters
        ----------
        scenes : sequence of scenes, at least one
            Scenes of this kind, without a sweep. The first is drawn, and numbers in which they
            differ are listed.
        numbers : sequence of numbers, optional
            Those of solved runs of these scenes. Default: none is solved.
        """
        return None

    def figures(self) -> Mapping[str, FigureKind]:
        """Return the figures that runs of this kind may have, by name; the first one leads."""
        return {}

    def subject(self, runs: Sequence[Any]) -> str:
        """Say what runs of one scene are about, for the title of a page: what rolls on what.

        The default is the name of the scene.
        """
        return str(runs[0].scene.name)

    def sentences(self, runs: Sequence[Any]) -> Sequence[str]:
        """Return the sentences with which the page of runs begins, the most important one first."""
        return ()

    def page_parts(self, runs: Sequence[Any]) -> PageParts:
        """Return what the page of runs has beside the parts of all pages.

        The default has nothing: the page has sentences, quantities, players of all sounds, doubts,
        all numbers, and how to make the runs again.
        """
        from rolling.kinds.page_parts import PageParts

        return PageParts()

    def prepare_page(self, run: Any) -> bool:
        """Make what a page shows of a run alone, and keep it in a property of `MADE_ONCE`.

        Return whether the run has something that it had not. The default makes nothing. A page has
        the same bytes whether it was prepared or not.
        """
        return False

    # ---- conditions

    def conditions(self, scene: Any) -> Sequence[Condition]:
        """Return the conditions of a scene without a sweep, which stand beside each answer.

        They follow from the scene alone. The default has its name.
        """
        return [Condition("scene", str(scene.name))]

    def method(self, scene: Any) -> Method:
        """Return how the numbers of a scene are computed, for a paragraph on methods.

        The default says that they are.
        """
        return Method(motion=f"A {self.name} was simulated.", computed="")

    # ---- sheets

    def sheets(self, run: Any) -> Sequence[Sheet]:
        """Return the sheets of a run that people hand on, from what is stored of it.

        The page of a run has them. The default has none: runs of this kind declare nothing.
        """
        return ()

    def surface_sheets(self, run: Any) -> Sequence[Sheet]:
        """Return the sheets of the surfaces of a run, whose heights are made anew.

        Nothing is marched. The default has none.
        """
        return ()

    # ---- choices

    def audition(self) -> Any | None:
        """Return how scenes of this kind are compared, an Audition of the room of choices.

        None where they are compared by the sound of their runs on specimens with other seeds.
        """
        return None
