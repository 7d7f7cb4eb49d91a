"""What the gains of rough contacts leave open in the bands of a ring's velocity.

All specimens of a choice share the gains of their marches, so more specimens do not tell how wrong
these are. The waves of a march are parted into groups, and each group is left out once (jackknife).
Contacts with the same march move together, and their part cancels in a difference.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.linear_ring import linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing_contacts.contact_gain import GROUPS, contact_gain
from rolling.bearing_contacts.joined_tracks import bearing_tracks, rough_rows
from rolling.bearing_contacts.plan import RINGS, ContactPlan, radius_of
from rolling.bearing_contacts.solving import Marches

FREQUENCIES = 400  # of a band, at which its power is summed


def gain_levels(model: BearingModel, plan: ContactPlan, marches: Marches) -> dict[str, Array]:
    """Return the radial level of each band [dB] without each group of waves of the marches.

    The ring is linear here, and equal changes of the approach of any contact move it alike.

    Parameters
    ----------
    model : BearingModel
    plan : ContactPlan
        Its contacts.
    marches : dict
        Marches by contact identity, as of `solved_stages`.

    Returns
    -------
    dict of arrays (GROUPS,), dB
        Level over that with all waves, by the name of the band; zeros where nothing is rough, or a
        whole turn was measured.
    """
    mobility = linear_ring(model).radial_mobility
    speed = model.kinematics.rolling_speed_m_s
    densities = list(_densities(plan, marches, speed))
    forms = list(_waves_around(plan, speed))
    levels = {}
    for band, (low_hz, high_hz) in VELOCITY_BANDS_HZ.items():
        grid_hz = np.linspace(low_hz, high_hz, FREQUENCIES)
        weight = np.abs(mobility(grid_hz)) ** 2 * (high_hz - low_hz) / FREQUENCIES
        power = 0.0
        powers = np.zeros(GROUPS)
        for waves_hz, whole, parts in densities:
            power += float(np.interp(grid_hz, waves_hz, whole) @ weight)
            powers += [np.interp(grid_hz, waves_hz, part) @ weight for part in parts]
        for waves_hz, squares in forms:
            inside = (waves_hz >= low_hz) & (waves_hz < high_hz)
            of_form = float(np.abs(mobility(waves_hz[inside])) ** 2 @ squares[inside])
            power += of_form
            powers += of_form
        levels[band] = 10 * np.log10(powers / power) if power > 0 else powers
    return levels


def gain_uncertainty_db(first: Array, second: Array) -> float:
    """Return the standard uncertainty of the difference of two levels by their gains [dB].

    Parameters
    ----------
    first, second : arrays (GROUPS,), dB
        Levels of a band of two bearings, as of `gain_levels`.
    """
    apart = second - first
    return float(np.sqrt((1 - 1 / GROUPS) * np.sum((apart - apart.mean()) ** 2)))


def _densities(
    plan: ContactPlan, marches: Marches, speed_m_s: float
) -> Iterator[tuple[Array, Array, list[Array]]]:
    """Yield frequencies [Hz] and densities [m2/Hz] of the approach of each rough contact.

    The last ones are the densities without each group of waves.
    """
    for contact in plan.rough.values():
        if contact.scene.height_paths:
            continue
        gain = contact_gain(contact, rough_rows(contact, marches))
        place = contact.loads_n.index(contact.middle_load_n)
        seconds = contact.steps * contact.scene.step / speed_m_s
        factor = 2 * seconds / contact.steps**2
        whole = factor * gain.expected_power()[place]
        parts = [factor * gain.expected_power(group)[place] for group in range(GROUPS)]
        yield np.arange(1, len(whole) + 1) / seconds, whole, parts


def _waves_around(plan: ContactPlan, speed_m_s: float) -> Iterator[tuple[Array, Array]]:
    """Yield frequencies [Hz] and mean squares [m2] of the waves around the bodies.

    A ring is moved radially by its orders q Z + 1 and q Z - 1 alone, by all Z balls at once, and by
    even orders of a ball alone, by both of its contacts at once.
    """
    tracks = bearing_tracks(replace(plan, rough={}, faults=()))
    balls = plan.geometry.balls
    load = np.array([plan.loads_n[len(plan.loads_n) // 2]])
    for ring in RINGS:
        (heights,) = getattr(tracks, ring).at_loads(load)
        orders, squares = _mean_squares(heights)
        moving = np.isin(orders % balls, (1, balls - 1))
        yield orders * _turns_hz(plan, ring, speed_m_s), squares * moving * balls / 2
    for on_inner, on_outer in zip(tracks.balls_on_inner, tracks.balls_on_outer, strict=True):
        heights = on_inner.at_loads(load)[0] + on_outer.at_loads(load)[0]
        orders, squares = _mean_squares(heights)
        yield orders * _turns_hz(plan, "balls", speed_m_s), squares * (orders % 2 == 0) / balls


def _mean_squares(heights_m: Array) -> tuple[Array, Array]:
    """Return the orders of the waves around a turn, and their mean squares [m2]."""
    lines = np.fft.rfft(heights_m)[1:] / len(heights_m)
    return np.arange(1.0, len(lines) + 1), 2 * np.abs(lines) ** 2


def _turns_hz(plan: ContactPlan, body: str, speed_m_s: float) -> float:
    """Return how often a place of a body meets the same contact [Hz]."""
    return speed_m_s / (2 * np.pi * radius_of(plan.geometry, body))
