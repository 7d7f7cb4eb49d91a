"""Plots of levels and power. Each draws on the axes it is given and returns them. Depends on matplotlib.

Colours are those of Okabe and Ito (2008), told apart with any colour vision; line styles differ too, for grey print.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, LEAST_BT, MID_HZ, reliable

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINE_STYLES: tuple[str | tuple[int, tuple[int, ...]], ...] = (
    "-", "--", "-.", ":", (0, (8, 2)), (0, (4, 1, 1, 1, 1, 1)), (0, (1, 1)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
_GREY = "0.6"

_SHOWN_DB = 70.0
_NOTHING_DB = -300.0  # stands for -inf, which matplotlib would leave out together with its neighbours
_DENSE = 500  # more lines than this hide one another: they fade behind their mean
_PER_OCTAVE = 12


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


def spectrum(ax: Axes, curves: Sequence[tuple[str, np.ndarray, np.ndarray]], title: str) -> Axes:
    """Line spectra against frequency, 20 Hz to 20 kHz.

    A spectrum of more than 500 lines is drawn thin and pale, with the mean (of powers) over 1/12 octave on top.

    Parameters
    ----------
    ax
        Axes to draw on.
    curves
        Label with the unit of the level, frequencies (n,) in Hz, levels (n,) in dB; -inf lies below the axis.
    title
        What is shown and what was assumed.
    """
    seen: list[float] = []
    for number, (label, frequency_hz, level_db) in enumerate(curves):
        inside = (frequency_hz >= AUDIBLE_HZ[0]) & (frequency_hz < AUDIBLE_HZ[1])
        f, level = frequency_hz[inside], np.maximum(level_db[inside], _NOTHING_DB)
        style = {"color": _cycled(COLOURS, number), "linestyle": _cycled(LINE_STYLES, number)}
        if len(f) > _DENSE:
            ax.plot(f, level, color=style["color"], linewidth=0.3, alpha=0.35, rasterized=True)
            seen.append(level.max())
            f, level = _band_mean(f, level)
            ax.plot(f, level, linewidth=1.8, label=f"{label}, mean over 1/{_PER_OCTAVE} octave", **style)
        else:
            ax.plot(f, level, linewidth=1.2, label=label, **style)
        seen += [*level]
    ax.set_ylim(level_limits(seen))
    _frequency_axis(ax)
    octaves = slice(2, None, 3)
    ax.xaxis.set_major_locator(FixedLocator(list(MID_HZ[octaves])))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda f, _: _short(BAND_NAMES[int(np.abs(MID_HZ - f).argmin())])))
    ax.set_xlabel("frequency [Hz]")
    return _finish(ax, "level [dB]", title, len(curves))


def third_octaves(
    ax: Axes,
    curves: Sequence[tuple[str, Mapping[str, float | None] | Sequence[float | None]]],
    duration_s: float,
    title: str,
) -> Axes:
    """Third-octave levels as steps over the bands, 20 Hz to 20 kHz.

    Bands of which the record holds too little to be read as a level (B T < 5, uncertain by 2 dB or more) are grey.

    Parameters
    ----------
    ax
        Axes to draw on.
    curves
        Label with the weighting, and the levels in dB re 20 uPa: by nominal frequency, or all 31 in order; None is
        a gap.
    duration_s
        Duration T of the record, s.
    title
        What is shown and what was assumed.
    """
    read = reliable(duration_s)
    first = int(np.argmax(read)) if read.any() else len(read)  # bands widen upwards, so the grey ones are the lowest
    seen: list[float] = []
    for number, (label, levels) in enumerate(curves):
        level = _numbers([levels.get(name) for name in BAND_NAMES] if isinstance(levels, Mapping) else levels)
        seen += [*level]
        colour, style = _cycled(COLOURS, number), _cycled(LINE_STYLES, number)
        marker = {"marker": _cycled(MARKERS, number), "markersize": 4, "linestyle": "none"}
        if first > 0:
            ax.stairs(level[:first], EDGES_HZ[: first + 1], baseline=None, color=_GREY, linestyle=style, linewidth=1.2)
            ax.plot(MID_HZ[:first], level[:first], color=_GREY, markerfacecolor="white", **marker)
        if first < len(read):
            ax.stairs(level[first:], EDGES_HZ[first:], baseline=None, color=colour, linestyle=style, linewidth=1.5)
        ax.plot(MID_HZ[first:], level[first:], color=colour, **marker)
        ax.plot([], [], color=colour, linestyle=style, marker=marker["marker"], markersize=4, label=label)
    if first > 0:
        ax.axvspan(
            EDGES_HZ[0], EDGES_HZ[first], color="0.93", zorder=0, label=f"B T < {LEAST_BT:g}: uncertain by 2 dB or more"
        )
    ax.set_ylim(level_limits(seen))
    _frequency_axis(ax)
    ax.xaxis.set_major_locator(FixedLocator(list(MID_HZ)))
    ax.set_xticks(MID_HZ, [_short(name) for name in BAND_NAMES], rotation=90, fontsize="small")
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    return _finish(ax, "sound pressure level [dB re 20 µPa]", title, len(curves) + (first > 0))


def power(ax: Axes, time_s: np.ndarray, power_w: np.ndarray, title: str) -> Axes:
    """Release power against time with its mean, in units that suit the numbers.

    The power axis spans at least 2 % of the mean, so that a steady power looks steady.

    Parameters
    ----------
    ax
        Axes to draw on.
    time_s
        Time (n,), s.
    power_w
        Release power (n,), W.
    title
        What is shown and what was assumed.
    """
    time_unit, power_unit = _prefix(np.max(np.abs(time_s))), _prefix(np.max(np.abs(power_w)))
    shown, mean = power_w / power_unit[0], float(np.mean(power_w)) / power_unit[0]
    ax.plot(time_s / time_unit[0], shown, color=COLOURS[0], linewidth=0.5 if len(shown) > _DENSE else 1.5)
    ax.axhline(mean, color=COLOURS[1], linestyle="--", linewidth=1.2, label=f"mean {mean:.4g} {power_unit[1]}W")
    low, high = min(float(shown.min()), 0.99 * mean), max(float(shown.max()), 1.01 * mean)
    room = 0.05 * (high - low) or 1.0
    ax.set_ylim(low - room, high + room)
    ax.set_xlim(float(time_s[0]) / time_unit[0], float(time_s[-1]) / time_unit[0] or 1.0)
    ax.ticklabel_format(useOffset=False)
    ax.set_xlabel(f"time [{time_unit[1]}s]")
    return _finish(ax, f"release power [{power_unit[1]}W]", title, 1)


def level_against(
    ax: Axes,
    x: Sequence[float] | np.ndarray,
    curves: Sequence[tuple[str, Sequence[float | None]]],
    xlabel: str,
    title: str,
) -> Axes:
    """Levels against a quantity that was varied, such as the load; logarithmic when it spans more than a decade.

    Parameters
    ----------
    ax
        Axes to draw on.
    x
        Values of the quantity (n,).
    curves
        Label with the weighting, and the levels (n,) in dB; None is a gap.
    xlabel
        Name and unit of the quantity.
    title
        What is shown and what was assumed.
    """
    values = np.asarray(x, dtype=float)
    order = np.argsort(values)
    seen: list[float] = []
    for number, (label, levels) in enumerate(curves):
        level = _numbers(levels)[order]
        seen += [*level]
        ax.plot(
            values[order],
            level,
            color=_cycled(COLOURS, number),
            linestyle=_cycled(LINE_STYLES, number),
            marker=_cycled(MARKERS, number),
            markersize=5,
            label=label,
        )
    if values.min(initial=np.inf) > 0.0 and values.max() > 10.0 * values.min():
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        if len(values) <= 8:
            ax.set_xticks(np.unique(values))
    ax.set_ylim(level_limits(seen))
    ax.set_xlabel(xlabel)
    return _finish(ax, "level [dB]", title, len(curves))


def _finish(ax: Axes, ylabel: str, title: str, entries: int) -> Axes:
    ax.set_ylabel(ylabel)
    ax.set_title(title)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    if entries:
        ax.legend(fontsize="small", framealpha=0.85)
    return ax


def _frequency_axis(ax: Axes) -> None:
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.xaxis.set_minor_locator(NullLocator())


def _band_mean(frequency_hz: np.ndarray, level_db: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Level of the mean power of the lines in each 1/12 octave that has any, at its mid frequency."""
    octaves = math.log2(AUDIBLE_HZ[1] / AUDIBLE_HZ[0])
    edges = AUDIBLE_HZ[0] * 2.0 ** (np.arange(math.ceil(octaves * _PER_OCTAVE) + 1) / _PER_OCTAVE)
    band = np.searchsorted(edges, frequency_hz, side="right") - 1
    lines = np.bincount(band, minlength=len(edges) - 1)
    power = np.bincount(band, weights=10.0 ** (level_db / 10.0), minlength=len(edges) - 1)
    held = lines > 0
    mid = np.sqrt(edges[:-1] * edges[1:])
    return mid[held], 10.0 * np.log10(power[held] / lines[held])


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


def _cycled(items: Sequence, number: int):
    return items[number % len(items)]
