"""Figures of runs by name, and their files, for every kind of scene.

A kind of scene gives the figures of its runs. Those that compare runs, those of one run, and those
on request are drawn, tabulated and written by the same functions.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.axes import Axes

from acoustics.arrays import instance
from rolling.figures.picture import Picture, listed, picture, slug
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.figure_kind import FigureKind
from rolling.kinds.registry import kind_of_runs
from rolling.kinds.run_folder import RunFolder
from rolling.results.runs_table import csv_bytes
from rolling.scene.messages import nearest
from rolling.terminal.whole_files import make_below, write_bytes

FORMATS = ("png", "svg", "csv")
FIGURES = "figures"  # folder beside a page


def figures_of(runs: Sequence[RunFolder]) -> Mapping[str, FigureKind]:
    """Return the figures that the kind of runs has, by name.

    Raises
    ------
    ValueError : there is no run, or the runs are of several kinds.
    """
    return kind_of_runs(runs).figures()


def names_of(runs: Sequence[RunFolder]) -> list[str]:
    """Return the names of the figures that runs have."""
    return [name for name, kind in figures_of(runs).items() if _subjects(name, kind, runs)]


# ---- pictures


def comparing_pictures(runs: Sequence[RunFolder], names: Iterable[str] = ()) -> Iterator[Picture]:
    """Draw the figures that compare runs, a curve or mark for each run.

    Without names these are the figures that runs have without a request.
    """
    figures = figures_of(runs)
    for name in names or _unasked(figures, runs):
        kind = figures[name]
        if not kind.is_shown(runs):
            continue
        drawn = None
        with left_out_if_it_fails(name):
            drawn = picture_of(name, kind, runs)
        if drawn is not None:
            yield drawn


def _unasked(figures: Mapping[str, FigureKind], runs: Sequence[RunFolder]) -> list[str]:
    """Return the names of the figures that compare runs and need no request."""
    return [
        name
        for name, kind in figures.items()
        if not (kind.is_single or kind.is_asked_only)
        and kind.is_shown(runs)
        and kind.is_unasked(runs)
    ]


def single_names(run: RunFolder) -> list[str]:
    """Return the names of the figures of one run that its kind has."""
    return [name for name, kind in figures_of([run]).items() if kind.is_single]


def single_picture(name: str, run: Any, among: Sequence[RunFolder] = ()) -> Picture | None:
    """Draw a figure of one run on the axes of all runs `among` which it is compared.

    None for a figure that the run does not have, or that cannot be drawn.
    """
    kind = figures_of([run])[name]
    if not kind.is_shown(run):
        return None
    with left_out_if_it_fails(f"{name} of {run.label}"):
        return picture_of(name, kind, run, among)
    return None


def picture_of(name: str, kind: FigureKind, shown: Any, among: Sequence[Any] = ()) -> Picture:
    """Draw and tabulate the figure of runs, or of one run on the axes of all runs `among`."""
    table = None if kind.table is None else kind.table(shown)
    return picture(name, _drawing(kind, shown, among), table, kind.is_polar)


def _file(
    name: str, kind: FigureKind, shown: Any, form: str, among: Sequence[Any] = ()
) -> bytes | None:
    """Return a figure as the bytes of a png, svg or csv file; a map has no csv."""
    if form != "csv":
        return picture(name, _drawing(kind, shown, among), is_polar=kind.is_polar).file(form)
    if kind.table is None:
        return None
    return csv_bytes(kind.table(shown))


def _drawing(kind: FigureKind, shown: Any, among: Sequence[Any]) -> Callable[..., Axes]:
    """Return the function that draws the figure of runs on axes."""
    if kind.shares_scales:
        return partial(kind.draw, shown, among=among)
    return partial(kind.draw, shown)


def draw(runs: Any, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw a figure of one run, or of several, on axes.

    Parameters
    ----------
    runs : run or iterable of runs
        Runs of one kind of scene; a figure of one run takes one.
    name : str
        Name of the figure. Default: the first figure of the kind.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes, which are polar for a figure around an axis.

    Returns
    -------
    ax : matplotlib.axes.Axes

    Raises
    ------
    ValueError
        The runs have no such figure.
    """
    shown = listed(runs)
    for run in shown:
        instance("runs", run, RunFolder)
    figures = figures_of(shown)
    if name is None:
        name = next(iter(figures), "")
    _refuse_unknown(name, shown)
    kind = figures[name]
    if not kind.is_single:
        return kind.draw(shown, ax=ax)
    if len(shown) > 1:
        raise ValueError(f"{name}: got {len(shown)} runs, allowed: one run")
    return kind.draw(shown[0], ax=ax)


def _refuse_unknown(name: str, runs: Sequence[RunFolder]) -> None:
    """Raise ValueError for a figure that the runs lack, with the names of those that they have."""
    figures = figures_of(runs)
    if name in figures and _subjects(name, figures[name], runs):
        return
    own = names_of(runs)
    has = ", ".join(own) or "none"
    if name in figures:
        raise ValueError(f"{name}: the runs have no such figure, they have: {has}")
    raise ValueError(f"{name}: no figure of these runs{nearest(name, own)}, allowed: {has}")


# ---- files


def has_written_figures(runs: Sequence[RunFolder]) -> bool:
    """Tell whether `rolling run` writes figures of so many runs beside their page."""
    figures = figures_of(runs).values()
    if any(kind.is_single and kind.has_file for kind in figures):
        return True
    return len(runs) > 1 and any(not kind.is_single and kind.has_file for kind in figures)


def write_figures(runs: Sequence[Any], folder: Path) -> list[Path]:
    """Write the figures that belong to the page of runs as PNG, and return their paths.

    Figures that compare several runs are in `folder/figures`, those of one run in the folder
    `figures` of the run.
    """
    figures = figures_of(runs)
    paths = []
    names = [name for name in _unasked(figures, runs) if figures[name].has_file]
    if len(runs) > 1 and names:
        make_below(folder, folder / FIGURES)
        paths += plot_run(runs, names, out=folder / FIGURES)
    names = [name for name, kind in figures.items() if kind.is_single and kind.has_file]
    for run in runs:
        own = [name for name in names if figures[name].is_shown(run)]
        if own:
            make_below(run.home, run.folder)
            make_below(run.folder, run.folder / FIGURES)
            paths += plot_run(run, own, out=run.folder / FIGURES)
    return paths


def plot_run(
    runs: Any, names: Sequence[str] = (), form: str = "png", out: Path | str = "."
) -> list[Path]:
    """Write figures of one run, or of the runs of a sweep, into a folder.

    Parameters
    ----------
    runs : run or iterable of runs
        A run, or runs of one kind of scene, whose figures are drawn on common axes.
    names : sequence of str
        Names of figures, as in `rolling.plot`. Default: all figures that the runs have.
    form : str
        Format: png, svg or csv. Default: png.
    out : Path or str
        Folder for the files, which is made if it is missing. Default: the working directory.

    Returns
    -------
    paths : list of Path
        The files: NAME.png for a figure of all runs, NAME-LABEL.png for a figure of one of several.
        A figure that cannot be drawn is left out with a warning.

    Raises
    ------
    ValueError
        The format is unknown, or the runs lack a figure that is named.
    OSError
        A file cannot be written.
    """
    shown = listed(runs)
    folder = Path(out)
    if form not in FORMATS:
        raise ValueError(f"{form}: no format of figures, allowed: {', '.join(FORMATS)}")
    figures = figures_of(shown)
    for name in names:
        _refuse_unknown(name, shown)
        if form == "csv" and figures[name].table is None:
            raise ValueError(f"{name}: the runs have no such figure in {form}")
    paths = list[Path]()
    for name in names or figures:
        contents = dict[Path, bytes]()
        for subject in _subjects(name, figures[name], shown):
            with left_out_if_it_fails(subject.title):
                content = _file(name, figures[name], subject.shown, form, among=shown)
                if content is not None:
                    contents[folder / f"{subject.stem}.{form}"] = content
        if contents:
            folder.mkdir(parents=True, exist_ok=True)
        for path, content in contents.items():
            write_bytes(path, content)
        paths += contents
    return paths


class _Subject(NamedTuple):
    """Runs or a run that have a figure, with its title in warnings and the stem of its file."""

    shown: Any
    title: str
    stem: str


def _subjects(name: str, kind: FigureKind, runs: Sequence[Any]) -> list[_Subject]:
    """Return all runs together for a figure that compares runs, otherwise each run that has it."""
    if kind.is_single:
        subjects = []
        for run in runs:
            if kind.is_shown(run):
                stem = name if len(runs) == 1 else f"{name}-{slug(run.label)}"
                subjects.append(_Subject(run, title=f"{name} of {run.label}", stem=stem))
        return subjects
    if not kind.is_shown(runs):
        return []
    if kind.groups is None:
        return [_Subject(runs, title=name, stem=name)]
    subjects = []
    for label, group in kind.groups(runs):
        stem = f"{name}-{slug(label)}" if label else name
        subjects.append(_Subject(group, title=f"{name} of {label}", stem=stem))
    return subjects
