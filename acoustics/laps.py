"""Laps of a record that follow each other without a click or a gap, for listening."""

from dataclasses import dataclass, replace

import numpy as np

from acoustics.arrays import Array, refuse_masked
from acoustics.level import a_weighted_rms

_OVERLAP_S = 0.01  # [s], at most a sixth of the record
_SEARCH = 2  # overlaps within which the beginning of a lap is chosen; more would leave out events


@dataclass(frozen=True)
class Lap:
    """Part of a record that repeats: record[begin:end], whose last samples lead to its first.

    begin, end : int. First sample, and the sample behind the last one.
    overlap : int. Samples before the end that are cross-faded with those behind the beginning; 0
        for a record that closes on itself.
    correlation : float. Correlation of both, from 0 to 1.
    factor : float. Factor on the lap that gives it the A-weighted rms of the record.
    """

    begin: int
    end: int
    overlap: int = 0
    correlation: float = 0.0
    factor: float = 1.0

    def __len__(self) -> int:
        return self.end - self.overlap - self.begin

    def samples(self, record: Array) -> Array:
        """Return the lap of its record, (len(self),) or (len(self), channels) in its unit."""
        if record.ndim == 2:
            return np.stack([self.samples(channel) for channel in record.T], axis=1)
        lap = np.array(record[self.begin : self.end - self.overlap], dtype=float)
        angle = 0.5 * np.pi * (np.arange(self.overlap) + 0.5) / max(self.overlap, 1)
        rise = np.square(np.sin(angle))
        fall = 1.0 - rise
        mixed = rise * lap[: self.overlap] + fall * record[self.end - self.overlap : self.end]
        # The mean square of the sum stays that of its parts.
        square = np.square(rise) + np.square(fall) + 2.0 * self.correlation * rise * fall
        lap[: self.overlap] = mixed / np.sqrt(square)
        return self.factor * lap


def crossfaded_lap(record: Array, fade: int, sample_rate_hz: float) -> Lap:
    """Return a lap of a record that does not close, without the faded samples at its ends.

    The end is cross-faded with the part of the beginning that is most alike, with equal slopes. A
    record that is too short is its own lap.
    """
    refuse_masked("record", record)
    end = len(record) - fade
    most = (end - fade) // 6
    overlap = min(round(_OVERLAP_S * sample_rate_hz), most)
    if overlap < 1:
        return Lap(begin=0, end=len(record))
    tail = record[end - overlap : end]
    head = record[fade : fade + overlap + min(_SEARCH * overlap, most)]
    energy = np.convolve(np.square(head), np.ones(overlap), "valid") * float(tail @ tail)
    size = np.sqrt(np.maximum(energy, 0.0))
    product = np.correlate(head, tail, "valid")
    alike = np.divide(product, size, out=np.zeros_like(size), where=size > 0.0)
    best = int(np.argmax(alike))
    lap = Lap(
        begin=fade + best,
        end=end,
        overlap=overlap,
        correlation=min(max(float(alike[best]), 0.0), 1.0),
    )
    rms_of_record = a_weighted_rms(record, sample_rate_hz)
    rms_of_lap = a_weighted_rms(lap.samples(record), sample_rate_hz)
    if min(rms_of_record, rms_of_lap) > 0.0:
        return replace(lap, factor=rms_of_record / rms_of_lap)
    return lap
