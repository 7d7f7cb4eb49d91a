"""Figures of the vibration of a run: sources, contact force, contact filter, mobilities."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics.arrays import instance
from acoustics.bands import BAND_NAMES
from acoustics.numbers import rounded
from acoustics.plots import COLOURS, third_octaves
from acoustics.traps import ignoring_underflow
from rolling.dynamics.smooth_contact import semi_axes
from rolling.figures.picture import axes_of, duration_text, finish, number
from rolling.figures.sound import band_table
from rolling.results.run_result import Run
from rolling.sound.vibration_sound import Vibration
from rolling.sound.wavelengths import wavelength_bands
from rolling.surface.scene_surface import scene_surface

_COLUMNS = 1500  # of the force over time, in each of which minimum and maximum are drawn
_FILTERED_DB = 40.0  # below the maximum of the surface's spectrum
_LINE_STYLES = ("-", "--", "-.", ":")


def _vibration(run: Run) -> Vibration:
    """Return the vibration of a run; raise TypeError or ValueError if there is none."""
    instance("run", run, Run)
    if run.vibration is None:
        raise ValueError(f"{run.title}: has no vibration, because its scene has no dynamics")
    return run.vibration


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


@ignoring_underflow
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
    labels = {
        "vibration": "pressure of the vibration [dB re 20 µPa]",
        "release": f"pressure of the release, q = {run.scene.sound.q:g} [dB re 20 µPa]",
        "plate_power": "sound power of the plate [dB re 1 pW]",
        "ball_power": "sound power of the sphere [dB re 1 pW]",
    }
    names = source_names(run)
    unknown = dict.fromkeys(BAND_NAMES)
    curves = []
    for name in names:
        levels = run.summary[f"{name}_third_octave_db"]
        if any(levels.values()):
            curves.append((labels[name], levels, unknown))
    ax = third_octaves(axes_of(ax), curves, run.sound.duration)
    ax.set_ylabel("level [dB]")
    distance = f"at {number(run.scene.vibration_distance_m)} m"
    if run.scene.sound.listener_mm is not None:
        distance += " from the contact"
    if run.scene.plate.loss_factor is None:
        losses = "no loss factor: no power above coincidence"
    else:
        losses = f"loss factor {run.scene.plate.loss_factor:g}"
    facts = [distance, duration_text([run]), "one side of the plate", losses]
    title = "Vibration and release" if "release" in names else "Vibration"
    return finish(ax, f"{title}: {run.title}", facts)


def source_table(run: Run) -> pd.DataFrame:
    """Tabulate the third octaves of the sources of a run [dB]."""
    columns = {
        f"{name}_level_db": run.summary[f"{name}_third_octave_db"] for name in source_names(run)
    }
    return band_table(columns)


def source_names(run: Run) -> list[str]:
    """Return the sources of a run with dynamics by their names in summary.json.

    The release belongs to a ball that rolls under its load, which a ball that falls does not.
    """
    if run.scene.rolling.drop_mm is not None:
        return ["vibration", "plate_power", "ball_power"]
    return ["vibration", "release", "plate_power", "ball_power"]


# ---- contact force


@ignoring_underflow
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
        Axes with minimum and maximum of the force over the load in each column, over time, ms.

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
    ax = axes_of(ax)
    ax.fill_between(
        1e3 * table["time_s"],
        table["minimum_ratio"],
        table["maximum_ratio"],
        step="post",
        color=COLOURS[0],
        linewidth=0.6,
    )
    ax.axhline(1.0, color="0.4", linewidth=0.6)
    ax.set(xlabel="time [ms]", ylabel="contact force over load [-]")
    ax.set_xlim(0.0, 1e3 * motion.time_step_s * len(ratio))
    facts = [
        f"load {vibration.load:g} N",
        f"rms {rounded(vibration.rms_ratio, 3)},"
        f" from {rounded(ratio.min(), 3)} to {rounded(ratio.max(), 3)}",
        f"in flight {rounded(100 * motion.flight_share)} % of the time",
        "1 impact" if motion.impacts == 1 else f"{motion.impacts} impacts",
    ]
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


@ignoring_underflow
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
    radius_um = 1e6 * semi_axes(run.scene)[0]
    ax = axes_of(ax)
    labels = {
        "surface_level_db": "surface, lines under the contact",
        "approach_level_db": "approach under the load",
        "contact_filter_db": "contact filter, their difference [dB]",
    }
    _draw_columns(ax, table, labels)
    ax.set(xlabel="wavelength [µm]", ylabel="level [dB]")
    ax.axvline(radius_um, color="0.4", linestyle=":", linewidth=1.0)
    ax.set_ylim(bottom=np.nanmin(table["approach_level_db"]) - 10)
    ax.invert_xaxis()
    facts = [
        "third octaves, dB re 1 µm rms",
        f"load {rounded(run.scene.load, 6)} N, constant",
        f"dotted: Hertz radius {rounded(radius_um, 3)} µm",
    ]
    return finish(ax, f"Contact filter: {run.title}", facts)


def contact_filter_table(run: Run) -> pd.DataFrame:
    """Tabulate the levels of surface and approach [dB re 1 µm] by wavelength [µm]."""
    scene = run.scene
    result = run.result
    heights = scene_surface(scene).heights
    middle = heights.shape[1] // 2
    half_width = max(1, round(semi_axes(scene)[1] / scene.spacing))
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


@ignoring_underflow
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
        {column: column.removesuffix("_s_kg").replace("_", " ") for column in table.columns[1:]},
    )
    ax.set(xlabel="frequency [Hz]", ylabel="magnitude of the mobility [s/kg]", yscale="log")
    ax.axvline(chain.resonance_hz, color="0.4", linestyle=":", linewidth=1.0)
    quality = "undamped" if np.isinf(chain.quality) else f"Q {rounded(chain.quality, 3)}"
    if run.scene.plate.thickness_mm is None:
        plate = "half-space at the resonance's damping"
    else:
        plate = f"infinite plate of {run.scene.plate.thickness_mm:g} mm"
    facts = [
        f"dotted: resonance of sphere and contact at {number(chain.resonance_hz)} Hz, {quality}",
        plate,
    ]
    return finish(ax, f"Mobilities: {run.title}", facts)


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
