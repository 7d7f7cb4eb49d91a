"""Figures of the channels of a run: third octaves, narrow bands and envelopes."""

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from acoustics import plots
from acoustics.arrays import instance
from acoustics.bands import BAND_NAMES, MID_HZ, NOMINAL_HZ
from acoustics.plot_style import Lines, curve_style, gridded
from acoustics.vibration_level import REFERENCES
from rolling.figures.picture import axes_of, duration_text, finish
from rolling.results.channels import Channel
from rolling.results.run_result import Run

MOST_HZ = 200.0  # of the modulations that are drawn
_ISO = "reference values of ISO 1683 stand behind the names"


def channel_third_octaves(run: Run, ax: Axes | None = None) -> Axes:
    """Plot third-octave levels of the channels of a run, without weighting.

    Parameters
    ----------
    run : Run
        Run whose scene asks for channels.
    ax : matplotlib.axes.Axes
        Axes to draw on. Default: new axes.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with levels over nominal mid frequency, Hz; the legend has the reference of each.

    Raises
    ------
    ValueError
        The run has no channels.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.channel_third_octaves(run)
    """
    channels = _channels(run)
    no_spread = dict.fromkeys(BAND_NAMES)
    curves = [(_label(channel), channel.levels.third_octave_db, no_spread) for channel in channels]
    ax = plots.third_octaves(axes_of(ax), curves, duration_s=run.sound.duration / run.laps)
    ax.set_ylim(_limits([channel.levels.third_octave_db.values() for channel in channels]))
    ax.set_ylabel("level [dB re the value in the legend]")
    facts = [_ISO, "no frequency weighting", duration_text([run])]
    return finish(ax, f"Third octaves of the channels: {run.title}", facts)


def channel_third_octave_table(run: Run) -> pd.DataFrame:
    """Tabulate third octaves of the channels of a run [dB] with their rms [SI] and references."""
    frames = []
    for channel in _channels(run):
        level = np.array([*channel.levels.third_octave_db.values()], dtype=float)
        frame = pd.DataFrame(
            {
                "channel": channel.name,
                "band_hz": NOMINAL_HZ,
                "mid_frequency_hz": MID_HZ,
                "level_db": level,
                "reference": channel.reference,
                "rms": REFERENCES[channel.quantity].value * 10 ** (level / 20),
                "unit": channel.unit,
            }
        )
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def channel_spectrum(run: Run, ax: Axes | None = None) -> Axes:
    """Plot narrow bands of the channels of a run: densities by Welch's method.

    Parameters
    ----------
    run, ax : Run, matplotlib.axes.Axes
        As in `channel_third_octaves`.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with density levels, dB re the squared reference per Hz, over frequency, Hz.

    Raises
    ------
    ValueError
        As in `channel_third_octaves`.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.channel_spectrum(run)
    """
    channels = _channels(run)
    curves = []
    for channel in channels:
        frequency_hz, level_db = _density_level(channel)
        curves.append((_label(channel), Lines.audible(frequency_hz, level_db)))
    limits = _limits([lines.level_db for _, lines in curves])
    ax = plots.spectrum(axes_of(ax), curves, limits)
    ax.set_ylabel("density level [dB re (value in the legend)²/Hz]")
    facts = [
        _ISO,
        f"Welch's method, Hann window, bandwidth {channels[0].density.enbw_hz:.3g} Hz",
        duration_text([run]),
    ]
    return finish(ax, f"Narrow bands of the channels: {run.title}", facts)


def channel_spectrum_table(run: Run) -> pd.DataFrame:
    """Tabulate densities of the channels of a run over frequency [Hz], in SI and as levels."""
    frames = []
    for channel in _channels(run):
        frequency_hz, level_db = _density_level(channel)
        frame = pd.DataFrame(
            {
                "channel": channel.name,
                "frequency_hz": frequency_hz,
                "density": channel.density.psd,
                "unit": f"({channel.unit})2/Hz",
                "density_level_db": level_db,
                "reference": f"{channel.reference} squared per Hz",
            }
        )
        frames.append(frame)
    return pd.concat(frames, ignore_index=True).replace(-np.inf, np.nan)


def channel_envelope(run: Run, ax: Axes | None = None) -> Axes:
    """Plot the envelope spectra of the channels of a run, each of its octave with the most power.

    Parameters
    ----------
    run, ax : Run, matplotlib.axes.Axes
        As in `channel_third_octaves`.

    Returns
    -------
    ax : matplotlib.axes.Axes
        Axes with the modulation of the envelope over frequency, Hz.

    Raises
    ------
    ValueError
        As in `channel_third_octaves`.

    Examples
    --------
    >>> import rolling
    >>> ax = rolling.plot.channel_envelope(run)
    """
    channels = _channels(run)
    ax = axes_of(ax)
    for number, channel in enumerate(channels):
        spectrum = channel.envelope
        if spectrum is None:
            continue
        low_hz, high_hz = spectrum.band_hz
        shown = spectrum.frequency_hz <= MOST_HZ
        look = curve_style(number, len(channels))
        del look["marker"]
        label = f"{channel.name}, {low_hz:.0f} to {high_hz:.0f} Hz"
        ax.plot(spectrum.frequency_hz[shown], spectrum.modulation[shown], label=label, **look)
    ax.set(xlim=(0.0, MOST_HZ), ylim=(0.0, None))
    gridded(ax, xlabel="frequency of the modulation [Hz]", ylabel="modulation of the envelope [-]")
    facts = ["the octave of each channel is that with the most power", duration_text([run])]
    return finish(ax, f"Envelopes of the channels: {run.title}", facts)


def channel_envelope_table(run: Run) -> pd.DataFrame:
    """Tabulate the modulation [-] of the channels of a run over frequency [Hz]."""
    frames = []
    for channel in _channels(run):
        spectrum = channel.envelope
        if spectrum is None:
            continue
        low_hz, high_hz = spectrum.band_hz
        frame = pd.DataFrame(
            {
                "channel": channel.name,
                "band_low_hz": low_hz,
                "band_high_hz": high_hz,
                "frequency_hz": spectrum.frequency_hz,
                "modulation": spectrum.modulation,
            }
        )
        frames.append(frame)
    if not frames:
        return pd.DataFrame()
    return pd.concat(frames, ignore_index=True)


def _channels(run: Run) -> tuple[Channel, ...]:
    """Return the channels of a run; refuse a run without."""
    instance("run", run, Run)
    if not run.channels:
        raise ValueError(f"{run.title}: has no channels; sound.channels of a scene asks for them")
    return run.channels


def _limits(levels: Sequence[Iterable[float | None]]) -> tuple[float, float]:
    """Return limits [dB] that show the upper 50 dB of each channel, whatever its reference."""
    largest = []
    for values in levels:
        known = [value for value in values if value is not None and np.isfinite(value)]
        if known:
            largest.append(max(known))
    if not largest:
        return 0.0, 10.0
    return 10.0 * np.floor(min(largest) / 10 - 5), 10.0 * np.ceil(max(largest) / 10 + 0.5)


def _label(channel: Channel) -> str:
    """Return the name of a channel with the reference of its levels."""
    return f"{channel.name}, {channel.reference}"


def _density_level(channel: Channel) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and density levels [dB re the squared reference per Hz]."""
    density = channel.density
    with np.errstate(divide="ignore"):
        level_db = 10 * np.log10(density.psd / REFERENCES[channel.quantity].value ** 2)
    return density.frequency_hz, level_db
