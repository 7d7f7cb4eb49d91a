"""Figure of the sound by place: a profile along a track, or a map of tracks side by side."""

import math
from collections.abc import Iterable, Sequence

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics.arrays import Array
from acoustics.numbers import micrometres, rounded
from acoustics.plot_style import curve_style
from rolling.figures import picture
from rolling.figures.picture import axes_of, compared, finish, level_of
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import heights
from rolling.results import labels
from rolling.results.run_result import Run
from rolling.sound.sound_by_place import SoundByPlace

TRACK = "rolling.across_um"
_PARTS = (2.4, 1.0)  # heights of the axes of the levels and of the heights below them
_BELOW_DB = 30.0  # the maximum, down to which levels are shown
_MAX_NODES = 1000  # of the height map, in each direction
_SMALL_PT = 7.5  # size of the letters beside the heights
_ROWS = 240  # of the map of tracks
_HIDDEN = 0.002  # of the heights at either end, which have no colour of their own
_LEAST_UM = 1e-3  # end of a scale of heights; it hides the rounding of a smooth surface


def places(runs: Run | Iterable[Run], ax: Axes | None = None) -> Axes:
    """Plot the level of each patch of the track of runs, above the heights under the track.

    Runs that differ in `rolling.across_um` alone are tracks on a map.

    Parameters
    ----------
    runs : Run or iterable of Run
        One run, or runs to compare.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels, dB(A), over the place along the surface, µm; of tracks, a map of levels
        over places along and across, µm. Below them stand the heights, with the edges of
        the contact, or the middle of each track.

    Raises
    ------
    ValueError
        The runs are silent, or fall.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.places(run)
    """
    shown = _with_places(compared(runs))
    ax = axes_of(ax)
    by_place = [_by_place(run) for run in shown]
    ax.set_xlabel("along the surface [µm]")
    if are_tracks(shown):
        _draw_tracks(ax, shown, by_place)
    else:
        _draw_profiles(ax, shown, by_place)
    if _share_surface(shown):
        _draw_heights(ax, shown)
    return finish(ax, f"Sound by place: {picture.subject(shown)}", _facts(shown, by_place))


def place_table(runs: Run | Sequence[Run]) -> pd.DataFrame:
    """Tabulate the patches of runs: place [um], level [dB(A)] and time [s]."""
    shown = _with_places(compared(runs))
    frames = []
    for label, run in zip(labels.labels(shown), shown, strict=True):
        by_place = _by_place(run)
        columns: dict[str, object] = {"run": label} if len(shown) > 1 else {}
        columns |= {
            "along_um": 1e6 * by_place.position,
            "across_um": run.scene.rolling.across_um,
            "laeq_db": by_place.level_db,
            "seconds": by_place.seconds,
        }
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)


def has_places(runs: Run | Sequence[Run]) -> bool:
    """Tell whether any of the runs sounds while it rolls."""
    return any(run.sound_by_place is not None for run in picture.listed(runs))


def are_tracks(runs: Sequence[Run]) -> bool:
    """Tell whether runs are tracks beside each other that differ in nothing else."""
    if len({run.scene.across_nodes for run in runs}) < 2:
        return False
    others = {repr({key: x for key, x in run.values.items() if key != TRACK}) for run in runs}
    return len(others) == 1 and all(TRACK in run.values for run in runs)


def _with_places(runs: Sequence[Run]) -> list[Run]:
    """Return the runs that sound while they roll; raise ValueError if there are none."""
    shown = [run for run in runs if run.sound_by_place is not None]
    if not shown:
        raise ValueError(f"{picture.subject(runs)}: is silent or falls, so no place sounds")
    return shown


def _by_place(run: Run) -> SoundByPlace:
    """Return the sound by place of a run that has it."""
    by_place = run.sound_by_place
    assert by_place is not None  # as `_with_places` chose the run
    return by_place


def _share_surface(runs: Sequence[Run]) -> bool:
    """Tell whether runs roll over the same heights, if on other tracks."""
    surfaces = {(run.scene.surface.model_dump_json(), run.scene.height_path) for run in runs}
    return len(surfaces) == 1


def _facts(runs: Sequence[Run], by_place: Sequence[SoundByPlace]) -> list[str]:
    """Say what the levels are levels of, and how long the patches are."""
    first = by_place[0]
    loudest = max(by_place, key=lambda places: float(np.nanmax(places.level_db)))
    place = loudest.position[int(np.nanargmax(loudest.level_db))]
    of = level_of(runs)
    return [
        "LAeq while the ball crosses a patch",
        of.meaning,
        picture.distance_text(runs),
        f"patches of {micrometres(first.length)} µm ({first.reason})",
        f"loudest at {rounded(1e6 * place, 3)} µm",
    ]


# ---- levels


def _draw_profiles(ax: Axes, runs: Sequence[Run], by_place: Sequence[SoundByPlace]) -> None:
    """Draw the levels of runs over the place along the surface."""
    named = labels.labels(runs)
    for number, (label, places) in enumerate(zip(named, by_place, strict=True)):
        style = curve_style(number, len(runs))
        ax.stairs(
            places.level_db,
            1e6 * _edges(places),
            baseline=None,
            color=style["color"],
            linestyle=style["linestyle"] if len(runs) > 1 else "-",
            label=label if len(runs) > 1 else None,
            linewidth=1.4,
        )
    highest = max(float(np.nanmax(places.level_db)) for places in by_place)
    lowest = min(float(np.nanmin(places.level_db)) for places in by_place)
    ax.set_ylim(max(lowest, highest - _BELOW_DB) - 1.0, highest + 2.0)
    ax.set_ylabel(f"LAeq of the {level_of(runs).name} [dB(A)]")
    edges = np.concatenate([_edges(places) for places in by_place])
    ax.set_xlim(1e6 * edges.min(), 1e6 * edges.max())


def _edges(places: SoundByPlace) -> Array:
    """Return the edges [m] of the patches."""
    return np.append(places.position, places.position[-1] + places.length) - places.length / 2


def _draw_tracks(ax: Axes, runs: Sequence[Run], by_place: Sequence[SoundByPlace]) -> None:
    """Draw the levels of tracks as a map; each track reaches half way to the next."""
    across_um = np.array([_across_um(run) for run in runs])
    order = np.argsort(across_um)
    centres = across_um[order]
    between = np.diff(centres)
    first = centres[0] - between[0] / 2
    last = centres[-1] + between[-1] / 2
    rows = first + (np.arange(_ROWS) + 0.5) * (last - first) / _ROWS
    nearest = order[np.searchsorted(centres[:-1] + between / 2, rows)]
    longest = by_place[int(np.argmax([len(places.position) for places in by_place]))]
    edges_um = 1e6 * _edges(longest)
    levels = []
    for places in by_place:
        places_number = np.searchsorted(_edges(places)[1:-1], longest.position)
        levels.append(places.level_db[places_number])
    image = ax.imshow(
        np.array(levels)[nearest],
        matplotlib.colormaps["magma"],
        origin="lower",
        extent=(edges_um[0], edges_um[-1], first, last),
        interpolation="none",
        aspect="auto",
    )
    highest = float(np.nanmax(levels))
    image.set_clim(max(float(np.nanmin(levels)), highest - _BELOW_DB), highest)
    beside = ax.inset_axes((1.02, 0.0, 0.03, 1.0))
    ax.figure.colorbar(image, cax=beside, label="LAeq [dB(A)]")
    ax.set_ylabel("across [µm]")


def _across_um(run: Run) -> float:
    """Return the distance of a track from the middle of its surface [um], at most half a width."""
    nodes = run.scene.across_nodes
    if nodes > run.scene.track.n_across / 2:
        nodes -= run.scene.track.n_across
    return nodes * run.scene.spacing * 1e6


# ---- heights


def _draw_heights(ax: Axes, runs: Sequence[Run]) -> None:
    """Draw the heights of the surface below the axes, with the edges of the contact or tracks."""
    first = runs[0]
    spacing_um = 1e6 * first.scene.spacing
    z = heights(first.scene) * 1e6
    if len(runs) > 1:  # counted from the middle of the surface, in which a single track lies
        z = np.roll(z, first.scene.across_nodes, axis=1)
    left, right = ax.get_xlim()
    rows = np.arange(math.floor(left / spacing_um), math.ceil(right / spacing_um))
    rows = rows[:: max(1, math.ceil(len(rows) / _MAX_NODES))]
    shown = z[rows % len(z)]
    shown = shown[:, :: max(1, math.ceil(shown.shape[1] / _MAX_NODES))]
    half = z.shape[1] * spacing_um / 2
    strip = _axes_below(ax)
    image = strip.imshow(
        shown.T,
        matplotlib.colormaps["cividis"],
        origin="lower",
        extent=(left, right, -half, half),
        interpolation="none",
        aspect="auto",
    )
    low, high = np.quantile(shown, [_HIDDEN, 1 - _HIDDEN])
    image.set_clim(min(low, -_LEAST_UM), max(high, _LEAST_UM))
    beside = strip.inset_axes((1.02, 0.0, 0.03, 1.0))
    ax.figure.colorbar(image, cax=beside, label="height [µm]", extend="both")
    reach_um = 1e6 * smooth_contact_of(first.scene).semi_axes_m()[1]
    lines_um = [-reach_um, reach_um]
    if len(runs) > 1:  # whose contacts may overlap
        lines_um = [_across_um(run) for run in runs]
    for line_um in lines_um:
        strip.axhline(line_um, color="white", linewidth=0.8)
    strip.set_ylabel("across [µm]", fontsize=_SMALL_PT)
    beside.yaxis.label.set_fontsize(_SMALL_PT)
    beside.tick_params(labelsize=_SMALL_PT)
    strip.tick_params(labelbottom=False, labelsize=_SMALL_PT)


def _axes_below(ax: Axes) -> Axes:
    """Return new axes in the lower part of the place of axes, which keep the upper part.

    Axes that stand in no grid get axes below them.
    """
    place = ax.get_subplotspec()
    figure = ax.get_figure(root=False)
    if place is None or figure is None:
        return ax.inset_axes((0.0, -0.62, 1.0, 0.38))
    parts = place.subgridspec(2, 1, height_ratios=_PARTS)
    ax.set_subplotspec(parts[0])
    return figure.add_subplot(parts[1])
