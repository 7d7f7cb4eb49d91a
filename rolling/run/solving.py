"""Solve runs in memory, or those that a folder lacks; write the files of runs, and read them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from acoustics.texts import printable
from rolling.check import refusals
from rolling.contact.solver import ContactError
from rolling.kinds.former_folder import refuse_former
from rolling.kinds.kind import Kind
from rolling.kinds.needed_marches import March
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import FAILED, LISTEN, RunFolder
from rolling.marches.piece import contact_identity
from rolling.results import labels
from rolling.run import folder as folders
from rolling.run.cluster import Cluster
from rolling.run.ending import Ending
from rolling.run.executor import RunFiles, RunLoop, ended_by_signal
from rolling.run.pilots import PilotRun, Pilots
from rolling.run.pools import Pool, local_pool
from rolling.run.worker import finish_and_keep_run, finish_run
from rolling.scene.messages import SceneError
from rolling.scene.sweep import Value
from rolling.terminal import defaults, progress, shortage, system_errors, whole_files
from rolling.terminal.whole_files import FolderError

Values = Value | tuple[Value, ...]


def simulate_runs(
    scene: Any, workers: int, shown: bool | None, sources: Sequence[RunFolder] = ()
) -> tuple[dict[Values, Any], dict[str, str]]:
    """Simulate the runs of a scene in memory: check, march and sound.

    The surface is made by the process that marches a piece. The march is in `march_piece`.

    Parameters
    ----------
    scene : scene of any kind. A scene with or without a sweep.
    workers : int. Number of processes; 0: one per core.
    shown : bool or None. Whether the progress is shown; None: where somebody looks.
    sources : sequence of RunFolder. Runs in folders, whose equal marches are taken. Default: none.

    Returns
    -------
    runs, failures : dict, dict. Runs by their swept values, and reasons by label.
    """
    if isinstance(workers, np.integer):
        workers = int(workers)
    if type(workers) is not int or workers < 0:
        raise ValueError(f"workers: got {workers!r}, allowed: a whole number >= 0")
    kind = kind_of(scene)
    kind.refuse(scene, workers, None)
    runs = [RunFolder(values, single, Path()) for values, single in scene.runs()]
    marches = [kind.marches(run.scene) for run in runs]
    refusals.refuse_few_addresses(contacts_of(marches))
    names = labels.labels(runs)
    made: dict[int, Any] = {}
    with ExitStack() as stack:
        stack.enter_context(shortage.as_memory_error())
        if shown is False:  # before the bar, which stays hidden then
            stack.enter_context(progress.begin(progress.Level.QUIET))
        bar = stack.enter_context(progress.Bar(0.0, scene.name, shown))
        store = kind.march_store(sources=sources)
        pool = stack.enter_context(local_pool(workers, contacts_of(marches)))
        stack.enter_context(ended_by_signal())
        loop = RunLoop(marches, store, bar)
        for number, marched, _ in loop.finished_runs(pool):
            try:
                made[number] = kind.make_run(runs[number], names[number], marched)
            except ContactError as error:
                loop.fail(number, str(error))
    by_values = {_swept_values(made[number]): made[number] for number in sorted(made)}
    failures = {names[number]: reason for number, reason in loop.failures.items()}
    return by_values, failures


def contacts_of(marches: Sequence[Sequence[March]]) -> list[Any]:
    """Return the contacts of the marches of runs."""
    return [march.scene for of_run in marches for march in of_run]


def _swept_values(run: RunFolder) -> Values:
    """Return the value of a run in its sweep, or a tuple where several keys are swept."""
    values = tuple(run.values.values())
    if len(values) == 1:
        return values[0]
    return values


# ---- folders


def solve_folder(
    scene: Any,
    folder: Path,
    *,
    sources: Sequence[RunFolder] = (),
    start_from: Path | None = None,
    part: folders.Part | None = None,
    workers: int = 0,
    cluster: str | None = None,
    ending: Ending | None = None,
) -> dict[str, str]:
    """Solve the runs of a scene that a folder lacks, and write the files of all of them.

    Parameters
    ----------
    scene : scene of any kind. A scene with or without a sweep.
    folder : Path. Its run folder, which may exist.
    sources : sequence of RunFolder. Runs elsewhere that are done, whose marches are taken.
    start_from : Path. Another run folder, whose equal marches are taken as far as they are sound;
        what is taken is said. Default: none.
    ending : Ending. It keeps runs and processes for the end of the command. Default: none.
    part, workers, cluster : as in `rolling.commands.run.run_scene`.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError, OSError, KeyboardInterrupt : as in `rolling.commands.run.run_scene`.
    """
    kind = kind_of(scene)
    runs = folders.runs_in(folder, scene)
    unsolved = [run.scene for run in runs if not run.is_done]
    kind.refuse(scene, workers, folder, unsolved)
    if part is not None and not scene.sweep:
        raise SceneError(["sweep: a part is a share of the runs of a sweep, the scene has none"])
    folders.refuse_other(folder, scene)
    elsewhere = [] if start_from is None else folders.stored_runs(start_from)
    if start_from is not None:
        refuse_other_kind(start_from, elsewhere, kind)
        refuse_former(elsewhere)
    if cluster is not None:  # its workers have other working folders
        scene = type(scene).from_dict(scene.to_dict(), scene.folder.resolve())
        folder = folder.resolve()
        runs = folders.runs_in(folder, scene)
    with ExitStack() as stack:
        pool = None
        if cluster is not None:  # refused before anything is written where no scheduler answers
            pool = stack.enter_context(Cluster(cluster))
        folder.mkdir(parents=True, exist_ok=True)
        stack.enter_context(folders.locked(folder, part))
        if not folders.refuse_other(folder, scene):
            folders.write_scene(folder, scene)
        if not progress.is_quiet():
            print(f"files: {folder}", flush=True)
        own = runs_of_part(runs, part)
        folders.tidy(folder, own, alone=len(own) == len(runs))
        kind.refuse_edited([run for run in own if run.is_done])
        failures: dict[str, str] = {}
        if all(run.is_done for run in own):
            progress.line(f"{folder}: all runs are done")
        else:
            if start_from is not None:
                sources = [*sources, *kind.take_marches(start_from, elsewhere, own)]
            failures = _solve_lacking(kind, folder, runs, own, sources, workers, pool, ending)
        if not (folder / folders.SCENE).is_file():  # somebody removed the folder meanwhile
            folders.write_scene(folder, scene)
    return failures


def refuse_other_kind(folder: Path, runs: Sequence[RunFolder], kind: Kind) -> None:
    """Refuse a folder with runs of another kind; raise FolderError with what it holds."""
    other = kind_of(runs[0].scene)
    if other is not kind:
        raise FolderError(
            f"{folder}: runs of a {other.name}; a {kind.name} takes the marches of the run folder"
            f" of a {kind.name}"
        )


def runs_of_part(runs: Sequence[RunFolder], part: folders.Part | None) -> list[RunFolder]:
    """Return the runs of every N-th march of a sweep; runs with one march stay together."""
    if part is None:
        return list(runs)
    number, count = part
    marches = [_identity_of(run) for run in runs]
    places = {march: place for place, march in enumerate(dict.fromkeys(marches))}
    return [
        run for run, march in zip(runs, marches, strict=True) if places[march] % count == number - 1
    ]


def _identity_of(run: RunFolder) -> tuple[str, ...]:
    """Return the contact identities of the marches of a run."""
    marches = kind_of(run.scene).marches(run.scene)
    return tuple(sorted({contact_identity(march.scene) for march in marches}))


class _RunOfLoop(NamedTuple):
    """A run that the loop solves: one of the scene, or a pilot.

    place : RunFolder. Its scene and folder.
    label : str. Its label.
    marches : list of March. The marches that it needs.
    pilot : PilotRun or None. The pilot that it is; None for a run of the scene.
    """

    place: RunFolder
    label: str
    marches: list[March]
    pilot: PilotRun | None = None

    @classmethod
    def of_pilot(cls, pilot: PilotRun) -> Self:
        """Return a pilot as a run of the loop."""
        return cls(place=pilot.place, label=pilot.label, marches=pilot.marches, pilot=pilot)


def _solve_lacking(
    kind: Kind,
    folder: Path,
    runs: Sequence[RunFolder],
    own: Sequence[RunFolder],
    sources: Sequence[RunFolder],
    workers: int,
    pool: Pool | None,
    ending: Ending | None,
) -> dict[str, str]:
    """Solve own runs that are not done, and write their files; return failures by label."""
    label_of = dict(zip((run.folder for run in runs), labels.labels(runs), strict=True))
    lacking = [run for run in own if not run.is_done]
    names = [label_of[run.folder] for run in lacking]
    film = len(runs) <= defaults.MAX_RUNS_ON_PAGE
    marches = [kind.marches(run.scene, film) for run in lacking]
    done = [run for run in runs if run.is_done]
    piloted: list[RunFolder] = []
    if film and ending is not None:
        marched = {identity for run in (*sources, *done) for identity in _identity_of(run)}
        for run in lacking:
            identities = _identity_of(run)
            if not identities or not marched.issuperset(identities):
                piloted.append(run)
    pilots = Pilots(kind, folder, piloted, [label_of[run.folder] for run in piloted])
    if pilots.all:  # the whole marches wait for them
        marches = [[march._replace(is_first=False) for march in of_run] for of_run in marches]
    tasks = [_RunOfLoop.of_pilot(pilot) for pilot in pilots.lacking]
    for run, label, needed in zip(lacking, names, marches, strict=True):
        tasks.append(_RunOfLoop(place=run, label=label, marches=needed))
    pilots.make_folder()
    refusals.refuse_few_addresses(contacts_of(marches))
    store = kind.march_store(folder, done, sources)
    is_compared = ending is not None and len(runs) <= defaults.MAX_RUNS_COMPARED
    run_files = RunFiles(
        runs=[task.place for task in tasks],
        labels=[task.label for task in tasks],
        folder=folder,
        finish=finish_and_keep_run if is_compared else finish_run,
    )
    advice = f"finished pieces are kept in {folder}; the same command goes on"
    count = 0
    try:
        with ExitStack() as stack:
            bar = stack.enter_context(progress.Bar(0.0, lacking[0].scene.name))
            if pool is None and ending is not None:  # its processes stay until the end
                pool = ending.pool = ending.enter_context(local_pool(workers, contacts_of(marches)))
            elif pool is None:
                pool = stack.enter_context(local_pool(workers, contacts_of(marches)))
            stack.enter_context(ended_by_signal())
            loop = RunLoop([task.marches for task in tasks], store, bar, run_files)
            for finished in loop.finished_runs(pool):
                task = tasks[finished.number]
                if task.pilot is not None:
                    _tell_pilot(pilots, task.pilot, finished.digest, loop, ending)
                    continue
                count += 1
                pilots.replace(task.place)
                if ending is not None and finished.digest:
                    ending.kept.add(task.place, finished.digest)
                    if film:
                        _prepare_page(task, finished.number, loop, ending)
                if count == 1 and len(lacking) > 1 and not pilots.all:
                    progress.line(f"the first sound, {task.label}: {task.place.folder / LISTEN}")
    except OSError as error:
        text = system_errors.sentence(error)
        if system_errors.is_of_a_place(error) and not progress.has_solved():
            raise FolderError(text) from error
        raise OSError(f"{text}\n{advice}") from error
    except KeyboardInterrupt:
        progress.line(advice)
        raise
    failures: dict[str, str] = {}
    for number, reason in loop.failures.items():
        task = tasks[number]
        if task.pilot is not None:  # which is no run
            continue
        with suppress(OSError, FolderError):  # of a folder that cannot be written
            whole_files.make_below(task.place.home, task.place.folder)
            whole_files.write_json(task.place.folder / FAILED, {"reason": reason})
        failures[task.label] = reason
    return failures


def _prepare_page(task: _RunOfLoop, number: int, loop: RunLoop, ending: Ending) -> None:
    """Queue the making of what the page shows of a run alone, while others are still solved."""
    if ending.prepare_page is None or ending.pool is None:  # of a cluster
        return
    loop.queue_beside(
        number,
        function=ending.prepare_page,
        arguments=(ending.kept.only(task.place), task.place, task.label),
        then=partial(ending.kept.exchange, task.place),
    )


def _tell_pilot(
    pilots: Pilots, pilot: PilotRun, digest: str, loop: RunLoop, ending: Ending | None
) -> None:
    """Say what a pilot found, and queue the page of all pilots after the last one."""
    if digest:
        pilots.kept.add(pilot.place, digest)
    pilots.tell(pilot)
    if pilots.are_told and ending is not None and ending.first_page is not None:
        loop.queue_page(ending.first_page, *pilots.page_arguments)


def open_runs(
    runs: Sequence[RunFolder], read: Callable[[RunFolder, str], Any] | None = None
) -> list[Any]:
    """Read runs that are done, with labels that tell them apart; a single run keeps its own.

    Parameters
    ----------
    runs : sequence of RunFolder.
    read : function. It reads a run under a label. Default: that of the kind of the run.

    Raises
    ------
    FolderError, SceneError : as `Kind.read_run`.
    """
    opened = []
    for run, label in zip(runs, labels.labels(runs), strict=True):
        read_one = kind_of(run.scene).read_run if read is None else read
        opened.append(read_one(run, label))
    if len(opened) == 1:  # perhaps of a sweep, and saved alone
        stored = opened[0].stored
        label = opened[0].label
        if stored is not None and stored.provenance.label:
            label = stored.provenance.label
        opened[0] = replace(opened[0], label=printable(label))
    return opened
