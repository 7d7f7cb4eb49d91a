"""Work on a claimed run folder: solving, sound, tables, figures, page, and the states last."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.commands import details
from rolling.commands.run_files import Wanted, page_of, write_run, write_sweep
from rolling.folders import claim, files, new_folder
from rolling.folders.claim import Claim
from rolling.folders.files import Stopped
from rolling.simulation import batch, labels
from rolling.simulation.batch import Run
from rolling.simulation.lacking import lacks_marches
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import is_begun, is_kept
from rolling.terminal import progress

if TYPE_CHECKING:
    from rolling.report.page import Exhibit

PAGE = "report.html"


@dataclass(frozen=True)
class Report:
    """The outcome of a command.

    folder : Path. The run folder.
    runs : list of pairs. The runs with their summaries; None where too few steps are solved.
    failures : dict. Reasons by the label of the run.
    interrupted : bool. Whether the work was interrupted.
    page : Path. File of the report page; None without a page.
    solved : bool. Whether any step is solved.
    previous : Path. Folder of an earlier run that stays beside this run; None without it.
    finished_before : str. Time at which the run was finished before the command; None otherwise.
    """

    folder: Path
    runs: Sequence[tuple[Run, dict[str, Any] | None]]
    failures: dict[str, str]
    interrupted: bool
    page: Path | None
    solved: bool
    previous: Path | None
    finished_before: str | None = None

    @property
    def exit_code(self) -> int:
        """The exit code of the command: 0, 1 for a run that failed, 130 for an interruption."""
        return 130 if self.interrupted else 1 if self.failures else 0


@dataclass(frozen=True)
class Work:
    """The runs of a claimed folder with their results, as far as they are solved.

    held : Claim. The claim on the folder.
    runs : list of Run. The runs in the folder.
    results : list of Result. One result per run.
    wanted : Wanted. The files that are requested.
    """

    held: Claim
    runs: list[Run]
    results: list[Result]
    wanted: Wanted

    @property
    def whole_folders(self) -> bool:
        """Whether each run has all files in its folder."""
        return self.wanted.whole_folders(len(self.runs))

    @property
    def folder(self) -> Path:
        """The claimed folder."""
        return self.held.folder


def solve(work: Work) -> Report:
    """Solve the missing steps of the runs, then write everything else."""
    work.wanted.begun(work.folder)
    names = labels.labels(work.runs)
    sounds: dict[int, RunResult | None] = {}

    def complete(number: int) -> None:
        sounds[number] = _sound(work, number, names[number])
        if sounds[number] is None:
            batch.keep(work.runs[number], work.results[number])

    with told_on_error(lambda: _way_on(work)):
        outcome = batch.solve(
            work.runs,
            work.results,
            work.wanted.workers,
            work.runs[0].scene.name,
            begun=lambda each: work.held.mark(each.folder, "running"),
            complete=complete,
        )
        finished = make_sounds(work, sounds)
        details.tell(work.runs, work.results)
        return finish(work, finished, outcome)


@contextmanager
def told_on_error(way_on: Callable[[], str]) -> Iterator[None]:
    """Add instructions for continuing to an error of the system, such as a full disk."""
    try:
        yield
    except OSError as error:
        raise Stopped(error, way_on()) from error


def _way_on(work: Work) -> str:
    """Describe the kept part of work that the system stopped, and how to continue."""
    folder = work.folder
    kept = (
        f"the steps solved before are kept in {folder}"
        if any(map(is_kept, work.runs))
        else "nothing was solved"
    )
    text = f"{kept}; `rolling resume {folder}` continues when the cause is removed"
    if not work.held.record.replaces:
        return text
    return (
        f"{text}\nthe run that this one replaces stays in {new_folder.previous(folder)} until "
        "this one is done"
    )


def make_sounds(work: Work, made: Mapping[int, RunResult | None]) -> list[RunResult | None]:
    """Make the sound of each run and write its files; None where too few steps are solved.

    Parameters
    ----------
    work : The runs and their results.
    made : The runs that have their sound already, by number.
    """
    names = labels.labels(work.runs)
    sounds: list[RunResult | None] = []
    with progress.bar(len(names), "sound") as bar:
        for number, label in enumerate(names):
            run, result = work.runs[number], work.results[number]
            if number not in made:
                sounds.append(_sound(work, number, label))
            else:  # pictures read the heights once more
                sounds.append(None if batch.other_surface(run, result) else made[number])
            bar.update(1)
    return sounds


def _sound(work: Work, number: int, label: str) -> RunResult | None:
    """Make the sound of a run and write its files; None where too few steps are solved."""
    run, result = work.runs[number], work.results[number]
    if batch.other_surface(run, result):  # the numbers of another surface would be wrong
        return None
    finished = hear(label, run.values, run.folder, run.scene, result)
    if finished is not None:
        write_run(finished, result, work.whole_folders)
    return finished


def finish(work: Work, sounds: Sequence[RunResult | None], outcome: Outcome) -> Report:
    """Write tables and figures of all runs, the page, and the states last.

    Parameters
    ----------
    work : The runs and their results.
    sounds : Each run with its sound, whose files are written; None where too few steps are solved.
    outcome : The outcome of solving.
    """
    finished = [each for each in sounds if each is not None]
    names = labels.labels(work.runs)
    summaries = [None if each is None else each.summary for each in sounds]
    if len(work.runs) > 1:
        write_sweep(work.folder, work.runs, names, summaries)
    exhibits = []
    if finished and work.wanted.pictures is not False:
        exhibits = write_pictures(work.folder, finished, work.wanted)
    if exhibits:
        unsolved = [label for label, each in zip(names, sounds, strict=True) if each is None]
        with progress.step("writing the page"):
            files.write_bytes(work.folder / PAGE, page_of(finished, exhibits, unsolved))
    previous = _mark_all(work, outcome)
    return Report(
        work.folder,
        list(zip(work.runs, summaries, strict=True)),
        {names[number]: reason for number, reason in outcome.failures.items()},
        outcome.interrupted,
        work.folder / PAGE if exhibits else None,
        any(map(is_begun, work.results)),
        previous,
    )


def _mark_all(work: Work, outcome: Outcome) -> Path | None:
    """Write the state of each run and of the folder.

    The folder is done when all runs are done, and failed when any run has failed.

    Returns
    -------
    previous : The folder of an earlier run that stays beside this run.
    """
    held, failures = work.held, outcome.failures
    for number, (each, result) in enumerate(zip(work.runs, work.results, strict=True)):
        if each.folder == held.folder:
            continue
        if number in failures:
            held.mark(each.folder, "failed", failures[number])
        elif not lacks_marches(each.scene, result):
            held.mark(each.folder, "done")
        elif is_begun(result) or outcome.interrupted:
            held.mark(each.folder, "waiting", claim.INTERRUPTED)
    if outcome.interrupted:
        held.mark(held.folder, "waiting", claim.INTERRUPTED)
    elif failures:
        first, runs = next(iter(failures.values())), len(work.runs)
        held.mark(
            held.folder,
            "failed",
            first if runs == 1 else f"{len(failures)} of {runs} runs: {first}",
        )
    elif all(result.complete for result in work.results):
        held.mark(held.folder, "done")
        return new_folder.drop_previous(held)
    else:  # new sound of an incomplete run
        held.mark(held.folder, "waiting", "its result is a part")
    return new_folder.previous(held.folder) if held.record.replaces else None


def write_pictures(
    folder: Path, runs: Sequence[RunResult], wanted: Wanted
) -> list[tuple[RunResult | None, Exhibit]]:
    """Write the figures of each run into its folder, and the comparisons into the shared folder.

    Returns
    -------
    exhibits : The figures for the page; empty if no page is requested.
    """
    # Matplotlib is slow to import, and a failed run does not need it.
    from rolling.commands import drawing

    of_each = wanted.whole_folders(len(runs))
    return drawing.draw(folder, runs, of_each, wanted.page, wanted.workers)
