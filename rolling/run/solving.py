"""Solve runs in memory, or those that a folder lacks; write the files of runs, and read them."""

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack, nullcontext, suppress
from dataclasses import replace
from pathlib import Path

from acoustics.texts import printable
from rolling.check import refusals
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.results import labels, result_file
from rolling.results.run_folder import FAILED, RESULT, RunFolder
from rolling.results.run_result import LISTEN, Run, make_run, read_run
from rolling.run import folder as folders
from rolling.run import worker
from rolling.run.executor import RunLoop
from rolling.run.pools import Cluster, Pool, Task, local_pool
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.terminal import defaults, files, progress, shortage, system_errors

Derive = Callable[[Path, Sequence[RunFolder]], object]
Values = Value | tuple[Value, ...]


def simulated(
    scene: Scene, workers: int, shown: bool | None
) -> tuple[dict[Values, Run], dict[str, str]]:
    """Simulate the runs of a scene; return them by swept values, and failures by label."""
    if type(workers) is not int or workers < 0:
        raise ValueError(f"workers: got {workers!r}, allowed: a whole number >= 0")
    refusals.refuse(scene, workers)
    runs = [RunFolder(values, single, Path()) for values, single in scene.runs()]
    refusals.refuse_few_addresses([run.scene for run in runs])
    names, heard = labels.labels(runs), dict[int, Run]()

    def finish(number: int, result: Result) -> None:
        heard[number] = make_run(runs[number], names[number], result)

    scenes = [run.scene for run in runs]
    silence = progress.begin(progress.Level.QUIET) if shown is False else nullcontext()
    with ExitStack() as stack:
        stack.enter_context(shortage.as_memory_error())
        stack.enter_context(silence)  # before the bar, which stays hidden then
        bar = stack.enter_context(progress.Bar(0.0, scene.name, shown))
        pool = stack.enter_context(local_pool(workers, scenes))
        loop = RunLoop(scenes, lambda number: Result.empty(scenes[number]), finish, bar)
        loop.run(pool)
    swept: dict[Values, Run] = {}
    for _, run in sorted(heard.items()):
        values = tuple(run.values.values())
        swept[values[0] if len(values) == 1 else values] = run
    return swept, {names[number]: reason for number, reason in loop.failures.items()}


# ---- folders


def solve_folder(
    scene: Scene,
    folder: Path,
    derive: Derive | None = None,
    *,
    sources: Sequence[RunFolder] = (),
    part: folders.Part | None = None,
    workers: int = 0,
    cluster: str | None = None,
) -> dict[str, str]:
    """Solve the runs of a scene that a folder lacks, and write the files of all of them.

    Parameters
    ----------
    scene : Scene. A scene with or without a sweep.
    folder : Path. Its run folder, which may exist.
    derive : callable. It receives folder and runs at the end, to write tables, figures and page.
        Default: none.
    sources : sequence of RunFolder. Runs elsewhere that are done, whose marches are taken.
    part, workers, cluster : as in `rolling.commands.run_scene`.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError, OSError, KeyboardInterrupt : as in `rolling.commands.run_scene`.
    """
    refusals.refuse(scene, workers, folder)
    if part is not None and not scene.sweep:
        raise SceneError(["sweep: a part is a share of the runs of a sweep, the scene has none"])
    folders.refuse_other(folder, scene)
    if cluster is not None:  # whose workers have other working folders
        scene = Scene.from_dict(scene.to_dict(), scene.folder.resolve())
        folder = folder.resolve()
    # An address without a scheduler is refused before anything is written.
    with nullcontext() if cluster is None else Cluster(cluster) as pool:
        folder.mkdir(parents=True, exist_ok=True)
        with folders.held(folder, part):
            if not folders.refuse_other(folder, scene):
                folders.write_scene(folder, scene)
            if not progress.is_quiet():
                print(f"files: {folder}", flush=True)
            runs = folders.runs_in(folder, scene)
            failures = _solve(folder, runs, runs_of_part(runs, part), sources, workers, pool)
            if not (folder / folders.SCENE).is_file():  # somebody removed the folder meanwhile
                folders.write_scene(folder, scene)
            if derive and part is None:
                derive(folder, runs)
    if derive and part is not None:
        _derive_after_parts(folder, runs, derive)
    return failures


def _derive_after_parts(folder: Path, runs: Sequence[RunFolder], derive: Derive) -> None:
    """Write table, figures and page after the part that ends last, which finds no other at work."""
    if not all(run.is_done or run.failure for run in runs):
        return
    with ExitStack() as stack:
        try:
            stack.enter_context(folders.held(folder))
        except files.FolderError:
            progress.line("other parts are at work; the last one writes table and page")
            return
        derive(folder, runs)


def runs_of_part(runs: Sequence[RunFolder], part: folders.Part | None) -> list[RunFolder]:
    """Return the runs of every N-th march of a sweep; runs with one march stay together."""
    if part is None:
        return list(runs)
    number, count = part
    marches = [contact_identity(run.scene) for run in runs]
    places = {march: place for place, march in enumerate(dict.fromkeys(marches))}
    pairs = zip(runs, marches, strict=True)
    return [run for run, march in pairs if places[march] % count == number - 1]


def _solve(
    folder: Path,
    runs: Sequence[RunFolder],
    own: Sequence[RunFolder],
    sources: Sequence[RunFolder],
    workers: int,
    pool: Pool | None,
) -> dict[str, str]:
    """Solve the runs that are not done, and write their files; return failures by label."""
    names = dict(zip((run.folder for run in runs), labels.labels(runs), strict=True))
    lacking = [run for run in own if not run.is_done]
    folders.tidy(folder, own, alone=len(own) == len(runs))
    for run in own:
        if run.is_done and run.scene.height_paths:  # its file may have been edited
            result_file.read_result(run.folder / RESULT, run.scene)
    if not lacking:
        progress.line(f"{folder}: all runs are done")
        return {}
    scenes = [run.scene for run in lacking]
    refusals.refuse_few_addresses(scenes)
    marches = [contact_identity(scene) for scene in scenes]
    left = Counter(marches)  # runs that still need the pieces of a march

    def finish(number: int, result: Result) -> Task:
        run = lacking[number]
        arguments = run, names[run.folder], result
        return Task(("finish", str(number)), worker.finish_run, arguments)

    def finished(number: int) -> None:
        if left.total() == len(lacking) > 1:
            sound = lacking[number].folder / LISTEN
            progress.line(f"the first sound, {names[lacking[number].folder]}: {sound}")
        left[marches[number]] -= 1
        if not left[marches[number]]:
            folders.drop_pieces(folder, marches[number])

    done = [*sources, *(run for run in runs if run.is_done)]
    stored = {contact_identity(run.scene): run for run in reversed(done)}

    def start(number: int) -> Result:
        source = stored.get(marches[number])
        if source is None:
            return Result.empty(scenes[number])
        result = result_file.read_result(source.folder / RESULT, source.scene)
        film = result.slow_motion
        kept = film if film and len(film.positions) else None  # another stretch may not fail
        return replace(result, steps=scenes[number].track.steps, extremes={}, slow_motion=kept)

    advice = f"finished pieces are kept in {folder}; the same command goes on"
    pieces = folder / folders.PIECES
    film = len(runs) <= defaults.MAX_RUNS_ON_PAGE
    with progress.Bar(0.0, scenes[0].name) as bar:
        loop = RunLoop(scenes, start, finish, bar, finished, pieces, film)
        try:
            with nullcontext(pool) if pool else local_pool(workers, scenes) as pool:
                loop.run(pool)
        except OSError as error:
            text = system_errors.sentence(error)
            if system_errors.is_of_a_place(error) and not progress.has_solved():
                raise files.FolderError(text) from error
            raise OSError(f"{text}\n{advice}") from error
        except KeyboardInterrupt:
            progress.line(advice)
            raise
    for number, reason in loop.failures.items():
        run = lacking[number]
        with suppress(OSError, files.FolderError):  # of a folder that cannot be written
            files.make_below(run.home, run.folder)
            files.write_json(run.folder / FAILED, {"reason": reason})
    return {names[lacking[number].folder]: text for number, text in loop.failures.items()}


def open_runs(runs: Sequence[RunFolder]) -> list[Run]:
    """Read runs that are done, with labels that tell them apart; a single run keeps its own."""
    opened = [read_run(run, label) for run, label in zip(runs, labels.labels(runs), strict=True)]
    if len(opened) == 1:  # perhaps of a sweep, and saved alone
        label = opened[0].summary.get("provenance", {}).get("label") or opened[0].label
        opened[0] = replace(opened[0], label=printable(label))
    return opened
