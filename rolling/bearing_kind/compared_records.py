"""Records of the run of a bearing that recordings are compared with: its ring, and its housing."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, MID_HZ
from acoustics.level import sound_levels
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.ring_record import AXIAL, RADIAL
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.numbers.bearing_numbers import BandVelocities
from rolling.recordings.compared_run import (
    ComparedRecord,
    ComparedRun,
    faded_record,
    unknown_spread,
)
from rolling.recordings.recorded import PRESSURE, MeasuredQuantity, Recording
from rolling.recordings.run_spread import RunSpread
from rolling.terminal.whole_files import FolderError

DIRECTION_OF = {"x": RADIAL, "y": RADIAL, "z": AXIAL}  # of the axes of the ring
_NO_PRESSURE = (
    "no sound, only velocity and acceleration of the ring; add the plate of the housing, its"
    " section `plate`, by `rolling resound`"
)
_UNKNOWN_LEVEL = "the ± of the level of the housing plate is not known, only that of its record"


def records_of_bearing(run: BearingRun, quantity: MeasuredQuantity) -> ComparedRun:
    """Return the sound of the housing of a run, or the motion of its ring along x, y and z.

    Raises
    ------
    FolderError : the run has no such record.
    """
    if quantity is PRESSURE:
        return _sound(run)
    of_ring = {
        "velocity": run.record.velocity_m_s,
        "acceleration": run.record.acceleration_m_s2,
    }
    if quantity.name not in of_ring:
        raise FolderError(
            f"{run.folder}: a ring has no channel of {quantity.name}, only {', '.join(of_ring)};"
            " give --quantity one of them"
        )
    bending_hz = run.numbers.ring.bending_hz
    highest_hz = min(VELOCITY_BANDS_HZ["high"][1], bending_hz)
    warnings = [f"the ring of the run is rigid, so it is compared up to {highest_hz:.0f} Hz"]
    if run.numbers.axial_doubt is not None:
        warnings.append(f"along z: {run.numbers.axial_doubt.line}")
    records = []
    for axis, samples in zip(DIRECTION_OF, of_ring[quantity.name].T, strict=True):
        record = faded_record(axis, samples, round(run.record.rate_hz), highest_hz, quantity)
        velocities = run.numbers.velocities.by_direction[DIRECTION_OF[axis]]
        spread = _spread_of_motion(record, velocities)
        records.append(ComparedRecord(record, record.seconds, spread))
    return ComparedRun(records=tuple(records), warnings=tuple(warnings))


def _sound(run: BearingRun) -> ComparedRun:
    """Return the sound pressure of the housing plate of a run."""
    housing = run.housing
    numbers = run.numbers.housing
    if housing is None or numbers is None:
        raise FolderError(f"{run.folder}: {_NO_PRESSURE}")
    highest_hz = min(VELOCITY_BANDS_HZ["high"][1], run.numbers.ring.bending_hz)
    record = faded_record(
        "sound of the housing", housing.pressure, round(run.record.rate_hz), highest_hz, PRESSURE
    )
    spread = replace(unknown_spread(PRESSURE), level_parts=dict(numbers.laeq.parts))
    warnings = [f"the ring of the run is rigid, so it is compared up to {highest_hz:.0f} Hz"]
    if not numbers.laeq.parts:
        warnings.append(_UNKNOWN_LEVEL)
    return ComparedRun(
        records=(ComparedRecord(record, record.seconds, spread),),
        stated=(
            f"levels of the housing plate, which `rolling run` states as {numbers.laeq}"
            f" ({numbers.laeq.verdict})"
        ),
        warnings=tuple(warnings),
    )


def _spread_of_motion(record: Recording, velocities: BandVelocities) -> RunSpread:
    """Return what is uncertain of the levels of the ring along an axis.

    Third octaves have the parts of the velocity in the band of ISO 15242 around them, those below
    and above the parts of the nearest one. The parts of the total follow by power, because a wrong
    gain changes all third octaves of a band in the same sense.
    """
    band_parts: dict[str, Array] = {}
    for band, velocity in velocities.by_band.items():
        is_inside = _is_of_band(band)
        for source, part_db in velocity.parts.items():
            parts = band_parts.setdefault(source, np.zeros(len(BAND_NAMES)))
            parts[is_inside] = part_db
    levels = sound_levels(record.samples, round(len(record.samples) / record.seconds), closed=False)
    powers = _powers([levels.third_octave_db[name] for name in BAND_NAMES])
    powers = np.where(EDGES_HZ[1:] <= record.highest, powers, 0.0)
    whole = float(powers.sum()) or 1.0
    return replace(
        unknown_spread(record.quantity),
        level_parts={source: float(powers @ part) / whole for source, part in band_parts.items()},
        band_parts=band_parts,
    )


def _is_of_band(band: str) -> NDArray[np.bool_]:
    """Tell which third octaves (31,) count with a band of ISO 15242."""
    first_hz, last_hz = VELOCITY_BANDS_HZ[band]
    if band == "low":
        first_hz = 0.0
    if band == "high":
        last_hz = math.inf
    return (first_hz <= MID_HZ) & (last_hz > MID_HZ)


def _powers(levels_db: Iterable[float | None]) -> Array:
    """Return the powers of third octaves (31,) from their levels, 0 where one is unknown."""
    return np.array([0.0 if level is None else 10 ** (level / 10) for level in levels_db])
