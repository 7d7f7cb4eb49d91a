"""The commands run, resume, resound and report: from a scene to a run folder.

A run is solved and written as it grows. Sound, levels, figures and report page follow. The state
`done` in its run.json comes last. The runs of a sweep share a folder, the figures that compare
them, tables and the page. Each run of a large sweep writes four files only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import refusals
from rolling.commands import details
from rolling.commands.run_files import Wanted, ignore, page_of, write_run, write_sweep
from rolling.folders import claim, files, new_folder, own_files, run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Stopped
from rolling.folders.run_record import Kind
from rolling.scene import file, library
from rolling.simulation import batch, labels
from rolling.simulation.batch import Run
from rolling.simulation.plan import Plan, refuse
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import (
    is_begun,
    is_kept,
    read_runs,
    records_of,
    resolved_scene,
    warn_of_other_program,
)
from rolling.terminal import progress

if TYPE_CHECKING:
    from rolling.report.page import Exhibit

PAGE = "report.html"
KINDS: tuple[Kind, ...] = ("run", "sweep")  # kinds of the folders that these commands make


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
class _Work:
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
    scene_path : Path. The scene file, or the name of a scene of the library.
    overrides : sequence of str. Assignments such as "rolling.load_n=50". Default: none.
    out : Path. Run folder to make. Default: a folder named after scene and time.
    force : bool. Replace an earlier run at `out`. Default: false.
    workers : int. Number of processes; 0: one per core. Default: 0.
    page : bool. Write the report page as well. Default: true.
    pictures : bool. Write pictures of each run; false: no pictures and no page. Default: of up to
        24 runs.
    begun : callable. It receives the run folder before anything is solved. Default: none.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.read_scene(scene_path, overrides)
    refuse(scene, workers, out or refusals.OUTPUTS)
    scene_path = library.find(scene_path)
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
    """Continue a run folder that was interrupted or killed; solved steps are not solved again.

    A finished folder stays as it is, unless `pictures` asks for pictures that it may lack.

    Parameters
    ----------
    folder : Path. The run folder.
    workers : int. Number of processes; 0: one per core. Default: 0.
    page : bool. Write the report page as well. Default: true.
    take_over : bool. Continue even if the process that works on the folder is not visible from this
        machine. Default: false.
    pictures, begun : as in `run`.

    Raises
    ------
    FolderError : the folder is not a run folder, is in use, or holds the result of another scene or
        surface.
    SceneError : the scene cannot be run here.
    """
    runs = read_runs(folder)
    for each in runs:
        if not each.folder.is_dir():
            raise FolderError(
                f"{each.folder}: no such folder, though {folder / 'resolved.yaml'} sweeps it; "
                "run a new scene instead"
            )
        refusals.refuse_unavailable(each.scene)
    # Pictures that are asked for by name are drawn for a finished run, too.
    if not pictures and (done := _finished(folder, runs)):
        return done
    refusals.refuse_what_cannot_fit(resolved_scene(folder), workers, folder)
    wanted = Wanted(page, pictures, workers, begun)
    report = _resumed(folder, runs, wanted, take_over)
    if sweep := details.sweep_to_finish(folder):
        _finish_sweep(sweep, replace(wanted, begun=ignore), take_over)
    return report


def _finish_sweep(sweep: Path, wanted: Wanted, take_over: bool) -> None:
    """Write table, figures, page and state of a sweep whose runs are done."""
    progress.line(f"that was the last run of {sweep}, whose table, figures and page follow")
    try:
        _resumed(sweep, read_runs(sweep), wanted, take_over)
    except FolderError as error:  # such as another process that does the same; the run is done
        progress.line(f"not finished: {error}")


def _resumed(folder: Path, runs: list[Run], wanted: Wanted, take_over: bool) -> Report:
    """Claim a folder and solve what its runs lack."""
    before = run_record.read(folder)
    names = [each.folder.name for each in runs] if runs[0].values else []
    with claim.take(folder, "sweep" if names else "run", names, take_over) as held:
        # Another process may have gone on since the folder was looked at.
        results = [
            batch.stored(each) or Result.empty(each.scene.track, each.scene.start) for each in runs
        ]
        warn_of_other_program(folder, before, results)
        return _solve(_Work(held, runs, results, wanted))


def _finished(folder: Path, runs: Sequence[Run]) -> Report | None:
    """Report a folder whose runs are all done; None where there is work left."""
    record = records_of([folder])[0]
    if record is None or record.state != "done":
        return None
    with progress.step("reading the runs"):
        numbers = details.numbers_of_finished(runs)
    if numbers is None:
        return None
    page = folder / PAGE if (folder / PAGE).is_file() else None
    pairs = list(zip(runs, numbers, strict=True))
    return Report(folder, pairs, {}, False, page, True, None, record.completed)


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
    folder : Path. The run folder.
    overrides : sequence of str. Assignments such as "sound.distance_m=2".
    out, force, page, pictures, begun : as in `run`.

    Raises
    ------
    FolderError : the folder is not a run folder, or nothing is solved in it.
    SceneError : the overrides need a new solve or are not allowed.
    """
    stored = read_runs(folder)
    # Everything is read and checked before the new folder is made.
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
    with progress.step("reading the runs"):
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
        again = (
            f"{folder} is as it was; give the command again, with --force if {held.folder} is in "
            "the way"
        )
        with _told_on_error(lambda: again):
            return _finish(work, _sounds(work, {}), Outcome())


def save_run(finished: RunResult, folder: Path, force: bool = False, report: bool = True) -> Path:
    """Write a run that is in memory into a new run folder, with the files that `run` writes.

    Parameters
    ----------
    finished : RunResult. The run.
    folder : Path. The folder to make.
    force : bool. Replace an earlier run at `folder`. Default: false.
    report : bool. Write the report page as well. Default: true.

    Raises
    ------
    FolderError : the folder exists already.
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
    """Write a page of all the runs in run folders, and return its file.

    Parameters
    ----------
    folders : sequence of Path. The run folders.
    out : Path. File to write. Default: report.html in the run folder, which replaces an older page;
        for several folders a page in a new folder.
    force : bool. Replace an existing page of this program at `out`. Default: false.

    Raises
    ------
    FolderError, SceneError : a folder is not a run folder, nothing is solved in it, or `out`
        exists. Nothing is written.
    """
    from rolling.report import page as pages

    if out is not None:
        own_files.refuse_file(out, force, pages.is_page)
    runs = list(
        {each.folder.resolve(): each for folder in folders for each in read_runs(folder)}.values()
    )
    with progress.step("reading the runs, making their sound"):
        finished, unsolved = _stored_sounds(runs)
    if not finished:
        raise FolderError(
            f"{', '.join(map(str, folders))}: nothing is solved yet, so there is nothing to report"
        )
    with progress.step("drawing the figures"):
        exhibits = pages.exhibits(finished)
    with progress.step("writing the page"):
        content = page_of(finished, exhibits, unsolved)
    records_of(folders)
    if out is None:
        out = (
            folders[0] if len(folders) == 1 else new_folder.stamped(Path("outputs") / "report")
        ) / PAGE
    else:
        own_files.refuse_file(
            out, force, pages.is_page
        )  # another program may have made the file meanwhile
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return out


def _stored_sounds(runs: Sequence[Run]) -> tuple[list[RunResult], list[str]]:
    """Make the sound of stored runs.

    Returns
    -------
    finished : The runs with their sound.
    unsolved : The titles of runs with too few solved steps.
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
        finished = _sounds(work, sounds)
        details.tell(work.runs, work.results)
        return _finish(work, finished, outcome)


@contextmanager
def _told_on_error(way_on: Callable[[], str]) -> Iterator[None]:
    """Add instructions for continuing to an error of the system, such as a full disk."""
    try:
        yield
    except OSError as error:
        raise Stopped(error, way_on()) from error


def _way_on(work: _Work) -> str:
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


def _sounds(work: _Work, made: Mapping[int, RunResult | None]) -> list[RunResult | None]:
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


def _sound(work: _Work, number: int, label: str) -> RunResult | None:
    """Make the sound of a run and write its files; None where too few steps are solved."""
    run, result = work.runs[number], work.results[number]
    if batch.other_surface(run, result):  # the numbers of another surface would be wrong
        return None
    finished = hear(label, run.values, run.folder, run.scene, result)
    if finished is not None:
        write_run(finished, result, work.whole_folders)
    return finished


def _finish(work: _Work, sounds: Sequence[RunResult | None], outcome: Outcome) -> Report:
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
        exhibits = _write_pictures(work.folder, finished, work.wanted)
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


def _mark_all(work: _Work, outcome: Outcome) -> Path | None:
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
    else:  # new sound of an incomplete run
        held.mark(held.folder, "waiting", "its result is a part")
    return new_folder.previous(held.folder) if held.record.replaces else None


def _write_pictures(
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
