"""What the rough contacts leave uncertain in the bands of a ring, weighted by what they make of it.

By linear theory the roughness of a kind of contact moves the ring in proportion to the level of its
approach at each frequency, the stiffness of the balls and the mobility of the ring. A part of a
band that is uncertain by some decibels makes the band uncertain by its share of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.continued_rows import drawn_lines
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing import waves
from rolling.bearing.band_uncertainty import (
    FILM,
    LINEAR,
    ONE_LOAD,
    WINDOW,
    BandUncertainty,
    DecibelsOfBands,
)
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import AXIAL, DIRECTIONS, RADIAL, RingRecord
from rolling.bearing_kind.contact_plan import ContactPlan, body_of, radius_of
from rolling.bearing_kind.joined_tracks import (
    BETWEEN_LAWS,
    CIRCULAR_LAW,
    LINE_LAW,
    acting_rows,
)
from rolling.bearing_kind.rough_contacts import RoughContact
from rolling.in_si.scene_surface import heights
from rolling.marches.piece import contact_identity
from rolling.run.march_files import Marches
from rolling.scene.laws import Roughness

WHOLE_TURN = 0.99  # of a turn, from which on a stretch is all of it
STEP_HZ = 4.0  # between frequencies at which the mobility of the ring is taken
# Error of the level of a band where a rough contact is linear [dB], over the root of its rms
# roughness over the approach, and its largest value. It was read from marches of the inner contact
# of a 6204 (axial loads of 20, 70 and 400 N), a 608 and a 6305 (70 N) over Ra 0.02 to 0.2 um, with
# lengths of 60 by 10 and of 20 um: rms differences of six bands of 0.2 to 1.8 dB
# (`tests/benchmarks/linear_study.py`).
LINEAR_DB = 4.0
LARGEST_LINEAR_DB = 2.0
# Power of the load by which balls dip deeper into a pit: the rms of six pits of a 6205 of 0.18 to
# 0.53 mm, under 14 to 228 N, which have 0.04 to 0.22 (`tests/benchmarks/pit_budget.py dips`).
DIP_EXPONENT = 0.12
_DECIBELS = 10 / math.log(10)  # of a relative change of a mean square


class RoughnessPower(NamedTuple):
    """Power with which the roughness of a kind of contact moves the ring, by linear theory.

    frequency_hz : array (n,), Hz. Equally spaced frequencies, up to 10 kHz.
    density : dict. Mean square of the velocity in each step of frequency [(m/s)^2], (n,), by
        direction.
    line_hz : float, Hz. Distance of the lines of the stretch that is known.
    """

    frequency_hz: Array
    density: Mapping[str, Array]
    line_hz: float

    def of_band(self, direction: str, band: str) -> Array:
        """Return the density in a band, and zeros beside it."""
        low, high = VELOCITY_BANDS_HZ[band]
        inside = (self.frequency_hz >= low) & (self.frequency_hz < high)
        return np.where(inside, self.density[direction], 0.0)


def track_length_m(contact: RoughContact) -> float:
    """Return the length of track [m] on which a contact is marched."""
    return contact.steps * contact.scene.step


def is_whole_turn(plan: ContactPlan, contact: RoughContact) -> bool:
    """Tell whether a contact is marched around its whole body."""
    turn = 2 * math.pi * radius_of(plan.geometry, body_of(contact.name))
    return track_length_m(contact) >= WHOLE_TURN * turn


def roughness_powers(
    plan: ContactPlan,
    marches: Marches,
    model: BearingModel,
    law: str = BETWEEN_LAWS,
    weight: float | None = None,
) -> dict[str, RoughnessPower]:
    """Return the power with which the roughness of each kind of contact moves the ring.

    Balls meet a random roughness at places of their own, so the powers of their forces add. `law`
    and `weight` are those of films, as of `acting_rows`.
    """
    frequency_hz = shown_hz()
    gain = velocity_per_approach(model, frequency_hz)
    powers = {}
    for name, contact in plan.rough.items():
        rows = acting_rows(plan, contact, marches, law, weight)
        row = rows[contact.loads_n.index(contact.middle_load_n)]
        line_hz = model.kinematics.rolling_speed_m_s / track_length_m(contact)
        lines = np.square(np.abs(np.fft.rfft(row))) * 2 / len(row) ** 2
        number = np.clip(np.rint(frequency_hz / line_hz).astype(int), 1, len(lines) - 1)
        approach = lines[number] * STEP_HZ / line_hz
        density = {direction: gain[direction] * approach for direction in DIRECTIONS}
        powers[name] = RoughnessPower(frequency_hz, density, line_hz)
    return powers


def shown_hz() -> Array:
    """Return the frequencies [Hz] at which powers are taken, below the end of the high band."""
    return np.arange(STEP_HZ, VELOCITY_BANDS_HZ["high"][1], STEP_HZ)


def velocity_per_approach(model: BearingModel, frequency_hz: Array) -> dict[str, Array]:
    """Return the mean square of the ring's velocity over that of the approach of a contact [1/s2].

    All balls have an approach of this mean square, each at random. By direction, (n,).
    """
    forces = _force_per_approach(model)
    mobility = linear_ring(model).mobility(frequency_hz)
    velocity = mobility @ forces @ np.conj(np.swapaxes(mobility, 1, 2))
    squares = np.real(np.diagonal(velocity, axis1=1, axis2=2))
    return {RADIAL: squares[:, model.radial].sum(axis=1) / 2, AXIAL: squares[:, 2]}


def _force_per_approach(model: BearingModel) -> Array:
    """Return the sum over the balls of their stiffness squared along their lines [N2/m2], (m, m).

    It is the mean over places of the cage.
    """
    geometry = model.geometry
    total = np.zeros((len(model.columns), len(model.columns)))
    balances = model.balances()
    for balance in balances:
        stiffness = 1.5 * geometry.series_stiffness ** (2 / 3) * balance.ball_load_n ** (1 / 3)
        forces = stiffness[:, None] * balance.ways[:, model.columns]
        total += forces.T @ forces
    return total / len(balances)


def roughness_shares(
    powers: Mapping[str, RoughnessPower], record: RingRecord
) -> dict[str, dict[str, dict[str, float]]]:
    """Return which share of the power of a band each kind of contact has, by direction and band.

    What is left is form, waves and faults. All shares together are 1 at most.
    """
    shares: dict[str, dict[str, dict[str, float]]] = {
        name: {direction: {} for direction in DIRECTIONS} for name in powers
    }
    for direction in DIRECTIONS:
        for band, rms in record.bands[direction].rms_m_s.items():
            own = {name: power.of_band(direction, band).sum() for name, power in powers.items()}
            whole = max(rms**2, sum(own.values()), np.finfo(float).tiny)
            for name, value in own.items():
                shares[name][direction][band] = float(value / whole)
    return shares


def contact_uncertainty(
    plan: ContactPlan, marches: Marches, model: BearingModel, record: RingRecord
) -> BandUncertainty:
    """Return the parts of the uncertainty of the bands that come from the rough contacts.

    Parameters
    ----------
    plan : ContactPlan
        Contacts of the bearing.
    marches : dict
        Marches by contact identity.
    model : BearingModel
        Bearing.
    record : RingRecord
        Motion of its ring.
    """
    powers = roughness_powers(plan, marches, model)
    shares = roughness_shares(powers, record)
    uncertainty = BandUncertainty()
    short = [name for name, contact in plan.rough.items() if not is_whole_turn(plan, contact)]
    if short:
        uncertainty = uncertainty.with_part(WINDOW, _window_db(short, powers, shares))
    linear_db = {}
    for name, contact in plan.rough.items():
        if contact_identity(contact.scene) not in marches and not plan.is_parted(name):
            linear_db[name] = linear_contact_db(contact)
    if linear_db:
        uncertainty = uncertainty.with_part(LINEAR, _of_shares(linear_db, shares))
    if plan.faults and not plan.has_faults_at_all_loads(marches):
        one_load_db = faults_at_one_load_db(plan, model)
        bands = dict.fromkeys(VELOCITY_BANDS_HZ, one_load_db)
        uncertainty = uncertainty.with_part(ONE_LOAD, dict.fromkeys(DIRECTIONS, bands))
    if plan.films and powers:
        changes = _FilmChanges(plan, marches, model, powers, record)
        uncertainty = uncertainty.with_part(FILM, changes.decibels)
    return uncertainty


def linear_contact_db(contact: RoughContact) -> float:
    """Return what the linear response of a rough contact leaves uncertain in a band [dB]."""
    law = contact.scene.surface.law
    rms_m = law.rq_m if isinstance(law, Roughness) else float(np.std(heights(contact.scene)))
    approach_m = waves.hertz_approach(contact.contact, contact.middle_load_n)
    return min(LINEAR_DB * math.sqrt(rms_m / approach_m), LARGEST_LINEAR_DB)


def faults_at_one_load_db(plan: ContactPlan, model: BearingModel) -> float:
    """Return what faults that are marched at one load leave uncertain in a band [dB].

    It is that of a band which the faults alone make. Loads of the balls count by their size,
    because a loaded ball moves the ring more, and lighter ones than the least marched load as it.
    """
    loads = np.concatenate([np.ravel(balance.ball_load_n) for balance in model.balances()])
    middle_n = plan.faults[0].with_fault.load
    decades = np.log10(np.maximum(loads, plan.loads_n[0]) / middle_n)
    rms = math.sqrt(np.average(np.square(decades), weights=loads))
    return 20 * DIP_EXPONENT * rms


def _of_shares(
    own_db: Mapping[str, float], shares: Mapping[str, Mapping[str, Mapping[str, float]]]
) -> DecibelsOfBands:
    """Return what kinds of contact that are uncertain by some decibels leave in each band [dB]."""
    return {
        direction: {
            band: math.hypot(
                *(decibels * shares[name][direction][band] for name, decibels in own_db.items())
            )
            for band in VELOCITY_BANDS_HZ
        }
        for direction in DIRECTIONS
    }


@dataclass(frozen=True)
class _FilmChanges:
    """What films would make of the bands of a ring by another law, or with another weight.

    Form, waves and faults stay as they are.
    """

    plan: ContactPlan
    marches: Marches
    model: BearingModel
    powers: Mapping[str, RoughnessPower]
    record: RingRecord

    @property
    def decibels(self) -> dict[str, dict[str, float]]:
        """Standard uncertainty by films [dB]: both laws are as likely, and all weights between."""
        laws = [self._changes(law=law) for law in (CIRCULAR_LAW, LINE_LAW)]
        is_mixed = any(0 < film.weight < 1 for film in self.plan.films.values())
        ends = [self._changes(weight=weight) for weight in (0.0, 1.0)] if is_mixed else []
        return {
            direction: {
                band: math.hypot(
                    _range(laws, direction, band) / 2, _range(ends, direction, band) / math.sqrt(12)
                )
                for band in VELOCITY_BANDS_HZ
            }
            for direction in DIRECTIONS
        }

    def _changes(
        self, law: str = BETWEEN_LAWS, weight: float | None = None
    ) -> dict[str, dict[str, float]]:
        """Return the changes of the bands [dB] by another law or weight of the films."""
        others = roughness_powers(self.plan, self.marches, self.model, law, weight)
        changes: dict[str, dict[str, float]] = {}
        for direction in DIRECTIONS:
            changes[direction] = {}
            for band, rms in self.record.bands[direction].rms_m_s.items():
                own = sum(power.of_band(direction, band).sum() for power in self.powers.values())
                other = sum(power.of_band(direction, band).sum() for power in others.values())
                whole = max(rms**2, own, np.finfo(float).tiny)
                ratio = max((whole - own + other) / whole, np.finfo(float).tiny)
                changes[direction][band] = 10 * math.log10(ratio)
        return changes


def _range(changes: Sequence[DecibelsOfBands], direction: str, band: str) -> float:
    """Return the range of the changes of a band [dB], 0 of none."""
    values = [change[direction][band] for change in changes]
    return max(values) - min(values) if values else 0.0


def _window_db(
    short: list[str],
    powers: Mapping[str, RoughnessPower],
    shares: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> dict[str, dict[str, float]]:
    """Return the scatter of bands [dB] by roughness that is known from a stretch of track only.

    Both contacts of a ball meet the same stretch, and bodies have stretches of their own.
    """
    scatter: dict[str, dict[str, float]] = {}
    for direction in DIRECTIONS:
        scatter[direction] = {}
        for band in VELOCITY_BANDS_HZ:
            by_body: dict[str, float] = {}
            for name in short:
                power = powers[name]
                places = power.frequency_hz / power.line_hz
                lines = drawn_lines(places, power.of_band(direction, band))
                own_db = _DECIBELS / math.sqrt(lines) * shares[name][direction][band]
                by_body[body_of(name)] = by_body.get(body_of(name), 0.0) + own_db
            scatter[direction][band] = math.hypot(*by_body.values())
    return scatter
