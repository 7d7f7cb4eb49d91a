"""Commands on run folders: run a scene, make new sound of stored runs, report, table, extend."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, nullcontext, suppress
from dataclasses import replace
from pathlib import Path

from acoustics import extension, wav
from rolling.check import refusals
from rolling.marches.piece import contact_identity
from rolling.marches.result import Result
from rolling.results import labels, result_file, runs_table
from rolling.results.run_files import write_extended
from rolling.run import folder as folders
from rolling.run import worker
from rolling.run.executor import RunLoop
from rolling.run.folder import Part, RunFolder, default_folder
from rolling.run.pools import Cluster, Pool, Task, local_pool
from rolling.run.stored import PAGE, TABLE, derive, open_runs, write_report, write_table
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.terminal import defaults, files, progress
from rolling.terminal.files import FolderError

__all__ = ["default_folder", "extend", "plot", "report", "resound", "run_scene", "tabulate"]


def run_scene(
    scene: Scene | Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    *,
    part: Part | None = None,
    workers: int = 0,
    cluster: str | None = None,
    report: bool = True,
) -> dict[str, str]:
    """Run a scene into a folder, or the part of it that the folder lacks.

    Parameters
    ----------
    scene : Scene or Path. The scene, its file, or the name of a scene of the library.
    overrides : sequence of str. Assignments such as "rolling.load_n=50" for a file. Default: none.
    out : Path. Run folder. Default: outputs/NAME-DIGITS, which the scene decides.
    part : pair. Number K and count N: every N-th march from march K on. Default: all.
    workers : int. Number of processes; 0: one per core. Default: 0.
    cluster : str. Address of a Dask scheduler, whose workers solve. Default: none.
    report : bool. Whether page and figures are written. Default: true.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    OSError : a disk is full, or a cluster is gone; finished pieces are kept.
    KeyboardInterrupt : Ctrl-C or SIGTERM; finished pieces are kept.
    """
    if not isinstance(scene, Scene):
        scene = file.read_scene(scene, overrides)
    folder = out or default_folder(scene)
    refusals.refuse(scene, workers, folder)
    if part is not None and not scene.sweep:
        raise SceneError(["sweep: a part is a share of the runs of a sweep, the scene has none"])
    return _run(scene, folder, [], part, workers, cluster, report)


def resound(
    source: Path,
    overrides: Sequence[str],
    out: Path | None = None,
    *,
    workers: int = 0,
    report: bool = True,
) -> dict[str, str]:
    """Run the scene of a run folder with other values, with the marches that are stored there.

    Parameters
    ----------
    source : Path. The run folder.
    overrides : sequence of str. Assignments such as "sound.distance_m=2".
    out, workers, report : as in `run_scene`.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    FolderError : nothing is solved in the run folder, or `out` holds another scene.
    SceneError : the overrides are not allowed.
    """
    stored = [run for run in folders.stored_runs(source) if run.is_done]
    if not stored:
        raise FolderError(f"{source}: no run in it is done, so there is no march to take")
    scene = file.resound(folders.stored_scene(source), overrides)
    folder = out or default_folder(scene)
    refusals.refuse(scene, workers, folder)
    return _run(scene, folder, stored, None, workers, None, report)


def _run(
    scene: Scene,
    folder: Path,
    sources: Sequence[RunFolder],
    part: Part | None,
    workers: int,
    cluster: str | None,
    report: bool,
) -> dict[str, str]:
    """Solve the runs of a scene that a folder lacks, and write the files of all of them."""
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
            own = _runs_of_part(runs, part)
            failures = _solve(folder, runs, own, sources, workers, pool)
            if part is None:
                derive(folder, runs, report)
    if part is not None:
        _derive_after_parts(folder, runs, report)
    _print_runs(folder, own)
    return failures


def _derive_after_parts(folder: Path, runs: Sequence[RunFolder], report: bool) -> None:
    """Write table, figures and page after the part that ends last, which finds no other at work."""
    if not all(run.is_done or run.failure for run in runs):
        return
    with ExitStack() as stack:
        try:
            stack.enter_context(folders.held(folder))
        except FolderError:
            progress.line("other parts are at work; the last one writes table and page")
            return
        derive(folder, runs, report)


def _runs_of_part(runs: Sequence[RunFolder], part: Part | None) -> list[RunFolder]:
    """Return the runs of every N-th march of a sweep; runs with one march stay together."""
    if part is None:
        return list(runs)
    number, count = part
    marches = [contact_identity(run.scene) for run in runs]
    places = {march: place for place, march in enumerate(dict.fromkeys(marches))}
    return [
        run for run, march in zip(runs, marches, strict=True) if places[march] % count == number - 1
    ]


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
    folders.tidy(folder, own)
    for run in own:
        if run.is_done and run.scene.height_path is not None:  # its file may have been edited
            result_file.read_result(run.folder / folders.RESULT, run.scene)
    if not lacking:
        progress.line(f"{folder}: all runs are done")
        return {}
    scenes = [run.scene for run in lacking]
    marches = [contact_identity(scene) for scene in scenes]
    left = Counter(marches)  # runs that still need the pieces of a march

    def finish(number: int, result: Result) -> Task:
        run = lacking[number]
        arguments = run, names[run.folder], result
        return Task(("finish", str(number)), worker.finish_run, arguments)

    def finished(number: int) -> None:
        left[marches[number]] -= 1
        if not left[marches[number]]:
            folders.drop_pieces(folder, marches[number])

    done = [*sources, *(run for run in runs if run.is_done)]
    stored = {contact_identity(run.scene): run for run in reversed(done)}

    def start(number: int) -> Result:
        source = stored.get(marches[number])
        if source is None:
            return Result.empty(scenes[number])
        result = result_file.read_result(source.folder / folders.RESULT, source.scene)
        return replace(result, steps=scenes[number].track.steps, extremes={})

    way_on = f"finished pieces are kept in {folder}; the same command goes on"
    pieces = folder / folders.PIECES
    film = len(runs) <= defaults.MOST_RUNS_ON_PAGE
    with progress.bar(0.0, scenes[0].name) as bar:
        loop = RunLoop(scenes, start, finish, finished, pieces, film, bar)
        try:
            with nullcontext(pool) if pool else local_pool(workers, scenes) as pool:
                loop.run(pool)
        except OSError as error:
            raise OSError(f"{error}\n{way_on}") from error
        except KeyboardInterrupt:
            progress.line(way_on)
            raise
    for number, reason in loop.failures.items():
        _note_failure(lacking[number], reason)
    return {names[lacking[number].folder]: text for number, text in loop.failures.items()}


def _note_failure(run: RunFolder, reason: str) -> None:
    """Write why a run failed into its folder, if that can be written."""
    with suppress(OSError):
        run.folder.mkdir(parents=True, exist_ok=True)
        files.write_json(run.folder / folders.FAILED, {"reason": reason})


def _print_runs(folder: Path, runs: Sequence[RunFolder]) -> None:
    """Print the levels of runs and the files that a person opens first; the folder if quiet."""
    done = [run for run in runs if run.is_done]
    if progress.is_quiet():
        print(folder)
        return
    if not done:
        return
    many = len(done) > defaults.MOST_RUNS_COMPARED
    print(runs_table.levels_table(done[: defaults.FEW_RUNS] if many else done))
    if many:
        print(f"{len(done) - defaults.FEW_RUNS} more runs, a row each in {TABLE}")
    print(f"\nlisten: {done[0].folder / 'listen.wav'}   all files: {folder}")
    if len(runs) > 1:
        print(f"a row per run: {folder / TABLE}")
    if (folder / PAGE).is_file():
        print(f"all on one page: {folder / PAGE}")


def report(run_folders: Sequence[Path], out: Path | None = None) -> Path:
    """Write a page of all runs that are done in run folders, and return its file.

    Parameters
    ----------
    run_folders : sequence of Path. The run folders.
    out : Path. File to write. Default: report.html in the only run folder.

    Raises
    ------
    FolderError, SceneError : a folder is no run folder, nothing is done in it, or `out` exists.
        Nothing is written.
    """
    from rolling.report import page

    if out is None and len(run_folders) > 1:
        raise FolderError("--out: give the file of a page of several run folders")
    if out is not None and out.exists():
        raise FolderError(f"{out}: exists; take another --out, or remove it")
    runs = [run for folder in run_folders for run in folders.stored_runs(folder)]
    runs = list({run.folder.resolve(): run for run in runs}.values())
    done = [run for run in runs if run.is_done]
    if not done:
        raise FolderError(f"{', '.join(map(str, run_folders))}: no run is done yet")
    with progress.step("reading the runs, making their sound"):
        finished = open_runs(done)
    if out is None:
        write_report(finished, run_folders[0], [run for run in runs if not run.is_done])
        return run_folders[0] / PAGE
    with progress.step("writing the page"):
        content = page.page(finished, [])
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return out


def extend(folder: Path, seconds: float = defaults.EXTENDED_SECONDS) -> Iterator[tuple[Path, str]]:
    """Write extended.wav for each run of a run folder; yield its path and its kurtosis in words.

    Parameters
    ----------
    folder : Path. The run folder.
    seconds : float, s. Length of the records to make. Default: 30.

    Raises
    ------
    FolderError : the folder is no run folder, a run in it is not done or has no sound that can be
        extended, or `seconds` is not longer than its record or too long.
    """
    if seconds > defaults.MOST_EXTENDED_SECONDS:
        raise FolderError(
            f"--seconds: got {seconds:g}, allowed is up to {defaults.MOST_EXTENDED_SECONDS:g}"
        )
    with progress.step("reading the runs, making their sound"):
        runs = open_runs(_done(folder))
    for run in runs:
        if reason := run.sound.not_extendable:
            raise FolderError(f"{run.folder}: {reason}, so it cannot be extended")
        if round(seconds * wav.SAMPLE_RATE_HZ) <= len(run.sound.pressure):
            raise FolderError(
                f"{run.folder}: --seconds: got {seconds:g}, the record itself is"
                f" {run.sound.duration:.4g} s long; give more"
            )
    for run in runs:
        record, rate = run.sound.pressure, wav.SAMPLE_RATE_HZ
        extended = extension.extend(record, round(seconds * rate), rate, run.laps)
        path = write_extended(run, extended)
        text = (
            f"{run.label}: kurtosis {extension.kurtosis(extended):.1f}, of the record"
            f" {extension.kurtosis(record):.1f} (3: Gaussian noise)"
        )
        yield path, text


def _done(folder: Path) -> list[RunFolder]:
    """Return the runs of a folder; raise FolderError for an unsolved run."""
    runs = folders.stored_runs(folder)
    for run in runs:
        if not run.is_done:
            raise FolderError(f"{run.folder}: not done; the same `rolling run` goes on with it")
    return runs


def plot(folder: Path, names: Sequence[str], form: str, out: Path | None = None) -> list[Path]:
    """Draw figures of the runs of a folder, and return their files.

    Parameters
    ----------
    folder : Path. The run folder.
    names : sequence of str. Names of figures, as in `rolling.plot`. Empty: all of them.
    form : str. png, svg or csv.
    out : Path. Folder of the files. Default: figures in the run folder.

    Raises
    ------
    FolderError : a run is not done, or there is no such figure of the runs.
    """
    from rolling import figures

    with progress.step("reading the runs, making their sound"):
        runs = open_runs(_done(folder))
    try:
        return figures.plot_run(runs, names, form, out or folder / "figures")
    except ValueError as error:
        raise FolderError(str(error)) from error


def tabulate(
    folder: Path, numbers: Sequence[str], against: Sequence[str], over: str = runs_table.SEED
) -> list[Path]:
    """Write the tables, statistics and plots of a sweep, as far as its runs are done.

    Parameters
    ----------
    folder : Path. The folder of the sweep.
    numbers : sequence of str. Columns of runs.csv to plot. Empty: LAeq.
    against : sequence of str. One or two swept keys. Empty: the first swept key.
    over : str. The swept key over which statistics are made. Default: the seed.

    Returns
    -------
    files : list of Path. The files, the table of runs first.

    Raises
    ------
    FolderError : the folder holds no done run of a sweep, or a name is unknown. Nothing is written.
    """
    runs = folders.stored_runs(folder)
    if not runs[0].values or not any(run.is_done for run in runs):
        raise FolderError(f"{folder}: no run of a sweep is done, so there is nothing to tabulate")
    table = runs_table.runs_table(runs)
    solved = table[table["laeq_db"].notna() | table["steps"].notna()]
    keys = [key for key in runs[0].values if key != over]
    if over != runs_table.SEED:
        _refuse_unknown(over, [*runs[0].values], "swept key")
    if len(against) > 2:
        raise FolderError(
            f"--against: got {len(against)} keys, allowed: one for lines, two for a map"
        )
    for key in against:
        _refuse_unknown(key, keys, "swept key")
    for name in numbers:
        _refuse_unknown(name, [*solved.select_dtypes("number")], "number of runs.csv")
    paths = [folder / TABLE, folder / "statistics.csv"]
    write_table(table, paths[0])
    write_table(runs_table.seed_statistics(solved, over), paths[1])
    if not (axes := [*against] or keys[:1]):
        return paths
    from rolling import figures

    subject = runs[0].scene.name
    return paths + figures.write_number_figures(
        solved.reset_index(), numbers or ["laeq_db"], axes, folder / "figures", subject
    )


def _refuse_unknown(name: str, known: Sequence[str], kind: str) -> None:
    """Raise FolderError for an unknown name, with the nearest known one."""
    if name not in known:
        near = difflib.get_close_matches(name, known, 1)
        hint = f", nearest: {near[0]}" if near else ""
        raise FolderError(f"{name}: no {kind}{hint}, allowed: {', '.join(known)}")
