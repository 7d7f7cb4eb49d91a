"""Plots of levels and power. Each draws on the axes it is given and returns them. Depends on matplotlib.

Colours are those of Okabe and Ito (2008), told apart with any colour vision; line styles differ too, for grey print. More
curves than there are such colours go from dark to light in the order given. Titles and legends are the figure's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, LEAST_BT, MID_HZ, reliable
from acoustics.spectrogram import Spectrogram

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINE_STYLES: tuple[str | tuple[int, tuple[int, ...]], ...] = (
    "-", "--", "-.", ":", (0, (8, 2)), (0, (4, 1, 1, 1, 1, 1)), (0, (1, 1)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
PER_OCTAVE = 12  # of the means drawn of dense spectra
_GREY = "0.6"

_SHOWN_DB = 70.0
_NOTHING_DB = -300.0  # stands for -inf, which matplotlib would leave out together with its neighbours
_DENSE = 500  # more lines than this hide one another: they fade behind their mean
_COLUMNS = 1500  # across a plot: more than it has dots, so that an envelope looks like the curve itself
_SHADES = 36  # of a spectrogram: 2 dB in 70, less than noise leaves uncertain; more make large files
FEW = 3  # curves whose single lines or error bars can be told apart


def level_limits(levels_db: Iterable[float | None]) -> tuple[float, float]:
    """Limits of a level axis in dB: multiples of 5 with 2.5 dB of room or more, and the upper 70 dB at most.

    Give all curves of several plots at once to put them on the same axis.

    Parameters
    ----------
    levels_db
        Levels, dB; None and what is below -300 do not count. Without any level: 0 to 70.
    """
    values = _numbers(levels_db)
    values = values[np.isfinite(values) & (values > _NOTHING_DB)]
    if not len(values):
        return 0.0, _SHOWN_DB
    top = 5.0 * math.ceil(float(values.max()) / 5.0 + 0.5)
    bottom = 5.0 * math.floor(float(values.min()) / 5.0 - 0.5)
    return max(bottom, top - _SHOWN_DB), top


@dataclass(frozen=True, eq=False)
class Lines:
    """A spectrum as it is drawn, 20 Hz to 20 kHz: what takes time is done once however often it is asked for.

    frequency_hz, level_db : the lines (n,), rising frequencies; -inf is no sound.
    """

    frequency_hz: np.ndarray
    level_db: np.ndarray

    @classmethod
    def audible(cls, frequency_hz: np.ndarray, level_db: np.ndarray) -> Lines:
        """The lines that lie between 20 Hz and 20 kHz."""
        inside = (frequency_hz >= AUDIBLE_HZ[0]) & (frequency_hz < AUDIBLE_HZ[1])
        return cls(frequency_hz[inside], level_db[inside])

    @property
    def dense(self) -> bool:
        """More lines than can be told apart."""
        return len(self.frequency_hz) > _DENSE

    @cached_property
    def mean(self) -> tuple[np.ndarray, np.ndarray]:
        """Mid frequency and level of the mean power of the lines in each 1/12 octave that has any."""
        return _band_mean(self.frequency_hz, self.level_db)

    @cached_property
    def envelope(self) -> tuple[np.ndarray, np.ndarray]:
        """The lines, or the lowest and highest of each column of the plot where several share one."""
        low, high = np.log(AUDIBLE_HZ)
        column = (np.log(self.frequency_hz) - low) / (high - low)
        return _thinned(self.frequency_hz, np.maximum(self.level_db, _NOTHING_DB), column)

    @cached_property
    def extremes(self) -> list[float]:
        """Lowest and highest level that is to be seen, nothing of a silent spectrum; low single lines of many do not count."""
        shown = np.append(self.mean[1], self.level_db.max()) if self.dense else self.level_db
        shown = shown[shown > _NOTHING_DB]
        return [float(shown.min()), float(shown.max())] if len(shown) else []


def drawn_as_means(curves: Sequence[tuple[str, Lines]]) -> list[tuple[str, Lines]]:
    """Those of which the mean over 1/12 octave is drawn: their lines, or they themselves, are too many to be told apart."""
    return [curve for curve in curves if curve[1].dense or len(curves) > FEW]


def spectrum(ax: Axes, curves: Sequence[tuple[str, Lines]], limits_db: tuple[float, float] | None = None) -> Axes:
    """Spectra against frequency, 20 Hz to 20 kHz.

    Of more than 500 lines, and of more than three curves, the mean (of powers) over 1/12 octave is drawn; the lines of
    three curves at most are thin and pale behind it.

    Parameters
    ----------
    ax
        Axes to draw on.
    curves
        Label and spectrum, levels in dB; -inf lies below the axis.
    limits_db
        Of the level axis; otherwise those of the curves, see `level_limits`.
    """
    for number, (label, lines) in enumerate(curves):
        look = _look(number, len(curves))
        del look["marker"]
        if (label, lines) in drawn_as_means(curves):
            if len(curves) <= FEW:
                ax.plot(*lines.envelope, color=look["color"], linewidth=0.3, alpha=0.4, zorder=1.5)
            ax.plot(*lines.mean, linewidth=1.8, label=label, **look)
        else:
            level = np.maximum(lines.level_db, _NOTHING_DB)
            ax.plot(lines.frequency_hz, level, linewidth=1.2, label=label, **look)
    ax.set_ylim(limits_db or level_limits([level for _, lines in curves for level in lines.extremes]))
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.xaxis.set_minor_locator(NullLocator())
    _say_if_silent(ax, any(lines.extremes for _, lines in curves))
    octaves = slice(2, None, 3)
    ax.xaxis.set_major_locator(FixedLocator(list(MID_HZ[octaves])))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda f, _: _short(BAND_NAMES[int(np.abs(MID_HZ - f).argmin())])))
    ax.set_xlabel("frequency [Hz]")
    return _finish(ax, "level [dB]")


def third_octaves(
    ax: Axes,
    curves: Sequence[tuple[str, Mapping[str, float | None], Mapping[str, float | None]]],
    duration_s: float,
    limits_db: tuple[float, float] | None = None,
) -> Axes:
    """Third-octave levels as steps over the bands, 20 Hz to 20 kHz.

    More than three curves are straight lines from band to band instead.

    Bands of which the record holds too little to be read as a level (B T < 5, uncertain by 2 dB or more) are grey. Up to
    three curves have bars of their standard uncertainty in the others.

    Parameters
    ----------
    ax
        Axes to draw on.
    curves
        Label with the weighting, levels in dB re 20 uPa and their standard uncertainty in dB by nominal frequency; None is
        a gap.
    duration_s
        Duration T of the record, s; of several the shortest.
    limits_db
        Of the level axis; otherwise those of the curves, see `level_limits`.
    """
    read = reliable(duration_s)
    first = int(np.argmax(read)) if read.any() else len(read)  # bands widen upwards, so the grey ones are the lowest
    seen: list[float] = []
    for number, (label, levels, uncertainty) in enumerate(curves):
        level, spread = (_numbers(by_name[name] for name in BAND_NAMES) for by_name in (levels, uncertainty))
        seen += [*level]
        look = _look(number, len(curves))
        colour, style = look["color"], look["linestyle"]
        marker = {"marker": look["marker"], "markersize": 4, "linestyle": "none"}
        few = len(curves) <= FEW
        if first > 0:
            _steps(
                ax,
                level[:first],
                EDGES_HZ[: first + 1],
                few,
                color=_GREY,
                linestyle=style,
                linewidth=1.2 if few else 0.7,
            )
            if few:
                ax.plot(MID_HZ[:first], level[:first], color=_GREY, markerfacecolor="white", **marker)
        if first < len(read):
            _steps(ax, level[first:], EDGES_HZ[first:], few, color=colour, linestyle=style, linewidth=1.5)
            if few:
                _bars(ax, MID_HZ[first:], level[first:], spread[first:], colour)
        ax.plot(MID_HZ[first:], level[first:], color=colour, **marker)
        ax.plot([], [], color=colour, linestyle=style, marker=marker["marker"], markersize=4, label=label)
    if first > 0:
        ax.axvspan(
            EDGES_HZ[0], EDGES_HZ[first], color="0.93", zorder=0, label=f"B T < {LEAST_BT:g}: uncertain by 2 dB or more"
        )
    ax.set_ylim(limits_db or level_limits(seen))
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.xaxis.set_minor_locator(NullLocator())
    _say_if_silent(ax, bool(np.isfinite(seen).any()))
    ax.set_xticks(MID_HZ, [_short(name) for name in BAND_NAMES], rotation=90, fontsize="small")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    return _finish(ax, "sound pressure level [dB re 20 µPa]")


def spectrogram(ax: Axes, bar: Axes, shown: Spectrogram, duration_s: float, limits_db: tuple[float, float]) -> Axes:
    """Level of the spectral density as colours over time and frequency, light where there is nothing to show.

    Parameters
    ----------
    ax, bar
        Axes to draw on, and those of the colour bar.
    shown
        Spectrogram with rows of equal width on a logarithmic scale.
    duration_s
        Duration of the record, s: the whole width of the axes.
    limits_db
        Of the colours.
    """
    factor, prefix = _prefix(duration_s)
    first, last = (shown.time_s[[0, -1]] + np.array([-0.5, 0.5]) * shown.hop_s) / factor
    low, high = np.log10(shown.edges_hz[[0, -1]])
    colours = matplotlib.colormaps["magma"].resampled(_SHADES).with_extremes(bad="0.85")
    # Rows are equally wide on a logarithmic scale: an image on a linear axis of logarithms is drawn as it is, each value a dot.
    image = ax.imshow(
        shown.level_db,
        origin="lower",
        extent=(first, last, low, high),
        aspect="auto",
        cmap=colours,
        vmin=limits_db[0],
        vmax=limits_db[1],
        interpolation="none",
    )
    _say_if_silent(ax, bool(np.isfinite(shown.level_db).any()))
    ax.set_xlim(0.0, duration_s / factor)
    ax.set_ylim(low, high)
    octaves = slice(2, None, 3)
    ax.set_yticks(np.log10(MID_HZ[octaves]), [_short(name) for name in BAND_NAMES[octaves]])
    ax.set_xlabel(f"time [{prefix}s]")
    ax.set_ylabel("frequency [Hz]")
    ax.figure.colorbar(image, cax=bar, label="density level [dB re (20 µPa)²/Hz]", extend="both")
    return ax


def power(
    ax: Axes,
    time_s: np.ndarray,
    power_w: np.ndarray,
    mean_w: float,
    duration_s: float,
    share: tuple[float, float] | None = None,
) -> Axes:
    """Draw release power against time with its mean, in units that suit the numbers.

    The power axis spans at least 2 % of the mean, so that a steady power looks steady. Of more than 3,000 values the least
    and the greatest in each of 1,500 columns are drawn.

    Parameters
    ----------
    ax
        Axes to draw on.
    time_s
        Time (n,), s.
    power_w
        Release power (n,), W.
    mean_w
        Its mean over time, W: that of the values only where they are evenly spaced.
    duration_s
        Duration of the record, s: the whole width of the axes.
    share
        Least and greatest power shown as shares of the mean; otherwise those of the power, see `power_share`.
    """
    time_unit, power_unit = _prefix(duration_s), _prefix(np.max(np.abs(power_w)))
    mean = mean_w / power_unit[0]
    time, shown = power_envelope(time_s, power_w)
    ax.plot(
        time / time_unit[0],
        shown / power_unit[0],
        color=COLOURS[0],
        linewidth=0.5 if len(time) > _DENSE else 1.5,
        label="release power",
    )
    ax.axhline(mean, color=COLOURS[1], linestyle="--", linewidth=1.5, label=f"mean {mean:.4g} {power_unit[1]}W")
    low, high = (edge * mean for edge in share or power_share(power_w, mean_w))
    room = 0.05 * (high - low) or 1.0
    ax.set_ylim(low - room, high + room)
    ax.set_xlim(0.0, duration_s / time_unit[0])
    ax.ticklabel_format(useOffset=False)
    ax.set_xlabel(f"time [{time_unit[1]}s]")
    return _finish(ax, f"release power [{power_unit[1]}W]")


def power_share(power_w: np.ndarray, mean_w: float) -> tuple[float, float]:
    """Return least and greatest power as shares of the mean, no nearer to it than 1 %; several give a common axis."""
    mean = mean_w or 1.0
    return min(float(power_w.min()) / mean, 0.99), max(float(power_w.max()) / mean, 1.01)


def is_thinned(time_s: np.ndarray) -> bool:
    """Whether a record has more values than are drawn of it."""
    return len(time_s) > 2 * _COLUMNS


def power_envelope(time_s: np.ndarray, power_w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time and power as drawn: of more than 3,000 values the least and the greatest in each of 1,500 columns."""
    if not is_thinned(time_s):
        return time_s, power_w
    return _thinned(time_s, power_w, (time_s - time_s[0]) / (time_s[-1] - time_s[0]))


def level_against(
    ax: Axes,
    x: Sequence[float] | np.ndarray,
    curves: Sequence[tuple[str, Sequence[float | None], Sequence[float | None]]],
    xlabel: str,
    limits_db: tuple[float, float] | None = None,
) -> Axes:
    """Levels against a quantity that was varied, such as the load; logarithmic when it spans more than a decade.

    Parameters
    ----------
    ax
        Axes to draw on.
    x
        Values of the quantity (n,).
    curves
        Label with the weighting, the levels (n,) in dB and their standard uncertainty (n,) in dB; None is a gap.
    xlabel
        Name and unit of the quantity.
    limits_db
        Of the level axis; otherwise those of the curves, see `level_limits`.
    """
    values = np.asarray(x, dtype=float)
    order = np.argsort(values)
    seen: list[float] = []
    for number, (label, levels, uncertainty) in enumerate(curves):
        level, spread = _numbers(levels)[order], _numbers(uncertainty)[order]
        seen += [*level]
        look = _look(number, len(curves))
        ax.plot(values[order], level, markersize=5, label=label, **look)
        _bars(ax, values[order], level, spread, look["color"])
    if values.min(initial=np.inf) > 0.0 and values.max() > 10.0 * values.min():
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
    if len(values) <= 8:
        ax.set_xticks(np.unique(values), [f"{value:g}" for value in np.unique(values)])
        ax.xaxis.set_minor_locator(NullLocator())
    ax.set_ylim(limits_db or level_limits(seen))
    ax.set_xlabel(xlabel)
    return _finish(ax, "level [dB]")


def _finish(ax: Axes, ylabel: str) -> Axes:
    ax.set_ylabel(ylabel)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def _say_if_silent(ax: Axes, sounds: bool) -> None:
    if not sounds:
        ax.text(0.5, 0.5, "no sound", transform=ax.transAxes, ha="center", va="center", color="0.4", fontsize=14)


def _look(number: int, count: int) -> dict[str, Any]:
    """Colour, line style and marker of one of so many curves."""
    colour = COLOURS[number % len(COLOURS)]
    if count > len(COLOURS):  # beyond 0.9 the map is too light for white paper
        colour = to_hex(matplotlib.colormaps["viridis"](0.9 * number / (count - 1)))
    return {"color": colour, "linestyle": _cycled(LINE_STYLES, number), "marker": _cycled(MARKERS, number)}


def _steps(ax: Axes, level_db: np.ndarray, edges_hz: np.ndarray, few: bool, **look: Any) -> None:
    """Bands as steps, or as a line through their middles where steps of many curves would hide one another."""
    if few:
        ax.stairs(level_db, edges_hz, baseline=None, **look)
    else:
        ax.plot(np.sqrt(edges_hz[:-1] * edges_hz[1:]), level_db, **look)


def _bars(ax: Axes, x: np.ndarray, level_db: np.ndarray, uncertainty_db: np.ndarray, colour: str) -> None:
    ax.errorbar(x, level_db, yerr=uncertainty_db, fmt="none", ecolor=colour, elinewidth=0.9, capsize=2.5, capthick=0.9)


def _thinned(x: np.ndarray, y: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each column that holds more than two points, the least and the greatest y at its first x; x rising.

    `share` of the width (n,), 0 to 1, says where each point lies.
    """
    column = np.minimum(np.floor(share * _COLUMNS), _COLUMNS - 1)
    starts = np.flatnonzero(np.diff(column, prepend=-1.0))
    counts = np.diff(starts, append=len(x))
    crowded = counts > 2
    alone = np.repeat(~crowded, counts)
    at = np.repeat(x[starts[crowded]], 2)
    extremes = np.stack([np.minimum.reduceat(y, starts)[crowded], np.maximum.reduceat(y, starts)[crowded]], 1).ravel()
    merged = np.argsort(np.concatenate([x[alone], at]), kind="stable")
    return np.concatenate([x[alone], at])[merged], np.concatenate([y[alone], extremes])[merged]


def _band_mean(frequency_hz: np.ndarray, level_db: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Level of the mean power of the lines in each 1/12 octave that has any, at its mid frequency."""
    octaves = math.log2(AUDIBLE_HZ[1] / AUDIBLE_HZ[0])
    edges = AUDIBLE_HZ[0] * 2.0 ** (np.arange(math.ceil(octaves * PER_OCTAVE) + 1) / PER_OCTAVE)
    band = np.searchsorted(edges, frequency_hz, side="right") - 1
    lines = np.bincount(band, minlength=len(edges) - 1)
    power = np.bincount(band, weights=10.0 ** (level_db / 10.0), minlength=len(edges) - 1)
    held = lines > 0
    mid = np.sqrt(edges[:-1] * edges[1:])
    with np.errstate(divide="ignore"):
        level = 10.0 * np.log10(power[held] / lines[held])
    return mid[held], np.maximum(level, _NOTHING_DB)


def _numbers(levels_db: Iterable[float | None]) -> np.ndarray:
    return np.array([np.nan if level is None else level for level in levels_db], dtype=float)


def _prefix(largest: float) -> tuple[float, str]:
    """Factor and SI prefix that bring a value to between 1 and 1000."""
    prefixes = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M"}
    thousands = math.floor(math.log10(largest) / 3.0) if largest > 0.0 else 0
    thousands = min(max(thousands, min(prefixes)), max(prefixes))
    return 1000.0**thousands, prefixes[thousands]


def _short(name: str) -> str:
    """Frequency as tick labels give it: 1000 is 1k."""
    value = float(name)
    return f"{value / 1000.0:g}k" if value >= 1000.0 else name


def _cycled(items: Sequence[Any], number: int) -> Any:
    return items[number % len(items)]
