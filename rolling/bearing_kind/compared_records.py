"""Records of the run of a bearing that recordings are compared with: its ring, and its housing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acoustics.bands import EDGES_HZ
from acoustics.level import SoundLevels, sound_levels
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.kinematics import Kinematics
from rolling.bearing.lines import envelope_lines
from rolling.bearing.ring_record import AXIAL, RADIAL
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.bearing_kind.octave_parts import octave_parts, parts_of_total, powers_of
from rolling.numbers.bearing_numbers import BandVelocities, HousingNumbers
from rolling.recordings.compared_run import (
    ComparedRecord,
    ComparedRun,
    faded_record,
    unknown_spread,
)
from rolling.recordings.read_vibration import VibrationMarks
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
        "velocity": run.record.seen_velocity_m_s,
        "acceleration": run.record.seen_acceleration_m_s2,
    }
    if quantity.name not in of_ring:
        raise FolderError(
            f"{run.folder}: a ring has no channel of {quantity.name}, only {', '.join(of_ring)};"
            " give --quantity one of them"
        )
    highest_hz = min(VELOCITY_BANDS_HZ["high"][1], run.numbers.ring.holds_hz)
    warnings = [_compared_up_to(run, highest_hz)]
    if run.numbers.axial_doubt is not None:
        warnings.append(f"along z: {run.numbers.axial_doubt.line}")
    records = []
    velocity_db = {}
    for axis, samples in zip(DIRECTION_OF, of_ring[quantity.name].T, strict=True):
        record = faded_record(axis, samples, round(run.record.rate_hz), highest_hz, quantity)
        velocities = run.numbers.velocities.by_direction[DIRECTION_OF[axis]]
        spread = _spread_of_motion(record, velocities)
        records.append(ComparedRecord(record, record.seconds, spread))
        of_bands = run.numbers.below_bending.by_direction[DIRECTION_OF[axis]]
        velocity_db[axis] = {
            band: velocity.uncertainty or 0.0 for band, velocity in of_bands.by_band.items()
        }
    marks = VibrationMarks(
        bands_hz=VELOCITY_BANDS_HZ,
        lines_hz=pulse_lines_hz(run.kinematics),
        velocity_db=velocity_db,
    )
    return ComparedRun(records=tuple(records), warnings=tuple(warnings), marks=marks)


def pulse_lines_hz(kinematics: Kinematics) -> dict[str, float]:
    """Return the frequencies of pulses of a bearing by the names of their lines [Hz]."""
    return {line.name: line.frequency_hz for line in envelope_lines(kinematics) if not line.minor}


def _compared_up_to(run: BearingRun, highest_hz: float) -> str:
    """Say up to which frequency a run is compared, and why."""
    if run.numbers.ring.left_out_hz is None:
        return f"the ring of the run is rigid, so it is compared up to {highest_hz:.0f} Hz"
    return f"the ring of the run has no other modes, so it is compared up to {highest_hz:.0f} Hz"


def _sound(run: BearingRun) -> ComparedRun:
    """Return the sound pressure of the housing plate of a run."""
    housing = run.housing
    numbers = run.numbers.housing
    if housing is None or numbers is None:
        raise FolderError(f"{run.folder}: {_NO_PRESSURE}")
    highest_hz = min(VELOCITY_BANDS_HZ["high"][1], run.numbers.ring.holds_hz)
    record = faded_record(
        "sound of the housing", housing.pressure, round(run.record.rate_hz), highest_hz, PRESSURE
    )
    spread = _spread_of_sound(numbers, housing.levels)
    warnings = [_compared_up_to(run, highest_hz)]
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


def _spread_of_sound(numbers: HousingNumbers, levels: SoundLevels) -> RunSpread:
    """Return what is uncertain of the levels of the housing plate; nothing is known of old runs."""
    bands = numbers.third_octaves
    known = [spread is not None for spread in bands.uncertainty_by_name.values()]
    return replace(
        unknown_spread(PRESSURE),
        level_parts=dict(numbers.laeq.parts),
        band_parts={source: np.array(part) for source, part in bands.parts.items()},
        known=np.array(known),
        powers={"Z": powers_of(levels.third_octave_db), "A": powers_of(levels.third_octave_a_db)},
    )


def _spread_of_motion(record: Recording, velocities: BandVelocities) -> RunSpread:
    """Return what is uncertain of the levels of the ring along an axis.

    Third octaves have those of the velocity in the band around them.
    """
    parts = octave_parts(velocities)
    levels = sound_levels(record.samples, round(len(record.samples) / record.seconds), closed=False)
    powers = powers_of(levels.third_octave_db)
    powers = np.where(EDGES_HZ[1:] <= record.highest, powers, 0.0)
    return replace(
        unknown_spread(record.quantity),
        level_parts=parts_of_total(parts, powers),
        band_parts=parts,
    )
