"""The same bearing without its single faults: what a fault adds, and what was there before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import lines
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.ring_record import DIRECTIONS, UM_S, RingRecord


@dataclass(frozen=True)
class WithoutFaults:
    """Numbers of a bearing as it would run without its single faults.

    bands_um_s : dict. Velocity of the ring [um/s] by direction and band.
    heights : dict. Height of each line of the envelope over its surroundings; None where the record
        does not separate it from a stronger line.
    """

    bands_um_s: Mapping[str, Mapping[str, float]]
    heights: Mapping[str, float | None]

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers as summary.json has them."""
        bands = {direction: dict(bands) for direction, bands in self.bands_um_s.items()}
        return {"bands_um_s": bands, "envelope_heights": dict(self.heights)}


def without_faults_of_record(record: RingRecord, kinematics: Kinematics) -> WithoutFaults:
    """Return the numbers of the record of a bearing without its faults."""
    bands = {
        direction: {name: UM_S * rms for name, rms in record.bands[direction].rms_m_s.items()}
        for direction in DIRECTIONS
    }
    heights = {
        line.name: reading.height
        for line, reading in lines.envelope_readings(record.envelope, kinematics)
    }
    return WithoutFaults(bands_um_s=bands, heights=heights)


def stored_without_faults(stored: Mapping[str, Any] | None) -> WithoutFaults | None:
    """Return the numbers that summary.json has; None where it has none.

    Raises
    ------
    KeyError, TypeError, ValueError
        They are damaged.
    """
    if stored is None:
        return None
    bands = {
        direction: {
            name: float(stored["bands_um_s"][direction][name]) for name in VELOCITY_BANDS_HZ
        }
        for direction in DIRECTIONS
    }
    heights = {}
    for name, height in stored["envelope_heights"].items():
        heights[str(name)] = None if height is None else float(height)
    return WithoutFaults(bands_um_s=bands, heights=heights)
