"""The commands run, resume, resound and report: from a scene to a run folder.

A run is solved and written as it grows. Its sound, levels, figures and report page follow, and last
the state `done` in its run.json. The runs of a sweep share a folder, figures that compare them,
tables and the page. Each run of a large sweep writes four files only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import refusals
from rolling.commands.run_files import Wanted, ignore, page_of, write_run, write_sweep
from rolling.folders import claim, files, new_folder, own_files
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Stopped
from rolling.folders.run_record import Kind
from rolling.scene import file
from rolling.simulation import batch, labels
from rolling.simulation.batch import Run
from rolling.simulation.plan import Plan, refuse
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.solving import progress_bar
from rolling.simulation.stored_runs import (
    is_begun,
    is_kept,
    read_runs,
    records_of,
    resolved_scene,
    warn_of_other_program,
)

if TYPE_CHECKING:
    from rolling.report.page import Exhibit

PAGE = "report.html"
KINDS: tuple[Kind, ...] = ("run", "sweep")  # of folders that these commands make


@dataclass(frozen=True)
class Report:
    """The outcome of a command.

    runs : the runs, each with its summary, or None where too little is solved for one.
    failures : reasons by label of the run.
    page : file of the report page, None when none was made.
    solved : whether anything is solved.
    previous : folder of an earlier run that stays beside this one.
    """

    folder: Path
    runs: list[tuple[Run, dict[str, Any] | None]]
    failures: dict[str, str]
    interrupted: bool
    page: Path | None
    solved: bool
    previous: Path | None

    @property
    def exit_code(self) -> int:
        """The exit code of the command: 0, 1 for a run that failed, 130 for an interruption."""
        return 130 if self.interrupted else 1 if self.failures else 0


@dataclass(frozen=True)
class _Work:
    """The runs of a claimed folder with their results, as far as they are solved."""

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


def run(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    workers: int = 0,
    page: bool = True,
    pictures: bool | None = None,
    begun: Callable[[Path], object] = ignore,
) -> Report:
    """Run a scene file: every combination of its sweep, each into a run folder.

    Parameters
    ----------
    overrides : "rolling.load_n=50" each.
    out : Run folder to make. Default: a folder named after scene and time.
    force : Replace an earlier run at `out`. Default: false.
    workers : Processes; 0: one per core.
    page : Write the report page as well. Default: true.
    pictures : Write pictures of each run. Default: of up to 24 runs; false: none at all, no page.
    begun : Gets the run folder before anything is solved.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.read_scene(scene_path, overrides)
    refuse(scene, workers, out or refusals.OUTPUTS)
    wanted = Wanted(page, pictures, workers, begun)
    plan = Plan(scene, scene_path.read_bytes(), wanted.whole_folders(len(scene.runs())))
    target = new_folder.aim(
        Path("outputs") / scene.name, out, force, KINDS, [scene_path, *plan.height_files]
    )
    with new_folder.make(target, plan.record(), plan.write) as held:
        runs = plan.runs(held.folder)
        results = [Result.empty(each.scene.track, each.scene.start) for each in runs]
        return _solve(_Work(held, runs, results, wanted))


def resume(
    folder: Path,
    workers: int = 0,
    page: bool = True,
    take_over: bool = False,
    pictures: bool | None = None,
    begun: Callable[[Path], object] = ignore,
) -> Report:
    """Go on with a run folder that was interrupted or killed; solved steps are not solved again.

    Parameters
    ----------
    take_over : Go on even if the process that works on the folder cannot be seen from here.
        Default: false.
    pictures, begun : As of `run`.

    Raises
    ------
    FolderError : no run folder, one in use, or a result of another scene or surface.
    SceneError : the scene cannot be run here.
    """
    runs = read_runs(folder)
    for each in runs:
        if not each.folder.is_dir():
            raise FolderError(
                f"{each.folder}: no such folder, though {folder / 'resolved.yaml'} sweeps it; run a new scene instead"
            )
        refusals.refuse_unavailable(each.scene)
    refusals.refuse_what_cannot_fit(resolved_scene(folder), workers, folder)
    before = records_of([folder])[0]
    names = [each.folder.name for each in runs] if runs[0].values else []
    with claim.take(folder, "sweep" if names else "run", names, take_over) as held:
        results = [
            batch.stored(each) or Result.empty(each.scene.track, each.scene.start) for each in runs
        ]
        warn_of_other_program(folder, before, results)
        return _solve(_Work(held, runs, results, Wanted(page, pictures, workers, begun)))


def resound(
    folder: Path,
    overrides: Sequence[str],
    out: Path | None = None,
    force: bool = False,
    page: bool = True,
    pictures: bool | None = None,
    begun: Callable[[Path], object] = ignore,
) -> Report:
    """Make new sound from stored runs without solving: other speed, distance, q or gain.

    Parameters
    ----------
    overrides, out, force, page, pictures, begun : As of `run`.

    Raises
    ------
    FolderError : no run folder, or nothing is solved in it.
    SceneError : overrides that need a new solve or are not allowed.
    """
    stored = read_runs(folder)
    # All is read and checked before the new folder is made.
    scene = file.resound(resolved_scene(folder), overrides)
    refusals.refuse_unavailable(scene)
    refusals.refuse_what_cannot_fit(scene, 1, out or refusals.OUTPUTS)
    given = folder / "scene.yaml"
    wanted = Wanted(page, pictures, 0, begun)
    text = given.read_bytes() if given.is_file() else None
    plan = Plan(scene, text, wanted.whole_folders(len(stored)))
    if [values for values, _ in plan.singles] != [each.values for each in stored]:
        raise FolderError(
            f"{folder}: its sweep varies a key of --set; resound the runs in it one by one"
        )
    results = [result for each in stored if (result := batch.stored(each))]
    if len(results) < len(stored):
        raise FolderError(
            f"{folder}: nothing is solved in some of its runs; `rolling resume` goes on with it"
        )
    target = new_folder.aim(
        Path("outputs") / scene.name, out, force, KINDS, [folder, *plan.height_files]
    )
    records_of([folder])
    with new_folder.make(target, plan.record(), plan.write) as held:
        work = _Work(held, plan.runs(held.folder), results, wanted)
        wanted.begun(held.folder)
        again = f"{folder} is as it was; give the command again, with --force if {held.folder} is in the way"
        with _told_on_error(lambda: again):
            return _finish(work, _sounds(work, {}), Outcome())


def save_run(finished: RunResult, folder: Path, force: bool = False, report: bool = True) -> Path:
    """Write a run that is in memory into a new run folder, with the files that `run` writes.

    Parameters
    ----------
    finished : The run.
    folder : The folder to make.
    force : Replace an earlier run at `folder`. Default: false.
    report : Write the report page as well. Default: true.

    Raises
    ------
    FolderError : the folder is taken.
    """
    plan = Plan(finished.scene, None)
    target = new_folder.aim(folder, folder, force, KINDS, plan.height_files)
    with new_folder.make(target, plan.record(), plan.write) as held:
        (alone,) = plan.runs(held.folder)
        work = _Work(held, [alone], [finished.result], Wanted(report))
        with _told_on_error(
            lambda: f"the run is still in memory; save it to another folder than {held.folder}"
        ):
            saved = replace(finished, folder=alone.folder, label=alone.label, values={})
            write_run(saved, saved.result, work.whole_folders)
            _finish(work, [saved], Outcome())
    return held.folder


def report(folders: Sequence[Path], out: Path | None = None, force: bool = False) -> Path:
    """Write one page of all the runs in run folders; return its file.

    Parameters
    ----------
    out : File to write; an existing page of this program is replaced with `force` only. Default:
        report.html in the run folder, which replaces an older one; for several folders a page in a
        new folder.

    Raises
    ------
    FolderError, SceneError : no run folder, nothing solved in it, or `out` exists; nothing is
        written.
    """
    from rolling.report import page as pages

    if out is not None:
        own_files.refuse_file(out, force, pages.is_page)
    runs = list(
        {each.folder.resolve(): each for folder in folders for each in read_runs(folder)}.values()
    )
    finished, unsolved = _stored_sounds(runs)
    if not finished:
        raise FolderError(
            f"{', '.join(map(str, folders))}: nothing is solved yet, so there is nothing to report"
        )
    content = page_of(finished, pages.exhibits(finished), unsolved)
    records_of(folders)
    if out is None:
        out = (
            folders[0] if len(folders) == 1 else new_folder.stamped(Path("outputs") / "report")
        ) / PAGE
    else:
        own_files.refuse_file(out, force, pages.is_page)  # the page took a while to make
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return out


def _stored_sounds(runs: Sequence[Run]) -> tuple[list[RunResult], list[str]]:
    """Make the sound of stored runs; return them, and the titles of runs of which too little is
    solved.
    """
    finished: list[RunResult] = []
    unsolved: list[str] = []
    for each, label in zip(runs, labels.labels(runs), strict=True):
        refusals.refuse_unavailable(each.scene)
        result = batch.stored(each)
        with_sound = hear(label, each.values, each.folder, each.scene, result) if result else None
        if with_sound is None:
            unsolved.append(labels.title(each.scene.name, label))
        else:
            finished.append(with_sound)
    return finished, unsolved


def _solve(work: _Work) -> Report:
    """Solve the missing steps of the runs, then write everything else."""
    work.wanted.begun(work.folder)
    names = labels.labels(work.runs)
    sounds: dict[int, RunResult | None] = {}

    def complete(number: int) -> None:
        sounds[number] = _sound(work, number, names[number])
        if sounds[number] is None:
            batch.keep(work.runs[number], work.results[number])

    with _told_on_error(lambda: _way_on(work)):
        outcome = batch.solve(
            work.runs,
            work.results,
            work.wanted.workers,
            work.runs[0].scene.name,
            begun=lambda each: work.held.mark(each.folder, "running"),
            complete=complete,
        )
        return _finish(work, _sounds(work, sounds), outcome)


@contextmanager
def _told_on_error(way_on: Callable[[], str]) -> Iterator[None]:
    """Add the way on to an error of the system, such as a full disk."""
    try:
        yield
    except OSError as error:
        raise Stopped(error, way_on()) from error


def _way_on(work: _Work) -> str:
    """Say what is kept of work that the system stopped, and how to go on."""
    folder = work.folder
    kept = (
        f"what was solved before is kept in {folder}"
        if any(map(is_kept, work.runs))
        else "nothing was solved"
    )
    text = f"{kept}; `rolling resume {folder}` goes on when the cause is mended"
    if not work.held.record.replaces:
        return text
    return f"{text}\nthe run that this one replaces stays in {new_folder.previous(folder)} until this one is done"


def _sounds(work: _Work, made: Mapping[int, RunResult | None]) -> list[RunResult | None]:
    """Make the sound of each run and write its files; None where too little is solved.

    Parameters
    ----------
    made : The runs that have their sound already, by number.
    """
    names = labels.labels(work.runs)
    sounds: list[RunResult | None] = []
    with progress_bar(len(names), "sound") as bar:
        for number, label in enumerate(names):
            run, result = work.runs[number], work.results[number]
            if number not in made:
                sounds.append(_sound(work, number, label))
            else:  # pictures read the heights once more
                sounds.append(None if batch.other_surface(run, result) else made[number])
            bar.update()
    return sounds


def _sound(work: _Work, number: int, label: str) -> RunResult | None:
    """Make the sound of a run and write its files; None where too little is solved."""
    run, result = work.runs[number], work.results[number]
    if batch.other_surface(run, result):  # the numbers would not be the run's
        return None
    finished = hear(label, run.values, run.folder, run.scene, result)
    if finished is not None:
        write_run(finished, result, work.whole_folders)
    return finished


def _finish(work: _Work, sounds: Sequence[RunResult | None], outcome: Outcome) -> Report:
    """Write tables and figures of all runs, the page, and the states last.

    Parameters
    ----------
    sounds : Each run with its sound, whose files are written; None where too little is solved for
        one.
    """
    finished = [each for each in sounds if each is not None]
    names = labels.labels(work.runs)
    summaries = [None if each is None else each.summary for each in sounds]
    if len(work.runs) > 1:
        write_sweep(work.folder, work.runs, names, summaries)
    exhibits = []
    if finished and work.wanted.pictures is not False:
        exhibits = _write_pictures(work.folder, finished, work.wanted)
    if exhibits:
        unsolved = [label for label, each in zip(names, sounds, strict=True) if each is None]
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


def _mark_all(work: _Work, outcome: Outcome) -> Path | None:
    """Write the state of each run, and of the folder: done when all runs are, failed when one is.

    Returns
    -------
    previous : The folder of an earlier run that stays beside this one.
    """
    held, failures = work.held, outcome.failures
    for number, (each, result) in enumerate(zip(work.runs, work.results, strict=True)):
        if each.folder == held.folder:
            continue
        if number in failures:
            held.mark(each.folder, "failed", failures[number])
        elif result.complete:
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
    else:  # new sound of a part
        held.mark(held.folder, "waiting", "its result is a part")
    return new_folder.previous(held.folder) if held.record.replaces else None


def _write_pictures(
    folder: Path, runs: Sequence[RunResult], wanted: Wanted
) -> list[tuple[RunResult | None, Exhibit]]:
    """Write the figures of each run into its folder and those of all runs into theirs.

    Returns
    -------
    exhibits : The figures for the page; none where it is not wanted.
    """
    # Matplotlib is slow to import, and a run that fails needs none.
    from rolling.commands import drawing

    of_each = wanted.whole_folders(len(runs))
    return drawing.draw(folder, runs, of_each, wanted.page, wanted.workers)
