"""Solve the specimens of a choice that its folder lacks, on all cores."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rolling.choice.heard import Specimen, finish_specimen, write_heard
from rolling.choice.omissions import forget, remember
from rolling.contact.solver import ContactError
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RESULT
from rolling.marches.piece import contact_identity
from rolling.results import result_file
from rolling.run import folder as folders
from rolling.run.executor import RunFiles, RunLoop
from rolling.run.pools import Pool
from rolling.terminal import files, progress, system_errors


def solve(
    folder: Path,
    specimens: Sequence[Specimen],
    labels: Sequence[str],
    stored: Sequence[Specimen],
    pool: Pool,
    bar: progress.Bar,
) -> None:
    """Solve specimens that are not heard yet, and write their files.

    Parameters
    ----------
    folder : Path. Folder of the choice.
    specimens, labels : sequences. The specimens, and what they are called in messages.
    stored : sequence of Specimen. Specimens that may be done, whose marches are taken.
    pool : Pool. Its processes march.
    bar : Bar. It receives the expected time of pieces [s].

    A specimen whose contact has no solution gets a file that says so, and the others go on.

    Raises
    ------
    ContactError : a specimen failed for another reason. Finished ones are kept.
    OSError, KeyboardInterrupt : as `RunLoop`. Finished pieces are kept.
    """
    lacking = []
    names = []
    for specimen, name in zip(specimens, labels, strict=True):
        if specimen.is_done and not specimen.is_heard:  # a kill came between the two
            result = result_file.read_result(specimen.folder / RESULT, specimen.scene)
            try:
                write_heard(specimen, result)
            except ContactError as error:
                remember(folder, specimen, str(error))
                continue
        if not specimen.is_heard:
            files.make_below(folder, specimen.folder)
            forget(specimen)
            if not folders.refuse_other(specimen.folder, specimen.scene):
                folders.write_scene(specimen.folder, specimen.scene)
            lacking.append(specimen)
            names.append(name)
    if not lacking:
        return
    kind = kind_of(lacking[0].scene)
    run_files = RunFiles(runs=lacking, labels=names, folder=folder, finish=finish_specimen)
    done = [specimen for specimen in stored if specimen.is_done]
    store = kind.march_store(folder, done)
    with progress.step("estimating the time of the marches"):
        needed = [kind.marches(specimen.scene) for specimen in lacking]
        loop = RunLoop(needed, store, bar, run_files)
    marches = [contact_identity(specimen.scene) for specimen in lacking]
    with _kept_advice(folder):
        for _ in loop.finished_runs(pool):
            pass
    for number, reason in loop.failures.items():
        # A height file that was replaced meanwhile says nothing of the contact of its scene.
        is_same = contact_identity(lacking[number].scene) == marches[number]
        if number not in loop.without_solution or not is_same:
            raise ContactError(f"{names[number]}: {reason}")
        progress.line(f"{names[number]} is left out: {reason}")
        remember(folder, lacking[number], reason)
        folders.drop_pieces(folder, marches[number])


@contextmanager
def _kept_advice(folder: Path) -> Iterator[None]:
    """Say what is kept where the work is interrupted or a disk is full."""
    advice = f"finished pieces are kept in {folder}; the same command goes on"
    try:
        yield
    except OSError as error:
        raise OSError(f"{system_errors.sentence(error)}\n{advice}") from error
    except KeyboardInterrupt:
        progress.line(advice)
        raise
