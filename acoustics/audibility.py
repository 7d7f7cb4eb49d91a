"""Tell whether the difference between two sounds is audible in the background noise of a room.

N5 of room and sound A is compared with N5 of room and sound B. N5 is the loudness that is exceeded
for 5 % of the time (`acoustics.loudness`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, stdtrit

from acoustics.arrays import Array, positive, truth, within
from acoustics.bands import (
    BAND_NAMES,
    EDGES_HZ,
    MAX_ROOM_DB,
    MID_HZ,
    MIN_ROOM_DB,
    NOMINAL_HZ,
    nearest_nominal,
)
from acoustics.loudness import VARYING_RATE_HZ, loudness_in_time, n5_sone
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import checked_record
from acoustics.weighting import a_weighting_db

AUDIBLE_PERCENT = 8.0
"""A larger difference of N5 counts as audible [%], by convention (`audible_difference`)."""
NOT_AUDIBLE_PERCENT = 4.0
"""A smaller difference of N5 counts as not audible [%], by convention (`audible_difference`)."""

AUDIBLE = "audible"
PERHAPS = "perhaps"
NOT_AUDIBLE = "not audible"

ROOM_LAEQ_DB = 30.0  # of the default room [dB(A)]
ROOM_BAND_HZ = (50.0, 10000.0)  # nominal mid frequencies of its lowest and highest third octave

# Realisations of the room's noise for one pair of records. Several pairs share them.
_REALISATIONS = 4
# The room is heard alone first, until the filters of the lowest bands have settled [s].
_LEAD_S = 0.3
# [s] of a loop that are judged.
_SHORTEST_LOOP_S = 1.0
_LONGEST_LOOP_S = 3.0
# [s] after an open record, in which the loudness of its end rises and fades.
_AFTER_S = 0.2
# Noise is made for this time at least, so that the lowest third octave has lines [s].
_SHORTEST_NOISE_S = 1.0
# Loudness at 5 phon, just above the threshold of 3 phon (ISO 532-1:2017, 5.7). Smaller loudness
# counts as this one, so that two sounds which nobody hears do not differ.
_THRESHOLD_SONE = 0.003
_ONE_SIGMA = float(ndtr(1.0))
_SHARE_95 = 0.975  # of Student's distribution, two-sided 95 %


def default_room_db() -> dict[float, float]:
    """Return the third octaves of the default room: pink noise of 30 dB(A), 50 Hz to 10 kHz.

    Returns
    -------
    dict
        Level of each third octave, dB re 20 uPa, by nominal mid frequency [Hz]. All are equal.

    Examples
    --------
    >>> import acoustics
    >>> room = acoustics.default_room_db()
    >>> len(room), round(room[1000], 2)
    (24, 18.27)
    """
    lowest, highest = ROOM_BAND_HZ
    inside = [lowest <= nominal <= highest for nominal in NOMINAL_HZ]
    energy = float(np.sum(10.0 ** (a_weighting_db(MID_HZ[inside]) / 10.0)))
    level = ROOM_LAEQ_DB - 10.0 * math.log10(energy)
    return {nominal: level for nominal in NOMINAL_HZ if lowest <= nominal <= highest}


def room_noise(
    third_octaves_db: Mapping[float, float] | None,
    seconds: float,
    sample_rate_hz: float = VARYING_RATE_HZ,
    seed: int | Sequence[int] = 0,
) -> Array:
    """Make Gaussian noise with given levels of its third octaves.

    The density falls as 1/f within a band, so equal levels make pink noise. Noise of 1 s or more
    closes on itself, and has the given levels exactly. Shorter noise is cut out of one second, and
    has them on average.

    Parameters
    ----------
    third_octaves_db : mapping or None, dB re 20 uPa
        Level by nominal mid frequency, 20 to 20000 Hz. A missing band is silent. None is
        `default_room_db`.
    seconds : float, s
        Duration.
    sample_rate_hz : float, Hz
        Sample rate. Default 48000.
    seed : int, or several
        Seed. The same seed gives the same noise.

    Returns
    -------
    array (n,), Pa

    Raises
    ------
    ValueError
        If a frequency is no nominal mid frequency, a level lies outside -20 to 120 dB, or a band
        lies above half the sample rate.

    References
    ----------
    IEC 61260-1:2014 for nominal mid frequencies and edges.

    Examples
    --------
    >>> import acoustics
    >>> noise = acoustics.room_noise({500: 20.0, 1000: 26.0}, seconds=2)
    >>> round(acoustics.sound_levels(noise, 48000).third_octave_db["1000"], 2)
    26.0
    """
    seconds = positive("seconds", seconds)
    rate = positive("sample_rate_hz", sample_rate_hz)
    levels = checked_bands_db(default_room_db() if third_octaves_db is None else third_octaves_db)
    wanted = max(1, round(seconds * rate))
    n = max(wanted, round(_SHORTEST_NOISE_S * rate))
    frequency_hz = np.fft.rfftfreq(n, 1.0 / rate)
    random = np.random.default_rng(seed)
    # All lines are drawn, so that a band has the same noise whatever the other bands are.
    drawn = random.standard_normal(len(frequency_hz)) + 1j * random.standard_normal(
        len(frequency_hz)
    )
    lines = np.zeros(len(frequency_hz), dtype=complex)
    for band, level_db in levels.items():
        if EDGES_HZ[band + 1] > rate / 2.0:
            raise ValueError(
                f"third_octaves_db: got a level at {BAND_NAMES[band]} Hz, allowed at a sample rate "
                f"of {rate:g} Hz: third octaves below {rate / 2:g} Hz"
            )
        first, end = np.searchsorted(frequency_hz, EDGES_HZ[band : band + 2])
        part = drawn[first:end] / np.sqrt(frequency_hz[first:end])
        mean_square = P_REF_PA**2 * 10.0 ** (level_db / 10.0)
        # A line and its mirror image have the mean square 2 |line / n|^2.
        drawn_square = 2.0 * float(np.sum(np.abs(part / n) ** 2))
        lines[first:end] = part * math.sqrt(mean_square / drawn_square)
    return np.fft.irfft(lines, n)[:wanted]


def checked_bands_db(third_octaves_db: Mapping[float, float]) -> dict[int, float]:
    """Return the levels of third octaves by the number of their band; refuse others.

    Raises
    ------
    ValueError
        If a frequency is no nominal mid frequency, or a level lies outside -20 to 120 dB.
    """
    levels = {}
    for key, level in third_octaves_db.items():
        name = f"{float(key):g}"
        if name not in BAND_NAMES:
            raise ValueError(
                f"third_octaves_db: got {float(key):g} Hz, allowed: nominal mid frequencies of "
                f"third octaves from 20 to 20000 Hz; the nearest is {nearest_nominal(float(key)):g}"
            )
        levels[BAND_NAMES.index(name)] = within(
            f"third_octaves_db at {name} Hz", level, MIN_ROOM_DB, MAX_ROOM_DB
        )
    return levels


class TooLoudError(ValueError):
    """A sound whose loudness is not defined, with a third octave up to 250 Hz above 120 dB."""


@dataclass(frozen=True)
class Audibility:
    """Loudness of two sounds in a room, their difference, and a verdict on it.

    Parameters
    ----------
    n5_a_sone, n5_b_sone : float, sone
        N5 of room and A, and of room and B; geometric means.
    n5_room_sone : float, sone
        N5 of the room alone.
    difference_percent : float, %
        By how much the louder N5 exceeds the other: positive where A is louder, negative where B
        is.
    uncertainty_percent : float, %
        Standard uncertainty of the difference, widened by Student's t to hold 68 %.
    low_percent, high_percent : float, %
        Interval that holds the difference with 95 %, by Student's t.
    specimens : int
        Pairs of records.
    realisations : int
        Realisations of the room's noise. Each was heard under A and under B.
    verdict : str
        "audible", "perhaps" or "not audible", as `audible_difference` defines them.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> silence = np.zeros(4800)
    >>> acoustics.audible_difference([silence], [silence], 48000).difference_percent
    0.0
    """

    n5_a_sone: float
    n5_b_sone: float
    n5_room_sone: float
    difference_percent: float
    uncertainty_percent: float
    low_percent: float
    high_percent: float
    specimens: int
    realisations: int
    verdict: str


def audible_difference(
    records_a: Sequence[Array],
    records_b: Sequence[Array],
    sample_rate_hz: float,
    closed_a: bool = True,
    closed_b: bool = True,
    room_db: Mapping[float, float] | None = None,
    seed: int = 0,
) -> Audibility:
    """Tell whether the difference between two sounds is audible in the noise of a room.

    Each pair of records is heard in the same noise. The verdict is about the difference of N5, with
    the interval that holds it with 95 %:

    - audible: the whole interval lies above 8 %, or below -8 %;
    - not audible: the whole interval lies within 4 % on either side;
    - perhaps: all else. The difference is between the limits, or too uncertain.

    The limits are conventions and no standard. The 8 % are the difference of N10 that half of the
    listeners are said to have noticed in a study of drum sounds. The publication is not named here,
    because it was not found; treat the limit as a rule of thumb. The 4 % are half of it.

    The difference has the standard uncertainty of a mean over pairs. With one pair it holds the
    noise of the room only, and says nothing about other specimens.

    Parameters
    ----------
    records_a, records_b : sequence of arrays (n,), Pa
        Sound pressure of the specimens of A and of B at the listener. The first of A belongs to the
        first of B, such as records of the same seed.
    sample_rate_hz : float, Hz
        Sample rate, 48 kHz.
    closed_a, closed_b : bool
        If true, the records close on themselves. They are looped, and 1 to 3 s are judged.
        Otherwise a record is heard once, in the middle of the noise.
    room_db : mapping or None, dB re 20 uPa
        Third octaves of the noise, as in `room_noise`. Default: `default_room_db`.
    seed : int
        Seed of the noise.

    Returns
    -------
    Audibility

    Raises
    ------
    ValueError
        If A and B have no records or not equally many; also as `room_noise` and
        `acoustics.spectrum.checked_record`.
    TooLoudError
        If the loudness of a sound or of the room is not defined, a ValueError.

    References
    ----------
    ISO 532-1:2017, method 2, for the loudness.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> tone = 2e-3 * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 37 dB
    >>> acoustics.audible_difference([tone], [0.1 * tone], 48000).verdict
    'audible'
    """
    if not len(records_a) == len(records_b) > 0:
        raise ValueError(
            f"records: got {len(records_a)} of A and {len(records_b)} of B, allowed: equally many "
            "of both, and at least one"
        )
    truth("closed_a", closed_a)
    truth("closed_b", closed_b)
    sounds_a = [_Sound(record, sample_rate_hz, closed_a) for record in records_a]
    sounds_b = [_Sound(record, sample_rate_hz, closed_b) for record in records_b]
    specimens = len(sounds_a)
    rounds = max(1, _REALISATIONS // specimens)
    judged_s = _judged_s([*sounds_a, *sounds_b])
    after_s = 0.0 if closed_a and closed_b else _AFTER_S
    noise_s = _LEAD_S + judged_s + after_s

    noises = []
    played_a = []
    played_b = []
    for k in range(specimens * rounds):
        noise = room_noise(room_db, noise_s, sample_rate_hz, [seed, k])
        noises.append(noise)
        played_a.append(noise + sounds_a[k % specimens].placed(noise_s, judged_s, k))
        played_b.append(noise + sounds_b[k % specimens].placed(noise_s, judged_s, k))
    courses = loudness_in_time([*played_a, *played_b, *noises[:_REALISATIONS]], sample_rate_hz)
    if courses is None:
        raise TooLoudError(
            "records: got a sound with a third octave up to 250 Hz above 120 dB, for which "
            "ISO 532-1 has no loudness"
        )
    n5 = [max(n5_sone(sone, _LEAD_S, judged_s), _THRESHOLD_SONE) for sone in courses]
    pairs = specimens * rounds
    log_a = np.log(n5[:pairs]).reshape(rounds, specimens)
    log_b = np.log(n5[pairs : 2 * pairs]).reshape(rounds, specimens)
    differences = log_a - log_b
    # Specimens are the larger part of the scatter, and their number counts. One specimen leaves
    # the scatter of the noise.
    values = differences.ravel() if specimens == 1 else differences.mean(axis=0)
    difference = float(np.mean(values))
    standard_error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    degrees = len(values) - 1
    half = float(stdtrit(degrees, _SHARE_95)) * standard_error
    uncertainty = float(stdtrit(degrees, _ONE_SIGMA)) * standard_error
    return Audibility(
        n5_a_sone=math.exp(float(np.mean(log_a))),
        n5_b_sone=math.exp(float(np.mean(log_b))),
        n5_room_sone=float(np.mean(n5[2 * pairs :])),
        difference_percent=_percent(difference),
        uncertainty_percent=100.0 * math.exp(abs(difference)) * uncertainty,
        low_percent=_percent(difference - half),
        high_percent=_percent(difference + half),
        specimens=specimens,
        realisations=pairs,
        verdict=_verdict(difference - half, difference + half),
    )


def _verdict(low: float, high: float) -> str:
    """Return the verdict on an interval of ln(N5 of A / N5 of B)."""
    audible = math.log1p(AUDIBLE_PERCENT / 100.0)
    not_audible = math.log1p(NOT_AUDIBLE_PERCENT / 100.0)
    if low > audible or high < -audible:
        return AUDIBLE
    if -not_audible < low and high < not_audible:
        return NOT_AUDIBLE
    return PERHAPS


def _percent(log_ratio: float) -> float:
    """Return by how many percent the larger of two numbers exceeds the other, with the sign."""
    return math.copysign(100.0 * math.expm1(abs(log_ratio)), log_ratio)


class _Sound:
    """A record that is laid into the noise of a room."""

    def __init__(self, record: Array, rate: float, closed: bool) -> None:
        record = checked_record(record, rate)
        # the onset of a mean would be heard as a bang
        self.fluctuation = record - np.mean(record)
        self.rate = rate
        self.closed = closed
        self.duration_s = len(record) / rate

    def placed(self, noise_s: float, judged_s: float, k: int) -> Array:
        """Return the pressure in the noise of realisation k [Pa]."""
        n = round(noise_s * self.rate)
        if self.closed:
            # Each realisation plays the next stretch of a long loop.
            start = k * round(judged_s * self.rate)
            return np.resize(np.roll(self.fluctuation, -start), n)
        placed = np.zeros(n)
        first = round((_LEAD_S + (judged_s - self.duration_s) / 2.0) * self.rate)
        placed[first : first + len(self.fluctuation)] = self.fluctuation
        return placed


def _judged_s(sounds: Sequence[_Sound]) -> float:
    """Return the duration that is judged: that of the longest open record, or of a loop."""
    longest_open = max((sound.duration_s for sound in sounds if not sound.closed), default=0.0)
    longest_loop = max((sound.duration_s for sound in sounds if sound.closed), default=0.0)
    if longest_loop == 0.0:
        return longest_open
    loop_s = min(max(longest_loop, _SHORTEST_LOOP_S), _LONGEST_LOOP_S)
    return max(loop_s, longest_open)
