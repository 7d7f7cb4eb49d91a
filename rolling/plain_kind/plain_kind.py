"""A kind of scene whose runs are numbers, arrays and a sound, and that has no files of its own.

A new kind begins here: it says which contacts it marches, and what their marches give.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from rolling.archive.archive_file import largest_size
from rolling.archive.definition import Series, Variable
from rolling.check.memory_and_disk import disk
from rolling.check.run_size import run_size
from rolling.contact.processor_time import ProcessorTime
from rolling.kinds.heard_sound import HeardSound
from rolling.kinds.run_folder import LISTEN, RunFolder
from rolling.marches import effort
from rolling.marches.effort import Effort
from rolling.marches.piece import contact_identity
from rolling.plain_kind import plain_lines, plain_run
from rolling.plain_kind.plain_run import (
    SIGNAL,
    MarchedEffort,
    PlainNumbers,
    PlainRun,
    Solved,
    stored_type_of,
)
from rolling.results import shared_lines
from rolling.run.march_files import ContactMarch, MarchesInFiles
from rolling.scene.identity import digest
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:
    from rolling.recordings.compared_run import ComparedRun
    from rolling.recordings.recorded import MeasuredQuantity

_NO_IDENTITY = {"name", "title", "description", "listen_for", "sweep"}  # keys that change no run
PARTS = (effort.COMPILATION, effort.SURFACE, effort.MARCH)  # of the processor time of marches


class PlainKind(MarchesInFiles):
    """A kind of scene whose runs are numbers, arrays and a sound.

    Attributes
    ----------
    name, scene_type, description : str, type, str
        As in `Kind`.
    numbers_type : type
        Numbers of its runs, a data class below `PlainNumbers`.
    variables : tuple of Variable
        Definitions of the arrays of its runs.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> from rolling.plain_kind.plain_run import PlainNumbers, RunSound, Solved
    >>> class Press(rolling.PlainScene):
    ...     SECTION, TITLE = "load_n", "Scene of a ball that is pressed"
    ...     load_n: float
    >>> class PressedBall(rolling.PlainKind):
    ...     name, scene_type, description = "pressed-ball", Press, "A ball that is pressed."
    ...     numbers_type = PlainNumbers
    ...     def marches(self, scene, film=False):
    ...         contact = rolling.read_scene("elastic-plate").with_(load_n=scene.load_n)
    ...         return [rolling.March(contact)]
    ...     def solve(self, scene, marched):
    ...         depth_um = 1e6 * marched[0].approach_m.mean()
    ...         numbers = PlainNumbers(sentences=(f"The ball sinks in by {depth_um:.1f} um.",))
    ...         return Solved(numbers, {}, RunSound(np.zeros(4800), "Pa", "silence"))
    >>> kind = PressedBall()  # which `rolling.register(kind)` adds to those of the program
    >>> kind.marches(Press(name="press", load_n=2))[0].scene.load
    2.0
    """

    numbers_type: ClassVar[type[PlainNumbers]]
    variables: ClassVar[tuple[Variable, ...]] = ()

    def __init_subclass__(cls, **options: Any) -> None:
        """Store the numbers of the class as those of its name; keep the name of the sound free."""
        super().__init_subclass__(**options)
        if any(variable.name == SIGNAL for variable in getattr(cls, "variables", ())):
            raise TypeError(f"{cls.__name__}.variables: {SIGNAL!r} is the sound of a run")
        if "numbers_type" in vars(cls):
            cls.stored_type = stored_type_of(cls.name, cls.numbers_type)

    @abstractmethod
    def solve(self, scene: Any, marched: Sequence[ContactMarch]) -> Solved:
        """Return numbers, arrays and sound of a scene.

        Parameters
        ----------
        scene : scene
            Scene without a sweep.
        marched : sequence of ContactMarch
            Its marches, in the order of `marches`: the approach [m] at each position, the maximum
            pressure and the mean contact area.

        Raises
        ------
        ContactError
            The marches make no run.
        """

    # ---- runs

    def make_run(self, place: RunFolder, label: str, marched: Sequence[ContactMarch]) -> PlainRun:
        """Return the run that its whole marches give, with its numbers."""
        began = ProcessorTime.now()
        solved = self.solve(place.scene, marched)
        whole = Effort()
        for march in {id(march): march for march in marched}.values():  # equal ones count once
            whole.add_piece(effort.MARCH, march.effort)
        spent = ProcessorTime.now().since(began)
        parts = effort.with_work(whole.numbers(PARTS), effort.SOUND, spent)
        numbers = replace(
            solved.numbers,
            name=place.scene.name,
            title=place.scene.title,
            effort=MarchedEffort(march_cpu_s=parts[effort.MARCH], parts_cpu_s=parts),
        )
        return PlainRun(
            values=place.values,
            scene=place.scene,
            folder=place.folder,
            label=label,
            numbers=numbers,
            variables=self.variables,
            arrays=solved.arrays,
            sound=solved.sound,
        )

    def write_run(self, run: PlainRun) -> None:
        """Write the files of a run into its folder, last summary.json."""
        plain_run.write_run(run, self.stored_type, self._identity(run.scene))

    def read_run(self, place: RunFolder, label: str) -> PlainRun:
        """Read a run from its folder, with its stored numbers, under a label."""
        contacts = [march.scene for march in self.marches(place.scene)]
        return plain_run.read_run(
            place,
            label,
            variables=self.variables,
            identity=self._identity(place.scene),
            most_bytes=largest_size(disk([run_size(contact) for contact in contacts])),
        )

    def _identity(self, scene: Any) -> str:
        """Return the digest of the contacts of a scene, and of all its keys but texts and sweep."""
        contacts = [contact_identity(march.scene) for march in self.marches(scene)]
        return digest([contacts, scene.model_dump(mode="json", exclude=_NO_IDENTITY)])

    def sounds(self, run: PlainRun) -> list[HeardSound]:
        """Return the sound of a run."""
        return [plain_run.heard_sound(run)]

    def series(self, run: PlainRun) -> Series:
        """Return the arrays of a run; one of the name of its only dimension tells places."""
        return {variable: run.arrays[variable.name] for variable in self.variables}

    def compared(self, run: PlainRun, quantity: MeasuredQuantity) -> ComparedRun:
        """Return the sound of a run where it is a record of the quantity, by its unit."""
        from rolling.recordings.compared_run import sound_alone

        if run.sound.unit != quantity.unit:
            raise FolderError(
                f"{run.folder}: got --quantity {quantity.name} [{quantity.unit}], and the record of"
                f" the run is in {run.sound.unit}: {run.sound.content}"
            )
        return sound_alone(run.sound.samples, run.sound.content, quantity)

    # ---- how runs are shown

    def answer_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the sentences of a run, or a table of the quantities of several."""
        return plain_lines.answer_lines(done)

    def doubt_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return the doubts about runs, the worst first."""
        return shared_lines.doubt_lines(done)

    def further_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Return all numbers of runs."""
        return plain_lines.number_lines(done)

    def listen_lines(self, done: Sequence[RunFolder]) -> list[str]:
        """Name the sound of the first run."""
        return shared_lines.listen_lines(done, [("listen", LISTEN, "")])

    def sentences(self, runs: Sequence[PlainRun]) -> list[str]:
        """Return the sentences of a run, each with its label where there are several."""
        if len(runs) == 1:
            return list(runs[0].numbers.sentences)
        return [f"{run.label}: {sentence}" for run in runs for sentence in run.numbers.sentences]

    def card_sentence(self, run: PlainRun) -> str:
        """Return the first sentence of the answer."""
        return next(iter(run.numbers.sentences), "")
