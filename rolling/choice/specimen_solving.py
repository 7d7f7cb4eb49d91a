"""Solve the specimens of a choice that its folder lacks, on all cores."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rolling.choice.heard_specimen import Specimen
from rolling.choice.omissions import forget, remember
from rolling.contact.solver import ContactError
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RunFolder
from rolling.marches.piece import contact_identity
from rolling.run import folder as folders
from rolling.run.executor import RunFiles, RunLoop
from rolling.run.pools import Pool
from rolling.terminal import progress, system_errors, whole_files

Finish = Callable[[RunFolder, str, Sequence[Any]], None]


class Solver(ABC):
    """Solves specimens in the folder of a choice, and writes what is heard of them."""

    @abstractmethod
    def solve(
        self, specimens: Sequence[Specimen], names: Sequence[str], stored: Sequence[Specimen]
    ) -> None:
        """Solve specimens that are not heard yet, and write their files.

        A specimen whose contact has no solution gets a file that says so, and the others go on.

        Parameters
        ----------
        specimens, names : sequences. The specimens, and what they are called in messages.
        stored : sequence of Specimen. Specimens that may be done, whose marches are taken.

        Raises
        ------
        ContactError : a specimen failed for another reason. Finished ones are kept.
        OSError, KeyboardInterrupt : finished pieces and specimens are kept.
        """


def prepare(folder: Path, specimen: Specimen) -> None:
    """Make the folder of a specimen that is not heard yet, with its scene.

    Raises
    ------
    FolderError : the folder holds something else.
    """
    whole_files.make_below(folder, specimen.folder)
    forget(specimen)
    if not folders.refuse_other(specimen.folder, specimen.scene):
        folders.write_scene(specimen.folder, specimen.scene)


class RunSolver(Solver):
    """Solves each specimen as a run of its own.

    folder : Path. Folder of the choice.
    pool : Pool. Its processes march.
    bar : Bar. It receives the expected time of pieces [s].
    finish : function. It writes the files of a run and what is heard of it, in a process.
    hear_stored : function. It writes what is heard of a specimen whose run is done.
    """

    def __init__(
        self,
        *,
        folder: Path,
        pool: Pool,
        bar: progress.Bar,
        finish: Finish,
        hear_stored: Callable[[Specimen], None],
    ) -> None:
        self._folder = folder
        self._pool = pool
        self._bar = bar
        self._finish = finish
        self._hear_stored = hear_stored

    def solve(
        self, specimens: Sequence[Specimen], names: Sequence[str], stored: Sequence[Specimen]
    ) -> None:
        """Solve specimens that are not heard yet, and write their files."""
        lacking: list[Specimen] = []
        labels: list[str] = []
        for specimen, name in zip(specimens, names, strict=True):
            if specimen.is_done and not specimen.is_heard:  # a kill came between the two
                try:
                    self._hear_stored(specimen)
                except ContactError as error:
                    remember(self._folder, specimen, str(error))
                    continue
            if not (specimen.is_done and specimen.is_heard):
                prepare(self._folder, specimen)
                lacking.append(specimen)
                labels.append(name)
        if lacking:
            self._march(lacking, labels, [specimen for specimen in stored if specimen.is_done])

    def _march(
        self, lacking: Sequence[Specimen], labels: Sequence[str], done: Sequence[Specimen]
    ) -> None:
        """March the contacts of specimens, and remember those without a solution."""
        kind = kind_of(lacking[0].scene)
        run_files = RunFiles(runs=lacking, labels=labels, folder=self._folder, finish=self._finish)
        store = kind.march_store(self._folder, done)
        with progress.step("estimating the time of the marches"):
            needed = [kind.marches(specimen.scene) for specimen in lacking]
            loop = RunLoop(needed, store, self._bar, run_files)
        identities = [[contact_identity(march.scene) for march in of_one] for of_one in needed]
        with kept_advice(self._folder):
            for _ in loop.finished_runs(self._pool):
                pass
        for number, reason in loop.failures.items():
            # A height file that was replaced meanwhile says nothing of the contact of its scene.
            now = [contact_identity(march.scene) for march in needed[number]]
            if number not in loop.without_solution or now != identities[number]:
                raise ContactError(f"{labels[number]}: {reason}")
            progress.line(f"{labels[number]} is left out: {reason}")
            remember(self._folder, lacking[number], reason)
            for identity in identities[number]:
                folders.drop_pieces(self._folder, identity)


@contextmanager
def kept_advice(folder: Path) -> Iterator[None]:
    """Say what is kept where the work is interrupted or a disk is full."""
    advice = f"finished pieces are kept in {folder}; the same command goes on"
    try:
        yield
    except OSError as error:
        raise OSError(f"{system_errors.sentence(error)}\n{advice}") from error
    except KeyboardInterrupt:
        progress.line(advice)
        raise
