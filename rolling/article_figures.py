"""The figures of the article, drawn anew for one reading of it: surfaces, contacts, plastic ratio, spectra, levels.

Depends on study and picture. All readings are drawn on the same axes; wherever a surface is too steep for half-space theory
the figure says so.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, LEAST_BT, reliable
from acoustics.plots import COLOURS, LINE_STYLES, MARKERS, Lines
from rolling import simulate, surface
from rolling.check import GREATEST_SLOPE
from rolling.picture import BOTTOM_IN, LEFT_IN, RIGHT_IN, SIDE_IN, WIDTH_IN, Picture, blank, lay_out
from rolling.scenario import Gaussian, Scene, track
from rolling.solve import Run
from rolling.store import Result
from rolling.study import Case

Array = NDArray[np.float64]
Place = tuple[float, float, float, float]
Sheet = tuple[Array, Array, Array]  # positions along (m,) and across (n,) and values (m, n), as drawn

PATCH_M = 512e-6  # side of the surfaces of the article's Fig. 1
SCALE_REFERENCE = (1.0, 20.0)  # Ra [um] and load [N] whose greatest line 20 lg levels are relative to
_CELLS = 100  # along a side of what is drawn in three dimensions, at most: more are hardly told apart
_NOTHING_DB = -300.0  # and below: no sound
_WARNING = "#B34400"
_LINE_IN = 0.2  # of warnings below a figure
_SCALE_ROOM_IN = 0.75  # for the axis on the right


@dataclass(frozen=True)
class Patch:
    """A square of a surface: heights (n, n) [m] at a spacing [m]."""

    heights: Array
    spacing: float


@dataclass(frozen=True)
class Contact:
    """Pressure [Pa] and deflection [m] (m, n) of nodes at the positions along (m,) and across (n,) from the sphere [m]."""

    along: Array
    across: Array
    pressure: Array
    deflection: Array

    @property
    def reach(self) -> float:
        """How far from below the sphere the farthest loaded node lies, along or across [m]."""
        row, column = np.nonzero(self.pressure > 0.0)
        farthest = np.concatenate([np.abs(self.along[row]), np.abs(self.across[column])])
        return float(farthest.max(initial=0.0))


@dataclass(frozen=True)
class Reading:
    """What the figures of a reading are drawn from.

    slopes : rms norm of the surface's gradient by Ra and correlation length [um].
    patches : a surface by Ra [um].  contacts : of that surface, by Ra [um] and load [N].
    """

    name: str
    cases: Sequence[Case]
    slopes: Mapping[tuple[float, float], float] = field(default_factory=dict)
    patches: Mapping[float, Patch] = field(default_factory=dict)
    contacts: Mapping[tuple[float, float], Contact] = field(default_factory=dict)

    @property
    def lengths(self) -> list[float]:
        return sorted({one.correlation_um for one in self.cases})

    def at(self, **values: float) -> list[Case]:
        """The cases with these values, such as load_n=5."""
        return [one for one in self.cases if all(getattr(one, name) == value for name, value in values.items())]


@dataclass(frozen=True)
class Scales:
    """Axes that are the same for all readings; colours of roughnesses and loads go by their place in the lists.

    reach_um : of contacts from the sphere.  height_um : of a surface's highest or deepest point.
    """

    roughnesses: list[float]
    loads: list[float]
    height_um: float
    reach_um: float
    pressure_gpa: float
    deflection_um: float
    plastic_ratio: float
    spectrum_db: tuple[float, float]
    maximum_db: tuple[float, float]

    @property
    def ends(self) -> list[float]:
        """The least and the greatest load, of which maps are drawn."""
        return sorted({self.loads[0], self.loads[-1]}) if self.loads else []


def gather(name: str, runs: Sequence[Run], results: Sequence[Result], cases: Sequence[Case]) -> Reading:
    """What is drawn of a reading: slopes of all its surfaces; surface and contacts of the first seed.

    Parameters
    ----------
    runs, results : as `study.runs` and `study.open_results` give them, in that order; results may be empty.
    cases : of those that are solved.
    """
    slopes: dict[tuple[float, float], float] = {}
    patches: dict[float, Patch] = {}
    contacts: dict[tuple[float, float], Contact] = {}
    for one, result in zip(runs, results, strict=True):
        scene, s = one.scene, one.scene.surface
        assert isinstance(s, Gaussian)
        roughness, length = s.roughness_ra_um, s.correlation_length_um
        if (roughness, length) not in slopes:
            heights = simulate.heights(scene)
            nodes = round(PATCH_M / scene.spacing)
            slopes[roughness, length] = surface.statistics(heights, scene.spacing).rms_slope
            patches[roughness] = Patch(heights[:nodes, :nodes].copy(), scene.spacing)
        if result.snapshot is not None:
            contacts.setdefault((roughness, scene.load), _contact(scene, result.snapshot))
    return Reading(name, tuple(cases), slopes, patches, contacts)


def _contact(scene: Scene, snapshot: simulate.Snapshot) -> Contact:
    middle = (track(scene).n_across - 1) / 2 * scene.spacing
    rows, columns = (_positions(count, scene.spacing) for count in snapshot.pressure.shape)
    along, across = snapshot.along - snapshot.distance, snapshot.across - middle
    return Contact(along + rows, across + columns, snapshot.pressure, snapshot.deflection)


def scales(readings: Sequence[Reading]) -> Scales:
    """Axes on which all these readings can be compared."""
    cases = [one for reading in readings for one in reading.cases]
    contacts = [one for reading in readings for one in reading.contacts.values()]
    heights = [one.heights for reading in readings for one in reading.patches.values()]
    roughnesses = sorted({one.roughness_um for one in cases} | {ra for each in readings for ra in each.patches})
    loads = sorted({one.load_n for one in cases} | {load for each in readings for _, load in each.contacts})
    maxima = [one.maximum_db for one in cases if one.maximum_db > _NOTHING_DB]
    return Scales(
        roughnesses,
        loads,
        height_um=1e6 * max((float(np.abs(one).max()) for one in heights), default=1e-6),
        reach_um=1e6 * max((one.reach for one in contacts), default=1e-4),
        pressure_gpa=1e-9 * max((float(one.pressure.max()) for one in contacts), default=1e9),
        deflection_um=1e6 * max((float(one.deflection.max()) for one in contacts), default=1e-6),
        plastic_ratio=1.05 * max((one.plastic_ratio for one in cases), default=1.0) or 1.0,
        spectrum_db=sound_plots.level_limits(level for one in cases for level in one.line_db),
        maximum_db=sound_plots.level_limits(maxima),
    )


def gallery(reading: Reading, on: Scales) -> Iterator[Picture]:
    """The pictures of a reading for which there is anything: Fig. 1, 5 to 9, or those of the correlation length."""
    if len(reading.lengths) > 1:
        yield correlation_length(reading)
        return
    if reading.patches:
        yield surfaces(reading, on)
    if any(load in on.ends for _, load in reading.contacts):
        yield contact_pressure(reading, on)
        yield deflection(reading, on)
    if reading.cases:
        yield plastic_ratio(reading, on)
        yield spectra(reading, on)
        yield maximum_level(reading, on)


def surfaces(reading: Reading, on: Scales) -> Picture:
    """Fig. 1: the two roughest surfaces."""
    shown = [ra for ra in on.roughnesses if ra in reading.patches][-2:]
    sheets = []
    nodes: set[int] = set()
    for ra in shown:
        patch = reading.patches[ra]
        along, across = (_positions(count, patch.spacing * 1e6) for count in patch.heights.shape)
        nodes.add(_stride(patch.heights))
        sheets.append((_panel_title(reading, ra), _thinned(along, across, patch.heights * 1e6)))
    side = 1e6 * PATCH_M
    look = _Look(
        "height [µm]", (-on.height_um, on.height_um), "cividis", (0.0, side), along_label="along the track [µm]"
    )
    note = f"512 µm x 512 µm; one scale of height; {_drawn(nodes, 'every', 'nodes')}"
    return _sheets("fig1_surfaces", "Surfaces", note, reading, shown, sheets, look, 3.0)


def contact_pressure(reading: Reading, on: Scales) -> Picture:
    """Fig. 5: pressure [GPa] under the least and the greatest load."""
    reach = on.reach_um * 1e-6

    def sheet(contact: Contact) -> Sheet:
        inside = _within(contact, reach)
        every = _stride(inside.pressure)
        greatest = _blocks(inside.pressure, every)
        return inside.along[::every] * 1e6, inside.across[::every] * 1e6, greatest * 1e-9

    look = _Look("pressure [GPa]", (0.0, on.pressure_gpa), "magma", (-on.reach_um, on.reach_um))
    return _contacts(
        "fig5_contact_pressure", "Contact pressure", "a facet shows its greatest node", reading, on, sheet, look,
        lambda contact: f"greatest {contact.pressure.max() * 1e-9:.2f} GPa",
    )  # fmt: skip


def deflection(reading: Reading, on: Scales) -> Picture:
    """Fig. 6: deflection of the plate [um], downwards, under the least and the greatest load."""
    reach = on.reach_um * 1e-6

    def sheet(contact: Contact) -> Sheet:
        inside = _within(contact, reach)
        return _thinned(inside.along * 1e6, inside.across * 1e6, inside.deflection * 1e6)

    look = _Look("deflection [µm]", (on.deflection_um, 0.0), "viridis", (-on.reach_um, on.reach_um))
    return _contacts(
        "fig6_deflection", "Deflection of the plate", "downwards; of the part that was solved", reading, on, sheet, look,
        lambda contact: f"greatest {contact.deflection.max() * 1e6:.2f} µm",
    )  # fmt: skip


def plastic_ratio(reading: Reading, on: Scales) -> Picture:
    """Fig. 7: plastic area over the Hertz area against load, mean and standard deviation over surfaces."""
    figure = blank()
    ax = figure.add_subplot()
    columns = _against_load(ax, reading, on, lambda one: one.plastic_ratio, "plastic area / Hertz area", "1")
    ax.set_ylim(-0.03 * on.plastic_ratio, on.plastic_ratio)
    shown = _shown(reading, on)
    places: dict[Axes, Place] = {ax: (LEFT_IN, BOTTOM_IN, WIDTH_IN - LEFT_IN - RIGHT_IN, 3.5)}
    note = f"{_surfaces_of(reading.cases)}; mean along the track; Hertz area: of the smooth elastic contact"
    return _finish("fig7_plastic_ratio", "Plastic ratio", note, reading, shown, places, columns)


def spectra(reading: Reading, on: Scales) -> Picture:
    """Fig. 8: the article's A-weighted line spectra, a panel for each roughness, a curve for each load."""
    figure = blank()
    shown = _shown(reading, on)
    reference = _reference_db(reading)
    columns: dict[str, Array] = {}
    places: dict[Axes, Place] = {}
    gap, wide, tall, step = 0.2, 3.3, 2.35, 2.5
    for number, ra in enumerate(shown):
        ax = figure.add_subplot()
        curves = []
        for load in on.loads:
            frequency, level = _mean_spectrum(reading.at(roughness_um=ra, load_n=load))
            # The first panel's legend is that of all: it names what any of them shows, and "_" is named nowhere.
            curves.append((f"{load:g} N" if reading.at(load_n=load) else "_", frequency, level))
            if len(frequency):
                _add(columns, f"Ra {ra:g} µm, {load:g} N", frequency, level)
        _spectra(ax, curves, [one.duration_s for one in reading.cases], on.spectrum_db)
        row, column = divmod(number, 2)
        below = (len(shown) - 1) // 2 - row
        _heading(ax, _panel_title(reading, ra), _steep(reading, ra))
        ax.tick_params(labelleft=column == 0, labelbottom=number + 2 >= len(shown))
        ax.set_xlabel("frequency [Hz]" if number + 2 >= len(shown) else "")
        ax.set_ylabel("A-weighted line level\n[dB re 1 pW/m²]" if column == 0 else "")
        if column == 1 or len(shown) == 1:
            _twice(ax, reference)
        places[ax] = (LEFT_IN + column * (wide + gap), BOTTOM_IN + below * step, wide, tall)
    note = "; ".join([_duration(reading.cases), _mean_over(reading.cases), _scale_note(reference)])
    return _finish("fig8_spectra", "A-weighted spectra", note, reading, shown, places, columns)


def maximum_level(reading: Reading, on: Scales) -> Picture:
    """Fig. 9: greatest A-weighted line against load, mean and standard deviation over surfaces."""
    figure = blank()
    ax = figure.add_subplot()
    label = "greatest A-weighted line level"
    columns = _against_load(ax, reading, on, lambda one: one.maximum_db, label, "dB re 1 pW/m²")
    ax.set_ylim(on.maximum_db)
    reference = _reference_db(reading)
    if reference is not None:
        for name, values in list(columns.items())[1:]:
            spread = "deviation" in name
            what = "standard deviation" if spread else "relative to Ra 1 µm, 20 N"
            columns[f"{name.partition(':')[0]}, 20 lg: {what} [dB]"] = 2 * (values if spread else values - reference)
    _twice(ax, reference)
    shown = _shown(reading, on)
    places: dict[Axes, Place] = {ax: (LEFT_IN, BOTTOM_IN, WIDTH_IN - LEFT_IN - _SCALE_ROOM_IN, 3.5)}
    note = "; ".join([_surfaces_of(reading.cases), _duration(reading.cases), _scale_note(reference)])
    return _finish("fig9_maximum_level", "Maximum A-weighted level", note, reading, shown, places, columns)


def correlation_length(reading: Reading) -> Picture:
    """Spectra for each correlation length, and levels against it."""
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
    _spectra(left, curves, [one.duration_s for one in reading.cases], limits)
    columns["correlation length [µm]"] = lengths
    levels: tuple[tuple[str, str, Callable[[Case], float | None]], ...] = (
        ("LAeq", "dB re 20 µPa", lambda one: one.laeq_db),
        ("greatest line", "dB re 1 pW/m²", lambda one: one.maximum_db),
    )
    seen: list[float] = []
    for number, (name, unit, quantity) in enumerate(levels):
        mean, spread = _statistics([reading.at(correlation_um=length) for length in reading.lengths], quantity)
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
    shown = sorted({one.roughness_um for one in reading.cases})
    loads = sorted({one.load_n for one in reading.cases})
    conditions = f"Ra {', '.join(f'{ra:g}' for ra in shown)} µm; {', '.join(f'{load:g}' for load in loads)} N"
    note = "; ".join([conditions, _duration(reading.cases), f"spectra: {_mean_over(reading.cases)}"])
    return _finish("correlation_length", "Correlation length", note, reading, shown, places, columns)


@dataclass(frozen=True)
class _Look:
    """Of sheets in three dimensions: label, limits (bottom, top) and colours of their heights, limits of both sides [um]."""

    label: str
    limits: tuple[float, float]
    colours: str
    sides: tuple[float, float]
    along_label: str = "along [µm]"


def _contacts(
    name: str,
    title: str,
    fact: str,
    reading: Reading,
    on: Scales,
    sheet: Callable[[Contact], Sheet],
    look: _Look,
    number: Callable[[Contact], str],
) -> Picture:
    """A row for each roughness of which there is a contact, a column for each of the two loads."""
    shown = [ra for ra in on.roughnesses if any((ra, load) in reading.contacts for load in on.ends)]
    sheets: list[tuple[str, Sheet | None]] = []
    for ra in shown:
        for load in on.ends:
            contact = reading.contacts.get((ra, load))
            heading = f"{_panel_title(reading, ra)}, {load:g} N"
            if contact is None:
                sheets.append((f"{heading}: not solved", None))
            else:
                sheets.append((f"{heading}: {number(contact)}", sheet(contact)))
    note = f"one surface; along and across from the sphere's centre; {fact}; one scale for all readings"
    return _sheets(name, title, note, reading, shown, sheets, look, 2.75)


def _sheets(
    name: str,
    title: str,
    note: str,
    reading: Reading,
    shown: Sequence[float],
    sheets: Sequence[tuple[str, Sheet | None]],
    look: _Look,
    tall: float,
) -> Picture:
    """Sheets in three dimensions, two to a row."""
    figure = blank()
    rows = -(-len(sheets) // 2)
    wide = (WIDTH_IN - 2 * SIDE_IN) / 2
    places: dict[Axes, Place] = {}
    for number, (heading, sheet) in enumerate(sheets):
        ax = cast(Axes3D, figure.add_subplot(projection="3d"))
        row, column = divmod(number, 2)
        # Labels of three-dimensional axes stand outside of their place.
        places[ax] = (SIDE_IN + column * wide, 0.22 + (rows - 1 - row) * (tall + 0.3), wide - 0.3, tall - 0.1)
        ax.text2D(0.5, 0.99, heading, transform=ax.transAxes, ha="center", va="bottom", fontsize=8.5)
        if sheet is None:
            ax.set_axis_off()
            continue
        along, across, values = sheet
        grid = np.meshgrid(along, across, indexing="ij")
        drawn = ax.plot_surface(
            *grid,
            values,
            rcount=len(along),
            ccount=len(across),
            cmap=matplotlib.colormaps[look.colours],
            vmin=min(look.limits),
            vmax=max(look.limits),
            linewidth=0.0,
            antialiased=False,
        )
        drawn.set_rasterized(True)  # thousands of facets: as an image a tenth of the size
        ax.set_xlim(look.sides)
        ax.set_ylim(look.sides)
        ax.set_zlim(look.limits)
        ax.set_box_aspect((1.0, 1.0, 0.55), zoom=1.12)
        ax.view_init(elev=28, azim=-58)
        ax.tick_params(labelsize=7, pad=0)
        for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
            axis.set_major_locator(MaxNLocator(5))
        for set_label, text in (
            (ax.set_xlabel, look.along_label),
            (ax.set_ylabel, "across [µm]"),
            (ax.set_zlabel, look.label),
        ):
            set_label(text, fontsize=8, labelpad=0)
    return _finish(name, title, note, reading, shown, places, {})


def _finish(
    name: str,
    title: str,
    note: str,
    reading: Reading,
    shown: Sequence[float],
    places: dict[Axes, Place],
    columns: dict[str, Array],
) -> Picture:
    """A picture with its warnings below the axes."""
    figure = cast(Figure, next(iter(places)).figure)
    warnings = [text for ra in shown for text in _warnings(reading, ra)]
    room = 0.06 + _LINE_IN * len(warnings) if warnings else 0.0
    lifted: dict[Axes, Place] = {
        ax: (left, bottom + room, wide, tall) for ax, (left, bottom, wide, tall) in places.items()
    }
    if warnings:
        strip = figure.add_subplot()
        strip.set_axis_off()
        strip.text(0.0, 0.5, "\n".join(warnings), color=_WARNING, fontsize=8.5, va="center", fontweight="bold")
        lifted[strip] = (SIDE_IN, 0.0, WIDTH_IN - 2 * SIDE_IN, room)
    full = f"{title}: {reading.name}"
    lay_out(figure, full, note, lifted)
    return Picture(name, ". ".join([f"{full}: {note}", *warnings]), figure, columns)


def _warnings(reading: Reading, roughness_um: float) -> list[str]:
    """What half-space theory cannot hold for on surfaces of this Ra, one line for each correlation length."""
    found = []
    for (ra, length), norm in sorted(reading.slopes.items()):
        if ra == roughness_um and norm > GREATEST_SLOPE:
            of = f"Ra {ra:g} µm" + (f", length {length:g} µm" if len(reading.lengths) > 1 else "")
            each = norm / np.sqrt(2)  # isotropic
            found.append(
                f"{of}: rms slope {each:.2g} along each direction, norm {norm:.2g} > {GREATEST_SLOPE:g}: half-space"
                " theory does not hold"
            )
    return found


def _steep(reading: Reading, roughness_um: float) -> bool:
    return bool(_warnings(reading, roughness_um))


def _panel_title(reading: Reading, roughness_um: float) -> str:
    return f"Ra {roughness_um:g} µm" + (" (not valid: too steep)" if _steep(reading, roughness_um) else "")


def _heading(ax: Axes, text: str, warned: bool) -> None:
    colour = _WARNING if warned else "black"
    ax.text(0.03, 0.96, text, transform=ax.transAxes, va="top", fontsize=9, fontweight="bold", color=colour)


def _shown(reading: Reading, on: Scales) -> list[float]:
    found = {one.roughness_um for one in reading.cases}
    return [ra for ra in on.roughnesses if ra in found]


def _against_load(
    ax: Axes, reading: Reading, on: Scales, quantity: Callable[[Case], float | None], label: str, unit: str
) -> dict[str, Array]:
    """Mean and standard deviation of a quantity against load, a curve for each roughness; what is drawn, as columns."""
    loads = np.array(on.loads)
    columns: dict[str, Array] = {"load [N]": loads}
    for number, ra in enumerate(on.roughnesses):
        groups = [reading.at(roughness_um=ra, load_n=load) for load in on.loads]
        if not any(groups):
            continue
        mean, spread = _statistics(groups, quantity)
        _points(ax, loads, mean, spread, number, _panel_title(reading, ra))
        columns |= {
            f"Ra {ra:g} µm: {label} [{unit}]": mean,
            f"Ra {ra:g} µm: standard deviation [{unit.split(' ')[0]}]": spread,
        }
    _varied(ax, on.loads, "load [N]")
    ax.set_ylabel(label if unit == "1" else f"{label} [{unit}]")
    return columns


def _statistics(groups: Sequence[Sequence[Case]], quantity: Callable[[Case], float | None]) -> tuple[Array, Array]:
    """Mean and standard deviation in each group; NaN of none, and no deviation of one."""
    mean, spread = np.full(len(groups), np.nan), np.full(len(groups), np.nan)
    for number, group in enumerate(groups):
        found = [quantity(one) for one in group]
        values = [value for value in found if value is not None and value > _NOTHING_DB]
        if values:
            mean[number] = np.mean(values)
        if len(values) > 1:
            spread[number] = np.std(values, ddof=1)
    return mean, spread


def _points(ax: Axes, x: Array, mean: Array, spread: Array, number: int, label: str) -> None:
    """Mean values with error bars, joined where some between are missing."""
    there = np.isfinite(mean)
    ax.errorbar(x[there], mean[there], spread[there], label=label, capsize=3, markersize=5, **_look(number))


def _look(number: int) -> dict[str, Any]:
    return {
        "color": COLOURS[number % len(COLOURS)],
        "linestyle": LINE_STYLES[number % len(LINE_STYLES)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def _varied(ax: Axes, values: Sequence[float], label: str) -> None:
    if len(values) > 1 and values[0] > 0.0:
        ax.set_xscale("log")
    ax.set_xticks(values, [f"{value:g}" for value in values])
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel(label)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)


def _mean_spectrum(cases: Sequence[Case]) -> tuple[Array, Array]:
    """Frequencies [Hz] and level of the mean power of several surfaces [dB]; NaN is no sound, and none of no cases."""
    if not cases:
        return np.empty(0), np.empty(0)
    power = np.mean([10 ** (one.line_db / 10) for one in cases], axis=0)
    level = 10 * np.log10(np.maximum(power, 10 ** (_NOTHING_DB / 10)))
    return cases[0].line_hz, np.where(level > _NOTHING_DB + 1e-6, level, np.nan)


def _spectra(
    ax: Axes,
    curves: Sequence[tuple[str, Array, Array]],
    durations_s: Sequence[float],
    limits_db: tuple[float, float],
) -> None:
    """Spectra on an axis of frequency, grey where third octaves of the shortest record mean nothing yet."""
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
    read = reliable(min(durations_s))
    return int(np.argmax(read)) if read.any() else len(read)


def _duration(cases: Sequence[Case]) -> str:
    durations = [one.duration_s for one in cases]
    ends = dict.fromkeys(f"{value:.3g}" for value in (min(durations), max(durations)))
    first = _first_reliable(durations)
    mean = (
        f"third octaves from {BAND_NAMES[first]} Hz mean something"
        if first < len(BAND_NAMES)
        else "no third octave does"
    )
    return f"T = {' to '.join(ends)} s: {mean}"


def _surfaces_of(cases: Sequence[Case]) -> str:
    """How many surfaces a point stands for."""
    count = _surface_count(cases)
    return "one surface: no error bars" if count == "1" else f"mean and standard deviation of {count} surfaces"


def _mean_over(cases: Sequence[Case]) -> str:
    """How many surfaces a spectrum stands for, and of how many lines a point of it."""
    count = _surface_count(cases)
    return "1/12-octave means of " + ("one surface" if count == "1" else f"the power of {count} surfaces")


def _surface_count(cases: Sequence[Case]) -> str:
    groups = Counter((one.roughness_um, one.load_n, one.correlation_um) for one in cases).values()
    return " to ".join(dict.fromkeys(str(end) for end in (min(groups), max(groups))))


def _reference_db(reading: Reading) -> float | None:
    """Greatest line of the case to which 20 lg levels are relative, mean over surfaces; None without it."""
    ra, load = SCALE_REFERENCE
    mean, _ = _statistics([reading.at(roughness_um=ra, load_n=load)], lambda one: one.maximum_db)
    return float(mean[0]) if np.isfinite(mean[0]) else None


def _scale_note(reference_db: float | None) -> str:
    ra, load = SCALE_REFERENCE
    if reference_db is None:
        return f"no axis of 20 lg: Ra {ra:g} µm, {load:g} N is not solved"
    return "left: 10 lg, right: 20 lg"


def _twice(ax: Axes, reference_db: float | None) -> None:
    """A dashed axis on the right: 20 lg of the power, whose differences are twice those of 10 lg."""
    if reference_db is None:
        return
    ra, load = SCALE_REFERENCE

    def doubled(level: Any) -> Any:
        return 2 * (level - reference_db)

    def halved(level: Any) -> Any:
        return level / 2 + reference_db

    other = ax.secondary_yaxis("right", functions=(doubled, halved))
    ax.spines["right"].set_visible(False)  # it would show between the dashes
    other.set_ylabel(f"20 lg, re greatest of Ra {ra:g} µm, {load:g} N [dB]", fontsize=8.5)
    other.spines["right"].set_linestyle((0, (4, 3)))
    other.tick_params(labelsize=8.5)


def _add(columns: dict[str, Array], label: str, frequency: Array, level: Array) -> None:
    """A spectrum as columns; frequencies once, and again only where they differ."""
    known = [values for name, values in columns.items() if "frequency" in name]
    if not known or not np.array_equal(known[-1], frequency):
        columns[f"frequency of {label} [Hz]" if known else "frequency [Hz]"] = frequency
    columns[f"{label} [dB re 1 pW/m²]"] = level


def _within(contact: Contact, reach: float) -> Contact:
    """The part of a contact no farther than `reach` [m] from below the sphere."""
    rows, columns = np.abs(contact.along) <= reach, np.abs(contact.across) <= reach
    part = np.ix_(rows, columns)
    return Contact(contact.along[rows], contact.across[columns], contact.pressure[part], contact.deflection[part])


def _positions(count: int, spacing: float) -> Array:
    return np.linspace(0.0, (count - 1) * spacing, count)


def _stride(values: Array) -> int:
    return -(-max(values.shape) // _CELLS)


def _thinned(along: Array, across: Array, values: Array) -> Sheet:
    """Of positions along (m,) and across (n,) and values (m, n) as many as are drawn."""
    every = _stride(values)
    return along[::every], across[::every], values[::every, ::every]


def _blocks(values: Array, every: int) -> Array:
    """The greatest in each block of so many nodes a side."""
    rows, columns = (-(-count // every) for count in values.shape)
    whole = np.zeros((rows * every, columns * every))
    whole[: values.shape[0], : values.shape[1]] = values
    return whole.reshape(rows, every, columns, every).max(axis=(1, 3))


def _drawn(nodes: set[int], every: str, what: str) -> str:
    return f"drawn: {every} {' or '.join(map(str, sorted(nodes)))} {what}" if nodes != {1} else "drawn: all nodes"
