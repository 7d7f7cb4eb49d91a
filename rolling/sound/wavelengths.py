"""Roughness over wavelength: its part of the sound, and its level before and after the contact.

A wave of length L along the track sounds at the frequency v/L. The record holds the contact filter
already. Waves much shorter than the contact are averaged out, and the sound at their frequencies
comes from the nonlinear contact of longer waves. The coherence of surface and approach tells both
apart. The spectrum of the approach under a constant load less that of the surface is the contact
filter of wheel and rail.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.contact.track import Motion, Track
from rolling.sound.contact_sound import ContactSound

EDGE_UM = 10.0  # an edge of the octaves
FOLLOWS = 0.5  # linear share from which the sound of an octave counts as made by its waves
MIN_SHARE = 1e-3  # of the energy in an octave that is shown
_ALL = 1e-6  # share of the energy outside an octave, below which the rest is silent
_MIN_LINES = 8  # of an octave whose coherence is estimated, which is wrong by one over them
_MAX_NODES = 20_000_000  # under the contact; of longer tracks fewer lines count


class WavelengthOctave(NamedTuple):
    """Octave of wavelengths: its share of the A-weighted energy, and the fall without it.

    linear_share : share of the approach in the octave that follows its waves; None for a release,
        and where it is unknown.
    fall_db : fall of LAeq without the waves of the octave; None where the rest is silent.
    """

    from_um: float
    to_um: float
    energy_share: float
    linear_share: float | None
    fall_db: float | None


def weighted_lines(sound: ContactSound) -> tuple[Array, Array, Array]:
    """Return the audible lines of a record: frequencies [Hz], Z and A mean squares [Pa2]."""
    frequency, square = audible_lines(sound.pressure, sound.sample_rate)
    return frequency, square, square * 10.0 ** (a_weighting_db(frequency) / 10.0)


def mean_speed(motion: Motion, sound: ContactSound) -> float:
    """Return the mean speed [m/s] of a record."""
    return float(motion.distance(sound.duration)) / sound.duration


def wavelength_octaves(
    sound: ContactSound,
    speed: float,
    own_factor: bool,
    linear: Mapping[int, float] | None = None,
) -> list[WavelengthOctave]:
    """Return the octaves within hearing of a ball that rolls, short waves first.

    A silent record has no octaves.

    Parameters
    ----------
    sound : ContactSound
        Record of the run.
    speed : float, m/s
        Mean speed of the record.
    own_factor : bool
        Whether the fluctuation of a release sets its factor to sound pressure.
    linear : mapping of int to float, optional
        Linear shares of a vibration by octave, as `linear_shares` returns them. Default: none is
        known.
    """
    frequency, square, weighted = weighted_lines(sound)
    if not weighted.sum() > 0:
        return []
    shares = linear or {}
    order = _order(1e6 * speed / frequency)
    octaves = []
    for k in range(order.min(), order.max() + 1):
        inside = order == k
        share = float(weighted[inside].sum() / weighted.sum())
        unweighted_share = float(square[inside].sum() / square.sum())
        octave = WavelengthOctave(
            from_um=EDGE_UM * 2.0**k,
            to_um=EDGE_UM * 2.0 ** (k + 1),
            energy_share=share,
            linear_share=shares.get(k),
            fall_db=_fall_db(sound, own_factor, share, unweighted_share, shares.get(k)),
        )
        octaves.append(octave)
    return octaves


def _order(length_um: Array) -> Array:
    """Return the numbers of the octaves that hold wavelengths [um]."""
    return np.floor(np.log2(length_um / EDGE_UM)).astype(int)


def _fall_db(
    sound: ContactSound, own_factor: bool, share: float, plain: float, linear: float | None
) -> float | None:
    """Return the fall of LAeq without the A- and Z-weighted shares of an octave [dB]."""
    if sound.source == "vibration" and linear is not None:
        share *= linear  # only the linear share goes with the waves
    if share >= 1 - _ALL:
        return None
    fall = 0.0 - 10 * math.log10(1 - share)  # never -0.0
    if sound.source == "release" and own_factor:
        # Its own factor makes p^2 proportional to the rms of the power: half of the fall.
        if plain >= 1 - _ALL:
            return None
        fall += 5 * math.log10(1 - plain)
    return fall


def linear_shares(
    heights: Array,
    approach: Array,
    track: Track,
    spacing: float,
    start: float,
    semi_axes: tuple[float, float],
) -> dict[int, float]:
    """Return the coherence of surface and approach by octave; empty unless a lap is solved.

    Parameters
    ----------
    heights : (nodes along, nodes across) array, m
        Heights of the surface.
    approach : (positions,) array, m
        Approach of the solved positions under the constant load.
    track : Track
        Positions of the ball.
    spacing : float, m
        Distance of the nodes.
    start : float, m
        First position along the surface.
    semi_axes : pair of float, m
        Semi-axes of the smooth contact along and across the track.
    """
    # To first order the approach under a constant load is the mean of the heights under the
    # pressure, for which Hertz's pressure stands.
    count = len(heights)
    lap = round(count * spacing / track.step)
    closes = track.closed and track.lap_steps == lap < len(approach)
    if track.turn_nodes or not closes or abs(lap * track.step / spacing - count) > 1e-6:
        return {}
    along_m, across_m = semi_axes
    length = along_m / spacing
    width = across_m / spacing
    middle = heights.shape[1] // 2
    reach = int(width)
    along = np.fft.fftfreq(count, 1 / count)
    mean = np.zeros(count // 2 + 1, dtype=complex)
    for k in range(-reach, reach + 1, 1 + (2 * reach + 1) * count // _MAX_NODES):
        weight = np.sqrt(np.clip(1 - (along / length) ** 2 - (k / width) ** 2, 0, None))
        line = heights[:, (middle + k) % heights.shape[1]]
        mean += np.fft.rfft(line) * np.fft.rfft(weight)
    actual = np.fft.rfft(approach[:lap])
    waves = np.arange(1, min(len(mean), len(actual)))
    begin = start / (count * spacing)  # of the steps, in laps
    mean = mean[waves] * np.exp(2j * np.pi * begin * waves)
    actual = actual[waves]
    order = _order(1e6 * count * spacing / waves)
    shares = {}
    for k in np.unique(order):
        x = mean[order == k]
        y = actual[order == k]
        powers = float(np.vdot(x, x).real * np.vdot(y, y).real)
        if len(x) >= _MIN_LINES and powers > 0:
            shares[int(k)] = float(abs(np.vdot(x, y)) ** 2 / powers)
    return shares


_HALF_BAND = 10**0.05  # from the middle of a third octave to its edges


def wavelength_bands(profiles: Array, spacing: float, closed: bool) -> tuple[Array, Array]:
    """Return wavelengths [m] and levels [dB re 1 um] of profiles along the track, in third octaves.

    The wavelengths descend, and the lines of profiles have their mean. The level is NaN for a band
    without a line or without roughness.

    Parameters
    ----------
    profiles : (n,) or (n, lines) array, m
        Heights along the track, of one line or several.
    spacing : float, m
        Distance of the heights.
    closed : bool
        If true, the end leads to the beginning. Otherwise a straight line is removed, and the
        ends are faded.
    """
    heights = profiles.reshape(len(profiles), -1)
    count = len(heights)
    if not closed:
        t = np.linspace(-1.0, 1.0, count)[:, None]
        heights = heights - heights.mean(axis=0)
        heights = heights - t * (np.sum(t * heights, axis=0) / np.sum(t**2))
        heights = heights * np.hanning(count)[:, None] * np.sqrt(8 / 3)
    lines = np.abs(np.fft.rfft(heights, axis=0)) ** 2 / count**2
    lines[1 : (count + 1) // 2] *= 2
    wave_number = np.fft.rfftfreq(count, spacing)[1:]
    mean_square = lines[1:].mean(axis=1)
    first = np.round(10 * np.log10(wave_number[0]))
    last = np.floor(10 * np.log10(wave_number[-1] / _HALF_BAND))
    middle = 10 ** (np.arange(first, last + 1) / 10)
    edges = np.append(middle / _HALF_BAND, middle[-1] * _HALF_BAND)
    band = np.searchsorted(edges, wave_number, side="right") - 1
    inside = (band >= 0) & (band < len(middle))
    sums = np.bincount(band[inside], mean_square[inside], len(middle))
    return 1 / middle, 10 * np.log10(np.where(sums > 0, sums, np.nan) / 1e-12)
