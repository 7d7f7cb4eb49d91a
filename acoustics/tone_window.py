"""Four-term Blackman-Harris window: a strong tone hides the lines within its lobe, and no others.

The lobe of a tone reaches four lines to either side, and all side lobes are 92 dB below the tone.
A Hann window has a lobe half as wide, but its side lobes stand out of a quiet surrounding like
lines of their own.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array

# F. J. Harris, Proceedings of the IEEE 1978, 66(1), 51-83, table I.
_TERMS = (0.35875, 0.48829, 0.14128, 0.01168)
REACH = 4.0  # lines from a tone to the end of its lobe
SEPARATED = REACH + 1.0  # lines between tones that are read apart, however weak one of them is
SIDE_LOBES = 3e-5  # largest side lobe over its tone, with a margin: -92 dB are 2.5e-5
# The place of a peak between lines: error of the parabola, and error by noise of a height of one.
_PLACE_ERROR = 0.05
_PLACE_ERROR_OF_NOISE = 1.0
_MOST_PULL = 0.15  # lines by which another tone may move a peak that stays apart
_PULLED = 0.7  # lines up to which a peak may be pulled from its place
_BETWEEN = 1.5  # ratio of the distances of a peak from two tones of which it is made, at most


def tone_window(count: int) -> Array:
    """Return the window of a record with so many samples, (count,)."""
    phase = 2.0 * np.pi * np.arange(count) / count
    window = np.zeros(count)
    for order, term in enumerate(_TERMS):
        window += (-1) ** order * term * np.cos(order * phase)
    return window


def lobe(lines: ArrayLike) -> Array:
    """Return the amplitude at some lines from a tone over that of the tone, an array of the shape.

    It is the transform of the window, whose terms are pairs of lines beside the middle one.
    """
    away = np.asarray(lines, dtype=float)
    amplitude = _TERMS[0] * np.sinc(away)
    for order, term in enumerate(_TERMS[1:], start=1):
        amplitude = amplitude + term / 2 * (np.sinc(away - order) + np.sinc(away + order))
    return np.asarray(np.abs(amplitude) / _TERMS[0])


# ---- tones near each other


class SpectralTone(NamedTuple):
    """A tone that stands out: its place in lines, the error of this place, and its rms."""

    place: float
    error: float
    rms: float


def place_error(height: float) -> float:
    """Return how far the place of a peak may be off [lines], from its height over the noise."""
    return _PLACE_ERROR + _PLACE_ERROR_OF_NOISE / max(height, 1.0)


def with_pull(tone: SpectralTone, tones: Sequence[SpectralTone]) -> SpectralTone:
    """Return a tone whose place is less certain by what the lobes of others do to its peak."""
    pull = 0.0
    for other in tones:
        if other is not tone:
            away = max(abs(other.place - tone.place) - 1.0, 0.0)
            pull += other.rms / tone.rms * float(lobe(away)) / 2
    return tone._replace(error=tone.error + min(pull, _MOST_PULL))


def lines_apart(place: float, tones: Sequence[SpectralTone], rivals: Sequence[float]) -> float:
    """Return how many lines the nearest tone is away that hides the line at a place.

    A peak between two tones that may be there is both of them, and one that is half a line away or
    less is the line itself, pulled by another.
    """
    away = []
    for tone in tones:
        distance = abs(tone.place - place)
        made_of = [
            abs(rival - place)
            for rival in rivals
            if abs(rival - place) < SEPARATED
            and (abs(rival - tone.place) <= _BETWEEN * distance or distance < _PULLED)
        ]
        if made_of:
            away.append(min(made_of))
        elif distance >= _PULLED:
            away.append(distance)
    return min(away, default=min(abs(tone.place - place) for tone in tones))


def tone_is_at(tone: SpectralTone, place: float) -> bool:
    """Tell whether a tone may be at a place, as far as noise lets one know."""
    return abs(tone.place - place) <= tone.error
