"""Sound above the Nyquist frequency of the steps, which a record cannot contain.

Coarse steps or a low speed end the band of a record below the end of hearing. The part that is cut
off is estimated from the waves that the steps resolve. An asperity that comes into contact bends
the approach with the power 3/2 of the distance, as Hertz has it, and the release with the power
1/2. Power spectra of such bends fall with the fifth and the third power of the wavenumber. A
release reaches this law at short waves only, so its spectrum goes on with the mean of this power
and the power of its last octave.

tests/benchmarks/missing_band_study.py compares the estimate with shorter steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acoustics import spectrum, wav
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.radiation import P_REF_PA
from acoustics.weighting import a_weighting_db
from rolling.contact.track import Motion
from rolling.sound.contact_sound import ContactSound
from rolling.sound.error_estimate import Gain
from rolling.sound.vibration_sound import Vibration

APPROACH_POWER = -5.0  # of the wavenumber, with which the spectrum of an approach falls
RELEASE_POWER = -3.0  # of the wavenumber, with which the spectrum of a release falls
OWN_POWERS = -6.0, 0.0  # limits of the power of the last octave of a release
# Waves from which a spectrum goes on, over the shortest wave of the steps. Still shorter ones hold
# a part of the missing waves, which the steps fold back.
LAST_OCTAVE = 0.45, 0.75
MIN_LINES = 8  # in the last octave
DOUBT = 0.5  # standard uncertainty over the decibels that are missing
LEAST_DB = 0.1  # standard uncertainty of an error that is hardly there
MAX_DB = 60.0  # part that a record may miss; it has no level that could be known then
_SPEEDS = 24  # speeds that stand for a record of changing speed
_POINTS = 4000  # frequencies of the missing band
_NEAR = 12.0  # half-widths of a resonance within which it has points of its own


@dataclass(frozen=True)
class MissingBand:
    """Part of the sound that the steps of a record cut off.

    highest_hz : float, Hz. Nyquist frequency of the steps at the minimum speed.
    error_db : float, dB. Reported LAeq less LAeq with the missing band; negative: too low.
    uncertainty_db : float, dB. Standard uncertainty of the error.
    """

    highest_hz: float
    error_db: float
    uncertainty_db: float


class VibrationSource(NamedTuple):
    """Vibration that is the source of a sound, and how an approach becomes its pressure."""

    vibration: Vibration
    gain: Gain  # power gain [Pa2/m2] from an approach under the constant load to the pressure


def missing_band(
    sound: ContactSound,
    lap: Array,
    step: float,
    motion: Motion,
    own_factor: bool,
    source: VibrationSource | None = None,
) -> MissingBand | None:
    """Estimate the part of a sound above the Nyquist frequency of its steps.

    Parameters
    ----------
    sound : ContactSound. The sound of the run.
    lap : (steps,) array, m or J. Approach at each position of the solved track for a vibration,
        released energy of each step for a release.
    step : float, m. Length of a step.
    motion : Motion. Distance and speed over time.
    own_factor : bool. Whether the fluctuation of a release sets its factor to sound pressure.
    source : VibrationSource. The vibration that is heard. Default: the release is heard.

    Returns
    -------
    MissingBand, or None
        None where the steps resolve hearing, where nothing sounds, where contact is lost, and where
        the track is too short to tell.
    """
    vibration = None if source is None else source.vibration
    duration = sound.duration
    lowest = motion.slowest(duration) / (2 * step)
    if lowest >= AUDIBLE_HZ[1] or sound.once or sound.levels.laeq_db is None:
        return None
    if vibration is not None and vibration.motion.flight_share > 0:
        return None  # impacts sound above the band of the steps, and their time steps resolve it
    waves = _waves(lap, step, sound.closed, vibration is not None)
    if waves is None:
        return None
    gain: Gain = _gain_of_release
    resonance = None
    if source is not None:
        gain = source.gain
        chain = source.vibration.chain
        resonance = chain.resonance_hz, chain.quality
    # Mean squares, A-weighted and unweighted.
    solved = np.zeros(2)
    missing = np.zeros(2)
    for speed in _speeds(motion, duration):
        # The power of a release goes with the square of the speed.
        factor = 1.0 if vibration is not None else speed**2
        solved += factor * waves.solved(speed, gain)
        missing += factor * waves.missing(speed, gain, resonance)
    spurious = 0.0
    if vibration is not None and vibration.is_mean_of_comb:
        # The level that is stated is the mean over the comb, of the lines of the steps alone.
        stated = P_REF_PA**2 * 10 ** (sound.levels.laeq_db / 10)
        solved = np.array([stated, stated])
    elif vibration is not None and sound.constant_speed:
        # The record has the true lines of the solved band, and above it lines of splines, which
        # join the positions.
        solved, spurious = _of_record(sound.pressure, lowest)
    if not solved[0] > 0:
        return MissingBand(highest_hz=lowest, error_db=-MAX_DB, uncertainty_db=DOUBT * MAX_DB)
    error = 10 * np.log10((solved + np.array([spurious, 0.0])) / (solved + missing))
    whole = float(error[0])
    if vibration is None and own_factor:
        whole -= 0.5 * float(error[1])  # the record's own fluctuation sets its factor
    whole = max(whole, -MAX_DB)
    lacking = 10 * math.log10(1 + missing[0] / solved[0])
    doubt = DOUBT * min(max(abs(whole), lacking), MAX_DB)
    return MissingBand(
        highest_hz=lowest, error_db=whole, uncertainty_db=math.hypot(LEAST_DB, doubt)
    )


@dataclass(frozen=True)
class _Waves:
    """Spectrum of a signal along a track, and the law by which it goes on.

    wavenumber : (lines,) array, 1/m. Wavenumbers of the lines.
    squares : (lines,) array. Mean squares of the lines.
    density : float. Mean square per wavenumber at `place`.
    place : float, 1/m. A wavenumber within the last octave.
    power : float. Power of the wavenumber by which the density falls.
    shortest : float, 1/m. Wavenumber at which the steps end.
    """

    wavenumber: Array
    squares: Array
    density: float
    place: float
    power: float
    shortest: float

    def solved(self, speed: float, gain: Gain) -> Array:
        """Return the A-weighted and the unweighted mean square of the lines at a speed [m/s]."""
        frequency = speed * self.wavenumber
        audible = (frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
        squares = self.squares[audible] * gain(frequency[audible])
        return _weighted(frequency[audible], squares)

    def missing(
        self,
        speed: float,
        gain: Gain,
        resonance: tuple[float, float] | None,
    ) -> Array:
        """Return the A-weighted and the unweighted mean square beyond the steps at a speed."""
        first = max(speed * self.shortest, AUDIBLE_HZ[0])
        if first >= AUDIBLE_HZ[1]:
            return np.zeros(2)
        frequency = _frequencies(first, resonance)
        width = np.gradient(frequency)
        density = self.density * (frequency / speed / self.place) ** self.power / speed
        return _weighted(frequency, density * width * gain(frequency))


def _gain_of_release(frequency: Array) -> Array:
    """Return the gain of a release, which is heard as it is."""
    return np.ones(len(frequency))


def _weighted(frequency: Array, squares: Array) -> Array:
    """Return the A-weighted and the unweighted sum of mean squares."""
    weights = 10 ** (a_weighting_db(frequency) / 10)
    return np.array([squares @ weights, squares.sum()])


def _waves(lap: Array, step: float, closed: bool, is_approach: bool) -> _Waves | None:
    """Return the spectrum of a lap with the law by which it goes on; None for a short track."""
    count = len(lap)
    window = np.ones(count)
    if not closed:  # a Hann window, whose mean square is 1
        turn = 2 * np.pi * (np.arange(count) + 0.5) / count
        window = np.sqrt(2 / 3) * (1 - np.cos(turn))
    lines = np.fft.rfft((lap - lap.mean()) * window)[1:-1] / count
    squares = 2 * np.square(np.abs(lines))
    order = np.arange(1, len(squares) + 1)
    if not is_approach:  # the energy of a step is a mean over it
        squares = squares / np.square(np.sinc(order / count))
    share = 2 * order / count
    last = (share >= LAST_OCTAVE[0]) & (share < LAST_OCTAVE[1])
    mean = float(squares[last].mean()) if last.sum() >= MIN_LINES else 0.0
    if not mean > 0:
        return None
    power = APPROACH_POWER
    if not is_approach:
        own = np.polyfit(np.log(order[last]), np.log(np.maximum(squares[last], 1e-6 * mean)), 1)[0]
        least, most = OWN_POWERS
        power = 0.5 * (RELEASE_POWER + float(np.clip(own, least, most)))
    length = count * step
    return _Waves(
        wavenumber=order / length,
        squares=squares,
        density=mean * length,
        place=float(np.exp(np.log(order[last]).mean())) / length,
        power=power,
        shortest=0.5 / step,
    )


def _speeds(motion: Motion, duration: float) -> Array:
    """Return speeds [m/s] that stand for equal parts of the time of a record."""
    if motion.is_constant(duration):
        return np.array([motion.fastest(duration)])
    middles = (np.arange(_SPEEDS) + 0.5) * (duration / _SPEEDS)
    speeds = np.asarray(motion.speed(middles), dtype=float)
    return speeds[speeds > 0]


def _frequencies(first: float, resonance: tuple[float, float] | None) -> Array:
    """Return frequencies [Hz] from the first to the last of hearing, closer at a resonance."""
    frequency = np.geomspace(first, AUDIBLE_HZ[1], _POINTS)
    if resonance is None:
        return frequency
    middle, quality = resonance
    half = middle / (2 * quality) if math.isfinite(quality) else 1e-6 * middle
    near = middle + half * np.sinh(np.linspace(-_NEAR, _NEAR, _POINTS))
    near = near[(near > first) & (near < AUDIBLE_HZ[1])]
    return np.unique(np.concatenate((frequency, near)))


def _of_record(pressure: Array, highest: float) -> tuple[Array, float]:
    """Return the mean squares of a record below a frequency [Hz], and the A-weighted one above."""
    frequency, squares = spectrum.audible_lines(pressure, wav.SAMPLE_RATE_HZ)
    below = frequency < highest
    above = _weighted(frequency[~below], squares[~below])
    return _weighted(frequency[below], squares[below]), float(above[0])
