"""Doubts about a run of a bearing: of its contacts, record, damping, scene and motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from acoustics.numbers import rounded
from rolling.bearing import assumed_damping, oil_film
from rolling.bearing.band_uncertainty import FILM_DAMPING, LOSS_FACTOR, SURFACES
from rolling.bearing.ring_record import DIRECTIONS, NOTHING_UM_S, RADIAL
from rolling.bearing_kind.bearing_check import scene_rules
from rolling.bearing_kind.solved_bearing import SolvedBearing
from rolling.numbers.bearing_numbers import HOUSING, RingVelocities
from rolling.numbers.doubt import Doubt, Severity, severity_of, sized
from rolling.scene.bearing_sections import LONGEST_S

_UNCERTAIN_DB = 0.05  # from which on a band is stated as uncertain
_LEAST_DB = 0.1  # effects below it have no sentence
_ENERGY_DB = 10 / math.log(10)


class JudgedBearing(NamedTuple):
    """A bearing about whose numbers there are doubts.

    bearing : SolvedBearing. Motion of the ring.
    rigid, below_bending : RingVelocities. Its velocities in the whole bands and in their parts.
    of_contacts : sequence of Doubt. Doubts about the rough contacts, from their marches.
    """

    bearing: SolvedBearing
    rigid: RingVelocities
    below_bending: RingVelocities
    of_contacts: Sequence[Doubt] = ()


def doubts_of(judged: JudgedBearing) -> list[Doubt]:
    """Return what makes the numbers of a run uncertain, one sentence each."""
    return [doubt for rule in RULES for doubt in rule(judged)]


def moves(um_s: float | None) -> bool:
    """Tell whether a velocity is more than nothing."""
    return um_s is not None and um_s >= NOTHING_UM_S


def of_contacts(judged: JudgedBearing) -> Iterator[Doubt]:
    """Yield the doubts about the rough contacts, which their marches raised."""
    yield from judged.of_contacts


def short_record(judged: JudgedBearing) -> Iterator[Doubt]:
    """Doubt bands that scatter within a short record."""
    bearing = judged.bearing
    uncertain = {
        name: db
        for name, db in bearing.record.bands[RADIAL].uncertainty_db.items()
        if moves(judged.rigid.radial.um_s[name])
    }
    if not uncertain:
        return
    name, largest = max(uncertain.items(), key=lambda item: item[1])
    if largest < _UNCERTAIN_DB:
        return
    longer_s = 4 * bearing.record.duration_s
    advice = "one four times as long halves it"
    if longer_s <= LONGEST_S:
        advice += f", sound.duration_s: {rounded(longer_s, 3)}"
    yield sized(
        "short_record",
        f"the record of {rounded(bearing.record.duration_s, 3)} s leaves ± {largest:.1f} dB in the"
        f" {name} band",
        largest,
        advice,
    )


def assumed_loss_factor(judged: JudgedBearing) -> Iterator[Doubt]:
    """Doubt bands that an assumed loss factor of the contacts moves."""
    bearing = judged.bearing
    if bearing.model.film_time_s > 0:
        return
    parts = [
        velocity.parts[LOSS_FACTOR]
        for bands in judged.rigid.by_direction.values()
        for velocity in bands.by_band.values()
        if LOSS_FACTOR in velocity.parts
    ]
    largest = max(parts, default=0.0)
    if largest < _UNCERTAIN_DB:
        return
    most = assumed_damping.LARGEST_LOSS_FACTOR
    change = assumed_damping.band_change_db(bearing.record, bearing.model, most)
    radial, axial = (
        ", ".join(f"{decibels:+.1f}" for decibels in _without_minus_zero(change[direction]))
        for direction in DIRECTIONS
    )
    yield sized(
        "loss_factor",
        f"the loss factor of the contacts, {bearing.model.contact_loss_factor:g}, is assumed; at"
        f" {most:g}, which a lubricated bearing may have, the three bands would be {radial} dB"
        f" radially and {axial} dB axially",
        largest,
        advice="give bearing.contact_loss_factor as measured, such as by a tap on the ring",
    )


def film_damping(judged: JudgedBearing) -> Iterator[Doubt]:
    """Doubt bands that the viscosity of films of oil moves."""
    bearing = judged.bearing
    if not bearing.model.film_time_s > 0:
        return
    parts = [
        velocity.parts.get(FILM_DAMPING, 0.0)
        for bands in judged.rigid.by_direction.values()
        for velocity in bands.by_band.values()
    ]
    if max(parts) < _UNCERTAIN_DB:
        return
    share = bearing.model.film_time_s / oil_film.TIME_S
    changes = []
    for time in (oil_film.LEAST_TIME_S, oil_film.LARGEST_TIME_S):
        change = assumed_damping.band_change_db(
            bearing.record, bearing.model, film_time_s=share * time
        )
        texts = [f"{decibels:+.1f}" for decibels in _without_minus_zero(change[RADIAL])]
        changes.append(", ".join(texts))
    yield sized(
        "film_damping",
        f"films of oil damp by {1e6 * oil_film.LEAST_TIME_S:g} to"
        f" {1e6 * oil_film.LARGEST_TIME_S:g} us times the stiffness, as was found on rotors; at"
        f" these ends the three bands would be {changes[0]} dB and {changes[1]} dB radially",
        max(parts),
    )


def assumed_surfaces(judged: JudgedBearing) -> Iterator[Doubt]:
    """Doubt bands that assumed waves around balls and raceways move."""
    parts = {
        direction: {
            band: velocity.parts.get(SURFACES, 0.0)
            for band, velocity in judged.rigid.by_direction[direction].by_band.items()
        }
        for direction in DIRECTIONS
    }
    largest = max(max(bands.values()) for bands in parts.values())
    if largest < _UNCERTAIN_DB:
        return
    radial, axial = (
        ", ".join(f"{decibels:.1f}" for decibels in parts[direction].values())
        for direction in DIRECTIONS
    )
    yield sized(
        SURFACES,
        "the waves around balls and raceways are assumed, by a finish or by the limit of a grade,"
        f" which leaves ± {radial} dB in the three bands radially and ± {axial} dB axially",
        largest,
        advice="give measured waves, such as by bearing.surfaces.inner.roundness",
    )


def _without_minus_zero(bands: Mapping[str, float]) -> list[float]:
    """Return decibels with one digit and without a negative zero."""
    return [round(decibels, 1) + 0.0 for decibels in bands.values()]


def of_scene(judged: JudgedBearing) -> Iterator[Doubt]:
    """Yield the doubts that the scene raises; one about a ring that bends has its share."""
    for doubt in scene_rules(judged.bearing.scene):
        if isinstance(doubt, Doubt):
            yield _with_share(judged, doubt) if doubt.key == "ring_bending" else doubt


def _with_share(judged: JudgedBearing, doubt: Doubt) -> Doubt:
    """Return the doubt about a ring that bends, with the part of the high band that it has."""
    whole = judged.rigid.radial.high.value
    below = judged.below_bending.radial.high.value
    if whole is None or below is None or not moves(whole):
        return doubt
    if not below > 0:
        text = f"{doubt.text}; all of the high band lies above"
        return replace(doubt, text=text, severity=Severity.DO_NOT_QUOTE)
    decibels = 20 * math.log10(whole / below)
    text = f"{doubt.text}; what lies above raises the high band by {decibels:.1f} dB"
    return replace(doubt, text=text, severity=severity_of(decibels), decibels=decibels)


def lost_contact(judged: JudgedBearing) -> Iterator[Doubt]:
    """Say that balls lose contact, where an axial load presses all of them."""
    bearing = judged.bearing
    share = bearing.record.lost_contact_share
    if share > 0 and bearing.housing is not None:
        yield Doubt(
            key="housing_linear",
            text=f"balls bear nothing for {rounded(100 * share)} % of the time, and the level of"
            " the housing holds for balls that stay in contact",
            severity=Severity.INDICATIVE,
            about=(HOUSING,),
        )
    if share > 0 and not bearing.scene.radial_load > 0:
        yield Doubt(
            key="lost_contact",
            text=f"a ball bears nothing for {rounded(100 * share)} % of the time",
            severity=Severity.NOTE,
            advice="a larger axial load holds the balls",
        )


def energy_balance(judged: JudgedBearing) -> Iterator[Doubt]:
    """Doubt a motion whose energy does not balance."""
    error = abs(judged.bearing.record.energy_error)
    decibels = _ENERGY_DB * error
    if decibels > _LEAST_DB:
        text = f"the energy of the motion lacks {rounded(100 * error)} %: {decibels:.1f} dB"
        yield sized("energy_balance", text, decibels)


Rule = Callable[[JudgedBearing], Iterator[Doubt]]
RULES: tuple[Rule, ...] = (
    of_contacts,
    short_record,
    assumed_loss_factor,
    film_damping,
    assumed_surfaces,
    of_scene,
    lost_contact,
    energy_balance,
)
