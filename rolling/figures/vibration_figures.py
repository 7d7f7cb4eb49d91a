"""Figures of the vibration of a run: sources, contact force, contact filter, mobilities."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics.arrays import instance
from acoustics.bands import BAND_NAMES
from acoustics.numbers import rounded
from acoustics.plot_style import unit_prefix
from acoustics.plots import COLOURS, third_octaves
from rolling.figures.picture import axes_of, duration_text, finish, number
from rolling.figures.sound_figures import band_table
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.results.run_result import Run
from rolling.scene.sections import loss_text
from rolling.sound.vibration_sound import Vibration
from rolling.sound.wavelengths import wavelength_bands

_COLUMNS = 1500  # of the force over time, in each of which minimum and maximum are drawn
_BANDS_DB = 40.0  # below the strongest band of the vibration, the levels that are shown
_FILTERED_DB = 40.0  # below the maximum of the surface's spectrum
_LINE_STYLES = ("-", "--", "-.", ":")


def _vibration(run: Run) -> Vibration:
    """Return the vibration of a run; raise TypeError or ValueError if there is none."""
    instance("run", run, Run)
    if run.vibration_sound is None:
        raise ValueError(f"{run.title}: has no vibration, because its scene has no dynamics")
    return run.vibration_sound


def _draw_columns(ax: Axes, table: pd.DataFrame, labels: dict[str, str]) -> None:
    """Draw columns of a table, with their labels, over its first column on a logarithmic axis."""
    for k, (column, label) in enumerate(labels.items()):
        ax.plot(
            table.iloc[:, 0],
            table[column],
            color=COLOURS[k],
            linestyle=_LINE_STYLES[k],
            linewidth=1.5,
            label=label,
        )
    ax.set_xscale("log")


# ---- sources side by side


def sources(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the third octaves of vibration, release and sound power of a run with dynamics.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with pressure levels, dB re 20 µPa, and power levels, dB re 1 pW, over frequency, Hz.

    Raises
    ------
    ValueError
        The run has no vibration.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.sources(run)
    """
    _vibration(run)
    unknown = dict.fromkeys(BAND_NAMES)
    shown = _sources(run)
    curves = [
        (source.label, source.levels_db, unknown)
        for source in shown
        if any(source.levels_db.values())
    ]
    ax = third_octaves(axes_of(ax), curves, run.sound.duration)
    _show_down_to(ax, shown[0].levels_db)
    ax.set_ylabel("level without weighting [dB]")
    distance = f"listener at {number(run.scene.vibration_distance_m)} m"
    if run.scene.sound.listener_mm is not None:
        distance += " from the contact"
    if run.scene.plate.loss_factor is None:
        losses = "no loss factor, so no sound power above coincidence"
    else:
        losses = f"loss factor {loss_text(run.scene.plate.loss_factor)}"
    facts = [distance, duration_text([run]), "sound power of one side of the plate", losses]
    title = "Vibration and sound powers"
    if run.scene.has_release:
        title = "Vibration, released power and sound powers"
    return finish(ax, f"{title}: {run.title}", facts)


def _show_down_to(ax: Axes, levels: Mapping[str, float | None]) -> None:
    """Extend the axis of levels [dB] downwards, so that the strongest bands of a source show."""
    known = [level for level in levels.values() if level is not None]
    if known:
        low, _ = ax.get_ylim()
        ax.set_ylim(bottom=min(low, 10.0 * math.floor((max(known) - _BANDS_DB) / 10.0)))


def _share_text(run: Run) -> str:
    """Say which share of the released power counts as sound."""
    q = run.scene.sound.q
    return "q = 1, upper bound" if q == 1 else f"q = {q:g}"


def source_table(run: Run) -> pd.DataFrame:
    """Tabulate the third octaves of the sources of a run [dB]."""
    _vibration(run)
    return band_table({f"{source.name}_level_db": source.levels_db for source in _sources(run)})


class _Source(NamedTuple):
    """A source of sound: its name in tables, its label in the legend, its third octaves [dB]."""

    name: str
    label: str
    levels_db: Mapping[str, float | None]


def _sources(run: Run) -> list[_Source]:
    """Return the sources of a run with dynamics, the vibration first.

    All are heard where the vibration is. The release belongs to a ball that rolls under its load,
    which a ball that falls does not.
    """
    bands = run.numbers.bands
    release = f"released power, {_share_text(run)} [dB re 20 µPa]"
    rows = [("vibration", "vibration, sound pressure level [dB re 20 µPa]", bands.vibration)]
    if run.scene.has_release:
        rows.append(("released_power", release, bands.released_power_at_listener))
    rows += [
        ("plate_power", "sound power level of the plate [dB re 1 pW]", bands.plate_power),
        ("ball_power", "sound power level of the ball [dB re 1 pW]", bands.ball_power),
    ]
    return [
        _Source(name, label, levels.by_name) for name, label, levels in rows if levels is not None
    ]


# ---- contact force


def contact_force(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the contact force over the load of a run with dynamics against time.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with minimum and maximum of the force in each column, over time, ms: over the load, or
        in newtons for a ball that falls.

    Raises
    ------
    ValueError
        The run has no vibration.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.contact_force(run)
    """
    vibration = _vibration(run)
    motion = vibration.motion
    ratio = vibration.force_ratio
    table = contact_force_table(run)
    factor = 1.0
    label = "contact force over load [-]"
    if not run.scene.keeps_its_load:  # whose impacts are many times the load
        newton, prefix = unit_prefix(float(vibration.load * ratio.max()))
        factor = vibration.load / newton
        label = f"contact force [{prefix}N]"
    ax = axes_of(ax)
    ax.fill_between(
        1e3 * table["time_s"],
        factor * table["minimum_ratio"],
        factor * table["maximum_ratio"],
        step="post",
        color=COLOURS[0],
        linewidth=0.6,
    )
    ax.axhline(factor, color="0.4", linewidth=0.6)
    ax.set(xlabel="time [ms]", ylabel=label)
    ax.set_xlim(0.0, 1e3 * motion.time_step_s * len(ratio))
    facts = [
        f"load {rounded(vibration.load, 4)} N",
        f"fluctuation {rounded(vibration.rms_ratio, 3)} of the load (rms), "
        f"from {rounded(ratio.min(), 3)} to {rounded(ratio.max(), 3)} times the load",
    ]
    if motion.flight_share > 0 or motion.impacts:
        facts.append(f"in flight {rounded(100 * motion.flight_share, 3)} % of the time")
        facts.append("1 impact" if motion.impacts == 1 else f"{motion.impacts} impacts")
    else:
        facts.append("the ball never loses contact")
    return finish(ax, f"Contact force: {run.title}", facts)


def contact_force_table(run: Run) -> pd.DataFrame:
    """Tabulate minimum and maximum of the contact force over the load by time [s]."""
    vibration = _vibration(run)
    ratio = vibration.force_ratio
    count = min(_COLUMNS, len(ratio))
    starts = np.arange(count) * len(ratio) // count
    return pd.DataFrame(
        {
            "time_s": vibration.motion.time_s[starts],
            "minimum_ratio": np.minimum.reduceat(ratio, starts),
            "maximum_ratio": np.maximum.reduceat(ratio, starts),
        }
    )


# ---- contact filter


def contact_filter(run: Run, ax: Axes | None = None) -> Axes:
    """Plot surface and approach of a run over wavelength, and their difference, the filter.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with third octaves, dB re 1 µm rms, over wavelength, µm.

    References
    ----------
    P. J. Remington, J. Sound Vib. 46 (1976), 419-436, for the contact filter of wheel and rail.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.contact_filter(run)
    """
    instance("run", run, Run)
    table = contact_filter_table(run)
    radius_um = 1e6 * smooth_contact_of(run.scene).semi_axes_m()[0]
    ax = axes_of(ax)
    labels = {
        "surface_level_db": "heights of the surface under the contact",
        "approach_level_db": "movement of the ball under its load (approach)",
        "contact_filter_db": "contact filter: their difference",
    }
    _draw_columns(ax, table, labels)
    ax.set(xlabel="wavelength along the track [µm]", ylabel="level [dB re 1 µm], difference [dB]")
    ax.axvline(radius_um, color="0.4", linestyle=":", linewidth=1.0)
    ax.set_ylim(bottom=np.nanmin(table["approach_level_db"]) - 10)
    ax.invert_xaxis()
    facts = [
        "third octaves of wavelength, rms",
        f"constant load of {rounded(run.scene.load, 4)} N",
        f"dotted: radius of Hertz's contact, {rounded(radius_um, 3)} µm",
    ]
    return finish(ax, f"Contact filter: {run.title}", facts)


def contact_filter_table(run: Run) -> pd.DataFrame:
    """Tabulate the levels of surface and approach [dB re 1 µm] by wavelength [µm]."""
    scene = run.scene
    result = run.result
    heights = scene_surface(scene).heights
    middle = heights.shape[1] // 2
    half_width = max(1, round(smooth_contact_of(scene).semi_axes_m()[1] / scene.spacing))
    under_contact = heights[:, max(0, middle - half_width) : middle + half_width]
    closed = scene.track.lap_steps <= result.solved_steps
    surface_wavelength, heights_db = wavelength_bands(under_contact, scene.spacing, closed)
    approach = result.series["approach"][: result.solved_steps]
    wavelength, level_db = wavelength_bands(approach, result.step, closed)
    surface_db = np.interp(-np.log(wavelength), -np.log(surface_wavelength), heights_db)
    # Where the surface has next to nothing, the approach is bent by the contact, not filtered.
    rough = surface_db > np.nanmax(surface_db) - _FILTERED_DB
    return pd.DataFrame(
        {
            "wavelength_um": 1e6 * wavelength,
            "surface_level_db": surface_db,
            "approach_level_db": level_db,
            "contact_filter_db": np.where(rough, level_db - surface_db, np.nan),
        }
    )


# ---- mobilities


def mobilities(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the mobilities of sphere, contact and plate of a run, with the resonance marked.

    Parameters
    ----------
    run : Run
        Run to plot.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with magnitudes of the mobility, s/kg, over frequency, Hz.

    Raises
    ------
    ValueError
        The run has no vibration.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.mobilities(run)
    """
    chain = _vibration(run).chain
    table = mobility_table(run)
    ax = axes_of(ax)
    _draw_columns(
        ax,
        table,
        {column: _body(column) for column in table.columns[1:]},
    )
    ax.set(xlabel="frequency [Hz]", ylabel="mobility: velocity per force [s/kg]", yscale="log")
    ax.axvline(chain.resonance_hz, color="0.4", linestyle=":", linewidth=1.0)
    quality = "undamped" if np.isinf(chain.quality) else f"Q = {rounded(chain.quality, 3)}"
    if run.scene.plate.thickness_mm is None:
        plate = "half-space at the resonance's damping"
    elif run.scene.plate.length_mm is not None:
        plate = f"plate of {run.scene.plate.thickness_mm:g} mm with edges"
    else:
        plate = f"infinite plate of {run.scene.plate.thickness_mm:g} mm"
    resonance = f"{number(chain.resonance_hz)} Hz, {quality}"
    facts = [f"dotted: resonance of the ball on its contact at {resonance}", plate]
    return finish(ax, f"Mobilities: {run.title}", facts)


def _body(column: str) -> str:
    """Name the bodies of a column of mobilities."""
    return column.removesuffix("_s_kg").replace("_", " ").replace("sphere", "ball")


def mobility_table(run: Run) -> pd.DataFrame:
    """Tabulate the magnitudes of the mobilities of a run [s/kg] by frequency [Hz]."""
    chain = _vibration(run).chain
    frequency = np.geomspace(20.0, max(40e3, 2 * chain.resonance_hz), 400)
    mobilities = {
        name.replace("ball", "sphere"): mobility
        for name, mobility in chain.mobilities(frequency).items()
    }
    mobilities["all_three_in_a_row"] = np.asarray(sum(mobilities.values()))
    table = pd.DataFrame({"frequency_hz": frequency})
    for name, mobility in mobilities.items():
        table[f"{name}_s_kg"] = np.abs(mobility)
    return table
