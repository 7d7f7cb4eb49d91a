"""Units in which vibration is recorded, each with its quantity."""

from __future__ import annotations

from typing import NamedTuple

from rolling.recordings.recorded import QUANTITIES
from rolling.scene.messages import nearest
from rolling.terminal.whole_files import FolderError

STANDARD_GRAVITY_M_S2 = 9.80665


class RecordedUnit(NamedTuple):
    """A unit of recorded numbers.

    quantity : str. Name of its quantity.
    si : float. Its value in the SI unit of the quantity.
    """

    quantity: str
    si: float


UNITS = {
    "m/s2": RecordedUnit("acceleration", 1.0),
    "mm/s2": RecordedUnit("acceleration", 1e-3),
    "g": RecordedUnit("acceleration", STANDARD_GRAVITY_M_S2),
    "m/s": RecordedUnit("velocity", 1.0),
    "mm/s": RecordedUnit("velocity", 1e-3),
    "um/s": RecordedUnit("velocity", 1e-6),
    "in/s": RecordedUnit("velocity", 0.0254),
    "m": RecordedUnit("displacement", 1.0),
    "mm": RecordedUnit("displacement", 1e-3),
    "um": RecordedUnit("displacement", 1e-6),
    "N": RecordedUnit("force", 1.0),
    "Pa": RecordedUnit("pressure", 1.0),
}


def unit_of(name: str, quantity: str | None, calibration: str | None) -> RecordedUnit:
    """Return a unit by its name.

    Parameters
    ----------
    name : str. A name of UNITS.
    quantity, calibration : str or None. What else is said of the recording.

    Raises
    ------
    FolderError : there is no such unit, it is one of another quantity, or the recording has a
        calibration too.
    """
    if name not in UNITS:
        near = nearest(name, [*UNITS])
        raise FolderError(f"--unit: got {name}{near}, allowed: {', '.join(UNITS)}")
    unit = UNITS[name]
    assert unit.quantity in QUANTITIES
    if quantity is not None and quantity != unit.quantity:
        raise FolderError(
            f"--unit: got {name}, a unit of {unit.quantity}, with --quantity {quantity}; leave one"
            " of them out"
        )
    if calibration is not None:
        raise FolderError(
            "--unit: got a unit and a --calibration, allowed: one of them, because both say what"
            " the numbers of the recording are"
        )
    return unit
