"""Numbers as makers and diagnosticians read them: acceleration, peaks, kurtosis, and a class."""

from __future__ import annotations

import math
from collections.abc import Sequence

from acoustics.impulsiveness import BandPulses, band_pulses
from acoustics.numbers import si
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import vibration_classes
from rolling.bearing.ring_record import NOTHING_UM_S, UM_S
from rolling.bearing.vibration_classes import SOURCE, Velocity
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.numbers.bearing_numbers import (
    MAKERS_REFERENCE_M_S2,
    BandPulseNumbers,
    BandVelocities,
    PulseNumbers,
    VibrationClass,
)

_X = 0  # direction of the radial load, in which a pick-up stands


def pulse_numbers(bearing: SolvedBearing) -> PulseNumbers | None:
    """Return peaks, crest factors and kurtoses of the ring along x; None for a ring at rest.

    Velocities are read in the three bands, and the acceleration from 50 Hz on. All end where the
    ring bends.
    """
    record = bearing.record
    bands_hz = {
        band: edges for band, edges in bearing.bands_below_bending_hz.items() if edges[1] > edges[0]
    }
    if not bands_hz:
        return None
    by_band = band_pulses(record.seen_velocity_m_s[:, _X], record.rate_hz, bands_hz)
    lowest_hz = VELOCITY_BANDS_HZ["low"][0]
    highest_hz = max(high for _, high in bands_hz.values())
    whole = {"all": (lowest_hz, highest_hz)}
    of_all = band_pulses(record.seen_acceleration_m_s2[:, _X], record.rate_hz, whole)["all"]
    if UM_S * max(pulses.rms for pulses in by_band.values()) < NOTHING_UM_S:
        return None
    return PulseNumbers(
        **{band: _of_band(pulses) for band, pulses in by_band.items()},
        lowest_hz=lowest_hz,
        highest_hz=highest_hz,
        acceleration_m_s2=of_all.rms,
        acceleration_db=20 * math.log10(of_all.rms / MAKERS_REFERENCE_M_S2),
        crest_factor=of_all.crest_factor,
        kurtosis=of_all.kurtosis,
        kurtosis_uncertainty=of_all.kurtosis_uncertainty,
    )


def _of_band(pulses: BandPulses) -> BandPulseNumbers:
    """Return the numbers of the velocity in a band."""
    return BandPulseNumbers(
        peak_um_s=UM_S * pulses.peak,
        crest_factor=pulses.crest_factor,
        kurtosis=pulses.kurtosis,
    )


def vibration_class(
    bearing: SolvedBearing, radial: BandVelocities, departures: Sequence[str]
) -> VibrationClass:
    """Return the class of a bearing by the limits of makers, or why it has none.

    Parameters
    ----------
    bearing : SolvedBearing
    radial : BandVelocities
        Radial velocities below the first bending mode of the ring.
    departures : sequence of str
        What the run does otherwise than ISO 15242 asks for.
    """
    bore_mm = 1e3 * bearing.scene.bore
    limits = vibration_classes.limits_of_bore(bore_mm)
    if limits is None:
        return VibrationClass(
            none_because=f"no limits are known for a bore of {bore_mm:g} mm", source=SOURCE
        )
    if departures:
        return VibrationClass(none_because=f"not ISO 15242: {departures[0]}", source=SOURCE)
    known = {}
    for band, velocity in radial.by_band.items():
        is_whole = bearing.bands_below_bending_hz[band][1] >= VELOCITY_BANDS_HZ[band][1]
        if is_whole and velocity.value is not None:
            own = Velocity(velocity.value, velocity.uncertainty or 0.0)
            known[band] = vibration_classes.class_of_band(limits, band, own)
    because = ""
    if len(known) < len(VELOCITY_BANDS_HZ):
        holds = si(bearing.scene.ring_holds_hz, "Hz")
        because = f"the ring bends from {holds} on, so what it has above is not known"
        if bearing.model.bending:
            because = f"the ring lacks modes from {holds} on, so what it has above is not known"
    return VibrationClass(
        **{band: own.words for band, own in known.items()},
        overall=None if because else vibration_classes.class_of_bands(known).words,
        none_because=because or None,
        source=SOURCE,
    )
