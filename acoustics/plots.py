"""Plots of levels: each function draws on `ax` and returns it.

The functions label their curves, but leave title and legend to the caller.
"""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib

# isort: split

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from acoustics import plot_style as style
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, EDGES_HZ, MID_HZ, MIN_BT, OFF_DB, reliable
from acoustics.plot_style import COLOURS, FEW, PER_OCTAVE, Lines, level_limits
from acoustics.spectrum import Spectrogram
from acoustics.traps import ignoring_underflow

__all__ = [
    "COLOURS", "FEW", "PER_OCTAVE", "BandErrors", "Lines", "drawn_as_means", "level_limits",
    "lowest_resolved", "resolved_levels", "spectrogram", "spectrum", "third_octaves",
]  # fmt: skip

Limits = tuple[float, float]
Curve = tuple[str, Lines]  # label and spectrum
Levels = Mapping[str, float | None]  # by nominal frequency; None is a gap


class BandErrors(NamedTuple):
    """Errors of band levels [dB], too loud is positive, and their standard uncertainty [dB]."""

    error_db: Levels
    uncertainty_db: Levels


_THIRD_OF_OCTAVES = slice(2, None, 9)  # of the third octaves, every third octave from 31.5 Hz on
_SMALL_IN = 2.4  # height of axes that takes a name for each octave
# Shades of a spectrogram are at most 2.3 dB apart, less than the uncertainty of noise; more shades
# make large files.
_SHADES = 30
_FULL = 1.3  # width of a line
_THIN = 0.7  # width of a line where levels are uncertain
_PERIODS = 2.0  # in a frame of a spectrogram; a slower tone is not told from a steady pressure


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
        look = style.curve_style(number, len(curves), ordered)
        del look["marker"]
        if lines.dense or len(curves) > FEW:
            if len(curves) <= FEW:
                frequency, level = lines.envelope
                ax.plot(frequency, level, color=look["color"], linewidth=0.3, alpha=0.3, zorder=1.5)
            frequency, level = lines.mean
            ax.plot(frequency, level, linewidth=1.8, label=label, **look)
        else:
            level = np.maximum(lines.level_db, style.NOTHING_DB)
            ax.plot(lines.frequency_hz, level, linewidth=1.2, label=label, **look)
    extremes = [level for _, lines in curves for level in lines.extremes]
    _scale_axes(ax, extremes, limits_db, octaves=True)
    return style.gridded(ax, xlabel="frequency [Hz]", ylabel="level [dB]")


@ignoring_underflow
def third_octaves(
    ax: Axes,
    curves: Sequence[tuple[str, Levels, Levels]],
    duration_s: float,
    errors: Sequence[BandErrors | None] = (),
    ordered: bool = False,
) -> Axes:
    """Draw third-octave levels as steps over the bands, 20 Hz to 20 kHz.

    More than three curves are drawn as lines from band to band instead. A band stands on grey
    ground, with thin lines and hollow marks, if the record is too short for its level (B T < 5,
    uncertain by 2 dB or more). In the other bands up to three curves have bars of their standard
    uncertainty.

    Parameters
    ----------
    ax : axes to draw on
    curves : sequence of triples
        Label with the weighting, levels in dB re 20 uPa and their standard uncertainty in dB, both
        by nominal frequency; None is a gap.
    duration_s : float, s
        Duration T of the record; the shortest of several.
    errors : sequence of BandErrors or None
        Errors of the levels of each curve in dB, too loud is positive, and their standard
        uncertainty, both by nominal frequency; None for a curve without. Where the level of up to
        three curves is off by more than 1 dB, a diamond stands at the level less its error.
        Default: none.
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
    is_reliable = reliable(duration_s)
    # Bands widen upwards, so the grey bands are the lowest.
    first = int(np.argmax(is_reliable)) if is_reliable.any() else len(is_reliable)
    shown_db: list[float] = []
    for number, (label, levels, uncertainty) in enumerate(curves):
        level = _by_band(levels)
        shown_db += [*level]
        look = style.curve_style(number, len(curves), ordered)
        if len(curves) <= FEW:
            _draw_steps(ax, label, level, _by_band(uncertainty), first, look)
        else:
            _draw_line(ax, label, level, first, look)
        of_curve = errors[number] if number < len(errors) else None
        if of_curve is not None and len(curves) <= FEW:
            shown_db += _mark_errors(ax, level, BandErrors(*of_curve), look["color"])
    if first > 0:
        short = f"uncertain by 2 dB or more (B T < {MIN_BT:g})"
        ax.axvspan(EDGES_HZ[0], EDGES_HZ[first], color="0.93", zorder=0, label=short)
    _scale_axes(ax, shown_db, None)
    ax.set_xlabel("third octave, nominal mid frequency [Hz]")
    return style.gridded(ax, ylabel="sound pressure level [dB re 20 µPa]")


def _by_band(by_name: Mapping[str, float | None]) -> Array:
    """Return the values of all third octaves, with NaN in place of None."""
    return style.numbers(by_name[name] for name in BAND_NAMES)


def _scale_axes(
    ax: Axes, levels_db: Sequence[float], limits_db: Limits | None, octaves: bool = False
) -> None:
    """Give the axes a logarithmic axis of the audible range and one of the levels."""
    ax.set_ylim(limits_db or level_limits(levels_db))
    ax.set_xscale("log")
    ax.set_xlim(*AUDIBLE_HZ)
    ax.xaxis.set_minor_locator(NullLocator())
    style.say_if_silent(ax, bool(np.isfinite(levels_db).any()))
    style.band_ticks(ax, octaves)


def _draw_steps(
    ax: Axes, label: str, level: Array, spread: Array, first: int, look: dict[str, Any]
) -> None:
    """Draw a curve of third octaves as steps, thin below the first reliable band."""
    hidden = f"_{label}"  # which is not in the legend
    for bands, width in _thin_and_full(first, len(level)):
        edges = EDGES_HZ[bands.start : bands.stop + 1]
        ax.stairs(
            level[bands],
            edges,
            baseline=None,
            color=look["color"],
            linestyle=look["linestyle"],
            linewidth=width,
            label=hidden,
        )
    _draw_marks(ax, level, first, look, hidden)
    style.error_bars(ax, MID_HZ[first:], level[first:], spread[first:], look["color"])
    _name_curve(ax, label, look)


def _draw_line(ax: Axes, label: str, level: Array, first: int, look: dict[str, Any]) -> None:
    """Draw a curve of third octaves as a line, thin below the first reliable band.

    The steps of many curves would hide one another.
    """
    hidden = f"_{label}"  # which is not in the legend
    for bands, width in _thin_and_full(first, len(level)):
        ax.plot(
            MID_HZ[bands],
            level[bands],
            color=look["color"],
            linestyle=look["linestyle"],
            linewidth=width,
            label=hidden,
        )
    _draw_marks(ax, level, first, look, hidden)
    _name_curve(ax, label, look)


def _thin_and_full(first: int, count: int) -> list[tuple[slice, float]]:
    """Return the bands below and from the first reliable one with the widths of their lines."""
    parts = [(slice(0, first), _THIN), (slice(first, count), _FULL)]
    return [(bands, width) for bands, width in parts if bands.stop > bands.start]


def _draw_marks(ax: Axes, level: Array, first: int, look: dict[str, Any], label: str) -> None:
    """Draw marks without a line, hollow below the first reliable band."""
    parts = [(slice(0, first), "white"), (slice(first, len(level)), look["color"])]
    for bands, face in parts:
        if bands.stop > bands.start:
            ax.plot(
                MID_HZ[bands],
                level[bands],
                marker=look["marker"],
                markersize=4,
                markerfacecolor=face,
                color=look["color"],
                linestyle="none",
                label=label,
            )


def _name_curve(ax: Axes, label: str, look: dict[str, Any]) -> None:
    """Add line and mark of a curve to the legend."""
    ax.plot([], [], label=label, markersize=4, **look)


def _mark_errors(ax: Axes, level: Array, errors: BandErrors, colour: str) -> list[float]:
    """Draw diamonds at levels less their errors, in the bands that are off by over 1 dB.

    Returns these levels [dB].
    """
    error = _by_band(errors.error_db)
    spread = _by_band(errors.uncertainty_db)
    is_off = np.isfinite(level) & (np.abs(np.nan_to_num(error)) > OFF_DB)
    if not is_off.any():
        return []
    corrected = (level - error)[is_off]
    name = f"less its estimated error (over {OFF_DB:g} dB)"
    if name in ax.get_legend_handles_labels()[1]:
        name = f"_{name}"
    ax.errorbar(
        MID_HZ[is_off],
        corrected,
        np.nan_to_num(spread[is_off]),
        label=name,
        color=colour,
        fmt="D",
        markersize=7,  # the curve's own mark shows inside
        markeredgewidth=0.9,
        markerfacecolor="none",
        elinewidth=0.7,
        zorder=1.8,
    )
    return [float(level) for level in corrected]


@ignoring_underflow
def spectrogram(
    ax: Axes,
    shown: Spectrogram,
    duration_s: float,
    limits_db: Limits,
    unit: str = "dB re (20 µPa)²/Hz",
) -> Axes:
    """Draw a spectrogram as colours over time and frequency, grey where there is silence.

    Rows below `lowest_resolved` are grey too, because a frame holds too few of their periods.

    Parameters
    ----------
    ax : axes to draw on; the colour bar stands beside them
    shown : Spectrogram
        Its rows have equal width on a logarithmic scale.
    duration_s : float, s
        Duration of the record, the whole width of the axes.
    limits_db : pair of float, dB
        Levels of the first and the last colour.
    unit : str
        Unit of the levels. Default: that of sound pressure.

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
    second, prefix = style.unit_prefix(duration_s)
    first = (shown.time_s[0] - 0.5 * shown.hop_s) / second
    last = (shown.time_s[-1] + 0.5 * shown.hop_s) / second
    low, high = np.log10(shown.edges_hz[[0, -1]])
    level_db = resolved_levels(shown)
    # Rows are equally wide on a logarithmic scale, so an image on a linear axis of logarithms shows
    # each value as a dot.
    image = ax.imshow(
        level_db,
        cmap=matplotlib.colormaps["magma"].resampled(_SHADES).with_extremes(bad="0.85"),
        vmin=limits_db[0],
        vmax=limits_db[1],
        origin="lower",
        interpolation="none",
        extent=(first, last, low, high),
        aspect="auto",
    )
    style.say_if_silent(ax, bool(np.isfinite(level_db).any()))
    ax.set(xlim=(0.0, duration_s / second), ylim=(low, high))
    is_small = ax.bbox.height <= _SMALL_IN * ax.figure.dpi
    named = _THIRD_OF_OCTAVES if is_small else style.OCTAVES
    ax.set_yticks(np.log10(MID_HZ[named]), [style.short_name(name) for name in BAND_NAMES[named]])
    ax.set(xlabel=f"time [{prefix}s]", ylabel="frequency [Hz]")
    beside = ax.inset_axes((1.03, 0.0, 0.04, 1.0))
    label = f"density level [{unit}]"
    ax.figure.colorbar(image, cax=beside, label=label, extend="both")
    return ax


@ignoring_underflow
def lowest_resolved(shown: Spectrogram) -> float:
    """Return the lowest frequency [Hz] of a spectrogram: two periods in a frame.

    Below it a Hann window does not tell a tone from a steady pressure.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import plots
    >>> from acoustics.spectrum import spectrogram
    >>> shown = spectrogram(np.random.default_rng(1).standard_normal(24000), 48000)
    >>> round(plots.lowest_resolved(shown))
    50
    """
    return _PERIODS / shown.frame_s


@ignoring_underflow
def resolved_levels(shown: Spectrogram) -> Array:
    """Return the levels (rows, frames) of a spectrogram [dB], NaN below `lowest_resolved`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import plots
    >>> from acoustics.spectrum import spectrogram
    >>> shown = spectrogram(np.random.default_rng(1).standard_normal(24000), 48000)
    >>> bool(np.isnan(plots.resolved_levels(shown)[0]).all())
    True
    """
    is_resolved = shown.edges_hz[:-1] >= lowest_resolved(shown) * (1.0 - 1e-9)
    return np.where(is_resolved[:, np.newaxis], shown.level_db, np.nan)
