"""First answers: short runs that are solved before the runs of a folder for which they stand.

A pilot is a run of its own, in the folder of the pieces. It is no part of the record of its run.
Its number with a wide ± is said on the terminal, and stands in a file of the folder of its run. Its
sound stands in the place of that of its run, and a page of all pilots in the place of the page,
until the whole ones replace them.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from acoustics.texts import printable
from rolling.kinds.kind import Kind
from rolling.kinds.needed_marches import March
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import LISTEN, PAGE, RESULT, RunFolder
from rolling.marches.piece import contact_identity
from rolling.results.stored_numbers import read_stored
from rolling.run import folder as folders
from rolling.run.kept_runs import KeptRuns
from rolling.scene.identity import scene_identity
from rolling.terminal import progress
from rolling.terminal.streams import folded
from rolling.terminal.whole_files import FolderError, make_below, read_regular, write_bytes

FIRST = "first"  # folder of the pilots, in that of the pieces
NOTICE = (
    "These are first answers: of short tracks with a surface of their own, or of a bearing whose"
    " rough contacts are linear. The whole runs replace this page."
)
_MAX_SOUND = 2**28  # bytes of a sound that is copied


class PilotRun(NamedTuple):
    """A pilot, and the run for which it stands.

    place : RunFolder. Scene and folder of the pilot.
    run : RunFolder. The run for which it stands.
    label : str. Label of both.
    marches : list of March. The marches that the pilot needs.
    words : str. What the pilot has solved.
    """

    place: RunFolder
    run: RunFolder
    label: str
    marches: list[March]
    words: str


class Pilots:
    """Pilots of the runs of a folder that are not done; runs with equal contacts share one."""

    def __init__(
        self, kind: Kind, folder: Path, runs: Sequence[RunFolder], labels: Sequence[str]
    ) -> None:
        """Find the pilots of runs; those of an earlier command are known already."""
        self._page = folder / PAGE
        self._folder = folder
        self._first = folder / folders.PIECES / FIRST
        self.kept = KeptRuns(self._first)
        self.all: list[PilotRun] = []
        known = set[str]()  # what the pilots answer
        for run, label in zip(runs, labels, strict=True):
            pilot = kind.pilot(run.scene)
            if pilot is None:
                continue
            answered = {contact_identity(march.scene) for march in pilot.marches}
            if pilot.is_of_one_run:
                answered = {scene_identity(pilot.scene)}
            if answered <= known:
                continue
            known |= answered
            place = RunFolder(run.values, pilot.scene, self._first / run.folder.relative_to(folder))
            self.all.append(
                PilotRun(
                    place=place, run=run, label=label, marches=pilot.marches, words=pilot.words
                )
            )
        self._written = set[Path]()  # folders of pilots whose answer stands in that of their run
        self.lacking = [pilot for pilot in self.all if not pilot.place.is_done]

    def make_folder(self) -> None:
        """Make the folder of the pilots, which a link must not lead elsewhere."""
        if self.lacking:
            make_below(self._folder, self._first)

    def tell(self, pilot: PilotRun) -> None:
        """Say what a pilot has found, and put answer and sound in the place of those of its run."""
        numbers = read_stored(pilot.place.folder).numbers
        words = f"{kind_of(pilot.place.scene).first_answer(numbers)}, after {pilot.words}"
        name = f"{printable(pilot.label)}: " if len(self.all) > 1 else ""
        self._write_files(pilot, words)
        progress.line(folded(f"{name}{words}; going on"))
        if pilot.place.folder in self._written and len(self._written) == 1:
            progress.line(f"the first sound: {pilot.run.folder / LISTEN}")

    def _write_files(self, pilot: PilotRun, words: str) -> None:
        """Put answer and sound of a pilot in the place of those of its run."""
        if (pilot.run.folder / RESULT).is_file():  # whose sound is there, or comes
            return
        with suppress(OSError, FolderError):  # the sound of the run is what counts
            sound = read_regular(pilot.place.folder / LISTEN, _MAX_SOUND)
            make_below(pilot.run.home, pilot.run.folder)
            text = f"A first answer, which the whole run will replace: {words}.\n"
            write_bytes(pilot.run.folder / folders.FIRST_ANSWER, text.encode())
            write_bytes(pilot.run.folder / LISTEN, sound)
            self._written.add(pilot.place.folder)

    def replace(self, run: RunFolder) -> None:
        """Remove the first answer of a run that is done."""
        with suppress(OSError):  # no file, or none that can be removed
            (run.folder / folders.FIRST_ANSWER).unlink(missing_ok=True)

    @property
    def are_told(self) -> bool:
        """Whether all pilots are done."""
        return bool(self.all) and all(pilot.place.is_done for pilot in self.all)

    @property
    def page_arguments(self) -> tuple[KeptRuns, list[RunFolder], str, Path]:
        """Arguments of the function that writes their page."""
        return self.kept, [pilot.place for pilot in self.all], NOTICE, self._page
