"""Parts of the standard uncertainty of the velocity in the bands of a ring."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

# Decibels by the direction (radial, axial) and the name of the band (low, medium, high).
DecibelsOfBands = Mapping[str, Mapping[str, float]]

# Names of parts.
RECORD = "record"  # scatter within a record that is short
WINDOW = "window"  # roughness that is known from a stretch of track
LINEAR = "linear"  # rough contacts that are not marched
ONE_LOAD = "one_load"  # single faults that are marched at one load
LOSS_FACTOR = "loss_factor"  # of the contacts, where it is assumed
FILM = "film"  # how far a film of oil presses waves flat
FILM_DAMPING = "film_damping"  # how much a film of oil damps
SURFACES = "surfaces"  # waves around balls and raceways, where their law is assumed


@dataclass(frozen=True)
class BandUncertainty:
    """Parts of the standard uncertainty of each band of a ring, independent of each other.

    Parameters
    ----------
    parts_db : dict, dB
        Decibels by the name of the part, the direction and the name of the band. Default: none.
    """

    parts_db: Mapping[str, DecibelsOfBands] = field(default_factory=dict)

    def with_part(self, name: str, decibels: DecibelsOfBands) -> BandUncertainty:
        """Return the uncertainty with one more part, which replaces an earlier one of its name."""
        return BandUncertainty({**self.parts_db, name: decibels})

    def of_band(self, direction: str, band: str) -> dict[str, float]:
        """Return the parts of a band [dB] by their names."""
        return {name: part[direction][band] for name, part in self.parts_db.items()}
