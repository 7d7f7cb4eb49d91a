"""The numbers of a housing plate: its levels with their ±, and the force and velocity behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from acoustics import wav
from acoustics.bands import BAND_NAMES
from acoustics.uncertainty import LevelUncertainty, level_uncertainty
from rolling.bearing.band_uncertainty import RECORD
from rolling.bearing.ring_record import UM_S
from rolling.bearing_kind.housing import HousingSound
from rolling.bearing_kind.octave_parts import octave_parts, parts_of_total, powers_of
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.bearing_kind.velocities import spread_doubt
from rolling.numbers.bearing_numbers import HOUSING, BandVelocities, HousingNumbers
from rolling.numbers.doubt import Doubt
from rolling.numbers.quantity import BandQuantity, Quantity, RecordOfNumber, joined


def housing_numbers(
    bearing: SolvedBearing, radial: BandVelocities, doubts: Sequence[Doubt]
) -> HousingNumbers | None:
    """Return the sound of the housing plate, None for a scene without one.

    Parameters
    ----------
    bearing : SolvedBearing
        Motion of the ring, and the sound of the plate.
    radial : BandVelocities
        Radial velocity of the ring, whose parts of the ± the sound has.
    doubts : sequence of Doubt
        Doubts about the run.
    """
    sound = bearing.housing
    if sound is None:
        return None
    return HousingNumbers(
        laeq=_laeq(bearing, sound, radial, doubts),
        third_octaves=_third_octaves(sound, radial),
        distance_m=bearing.scene.sound.distance_m,
        force_n=float(sound.force_n.std()),
        velocity_um_s=UM_S * float(sound.velocity_m_s.std()),
    )


def _laeq(
    bearing: SolvedBearing, sound: HousingSound, radial: BandVelocities, doubts: Sequence[Doubt]
) -> Quantity:
    """Return LAeq of the plate, with the parts of the velocity of the ring in each third octave.

    Its record has a part of its own, because the plate chooses other lines than the ring.
    """
    level_db = sound.levels.laeq_db
    duration_s = bearing.record.duration_s
    parts: dict[str, float] = {}
    about: list[Doubt] = []
    if level_db is not None:
        parts = parts_of_total(octave_parts(radial), powers_of(sound.levels.third_octave_a_db))
        parts[RECORD] = _spreads(sound).laeq_db or 0.0
        about = [spread_doubt(joined(parts))]
    distance_m = bearing.scene.sound.distance_m
    laeq = Quantity(
        name=HOUSING,
        value=level_db,
        unit="dB(A)",
        measure="LAeq",
        uncertainty=joined(parts) if parts else None,
        parts=parts,
        record=RecordOfNumber(heard_s=duration_s, solved_s=duration_s, repeats=False),
        where=f"at {distance_m:g} m from the plate",
        meaning="A-weighted level of the housing plate that the ring shakes",
        reason="the plate does not move" if level_db is None else "",
    )
    return laeq.with_doubts([*about, *doubts])


def _third_octaves(sound: HousingSound, radial: BandVelocities) -> BandQuantity:
    """Return the third octaves of the plate, with those parts and that of their record."""
    levels_db = sound.levels.third_octave_db
    of_record = _spreads(sound).third_octave_db
    parts = octave_parts(radial)
    parts[RECORD] = np.array([of_record[name] or 0.0 for name in BAND_NAMES])
    whole = np.sqrt(np.sum([np.square(decibels) for decibels in parts.values()], axis=0))
    spreads = {
        name: None if levels_db[name] is None else float(decibels)
        for name, decibels in zip(BAND_NAMES, whole, strict=True)
    }
    bands = BandQuantity.of(levels_db, "dB", spreads)
    return replace(bands, parts={source: tuple(part.tolist()) for source, part in parts.items()})


def _spreads(sound: HousingSound) -> LevelUncertainty:
    """Return what the length of the record leaves uncertain of the levels of a plate."""
    return level_uncertainty(sound.pressure, wav.SAMPLE_RATE_HZ, sound.levels, own_factor=False)
