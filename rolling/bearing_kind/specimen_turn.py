"""Turns of further specimens of a rough body: other heights of the same law, by linear response.

The linear response of contacts to the random heights of a law is a Gaussian process along the
track, whose covariance between contacts and loads is known from the law: it sums, over the waves
across the track, the power of a wave and how the contacts average it. A specimen is drawn from it
on all waves of a whole turn, so it has the waves that a body has, and not those of a stretch. The
gain of the march and its rest follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing import waves
from rolling.bearing_kind.contact_gain import ContactGain, contact_gain
from rolling.bearing_kind.rough_contacts import RoughContact
from rolling.scene.laws import Roughness
from rolling.surface import heights

BLOCK = 512  # waves along the track that are summed over those across at once, to save memory


@dataclass(frozen=True)
class RoughBody:
    """Rough surface of a body under all its contacts, of which specimens are drawn.

    covariance : array (waves, rows, rows), m2. Of the linear response at the waves 1, 2, ... of the
        marched track, between all loads of all contacts.
    gains : list of ContactGain. Of each contact.
    positions : int. Number of positions of the marched track.
    """

    __repr__ = short_repr

    covariance: Array
    gains: list[ContactGain]
    positions: int

    def turn(self, points: int, seed: int) -> Array:
        """Return the change of the approach [m] around a specimen, (rows, points), of zero mean.

        Equal seeds give equal phases and luck, so that bodies which differ by their law are heard
        on the same random numbers.

        Parameters
        ----------
        points : int
            Points around the body, at the distance of the marched positions.
        seed : int
            Number of the specimen.
        """
        count = (points + 1) // 2 - 1  # waves around the body below the shortest one
        places = np.arange(1, count + 1) * self.positions / points  # among those of the track
        random = np.random.default_rng(seed)
        luck = random.standard_normal((count, self.covariance.shape[1], 2)) @ [1, 1j]
        linear = (self._root_at(places) @ luck[:, :, None])[:, :, 0].T / np.sqrt(2)
        first = 0
        lines = []
        for gain in self.gains:
            end = first + len(gain.level)
            lines.append(gain.applied(linear[first:end], places, seed))
            first = end
        spectrum = np.zeros((first, points // 2 + 1), dtype=complex)
        spectrum[:, 1 : count + 1] = np.sqrt(points / self.positions) * np.concatenate(lines)
        return np.asarray(np.fft.irfft(spectrum, points, axis=1))

    def _root_at(self, places: Array) -> Array:
        """Return the symmetric root of the covariance between its waves, (places, rows, rows)."""
        position = np.clip(places - 1, 0, len(self.covariance) - 1)
        below = np.minimum(position.astype(int), len(self.covariance) - 2)
        share = (position - below)[:, None, None]
        between = (1 - share) * self.covariance[below] + share * self.covariance[below + 1]
        squares, directions = np.linalg.eigh(between)
        roots = np.sqrt(np.maximum(squares, 0.0))[:, None, :]
        return np.asarray((directions * roots) @ np.swapaxes(directions, 1, 2))


def rough_body(contacts: Sequence[RoughContact], rows: Sequence[Array]) -> RoughBody:
    """Return the rough surface of a body from the marches of its contacts.

    Parameters
    ----------
    contacts : sequence of RoughContact
        Contacts with one surface, on one grid.
    rows : sequence of arrays (loads, positions), m
        Change of the approach of each, as of `joined_tracks.rough_rows`.
    """
    return RoughBody(
        covariance=linear_covariance(contacts),
        gains=[contact_gain(contact, row) for contact, row in zip(contacts, rows, strict=True)],
        positions=contacts[0].steps,
    )


def linear_covariance(contacts: Sequence[RoughContact]) -> Array:
    """Return the covariance of the linear response of contacts with one surface.

    Parameters
    ----------
    contacts : sequence of RoughContact
        Contacts with one random surface, on one grid.

    Returns
    -------
    array (waves, rows, rows), m2
        Mean product of the Fourier sums over the positions of the track, at the waves 1, 2, ...
        along it, between all loads of all contacts.
    """
    scene = contacts[0].scene
    law = scene.surface.law
    assert isinstance(law, Roughness)  # the law of a body that turns
    shape = scene.track.n_along, scene.track.n_across
    density = heights.spectral_density(shape, scene.spacing, law.in_si)
    count = min(contacts[0].steps // 2, shape[0] // 2)
    along = 2 * np.pi * np.fft.rfftfreq(shape[0], scene.spacing)[1 : count + 1]
    across = 2 * np.pi * np.fft.rfftfreq(shape[1], scene.spacing)
    # A turned law has another density for waves that lean to the other side.
    both = (density[1 : count + 1] + density[: -count - 1 : -1]) / 2 * heights.wave_counts(shape)
    power = law.rq_m**2 * both * shape[0] / shape[1] / round(scene.step_nodes) ** 2
    covariance = []
    for first in range(0, count, BLOCK):
        block = slice(first, first + BLOCK)
        shares = []
        for contact in contacts:
            for load in contact.loads_n:
                axes = waves.semi_axes(contact.contact, load)
                phase = np.hypot(along[block, None] * axes.along, across * axes.across)
                shares.append(waves.response(phase))
        each = np.array(shares)
        covariance.append(np.einsum("ky,lky,mky->klm", power[block], each, each, optimize=True))
    return np.concatenate(covariance)
