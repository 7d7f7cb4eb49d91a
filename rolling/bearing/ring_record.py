"""Record of a bearing's ring: its motion and the loads of the balls, and what is read from it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics.arrays import Array, short_repr
from acoustics.impulsiveness import Kurtogram, pulse_kurtogram
from acoustics.ring_velocity import (
    VELOCITY_BANDS_HZ,
    NarrowSpectrum,
    VelocityBands,
    narrow_spectrum,
    squared_envelope_spectrum,
    velocity_bands,
)
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.ring_motion import RingMotion

RADIAL = "radial"
AXIAL = "axial"
DIRECTIONS = (RADIAL, AXIAL)
PLACES = 72  # around the bearing at which mean loads are stated
UM_S = 1e6  # micrometres per second in a metre per second
NOTHING_UM_S = 1e-3  # velocity below which nothing moves
AXIS = 2  # column of the motion along the axis


@dataclass(frozen=True, eq=False)
class RingRecord:
    """Motion of the ring that vibrates, at equal times, and the loads of the balls.

    Axes x and y are radial, z is axial; the middle of the load zone is at angle 0, on x. The cosine
    and the sine part of bending with two and with three waves around the ring may follow, and then
    its turns about x and y.

    Parameters
    ----------
    rate_hz : float, Hz
        Samples per second.
    velocity_m_s, acceleration_m_s2 : array (n, m), m/s, m/s2
        Motion of the ring.
    ball_load_n : array (n, balls), N
        Load of each ball.
    cage_hz : float, Hz
        Turns per second of the cage; ball 0 begins at angle 0.
    energy_error : float
        Energy that the balance lacks, over the energy that was exchanged [-].
    lost_contact_share : float
        Share of the time that a ball bears nothing, over all balls [-].
    sensor : float, rad, optional
        Angle of the place at which the radial motion is seen. Default: bands and spectra are means
        over all places by power, and signals are seen at angle 0.
    tilts : bool
        Whether the last two numbers of the motion are turns [rad/s, rad/s2].
    """

    __repr__ = short_repr

    rate_hz: float
    velocity_m_s: Array
    acceleration_m_s2: Array
    ball_load_n: Array
    cage_hz: float
    energy_error: float
    lost_contact_share: float
    sensor: float | None = None
    tilts: bool = False

    @property
    def duration_s(self) -> float:
        """Length of the record [s]."""
        return len(self.velocity_m_s) / self.rate_hz

    @cached_property
    def bands(self) -> dict[str, VelocityBands]:
        """Velocity in the three bands, radial and axial.

        The radial one is that at the sensor, or the mean over all places by power.
        """
        parts = [velocity_bands(row, self.rate_hz) for row in self._radial_parts]
        axial = velocity_bands(self.velocity_m_s[:, AXIS], self.rate_hz)
        rms = {}
        uncertainty_db = {}
        for name in VELOCITY_BANDS_HZ:
            squares = np.square([part.rms_m_s[name] for part in parts])
            rms[name] = math.sqrt(float(squares.sum()))
            # All parts feel the same balls, so their sum is no more certain than one.
            weights = squares / max(float(squares.sum()), np.finfo(float).tiny)
            each_db = np.array([part.uncertainty_db[name] for part in parts])
            uncertainty_db[name] = float(weights @ each_db)
        return {RADIAL: VelocityBands(rms, uncertainty_db), AXIAL: axial}

    @property
    def _radial_parts(self) -> list[Array]:
        """Velocities [m/s] whose mean squares add to that along the radius.

        The mean square over all places has half of that of x and y, and of each part of bending.
        """
        if self.sensor is not None:
            return [self.seen_velocity_m_s[:, 0]]
        return [self.velocity_m_s[:, column] / math.sqrt(2) for column in self.radial_columns]

    @property
    def radial_columns(self) -> list[int]:
        """Columns of the motion that move a place of the ring along its radius."""
        turns = 2 if self.tilts else 0
        return [0, 1, *range(AXIS + 1, self.velocity_m_s.shape[1] - turns)]

    @cached_property
    def seen_velocity_m_s(self) -> Array:
        """Velocity [m/s] at the sensor, a quarter of a turn beside it, and along the axis, (n, 3).

        For a sensor at angle 0 they are those along x, y and z.
        """
        return self._seen(self.velocity_m_s)

    @cached_property
    def seen_acceleration_m_s2(self) -> Array:
        """Acceleration [m/s2] at the same places, (n, 3)."""
        return self._seen(self.acceleration_m_s2)

    def _seen(self, motion: Array) -> Array:
        """Return what two places of the ring have of a motion along the radius, and the axis."""
        first = self.sensor or 0.0
        radial = motion[:, self.radial_columns]
        if not first and radial.shape[1] == 2:
            return motion[:, : AXIS + 1]
        orders = range(1, 1 + radial.shape[1] // 2)
        seen = []
        for place in (first, first + math.pi / 2):
            shapes = [(math.cos(order * place), math.sin(order * place)) for order in orders]
            seen.append(radial @ np.ravel(shapes))
        return np.stack([*seen, motion[:, AXIS]], axis=1)

    @cached_property
    def spectra(self) -> dict[str, NarrowSpectrum]:
        """Narrow spectra of the velocity [m/s], radial and axial."""
        parts = [narrow_spectrum(row, self.rate_hz) for row in self._radial_parts]
        axial = narrow_spectrum(self.velocity_m_s[:, AXIS], self.rate_hz)
        radial = np.sqrt(np.sum([np.square(part.rms) for part in parts], axis=0))
        return {RADIAL: NarrowSpectrum(axial.frequency_hz, radial), AXIAL: axial}

    def envelope(self, band_hz: tuple[float, float]) -> NarrowSpectrum:
        """Return the spectrum of the squared envelope of the velocity at the sensor in a band [Hz].

        A vibration pick-up stands at one place: by default at x, in the middle of the load zone.
        """
        return squared_envelope_spectrum(self.seen_velocity_m_s[:, 0], self.rate_hz, band_hz)

    def kurtogram(self, highest_hz: float, pulses_hz: float) -> Kurtogram:
        """Return in which band the velocity at the sensor has most of such frequent pulses."""
        return pulse_kurtogram(self.seen_velocity_m_s[:, 0], self.rate_hz, highest_hz, pulses_hz)

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


def record_of(
    motion: RingMotion, kinematics: Kinematics, sensor: float | None = None
) -> RingRecord:
    """Return what a run keeps of the motion of its ring, and where it is seen [rad].

    The filter of the motion undershoots where a ball lifts off; no ball bears less than nothing.
    """
    return RingRecord(
        rate_hz=motion.rate_hz,
        velocity_m_s=motion.velocity_m_s,
        acceleration_m_s2=motion.acceleration_m_s2,
        ball_load_n=np.maximum(motion.ball_load_n, 0.0),
        cage_hz=kinematics.cage_hz,
        energy_error=motion.energy_error,
        lost_contact_share=motion.lost_contact_share,
        sensor=sensor,
        tilts=motion.tilts,
    )
