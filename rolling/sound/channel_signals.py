"""Signals of transducers: the contact force in, motion of plate, ball or the blocked force out.

All signals are fluctuations about the rest under the load, within hearing, at the samples of the
sound. Plate and ball count their motion in the direction in which the ball presses the plate.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics import resampling, wav
from acoustics.arrays import Array, short_repr
from acoustics.bands import AUDIBLE_HZ
from acoustics.radiation import ThinPlate
from acoustics.rectangular_plate import MODES_HZ, RectangularPlate
from rolling.contact.track import Motion, Travel
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.motion import BodyMotion
from rolling.dynamics.motion_of_ball import contact_path, motion_on_rigid_plate
from rolling.sound.contact_sound import faded_out
from rolling.sound.edged_sound import WRAPPED
from rolling.sound.receivers import Transducer
from rolling.sound.vibration_sound import Vibration, force_fluctuation

Complex = NDArray[np.complex128]
_DERIVATIVES = {"displacement": 0, "velocity": 1, "acceleration": 2}
_MIN_S = 0.25  # [s] of an open record with silence, at least twice
_BLOCK = 2**21  # values of modes in time or frequency at once
_TABLE = 48  # frequencies at which the remainder of the modes beyond MODES_HZ is computed
_NODES = 5000  # of its integral over wave numbers


class ChannelSignal(NamedTuple):
    """Samples of a channel, in SI units, and how its record ends.

    samples : (samples,) array. Fluctuation about the rest, at the rate of the sound.
    closed : bool. Whether the record repeats without a click; otherwise it is faded.
    note : str. What the reader of the levels must know; empty if nothing.
    """

    samples: Array
    closed: bool
    note: str = ""


def channel_signals(
    bodies: BallOnPlate, travel: Travel, vibration: Vibration, transducers: Sequence[Transducer]
) -> list[ChannelSignal]:
    """Return the signal of each transducer on bodies that vibrate."""
    signals = []
    driving = None
    blocked = None
    for transducer in transducers:
        if transducer.quantity == "force":
            signals.append(ChannelSignal(vibration.force, vibration.closed))
            continue
        if transducer.quantity == "blocked_force":
            if blocked is None:
                blocked = _blocked_force(bodies, travel, vibration)
            signals.append(blocked)
            continue
        if driving is None:
            driving = _Driving.of_motion(bodies, vibration)
        if transducer.of == "ball":
            displacement = _ball_displacement(bodies, driving)
        else:
            assert transducer.place_m is not None  # the transducer is on the plate
            displacement = _plate_displacement(bodies, travel.motion, driving, transducer.place_m)
        samples = driving.in_time(displacement, _DERIVATIVES[transducer.quantity])
        signals.append(ChannelSignal(samples, vibration.closed))
    return signals


# ---- the force that drives


@dataclass(frozen=True)
class _Driving:
    """Contact force of a record and its lines, those of an open record with silence behind.

    Waves of an open record that fall with time by `growth` [1/s] do not wrap round; frequencies are
    complex then, and the record is raised again.
    """

    __repr__ = short_repr

    force: Array  # (samples,) [N]
    closed: bool
    growth: float
    lines: int  # samples of the transform
    frequency: Complex  # of the lines that are computed [Hz]
    numbers: NDArray[np.int64]  # of these lines

    @classmethod
    def of_motion(cls, bodies: BallOnPlate, vibration: Vibration) -> "_Driving":
        """Return the force of the motion of a run."""
        fluctuation = force_fluctuation(bodies, vibration.motion, vibration.closed)
        samples = len(vibration.force)
        force = resampling.resample_closed(fluctuation, samples)
        rate = wav.SAMPLE_RATE_HZ
        n = samples
        growth = 0.0
        if not vibration.closed:
            from scipy.fft import next_fast_len  # slow to import

            n = int(next_fast_len(2 * max(samples, round(_MIN_S * rate)), real=True))
            growth = -math.log(WRAPPED) * rate / n
        frequency = np.asarray(np.fft.rfftfreq(n, 1 / rate) - 0.5j * growth / np.pi, dtype=complex)
        numbers = np.arange(len(frequency))
        if vibration.closed:
            real = frequency.real
            numbers = numbers[(real >= AUDIBLE_HZ[0]) & (real < AUDIBLE_HZ[1])]
        return cls(
            force=force,
            closed=vibration.closed,
            growth=growth,
            lines=n,
            frequency=frequency[numbers],
            numbers=numbers,
        )

    def spectrum(self, share: Array | float = 1.0) -> Complex:
        """Return the lines of the force [N], times a share of it at each sample."""
        times = np.arange(len(self.force)) / wav.SAMPLE_RATE_HZ
        fallen = self.force * share * np.exp(-self.growth * times)
        return np.asarray(np.fft.rfft(fallen, self.lines)[self.numbers])

    def in_time(self, displacement: Complex, derivatives: int) -> Array:
        """Return a derivative of a displacement [m] by its lines, at the samples of the sound."""
        samples = len(self.force)
        rate = wav.SAMPLE_RATE_HZ
        record = np.zeros(self.lines // 2 + 1, dtype=complex)
        record[self.numbers] = displacement * (2j * np.pi * self.frequency) ** derivatives
        if self.closed:
            return np.asarray(np.fft.irfft(record, self.lines))
        times = np.arange(samples) / rate
        raised = np.fft.irfft(record, self.lines)[:samples] * np.exp(self.growth * times)
        return resampling.band_limit(faded_out(raised, samples / rate), rate)


# ---- ball and plate


def _ball_displacement(bodies: BallOnPlate, driving: _Driving) -> Complex:
    """Return the displacement of the ball [m] at the lines: M z.. = W - F."""
    square = np.square(2j * np.pi * driving.frequency)
    return np.asarray(-driving.spectrum() / (bodies.mass_kg * square))


def _plate_displacement(
    bodies: BallOnPlate, motion: Motion, driving: _Driving, place: tuple[float, float]
) -> Complex:
    """Return the displacement of the plate [m] at a place [m], at the lines."""
    rectangle = bodies.plate.with_edges
    if rectangle is not None:
        return _on_edged_plate(bodies, rectangle, motion, driving, np.array([place]))
    infinite = bodies.plate.bending
    assert infinite is not None  # a plate with a transducer bends
    mobility = transfer_mobility(infinite, driving.frequency, math.hypot(*place))
    return np.asarray(mobility * driving.spectrum() / (2j * np.pi * driving.frequency))


def transfer_mobility(plate: ThinPlate, frequency_hz: Complex, distance_m: float) -> Complex:
    """Return the velocity of an infinite plate per force [m/(N s)] at a distance from the force.

    It is Y (H0(k r) - H0(-i k r)) for phasors of exp(i w t), with Hankel functions of the second
    kind, the mobility Y at the force, and the wave number k of bending waves, which the loss factor
    lowers by a quarter of itself in the imaginary part (Cremer, Heckl & Petersson, Structure-Borne
    Sound, 3rd ed. 2005, section 4.4).
    """
    from scipy.special import hankel2, kv  # slow to import

    if distance_m == 0:
        return np.full(frequency_hz.shape, plate.mobility_s_kg, dtype=complex)
    ratio = plate.mass_per_area_kg_m2 / plate.bending_stiffness_n_m
    wave_number = ratio**0.25 * np.sqrt(2 * np.pi * frequency_hz)
    loss = plate.loss_factor_at(frequency_hz.real)
    phase = wave_number * (1 - 0.25j * loss) * distance_m
    near_field = 2j / np.pi * kv(0, phase)  # H0 of the second kind at -i k r
    return np.asarray(plate.mobility_s_kg * (hankel2(0, phase) - near_field))


def _on_edged_plate(
    bodies: BallOnPlate, plate: RectangularPlate, motion: Motion, driving: _Driving, place: Array
) -> Complex:
    """Return the displacement [m] of a plate with edges at a place (1, 2) [m], at the lines."""
    path = contact_path(bodies.plate, motion)
    frequency = driving.frequency
    at_place = plate.shapes(place)[0]
    total = np.zeros(len(frequency), dtype=complex)
    modes = len(plate.angular_frequency)
    count = max(1, _BLOCK // max(len(frequency), len(driving.force)))
    blocks = [slice(first, min(first + count, modes)) for first in range(0, modes, count)]
    whole = driving.spectrum()
    if path is None:
        contact = bodies.plate.points_between_ends(1)
        at_contact = plate.shapes(contact)[0]
        for block in blocks:
            total += plate.mode_receptance(frequency, block) @ (at_contact * at_place)[block]
        total *= whole
    else:
        points = path(np.arange(len(driving.force)) / wav.SAMPLE_RATE_HZ)
        for block in blocks:
            receptance = plate.mode_receptance(frequency, block)
            shapes = plate.shapes(points, block)
            for column, shape in enumerate(at_place[block]):
                total += shape * receptance[:, column] * driving.spectrum(shapes[:, column])
        contact = points.mean(axis=0, keepdims=True)  # the remainder is that of the middle
    return total + remainder(plate, frequency, contact, place) * whole


def remainder(
    plate: RectangularPlate, frequency_hz: Complex, contact: Array, place: Array
) -> Complex:
    """Return the displacement per force [m/N] of the modes beyond MODES_HZ, between two points.

    They have the static compliance that the plate states at the contact. Its change with frequency
    and distance is that of the modes of an infinite plate, whose mean number per frequency is
    constant: with the ratios x of a frequency and t of a wave number to those at MODES_HZ,

        integral over t > 1 of 2 t J0(k r t) / (t^4 - x^2)
    """
    from scipy.special import j0  # slow to import

    reach = 2 * np.pi / plate.bending_wavelength_m(MODES_HZ)
    phase = reach * math.dist(np.ravel(contact), np.ravel(place))
    s = (np.arange(_NODES) + 0.5) / _NODES  # t^-2, over which the integrand is bounded
    shape = j0(phase / np.sqrt(s)) / _NODES
    x = np.linspace(0, AUDIBLE_HZ[1] / MODES_HZ, _TABLE)
    table = (shape / (1 - np.square(x[:, None] * s))).sum(axis=1)
    share = np.interp(frequency_hz.real / MODES_HZ, x, table)
    return np.asarray(plate.residual_compliance_m_n(contact) * share, dtype=complex)


# ---- blocked force


def _blocked_force(bodies: BallOnPlate, travel: Travel, vibration: Vibration) -> ChannelSignal:
    """Return the fluctuation of the contact force on a rigid plate."""
    motion = motion_on_rigid_plate(bodies, travel, vibration.law)
    closed = vibration.closed and bool(motion.settled)
    fluctuation = force_fluctuation(bodies, motion, closed)
    whole = resampling.resample_closed(fluctuation, len(vibration.force))
    samples = resampling.band_limit(whole, wav.SAMPLE_RATE_HZ)
    return ChannelSignal(samples, closed, _note_on_blocked_force(bodies, vibration, motion))


def _note_on_blocked_force(bodies: BallOnPlate, vibration: Vibration, motion: BodyMotion) -> str:
    """Say what is arbitrary in a blocked force that nothing damps; empty with a loss."""
    if bodies.contact_loss_factor or bodies.falls:
        return ""
    resonance = vibration.chain.resonance_hz
    note = (
        f"nothing damps the contact resonance at {resonance:.0f} Hz on a rigid plate, so the level"
        " there grows with the record and means nothing; plate.contact_loss_factor damps it"
    )
    if motion.flight_share > 0:
        note += f", and the ball flies for {100 * motion.flight_share:.3g} % of the time"
    return note
