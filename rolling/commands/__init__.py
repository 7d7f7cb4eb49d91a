"""The commands run, resume, resound and report: from a scene to a run folder.

A run is solved and written as it grows. Sound, levels, figures and report page follow. The state
`done` in its run.json comes last. The runs of a sweep share a folder, the figures that compare
them, tables and the page. Each run of a large sweep writes four files only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rolling.check import refusals
from rolling.commands import details
from rolling.commands.parts import Part, do_part
from rolling.commands.run_files import ALL_FILES, Wanted, ignore, write_run
from rolling.commands.run_tasks import Ends
from rolling.commands.work import (
    PAGE,
    Report,
    Work,
    finish,
    make_sounds,
    solve,
    solve_releases,
    told_on_error,
    work_on,
)
from rolling.folders import claim, files, new_folder, own_files, run_record
from rolling.folders.files import FolderError
from rolling.folders.run_record import Kind
from rolling.scene import file, library
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.simulation import batch, force_law, labels
from rolling.simulation.batch import Run
from rolling.simulation.plan import Plan, refuse
from rolling.simulation.pool import Outcome
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import (
    read_runs,
    records_of,
    resolved_scene,
)
from rolling.terminal import progress

__all__ = [
    "KINDS",
    "PAGE",
    "Part",
    "Report",
    "Wanted",
    "report",
    "resound",
    "resume",
    "run",
    "run_part",
    "save_run",
]

KINDS: tuple[Kind, ...] = ("run", "sweep")  # kinds of the folders that these commands make


def run(
    scene_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    force: bool = False,
    wanted: Wanted = ALL_FILES,
) -> Report:
    """Run a scene file: every combination of its sweep, each into a run folder.

    Parameters
    ----------
    scene_path : Path. The scene file, or the name of a scene of the library.
    overrides : sequence of str. Assignments such as "rolling.load_n=50". Default: none.
    out : Path. Run folder to make. Default: a folder named after scene and time.
    force : bool. Replace an earlier run at `out`. Default: false.
    wanted : Wanted. The files that are requested, and the processes that make them. Default: all
        files, on all cores.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    """
    scene, wanted = _read(scene_path, overrides, out, wanted)
    scene_path = library.find(scene_path)
    plan = Plan(scene, scene_path.read_bytes(), wanted.whole_folders(len(scene.runs())))
    target = new_folder.aim(
        Path("outputs") / scene.name, out, force, KINDS, [scene_path, *plan.height_files]
    )
    with new_folder.make(target, plan.record(), plan.write) as held:
        if out is None:
            new_folder.link_latest(held.folder)
        return solve(work_on(held, plan.runs(held.folder), wanted, None))


def run_part(
    scene_path: Path,
    overrides: Sequence[str],
    out: Path,
    part: Part,
    wanted: Wanted = ALL_FILES,
    take_over: bool = False,
) -> Report:
    """Run a share of the sweep of a scene file, in a folder that other commands share.

    Parameters
    ----------
    scene_path, overrides, wanted : as in `run`.
    out : Path. Run folder of all parts, which the first command makes.
    part : Part. The share.
    take_over : bool. As in `resume`. Default: false.

    Raises
    ------
    SceneError : the scene has no sweep, or cannot be run here.
    FolderError : the folder holds another scene, or another process works on these runs.
    """
    scene, wanted = _read(scene_path, overrides, out, wanted)
    if not scene.sweep:
        raise SceneError(["sweep: a part is a share of the runs of a sweep, the scene has none"])
    return do_part(scene, scene_path, out, part, wanted, take_over)


def _read(
    scene_path: Path, overrides: Sequence[str], out: Path | None, wanted: Wanted
) -> tuple[Scene, Wanted]:
    """Read a scene that can be run here, and count the workers of the cluster that runs it."""
    scene = file.read_scene(scene_path, overrides)
    refuse(scene, wanted.workers, out or refusals.OUTPUTS)
    if wanted.cluster is not None:  # whose workers have other working folders
        scene = Scene.from_dict(scene.to_dict(), scene.folder.resolve())
    return scene, wanted.counted()


def resume(folder: Path, wanted: Wanted = ALL_FILES, take_over: bool = False) -> Report:
    """Continue a run folder that was interrupted or killed; solved steps are not solved again.

    A finished folder stays as it is, unless pictures are wanted that it may lack.

    Parameters
    ----------
    folder : Path. The run folder.
    wanted : Wanted. As in `run`.
    take_over : bool. Continue even if the process that works on the folder is not visible from this
        machine. Default: false.

    Raises
    ------
    FolderError : the folder is not a run folder, is in use, or holds the result of another scene or
        surface.
    SceneError : the scene cannot be run here.
    """
    folder = folder if wanted.cluster is None else folder.resolve()  # as its workers see it
    runs = read_runs(folder)
    for each in runs:
        if not each.folder.is_dir():
            raise FolderError(
                f"{each.folder}: no such folder, though {folder / 'resolved.yaml'} sweeps it; "
                "run a new scene instead"
            )
        refusals.refuse_unavailable(each.scene)
    # Pictures that are asked for by name are drawn for a finished run, too.
    if not wanted.pictures and (done := _finished(folder, runs)):
        return done
    refusals.refuse_what_cannot_fit(resolved_scene(folder), wanted.workers, folder)
    wanted = wanted.counted()
    report = _resumed(folder, runs, wanted, take_over)
    if sweep := details.sweep_to_finish(folder):
        unmade = _finish_sweep(sweep, replace(wanted, begun=ignore), take_over)
        report = replace(report, unmade=[*report.unmade, *unmade])
    return report


def _finish_sweep(sweep: Path, wanted: Wanted, take_over: bool) -> Sequence[str]:
    """Write table, figures, page and state of a sweep whose runs are done.

    Returns
    -------
    unmade : Pictures and pages that could not be made, with their errors.
    """
    progress.line(f"that was the last run of {sweep}, whose table, figures and page follow")
    try:
        return _resumed(sweep, read_runs(sweep), wanted, take_over).unmade
    except FolderError as error:  # such as another process that does the same; the run is done
        progress.line(f"not finished: {error}")
        return ()


def _resumed(folder: Path, runs: list[Run], wanted: Wanted, take_over: bool) -> Report:
    """Claim a folder and solve the missing steps of its runs."""
    before = run_record.read(folder)
    names = [each.folder.name for each in runs] if runs[0].values else []
    with claim.take(folder, "sweep" if names else "run", names, take_over) as held:
        # Another process may have gone on since the folder was looked at.
        return solve(work_on(held, runs, wanted, before or held.record, take_over))


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
    wanted: Wanted = ALL_FILES,
) -> Report:
    """Make new sound from stored runs without solving: other speed, bodies, distance, q or gain.

    Only a release under the moving load needs its march, which is announced.

    Parameters
    ----------
    folder : Path. The run folder.
    overrides : sequence of str. Assignments such as "sound.distance_m=2".
    out, force, wanted : as in `run`. The sound is made in this process.

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
    text = given.read_bytes() if given.is_file() else None
    plan = Plan(scene, text, wanted.whole_folders(len(stored)))
    if [values for values, _ in plan.singles] != [each.values for each in stored]:
        raise FolderError(
            f"{folder}: its sweep varies a key of --set; resound the runs in it one by one"
        )
    plan.take_tolerances(stored)
    with progress.step("reading the runs"):
        results = [result for each in stored if (result := batch.stored(each))]
    if len(results) < len(stored):
        raise FolderError(
            f"{folder}: nothing is solved in some of its runs; `rolling resume` goes on with it"
        )
    for (_, single), result in zip(plan.singles, results, strict=True):
        if force_law.is_missing(single, result):
            way_on = (
                "`rolling resume` goes on"
                if stored[0].scene.dynamics is not None
                else "its scene has no section dynamics; run it with one"
            )
            raise FolderError(f"{folder}: the marches of its force law are missing; {way_on}")
    target = new_folder.aim(
        Path("outputs") / scene.name, out, force, KINDS, [folder, *plan.height_files]
    )
    records_of([folder])
    missing = details.tell_releases([single for _, single in plan.singles], results)
    with new_folder.make(target, plan.record(), plan.write) as held:
        work = Work(held, plan.runs(held.folder), results, wanted)
        if missing:
            return solve_releases(work)
        wanted.begun(held.folder)
        again = (
            f"{folder} is as it was; give the command again, with --force if {held.folder} is in "
            "the way"
        )
        with told_on_error(held.folder, lambda: again):
            outcome = Outcome()
            return finish(work, make_sounds(work, {}, outcome), outcome)


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
        work = Work(held, [alone], [finished.result], Wanted(report))
        with told_on_error(
            held.folder,
            lambda: f"the run is still in memory; save it to another folder than {held.folder}",
        ):
            saved = replace(finished, folder=alone.folder, label=alone.label, values={})
            write_run(saved, saved.result, work.whole_folders)
            ends = Ends.of(work.runs, work.results, [saved])
            if unmade := finish(work, ends, Outcome()).unmade:
                raise OSError(f"{held.folder}: not made: {'; '.join(unmade)}")
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
    with progress.step("writing the page"):
        content = pages.page(finished, unsolved)
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
