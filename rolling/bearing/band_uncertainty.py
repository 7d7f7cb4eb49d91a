"""Standard uncertainty of the velocity in the bands of a ring, and its parts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_record import DIRECTIONS

# Decibels by the direction (radial, axial) and the name of the band (low, medium, high).
DecibelsOfBands = Mapping[str, Mapping[str, float]]

# Names of parts.
RECORD = "record"  # scatter within a record that is short
WINDOW = "window"  # roughness that is known from a stretch of track
LOSS_FACTOR = "loss_factor"  # of the contacts, where it is assumed


@dataclass(frozen=True)
class BandUncertainty:
    """Standard uncertainty of each band of a ring, as parts that are independent of each other.

    Parameters
    ----------
    parts_db : dict, dB
        Decibels by the name of the part, the direction and the name of the band. Default: none.
    """

    parts_db: Mapping[str, DecibelsOfBands] = field(default_factory=dict)

    def with_part(self, name: str, decibels: DecibelsOfBands) -> BandUncertainty:
        """Return the uncertainty with one more part, which replaces an earlier one of its name."""
        return BandUncertainty({**self.parts_db, name: decibels})

    def total_db(self, direction: str, band: str) -> float:
        """Return the root of the sum of squares of all parts [dB]."""
        return math.hypot(*(part[direction][band] for part in self.parts_db.values()))

    @property
    def totals_db(self) -> dict[str, dict[str, float]]:
        """Root of the sum of squares of all parts [dB], by direction and band."""
        return {
            direction: {band: self.total_db(direction, band) for band in VELOCITY_BANDS_HZ}
            for direction in DIRECTIONS
        }

    def to_dict(self) -> dict[str, dict[str, dict[str, float]]]:
        """Return the parts as summary.json has them."""
        return {
            name: {direction: dict(part[direction]) for direction in DIRECTIONS}
            for name, part in self.parts_db.items()
        }


def stored_uncertainty(stored: Mapping[str, DecibelsOfBands]) -> BandUncertainty:
    """Return the parts that summary.json has.

    Raises
    ------
    KeyError, TypeError, ValueError, AttributeError
        They are damaged.
    """
    parts: dict[str, DecibelsOfBands] = {}
    for name, part in stored.items():
        parts[str(name)] = {
            direction: {band: float(part[direction][band]) for band in VELOCITY_BANDS_HZ}
            for direction in DIRECTIONS
        }
    return BandUncertainty(parts)
