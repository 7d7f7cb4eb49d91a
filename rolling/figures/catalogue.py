"""All figures by name, and their files: figures that compare runs, figures of one run, on request.

Files, the page and `rolling.plot` draw each figure by the same function.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from pandas import DataFrame

from rolling.ball.scene_surface import scene_surface
from rolling.figures import (
    article,
    channels,
    contact,
    levels,
    origins,
    places,
    sound,
    sweep,
    vibration,
)
from rolling.figures.picture import Picture, csv_bytes, listed, picture, slug
from rolling.figures.settings import left_out_if_it_fails
from rolling.results.run_result import Run
from rolling.scene.messages import nearest
from rolling.terminal.files import make_below, write_bytes

FORMATS = ("png", "svg", "csv")


# ---- runs that have a figure


def _always(shown: Run | Sequence[Run]) -> bool:
    return True


def _has_swept_key(runs: Sequence[Run]) -> bool:
    return sweep.swept_key(runs) is not None


def _has_turns(run: Run) -> bool:
    return run.numbers.turns is not None and run.numbers.turns.band_hz is not None


def _has_wavelengths(run: Run) -> bool:
    return bool(run.wavelength_octaves)


def _has_passes(run: Run) -> bool:
    return run.result.passes is not None


def _has_snapshot(run: Run) -> bool:
    return run.result.snapshot is not None


def _has_ball_surface(run: Run) -> bool:
    return run.scene.sphere.surface is not None


def _rolls(run: Run) -> bool:
    return run.scene.rolling.drop_mm is None


def _has_events(run: Run) -> bool:
    return run.event_statistics is not None


def _has_vibration(run: Run) -> bool:
    return run.vibration_sound is not None


def _has_channels(run: Run) -> bool:
    return bool(run.channels)


def _vibrates_on_a_rough_surface(run: Run) -> bool:
    return run.vibration_sound is not None and scene_surface(run.scene).statistics.rq > 0


# ---- the figures


@dataclass(frozen=True)
class FigureKind:
    """A kind of figure: its function on axes, its table, and the runs that have it.

    Parameters
    ----------
    draw : callable of (runs, ax=), or of (run, ax=) for a figure of one run.
    table : callable of the same runs or run. None for a map.
    is_shown : callable of the same. Whether the runs have the figure.
    shares_scales : bool. Whether `draw` takes the runs `among` which a run is compared.
    is_unasked : callable of the same. Whether the runs have it without a request, if fewer runs do.
    """

    draw: Callable[..., Axes]
    table: Callable[..., DataFrame] | None = None
    is_shown: Callable[[Any], bool] = _always
    shares_scales: bool = False
    is_unasked: Callable[[Any], bool] = _always

    def picture(self, name: str, shown: Run | Sequence[Run], among: Sequence[Run] = ()) -> Picture:
        """Draw and tabulate the figure of runs, or of one run on the axes of all runs `among`."""
        table = None if self.table is None else self.table(shown)
        return picture(name, self._drawing(shown, among), table)

    def file(
        self, name: str, shown: Run | Sequence[Run], form: str, among: Sequence[Run] = ()
    ) -> bytes | None:
        """Return the figure as the bytes of a png, svg or csv file; a map has no csv."""
        if form != "csv":
            return picture(name, self._drawing(shown, among)).file(form)
        if self.table is None:
            return None
        return csv_bytes(self.table(shown))

    def _drawing(self, shown: Run | Sequence[Run], among: Sequence[Run]) -> Callable[..., Axes]:
        """Return the function that draws the figure of runs on axes."""
        if self.shares_scales:
            return partial(self.draw, shown, among=among)
        return partial(self.draw, shown)


COMPARING = {
    "third_octaves": FigureKind(sound.third_octaves, sound.third_octave_table),
    "third_octaves_a": FigureKind(sound.third_octaves_a, sound.third_octave_a_table),
    "spectrum": FigureKind(sound.spectrum, sound.spectrum_table),
    "levels": FigureKind(levels.levels, levels.level_table, _has_swept_key),
    "contact_areas": FigureKind(sweep.contact_areas, sweep.area_table, _has_swept_key),
    "places": FigureKind(
        places.places, places.place_table, places.has_places, is_unasked=places.are_tracks
    ),
    "mean_third_octaves": FigureKind(sweep.mean_third_octaves, sweep.seed_table, sweep.has_seeds),
    "max_level_over_load": FigureKind(
        article.max_level_over_load,
        article.max_level_table,
        article.has_loads,
        is_unasked=article.has_loads_and_seeds,
    ),
}
SINGLE = {
    "release_power": FigureKind(
        sound.release_power, sound.release_power_table, _rolls, shares_scales=True
    ),
    "spectrogram": FigureKind(sound.spectrogram, shares_scales=True),
    "modulation": FigureKind(origins.modulation, origins.modulation_table, _has_turns),
    "wavelengths": FigureKind(origins.wavelengths, origins.wavelength_table, _has_wavelengths),
    "running_in": FigureKind(origins.running_in, origins.running_in_table, _has_passes),
    "surface": FigureKind(contact.surface),
    "ball_surface": FigureKind(contact.ball_surface, is_shown=_has_ball_surface),
    "contact_pressure": FigureKind(
        contact.contact_pressure, is_shown=_has_snapshot, shares_scales=True
    ),
    "recovery_events": FigureKind(
        contact.recovery_events, contact.recovery_event_table, _has_events
    ),
    "sources": FigureKind(vibration.sources, vibration.source_table, _has_vibration),
    "contact_force": FigureKind(
        vibration.contact_force, vibration.contact_force_table, _has_vibration
    ),
    "contact_filter": FigureKind(
        vibration.contact_filter, vibration.contact_filter_table, _vibrates_on_a_rough_surface
    ),
    "mobilities": FigureKind(vibration.mobilities, vibration.mobility_table, _has_vibration),
    "channel_third_octaves": FigureKind(
        channels.channel_third_octaves, channels.channel_third_octave_table, _has_channels
    ),
    "channel_spectrum": FigureKind(
        channels.channel_spectrum, channels.channel_spectrum_table, _has_channels
    ),
    "channel_envelope": FigureKind(
        channels.channel_envelope, channels.channel_envelope_table, _has_channels
    ),
}
# A figure for all loads and seeds of each combination of the other swept values.
BY_SURFACE = {
    "spectra_over_load": FigureKind(
        article.spectra_over_load, article.spectra_table, article.has_loads
    ),
}
ON_REQUEST = {"power_density": FigureKind(sound.power_density)} | BY_SURFACE
FIGURES = COMPARING | SINGLE | ON_REQUEST


def comparing_pictures(runs: Sequence[Run], names: Iterable[str] = ()) -> Iterator[Picture]:
    """Draw the figures that compare runs, a curve or mark for each run."""
    for name in names or COMPARING:
        kind = FIGURES[name]
        if not kind.is_shown(runs) or not (names or kind.is_unasked(runs)):
            continue
        drawn = None
        with left_out_if_it_fails(name):
            drawn = kind.picture(name, runs)
        if drawn is not None:
            yield drawn


def single_picture(name: str, run: Run, among: Sequence[Run] = ()) -> Picture | None:
    """Draw a figure of one run on the axes of all runs `among` which it is compared.

    None for a figure that the run does not have, or that cannot be drawn.
    """
    kind = SINGLE[name]
    if not kind.is_shown(run):
        return None
    with left_out_if_it_fails(f"{name} of {run.label}"):
        return kind.picture(name, run, among)
    return None


# ---- files


def write_figures(runs: Sequence[Run], folder: Path) -> list[Path]:
    """Write the figures that compare runs into `folder/figures` as PNG, and return their paths."""
    make_below(folder, folder / "figures")
    names = []
    for name, kind in COMPARING.items():
        if kind.is_shown(runs) and kind.is_unasked(runs):
            names.append(name)
    return plot_run(runs, names, out=folder / "figures")


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
    shown = listed(runs)
    folder = Path(out)
    if form not in FORMATS:
        raise ValueError(f"{form}: no format of figures, allowed: {', '.join(FORMATS)}")
    for name in names:
        if name not in FIGURES:
            like = nearest(name, [*FIGURES])
            raise ValueError(f"{name}: no figure, allowed: {', '.join(FIGURES)}{like}")
    paths = list[Path]()
    for name in names or FIGURES:
        subjects = _subjects(name, shown)
        if names and (not subjects or (form == "csv" and FIGURES[name].table is None)):
            raise ValueError(f"{name}: the runs have no such figure in {form}")
        contents = dict[Path, bytes]()
        for subject in subjects:
            with left_out_if_it_fails(subject.title):
                content = FIGURES[name].file(name, subject.shown, form, among=shown)
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

    shown: Run | Sequence[Run]
    title: str
    stem: str


def _subjects(name: str, runs: Sequence[Run]) -> list[_Subject]:
    """Return all runs together for a figure that compares runs, otherwise each run that has it."""
    kind = FIGURES[name]
    subjects = []
    if name in BY_SURFACE and kind.is_shown(runs):
        for label, of_surface in article.runs_by_surface(runs):
            stem = f"{name}-{slug(label)}" if label else name
            subjects.append(_Subject(of_surface, title=f"{name} of {label}", stem=stem))
        return subjects
    if name not in SINGLE:
        return [_Subject(runs, title=name, stem=name)] if kind.is_shown(runs) else []
    for run in runs:
        if kind.is_shown(run):
            stem = name if len(runs) == 1 else f"{name}-{slug(run.label)}"
            subjects.append(_Subject(run, title=f"{name} of {run.label}", stem=stem))
    return subjects
