"""The commands run, resume, resound and report: from a scene to a run folder.

A run is solved and written as it grows. Sound, levels, figures and report page follow. The state
`done` in its run.json comes last. The runs of a sweep share a folder, the figures that compare
them, a table and the page.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import refusals
from rolling.commands import details
from rolling.folders import claim, files, new_folder, own_files, run_record
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Stopped
from rolling.folders.run_record import Kind
from rolling.scene import file, library
from rolling.simulation import batch, labels, sound_files, summary
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
    with_page : bool. Whether a report page is requested.
    """

    held: Claim
    runs: list[Run]
    results: list[Result]
    with_page: bool

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

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.read_scene(scene_path, overrides)
    refuse(scene, workers, out or refusals.OUTPUTS)
    scene_path = library.find(scene_path)
    plan = Plan(scene, scene_path.read_bytes())
    target = new_folder.aim(
        Path("outputs") / scene.name, out, force, KINDS, [scene_path, *plan.height_files]
    )
    with new_folder.make(target, plan.record(), plan.write) as held:
        runs = plan.runs(held.folder)
        results = [Result.empty(each.scene.track, each.scene.start) for each in runs]
        return _solve(_Work(held, runs, results, page), workers)


def resume(folder: Path, workers: int = 0, page: bool = True, take_over: bool = False) -> Report:
    """Continue a run folder that was interrupted or killed; solved steps are not solved again.

    Parameters
    ----------
    folder : Path. The run folder.
    workers : int. Number of processes; 0: one per core. Default: 0.
    page : bool. Write the report page as well. Default: true.
    take_over : bool. Continue even if the process that works on the folder is not visible from this
        machine. Default: false.

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
    if done := _finished(folder, runs):
        return done
    refusals.refuse_what_cannot_fit(resolved_scene(folder), workers, folder)
    report = _resumed(folder, runs, workers, page, take_over)
    if sweep := details.sweep_to_finish(folder):
        _finish_sweep(sweep, workers, page, take_over)
    return report


def _finish_sweep(sweep: Path, workers: int, page: bool, take_over: bool) -> None:
    """Write table, figures, page and state of a sweep whose runs are done."""
    progress.line(f"that was the last run of {sweep}, whose table, figures and page follow")
    try:
        _resumed(sweep, read_runs(sweep), workers, page, take_over)
    except FolderError as error:  # such as another process that does the same; the run is done
        progress.line(f"not finished: {error}")


def _resumed(folder: Path, runs: list[Run], workers: int, page: bool, take_over: bool) -> Report:
    """Claim a folder and solve what its runs lack."""
    before = run_record.read(folder)
    names = [each.folder.name for each in runs] if runs[0].values else []
    with claim.take(folder, "sweep" if names else "run", names, take_over) as held:
        # Another process may have gone on since the folder was looked at.
        results = [
            batch.stored(each) or Result.empty(each.scene.track, each.scene.start) for each in runs
        ]
        warn_of_other_program(folder, before, results)
        return _solve(_Work(held, runs, results, page), workers)


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
) -> Report:
    """Make new sound from stored runs without solving: other speed, distance, q or gain.

    Parameters
    ----------
    folder : Path. The run folder.
    overrides : sequence of str. Assignments such as "sound.distance_m=2".
    out, force, page : as in `run`.

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
    plan = Plan(scene, given.read_bytes() if given.is_file() else None)
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
        work = _Work(held, plan.runs(held.folder), results, page)
        again = (
            f"{folder} is as it was; give the command again, with --force if {held.folder} is in "
            "the way"
        )
        with _told_on_error(lambda: again):
            with progress.step("sound and levels"):
                sounds = _sounds(work)
            return _finish(work, sounds, Outcome())


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
        work = _Work(held, [alone], [finished.result], report)
        with _told_on_error(
            lambda: f"the run is still in memory; save it to another folder than {held.folder}"
        ):
            _finish(
                work,
                [replace(finished, folder=alone.folder, label=alone.label, values={})],
                Outcome(),
            )
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
    if len(runs) > pages.MOST_RUNS:
        raise FolderError(
            f"{len(runs)} runs, a page holds {pages.MOST_RUNS}: give the folders of those to "
            "compare"
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
        content = pages.page(finished, exhibits, unsolved)
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


def _solve(work: _Work, workers: int) -> Report:
    """Solve the missing steps of the runs, then write everything else."""
    with _told_on_error(lambda: _way_on(work)):
        outcome = batch.solve(
            work.runs,
            work.results,
            workers,
            work.runs[0].scene.name,
            begun=lambda each: work.held.mark(each.folder, "running"),
        )
        with progress.step("sound and levels"):
            sounds = _sounds(work)
        details.tell(work.runs, work.results)
        return _finish(work, sounds, outcome)


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


def _sounds(work: _Work) -> list[RunResult | None]:
    """Make the sound of each run; None where too few steps are solved."""
    names = labels.labels(work.runs)
    return [
        # The numbers of another surface would be wrong for the run.
        None
        if batch.other_surface(each, result)
        else hear(label, each.values, each.folder, each.scene, result)
        for each, label, result in zip(work.runs, names, work.results, strict=True)
    ]


def _finish(work: _Work, sounds: Sequence[RunResult | None], outcome: Outcome) -> Report:
    """Write sound, numbers and figures of every run, their comparison, the page, and the states.

    Parameters
    ----------
    work : The runs and their results.
    sounds : Each run with its sound; None where too few steps are solved.
    outcome : The outcome of solving.
    """
    finished = [each for each in sounds if each is not None]
    for each, result in zip(sounds, work.results, strict=True):
        if each is not None:
            _write_run(each, result)
    names = labels.labels(work.runs)
    summaries = [None if each is None else each.summary for each in sounds]
    with progress.step("drawing the figures"):
        exhibits = _write_pictures(work.folder, finished, work.with_page)
    if len(work.runs) > 1:
        _write_sweep(work, names, summaries)
    if exhibits:
        from rolling.report import page as pages

        unsolved = [label for label, each in zip(names, sounds, strict=True) if each is None]
        with progress.step("writing the page"):
            files.write_bytes(work.folder / PAGE, pages.page(finished, exhibits, unsolved))
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


def _write_run(finished: RunResult, result: Result) -> None:
    """Write result, sound files, numbers and provenance of one run into its folder."""
    folder, scene = finished.folder, finished.scene
    batch.keep(Run(finished.values, scene, folder), result, finished.sound)
    sound_files.write(folder, scene, finished.label, finished.sound, finished.summary["caveats"])
    files.write_json(folder / "summary.json", finished.summary)
    files.write_json(folder / "provenance.json", summary.provenance(scene))


def _write_sweep(
    work: _Work, names: Sequence[str], summaries: Sequence[dict[str, Any] | None]
) -> None:
    """Write the table of the runs of a sweep."""
    table = [
        {"values": each.values, "folder": each.folder.name, "label": label, "summary": numbers}
        for each, label, numbers in zip(work.runs, names, summaries, strict=True)
    ]
    files.write_json(work.folder / "sweep.json", table)


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
    folder: Path, runs: list[RunResult], page: bool
) -> list[tuple[RunResult | None, Exhibit]]:
    """Write the figures of each run into its folder, and the comparisons into the shared folder.

    Returns
    -------
    exhibits : The figures for the page; empty if no page is requested or it would be too long.
    """
    from rolling.figures import (
        run_figures,  # matplotlib is slow to import, and a failed run does not need it
    )
    from rolling.report import page as pages

    page = page and len(runs) <= pages.MOST_RUNS
    exhibits = []
    for each, picture in run_figures.gallery(runs):
        picture.write(each.folder if each else folder)
        if page and pages.belongs(each, picture.name, len(runs)):
            exhibits.append((each, pages.exhibit(picture)))
    return exhibits
