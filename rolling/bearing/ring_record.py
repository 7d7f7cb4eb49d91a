"""Record of a bearing's ring: its motion and the loads of the balls, and what is read from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics.arrays import Array, short_repr
from acoustics.ring_velocity import (
    VELOCITY_BANDS_HZ,
    NarrowSpectrum,
    VelocityBands,
    narrow_spectrum,
    squared_envelope_spectrum,
    velocity_bands,
)

RADIAL = "radial"
AXIAL = "axial"
DIRECTIONS = (RADIAL, AXIAL)
PLACES = 72  # around the bearing at which mean loads are stated
UM_S = 1e6  # micrometres per second in a metre per second
NOTHING_UM_S = 1e-3  # velocity below which nothing moves


@dataclass(frozen=True, eq=False)
class RingRecord:
    """Motion of the ring that vibrates, at equal times, and the loads of the balls.

    Axes x and y are radial, z is axial; the middle of the load zone is at angle 0, on x.

    Parameters
    ----------
    rate_hz : float, Hz
        Samples per second.
    velocity_m_s, acceleration_m_s2 : array (n, 3), m/s, m/s2
        Motion of the ring.
    ball_load_n : array (n, balls), N
        Load of each ball.
    cage_hz : float, Hz
        Turns per second of the cage; ball 0 begins at angle 0.
    energy_error : float
        Energy that the balance lacks, over the energy that was exchanged [-].
    lost_contact_share : float
        Share of the time that a ball bears nothing, over all balls [-].
    """

    __repr__ = short_repr

    rate_hz: float
    velocity_m_s: Array
    acceleration_m_s2: Array
    ball_load_n: Array
    cage_hz: float
    energy_error: float
    lost_contact_share: float

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return len(self.velocity_m_s) / self.rate_hz

    @cached_property
    def bands(self) -> dict[str, VelocityBands]:
        """Velocity in the three bands, radial and axial.

        The radial one is the mean over all radial directions, by power.
        """
        x, y, axial = (velocity_bands(row, self.rate_hz) for row in self.velocity_m_s.T)
        rms = {}
        uncertainty_db = {}
        for name in VELOCITY_BANDS_HZ:
            squares = np.square([x.rms_m_s[name], y.rms_m_s[name]])
            rms[name] = math.sqrt(float(squares.mean()))
            # Both directions feel the same balls, so their mean is no more certain than one.
            weights = squares / max(float(squares.sum()), np.finfo(float).tiny)
            both_db = np.array([x.uncertainty_db[name], y.uncertainty_db[name]])
            uncertainty_db[name] = float(weights @ both_db)
        return {RADIAL: VelocityBands(rms, uncertainty_db), AXIAL: axial}

    @cached_property
    def spectra(self) -> dict[str, NarrowSpectrum]:
        """Narrow spectra of the velocity [m/s], radial and axial."""
        x, y, axial = (narrow_spectrum(row, self.rate_hz) for row in self.velocity_m_s.T)
        radial = np.sqrt((np.square(x.rms) + np.square(y.rms)) / 2)
        return {RADIAL: NarrowSpectrum(x.frequency_hz, radial), AXIAL: axial}

    @cached_property
    def envelope(self) -> NarrowSpectrum:
        """Spectrum of the squared envelope of the velocity along x, from 1,800 to 10,000 Hz.

        A vibration pick-up stands at one place, so this is one direction: that of the load.
        """
        return squared_envelope_spectrum(self.velocity_m_s[:, 0], self.rate_hz)

    def loads_around(self, places: int) -> Array:
        """Return the mean load of a ball at each angle [N], (places,); NaN where none has been."""
        balls = self.ball_load_n.shape[1]
        time_s = np.arange(len(self.ball_load_n)) / self.rate_hz
        turns = self.cage_hz * time_s[:, None] + np.arange(balls) / balls
        place = np.floor((turns * places + 0.5) % places).astype(int)
        sums = np.bincount(place.ravel(), self.ball_load_n.ravel(), places)
        counts = np.bincount(place.ravel(), minlength=places)
        means = np.full(places, np.nan)
        np.divide(sums, counts, out=means, where=counts > 0)
        return means
