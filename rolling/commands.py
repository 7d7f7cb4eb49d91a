"""Commands on run folders: run a scene, make new sound of stored runs, report, table, listen."""

from __future__ import annotations

import shutil
import sys
import time
import webbrowser
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from acoustics.texts import printable
from rolling.results import labels, listening, run_lines, runs_table
from rolling.results.common_gain import write_with_common_gain
from rolling.results.long_record import ListeningError
from rolling.results.run_folder import PAGE, SUMMARY, RunFolder
from rolling.results.run_result import PASSES, Run
from rolling.run import folder as folders
from rolling.run.solving import open_runs, runs_of_part, solve_folder
from rolling.scene import file
from rolling.scene.messages import nearest
from rolling.scene.scene import Scene
from rolling.terminal import defaults, files, progress
from rolling.terminal.files import FolderError
from rolling.terminal.streams import folded

if TYPE_CHECKING:
    import pandas as pd

    from rolling.report.recording import RecordingComparison

TABLE = "runs.csv"
GALLERY = Path("gallery.html")


def run_scene(
    scene: Scene,
    out: Path | None = None,
    *,
    part: folders.Part | None = None,
    workers: int = 0,
    cluster: str | None = None,
    report: bool = True,
    open: bool = False,
) -> dict[str, str]:
    """Run a scene into a folder, or the part of it that the folder lacks.

    Parameters
    ----------
    scene : Scene. The scene.
    out : Path. Run folder. Default: outputs/NAME-DIGITS, which the scene decides.
    part : pair. Number K and count N: every N-th march from march K on. Default: all.
    workers : int. Number of processes; 0: one per core. Default: 0.
    cluster : str. Address of a Dask scheduler, whose workers solve. Default: none.
    report : bool. Whether page and figures are written. Default: true.
    open : bool. Whether the page is opened in a browser. Default: false.

    Returns
    -------
    failures : dict. Reasons by the label of each run that failed.

    Raises
    ------
    SceneError, FolderError : before anything is computed or written.
    OSError : a disk is full, or a cluster is gone; finished pieces are kept.
    KeyboardInterrupt : Ctrl-C or SIGTERM; finished pieces are kept.
    """
    folder = out or folders.default_folder(scene)
    failures = solve_folder(scene, folder, part=part, workers=workers, cluster=cluster)
    runs = folders.runs_in(folder, scene)
    _write_derived_alone(folder, runs, report, part)
    _print_runs(folder, runs_of_part(runs, part))
    if open:
        _open_page(folder / PAGE)
    return failures


def _open_page(page: Path) -> None:
    """Open a page in a browser, or say why it is not open."""
    if not page.is_file():
        print("--open: there is no report page to open", file=sys.stderr)
    elif not webbrowser.open(page.resolve().as_uri()):
        print(f"--open: no browser was found; open {page} in one", file=sys.stderr)


def resound(
    folder: Path,
    overrides: Sequence[str],
    out: Path | None = None,
    *,
    workers: int = 0,
    report: bool = True,
) -> dict[str, str]:
    """Run the scene of a run folder with other values, with the marches that are stored there.

    Parameters
    ----------
    folder : Path. The run folder.
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
    stored = [run for run in folders.stored_runs(folder) if run.is_done]
    if not stored:
        raise FolderError(f"{folder}: no run in it is done, so there is no march to take")
    scene = file.resound(folders.stored_scene(folder), overrides)
    program = folders.made_by(stored[0].home)
    if program != folders.this_program():
        progress.line(f"{folder}: marched by {program}, heard by {folders.this_program()}")
    target = out or folders.default_folder(scene)
    failures = solve_folder(scene, target, sources=stored, workers=workers)
    runs = folders.runs_in(target, scene)
    _write_derived_alone(target, runs, report)
    _print_runs(target, runs)
    return failures


def _print_runs(folder: Path, runs: Sequence[RunFolder]) -> None:
    """Print the levels of runs and the files that a person opens first; the folder if quiet."""
    if progress.is_quiet():
        print(folder)
        return
    done = [run for run in runs if run.is_done]
    if not done:
        return
    shown = _print_answers(done)
    for line in run_lines.channel_lines(shown):
        print(line)
    for line in run_lines.doubt_lines(shown):
        print(line)
    _print_files(folder, done)
    if progress.is_verbose():
        print()
        for line in run_lines.further_lines(shown):
            print(line)


def _print_answers(done: Sequence[RunFolder]) -> Sequence[RunFolder]:
    """Print sentence, table and conclusion of runs, only the first of very many; return these."""
    shown = done
    if len(done) > defaults.MAX_RUNS_COMPARED:
        shown = done[: defaults.FEW_RUNS]
    print("\n".join(run_lines.answer_lines(shown)))
    if len(done) > len(shown):
        print(f"{len(done) - len(shown)} more runs, a row each in {TABLE}")
    print()
    return shown


def _print_files(folder: Path, done: Sequence[RunFolder]) -> None:
    """Print the files that a person opens first."""
    first = done[0]
    heard = ["released power" if first.scene.sound.source == "release" else "vibration"]
    if len(done) > 1:
        heard.insert(0, labels.labels(done)[0])
    print(f"listen: {printable(str(first.folder / 'listen.wav'))} ({', '.join(heard)})")
    if (first.folder / PASSES).is_file():
        print(f"pass by pass: {printable(str(first.folder / PASSES))}")
    if (folder / PAGE).is_file():
        print(f"page: {printable(str(folder / PAGE))}")
    else:
        print(f"folder: {printable(str(folder))}")


def _write_derived_alone(
    folder: Path, runs: Sequence[RunFolder], report: bool, part: folders.Part | None = None
) -> None:
    """Write table, figures and page of a folder on which no other command works.

    After a part of a sweep, the part that ends last writes them: it finds no other at work.
    """
    if part is not None and not all(run.is_done or run.failure for run in runs):
        return
    with ExitStack() as stack:
        try:
            stack.enter_context(folders.locked(folder))
        except FolderError:
            if part is None:
                progress.line("another command works on the folder; it writes table and page")
            else:
                progress.line("other parts are at work; the last one writes table and page")
            return
        write_derived(folder, runs, report)


def write_derived(folder: Path, runs: Sequence[RunFolder], report: bool) -> None:
    """Write what follows from the runs that are done: one gain, table, figures and page.

    Files that are up to date stay as they are.
    """
    done = [run for run in runs if run.is_done]
    if len(done) == len(runs):
        shutil.rmtree(folder / folders.PIECES, ignore_errors=True)
    if not done:
        return
    write_with_common_gain(runs)
    newest = max((run.folder / SUMMARY).stat().st_mtime_ns for run in done)
    report = report and len(runs) <= defaults.MAX_RUNS_COMPARED
    last = folder / TABLE
    if report:
        last = folder / PAGE
    # A page from the future was written before a clock was set back.
    if last.is_file() and newest <= last.stat().st_mtime_ns <= time.time_ns():
        return
    with progress.step("writing the table"):
        write_table(runs_table.runs_table(runs), folder / TABLE)
    if report:
        write_report(open_runs(done), folder, [run for run in runs if not run.is_done])


def write_table(frame: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, without a text that a spreadsheet takes for a formula."""
    safe = runs_table.without_formulas(frame)
    files.write_bytes(path, safe.to_csv(lineterminator="\n").encode("utf-8", "backslashreplace"))


def write_report(runs: Sequence[Run], folder: Path, unsolved: Sequence[RunFolder]) -> None:
    """Write the figures that compare runs and the page of all runs into a folder."""
    from rolling.figures import write_figures
    from rolling.report import page

    with progress.step("drawing the figures"):
        if len(runs) > 1:
            write_figures(runs, folder)
    with progress.step("writing the page"):
        names: list[str] = []
        if unsolved:
            names = labels.labels(unsolved)
        files.write_bytes(folder / PAGE, page.page(runs, names))


def report(run_folders: Sequence[Path], out: Path | None = None) -> list[Path]:
    """Write a page of all runs that are done in run folders; return its file.

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
    if out is not None:
        _refuse_page(out)
    done, unsolved = _done_and_unsolved(run_folders)
    with progress.step("reading the runs, making their sound"):
        finished = open_runs(done)
    if out is None:
        write_report(finished, run_folders[0], unsolved)
        return [run_folders[0] / PAGE]
    with progress.step("writing the page"):
        content = page.page(finished, [])
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return [out]


def _refuse_page(out: Path) -> None:
    """Refuse a page that exists, or whose ending no browser opens."""
    if out.exists():
        raise FolderError(f"{out}: exists; take another --out, or remove it")
    if out.suffix.lower() not in (".html", ".htm"):
        raise FolderError(f"{out}: a page ends in .html, such as --out {out.name}.html")


def _done_and_unsolved(
    run_folders: Sequence[Path],
) -> tuple[list[RunFolder], list[RunFolder]]:
    """Return the runs of run folders, those that are done and the others, each once."""
    by_place = {}
    for folder in run_folders:
        for run in folders.stored_runs(folder):
            by_place[run.folder.resolve()] = run
    done = [run for run in by_place.values() if run.is_done]
    if not done:
        raise FolderError(f"{', '.join(map(str, run_folders))}: no run is done yet")
    return done, [run for run in by_place.values() if not run.is_done]


def gallery(run_folders: Sequence[Path], out: Path | None = None) -> list[Path]:
    """Write one page of many runs, each with a picture, a sound and a sentence; return its file.

    Parameters
    ----------
    run_folders : sequence of Path. Run folders, and folders of sweeps.
    out : Path. File to write. Default: gallery.html.

    Raises
    ------
    FolderError, SceneError : a folder is no run folder, nothing is done in
        them, a run is damaged, or `out` exists. Nothing is written.
    """
    from rolling.report.gallery import MAX_CARDS, gallery_page

    out = out or GALLERY
    _refuse_page(out)
    done, unsolved = _done_and_unsolved(run_folders)
    if len(done) > MAX_CARDS:
        raise FolderError(f"{len(done)} runs: a gallery shows {MAX_CARDS}; name fewer folders")
    with progress.step("reading the runs, making their sound"):
        left_out = [printable(run.folder.resolve().name) for run in unsolved]
        content = gallery_page(_opened_by_scene(done), len(done), out.parent, left_out)
    out.parent.mkdir(parents=True, exist_ok=True)
    files.write_bytes(out, content)
    return [out]


def _opened_by_scene(runs: Sequence[RunFolder]) -> Iterator[Run]:
    """Read runs one after the other, scene by scene, with labels that tell those of a scene apart.

    A gallery may have more runs than the memory holds.
    """
    by_scene: dict[str, list[RunFolder]] = {}
    for run in runs:
        by_scene.setdefault(run.scene.name, []).append(run)
    for name in sorted(by_scene):
        of_scene = by_scene[name]
        for run, label in zip(of_scene, labels.labels(of_scene), strict=True):
            (opened,) = open_runs([run])
            yield replace(opened, label=label)


def listen(
    folder: Path,
    seconds: float = defaults.LISTENED_SECONDS,
    speed: float | tuple[float, float] | None = None,
    seed: int = 0,
) -> list[Path]:
    """Write a long record of a run into long.wav, print its facts; return its path.

    Parameters
    ----------
    folder : Path. The folder of one run.
    seconds : float, s. Length of the record. Default: 20.
    speed : float or pair of float, m/s. Speed, or speeds at start and end. Default: the scene's.
    seed : int. Number of the random continuation. Default: 0.

    Raises
    ------
    FolderError : the folder is no run folder, holds several runs, its run is not done or has no
        long listening, or a number is not allowed. Nothing is written.
    """
    stored = folders.done_run(folder, "listen to")
    with progress.step("reading the run, making its sound"):
        (run,) = open_runs([stored])
    try:
        long = run.listen(seconds, speed, seed)
    except ListeningError as error:
        raise FolderError(f"{folder}: {error}") from error
    path = listening.write_long(run, long)
    progress.line(listening.describe_long_record(run, long))
    for text in long.numbers["limits"]:
        progress.line(f"warning: {text}")
    return [path]


def compare(
    folder: Path,
    recording: Path,
    calibration: str | None = None,
    background: Path | None = None,
    quantity: str = "pressure",
    channels: Sequence[str] = (),
) -> list[Path]:
    """Compare a run with a recording: print a table, write it and a page, and return its path.

    Parameters
    ----------
    folder : Path. The folder of one run, which gets compare-NAME.html and compare-NAME.csv, with a
        number where another comparison has the name.
    recording : Path. Sound file of the real thing, whose name is NAME.
    calibration : str. TONE.wav=LEVEL, a recorded tone of known level (dB re 20 uPa of sound,
        otherwise the rms in the SI unit), or the value of full scale in the SI unit. Default: none;
        the recording gets the total level of the run.
    background : Path. Recording of the background alone, which is subtracted. Default: none.
    quantity : str. What is recorded: pressure, acceleration, velocity, displacement or force.
        Default: pressure.
    channels : sequence of str. Names of the run's channels, in the order of the recording's.
        Default: those of the quantity in their order.

    Raises
    ------
    FolderError : the folder holds no single run that is done, or a recording cannot be compared.
        Nothing is written.
    """
    from rolling.report import recording as recordings
    from rolling.report.recorded import quantity_of

    quantity_of(quantity)
    run = _run_to_compare(folder)
    with progress.step("comparing it with the recording"):
        comparison = recordings.compare(
            run=run,
            path=recording,
            calibration=calibration,
            background=background,
            quantity=quantity,
            channels=channels,
        )
    return [_write_comparison(run, folder, recording, comparison)]


def compare_bench(folder: Path) -> list[Path]:
    """Run the scene of a bench unless it has run, and compare it with each of its recordings.

    Parameters
    ----------
    folder : Path. Folder with scene, scan, recordings and calibration.txt; its run is in the folder
        run. The name synthetic-bench, where there is no such folder, makes one below outputs.

    Returns
    -------
    pages : list of Path. A page for each recording.

    Raises
    ------
    FolderError : something is missing in the folder, and nothing is written; or a run failed, or a
        recording cannot be compared, after all others were.
    """
    from rolling.report import bench as benches
    from rolling.report import synthetic_bench

    if folder == synthetic_bench.NAME and not folder.exists():
        folder = synthetic_bench.make(Path("outputs") / folder)
    bench = benches.read_bench(folder)
    place = benches.run_folder(bench)
    failures = run_scene(bench.scene, place)
    if failures:
        raise FolderError("; ".join(f"{place}: {reason}" for reason in failures.values()))
    run = _run_to_compare(place)
    pages = []
    faults = []
    for item in bench.recordings:
        try:
            with progress.step(f"comparing it with {item.path.name}"):
                comparison = benches.compare_recording(run, item)
        except FolderError as error:
            faults.append(str(error))
            continue
        pages.append(_write_comparison(run, place, item.path, comparison))
    if faults:
        raise FolderError("\n".join(faults))
    progress.line(f"as rows of the validation: rolling validate --bench {folder}")
    return pages


def _run_to_compare(folder: Path) -> Run:
    """Return the only run of a folder, with its sound."""
    stored = folders.done_run(folder, "compare")
    with progress.step("reading the run, making its sound"):
        (run,) = open_runs([stored])
    return run


def _write_comparison(
    run: Run, folder: Path, recording: Path, comparison: RecordingComparison
) -> Path:
    """Write page and table of a comparison into a run folder, and print them; return the page."""
    from rolling.figures.picture import csv_bytes, slug
    from rolling.report import recording as recordings

    content = recordings.page(run, comparison)
    numbers = csv_bytes(comparison.table)
    page = _free_page(folder / f"compare-{slug(recording.name)[:80]}.html", content, numbers)
    files.write_bytes(page.with_suffix(".csv"), numbers)
    files.write_bytes(page, content)
    if not progress.is_quiet():
        print(*map(folded, comparison.notes), sep="\n")
        for heading, table in recordings.words(comparison).items():
            print(f"\n{heading}\n{table.to_string(index=False)}")
        print()
    return page


def _free_page(page: Path, content: bytes, numbers: bytes) -> Path:
    """Return a page, with a number where another comparison has its name.

    A comparison that is there already keeps its name.
    """
    free = page
    number = 1
    while free.exists() or free.with_suffix(".csv").exists():
        if _holds(free, content) and _holds(free.with_suffix(".csv"), numbers):
            return free
        number += 1
        free = page.with_name(f"{page.stem}-{number}{page.suffix}")
    return free


def _holds(path: Path, content: bytes) -> bool:
    """Tell whether a file has this content."""
    return path.is_file() and path.read_bytes() == content


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
    from rolling.figures.catalogue import FIGURES, plot_run

    with progress.step("reading the runs, making their sound"):
        runs = open_runs(folders.done_runs(folder))
    if out is None:
        out = folder / "figures"
        files.make_below(folder, out)
    else:
        drawn = names or FIGURES
        for path in out.glob(f"*.{form}"):
            if path.stem.split("-")[0] in drawn:
                raise FolderError(f"{path}: exists; take another folder, or remove it")
    try:
        return plot_run(runs, names, form, out)
    except ValueError as error:
        raise FolderError(str(error)) from error


def table(
    folder: Path, numbers: Sequence[str], against: Sequence[str], over: str = labels.SEED
) -> list[Path]:
    """Print the table of a sweep, write tables, statistics and plots, as far as runs are done.

    Parameters
    ----------
    folder : Path. The folder of the sweep.
    numbers : sequence of str. Columns of runs.csv to plot. Empty: the two numbers.
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
    frame = runs_table.runs_table(runs)
    solved = frame[frame["laeq_db"].notna() | frame["steps"].notna()]
    swept = list(runs[0].values)
    if over != labels.SEED:
        _refuse_unknown(over, swept, "swept key")
    if len(against) > 2 or len(set(against)) < len(against):
        raise FolderError(
            f"--against: got {' '.join(against)}, allowed: one key for lines, two different ones"
            " for a map"
        )
    keys = [key for key in swept if key != over]
    for key in against:
        _refuse_unknown(key, keys, "swept key")
    for name in numbers:
        _refuse_unknown(name, list(solved.select_dtypes("number")), "number of runs.csv")
    if not progress.is_quiet():
        _print_answers([run for run in runs if run.is_done])
    paths = [folder / TABLE, folder / "statistics.csv"]
    write_table(frame, paths[0])
    write_table(runs_table.seed_statistics(solved, over), paths[1])
    axes = list(against) or keys[:1]
    if not axes:
        return paths
    from rolling import figures

    files.make_below(folder, folder / "figures")
    return paths + figures.write_number_figures(
        solved.reset_index(),
        numbers or _answers_to_plot(solved),
        axes,
        folder / "figures",
        runs[0].scene.name,
    )


def _answers_to_plot(solved: pd.DataFrame) -> list[str]:
    """Return the columns of the two numbers that runs have, the vibration first."""
    columns = [f"{name}_db" for name in runs_table.ANSWERS]
    return [column for column in columns if solved[column].notna().any()]


def _refuse_unknown(name: str, known: Sequence[str], kind: str) -> None:
    """Raise FolderError for an unknown name, with the nearest known one."""
    if name not in known:
        raise FolderError(f"{name}: no {kind}{nearest(name, known)}, allowed: {', '.join(known)}")
