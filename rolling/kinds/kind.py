"""What a kind of scene tells: its marches, what it makes of them, and how its runs are shown.

Rooms above know runs, folders, pools, pages and the terminal, and no kind. A kind knows its scene,
its motion, its numbers and its pictures, and neither pools nor folders of sweeps.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rolling.kinds.run_folder import RunFolder
from rolling.scene.swept import SweptScene

if TYPE_CHECKING:  # a scene is read without the solver
    from rolling.kinds.march import March, MarchStore

Read = Callable[[RunFolder, str], Any]  # a run that is done, under a label
Each = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Any]  # calls, in some process


NOT_IN_0_8 = -1


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
    """

    name: ClassVar[str]
    scene_type: ClassVar[type[SweptScene]]
    description: ClassVar[str]
    stored_type: ClassVar[type[Any]]
    former_format: ClassVar[int | None] = NOT_IN_0_8

    # ---- scenes

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

    @abstractmethod
    def resound(self, scene: Any, overrides: Sequence[str]) -> Any:
        """Return the scene of stored runs with other values that need no new march.

        Raises
        ------
        SceneError : a key needs a new solution, or a value is not allowed.
        """

    def kept_scene(self, scene: Any, folder: Path) -> Any:
        """Return the scene of a run in memory as a folder keeps it."""
        return scene

    # ---- marches

    @abstractmethod
    def marches(self, scene: Any, film: bool = False) -> list[March]:
        """Return the marches that a scene without a sweep needs, those of its first sound first."""

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
            What the store kept of each march, in the order of `marches`.

        Raises
        ------
        ContactError
            The marches make no run.
        """

    def write_first_sound(self, place: RunFolder, label: str, marched: Sequence[Any]) -> Path:
        """Write a sound of the first marches of a run, None for the others; return its file."""
        raise NotImplementedError(f"{self.name}: all marches belong to the first sound")

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

    @abstractmethod
    def refuse_edited(self, runs: Sequence[RunFolder]) -> None:
        """Raise SceneError where the height file of a run that is done has other bytes now."""

    @abstractmethod
    def former_stored(self, content: bytes) -> Any:
        """Return the stored numbers of a run of version 0.8 from its summary.json.

        Raises
        ------
        ValueError : it is none.
        """

    @abstractmethod
    def write_with_common_gain(
        self, runs: Sequence[RunFolder], reader_of: Callable[[RunFolder], Read], each: Each
    ) -> None:
        """Write the sounds of the runs of a sweep with the gain that they share."""

    @abstractmethod
    def write_long(
        self, run: Any, seconds: float, speed: float | tuple[float, float] | None, seed: int
    ) -> Path:
        """Write a long record of a run, and say what it is; return its file.

        Raises
        ------
        ValueError : the run has no long record, or a number is not allowed.
        """

    # ---- how runs are shown

    @abstractmethod
    def answer_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the answer of runs as the terminal prints it first."""

    @abstractmethod
    def doubt_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines on doubts and channels below the answer."""

    @abstractmethod
    def further_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return all other lines on runs, for --verbose."""

    @abstractmethod
    def listen_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the lines that name the sounds that a person opens first."""

    def has_figures(self, runs: int) -> bool:
        """Tell whether so many runs get figures beside their page."""
        return True

    @abstractmethod
    def write_figures(self, runs: Sequence[Any], folder: Path) -> None:
        """Write the figures that `rolling run` writes for runs into their folder."""

    @abstractmethod
    def page(self, runs: Sequence[Any], unsolved: Sequence[str], folder: Path | None) -> bytes:
        """Return the page of runs; the folder has their scene file, None for runs in memory."""

    # ---- choices

    @abstractmethod
    def choose(self, scenes: Sequence[Any], folder: Path | None, budget: Any, workers: int) -> Any:
        """Choose between scenes; a folder keeps what is done."""

    @abstractmethod
    def write_choice(self, choice: Any) -> None:
        """Write the files of a choice, and print its answer."""
