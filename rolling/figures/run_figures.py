"""The pictures of a run and of runs compared, on the same axes. Depends on acoustics.plots and rolling.plots."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import groupby
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter
from numpy.typing import NDArray

from acoustics import plots as sound_plots
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.level import P_REF_PA
from acoustics.plots import Lines
from acoustics.spectrogram import Spectrogram, spectrogram
from acoustics.spectrum import Psd, article_line_level_db, line_spectrum, welch
from acoustics.weighting import a_weighting_db
from rolling.figures import axes
from rolling.figures.picture import BOTTOM_IN, LEFT_IN, RIGHT_IN, WIDTH_IN, Picture, blank, lay_out, single
from rolling.simulation import caveats, labels
from rolling.simulation.run_result import Heard
from rolling.surface import scene_surface

Array = NDArray[np.float64]

_BAR_IN = 0.16  # width of a colour bar
_BAR_ROOM_IN = 1.0  # from the end of its axes to the edge: gap, bar, tick labels, label
_ENERGIES_PER_DECADE = 5
_SMALLEST_SHARE = 1e-6  # of the greatest energy: where the axis begins
_NAMES = 4  # scenes that a title names
_DURATIONS = 50  # columns of a distribution of durations, at most


class _Views:
    """What pictures of a run are drawn from, each made when first asked for."""

    def __init__(self, one: Heard) -> None:
        self._sound, self._scene = one.sound, one.scene

    @cached_property
    def a_weighted(self) -> Lines:
        frequency, square = line_spectrum(self._sound.pressure, self._sound.sample_rate)
        return Lines.audible(frequency, _level(square) + a_weighting_db(frequency))

    @cached_property
    def article(self) -> Lines:
        power = self._sound.power
        rate = len(power) / self._sound.duration
        sound = self._scene.sound
        frequency, level = article_line_level_db(power, rate, sound.distance_m, sound.q)
        if self._sound.levels.level_db is None:  # what is left of a steady power is rounding
            level = np.full_like(level, -np.inf)
        return Lines.audible(frequency, level)

    @cached_property
    def welch(self) -> Psd:
        return welch(self._sound.pressure, self._sound.sample_rate)

    @cached_property
    def psd(self) -> Lines:
        return Lines.audible(self.welch.frequency_hz, _level(self.welch.psd))

    @cached_property
    def spectrogram(self) -> Spectrogram:
        sound = self._sound
        return spectrogram(sound.pressure, sound.sample_rate, sound.highest, sound.closed)

    @cached_property
    def density_extremes(self) -> list[float]:
        """Lowest and highest level of the spectrogram, but for the fiftieth that lies lowest: gaps between peaks."""
        shown = self.spectrogram.level_db[np.isfinite(self.spectrogram.level_db)]
        return [float(np.quantile(shown, 0.02)), float(shown.max())] if len(shown) else []


# The curves of each run set the axes of all the others: made once, kept as long as the run is.
_views_of: WeakKeyDictionary[Heard, _Views] = WeakKeyDictionary()


def gallery(runs: Sequence[Heard]) -> Iterator[tuple[Heard | None, Picture]]:
    """Draw all pictures of runs that are compared: of each run, with it, and of several together, with None.

    The labels of the runs differ, as `labels.labels` makes them.
    """
    for one in runs:
        for picture in of_run(one, runs):
            yield one, picture
    if len(runs) > 1:
        for picture in of_runs(runs):
            yield None, picture


def of_run(one: Heard, among: Sequence[Heard] = ()) -> Iterator[Picture]:
    """Pictures of one run, on the axes of all the runs `among` which it is to be compared."""
    runs = [*among] or [one]
    yield from _sound_curves([one], runs)
    yield _spectrogram(one, runs)
    yield _release_power(one, runs)
    yield _surface(one)
    if one.result.snapshot is not None:
        yield _contact(one, runs)
    events = _recovery_events(one)
    if events is not None:
        yield events


def of_runs(runs: Sequence[Heard]) -> Iterator[Picture]:
    """Pictures that compare runs, one curve each; levels against the first swept quantity if one is swept."""
    yield from _sound_curves(runs, runs)
    swept = [
        key
        for key in runs[0].values
        if all(key in one.values for one in runs) and len({one.values[key] for one in runs}) > 1
    ]
    # Runs that nothing swept tells apart would be one point.
    if swept and len({(one.scene.name, *one.values.items()) for one in runs}) == len(runs):
        yield _levels(swept[0], runs)


def _sound_curves(shown: Sequence[Heard], among: Sequence[Heard]) -> Iterator[Picture]:
    """Spectra and third octaves of the runs shown, one curve each."""
    of, at, record = _named(shown), _distance(shown), _record(shown)
    lines = _common("lines of", [1 / one.sound.duration for one in shown], "Hz")
    yield _spectrum(
        "spectrum",
        f"A-weighted spectrum: {of}",
        [at, record, lines],
        "A-weighted line level [dB re 20 µPa]",
        lambda one: _views(one).a_weighted,
        shown,
        among,
    )
    steady = [one for one in shown if one.sound.constant_speed]
    if steady:
        q = _common("q =", [one.scene.sound.q for one in steady])
        yield _spectrum(
            "article_spectrum",
            f"Per FFT line as Lee, Kim & Kim (2025): {of}",
            [at, q, record, lines, "lines of noise fall as T grows"],
            "A-weighted line level [dB re 1 pW/m²]",
            lambda one: _views(one).article,
            steady,
            [one for one in among if one.sound.constant_speed],
        )
    densities = [_views(one).welch for one in shown]
    yield _spectrum(
        "psd",
        f"Power spectral density: {of}",
        [
            at,
            record,
            f"Welch, {densities[0].window.capitalize()}",
            _common("lines of", [density.line_width_hz for density in densities], "Hz"),
            _common("ENBW", [density.enbw_hz for density in densities], "Hz"),
        ],
        "density level [dB re (20 µPa)²/Hz]",
        lambda one: _views(one).psd,
        shown,
        among,
    )
    yield _third_octaves("third_octaves", "Z", lambda one: one.sound.levels.third_octave_db, shown, among)
    yield _third_octaves("third_octaves_a", "A", lambda one: one.sound.levels.third_octave_a_db, shown, among)


def _spectrum(
    name: str,
    title: str,
    facts: list[str],
    ylabel: str,
    view: Callable[[Heard], Lines],
    shown: Sequence[Heard],
    among: Sequence[Heard],
) -> Picture:
    curves = [(one.label, view(one)) for one in shown]
    means = sound_plots.drawn_as_means(curves)
    limits = sound_plots.level_limits(level for one in among for level in view(one).extremes)
    columns = _line_columns([(label, lines.frequency_hz, lines.level_db) for label, lines in curves], "", ylabel)
    if means:
        mean = f"mean over 1/{sound_plots.PER_OCTAVE} octave"
        columns |= _line_columns([(label, *lines.mean) for label, lines in means], f"{mean}: ", ylabel)
        facts = [*facts, f"drawn bold: {mean}"]

    def draw(ax: Axes) -> None:
        sound_plots.spectrum(ax, curves, limits)
        ax.set_ylabel(ylabel)

    return single(name, title, _note(facts), columns, draw, _remarks(shown))


def _line_columns(curves: Iterable[tuple[str, Array, Array]], kind: str, ylabel: str) -> dict[str, Array]:
    """Columns of frequencies and levels; levels at the same frequencies stand behind one column of them."""
    columns: dict[str, Array] = {}
    before: Array | None = None
    for label, frequency, level in curves:
        if before is None or not np.array_equal(before, frequency):
            before = columns[f"{kind}frequency of {label} [Hz]" if columns else f"{kind}frequency [Hz]"] = frequency
        columns[f"{kind}{label}: {ylabel}"] = level
    return columns


def _third_octaves(
    name: str,
    weighting: str,
    levels: Callable[[Heard], Mapping[str, float | None]],
    shown: Sequence[Heard],
    among: Sequence[Heard],
) -> Picture:
    curves = [(one.label, levels(one), one.sound.uncertainty.third_octave_db) for one in shown]
    limits = sound_plots.level_limits(level for one in among for level in levels(one).values())
    columns: dict[str, Array] = {"mid frequency [Hz]": MID_HZ}
    for label, by_name, uncertainty in curves:
        columns[f"{label} [dB re 20 µPa]"] = _gaps(by_name[band] for band in BAND_NAMES)
        columns[f"{label}: standard uncertainty [dB]"] = _gaps(uncertainty[band] for band in BAND_NAMES)
    # On the axes of all, what is too short to be read in one run is grey in all.
    shortest = min(_lap_seconds(one) for one in among)
    facts = [_distance(shown), _record(shown)]
    if len(curves) <= sound_plots.FEW and any(one.sound.levels.level_db is not None for one in shown):
        facts.append("bars: standard uncertainty of Gaussian noise of that duration")
    return single(
        name,
        f"Third octaves, {weighting}-weighted: {_named(shown)}",
        _note(facts),
        columns,
        lambda ax: sound_plots.third_octaves(ax, curves, shortest, limits),
        _remarks(shown),
    )


def _spectrogram(one: Heard, among: Sequence[Heard]) -> Picture:
    shown = _views(one).spectrogram
    limits = sound_plots.level_limits(level for other in among for level in _views(other).density_extremes)
    title = f"Spectrogram: {_named([one])}"
    note = _note(
        [
            _distance([one]),
            _record([one]),
            f"{shown.window.capitalize()} frames of {shown.frame_s * 1e3:.3g} ms every {shown.hop_s * 1e3:.3g} ms",
            f"lines of {_number(shown.line_width_hz)} Hz, ENBW {_number(shown.enbw_hz)} Hz",
            "rows of 1/12 octave",
        ]
    )
    figure = blank()
    ax, bar = figure.add_subplot(), figure.add_subplot()
    sound_plots.spectrogram(ax, bar, shown, one.sound.duration, limits)
    width = WIDTH_IN - LEFT_IN - _BAR_ROOM_IN
    places = {ax: (LEFT_IN, BOTTOM_IN, width, 3.5), bar: (LEFT_IN + width + 0.12, BOTTOM_IN, _BAR_IN, 3.5)}
    lay_out(figure, title, note, places)
    return Picture("spectrogram", f"{title}: {note}", figure, {})


def _release_power(one: Heard, among: Sequence[Heard]) -> Picture:
    sound = one.sound
    shares = np.array([sound_plots.power_share(other.sound.power, other.sound.mean_power) for other in among])
    share = float(shares[:, 0].min()), float(shares[:, 1].max())
    facts = [_record([one]), "q and distance are not in it"]
    if len(among) > 1:
        facts.append(f"axis from {share[0]:.3g} to {share[1]:.3g} of the mean, as for all runs compared")
    if sound_plots.is_thinned(sound.time):
        facts.append("drawn: least and greatest in each of 1,500 columns")
    return single(
        "release_power",
        f"Release power: {_named([one])}",
        _note(facts),
        {"time [s]": sound.time, "release power [W]": sound.power},
        lambda ax: sound_plots.power(ax, sound.time, sound.power, sound.mean_power, sound.duration, share),
    )


def _levels(key: str, runs: Sequence[Heard]) -> Picture:
    """LAeq and LZeq against a swept quantity, a curve for every combination of the others."""

    several = len({one.scene.name for one in runs}) > 1

    def others(one: Heard) -> tuple[str, tuple[tuple[str, float], ...]]:
        return one.scene.name, tuple((name, value) for name, value in one.values.items() if name != key)

    x = np.array(sorted({one.values[key] for one in runs}))
    word, unit = labels.named(key)
    columns: dict[str, Array] = {f"{word} [{unit}]" if unit else word: x}
    panels = []
    for name, number in (("LAeq", "laeq_db"), ("LZeq", "level_db")):
        curves = []
        for same, group in groupby(sorted(runs, key=others), key=others):
            scene, values = same
            label = ", ".join([scene] * several + [labels.worded(*one) for one in values])
            at = {one.values[key]: one.sound for one in group}
            level = [getattr(at[value].levels, number) if value in at else None for value in x]
            spread = [getattr(at[value].uncertainty, number) if value in at else None for value in x]
            curves.append((label, level, spread))
            full = f"{name}, {label}" if label else name
            columns |= {f"{full} [dB re 20 µPa]": _gaps(level), f"{full}: standard uncertainty [dB]": _gaps(spread)}
        panels.append((name, curves))
    limits = sound_plots.level_limits(level for _, curves in panels for _, levels, _ in curves for level in levels)
    figure = blank()
    gap = 0.3
    width = (WIDTH_IN - LEFT_IN - RIGHT_IN - gap) / 2
    places: dict[Axes, tuple[float, float, float, float]] = {}
    for panel, (name, curves) in enumerate(panels):
        ax = figure.add_subplot()
        sound_plots.level_against(ax, x, curves, next(iter(columns)), limits)
        ax.set_ylabel("" if panel else "level [dB re 20 µPa]")
        ax.tick_params(labelleft=not panel)
        ax.text(0.03, 0.97, name, transform=ax.transAxes, va="top", fontweight="bold")
        places[ax] = (LEFT_IN + panel * (width + gap), BOTTOM_IN, width, 3.5)
    title = f"Levels against {word}: {_named(runs)}"
    note = _note([_distance(runs), _record(runs), "bars: standard uncertainty of Gaussian noise of that duration"])
    lay_out(figure, title, note, places)
    return Picture("levels", f"{title}: {note}", figure, columns, _remarks(runs))


def _surface(one: Heard) -> Picture:
    heights, spacing = scene_surface.heights(one.scene), one.scene.spacing
    statistics, every = one.numbers["surface"], axes.map_stride(heights, spacing)
    title = f"Surface: {_named([one])}"
    facts = [
        f"Ra {statistics['ra'] * 1e6:.4g} µm, Rq {statistics['rq'] * 1e6:.4g} µm",
        f"skewness {statistics['skewness']:.2f}, kurtosis {statistics['kurtosis']:.2f}",
        f"rms slope {statistics['rms_slope']:.3g}",
        f"{len(heights) * spacing * 1e3:.4g} mm of track; below: profile at mid-width",
    ]
    note = _note(facts if every == 1 else [*facts, f"map: every {every} nodes"])
    shown = axes.shown_nodes(heights, spacing)
    along = np.linspace(0.0, (shown - 1) * spacing * 1e6, shown)
    height: Array = heights[:shown, (heights.shape[1] - 1) // 2] * 1e6
    figure = blank()
    ax, bar, below = figure.add_subplot(), figure.add_subplot(), figure.add_subplot()
    axes.surface(ax, bar, heights, spacing)
    axes.profile(below, along, height)
    below.set_xlim(ax.get_xlim())
    ax.set_xlabel("")
    ax.tick_params(labelbottom=False)
    # As wide as there is room, or as high; a map of other proportions keeps its own within that.
    ratio = heights.shape[1] / shown
    widest, tallest, strip = WIDTH_IN - LEFT_IN - _BAR_ROOM_IN, 3.6, 1.1
    width = min(widest, max(2.0, tallest / ratio))
    tall = min(tallest, max(0.3, width * ratio))
    bottom = BOTTOM_IN + strip + 0.2
    places = {
        ax: (LEFT_IN, bottom, width, tall),
        bar: (LEFT_IN + width + 0.12, bottom, _BAR_IN, tall),
        below: (LEFT_IN, BOTTOM_IN, width, strip),
    }
    lay_out(figure, title, note, places)
    return Picture("surface", f"{title}: {note}", figure, {"along the track [µm]": along, "height [µm]": height})


def _contact(one: Heard, among: Sequence[Heard]) -> Picture:
    compared = [other for other in among if other.result.snapshot is not None]
    spacing, snapshot = one.scene.spacing, one.result.snapshot
    assert snapshot is not None
    along, across = _sphere(one)
    reach = max(_reach(other) for other in compared)
    figure = blank()
    places: dict[Axes, tuple[float, float, float, float]] = {}
    side = 2.7
    for number, (name, unit, factor) in enumerate((("pressure", "GPa", 1e-9), ("deflection", "µm", 1e6))):
        ax, bar = figure.add_subplot(), figure.add_subplot()
        greatest = max(float(getattr(other.result.snapshot, name).max()) for other in compared) * factor
        values = getattr(snapshot, name) * factor
        axes.contact_map(ax, bar, snapshot, values, spacing, (0.0, greatest), f"{name} [{unit}]")
        ax.set_xlim((along - reach) * 1e6, (along + reach) * 1e6)
        ax.set_ylim((across - reach) * 1e6, (across + reach) * 1e6)
        left = LEFT_IN + number * (side + 1.3)
        places |= {ax: (left, BOTTOM_IN, side, side), bar: (left + side + 0.1, BOTTOM_IN, _BAR_IN, side)}
    figure.axes[0].set_facecolor("black")  # nothing presses outside the window, but the deflection there is not known
    figure.axes[2].set_facecolor("0.85")
    figure.axes[2].set_ylabel("")
    figure.axes[2].tick_params(labelleft=False)
    title = f"Contact: {_named([one])}"
    facts = [f"sphere at {snapshot.distance * 1e6:.4g} µm"]
    if np.isfinite(one.scene.hardness):
        facts.append(f"hardness {one.scene.hardness * 1e-9:.4g} GPa")
    if len(among) > 1:
        facts.append("same scales for all runs compared")
    lay_out(figure, title, _note(facts), places)
    return Picture("contact", f"Pressure and deflection. {title}: {_note(facts)}", figure, {})


def _recovery_events(one: Heard) -> Picture | None:
    """How energy and duration of the recovery events are distributed; None where there are no events."""
    events, found = one.events, one.event_statistics
    if events is None or found is None:
        return None
    energy, steps = events["energy"], events["last"] - events["first"]
    low, high = np.log10(energy.min()), np.log10(energy.max())
    bins = np.arange(np.floor(low * _ENERGIES_PER_DECADE), np.floor(high * _ENERGIES_PER_DECADE) + 2)
    edges_of_energy = 10.0 ** (bins / _ENERGIES_PER_DECADE)
    every = -(-int(steps.max()) // _DURATIONS)
    joule = EngFormatter("J", places=1)
    title = f"Recovery events: {_named([one])}"
    note = _note(
        [
            f"{found.count:,} events, {_number(found.per_metre * 1e-3)} per mm",
            f"median {joule(found.energy_median)}, 90 % below {joule(found.energy_p90)}",
            f"the top tenth releases {100 * found.top_tenth_share:.3g} %",
            f"mean duration {found.duration_mean:.3g} steps of {one.result.step * 1e6:.3g} µm",
        ]
    )
    figure = blank()
    columns: dict[str, Array] = {}
    places: dict[Axes, tuple[float, float, float, float]] = {}
    gap = 0.75
    width = (WIDTH_IN - LEFT_IN - RIGHT_IN - gap) / 2
    for number, (name, values, edges, unit) in enumerate(
        (
            ("energy", energy, edges_of_energy, "J"),
            ("duration", steps, np.arange(0.5, steps.max() + every + 0.5, every), "steps"),
        )
    ):
        counts, released = (np.histogram(values, edges, weights=weights)[0] for weights in (None, energy))
        of_events, of_release = counts / counts.sum(), released / released.sum()
        columns |= {
            f"{name}, lower edge [{unit}]": edges[:-1],
            f"{name}, upper edge [{unit}]": edges[1:],
            f"{name}: share of the events": of_events,
            f"{name}: share of the release": of_release,
        }
        ax = figure.add_subplot()
        axes.shares(ax, edges, of_events, of_release, f"{name} of an event [{unit}]")
        places[ax] = (LEFT_IN + number * (width + gap), BOTTOM_IN, width, 3.0)
    figure.axes[0].set_xscale("log")
    # The tail reaches down to the rounding of the solution: millionths of the greatest.
    figure.axes[0].set_xlim(left=max(edges_of_energy[0], _SMALLEST_SHARE * edges_of_energy[-1]))
    figure.axes[1].set_ylabel("")
    lay_out(figure, title, note, places)
    return Picture("recovery_events", f"{title}: {note}", figure, columns)


def _views(one: Heard) -> _Views:
    if one not in _views_of:
        _views_of[one] = _Views(one)
    return _views_of[one]


def _sphere(one: Heard) -> tuple[float, float]:
    """Where the sphere stands in the snapshot, along and across [m]."""
    assert one.result.snapshot is not None
    return one.result.snapshot.distance, (one.scene.track.n_across - 1) / 2 * one.scene.spacing


def _reach(one: Heard) -> float:
    """How far the window of the snapshot reaches from the sphere, in its longest direction [m]."""
    snapshot, spacing = one.result.snapshot, one.scene.spacing
    assert snapshot is not None
    low = np.array([snapshot.along, snapshot.across]) - spacing / 2 - _sphere(one)
    return float(np.abs([low, low + np.array(snapshot.pressure.shape) * spacing]).max())


def _lap_seconds(one: Heard) -> float:
    """Duration of what does not repeat itself."""
    return one.sound.duration * min(1.0, one.result.solved_steps / one.result.done_steps)


def _level(mean_square: Array) -> Array:
    with np.errstate(divide="ignore"):
        return 10 * np.log10(mean_square / P_REF_PA**2)


def _named(runs: Sequence[Heard]) -> str:
    """Name the scene, and the run where it is one; of many scenes their number."""
    if len(runs) == 1:
        return runs[0].title
    names = dict.fromkeys(one.scene.name for one in runs)
    return ", ".join(names) if len(names) <= _NAMES else f"{len(names)} scenes"


def _remarks(runs: Sequence[Heard]) -> tuple[str, ...]:
    """List what belongs beside the levels of runs."""
    return tuple(each.line for each in caveats.gathered([(one.label, caveats.stored(one.numbers)) for one in runs]))


def _distance(runs: Iterable[Heard]) -> str:
    return _common("at", [one.scene.sound.distance_m for one in runs], "m")


def _record(runs: Iterable[Heard]) -> str:
    return _common("T =", [one.sound.duration for one in runs], "s")


def _common(word: str, values: Sequence[float], unit: str = "") -> str:
    """What is the same in all runs, or its range: at 1 m, at 1 to 2 m."""
    ends = dict.fromkeys(_number(value) for value in (min(values), max(values)))
    return f"{word} {' to '.join(ends)} {unit}".rstrip()


def _number(value: float) -> str:
    """Three digits, and all of those before the point."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def _note(facts: Iterable[str]) -> str:
    return "; ".join(facts)


def _gaps(values: Iterable[float | None]) -> Array:
    return np.array([np.nan if value is None else value for value in values])
