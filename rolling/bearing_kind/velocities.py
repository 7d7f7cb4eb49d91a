"""Velocities of the ring as quantities: values by direction and band, with the parts of their ±."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import assumed_damping
from rolling.bearing.assumed_surfaces import surfaces_db
from rolling.bearing.band_uncertainty import (
    FILM_DAMPING,
    LOSS_FACTOR,
    RECORD,
    SURFACES,
    BandUncertainty,
    DecibelsOfBands,
)
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, NOTHING_UM_S, RADIAL, UM_S
from rolling.bearing_kind.bearing_check import contact_angle_doubt
from rolling.bearing_kind.body_forms import assumed_surfaces
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.numbers.bearing_numbers import (
    RMS_VELOCITY,
    UM_PER_S,
    BandVelocities,
    RingVelocities,
)
from rolling.numbers.doubt import Doubt, sized
from rolling.numbers.quantity import Quantity, RecordOfNumber, joined
from rolling.scene.bearing_sources import has_assumed_loss_factor

DECIBELS = "dB"  # unit of the ± of a velocity
OF_SPREAD = "uncertainty"  # key of the doubt that a ± alone raises
_RIGID = "of a ring that stays rigid"
_BELOW = "up to the first bending mode of the ring"
BELOW_BENDING = "_below_bending"  # end of the names of velocities of parts of bands
_VelocitiesUmS = Mapping[str, Mapping[str, float]]


class _Velocities(NamedTuple):
    """Velocities [um/s] and the parts of their ±, by direction and band."""

    um_s: _VelocitiesUmS
    uncertainty: BandUncertainty
    end: str
    place: str


def rigid_velocities(bearing: SolvedBearing, of_contacts: BandUncertainty) -> RingVelocities:
    """Return the velocities of the ring in the whole bands, as it is without further modes.

    Parameters
    ----------
    bearing : SolvedBearing
        Motion of the ring.
    of_contacts : BandUncertainty
        Parts of the ± that come from the rough contacts.
    """
    um_s = _whole_um_s(bearing)
    whole = _Velocities(
        um_s=um_s,
        uncertainty=_uncertainty(bearing, of_contacts, um_s, VELOCITY_BANDS_HZ),
        end="",
        place="with what it lacks above its modes" if bearing.model.bending else _RIGID,
    )
    return _quantities(bearing, whole)


def velocities_below_bending(
    bearing: SolvedBearing, of_contacts: BandUncertainty
) -> RingVelocities:
    """Return the velocities in the parts of the bands below the first mode that the ring lacks.

    A part has the share of the power of its band that it has in the narrow spectrum. The parts of
    its ± are those of the whole band, but for those of assumed values, which depend on what is
    below: a resonance, and waves. Parameters are those of `rigid_velocities`.
    """
    um_s = _um_s_below_bending(bearing)
    below = _Velocities(
        um_s=um_s,
        uncertainty=_uncertainty(bearing, of_contacts, um_s, bearing.bands_below_bending_hz),
        end=BELOW_BENDING,
        place="up to the first mode that is left out" if bearing.model.bending else _BELOW,
    )
    return _quantities(bearing, below)


# ---- values


def _whole_um_s(bearing: SolvedBearing) -> dict[str, dict[str, float]]:
    """Return the velocities in the whole bands [um/s]."""
    return {
        direction: {name: UM_S * rms for name, rms in bands.rms_m_s.items()}
        for direction, bands in bearing.record.bands.items()
    }


def _um_s_below_bending(bearing: SolvedBearing) -> dict[str, dict[str, float]]:
    """Return the velocities in the parts of the bands below the bending [um/s]."""
    whole_um_s = _whole_um_s(bearing)
    velocities: dict[str, dict[str, float]] = {}
    for direction, spectrum in bearing.record.spectra.items():
        velocities[direction] = {}
        square = np.square(spectrum.rms)
        for band, (low, high) in VELOCITY_BANDS_HZ.items():
            inside = (spectrum.frequency_hz >= low) & (spectrum.frequency_hz < high)
            below = spectrum.frequency_hz < bearing.bands_below_bending_hz[band][1]
            whole = float(square[inside].sum())
            share = float(square[inside & below].sum()) / whole if whole > 0 else 1.0
            velocities[direction][band] = math.sqrt(share) * whole_um_s[direction][band]
    return velocities


# ---- uncertainty


def _uncertainty(
    bearing: SolvedBearing,
    of_contacts: BandUncertainty,
    um_s: _VelocitiesUmS,
    bands_hz: Mapping[str, tuple[float, float]],
) -> BandUncertainty:
    """Return the parts of the ± of bands with these velocities and edges."""
    of_record = {
        direction: bearing.record.bands[direction].uncertainty_db for direction in DIRECTIONS
    }
    parts = of_contacts.with_part(RECORD, of_record)
    record, model = bearing.record, bearing.model
    if model.film_time_s > 0:
        damping_db = assumed_damping.film_damping_db(record, model, bands_hz)
        parts = parts.with_part(FILM_DAMPING, _of_moving(bearing, damping_db))
    elif has_assumed_loss_factor(bearing.scene):
        damping_db = assumed_damping.loss_factor_db(record, model, bands_hz)
        parts = parts.with_part(LOSS_FACTOR, _of_moving(bearing, damping_db))
    surfaces = assumed_surfaces(bearing.scene)
    if surfaces:
        velocity_m_s = {
            direction: {band: value / UM_S for band, value in bands.items()}
            for direction, bands in um_s.items()
        }
        decibels = surfaces_db(surfaces, bearing.model, velocity_m_s, bands_hz)
        parts = parts.with_part(SURFACES, decibels)
    return parts


def _of_moving(bearing: SolvedBearing, decibels: DecibelsOfBands) -> DecibelsOfBands:
    """Return what is uncertain in bands [dB], 0 in those at rest."""
    whole_um_s = _whole_um_s(bearing)
    return {
        direction: {
            band: value if whole_um_s[direction][band] >= NOTHING_UM_S else 0.0
            for band, value in bands.items()
        }
        for direction, bands in decibels.items()
    }


# ---- quantities


def _quantities(bearing: SolvedBearing, velocities: _Velocities) -> RingVelocities:
    """Return velocities as quantities."""
    return RingVelocities(
        radial=_of_direction(bearing, velocities, RADIAL),
        axial=_of_direction(bearing, velocities, AXIAL),
    )


def _of_direction(
    bearing: SolvedBearing, velocities: _Velocities, direction: str
) -> BandVelocities:
    """Return the velocities of a direction as quantities."""
    bands = {band: _quantity(bearing, velocities, direction, band) for band in VELOCITY_BANDS_HZ}
    return BandVelocities(**bands)


def _quantity(
    bearing: SolvedBearing, velocities: _Velocities, direction: str, band: str
) -> Quantity:
    """Return the velocity of a direction in a band as a quantity.

    Its ± decides how far it is to be trusted, and for an axial one also an angle that the loads
    would turn.
    """
    name = f"{direction}_{band}{velocities.end}"
    parts = velocities.uncertainty.of_band(direction, band)
    duration_s = bearing.record.duration_s
    angle = contact_angle_doubt(bearing.scene)
    doubts = [spread_doubt(joined(parts))]
    if angle is not None and angle.touches(name):
        doubts.append(angle)
    return Quantity(
        name=name,
        value=velocities.um_s[direction][band],
        unit=UM_PER_S,
        measure=RMS_VELOCITY,
        uncertainty=joined(parts),
        uncertainty_unit=DECIBELS,
        parts=parts,
        record=RecordOfNumber(heard_s=duration_s, solved_s=duration_s, repeats=False),
        where=f"{bearing.moving} ring, {direction}",
        meaning=f"rms velocity of the {bearing.moving} ring in the {band} band, {velocities.place}",
        doubts=tuple(doubts),
    )


def spread_doubt(decibels: float) -> Doubt:
    """Return the doubt that the ± of a velocity alone raises."""
    return sized(OF_SPREAD, f"the parts of its ± make {decibels:.1f} dB", decibels)
