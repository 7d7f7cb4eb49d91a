"""Plots of levels: each function draws on `ax` and returns it.

The functions label their curves, but leave title and legend to the caller.
"""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib

# isort: split

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from acoustics import plot_style as style
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, MID_HZ, MIN_BT, OFF_DB, reliable
from acoustics.plot_style import COLOURS, FEW, GREY, PER_OCTAVE, Lines, level_limits
from acoustics.spectrum import Spectrogram
from acoustics.traps import ignoring_underflow

__all__ = [
    "COLOURS", "FEW", "PER_OCTAVE", "BandErrors", "Lines", "drawn_as_means", "level_limits",
    "spectrogram", "spectrum", "third_octaves",
]  # fmt: skip

Limits = tuple[float, float]
Curve = tuple[str, Lines]  # label and spectrum
# Errors of band levels [dB] and their standard uncertainty, by nominal frequency.
BandErrors = tuple[Mapping[str, float | None], Mapping[str, float | None]]
# Shades of a spectrogram are 2 dB apart, less than the uncertainty of noise; more make large files.
_SMALL_IN = 2.4  # height of axes that takes a name for each octave
_SHADES = 36
_HATCHES = ("////", "\\\\\\\\", "xxxx")  # marks of bands with large errors, one for each curve


@ignoring_underflow
def drawn_as_means(curves: Sequence[Curve]) -> list[Curve]:
    """Return the curves drawn as means: dense spectra, or all of more than three curves."""
    return [curve for curve in curves if curve[1].dense or len(curves) > FEW]


@ignoring_underflow
def spectrum(
    ax: Axes, curves: Sequence[Curve], limits_db: Limits | None = None, ordered: bool = False
) -> Axes:
    """Draw spectra against frequency, 20 Hz to 20 kHz.

    More than 500 lines, and more than three curves, are drawn as the mean (of powers) over 1/12
    octave. The lines of up to three curves are thin and pale behind it.

    Parameters
    ----------
    ax : axes to draw on
    curves : sequence of pairs
        Label and spectrum in dB; -inf lies below the axis.
    limits_db : pair of float, dB
        Limits of the level axis. Default: `level_limits` of the curves.
    ordered : bool
        Whether the order of the curves has a meaning, such as an ascending load. Three curves or
        more are then coloured from dark to light. Default: false.

    Returns
    -------
    the axes

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from acoustics import plots
    >>> lines = plots.Lines.audible(np.array([100.0, 1000.0]), np.array([40.0, 60.0]))
    >>> plots.spectrum(Figure().subplots(), [("two tones", lines)]).get_xlabel()
    'frequency [Hz]'
    """
    for number, (label, lines) in enumerate(curves):
        look = style.look_of(number, len(curves), ordered)
        del look["marker"]
        if (label, lines) in drawn_as_means(curves):
            if len(curves) <= FEW:
                ax.plot(*lines.envelope, color=look["color"], linewidth=0.3, alpha=0.4, zorder=1.5)
            ax.plot(*lines.mean, linewidth=1.8, label=label, **look)
        else:
            level = np.maximum(lines.level_db, style.NOTHING_DB)
            ax.plot(lines.frequency_hz, level, linewidth=1.2, label=label, **look)
    seen = [level for _, lines in curves for level in lines.extremes]
    _audible(ax, seen, limits_db, octaves=True)
    return style.gridded(ax, xlabel="frequency [Hz]", ylabel="level [dB]")


@ignoring_underflow
def third_octaves(
    ax: Axes,
    curves: Sequence[tuple[str, Mapping[str, float | None], Mapping[str, float | None]]],
    duration_s: float,
    errors: Sequence[BandErrors | None] = (),
    ordered: bool = False,
) -> Axes:
    """Draw third-octave levels as steps over the bands, 20 Hz to 20 kHz.

    More than three curves are drawn as lines from band to band instead. A band is grey if the
    record is too short for its level (B T < 5, uncertain by 2 dB or more). In the other bands up to
    three curves have bars of their standard uncertainty.

    Parameters
    ----------
    ax : axes to draw on
    curves : sequence of triples
        Label with the weighting, levels in dB re 20 uPa and their standard uncertainty in dB, both
        by nominal frequency; None is a gap.
    duration_s : float, s
        Duration T of the record; the shortest of several.
    errors : sequence of pairs
        Errors of the levels of each curve in dB, too loud is positive, and their standard
        uncertainty, both by nominal frequency; None for a curve without. Up to three curves have a
        diamond at the level less its error, and bands off by more than 1 dB are hatched in the
        colour of the curve. Default: none.
    ordered : bool
        As in `spectrum`. Default: false.

    Returns
    -------
    the axes

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from acoustics import BAND_NAMES, plots
    >>> levels, spread = dict.fromkeys(BAND_NAMES, 50.0), dict.fromkeys(BAND_NAMES, 0.5)
    >>> ax = plots.third_octaves(Figure().subplots(), [("noise, Z", levels, spread)], 10.0)
    >>> ax.get_xlabel()
    'third octave, nominal mid frequency [Hz]'
    """
    read = reliable(duration_s)
    # bands widen upwards, so the grey bands are the lowest
    first = int(np.argmax(read)) if read.any() else len(read)
    seen: list[float] = []
    for number, (label, levels, uncertainty) in enumerate(curves):
        level, spread = _by_band(levels), _by_band(uncertainty)
        seen += [*level]
        look = style.look_of(number, len(curves), ordered)
        _band_curve(ax, label, level, spread, first, look, len(curves) <= FEW)
        if number < len(errors) and (of_curve := errors[number]) and len(curves) <= FEW:
            seen += _error_marks(ax, label, number, level, of_curve, look["color"])
    if first > 0:
        short = f"B T < {MIN_BT:g}: uncertain by 2 dB or more"
        ax.axvspan(EDGES_HZ[0], EDGES_HZ[first], color="0.93", zorder=0, label=short)
    _audible(ax, seen, None)
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    return style.gridded(ax, ylabel="sound pressure level [dB re 20 µPa]")


def _by_band(by_name: Mapping[str, float | None]) -> Array:
    """Return the values of all third octaves, with NaN in place of None."""
    return style.numbers(by_name[name] for name in BAND_NAMES)


def _audible(
    ax: Axes, levels_db: Sequence[float], limits_db: Limits | None, octaves: bool = False
) -> None:
    """Give the axes a logarithmic axis of the audible range and one of the levels."""
    ax.set_ylim(limits_db or level_limits(levels_db))
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.xaxis.set_minor_locator(NullLocator())
    style.say_if_silent(ax, bool(np.isfinite(levels_db).any()))
    style.band_ticks(ax, octaves)


def _band_curve(
    ax: Axes, label: str, level: Array, spread: Array, first: int, look: dict[str, Any], few: bool
) -> None:
    """Draw a curve of third octaves, grey below the first reliable band.

    Bands are steps, or a line where the steps of many curves would hide one another.
    """
    marker, dash = {"marker": look["marker"], "markersize": 4}, {"linestyle": look["linestyle"]}
    grey, coloured = slice(0, first), slice(first, len(level))
    for part, colour in ((grey, GREY), (coloured, look["color"])):
        if part.start == part.stop:
            continue
        own = {"color": colour, "label": f"_{label}"}  # which is not in the legend
        line = dash | own | {"linewidth": 0.7 if colour == GREY and not few else 1.3}
        edges = EDGES_HZ[part.start : part.stop + 1]
        if few:
            ax.stairs(level[part], edges, baseline=None, **line)
        else:
            ax.plot(MID_HZ[part], level[part], **line)
        if few or colour != GREY:
            face = "white" if colour == GREY else colour
            dots = marker | own | {"markerfacecolor": face, "linestyle": "none"}
            ax.plot(MID_HZ[part], level[part], **dots)
    if few:
        style.bars(ax, MID_HZ[coloured], level[coloured], spread[coloured], look["color"])
    ax.plot([], [], color=look["color"], label=label, **marker, **dash)


def _error_marks(
    ax: Axes, label: str, number: int, level: Array, errors: BandErrors, colour: str
) -> list[float]:
    """Draw diamonds at levels less their errors, and hatch the bands that are off by over 1 dB.

    Returns these levels [dB].
    """
    error, spread = map(_by_band, errors)
    known = np.isfinite(error) & np.isfinite(level)
    right, marked = (level - error)[known], "level less its estimated error"
    named = f"_{marked}" if marked in ax.get_legend_handles_labels()[1] else marked
    # The curve's own mark shows inside a diamond of this size.
    diamond: dict[str, Any] = {"fmt": "D", "markersize": 7, "elinewidth": 0.7, "zorder": 1.8}
    diamond |= {"color": colour, "markeredgewidth": 0.8, "markerfacecolor": "none"}
    ax.errorbar(MID_HZ[known], right, np.nan_to_num(spread[known]), label=named, **diamond)
    hatch: dict[str, Any] = {"facecolor": "none", "edgecolor": colour, "alpha": 0.6}
    hatch |= {"hatch": _HATCHES[number], "linewidth": 0.0, "zorder": 0.5}
    for k, band in enumerate(np.flatnonzero(known & (np.abs(error) > OFF_DB))):
        named = f"{'_' if k else ''}{label}: off by more than {OFF_DB:g} dB"
        ax.axvspan(EDGES_HZ[band], EDGES_HZ[band + 1], label=named, **hatch)
    return [float(level) for level in right]


@ignoring_underflow
def spectrogram(ax: Axes, shown: Spectrogram, duration_s: float, limits_db: Limits) -> Axes:
    """Draw a spectrogram as colours over time and frequency, light where there is silence.

    Parameters
    ----------
    ax : axes to draw on; the colour bar stands beside them
    shown : Spectrogram
        Its rows have equal width on a logarithmic scale.
    duration_s : float, s
        Duration of the record, the whole width of the axes.
    limits_db : pair of float, dB
        Levels of the first and the last colour.

    Returns
    -------
    the axes

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from acoustics import plots
    >>> from acoustics.spectrum import spectrogram
    >>> shown = spectrogram(np.random.default_rng(1).standard_normal(24000), 48000)
    >>> plots.spectrogram(Figure().subplots(), shown, 0.5, (20.0, 90.0)).get_xlabel()
    'time [ms]'
    """
    factor, prefix = style.unit_prefix(duration_s)
    first, last = (shown.time_s[[0, -1]] + np.array([-0.5, 0.5]) * shown.hop_s) / factor
    low, high = np.log10(shown.edges_hz[[0, -1]])
    colours = matplotlib.colormaps["magma"].resampled(_SHADES).with_extremes(bad="0.85")
    # Rows are equally wide on a logarithmic scale, so an image on a linear axis of logarithms shows
    # each value as a dot.
    shape: dict[str, Any] = {"extent": (first, last, low, high), "aspect": "auto"}
    shades: dict[str, Any] = {"cmap": colours, "vmin": limits_db[0], "vmax": limits_db[1]}
    image = ax.imshow(shown.level_db, origin="lower", interpolation="none", **shape, **shades)
    style.say_if_silent(ax, bool(np.isfinite(shown.level_db).any()))
    ax.set(xlim=(0.0, duration_s / factor), ylim=(low, high))
    named = slice(2, None, 3 if ax.bbox.height > _SMALL_IN * ax.figure.dpi else 9)
    ax.set_yticks(np.log10(MID_HZ[named]), [*map(style.short_name, BAND_NAMES[named])])
    ax.set(xlabel=f"time [{prefix}s]", ylabel="frequency [Hz]")
    beside = ax.inset_axes((1.03, 0.0, 0.04, 1.0))
    label = "density level [dB re (20 µPa)²/Hz]"
    ax.figure.colorbar(image, cax=beside, label=label, extend="both")
    return ax
