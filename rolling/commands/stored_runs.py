"""Commands on stored runs: page, gallery, long record, figures and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from acoustics.texts import printable
from rolling.commands.answers import print_answers
from rolling.commands.derived import write_report, write_table, write_tables
from rolling.kinds.former_folder import refuse_former
from rolling.kinds.registry import kind_of, kind_of_runs
from rolling.kinds.run_folder import PAGE, RunFolder
from rolling.numbers import views
from rolling.results import labels, runs_table
from rolling.results.run_result import Run
from rolling.results.stored_numbers import numbers_of
from rolling.run import folder as folders
from rolling.run.solving import open_runs
from rolling.scene.messages import nearest
from rolling.terminal import defaults, pages, progress, whole_files
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:
    import pandas as pd

GALLERY = Path("gallery.html")


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
    from rolling.report import report_page

    if out is None and len(run_folders) > 1:
        raise FolderError("--out: give the file of a page of several run folders")
    if out is not None:
        pages.refuse_page(out)
    done, unsolved = _done_and_unsolved(run_folders)
    try:
        kind_of_runs(done)
    except ValueError as error:
        raise FolderError(f"{error}; `rolling gallery` shows runs of all kinds") from error
    with progress.step("reading the runs, making their sound"):
        finished = open_runs(done)
    if out is None:
        write_report(finished, run_folders[0], unsolved)
        return [run_folders[0] / PAGE]
    with progress.step("writing the page"):
        content = report_page.page(finished)
    out.parent.mkdir(parents=True, exist_ok=True)
    whole_files.write_bytes(out, content)
    return [out]


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
    pages.refuse_page(out)
    done, unsolved = _done_and_unsolved(run_folders)
    if len(done) > MAX_CARDS:
        raise FolderError(f"{len(done)} runs: a gallery shows {MAX_CARDS}; name fewer folders")
    with progress.step("reading the runs, making their sound"):
        left_out = [printable(run.folder.resolve().name) for run in unsolved]
        content = gallery_page(_opened_by_scene(done), len(done), out.parent, left_out)
    out.parent.mkdir(parents=True, exist_ok=True)
    whole_files.write_bytes(out, content)
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
    reverberation_s: float | None = None,
) -> list[Path]:
    """Write a long record of a run into long.wav, print its facts; return its path.

    With a reverberation time it is heard in a room, and written into room.wav.

    Parameters
    ----------
    folder : Path. The folder of one run.
    seconds : float, s. Length of the record. Default: 20.
    speed : float or pair of float, m/s. Speed, or speeds at start and end. Default: the scene's.
    seed : int. Number of the random continuation. Default: 0.
    reverberation_s : float, s. Reverberation time of a room to hear it in. Default: no room.

    Raises
    ------
    FolderError : the folder is no run folder, holds several runs, its run is not done or has no
        long listening, or a number is not allowed. Nothing is written.
    """
    stored = folders.done_run(folder, "listen to")
    refuse_former([stored])
    with progress.step("reading the run, making its sound"):
        (run,) = open_runs([stored])
    try:
        return [kind_of(run.scene).write_long(run, seconds, speed, seed, reverberation_s)]
    except ValueError as error:
        raise FolderError(f"{folder}: {error}") from error


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
    from rolling.figures.catalogue import figures_of, plot_run

    with progress.step("reading the runs, making their sound"):
        runs = open_runs(folders.done_runs(folder))
    if out is None:
        out = folder / "figures"  # made with the first figure that can be drawn
        whole_files.refuse_link_below(folder, out)
    else:
        drawn = names or figures_of(runs)
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
    """Print the table of runs, write tables, statistics and plots, as far as runs are done.

    Parameters
    ----------
    folder : Path. The run folder; a single run has tables alone.
    numbers : sequence of str. Columns of runs.csv to plot. Empty: the two numbers.
    against : sequence of str. One or two swept keys. Empty: the first swept key.
    over : str. The swept key over which statistics are made. Default: the seed.

    Returns
    -------
    files : list of Path. The files, the table of runs first.

    Raises
    ------
    FolderError : the folder holds no run that is done, or a name is unknown. Nothing is written.
    """
    runs = folders.stored_runs(folder)
    if not any(run.is_done for run in runs):
        raise FolderError(f"{folder}: no run is done, so there is nothing to tabulate")
    frame = runs_table.runs_table(runs)
    solved = frame.dropna(how="all")
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
        print_answers([run for run in runs if run.is_done])
    statistics = folder / "statistics.csv"
    paths = [*write_tables(runs, folder), statistics]
    write_table(runs_table.seed_statistics(runs, over), statistics)
    axes = list(against) or keys[:1]
    if not axes:
        return paths
    from rolling import figures

    whole_files.make_below(folder, folder / "figures")
    done = [run for run in runs if run.is_done]
    columns = numbers or _answers_to_plot(done, solved)
    return paths + figures.write_number_figures(done, columns, axes, folder / "figures")


def _answers_to_plot(runs: Sequence[RunFolder], solved: pd.DataFrame) -> list[str]:
    """Return the columns of the numbers that lead, as far as runs have them."""
    columns = kind_of(runs[0].scene).leading
    if not columns:
        columns = tuple(views.quantity_columns(numbers_of(runs[0])))
    return [column for column in columns if column in solved and solved[column].notna().any()]


def _refuse_unknown(name: str, known: Sequence[str], kind: str) -> None:
    """Raise FolderError for an unknown name, with the nearest known one."""
    if name not in known:
        raise FolderError(f"{name}: no {kind}{nearest(name, known)}, allowed: {', '.join(known)}")
