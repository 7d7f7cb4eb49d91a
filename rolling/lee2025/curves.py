"""Figures of curves: plastic ratio, spectra, maximum levels and correlation length.

They are Fig. 7 to 9 of the article. All readings are drawn on the same axes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from acoustics import plots as sound_plots
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, LEAST_BT, reliable
from acoustics.plots import COLOURS, LINE_STYLES, MARKERS, Lines
from rolling._typing import Array
from rolling.figures.picture import BOTTOM_IN, LEFT_IN, RIGHT_IN, WIDTH_IN, Picture, blank
from rolling.lee2025.figure_data import NOTHING_DB, Reading, Scales
from rolling.lee2025.figure_layout import WARNING, Place, finish, panel_title, steep
from rolling.lee2025.study import Case

# Ra [um] and load [N] whose maximum line level is the reference of 20 lg levels
SCALE_REFERENCE = (1.0, 20.0)
_SCALE_ROOM_IN = 0.75  # room for the axis on the right


def plastic_ratio(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 7: plastic area over the Hertz area against load, over all surfaces."""
    figure = blank()
    ax = figure.add_subplot()
    columns = _against_load(
        ax, reading, on, lambda case: case.plastic_ratio, "plastic area / Hertz area", "1"
    )
    ax.set_ylim(-0.03 * on.plastic_ratio, on.plastic_ratio)
    shown = shown_roughnesses(reading, on)
    places: dict[Axes, Place] = {ax: (LEFT_IN, BOTTOM_IN, WIDTH_IN - LEFT_IN - RIGHT_IN, 3.5)}
    note = (
        f"{_surfaces_of(reading.cases)}; mean along the track; Hertz area: "
        "of the smooth elastic contact"
    )
    return finish("fig7_plastic_ratio", "Plastic ratio", note, reading, shown, places, columns)


def spectra(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 8: the article's A-weighted line spectra.

    Each roughness has a panel, each load a curve.
    """
    figure = blank()
    shown = shown_roughnesses(reading, on)
    reference = _reference_db(reading)
    columns: dict[str, Array] = {}
    places: dict[Axes, Place] = {}
    gap, wide, tall, step = 0.2, 3.3, 2.35, 2.5
    for number, ra in enumerate(shown):
        ax = figure.add_subplot()
        curves = []
        for load in on.loads:
            frequency, level = _mean_spectrum(reading.at(roughness_um=ra, load_n=load))
            # The legend is taken from the first panel, so it must name the loads of all panels.
            # Labels
            # that begin with "_" are left out of it.
            curves.append((f"{load:g} N" if reading.at(load_n=load) else "_", frequency, level))
            if len(frequency):
                _add(columns, f"Ra {ra:g} µm, {load:g} N", frequency, level)
        _spectra(ax, curves, [case.duration_s for case in reading.cases], on.spectrum_db)
        row, column = divmod(number, 2)
        below = (len(shown) - 1) // 2 - row
        _heading(ax, panel_title(reading, ra), steep(reading, ra))
        ax.tick_params(labelleft=column == 0, labelbottom=number + 2 >= len(shown))
        ax.set_xlabel("frequency [Hz]" if number + 2 >= len(shown) else "")
        ax.set_ylabel("A-weighted line level\n[dB re 1 pW/m²]" if column == 0 else "")
        if column == 1 or len(shown) == 1:
            _twice(ax, reference)
        places[ax] = (LEFT_IN + column * (wide + gap), BOTTOM_IN + below * step, wide, tall)
    note = "; ".join([_duration(reading.cases), _mean_over(reading.cases), _scale_note(reference)])
    return finish("fig8_spectra", "A-weighted spectra", note, reading, shown, places, columns)


def maximum_level(reading: Reading, on: Scales) -> Picture:
    """Draw Fig. 9: maximum A-weighted line level against load, over all surfaces."""
    figure = blank()
    ax = figure.add_subplot()
    label = "maximum A-weighted line level"
    columns = _against_load(ax, reading, on, lambda case: case.maximum_db, label, "dB re 1 pW/m²")
    ax.set_ylim(on.maximum_db)
    reference = _reference_db(reading)
    if reference is not None:
        for name, values in list(columns.items())[1:]:
            spread = "deviation" in name
            quantity = "standard deviation" if spread else "relative to Ra 1 µm, 20 N"
            columns[f"{name.partition(':')[0]}, 20 lg: {quantity} [dB]"] = 2 * (
                values if spread else values - reference
            )
    _twice(ax, reference)
    shown = shown_roughnesses(reading, on)
    places: dict[Axes, Place] = {ax: (LEFT_IN, BOTTOM_IN, WIDTH_IN - LEFT_IN - _SCALE_ROOM_IN, 3.5)}
    note = "; ".join(
        [_surfaces_of(reading.cases), _duration(reading.cases), _scale_note(reference)]
    )
    return finish(
        "fig9_maximum_level", "Maximum A-weighted level", note, reading, shown, places, columns
    )


def correlation_length(reading: Reading) -> Picture:
    """Draw the spectra for each correlation length, and the levels against it."""
    figure = blank()
    left, right = figure.add_subplot(), figure.add_subplot()
    lengths = np.array(reading.lengths)
    columns: dict[str, Array] = {}
    curves = []
    for length in reading.lengths:
        frequency, level = _mean_spectrum(reading.at(correlation_um=length))
        curves.append((f"length {length:g} µm", frequency, level))
        _add(columns, f"length {length:g} µm", frequency, level)
    limits = sound_plots.level_limits(level for _, _, levels in curves for level in levels)
    _spectra(left, curves, [case.duration_s for case in reading.cases], limits)
    columns["correlation length [µm]"] = lengths
    levels: tuple[tuple[str, str, Callable[[Case], float | None]], ...] = (
        ("LAeq", "dB re 20 µPa", lambda case: case.laeq_db),
        ("maximum line", "dB re 1 pW/m²", lambda case: case.maximum_db),
    )
    seen: list[float] = []
    for number, (name, unit, quantity) in enumerate(levels):
        mean, spread = _statistics(
            [reading.at(correlation_um=length) for length in reading.lengths], quantity
        )
        _points(right, lengths, mean, spread, number, f"{name} [{unit}]")
        columns |= {f"{name} [{unit}]": mean, f"{name}: standard deviation [dB]": spread}
        seen += [*mean]
    _varied(right, reading.lengths, "correlation length [µm]")
    right.set_ylim(sound_plots.level_limits(seen))
    right.set_ylabel("A-weighted level [dB]")
    right.legend(fontsize=8, loc="best")
    left.set_ylabel("A-weighted line level [dB re 1 pW/m²]")
    wide = 4.35
    places: dict[Axes, Place] = {
        left: (LEFT_IN, BOTTOM_IN, wide, 3.3),
        right: (LEFT_IN + wide + 0.75, BOTTOM_IN, WIDTH_IN - LEFT_IN - RIGHT_IN - wide - 0.75, 3.3),
    }
    shown = sorted({case.roughness_um for case in reading.cases})
    loads = sorted({case.load_n for case in reading.cases})
    conditions = (
        f"Ra {', '.join(f'{ra:g}' for ra in shown)} µm; "
        f"{', '.join(f'{load:g}' for load in loads)} N"
    )
    note = "; ".join(
        [conditions, _duration(reading.cases), f"spectra: {_mean_over(reading.cases)}"]
    )
    return finish("correlation_length", "Correlation length", note, reading, shown, places, columns)


def _heading(ax: Axes, text: str, warned: bool) -> None:
    """Write the title of a panel; a coloured title is a warning."""
    colour = WARNING if warned else "black"
    ax.text(
        0.03,
        0.96,
        text,
        transform=ax.transAxes,
        va="top",
        fontsize=9,
        fontweight="bold",
        color=colour,
    )


def shown_roughnesses(reading: Reading, on: Scales) -> list[float]:
    """Return the roughnesses of the solved cases, in the order of the axes."""
    solved = {case.roughness_um for case in reading.cases}
    return [ra for ra in on.roughnesses if ra in solved]


def _against_load(
    ax: Axes,
    reading: Reading,
    on: Scales,
    quantity: Callable[[Case], float | None],
    label: str,
    unit: str,
) -> dict[str, Array]:
    """Plot mean and standard deviation of a quantity against load, with a curve per roughness.

    Returns the plotted numbers as columns.
    """
    loads = np.array(on.loads)
    columns: dict[str, Array] = {"load [N]": loads}
    for number, ra in enumerate(on.roughnesses):
        groups = [reading.at(roughness_um=ra, load_n=load) for load in on.loads]
        if not any(groups):
            continue
        mean, spread = _statistics(groups, quantity)
        _points(ax, loads, mean, spread, number, panel_title(reading, ra))
        columns |= {
            f"Ra {ra:g} µm: {label} [{unit}]": mean,
            f"Ra {ra:g} µm: standard deviation [{unit.split(' ')[0]}]": spread,
        }
    _varied(ax, on.loads, "load [N]")
    ax.set_ylabel(label if unit == "1" else f"{label} [{unit}]")
    return columns


def _statistics(
    groups: Sequence[Sequence[Case]], quantity: Callable[[Case], float | None]
) -> tuple[Array, Array]:
    """Compute mean and standard deviation of each group.

    The mean of an empty group is NaN, as is the deviation of a single value.
    """
    mean, spread = np.full(len(groups), np.nan), np.full(len(groups), np.nan)
    for number, group in enumerate(groups):
        numbers = [quantity(case) for case in group]
        values = [value for value in numbers if value is not None and value > NOTHING_DB]
        if values:
            mean[number] = np.mean(values)
        if len(values) > 1:
            spread[number] = np.std(values, ddof=1)
    return mean, spread


def _points(ax: Axes, x: Array, mean: Array, spread: Array, number: int, label: str) -> None:
    """Plot mean values with error bars, joined across missing values."""
    there = np.isfinite(mean)
    ax.errorbar(
        x[there], mean[there], spread[there], label=label, capsize=3, markersize=5, **_look(number)
    )


def _look(number: int) -> dict[str, Any]:
    """Return colour, line style and marker of a curve."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "linestyle": LINE_STYLES[number % len(LINE_STYLES)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def _varied(ax: Axes, values: Sequence[float], label: str) -> None:
    """Set up the axis of the varied quantity."""
    if len(values) > 1 and values[0] > 0.0:
        ax.set_xscale("log")
    ax.set_xticks(values, [f"{value:g}" for value in values])
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel(label)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)


def _mean_spectrum(cases: Sequence[Case]) -> tuple[Array, Array]:
    """Return frequencies [Hz] and the level of the mean power of several surfaces [dB].

    The level is NaN without sound; both arrays are empty without cases.
    """
    if not cases:
        return np.empty(0), np.empty(0)
    power = np.mean([10 ** (case.line_db / 10) for case in cases], axis=0)
    level = 10 * np.log10(np.maximum(power, 10 ** (NOTHING_DB / 10)))
    return cases[0].line_hz, np.where(level > NOTHING_DB + 1e-6, level, np.nan)


def _spectra(
    ax: Axes,
    curves: Sequence[tuple[str, Array, Array]],
    durations_s: Sequence[float],
    limits_db: tuple[float, float],
) -> None:
    """Plot spectra, with a grey area where third octaves of the shortest record are unreliable."""
    sound_plots.spectrum(ax, [("", Lines(np.array([1e3]), np.array([-np.inf])))], limits_db)
    for line in (*ax.lines, *ax.texts):
        line.remove()
    for number, (label, frequency, level) in enumerate(curves):
        look = _look(number)
        del look["marker"]
        ax.plot(frequency, level, label=label, linewidth=1.4, **look)
    first = _first_reliable(durations_s)
    if first:
        ax.axvspan(
            AUDIBLE_HZ[0],
            EDGES_HZ[first],
            color="0.92",
            zorder=0,
            label=f"third octaves uncertain by 2 dB or more (B T < {LEAST_BT:g})",
        )


def _first_reliable(durations_s: Sequence[float]) -> int:
    """Return the number of the lowest third octave that the shortest record resolves."""
    read = reliable(min(durations_s))
    return int(np.argmax(read)) if read.any() else len(read)


def _duration(cases: Sequence[Case]) -> str:
    """Write the duration of the records, and the lowest reliable third octave."""
    durations = [case.duration_s for case in cases]
    ends = dict.fromkeys(f"{value:.3g}" for value in (min(durations), max(durations)))
    first = _first_reliable(durations)
    mean = (
        f"third octaves are reliable from {BAND_NAMES[first]} Hz"
        if first < len(BAND_NAMES)
        else "no third octave is reliable"
    )
    return f"T = {' to '.join(ends)} s: {mean}"


def _surfaces_of(cases: Sequence[Case]) -> str:
    """Write the number of surfaces behind a point."""
    count = _surface_count(cases)
    return (
        "one surface: no error bars"
        if count == "1"
        else f"mean and standard deviation of {count} surfaces"
    )


def _mean_over(cases: Sequence[Case]) -> str:
    """Write the number of surfaces and of lines behind a point of a spectrum."""
    count = _surface_count(cases)
    return "1/12-octave means of " + (
        "one surface" if count == "1" else f"the power of {count} surfaces"
    )


def _surface_count(cases: Sequence[Case]) -> str:
    """Write the number of surfaces per case, or its range."""
    groups = Counter(
        (case.roughness_um, case.load_n, case.correlation_um) for case in cases
    ).values()
    return " to ".join(dict.fromkeys(str(end) for end in (min(groups), max(groups))))


def _reference_db(reading: Reading) -> float | None:
    """Return the maximum line level that 20 lg levels refer to, or None without that case."""
    ra, load = SCALE_REFERENCE
    mean, _ = _statistics([reading.at(roughness_um=ra, load_n=load)], lambda case: case.maximum_db)
    return float(mean[0]) if np.isfinite(mean[0]) else None


def _scale_note(reference_db: float | None) -> str:
    """Write a note on the two axes of levels."""
    ra, load = SCALE_REFERENCE
    if reference_db is None:
        return f"no axis of 20 lg: Ra {ra:g} µm, {load:g} N is not solved"
    return "left: 10 lg, right: 20 lg"


def _twice(ax: Axes, reference_db: float | None) -> None:
    """Add a dashed axis on the right: 20 lg of the power.

    Its differences are twice the differences with 10 lg.
    """
    if reference_db is None:
        return
    ra, load = SCALE_REFERENCE

    def doubled(level: Any) -> Any:
        return 2 * (level - reference_db)

    def halved(level: Any) -> Any:
        return level / 2 + reference_db

    other = ax.secondary_yaxis("right", functions=(doubled, halved))
    ax.spines["right"].set_visible(False)  # the solid axis would show between the dashes
    other.set_ylabel(f"20 lg, re maximum of Ra {ra:g} µm, {load:g} N [dB]", fontsize=8.5)
    other.spines["right"].set_linestyle((0, (4, 3)))
    other.tick_params(labelsize=8.5)


def _add(columns: dict[str, Array], label: str, frequency: Array, level: Array) -> None:
    """Add a spectrum as columns; repeated frequencies are left out."""
    known = [values for name, values in columns.items() if "frequency" in name]
    if not known or not np.array_equal(known[-1], frequency):
        columns[f"frequency of {label} [Hz]" if known else "frequency [Hz]"] = frequency
    columns[f"{label} [dB re 1 pW/m²]"] = level
