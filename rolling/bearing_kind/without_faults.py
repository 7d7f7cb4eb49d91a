"""The same bearing without its single faults: what a fault adds, and what was there before."""

from __future__ import annotations

from rolling.bearing import lines
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.ring_record import AXIAL, RADIAL, UM_S, RingRecord
from rolling.numbers.bearing_numbers import BandValues, EnvelopeHeight, FaultlessNumbers


def without_faults_of_record(
    record: RingRecord, kinematics: Kinematics, envelope_hz: tuple[float, float]
) -> FaultlessNumbers:
    """Return the numbers of the record of a bearing without its faults.

    Its envelope has the band [Hz] of the bearing with them.
    """
    readings = lines.envelope_readings(record.envelope(envelope_hz), kinematics)
    return FaultlessNumbers(
        radial=_values(record, RADIAL),
        axial=_values(record, AXIAL),
        envelope=tuple(
            EnvelopeHeight(name=line.name, height=reading.height) for line, reading in readings
        ),
    )


def _values(record: RingRecord, direction: str) -> BandValues:
    """Return the velocities of a direction."""
    rms = record.bands[direction].rms_m_s
    return BandValues(**{band: UM_S * value for band, value in rms.items()})
