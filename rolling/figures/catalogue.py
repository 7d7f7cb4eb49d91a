"""All figures by name, and their files: those that compare runs, and those on request."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from pandas import DataFrame

from acoustics.traps import ignoring_underflow
from rolling.figures import contact, origins, sound, sweep, vibration
from rolling.figures.picture import Picture, listed, picture, slug
from rolling.figures.settings import left_out_if_it_fails
from rolling.results.run_result import Run
from rolling.scene.messages import nearest
from rolling.surface.scene_surface import scene_surface
from rolling.terminal.files import make_below, write_bytes

FORMATS = ("png", "svg", "csv")


@dataclass(frozen=True)
class FigureKind:
    """A kind of figure: its function on axes, its table, and the runs that it holds for.

    Parameters
    ----------
    draw : callable of (runs, ax), or of (run, ax) for a figure of one run.
    table : callable of the same runs or run. None for a map.
    holds : callable of the same. True, or anything but nothing, if there is such a figure.
    among : bool. Whether `draw` takes the runs `among` which a run is compared.
    """

    draw: Callable[..., Axes]
    table: Callable[..., DataFrame] | None = None
    holds: Callable[..., Any] = lambda shown: True
    among: bool = False


def _turns(run: Run) -> bool:
    return bool(run.summary.get("turn_band_hz"))


def _filters(run: Run) -> bool:
    return bool(run.vibration) and scene_surface(run.scene).statistics.rq > 0


_AREAS = partial(sweep.swept_table, names=sweep.AREAS)
_VIBRATES, _OCTAVES = map(attrgetter, ("vibration", "wavelength_octaves"))
_PASSES, _SNAPSHOT = map(attrgetter, ("result.passes", "result.snapshot"))
_EVENTS = attrgetter("event_statistics")
COMPARING = {
    "third_octaves": FigureKind(sound.third_octaves, sound.third_octave_table),
    "third_octaves_a": FigureKind(
        partial(sound.third_octaves, a_weighted=True),
        partial(sound.third_octave_table, a_weighted=True),
    ),
    "spectrum": FigureKind(sound.spectrum, sound.spectrum_table),
    "levels": FigureKind(sweep.levels, sweep.level_table, sweep.swept_key),
    "contact_areas": FigureKind(sweep.contact_areas, _AREAS, sweep.swept_key),
    "mean_third_octaves": FigureKind(sweep.mean_third_octaves, sweep.seed_table, sweep.has_seeds),
}
SINGLE = {
    "release_power": FigureKind(sound.release_power, sound.release_power_table, among=True),
    "spectrogram": FigureKind(sound.spectrogram, among=True),
    "modulation": FigureKind(origins.modulation, origins.modulation_table, _turns),
    "wavelengths": FigureKind(origins.wavelengths, origins.wavelength_table, _OCTAVES),
    "running_in": FigureKind(origins.running_in, origins.running_in_table, _PASSES),
    "surface": FigureKind(contact.surface),
    "contact_pressure": FigureKind(contact.contact_pressure, holds=_SNAPSHOT, among=True),
    "recovery_events": FigureKind(contact.recovery_events, contact.recovery_event_table, _EVENTS),
    "sources": FigureKind(vibration.sources, vibration.source_table, _VIBRATES),
    "contact_force": FigureKind(vibration.contact_force, vibration.contact_force_table, _VIBRATES),
    "contact_filter": FigureKind(
        vibration.contact_filter, vibration.contact_filter_table, _filters
    ),
    "mobilities": FigureKind(vibration.mobilities, vibration.mobility_table, _VIBRATES),
}
ON_REQUEST = {"power_density": FigureKind(sound.power_density)}
FIGURES = COMPARING | SINGLE | ON_REQUEST


def comparing_pictures(runs: Sequence[Run], names: Iterable[str] = ()) -> Iterator[Picture]:
    """Draw the figures that compare runs, a curve or mark for each run."""
    for name in names or COMPARING:
        kind = FIGURES[name]
        if not kind.holds(runs):
            continue
        drawn = None
        with left_out_if_it_fails(name):
            drawn = picture(name, partial(kind.draw, runs), kind.table and kind.table(runs))
        if drawn is not None:
            yield drawn


def single_picture(name: str, run: Run, among: Sequence[Run] = ()) -> Picture | None:
    """Draw a figure of one run on the axes of all runs `among` which it is compared.

    None for a figure that the run does not have, or that cannot be drawn.
    """
    kind = SINGLE[name]
    if not kind.holds(run):
        return None
    shared = {"among": among} if kind.among else {}
    with left_out_if_it_fails(f"{name} of {run.label}"):
        return picture(name, partial(kind.draw, run, **shared), kind.table and kind.table(run))
    return None


def write_figures(runs: Sequence[Run], folder: Path) -> list[Path]:
    """Write the figures that compare runs into `folder/figures` as PNG, and return their paths."""
    make_below(folder, folder / "figures")
    names = [name for name, kind in COMPARING.items() if kind.holds(runs)]
    return plot_run(runs, names, out=folder / "figures")


@ignoring_underflow
def plot_run(
    runs: Run | Iterable[Run], names: Sequence[str] = (), form: str = "png", out: Path | str = "."
) -> list[Path]:
    """Write figures of one run, or of the runs of a sweep, into a folder.

    Parameters
    ----------
    runs : Run or iterable of Run
        A run, or runs whose figures are drawn on common axes.
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
        A name or the format is unknown, or the runs lack a figure that is named.
    OSError
        A file cannot be written.
    """
    shown, paths = listed(runs), list[Path]()
    if form not in FORMATS:
        raise ValueError(f"{form}: no format of figures, allowed: {', '.join(FORMATS)}")
    for name in names:
        if name not in FIGURES:
            like = nearest(name, [*FIGURES])
            raise ValueError(f"{name}: no figure, allowed: {', '.join(FIGURES)}{like}")
    folder = Path(out)
    for name in names or FIGURES:
        if names and not _is_there(name, shown, form):
            raise ValueError(f"{name}: the runs have no such figure in {form}")
        contents = dict[Path, bytes]()
        for stem, drawn in _pictures(name, shown):
            with left_out_if_it_fails(stem):
                content = drawn.file(form)
                if content is not None:
                    contents[folder / f"{stem}.{form}"] = content
        if contents:
            folder.mkdir(parents=True, exist_ok=True)
        for path, content in contents.items():
            write_bytes(path, content)
        paths += contents
    return paths


def _is_there(name: str, runs: Sequence[Run], form: str) -> bool:
    """Tell whether runs have a figure; a map has no csv."""
    kind = FIGURES[name]
    if form == "csv" and kind.table is None:
        return False
    if name in SINGLE:
        return any(kind.holds(run) for run in runs)
    return bool(kind.holds(runs))


def _pictures(name: str, runs: Sequence[Run]) -> Iterator[tuple[str, Picture]]:
    """Draw a figure of all runs or of each run, with the stem of its file."""
    if name not in SINGLE:
        yield from ((name, drawn) for drawn in comparing_pictures(runs, [name]))
        return
    for run in runs:
        if drawn := single_picture(name, run, runs):
            yield (name if len(runs) == 1 else f"{name}-{slug(run.label)}"), drawn
