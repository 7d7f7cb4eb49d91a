"""Pictures of a vibration: sources, force, contact filter, mobilities, slopes over speed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.plots import COLOURS
from rolling._typing import Array
from rolling.contact import closed_forms
from rolling.figures import captions
from rolling.figures.picture import Picture, single
from rolling.scene.sweep import Value
from rolling.simulation import labels
from rolling.simulation.run_result import RunResult
from rolling.sound.effective_roughness import WavelengthBands, wavelength_bands
from rolling.sound.vibration_sound import Vibration
from rolling.surface.scene_surface import scene_surface

SPEED = "rolling.speed_m_s"
_COLUMNS = 1500  # of the force over time, in each of which minimum and maximum are drawn
_FILTERED_DB = 40.0  # below the maximum of the surface's spectrum
_STYLES = ("-", "--", "-.", ":")


def pictures(run: RunResult) -> Iterator[Picture]:
    """Draw the pictures of a run that vibrates; none without dynamics."""
    if run.vibration is None:
        return
    yield sources(run, run.vibration)
    yield contact_force(run, run.vibration)
    yield contact_filter(run)
    yield mobilities(run, run.vibration)


def _curves(ax: Axes, xlabel: str, ylabel: str) -> None:
    """Finish axes with logarithmic abscissa and a legend below."""
    ax.set_xscale("log")
    ax.set_xlabel(xlabel)
    ax.set_ylabel(ylabel)
    ax.grid(True, which="major", color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)


# ---- sources side by side


def sources(run: RunResult, vibration: Vibration) -> Picture:
    """Draw the third octaves of vibration and release, and of the sound power."""
    summary, q = run.summary, run.scene.sound.q
    curves = {
        "pressure of the vibration [dB re 20 µPa]": summary["vibration_third_octave_db"],
        f"pressure of the release, q = {q:g} [dB re 20 µPa]": summary["release_third_octave_db"],
        "sound power of the plate [dB re 1 pW]": summary["plate_power_third_octave_db"],
        "sound power of the sphere [dB re 1 pW]": summary["ball_power_third_octave_db"],
    }
    curves = {name: levels for name, levels in curves.items() if any(levels.values())}
    nothing = dict.fromkeys(BAND_NAMES)
    shown = [(name, levels, nothing) for name, levels in curves.items()]
    loss = run.scene.plate.loss_factor
    facts = [
        captions.distance([run]),
        captions.duration([run]),
        "one side of the plate",
        "no loss factor: no power above coincidence" if loss is None else f"loss factor {loss:g}",
    ]

    def draw(ax: Axes) -> None:
        sound_plots.third_octaves(ax, shown, run.sound.duration)
        ax.set_ylabel("level [dB]")

    columns: dict[str, NDArray[Any]] = {"mid_frequency_hz": np.array(MID_HZ)}
    for key in ("vibration", "release", "plate_power", "ball_power"):
        levels = summary[f"{key}_third_octave_db"]
        columns[f"{key}_level_db"] = captions.gaps(levels[name] for name in BAND_NAMES)
    title = f"Vibration and release: {captions.subject([run])}"
    return single("sources", title, captions.note(facts), columns, draw)


# ---- contact force


def contact_force(run: RunResult, vibration: Vibration) -> Picture:
    """Draw the contact force over the load against time, as minimum and maximum of columns."""
    motion, ratio = vibration.motion, vibration.force_ratio
    count = min(_COLUMNS, len(ratio))
    starts = np.arange(count) * len(ratio) // count
    low, high = np.minimum.reduceat(ratio, starts), np.maximum.reduceat(ratio, starts)
    time = motion.time_s[starts]
    facts = [
        f"load {vibration.load:g} N",
        f"rms {vibration.rms_ratio:.3g}, from {ratio.min():.3g} to {ratio.max():.3g}",
        f"in flight {100 * motion.flight_share:.2g} % of the time",
        f"{motion.impacts} impacts",
    ]

    def draw(ax: Axes) -> None:
        ax.fill_between(1e3 * time, low, high, step="post", color=COLOURS[0], linewidth=0.6)
        ax.axhline(1.0, color="0.4", linewidth=0.6)
        ax.set_xlim(0.0, 1e3 * motion.time_step_s * len(ratio))
        ax.set_xlabel("time [ms]")
        ax.set_ylabel("contact force over load [-]")
        ax.grid(True, color="0.85", linewidth=0.5)
        ax.set_axisbelow(True)

    columns = {"time_s": time, "minimum_ratio": low, "maximum_ratio": high}
    title = f"Contact force: {captions.subject([run])}"
    return single("contact_force", title, captions.note(facts), columns, draw)


# ---- contact filter


def roughness(run: RunResult) -> tuple[WavelengthBands, WavelengthBands]:
    """Return the third octaves over wavelength of the surface and of the approach.

    The surface is the mean of the lines under the contact of the smooth sphere.
    """
    scene, result = run.scene, run.result
    heights = scene_surface(scene).heights
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    middle, reach = heights.shape[1] // 2, max(1, round(radius / scene.spacing))
    under = heights[:, max(0, middle - reach) : middle + reach]
    closed = scene.track.lap_steps <= result.solved_steps
    approach = result.series["approach"][: result.solved_steps]
    return (
        wavelength_bands(under, scene.spacing, closed),
        wavelength_bands(approach, result.step, closed),
    )


def contact_filter(run: RunResult) -> Picture:
    """Draw surface and approach over wavelength, and their difference, the contact filter."""
    surface, approach = roughness(run)
    levels = np.interp(-np.log(approach.wavelength), -np.log(surface.wavelength), surface.level_db)
    # Where the surface has next to nothing, the approach is bent by the contact, not filtered.
    rough = levels > np.nanmax(levels) - _FILTERED_DB
    passed = np.where(rough, approach.level_db - levels, np.nan)
    wavelength = 1e6 * approach.wavelength
    radius = closed_forms.hertz_radius(run.scene.load, run.scene.radius, run.scene.contact_modulus)
    facts = [
        "third octaves, dB re 1 µm rms",
        f"load {run.scene.load:g} N, constant",
        f"dotted: Hertz radius {1e6 * radius:.3g} µm",
    ]

    def draw(ax: Axes) -> None:
        for number, (name, x, level) in enumerate(
            (
                ("surface, lines under the contact", 1e6 * surface.wavelength, surface.level_db),
                ("approach under the load", wavelength, approach.level_db),
                ("contact filter, their difference [dB]", wavelength, passed),
            )
        ):
            ax.plot(x, level, _STYLES[number], color=COLOURS[number], linewidth=1.5, label=name)
        ax.axvline(1e6 * radius, color="0.4", linestyle=":", linewidth=1.0)
        ax.set_ylim(bottom=np.nanmin(approach.level_db) - 10)
        _curves(ax, "wavelength [µm]", "level [dB]")
        ax.invert_xaxis()

    columns = {
        "wavelength_um": wavelength,
        "surface_level_db": levels,
        "approach_level_db": approach.level_db,
        "contact_filter_db": passed,
    }
    title = f"Contact filter: {captions.subject([run])}"
    return single("contact_filter", title, captions.note(facts), columns, draw)


# ---- mobilities


def mobilities(run: RunResult, vibration: Vibration) -> Picture:
    """Draw the mobilities of sphere, contact and plate, with the resonance marked."""
    chain = vibration.chain
    frequency = np.geomspace(20.0, max(40e3, 2 * chain.resonance_hz), 400)
    values = {name: np.abs(values) for name, values in chain.mobilities(frequency).items()}
    both = np.abs(sum(chain.mobilities(frequency).values()))
    quality = "undamped" if np.isinf(chain.quality) else f"Q {chain.quality:.3g}"
    facts = [
        f"dotted: resonance of sphere and contact at {captions.number(chain.resonance_hz)} Hz"
        f", {quality}",
        "half-space at the resonance's damping"
        if run.scene.plate.thickness_mm is None
        else f"infinite plate of {run.scene.plate.thickness_mm:g} mm",
    ]
    curves: dict[str, Array] = values | {"all three in a row": np.asarray(both)}

    def draw(ax: Axes) -> None:
        for number, (name, level) in enumerate(curves.items()):
            name = "sphere" if name == "ball" else name
            ax.plot(frequency, level, _STYLES[number], color=COLOURS[number], label=name)
        ax.axvline(chain.resonance_hz, color="0.4", linestyle=":", linewidth=1.0)
        ax.set_yscale("log")
        _curves(ax, "frequency [Hz]", "magnitude of the mobility [s/kg]")

    columns = {"frequency_hz": frequency} | {
        f"{name.replace(' ', '_').replace('ball', 'sphere')}_s_kg": values
        for name, values in curves.items()
    }
    title = f"Mobilities: {captions.subject([run])}"
    return single("mobilities", title, captions.note(facts), columns, draw)


# ---- levels over speed


def slope_db(speeds: Sequence[float], levels: Sequence[float]) -> float:
    """Return the slope of levels over speed [dB per decade], by least squares."""
    return float(np.polyfit(np.log10(speeds), levels, 1)[0])


def speed_slopes(runs: Sequence[RunResult]) -> Picture | None:
    """Draw LAeq of both sources over speed, with their slopes.

    Return None unless runs with dynamics sweep a constant speed.
    """
    # A speed profile is swept by labels, which are no numbers.
    vibrating = [
        run
        for run in runs
        if run.vibration is not None and isinstance(run.values.get(SPEED), float | int)
    ]
    if len({run.values[SPEED] for run in vibrating}) < 2:
        return None

    def others(run: RunResult) -> tuple[str, tuple[tuple[str, Value], ...]]:
        return run.scene.name, tuple(each for each in run.values.items() if each[0] != SPEED)

    curves: list[tuple[str, Array, Array]] = []
    for (_, values), group in groupby(sorted(vibrating, key=others), key=others):
        members = sorted(group, key=lambda run: run.values[SPEED])
        for source in ("vibration", "release"):
            points = [
                (run.values[SPEED], level)
                for run in members
                if (level := run.summary[f"{source}_laeq_db"]) is not None
            ]
            if len(points) > 1:
                x, y = np.array(points).T
                words = ", ".join([source, *(labels.worded(*value) for value in values)])
                curves.append((f"{words}: {slope_db(x, y):.1f} dB per decade", x, y))
    if not curves:
        return None

    def draw(ax: Axes) -> None:
        for number, (name, x, y) in enumerate(curves):
            colour = COLOURS[number // 2 % len(COLOURS)]
            ax.plot(x, y, "o" + _STYLES[number % 2], color=colour, label=name, markersize=4)
        _curves(ax, "speed [m/s]", "LAeq [dB re 20 µPa]")

    columns: dict[str, NDArray[Any]] = {
        "curve": np.repeat([name for name, _, _ in curves], [len(x) for _, x, _ in curves]),
        "speed_m_s": np.concatenate([x for _, x, _ in curves]),
        "laeq_db": np.concatenate([y for _, _, y in curves]),
    }
    q = captions.common("release with q =", [run.scene.sound.q for run in vibrating])
    note = captions.note([captions.distance(vibrating), q])
    title = f"Both sources over speed: {captions.subject(vibrating)}"
    return single("speed_slopes", title, note, columns, draw)
