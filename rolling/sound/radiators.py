"""Bodies that a vibration makes heard: sound power, and levels by a linear chain.

Sphere, contact and plate are a chain of linear bodies that the approach under the constant load
moves. It gives the comb of a looped record, in which a sharp resonance falls on a line or between
two, and the level of the vibration that a run without dynamics leaves out.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics import level, wav
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, EDGES_HZ, MID_HZ, third_octave_mean_square
from acoustics.loss_factors import least_loss_factor
from acoustics.plate_modes import FREE
from acoustics.radiation import Body, ThinPlate, axis_transfer
from acoustics.sound_power import band_power
from acoustics.spectrum import audible_lines, audible_phasors
from acoustics.unbaffled import baffle_uncertainty_db
from acoustics.uncertainty import uncertainty_of_lines_db
from acoustics.weighting import a_weighting_db
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate, PlateBody
from rolling.dynamics.bodies import Chain
from rolling.dynamics.comb import Comb, speeds_of_comb, spread_db
from rolling.dynamics.force_law import ForceLaw
from rolling.sound import edged_sound
from rolling.sound.contact_sound import faded
from rolling.sound.error_estimate import Gain
from rolling.sound.receivers import Listener


def sources(bodies: BallOnPlate, listener: Listener) -> list[Body]:
    """Return the bodies that a listener hears."""
    radiating: list[Body] = [bodies.plate.ground]
    if listener.hears_ball:
        radiating.append(bodies.ball)
    return radiating


def powers(bodies: BallOnPlate, force: Array, highest: float) -> tuple[Array, Array]:
    """Return the sound power [W] of plate and sphere in third octaves."""
    ground = bodies.plate.ground
    rate = wav.SAMPLE_RATE_HZ
    of_ball = band_power(force, rate, bodies.ball)
    plate = np.full(len(of_ball), np.nan)
    rectangle = bodies.plate.with_edges
    if rectangle is not None:
        frequency, square = audible_lines(force, rate)
        points = edged_sound.points_on_path(bodies.plate)
        power = edged_sound.power_per_force(rectangle, points, frequency)
        plate = third_octave_mean_square(frequency, square * power)
    elif isinstance(ground, ThinPlate):
        plate = band_power(force, rate, ground)
        if not ground.loss_factor:  # it decides the power above coincidence
            plate[EDGES_HZ[1:] > ground.critical_hz] = np.nan
    known = known_bands(highest)
    return np.where(known, plate, np.nan), np.where(known, of_ball, np.nan)


def known_bands(highest: float) -> Array:
    """Return which bands lie below a highest frequency [Hz], a (31,) array of bool."""
    return np.asarray(EDGES_HZ[1:] <= min(highest, wav.SAMPLE_RATE_HZ / 2))


def roughness_transfers(
    bodies: BallOnPlate, listener: Listener, chain: Chain
) -> Callable[[Array], NDArray[np.complex128]]:
    """Return the transfer [Pa/m] from an approach under the constant load to the pressure.

    Sphere, contact and plate are a linear chain. The transfer has a row for each contact point on a
    plate with edges, and a single row otherwise, (contact points, frequencies).
    """
    rectangle = bodies.plate.with_edges
    radiating = sources(bodies, listener)

    def transfers(frequency: Array) -> NDArray[np.complex128]:
        """Return the rows at frequencies [Hz]; the roughness is minus the approach."""
        force = chain.force(frequency, np.full(len(frequency), -1.0))
        if rectangle is not None:
            return edged_sound.transfers(bodies, listener, rectangle, frequency) * force
        on_axis = sum(axis_transfer(frequency, body, listener.distance_m) for body in radiating)
        return np.atleast_2d(on_axis * force)

    return transfers


def roughness_gain(bodies: BallOnPlate, listener: Listener, chain: Chain) -> Gain:
    """Return the power gain [Pa2/m2] of `roughness_transfers`, as a mean over contact points.

    With the stiffness of a smooth contact it serves for ratios of powers, in which an error of the
    stiffness cancels.
    """
    transfers = roughness_transfers(bodies, listener, chain)

    def gain(frequency: Array) -> Array:
        return np.asarray(np.mean(np.square(np.abs(transfers(frequency))), axis=0))

    return gain


def comb(law: ForceLaw, chain: Chain, bodies: BallOnPlate, gain: Gain, speed: float) -> Comb | None:
    """Return the levels over other speeds; None where a resonance holds several lines.

    `gain` is that of `roughness_gain`, and `speed` [m/s] the maximum along the track.
    """
    if law.period_m is None:
        return None
    approach = law.approach(law.position_m, bodies.load_n)
    lines: Array = 2 * np.square(np.abs(np.fft.rfft(approach)[1:] / len(approach)))

    def weighted(frequency: Array) -> Array:
        """Return the A-weighted gain of lines."""
        return np.asarray(10 ** (a_weighting_db(frequency) / 10) * gain(frequency))

    speeds = speeds_of_comb(
        chain=chain,
        lines=lines,
        line_hz=speed / law.period_m,
        loss_factor=least_loss_factor(bodies.plate.loss_factor or 0.0),
        gain=weighted,
    )
    if speeds is None:
        return None
    bands = np.array(
        [third_octave_mean_square(at.frequency_hz, lines[at.audible] * at.gain) for at in speeds]
    )
    sums = bands.sum(axis=1)
    if not sums.min() > 0:  # no line is heard
        return None
    return Comb(
        spread_db=spread_db(sums),
        mean_laeq_db=level.level_db(float(sums.mean())),
        band_spread_db=np.array([spread_db(band) for band in bands.T]),
    )


PLACES = 8  # usual number of places between two lines of a record at which a resonance may lie
MAX_PLACES = 512  # maximum number of these places
FEWEST_POSITIONS = 5  # of an approach of which an estimate is made
MAX_GAINS = 400_000  # maximum number of places of all lines together
DENSE = 4.0  # samples of an approach in a period of the highest audible frequency, at least
# Standard uncertainties of the estimate by tests/benchmarks/vibration_estimate_study.py: of the
# stiffness, relative, and of the linear chain.
STIFFNESS_ERROR = 0.06
LINEAR_DB = 0.5
# Uncertainty over the decibels between the local and the mean stiffness, over those that lie above
# the Nyquist frequency of the steps, and over the change by a loss in the contact.
HALF = 0.5
# Loss factor that a contact may have of which nobody measured it: no published value is known.
UNKNOWN_LOSS = 0.02


class ContactLoss(NamedTuple):
    """Changes of levels by a loss factor UNKNOWN_LOSS of the contact in the place of none.

    laeq_db : float, dB. Change of LAeq.
    third_octave_db : (31,) array, dB. Change of each third octave; 0 in a silent one.
    """

    laeq_db: float
    third_octave_db: Array


def contact_loss(
    law: ForceLaw, chain: Chain, bodies: BallOnPlate, gain: Gain, motion: Motion
) -> ContactLoss | None:
    """Return how a loss of the contact would change the levels, by the linear chain.

    `gain` is that of `roughness_gain`. None where the loss is not in doubt: a loss factor is
    stated, the sphere falls, or nothing is heard.
    """
    if bodies.contact_loss_factor is not None or bodies.falls or bodies.is_smooth:
        return None
    closed = law.period_m is not None
    approach = law.approach(law.position_m, bodies.load_n)
    if closed:
        approach = np.append(approach, approach[0])
    lines = approach_lines(motion, approach, law.spacing_m, closed)
    frequency = lines.frequency
    mean_square = lines.mean_square
    if not mean_square.sum() > 0:
        return None
    points = _places_of_resonance(chain, frequency, 1 / lines.duration)
    gains = gain(points.ravel()).reshape(points.shape)
    without = mean_square * gains.mean(axis=1)
    ratio = force_gain(replace(chain, contact_loss_factor=UNKNOWN_LOSS), points)
    ratio /= force_gain(chain, points)
    with_loss = mean_square * (gains * ratio).mean(axis=1)
    weights = 10 ** (a_weighting_db(frequency) / 10)
    bands = third_octave_mean_square(frequency, without)
    damped_bands = third_octave_mean_square(frequency, with_loss)
    has_sound = bands > 0
    changes = np.zeros(len(bands))
    changes[has_sound] = 10 * np.log10(damped_bands[has_sound] / bands[has_sound])
    return ContactLoss(
        laeq_db=10 * math.log10(float(weights @ with_loss) / float(weights @ without)),
        third_octave_db=changes,
    )


class BaffleSpread(NamedTuple):
    """Standard uncertainties of levels of a free plate, which has no baffle.

    laeq_db : float, dB. Of LAeq.
    third_octave_db : (31,) array, dB. Of each third octave.
    """

    laeq_db: float
    third_octave_db: Array


def baffle_spread(plate: PlateBody, weighted_square: Array) -> BaffleSpread | None:
    """Return what the missing baffle leaves on the levels of a free plate; None for others.

    The third octaves change in the same sense, so their spreads are added by their share of the
    A-weighted mean squares (31,).
    """
    bands = baffle_bands_db(plate)
    whole = float(weighted_square.sum())
    if bands is None or not whole > 0:
        return None
    return BaffleSpread(
        laeq_db=float(weighted_square @ bands) / whole,
        third_octave_db=bands,
    )


def baffle_bands_db(plate: PlateBody) -> Array | None:
    """Return the uncertainty of third octaves of a free plate (31,) [dB]; None for others."""
    rectangle = plate.with_edges
    if rectangle is None or set(plate.edges) != {FREE}:
        return None
    area = rectangle.length_m * rectangle.width_m
    return baffle_uncertainty_db(MID_HZ, area, rectangle.critical_hz)


def _places_of_resonance(chain: Chain, frequency: Array, width: float) -> Array:
    """Return frequencies [Hz] around each line, dense enough for the resonance of the contact."""
    sharp = chain.resonance_hz / chain.quality
    most = max(1, min(MAX_PLACES, MAX_GAINS // len(frequency)))
    count = MAX_PLACES if sharp == 0 else math.ceil(PLACES * width / sharp)
    return _spread_over_intervals(frequency, min(count, most), width)


def _spread_over_intervals(frequency: Array, count: int, width: float) -> Array:
    """Return `count` frequencies in the interval [Hz] of each line, (lines, count)."""
    offsets = ((np.arange(count) + 0.5) / count - 0.5) * width
    return np.asarray(np.maximum(frequency[:, None] + offsets, 1.0))


class VibrationEstimate(NamedTuple):
    """Level of the vibration that a run without dynamics leaves out, by a linear chain.

    laeq_db : float or None, dB. LAeq; None where the approach does not fluctuate within hearing.
    parts_db : dict, dB. Parts of the standard uncertainty of LAeq by source, while contact holds.
    force_ratio : float. Rms of the contact force over the load.
    contact_loss_db : float, dB. Change of LAeq by a loss factor UNKNOWN_LOSS of the contact, half
        of which is in the uncertainty; 0 where the scene states a loss factor.
    stiffness_n_m : float, N/m. Mean stiffness of the contact, with which the estimate is heard.
    """

    laeq_db: float | None
    parts_db: dict[str, float]
    force_ratio: float
    contact_loss_db: float
    stiffness_n_m: float

    @property
    def uncertainty_db(self) -> float | None:
        """Standard uncertainty of LAeq [dB], as far as contact holds; None without a level."""
        return None if self.laeq_db is None else math.hypot(*self.parts_db.values())


def vibration_estimate(
    bodies: BallOnPlate,
    listener: Listener,
    motion: Motion,
    approach: Array,
    step: float,
    closed: bool,
    stiffness_n_m: Array | float,
) -> VibrationEstimate:
    """Estimate the LAeq of the vibration, its uncertainty, and the fluctuation of the force.

    The sphere meets the same approach as in a run with dynamics: splines join the positions, so
    that the band ends where that of the run does.

    Parameters
    ----------
    bodies : BallOnPlate. Ball and plate.
    listener : Listener. Listener of the vibration.
    motion : Motion. Distance and speed over time.
    approach : (steps + 1,) array, m. Approach under the constant load at the ends of the steps.
    step : float, m. Length of a step.
    closed : bool. If true, the steps are whole laps of the track.
    stiffness_n_m : (positions,) array or float, N/m. Stiffness of the contact at positions along
        the track.
    """
    stiffness = np.atleast_1d(stiffness_n_m)
    mean_stiffness = float(1 / np.mean(1 / stiffness))
    moved = None
    if not bodies.is_smooth and len(approach) >= FEWEST_POSITIONS:
        chain = bodies.chain(mean_stiffness)
        moved = chain_at_lines(bodies, listener, chain, motion, approach, step, closed)
    if moved is None:
        return VibrationEstimate(
            laeq_db=None,
            parts_db={},
            force_ratio=0.0,
            contact_loss_db=0.0,
            stiffness_n_m=mean_stiffness,
        )
    lines = moved.lines
    chain = moved.chain
    points = moved.points
    mean_square = lines.mean_square
    resolved_hz = motion.fastest(lines.duration) / (2 * step)
    forces = force_gain(chain, points)
    gain = moved.gain * mean_square[:, None] * 10 ** (a_weighting_db(points) / 10) / forces

    def weighted_squares(stiffnesses: Array) -> Array:
        """Return A-weighted mean squares of the lines at their places, as a mean over chains."""
        forces = np.zeros_like(points)
        for value in stiffnesses:
            forces += force_gain(bodies.chain(float(value)), points)
        return np.asarray(gain * forces / len(stiffnesses))

    def squares_at(factor: float) -> Array:
        """Return the A-weighted mean square at each place, for a multiple of the mean stiffness."""
        return np.asarray(weighted_squares(np.array([factor * mean_stiffness])).sum(axis=0))

    of_lines = weighted_squares(np.array([mean_stiffness]))
    at_mean = of_lines.sum(axis=0)
    softer = squares_at(1 - STIFFNESS_ERROR)
    stiffer = squares_at(1 + STIFFNESS_ERROR)
    mean = float(at_mean.mean())
    # The resonance follows the stiffness along the track where it changes slowly, and the mean
    # stiffness where it changes within a period. The level lies between both.
    local = weighted_squares(stiffness)
    following = float(local.sum(axis=0).mean())
    within = float(local[lines.frequency < resolved_hz].sum(axis=0).mean())
    contact_loss_db = 0.0
    if bodies.contact_loss_factor is None:
        damped = replace(chain, contact_loss_factor=UNKNOWN_LOSS)
        with_loss = (gain * force_gain(damped, points)).sum(axis=0).mean()
        contact_loss_db = 10 * math.log10(float(with_loss) / mean)
    parts_db = {
        "chain": LINEAR_DB,
        "stiffness": max(_apart_db(float(x.mean()), mean) for x in (softer, stiffer)),
        "stiffness_changes": HALF * _apart_db(following, mean),
        "band": HALF * _apart_db(within, following),
        "contact_loss": HALF * abs(contact_loss_db),
    }
    return VibrationEstimate(
        laeq_db=level.level_db(math.sqrt(mean * following)),
        parts_db=parts_db | _record_parts_db(of_lines, lines.looped),
        force_ratio=math.sqrt(float(mean_square @ forces.mean(axis=1))) / bodies.load_n,
        contact_loss_db=contact_loss_db,
        stiffness_n_m=mean_stiffness,
    )


class ApproachLines(NamedTuple):
    """Audible lines of an approach as it passes in time.

    duration : float, s. Duration of the approach.
    looped : bool. Whether it repeats; otherwise it is faded.
    first : int. Order of the first line, its frequency times the duration.
    frequency : (lines,) array, Hz. Frequencies.
    phasor : (lines,) complex array, m. Fourier coefficients.
    """

    duration: float
    looped: bool
    first: int
    frequency: Array
    phasor: NDArray[np.complex128]

    @property
    def mean_square(self) -> Array:
        """Mean squares of the lines [m2]."""
        return np.asarray(2 * np.square(np.abs(self.phasor)))


class ChainAtLines(NamedTuple):
    """A linear chain at the lines of an approach.

    lines : ApproachLines. Lines of the approach.
    chain : Chain. Ball, contact and plate.
    points : (lines, places) array, Hz. Frequencies in the interval of each line.
    gain : (lines, places) array, Pa2/m2. Mean square pressure at the listener per mean square
        approach at these frequencies.
    """

    lines: ApproachLines
    chain: Chain
    points: Array
    gain: Array


def chain_at_lines(
    bodies: BallOnPlate,
    listener: Listener,
    chain: Chain,
    motion: Motion,
    approach: Array,
    step: float,
    closed: bool,
) -> ChainAtLines | None:
    """Return a chain at the lines of an approach; None where it does not fluctuate within hearing.

    The approach is that of `vibration_estimate`.
    """
    lines = approach_lines(motion, approach, step, closed)
    if not lines.mean_square.sum() > 0:
        return None
    points = places_of_lines(bodies.plate, chain, lines.frequency, 1 / lines.duration)
    gain = roughness_gain(bodies, listener, chain)(points.ravel()).reshape(points.shape)
    return ChainAtLines(lines=lines, chain=chain, points=points, gain=gain)


def linear_pressure(
    bodies: BallOnPlate, listener: Listener, moved: ChainAtLines, samples: int, laps: int = 1
) -> Array:
    """Return the sound pressure [Pa] of an approach that moves a linear chain, (samples,).

    Each line of the approach keeps its phase through contact, ball and plate. Its size is that of
    the mean square over the interval of the line, as `vibration_estimate` has it, so that a sharp
    resonance between two lines is heard. The record holds the lines of so many `laps`.
    """
    lines = moved.lines
    transfer = roughness_transfers(bodies, listener, moved.chain)(lines.frequency)[0]
    size = np.sqrt(moved.gain.mean(axis=1))
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    orders = laps * (lines.first + np.arange(len(lines.frequency)))
    below = orders < (samples + 1) // 2
    phasors = lines.phasor * size * np.exp(1j * np.angle(transfer))
    spectrum[orders[below]] = samples * phasors[below]
    return np.fft.irfft(spectrum, samples)


def _record_parts_db(squares: Array, looped: bool) -> dict[str, float]:
    """Return the uncertainties [dB] that few lines leave, from A-weighted lines at their places.

    Lines that are strong or weak by chance are in the comb as well, so the larger of both counts.
    """
    record_db = uncertainty_of_lines_db(squares.mean(axis=1))
    if not looped:
        return {"record": record_db}
    at_places = squares.sum(axis=0)
    mean = float(at_places.mean())
    comb_db = math.sqrt(np.mean([_apart_db(place, mean) ** 2 for place in at_places]))
    return {"comb": comb_db, "record": math.sqrt(max(0.0, record_db**2 - comb_db**2))}


def force_gain(chain: Chain, frequency: Array) -> Array:
    """Return the square of force per approach [N2/m2] at frequencies of any shape [Hz]."""
    force = chain.force(frequency.ravel(), np.ones(frequency.size))
    return np.asarray(np.square(np.abs(force)).reshape(frequency.shape))


def _apart_db(square: float, other: float) -> float:
    """Return the distance of two levels [dB] from their mean squares."""
    return abs(10 * math.log10(max(square, 1e-12 * other) / other))


def approach_lines(motion: Motion, approach: Array, step: float, closed: bool) -> ApproachLines:
    """Return the lines of an approach [m] at the ends of steps [m], of whole laps if `closed`."""
    duration = motion.duration((len(approach) - 1) * step)
    looped = closed and motion.is_constant(duration)
    signal = approach_in_time(motion, approach, step, looped)
    if not looped:
        signal = faded(signal, duration)
    # There are at least DENSE samples in a period, so no line that is heard lies at Nyquist.
    frequency, phasor = audible_phasors(signal - signal.mean(), len(signal) / duration)
    first = round(float(frequency[0]) * duration) if len(frequency) else 0
    return ApproachLines(duration, looped, first, frequency, phasor)


def approach_in_time(motion: Motion, approach: Array, step: float, looped: bool) -> Array:
    """Return the approach [m] at even times, dense enough for hearing, by splines along the track.

    The force law of a run joins its positions in the same way.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    steps = len(approach) - 1
    duration = motion.duration(steps * step)
    count = max(steps, math.ceil(DENSE * AUDIBLE_HZ[1] * duration))
    if looped and count == steps:
        return approach[:-1]
    ends = approach
    if looped:
        ends = np.append(approach[:-1], approach[0])
    joined = CubicSpline(np.arange(steps + 1), ends, bc_type="periodic" if looped else "not-a-knot")
    distances = np.asarray(motion.distance(np.arange(count) * (duration / count)))
    return np.asarray(joined(np.minimum(distances / step, steps)))


def places_of_lines(plate: PlateBody, chain: Chain, frequency: Array, width: float) -> Array:
    """Return frequencies [Hz] around each line, within the width of an interval, (lines, places).

    A resonance that is narrower than the distance of two lines falls on a line or between them.
    """
    sharp = chain.resonance_hz / chain.quality
    if chain.modes is not None:
        sharp = min(sharp, float(frequency[0]) * least_loss_factor(plate.loss_factor or 1.0))
    wanted = math.ceil(PLACES * width / sharp) if sharp > 0 else MAX_PLACES
    most = min(MAX_PLACES, MAX_GAINS // len(frequency))  # a long record has dense lines
    return _spread_over_intervals(frequency, max(1, min(max(PLACES, wanted), most)), width)
