"""Doubts about the contacts of a bearing: their sum, their mean, yielding, and what is not marched.

Each rule was read from marches of both surfaces together and of each alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from acoustics.numbers import rounded
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import waves
from rolling.bearing.band_uncertainty import WINDOW, BandUncertainty
from rolling.bearing.ring_record import AXIAL, RADIAL
from rolling.bearing_kind.body_forms import form_of
from rolling.bearing_kind.contact_plan import (
    RINGS,
    ContactPlan,
    contact_of,
    kinds_of_contact,
    law_of,
    radius_of,
)
from rolling.bearing_kind.contact_uncertainty import is_whole_turn, track_length_m
from rolling.bearing_kind.joined_tracks import rough_rows
from rolling.bearing_kind.rough_contacts import RoughContact
from rolling.marches.piece import contact_identity
from rolling.numbers.bearing_numbers import MarchedContact
from rolling.numbers.doubt import Doubt, Severity, sized
from rolling.run.march_files import ContactMarch, Marches
from rolling.scene.laws import AUTOCORRELATIONS, Roughness
from rolling.scene.surfaces import BallHeightFile
from rolling.surface.ball_form import form_heights

# Error of the level of the approach where both surfaces are marched alone [dB], over the root of
# their rms roughness over the smooth approach. It was read from 16 contacts of a 6204, and held on
# eight others (608, 6305, 7210; 2 to 60 N; Ra 0.02 to 0.4 um; exponential and skewed).
SUPERPOSITION_DB = 1.2
# A contact of a 6204 (42 N) followed waves of 100 to 1,000 um by its linear response within 2 % up
# to half of the Hertz pressure, and lost 0.2 to 1.2 dB at once and 4 dB at twice the pressure.
BRIDGED = 0.5  # pressure that presses waves flat over Hertz's, from which on it is a doubt
BRIDGED_DB = 1.0  # loss at a ratio of one [dB], which grows with its square
FORM_POINTS = 2**14  # of a turn, which hold waves as short as any contact
COARSE_DB = 0.3  # from which on nodes that are too far apart are a doubt
SOFTER = 0.03  # change of the mean stiffness beside Hertz's, from which on it is a doubt


def marched_contacts(plan: ContactPlan, marches: Marches) -> list[MarchedContact]:
    """Return the numbers of the rough contacts whose marches are there."""
    contacts = []
    for contact in plan.rough.values():
        by_load: dict[float, ContactMarch] = {}
        for load, scene in contact.scenes.items():
            march = marches.get(contact_identity(scene))
            if march is not None:
                by_load[load] = march
        middle = contact.middle_load_n
        if middle not in by_load:
            continue
        contacts.append(_numbers(contact, middle, by_load, marches))
    return contacts


def _numbers(
    contact: RoughContact, middle: float, by_load: dict[float, ContactMarch], marches: Marches
) -> MarchedContact:
    """Return the numbers of a contact at its middle load."""
    place = contact.loads_n.index(middle)
    marched = float(np.std(rough_rows(contact, marches)[place]))
    linear = float(np.std(contact.linear_rows([middle])))
    hertz = waves.hertz_approach(contact.contact, middle)
    means = {load: float(march.approach_m.mean()) for load, march in by_load.items()}
    change = None
    low = contact.loads_n[max(place - 1, 0)]
    high = contact.loads_n[min(place + 1, len(contact.loads_n) - 1)]
    if low < high and low in means and high in means:
        smooth = waves.hertz_approach(contact.contact, high)
        smooth -= waves.hertz_approach(contact.contact, low)
        change = smooth / (means[high] - means[low]) - 1
    return MarchedContact(
        name=contact.name,
        load_n=middle,
        approach_rms_m=marched,
        linear_db=20 * math.log10(linear / marched),
        approach_loss=means[middle] / hertz - 1,
        stiffness_change=change,
        max_pressure_pa=max(march.max_pressure_pa for march in by_load.values()),
        march_cpu_s=sum(march.effort.march_s for march in by_load.values()),
    )


def contact_doubts(
    plan: ContactPlan, marches: Marches, hardness_pa: float, uncertainty: BandUncertainty
) -> tuple[Doubt, ...]:
    """Return the doubts about the contacts of a bearing whose marches are there.

    Parameters
    ----------
    plan : ContactPlan
        Contacts.
    marches : dict
        Marches by contact identity.
    hardness_pa : float, Pa
        Hardness of rings and balls, infinite where it is unknown.
    uncertainty : BandUncertainty
        Parts of the uncertainty of the bands that come from the contacts.
    """
    contacts = JudgedContacts(plan, marched_contacts(plan, marches), hardness_pa, uncertainty)
    return tuple(doubt for rule in RULES for doubt in rule(contacts))


class JudgedContacts(NamedTuple):
    """The contacts of a bearing about which there are doubts.

    plan : ContactPlan. All contacts.
    marched : list of MarchedContact. Numbers of those that were marched.
    hardness_pa : float, Pa. Hardness of rings and balls, infinite where it is unknown.
    uncertainty : BandUncertainty. Parts of the uncertainty of the bands that come from them.
    """

    plan: ContactPlan
    marched: list[MarchedContact]
    hardness_pa: float
    uncertainty: BandUncertainty


def superposition(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State the error of adding the approaches of both surfaces of a contact."""
    plan = contacts.plan
    balls = plan.surfaces["balls"]
    ball_law = None if balls is None else law_of(balls)
    worst = 0.0
    for ring in RINGS:
        surface = plan.surfaces[ring]
        ring_law = None if surface is None else law_of(surface)
        if ball_law is None or ring_law is None:
            continue
        film = plan.films.get(ring)
        if film is not None and film.weight >= 1:  # what is linear adds
            continue
        middle = plan.loads_n[len(plan.loads_n) // 2]
        approach = waves.hertz_approach(contact_of(plan.geometry, ring), middle)
        worst = max(worst, math.hypot(ball_law.rq_m, ring_law.rq_m) / approach)
    if worst:
        decibels = SUPERPOSITION_DB * math.sqrt(worst)
        yield sized(
            "superposition",
            "the roughness of balls and that of raceways are solved one by one and added, which is"
            f" uncertain by {rounded(decibels)} dB, by a rule for a rms roughness of"
            f" {rounded(100 * worst)} % of the approach",
            decibels,
        )


def coarse_nodes_db(law: Roughness, spacing_um: float) -> float:
    """Return how much nodes that are too far apart raise the level of long waves [dB].

    A contact averages roughness over many correlation lengths. The mean square of the average
    follows the integral of the autocorrelation, for which nodes have a sum.
    """
    decay, exponent = AUTOCORRELATIONS[law.autocorrelation]
    ratio = 1.0
    for length_um in law.lengths_um:
        step = spacing_um / length_um
        reach = np.arange(1, math.ceil(40 / step) + 2) * step
        total = step * (1 + 2 * np.exp(-decay * reach**exponent).sum())
        ratio *= total / (2 * math.gamma(1 + 1 / exponent) / decay ** (1 / exponent))
    return 10 * math.log10(ratio)


def coarse_nodes(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State that nodes are too far apart for the roughness."""
    for contact in contacts.plan.rough.values():
        law = contact.scene.surface.law
        if not isinstance(law, Roughness):
            continue
        decibels = coarse_nodes_db(law, contact.scene.spacing_um)
        if decibels > COARSE_DB:
            yield sized(
                "contact_nodes",
                f"{contact.name}: nodes of {rounded(contact.scene.spacing_um)} um are too far apart"
                f" for a correlation length of {rounded(min(law.lengths_um))} um, which raises the"
                f" approach by up to {rounded(decibels)} dB",
                decibels,
                advice="choose a smaller numerics.spacing_um, which takes longer",
            )


def steep_waves(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State that a contact bridges waves around a body, which enter by its linear response."""
    plan = contacts.plan
    lightest = plan.loads_n[0]
    for body, surface in plan.surfaces.items():
        if surface is None or not surface.has_form:
            continue
        profile = form_heights(form_of(surface, plan.folder), FORM_POINTS)
        for name in kinds_of_contact(body):
            contact = contact_of(plan.geometry, name)
            pressure = waves.wave_pressure(contact, profile, radius_of(plan.geometry, body))
            ratio = pressure / waves.hertz_pressure(contact, lightest)
            if ratio > BRIDGED:
                yield sized(
                    "steep_waves",
                    f"{name}: waves around the body would take {rounded(ratio)} times the pressure"
                    f" of the contact at {rounded(lightest)} N to be pressed flat, so it bridges"
                    " their valleys; they enter by its linear response",
                    BRIDGED_DB * ratio**2,
                )


def window_scatter_db(length_m: float, speed_m_s: float, band_hz: tuple[float, float]) -> float:
    """Return the standard deviation of a level that is known from a stretch of a surface [dB].

    A band of a stretch has as many waves as its width allows, of which about half carry the power,
    and the mean square of N random waves scatters by 1 / sqrt(N).
    """
    low, high = band_hz
    count = max(length_m * (high - low) / speed_m_s / 2, 1.0)
    return 10 / math.log(10) / math.sqrt(count)


def short_windows(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State the scatter of levels whose roughness is known from a stretch of track only."""
    plan = contacts.plan
    part = contacts.uncertainty.parts_db.get(WINDOW)
    short = [contact for contact in plan.rough.values() if not is_whole_turn(plan, contact)]
    if part is None or not short:
        return
    shortest = min(short, key=track_length_m)
    length = track_length_m(shortest)
    speed = shortest.scene.motion.fastest(shortest.scene.duration)
    own = {
        band: rounded(window_scatter_db(length, speed, VELOCITY_BANDS_HZ[band]))
        for band in ("high", "medium")
    }
    radial, axial = (
        ", ".join(f"{decibels:.1f}" for decibels in part[direction].values())
        for direction in (RADIAL, AXIAL)
    )
    yield sized(
        "window",
        f"roughness is known from {rounded(length * 1e3)} mm of track, and goes on at random: its"
        f" own level scatters by {own['high']} dB in the high band and by {own['medium']} dB in the"
        " medium band; with what else moves the ring, and with its resonances, which few waves"
        f" meet, that leaves ± {radial} dB in the three bands radially and ± {axial} dB axially",
        max(max(bands.values()) for bands in part.values()),
        advice="choose a longer numerics.window_mm, which takes longer",
    )


def narrow_turns(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State that measured turns narrower than a contact enter by the linear response alone."""
    plan = contacts.plan
    for body, surface in plan.surfaces.items():
        if isinstance(surface, BallHeightFile) and kinds_of_contact(body)[0] not in plan.rough:
            yield Doubt(
                "narrow_turn",
                f"the measured heights of {body} are narrower than the contact, so they are"
                " repeated across, and enter by the linear response of the contact",
                Severity.INDICATIVE,
                advice="give a single line, or a wider measurement",
            )


def unmarched(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State that contacts are not marched, so that the linear response stands in their place."""
    marched = {contact.name for contact in contacts.marched}
    needed = {name for name in contacts.plan.rough if not contacts.plan.is_parted(name)}
    missing = sorted(needed - marched)
    if missing:
        yield Doubt(
            "unmarched_contacts",
            f"{', '.join(missing)}: the roughness enters by the linear response of the contact,"
            " because its march is not there",
            Severity.INDICATIVE,
        )


def marched(contacts: JudgedContacts) -> Iterator[Doubt]:
    """State what the march of each rough contact shows against the motion and the hardness."""
    for contact in contacts.marched:
        yield from _stiffness(contact)
        yield from _yielding(contact, contacts.hardness_pa)


def _stiffness(contact: MarchedContact) -> Iterator[Doubt]:
    """State how much a rough contact is softer than Hertz's, which the motion takes."""
    change = contact.stiffness_change
    if change is None or abs(change) <= SOFTER:
        return
    word = "softer" if change < 0 else "stiffer"
    yield sized(
        "rough_stiffness",
        f"{contact.name}: roughness makes the contact {rounded(100 * abs(change))} % {word} than"
        " the smooth contact that the motion takes",
        20 * math.log10(1 + abs(change)),
    )


def _yielding(contact: MarchedContact, hardness_pa: float) -> Iterator[Doubt]:
    """State that the highest peaks would yield, which an elastic march leaves out."""
    if contact.max_pressure_pa <= hardness_pa:
        return
    yield Doubt(
        "yielding_peaks",
        f"{contact.name}: peaks bear up to {rounded(contact.max_pressure_pa * 1e-9)} GPa, above the"
        f" hardness of {rounded(hardness_pa * 1e-9)} GPa; they are marched as elastic",
        Severity.INDICATIVE,
    )


Rule = Callable[[JudgedContacts], Iterator[Doubt]]
RULES: tuple[Rule, ...] = (
    superposition,
    narrow_turns,
    coarse_nodes,
    steep_waves,
    short_windows,
    unmarched,
    marched,
)
