"""Work on a claimed run folder: solving, sound, tables, figures, page, and the states last."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rolling.commands import details, run_tasks, table
from rolling.commands.run_files import Wanted, write_run, write_sweep
from rolling.commands.run_tasks import Ends
from rolling.folders import claim, files, new_folder
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Stopped, Unwritable
from rolling.folders.run_record import RunRecord
from rolling.simulation import batch, chosen_tolerances, labels
from rolling.simulation.batch import Run
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import is_begun, is_kept, warn_of_other_program
from rolling.terminal import progress

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
    unmade : list of str. Pictures and pages that could not be made, with their errors.
    """

    folder: Path
    runs: Sequence[tuple[Run, dict[str, Any] | None]]
    failures: dict[str, str]
    interrupted: bool
    page: Path | None
    solved: bool
    previous: Path | None
    finished_before: str | None = None
    unmade: Sequence[str] = ()

    @property
    def exit_code(self) -> int:
        """The exit code of the command: 0, 1 where something failed, 130 for an interruption."""
        return 130 if self.interrupted else 1 if self.failures or self.unmade else 0


@dataclass(frozen=True)
class Work:
    """The runs of a claimed folder with their results, as far as they are solved.

    held : Claim. The claim on the folder.
    runs : list of Run. The runs in the folder.
    results : list of Result. One result per run; empty where each run is a task.
    wanted : Wanted. The files that are requested.
    take_over : bool. Whether claims that cannot be judged from here are ignored. Default: false.
    """

    held: Claim
    runs: list[Run]
    results: list[Result]
    wanted: Wanted
    take_over: bool = False

    @property
    def whole_folders(self) -> bool:
        """Whether each run has all files in its folder."""
        return self.wanted.whole_folders(len(self.runs))

    @property
    def folder(self) -> Path:
        """The claimed folder."""
        return self.held.folder


def work_on(
    held: Claim, runs: list[Run], wanted: Wanted, before: RunRecord | None, take_over: bool = False
) -> Work:
    """Return the work on a claimed folder, with stored results where its runs are not tasks.

    Parameters
    ----------
    before : RunRecord. The record of the folder before it was claimed; None for a new folder, whose
        results are empty.
    """
    if run_tasks.are_tasks(runs, wanted):
        if before is not None:
            warn_of_other_program(held.folder, before, before.state != "done")
        return Work(held, runs, [], wanted, take_over)
    results = [
        chosen_tolerances.stored_or_empty(each)
        if before
        else Result.empty(each.scene.track, each.scene.start)
        for each in runs
    ]
    if before is not None:
        partly = any(is_begun(result) and not result.complete for result in results)
        warn_of_other_program(held.folder, before, partly)
    return Work(held, runs, results, wanted, take_over)


def solve(work: Work) -> Report:
    """Solve the missing steps of the runs, then write everything else."""
    work.wanted.begun(work.folder)
    with told_on_error(work.folder, lambda: _way_on(work)):
        if not work.results:
            outcome, ends = run_tasks.solve(work.held, work.runs, work.wanted, work.take_over)
            return finish(work, ends, outcome)
        noted = work.held.note_trial
        if chosen_tolerances.choose_tolerances(work.runs, work.results, work.wanted.solvers, noted):
            outcome = Outcome(interrupted=True)
            return finish(work, make_sounds(work, {}, outcome), outcome)
        details.tell_releases([each.scene for each in work.runs], work.results)
        outcome, ends = _solve_pieces(work, work.wanted.shows_each(len(work.runs)))
        details.tell(work.runs, work.results)
        return finish(work, ends, outcome)


def solve_releases(work: Work) -> Report:
    """Solve the releases under the moving load that stored runs lack, then write everything."""
    work.wanted.begun(work.folder)
    with told_on_error(work.folder, lambda: _way_on(work)):
        outcome, ends = _solve_pieces(work, filmed=False)
        return finish(work, ends, outcome)


def _solve_pieces(work: Work, filmed: bool) -> tuple[Outcome, Ends]:
    """Solve pieces of the runs on all cores, and make the sound of each run in this process."""
    names = labels.labels(work.runs)
    sounds: dict[int, RunResult | None] = {}

    def complete(number: int) -> None:
        sounds[number] = _sound(work, number, names[number])
        if sounds[number] is None:
            batch.keep(work.runs[number], work.results[number])

    outcome = batch.solve(
        work.runs,
        work.results,
        work.wanted.solvers,
        work.runs[0].scene.name,
        begun=lambda each: work.held.mark(each.folder, "running"),
        complete=complete,
        filmed=filmed,
    )
    return outcome, make_sounds(work, sounds, outcome)


@contextmanager
def told_on_error(folder: Path, way_on: Callable[[], str]) -> Iterator[None]:
    """Add instructions for continuing to an error of the system, such as a full disk.

    Parameters
    ----------
    folder : The folder into which the work is written.
    way_on : It returns the instructions.
    """
    try:
        with files.writing(folder):
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


def make_sounds(work: Work, made: Mapping[int, RunResult | None], outcome: Outcome) -> Ends:
    """Make the sound of each run and write its files.

    A run of a sweep fails alone whose folder cannot be written.

    Parameters
    ----------
    work : The runs and their results.
    made : The runs that have their sound already, by number.
    outcome : The outcome of solving, which gets the failures.
    """
    names = labels.labels(work.runs)
    sounds: list[RunResult | None] = []
    with progress.bar(len(names), "sound") as bar:
        for number, label in enumerate(names):
            run, result = work.runs[number], work.results[number]
            if number not in made:
                sounds.append(_sound_or_failure(work, number, label, outcome))
            else:  # pictures read the heights once more
                sounds.append(None if batch.other_surface(run, result) else made[number])
            bar.update(1)
    return Ends.of(work.runs, work.results, sounds)


def _sound_or_failure(work: Work, number: int, label: str, outcome: Outcome) -> RunResult | None:
    """Make the sound of a run and write its files; None where they cannot be written alone."""
    try:
        with files.writing(work.runs[number].folder):
            return _sound(work, number, label)
    except Unwritable as error:
        if error.everywhere or len(work.runs) == 1:
            raise
        outcome.failures.setdefault(number, str(error))
        return None


def _sound(work: Work, number: int, label: str) -> RunResult | None:
    """Make the sound of a run and write its files; None where too few steps are solved."""
    run, result = work.runs[number], work.results[number]
    if batch.other_surface(run, result):  # the numbers of another surface would be wrong
        return None
    finished = hear(label, run.values, run.folder, run.scene, result)
    if finished is not None:
        write_run(finished, result, work.whole_folders)
    return finished


def finish(work: Work, ends: Ends, outcome: Outcome) -> Report:
    """Write tables and figures of all runs, the page, and the states last.

    Parameters
    ----------
    work : The runs and their results.
    ends : The runs with their sound, whose files are written.
    outcome : The outcome of solving.
    """
    names = labels.labels(work.runs)
    unmade: list[str] = []
    if len(work.runs) > 1:
        rows = write_sweep(work.folder, work.runs, names, ends.summaries)
        if run_tasks.are_summarized(work.runs, work.wanted):
            with progress.step("drawing the means"), _told("plots of the means", unmade):
                table.summarize(work.folder, rows)
    page = _write_page(work, ends, unmade)
    previous = _mark_all(work, ends, outcome, unmade)
    return Report(
        work.folder,
        list(zip(work.runs, ends.summaries, strict=True)),
        {names[number]: reason for number, reason in outcome.failures.items()},
        outcome.interrupted,
        page,
        any(ends.begun),
        previous,
        unmade=unmade,
    )


def _write_page(work: Work, ends: Ends, unmade: list[str]) -> Path | None:
    """Draw the pictures of the runs and write the page; return its file, or None without one."""
    finished = [each for each in ends.sounds if each is not None]
    if finished and work.wanted.pictures is not False:
        with _told("pictures", unmade):
            write_pictures(work.folder, finished)
    if not finished or not work.wanted.page:
        return None
    from rolling.report import page

    names = labels.labels(work.runs)
    unsolved = [label for label, each in zip(names, ends.sounds, strict=True) if each is None]
    with progress.step("writing the page"), _told("page", unmade):
        files.write_bytes(work.folder / PAGE, page.page(finished, unsolved))
        return work.folder / PAGE
    return None


@contextmanager
def _told(made: str, unmade: list[str]) -> Iterator[None]:
    """Note an error, because the numbers of solved runs are worth more than their pictures."""
    try:
        yield
    except OSError as error:  # it says itself that a disk is full, or a process was killed
        unmade.append(f"{made}: {error}")
    except Exception as error:
        unmade.append(f"{made}: {type(error).__name__}: {error}")


def _mark_all(work: Work, ends: Ends, outcome: Outcome, unmade: Sequence[str]) -> Path | None:
    """Write the state of each run and of the folder.

    The folder is done when all runs are done, and failed when any run or picture has failed.

    Returns
    -------
    previous : The folder of an earlier run that stays beside this run.
    """
    held, failures = work.held, outcome.failures
    for number, each in enumerate(work.runs):
        if each.folder == held.folder:
            continue
        if number in failures:
            with suppress(OSError, FolderError):  # a folder that cannot be written says so
                held.mark(each.folder, "failed", failures[number])
        elif ends.complete[number]:
            held.mark(each.folder, "done")
        elif ends.begun[number] or outcome.interrupted:
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
    elif unmade:
        held.mark(held.folder, "failed", unmade[0])
    elif all(ends.complete):
        held.mark(held.folder, "done")
        return new_folder.drop_previous(held)
    else:  # new sound of an incomplete run
        held.mark(held.folder, "waiting", "its result is a part")
    return new_folder.previous(held.folder) if held.record.replaces else None


def write_pictures(folder: Path, runs: Sequence[RunResult]) -> None:
    """Write the figures that compare runs into the folder `figures` in theirs."""
    # Matplotlib is slow to import, and a failed run does not need it.
    from rolling.figures import write_figures

    with progress.step("drawing the figures"):
        write_figures(runs, folder)
