"""Gain of a rough contact: what its march adds to its linear response, by waves along the track.

Heights change the approach of a nearly closed contact by their linear response L. Its rim opens
and closes, and adds a part E that L does not explain. Over the waves k of a march N

    N(k) = H(k) L(k) + E(k),    H = Re sum(conj(L) N) / sum(|L|^2),    S_E = mean(|N - H L|^2)

with sums over neighbouring waves. Neither H nor S_E over the power of N changes much between waves
that differ by a part of a wave in the length of a contact, so the sums are over many waves also
where a track holds few long ones. All waves count alike: they are divided by their smooth level
before. A ratio of powers would scatter by 3 to 11 dB from wave to wave, because a wave of L is
small by chance where the same wave of E is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from rolling.bearing import waves
from rolling.bearing_kind.rough_contacts import RoughContact

LEAST_LINES = 10  # to either side of a wave, over which its gain is estimated
PART_OF_CONTACT = 0.25  # of a wave in the length of a contact: the reach of a sum, where longer
THIRD_OCTAVE = 2 ** (1 / 6) - 2 ** (-1 / 6)  # its width over its middle: the reach of short waves
FEW = 2  # waves to either side over which a power is averaged before its logarithm is taken
GROUPS = 10  # of the waves, each of which is left out once to learn how the gain scatters
_REST = 3  # part of a seed, so that the rest differs from what it is added to
_FLOOR = 1e-26  # of the largest power of a wave, below which only rounding remains
Complexes = NDArray[np.complex128]
Places = NDArray[np.int64]


@dataclass(frozen=True)
class ContactGain:
    """How the march of a rough contact differs from its linear response.

    linear, marched : complex array (loads, waves). Waves 1, 2, ... along the track over the level.
    level : array (loads, waves), m. Smooth level of the waves.
    first, end : int arrays (waves,). The neighbours over which the sums at each wave go.
    """

    __repr__ = short_repr

    linear: Complexes
    marched: Complexes
    level: Array
    first: Places
    end: Places

    def coherent(self, left_out: int | None = None) -> Array:
        """Return the gain H of the linear response, (loads, waves), perhaps without a group."""
        linear_power = self._mean(np.abs(self.linear) ** 2, left_out)
        shared = self._mean((np.conj(self.linear) * self.marched).real, left_out)
        gain = np.ones_like(shared)
        np.divide(shared, linear_power, out=gain, where=linear_power > 0)
        return gain

    def rest_power(self, gain: Array, left_out: int | None = None) -> Array:
        """Return the power of what a gain (loads, waves) does not explain, over the level."""
        return self._mean(np.abs(self.marched - gain * self.linear) ** 2, left_out)

    def power_gain(self, left_out: int | None = None) -> Array:
        """Return the expected power of waves over that of their linear response, (loads, waves)."""
        gain = self.coherent(left_out)
        rest_power = self.rest_power(gain, left_out)
        linear_power = self._mean(np.abs(self.linear) ** 2)
        share = np.zeros_like(rest_power)
        np.divide(rest_power, linear_power, out=share, where=linear_power > 0)
        return gain**2 + share

    @property
    def marched_power(self) -> Array:
        """Smooth power of the march [m2], (loads, waves)."""
        return self.level**2 * self._mean(np.abs(self.marched) ** 2)

    def applied(self, linear: Complexes, places: Array, seed: int) -> Complexes:
        """Return the waves of a specimen [m] from those of its linear response.

        The rest is drawn at random, with the power and the coherence between loads of the march.

        Parameters
        ----------
        linear : complex array (loads, n), m
            Waves of the linear response.
        places : array (n,)
            Their places among the waves 1, 2, ... of the marched track.
        seed : int
            Seed of the rest.
        """
        random = np.random.default_rng((seed, _REST))
        number = np.arange(1, len(self.first) + 1)
        gain = self.coherent()
        gain_there = np.array([np.interp(places, number, row) for row in gain])
        level = np.exp([np.interp(places, number, row) for row in np.log(self.level)])
        # Each wave takes the rest of a neighbour at random, at its own level, with another phase.
        nearest = np.clip(np.rint(places).astype(int), 1, len(number)) - 1
        neighbour = random.integers(self.first[nearest], self.end[nearest])
        phase = np.exp(2j * np.pi * random.uniform(size=len(places)))
        rest = (self.marched - gain * self.linear)[:, neighbour]
        return np.asarray(gain_there * linear + level * rest * phase)

    def _mean(self, lines: Array, left_out: int | None = None) -> Array:
        """Return the mean of rows of waves over the neighbours of each wave."""
        kept = np.ones(lines.shape[1])
        if left_out is not None:
            kept[left_out::GROUPS] = 0.0
        return _mean_between(lines, self.first, self.end, kept)


def contact_gain(contact: RoughContact, marched_rows: Array) -> ContactGain:
    """Return the gain of a rough contact from its march.

    Parameters
    ----------
    contact : RoughContact
        Contact, whose linear response is known.
    marched_rows : array (loads, positions), m
        Changes of its approach along the closed track, as of `joined_tracks.rough_rows`.
    """
    positions = marched_rows.shape[1]
    linear = np.fft.rfft(contact.own_linear_rows, axis=1)[:, 1:]
    marched = np.fft.rfft(marched_rows, axis=1)[:, 1:]
    length = positions * contact.scene.step
    axes = waves.semi_axes(contact.contact, contact.middle_load_n)
    contacts = length / (2 * axes.along)  # waves of the length of a contact
    number = np.arange(1, linear.shape[1] + 1)
    reach = np.maximum(max(LEAST_LINES, PART_OF_CONTACT * contacts), THIRD_OCTAVE / 2 * number)
    first, end = _neighbours(number, np.rint(reach))
    level = _level(np.abs(linear) ** 2 + np.abs(marched) ** 2, first, end)
    return ContactGain(
        linear=linear / level,
        marched=marched / level,
        level=level,
        first=first,
        end=end,
    )


def _neighbours(number: Array, reach: Array) -> tuple[Places, Places]:
    """Return the first neighbour of each wave 1, 2, ... up to a reach, and that behind the last."""
    first = np.maximum(number - 1 - reach, 0).astype(np.int64)
    return first, np.minimum(number + reach, len(number)).astype(np.int64)


def _level(power: Array, first: Places, end: Places) -> Array:
    """Return the smooth level of waves by the logarithmic mean of their power over neighbours.

    A steep spectrum is followed so, where a plain mean would be that of its largest neighbours.
    """
    few = _neighbours(np.arange(1, power.shape[1] + 1), np.array(float(FEW)))
    floor = np.maximum(_FLOOR * power.max(axis=1, keepdims=True), np.finfo(float).tiny)
    kept = np.ones(power.shape[1])
    logarithm = np.log(np.maximum(_mean_between(power, *few, kept), floor))
    return np.asarray(np.exp(0.5 * _mean_between(logarithm, first, end, kept)))


def _mean_between(lines: Array, first: Places, end: Places, kept: Array) -> Array:
    """Return the mean of rows of lines from a first one to before an end; `kept` is 1 or 0."""
    sums = np.cumsum(np.pad(lines * kept, ((0, 0), (1, 0))), axis=1)
    counts = np.cumsum(np.pad(kept, (1, 0)))
    number = np.maximum(counts[end] - counts[first], 1.0)
    return np.asarray((sums[:, end] - sums[:, first]) / number)
