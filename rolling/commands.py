"""Scene to run folder: the only place that knows contact, sound and files.

A run is simulated, kept as it goes, and finished: sound, levels, plots, the report page, then the state `done` in its run.json.
Several runs of one scene (a sweep) share a folder, their plots, a table and the page.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import long_steps, refusals
from rolling.folders import claim, files, new_folder
from rolling.folders.claim import Claim
from rolling.folders.files import FolderError, Stopped
from rolling.folders.run_record import Kind
from rolling.scene import file
from rolling.simulation import batch, labels, sound_files, summary
from rolling.simulation.batch import Run
from rolling.simulation.plan import Plan
from rolling.simulation.result import Result
from rolling.simulation.run_result import Heard, hear
from rolling.simulation.stored_runs import (
    is_begun,
    is_kept,
    read_runs,
    records_of,
    resolved_scene,
    warn_of_other_program,
)
from rolling.surface import contact_of_scene

if TYPE_CHECKING:
    from rolling.report.page import Exhibit

PAGE = "report.html"
KINDS: tuple[Kind, ...] = ("run", "sweep")  # of folders that these commands make


@dataclass(frozen=True)
class Report:
    """The outcome of a command.

    runs : each with its summary, None where too little is solved for one.
    failures : reasons by run.
    page : None when none was made.
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
        return 130 if self.interrupted else 1 if self.failures else 0


def run(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    workers: int = 0,
    page: bool = True,
) -> Report:
    """Run a scene file: every combination of its sweep, each into a run folder, and a report page unless `page` is not wanted.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene = file.read_scene(scene_path, overrides)
    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    refusals.refuse_what_cannot_fit(scene, workers, out or refusals.OUTPUTS)
    plan = Plan(scene, scene_path.read_bytes())
    for _, single in plan.singles:
        contact_of_scene.rolling_contact(single)  # a surface that cannot be had shows before anything is written
    target = new_folder.aim(Path("outputs") / scene.name, out, force, KINDS, [scene_path, *plan.height_files])
    with new_folder.make(target, plan.record(), plan.write) as held:
        runs = plan.runs(held.folder)
        results = [Result.empty(one.scene.track, one.scene.start) for one in runs]
        return _work(held, runs, results, workers, page)


def resume(folder: Path, workers: int = 0, page: bool = True, take_over: bool = False) -> Report:
    """Go on with a run folder that was interrupted or killed; what is solved is not solved again.

    Parameters
    ----------
    take_over : go on, too, if the process that works on it cannot be seen from here.

    Raises
    ------
    FolderError : no run folder, one in use, or a result of another scene or surface. SceneError : it cannot be had here.
    """
    runs = read_runs(folder)
    for one in runs:
        if not one.folder.is_dir():
            raise FolderError(
                f"{one.folder}: no such folder, though {folder / 'resolved.yaml'} sweeps it; run a new scene instead"
            )
        refusals.refuse_unavailable(one.scene)
    refusals.refuse_what_cannot_fit(resolved_scene(folder), workers, folder)
    before = records_of([folder])[0]
    names = [one.folder.name for one in runs] if runs[0].values else []
    with claim.take(folder, "sweep" if names else "run", names, take_over) as held:
        results = [batch.stored(one) or Result.empty(one.scene.track, one.scene.start) for one in runs]
        warn_of_other_program(folder, before, results)
        return _work(held, runs, results, workers, page)


def resound(
    folder: Path, overrides: Sequence[str], out: Path | None = None, force: bool = False, page: bool = True
) -> Report:
    """New sound from stored runs, without solving: other speed, distance, q or gain.

    Raises
    ------
    FolderError : no run folder. SceneError : overrides that need a new solve, are not allowed or cannot be had.
    """
    stored = read_runs(folder)
    # All is read and checked before the new folder is made.
    scene = file.resound(resolved_scene(folder), overrides)
    refusals.refuse_unavailable(scene)
    refusals.refuse_what_cannot_fit(scene, 1, out or refusals.OUTPUTS)
    given = folder / "scene.yaml"
    plan = Plan(scene, given.read_bytes() if given.is_file() else None)
    if [values for values, _ in plan.singles] != [one.values for one in stored]:
        raise FolderError(f"{folder}: its sweep varies a key of --set; resound the runs in it one by one")
    results = [result for one in stored if (result := batch.stored(one))]
    if len(results) < len(stored):
        raise FolderError(f"{folder}: nothing is solved in some of its runs; `rolling resume` goes on with it")
    target = new_folder.aim(Path("outputs") / scene.name, out, force, KINDS, [folder, *plan.height_files])
    records_of([folder])
    with new_folder.make(target, plan.record(), plan.write) as held:
        runs = plan.runs(held.folder)
        again = f"{folder} is as it was; give the command again, with --force if {held.folder} is in the way"
        with _told_on_error(lambda: again):
            return _finish(held, runs, results, {}, False, page)


def report(folders: Sequence[Path], out: Path | None = None, force: bool = False) -> Path:
    """One page of all the runs in run folders; returns its file.

    Parameters
    ----------
    out : file to write, an existing page of this program with `force` only. None: report.html in the run folder, which it is
        derived from, so an older one is replaced; of several folders in a new folder.

    Raises
    ------
    FolderError, SceneError : no run folder, nothing solved in it, or `out` exists; nothing is written.
    """
    from rolling.report import page as pages

    if out is not None:
        _refuse_page(out, force)
    runs = list({one.folder.resolve(): one for folder in folders for one in read_runs(folder)}.values())
    if len(runs) > pages.MOST_RUNS:
        raise FolderError(f"{len(runs)} runs, a page holds {pages.MOST_RUNS}: give the folders of those to compare")
    heard: list[Heard] = []
    unheard: list[str] = []
    for one, label in zip(runs, labels.labels(runs), strict=True):
        refusals.refuse_unavailable(one.scene)
        result = batch.stored(one)
        sounding = _heard(one, label, result) if result else None
        if sounding is None:
            unheard.append(labels.title(one.scene.name, label))
        else:
            heard.append(sounding)
    if not heard:
        raise FolderError(f"{', '.join(map(str, folders))}: nothing is solved yet, so there is nothing to report")
    content = pages.page(heard, pages.exhibits(heard), unheard)
    records_of(folders)
    if out is None:
        out = (folders[0] if len(folders) == 1 else new_folder.stamped(Path("outputs") / "report")) / PAGE
    else:
        _refuse_page(out, force)  # the page took a while to make
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return out


def _refuse_page(out: Path, force: bool) -> None:
    """Raise FolderError if a page may not be written to a file."""
    from rolling.report import page as pages

    if not os.path.lexists(out):
        return
    if out.is_symlink():
        raise FolderError(f"{out}: a symbolic link, which is not replaced; take another --out")
    if not out.is_file():
        raise FolderError(f"{out}: {'is a folder' if out.is_dir() else 'is no file'}, --out is the file to write")
    if not force:
        raise FolderError(f"{out}: exists; take another --out, or --force to replace a page of this program")
    try:
        is_page = pages.is_page(out)
    except OSError as error:
        raise FolderError(f"{out}: not readable ({error.strerror or error}), so it is not replaced") from error
    if not is_page:
        raise FolderError(
            f"{out}: not replaced, because it is not a page that this version can tell as its own; take another --out"
        )


def _work(held: Claim, runs: list[Run], results: list[Result], workers: int, page: bool) -> Report:
    with _told_on_error(lambda: _way_on(held, runs)):
        outcome = batch.solve(
            runs, results, workers, runs[0].scene.name, begun=lambda one: held.mark(one.folder, "running")
        )
        return _finish(held, runs, results, outcome.failures, outcome.interrupted, page)


@contextmanager
def _told_on_error(way_on: Callable[[], str]) -> Iterator[None]:
    """Add the way on to an error of the system, such as a full disk."""
    try:
        yield
    except OSError as error:
        raise Stopped(error, way_on()) from error


def _way_on(held: Claim, runs: Sequence[Run]) -> str:
    folder = held.folder
    kept = f"what was solved before is kept in {folder}" if any(map(is_kept, runs)) else "nothing was solved"
    text = f"{kept}; `rolling resume {folder}` goes on when the cause is mended"
    return f"{text}\n{_of_previous(folder)}" if held.record.replaces else text


def _of_previous(folder: Path) -> str:
    return f"the run that this one replaces stays in {new_folder.previous(folder)} until this one is done"


def _finish(
    held: Claim, runs: list[Run], results: list[Result], failures: dict[int, str], interrupted: bool, page: bool
) -> Report:
    """Sound, numbers and plots of every run that has enough steps; of all together when there are several; the page last."""
    folder = held.folder
    heard: list[Heard] = []
    done: list[tuple[Run, dict[str, Any] | None]] = []
    names = labels.labels(runs)
    for one, label, result in zip(runs, names, results, strict=True):
        # Numbers of another surface would not be the run's.
        sounding = None if batch.other_surface(one, result) else _heard(one, label, result)
        done.append((one, sounding.numbers if sounding else None))
        if sounding is None:
            continue
        batch.keep(one, result, sounding.sound)
        sound_files.write(one.folder, one.scene, label, sounding.sound, sounding.numbers["caveats"])
        files.write_json(one.folder / "summary.json", sounding.numbers)
        files.write_json(one.folder / "provenance.json", summary.provenance(one.scene))
        heard.append(sounding)
    shelf = _write_pictures(folder, heard, page)
    if len(runs) > 1:
        files.write_json(
            folder / "sweep.json",
            [
                {"values": one.values, "folder": one.folder.name, "label": label, "summary": numbers}
                for label, (one, numbers) in zip(names, done, strict=True)
            ],
        )
    if shelf:
        from rolling.report import page as pages

        unheard = [label for label, (_, numbers) in zip(names, done, strict=True) if numbers is None]
        files.write_bytes(folder / PAGE, pages.page(heard, shelf, unheard))
    stays = _mark_all(held, runs, results, failures, interrupted)
    return Report(
        folder,
        done,
        {names[number]: reason for number, reason in failures.items()},
        interrupted,
        folder / PAGE if shelf else None,
        any(map(is_begun, results)),
        stays,
    )


def _mark_all(
    held: Claim, runs: Sequence[Run], results: Sequence[Result], failures: dict[int, str], interrupted: bool
) -> Path | None:
    """Write the state of each run, and of the folder: done when all are, failed when one is.

    Returns the folder of an earlier run that stays beside it.
    """
    for number, (one, result) in enumerate(zip(runs, results, strict=True)):
        if one.folder == held.folder:
            continue
        if number in failures:
            held.mark(one.folder, "failed", failures[number])
        elif result.complete:
            held.mark(one.folder, "done")
        elif is_begun(result) or interrupted:
            held.mark(one.folder, "waiting", claim.INTERRUPTED)
    if interrupted:
        held.mark(held.folder, "waiting", claim.INTERRUPTED)
    elif failures:
        first = next(iter(failures.values()))
        held.mark(held.folder, "failed", first if len(runs) == 1 else f"{len(failures)} of {len(runs)} runs: {first}")
    else:
        incomplete = not all(result.complete for result in results)  # new sound of a part
        held.mark(held.folder, "waiting" if incomplete else "done", "its result is a part" if incomplete else None)
        if not incomplete:
            return new_folder.drop_previous(held)
    return new_folder.previous(held.folder) if held.record.replaces else None


def _heard(one: Run, label: str, result: Result) -> Heard | None:
    return hear(label, one.values, one.folder, one.scene, result)


def _write_pictures(folder: Path, heard: list[Heard], page: bool) -> list[tuple[Heard | None, Exhibit]]:
    """Pictures of each run into its folder, of all into theirs; returned for the page if it is wanted and not too long."""
    from rolling.figures import run_figures  # matplotlib is slow to import, and a run that fails needs none
    from rolling.report import page as pages

    page = page and len(heard) <= pages.MOST_RUNS
    shelf = []
    for one, picture in run_figures.gallery(heard):
        picture.write(one.folder if one else folder)
        if page and pages.belongs(one, picture.name, len(heard)):
            shelf.append((one, pages.exhibit(picture)))
    return shelf
